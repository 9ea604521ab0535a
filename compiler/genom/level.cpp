// Writes the functional level, module by module: who may request, which requests are accepted, rejected, stopped and
// begun; then time.
//
// A request is decided at the place `okay` (compiler/docs/genom.md): either `allow` and the interruptions happen, or a
// `reject` does; their guards exclude each other. Activities that a rule stops are stopped before time passes.
#include "compiler/genom/level.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "compiler/genom/codels.hpp"
#include "compiler/genom/level_condition.hpp"
#include "compiler/genom/wires.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

class LevelWriter {
 public:
  LevelWriter(std::string& out, const std::vector<Plan>& plans, const GenerateOptions& options, std::int64_t tick_us)
      : out_(out),
        plans_(plans),
        constraints_(options.constraints),
        options_(options),
        tick_us_(tick_us),
        names_(level_scope()),
        conditions_(plans, options, parts_, tick_us) {}

  /// Returns what may be asked for, by module.
  std::vector<std::vector<RequestSpec>> run() {
    out_ += "\n  // All modules, the token for triggers, and the clock.\n  compound type FunctionalLevel()\n";
    for (const Plan& p : plans_) {
      BIP_ASSERT(p.posters.size() == p.module->posters.size(), "{} posters of `{}` have {} names",
                 p.module->posters.size(), p.component, p.posters.size());
      out_ += fmt::format("    @SuppressWarning(unboundcomponentport)\n    component {} {}()\n", p.type, p.component);
      names_.claim(p.component, "");
      for (std::size_t i = 0; i < p.posters.size(); ++i)
        posters_[p.module->name.text + "." + p.module->posters[i].name.text] = p.component + ".read_" + p.posters[i];
    }
    sync_ = names_.claim("InterModuleSync", "event");
    out_ += "    @SuppressWarning(unboundcomponentport)\n    component Semaphore semaphore()\n";
    out_ += is_clocked() ? fmt::format("    component MasterClock masterTimer({})\n", tick_us_)
                         : "    component MasterTimer masterTimer()\n";
    executives();
    parts();
    for (std::size_t m = 0; m < plans_.size(); ++m) module(m);
    whens();
    time();
    out_ += priorities_.empty() ? "" : "\n";
    for (const auto& [low, high] : priorities_)
      out_ += fmt::format("    priority {} {}:* < {}:*\n", names_.claim("first_" + high, "rule"), low, high);
    promises();
    out_ += "  end\n";
    return std::move(requests_);
  }

 private:
  // Under its own name, or with a suffix if that is taken.
  std::string wire(Wire w, const std::string& suffix = "event") {
    w.name = names_.claim(w.name, suffix);
    write_wire(out_, w);
    return w.name;
  }
  // Requests bring values of their own, not only those that rules list for verification.
  [[nodiscard]] bool has_any_value() const { return options_.executive != Executive::Anybody; }
  [[nodiscard]] bool is_served() const { return options_.executive == Executive::Served; }
  // What a codel takes of time needs a clock beside it.
  [[nodiscard]] bool is_clocked() const {
    return is_served() ||
           (options_.flavour == Flavour::Execution &&
            std::any_of(plans_.begin(), plans_.end(), [](const Plan& p) { return p.module->has_async(); }));
  }
  [[nodiscard]] const Plan& plan(ServiceRef s) const { return plans_[s.module]; }
  [[nodiscard]] std::string name_of(ServiceRef s) const {
    BIP_ASSERT(s.module < plans_.size() && s.service < plan(s).services.size(), "service {} of module {}", s.service,
               s.module);
    return plan(s).component + "_" + plan(s).services[s.service].id;
  }
  [[nodiscard]] std::vector<std::string> of_activities(ServiceRef s, const char* port) const {
    std::vector<std::string> all;
    for (const std::size_t activity : plan(s).services[s.service].activities)
      all.push_back(fmt::format("{}.{}_{}", plan(s).component, port, plan(s).activities[activity].component));
    return all;
  }

  // Who asks, by module: one for all, or a mailbox each.
  void executives() {
    if (options_.executive == Executive::Anybody) return;
    std::string executive;
    for (std::size_t m = 0; m < plans_.size(); ++m) {
      requests_.push_back(request_specs_of(plans_[m], m, constraints_));
      if (is_served()) {
        executives_.push_back(names_.claim(plans_[m].component + "_mail", "part"));
        const std::string patience =
            plans_[m].has_patient_mailbox() ? "" : std::to_string(100 + 2 * options_.control_period);
        out_ += fmt::format("    @SuppressWarning(unboundcomponentport)\n    component {} {}({})\n",
                            plans_[m].mailbox_type, executives_.back(), patience);
        continue;
      }
      if (executive.empty()) {
        executive = names_.claim("executive", "part");
        out_ += fmt::format("    component Executive {}()\n", executive);
      }
      executives_.push_back(executive);
    }
  }

  // What rules remember.
  void parts() {
    // Parameters come with requests although no rule asks for them; what is remembered stays where a rule is left out
    // (--prove).
    if (!constraints_.has_parts()) return;
    out_ += "\n    // What the rules remember.\n";
    const auto component = [&](const std::string& wanted, const std::string& type, const std::string& arguments) {
      const std::string name = names_.claim(wanted, "part");
      out_ +=
          fmt::format("    @SuppressWarning(unboundcomponentport)\n    component {} {}({})\n", type, name, arguments);
      return name;
    };
    for (const ParameterRow& p : constraints_.parameters) {
      BIP_ASSERT(!p.values.empty(), "parameter `{}` has no values", p.name);
      parts_.parameters.push_back(
          component(name_of(p.service) + "_" + bip_name(p.name),
                    p.type == ValueType::Text ? "TextParameter"
                    : has_any_value()         ? "FractionParameter"
                                              : "NumberParameter",
                    p.type == ValueType::Float && !has_any_value() ? ten_thousandths(p.values[0]) : p.values[0]));
    }
    for (const StopwatchRow& w : constraints_.stopwatches) {
      const std::int64_t limit = conditions_.ticks(w.limit);
      parts_.stopwatches.push_back(
          component(name_of(w.service) + (w.counts_active ? "_takes" : "_since"), "Stopwatch",
                    fmt::format("{}, {}, {}", limit, w.counts_active, w.counts_active ? 0 : limit)));
    }
    for (const SuccessRow& s : constraints_.successes) {
      const std::int64_t limit = s.within ? conditions_.ticks(*s.within) : 0;
      parts_.successes.push_back(component(name_of(s.service) + "_succeeded", "Success", std::to_string(limit)));
    }
    for (const PairRow& p : constraints_.pairs)
      parts_.pairs.push_back(component(fmt::format("{}_then_{}", name_of(p.first), name_of(p.second)), "Pair", ""));
    for (const SilenceRow& s : constraints_.silences) {
      const std::string of = s.module ? plans_[*s.module].component : "decisional_level";
      parts_.silences.push_back(component(of + "_silence", "Silence", std::to_string(conditions_.ticks(s.limit))));
    }
    for (const FailureRow& f : constraints_.failures) {
      const char* const how = f.kind == FailureKind::Lost ? "_lost" : f.kind == FailureKind::Late ? "_late" : "_failed";
      parts_.failures.push_back(component(name_of(f.service) + how, "Failure", ""));
    }
    std::map<std::pair<std::string, ServiceRef>, std::string> known;
    for (const Constraint& row : constraints_.rows) {
      parts_.edges.push_back(row.kind == ConstraintKind::When ? component(row.name + "_edge", "Edge", "") : "");
      std::string& recovery = parts_.recoveries.emplace_back();
      if (!row.recovery) continue;
      std::string& part = known[{row.name, *row.recovery}];
      if (part.empty()) part = component("after_" + row.name, "Recovery", "");
      recovery = part;
    }
  }

  void module(std::size_t m) {
    const Plan& p = plans_[m];
    const std::string prefix = p.component + ".";
    out_ += fmt::format("\n    // {}: a request takes the semaphore{}; what no rule is about is free.\n",
                        p.module->name.text, p.takes_semaphore_to_decide() ? " when it is decided" : "");
    std::vector<std::string> reads;
    for (std::size_t i = 0; i < p.services.size(); ++i) service({m, i}, reads);
    if (p.execution_activities > 0) {
      Wire abort{.name = p.component + "_read_Abort", .ports = {prefix + "read_Abort"}};
      takes_to_read(abort.ports, m);
      asks(abort, m, p.services.size());
      hears(abort, m);
      if (is_served())
        abort.action += fmt::format("; {}.activity <- request_word({}.ask.due, 0)", abort.ports[0], executives_[m]);
      reads.push_back(wire(std::move(abort)));
    }
    recoveries(m, reads);
    if (is_served()) {
      wire({.name = p.component + "_woken", .ports = {prefix + "woken", executives_[m] + ".waits"}});
      wire({.name = p.component + "_told", .ports = {prefix + "told", executives_[m] + ".told"}});
    }
    if (!executives_.empty()) {
      // What is asked for is not left for the next cycle.
      const std::string none = wire({.name = p.component + "_none", .ports = {prefix + "none"}});
      for (const std::string& read : reads) priorities_.emplace_back(none, read);
    }
    if (p.is_on_demand()) demands(m);
    if (p.is_launched_by_rules) launches(m);
    if (!p.takes_semaphore_to_decide())
      wire({.name = p.component + "_give", .ports = {prefix + "give", "semaphore.give"}});
    for (std::size_t i = 0; i < p.tasks.size(); ++i) {
      const Task& t = p.module->tasks[i];
      if (!t.has_permanent() && t.reads.empty()) continue;
      BIP_ASSERT(t.freshness.size() == t.reads.size(), "{} posters are read, {} have an age", t.reads.size(),
                 t.freshness.size());
      std::vector<std::string> ports{prefix + "begin_" + p.tasks[i].component};
      std::string guard;
      for (const Name& read : t.reads) {
        const auto poster = posters_.find(read.text);
        if (poster == posters_.end()) continue;
        add_port(ports, poster->second);
        if (const std::int64_t age = t.freshness[static_cast<std::size_t>(&read - t.reads.data())]; age > 0)
          guard += fmt::format("{}{}.PosterAge < {}", guard.empty() ? "" : " && ", poster->second, age);
      }
      for (const char* how : {"begin_", "permanent_"}) {
        if (how != std::string("begin_") && !p.has_permanent_cycle(i)) continue;
        ports[0] = prefix + how + p.tasks[i].component;
        const std::string begin = wire(
            {.name = fmt::format("{}_{}{}", p.component, how, p.tasks[i].component), .ports = ports, .guard = guard});
        for (const auto& [s, stop] : stops_) {
          if (s.module == m && p.module->services[s.service].task_index == i) priorities_.emplace_back(begin, stop);
        }
      }
    }
  }

  // In the order of a control cycle: asked for, rejected or allowed, accepted; then told to stop.
  void service(ServiceRef s, std::vector<std::string>& reads) {
    const std::string port = plan(s).component + ".";
    const std::string& id = plan(s).services[s.service].id;
    requests(s, port + "read_" + id, reads);
    decide(s, port);
    std::vector<std::string> trig{port + "trig_" + id};
    if (plan(s).takes_semaphore_to_decide()) trig.push_back("semaphore.give");
    for (std::size_t i = 0; i < constraints_.parameters.size(); ++i) {
      if (constraints_.parameters[i].service == s) trig.push_back(parts_.parameters[i] + ".accept");
    }
    for (std::size_t i = 0; i < constraints_.stopwatches.size(); ++i) {
      if (constraints_.stopwatches[i].service == s) trig.push_back(parts_.stopwatches[i] + ".restart");
    }
    for (std::size_t i = 0; i < constraints_.pairs.size(); ++i) {
      if (constraints_.pairs[i].first == s) trig.push_back(parts_.pairs[i] + ".first");
      if (constraints_.pairs[i].second == s && constraints_.pairs[i].first != s)
        trig.push_back(parts_.pairs[i] + ".second");
    }
    for (std::size_t i = 0; i < constraints_.successes.size(); ++i) {
      if (constraints_.successes[i].since == s) trig.push_back(parts_.successes[i] + ".forget");
    }
    // The input of a refused request is given to no codel.
    std::string action;
    if (is_served()) {
      trig.push_back(executives_[s.module] + "." + requests_[s.module][s.service].event);
      action = fmt::format("if ({0}.asked != \"\") then {1}({0}.asked, {0}.asked_input); fi", trig.back(),
                           request_function(options_, "input"));
    }
    for (std::size_t i = 0; i < constraints_.failures.size(); ++i) {
      if (constraints_.failures[i].service == s) trig.push_back(parts_.failures[i] + ".forget");
    }
    trigs_[s] = wire({.name = plan(s).component + "_trig_" + id, .ports = trig, .action = action});
    if (plan(s).services[s.service].is_heard) successes(s);
    failures(s);
    for (std::size_t row = 0; row < constraints_.rows.size(); ++row) {
      if (constraints_.rows[row].kind == ConstraintKind::Keep && constraints_.rows[row].subject == s) stop(row);
    }
  }

  void takes_to_read(std::vector<std::string>& ports, std::size_t module) const {
    if (!plans_[module].takes_semaphore_to_decide()) ports.push_back("semaphore.take");
  }

  // Whoever counts from its last success hears of it.
  void successes(ServiceRef s) {
    if (plan(s).module->services[s.service].kind == ServiceKind::Execution &&
        !plan(s).services[s.service].activity.ends)
      return;
    for (const std::string& fin : of_activities(s, "fin")) {
      BIP_ASSERT(fin.find(".fin_") != std::string::npos, "`{}` is no port `fin`", fin);
      std::vector<std::string> ports{fin};
      for (std::size_t i = 0; i < constraints_.successes.size(); ++i) {
        if (constraints_.successes[i].service == s) ports.push_back(parts_.successes[i] + ".ended");
      }
      std::string name = fin;
      name.replace(name.find(".fin_"), 5, "_fin_");
      wire({.name = name, .ports = ports});
    }
  }

  // Failure atoms of the service take part in each end that is neither a success nor an interruption, and hear of
  // codels that were late before time goes on.
  void failures(ServiceRef s) {
    const ServicePlan& p = plan(s).services[s.service];
    const Service& service = plan(s).module->services[s.service];
    const bool is_control = service.kind == ServiceKind::Control;
    struct End {
      const char* port;
      bool is_possible;
      std::vector<FailureKind> kinds;
    };
    using enum FailureKind;
    for (const End& end :
         {End{"nofin", is_control ? control_may_fail(service) : p.activity.ends_not_ok, {Failed}},
          End{"fail", p.activity.has_zombie, {Failed}}, End{"lost", p.activity.has_async, {Failed, Lost, Late}},
          End{"late", p.activity.has_timed(), {Late}}}) {
      std::vector<std::string> ended;
      for (std::size_t i = 0; i < constraints_.failures.size(); ++i) {
        const FailureRow& row = constraints_.failures[i];
        if (row.service == s && std::find(end.kinds.begin(), end.kinds.end(), row.kind) != end.kinds.end())
          ended.push_back(parts_.failures[i] + ".ended");
      }
      if (ended.empty() || !end.is_possible) continue;
      for (const std::size_t activity : p.activities) {
        const std::string& name = plan(s).activities[activity].component;
        std::vector<std::string> ports{fmt::format("{}.{}_{}", plan(s).component, end.port, name)};
        ports.insert(ports.end(), ended.begin(), ended.end());
        const std::string heard =
            wire({.name = fmt::format("{}_{}_{}", plan(s).component, end.port, name), .ports = ports});
        if (end.kinds.front() == Late) priorities_.emplace_back(sync_, heard);
      }
    }
  }

  // A request ends the silence of its module.
  void hears(Wire& w, std::size_t module) const {
    for (std::size_t i = 0; i < constraints_.silences.size(); ++i) {
      if (constraints_.silences[i].module.value_or(module) == module) w.ports.push_back(parts_.silences[i] + ".heard");
    }
  }

  // One connector; without an executive one a value of its parameters.
  void requests(ServiceRef s, const std::string& read, std::vector<std::string>& reads) {
    const std::string name = plan(s).component + "_read_" + plan(s).services[s.service].id;
    std::vector<Wire> wires{{.name = name, .ports = {read}}};
    takes_to_read(wires[0].ports, s.module);
    if (has_any_value()) asks(wires[0], s.module, s.service);
    hears(wires[0], s.module);
    std::size_t k = 0;
    for (std::size_t i = 0; i < constraints_.parameters.size(); ++i) {
      const ParameterRow& p = constraints_.parameters[i];
      if (p.service != s) continue;
      if (has_any_value()) brings(wires[0], s, i, k++);
      else wires = with_each_value(wires, i);
    }
    for (Wire& w : wires) reads.push_back(wire(std::move(w)));
  }

  // Parameter `row` is value `k` of the request.
  void brings(Wire& w, ServiceRef s, std::size_t row, std::size_t k) {
    BIP_ASSERT(row < parts_.parameters.size() && constraints_.parameters[row].service == s,
               "parameter {} is brought by service {}, which does not have it", row, s.service);
    w.ports.push_back(parts_.parameters[row] + ".set");
    w.action +=
        fmt::format("{}{}.set.asked <- {}({}.ask.due, {})", w.action.empty() ? "" : "; ", parts_.parameters[row],
                    constraints_.parameters[row].type == ValueType::Text ? "request_word" : "request_number",
                    executives_[s.module], k);
  }

  [[nodiscard]] std::vector<Wire> with_each_value(const std::vector<Wire>& wires, std::size_t row) const {
    const ParameterRow& p = constraints_.parameters[row];
    std::vector<Wire> more;
    for (const Wire& w : wires) {
      for (const std::string& value : p.values) {
        Wire next = w;
        std::string bare = p.type == ValueType::Text ? value.substr(1, value.size() - 2) : value;
        if (p.type != ValueType::Text && bare.starts_with('-')) bare.replace(0, 1, "minus_");
        next.name = bip_name(fmt::format("{}_{}_{}", next.name, p.name, bare));
        next.ports.push_back(parts_.parameters[row] + ".set");
        next.action += fmt::format("{}{}.set.asked <- {}", next.action.empty() ? "" : "; ", parts_.parameters[row],
                                   p.type == ValueType::Float ? ten_thousandths(value) : value);
        more.push_back(std::move(next));
      }
    }
    return more;
  }

  // Only if the executive says so.
  void asks(Wire& w, std::size_t module, std::size_t request) {
    if (executives_.empty()) return;
    const std::string& executive = executives_[module];
    BIP_ASSERT(request < requests_[module].size(), "request {} of {}", request, requests_[module].size());
    w.ports.push_back(executive + ".ask");
    w.guard = fmt::format("{}.ask.due_service == \"{}\"", executive, requests_[module][request].text);
    if (is_served())
      w.action = fmt::format("{1}({0}.ask.due, {0}.ask.due_input)", executive, request_function(options_, "asked"));
  }

  // Either every rule allows it, or one rejects it; then what it interrupts is told.
  void decide(ServiceRef s, const std::string& port) {
    const std::string& id = plan(s).services[s.service].id;
    std::vector<std::string> ports{port + "allow_" + id};
    std::string guard;
    for (std::size_t row = 0; row < constraints_.rows.size(); ++row) {
      const Constraint& c = constraints_.rows[row];
      if (c.subject != s || c.kind != ConstraintKind::Admit) continue;
      reject(row);
      std::string condition = conditions_.text(c.condition, ports);
      if (c.condition.kind == ConditionKind::Operator) condition = "(" + condition + ")";
      guard += (guard.empty() ? "" : " && ") + condition;
    }
    const bool is_decided = !guard.empty();
    const bool takes = plan(s).takes_semaphore_to_decide();
    if (is_decided && takes) ports.push_back("semaphore.take");
    if (is_decided) wire({.name = plan(s).component + "_allow_" + id, .ports = ports, .guard = guard});
    ports = {port + "abtInc_" + id};
    if (!is_decided && takes) ports.push_back("semaphore.take");
    const std::size_t needed = ports.size();
    for (const Constraint& c : constraints_.rows) {
      if (c.subject == s && c.kind == ConstraintKind::Interrupt && !waits_already(c)) tell(c, ports);
    }
    wire({.name = plan(s).component + "_abtInc_" + id, .ports = ports, .triggers = ports.size() > needed ? needed : 0});
  }

  void reject(std::size_t row) {
    BIP_ASSERT(constraints_.rows[row].kind == ConstraintKind::Admit, "rule {} rejects, and is of kind {}", row,
               constraints_.rows[row].kind);
    const Constraint& c = constraints_.rows[row];
    out_ += fmt::format("\n    // {}", c.text);
    const std::string rejected =
        fmt::format("{}.rej_{}", plan(c.subject).component, plan(c.subject).services[c.subject.service].id);
    std::vector<std::string> ports{rejected};
    const Condition violated = negated(c.condition);
    const std::string guard = conditions_.text(violated, ports);
    if (c.recovery) ports.push_back(parts_.recoveries[row] + ".call");
    wire({.name = fmt::format("{}_reject_{}", plan(c.subject).component, c.name),
          .ports = ports,
          .guard = guard,
          .action = fmt::format("{}.rep <- \"{}\"", rejected, c.report)},
         plan(c.subject).services[c.subject.service].id);
  }

  static Condition negated(const Condition& of) {
    BIP_ASSERT(of.kind != ConditionKind::Not || of.operands.size() == 1, "`not` has {} operands", of.operands.size());
    if (of.kind == ConditionKind::Not) return of.operands[0];
    Condition c;
    c.kind = ConditionKind::Not;
    c.operands.push_back(of);
    return c;
  }

  // A connector each that carries the report, and joins the interruption if there is something to stop.
  void tell(const Constraint& c, std::vector<std::string>& told) {
    for (const std::string& halt : of_activities(c.other, "halt")) {
      BIP_ASSERT(halt.find(".halt_") != std::string::npos, "`{}` is no port `halt`", halt);
      std::string wanted = fmt::format("{}_tells_{}", name_of(c.subject), halt);
      wanted.replace(wanted.find(".halt_"), 6, "_");
      if (std::find(told.begin(), told.end(), wanted + ".out") != told.end()) continue;
      out_ += fmt::format("\n    // {}", c.text);
      told.push_back(wire({.name = wanted,
                           .ports = {halt},
                           .action = fmt::format("{}.rep <- \"{}\"", halt, c.report),
                           .exported = true}) +
                     ".out");
    }
  }

  void stop(std::size_t row) {
    BIP_ASSERT(constraints_.rows[row].kind == ConstraintKind::Keep, "rule {} stops, and is of kind {}", row,
               constraints_.rows[row].kind);
    const Constraint& c = constraints_.rows[row];
    for (const std::string& halt : of_activities(c.subject, "halt")) {
      out_ += fmt::format("\n    // {}", c.text);
      std::vector<std::string> ports{halt};
      const std::string guard = conditions_.text(negated(c.condition), ports);
      if (c.recovery) ports.push_back(parts_.recoveries[row] + ".call");
      const std::string name = wire({.name = fmt::format("{}_stop_{}", plan(c.subject).component, c.name),
                                     .ports = ports,
                                     .guard = guard,
                                     .action = fmt::format("{}.rep <- \"{}\"", halt, c.report)},
                                    plan(c.subject).services[c.subject.service].id);
      stops_.emplace_back(c.subject, name);
      priorities_.emplace_back(sync_, name);
    }
  }

  // What begins a control cycle of a module beside what its own activities and tasks want: a request to it that waits,
  // and each recovery that it begins.
  void demands(std::size_t m) {
    const Plan& p = plans_[m];
    const std::string chck = p.component + ".chck";
    const std::string pending = executives_[m] + ".pending";
    wire({.name = p.component + "_chck",
          .ports = {chck, pending},
          .guard = is_served() ? "" : fmt::format("{}.due_module == \"{}\"", pending, p.module->name.text)});
    std::vector<std::string> done;
    for (std::size_t row = 0; row < constraints_.rows.size(); ++row) {
      const Constraint& c = constraints_.rows[row];
      const std::string& recovery = parts_.recoveries[row];
      if (!c.recovery || c.recovery->module != m || std::find(done.begin(), done.end(), recovery) != done.end())
        continue;
      done.push_back(recovery);
      wire({.name = fmt::format("{}_chck_{}", p.component, c.name), .ports = {chck, recovery + ".due"}});
    }
  }

  // What is to be done after a violation comes before any other request to its module.
  void recoveries(std::size_t m, const std::vector<std::string>& reads) {
    std::vector<std::string> done;
    for (std::size_t row = 0; row < constraints_.rows.size(); ++row) {
      const Constraint& c = constraints_.rows[row];
      if (!c.recovery || c.recovery->module != m ||
          std::find(done.begin(), done.end(), parts_.recoveries[row]) != done.end())
        continue;
      done.push_back(parts_.recoveries[row]);
      const Plan& p = plans_[m];
      std::vector<std::string> ports{fmt::format("{}.read_{}", p.component, p.services[c.recovery->service].id)};
      takes_to_read(ports, m);
      ports.push_back(parts_.recoveries[row] + ".run");
      if (is_served()) ports.push_back(executives_[m] + ".recover");
      const std::string name = wire({.name = fmt::format("{}_recover_{}", p.component, c.name), .ports = ports});
      for (const std::string& read : reads) priorities_.emplace_back(read, name);
    }
  }

  // A condition that becomes true is seen before time goes on, and before the service is accepted again whose failure
  // it is about.
  void whens() {
    for (std::size_t row = 0; row < constraints_.rows.size(); ++row) {
      const Constraint& c = constraints_.rows[row];
      if (c.kind != ConstraintKind::When) continue;
      out_ += fmt::format("\n    // {}", c.text);
      const std::string rise = parts_.edges[row] + ".rise";
      BIP_ASSERT(!parts_.edges[row].empty() && !parts_.recoveries[row].empty(), "rule {} has no edge or no recovery",
                 row);
      std::vector<std::string> ports{rise, parts_.recoveries[row] + ".call"};
      std::string guard = conditions_.text(c.condition, ports);
      const std::string name = wire({.name = "when_" + c.name,
                                     .ports = ports,
                                     .guard = guard,
                                     .action = fmt::format("{}.rep <- \"{}\"", rise, c.report)});
      ports = {parts_.edges[row] + ".fall"};
      guard = conditions_.text(negated(c.condition), ports);
      const std::string over = wire({.name = "when_" + c.name + "_over", .ports = ports, .guard = guard});
      for (const std::string& edge : {name, over}) priorities_.emplace_back(sync_, edge);
      std::vector<std::string> again;
      acceptances(c.condition, again);
      for (const std::string& trig : again) priorities_.emplace_back(trig, name);
    }
  }

  // The connectors that accept a service of whose failure a condition speaks.
  void acceptances(const Condition& c, std::vector<std::string>& into) const {
    if (c.kind == ConditionKind::Failed) add_port(into, trigs_.at(constraints_.failures[c.row].service));
    for (const Condition& operand : c.operands) acceptances(operand, into);
  }

  // Accepted activities begin in activity order, before the control cycle ends, when those that rules name do not run.
  void launches(std::size_t m) {
    const Plan& p = plans_[m];
    std::vector<std::string> all;
    for (std::size_t k = 0; k < p.activities.size(); ++k) {
      if (p.service_of(k).kind != ServiceKind::Execution) continue;
      std::vector<std::string> ports{fmt::format("{}.launch_{}", p.component, p.activities[k].component)};
      for (const Constraint& c : constraints_.rows) {
        if (c.kind != ConstraintKind::Wait || c.subject != ServiceRef{m, p.activities[k].service} || waits_already(c))
          continue;
        for (const std::string& idle : of_activities(c.other, "idle")) add_port(ports, idle);
      }
      all.push_back(
          wire({.name = fmt::format("{}_launch_{}", p.component, p.activities[k].component), .ports = ports}));
    }
    all.push_back(wire({.name = p.component + "_done", .ports = {p.component + ".done"}}));
    for (std::size_t k = 0; k + 1 < all.size(); ++k) priorities_.emplace_back(all[k + 1], all[k]);
  }

  // The module's own list of what a service interrupts says the same.
  [[nodiscard]] bool waits_already(const Constraint& c) const {
    if (c.subject.module != c.other.module) return false;
    const std::vector<std::size_t>& interrupted = plan(c.subject).module->services[c.subject.service].interrupted;
    return std::find(interrupted.begin(), interrupted.end(), c.other.service) != interrupted.end();
  }

  void time() {
    std::vector<std::string> ports{"masterTimer.tick"};
    std::string action;
    for (const Plan& p : plans_) ports.push_back(p.component + ".moduleTick");
    for (const std::string& executive : executives_) add_port(ports, executive + ".tick");
    for (std::size_t i = 0; i < constraints_.stopwatches.size(); ++i) {
      const std::string tick = parts_.stopwatches[i] + ".tick";
      ports.push_back(tick);
      std::string active;
      for (const std::string& stat : conditions_.stats(constraints_.stopwatches[i].service)) {
        add_port(ports, stat);
        active += (active.empty() ? "" : " || ") + stat + ".active";
      }
      action += fmt::format("{}{}.running <- {}", action.empty() ? "" : "; ", tick, active);
    }
    for (std::size_t i = 0; i < constraints_.successes.size(); ++i) {
      if (constraints_.successes[i].within) ports.push_back(parts_.successes[i] + ".tick");
    }
    for (const std::string& silence : parts_.silences) ports.push_back(silence + ".tick");
    write_wire(out_, {.name = sync_, .ports = ports, .action = action});
  }

  // For `bipc verify`, which is not asked about programs.
  void promises() {
    if (constraints_.promises.empty() || options_.flavour == Flavour::Execution) return;
    out_ += "\n    // What the rules promise.\n";
    for (const PromiseRow& p : constraints_.promises)
      out_ += fmt::format("    property {} {{ {} {} }}\n", names_.claim(p.name, "promise"),
                          p.is_never ? "never" : "always", conditions_.property(p.condition));
  }

  std::string& out_;
  const std::vector<Plan>& plans_;
  const Constraints& constraints_;
  const GenerateOptions& options_;
  std::int64_t tick_us_;
  LevelParts parts_;
  std::vector<std::string> executives_;  // by module
  std::string sync_;
  std::vector<std::vector<RequestSpec>> requests_;  // by module, in the order of its services, then Abort
  Scope names_;
  ConditionWriter conditions_;
  std::map<std::string, std::string> posters_;
  std::vector<std::pair<ServiceRef, std::string>> stops_;
  std::map<ServiceRef, std::string> trigs_;
  std::vector<std::pair<std::string, std::string>> priorities_;
};

}  // namespace

Scope level_scope() {
  Scope names;
  for (const char* own : {"semaphore", "masterTimer"}) names.claim(own, "");
  return names;
}

std::vector<std::vector<RequestSpec>> write_level(std::string& out, const std::vector<Plan>& plans,
                                                  const GenerateOptions& options, std::int64_t tick_us) {
  return LevelWriter(out, plans, options, tick_us).run();
}

}  // namespace bip::genom
