// See rounds.hpp. What a step may do is more than it does, what is possible for sure is less, so more runs count as
// fair and more rounds are over.
#include "tools/certcheck/rounds.hpp"

namespace certcheck {

Rounds::Rounds(const Model& model, const Certificate& certificate, const Tree& claim, const Terms& terms)
    : model_(model), proof_(certificate), terms_(terms), formula_(claim) {
  if (claim.head() != "runs") throw NotCheckable("a claim about points without a list of states");
  demands_ = formula_.promises() + proof_.turns.size();
  const std::size_t most = std::max({formula_.bits(), demands_, *proof_.rounds + 1});
  for (const Fact& fact : proof_.facts)
    for (const Case& row : fact.cases)
      for (const Literal& l : row.literals)
        if (l.atom == model_.atoms.size() && l.variable >= Monitor::row(Monitor::Bit, most))
          throw Rejected(fact.line + ": the monitor has no such bit");
}

Local Rounds::bits(bool are_first) const {
  const std::size_t most = std::max({formula_.bits(), demands_, *proof_.rounds + 1});
  Local bits;
  for (std::size_t k = 0; k < most; ++k) {
    for (std::size_t kind = 0; kind < Monitor::kKinds; ++kind) {
      // What is promised, and what is guessed never to be possible again, is any at first.
      const std::optional<bool> first = kind == Monitor::Bit && k < formula_.bits() ? formula_.first(k)
                                        : kind == Monitor::Never                    ? std::nullopt
                                                                                    : std::optional(false);
      bits.push_back(are_first && first ? terms_.truth(*first) : terms_.fresh("bool"));
    }
  }
  return bits;
}

expr Rounds::is_bad(const Local& now) const { return now[Monitor::row(Monitor::Over, *proof_.rounds)]; }

// Is the step one of the connector, the port or the atom, or the interaction with exactly these ports?
expr Rounds::takes_turn(const Turn& turn, const Step& step) const {
  const Fair::What what = proof_.fair[turn.fair].what;
  if (what == Fair::Connector) return terms_.truth(step.connector == turn.row);
  if (what != Fair::Interactions)
    return terms_.some(step.parts, [&](const auto& part) {
      const std::size_t row = what == Fair::Port ? part.first : model_.atom_of_port[part.first];
      return row == turn.row ? part.second : terms_.truth(false);
    });
  const bool are_there = std::ranges::all_of(turn.ports, [&](std::size_t port) { return step.parts.contains(port); });
  if (step.connector != turn.row || !are_there) return terms_.truth(false);
  return terms_.all(step.parts,
                    [&](const auto& part) { return contains(turn.ports, part.first) ? part.second : no(part.second); });
}

void Rounds::add_monitor(const Local& now, System& system, std::vector<Step>& steps) const {
  const auto bit = [&](Monitor::Kind kind, std::size_t k) -> const expr& { return now[Monitor::row(kind, k)]; };
  Local possible;
  for (const Turn& turn : proof_.turns)
    possible.push_back(terms_.some(
        steps, [&](const Step& step) { return both(both(step.sure, no(step.fault)), takes_turn(turn, step)); }));
  // The last state of a run repeats.
  const expr ends = no(system.has_step()), never = terms_.truth(false);
  steps.push_back({ends, ends, never, never, kNone, {}, {}, {}});
  Local bits, later;
  for (std::size_t k = 0; k < formula_.bits(); ++k) {
    bits.push_back(bit(Monitor::Bit, k));
    later.push_back(terms_.fresh("bool"));
  }
  // Rounds begin at any time, and with them the guesses count.
  const expr started = is_strong_ ? bit(Monitor::Started, 0) : terms_.truth(true),
             starts = either(started, terms_.fresh("bool"));
  for (Step& step : steps) {
    const bool is_end = &step == &steps.back();
    Local leaves;
    for (const Tree& leaf : formula_.leaves()) {
      if (!Formula::is_about_step(leaf)) leaves.push_back(system.claim(leaf));
      else leaves.push_back(is_end ? terms_.truth(false) : happens(model_, terms_, leaf, step.connector, step.parts));
    }
    const Formula::Point point = formula_.point(terms_, leaves, bits, later);
    expr allowed = point.possible;
    Local met;
    for (const expr& pending : point.pending) met.push_back(no(pending));
    for (std::size_t k = 0; k < proof_.turns.size(); ++k) {
      const expr taken = is_end ? terms_.truth(false) : takes_turn(proof_.turns[k], step);
      const expr is_never = both(started, bit(Monitor::Never, k));
      const bool is_strong = proof_.fair[proof_.turns[k].fair].is_strong;
      met.push_back(either(taken, is_strong ? bit(Monitor::Never, k) : no(possible[k])));
      if (is_strong) allowed = both(allowed, no(both(is_never, possible[k])));
    }
    expr round = started;
    for (std::size_t k = 0; k < met.size(); ++k) round = both(round, either(bit(Monitor::Seen, k), met[k]));
    Local next = now;
    for (std::size_t k = 0; k < formula_.bits(); ++k)
      next[Monitor::row(Monitor::Bit, k)] = formula_.looks_ahead(k) ? later[k] : point.next[k];
    for (std::size_t k = 0; k < met.size(); ++k)
      next[Monitor::row(Monitor::Seen, k)] = both(both(started, no(round)), either(bit(Monitor::Seen, k), met[k]));
    for (std::size_t k = 0; k <= *proof_.rounds; ++k) {
      const expr before = k == 0 ? terms_.truth(true) : bit(Monitor::Over, k - 1);
      next[Monitor::row(Monitor::Over, k)] = either(bit(Monitor::Over, k), both(before, round));
    }
    if (is_strong_) next[Monitor::row(Monitor::Started, 0)] = starts;
    step.next.emplace(model_.atoms.size(), std::move(next));
    step.now.emplace(model_.atoms.size(), now);
    step.possible = both(step.possible, allowed);
    step.offered = both(step.offered, allowed);
  }
}

}  // namespace certcheck
