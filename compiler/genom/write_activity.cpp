// The automaton of an activity (Bensalem, de Silva, Ingrand, Yan 2011, Figure 3) as an atom: a place a state, and one
// while its codel runs.
//
//   STATE        waits for its turn            STATE_RUNS    the codel runs
//   STATE_PAUSED waits for the next cycle (3)  STATE_ENDS    it ran, its locks are given back (codel granularity)
//   LOST         given up while its codel ran beside the task; until that comes back
//   late         an event between a codel's turn and its answer, if rules ask for it: it took longer than its budget
//
// A codel that runs beside the task does so in another atom (write_work.cpp); this one waits in STATE_RUNS and can be
// told to stop. A codel may return any of its answers: there is one port per answer, and the ports that the rest of the
// module treats alike are merged.
#include <fmt/format.h>

#include <algorithm>

#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

class ActivityWriter {
 public:
  ActivityWriter(std::string& out, const Plan& plan, const Activity& activity, const ActivityPlan& a,
                 const Service* service)
      : out_(out),
        plan_(plan),
        activity_(activity),
        activity_plan_(a),
        service_(service),
        reports_(service == nullptr ? std::vector<std::string>() : activity_reports(plan, *service)),
        is_3_(plan.module->generation == 3),
        places_(a.places) {
    BIP_ASSERT(
        places_.size() == activity.states.size() && activity.start < places_.size() && activity.stop < places_.size(),
        "{} places of {} states, start {}, stop {}", places_.size(), activity.states.size(), activity.start,
        activity.stop);
  }

  void run(const std::string& comment, std::optional<std::size_t> owner) {
    owner_ = owner ? std::to_string(*owner) : "owner";
    out_ += fmt::format("\n  // {}\n  atom type {}({})\n", comment, activity_plan_.type,
                        plan_.calls && service_ != nullptr ? "int owner" : "");
    data();
    ports();
    place_line();
    out_ += fmt::format("\n    initial to {}\n", service_ != nullptr ? "ETHER" : places_[activity_.start]);
    if (service_ != nullptr) {
      out_ += fmt::format("\n    on start from ETHER to {}\n",
                          is_3_ ? places_[activity_.start] + "_PAUSED" : places_[activity_.start]);
      aborts();
    } else if (is_killed()) {
      aborts();
      if (activity_plan_.ends) on("abt", "ETHER", "ETHER");
    }
    turns();
    answers();
    rests();
    out_ += "  end\n";
  }

 private:
  [[nodiscard]] bool stoppable() const { return service_ != nullptr; }
  // A task's own codels, of a component that can be killed.
  [[nodiscard]] bool is_killed() const { return service_ == nullptr && plan_.module->is_killed; }
  [[nodiscard]] std::string ended(std::size_t i) const { return places_[i] + (leaves(i) ? "_ENDS" : "_RUNS"); }
  // Is what happens between its turn and its answer seen by others?
  [[nodiscard]] bool leaves(std::size_t i) const { return plan_.by_codel || activity_plan_.async[i]; }
  // Is its codel called by another atom while the task waits?
  [[nodiscard]] bool has_turn(std::size_t i) const { return plan_.by_codel && activity_plan_.threaded[i]; }
  // A task waits for its own codels, however long they take.
  [[nodiscard]] bool is_given_up() const { return stoppable() && activity_plan_.has_async; }
  [[nodiscard]] bool remembers() const {
    return (stoppable() || is_killed()) && (plan_.by_codel || activity_plan_.has_async);
  }

  void data() {
    if (activity_plan_.ends_not_ok) {
      for (const std::string& r : reports_) out_ += fmt::format("    data string rep_{} = \"{}\"\n", bip_name(r), r);
    }
    if (remembers()) out_ += "    data bool stopping = false\n";
    if (activity_plan_.has_timed()) out_ += "    data bool over = false\n";
    if (plan_.calls) out_ += "    data int next = 0, report = 0\n";
  }

  void port(const std::string& name) { out_ += fmt::format("    export port Signal {}()\n", name); }

  // Of several ports one; a report's port shows it.
  void merged(const std::vector<std::string>& names, const char* type, const std::string& as,
              bool with_report = false) {
    if (names.empty()) return;
    std::string list;
    for (const std::string& n : names)
      list += (list.empty() ? "" : ", ") + n +
              (with_report ? "(" + n.substr(n.find('_') + 1).insert(0, "rep_") + ")" : "()");
    out_ += fmt::format("    export port {} {}{}\n", type, list, as == names[0] ? "" : " as " + as);
  }

  [[nodiscard]] bool yields(std::size_t to, Next next) const {
    for (std::size_t i = 0; i < activity_.states.size(); ++i) {
      if (!activity_plan_.used[i]) continue;
      for (const Yield& y : activity_.states[i].yields) {
        if (y.next == next && y.state == to) return true;
      }
    }
    return false;
  }

  void ports() {
    if (stoppable()) {
      port("start");
      port("abt");
    } else if (is_killed()) {
      port("abt");
    }
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (!activity_plan_.used[i]) continue;
      port("run_" + places_[i]);
      if (activity_plan_.async[i])
        out_ += fmt::format("    export port {} back_{}({})\n", plan_.calls ? "Outcome" : "Signal", places_[i],
                            plan_.calls ? "next, report" : "");
      else if (plan_.by_codel && activity_plan_.threaded[i])
        out_ += fmt::format("    export port {} done_{}(next, report{})\n", outcome_type(activity_plan_), places_[i],
                            activity_plan_.has_timed() ? ", over" : "");
      else if (plan_.by_codel) port("done_" + places_[i]);
    }
    if (activity_plan_.has_timed()) port("late");
    if (activity_plan_.has_async) port("wait");
    if (is_given_up()) {
      port("lost");
      port("found");
    }
    if (is_3_ && (stoppable() || activity_plan_.pauses)) port("resume");
    merged(activity_plan_.to, "Signal", activity_plan_.went_on());
    merged(activity_plan_.pause, "Signal", activity_plan_.paused());
    if (activity_plan_.ends) port("ok");
    if (activity_plan_.ends_not_ok) merged(activity_plan_.report, "Report", activity_plan_.not_ok(), true);
    if (activity_plan_.ends_stopped) port("intr");
    if (activity_plan_.has_zombie) {
      port("zombie");
      port("bury");
    }
    if (activity_plan_.has_bad) port("bad");
    if (activity_plan_.rests) port("rest");
  }

  void place_line() {
    std::string list = service_ != nullptr || activity_plan_.ends ? "ETHER" : "";
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (!activity_plan_.used[i]) continue;
      list += (list.empty() ? "" : ", ") + places_[i] + ", " + places_[i] + "_RUNS";
      if (leaves(i)) list += ", " + places_[i] + "_ENDS";
      if (has_paused(i)) list += ", " + places_[i] + "_PAUSED";
    }
    if (activity_plan_.has_sleep) list += ", SLEEP";
    if (activity_plan_.has_zombie) list += ", ZOMBIE";
    if (is_given_up()) list += ", LOST";
    out_ += "\n    place " + list + "\n";
  }

  // GenoM 3: begins paused, stops paused, or somebody pauses for it.
  [[nodiscard]] bool has_paused(std::size_t i) const {
    return is_3_ && ((stoppable() && (i == activity_.start || i == activity_.stop)) ||
                     (is_killed() && activity_plan_.pauses && i == activity_.stop) || yields(i, Next::Pause));
  }

  void on(const std::string& port, const std::string& from, const std::string& to, const std::string& action = {},
          const std::string& guard = {}) {
    out_ +=
        fmt::format("    on {} from {} to {}{}{}\n", port, from, to, guard.empty() ? "" : " provided (" + guard + ")",
                    action.empty() ? "" : " do { " + action + "; }");
  }

  // Whatever it does, an aborted activity goes to its stop state: at once if it waits, else when its codel has
  // answered.
  void aborts() {
    const std::string stop = places_[activity_.stop];
    out_ += "\n    // Told to stop.\n";
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (!activity_plan_.used[i]) continue;
      on("abt", places_[i], stop);
      if (has_paused(i)) on("abt", places_[i] + "_PAUSED", stop + "_PAUSED");
      if (!leaves(i)) continue;
      const std::string remember = i == activity_.stop ? "" : "stopping = true";
      on("abt", places_[i] + "_RUNS", places_[i] + "_RUNS", remember);
      on("abt", places_[i] + "_ENDS", places_[i] + "_ENDS", remember);
    }
    if (activity_plan_.has_sleep) on("abt", "SLEEP", stop);
    if (!remembers()) return;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (!activity_plan_.used[i] || i == activity_.stop) continue;
      if (may_follow(i, Next::State))
        out_ += fmt::format("    internal from {} to {} provided (stopping) do {{ stopping = false; }}\n", places_[i],
                            stop);
      if (may_follow(i, Next::Pause))
        out_ += fmt::format("    internal from {}_PAUSED to {}_PAUSED provided (stopping) do {{ stopping = false; }}\n",
                            places_[i], stop);
    }
    if (activity_plan_.has_sleep)
      out_ += fmt::format("    internal from SLEEP to {} provided (stopping) do {{ stopping = false; }}\n", stop);
  }

  // Can a codel of a state that is not `stop` answer with it?
  [[nodiscard]] bool may_follow(std::size_t to, Next next) const {
    for (std::size_t i = 0; i < activity_.states.size(); ++i) {
      if (!activity_plan_.used[i] || i == activity_.stop) continue;
      for (const Yield& y : activity_.states[i].yields) {
        if (y.next == next && y.state == to) return true;
      }
    }
    return false;
  }

  void turns() {
    out_ += "\n    // Its turn.\n";
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (!activity_plan_.used[i]) continue;
      const Codel& codel = activity_.states[i].codel;
      const bool is_called_elsewhere = activity_plan_.async[i] || has_turn(i);
      const bool calls = plan_.calls && codel.name.is_set() && !is_called_elsewhere;
      std::string action =
          calls ? fmt::format("report = 0; next = {}({}, report)", codel_function(codel.name.text), owner_) : "";
      if (activity_plan_.timed[i]) {
        // Where nothing is called it may have been late, or not.
        action += calls ? "; over = codel_was_late() != 0" : has_turn(i) ? "" : "over = true";
        const std::string at = places_[i] + (has_turn(i) ? "_ENDS" : "_RUNS");
        on("late", at, at, "over = false", "over");
      }
      if (calls && activity_plan_.threaded[i]) out_ += "    @async\n";
      on("run_" + places_[i], places_[i], places_[i] + "_RUNS", action);
      if (leaves(i))
        on((activity_plan_.async[i] ? "back_" : "done_") + places_[i], places_[i] + "_RUNS", places_[i] + "_ENDS", {},
           is_told_first(i) && !has_turn(i) ? "!over" : "");
      if (!activity_plan_.async[i]) continue;
      on("wait", places_[i] + "_RUNS", places_[i] + "_RUNS");
      if (is_given_up()) on("lost", places_[i] + "_RUNS", "LOST", "stopping = false");
    }
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (activity_plan_.used[i] && has_paused(i)) on("resume", places_[i] + "_PAUSED", places_[i]);
    }
  }

  void answers() {
    // An end makes up for an abort that came while the last codel ran.
    const std::string forget = remembers() ? "stopping = false" : "";
    for (std::size_t i = 0; i < activity_.states.size(); ++i) {
      if (!activity_plan_.used[i]) continue;
      const State& s = activity_.states[i];
      const std::string from = ended(i);
      const bool is_stop = stoppable() && i == activity_.stop;
      const std::string clear = is_stop ? "" : forget;
      out_ += fmt::format("\n    // {}\n", s.codel.name.is_set() ? "What " + s.codel.name.text + " answers."
                                                                 : s.name.text + " has no codel.");
      const bool ends =
          std::any_of(s.yields.begin(), s.yields.end(), [](const Yield& y) { return y.next == Next::Ether; });
      const bool may_report =
          service_ != nullptr && s.codel.name.is_set() && !reports_.empty() && (is_3_ || (ends && !is_stop));
      const bool calls = plan_.calls && s.codel.name.is_set();
      const auto answers = [&](const std::string& port, const std::string& to, const std::string& action,
                               const std::string& guard) {
        const bool waits = is_told_first(i) && (!leaves(i) || has_turn(i));
        on(port, from, to, action, !waits ? guard : guard.empty() ? "!over" : "!over && (" + guard + ")");
      };
      std::string known;
      const auto when = [&](const Yield& y) {
        if (!calls) return std::string();
        if (y.next == Next::Other) return "!(" + (known.empty() ? "false" : known) + ")";
        std::string guard = fmt::format("next == {}", answer_code(y));
        // GenoM 2: what threw fails, after its codel for that if the state permits it.
        if (!is_3_ && service_ != nullptr && is_failure(s, y)) guard = fmt::format("({} || next == {})", guard, kThrew);
        // GenoM 3: an exception goes before any state.
        if (may_report && (is_3_ || y.next == Next::Ether)) guard += " && report == 0";
        known += (known.empty() ? "" : " || ") + (guard.find('&') == std::string::npos ? guard : "(" + guard + ")");
        return guard;
      };
      for (const Yield& y : s.yields) {
        if (y.next == Next::State) answers("to_" + places_[y.state], places_[y.state], {}, when(y));
        if (y.next == Next::Pause) answers("pause_" + places_[y.state], places_[y.state] + "_PAUSED", {}, when(y));
        if (y.next == Next::Sleep) answers("to_SLEEP", "SLEEP", {}, when(y));
        if (y.next == Next::Zombie) answers("zombie", "ZOMBIE", clear, when(y));
        if (y.next == Next::Ether) answers(is_stop ? "intr" : "ok", "ETHER", clear, when(y));
      }
      for (std::size_t k = 0; may_report && k < reports_.size(); ++k) {
        // Below: it is for what nothing else is.
        if (is_3_ && calls && reports_[k] == "bad_transition") continue;
        std::string guard;
        if (calls) {
          guard = is_3_ && reports_[k] == "codel_exception" ? fmt::format("next == {}", kThrew)
                  : is_3_                                   ? fmt::format("report == {}", k + 1)
                          : fmt::format("next == {} && report == {}", answer_code({Next::Ether, {}, 0}), k + 1);
          known += (known.empty() ? "" : " || ") + (is_3_ ? guard : "(" + guard + ")");
        }
        answers("report_" + bip_name(reports_[k]), "ETHER", clear, guard);
      }
      for (const Yield& y : s.yields) {
        if (y.next != Next::Other) continue;
        if (is_3_ && may_report) answers("report_bad_transition", "ETHER", clear, when(y));
        else answers("bad", places_[i], {}, when(y));
      }
    }
  }

  // In the execution flavour a late codel is reported before its answer takes effect.
  [[nodiscard]] bool is_told_first(std::size_t i) const { return plan_.calls && activity_plan_.timed[i]; }

  [[nodiscard]] bool is_failure(const State& s, const Yield& y) const {
    const auto fails = [&](const Yield& other) {
      return other.next == Next::State && activity_.states[other.state].name.text == "FAIL";
    };
    return fails(y) || (y.next == Next::Zombie && std::none_of(s.yields.begin(), s.yields.end(), fails));
  }

  // Nothing to do for it in this turn.
  void rests() {
    if (!activity_plan_.rests) return;
    out_ += "\n    // Nothing to run.\n";
    if (service_ != nullptr || activity_plan_.ends) on("rest", "ETHER", "ETHER");
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (activity_plan_.used[i] && has_paused(i)) on("rest", places_[i] + "_PAUSED", places_[i] + "_PAUSED");
    }
    if (activity_plan_.has_sleep) on("rest", "SLEEP", "SLEEP");
    if (is_given_up()) {
      on("rest", "LOST", "LOST");
      on("found", "LOST", "ETHER");
    }
    if (activity_plan_.has_zombie) {
      on("rest", "ZOMBIE", "ZOMBIE");
      on("bury", "ZOMBIE", "ETHER");
    }
  }

  std::string& out_;
  const Plan& plan_;
  const Activity& activity_;
  const ActivityPlan& activity_plan_;
  const Service* service_;
  std::string owner_;
  std::vector<std::string> reports_;
  bool is_3_;
  const std::vector<std::string>& places_;
};

}  // namespace

void write_activity(std::string& out, const Plan& plan, const Activity& activity, const ActivityPlan& a,
                    const Service* service, const std::string& comment, std::optional<std::size_t> owner) {
  ActivityWriter(out, plan, activity, a, service).run(comment, owner);
}

}  // namespace bip::genom
