// See counting_rows.hpp. Local states that differ in one int only, without a gap, are one case with a range.
#include "compiler/verify/counting/counting_rows.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// The checker adds up all weights of a row in 32 bits.
constexpr std::int64_t kMostSum = std::int64_t{1} << 30;

struct ValueRange {
  std::int32_t low = 0, high = 0;
  friend auto operator<=>(const ValueRange&, const ValueRange&) = default;
};
// What is said of a local state: each place (of an automaton: its number), each variable that is read.
using Said = std::vector<ValueRange>;

class RowWriter {
 public:
  RowWriter(CountedNetBuilder& builder, const System& system, const std::vector<rt::VariableId>& unread_cells)
      : builder_(builder), net_(builder.net()), system_(system), unread_cells_(unread_cells) {}

  std::optional<std::string> run(const std::vector<SubInvariant>& proofs) {
    for (u32 kind = 0; kind < net_.atom_of_kind.size(); ++kind) {
      if (!read_kind(kind)) return std::nullopt;
    }
    std::string out;
    for (u32 atom = 0; atom < net_.kind_of_atom.size(); ++atom) {
      out += "lemma";
      std::vector<Said> all;
      for (const u32 place : net_.places_of_kind[net_.kind_of_atom[atom]]) all.push_back(said_[place]);
      for (const Said& said : joined(std::move(all), net_.kind_of_atom[atom])) out += ' ' + case_of(atom, said);
      out += '\n';
    }
    for (const SubInvariant& proof : proofs) {
      for (const SubInvariant::WeightedTrap& trap : proof.traps) {
        out += "lemma";
        for_atoms_at(trap.places, [&](u32 atom, u32 place) { out += ' ' + case_of(atom, said_[place]); });
        out += '\n';
      }
      if (!add_bound(proof, out)) return std::nullopt;
    }
    return out;
  }

 private:
  struct SaidColumn {
    enum class About : std::uint8_t { Automaton, Place, Value } about = About::Automaton;
    u32 row = 0;
    bool is_int = false;
  };

  template <class Visit>
  void for_atoms_at(const std::vector<u32>& places, const Visit& visit) const {
    for (u32 atom = 0; atom < net_.kind_of_atom.size(); ++atom) {
      for (const u32 place : places) {
        if (net_.places[place].kind == net_.kind_of_atom[atom]) visit(atom, place);
      }
    }
  }
  [[nodiscard]] const AtomType& type_of(u32 atom) const {
    return system_.atom_types[system_.atoms[AtomId(std::size_t{atom})].type];
  }
  bool read_kind(u32 kind) {
    const u32 atom = net_.atom_of_kind[kind];
    const AtomType& type = type_of(atom);
    std::vector<SaidColumn>& columns = columns_.emplace_back();
    if (type.is_automaton()) columns.push_back({SaidColumn::About::Automaton, 0, false});
    for (u32 place = 0; place < type.places.size() && !type.is_automaton(); ++place)
      columns.push_back({SaidColumn::About::Place, place, false});
    for (u32 k = 0; k < type.variables.size(); ++k) {
      const DataVariable& variable = type.variables[k];
      // A name of the compiler's own is none that a row can hold.
      if (variable.is_param || variable.name.find(' ') != std::string::npos ||
          std::binary_search(unread_cells_.begin(), unread_cells_.end(), cell_of(atom, k)))
        continue;
      if (variable.type != Type::Int && variable.type != Type::Bool && variable.type != Type::String) return false;
      columns.push_back({SaidColumn::About::Value, k, variable.type == Type::Int});
    }
    said_.resize(net_.places.size());
    for (const u32 place : net_.places_of_kind[kind]) {
      if (!builder_.enter_atoms({atom}, {place})) return false;
      for (const SaidColumn& column : columns) {
        const std::int32_t value = value_in_core(atom, column);
        said_[place].push_back({value, value});
      }
    }
    return true;
  }
  [[nodiscard]] rt::VariableId cell_of(u32 atom, u32 variable) const {
    return builder_.core().image().atoms[atom].variable(variable);
  }
  [[nodiscard]] std::int32_t value_in_core(u32 atom, const SaidColumn& column) const {
    const rt::Core& core = builder_.core();
    if (column.about == SaidColumn::About::Place) return core.is_marked(atom, column.row) ? 1 : 0;
    if (column.about == SaidColumn::About::Value)
      return static_cast<std::int32_t>(static_cast<u32>(core.cell(cell_of(atom, column.row)).bits));
    u32 place = 0;
    while (!core.is_marked(atom, place)) ++place;
    return static_cast<std::int32_t>(place);
  }
  // SaidColumn by column.
  [[nodiscard]] std::vector<Said> joined(std::vector<Said> all, u32 kind) const {
    for (std::size_t k = 0; k < columns_[kind].size(); ++k) {
      if (!columns_[kind][k].is_int) continue;
      std::sort(all.begin(), all.end(), [&](const Said& a, const Said& b) {
        const auto rest = [&](const Said& said) {
          Said others = said;
          others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
          return others;
        };
        const Said of_a = rest(a), of_b = rest(b);
        return of_a != of_b ? of_a < of_b : a[k] < b[k];
      });
      std::vector<Said> fewer;
      for (Said& said : all) {
        if (!fewer.empty()) {
          Said longer = fewer.back();
          const bool follows = std::int64_t{longer[k].high} + 1 == said[k].low;
          longer[k] = said[k];
          if (follows && longer == said) {
            fewer.back()[k].high = said[k].high;
            continue;
          }
        }
        fewer.push_back(std::move(said));
      }
      all = std::move(fewer);
    }
    return all;
  }
  // "ROOT.a@S&ROOT.a.n=0..3"
  [[nodiscard]] std::string case_of(u32 atom, const Said& said) const {
    const AtomType& type = type_of(atom);
    const std::string& path = system_.atoms[AtomId(std::size_t{atom})].path;
    const std::vector<SaidColumn>& columns = columns_[net_.kind_of_atom[atom]];
    BIP_ASSERT(said.size() == columns.size(), "{} values of {} columns", said.size(), columns.size());
    std::string out;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (k != 0) out += '&';
      switch (columns[k].about) {
        case SaidColumn::About::Automaton:
          out += path + '@' + type.places[static_cast<std::size_t>(said[k].low)];
          break;
        case SaidColumn::About::Place:
          out += (said[k].low == 0 ? "!" : "") + path + '@' + type.places[columns[k].row];
          break;
        case SaidColumn::About::Value:
          out += path + '.' + type.variables[columns[k].row].name + '=' + std::to_string(said[k].low);
          if (said[k].low != said[k].high) out += ".." + std::to_string(said[k].high);
          break;
      }
    }
    return out;
  }
  bool add_bound(const SubInvariant& proof, std::string& out) const {
    std::int64_t total = 0, sum = 0;
    std::vector<u32> weighted;
    for (u32 place = 0; place < net_.places.size(); ++place) {
      total += proof.weights[place] * net_.tokens[place];
      if (proof.weights[place] != 0) weighted.push_back(place);
    }
    if (total >= kMostSum) return false;
    out += "bound " + std::to_string(total);
    for_atoms_at(weighted, [&](u32 atom, u32 place) {
      sum = std::min(kMostSum, sum + std::min(kMostSum, proof.weights[place]));
      out += ' ' + case_of(atom, said_[place]) + '*' + std::to_string(proof.weights[place]);
    });
    out += '\n';
    return sum < kMostSum;
  }

  CountedNetBuilder& builder_;
  const CountedNet& net_;
  const System& system_;
  const std::vector<rt::VariableId>& unread_cells_;
  std::vector<std::vector<SaidColumn>> columns_;  // by kind
  std::vector<Said> said_;                        // by place
};

}  // namespace

std::optional<std::string> counting_rows(CountedNetBuilder& builder, const std::vector<SubInvariant>& proofs,
                                         const System& system, const std::vector<rt::VariableId>& unread_cells) {
  return RowWriter(builder, system, unread_cells).run(proofs);
}

}  // namespace bip::verify
