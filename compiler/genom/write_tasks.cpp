// Execution tasks: the scheduler, which gives each activity its turn in the order of activities, and the compound of
// Figure 7 around it.
//
// A cycle, place by place:
//   idle   -trigger->  perm   the timer says so. Left out where a cycle begins with its timer (begins_with_timer)
//   perm   -begin->    at_A   there is work, else -stop-> stpd. A permanent codel of GenoM 2 runs with `begin`; where
//                             its answer is heard by a step of its own, that is -permanentdone-> at_A
//   at_S   -step_S->   run_S  the codel of S, else -skip_S-> the next place
//   run_S  -ran_S->    ...    the next place; of the last activity it is over
//   over   -give->     idle
//
// With an executive or mailboxes a cycle takes no steps for activities that do not work (Plan::passes_over):
//   at_A   -next_S->   at_S   none before S works, S does
//   at_S   -pass_S->   idle   neither S nor any that follows works. To over where more may come (ends_by_passing)
//   perm   -permanentalone-> alone -passalone-> idle: the cycle of a permanent codel while no activity works
#include <fmt/format.h>

#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"
#include "compiler/genom/wires.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

void port(std::string& out, const std::string& name) { out += fmt::format("    export port Signal {}()\n", name); }

// Whose turn it can be: "permanent" (GenoM 3), then the activities.
std::vector<std::string> turns_of(const Plan& plan, std::size_t task) {
  BIP_ASSERT(task < plan.tasks.size(), "task {} of {}", task, plan.tasks.size());
  std::vector<std::string> turns;
  if (!plan.module->tasks[task].activity.states.empty()) turns.emplace_back("permanent");
  for (const std::size_t activity : plan.tasks[task].activities) turns.push_back(plan.activities[activity].component);
  return turns;
}

// Of the activity whose turn it is.
const ActivityPlan& activity_of(const Plan& plan, std::size_t task, std::size_t turn) {
  const bool has_permanent = !plan.module->tasks[task].activity.states.empty();
  BIP_ASSERT(turn < plan.tasks[task].activities.size() + (has_permanent ? 1 : 0), "turn {} of a task of {} activities",
             turn, plan.tasks[task].activities.size());
  if (has_permanent && turn == 0) return plan.tasks[task].permanent;
  return plan.services[plan.activities[plan.tasks[task].activities[turn - (has_permanent ? 1 : 0)]].service].activity;
}

// Codels of a task may go on for ever; then it never says that it has paused or ended.
bool has_ran(const Plan& plan, std::size_t task, const ActivityPlan& a) {
  return &a != &plan.tasks[task].permanent || a.pauses || a.ends;
}

std::string begin_port(const Task& t) { return t.permanent.name.is_set() ? "permanentexec" : "begin"; }

void scheduler_ports(std::string& out, const Plan& plan, std::size_t task, const std::vector<std::string>& turns) {
  const Task& t = plan.module->tasks[task];
  const std::size_t first_activity = t.activity.states.empty() ? 0 : 1;
  if (!plan.begins_with_timer(task) || plan.may_suspend(task)) port(out, "trigger");
  if (!t.has_permanent()) port(out, "stop");
  port(out, begin_port(t));
  if (t.permanent.name.is_set()) port(out, plan.tasks[task].permanent_to_begin ? "permanentfails" : "permanentdone");
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const ActivityPlan& a = activity_of(plan, task, i);
    if (a.steps()) port(out, "step_" + turns[i]);
    if (a.skips()) port(out, "skip_" + turns[i]);
    if (plan.passes_over(task) && i >= first_activity) {
      port(out, "pass_" + turns[i]);
      if (i > first_activity) port(out, "next_" + turns[i]);
    }
    if (plan.by_codel && a.steps()) port(out, "done_" + turns[i]);
    if (a.has_async) {
      port(out, "sent_" + turns[i]);
      port(out, "back_" + turns[i]);
    }
    if (has_ran(plan, task, a)) port(out, "ran_" + turns[i]);
    if (plan.module->generation == 3 && a.goes_on) port(out, "more_" + turns[i]);
  }
  if (plan.has_permanent_cycle(task)) {
    port(out, "permanentalone");
    port(out, "passalone");
  }
  if (plan.may_suspend(task)) port(out, "suspend");
  for (const Poster& p : plan.module->posters) {
    if (plan.module->generation != 2 || p.is_auto || p.task_index != task) continue;
    port(out, "update");
    break;
  }
  port(out, "give");
}

}  // namespace

void write_scheduler(std::string& out, const Plan& plan, std::size_t task) {
  const Task& t = plan.module->tasks[task];
  const std::vector<std::string> turns = turns_of(plan, task);
  const bool is_3 = plan.module->generation == 3;
  const bool has_update = [&] {
    for (const Poster& p : plan.module->posters) {
      if (!is_3 && !p.is_auto && p.task_index == task) return true;
    }
    return false;
  }();
  out += fmt::format(
      "\n  // The cycle of task {}: woken by its timer, then{} one codel of each activity, in the order of their "
      "slots{}.\n",
      t.name.text, t.permanent.name.is_set() ? " the permanent codel and" : "",
      is_3 ? ", in rounds until all pause" : "");
  out += fmt::format("  atom type {}()\n", plan.tasks[task].scheduler);
  if (is_3) out += "    data bool more = false\n";
  scheduler_ports(out, plan, task, turns);

  const bool begins_with_timer = plan.begins_with_timer(task);
  std::string places = begins_with_timer ? "idle" : t.has_permanent() ? "idle, perm" : "idle, perm, stpd";
  const bool runs_to_begin = plan.tasks[task].permanent_to_begin;
  const bool waits_for_permanent = t.permanent.name.is_set() && !runs_to_begin;
  if (waits_for_permanent) places += ", exec";
  if (plan.has_permanent_cycle(task)) places += ", alone";
  for (std::size_t i = 0; i < turns.size(); ++i) {
    places += ", at_" + turns[i];
    if (!plan.by_codel || activity_of(plan, task, i).steps()) places += ", run_" + turns[i];
    if (plan.by_codel) places += ", end_" + turns[i];
  }
  places += ", over";
  if (plan.may_suspend(task)) places += ", susp";
  out += fmt::format("\n    place {}\n\n    initial to idle\n\n", places);

  const std::size_t first_activity = t.activity.states.empty() ? 0 : 1;
  const std::string first = turns.empty() ? "over" : "at_" + turns[0];
  if (begins_with_timer) {
    if (!t.has_permanent()) out += "    on stop from idle to idle\n";
  } else {
    out += "    on trigger from idle to perm\n";
    if (!t.has_permanent()) out += "    on trigger from stpd to perm\n    on stop from perm to stpd\n";
  }
  out += fmt::format("    on {} from {} to {}\n", begin_port(t), begins_with_timer ? "idle" : "perm",
                     waits_for_permanent ? "exec" : first);
  if (plan.has_permanent_cycle(task))
    out += fmt::format("    on permanentalone from {} to alone\n    on passalone from alone to idle\n",
                       begins_with_timer ? "idle" : "perm");
  if (waits_for_permanent) out += fmt::format("    on permanentdone from exec to {}\n", first);
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const ActivityPlan& a = activity_of(plan, task, i);
    const std::string& turn = turns[i];
    const std::string next = i + 1 < turns.size() ? "at_" + turns[i + 1] : "over";
    const std::string last = (plan.by_codel ? "end_" : "run_") + turn;
    out += a.steps() ? fmt::format("\n    on step_{0} from at_{0} to run_{0}\n", turn) : "\n";
    if (a.skips()) out += fmt::format("    on skip_{0} from at_{0} to {1}\n", turn, next);
    if (plan.passes_over(task) && i >= first_activity) {
      const bool is_first = i == first_activity;
      out += fmt::format("    on pass_{0} from at_{0} to {1}\n", turn, plan.ends_by_passing(task) ? "idle" : "over");
      if (!is_first) out += fmt::format("    on next_{0} from at_{1} to at_{0}\n", turn, turns[first_activity]);
    }
    // A codel that runs beside the task: its turn is over at once, and its answer is heard at a later one.
    if (a.has_async)
      out += fmt::format("    on sent_{0} from at_{0} to {1}\n    on back_{0} from at_{0} to {2}\n", turn, next, last);
    if (plan.by_codel && a.steps()) out += fmt::format("    on done_{0} from run_{0} to end_{0}\n", turn);
    if (has_ran(plan, task, a)) out += fmt::format("    on ran_{} from {} to {}\n", turn, last, next);
    if (is_3 && a.goes_on) out += fmt::format("    on more_{} from {} to {} do {{ more = true; }}\n", turn, last, next);
    if (a.has_bad) out += fmt::format("    on suspend from {} to susp\n", last);
  }
  out += "\n";
  if (is_3) out += fmt::format("    internal from over to {} provided (more) do {{ more = false; }}\n", first);
  if (has_update) out += "    on update from over to over\n";
  out += fmt::format("    on give from over to idle{}\n", is_3 ? " provided (!more)" : "");
  if (plan.may_suspend(task)) {
    out += "\n    // Suspended for good: time goes on without it.\n";
    if (runs_to_begin) {
      out += fmt::format("    on permanentfails from {} to susp\n", first);
      if (plan.has_permanent_cycle(task)) out += "    on permanentfails from alone to susp\n";
    } else if (t.permanent.name.is_set() && t.permanent_fails) {
      out += "    on suspend from exec to susp\n";
    }
    out += "    on trigger from susp to susp\n";
  }
  out += "  end\n";
}

void write_task(std::string& out, const Plan& plan, std::size_t task, std::int64_t tick_us) {
  BIP_ASSERT(tick_us > 0 && task < plan.tasks.size(), "task {} with ticks of {} us", task, tick_us);
  const Task& t = plan.module->tasks[task];
  const TaskPlan& p = plan.tasks[task];
  const std::vector<std::string> turns = turns_of(plan, task);
  const auto ticks = [&](std::int64_t us) { return (us + tick_us / 2) / tick_us; };
  const bool is_periodic = t.period_us > 0;
  out += fmt::format(
      "\n  // Execution task {}{}.\n  compound type {}()\n", t.name.text,
      is_periodic ? fmt::format(", every {} ms", static_cast<double>(t.period_us) / 1000.0) : ", when it is woken",
      p.type);
  out += fmt::format("    component {} scheduler()\n", p.scheduler);
  out += fmt::format("    @SuppressWarning(unboundcomponentport)\n    component TaskController controller({}, {})\n",
                     p.activities.size(), t.has_permanent() ? "true" : "false");
  if (is_periodic) {
    const bool may_lapse = plan.begins_with_timer(task) && !t.has_permanent();
    if (p.is_watched && !may_lapse) out += "    @SuppressWarning(unboundcomponentport)\n";
    out += fmt::format("    component {}{} timer({}, {})\n", plan.has_task_threads ? "Patient" : "",
                       p.is_watched ? "WatchedTimer" : "Timer", std::max<std::int64_t>(1, ticks(t.period_us)),
                       ticks(t.delay_us));
  } else {
    out += "    component WakeUp timer()\n";
  }
  const bool runs_to_begin = plan.tasks[task].permanent_to_begin;
  if (t.permanent.name.is_set())
    out += fmt::format("    @SuppressWarning(unboundcomponentport)\n    component {} permanent()\n",
                       p.permanent_type.empty() ? "Permanent" : p.permanent_type);
  if (!t.activity.states.empty()) out += fmt::format("    component {} permanent()\n", p.permanent.type);
  if (p.permanent.has_work()) out += fmt::format("    component {} work()\n", p.work_type);

  // Only a suspended task takes a trigger that begins no cycle.
  const bool begins_with_timer = plan.begins_with_timer(task);
  if (!begins_with_timer || plan.may_suspend(task))
    write_wire(out, {.name = "wake_up", .ports = {"scheduler.trigger", "timer.trigger"}});
  if (!t.has_permanent()) {
    std::vector<std::string> stop{"scheduler.stop", "controller.stop"};
    if (begins_with_timer) stop.emplace_back(p.is_watched ? "timer.lapse" : "timer.trigger");
    else if (p.is_watched) stop.emplace_back("timer.over");
    write_wire(out, {.name = "stop", .ports = stop});
  }
  const bool has_permanent_cycle = plan.has_permanent_cycle(task);
  std::vector<std::string> begin{"scheduler." + begin_port(t),
                                 has_permanent_cycle ? "controller.active" : "controller.work"};
  if (begins_with_timer) begin.emplace_back("timer.trigger");
  if (t.permanent.name.is_set()) begin.emplace_back("permanent.exec");
  const bool calls = plan.calls && t.permanent.name.is_set();
  write_wire(out, {.name = "begin",
                   .ports = begin,
                   .action = calls && p.permanent_type.empty()
                                 ? fmt::format("permanent.exec.answer <- {}({})", codel_function(t.permanent.name.text),
                                               plan.owner_of_task(task))
                                 : "",
                   .exported = true});
  if (has_permanent_cycle) {
    begin[0] = "scheduler.permanentalone";
    begin[1] = "controller.quiet";
    write_wire(out, {.name = "alone", .ports = begin, .exported = true});
    if (p.is_watched)
      write_wire(out, {.name = "passed_alone", .ports = {"scheduler.passalone", "timer.over"}, .exported = true});
  }
  if (runs_to_begin) {
    write_wire(out,
               {.name = "permanent_fails", .ports = {"scheduler.permanentfails", "permanent.fail"}, .exported = true});
  } else if (t.permanent.name.is_set()) {
    write_wire(out, {.name = "permanent_done",
                     .ports = {"scheduler.permanentdone", "permanent.done"},
                     .guard = calls ? "permanent.done.answer == 0" : "",
                     .exported = plan.by_codel});
  }
  if (t.permanent.name.is_set() && t.permanent_fails && !runs_to_begin) {
    write_wire(out, {.name = "permanent_fails",
                     .ports = {"scheduler.suspend", "permanent.fail"},
                     .guard = calls ? "permanent.fail.answer != 0" : "",
                     .exported = true});
  }

  if (p.is_watched) write_wire(out, {.name = "over", .ports = {"scheduler.give", "timer.over"}, .exported = true});
  const std::size_t first_activity = t.activity.states.empty() ? 0 : 1;
  for (std::size_t i = first_activity; p.is_watched && plan.ends_by_passing(task) && i < turns.size(); ++i)
    write_wire(out,
               {.name = "passed_" + turns[i], .ports = {"scheduler.pass_" + turns[i], "timer.over"}, .exported = true});

  out += "\n";
  write_export(out, is_periodic ? "timer.tick" : "timer.wake", is_periodic ? "tick" : "wake");
  write_export(out, "begin.out", "begin");
  if (runs_to_begin) write_export(out, "permanent.ok", "permanent_ok");
  if (has_permanent_cycle) {
    write_export(out, "alone.out", "permanent_alone");
    write_export(out, p.is_watched ? "passed_alone.out" : "scheduler.passalone", "pass_alone");
  }
  if (!is_periodic && plan.is_on_demand()) write_export(out, "controller.work", "work");
  if (t.permanent.name.is_set() && plan.by_codel) write_export(out, "permanent_done.out", "permanent_done");
  if (t.permanent.name.is_set() && t.permanent_fails) write_export(out, "permanent_fails.out", "permanent_fails");
  if (!p.activities.empty()) {
    write_export(out, "controller.add", "add");
    write_export(out, "controller.remove", "remove");
  }
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const ActivityPlan& a = activity_of(plan, task, i);
    const std::string& turn = turns[i];
    if (a.steps()) write_export(out, "scheduler.step_" + turn, "step_" + turn);
    if (a.skips()) write_export(out, "scheduler.skip_" + turn, "skip_" + turn);
    if (plan.passes_over(task) && i >= first_activity) {
      const bool ends = p.is_watched && plan.ends_by_passing(task);
      write_export(out, ends ? "passed_" + turn + ".out" : "scheduler.pass_" + turn, "pass_" + turn);
      if (i > first_activity) write_export(out, "scheduler.next_" + turn, "next_" + turn);
    }
    if (a.has_async) {
      write_export(out, "scheduler.sent_" + turn, "sent_" + turn);
      write_export(out, "scheduler.back_" + turn, "back_" + turn);
    }
    if (plan.by_codel && a.steps()) write_export(out, "scheduler.done_" + turn, "done_" + turn);
    if (has_ran(plan, task, a)) write_export(out, "scheduler.ran_" + turn, "ran_" + turn);
    if (plan.module->generation == 3 && a.goes_on) write_export(out, "scheduler.more_" + turn, "more_" + turn);
  }
  if (!t.activity.states.empty()) {
    const ActivityPlan& a = p.permanent;
    for (std::size_t i = 0; i < t.activity.states.size(); ++i) {
      if (!a.used[i] || a.async[i] || (a.has_turns && a.threaded[i])) continue;
      const std::string& place = a.places[i];
      write_export(out, "permanent.run_" + place, "permanent_run_" + place);
      if (plan.by_codel) write_export(out, "permanent.done_" + place, "permanent_done_" + place);
    }
    write_turns(out, a, "permanent", "permanent_");
    if (plan.module->is_killed) write_export(out, "permanent.abt", "permanent_abt");
    if (a.has_async) write_task_work(out, plan, task);
    if (a.goes_on) write_export(out, "permanent." + a.went_on(), "permanent_went_on");
    if (a.pauses) write_export(out, "permanent." + a.paused(), "permanent_paused");
    if (a.pauses) write_export(out, "permanent.resume", "permanent_resume");
    if (a.ends) write_export(out, "permanent.ok", "permanent_ok");
    if (a.rests) write_export(out, "permanent.rest", "permanent_rest");
    if (a.has_bad) write_export(out, "permanent.bad", "permanent_bad");
  }
  bool any_bad = false;
  for (std::size_t i = 0; i < turns.size(); ++i) any_bad = any_bad || activity_of(plan, task, i).has_bad;
  if (any_bad) write_export(out, "scheduler.suspend", "suspend");
  for (const Poster& poster : plan.module->posters) {
    if (plan.module->generation != 2 || poster.is_auto || poster.task_index != task) continue;
    write_export(out, "scheduler.update", "update");
    break;
  }
  write_export(out, p.is_watched ? "over.out" : "scheduler.give", "give");
  if (p.is_watched) write_export(out, "timer.read", "missed");
  out += "  end\n";
}

void write_service(std::string& out, const Plan& plan, std::size_t service, std::int64_t tick_us) {
  BIP_ASSERT(service < plan.services.size() && plan.module->services[service].kind == ServiceKind::Execution,
             "service {} of {} is no execution service", service, plan.services.size());
  const Service& s = plan.module->services[service];
  const ServicePlan& p = plan.services[service];
  const ActivityPlan& a = p.activity;
  const char* const owner = plan.calls ? "owner" : "";
  out += fmt::format("\n  // Execution service {}.\n  compound type {}({})\n", s.name.text, p.type,
                     plan.calls ? "int owner" : "");
  out += "    @SuppressWarning(unboundcomponentport)\n    component ServiceController controller()\n";
  out += fmt::format("    component {} activity({})\n", a.type, owner);
  if (a.has_work()) out += fmt::format("    component {} work({})\n", p.work_type, owner);
  if (a.has_async) out += "    component CodelWatch watch()\n";
  const std::string interrupted = plan.module->generation == 2 ? "ACTIVITY_INTERRUPTED" : "interrupted";
  write_wire(out, {.name = "start", .ports = {"controller.start", "activity.start"}, .exported = true});
  write_wire(out, {.name = "cancel",
                   .ports = {"controller.cancel"},
                   .exported = true,
                   .report_to = "controller.cancel",
                   .report = interrupted});
  write_wire(out, {.name = "abort",
                   .ports = {"controller.abt", "activity.abt"},
                   .exported = true,
                   .report_to = "controller.abt",
                   .report = interrupted});
  if (p.is_stopped) {
    // Told to stop, once.
    write_wire(out, {.name = "drop",
                     .ports = {"controller.cancel"},
                     .exported = true,
                     .report_to = "controller.cancel",
                     .report = interrupted});
    write_wire(out, {.name = "halt",
                     .ports = {"controller.halt", "activity.abt"},
                     .exported = true,
                     .report_to = "controller.halt",
                     .report = interrupted});
  }
  if (a.ends) write_wire(out, {.name = "fin", .ports = {"controller.fin", "activity.ok"}, .exported = true});
  if (a.ends_not_ok) {
    write_wire(out, {.name = "nofin",
                     .ports = {"controller.nofin", "activity." + a.not_ok()},
                     .action = fmt::format("controller.nofin.rep <- activity.{}.rep", a.not_ok()),
                     .exported = true});
  }
  if (a.ends_stopped)
    write_wire(out, {.name = "intr", .ports = {"controller.intr", "activity.intr"}, .exported = true});
  if (a.has_zombie) {
    write_wire(out, {.name = "fail", .ports = {"controller.fail", "activity.zombie"}, .exported = true});
    write_wire(out, {.name = "bury", .ports = {"controller.bury", "activity.bury"}, .exported = true});
  }
  if (a.has_async) write_work_wires(out, plan, service, tick_us);
  if (plan.executive == Executive::Cpp) {
    out += fmt::format(
        "\n    connector replied(controller.reply)\n      export port Signal out\n      define [controller.reply]\n"
        "      on controller.reply down {{ executive_reply(\"{}\", \"{}\", controller.reply.rep); }}\n",
        plan.module->name.text, s.name.text);
  }
  out += "\n";
  if (s.validate.name.is_set()) {
    for (const char* name : {"ctrl", "valid"}) write_export(out, std::string("controller.") + name, name);
    if (s.validate_fails) write_export(out, "controller.invalid", "invalid");
  } else {
    write_export(out, "controller.admit", "admit");
  }
  for (const char* name : {"trig", "rej", "idle", "free", "busy", "stat"})
    write_export(out, std::string("controller.") + name, name);
  if (plan.is_on_demand()) {
    for (const char* name : {"due", "working", "dormant"}) write_export(out, std::string("controller.") + name, name);
  }
  write_export(out, plan.executive == Executive::Cpp ? "replied.out" : "controller.reply", "reply");
  write_export(out, "start.out", "start");
  write_export(out, "cancel.out, abort.out", "abt");
  if (p.is_stopped) write_export(out, "drop.out, halt.out", "halt");
  if (a.ends) write_export(out, "fin.out", "fin");
  if (a.ends_not_ok) write_export(out, "nofin.out", "nofin");
  if (a.ends_stopped) write_export(out, "intr.out", "intr");
  if (a.has_zombie) {
    write_export(out, "fail.out", "fail");
    write_export(out, "bury.out", "bury");
  }
  for (std::size_t i = 0; i < s.activity.states.size(); ++i) {
    if (!a.used[i]) continue;
    const std::string& place = a.places[i];
    if (a.async[i] || (a.has_turns && a.threaded[i])) continue;
    write_export(out, "activity.run_" + place, "run_" + place);
    if (plan.by_codel) write_export(out, "activity.done_" + place, "done_" + place);
  }
  write_turns(out, a, "activity", "");
  if (a.has_async) write_work_exports(out, p);
  if (a.has_timed()) write_export(out, "activity.late", "late");
  if (a.goes_on) write_export(out, "activity." + a.went_on(), "went_on");
  if (a.pauses) write_export(out, "activity." + a.paused(), "paused");
  if (plan.module->generation == 3) write_export(out, "activity.resume", "resume");
  if (a.has_bad) write_export(out, "activity.bad", "bad");
  write_export(out, "activity.rest", "rest");
  out += "  end\n";
}

}  // namespace bip::genom
