// Computes the inner order, see inner_order.hpp.
#include "compiler/steps/inner_order.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "runtime/include/bip/assert.hpp"

namespace bip::steps {

namespace {

using rt::kNone;
using rt::u32;

class OrderFinder {
 public:
  OrderFinder(const rt::Image& image, const rt::Tables& tables)
      : image_(image),
        tables_(tables),
        rank_(image.atoms.size, kNone),
        atoms_of_type_(image.atom_types.size),
        starts_at_(image.atoms.size) {}

  InnerOrder find() {
    list_classes();
    for (Class& type_class : classes_) {
      arrange(type_class);
      rank_atoms(type_class);
    }
    for (u32 atom = 0; atom < rank_.size(); ++atom) rank(atom);
    InnerOrder order;
    for (const std::vector<u32>& atoms : atoms_of_type_)
      order.atoms.insert(order.atoms.end(), atoms.begin(), atoms.end());
    for (const Class& type_class : classes_) {
      order.first_of_class.resize(order.interactions.size() + type_class.members.size(),
                                  static_cast<u32>(order.interactions.size()));
      for (const rt::InteractionId member : type_class.members) order.interactions.push_back(member.value);
    }
    order_cells(order);
    BIP_ASSERT(order.atoms.size() == image_.atoms.size && order.interactions.size() == tables_.interactions.size() &&
                   order.cells.size() == image_.cell_count,
               "{} atoms, {} interactions, {} cells", order.atoms.size(), order.interactions.size(),
               order.cells.size());
    return order;
  }

 private:
  static constexpr std::size_t kMostParameters = 8;  // of interactions among which chains are looked for
  struct Class {
    std::vector<rt::InteractionId> members;
    std::size_t parameters = 0;
  };

  void read_ports(rt::InteractionId interaction, std::vector<u32>& ports) const {
    const rt::InteractionInfo info = tables_.interactions[interaction];
    ports.clear();
    switch (info.kind) {
      case rt::InteractionKind::Flat:
      case rt::InteractionKind::Star:
        for (u32 k = 0; k < info.count; ++k) ports.push_back(tables_.flat_ports[info.first + k]);
        break;
      case rt::InteractionKind::Planned: {
        const rt::Plan& plan = tables_.plans[info.plan()];
        for (u32 k = 0; k < plan.node_count; ++k) {
          const rt::PlanNode& node = tables_.plan_nodes[plan.first_node + k];
          if (node.kind == rt::NodeKind::Leaf) ports.push_back(node.ref);
        }
        break;
      }
      case rt::InteractionKind::Port: ports.push_back(info.row); break;
    }
  }

  // Large classes first: they say the most about the order of atoms.
  void list_classes() {
    std::map<std::vector<u32>, u32> known;
    std::vector<u32> ports, key;
    first_atom_.push_back(0);
    for (const rt::InteractionId interaction : tables_.interactions.ids()) {
      const rt::InteractionInfo info = tables_.interactions[interaction];
      read_ports(interaction, ports);
      key.assign(1, static_cast<u32>(info.kind));
      if (info.kind != rt::InteractionKind::Port) key.push_back(image_.connectors[info.row].type);
      for (const u32 port : ports) {
        const u32 atom = tables_.port_atom[port];
        atoms_.push_back(atom);
        key.push_back(tables_.atoms[atom].type);
        key.push_back(port - tables_.port_base(atom));
      }
      first_atom_.push_back(static_cast<u32>(atoms_.size()));
      const auto [at, is_new] = known.try_emplace(key, static_cast<u32>(classes_.size()));
      if (is_new) classes_.push_back({{}, ports.size()});
      classes_[at->second].members.push_back(interaction);
    }
    std::stable_sort(classes_.begin(), classes_.end(),
                     [](const Class& a, const Class& b) { return a.members.size() > b.members.size(); });
  }

  [[nodiscard]] rt::Span<u32> atoms_of(rt::InteractionId interaction) const {
    const u32 first = first_atom_[interaction.value];
    return {atoms_.data() + first, first_atom_[interaction.value + 1] - first};
  }
  [[nodiscard]] u32 atom_of(rt::InteractionId interaction, std::size_t parameter) const {
    return atoms_of(interaction)[parameter];
  }

  // Along the atoms that have a rank already; else along chains.
  void arrange(Class& type_class) {
    const bool has_ranks =
        std::any_of(type_class.members.begin(), type_class.members.end(), [&](rt::InteractionId member) {
          const rt::Span<u32> atoms = atoms_of(member);
          return std::any_of(atoms.begin(), atoms.end(), [&](u32 atom) { return rank_[atom] != kNone; });
        });
    if (!has_ranks) return arrange_in_chains(type_class);
    std::stable_sort(type_class.members.begin(), type_class.members.end(),
                     [&](rt::InteractionId a, rt::InteractionId b) {
                       for (std::size_t k = 0; k < type_class.parameters; ++k) {
                         if (rank_[atom_of(a, k)] != rank_[atom_of(b, k)])
                           return rank_[atom_of(a, k)] < rank_[atom_of(b, k)];
                       }
                       return false;
                     });
  }
  void arrange_in_chains(Class& type_class) {
    const std::size_t parameters = std::min(type_class.parameters, kMostParameters);
    for (std::size_t early = 0; early < parameters; ++early) {
      for (std::size_t late = early + 1; late < parameters; ++late) {
        if (follow_chains(type_class, early, late)) return;
      }
    }
  }
  // False: an atom is bound twice to one of the parameters, or no interaction follows another.
  bool follow_chains(Class& type_class, std::size_t early, std::size_t late) {
    const auto type_at = [&](std::size_t parameter) {
      return tables_.atoms[atom_of(type_class.members.front(), parameter)].type;
    };
    if (type_at(early) != type_at(late)) return false;
    bool is_unique = true;
    for (const rt::InteractionId member : type_class.members) {
      rt::InteractionId& start = starts_at_[atom_of(member, early)];
      is_unique = is_unique && !start.is_valid();
      start = member;
    }
    std::vector<u32> next(type_class.members.size(), kNone);
    IndexVector<rt::InteractionId, u32> row_of(tables_.interactions.size(), kNone);
    std::vector<bool> follows(type_class.members.size(), false);
    bool is_chained = false;
    if (is_unique) {
      for (std::size_t row = 0; row < type_class.members.size(); ++row)
        row_of[type_class.members[row]] = static_cast<u32>(row);
      for (std::size_t row = 0; row < type_class.members.size() && is_unique; ++row) {
        const rt::InteractionId after = starts_at_[atom_of(type_class.members[row], late)];
        if (!after.is_valid()) continue;
        const u32 after_row = row_of[after];
        is_unique = !follows[after_row];
        follows[after_row] = true;
        next[row] = after_row;
        is_chained = true;
      }
    }
    for (const rt::InteractionId member : type_class.members) starts_at_[atom_of(member, early)] = {};
    if (!is_unique || !is_chained) return false;
    std::vector<rt::InteractionId> arranged;
    std::vector<bool> is_done(type_class.members.size(), false);
    // Chains with a beginning, then cycles.
    for (const bool cycles : {false, true}) {
      for (std::size_t row = 0; row < type_class.members.size(); ++row) {
        if (!cycles && follows[row]) continue;
        for (std::size_t at = row; at != kNone && !is_done[at]; at = next[at]) {
          is_done[at] = true;
          arranged.push_back(type_class.members[at]);
        }
      }
    }
    BIP_ASSERT(arranged.size() == type_class.members.size(), "{} of {} interactions are in chains", arranged.size(),
               type_class.members.size());
    type_class.members = std::move(arranged);
    return true;
  }

  void rank(u32 atom) {
    if (rank_[atom] != kNone) return;
    std::vector<u32>& atoms = atoms_of_type_[tables_.atoms[atom].type];
    rank_[atom] = static_cast<u32>(atoms.size());
    atoms.push_back(atom);
  }
  void rank_atoms(const Class& type_class) {
    for (std::size_t parameter = 0; parameter < type_class.parameters; ++parameter) {
      for (const rt::InteractionId member : type_class.members) rank(atom_of(member, parameter));
    }
  }

  // Those of atoms, then those of the connectors of flat interactions, then the others as they are.
  void order_cells(InnerOrder& order) const {
    std::vector<bool> is_done(image_.cell_count, false);
    const auto add = [&](u32 first, u32 count) {
      for (u32 cell = first; cell < first + count; ++cell) {
        if (is_done[cell]) continue;
        is_done[cell] = true;
        order.cells.push_back(cell);
        order.cell_distance.push_back(count);
      }
    };
    for (const u32 atom : order.atoms)
      add(tables_.atoms[atom].first_cell.value, image_.atom_types[tables_.atoms[atom].type].variables.size);
    for (const u32 interaction : order.interactions) {
      const rt::InteractionInfo info = tables_.interactions[rt::InteractionId(interaction)];
      if (info.kind != rt::InteractionKind::Port)
        add(image_.connectors[info.row].first_cell, tables_.connector_type(info.row).variables.size);
    }
    for (u32 cell = 0; cell < image_.cell_count; ++cell) add(cell, 1);
  }

  const rt::Image& image_;
  const rt::Tables& tables_;
  std::vector<Class> classes_;
  std::vector<u32> first_atom_, atoms_;          // by interaction: the atoms of its ports
  std::vector<u32> rank_;                        // by atom: among those of its type
  std::vector<std::vector<u32>> atoms_of_type_;  // by rank
  std::vector<rt::InteractionId> starts_at_;     // by atom: the member that binds it to the early parameter
};

}  // namespace

InnerOrder find_inner_order(const rt::Image& image, const rt::Tables& tables) {
  return OrderFinder(image, tables).find();
}

}  // namespace bip::steps
