// Lowers the timed part of types: clocks, bounds, urgency, `resume`. Types without time get no tables.
#include "compiler/lower/pools.hpp"
#include "compiler/model/clock_uses.hpp"
#include "runtime/include/bip/assert.hpp"
#include "runtime/include/bip/image_time.hpp"

namespace bip::lower {

namespace {

bool has_time(const AtomType& type) {
  if (!type.clocks.empty() || type.initial_resume.present) return true;
  for (const Port& port : type.ports) {
    if (port.external) return true;
  }
  for (const Transition& t : type.transitions) {
    if (t.urgency != Urgency::Lazy || t.resume.present || t.async.present) return true;
  }
  return false;
}

struct TimeLowering {
  Lowering& l;
  std::uint32_t row;
  const AtomType& type;

  rt::TimeGuard when(const TimeGuard& guard, const std::string& name) {
    std::vector<rt::Bound> bounds;
    for (const Bound& b : guard.bounds) {
      bounds.push_back({b.clock, b.minus == Bound::kNone ? rt::kNone : b.minus, static_cast<rt::BoundOp>(b.op), b.ticks,
                        b.variable == Bound::kNone ? rt::kNone : b.variable});
    }
    return {l.pools.list(bounds), l.action(CodeOwner::Atom, row, name + "_limits", guard.measure)};
  }
  rt::Resume resume(const Resume& r, const std::string& name) {
    if (!r.present) return {false, rt::kNone, {{}, rt::kNone}};
    return {true, l.guard(CodeOwner::Atom, row, name + "_resume", r.guard), when(r.when, name + "_resume")};
  }
};

}  // namespace

const rt::AtomTime* lower_time(Lowering& l, std::uint32_t row, const AtomType& type) {
  if (!has_time(type)) return nullptr;
  TimeLowering time{l, row, type};
  rt::AtomTime to{};
  std::vector<rt::Clock> clocks;
  for (const Clock& c : type.clocks)
    clocks.push_back(
        {c.name.c_str(), c.unit, c.variable, loc_of(c.loc), model::is_read_by_actions(l.system.code, type, c)});
  to.clocks = l.pools.list(clocks);
  std::vector<rt::TransitionTime> transitions;
  for (const Transition& t : type.transitions) {
    const std::string name = transition_name(type, t);
    transitions.push_back(
        {time.when(t.when, name),
         static_cast<rt::Urgency>(t.urgency),
         time.resume(t.resume, name),
         {t.async.present, t.async.budget, t.async.overrun == Async::kNone ? rt::kNone : t.async.overrun}});
  }
  to.transitions = l.pools.list(transitions);
  std::vector<rt::TimeGuard> invariants;
  for (const Invariant& i : type.invariants) invariants.push_back(time.when(i.when, type.name + "_" + i.name));
  to.invariants = l.pools.list(invariants);
  to.initial = time.resume(type.initial_resume, type.name + "_initial");
  std::vector<rt::EventPort> events;
  for (std::uint32_t port = 0; port < type.ports.size(); ++port) {
    const Port& p = type.ports[port];
    if (!p.external) continue;
    std::uint32_t source = 0;
    while (source < l.event_classes.size() &&
           (l.event_classes[source].type.value != row || l.event_classes[source].port != port))
      ++source;
    events.push_back({port, static_cast<rt::EventPolicy>(p.policy), p.event_class.c_str(),
                      source == l.event_classes.size() ? rt::kNone : source});
  }
  BIP_ASSERT(to.transitions.size == type.transitions.size() && to.invariants.size == type.invariants.size(),
             "{} of {} transitions have times", to.transitions.size, type.transitions.size());
  to.events = l.pools.list(events);
  return l.pools.list(std::vector<rt::AtomTime>{to}).data;
}

}  // namespace bip::lower
