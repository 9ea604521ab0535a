// Atoms of the transition system: state bits, enabled ports with the atom's priorities, what firing a port does,
// internal transitions unrolled, invariants.
#include <algorithm>
#include <bit>

#include "compiler/system/system.hpp"
#include "compiler/verify/symbolic/transition_system_builder.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

Variables TransitionSystemBuilder::variables_of(Local& local) const {
  Variables v;
  v.self = [&local](u32 k) { return local.variables[k]; };
  v.set_self = [&local](u32 k, Word w) { local.variables[k] = std::move(w); };
  return v;
}

Signal TransitionSystemBuilder::marked(const Local& local, const std::vector<u32>& places) {
  Signal result = kTrue;
  for (u32 place : places) result = aig_.make_and(result, local.marks[place]);
  return result;
}

void TransitionSystemBuilder::merge(Signal when, const Local& from, Local& into) {
  for (std::size_t p = 0; p < into.marks.size(); ++p) into.marks[p] = aig_.make_ite(when, from.marks[p], into.marks[p]);
  for (std::size_t k = 0; k < into.variables.size(); ++k) {
    if (from.variables[k].empty() || into.variables[k].empty()) {
      if (when == kTrue) into.variables[k] = from.variables[k];
      else if (when != kFalse) into.variables[k].clear();
      continue;
    }
    into.variables[k] = make_ite(aig_, when, from.variables[k], into.variables[k]);
  }
}

// Inputs for places and variables, and what they are at first.
void TransitionSystemBuilder::add_state() {
  transition_system_.ranges = find_ranges(system_, image_);
  transition_system_.words.resize(tables_.atom_cells);
  for (u32 a = 0; a < system_.atoms.size(); ++a) {
    const AtomType& type = type_of(a);
    const u32 base = image_.atoms[a].first_cell;
    const bool alone = type.is_automaton();
    transition_system_.is_automaton.push_back(alone ? 1 : 0);
    Local now;
    std::vector<u32> group;
    for (u32 p = 0; p < type.places.size(); ++p) {
      if (alone && type.places.size() == 1) {
        now.marks.push_back(kTrue);
        continue;
      }
      now.marks.push_back(aig_.make_input());
      group.push_back(static_cast<u32>(transition_system_.bits.size()));
      transition_system_.bits.push_back(
          {.now = now.marks.back(), .is_place = true, .is_alone = alone, .atom = a, .row = p});
    }
    if (alone && !group.empty()) transition_system_.exactly_one.push_back(group);
    for (u32 k = 0; k < type.variables.size(); ++k) {
      atom_of_cell_.resize(std::max<std::size_t>(atom_of_cell_.size(), base + k + 1), kNoRow);
      atom_of_cell_[base + k] = a;
      if (!is_followed(type.variables[k].type)) {
        now.variables.emplace_back();
        continue;
      }
      const Range& range = transition_system_.ranges[base + k];
      Word word;
      if (range.low == range.high) {
        word = word_of(static_cast<std::int32_t>(range.low));
      } else {
        const auto bits = [](std::int64_t value) {
          return static_cast<u32>(std::bit_width(static_cast<std::uint64_t>(value)));
        };
        const u32 width = range.low >= 0 ? bits(range.high)
                                         : std::max(bits(-1 - range.low), range.high < 0 ? 0u : bits(range.high)) + 1;
        for (u32 b = 0; b < width; ++b) {
          word.push_back(aig_.make_input());
          transition_system_.bits.push_back({.now = word.back(), .atom = a, .row = k, .position = b});
        }
        if (range.low >= 0) word.push_back(kFalse);
        if (const Signal inside = fits(word, range); inside != kTrue) transition_system_.in_range.push_back(inside);
      }
      transition_system_.words[base + k] = word;
      now.variables.push_back(std::move(word));
    }
    BIP_ASSERT(now.marks.size() == type.places.size() && now.variables.size() == type.variables.size(),
               "atom {} has {} places", a, now.marks.size());
    BIP_ASSERT(transition_system_.marks.size() == a, "atom {} comes after {}", a, transition_system_.marks.size());
    transition_system_.marks.push_back(now.marks);
    now_.push_back(std::move(now));

    // The initial state, from constants.
    Local first;
    first.marks.assign(type.places.size(), kFalse);
    for (u32 place : type.initial) first.marks[place] = kTrue;
    for (u32 k = 0; k < type.variables.size(); ++k) {
      const bool has_arg = k < system_.atoms[AtomId(std::size_t{a})].args.size();
      first.variables.push_back(!is_followed(type.variables[k].type) ? Word{}
                                : has_arg ? word_of(system_.atoms[AtomId(std::size_t{a})].args[k].int_value)
                                          : word_of(0));
    }
    BIP_ASSERT(first.variables.size() == type.variables.size(), "atom {} has {} variables", a, first.variables.size());
    Signal fault = kFalse, lost = kFalse;
    code_.execute(type.initial_action, variables_of(first), kTrue, fault);
    check_invariants(a, first, kTrue, fault);
    run_internals(a, first, fault, lost);
    if (fault == kTrue || lost != kFalse) transition_system_.starts_with_fault = true;
    for (StateBit& bit_row : transition_system_.bits) {
      if (bit_row.atom != a) continue;
      Signal value = kNoRow;
      if (bit_row.is_place) value = first.marks[bit_row.row];
      else if (!first.variables[bit_row.row].empty()) value = bit(first.variables[bit_row.row], bit_row.position);
      bit_row.initial = value == kTrue ? 1 : value == kFalse ? 0 : -1;
    }
  }
}

Signal TransitionSystemBuilder::fits(const Word& word, const Range& range) {
  if (word.empty() || range == kAnyInt) return kTrue;
  const Word low = word_of(static_cast<std::int32_t>(range.low)), high = word_of(static_cast<std::int32_t>(range.high));
  const Signal is_above = less(aig_, high, word);
  return aig_.make_and(negated(less(aig_, word, low)), negated(is_above));
}

// Which ports are enabled; faults of guards, of two transitions at once and of priorities end the run in this state.
void TransitionSystemBuilder::add_ports() {
  transition_system_.port_is_on.assign(tables_.port_atom.size(), kFalse);
  posts_.resize(tables_.port_atom.size());
  fired_plainly_.assign(tables_.port_atom.size(), kFalse);
  moves_.resize(now_.size());
  enabled_.resize(now_.size());
  for (u32 a = 0; a < now_.size(); ++a) {
    const AtomType& type = type_of(a);
    const Variables variables = variables_of(now_[a]);
    for (const Transition& t : type.transitions) {
      Signal on = kFalse;
      if (t.port != Transition::kInternal) {
        const Signal there = marked(now_[a], t.from);
        on = aig_.make_and(there, code_.test(t.guard, variables, there, state_fault_));
        Signal& port = transition_system_.port_is_on[tables_.port_base(a) + t.port];
        state_fault_ = aig_.make_or(state_fault_, aig_.make_and(port, on));
        port = aig_.make_or(port, on);
      } else {
        // A stable state has no internal transition left.
        Signal ignored = kFalse;
        const Signal there = marked(now_[a], t.from);
        const Signal left = aig_.make_and(there, code_.test(t.guard, variables, there, ignored));
        if (left != kTrue && left != kFalse) transition_system_.in_range.push_back(negated(left));
      }
      enabled_[a].push_back(on);
    }
    if (!type.priorities.empty()) hide_ports(a);
  }
}

void TransitionSystemBuilder::hide_ports(u32 a) {
  const AtomType& type = type_of(a);
  const Variables variables = variables_of(now_[a]);
  const std::size_t ports = type.ports.size();
  std::vector<std::vector<Signal>> above(ports, std::vector<Signal>(ports, kFalse));  // low, high
  for (const AtomPriority& rule : type.priorities) {
    const Signal holds = code_.test(rule.guard, variables, kTrue, state_fault_);
    for (u32 low = 0; low < ports; ++low) {
      for (u32 high = 0; high < ports; ++high) {
        if (rule.low != AtomPriority::kAnyPort ? rule.low != low : low == rule.high) continue;
        if (rule.high != AtomPriority::kAnyPort ? rule.high != high : high == rule.low) continue;
        above[low][high] = aig_.make_or(above[low][high], holds);
      }
    }
  }
  const Signal* on = transition_system_.port_is_on.data() + tables_.port_base(a);
  std::vector<Signal> covered(ports, kFalse), on_cycle(ports, kTrue);
  for (std::size_t round = 0; round < ports; ++round) {
    std::vector<Signal> covers(ports, kFalse), cycles(ports, kFalse);
    for (std::size_t low = 0; low < ports; ++low) {
      for (std::size_t high = 0; high < ports; ++high) {
        covers[low] = aig_.make_or(covers[low], aig_.make_and(above[low][high], aig_.make_or(on[high], covered[high])));
        cycles[low] = aig_.make_or(cycles[low], aig_.make_and(above[low][high], on_cycle[high]));
      }
    }
    BIP_ASSERT(covers.size() == ports && cycles.size() == ports, "{} ports of {}", covers.size(), ports);
    if (covers == covered && cycles == on_cycle) break;
    covered = std::move(covers);
    on_cycle = std::move(cycles);
  }
  state_fault_ = aig_.make_or(state_fault_, aig_.make_or_of(on_cycle));
  for (std::size_t p = 0; p < ports; ++p) {
    Signal& port = transition_system_.port_is_on[tables_.port_base(a) + p];
    port = aig_.make_and(port, negated(covered[p]));
  }
}

void TransitionSystemBuilder::check_invariants(u32 a, Local& local, Signal when, Signal& fault) {
  const AtomType& type = type_of(a);
  for (const Invariant& invariant : type.invariants) {
    Signal applies = when;
    if (invariant.scope != InvariantScope::Always) applies = aig_.make_and(applies, marked(local, invariant.places));
    if (invariant.scope == InvariantScope::At) {
      for (u32 p = 0; p < type.places.size(); ++p) {
        if (std::find(invariant.places.begin(), invariant.places.end(), p) == invariant.places.end())
          applies = aig_.make_and(applies, negated(local.marks[p]));
      }
    }
    const Signal holds = code_.test(invariant.condition, variables_of(local), applies, fault);
    fault = aig_.make_or(fault, aig_.make_and(applies, negated(holds)));
  }
}

// Tokens, action, invariants, without a look at guards. `when`: under which condition this matters.
void TransitionSystemBuilder::move(u32 a, const Transition& t, Local& local, Signal when, Signal& fault) {
  for (u32 place : t.from) local.marks[place] = kFalse;
  for (u32 place : t.to) {
    fault = aig_.make_or(fault, aig_.make_and(when, local.marks[place]));
    local.marks[place] = kTrue;
  }
  code_.execute(t.action, variables_of(local), when, fault);
  check_invariants(a, local, when, fault);
}

// `active` is where all transitions so far were taken; where it ends, what is there is the result.
void TransitionSystemBuilder::run_internals(u32 a, Local& local, Signal& fault, Signal& lost) {
  const AtomType& type = type_of(a);
  const bool alone = type.is_automaton();
  Local now = local;
  Signal active = kTrue;
  for (u32 round = 0;; ++round) {
    Signal any = kFalse;
    std::optional<Local> next;
    for (const Transition& t : type.transitions) {
      if (t.port != Transition::kInternal) continue;
      const Signal there = aig_.make_and(active, marked(now, t.from));
      if (there == kFalse) continue;
      const Signal on = aig_.make_and(there, code_.test(t.guard, variables_of(now), there, fault));
      if (on == kFalse) continue;
      fault = aig_.make_or(fault, aig_.make_and(any, on));
      any = aig_.make_or(any, on);
      Local moved = now;
      // An automaton is where the transition leads to, and nowhere else.
      if (alone) moved.marks.assign(type.places.size(), kFalse);
      move(a, t, moved, on, fault);
      if (next) merge(on, moved, *next);
      else next = std::move(moved);
    }
    merge(aig_.make_and(active, negated(any)), now, local);
    active = any;
    if (active == kFalse) return;
    if (round == kMaxInternals) {
      lost = aig_.make_or(lost, active);
      return;
    }
    now = std::move(*next);
  }
}

TransitionSystemBuilder::Post TransitionSystemBuilder::fire(u32 port, const Local& before) {
  const u32 a = tables_.port_atom[port];
  const AtomType& type = type_of(a);
  const bool alone = type.is_automaton();
  Post post{before, kFalse, kFalse};
  for (std::size_t t = 0; t < type.transitions.size(); ++t) {
    const Signal on = enabled_[a][t];
    BIP_ASSERT(enabled_[a].size() == type.transitions.size(), "{} of {} transitions", enabled_[a].size(),
               type.transitions.size());
    if (on == kFalse || type.transitions[t].port != port - tables_.port_base(a)) continue;
    Local local = before;
    if (alone) {
      local.marks.assign(type.places.size(), kFalse);
    } else {
      for (u32 place : type.transitions[t].from) local.marks[place] = kTrue;
    }
    Signal fault = kFalse, lost = kFalse;
    move(a, type.transitions[t], local, kTrue, fault);
    run_internals(a, local, fault, lost);
    post.fault = aig_.make_or(post.fault, aig_.make_and(on, fault));
    post.lost = aig_.make_or(post.lost, aig_.make_and(on, lost));
    merge(on, local, post.local);
  }
  return post;
}

// Next values of the bits, once all steps are known.
void TransitionSystemBuilder::finish_state() {
  std::size_t at = 0;
  for (u32 a = 0; a < now_.size(); ++a) {
    Local next = now_[a];
    for (u32 port = tables_.port_base(a); port < tables_.port_base(a + 1); ++port) {
      if (fired_plainly_[port] != kFalse) merge(fired_plainly_[port], posts_[port]->local, next);
    }
    for (const Move& move : moves_[a]) merge(move.when, move.to, next);
    const AtomType& type = type_of(a);
    for (u32 k = 0; k < type.variables.size(); ++k) {
      if (!is_followed(type.variables[k].type)) continue;
      // Something unknown was written somewhere: any value of the range.
      if (next.variables[k].empty()) next.variables[k] = code_.any(type.variables[k].type);
      transition_system_.next_in_range =
          aig_.make_and(transition_system_.next_in_range,
                        fits(next.variables[k], transition_system_.ranges[image_.atoms[a].first_cell + k]));
    }
    for (; at < transition_system_.bits.size() && transition_system_.bits[at].atom == a; ++at) {
      StateBit& row = transition_system_.bits[at];
      BIP_ASSERT(row.is_place ? row.row < next.marks.size() : row.row < next.variables.size(), "bit {} is of row {}",
                 at, row.row);
      row.next = row.is_place ? next.marks[row.row] : bit(next.variables[row.row], row.position);
    }
  }
}

}  // namespace bip::verify
