// Writes the package: a comment, the packages used, the modules; level.cpp writes the functional level.
#include "compiler/genom/generate_package.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "compiler/genom/codels.hpp"
#include "compiler/genom/level.hpp"
#include "compiler/genom/level_condition.hpp"
#include "compiler/genom/mailbox.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {

std::int64_t tick_of(const std::vector<Module>& modules) {
  std::int64_t tick = 0;
  for (const Module& m : modules) {
    if (m.generation == 2) tick = std::gcd(tick, m.tick_us);
    for (const Task& t : m.tasks) {
      if (m.generation == 3) tick = std::gcd(tick, std::gcd(t.period_us, t.delay_us));
    }
  }
  return tick == 0 ? 10000 : tick;
}

namespace {

// PosterAge has to come past what conditions compare it with.
std::int64_t oldest_for(const Condition& c, const GenerateOptions& options, std::int64_t tick_us) {
  std::int64_t oldest = c.kind == ConditionKind::Fresh ? steps_of_age(c.span, options, tick_us) + 1 : 0;
  for (const Condition& operand : c.operands) {
    oldest = std::max(oldest, oldest_for(operand, options, tick_us));
    if (operand.kind != ConditionKind::Age) continue;
    for (const Condition& other : c.operands)
      oldest = std::max(oldest, std::min<std::int64_t>(other.number, 1000000) + 1);
  }
  return oldest;
}

bool any_async(const std::vector<Module>& modules) {
  return std::any_of(modules.begin(), modules.end(), [](const Module& m) { return m.has_async(); });
}

std::string header(const std::vector<Module>& modules, const GenerateOptions& options, std::int64_t tick_us) {
  std::string files;
  for (const std::string& source : options.sources) files += (files.empty() ? "" : ", ") + source;
  std::string names;
  for (const Module& m : modules) names += (names.empty() ? "" : ", ") + m.name.text;
  std::string sources;
  for (const std::string& file : options.c_sources) sources += "," + file;
  return fmt::format(
      "// {} as BIP: what `bipc genom` made of {}.\n"
      "//\n"
      "// One tick is {} ms; {}; requests come in any order. compiler/docs/genom.md says what is what.\n"
      "{}package {}\n"
      "  use genom.ports\n  use genom.timers\n  use genom.locks\n  use genom.posters\n  use genom.services\n  use "
      "genom.tasks\n{}",
      names, files, static_cast<double>(tick_us) / 1000.0,
      options.flavour == Flavour::Execution ? "codels are the C++ functions of their names" : "codels answer freely",
      options.flavour == Flavour::Execution
          ? fmt::format("@cpp(include=\"{0}_codels.hpp\", src=\"{0}_codels.cpp{1}\")\n", options.package, sources)
          : "",
      options.package,
      (any_async(modules) || options.has_task_threads ? std::string("  use genom.codels\n") : std::string()) +
          (options.constraints.has_parts() ? "  use genom.rules\n" : ""));
}

void write_types(std::string& out, const Plan& plan, std::int64_t tick_us) {
  const Module& m = *plan.module;
  for (std::size_t i = 0; i < m.services.size(); ++i) {
    const Service& s = m.services[i];
    if (s.kind != ServiceKind::Execution) continue;
    write_activity(out, plan, s.activity, plan.services[i].activity, &s,
                   fmt::format("The activity of {}: its codels, one after the other.", s.name.text));
    if (plan.services[i].activity.has_work())
      write_work(out, plan, plan.module->services[i].activity, plan.services[i].activity, plan.services[i].work_type,
                 plan.module->services[i].name.text);
    write_service(out, plan, i, tick_us);
  }
  for (std::size_t i = 0; i < m.tasks.size(); ++i) {
    const Task& t = m.tasks[i];
    if (!t.activity.states.empty())
      write_activity(out, plan, t.activity, plan.tasks[i].permanent, nullptr,
                     fmt::format("The codels of task {} itself.", t.name.text), plan.owner_of_task(i));
    if (!plan.tasks[i].permanent_type.empty()) write_permanent(out, plan, i);
    if (plan.tasks[i].permanent.has_work())
      write_work(out, plan, t.activity, plan.tasks[i].permanent, plan.tasks[i].work_type, "task " + t.name.text,
                 plan.owner_of_task(i));
    write_scheduler(out, plan, i);
    write_task(out, plan, i, tick_us);
  }
  write_control(out, plan);
}

}  // namespace

std::string generate(const std::vector<Module>& modules, const GenerateOptions& given) {
  const std::int64_t tick_us = given.tick_us > 0 ? given.tick_us : tick_of(modules);
  BIP_ASSERT(tick_us > 0, "ticks of {} us", tick_us);
  GenerateOptions options = given;
  for (const Constraint& c : options.constraints.rows)
    options.oldest = std::max(options.oldest, oldest_for(c.condition, options, tick_us));
  std::string out = header(modules, options, tick_us);
  if (options.flavour == Flavour::Execution) out += codel_prototypes(modules, options);
  const std::size_t executive_at = out.size();
  const std::vector<Plan> plans = make_plans(modules, options);
  std::set<std::size_t> lock_sizes;
  for (const Plan& p : plans) {
    for (const LockPlan& lock : p.locks) lock_sizes.insert(lock.threads.size());
  }
  for (const std::size_t size : lock_sizes) write_data_lock(out, size);
  for (const Plan& p : plans) {
    write_types(out, p, tick_us);
    for (std::size_t k = 0; k < p.posters.size(); ++k) {
      if (!p.poster_types[k].values.empty()) write_poster(out, p, k);
    }
    write_module(out, p, options);
  }
  const std::vector<std::vector<RequestSpec>> requests = write_level(out, plans, options, tick_us);
  if (options.executive != Executive::Anybody) {
    BIP_ASSERT(requests.size() == plans.size(), "requests of {} modules of {}", requests.size(), plans.size());
    std::vector<RequestSpec> all;
    std::string mailboxes;
    for (std::size_t m = 0; m < plans.size(); ++m) {
      all.insert(all.end(), requests[m].begin(), requests[m].end());
      if (options.executive == Executive::Served) mailboxes += mailbox_type(plans[m], requests[m]);
    }
    out.insert(executive_at, executive_type(options, all) + mailboxes);
  }
  return out + "end\n";
}

}  // namespace bip::genom
