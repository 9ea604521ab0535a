// Codels that run beside their task (`async`): the atom that runs them, and how it is bound inside the service's
// compound.
//
//   HERE -begin_STATE-> AWAY   its turn came; the task goes on. Execution flavour: the call is an action with `@async`,
//   so that the atom
//                              is at work, and offers nothing, until the C++ function has returned
//   AWAY -returned-> BACK      it has returned; in verification whenever it likes
//   BACK -take-> HERE          its answer is heard at the next turn, or thrown away if it came too late
//
// A CodelWatch (stdlib/genom/codels.bip) counts its budget down. Cost: two atoms a service that has such codels.
#include <fmt/format.h>

#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"
#include "compiler/genom/wires.hpp"

namespace bip::genom {
namespace {

// As `@async` has it.
std::string budget_text(std::int64_t us) {
  if (us % 1'000'000 == 0) return fmt::format("{}s", us / 1'000'000);
  if (us % 1000 == 0) return fmt::format("{}ms", us / 1000);
  return fmt::format("{}us", us);
}

// A tick more than it takes, for its turn falls between two.
std::int64_t budget_ticks(std::int64_t us, std::int64_t tick_us) {
  return us == 0 ? -1 : (us + tick_us - 1) / tick_us + 1;
}

}  // namespace

void write_work(std::string& out, const Plan& plan, std::size_t service) {
  const Service& s = plan.module->services[service];
  const ActivityPlan& a = plan.services[service].activity;
  out += fmt::format("\n  // Codels of {} that run beside their task.\n  atom type {}()\n", s.name.text,
                     plan.services[service].work_type);
  if (plan.calls) out += "    data int next = 0, report = 0\n";
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (a.async[i]) out += fmt::format("    export port Signal begin_{}()\n", a.places[i]);
  }
  out += fmt::format(
      "    export port Signal returned()\n    export port {}\n\n    place HERE, AWAY, BACK\n\n    initial to HERE\n\n",
      plan.calls ? "Outcome take(next, report)" : "Signal take()");
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (!a.async[i]) continue;
    const Codel& codel = s.activity.states[i].codel;
    if (plan.calls)
      out += codel.budget_us == 0 ? std::string("    @async\n")
                                  : fmt::format("    @async(budget=\"{}\")\n", budget_text(codel.budget_us));
    out += fmt::format(
        "    on begin_{} from HERE to AWAY{}\n", a.places[i],
        plan.calls ? fmt::format(" do {{ report = 0; next = {}(report); }}", bip_name(codel.name.text)) : "");
  }
  out += "    on returned from AWAY to BACK\n    on take from BACK to HERE\n  end\n";
}

void write_work_wires(std::string& out, const Plan& plan, std::size_t service, std::int64_t tick_us) {
  const Service& s = plan.module->services[service];
  const ActivityPlan& a = plan.services[service].activity;
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (!a.async[i]) continue;
    const std::string& place = a.places[i];
    const std::string back = "activity.back_" + place;
    write_wire(out, {.name = "send_" + place,
                     .ports = {"activity.run_" + place, "work.begin_" + place, "watch.start"},
                     .action = fmt::format("watch.start.left <- {}",
                                           budget_ticks(s.activity.states[i].codel.budget_us, tick_us)),
                     .exported = true});
    write_wire(
        out,
        {.name = "back_" + place,
         .ports = {back, "work.take"},
         .action = plan.calls ? fmt::format("{0}.next <- work.take.next; {0}.report <- work.take.report", back) : "",
         .exported = true});
  }
  write_wire(out, {.name = "wait", .ports = {"activity.wait", "watch.away"}, .exported = true});
  write_wire(out, {.name = "returned", .ports = {"work.returned", "watch.returned"}, .exported = true});
  write_wire(out, {.name = "lost", .ports = {"controller.fail", "activity.lost", "watch.over"}, .exported = true});
  write_wire(out, {.name = "found", .ports = {"controller.bury", "activity.found", "work.take"}, .exported = true});
}

void write_work_exports(std::string& out, const ServicePlan& p) {
  for (std::size_t i = 0; i < p.activity.places.size(); ++i) {
    if (!p.activity.async[i]) continue;
    const std::string& place = p.activity.places[i];
    write_export(out, "send_" + place + ".out", "run_" + place);
    write_export(out, "back_" + place + ".out", "back_" + place);
  }
  for (const char* name : {"wait", "returned", "lost", "found"}) write_export(out, std::string(name) + ".out", name);
  write_export(out, "watch.tick", "watch_tick");
}

}  // namespace bip::genom
