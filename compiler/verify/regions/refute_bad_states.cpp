// See refute_bad_states.hpp.
#include "compiler/verify/regions/refute_bad_states.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "compiler/base/log.hpp"
#include "compiler/model/code_uses.hpp"
#include "compiler/verify/regions/bad_regions.hpp"
#include "compiler/verify/regions/explore_alone.hpp"
#include "compiler/verify/regions/joint_explorer.hpp"
#include "compiler/verify/regions/region_rows.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr u32 kMostLocal = 2'000;                   // states of one component
constexpr std::size_t kMostRegionStates = 400'000;  // of all together
constexpr std::size_t kMostProduct = 600;           // of the regions of several ints that are followed together
constexpr std::size_t kMostRegionTuples = 100'000;  // local states that occur together
constexpr std::size_t kMostReasons = 20;
constexpr std::size_t kSample = 32;  // neighbourhoods whose time says what all take

// By atom type and variable.
using Follows = std::vector<std::vector<std::uint8_t>>;

class Refuter {
 public:
  Refuter(const RegionNet& net, const Property* property, const CancellationToken& cancellation, RegionRows rows)
      : net_(net), property_(property), cancellation_(cancellation), wants_rows_(rows == RegionRows::Yes) {
    atoms_of_type_.resize(net.system->atom_types.size());
    for (u32 atom = 0; atom < net.connectors.size(); ++atom) {
      all_atoms_.push_back(atom);
      atoms_of_type_[net.system->atoms[AtomId(std::size_t{atom})].type.value].push_back(atom);
    }
    all_constants_ = constants_of(net, all_atoms_);
    find_observed();
    find_kinds();
  }

  RegionSearch run() {
    std::vector<std::vector<std::vector<std::uint8_t>>> choices;  // by atom type
    std::size_t rounds = 1;
    for (std::size_t type = 0; type < observed_.size(); ++type) {
      choices.push_back(choices_of(type));
      rounds = std::max(rounds, choices.back().size());
    }
    for (std::size_t round = 0; round < rounds && has_time(); ++round) {
      Follows follows;
      for (const auto& of_type : choices) follows.push_back(of_type[std::min(round, of_type.size() - 1)]);
      if (std::optional<RegionRefutation> found = attempt(follows)) return {std::move(found), true};
    }
    return {std::nullopt, has_time()};
  }

 private:
  [[nodiscard]] bool has_time() const { return !is_too_slow_ && !cancellation_.is_over(); }

  // Neighbours of two atom types.
  struct Kind {
    std::vector<std::pair<u32, u32>> pairs;
    std::size_t cost = 0;  // variables that are followed together
  };

  // Data that guards, connectors or the property read.
  void find_observed() {
    const System& system = *net_.system;
    for (const AtomType& type : system.atom_types) {
      std::vector<bool> reads(type.variables.size(), false);
      for (const Transition& t : type.transitions) model::mark_reads(system.code, t.guard, Op::LoadSelf, reads);
      observed_.emplace_back(reads.begin(), reads.end());
    }
    for (const Connector& connector : system.connectors) {
      const ConnectorType& type = system.connector_types[connector.type];
      for (std::size_t param = 0; param < connector.ports.size(); ++param) {
        const PortRef& ref = connector.ports[param];
        const std::vector<u32>& variables = net_.type_of(ref.atom.value).ports[ref.port].variables;
        for (u32 k = 0; k < variables.size(); ++k) {
          if (net_.reads[connector.type.value][type.params[param].first_bind + k])
            observed_[system.atoms[ref.atom].type.value][variables[k]] = 1;
        }
      }
    }
    if (property_ == nullptr) return;
    for (const PropertyNode& node : property_->nodes) {
      if (node.kind == PropertyKind::Data)
        observed_[system.atoms[AtomId(std::size_t{node.owner})].type.value][node.row] = 1;
    }
  }
  void find_kinds() {
    const System& system = *net_.system;
    std::map<std::pair<u32, u32>, std::set<std::pair<u32, u32>>> by_types;
    for (const Connector& connector : system.connectors) {
      for (std::size_t a = 0; a < connector.ports.size(); ++a) {
        for (std::size_t b = a + 1; b < connector.ports.size(); ++b) {
          u32 one = connector.ports[a].atom.value, other = connector.ports[b].atom.value;
          u32 of_one = system.atoms[AtomId(std::size_t{one})].type.value;
          u32 of_other = system.atoms[AtomId(std::size_t{other})].type.value;
          if (std::pair(of_other, other) < std::pair(of_one, one)) {
            std::swap(one, other);
            std::swap(of_one, of_other);
          }
          by_types[{of_one, of_other}].insert({one, other});
        }
      }
    }
    for (const auto& [types, pairs] : by_types) {
      Kind& kind = kinds_.emplace_back();
      kind.pairs.assign(pairs.begin(), pairs.end());
      for (const u32 type : {types.first, types.second})
        kind.cost += static_cast<std::size_t>(std::count(observed_[type].begin(), observed_[type].end(), 1));
    }
    std::stable_sort(kinds_.begin(), kinds_.end(), [](const Kind& a, const Kind& b) { return a.cost < b.cost; });
  }

  // Of all atoms of the type: the most regions of a variable; 1: it never changes.
  [[nodiscard]] std::size_t regions_of(std::size_t type, u32 variable) const {
    std::size_t most = 1;
    for (const u32 atom : atoms_of_type_[type]) {
      if (net_.is_fixed(atom, variable)) continue;
      most = std::max(most,
                      divide(net_.range(atom, variable), all_constants_[net_.values.class_of[type][variable]]).size());
    }
    return most;
  }
  // All bools with each int by itself; then with all ints, if that makes few states.
  [[nodiscard]] std::vector<std::vector<std::uint8_t>> choices_of(std::size_t type) const {
    const AtomType& row = net_.system->atom_types[AtomTypeId(type)];
    std::vector<std::uint8_t> bools(row.variables.size(), 0);
    std::vector<u32> ints;
    std::size_t product = 1;
    for (u32 k = 0; k < row.variables.size(); ++k) {
      if (observed_[type][k] == 0) continue;
      if (row.variables[k].type == Type::Bool) bools[k] = 1;
      if (row.variables[k].type != Type::Int) continue;
      const std::size_t regions = regions_of(type, k);
      if (regions == 1) continue;
      ints.push_back(k);
      product = std::min(product * regions, kMostProduct + 1);
    }
    std::vector<std::vector<std::uint8_t>> choices;
    if (ints.empty()) return {bools};
    for (const u32 k : ints) {
      choices.push_back(bools);
      choices.back()[k] = 1;
    }
    if (ints.size() > 1 && product <= kMostProduct) {
      choices.push_back(bools);
      for (const u32 k : ints) choices.back()[k] = 1;
    }
    return choices;
  }

  [[nodiscard]] std::optional<RegionRefutation> attempt(const Follows& follows) {
    RegionSpaces spaces;
    u32 states = 0;
    for (const u32 atom : all_atoms_) {
      std::optional<LocalSpace> space =
          explore_alone(net_, atom, all_constants_, follows[net_.system->atoms[AtomId(std::size_t{atom})].type.value],
                        kMostLocal, cancellation_);
      if (!space || states + space->size() > kMostRegionStates) return std::nullopt;
      spaces.first.push_back(states);
      states += space->size();
      spaces.spaces.push_back(std::move(*space));
    }
    BIP_LOG(Portfolio, 1, "regions: {} components with {} local states", all_atoms_.size(), states);
    RegionRefutation refutation;
    refutation.local_states = states;
    if (property_ == nullptr) {
      if (!refute(spaces, nullptr, refutation)) return std::nullopt;
      return refutation;
    }
    const std::optional<std::vector<BadRegions>> bad = find_bad_regions(net_, *property_, spaces.spaces);
    if (!bad) return std::nullopt;
    if (wants_rows_) refutation.rows = local_state_rows(net_, spaces, atoms_of(*property_));
    for (const BadRegions& each : *bad) {
      if (!refute(spaces, &each, refutation)) return std::nullopt;
    }
    return refutation;
  }

  [[nodiscard]] bool refute(const RegionSpaces& spaces, const BadRegions* bad, RegionRefutation& refutation) {
    ExclusionProgram program;
    for (u32 atom = 0; atom < all_atoms_.size(); ++atom) {
      const u32 first = program.add_component(spaces.spaces[atom].size());
      BIP_ASSERT(first == spaces.first[atom], "component {} begins at {}", atom, first);
    }
    if (bad == nullptr && !add_deadlock(net_, spaces, program, cancellation_)) return false;
    for (std::size_t k = 0; bad != nullptr && k < bad->atoms.size(); ++k) {
      const u32 atom = bad->atoms[k];
      for (u32 state = 0; state < spaces.spaces[atom].size(); ++state) {
        if (!std::binary_search(bad->states[k].begin(), bad->states[k].end(), state))
          program.forbid(spaces.first[atom] + state);
      }
    }
    if (is_refuted(program, spaces, refutation)) return true;
    if (wants_rows_) return false;
    JointExplorer joint(net_, observed_);
    std::vector<u32> beside{RegionStep::kNone};
    if (bad != nullptr) beside = bad->atoms;
    // Those that the property names, among themselves.
    bool is_related = false;
    for (std::size_t k = 0; bad != nullptr && k < bad->atoms.size(); ++k) {
      for (std::size_t other = k + 1; other < bad->atoms.size() && has_time(); ++other) {
        is_related |= relate(joint, spaces, bad->atoms[k], bad->atoms[other], RegionStep::kNone, program);
        ++refutation.explored;
      }
    }
    if (is_related && is_refuted(program, spaces, refutation)) return true;
    for (const Kind& kind : kinds_) {
      for (const u32 named : beside) {
        bool is_new = false;
        const double before = cancellation_.seconds_left();
        std::size_t done = 0;
        for (const auto& [a, b] : kind.pairs) {
          if (!has_time()) return false;
          if (++done == kSample) {
            const double left = cancellation_.seconds_left();
            is_too_slow_ = (before - left) / kSample * static_cast<double>(kind.pairs.size() - done) > left;
          }
          if (a == named || b == named) continue;
          is_new |= relate(joint, spaces, a, b, named, program);
          ++refutation.explored;
        }
        if (is_new && is_refuted(program, spaces, refutation)) return true;
      }
    }
    return false;
  }

  // Adds what the local states of `a` say about those of `b`, and the other way round, while `named` is in a bad state.
  bool relate(JointExplorer& joint, const RegionSpaces& spaces, u32 a, u32 b, u32 named, ExclusionProgram& program) {
    std::vector<u32> atoms{a, b};
    if (named != RegionStep::kNone) atoms.push_back(named);
    if (!joint.explore(atoms, kMostRegionTuples, cancellation_)) return false;
    // By state of a component's space the states of the program that it may stand for.
    std::vector<std::vector<std::vector<u32>>> possible(atoms.size());
    for (std::size_t k = 0; k < atoms.size(); ++k) {
      const LocalSpace &own = joint.spaces()[k], &whole = spaces.spaces[atoms[k]];
      possible[k].resize(own.size());
      for (u32 state = 0; state < whole.size(); ++state) {
        if (!program.is_possible(spaces.first[atoms[k]] + state)) continue;
        for (u32 each = 0; each < own.size(); ++each) {
          if (own.overlaps(each, whole, state)) possible[k][each].push_back(state);
        }
      }
    }
    const u32 size_a = joint.spaces()[0].size(), size_b = joint.spaces()[1].size();
    std::vector<std::vector<bool>> together(size_a, std::vector<bool>(size_b, false));
    for (const JointExplorer::Tuple& tuple : joint.reached()) {
      if (named != RegionStep::kNone && possible[2][tuple[2]].empty()) continue;
      together[tuple[0]][tuple[1]] = true;
    }
    std::vector<std::vector<bool>> turned(size_b, std::vector<bool>(size_a, false));
    for (u32 k = 0; k < size_a; ++k) {
      for (u32 other = 0; other < size_b; ++other) turned[other][k] = together[k][other];
    }
    const bool is_first = imply(together, possible[0], possible[1], spaces, a, b, program);
    return imply(turned, possible[1], possible[0], spaces, b, a, program) || is_first;
  }
  // `together`: by states of the small spaces.
  bool imply(const std::vector<std::vector<bool>>& together, const std::vector<std::vector<u32>>& possible_a,
             const std::vector<std::vector<u32>>& possible_b, const RegionSpaces& spaces, u32 a, u32 b,
             ExclusionProgram& program) const {
    // By state of the program of `a`: the small states that it may be in.
    std::map<u32, std::vector<u32>> small;
    for (u32 state = 0; state < possible_a.size(); ++state) {
      for (const u32 each : possible_a[state]) small[each].push_back(state);
    }
    std::set<u32> all_b;
    for (const std::vector<u32>& states : possible_b) all_b.insert(states.begin(), states.end());
    std::map<std::vector<u32>, std::vector<u32>> by_small;
    for (auto& [state, states] : small) by_small[states].push_back(state);
    std::map<std::set<u32>, std::vector<u32>> by_implied;
    for (const auto& [states, of_a] : by_small) {
      std::set<u32> implied;
      for (const u32 state : states) {
        for (u32 other = 0; other < possible_b.size(); ++other) {
          if (together[state][other]) implied.insert(possible_b[other].begin(), possible_b[other].end());
        }
      }
      if (implied.size() == all_b.size()) continue;
      std::vector<u32>& all = by_implied[std::move(implied)];
      all.insert(all.end(), of_a.begin(), of_a.end());
    }
    for (auto& [implied, states] : by_implied) {
      std::sort(states.begin(), states.end());
      Implication implication;
      for (const u32 state : states) implication.states.push_back(spaces.first[a] + state);
      for (const u32 state : implied) implication.implied.push_back(spaces.first[b] + state);
      program.add(std::move(implication));
    }
    return !by_implied.empty();
  }

  [[nodiscard]] bool is_refuted(ExclusionProgram& program, const RegionSpaces& spaces,
                                RegionRefutation& refutation) const {
    const std::optional<ExclusionProgram::Proof> proof = program.refute(cancellation_);
    if (!proof) return false;
    if (wants_rows_) {
      std::optional<std::string> rows = deadlock_rows(net_, spaces, program, *proof);
      if (!rows) return false;
      refutation.rows = std::move(*rows);
    }
    refutation.implications += proof->used.size();
    for (const Implication& each : proof->used) {
      if (refutation.reasons.size() >= kMostReasons) break;
      refutation.reasons.push_back((each.multiplier == 1 ? "" : std::to_string(each.multiplier) + " times: ") +
                                   text_of(each.states, spaces) + "  implies  " + text_of(each.implied, spaces));
    }
    return true;
  }
  // "process[0]@LOOKS level=3 | …"
  [[nodiscard]] std::string text_of(const std::vector<u32>& states, const RegionSpaces& spaces) const {
    std::string text;
    constexpr std::size_t kShown = 3;
    for (std::size_t k = 0; k < states.size() && k < kShown; ++k) {
      const auto after = std::upper_bound(spaces.first.begin(), spaces.first.end(), states[k]);
      const u32 atom = static_cast<u32>(after - spaces.first.begin()) - 1, state = states[k] - spaces.first[atom];
      const LocalSpace& space = spaces.spaces[atom];
      const AtomType& type = net_.type_of(atom);
      std::string path = net_.system->atoms[AtomId(std::size_t{atom})].path;
      if (path.starts_with("ROOT.")) path.erase(0, 5);
      text += (k == 0 ? "" : " or ") + path;
      for (const u32 place : space.marking(state)) text += '@' + type.places[place];
      for (u32 variable = 0; variable < type.variables.size(); ++variable) {
        const Range& range = space.range(state, variable);
        if (range == net_.range(atom, variable)) continue;
        text += ' ' + type.variables[variable].name + '=' + std::to_string(range.low);
        if (range.low != range.high) text += ".." + std::to_string(range.high);
      }
    }
    return text + (states.size() > kShown ? " or …" : states.empty() ? "nothing" : "");
  }

  const RegionNet& net_;
  const Property* property_;
  const CancellationToken& cancellation_;
  std::vector<u32> all_atoms_;
  RegionConstants all_constants_;
  Follows observed_;
  std::vector<Kind> kinds_;
  std::vector<std::vector<u32>> atoms_of_type_;
  bool wants_rows_ = false;
  bool is_too_slow_ = false;
};

}  // namespace

RegionSearch refute_bad_states(const RegionNet& net, const Property* property, const CancellationToken& cancellation,
                               RegionRows rows) {
  return Refuter(net, property, cancellation, rows).run();
}

}  // namespace bip::verify
