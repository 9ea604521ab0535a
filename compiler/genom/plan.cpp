// Assigns names, then computes what is reachable, then what is shared.
#include "compiler/genom/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "compiler/genom/level.hpp"
#include "compiler/genom/names.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

// Of stdlib/genom, and the root: a type of the package would hide them.
constexpr const char* kOwnTypes[] = {"Signal",
                                     "Report",
                                     "Status",
                                     "Age",
                                     "ControlState",
                                     "MasterTimer",
                                     "Timer",
                                     "WakeUp",
                                     "RestingTimer",
                                     "IdsLock",
                                     "Semaphore",
                                     "Poster",
                                     "UndatedPoster",
                                     "ServiceController",
                                     "ControlService",
                                     "PatientControlService",
                                     "TaskController",
                                     "Permanent",
                                     "ControlIds",
                                     "FunctionalLevel",
                                     "Answer",
                                     "Running",
                                     "Elapsed",
                                     "Number",
                                     "Text",
                                     "Order",
                                     "Stopwatch",
                                     "NumberParameter",
                                     "TextParameter",
                                     "Pair",
                                     "FractionParameter",
                                     "Fraction",
                                     "Recovery",
                                     "Asks",
                                     "Pending",
                                     "Executive",
                                     "MasterClock",
                                     "Posts",
                                     "Told",
                                     "Accepted",
                                     "Numbered",
                                     "Target",
                                     "Outcome",
                                     "Countdown",
                                     "CodelWatch",
                                     "Counts",
                                     "Success",
                                     "Quiet",
                                     "Silence",
                                     "Fault",
                                     "Failure",
                                     "Lateness",
                                     "WatchedTimer",
                                     "Edge"};

bool yields(const Activity& activity, const ActivityPlan& a, std::size_t to, Next next) {
  BIP_ASSERT(to < activity.states.size() && a.used.size() == activity.states.size(), "state {} of {}, {} are planned",
             to, activity.states.size(), a.used.size());
  for (std::size_t i = 0; i < activity.states.size(); ++i) {
    const std::vector<Yield>& all = activity.states[i].yields;
    if (a.used[i] &&
        std::any_of(all.begin(), all.end(), [&](const Yield& y) { return y.next == next && y.state == to; }))
      return true;
  }
  return false;
}

// Who can stop an activity: requests that of a service; a service `kill` that of a task, which then ends like one that
// stops by itself.
enum class StoppedBy : std::uint8_t { Nobody, Requests, Kill };

ActivityPlan plan_activity(const Activity& activity, StoppedBy stopped_by, const std::vector<std::string>& reports,
                           int generation) {
  const bool can_be_stopped = stopped_by == StoppedBy::Requests;
  BIP_ASSERT(activity.start < activity.states.size() && activity.stop < activity.states.size(),
             "an activity of {} states starts in {} and stops in {}", activity.states.size(), activity.start,
             activity.stop);
  const bool has_reports = !reports.empty();
  ActivityPlan a;
  Scope scope;
  for (const char* own : {"ETHER", "SLEEP", "ZOMBIE"}) scope.claim(own, "");
  for (const State& s : activity.states) a.places.push_back(scope.claim(upper(s.name.text), "state"));
  a.used.assign(activity.states.size(), false);
  a.async.assign(activity.states.size(), false);
  a.holds.assign(activity.states.size(), false);
  a.timed.assign(activity.states.size(), false);
  std::vector<std::size_t> todo{activity.start};
  if (stopped_by != StoppedBy::Nobody) todo.push_back(activity.stop);
  while (!todo.empty()) {
    const std::size_t row = todo.back();
    todo.pop_back();
    if (a.used[row]) continue;
    BIP_ASSERT(row < activity.states.size(), "state {} of {}", row, activity.states.size());
    a.used[row] = true;
    const State& state = activity.states[row];
    const bool is_stop = can_be_stopped && row == activity.stop;
    a.async[row] = state.codel.is_async;
    a.has_async = a.has_async || a.async[row];
    bool ends = false;
    for (const Yield& y : state.yields) {
      if (y.next == Next::State || y.next == Next::Pause) todo.push_back(y.state);
      a.goes_on = a.goes_on || y.next == Next::State || y.next == Next::Sleep;
      a.pauses = a.pauses || y.next == Next::Pause;
      a.has_sleep = a.has_sleep || y.next == Next::Sleep;
      a.has_zombie = a.has_zombie || y.next == Next::Zombie;
      // GenoM 3: an activity ends with `bad_transition`.
      a.has_bad = a.has_bad || (y.next == Next::Other && !(can_be_stopped && generation == 3));
      ends = ends || y.next == Next::Ether;
    }
    a.ends = a.ends || (ends && !is_stop);
    a.ends_stopped = a.ends_stopped || (ends && is_stop);
    // GenoM 2: a report goes with ETHER. GenoM 3: an exception ends an activity from any codel.
    a.ends_not_ok =
        a.ends_not_ok || (has_reports && state.codel.name.is_set() && (generation == 3 || (ends && !is_stop)));
  }
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (yields(activity, a, i, Next::State)) a.to.push_back("to_" + a.places[i]);
    if (yields(activity, a, i, Next::Pause)) a.pause.push_back("pause_" + a.places[i]);
  }
  if (a.has_sleep) a.to.emplace_back("to_SLEEP");
  for (const std::string& r : reports) a.report.push_back("report_" + bip_name(r));
  BIP_ASSERT(a.places.size() == activity.states.size() && a.async.size() == a.used.size(), "{} places of {} states",
             a.places.size(), activity.states.size());
  a.rests = can_be_stopped || a.ends || a.pauses || a.has_sleep || a.has_zombie;
  return a;
}

class Planner {
 public:
  Planner(const Module& module, const GenerateOptions& options, Scope& types)
      : module_(module), options_(options), types_(types) {
    plan_.module = &module;
    plan_.by_codel = options.lock == LockGranularity::Codel ||
                     (options.lock == LockGranularity::ByGeneration && module.generation == 3);
    plan_.calls = options.flavour == Flavour::Execution;
    plan_.calls_c = options.calls_c;
    plan_.has_task_threads = plan_.calls && options.has_task_threads;
    plan_.has_processes = options.processes.are_own;
    plan_.executive = options.executive;
    plan_.design = options.design;
    plan_.type = types_.claim(type_name(module.name.text), "Module");
    plan_.component = bip_name(module.name.text);
  }

  Plan run() {
    plan_.control_type = types_.claim(plan_.type + "Control", "Task");
    plan_.box_type = types_.claim(plan_.type + "MessageBox", "Atom");
    if (plan_.executive == Executive::Served) plan_.mailbox_type = types_.claim(plan_.type + "Mailbox", "Atom");
    plan_.control = scope_.claim("control", "task");
    plan_.ids = scope_.claim("ids", "control");
    if (!plan_.by_codel) plan_.lock = scope_.claim("lock", "ids");
    // Posters that grow older in each tick need no timer.
    const bool grow_with_time = plan_.is_on_demand() && options_.poster_period == 1;
    if (!module_.posters.empty() && !grow_with_time) plan_.poster_timer = scope_.claim("poster_timer", "module");
    for (std::size_t i = 0; i < module_.services.size(); ++i) service(i);
    for (std::size_t i = 0; i < module_.tasks.size(); ++i) task(i);
    for (const Poster& poster : module_.posters)
      plan_.posters.push_back(scope_.claim(bip_name(poster.name.text), "poster"));
    plan_.poster_types.resize(plan_.posters.size());
    BIP_ASSERT(plan_.services.size() == module_.services.size() && plan_.tasks.size() == module_.tasks.size(),
               "{} services, {} tasks", plan_.services.size(), plan_.tasks.size());
    if (plan_.by_codel) locks();
    return std::move(plan_);
  }

 private:
  void service(std::size_t i) {
    const Service& s = module_.services[i];
    ServicePlan plan;
    plan.id = ids_.claim(bip_name(s.name.text), "service");
    const bool is_execution = s.kind == ServiceKind::Execution;
    BIP_ASSERT(!is_execution || s.task_index < module_.tasks.size(), "service `{}` is of task {} of {}", s.name.text,
               s.task_index, module_.tasks.size());
    plan.type = plan_.accepts_before_data() ? "PatientControlService" : "ControlService";
    if (is_execution) {
      plan.type = types_.claim(plan_.type + type_name(s.name.text), "Service");
      plan.activity = plan_activity(s.activity, StoppedBy::Requests, activity_reports(plan_, s), module_.generation);
      plan.activity.type = types_.claim(plan.type + "Activity", "Atom");
      find_threaded(s.activity, plan.activity);
      if (plan.activity.has_work()) plan.work_type = types_.claim(plan.type + "Work", "Atom");
    }
    for (std::size_t k = 0; k < s.instances; ++k) {
      plan.activities.push_back(plan_.activities.size());
      plan_.activities.push_back({i, scope_.claim(k == 0 ? plan.id : fmt::format("{}_{}", plan.id, k + 1), "service")});
    }
    if (is_execution) plan_.execution_activities += s.instances;
    BIP_ASSERT(plan.activities.size() == s.instances && i == plan_.services.size(), "service {} has {} activities", i,
               plan.activities.size());
    plan_.services.push_back(std::move(plan));
  }

  // Which codels run in threads. With one lock for the module, an activity is not interrupted while its codel runs, so
  // the activity's own atom waits for the codel. With locks by codel it can be interrupted, so a second atom waits
  // (has_turns).
  void find_threaded(const Activity& activity, ActivityPlan& a) const {
    BIP_ASSERT(a.used.size() == activity.states.size() && a.async.size() == activity.states.size(),
               "{} states, {} are planned", activity.states.size(), a.used.size());
    a.threaded.assign(activity.states.size(), false);
    for (std::size_t i = 0; i < activity.states.size(); ++i) {
      a.threaded[i] = plan_.has_task_threads && a.used[i] && !a.async[i] && activity.states[i].codel.name.is_set();
      a.has_turns = a.has_turns || (a.threaded[i] && plan_.by_codel);
    }
  }

  void task(std::size_t i) {
    const Task& t = module_.tasks[i];
    TaskPlan plan;
    plan.component = scope_.claim(bip_name(t.name.text), "task");
    plan.type = types_.claim(plan_.type + type_name(t.name.text), "Task");
    plan.scheduler = types_.claim(plan.type + "Scheduler", "Atom");
    if (!t.activity.states.empty())
      plan.permanent =
          plan_activity(t.activity, module_.is_killed ? StoppedBy::Kill : StoppedBy::Nobody, {}, module_.generation);
    plan.permanent.type = types_.claim(plan.type + "Permanent", "Atom");
    plan.permanent_to_begin =
        t.permanent.name.is_set() && plan_.is_on_demand() && !plan_.by_codel && !plan_.has_task_threads;
    if (t.permanent.name.is_set() && (plan_.has_task_threads || plan.permanent_to_begin))
      plan.permanent_type = plan.permanent.type;
    find_threaded(t.activity, plan.permanent);
    if (plan.permanent.has_work()) plan.work_type = types_.claim(plan.type + "Work", "Atom");
    for (std::size_t k = 0; k < plan_.activities.size(); ++k) {
      const Service& s = plan_.service_of(k);
      if (s.kind == ServiceKind::Execution && s.task_index == i) plan.activities.push_back(k);
    }
    BIP_ASSERT(i == plan_.tasks.size(), "task {} comes after {}", i, plan_.tasks.size());
    plan_.tasks.push_back(std::move(plan));
  }

  static constexpr std::size_t kNobody = static_cast<std::size_t>(-1);
  struct Use {
    std::size_t thread;  // Plan::thread_of_task and its like
    std::size_t actor;   // whose codels run one after the other whatever their threads: an activity, a task's own
    bool writes;
  };

  static bool may_meet(const Use& a, const Use& b) {
    return a.thread != b.thread && (a.actor != b.actor || a.actor == kNobody) && (a.writes || b.writes);
  }

  // Calls f(codel, thread, actor) for each codel of the module and each thread that may run it.
  template <class F>
  void for_each_codel(F f) const {
    for (std::size_t i = 0; i < module_.services.size(); ++i) {
      const Service& s = module_.services[i];
      f(s.validate, 0, kNobody);
      for (const Codel& c : s.body) f(c, 0, kNobody);
      for (const State& state : s.activity.states) {
        for (const std::size_t activity : plan_.services[i].activities)
          f(state.codel,
            state.codel.is_async ? plan_.thread_beside_activity(activity) : Plan::thread_of_task(s.task_index),
            activity);
      }
    }
    for (std::size_t i = 0; i < module_.tasks.size(); ++i) {
      const std::size_t actor = plan_.activities.size() + i;
      if (module_.tasks[i].permanent.name.is_set()) f(module_.tasks[i].permanent, Plan::thread_of_task(i), actor);
      for (const State& state : module_.tasks[i].activity.states)
        f(state.codel, state.codel.is_async ? plan_.thread_beside_task(i) : Plan::thread_of_task(i), actor);
    }
  }

  // Data that two codels use that may run at once, one of them writing.
  void locks() {
    std::map<std::string, std::vector<Use>> all;
    std::vector<std::string> order;
    for_each_codel([&](const Codel& codel, std::size_t thread, std::size_t actor) {
      for (const DataUse& use : uses_of(module_, codel)) {
        std::vector<Use>& uses = all[use.data];
        if (uses.empty()) order.push_back(use.data);
        uses.push_back({thread, actor, use.writes});
      }
    });
    std::set<std::string> locked;
    for (const std::string& data : order) {
      const std::vector<Use>& uses = all[data];
      const bool meets = std::any_of(uses.begin(), uses.end(), [&](const Use& a) {
        return std::any_of(uses.begin(), uses.end(), [&](const Use& b) { return may_meet(a, b); });
      });
      if (!meets) continue;
      std::set<std::size_t> threads;
      for (const Use& use : uses) threads.insert(use.thread);
      BIP_ASSERT(threads.size() >= 2 && *threads.rbegin() <= 2 * module_.tasks.size() + plan_.activities.size(),
                 "the lock of `{}` is for {} threads, the last is {}", data, threads.size(), *threads.rbegin());
      locked.insert(data);
      plan_.locks.push_back({data, scope_.claim("lock_" + bip_name(data), "data"), {threads.begin(), threads.end()}});
    }
    const auto holds = [&](const Activity& activity, ActivityPlan& a) {
      for (std::size_t i = 0; i < activity.states.size(); ++i) {
        const std::vector<DataUse> uses = uses_of(module_, activity.states[i].codel);
        a.holds[i] = a.async[i] && std::any_of(uses.begin(), uses.end(),
                                               [&](const DataUse& use) { return locked.contains(use.data); });
      }
    };
    for (std::size_t i = 0; i < module_.services.size(); ++i) {
      if (module_.services[i].kind == ServiceKind::Execution)
        holds(module_.services[i].activity, plan_.services[i].activity);
    }
    for (std::size_t i = 0; i < module_.tasks.size(); ++i) {
      if (!module_.tasks[i].activity.states.empty()) holds(module_.tasks[i].activity, plan_.tasks[i].permanent);
    }
  }

  const Module& module_;
  const GenerateOptions& options_;
  Plan plan_;
  Scope scope_;
  Scope& types_;
  Scope ids_;  // of services, in names of ports
};

}  // namespace

namespace {

void add_aged(const Condition& c, std::set<std::pair<std::size_t, std::size_t>>& aged) {
  if (c.kind == ConditionKind::Fresh || c.kind == ConditionKind::Age) aged.emplace(c.poster.module, c.poster.poster);
  for (const Condition& operand : c.operands) add_aged(operand, aged);
}

// Posters that no rule and no task asks how old they are need not count that. Where a timer makes them older it goes
// on.
void leave_out_ages(std::vector<Plan>& plans, const Constraints& constraints) {
  std::set<std::pair<std::size_t, std::size_t>> aged;
  std::set<std::string> read;
  for (const Constraint& c : constraints.rows) add_aged(c.condition, aged);
  for (const Plan& p : plans) {
    for (const Task& t : p.module->tasks) {
      for (std::size_t k = 0; k < t.reads.size(); ++k) {
        if (t.freshness[k] > 0) read.insert(t.reads[k].text);
      }
    }
  }
  for (std::size_t m = 0; m < plans.size(); ++m) {
    Plan& p = plans[m];
    if (!p.is_on_demand() || !p.poster_timer.empty()) continue;
    for (std::size_t k = 0; k < p.poster_types.size(); ++k) {
      PosterPlan& poster = p.poster_types[k];
      if (!poster.values.empty() || aged.contains({m, k}) ||
          read.contains(p.module->name.text + "." + p.module->posters[k].name.text))
        continue;
      poster.has_age = false;
      poster.type = "UndatedPoster";
    }
  }
}

}  // namespace

Plan make_plan(const Module& module, std::size_t index, const GenerateOptions& options, Scope& types) {
  Plan p = Planner(module, options, types).run();
  for (const Constraint& c : options.constraints.rows) {
    BIP_ASSERT(c.kind == ConstraintKind::When || c.subject.module != index || c.subject.service < p.services.size(),
               "rule `{}` is about service {} of {}", c.name, c.subject.service, p.services.size());
    BIP_ASSERT((c.kind != ConstraintKind::Interrupt && c.kind != ConstraintKind::Wait) || c.other.module != index ||
                   c.other.service < p.services.size(),
               "rule `{}` names service {} of {}", c.name, c.other.service, p.services.size());
    if (c.kind == ConstraintKind::Admit && c.subject.module == index) p.services[c.subject.service].is_decided = true;
    if (c.kind == ConstraintKind::Keep && c.subject.module == index) p.services[c.subject.service].is_stopped = true;
    if (c.kind == ConstraintKind::Interrupt && c.other.module == index) p.services[c.other.service].is_stopped = true;
    if (c.kind != ConstraintKind::Wait) continue;
    if (c.other.module == index) p.services[c.other.service].is_waited_for = true;
    if (c.subject.module == index) p.is_launched_by_rules = true;
  }
  for (const SuccessRow& row : options.constraints.successes) {
    BIP_ASSERT(row.service.module != index || row.service.service < p.services.size(), "success of service {} of {}",
               row.service.service, p.services.size());
    if (row.service.module == index) p.services[row.service.service].is_heard = true;
  }
  for (const FailureRow& row : options.constraints.failures) {
    if (row.service.module != index) continue;
    BIP_ASSERT(row.service.service < p.services.size(), "failure of service {} of {}", row.service.service,
               p.services.size());
    ServicePlan& s = p.services[row.service.service];
    (row.kind == FailureKind::Failed ? s.fails_heard : s.losses_heard) = true;
    for (std::size_t i = 0; row.kind == FailureKind::Late && i < s.activity.timed.size(); ++i) {
      const Codel& codel = module.services[row.service.service].activity.states[i].codel;
      s.activity.timed[i] = s.activity.used[i] && codel.name.is_set() && !codel.is_async && codel.budget_us > 0;
    }
  }
  for (const TaskRef& task : options.constraints.watched_tasks) {
    BIP_ASSERT(task.module != index || task.task < p.tasks.size(), "task {} of {} is watched", task.task,
               p.tasks.size());
    if (task.module == index) p.tasks[task.task].is_watched = true;
  }
  for (const ValueRow& row : options.constraints.values) {
    BIP_ASSERT(row.poster.module != index || row.poster.poster < p.poster_types.size(), "poster {} of {}",
               row.poster.poster, p.poster_types.size());
    if (row.poster.module != index) continue;
    PosterPlan& poster = p.poster_types[row.poster.poster];
    const std::string name = p.type + type_name(module.posters[row.poster.poster].name.text);
    if (poster.values.empty()) poster = {types.claim(name, "Poster"), types.claim(name + "Data", "Port"), {}};
    poster.values.push_back(&row);
  }
  return p;
}

std::vector<Plan> make_plans(const std::vector<Module>& modules, const GenerateOptions& options) {
  std::vector<Plan> plans;
  Scope types;
  for (const char* own : kOwnTypes) types.claim(own, "");
  Scope parts = level_scope();
  std::size_t owners = 0;
  for (std::size_t i = 0; i < modules.size(); ++i) {
    plans.push_back(make_plan(modules[i], i, options, types));
    Plan& plan = plans.back();
    plan.component = parts.claim(plan.component, "module");
    plan.first_owner = owners;
    owners += plan.owners();
  }
  leave_out_ages(plans, options.constraints);
  return plans;
}

bool Plan::begins_with_timer(std::size_t task) const {
  const std::vector<std::int64_t>& ages = module->tasks[task].freshness;
  return is_on_demand() && !has_task_threads &&
         std::all_of(ages.begin(), ages.end(), [](std::int64_t age) { return age <= 0; });
}

bool Plan::ends_by_passing(std::size_t task) const {
  return passes_over(task) && module->generation == 2 &&
         std::none_of(module->posters.begin(), module->posters.end(),
                      [task](const Poster& p) { return !p.is_auto && p.task_index == task; });
}

bool Plan::may_suspend(std::size_t task) const {
  BIP_ASSERT(task < tasks.size() && tasks.size() == module->tasks.size(), "task {} of {}", task, tasks.size());
  const Task& t = module->tasks[task];
  if ((t.permanent.name.is_set() && t.permanent_fails) || tasks[task].permanent.has_bad) return true;
  return std::any_of(tasks[task].activities.begin(), tasks[task].activities.end(),
                     [&](std::size_t activity) { return services[activities[activity].service].activity.has_bad; });
}

bool control_may_fail(const Service& service) {
  return service.body_fails &&
         std::any_of(service.body.begin(), service.body.end(), [](const Codel& c) { return c.name.is_set(); });
}

std::vector<std::string> activity_reports(const Plan& plan, const Service& service) {
  std::vector<std::string> reports;
  for (const Name& r : service.reports) reports.push_back(r.text);
  if (plan.calls && plan.module->generation == 3) {
    for (const char* own : {"bad_transition", "codel_exception"}) {
      if (std::find(reports.begin(), reports.end(), own) == reports.end()) reports.emplace_back(own);
    }
  }
  return reports;
}

std::vector<DataUse> uses_of(const Module& module, const Codel& codel) {
  if (module.generation == 3) return codel.uses;
  // One that runs beside its task cannot be kept away from everything: what it touches is for its author to see.
  return codel.name.is_set() && !codel.is_async ? std::vector<DataUse>{{"ids", true}} : std::vector<DataUse>{};
}

int answer_code(const Yield& answer) {
  BIP_ASSERT((answer.next != Next::State && answer.next != Next::Pause) || answer.state < kMaxCalledStates,
             "state {} has no code of its own", answer.state);
  switch (answer.next) {
    case Next::Ether: return 0;
    case Next::State: return 1 + static_cast<int>(answer.state);
    case Next::Pause: return 101 + static_cast<int>(answer.state);
    case Next::Zombie: return 201;
    case Next::Sleep: return 202;
    case Next::Other: break;
  }
  return -1;
}

std::string codel_label(const State& state) {
  return state.codel.name.is_set() ? bip_name(state.codel.name.text) : "no_codel_" + bip_name(state.name.text);
}

}  // namespace bip::genom
