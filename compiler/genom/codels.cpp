// See codels.hpp. One list of codels gives three texts: BIP's prototypes, a C++ header, and a C++ source with empty
// functions.
#include "compiler/genom/codels.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/genom/codel_processes.hpp"
#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

std::string text_of(const Activity& activity, const Yield& y, bool is_3) {
  BIP_ASSERT((y.next != Next::State && y.next != Next::Pause) || y.state < activity.states.size(),
             "state {} of {} is yielded", y.state, activity.states.size());
  switch (y.next) {
    case Next::State: return activity.states[y.state].name.text;
    case Next::Pause: return "pause::" + activity.states[y.state].name.text;
    case Next::Ether: return is_3 ? "ether" : "ETHER";
    case Next::Zombie: return "ZOMBIE";
    case Next::Sleep: return "SLEEP";
    case Next::Other: break;
  }
  return {};
}

void add(std::vector<CodelFunction>& all, CodelFunction f) {
  const auto known = std::find_if(
      all.begin(), all.end(), [&](const CodelFunction& g) { return g.name == f.name && g.has_report == f.has_report; });
  if (known == all.end()) return all.push_back(std::move(f));
  known->is_unlimited = known->is_unlimited || f.is_unlimited;
  known->budget_us = std::max(known->budget_us, f.budget_us);
  known->wcet_us = std::max(known->wcet_us, f.wcet_us);
}

void add_activity(std::vector<CodelFunction>& all, const Module& m, const std::string& owner,
                  const Activity& activity) {
  for (const State& s : activity.states) {
    if (!s.codel.name.is_set()) continue;
    CodelFunction f{.name = bip_name(s.codel.name.text),
                    .module = m.name.text,
                    .has_report = true,
                    .says = fmt::format("{}, state {}", owner, s.name.text),
                    .is_unlimited = s.codel.is_async && s.codel.budget_us == 0,
                    .budget_us = s.codel.is_async ? s.codel.budget_us : 0,
                    .wcet_us = s.codel.budget_us};
    for (const Yield& y : s.yields) {
      if (y.next == Next::Other) continue;
      if (f.answers.empty()) f.first = answer_code(y);
      f.answers.push_back(fmt::format("{} = {}", text_of(activity, y, m.generation == 3), answer_code(y)));
    }
    add(all, std::move(f));
  }
}

// Do rules ask whether codels exceed their budgets?
bool asks_for_late(const GenerateOptions& options) {
  return std::any_of(options.constraints.failures.begin(), options.constraints.failures.end(),
                     [](const FailureRow& row) { return row.kind == FailureKind::Late; });
}

const char* cpp_type(const ValueRow& v) {
  return v.type == ValueType::Int ? "int" : v.type == ValueType::Float ? "double" : "std::string";
}

bool has_text_values(const GenerateOptions& options) {
  return std::any_of(options.constraints.values.begin(), options.constraints.values.end(),
                     [](const ValueRow& v) { return v.type == ValueType::Text; });
}

// "inline int codel_goMain(int owner, int& report) { return bip::guarded_step(...); }"
std::string guarded_text(const CodelFunction& f) {
  return fmt::format(
      "inline int {}(int owner{}) {{ return bip::guarded_{}(\"{}\", kCodelOwners[owner], [&] {{ return {}({}); }}); "
      "}}\n",
      codel_function(f.name), f.has_report ? ", int& report" : "", f.has_report ? "step" : "control", f.name, f.name,
      f.has_report ? "report" : "");
}

// By their numbers.
std::string owners_text(const std::vector<Plan>& plans) {
  std::string rows;
  for (const Plan& p : plans) {
    BIP_ASSERT(p.first_owner == static_cast<std::size_t>(std::count(rows.begin(), rows.end(), '\n')),
               "the owners of `{}` begin with {}, not in this row", p.component, p.first_owner);
    for (std::size_t k = 0; k < p.activities.size(); ++k)
      rows += fmt::format("    {{\"{}.{}\", \"{}.{}\"}},\n", p.component, p.activities[k].component,
                          p.module->name.text, p.service_of(k).name.text);
    for (const Task& t : p.module->tasks)
      rows += fmt::format("    {{\"task {}.{}\", \"\"}},\n", p.component, t.name.text);
  }
  return rows;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& p : parts) text += (text.empty() ? "" : ", ") + p;
  return text;
}

}  // namespace

std::vector<CodelFunction> functions_of(const std::vector<Module>& modules) {
  std::vector<CodelFunction> all;
  for (const Module& m : modules) {
    for (const Service& s : m.services) {
      std::vector<std::string> reports{"OK = 0"};
      for (std::size_t k = 0; k < s.reports.size(); ++k)
        reports.push_back(fmt::format("{} = {}", s.reports[k].text, k + 1));
      if (s.validate.name.is_set())
        add(all, {.name = bip_name(s.validate.name.text),
                  .module = m.name.text,
                  .says = fmt::format("{}, its parameters", s.name.text),
                  .answers = reports,
                  .wcet_us = s.validate.budget_us});
      for (const Codel& c : s.body) {
        if (c.name.is_set())
          add(all, {.name = bip_name(c.name.text),
                    .module = m.name.text,
                    .says = s.name.text,
                    .answers = reports,
                    .wcet_us = c.budget_us});
      }
      add_activity(all, m, s.name.text, s.activity);
    }
    for (const Task& t : m.tasks) {
      if (t.permanent.name.is_set())
        add(all, {.name = bip_name(t.permanent.name.text),
                  .module = m.name.text,
                  .says = fmt::format("task {}, in each cycle", t.name.text),
                  .answers = {"OK = 0"},
                  .wcet_us = t.permanent.budget_us});
      add_activity(all, m, "task " + t.name.text, t.activity);
    }
  }
  return all;
}

std::string value_function(const Module& module, const ValueRow& value) {
  BIP_ASSERT(value.poster.poster < module.posters.size(), "value `{}` is of poster {} of {}", value.name,
             value.poster.poster, module.posters.size());
  return bip_name(fmt::format("{}_{}_{}", module.name.text, module.posters[value.poster.poster].name.text, value.name));
}
std::string value_function(const std::vector<Module>& modules, const ValueRow& value) {
  BIP_ASSERT(value.poster.module < modules.size(), "value `{}` is of module {} of {}", value.name, value.poster.module,
             modules.size());
  return value_function(modules[value.poster.module], value);
}
std::string called_value_function(const Module& module, const ValueRow& value, bool has_processes) {
  return (has_processes ? "codel_value_" : "") + value_function(module, value);
}

std::string request_function(const GenerateOptions& options, const std::string& what) {
  return (options.processes.are_own && !options.calls_c ? "codel_request_" : "request_") + what;
}

std::string codel_prototypes(const std::vector<Module>& modules, const GenerateOptions& options) {
  std::string out = "\n";
  if (options.calls_c) out += "  extern function service_begin(const int)\n  extern function service_end(const int)\n";
  for (const ValueRow& v : options.constraints.values) {
    out += fmt::format("  extern function {} {}()\n",
                       v.type == ValueType::Int     ? "int"
                       : v.type == ValueType::Float ? "float"
                                                    : "string",
                       called_value_function(modules[v.poster.module], v, options.processes.are_own));
  }
  if (options.processes.are_own) out += "  extern function service_accepted(const int)\n";
  if (asks_for_late(options)) out += "  extern function int codel_was_late()\n";
  for (const CodelFunction& f : functions_of(modules))
    out += fmt::format("  extern function int {}(const int{})\n", codel_function(f.name), f.has_report ? ", int" : "");
  return out;
}

std::string codel_header(const std::vector<Module>& modules, const GenerateOptions& options) {
  std::string out =
      fmt::format("// Codels that {}.bip calls. Written by `bipc genom --skeleton`.\n//\n", options.package);
  if (options.executive == Executive::Cpp) {
    out +=
        "// The executive is asked once a tick for \"MODULE.SERVICE(VALUE, ...)\" or \"\", and hears of what came of "
        "it: (module, service, report).\n";
  }
  out +=
      "// A codel of an activity returns what is next, and sets `report` (0: OK) if it ends the activity with a report "
      "of its service.\n";
  out +=
      "// The others return 0 (OK) or the number of a report. Anything else suspends the task.\n#pragma once\n#include "
      "\"bip/codels.hpp\"\n";
  if (options.processes.are_own) out += "#include \"bip/codel_processes.hpp\"\n";
  if (options.executive != Executive::Anybody)
    out +=
        "#include \"bip/service_requests.hpp\"\n\nusing bip::request_known;\nusing bip::request_number;\n"
        "using bip::request_service;\nusing bip::request_word;\n";
  if (options.executive == Executive::Cpp) out += "using bip::request_module;\n";
  if (options.executive == Executive::Served)
    out += fmt::format(
        "\ninline bool request_agrees(const char* text, const char* input, const char* services) {{\n"
        "  return bip::request_agrees(text, input, services, bip::InputForm::{});\n}}\n",
        options.calls_c ? "Names" : "Words");
  if (options.executive == Executive::Served)
    out +=
        "\n// What a request of a client came with: when it is asked for, for codels that judge it; and, if it is "
        "accepted, before its codels run.\nvoid request_asked(const char* service, const char* input);\n"
        "void request_input(const char* service, const char* input);\n"
        "\n// Called beside everything else when the engine stalls, by the watchdog of `bipc serve`: stops the robot "
        "whatever codels do.\n"
        "// It must not wait for what a codel may hold.\nextern \"C\" void safe_stop(const char* why);\n"
        "\n// Need not be there: what poster \"MODULE.POSTER\" holds, as a JSON object, for `bipc serve` and `bipc "
        "ros2`; "
        "\"\": nothing yet, null: no such poster.\n"
        "extern \"C\" const char* bip_poster_value(const char* poster);\n";
  if (options.executive == Executive::Cpp) {
    out +=
        "\nstd::string executive_request();\n"
        "void executive_answer(const char* module, const char* service, const char* report);\n"
        "void executive_reply(const char* module, const char* service, const char* report);\n";
  }
  if (!options.constraints.values.empty())
    out +=
        fmt::format("\n// ---- What posters hold, asked for when they are written\n{}",
                    has_text_values(options) && options.executive == Executive::Anybody ? "#include <string>\n\n" : "");
  for (const ValueRow& v : options.constraints.values)
    out += fmt::format("{} {}();\n", cpp_type(v), value_function(modules, v));
  std::string module;
  for (const CodelFunction& f : functions_of(modules)) {
    if (options.calls_c) break;  // their own headers
    if (f.module != module) out += fmt::format("\n// ---- {}\n", f.module);
    module = f.module;
    out +=
        fmt::format("// {}: {}\nint {}({});\n", f.says, joined(f.answers), f.name, f.has_report ? "int& report" : "");
  }
  out += fmt::format(
      "\n// ---- What {}.bip calls: {} ends what its codel belongs to, and nothing else.\n"
      "inline constexpr bip::CodelOwner kCodelOwners[] = {{\n{}}};\n",
      options.package, options.processes.are_own ? "an exception, a signal or an exit" : "an exception",
      owners_text(make_plans(modules, options)));
  if (options.processes.are_own) out += process_declarations(modules, options);
  for (const CodelFunction& f : functions_of(modules)) {
    if (options.processes.are_own && !options.calls_c) break;  // those that call processes
    out += options.calls_c
               ? fmt::format("int {}(int owner{});\n", codel_function(f.name), f.has_report ? ", int& report" : "")
               : guarded_text(f);
  }
  if (options.calls_c) out += "void service_begin(int owner);\nvoid service_end(int owner);\n";
  if (asks_for_late(options)) out += "inline int codel_was_late() { return bip::codel_was_late() ? 1 : 0; }\n";
  std::string budgets;
  for (const CodelFunction& f : functions_of(modules)) {
    if (f.wcet_us > 0) budgets += fmt::format("    {{\"{}\", {}}},\n", f.name, f.wcet_us);
  }
  if (!budgets.empty())
    out += fmt::format(
        "inline constexpr bip::CodelBudget kCodelBudgets[] = {{\n{}}};\ninline const bool kHasCodelBudgets = "
        "bip::set_codel_budgets(kCodelBudgets);\n",
        budgets);
  out +=
      "extern \"C\" __attribute__((used)) inline const char* bip_codel_times() { return bip::codel_times_text(); }\n";
  if (options.calls_c)
    out +=
        "extern \"C\" __attribute__((used)) inline void bip_set_service_caller(bip::ServiceCaller caller) { "
        "bip::service_caller() = caller; }\n";
  if (options.executive == Executive::Served)
    out +=
        "extern \"C\" __attribute__((used)) inline const char* bip_reply_result(const char* whose, int is_activity) {\n"
        "  return bip::reply_result(whose, is_activity != 0);\n}\n";
  return out;
}

std::string codel_source(const std::vector<Module>& modules, const GenerateOptions& options) {
  std::string out = fmt::format(
      "// Codels of {0}.bip, empty: each answers the first thing that it may.\n#include \"{0}_codels.hpp\"\n",
      options.package);
  if (options.executive == Executive::Served)
    out +=
        "\nvoid request_asked(const char* /*service*/, const char* /*input*/) {}\n"
        "void request_input(const char* /*service*/, const char* /*input*/) {}\n"
        "void safe_stop(const char* /*why*/) {}\n";
  if (options.executive == Executive::Cpp) {
    out +=
        "\n// Never asks for anything.\nstd::string executive_request() { return {}; }\n"
        "void executive_answer(const char* /*module*/, const char* /*service*/, const char* /*report*/) {}\n"
        "void executive_reply(const char* /*module*/, const char* /*service*/, const char* /*report*/) {}\n";
  }
  for (const ValueRow& v : options.constraints.values)
    out += fmt::format("\n{} {}() {{ return {}; }}\n", cpp_type(v), value_function(modules, v), v.values.front());
  for (const CodelFunction& f : functions_of(modules)) {
    out += fmt::format("\n// {}: {}\nint {}({}) {{ return {}; }}\n", f.says, joined(f.answers), f.name,
                       f.has_report ? "int& /*report*/" : "", f.first);
  }
  return out;
}

}  // namespace bip::genom
