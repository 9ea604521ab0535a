// See fairness.hpp. Names are those of properties; `[*]` is matched with each path of the system.
#include "compiler/verify/property/fairness.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "compiler/base/ascii.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/property/rows_of_paths.hpp"
#include "runtime/core/text.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::string_view kAnyPosition = "[*]";
constexpr std::string_view kFairnessForms = "`weak`, `strong`, `weak:atoms`, `weak:NAME`, `strong:NAME`";

// Of TLA+, and of Manna, Pnueli, The Temporal Logic of Reactive and Concurrent Systems, 1992 (SMV).
struct OtherWord {
  std::string_view word;
  FairnessKind kind;
};
constexpr OtherWord kOtherWords[] = {{"WF", FairnessKind::Weak},
                                     {"SF", FairnessKind::Strong},
                                     {"justice", FairnessKind::Weak},
                                     {"compassion", FairnessKind::Strong}};

const char* word_of(FairnessKind kind) { return kind == FairnessKind::Strong ? "strong" : "weak"; }

// Is it the path, with some number in the place of each `[*]`?
bool matches_path(std::string_view pattern, std::string_view path) {
  while (!pattern.empty()) {
    if (pattern.starts_with(kAnyPosition)) {
      if (!path.starts_with('[')) return false;
      const std::size_t close = path.find(']');
      if (close == std::string_view::npos) return false;
      pattern.remove_prefix(kAnyPosition.size());
      path.remove_prefix(close + 1);
      continue;
    }
    if (path.empty() || path.front() != pattern.front()) return false;
    pattern.remove_prefix(1);
    path.remove_prefix(1);
  }
  return path.empty();
}

class FairnessReader {
 public:
  FairnessReader(std::string_view text, std::size_t begin, const System* system, const RowsOfPaths* rows)
      : text_(text), system_(system), rows_(rows), at_(begin) {}

  Result<Fairness> run() {
    skip_blanks();
    if (take_word("none")) {
      skip_blanks();
      if (at_ != text_.size()) return fail("beside `none` nothing is said");
      return std::move(fairness_);
    }
    for (bool goes_on = true; goes_on && problem_.empty();) {
      read_term();
      skip_blanks();
      goes_on = at_ < text_.size() && text_[at_] == ',';
      if (goes_on) ++at_;
    }
    if (!problem_.empty()) return Failure{problem_};
    if (at_ != text_.size())
      return fail(fmt::format("`,` and a term, or `:` and a name, was expected; terms are {}", kFairnessForms));
    return std::move(fairness_);
  }

 private:
  Failure fail(const std::string& why) {
    if (problem_.empty()) problem_ = fmt::format("column {}: {}", at_ + 1, why);
    return Failure{problem_};
  }
  void skip_blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n')) ++at_;
  }
  [[nodiscard]] static bool is_of_path(char c) {
    return is_letter(c) || is_digit(c) || c == '_' || c == '.' || c == '[' || c == ']' || c == '*';
  }
  bool take_word(std::string_view word) {
    const std::size_t end = at_ + word.size();
    if (text_.substr(at_, word.size()) != word || (end < text_.size() && is_of_path(text_[end]))) return false;
    at_ = end;
    return true;
  }

  // Where `weak` or `strong` was expected.
  void refuse_word() {
    std::size_t end = at_;
    while (end < text_.size() && is_of_path(text_[end])) ++end;
    const std::string_view word = text_.substr(at_, end - at_);
    for (const OtherWord& other : kOtherWords) {
      if (other.word != word) continue;
      fail(fmt::format("`{}` is written `{}`; terms are {}", word, word_of(other.kind), kFairnessForms));
      return;
    }
    if (word.empty()) fail(fmt::format("`weak` or `strong` was expected; terms are {}", kFairnessForms));
    else fail(fmt::format("`weak` or `strong` was expected, not `{}`; terms are {}", word, kFairnessForms));
  }

  void read_term() {
    skip_blanks();
    const std::size_t start = at_;
    FairnessKind kind = FairnessKind::Weak;
    if (take_word("strong")) kind = FairnessKind::Strong;
    else if (!take_word("weak")) {
      refuse_word();
      return;
    }
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != ':') return add({.kind = kind}, WrittenTerm{kind}, start);
    ++at_;
    skip_blanks();
    const std::size_t name_at = at_;
    while (at_ < text_.size() && is_of_path(text_[at_])) ++at_;
    const std::string name(text_.substr(name_at, at_ - name_at));
    if (name.empty()) {
      fail("a connector, a port (`COMPONENT.PORT`), a component, or `atoms` was expected");
      return;
    }
    if (name == "atoms") return add({.kind = kind, .unit = FairnessUnit::Atoms}, WrittenTerm{kind, name}, start);
    if (system_ == nullptr) return;
    const std::size_t before = fairness_.terms.size();
    resolve(name, kind, name_at);
    if (problem_.empty() && fairness_.terms.size() > before) fairness_.written.push_back({kind, name});
  }

  // The same thing twice would be a slip: strong fairness implies weak fairness.
  void add(FairnessTerm term, std::optional<WrittenTerm> written, std::size_t at) {
    for (const FairnessTerm& other : fairness_.terms) {
      if (other.unit != term.unit || other.owner != term.owner || other.port != term.port) continue;
      at_ = at;
      const std::string what = term.has_name()                           ? '`' + term.path + '`'
                               : term.unit == FairnessUnit::Interactions ? "each interaction"
                                                                         : "each component";
      fail(other.kind == term.kind
               ? fmt::format("{} fairness of {} is said twice", word_of(term.kind), what)
               : fmt::format("fairness of {} is weak or strong: what is strong is weak, too", what));
      return;
    }
    fairness_.terms.push_back(std::move(term));
    if (written) fairness_.written.push_back(std::move(*written));
  }

  void resolve(const std::string& name, FairnessKind kind, std::size_t at) {
    if (name.find('*') != std::string::npos) return resolve_each(name, kind, at);
    const std::string path = rt::whole_path(name);
    if (const auto connector = rows_->connectors.find(path); connector != rows_->connectors.end()) {
      if (!system_->is_top(ConnectorId(std::size_t{connector->second}))) {
        at_ = at;
        fail(fmt::format("connector `{}` exports a port: it is a part of others", name));
        return;
      }
      return add({.kind = kind, .unit = FairnessUnit::Connector, .path = short_path(path), .owner = connector->second},
                 std::nullopt, at);
    }
    if (const auto atom = rows_->atoms.find(path); atom != rows_->atoms.end())
      return add({.kind = kind, .unit = FairnessUnit::Atom, .path = short_path(path), .owner = atom->second},
                 std::nullopt, at);
    const std::size_t dot = path.rfind('.');
    const auto owner = dot == std::string::npos ? rows_->atoms.end() : rows_->atoms.find(path.substr(0, dot));
    if (owner != rows_->atoms.end() && add_port(owner->second, path.substr(dot + 1), kind, at)) return;
    at_ = at;
    if (owner != rows_->atoms.end()) {
      fail(fmt::format("component `{}` has no port `{}`", name.substr(0, name.rfind('.')), path.substr(dot + 1)));
      return;
    }
    fail(fmt::format("there is no connector, port or component `{}`{}", name, hint(path, name)));
  }
  // False: the atom has no such port.
  bool add_port(std::uint32_t atom, const std::string& port, FairnessKind kind, std::size_t at) {
    const Atom& owner = system_->atoms[AtomId(std::size_t{atom})];
    const auto& ports = system_->atom_types[owner.type].ports;
    for (std::uint32_t row = 0; row < ports.size(); ++row) {
      if (ports[row].name != port) continue;
      add({.kind = kind,
           .unit = FairnessUnit::Port,
           .path = short_path(owner.path) + '.' + port,
           .owner = atom,
           .port = row},
          std::nullopt, at);
      return true;
    }
    return false;
  }
  // Each connector, atom or port that the pattern matches, in the order of the system.
  void resolve_each(const std::string& name, FairnessKind kind, std::size_t at) {
    const std::string pattern = rt::whole_path(name);
    const std::size_t before = fairness_.terms.size();
    for (std::uint32_t row = 0; row < system_->connectors.size() && problem_.empty(); ++row) {
      const ConnectorId id{std::size_t{row}};
      const std::string& path = system_->connectors[id].path;
      if (system_->is_top(id) && matches_path(pattern, path))
        add({.kind = kind, .unit = FairnessUnit::Connector, .path = short_path(path), .owner = row}, std::nullopt, at);
    }
    const std::size_t dot = pattern.rfind('.');
    const std::string of_atom = pattern.substr(0, dot), port = pattern.substr(dot + 1);
    for (std::uint32_t row = 0; row < system_->atoms.size() && problem_.empty(); ++row) {
      const std::string& path = system_->atoms[AtomId(std::size_t{row})].path;
      if (matches_path(pattern, path))
        add({.kind = kind, .unit = FairnessUnit::Atom, .path = short_path(path), .owner = row}, std::nullopt, at);
      else if (matches_path(of_atom, path)) add_port(row, port, kind, at);
    }
    if (fairness_.terms.size() != before || !problem_.empty()) return;
    at_ = at;
    fail(fmt::format("no connector, port or component is called `{}`", name));
  }
  [[nodiscard]] static std::string short_path(const std::string& path) {
    constexpr std::string_view kRoot = "ROOT.";
    return path.starts_with(kRoot) ? path.substr(kRoot.size()) : path;
  }
  [[nodiscard]] std::string hint(const std::string& path, const std::string& name) const {
    if (name == "components" || name == "component" || name == "atom") return "; `atoms` is each component";
    if (name == "interactions" || name == "connectors") return "; without a name it is each interaction";
    const auto has_first = [&](const RowsByPath& rows) { return rows.find(path + "[0]") != rows.end(); };
    if (!has_first(rows_->connectors) && !has_first(rows_->atoms)) return {};
    return fmt::format("; it is an array: `{}[0]`, or `{}[*]` for each of them", name, name);
  }

  std::string_view text_;
  const System* system_;     // null: names are not looked up
  const RowsOfPaths* rows_;  // the same
  std::size_t at_;
  std::string problem_;
  Fairness fairness_;
};

}  // namespace

bool Fairness::has(FairnessKind kind) const {
  return std::any_of(terms.begin(), terms.end(), [kind](const FairnessTerm& term) { return term.kind == kind; });
}

bool Fairness::has_interactions() const {
  return std::any_of(terms.begin(), terms.end(),
                     [](const FairnessTerm& term) { return term.unit == FairnessUnit::Interactions; });
}

Result<Fairness> read_fairness(std::string_view text, const System& system) {
  return read_fairness(text, 0, system, RowsOfPaths(system));
}

Result<Fairness> read_fairness(std::string_view text, std::size_t begin, const System& system,
                               const RowsOfPaths& rows) {
  return FairnessReader(text, begin, &system, &rows).run();
}

std::string problem_of_fairness(std::string_view text) {
  const Result<Fairness> read = FairnessReader(text, 0, nullptr, nullptr).run();
  return read ? std::string() : read.error();
}

Fairness fairness_of_interactions(FairnessKind kind) { return {{{.kind = kind}}, {{kind}}}; }

std::string name_of(const Fairness& fairness) {
  std::string text;
  for (const WrittenTerm& term : fairness.written)
    text +=
        fmt::format("{}{}{}{}", text.empty() ? "" : ",", word_of(term.kind), term.what.empty() ? "" : ":", term.what);
  return text.empty() ? "none" : text;
}

std::string words_of(const Fairness& fairness) {
  std::string text;
  for (const FairnessKind kind : {FairnessKind::Weak, FairnessKind::Strong}) {
    std::string all;
    for (const WrittenTerm& term : fairness.written) {
      if (term.kind != kind) continue;
      all += fmt::format("{}{}", all.empty() ? "" : ", ",
                         term.what.empty()      ? "interactions"
                         : term.what == "atoms" ? "components"
                                                : '`' + term.what + '`');
    }
    if (!all.empty()) text += fmt::format("{}{} fairness of {}", text.empty() ? "" : ", ", word_of(kind), all);
  }
  return text.empty() ? "no fairness is assumed" : text;
}

std::string certificate_text(const FairnessTerm& term, const System& system) {
  const std::string word = word_of(term.kind);
  const auto atom = [&]() -> const Atom& { return system.atoms[AtomId(std::size_t{term.owner})]; };
  switch (term.unit) {
    case FairnessUnit::Interactions: return word;
    case FairnessUnit::Atoms: return word + ":atoms";
    case FairnessUnit::Connector:
      return word + ":connector:" + system.connectors[ConnectorId(std::size_t{term.owner})].path;
    case FairnessUnit::Port:
      return word + ":port:" + atom().path + '.' + system.atom_types[atom().type].ports[term.port].name;
    case FairnessUnit::Atom: return word + ":atom:" + atom().path;
  }
  BIP_UNREACHABLE("a term of no kind");
}

std::string certificate_text(const Fairness& fairness, const System& system) {
  std::string text;
  for (const FairnessTerm& term : fairness.terms) text += (text.empty() ? "" : " ") + certificate_text(term, system);
  return text.empty() ? "none" : text;
}

}  // namespace bip::verify
