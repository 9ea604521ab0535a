// The compound of a module (Bensalem, de Silva, Ingrand, Yan 2011, Figures 7 and 10): its components, and one
// connector per event, in the order of the control cycle, then of a task's cycle, then time.
#include <fmt/format.h>

#include <algorithm>

#include "compiler/genom/module_writer.hpp"
#include "compiler/genom/standard_services.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

std::vector<const Codel*> bodies(const Service& s) {
  std::vector<const Codel*> codels;
  for (const Codel& c : s.body) codels.push_back(&c);
  return codels;
}

// The last one stands for exceptions of C++, and for answers that there are not.
std::vector<std::string> control_reports(const Plan& plan, const Service& s) {
  std::vector<std::string> reports;
  for (const Name& r : s.reports) reports.push_back(r.text);
  if (plan.calls || reports.empty())
    reports.emplace_back(plan.calls && plan.module->generation == 3 ? "codel_exception" : "CONTROL_CODEL_ERROR");
  return reports;
}

bool has_checked(const Plan& p) {
  return p.has_checks() && std::any_of(p.module->services.begin(), p.module->services.end(),
                                       [](const Service& s) { return s.kind == ServiceKind::Execution && !s.is_init; });
}

}  // namespace

ModuleWriter::ModuleWriter(std::string& out, const Plan& plan)
    : out_(out), plan_(plan), module_(*plan.module), is_3_(plan.module->generation == 3) {
  BIP_ASSERT(plan_.services.size() == module_.services.size() && plan_.tasks.size() == module_.tasks.size() &&
                 plan_.poster_types.size() == module_.posters.size(),
             "the plan of `{}` has {} services, {} tasks, {} posters", module_.name.text, plan_.services.size(),
             plan_.tasks.size(), plan_.poster_types.size());
  for (const std::string& own : {plan_.control, plan_.ids, plan_.lock, plan_.poster_timer}) scope_.claim(own, "");
  for (const ServiceInstance& activity : plan_.activities) scope_.claim(activity.component, "");
  for (const TaskPlan& t : plan_.tasks) scope_.claim(t.component, "");
  for (const std::string& poster : plan_.posters) scope_.claim(poster, "");
  for (const LockPlan& lock : plan_.locks) scope_.claim(lock.component, "");
}

void ModuleWriter::wire(Wire w) {
  const std::string wanted = w.name;
  w.name = scope_.claim(wanted, "event");
  names_.emplace(wanted, w.name);
  write_wire(out_, w);
}

void ModuleWriter::run(const GenerateOptions& options) {
  out_ += fmt::format("\n  // Module {}.\n  compound type {}()\n", module_.name.text, plan_.type);
  parts(options);
  control_cycle();
  for (std::size_t i = 0; i < module_.services.size(); ++i) request(i);
  if (plan_.execution_activities > 0) {
    aborts();
    launches();
  }
  std::vector<std::string> done{control("done")};
  for (std::size_t i = 0; i < module_.tasks.size(); ++i) {
    if (module_.tasks[i].period_us == 0) done.push_back(of_task(i, "wake"));
  }
  wire({.name = "done", .ports = done, .exported = plan_.is_launched_by_rules});
  std::vector<std::string> rest{control("rest")};
  add_module_lock(rest, "give");
  wire({.name = "rest", .ports = rest});
  if (!plan_.takes_semaphore_to_decide()) {
    std::vector<std::string> give{control("give")};
    add_module_lock(give, "give");
    wire({.name = "give", .ports = give, .exported = true});
  }
  for (std::size_t i = 0; i < module_.tasks.size(); ++i) task(i);
  time();
  priorities();
  exports();
  out_ += "  end\n";
}

void ModuleWriter::add_module_lock(std::vector<std::string>& ports, const char* what) const {
  if (!plan_.by_codel) ports.push_back(plan_.lock + "." + what);
}

// Adds the locks of what a codel uses.
void ModuleWriter::add_locks(std::vector<std::string>& ports, const std::vector<const Codel*>& codels,
                             std::size_t thread, const char* what) const {
  if (!plan_.by_codel) return;
  for (const LockPlan& lock : plan_.locks) {
    bool used = false;
    bool written = false;
    for (const Codel* codel : codels) {
      for (const DataUse& use : uses_of(module_, *codel)) {
        used = used || use.data == lock.data;
        written = written || (use.data == lock.data && use.writes);
      }
    }
    const auto place = std::find(lock.threads.begin(), lock.threads.end(), thread) - lock.threads.begin();
    BIP_ASSERT(!used || static_cast<std::size_t>(place) < lock.threads.size(),
               "thread {} uses `{}`, and its lock is for {} others", thread, lock.data, lock.threads.size());
    if (used) ports.push_back(fmt::format("{}.{}_{}_{}", lock.component, written ? "write" : "read", what, place + 1));
  }
}

void ModuleWriter::parts(const GenerateOptions& options) {
  out_ += fmt::format("    component {} {}({})\n", plan_.control_type, plan_.control, options.control_period);
  if (plan_.has_checks()) {
    out_ += fmt::format("    @SuppressWarning(unboundcomponentport)\n    component ControlIds {}({}, {})\n", plan_.ids,
                        module_.has_init() ? "true" : "false", plan_.execution_activities);
  }
  if (!plan_.by_codel) out_ += fmt::format("    component IdsLock {}()\n", plan_.lock);
  for (const LockPlan& lock : plan_.locks)
    out_ += fmt::format("    @SuppressWarning(unboundcomponentport)\n    component DataLock{} {}()\n",
                        lock.threads.size(), lock.component);
  for (const TaskPlan& t : plan_.tasks) out_ += fmt::format("    component {} {}()\n", t.type, t.component);
  for (std::size_t k = 0; k < plan_.activities.size(); ++k) {
    const ServiceInstance& activity = plan_.activities[k];
    const bool is_execution = plan_.service_of(k).kind == ServiceKind::Execution;
    out_ += fmt::format("    @SuppressWarning(unboundcomponentport)\n    component {} {}({})\n",
                        plan_.services[activity.service].type, activity.component,
                        plan_.calls && is_execution ? std::to_string(plan_.owner_of_activity(k)) : "");
  }
  if (!plan_.poster_timer.empty())
    out_ += fmt::format("    component Timer {}({}, 0)\n", plan_.poster_timer, options.poster_period);
  for (std::size_t k = 0; k < plan_.posters.size(); ++k)
    out_ +=
        fmt::format("    @SuppressWarning(unboundcomponentport)\n    component {} {}({})\n", plan_.poster_types[k].type,
                    plan_.posters[k], plan_.poster_types[k].has_age ? std::to_string(options.oldest) : "");
}

// Execution flavour: the codels one after the other, until one does not answer OK.
std::string ModuleWriter::called(const std::vector<Codel>& codels, std::size_t activity,
                                 const std::string& port) const {
  const std::string answer = of_activity(activity, port);
  std::string action;
  for (const Codel& c : codels) {
    if (!plan_.calls || !c.name.is_set()) continue;
    const std::string call =
        fmt::format("{} <- {}({})", answer, codel_function(c.name.text), plan_.owner_of_activity(activity));
    action += action.empty()
                  ? call
                  : fmt::format("{} if ({} == 0) then {}; fi", action.ends_with("fi") ? "" : ";", answer, call);
  }
  return action;
}

static std::string in_sequence(const std::vector<std::string>& actions) {
  std::string all;
  for (const std::string& action : actions) {
    if (!action.empty()) all += (all.empty() ? "" : all.ends_with("fi") ? " " : "; ") + action;
  }
  return all;
}

// What C++ does as a request is accepted: its input is stored. A codel that judges the input has read it.
std::string ModuleWriter::begins(const Service& s, std::size_t activity) const {
  const std::size_t owner = plan_.owner_of_activity(activity);
  return in_sequence({plan_.has_processes ? fmt::format("service_accepted({})", owner) : "",
                      plan_.calls_c && !s.validate.name.is_set() ? fmt::format("service_begin({})", owner) : ""});
}

// A control service's codels, and its output.
std::string ModuleWriter::runs(const Service& s, std::size_t activity) const {
  const std::string answer = plan_.accepts_before_data() ? "run.answer" : "trig.answer";
  const std::string calls = called(s.body, activity, answer);
  if (!plan_.calls_c || s.kind != ServiceKind::Control) return calls;
  const std::string end = fmt::format("service_end({})", plan_.owner_of_activity(activity));
  return in_sequence(
      {calls, calls.empty() ? end : fmt::format("if ({} == 0) then {}; fi", of_activity(activity, answer), end)});
}

std::string ModuleWriter::accepted(const Service& s, std::size_t activity) const {
  return in_sequence({begins(s, activity), runs(s, activity)});
}

// The k-th of so many reports; the last one stands for whatever else a codel returns.
std::string ModuleWriter::answered(const std::string& answer, std::size_t k, std::size_t reports) const {
  BIP_ASSERT(k < reports, "report {} of {}", k, reports);
  if (!plan_.calls) return {};
  if (k + 1 < reports) return fmt::format("{} == {}", answer, k + 1);
  std::string guard = answer + " != 0";
  for (std::size_t i = 0; i < k; ++i) guard += fmt::format(" && {} != {}", answer, i + 1);
  return guard;
}

void ModuleWriter::control_cycle() {
  std::vector<std::string> chck{control("chck")};
  add_module_lock(chck, "take");
  wire({.name = "chck", .ports = chck, .exported = plan_.is_on_demand()});
  if (plan_.is_on_demand()) demands();
  if (plan_.executive == Executive::Served) {
    chck[0] = control("woken");
    wire({.name = "woken", .ports = chck, .exported = true});
  }
  std::vector<std::string> replies{control("collect")};
  for (std::size_t k = 0; k < plan_.activities.size(); ++k) {
    if (plan_.service_of(k).kind == ServiceKind::Execution) replies.push_back(of_activity(k, "reply"));
  }
  wire({.name = "collect", .ports = replies, .triggers = replies.size() > 1 ? 1u : 0u});
  wire({.name = "none", .ports = {control("none")}, .exported = plan_.executive != Executive::Anybody});
  if (!has_checked(plan_)) return;
  const std::string state = plan_.ids + ".state";
  const auto refuse = [&](const char* report, const std::string& guard) {
    wire({.name = fmt::format("refuse_{}", report),
          .ports = {control("refuse"), state},
          .guard = guard,
          .action = fmt::format("{}.rep <- \"{}\"", control("refuse"), report)});
  };
  wire({.name = "accept",
        .ports = {control("accept"), state},
        .guard = fmt::format("!{0}.suspended && {0}.initialised && {0}.zombies == 0", state)});
  refuse("SYSTEM_ERROR", fmt::format("{}.suspended", state));
  refuse("WAIT_INIT_RQST", fmt::format("!{0}.suspended && !{0}.initialised", state));
  refuse("WAIT_ABORT_ZOMBIE_ACTIVITY", fmt::format("!{0}.suspended && {0}.initialised && {0}.zombies > 0", state));
}

// What begins a control cycle beside requests, which the functional level adds: each instance that has a final reply
// due or waits to begin, and each aperiodic task that has work and is woken by `done`.
void ModuleWriter::demands() {
  const auto demand = [&](const std::string& component, const char* port) {
    std::vector<std::string> ports{control("chck"), component + "." + port};
    add_module_lock(ports, "take");
    wire({.name = "chck_" + component, .ports = ports});
  };
  for (std::size_t k = 0; k < plan_.activities.size(); ++k) {
    if (plan_.service_of(k).kind == ServiceKind::Execution) demand(plan_.activities[k].component, "due");
  }
  for (std::size_t i = 0; i < module_.tasks.size(); ++i) {
    if (module_.tasks[i].period_us == 0) demand(plan_.tasks[i].component, "work");
  }
}

// `before S`: once S has succeeded it is too late; `after S`: until then it is too early.
void ModuleWriter::order_guards(const Service& s, std::vector<std::string>& ports, std::string& guard) const {
  enum class Order : std::uint8_t { After, Before };
  const auto add = [&](std::size_t other, Order order) {
    std::string done;
    for (const std::size_t activity : plan_.services[other].activities) {
      const std::string stat = of_activity(activity, "stat");
      if (std::find(ports.begin(), ports.end(), stat) == ports.end()) ports.push_back(stat);
      done += (done.empty() ? "" : " || ") + stat + ".done";
    }
    guard += std::string(guard.empty() ? "" : " && ") + (order == Order::After ? "(" : "!(") + done + ")";
  };
  for (const std::size_t other : s.after_index) add(other, Order::After);
  for (const std::size_t other : s.before_index) add(other, Order::Before);
}

void ModuleWriter::request(std::size_t i) {
  const Service& s = module_.services[i];
  const ServicePlan& p = plan_.services[i];
  const bool is_execution = s.kind == ServiceKind::Execution;
  out_ += fmt::format("\n    // Request {}.\n", s.name.text);
  admissions(i);
  interruptions(s, p);
  for (const std::size_t activity : p.activities) {
    const std::string& name = plan_.activities[activity].component;
    std::vector<std::string> trig{control("trig_" + p.id), of_activity(activity, "trig")};
    const bool is_patient = !is_execution && plan_.accepts_before_data();
    if (!is_execution && !is_patient) add_locks(trig, bodies(s), 0, "take");
    std::string guard;
    if (plan_.waits_in_box()) wait_for_interrupted(s, activity, trig, guard);
    wire({.name = "trig_" + name,
          .ports = trig,
          .guard = guard,
          .action = is_patient ? begins(s, activity) : accepted(s, activity),
          .exported = true});
    if (is_patient) {
      std::vector<std::string> run{control("run_" + p.id), of_activity(activity, "run")};
      add_locks(run, bodies(s), 0, "take");
      wire({.name = "run_" + name, .ports = run, .action = runs(s, activity)});
    }
    const std::string rejected = control("rej_" + p.id);
    wire({.name = "rej_" + name,
          .ports = {rejected, of_activity(activity, "rej")},
          .exported = true,
          .report_to = rejected,
          .report = "REJECTED"});
  }
  if (!is_execution) finals(s, p);
}

// Nothing that it interrupts is active any more, but for itself.
void ModuleWriter::wait_for_interrupted(const Service& s, std::size_t activity, std::vector<std::string>& ports,
                                        std::string& guard) const {
  for (const std::size_t other : s.interrupted) {
    for (const std::size_t old : plan_.services[other].activities) {
      if (old == activity) continue;
      ports.push_back(of_activity(old, "stat"));
      guard += (guard.empty() ? "!" : " && !") + ports.back() + ".active";
    }
  }
}

// To the first free instance, if the order of services allows it.
void ModuleWriter::admissions(std::size_t i) {
  const Service& s = module_.services[i];
  const ServicePlan& p = plan_.services[i];
  std::vector<std::string> stats;
  std::string guard;
  order_guards(s, stats, guard);
  std::vector<std::string> busy;
  for (const std::size_t activity : p.activities) {
    std::vector<std::string> admit{control("admit_" + p.id),
                                   of_activity(activity, s.validate.name.is_set() ? "ctrl" : "admit")};
    admit.insert(admit.end(), busy.begin(), busy.end());
    admit.insert(admit.end(), stats.begin(), stats.end());
    add_locks(admit, {&s.validate}, 0, "take");
    wire({.name = "admit_" + plan_.activities[activity].component,
          .ports = admit,
          .guard = guard,
          .action = called({s.validate}, activity, "ctrl.answer")});
    if (s.validate.name.is_set()) validated(s, activity);
    busy.push_back(of_activity(activity, "busy"));
  }
  const std::string full = control("full_" + p.id);
  if (s.kind == ServiceKind::Execution) {
    busy.insert(busy.begin(), full);
    wire({.name = "full_" + p.id,
          .ports = busy,
          .action = fmt::format("{}.rep <- \"{}\"", full, is_3_ ? "too_many_activities" : "TOO_MANY_ACTIVITIES")});
  }
  if (s.is_before_itself || s.is_after_itself) admitted_once(i);
  if (guard.empty()) return;
  // A free activity is asked for first, so this is for when there is one.
  for (std::size_t k = 0; k < p.activities.size(); ++k) {
    std::vector<std::string> ports{full};
    if (s.kind == ServiceKind::Execution) ports.push_back(of_activity(p.activities[k], "free"));
    ports.insert(ports.end(), stats.begin(), stats.end());
    wire({.name = "disallow_" + plan_.activities[p.activities[k]].component,
          .ports = ports,
          .guard = fmt::format("!({})", guard),
          .action = full + ".rep <- \"disallowed\""});
  }
}

// `before` itself: not after its first success; `after` itself: never. The activity that would be admitted cannot be
// asked for its own state at once, so the refusal goes first, and the refusal for want of a free activity before it.
void ModuleWriter::admitted_once(std::size_t i) {
  const Service& s = module_.services[i];
  const ServicePlan& p = plan_.services[i];
  const std::string full = control("full_" + p.id);
  std::vector<std::string> ports{full};
  std::string done;
  for (const std::size_t activity : p.activities) {
    ports.push_back(of_activity(activity, "stat"));
    done += (done.empty() ? "" : " || ") + ports.back() + ".done";
  }
  const std::string disallow = "disallow_" + p.id + "_itself";
  wire({.name = disallow,
        .ports = ports,
        .guard = !s.is_after_itself   ? done
                 : s.is_before_itself ? ""
                                      : "!(" + done + ")",
        .action = full + ".rep <- \"disallowed\""});
  for (const std::size_t activity : p.activities)
    refusals_.emplace_back("admit_" + plan_.activities[activity].component, disallow);
  if (s.kind == ServiceKind::Execution) refusals_.emplace_back(disallow, "full_" + p.id);
}

void ModuleWriter::validated(const Service& s, std::size_t activity) {
  const std::string& name = plan_.activities[activity].component;
  std::vector<std::string> valid{control("valid"), of_activity(activity, "valid")};
  add_locks(valid, {&s.validate}, 0, "give");
  wire({.name = "valid_" + name,
        .ports = valid,
        .guard = plan_.calls ? of_activity(activity, "valid.answer == 0") : ""});
  if (!s.validate_fails) return;
  const std::vector<std::string> reports = control_reports(plan_, s);
  for (std::size_t k = 0; k < reports.size(); ++k) {
    const std::string& report = reports[k];
    std::vector<std::string> bad{control("invalid"), of_activity(activity, "invalid")};
    add_locks(bad, {&s.validate}, 0, "give");
    wire({.name = fmt::format("invalid_{}_{}", name, bip_name(report)),
          .ports = bad,
          .guard = answered(of_activity(activity, "invalid.answer"), k, reports.size()),
          .action = fmt::format("{}.rep <- \"{}\"", control("invalid"), report)});
  }
}

void ModuleWriter::interruptions(const Service& s, const ServicePlan& p) {
  std::vector<std::string> ports{control("abtInc_" + p.id)};
  if (waits(s)) ports.push_back(plan_.lock + ".give");
  const std::size_t triggers = ports.size();
  for (const std::size_t other : s.interrupted) {
    for (const std::size_t activity : plan_.services[other].activities) ports.push_back(of_activity(activity, "abt"));
  }
  for (std::size_t i = 0; module_.is_killed && s.name.text == kKill && i < module_.tasks.size(); ++i) {
    if (!module_.tasks[i].activity.states.empty()) ports.push_back(of_task(i, "permanent_abt"));
  }
  wire(
      {.name = "abtInc_" + p.id, .ports = ports, .triggers = ports.size() > triggers ? triggers : 0, .exported = true});
}

void ModuleWriter::finals(const Service& s, const ServicePlan& p) {
  BIP_ASSERT(s.kind == ServiceKind::Control && p.activities.size() == 1, "`{}` has {} activities", s.name.text,
             p.activities.size());
  const std::size_t activity = p.activities[0];
  std::vector<std::string> fin{control("final"), of_activity(activity, "fin")};
  add_locks(fin, bodies(s), 0, "give");
  if (s.is_init) fin.push_back(plan_.ids + ".initialise");
  const bool has_codel = std::any_of(s.body.begin(), s.body.end(), [](const Codel& c) { return c.name.is_set(); });
  wire({.name = "final_" + plan_.activities[activity].component,
        .ports = fin,
        .guard = plan_.calls && has_codel ? of_activity(activity, "fin.answer == 0") : "",
        .action = control("final") + ".rep <- \"OK\"",
        .exported = p.is_heard});
  if (!control_may_fail(s)) return;
  const std::vector<std::string> reports = control_reports(plan_, s);
  for (std::size_t k = 0; k < reports.size(); ++k) {
    const std::string& report = reports[k];
    std::vector<std::string> bad{control("final"), of_activity(activity, "nofin")};
    add_locks(bad, bodies(s), 0, "give");
    const std::string name = fmt::format("final_{}_{}", plan_.activities[activity].component, bip_name(report));
    wire({.name = name,
          .ports = bad,
          .guard = answered(of_activity(activity, "nofin.answer"), k, reports.size()),
          .action = fmt::format("{}.rep <- \"{}\"", control("final"), report),
          .exported = p.fails_heard});
    std::string& all = bad_finals_[plan_.activities[activity].component];
    all += (all.empty() ? "" : ", ") + out_of(name);
  }
}
}  // namespace bip::genom
