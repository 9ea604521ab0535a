// See reduce.hpp. Maps old references to new ones, in the order of the rows.
#include "compiler/rules/reduce.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "runtime/include/bip/assert.hpp"

namespace bip::rules {
namespace {

using genom::Condition;
using genom::Module;
using genom::ServiceRef;

constexpr std::int64_t kTick = 10000;

class Reducer {
 public:
  Reducer(const std::vector<Module>& modules, const genom::Constraints& constraints) : old_(modules) {
    out_.constraints = constraints;
  }

  Reduced run() {
    genom::Constraints& c = out_.constraints;
    for (genom::Constraint& row : c.rows) {
      if (row.kind != genom::ConstraintKind::When) service(row.subject);
      if (row.kind == genom::ConstraintKind::Interrupt || row.kind == genom::ConstraintKind::Wait) service(row.other);
      if (row.recovery) service(*row.recovery);
      condition(row.condition);
    }
    for (genom::PromiseRow& p : c.promises) condition(p.condition);
    for (genom::ParameterRow& p : c.parameters) service(p.service);
    for (genom::StopwatchRow& w : c.stopwatches) {
      service(w.service);
      w.limit = {2, true};
    }
    for (genom::PairRow& p : c.pairs) {
      service(p.first);
      service(p.second);
    }
    for (genom::SuccessRow& s : c.successes) {
      service(s.service);
      if (s.since) service(*s.since);
      if (s.within) s.within = genom::Span{2, true};
    }
    for (genom::ValueRow& v : c.values) poster(v.poster);
    for (genom::SilenceRow& s : c.silences) silence(s);
    for (genom::FailureRow& f : c.failures) failure(f);
    for (genom::TaskRef& t : c.watched_tasks) task(t);
    BIP_ASSERT(out_.modules.size() == modules_.size(), "{} modules of {}", out_.modules.size(), modules_.size());
    for (const genom::Constraint& row : c.rows) out_.names.push_back(row.subject);
    return std::move(out_);
  }

 private:
  Module& module(std::size_t& index) {
    const auto [it, is_new] = modules_.emplace(index, out_.modules.size());
    if (is_new) {
      Module m;
      m.name.text = fmt::format("m{}", out_.modules.size());
      m.generation = 2;
      m.tick_us = kTick;
      // It has always something to do, and what it writes, if it likes, it writes then.
      genom::Task t;
      t.name.text = "task";
      t.period_us = kTick;
      t.permanent.name.text = "cycle";
      t.permanent_fails = false;
      m.tasks.push_back(std::move(t));
      out_.modules.push_back(std::move(m));
    }
    index = it->second;
    return out_.modules[index];
  }

  void service(ServiceRef& s) {
    BIP_ASSERT(s.module < old_.size() && s.service < old_[s.module].services.size(), "service {} of module {}",
               s.service, s.module);
    const ServiceRef was = s;
    if (const auto known = services_.find(was); known != services_.end()) {
      s = known->second;
      return;
    }
    Module& m = module(s.module);
    s.service = m.services.size();
    services_.emplace(was, s);
    genom::Service reduced;
    reduced.name.text = fmt::format("s{}", s.service);
    reduced.kind = old_[was.module].services[was.service].kind;
    if (reduced.kind == genom::ServiceKind::Execution) {
      // It runs, and ends when it likes, well or not.
      genom::State run{.name = {"EXEC", {}},
                       .codel = {{"run", {}}, {}},
                       .yields = {{genom::Next::State, {}, 0}, {genom::Next::Ether, {}, 0}}};
      genom::State stop{.name = {"INTER", {}}, .codel = {{"stop", {}}, {}}, .yields = {{genom::Next::Ether, {}, 0}}};
      reduced.activity = {{std::move(run), std::move(stop)}, 0, 1};
      reduced.reports.push_back({"FAILED", {}});
    }
    m.services.push_back(std::move(reduced));
  }

  // Something may be requested of the module that no rule is about.
  void silence(genom::SilenceRow& s) {
    s.limit = {2, true};
    if (s.module) module(*s.module);
    BIP_ASSERT(!out_.modules.empty(), "a silence, and nothing that could break it");
    std::vector<genom::Service>& services = out_.modules[s.module.value_or(0)].services;
    if (std::any_of(services.begin(), services.end(), [](const genom::Service& o) { return o.name.text == "free"; }))
      return;
    services.emplace_back().name.text = "free";
  }

  // It may end so: with its own report, as every reduced activity does, and with a codel that is given up.
  void failure(genom::FailureRow& f) {
    service(f.service);
    genom::Service& s = out_.modules[f.service.module].services[f.service.service];
    if (s.kind == genom::ServiceKind::Control) {
      if (s.body.empty()) s.body.push_back({{"run", {}}, {}});
    } else if (f.kind != genom::FailureKind::Failed) {
      BIP_ASSERT(!s.activity.states.empty(), "the activity `{}` has no state", s.name.text);
      genom::Codel& run = s.activity.states[0].codel;
      run.is_async = run.is_async || f.kind == genom::FailureKind::Lost;
      run.budget_us = kTick;
    }
  }

  // It may take more than its period, whatever else the module does.
  void task(genom::TaskRef& t) {
    BIP_ASSERT(t.module < old_.size() && t.task < old_[t.module].tasks.size(), "task {} of module {}", t.task,
               t.module);
    Module& m = module(t.module);
    t.task = m.tasks.size();
    genom::Task watched = m.tasks[0];
    watched.name.text = fmt::format("task{}", t.task);
    m.tasks.push_back(std::move(watched));
  }

  void poster(genom::PosterRef& p) {
    BIP_ASSERT(p.module < old_.size() && p.poster < old_[p.module].posters.size(), "poster {} of module {}", p.poster,
               p.module);
    const auto was = std::pair(p.module, p.poster);
    if (const auto known = posters_.find(was); known != posters_.end()) {
      p = known->second;
      return;
    }
    Module& m = module(p.module);
    p.poster = m.posters.size();
    posters_.emplace(was, p);
    genom::Poster reduced;
    reduced.name.text = fmt::format("p{}", p.poster);
    reduced.task.text = "task";
    m.posters.push_back(std::move(reduced));
  }

  void condition(Condition& c) {
    if (c.kind == genom::ConditionKind::Active || c.kind == genom::ConditionKind::Done) service(c.service);
    if (c.kind == genom::ConditionKind::Fresh || c.kind == genom::ConditionKind::Age) poster(c.poster);
    if (c.kind == genom::ConditionKind::Fresh) c.span = {2, true};
    for (Condition& operand : c.operands) condition(operand);
  }

  const std::vector<Module>& old_;
  Reduced out_;
  std::map<std::size_t, std::size_t> modules_;
  std::map<ServiceRef, ServiceRef> services_;
  std::map<std::pair<std::size_t, std::size_t>, genom::PosterRef> posters_;
};

}  // namespace

genom::GenerateOptions reduced_options(const Reduced& reduced, const std::string& package) {
  genom::GenerateOptions options;
  options.package = package;
  options.constraints = reduced.constraints;
  options.oldest = 4;
  return options;
}

Reduced reduce(const std::vector<Module>& modules, const genom::Constraints& constraints) {
  return Reducer(modules, constraints).run();
}

}  // namespace bip::rules
