// See symmetry.hpp. Finding groups costs, for each member, the connectors at it, twice as often as there are groups.
#include "runtime/explore/symmetry.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include "bip/assert.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kGroupsOfFamily = 8;  // more: the members are individuals, as in a ring
constexpr u32 kDeepest = 200;               // hierarchy of connectors; what is deeper is not looked into

using Key = std::vector<u32>;

// A component array: by index its atoms, in the order of what follows the index in their paths.
struct Family {
  std::string name;   // up to the bracket
  std::string scope;  // the compound that has it
  std::map<u32, std::vector<std::pair<std::string, u32>>> members;
};

// Neighbours in the name of a group; of more the first and the last one stand for all.
constexpr std::size_t kMostListed = 8;

class SymmetryDetector {
 public:
  SymmetryDetector(const Image& image, const Locals& locals, const SymmetryLimits& limits)
      : image_(image), locals_(locals), limits_(limits) {
    owner_.assign(image.cell_count, {kNone, 0});
    for (u32 atom = 0; atom < image.atoms.size; ++atom) {
      for (u32 variable = 0; variable < image.atom_types[image.atoms[atom].type].variables.size; ++variable) {
        owner_[image.atoms[atom].variable(variable)] = {atom, variable};
      }
    }
    connectors_of_.resize(image.atoms.size);
    std::vector<u32> depth(image.connectors.size, 0);
    std::vector<std::vector<u32>> atoms_of(image.connectors.size);
    for (u32 connector = 0; connector < image.connectors.size; ++connector) {
      const Connector& row = image.connectors[connector];
      std::vector<u32>& atoms = atoms_of[connector];
      std::vector<PortRef> refs;
      for (u32 param = 0; param < image.connector_types[row.type].params.size; ++param)
        refs.push_back(image.port_refs[row.ports + param]);
      for (std::size_t k = 0; k < refs.size(); ++k) {
        const PortRef ref = refs[k];
        if (ref.choice != kNone)
          refs.insert(refs.end(), image.choices[ref.choice].ports.begin(), image.choices[ref.choice].ports.end());
        else if (ref.atom != kNone) atoms.push_back(ref.atom);
        else {
          atoms.insert(atoms.end(), atoms_of[ref.connector].begin(), atoms_of[ref.connector].end());
          depth[connector] = std::max(depth[connector], depth[ref.connector] + 1);
        }
      }
      is_too_deep_ = is_too_deep_ || depth[connector] > kDeepest;
      note_flat(connector);
      for (u32 k = 0; k < row.bind_count; ++k) {
        const u32 atom = owner_[image.binds[row.binds + k].variable()].first;
        if (atom != kNone) atoms.push_back(atom);
      }
      std::sort(atoms.begin(), atoms.end());
      atoms.erase(std::unique(atoms.begin(), atoms.end()), atoms.end());
      if (image.connector_types[row.type].exports) continue;
      for (const u32 atom : atoms) connectors_of_[atom].push_back(connector);
    }
  }

  std::vector<Family> families() const {
    std::map<std::string, Family> found;
    if (is_too_deep_) return {};
    for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
      const std::string path = image_.atoms[atom].path();
      for (std::size_t at = path.find('['); at != std::string::npos; at = path.find('[', at + 1)) {
        const std::size_t end = path.find(']', at);
        const std::string name = path.substr(0, at);
        Family& family = found[name];
        family.name = name;
        family.scope = name.substr(0, name.rfind('.'));
        family.members[static_cast<u32>(std::stoul(path.substr(at + 1, end - at - 1)))].emplace_back(
            path.substr(end + 1), atom);
      }
    }
    std::vector<Family> families;
    for (auto& [name, family] : found) families.push_back(std::move(family));
    return families;
  }

  // The members as atoms that correspond; empty if they are not alike or one of them is taken.
  std::vector<std::vector<u32>> columns(const std::vector<const Family*>& together, const std::set<u32>& taken) const {
    std::vector<std::vector<u32>> columns;
    for (const auto& [index, first] : together[0]->members) {
      std::vector<u32> column;
      for (const Family* family : together) {
        const auto member = family->members.find(index);
        if (member == family->members.end()) return {};
        const auto& model = family->members.begin()->second;
        if (member->second.size() != model.size()) return {};
        for (std::size_t k = 0; k < model.size(); ++k) {
          const u32 atom = member->second[k].second;
          if (member->second[k].first != model[k].first || taken.count(atom) != 0) return {};
          if (image_.atoms[atom].type != image_.atoms[model[k].second].type) return {};
          column.push_back(atom);
        }
      }
      columns.push_back(std::move(column));
    }
    return columns;
  }

  // Does exchanging the members map connectors onto connectors, and preserve the predicate?
  bool is_automorphism(const std::vector<u32>& a, const std::vector<u32>& b) {
    AtomExchange exchange;
    std::set<u32> connectors;
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (locals_.class_of(a[k]) != locals_.class_of(b[k])) return false;
      exchange[a[k]] = b[k];
      exchange[b[k]] = a[k];
      connectors.insert(connectors_of_[a[k]].begin(), connectors_of_[a[k]].end());
      connectors.insert(connectors_of_[b[k]].begin(), connectors_of_[b[k]].end());
    }
    work_ += limits_.work_per_exchange;
    if (!has_work_left() || (limits_.preserves_predicate && !limits_.preserves_predicate(exchange))) return false;
    for (const u32 connector : limits_.fixed_connectors) {
      if (key_of(connector, {}) != key_of(connector, exchange)) return false;
    }
    std::vector<Key> before, after;
    for (const u32 connector : connectors) {
      if (maps_flat_to_itself(connector, a, b)) continue;
      before.push_back(key_of(connector, {}));
      after.push_back(key_of(connector, exchange));
      work_ += before.back().size();
      if (!has_work_left()) return false;
    }
    std::sort(before.begin(), before.end());
    std::sort(after.begin(), after.end());
    return before == after;
  }
  bool has_work_left() const { return work_ <= limits_.work; }
  // Does the predicate name an atom of the member?
  bool is_named(const std::vector<u32>& column) const {
    return std::any_of(column.begin(), column.end(), [&](u32 atom) {
      return std::binary_search(limits_.named_atoms.begin(), limits_.named_atoms.end(), atom);
    });
  }

 private:
  // No code, and no groups within groups.
  static bool is_plain(const ConnectorType& type) {
    for (const Clause& clause : type.clauses) {
      if (clause.guard != kNone || clause.up != kNone || clause.down != kNone) return false;
    }
    for (u32 node = 1; node < type.define.size; ++node) {
      if (!type.define[node].is_leaf) return false;
    }
    return true;
  }
  // Of a connector without code and without connectors below, whose ports of each atom are one.
  struct FlatPort {
    u32 atom = 0, port = 0;
    bool is_trigger = false;
  };
  void note_flat(u32 connector) {
    const Connector& row = image_.connectors[connector];
    const ConnectorType& type = image_.connector_types[row.type];
    flat_.emplace_back();
    if (!is_plain(type) || type.exports || type.define.size != type.params.size + 1) return;
    std::vector<FlatPort>& ports = flat_.back();
    for (const DefineNode& node : type.define) {
      if (!node.is_leaf) continue;
      const PortRef ref = image_.port_refs[row.ports + node.param];
      if (ref.choice != kNone || ref.atom == kNone) {
        ports.clear();
        return;
      }
      ports.push_back({ref.atom, ref.port, node.trigger});
    }
    std::sort(ports.begin(), ports.end(), [](const FlatPort& x, const FlatPort& y) { return x.atom < y.atom; });
    const auto same = [](const FlatPort& x, const FlatPort& y) { return x.atom == y.atom; };
    if (std::adjacent_find(ports.begin(), ports.end(), same) != ports.end()) ports.clear();
  }
  // Is the connector the same, port by port, after the exchange? What is not found to be is compared as a whole.
  bool maps_flat_to_itself(u32 connector, const std::vector<u32>& a, const std::vector<u32>& b) {
    const std::vector<FlatPort>& ports = flat_[connector];
    const auto find = [&](u32 atom) -> const FlatPort* {
      const auto found = std::lower_bound(ports.begin(), ports.end(), atom,
                                          [](const FlatPort& port, u32 wanted) { return port.atom < wanted; });
      return found == ports.end() || found->atom != atom ? nullptr : &*found;
    };
    if (ports.empty()) return false;
    for (std::size_t k = 0; k < a.size(); ++k) {
      ++work_;
      const FlatPort *const first = find(a[k]), *const second = find(b[k]);
      if ((first == nullptr) != (second == nullptr)) return false;
      if (first != nullptr && (first->port != second->port || first->is_trigger != second->is_trigger)) return false;
    }
    return true;
  }

  // What a connector is: type, ports, data that it names. Where nothing tells its ports apart their order does not
  // count.
  Key key_of(u32 connector, const AtomExchange& exchange) const {
    const Connector& row = image_.connectors[connector];
    const ConnectorType& type = image_.connector_types[row.type];
    const auto image_of = [&](u32 atom) {
      const auto found = exchange.find(atom);
      return found == exchange.end() ? atom : found->second;
    };
    std::vector<u32> first_bind;
    std::vector<Key> params;
    for (u32 param = 0; param < type.params.size; ++param) {
      Key key;
      append_ref(image_.port_refs[row.ports + param], exchange, key);
      params.push_back(std::move(key));
    }
    const bool has_plain_type = is_plain(type);
    if (has_plain_type && !type.exports) {
      for (const DefineNode& node : type.define) {
        if (node.is_leaf) params[node.param].insert(params[node.param].begin(), node.trigger ? 1u : 0u);
      }
      std::sort(params.begin(), params.end());
    }
    Key key{row.type};
    for (const Key& param : params) {
      key.push_back(static_cast<u32>(param.size()));
      key.insert(key.end(), param.begin(), param.end());
    }
    for (u32 k = 0; k < row.bind_count && !has_plain_type; ++k) {
      const auto& [atom, variable] = owner_[image_.binds[row.binds + k].variable()];
      // Rows of connectors below say nothing that the parameters do not.
      key.push_back(atom == kNone ? kNone : image_of(atom));
      key.push_back(variable);
    }
    return key;
  }
  void append_ref(const PortRef& ref, const AtomExchange& exchange, Key& key) const {
    if (ref.choice != kNone) {
      key.push_back(2);
      for (const PortRef& port : image_.choices[ref.choice].ports) append_ref(port, exchange, key);
    } else if (ref.atom != kNone) {
      const auto found = exchange.find(ref.atom);
      key.insert(key.end(), {0, found == exchange.end() ? ref.atom : found->second, ref.port});
    } else {
      key.insert(key.end(), {1, ref.maximal_only ? 1u : 0u});
      const Key below = key_of(ref.connector, exchange);
      key.insert(key.end(), below.begin(), below.end());
    }
  }

  const Image& image_;
  const Locals& locals_;
  const SymmetryLimits& limits_;
  u64 work_ = 0;
  IndexVector<VariableId, std::pair<u32, u32>> owner_;  // atom, and which of its variables
  std::vector<std::vector<u32>> connectors_of_;         // by atom: those that run
  std::vector<std::vector<FlatPort>> flat_;             // by connector, by atom; empty: it is not flat
  bool is_too_deep_ = false;
};

}  // namespace

Symmetry::Symmetry(const Image& image, const Locals& locals, const SymmetryLimits& limits) {
  if (image.priorities.size != 0) return;
  SymmetryDetector finder(image, locals, limits);
  const std::vector<Family> families = finder.families();
  std::set<u32> taken;
  const auto try_together = [&](const std::vector<const Family*>& together) {
    const std::vector<std::vector<u32>> columns = finder.columns(together, taken);
    std::vector<std::vector<std::size_t>> parts;
    std::size_t unnamed_parts = 0;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      auto part = parts.begin();
      while (part != parts.end() && !finder.is_automorphism(columns[part->front()], columns[k])) ++part;
      if (part != parts.end()) {
        part->push_back(k);
        continue;
      }
      // What the predicate names may well be an individual.
      if (!finder.is_named(columns[k]) && ++unnamed_parts > kGroupsOfFamily) return false;
      parts.push_back({k});
    }
    if (!finder.has_work_left()) return false;
    bool any = false;
    for (const std::vector<std::size_t>& part : parts) {
      if (part.size() < 2) continue;
      any = true;
      Group group{static_cast<u32>(part.size()), static_cast<u32>(columns[part[0]].size()), {}, {}, {}};
      for (const Family* family : together) group.arrays.emplace_back(relative(family->name.c_str()));
      for (const std::size_t k : part) {
        group.atoms.insert(group.atoms.end(), columns[k].begin(), columns[k].end());
        group.indices.push_back(std::next(together[0]->members.begin(), static_cast<std::ptrdiff_t>(k))->first);
      }
      taken.insert(group.atoms.begin(), group.atoms.end());
      groups_.push_back(std::move(group));
    }
    return any;
  };
  std::vector<const Family*> left;
  for (const Family& family : families) {
    // Names are sorted: an array comes before what is inside its members.
    if (family.members.size() > 1 && !try_together({&family})) left.push_back(&family);
  }
  while (!left.empty()) {
    std::vector<const Family*> together, others;
    for (const Family* family : left) {
      const bool fits = family->scope == left[0]->scope && family->members.size() == left[0]->members.size();
      (fits ? together : others).push_back(family);
    }
    if (together.size() > 1) (void)try_together(together);
    left = std::move(others);
  }
  name_groups();
}

void Symmetry::name_groups() {
  names_.clear();
  for (const Group& group : groups_) {
    std::string indices;
    for (std::size_t first = 0, last = 0; first < group.indices.size(); first = last + 1) {
      last = first;
      while (last + 1 < group.indices.size() && group.indices[last + 1] == group.indices[last] + 1) ++last;
      // A few are listed.
      if (last < first + kMostListed) last = first;
      indices += indices.empty() ? "[" : ",";
      append_number(indices, group.indices[first]);
      if (last == first) continue;
      indices += "..";
      append_number(indices, group.indices[last]);
    }
    indices += ']';
    std::string name;
    for (const std::string& array : group.arrays) name += (name.empty() ? "" : " with ") + array + indices;
    names_.push_back(std::move(name));
  }
}

void Symmetry::fix_first_members() {
  for (Group& group : groups_) {
    --group.members;
    group.atoms.erase(group.atoms.begin(), group.atoms.begin() + group.width);
    group.indices.erase(group.indices.begin());
  }
  std::erase_if(groups_, [](const Group& group) { return group.members < 2; });
  name_groups();
}

std::vector<std::vector<std::vector<u32>>> Symmetry::members() const {
  std::vector<std::vector<std::vector<u32>>> members;
  for (const Group& group : groups_) {
    members.emplace_back();
    for (auto first = group.atoms.begin(); first != group.atoms.end(); first += group.width)
      members.back().emplace_back(first, first + group.width);
  }
  return members;
}

std::vector<u32> Symmetry::permuted_atoms() const {
  std::vector<u32> atoms;
  for (const Group& group : groups_) atoms.insert(atoms.end(), group.atoms.begin(), group.atoms.end());
  return atoms;
}

// Sorts the members of a group by the numbers of their atoms. Returns whether they were in another order.
template <class Get, class Set>
bool Symmetry::sort_members(const Group& group, const Get& get, const Set& set, std::vector<u64>& scratch) {
  const u32 width = group.width;
  BIP_ASSERT(group.atoms.size() == std::size_t{group.members} * width, "{} atoms", group.atoms.size());
  scratch.resize(std::size_t{group.members} * (width + 1));
  u64* values = scratch.data() + group.members;  // scratch begins with the order
  bool is_sorted = true;
  const auto less = [&](u64 a, u64 b) {
    return std::lexicographical_compare(values + a * width, values + (a + 1) * width, values + b * width,
                                        values + (b + 1) * width);
  };
  for (u32 member = 0; member < group.members; ++member) {
    scratch[member] = member;
    for (u32 k = 0; k < width; ++k)
      values[std::size_t{member} * width + k] = get(group.atoms[std::size_t{member} * width + k]);
    is_sorted = is_sorted && (member == 0 || !less(member, member - 1));
  }
  if (is_sorted) return false;
  std::sort(scratch.begin(), scratch.begin() + group.members, less);
  for (u32 member = 0; member < group.members; ++member) {
    const u64* from = values + scratch[member] * width;
    for (u32 k = 0; k < width; ++k) set(group.atoms[std::size_t{member} * width + k], static_cast<u32>(from[k]));
    BIP_ASSERT(member == 0 || !less(scratch[member], scratch[member - 1]), "member {} is not in order", member);
  }
  return true;
}

void Symmetry::normalize(u64* state, const Layout& layout, std::vector<u64>& scratch) const {
  for (const Group& group : groups_) {
    (void)sort_members(
        group, [&](u32 atom) { return layout.get(state, atom); },
        [&](u32 atom, u32 number) { layout.set(state, atom, number); }, scratch);
  }
}

bool Symmetry::normalize(std::vector<u32>& numbers, std::vector<u64>& scratch) const {
  bool has_changed = false;
  for (const Group& group : groups_) {
    has_changed = sort_members(
                      group, [&](u32 atom) { return numbers[atom]; },
                      [&](u32 atom, u32 number) { numbers[atom] = number; }, scratch) ||
                  has_changed;
  }
  return has_changed;
}

void Symmetry::index_interactions(const Shapes& shapes) {
  u32 atoms = 0;
  for (const Group& group : groups_)
    atoms = std::max(atoms, 1 + *std::max_element(group.atoms.begin(), group.atoms.end()));
  // By atom: its group and its member.
  std::vector<std::pair<u32, u32>> place_of(atoms, {kNone, 0});
  u32 base = 0;
  for (u32 row = 0; row < groups_.size(); ++row) {
    const Group& group = groups_[row];
    for (u32 k = 0; k < group.atoms.size(); ++k) place_of[group.atoms[k]] = {row, base + k / group.width};
    base += group.members;
  }
  lone_members_.assign(shapes.interactions.size(), {});
  for (const InteractionId interaction : shapes.interactions.ids()) {
    std::map<u32, std::set<u32>> members_of_group;
    for (const u32 atom : shapes.atoms_of(interaction)) {
      if (atom < atoms && place_of[atom].first != kNone)
        members_of_group[place_of[atom].first].insert(place_of[atom].second);
    }
    for (const auto& [group, members] : members_of_group) {
      if (members.size() == 1) lone_members_[interaction].push_back(*members.begin());
    }
  }
}

void Symmetry::find_equal_members(const u64* state, const Layout& layout, std::vector<u32>& counts) const {
  counts.clear();
  for (const Group& group : groups_) {
    std::size_t first = counts.size();
    counts.resize(first + group.members, 0);
    const auto are_equal = [&](u32 a, u32 b) {
      for (u32 k = 0; k < group.width; ++k) {
        if (layout.get(state, group.atoms[std::size_t{a} * group.width + k]) !=
            layout.get(state, group.atoms[std::size_t{b} * group.width + k]))
          return false;
      }
      return true;
    };
    const std::size_t base = first;
    for (u32 member = 0; member < group.members; ++member) {
      if (member != 0 && !are_equal(member - 1, member)) first = base + member;
      ++counts[first];
    }
  }
}

}  // namespace bip::rt
