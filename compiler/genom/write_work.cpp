// Codels that run beside their task (`async`), or in a thread while it waits (--task-threads): the atom that runs them,
// and how it is bound inside the service's compound.
//
//   HERE -begin_STATE-> AWAY   (AWAY_STATE if it holds locks, which are given back when it returns) its turn came, and
//                              the task goes on. Execution flavour: the call is an action with `@async`, so that the
//                              atom is at work, and offers nothing, until the C++ function has returned
//   AWAY -returned-> BACK      it has returned; in verification whenever it likes
//   HERE -begin_STATE-> BACK   the task waits for it (--task-threads): while the function runs the atom is at work
//   BACK -take-> HERE          its answer is heard at the next turn, or thrown away if it came too late
//
// A CodelWatch (stdlib/genom/codels.bip) counts its budget down. Cost: two atoms a service that has such codels.
#include <fmt/format.h>

#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"
#include "compiler/genom/wires.hpp"
#include "runtime/include/bip/assert.hpp"

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
  BIP_ASSERT(us >= 0 && tick_us > 0, "a budget of {} us in ticks of {} us", us, tick_us);
  return us == 0 ? -1 : (us + tick_us - 1) / tick_us + 1;
}

// Has it a codel that holds no lock while it is away?
bool returns_plainly(const ActivityPlan& a) {
  BIP_ASSERT(a.async.size() == a.places.size() && a.holds.size() == a.places.size(), "{} places, {} may be async",
             a.places.size(), a.async.size());
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (a.async[i] && !a.holds[i]) return true;
  }
  return false;
}

// What was handed over, and its answer.
void write_back(std::string& out, const Plan& plan, const std::string& back, const std::string& work,
                const std::string& place) {
  write_wire(
      out,
      {.name = "back_" + place,
       .ports = {back, work + ".take"},
       .action = plan.calls ? fmt::format("{0}.next <- {1}.take.next; {0}.report <- {1}.take.report", back, work) : "",
       .exported = true});
}

}  // namespace

void write_work(std::string& out, const Plan& plan, const Activity& activity, const ActivityPlan& a,
                const std::string& type, const std::string& says, std::optional<std::size_t> owner) {
  out += fmt::format("\n  // Codels of {} that run beside {} task.\n  atom type {}({})\n", says,
                     owner ? "the" : "their", type, plan.calls && !owner ? "int owner" : "");
  if (plan.calls) out += "    data int next = 0, report = 0\n";
  if (a.has_turns && a.has_timed()) out += "    data bool late = false\n";
  std::string places = "HERE";
  if (returns_plainly(a)) places += ", AWAY";
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (a.async[i] || (a.has_turns && a.threaded[i]))
      out += fmt::format("    export port Signal begin_{}()\n", a.places[i]);
    if (a.holds[i]) places += ", AWAY_" + a.places[i];
  }
  if (returns_plainly(a)) out += "    export port Signal returned()\n";
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (a.holds[i]) out += fmt::format("    export port Signal returned_{}()\n", a.places[i]);
  }
  out += fmt::format("    export port {}\n\n    place {}, BACK\n\n    initial to HERE\n\n",
                     !plan.calls                                 ? "Signal take()"
                     : outcome_type(a) == std::string("Outcome") ? "Outcome take(next, report)"
                                                                 : "TimedOutcome take(next, report, late)",
                     places);
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (!a.async[i]) continue;
    const Codel& codel = activity.states[i].codel;
    if (plan.calls)
      out += codel.budget_us == 0 ? std::string("    @async\n")
                                  : fmt::format("    @async(budget=\"{}\")\n", budget_text(codel.budget_us));
    out +=
        fmt::format("    on begin_{0} from HERE to AWAY{1}{2}\n", a.places[i], a.holds[i] ? "_" + a.places[i] : "",
                    plan.calls ? fmt::format(" do {{ report = 0; next = {}({}, report); }}",
                                             codel_function(codel.name.text), owner ? std::to_string(*owner) : "owner")
                               : "");
  }
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (!a.has_turns || !a.threaded[i]) continue;
    out += fmt::format("    @async\n    on begin_{} from HERE to BACK do {{ report = 0; next = {}({}, report);{} }}\n",
                       a.places[i], codel_function(activity.states[i].codel.name.text),
                       owner ? std::to_string(*owner) : "owner", a.has_timed() ? " late = codel_was_late() != 0;" : "");
  }
  if (returns_plainly(a)) out += "    on returned from AWAY to BACK\n";
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (a.holds[i]) out += fmt::format("    on returned_{0} from AWAY_{0} to BACK\n", a.places[i]);
  }
  out += "    on take from BACK to HERE\n  end\n";
}

void write_turns(std::string& out, const ActivityPlan& a, const std::string& component, const std::string& exported) {
  for (std::size_t i = 0; a.has_turns && i < a.places.size(); ++i) {
    if (!a.threaded[i]) continue;
    const std::string& place = a.places[i];
    const std::string done = fmt::format("{}.done_{}", component, place);
    write_wire(out, {.name = "send_" + place,
                     .ports = {fmt::format("{}.run_{}", component, place), "work.begin_" + place},
                     .exported = true});
    write_wire(out, {.name = "done_" + place,
                     .ports = {done, "work.take"},
                     .action = fmt::format("{0}.next <- work.take.next; {0}.report <- work.take.report{1}", done,
                                           a.has_timed() ? fmt::format("; {}.late <- work.take.late", done) : ""),
                     .exported = true});
    write_export(out, fmt::format("send_{}.out", place), fmt::format("{}run_{}", exported, place));
    write_export(out, fmt::format("done_{}.out", place), fmt::format("{}done_{}", exported, place));
  }
}

void write_permanent(std::string& out, const Plan& plan, std::size_t task) {
  BIP_ASSERT(task < plan.tasks.size() && !plan.tasks[task].permanent_type.empty(),
             "task {} calls its permanent codel itself", task);
  const TaskPlan& p = plan.tasks[task];
  const std::string& name = plan.module->tasks[task].name.text;
  const std::string call = fmt::format("answer = {}({});", codel_function(plan.module->tasks[task].permanent.name.text),
                                       plan.owner_of_task(task));
  out += fmt::format(
      "\n  // The permanent codel of task {}, {}.\n  atom type {}()\n    data int answer = 0\n"
      "    export port Answer exec(answer)\n",
      name, p.permanent_to_begin ? "which its cycles begin with" : "in a thread", p.permanent_type);
  if (p.permanent_to_begin) {
    out += fmt::format(
        "    export port Signal ok()\n    export port Signal fail()\n\n"
        "    place sleep\n\n    initial to sleep\n\n"
        "    on exec from sleep to sleep do {{ {} }}\n"
        "    on ok from sleep to sleep provided (answer == 0)\n"
        "    on fail from sleep to sleep provided (answer != 0)\n  end\n",
        call);
    return;
  }
  out += fmt::format(
      "    export port Answer done(answer)\n    export port Answer fail(answer)\n\n"
      "    place sleep, runs\n\n    initial to sleep\n\n    @async\n"
      "    on exec from sleep to runs do {{ {} }}\n"
      "    on done from runs to sleep\n    on fail from runs to sleep\n  end\n",
      call);
}

void write_work_wires(std::string& out, const Plan& plan, std::size_t service, std::int64_t tick_us) {
  BIP_ASSERT(service < plan.services.size() && plan.services[service].activity.has_async,
             "service {} of {} has no codels beside its task", service, plan.services.size());
  const Service& s = plan.module->services[service];
  const ActivityPlan& a = plan.services[service].activity;
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (!a.async[i]) continue;
    const std::string& place = a.places[i];
    write_wire(out, {.name = "send_" + place,
                     .ports = {"activity.run_" + place, "work.begin_" + place, "watch.start"},
                     .action = fmt::format("watch.start.left <- {}",
                                           budget_ticks(s.activity.states[i].codel.budget_us, tick_us)),
                     .exported = true});
    write_back(out, plan, "activity.back_" + place, "work", place);
    if (a.holds[i])
      write_wire(
          out, {.name = "returned_" + place, .ports = {"work.returned_" + place, "watch.returned"}, .exported = true});
  }
  write_wire(out, {.name = "wait", .ports = {"activity.wait", "watch.away"}, .exported = true});
  if (returns_plainly(a))
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
    if (p.activity.holds[i]) write_export(out, "returned_" + place + ".out", "returned_" + place);
  }
  if (returns_plainly(p.activity)) write_export(out, "returned.out", "returned");
  for (const char* name : {"wait", "lost", "found"}) write_export(out, std::string(name) + ".out", name);
  write_export(out, "watch.tick", "watch_tick");
}

// The codels of a task itself have no budget: a codel that exceeds its budget ends an activity, and a task is none.
void write_task_work(std::string& out, const Plan& plan, std::size_t task) {
  const ActivityPlan& a = plan.tasks[task].permanent;
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (!a.async[i]) continue;
    const std::string& place = a.places[i];
    write_wire(out,
               {.name = "send_" + place, .ports = {"permanent.run_" + place, "work.begin_" + place}, .exported = true});
    write_back(out, plan, "permanent.back_" + place, "work", place);
    write_export(out, "send_" + place + ".out", "permanent_run_" + place);
    write_export(out, "back_" + place + ".out", "permanent_back_" + place);
    if (a.holds[i]) write_export(out, "work.returned_" + place, "permanent_returned_" + place);
  }
  if (returns_plainly(a)) write_export(out, "work.returned", "permanent_returned");
  write_export(out, "permanent.wait", "permanent_wait");
}

}  // namespace bip::genom
