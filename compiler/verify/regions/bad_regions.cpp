// See bad_regions.hpp.
#include "compiler/verify/regions/bad_regions.hpp"

#include <algorithm>
#include <map>

#include "compiler/model/code_uses.hpp"
#include "compiler/verify/counting/class_combinations.hpp"
#include "compiler/verify/regions/property_ranges.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::size_t kMostRegionCombinations = 50'000;
constexpr std::size_t kMostBadRegions = 8;
constexpr std::size_t kMostGuardedPairs = 40'000;  // of states of two components that a guard is evaluated for
constexpr std::size_t kConnectorsBetweenLooks = 64;

// ---- deadlock ---------------------------------------------------------------------------------------------------

class DeadlockRows {
 public:
  DeadlockRows(const RegionNet& net, const RegionSpaces& spaces, ExclusionProgram& program)
      : net_(net), spaces_(spaces), program_(program), domain_(net.system->code) {
    for (u32 atom = 0; atom < spaces.spaces.size(); ++atom) {
      const AtomType& type = net.type_of(atom);
      sure_.emplace_back(type.ports.size());
      for (u32 port = 0; port < type.ports.size(); ++port) {
        for (u32 state = 0; state < spaces.spaces[atom].size(); ++state) {
          if (spaces.spaces[atom].surely_offers(state, port)) sure_[atom][port].push_back(state);
        }
        if (type.ports[port].exported) continue;
        // A step of its own.
        for (const u32 state : sure_[atom][port])
          program.forbid(spaces.first[atom] + state, net.first_own_step[atom] + port);
      }
    }
  }

  void add(u32 connector) {
    const Connector& row = net_.connector(connector);
    const ConnectorType& type = net_.type_of(row);
    start(connector);
    source_ = connector;
    members_.clear();
    for (u32 param = 0; param < row.ports.size(); ++param) {
      const PortRef& ref = row.ports[param];
      const std::vector<u32>& sure = sure_[ref.atom.value][ref.port];
      if (sure.empty()) return;
      members_.push_back({ref.atom.value, type.params[param].first_bind,
                          &net_.type_of(ref.atom.value).ports[ref.port].variables, sure});
    }
    together_.clear();
    if (!type.clauses.empty() && type.clauses.front().guard.is_valid() && !split(type.clauses.front().guard)) return;
    for (Member& member : members_) {
      if (member.states.empty()) return;
    }
    // Where every state will do, the member is nothing that a deadlock could rest on.
    if (together_.empty())
      std::erase_if(members_, [&](const Member& m) { return m.states.size() == spaces_.spaces[m.atom].size(); });
    if (members_.empty()) {
      forbid_all(row.ports.front().atom.value);
    } else if (members_.size() == 1 && together_.empty()) {
      for (const u32 state : members_[0].states) program_.forbid(spaces_.first[members_[0].atom] + state, source_);
    } else if (members_.size() == 2) {
      exclude_pairs();
    }
  }

 private:
  struct Member {
    u32 atom = 0, first_bind = 0;
    const std::vector<u32>* variables = nullptr;
    std::vector<u32> states;  // in which it takes part for sure, as far as it decides
  };

  void start(u32 connector) {
    const Connector& row = net_.connector(connector);
    point_.bind.clear();
    for (const PortRef& ref : row.ports) {
      for (const u32 variable : net_.type_of(ref.atom.value).ports[ref.port].variables)
        point_.bind.push_back(net_.range(ref.atom.value, variable));
    }
    for (const DataRef& ref : row.data) point_.bind.push_back(net_.range(ref.atom.value, ref.variable));
    const auto own = net_.ranges.begin() + static_cast<std::ptrdiff_t>(net_.first_own[connector]);
    point_.self.assign(own, own + static_cast<std::ptrdiff_t>(net_.type_of(row).variables.size()));
  }
  void enter(const Member& member, u32 state) {
    for (u32 k = 0; k < member.variables->size(); ++k)
      point_.bind[member.first_bind + k] = spaces_.spaces[member.atom].range(state, (*member.variables)[k]);
  }
  void leave(const Member& member) {
    for (u32 k = 0; k < member.variables->size(); ++k)
      point_.bind[member.first_bind + k] = net_.range(member.atom, (*member.variables)[k]);
  }
  [[nodiscard]] bool is_sure(ExprId condition) { return domain_.evaluate(condition, point_).low >= 1; }

  // Filters the members' states by the conjuncts about one of them; stores the others. False: never sure.
  bool split(ExprId guard) {
    std::vector<ExprId> todo{guard};
    while (!todo.empty()) {
      const ExprId id = todo.back();
      todo.pop_back();
      const Expr& e = net_.system->code.exprs[id];
      if (e.op == Op::And) {
        todo.insert(todo.end(), {e.b, e.a});
        continue;
      }
      if (is_sure(id)) continue;
      reads_.assign(point_.bind.size(), false);
      model::mark_reads(net_.system->code, id, Op::LoadBind, reads_);
      Member* only = nullptr;
      std::size_t count = 0;
      for (Member& member : members_) {
        bool depends = false;
        for (u32 k = 0; k < member.variables->size(); ++k)
          depends |= reads_[member.first_bind + k] && !is_one_range(member.atom, (*member.variables)[k]);
        if (!depends) continue;
        only = &member;
        ++count;
      }
      if (count == 0) return false;
      if (count > 1) {
        together_.push_back(id);
        continue;
      }
      std::erase_if(only->states, [&](u32 state) {
        enter(*only, state);
        return !is_sure(id);
      });
      leave(*only);
      if (only->states.empty()) return false;
    }
    return true;
  }
  [[nodiscard]] bool is_one_range(u32 atom, u32 variable) const {
    const LocalSpace& space = spaces_.spaces[atom];
    return space.size() == 0 || space.range(0, variable) == net_.range(atom, variable);
  }
  void forbid_all(u32 atom) {
    for (u32 state = 0; state < spaces_.spaces[atom].size(); ++state)
      program_.forbid(spaces_.first[atom] + state, source_);
  }
  void exclude_pairs() {
    const Member &a = members_[0], &b = members_[1];
    if (together_.empty()) {
      exclude(a, a.states, b, b.states);
      return;
    }
    if (a.states.size() * b.states.size() > kMostGuardedPairs) return;
    std::map<std::vector<u32>, std::vector<u32>> by_partners;
    for (const u32 state : a.states) {
      enter(a, state);
      std::vector<u32> partners;
      for (const u32 other : b.states) {
        enter(b, other);
        if (std::all_of(together_.begin(), together_.end(), [&](ExprId id) { return is_sure(id); }))
          partners.push_back(other);
      }
      if (!partners.empty()) by_partners[std::move(partners)].push_back(state);
    }
    for (const auto& [partners, states] : by_partners) exclude(a, states, b, partners);
  }
  // Not both: one implies the rest of the other one, whichever is shorter to say.
  void exclude(const Member& a, const std::vector<u32>& of_a, const Member& b, const std::vector<u32>& of_b) {
    const std::size_t all_a = spaces_.spaces[a.atom].size(), all_b = spaces_.spaces[b.atom].size();
    if (of_a.size() + all_b - of_b.size() <= of_b.size() + all_a - of_a.size()) imply(a.atom, of_a, b.atom, of_b);
    else imply(b.atom, of_b, a.atom, of_a);
  }
  void imply(u32 atom, const std::vector<u32>& states, u32 other, const std::vector<u32>& excluded) {
    Implication implication;
    for (const u32 state : states) implication.states.push_back(spaces_.first[atom] + state);
    for (u32 state = 0; state < spaces_.spaces[other].size(); ++state) {
      if (!std::binary_search(excluded.begin(), excluded.end(), state))
        implication.implied.push_back(spaces_.first[other] + state);
    }
    implication.source = source_;
    program_.add(std::move(implication));
  }

  const RegionNet& net_;
  const RegionSpaces& spaces_;
  ExclusionProgram& program_;
  IntervalDomain domain_;
  std::vector<std::vector<std::vector<u32>>> sure_;  // by component and port: states that offer it for sure
  IntervalPoint point_;
  u32 source_ = ExclusionProgram::kNone;
  std::vector<Member> members_;
  std::vector<ExprId> together_;  // conjuncts about several members
  std::vector<bool> reads_;
};

}  // namespace

std::optional<std::vector<BadRegions>> find_bad_regions(const RegionNet& net, const Property& property,
                                                        const std::vector<LocalSpace>& spaces) {
  const std::vector<u32> atoms = atoms_of(property);
  if (atoms.empty() || !connectors_of(property).empty()) return std::nullopt;
  BIP_ASSERT(spaces.size() == net.connectors.size(), "{} spaces of {} components", spaces.size(),
             net.connectors.size());
  const PropertyRanges ranges(property, [&spaces](u32 atom) -> const LocalSpace& { return spaces[atom]; });
  std::vector<std::vector<std::vector<u32>>> classes;  // by component and class: states that the property sees alike
  std::size_t combinations = 1;
  for (const u32 atom : atoms) {
    std::map<std::vector<std::int64_t>, std::vector<u32>> by_view;
    for (u32 state = 0; state < spaces[atom].size(); ++state) {
      std::vector<std::int64_t> view;
      for (const PropertyNode& node : property.nodes) {
        if (!names_atom(node.kind) || node.owner != atom) continue;
        const Range range = ranges.of_state(node, state);
        view.insert(view.end(), {range.low, range.high});
      }
      by_view[std::move(view)].push_back(state);
    }
    classes.emplace_back();
    for (auto& [view, states] : by_view) classes.back().push_back(std::move(states));
    combinations *= classes.back().size();
    if (combinations > kMostRegionCombinations) return std::nullopt;
  }
  std::vector<ClassCombination> bad;
  std::map<u32, u32> state_of;
  for (std::size_t number = 0; number < combinations; ++number) {
    std::size_t rest = number;
    ClassCombination combination;
    for (std::size_t k = 0; k < atoms.size(); ++k) {
      combination.push_back({static_cast<u32>(rest % classes[k].size())});
      rest /= classes[k].size();
      state_of[atoms[k]] = classes[k][combination.back().front()].front();
    }
    if (ranges.may_be(property.is_never, state_of)) bad.push_back(std::move(combination));
  }
  for (std::size_t k = 0; k < atoms.size(); ++k) join_combinations(bad, k);
  if (bad.size() > kMostBadRegions) return std::nullopt;
  std::vector<BadRegions> result;
  for (const ClassCombination& combination : bad) {
    BadRegions& one = result.emplace_back();
    one.atoms = atoms;
    for (std::size_t k = 0; k < atoms.size(); ++k) {
      std::vector<u32>& all = one.states.emplace_back();
      for (const u32 row : combination[k]) all.insert(all.end(), classes[k][row].begin(), classes[k][row].end());
      std::sort(all.begin(), all.end());
    }
  }
  return result;
}

bool add_deadlock(const RegionNet& net, const RegionSpaces& spaces, ExclusionProgram& program,
                  const CancellationToken& cancellation) {
  DeadlockRows rows(net, spaces, program);
  for (u32 connector = 0; connector < net.system->connectors.size(); ++connector) {
    if (connector % kConnectorsBetweenLooks == 0 && cancellation.is_over()) return false;
    rows.add(connector);
  }
  return true;
}

}  // namespace bip::verify
