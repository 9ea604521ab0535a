// See counting_rows.hpp.
#include "compiler/verify/counting/counting_rows.hpp"

#include <algorithm>
#include <map>

#include "compiler/verify/evidence/case_rows.hpp"

namespace bip::verify {

namespace {

// The checker adds up all weights of a row in 32 bits.
constexpr std::int64_t kMostSum = std::int64_t{1} << 30;

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
      std::vector<ValueBox> all;
      for (const u32 place : net_.places_of_kind[net_.kind_of_atom[atom]]) all.push_back(said_[place]);
      for (const ValueBox& box : joined_boxes(std::move(all), columns_[net_.kind_of_atom[atom]]))
        out += ' ' + case_of(atom, box);
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
    std::vector<CaseColumn>& columns = columns_.emplace_back(place_columns(type));
    for (u32 k = 0; k < type.variables.size(); ++k) {
      const DataVariable& variable = type.variables[k];
      if (!is_nameable(variable) || std::binary_search(unread_cells_.begin(), unread_cells_.end(), cell_of(atom, k)))
        continue;
      if (variable.type != Type::Int && variable.type != Type::Bool && variable.type != Type::String) return false;
      columns.push_back({CaseColumn::About::Value, k, variable.type == Type::Int});
    }
    said_.resize(net_.places.size());
    for (const u32 place : net_.places_of_kind[kind]) {
      if (!builder_.enter_atoms({atom}, {place})) return false;
      for (const CaseColumn& column : columns) {
        const std::int32_t value = value_in_core(atom, column);
        said_[place].push_back({value, value});
      }
    }
    return true;
  }
  [[nodiscard]] rt::VariableId cell_of(u32 atom, u32 variable) const {
    return builder_.core().image().atoms[atom].variable(variable);
  }
  [[nodiscard]] std::int32_t value_in_core(u32 atom, const CaseColumn& column) const {
    const rt::Core& core = builder_.core();
    if (column.about == CaseColumn::About::Place) return core.is_marked(atom, column.row) ? 1 : 0;
    if (column.about == CaseColumn::About::Value)
      return static_cast<std::int32_t>(static_cast<u32>(core.cell(cell_of(atom, column.row)).bits));
    u32 place = 0;
    while (!core.is_marked(atom, place)) ++place;
    return static_cast<std::int32_t>(place);
  }
  [[nodiscard]] std::string case_of(u32 atom, const ValueBox& box) const {
    return case_text(system_.atoms[AtomId(std::size_t{atom})], type_of(atom), columns_[net_.kind_of_atom[atom]], box);
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
  std::vector<std::vector<CaseColumn>> columns_;  // by kind
  std::vector<ValueBox> said_;                    // by place
};

}  // namespace

std::optional<std::string> counting_rows(CountedNetBuilder& builder, const std::vector<SubInvariant>& proofs,
                                         const System& system, const std::vector<rt::VariableId>& unread_cells) {
  return RowWriter(builder, system, unread_cells).run(proofs);
}

}  // namespace bip::verify
