// See cached_proof.hpp. The text has one row per line: first the components, then what is known about them, in numbers.
//
//   bipc kept proof 1                  way WAY                         steps CHOICE...
//   atom HASH PATH                     trap|one|sum TOLD TOTAL ATOM MODE WEIGHT ...
//   never ATOM PLACE? ROW POSITION VALUE ...                          equation ATOM PLACE? ROW WEIGHT ...
//   bounds
#include "compiler/verify/evidence/cached_proof.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>
#include <tuple>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::string_view kFirstLine = "bipc kept proof 1";
constexpr std::string_view kMethods[] = {"none", "plain", "told", "induction", "steps"};
constexpr std::string_view kKinds[] = {"trap", "one", "sum"};
// No sum of a file's numbers leaves 64 bits. The finder's own numbers (place_invariants.hpp) are below these.
constexpr std::int64_t kMaxCoefficient = std::int64_t{1} << 25, kMaxTotal = std::int64_t{1} << 48;

class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  [[nodiscard]] bool at_end() const { return rest_.empty(); }
  [[nodiscard]] bool has_failed() const { return has_failed_; }
  std::string_view word() {
    const std::size_t end = std::min(rest_.find(' '), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return word;
  }
  /// What is left of the line: paths hold no spaces, but this does not rely on it.
  std::string_view rest() { return std::exchange(rest_, {}); }
  template <class Number>
  Number number(Number least, Number most) {
    const std::string_view text = word();
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || end != text.data() + text.size() || value < least || value > most) {
      has_failed_ = true;
      return least;
    }
    return value;
  }
  u32 row() { return number<u32>(0, kNoRow - 1); }
  bool flag() { return number<u32>(0, 1) != 0; }

 private:
  std::string_view rest_;
  bool has_failed_ = false;
};

template <std::size_t count>
std::optional<std::size_t> row_of(const std::string_view (&names)[count], std::string_view name) {
  const auto* found = std::find(std::begin(names), std::end(names), name);
  return found == std::end(names) ? std::nullopt : std::optional(static_cast<std::size_t>(found - std::begin(names)));
}

class ProofCacheParser {
 public:
  explicit ProofCacheParser(const AtomOfName& atom_of) : atom_of_(atom_of) {}

  // False: the line is none of the form.
  bool line(std::string_view text) {
    Words words(text);
    const std::string_view first = words.word();
    if (first == "atom") {
      AtomName name;
      name.content = words.word();
      name.path = words.rest();
      atoms_.push_back(atom_of_(name));
      return true;
    }
    if (first == "way") {
      const auto way = row_of(kMethods, words.word());
      if (way) proof_.method = static_cast<ProofMethod>(*way);
      return way.has_value();
    }
    if (first == "steps") {
      while (!words.at_end() && !words.has_failed())
        proof_.choices.push_back(words.number<std::uint64_t>(0, ~std::uint64_t{0}));
      return !words.has_failed();
    }
    is_known_ = true;
    if (first == "never") {
      CachedLemma lemma;
      while (!words.at_end() && !words.has_failed()) {
        CachedLiteral literal;
        literal.atom = atom(words);
        literal.is_place = words.flag();
        literal.row = words.row();
        literal.position = words.row();
        literal.value = words.flag();
        lemma.push_back(literal);
      }
      if (is_known_ && !lemma.empty()) proof_.lemmas.push_back(std::move(lemma));
      return !words.has_failed();
    }
    if (first == "bounds") {
      proof_.uses_bounds = true;
      return words.at_end();
    }
    if (first == "equation") {
      CachedEquation equation;
      while (!words.at_end() && !words.has_failed()) {
        AffineEquation::Term term;
        term.atom = atom(words);
        term.is_place = words.flag();
        term.row = words.row();
        term.weight = words.number(std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max());
        equation.push_back(term);
      }
      if (is_known_ && !equation.empty()) proof_.equations.push_back(std::move(equation));
      return !words.has_failed();
    }
    const auto kind = row_of(kKinds, first);
    if (!kind) return false;
    CachedInvariant invariant;
    invariant.kind = static_cast<InvariantKind>(*kind);
    invariant.modes = words.flag() ? PortUseModes::Distinguished : PortUseModes::Merged;
    invariant.total = words.number(-kMaxTotal, kMaxTotal);
    while (!words.at_end() && !words.has_failed()) {
      CachedTerm term;
      term.atom = atom(words);
      term.mode = words.row();
      term.weight = words.number(-kMaxCoefficient, kMaxCoefficient);
      invariant.terms.push_back(term);
    }
    if (is_known_ && !invariant.terms.empty()) proof_.invariants.push_back(std::move(invariant));
    return !words.has_failed();
  }
  CachedProof proof_;

 private:
  u32 atom(Words& words) {
    const u32 row = words.row();
    const bool is_here = row < atoms_.size() && atoms_[row].has_value();
    is_known_ = is_known_ && is_here;
    return is_here ? *atoms_[row] : 0;
  }
  const AtomOfName& atom_of_;
  std::vector<std::optional<u32>> atoms_;
  bool is_known_ = true;
};

}  // namespace

CachedInvariant cached_invariant(const Net& net, const TokenInvariant& invariant, PortUseModes modes) {
  CachedInvariant result{invariant.kind, modes, invariant.kind == InvariantKind::Sum ? invariant.total : 1, {}};
  for (std::size_t k = 0; k < invariant.modes.size(); ++k) {
    BIP_ASSERT(invariant.modes[k] < net.mode_count(), "mode {} of {}", invariant.modes[k], net.mode_count());
    const u32 atom = net.atom_of_mode[invariant.modes[k]];
    result.terms.push_back({atom, invariant.modes[k] - net.mode_base[atom], weight_of(invariant, k)});
  }
  return result;
}

CachedLemma cached_lemma(const TransitionSystem& machine, const std::vector<u32>& cube) {
  CachedLemma result;
  for (u32 code : cube) {
    BIP_ASSERT(code / 2 < machine.bits.size(), "bit {} of {}", code / 2, machine.bits.size());
    const StateBit& bit = machine.bits[code / 2];
    result.push_back({bit.atom, bit.is_place, (code & 1) != 0, bit.row, bit.position});
  }
  return result;
}

std::vector<TokenInvariant> invariants_of(const CachedProof& proof, const Net& net, PortUseModes wanted) {
  std::vector<TokenInvariant> result;
  for (const CachedInvariant& row : proof.invariants) {
    if (row.modes != wanted || row.terms.empty()) continue;
    std::vector<std::pair<u32, std::int64_t>> modes;
    bool fits = true;
    for (const CachedTerm& term : row.terms) {
      fits = fits && std::size_t{term.atom} + 1 < net.mode_base.size() &&
             term.mode < net.mode_base[term.atom + 1] - net.mode_base[term.atom];
      fits = fits && term.weight != 0 && (row.kind == InvariantKind::Sum || term.weight == 1);
      if (!fits) break;
      modes.emplace_back(net.mode_base[term.atom] + term.mode, term.weight);
    }
    std::sort(modes.begin(), modes.end());
    fits = fits && std::adjacent_find(modes.begin(), modes.end(),
                                      [](const auto& a, const auto& b) { return a.first == b.first; }) == modes.end();
    if (!fits) continue;
    TokenInvariant invariant{row.kind, {}, {}, row.kind == InvariantKind::Sum ? row.total : 1};
    for (const auto& [mode, weight] : modes) {
      invariant.modes.push_back(mode);
      if (row.kind == InvariantKind::Sum) invariant.weights.push_back(weight);
    }
    result.push_back(std::move(invariant));
  }
  return result;
}

std::vector<AffineEquation> equations_of(const CachedProof& proof) {
  std::vector<AffineEquation> result;
  for (const CachedEquation& terms : proof.equations) result.push_back({terms, 0});
  return result;
}

std::vector<std::vector<u32>> lemmas_of(const CachedProof& proof, const TransitionSystem& machine) {
  if (proof.lemmas.empty()) return {};
  std::map<std::tuple<u32, bool, u32, u32>, u32> rows;
  for (u32 row = 0; row < machine.bits.size(); ++row) {
    const StateBit& bit = machine.bits[row];
    rows[{bit.atom, bit.is_place, bit.row, bit.position}] = row;
  }
  std::vector<std::vector<u32>> result;
  for (const CachedLemma& lemma : proof.lemmas) {
    std::vector<u32> cube;
    bool fits = !lemma.empty();
    for (const CachedLiteral& literal : lemma) {
      const auto found = rows.find({literal.atom, literal.is_place, literal.row, literal.position});
      fits = fits && found != rows.end();
      if (!fits) break;
      cube.push_back(2 * found->second + (literal.value ? 1 : 0));
    }
    std::sort(cube.begin(), cube.end());
    // Twice the same bit: nothing, or what no state is.
    fits =
        fits && std::adjacent_find(cube.begin(), cube.end(), [](u32 a, u32 b) { return a / 2 == b / 2; }) == cube.end();
    if (fits) result.push_back(std::move(cube));
  }
  return result;
}

std::string print_cached_proof(const CachedProof& proof, const NameOfAtom& name_of) {
  BIP_ASSERT(proof.choices.empty() || proof.method == ProofMethod::Steps, "steps in a proof");
  std::string out =
      std::string(kFirstLine) + "\nway " + std::string(kMethods[static_cast<std::size_t>(proof.method)]) + '\n';
  std::map<u32, std::size_t> rows;
  const auto add_atom = [&](u32 atom) {
    if (!rows.try_emplace(atom, rows.size()).second) return;
    const AtomName name = name_of(atom);
    out += "atom " + name.content + ' ' + name.path + '\n';
  };
  for (const CachedInvariant& invariant : proof.invariants) {
    for (const CachedTerm& term : invariant.terms) add_atom(term.atom);
  }
  for (const CachedEquation& equation : proof.equations) {
    for (const AffineEquation::Term& term : equation) add_atom(term.atom);
  }
  for (const CachedLemma& lemma : proof.lemmas) {
    for (const CachedLiteral& literal : lemma) add_atom(literal.atom);
  }
  const auto number = [&](auto value) { out += ' ' + std::to_string(value); };
  for (const CachedInvariant& invariant : proof.invariants) {
    out += kKinds[static_cast<std::size_t>(invariant.kind)];
    out += invariant.modes == PortUseModes::Distinguished ? " 1" : " 0";
    number(invariant.total);
    for (const CachedTerm& term : invariant.terms) {
      number(rows[term.atom]);
      number(term.mode);
      number(term.weight);
    }
    out += '\n';
  }
  if (proof.uses_bounds) out += "bounds\n";
  for (const CachedEquation& equation : proof.equations) {
    out += "equation";
    for (const AffineEquation::Term& term : equation) {
      number(rows[term.atom]);
      out += term.is_place ? " 1" : " 0";
      number(term.row);
      number(term.weight);
    }
    out += '\n';
  }
  for (const CachedLemma& lemma : proof.lemmas) {
    out += "never";
    for (const CachedLiteral& literal : lemma) {
      number(rows[literal.atom]);
      out += literal.is_place ? " 1" : " 0";
      number(literal.row);
      number(literal.position);
      out += literal.value ? " 1" : " 0";
    }
    out += '\n';
  }
  if (!proof.choices.empty()) {
    out += "steps";
    for (std::uint64_t choice : proof.choices) number(choice);
    out += '\n';
  }
  return out;
}

std::optional<CachedProof> parse_cached_proof(std::string_view text, const AtomOfName& atom_of) {
  ProofCacheParser parser(atom_of);
  bool is_first = true;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    if (is_first ? line != kFirstLine : !parser.line(line)) return std::nullopt;
    is_first = false;
  }
  if (is_first) return std::nullopt;
  return std::move(parser.proof_);
}

}  // namespace bip::verify
