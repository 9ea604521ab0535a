// The second half of a module's compound: its tasks, time, and its exported ports.
#include <fmt/format.h>

#include <algorithm>

#include "compiler/genom/module_writer.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {

void ModuleWriter::aborts() {
  out_ += "\n    // Request Abort.\n";
  // A client names the activity; without a name it is any.
  const bool is_served = plan_.executive == Executive::Served;
  for (std::size_t k = 0; k < plan_.activities.size(); ++k) {
    if (plan_.service_of(k).kind != ServiceKind::Execution) continue;
    const std::string& name = plan_.activities[k].component;
    const std::string guard =
        is_served ? fmt::format("{0}.activity == \"{1}\" || {0}.activity == \"\"", control("abort"), name) : "";
    wire({.name = "abort_" + name, .ports = {control("abort"), of_activity(k, "abt")}, .guard = guard});
    aborts_.push_back("abort_" + name);
    if (!plan_.services[plan_.activities[k].service].activity.has_zombie) continue;
    std::vector<std::string> bury{control("abort"), of_activity(k, "bury")};
    if (plan_.has_checks()) bury.push_back(plan_.ids + ".remove_zombie");
    wire({.name = "bury_" + name, .ports = bury, .guard = guard});
    aborts_.push_back("bury_" + name);
  }
  wire({.name = "unknown_activity", .ports = {control("unknown")}});
}

// An activity begins when nothing that it interrupts runs any more.
void ModuleWriter::launches() {
  out_ += "\n    // Start what is ready.\n";
  for (std::size_t k = 0; k < plan_.activities.size(); ++k) {
    const Service& s = plan_.service_of(k);
    if (s.kind != ServiceKind::Execution) continue;
    std::vector<std::string> ports{control("launch"), of_activity(k, "start"), of_task(s.task_index, "add")};
    for (const std::size_t other : s.interrupted) {
      for (const std::size_t activity : plan_.services[other].activities) {
        if (activity != k && !plan_.waits_in_box()) ports.push_back(of_activity(activity, "idle"));
      }
    }
    wire({.name = "launch_" + plan_.activities[k].component, .ports = ports, .exported = plan_.is_launched_by_rules});
  }
  if (std::any_of(module_.services.begin(), module_.services.end(), [&](const Service& s) { return waits(s); })) {
    wire({.name = "retake", .ports = {control("retake"), plan_.lock + ".take"}});
  }
}

void ModuleWriter::task(std::size_t i) {
  const Task& t = module_.tasks[i];
  const TaskPlan& p = plan_.tasks[i];
  out_ += fmt::format("\n    // Task {}.\n", t.name.text);
  std::vector<std::string> begin{of_task(i, "begin")};
  add_module_lock(begin, "take");
  if (t.permanent.name.is_set()) add_locks(begin, {&t.permanent}, 1 + i, "take");
  const std::size_t needed = begin.size();
  if (p.permanent.pauses) begin.push_back(of_task(i, "permanent_resume"));
  for (const std::size_t activity : p.activities) {
    if (is_3_) begin.push_back(of_activity(activity, "resume"));
  }
  const bool exported = t.has_permanent() || !t.reads.empty();
  wire({.name = "begin_" + p.component,
        .ports = begin,
        .triggers = begin.size() > needed ? needed : 0,
        .exported = exported});
  if (plan_.has_permanent_cycle(i)) {
    std::vector<std::string> alone{of_task(i, "permanent_alone")};
    add_module_lock(alone, "take");
    wire({.name = "permanent_" + p.component, .ports = alone, .exported = true});
    std::vector<std::string> pass = gives(i, "pass_alone");
    add_permanent(pass, i);
    wire({.name = "give_permanent_" + p.component, .ports = pass});
  }
  if (t.permanent.name.is_set()) permanent(i);
  if (!t.activity.states.empty()) turns_of_permanent(i);
  for (const std::size_t activity : p.activities) {
    turns(i, activity);
    ends(i, activity);
  }
  if (plan_.passes_over(i)) pass_over(i);
  for (std::size_t k = 0; k < module_.posters.size(); ++k) {
    const Poster& poster = module_.posters[k];
    if (is_3_ || poster.task_index != i || poster.is_auto) continue;
    std::vector<std::string> update{of_task(i, "update"), plan_.posters[k] + ".write"};
    if (p.activities.empty()) add_permanent(update, i);
    wire({.name = "update_" + plan_.posters[k], .ports = update});
  }
  std::vector<std::string> give = gives(i, "give");
  if (p.activities.empty()) add_permanent(give, i);
  wire({.name = "give_" + p.component, .ports = give});
}

// The end of a cycle: the lock goes back, and the automatic posters are written.
std::vector<std::string> ModuleWriter::gives(std::size_t i, const std::string& port) const {
  std::vector<std::string> give{of_task(i, port)};
  add_module_lock(give, "give");
  for (std::size_t k = 0; k < module_.posters.size(); ++k) {
    if (!is_3_ && module_.posters[k].task_index == i && module_.posters[k].is_auto)
      give.push_back(plan_.posters[k] + ".write");
  }
  return give;
}

// Activities that do not work have no turns of their own. Before the first turn exactly one of the connectors `pass` of
// the first activity, `next` of the first one that works, and those of the first one's own turn can happen; after it,
// `pass` goes first.
void ModuleWriter::pass_over(std::size_t i) {
  const TaskPlan& p = plan_.tasks[i];
  BIP_ASSERT(!p.activities.empty(), "task `{}` passes over no activities", p.component);
  for (std::size_t k = 0; k < p.activities.size(); ++k) {
    const std::string& name = plan_.activities[p.activities[k]].component;
    std::vector<std::string> pass =
        plan_.ends_by_passing(i) ? gives(i, "pass_" + name) : std::vector{of_task(i, "pass_" + name)};
    for (std::size_t other = k; other < p.activities.size(); ++other)
      pass.push_back(of_activity(p.activities[other], "dormant"));
    if (k == 0) add_permanent(pass, i);
    const std::string wanted = "pass_" + (k == 0 ? p.component : name);
    wire({.name = wanted, .ports = pass});
    if (k == 0) continue;
    if (k + 1 < p.activities.size()) refusals_.emplace_back("skip_" + name, wanted);
    std::vector<std::string> next{of_task(i, "next_" + name)};
    for (std::size_t other = 0; other < k; ++other) next.push_back(of_activity(p.activities[other], "dormant"));
    next.push_back(of_activity(p.activities[k], "working"));
    add_permanent(next, i);
    wire({.name = "next_" + name, .ports = next});
  }
}

// GenoM 2: one codel a cycle; only where locks go by codel is there something to give back.
void ModuleWriter::permanent(std::size_t i) {
  const Codel& codel = module_.tasks[i].permanent;
  if (plan_.by_codel) {
    std::vector<std::string> done{of_task(i, "permanent_done")};
    add_locks(done, {&codel}, 1 + i, "give");
    wire({.name = "permanent_done_" + plan_.tasks[i].component, .ports = done});
  }
  if (!module_.tasks[i].permanent_fails) return;
  std::vector<std::string> fails{of_task(i, "permanent_fails"), plan_.ids + ".suspend"};
  add_module_lock(fails, "give");
  add_locks(fails, {&codel}, 1 + i, "give");
  wire({.name = "permanent_fails_" + plan_.tasks[i].component, .ports = fails});
}

void ModuleWriter::turns_of_permanent(std::size_t i) {
  const Activity& activity = module_.tasks[i].activity;
  const ActivityPlan& a = plan_.tasks[i].permanent;
  for (std::size_t s = 0; s < activity.states.size(); ++s) {
    if (!a.used[s]) continue;
    const State& state = activity.states[s];
    if (a.async[s]) {
      std::vector<std::string> sent{of_task(i, "sent_permanent"), of_task(i, "permanent_run_" + a.places[s])};
      add_locks(sent, {&state.codel}, plan_.thread_beside_task(i), "take");
      wire({.name = codel_label(state), .ports = sent});
      std::vector<std::string> back{of_task(i, "back_permanent"), of_task(i, "permanent_back_" + a.places[s])};
      add_ports(back, state.codel);
      wire({.name = "back_" + codel_label(state), .ports = back});
      continue;
    }
    std::vector<std::string> run{of_task(i, "step_permanent"), of_task(i, "permanent_run_" + a.places[s])};
    add_locks(run, {&state.codel}, 1 + i, "take");
    add_ports(run, state.codel);
    wire({.name = codel_label(state), .ports = run});
    if (!plan_.by_codel) continue;
    std::vector<std::string> done{of_task(i, "done_permanent"), of_task(i, "permanent_done_" + a.places[s])};
    add_locks(done, {&state.codel}, 1 + i, "give");
    wire({.name = "done_" + codel_label(state), .ports = done});
  }
  const std::string& name = plan_.tasks[i].component;
  if (a.rests)
    wire({.name = "skip_permanent_" + name, .ports = {of_task(i, "skip_permanent"), of_task(i, "permanent_rest")}});
  if (a.goes_on)
    wire({.name = "more_permanent_" + name, .ports = {of_task(i, "more_permanent"), of_task(i, "permanent_went_on")}});
  if (a.pauses)
    wire({.name = "paused_permanent_" + name, .ports = {of_task(i, "ran_permanent"), of_task(i, "permanent_paused")}});
  if (a.has_bad) {
    std::vector<std::string> bad{of_task(i, "suspend"), of_task(i, "permanent_bad")};
    add_module_lock(bad, "give");
    wire({.name = "bad_permanent_" + name, .ports = bad});
  }
  if (a.ends)
    wire({.name = "ended_permanent_" + name, .ports = {of_task(i, "ran_permanent"), of_task(i, "permanent_ok")}});
  if (!a.has_async) return;
  wire({.name = "wait_permanent_" + name, .ports = {of_task(i, "skip_permanent"), of_task(i, "permanent_wait")}});
  returns(activity, a, i, of_task(i, "permanent_returned"), "permanent_" + name, plan_.thread_beside_task(i));
}

void ModuleWriter::turns(std::size_t i, std::size_t instance) {
  const std::string& name = plan_.activities[instance].component;
  const Activity& activity = plan_.service_of(instance).activity;
  const bool is_first = plan_.tasks[i].activities.front() == instance;
  const ActivityPlan& a = plan_.services[plan_.activities[instance].service].activity;
  for (std::size_t s = 0; s < activity.states.size(); ++s) {
    if (!a.used[s]) continue;
    const State& state = activity.states[s];
    // The same codel may serve several states.
    const std::string label = fmt::format("{}_{}_{}", name, a.places[s], codel_label(state));
    if (a.async[s]) {
      std::vector<std::string> sent{of_task(i, "sent_" + name), of_activity(instance, "run_" + a.places[s])};
      add_locks(sent, {&state.codel}, plan_.thread_beside_activity(instance), "take");
      if (is_first) add_permanent(sent, i);
      wire({.name = label, .ports = sent});
      std::vector<std::string> back{of_task(i, "back_" + name), of_activity(instance, "back_" + a.places[s])};
      add_ports(back, state.codel);
      if (is_first) add_permanent(back, i);
      wire({.name = "back_" + label, .ports = back});
      continue;
    }
    std::vector<std::string> run{of_task(i, "step_" + name), of_activity(instance, "run_" + a.places[s])};
    add_locks(run, {&state.codel}, 1 + i, "take");
    add_ports(run, state.codel);
    if (is_first) add_permanent(run, i);
    wire({.name = label, .ports = run});
    if (!plan_.by_codel) continue;
    std::vector<std::string> done{of_task(i, "done_" + name), of_activity(instance, "done_" + a.places[s])};
    add_locks(done, {&state.codel}, 1 + i, "give");
    wire({.name = "done_" + label, .ports = done});
  }
  std::vector<std::string> skip{of_task(i, "skip_" + name), of_activity(instance, "rest")};
  // At the other ones a turn may have come that `pass` does not cover.
  if (plan_.passes_over(i) && (is_first || plan_.tasks[i].activities.back() == instance))
    skip.push_back(of_activity(instance, "working"));
  if (is_first) add_permanent(skip, i);
  wire({.name = "skip_" + name, .ports = skip});
  if (a.has_timed()) wire({.name = "late_" + name, .ports = {of_activity(instance, "late")}, .exported = true});
  if (a.has_async) beside(i, instance);
}

// A codel runs beside the task: it is waited for; it comes back, which wakes a task without a period; or it is given
// up, and comes back too late.
void ModuleWriter::beside(std::size_t i, std::size_t activity) {
  const std::string& name = plan_.activities[activity].component;
  std::vector<std::string> wait{of_task(i, "skip_" + name), of_activity(activity, "wait")};
  if (plan_.tasks[i].activities.front() == activity) add_permanent(wait, i);
  wire({.name = "wait_" + name, .ports = wait});
  std::vector<std::string> lost{of_activity(activity, "lost"), of_task(i, "remove")};
  std::vector<std::string> found{of_activity(activity, "found")};
  if (plan_.has_checks()) {
    lost.push_back(plan_.ids + ".add_zombie");
    found.push_back(plan_.ids + ".remove_zombie");
  }
  const ActivityPlan& a = plan_.services[plan_.activities[activity].service].activity;
  returns(plan_.service_of(activity).activity, a, i, of_activity(activity, "returned"), name,
          plan_.thread_beside_activity(activity));
  const ServicePlan& service = plan_.services[plan_.activities[activity].service];
  wire({.name = "lost_" + name, .ports = lost, .exported = service.fails_heard || service.losses_heard});
  wire({.name = "found_" + name, .ports = found});
}

// It has come back, at `port` or with locks to give back at `port`_STATE.
void ModuleWriter::returns(const Activity& activity, const ActivityPlan& a, std::size_t task, const std::string& port,
                           const std::string& name, std::size_t thread) {
  const auto returned = [&](const std::string& suffix, const Codel* held) {
    std::vector<std::string> ports{port + suffix};
    if (held != nullptr) add_locks(ports, {held}, thread, "give");
    if (module_.tasks[task].period_us == 0) ports.push_back(of_task(task, "wake"));
    wire({.name = "returned_" + name + suffix, .ports = ports});
  };
  bool is_plain = false;
  for (std::size_t s = 0; s < a.places.size(); ++s) {
    if (a.holds[s]) returned("_" + a.places[s], &activity.states[s].codel);
    is_plain = is_plain || (a.async[s] && !a.holds[s]);
  }
  if (is_plain) returned("", nullptr);
}

// GenoM 3: a codel writes the ports out that it names.
void ModuleWriter::add_ports(std::vector<std::string>& ports, const Codel& codel) const {
  for (const DataUse& use : codel.uses) {
    for (std::size_t k = 0; k < module_.posters.size(); ++k) {
      if (is_3_ && use.writes && use.data == "port_" + module_.posters[k].name.text)
        ports.push_back(plan_.posters[k] + ".write");
    }
  }
}

// What a codel's answer means: the next activity's turn, and perhaps the end of the activity.
void ModuleWriter::ends(std::size_t i, std::size_t activity) {
  const std::string& name = plan_.activities[activity].component;
  const Service& s = plan_.service_of(activity);
  const ServicePlan& p = plan_.services[plan_.activities[activity].service];
  const ActivityPlan& a = p.activity;
  const std::string ran = of_task(i, "ran_" + name);
  const std::string remove = of_task(i, "remove");
  if (a.goes_on)
    wire({.name = "went_on_" + name,
          .ports = {is_3_ ? of_task(i, "more_" + name) : ran, of_activity(activity, "went_on")}});
  if (a.pauses) wire({.name = "paused_" + name, .ports = {ran, of_activity(activity, "paused")}});
  if (a.ends) {
    std::vector<std::string> fin{ran, of_activity(activity, "fin"), remove};
    if (s.is_init) fin.push_back(plan_.ids + ".initialise");
    wire({.name = "fin_" + name, .ports = fin, .exported = p.is_heard});
  }
  if (a.ends_not_ok)
    wire({.name = "nofin_" + name, .ports = {ran, of_activity(activity, "nofin"), remove}, .exported = p.fails_heard});
  if (a.ends_stopped) wire({.name = "intr_" + name, .ports = {ran, of_activity(activity, "intr"), remove}});
  if (a.has_zombie) {
    std::vector<std::string> fail{ran, of_activity(activity, "fail"), remove};
    if (plan_.has_checks()) fail.push_back(plan_.ids + ".add_zombie");
    wire({.name = "fail_" + name, .ports = fail, .exported = p.fails_heard});
  }
  if (a.has_bad) {
    std::vector<std::string> bad{of_task(i, "suspend"), of_activity(activity, "bad")};
    if (plan_.has_checks()) bad.push_back(plan_.ids + ".suspend");
    add_module_lock(bad, "give");
    wire({.name = "bad_" + name, .ports = bad});
  }
}

void ModuleWriter::time() {
  out_ += "\n    // Time. The control task's timer need not keep up: the message box may have to wait.\n";
  std::vector<std::string> ticks;
  for (std::size_t i = 0; i < module_.tasks.size(); ++i) {
    if (module_.tasks[i].period_us > 0) ticks.push_back(of_task(i, "tick"));
  }
  // Without a timer posters grow older in each tick.
  if (!plan_.poster_timer.empty()) {
    ticks.push_back(plan_.poster_timer + ".tick");
  } else {
    for (std::size_t k = 0; k < plan_.posters.size(); ++k) {
      if (plan_.poster_types[k].has_age) ticks.push_back(plan_.posters[k] + ".grow");
    }
  }
  for (std::size_t k = 0; k < plan_.activities.size(); ++k) {
    if (plan_.services[plan_.activities[k].service].activity.has_async) ticks.push_back(of_activity(k, "watch_tick"));
  }
  const std::size_t triggers = plan_.design == Design::First || plan_.is_on_demand() ? 0 : ticks.size();
  ticks.push_back(control("tick"));
  wire({.name = "ModuleSync", .ports = ticks, .triggers = triggers, .exported = true});
  if (plan_.poster_timer.empty()) return;
  std::vector<std::string> age{plan_.poster_timer + ".trigger"};
  for (const std::string& poster : plan_.posters) age.push_back(poster + ".grow");
  wire({.name = "grow_older", .ports = age});
}

// Everything that is ready is started before the control cycle ends, in the order of the activities.
void ModuleWriter::priorities() {
  std::vector<std::string> launches;
  for (std::size_t k = 0; k < plan_.activities.size(); ++k) {
    if (plan_.service_of(k).kind == ServiceKind::Execution)
      launches.push_back("launch_" + plan_.activities[k].component);
  }
  for (const auto& [low, high] : refusals_)
    out_ += fmt::format("    priority {} {}:* < {}:*\n", scope_.claim("first_" + high, "rule"), names_.at(low),
                        names_.at(high));
  if (plan_.executive == Executive::Served) {
    for (const std::string& abort : aborts_)
      out_ += fmt::format("    priority {} {}:* < {}:*\n", scope_.claim("first_" + abort, "rule"),
                          names_.at("unknown_activity"), names_.at(abort));
  }
  // Where rules say when activities begin, the functional level does this.
  if (launches.empty() || plan_.is_launched_by_rules) return;
  out_ += "\n";
  for (std::size_t k = 0; k < launches.size(); ++k) {
    const std::string& low = names_.at(k + 1 < launches.size() ? launches[k + 1] : "done");
    out_ += fmt::format("    priority {} {}:* < {}:*\n", scope_.claim("first_" + launches[k], "rule"), low,
                        names_.at(launches[k]));
  }
}

void ModuleWriter::exports() {
  out_ += "\n    // For constraints and clients: see the connectors of FunctionalLevel.\n";
  for (std::size_t i = 0; i < module_.services.size(); ++i) {
    const ServicePlan& p = plan_.services[i];
    write_export(out_, control("read_" + p.id), "read_" + p.id);
    std::string trig;
    std::string rej;
    std::string abt;
    for (const std::size_t activity : p.activities) {
      const char* comma = activity == p.activities[0] ? "" : ", ";
      trig += comma + out_of("trig_" + plan_.activities[activity].component);
      rej += comma + out_of("rej_" + plan_.activities[activity].component);
      abt += comma + of_activity(activity, "abt");
    }
    if (p.is_decided) write_export(out_, control("allow_" + p.id), "allow_" + p.id);
    write_export(out_, out_of("abtInc_" + p.id), "abtInc_" + p.id);
    write_export(out_, trig, "trig_" + p.id);
    write_export(out_, rej, "rej_" + p.id);
    if (module_.services[i].kind == ServiceKind::Execution) write_export(out_, abt, "abt_" + p.id);
    for (const std::size_t activity : p.activities) {
      const std::string& name = plan_.activities[activity].component;
      write_export(out_, of_activity(activity, "stat"), "stat_" + name);
      if (p.is_stopped) write_export(out_, of_activity(activity, "halt"), "halt_" + name);
      if (p.is_heard && module_.services[i].kind == ServiceKind::Control)
        write_export(out_, out_of("final_" + name), "fin_" + name);
      else if (p.is_heard && p.activity.ends) write_export(out_, out_of("fin_" + name), "fin_" + name);
      const bool is_execution = module_.services[i].kind == ServiceKind::Execution;
      if (p.fails_heard && !is_execution && bad_finals_.contains(name))
        write_export(out_, bad_finals_.at(name), "nofin_" + name);
      if (p.fails_heard && p.activity.ends_not_ok) write_export(out_, out_of("nofin_" + name), "nofin_" + name);
      if (p.fails_heard && p.activity.has_zombie) write_export(out_, out_of("fail_" + name), "fail_" + name);
      if ((p.fails_heard || p.losses_heard) && p.activity.has_async)
        write_export(out_, out_of("lost_" + name), "lost_" + name);
      if (p.activity.has_timed()) write_export(out_, out_of("late_" + name), "late_" + name);
      if (p.is_waited_for) write_export(out_, of_activity(activity, "idle"), "idle_" + name);
      if (plan_.is_launched_by_rules && is_execution) write_export(out_, out_of("launch_" + name), "launch_" + name);
    }
  }
  if (plan_.execution_activities > 0) write_export(out_, control("read_Abort"), "read_Abort");
  for (const char* name : {"err", "stop"}) write_export(out_, control(name), name);
  if (plan_.is_launched_by_rules) write_export(out_, out_of("done"), "done");
  if (plan_.executive != Executive::Anybody) write_export(out_, out_of("none"), "none");
  if (plan_.is_on_demand()) write_export(out_, out_of("chck"), "chck");
  if (plan_.executive == Executive::Served) write_export(out_, out_of("woken"), "woken");
  if (plan_.executive == Executive::Served) write_export(out_, control("told"), "told");
  if (!plan_.takes_semaphore_to_decide()) write_export(out_, out_of("give"), "give");
  for (std::size_t i = 0; i < module_.tasks.size(); ++i) {
    if (module_.tasks[i].has_permanent() || !module_.tasks[i].reads.empty())
      write_export(out_, out_of("begin_" + plan_.tasks[i].component), "begin_" + plan_.tasks[i].component);
    if (plan_.has_permanent_cycle(i))
      write_export(out_, out_of("permanent_" + plan_.tasks[i].component), "permanent_" + plan_.tasks[i].component);
    if (plan_.tasks[i].is_watched) write_export(out_, of_task(i, "missed"), "missed_" + plan_.tasks[i].component);
  }
  for (const std::string& poster : plan_.posters) write_export(out_, poster + ".read", "read_" + poster);
  write_export(out_, out_of("ModuleSync"), "moduleTick");
}

void write_module(std::string& out, const Plan& plan, const GenerateOptions& options) {
  ModuleWriter(out, plan).run(options);
}

}  // namespace bip::genom
