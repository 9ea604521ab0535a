// Shared by the parts of the generator: the names of everything that is generated for a module, and which parts are
// needed. Internal to compiler/genom.
#pragma once
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/module.hpp"
#include "compiler/genom/names.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {

/// The states of an activity that can be reached, and which kinds of answers it gives.
struct ActivityPlan {
  std::string type;                 // of the atom
  std::vector<std::string> places;  // by state
  std::vector<bool> used;           // by state
  std::vector<bool> async;          // by state: used, and its codel runs beside the task
  std::vector<bool> holds;          // by state: async, and locks are held until its codel has returned
  std::vector<bool> timed;          // by state: rules ask whether its codel, which the task waits for, took too long
  std::vector<bool> threaded;       // by state: its codel runs in a thread, and the task waits for it
  bool has_async = false;
  bool has_turns = false;  // threaded codels are called by the atom that runs async ones, too
  /// Is there such an atom?
  [[nodiscard]] bool has_work() const { return has_async || has_turns; }
  bool has_sleep = false, has_zombie = false, has_bad = false;
  bool goes_on = false;       // yields a state
  bool pauses = false;        // GenoM 3: yields a state of the next cycle
  bool ends = false;          // well
  bool ends_not_ok = false;   // with a report of its own
  bool ends_stopped = false;  // after `stop`
  bool rests = false;         // has places in which it needs no turn
  /// Has it a codel that its task waits for?
  [[nodiscard]] bool steps() const {
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (used[i] && !async[i]) return true;
    }
    return false;
  }
  [[nodiscard]] bool has_timed() const { return std::find(timed.begin(), timed.end(), true) != timed.end(); }
  /// Its turn may be left out.
  [[nodiscard]] bool skips() const { return rests || has_async; }
  // Its ports for answers that go on, that pause, and for its own reports; and what each is merged as.
  std::vector<std::string> to, pause, report;
  [[nodiscard]] std::string went_on() const { return to.size() == 1 ? to[0] : "went_on"; }
  [[nodiscard]] std::string paused() const { return pause.size() == 1 ? pause[0] : "paused"; }
  [[nodiscard]] std::string not_ok() const { return report.size() == 1 ? report[0] : "not_ok"; }
};

/// One instance of a service: an activity activity if it is an execution service.
struct ServiceInstance {
  std::size_t service = 0;
  std::string component;
};
struct ServicePlan {
  std::string id;         // in names of ports and connectors
  std::string type;       // of the compound; ControlService is one for all
  std::string work_type;  // of the atom that runs codels beside the task, if there are such
  ActivityPlan activity;
  std::vector<std::size_t> activities;  // indices of Plan::activities; of a control service one
  bool is_decided = false;              // rules say whether it is accepted
  bool is_stopped = false;              // and tell it to stop
  bool is_waited_for = false;           // services of rules begin when it does not run
  bool is_heard = false;                // rules count from its last success
  bool fails_heard = false;             // rules ask whether it failed
  bool losses_heard = false;            // and whether a codel of it exceeded its budget and was given up
};
struct TaskPlan {
  std::string component, type, scheduler;
  ActivityPlan permanent;      // GenoM 3
  std::string work_type;       // of the atom that runs its own codels beside it, if there are such
  std::string permanent_type;  // GenoM 2, of the atom that calls its permanent codel; empty if its task does
  /// Returns whether a cycle runs the permanent codel (GenoM 2) in the step that begins it, and goes on with its
  /// activities at once if the answer is OK.
  bool permanent_to_begin = false;
  std::vector<std::size_t> activities;  // its activities, in activity order
  bool is_watched = false;              // rules ask whether it has missed its period
};
/// Data that codels of several threads share, if one of them writes it (codel granularity): see Plan::thread_of.
struct LockPlan {
  std::string data, component;
  std::vector<std::size_t> threads;  // sorted
};

/// The atom of a poster: the library's, unless rules ask for what it holds.
struct PosterPlan {
  std::string type = "Poster", port_type{};
  std::vector<const ValueRow*> values{};
  bool has_age = true;
};

struct Plan {
  const Module* module = nullptr;
  bool by_codel = false;          // lock granularity
  bool calls = false;             // execution flavour: codels are called
  bool calls_c = false;           // codels get inputs of requests and give outputs
  bool has_task_threads = false;  // codels run beside the engine, and their tasks wait for them
  bool has_processes = false;     // codels of each module run in a process of its own
  Executive executive = Executive::Anybody;
  Design design = Design::Ours;
  bool is_launched_by_rules = false;  // rules say when activities begin
  std::string type;                   // of the module's compound; begins the names of its other types
  std::string component;              // in the functional level
  std::vector<ServiceInstance> activities;
  std::vector<ServicePlan> services;
  std::vector<TaskPlan> tasks;
  std::vector<std::string> posters;
  std::vector<PosterPlan> poster_types;  // by poster
  std::vector<LockPlan> locks;
  std::size_t execution_activities = 0;
  std::size_t first_owner = 0;  // in the list of owners of codels: activities, then tasks, of all modules
  std::string control, ids, lock, poster_timer;  // components
  std::string control_type, box_type, mailbox_type;

  [[nodiscard]] const Service& service_of(std::size_t activity) const {
    BIP_ASSERT(activity < activities.size() && activities[activity].service < module->services.size(),
               "activity {} of {} is of a service that there is not", activity, activities.size());
    return module->services[activities[activity].service];
  }
  /// Does the message box wait for what a request interrupts, so that a module's lock goes back meanwhile?
  [[nodiscard]] bool waits_in_box() const { return design != Design::Ours; }
  [[nodiscard]] bool gives_lock(const Service& s) const {
    return !by_codel && (waits_in_box() || (s.waits && s.kind == ServiceKind::Execution));
  }
  /// Returns whether a request takes the semaphore when it is decided, and gives it back when it is accepted. Where
  /// codels run in threads a request may wait for data as long as a codel takes; holding the semaphore meanwhile, as it
  /// does from `read` to `give` elsewhere, it would hold up all modules.
  [[nodiscard]] bool takes_semaphore_to_decide() const { return has_task_threads && design == Design::Ours; }
  /// Returns whether a control service is accepted, and tells the activities that it interrupts, before it waits for
  /// the data of its codel. It could not wait first: one of those activities may hold the data.
  [[nodiscard]] bool accepts_before_data() const { return takes_semaphore_to_decide() && by_codel; }
  /// Returns whether a request waits until its module takes it. Where codels run in threads a module takes nothing
  /// while its control task waits for the data of a codel, which may be as long as a codel takes, and time goes on.
  [[nodiscard]] bool has_patient_mailbox() const { return has_task_threads; }
  /// Returns whether the control task runs on demand: a cycle begins only if a request waits, a final reply is due, an
  /// activity waits to begin, or an aperiodic task has work. This takes a mailbox or an executive, whose port `pending`
  /// is enabled while a request waits. Without one a cycle begins in each period.
  [[nodiscard]] bool is_on_demand() const { return executive != Executive::Anybody && design == Design::Ours; }
  /// Returns whether a cycle of the task passes over all activities that do not work at once: before its first turn,
  /// up to the one that has it, and after a turn, if none that follows works.
  [[nodiscard]] bool passes_over(std::size_t task) const { return is_on_demand() && !tasks[task].activities.empty(); }
  /// Returns whether a cycle ends with the step in which it passes over what follows. It does not where codels may
  /// write posters at its end, or where turns go on in rounds (GenoM 3).
  [[nodiscard]] bool ends_by_passing(std::size_t task) const;
  /// Returns whether a cycle in which no activity works has steps of its own: one that begins it with the permanent
  /// codel, one that ends it.
  [[nodiscard]] bool has_permanent_cycle(std::size_t task) const {
    return tasks[task].permanent_to_begin && ends_by_passing(task);
  }
  /// Returns whether a cycle of the task begins in the step that takes the trigger of its timer, so that the timer
  /// holds time up until the lock is free. Codels in threads hold the lock while time goes on; a poster of which a
  /// cycle asks that it is fresh may be written in a later tick only. There the task takes the trigger first, and waits
  /// then.
  [[nodiscard]] bool begins_with_timer(std::size_t task) const;
  /// GenoM 2 refuses requests by the state of the whole module.
  [[nodiscard]] bool has_checks() const { return module->generation == 2; }
  [[nodiscard]] bool may_suspend(std::size_t task) const;
  /// The number that C++ gets with each call of a codel.
  [[nodiscard]] std::size_t owner_of_activity(std::size_t activity) const { return first_owner + activity; }
  [[nodiscard]] std::size_t owner_of_task(std::size_t task) const { return first_owner + activities.size() + task; }
  [[nodiscard]] std::size_t owners() const { return activities.size() + tasks.size(); }
  /// Threads of LockPlan: 0 the control task, then the tasks, then for what runs beside them the activities, then the
  /// tasks again.
  [[nodiscard]] static std::size_t thread_of_task(std::size_t task) { return 1 + task; }
  [[nodiscard]] std::size_t thread_beside_activity(std::size_t activity) const {
    return 1 + module->tasks.size() + activity;
  }
  [[nodiscard]] std::size_t thread_beside_task(std::size_t task) const {
    return 1 + module->tasks.size() + activities.size() + task;
  }
};

/// `types`: names of types that the package has already; those of the module are added.
/// `index`: of the module, in constraints.
[[nodiscard]] Plan make_plan(const Module& module, std::size_t index, const GenerateOptions& options, Scope& types);
/// Of all modules of a package. They point to `modules` and to the constraints of `options`.
[[nodiscard]] std::vector<Plan> make_plans(const std::vector<Module>& modules, const GenerateOptions& options);

/// The port type of what a codel answered that another atom called.
[[nodiscard]] inline const char* outcome_type(const ActivityPlan& a) {
  return a.has_turns && a.has_timed() ? "TimedOutcome" : "Outcome";
}
/// The atom of a service's or (GenoM 3) a task's codels. `service`: it is a service's. `owner`: of a task; that of an
/// activity is the atom's parameter.
void write_activity(std::string& out, const Plan& plan, const Activity& activity, const ActivityPlan& a,
                    const Service* service, const std::string& comment, std::optional<std::size_t> owner = {});
void write_service(std::string& out, const Plan& plan, std::size_t service, std::int64_t tick_us);
/// The atom in which codels run beside the task, of a service or of a task (`says` as in "Goto" or "task motion").
void write_work(std::string& out, const Plan& plan, const Activity& activity, const ActivityPlan& a,
                const std::string& type, const std::string& says, std::optional<std::size_t> owner = {});
/// What binds it to activity and controller inside the service's compound.
void write_work_wires(std::string& out, const Plan& plan, std::size_t service, std::int64_t tick_us);
void write_work_exports(std::string& out, const ServicePlan& p);
/// Codels that run in threads while the activity `component` and its task wait for them, by the atom `work`; in the
/// compound of both. They are exported with these beginnings of names.
void write_turns(std::string& out, const ActivityPlan& a, const std::string& component, const std::string& exported);
/// GenoM 2: the permanent codel of a task, in a thread, or in the step that begins a cycle.
void write_permanent(std::string& out, const Plan& plan, std::size_t task);
/// The same inside of a task's compound.
void write_task_work(std::string& out, const Plan& plan, std::size_t task);
void write_scheduler(std::string& out, const Plan& plan, std::size_t task);
void write_task(std::string& out, const Plan& plan, std::size_t task, std::int64_t tick_us);
/// A poster that holds values.
void write_poster(std::string& out, const Plan& plan, std::size_t poster);
/// A lock for so many threads: many readers or one writer.
void write_data_lock(std::string& out, std::size_t threads);
/// The message box and the compound of the control task.
void write_control(std::string& out, const Plan& plan);
void write_module(std::string& out, const Plan& plan, const GenerateOptions& options);

/// GenoM 2 does not say what a codel touches: everything.
[[nodiscard]] std::vector<DataUse> uses_of(const Module& module, const Codel& codel);
/// May a control service end with a report other than OK?
[[nodiscard]] bool control_may_fail(const Service& service);
/// The reports with which an activity may end: its service's, and those of codels in C++ that do what they may not.
[[nodiscard]] std::vector<std::string> activity_reports(const Plan& plan, const Service& service);
/// What BIP hears of a codel that threw an exception.
inline constexpr int kThrew = 203;
/// What a C++ codel returns for an answer: 0 ether, 1 + k the k-th state, 101 + k that after a pause, 201 zombie, 202
/// sleep.
[[nodiscard]] int answer_code(const Yield& answer);
/// How a state's turn is called: by its codel.
[[nodiscard]] std::string codel_label(const State& state);

}  // namespace bip::genom
