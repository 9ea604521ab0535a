// The package: a comment, what it uses, the modules, and the functional level with everything that belongs to no module.
#include "compiler/genom/generate.hpp"

#include <fmt/format.h>

#include <map>
#include <numeric>
#include <set>

#include "compiler/genom/names.hpp"
#include "compiler/genom/codels.hpp"
#include "compiler/genom/plan.hpp"
#include "compiler/genom/wires.hpp"

namespace bip::genom {
namespace {

// Of stdlib/genom, and the root: a type of the package would hide them.
constexpr const char* kOwnTypes[] = {"Signal", "Report", "Status", "Age", "ControlState", "MasterTimer", "Timer", "WakeUp", "IdsLock", "Semaphore",
                                     "Poster", "ServiceController", "ControlService", "TaskController", "Permanent", "ControlIds", "FunctionalLevel"};

// Of the functional level.
constexpr const char* kOwnParts[] = {"semaphore", "masterTimer", "InterModuleSync"};

// The greatest unit that divides all periods; 10 ms if there are none. GenoM 2 counts in its own clock.
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

std::string header(const std::vector<Module>& modules, const GenerateOptions& options, std::int64_t tick_us) {
  std::string files;
  for (const std::string& source : options.sources) files += (files.empty() ? "" : ", ") + source;
  std::string names;
  for (const Module& m : modules) names += (names.empty() ? "" : ", ") + m.name.text;
  return fmt::format(
      "// {} as BIP: what `bipc genom` made of {}.\n"
      "//\n"
      "// One tick is {} ms; {}; requests come in any order. compiler/docs/genom.md says what is what.\n"
      "{}package {}\n"
      "  use genom.ports\n  use genom.timers\n  use genom.locks\n  use genom.posters\n  use genom.services\n  use genom.tasks\n",
      names, files, static_cast<double>(tick_us) / 1000.0,
      options.flavour == Flavour::Execution ? "codels are the C++ functions of their names" : "codels answer freely",
      options.flavour == Flavour::Execution ? fmt::format("@cpp(include=\"{0}_codels.hpp\", src=\"{0}_codels.cpp\")\n", options.package) : "", options.package);
}

void write_types(std::string& out, const Plan& plan, std::int64_t tick_us) {
  const Module& m = *plan.module;
  for (std::size_t i = 0; i < m.services.size(); ++i) {
    const Service& s = m.services[i];
    if (s.kind != ServiceKind::Execution) continue;
    write_activity(out, plan, s.activity, plan.services[i].activity, &s, fmt::format("The activity of {}: its codels, one after the other.", s.name.text));
    write_service(out, plan, i);
  }
  for (std::size_t i = 0; i < m.tasks.size(); ++i) {
    const Task& t = m.tasks[i];
    if (!t.activity.states.empty()) write_activity(out, plan, t.activity, plan.tasks[i].permanent, nullptr, fmt::format("The codels of task {} itself.", t.name.text));
    write_scheduler(out, plan, i);
    write_task(out, plan, i, tick_us);
  }
  write_control(out, plan);
}

// The connectors that stand here by default and that constraints replace: see docs/genom.md.
void write_defaults(std::string& out, const Plan& p, const std::map<std::string, std::string>& posters, Scope& names) {
  const std::string m = p.component + ".";
  const auto wire = [&](Wire w) {
    w.name = names.claim(w.name, "event");
    write_wire(out, w);
  };
  out += fmt::format("\n    // {}: a request takes the semaphore; triggers and interruptions are free.\n", p.module->name.text);
  for (const ServicePlan& s : p.services) {
    wire({.name = fmt::format("{}_read_{}", p.component, s.id), .ports = {m + "read_" + s.id, "semaphore.take"}});
    wire({.name = fmt::format("{}_abtInc_{}", p.component, s.id), .ports = {m + "abtInc_" + s.id}});
    wire({.name = fmt::format("{}_trig_{}", p.component, s.id), .ports = {m + "trig_" + s.id}});
  }
  if (p.execution_slots > 0) wire({.name = p.component + "_read_Abort", .ports = {m + "read_Abort", "semaphore.take"}});
  wire({.name = p.component + "_give", .ports = {m + "give", "semaphore.give"}});
  for (std::size_t i = 0; i < p.tasks.size(); ++i) {
    const Task& t = p.module->tasks[i];
    if (!t.has_permanent() && t.reads.empty()) continue;
    std::vector<std::string> ports{m + "begin_" + p.tasks[i].component};
    for (const Name& read : t.reads) {
      const auto poster = posters.find(read.text);
      if (poster != posters.end()) ports.push_back(poster->second);
    }
    wire({.name = fmt::format("{}_begin_{}", p.component, p.tasks[i].component), .ports = ports});
  }
}

}  // namespace

void write_functional_level(std::string& out, const std::vector<Plan>& plans) {
  out += "\n  // All modules, the token for triggers, and the clock.\n  compound type FunctionalLevel()\n";
  std::map<std::string, std::string> posters;
  for (const Plan& p : plans) {
    out += fmt::format("    @SuppressWarning(unboundcomponentport)\n    component {} {}()\n", p.type, p.component);
    for (std::size_t i = 0; i < p.posters.size(); ++i) posters[p.module->name.text + "." + p.module->posters[i].name.text] = p.component + ".read_" + p.posters[i];
  }
  out += "    @SuppressWarning(unboundcomponentport)\n    component Semaphore semaphore()\n    component MasterTimer masterTimer()\n";
  Scope names;
  for (const char* own : kOwnParts) names.claim(own, "");
  for (const Plan& p : plans) names.claim(p.component, "");
  for (const Plan& p : plans) write_defaults(out, p, posters, names);
  std::vector<std::string> ticks{"masterTimer.tick"};
  for (const Plan& p : plans) ticks.push_back(p.component + ".moduleTick");
  write_wire(out, {.name = "InterModuleSync", .ports = ticks});
  out += "  end\n";
}

std::string generate(const std::vector<Module>& modules, const GenerateOptions& options) {
  const std::int64_t tick_us = options.tick_us > 0 ? options.tick_us : tick_of(modules);
  std::string out = header(modules, options, tick_us);
  if (options.flavour == Flavour::Execution) out += codel_prototypes(modules);
  std::vector<Plan> plans;
  Scope types;
  for (const char* own : kOwnTypes) types.claim(own, "");
  std::set<std::size_t> lock_sizes;
  Scope parts;
  for (const char* own : kOwnParts) parts.claim(own, "");
  for (const Module& m : modules) {
    plans.push_back(make_plan(m, options, types));
    plans.back().component = parts.claim(plans.back().component, "module");
    for (const LockPlan& lock : plans.back().locks) lock_sizes.insert(lock.threads.size());
  }
  for (const std::size_t size : lock_sizes) write_data_lock(out, size);
  for (const Plan& p : plans) {
    write_types(out, p, tick_us);
    write_module(out, p, options);
  }
  write_functional_level(out, plans);
  return out + "end\n";
}

}  // namespace bip::genom
