// See prove_time.hpp.
#include "compiler/verify/timed/prove_time.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <set>

#include <fmt/format.h>

#include "compiler/system/bsys.hpp"
#include "compiler/system/inner_priorities.hpp"
#include "compiler/system/system_ids.hpp"
#include "compiler/verify/timed/time_divergence.hpp"
#include "compiler/verify/invariants/mode_facts.hpp"
#include "compiler/verify/timed/localization.hpp"
#include "compiler/verify/net/unread_data.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Rounds of invariants of the untimed system: for a deadlock as many as it takes, fewer for a location of a local
// system.
constexpr u32 kRounds = 100000, kRoundsPerLocation = 200;

// The local state of an atom: marked places and data.
struct LocalState {
  std::vector<u32> places;
  std::vector<std::int32_t> values;  // by variable
  friend auto operator<=>(const LocalState&, const LocalState&) = default;
};
// Local states of one component that may get neighbourhoods of their own.
constexpr std::size_t kMaxLocalStates = 2000;

// The result for a local system, and the states of its members whose impossibility it depends on.
struct Explored {
  rt::PartReport report;
  std::vector<std::vector<LocalState>> impossible;  // by member
};

class TimeProver {
 public:
  TimeProver(const System& system, const std::vector<DataRef>& asked, const ExplorePart& explore,
             const CancellationToken& cancellation, const PartLimits& limits)
      : is_read_(find_read_data(system, asked)),
        simple_(without_unread_data(system, is_read_)),
        neighbours_(simple_),
        explore_(explore),
        cancellation_(cancellation),
        limits_(limits) {}

  TimeProof prove() {
    if (!prepare()) return std::move(proof_);
    if (has_deadlock()) return fail("a deadlock is not excluded by invariants");
    for (u32 atom = 0; atom < simple_.atoms.size(); ++atom) {
      if (!bounds_time(simple_, AtomId(std::size_t{atom}))) continue;
      ++proof_.neighbourhoods;
      if (!never_stops_time(atom)) return std::move(proof_);
    }
    proof_.invariants += facts_->invariants();
    proof_.is_proved = true;
    return std::move(proof_);
  }

  TimeProof prove(const Property& property) {
    if (!prepare()) return std::move(proof_);
    std::vector<u32> about = atoms_of(property);
    // Zones need a clock, whosever it is.
    const auto has_clock = [&](u32 atom) {
      return !simple_.atom_types[simple_.atoms[AtomId(std::size_t{atom})].type].clocks.empty();
    };
    if (std::none_of(about.begin(), about.end(), has_clock)) {
      u32 first = 0;
      while (first < simple_.atoms.size() && !has_clock(first)) ++first;
      if (first == simple_.atoms.size()) return fail("no component has a clock");
      about.push_back(first);
    }
    proof_.neighbourhoods = 1;
    proof_.is_proved = prove_by_refinement({.property = &property}, std::move(about));
    proof_.invariants += facts_->invariants();
    return std::move(proof_);
  }

 private:
  // Does the target (in one of its states only, or in all) ever stop time for good? Or is a property broken?
  struct Query {
    u32 target = 0;
    const LocalState* only = nullptr;
    const Property* property = nullptr;
  };

  bool prepare() {
    divergent_limit_ = time_divergent_limit(simple_);
    net_ = build_net(divergent_limit_);
    if (net_.too_large_atom != kNoRow)
      proof_.reason = "`" + path_of(net_.too_large_atom) + "` has too many local states";
    if (net_.too_large_atom != kNoRow) return false;
    std::vector<std::vector<AbstractValue>> constants;
    for (const ModeClass& row : net_.classes) constants.push_back(constants_of(row));
    constant_ = [this, constants](u32 atom, u32 variable) { return constants[net_.class_of[atom]][variable]; };
    facts_ = std::make_unique<ModeFacts>(net_, Encoded::Nothing, cancellation_);
    return true;
  }

  TimeProof fail(const std::string& reason) {
    proof_.reason = reason;
    return std::move(proof_);
  }
  [[nodiscard]] std::string path_of(u32 atom) const {
    const std::string& path = simple_.atoms[AtomId(std::size_t{atom})].path;
    return path.starts_with("ROOT.") ? path.substr(5) : path;
  }

  bool has_deadlock() {
    ModeFacts facts(net_, Encoded::NoStep, cancellation_);
    for (u32 atom = 0; atom < simple_.atoms.size(); ++atom) {
      for (const u32 mode : bounded_modes(net_, atom)) facts.exclude(net_.mode_base[atom] + mode);
    }
    const bool may_be = facts.may_be({}, kRounds);
    proof_.invariants = facts.invariants();
    return may_be;
  }

  // Returns the modes that abstract the atom's local state.
  [[nodiscard]] std::vector<u32> modes_of(u32 atom, const LocalState& state) const {
    const ModeClass& row = net_.class_at(atom);
    const AtomType& type = divergent_limit_.atom_types[row.type];
    BIP_ASSERT(state.values.size() <= row.followed.size(), "{} values of {} variables", state.values.size(),
               row.followed.size());
    std::vector<u32> modes;
    for (u32 mode = 0; mode < row.modes.size(); ++mode) {
      const Mode& of = row.modes[mode];
      bool fits = of.places == state.places;
      for (std::size_t k = 0; k < state.values.size() && fits; ++k) {
        if (row.followed[k] == 0 || !of.values[k].is_known) continue;
        // Without a row the string is "", which is row 0 at run time.
        const std::int32_t value =
            type.variables[k].type == Type::String ? std::max(of.values[k].value, 0) : of.values[k].value;
        fits = value == state.values[k];
      }
      if (fits) modes.push_back(net_.mode_base[atom] + mode);
    }
    return modes;
  }

  [[nodiscard]] LocalState local_state(const rt::Core& core, u32 row, const AtomType& type) const {
    LocalState state;
    for (u32 place = 0; place < type.places.size(); ++place) {
      if (core.is_marked(row, place)) state.places.push_back(place);
    }
    const rt::VariableId base = core.image().atoms[row].variable(0);
    for (u32 variable = 0; variable < type.variables.size(); ++variable)
      state.values.push_back(core.cell(base + variable).i);
    return state;
  }

  [[nodiscard]] bool is_impossible(const std::vector<u32>& members, const std::vector<LocalState>& states) {
    std::vector<std::vector<u32>> sets;
    BIP_ASSERT(members.size() == states.size(), "{} states of {} members", states.size(), members.size());
    for (std::size_t row = 0; row < members.size(); ++row) sets.push_back(modes_of(members[row], states[row]));
    return !facts_->may_be(sets, kRoundsPerLocation);
  }

  // Explores a local system. An equal one that was explored before has the same zones if the same states are
  // impossible. `target`: its row in the local system.
  const rt::PartReport& explore(const LocalizedSystem& part, u32 target, const Query& query) {
    const LocalState* only = query.only;
    BIP_ASSERT(target < part.members.size() || query.property != nullptr, "member {} of {} is asked about", target,
               part.members.size());
    std::string key = system::print(part.system) + std::to_string(target);
    if (only != nullptr) {
      for (const u32 place : only->places) key += ' ' + std::to_string(place);
      for (const std::int32_t value : only->values) key += ',' + std::to_string(value);
    }
    for (const std::uint8_t whole : part.is_whole) key += whole != 0 ? 'w' : 'c';
    if (const auto earlier = explored_parts_.find(key); earlier != explored_parts_.end()) {
      const std::vector<std::vector<LocalState>>& impossible = earlier->second.impossible;
      BIP_ASSERT(
          std::all_of(impossible.begin(), impossible.end(),
                      [&](const std::vector<LocalState>& states) { return states.size() == part.members.size(); }),
          "states of another local system, of {} members", part.members.size());
      if (std::all_of(impossible.begin(), impossible.end(),
                      [&](const std::vector<LocalState>& states) { return is_impossible(part.members, states); }))
        return earlier->second.report;
    }
    Explored found;
    rt::PartQuestion question{.atom = target, .is_whole = part.is_whole, .is_impossible = {}, .is_asked = {}};
    const auto state_of = [&](const rt::Core& core, u32 row) {
      return local_state(core, row, part.system.atom_types[part.system.atoms[AtomId(std::size_t{row})].type]);
    };
    if (query.property != nullptr) {
      question.asks_places = true;
      question.is_asked = [mine = localize(*query.property, part.members)](const rt::Core& core) {
        return is_broken(mine, core);
      };
    }
    if (only != nullptr) question.is_asked = [&](const rt::Core& core) { return state_of(core, target) == *only; };
    // Of one component the modes say all; invariants may exclude more if there are several, or for a property.
    if (part.members.size() > 1 || query.property != nullptr) {
      question.is_impossible = [&](const rt::Core& core) {
        std::vector<LocalState> states;
        for (u32 row = 0; row < part.members.size(); ++row) states.push_back(state_of(core, row));
        if (!is_impossible(part.members, states)) return false;
        found.impossible.push_back(std::move(states));
        return true;
      };
    }
    found.report = explore_(part.system, options(), question);
    ++proof_.explored;
    proof_.zones += found.report.zones;
    Explored& entry = explored_parts_[key];
    entry = std::move(found);
    return entry.report;
  }

  // Is a step possible whenever this component stops time? First with one neighbourhood for all of its local states,
  // then, if that becomes too large, with a neighbourhood for each of them.
  bool never_stops_time(u32 target) {
    if (prove_by_refinement({.target = target}, {target})) return true;
    if (!is_too_large_) return false;
    const std::string reason = proof_.reason;
    const LocalizedSystem alone = localize(simple_, neighbours_, is_read_, constant_, {target});
    const AtomType& type = simple_.atom_types[simple_.atoms[AtomId(std::size_t{target})].type];
    if (!alone.required.empty()) return false;
    std::set<LocalState> done;
    while (done.size() < kMaxLocalStates) {
      LocalState open;
      rt::PartQuestion question{.atom = 0, .is_whole = alone.is_whole, .is_impossible = {}, .is_asked = {}};
      question.is_asked = [&](const rt::Core& core) {
        LocalState state = local_state(core, 0, type);
        if (done.count(state) != 0) return false;
        open = std::move(state);
        return true;
      };
      const rt::PartReport found = explore_(alone.system, options(), question);
      ++proof_.explored;
      proof_.zones += found.zones;
      if (!found.is_open) return found.is_complete;
      BIP_ASSERT(done.count(open) == 0, "a local state of atom {} is open again", target);
      if (!prove_by_refinement({.target = target, .only = &open}, {target})) return false;
      done.insert(std::move(open));
    }
    proof_.reason = reason;
    return false;
  }

  [[nodiscard]] rt::ExploreOptions options() const { return local_options(limits_.zones, cancellation_); }

  // Refinement loop: `joined` are the members; a neighbour joins while the query stays open.
  bool prove_by_refinement(const Query& query, std::vector<u32> joined) {
    const std::string about = query.property != nullptr ? "the property may be broken"
                                                        : "time may stand still at `" + path_of(query.target) + "`";
    is_too_large_ = false;
    while (joined.size() <= limits_.members) {
      std::vector<u32> members = joined;
      std::sort(members.begin(), members.end());
      BIP_ASSERT(std::adjacent_find(members.begin(), members.end()) == members.end(), "one of {} members twice",
                 members.size());
      const LocalizedSystem part = localize(simple_, neighbours_, is_read_, constant_, members);
      proof_.reason = part.obstacle;
      if (!part.obstacle.empty()) return false;
      if (!part.required.empty()) {
        join(part.required, joined);
        continue;
      }
      const rt::PartReport& found = explore(
          part, static_cast<u32>(std::lower_bound(members.begin(), members.end(), query.target) - members.begin()),
          query);
      proof_.largest = std::max<std::uint64_t>(proof_.largest, members.size());
      if (!found.is_open) {
        is_too_large_ = !found.is_complete;
        if (cancellation_.is_cancelled()) proof_.reason = "interrupted";
        else if (cancellation_.is_over()) proof_.reason = "the time is over";
        else if (!found.is_complete)
          proof_.reason = found.inexact.empty() ? "a neighbourhood of `" + path_of(joined[0]) + "` has too many zones"
                                                : found.inexact;
        return found.is_complete;
      }
      if (!add_neighbour(part, found.open, joined)) {
        proof_.reason = about + ", and no other component is left to look at";
        return false;
      }
    }
    is_too_large_ = true;
    proof_.reason = about + ", as far as " + std::to_string(limits_.members) + " components show";
    return false;
  }

  static void join(const std::vector<u32>& atoms, std::vector<u32>& joined) {
    for (const u32 atom : atoms) {
      if (std::find(joined.begin(), joined.end(), atom) == joined.end()) joined.push_back(atom);
    }
  }

  // Chooses the connector whose components join: of the ports that are offered in the open state those of the members
  // that joined first, then the port with the fewest connectors, then the connector with the fewest new components.
  bool add_neighbour(const LocalizedSystem& part, const rt::State& open, std::vector<u32>& joined) const {
    std::set<std::array<std::size_t, 4>> choices;  // whose port, its connectors, others in this one, its row
    std::vector<rt::VariableId> first_cell{rt::VariableId(0u)};  // by member
    for (const u32 atom : part.members)
      first_cell.push_back(first_cell.back() +
                           static_cast<u32>(simple_.atom_types[simple_.atoms[AtomId(atom)].type].variables.size()));
    const VariableFacts value = [&](u32 atom, u32 variable) {
      const auto at = std::lower_bound(part.members.begin(), part.members.end(), atom);
      if (at == part.members.end() || *at != atom) return constant_(atom, variable);
      const Type type = simple_.atom_types[simple_.atoms[AtomId(std::size_t{atom})].type].variables[variable].type;
      if (type != Type::Int && type != Type::Bool) return AbstractValue{};
      return known(static_cast<std::int32_t>(
          open.data[first_cell[static_cast<std::size_t>(at - part.members.begin())] + variable]));
    };
    for (std::size_t order = 0; order < joined.size(); ++order) {
      const u32 atom = joined[order];
      const auto row =
          static_cast<u32>(std::lower_bound(part.members.begin(), part.members.end(), atom) - part.members.begin());
      const AtomType& type = simple_.atom_types[simple_.atoms[AtomId(std::size_t{atom})].type];
      std::map<u32, std::vector<u32>> tops;  // by port
      for (const u32 top : neighbours_.tops_of(atom)) {
        for (const Neighbours::Leaf& leaf : neighbours_.tops()[top].leaves) {
          if (leaf.atom == atom && may_offer(type, leaf.port, row, open) &&
              may_hold(simple_, neighbours_.tops()[top], value))
            tops[leaf.port].push_back(top);
        }
      }
      for (const auto& [port, rows] : tops) {
        for (const u32 top : rows) {
          const std::vector<u32>& atoms = neighbours_.tops()[top].atoms;
          const auto others = static_cast<std::size_t>(std::count_if(atoms.begin(), atoms.end(), [&](u32 member) {
            return std::find(joined.begin(), joined.end(), member) == joined.end();
          }));
          if (others != 0) choices.insert({order, rows.size(), others, top});
        }
      }
    }
    BIP_ASSERT(std::is_sorted(part.members.begin(), part.members.end()) && part.members.size() == joined.size(),
               "{} of {} components have joined", part.members.size(), joined.size());
    if (choices.empty()) return false;
    BIP_ASSERT(choices.begin()->back() < neighbours_.tops().size(), "connector {} of {}", choices.begin()->back(),
               neighbours_.tops().size());
    join(neighbours_.tops()[choices.begin()->back()].atoms, joined);
    return true;
  }

  // By its places alone; of a type that is no automaton any port.
  [[nodiscard]] static bool may_offer(const AtomType& type, u32 port, u32 row, const rt::State& open) {
    return std::any_of(type.transitions.begin(), type.transitions.end(), [&](const Transition& t) {
      return t.port == port && (t.from.size() != 1 || type.initial.size() != 1 || open.places[row] == t.from[0]);
    });
  }

  std::vector<std::vector<std::uint8_t>> is_read_;
  System simple_, divergent_limit_;
  Neighbours neighbours_;
  const ExplorePart& explore_;
  CancellationToken cancellation_;
  PartLimits limits_;
  Net net_;
  VariableFacts constant_;
  bool is_too_large_ = false;  // why there is no answer: the limits
  std::unique_ptr<ModeFacts> facts_;
  std::map<std::string, Explored> explored_parts_;  // by the text of the local system
  TimeProof proof_;
};

}  // namespace

// In a part, an eager step may be possible that others hinder in the whole, so parts cannot tell where it stops time.
std::string open_eager_bound(const System& system) {
  bool has_strict = false;
  for (const AtomType& type : system.atom_types) {
    for (const Transition& t : type.transitions) {
      for (const Bound& bound : t.when.bounds) has_strict |= bound.op == BoundOp::Gt || bound.op == BoundOp::Lt;
    }
  }
  for (const AtomType& type : system.atom_types) {
    for (const Transition& t : type.transitions) {
      if (has_strict && t.urgency == Urgency::Eager)
        return fmt::format("an eager step of `{}` may begin after an open bound, where time stops", type.name);
    }
  }
  return "";
}

std::string obstacle_to_local_proof(const System& system, const Property& property) {
  for (const PropertyNode& node : property.nodes) {
    if (node.kind == PropertyKind::CanConnector || node.kind == PropertyKind::CanPort)
      return "what `can` asks depends on the instant";
  }
  return obstacle_to_time_divergent_limit(system);
}

rt::ExploreOptions local_options(std::uint64_t zones, const CancellationToken& cancellation) {
  rt::ExploreOptions options;
  options.limit = zones;
  options.is_stopped = [&cancellation] { return cancellation.is_over(); };
  return options;
}

TimeProof prove_time(const System& system, const ExplorePart& explore, const CancellationToken& cancellation,
                     const PartLimits& limits) {
  TimeProof proof;
  proof.reason = obstacle_to_time_divergent_limit(system);
  if (proof.reason.empty()) proof.reason = system::first_inner_priority(system);
  if (proof.reason.empty()) proof.reason = open_eager_bound(system);
  if (!proof.reason.empty()) return proof;
  return TimeProver(system, {}, explore, cancellation, limits).prove();
}

TimeProof prove_state_in_time(const System& system, const Property& property, const ExplorePart& explore,
                              const CancellationToken& cancellation, const PartLimits& limits) {
  TimeProof proof;
  proof.reason = obstacle_to_local_proof(system, property);
  if (atoms_of(property).empty()) proof.reason = "the property speaks of no component";
  if (!proof.reason.empty()) return proof;
  return TimeProver(system, data_of(property), explore, cancellation, limits).prove(property);
}

}  // namespace bip::verify
