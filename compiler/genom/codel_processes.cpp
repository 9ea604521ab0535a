// See codel_processes.hpp. Each function that runs in a module's process has a row, by whose number it is called.
#include "compiler/genom/codel_processes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/genom/codels.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"
#include "compiler/genom/standard_services.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

// ms that a call may take: after its budget the codel has been given up.
std::int64_t limit_of(const CodelFunction& f, const GenerateOptions& options) {
  BIP_ASSERT(f.budget_us >= 0 && options.processes.kill_after_us >= 0, "codel `{}` has {} us, and then {} us", f.name,
             f.budget_us, options.processes.kill_after_us);
  if (options.processes.kill_after_us == 0 || f.is_unlimited) return 0;
  return std::max<std::int64_t>(1, (options.processes.kill_after_us + f.budget_us + 999) / 1000);
}

bool has_init_codel(const Service& s) {
  return s.is_init && s.kind == ServiceKind::Execution &&
         std::any_of(s.activity.states.begin(), s.activity.states.end(),
                     [](const State& state) { return state.codel.name.is_set(); });
}

const char* cpp_type_of(const ValueRow& v) {
  return v.type == ValueType::Int ? "int" : v.type == ValueType::Float ? "double" : "std::string";
}

class ProcessWriter {
 public:
  ProcessWriter(const std::vector<Module>& modules, const GenerateOptions& options)
      : modules_(modules),
        options_(options),
        plans_(make_plans(modules, options)),
        functions_(functions_of(modules)),
        level_(bip_name(options.package) + "_processes()"),
        inline_(options.calls_c ? "" : "inline ") {}

  std::string run(const std::string& posters, const std::string& readers) {
    for (const CodelFunction& f : functions_) codel(f);
    if (options_.calls_c) inputs_of_c();
    else if (options_.executive == Executive::Served) inputs();
    for (const ValueRow& v : options_.constraints.values) value(v);
    std::string modules, owners, starts;
    for (std::size_t m = 0; m < modules_.size(); ++m) module(m, modules, owners, starts);
    std::string out, more;
    table(out, "Module", "kCodelModules", modules);
    table(out, "Owner", "kCodelOwnerRows", owners);
    table(out, "Function", "kCodelFunctions", rows_);
    const auto optional_table = [&](const char* type, const char* member, const char* name, const std::string& rows) {
      if (rows.empty()) return;
      table(out, type, name, rows);
      more += fmt::format(",\n      .{} = {}", member, name);
    };
    optional_table("Start", "starts", "kCodelStarts", starts);
    optional_table("Poster", "posters", "kCodelPosters", posters);
    optional_table("Reader", "readers", "kCodelReaders", readers);
    if (options_.processes.memory_mb > 0) more += fmt::format(",\n      .memory_mb = {}", options_.processes.memory_mb);
    out += fmt::format(
        "{}bip::processes::Level& {} {{\n  static bip::processes::Level level({{.modules = kCodelModules,\n      "
        ".owners = kCodelOwners,\n      .owner_rows = kCodelOwnerRows,\n      .functions = kCodelFunctions{}}});\n  "
        "return level;\n}}\n",
        options_.calls_c ? "static " : "inline ", level_, more);
    out += calls_ + fmt::format("{}void service_accepted(int owner) {{ {}.accepted(owner); }}\n", inline_, level_);
    out += fmt::format(
        "// For `bipc serve`: what is called when a process has died.\nextern \"C\" __attribute__((used)) {}void "
        "bip_set_module_hook(void (*hook)(const char* why)) {{\n  {}.on_death.store(hook);\n}}\n",
        inline_, level_);
    return out;
  }

 private:
  static void table(std::string& out, const char* type, const char* name, const std::string& rows) {
    out += fmt::format("inline constexpr bip::processes::{}Row {}[] = {{\n{}}};\n", type, name, rows);
  }

  // Its number.
  std::size_t row(const std::string& name, std::int64_t limit_ms, const std::string& body, bool is_codel = false,
                  bool is_repeated = false) {
    rows_ += fmt::format("    {{\"{}\", {}, []([[maybe_unused]] bip::processes::Call& call) {{ {} }}{}{}}},\n", name,
                         limit_ms, body, is_codel ? ", true" : "", is_repeated ? ", true" : "");
    return row_count_++;
  }
  [[nodiscard]] std::int64_t plain_limit() const { return limit_of({}, options_); }

  void codel(const CodelFunction& f) {
    const std::string function = codel_function(f.name), take = "call.answer = ";
    BIP_ASSERT(row_count_ < functions_.size() && functions_[row_count_].name == f.name,
               "codel `{}` is not function {} of the table", f.name, row_count_);
    const std::string input = "bip::genom3::asked_inputs()[kCodelOwners[{}].service]";
    if (f.has_report) {
      const std::size_t k = row(
          f.name, limit_of(f, options_),
          options_.calls_c
              ? fmt::format("{}here_{}(call.owner, call.report);", take, function)
              : fmt::format("{}bip::guarded_step(\"{}\", kCodelOwners[call.owner], [&] {{ return {}(call.report); }});",
                            take, f.name, f.name),
          true);
      calls_ += fmt::format("{}int {}(int owner, int& report) {{ return {}.step({}, owner, report); }}\n", inline_,
                            function, level_, k);
    } else {
      const std::size_t k =
          row(f.name, limit_of(f, options_),
              options_.calls_c
                  ? fmt::format("{} = call.in; {}here_{}(call.owner);", fmt::format(fmt::runtime(input), "call.owner"),
                                take, function)
                  : fmt::format("{}bip::guarded_control(\"{}\", kCodelOwners[call.owner], [] {{ return {}(); }});",
                                take, f.name, f.name),
              true, is_repeated(f));
      calls_ += fmt::format("{}int {}(int owner) {{ return {}.control({}, owner{}); }}\n", inline_, function, level_, k,
                            options_.calls_c ? ", " + fmt::format(fmt::runtime(input), "owner") : "");
    }
  }

  [[nodiscard]] bool is_repeated(const CodelFunction& f) const {
    return std::any_of(modules_.begin(), modules_.end(), [&](const Module& m) {
      const auto is_that = [&](const char* service) {
        return is_connection(*m.component, service) && f.name == bip_name(connect_function(*m.component, service));
      };
      return m.component && (is_that(kConnectPort) || is_that(kConnectService));
    });
  }

  // The controller has the inputs, so that they outlive a process.
  void inputs_of_c() {
    const std::size_t begin =
        row("service_begin", plain_limit(),
            "bip::genom3::asked_inputs()[kCodelOwners[call.owner].service] = call.in; here_service_begin(call.owner);");
    calls_ += fmt::format(
        "void service_begin(int owner) {{\n  {}.call_of(owner, {}, "
        "bip::genom3::asked_inputs()[kCodelOwners[owner].service]);\n}}\n",
        level_, begin);
    const std::size_t end = row("service_end", plain_limit(), "here_service_end(call.owner);");
    calls_ += fmt::format("void service_end(int owner) {{ {}.call_of(owner, {}); }}\n", level_, end);
  }

  // They begin with the module's name.
  void inputs() {
    for (const char* const what : {"asked", "input"}) {
      const std::string name = fmt::format("request_{}", what);
      const std::size_t k = row(name, plain_limit(), fmt::format("bip::processes::give_two_texts(call.in, {});", name));
      calls_ +=
          fmt::format("inline void codel_{}(const char* service, const char* input) {{ {}.{}({}, service, input); }}\n",
                      name, level_, *what == 'a' ? "call_by_name" : "give_input", k);
    }
    const std::size_t k = row("bip_poster_value", plain_limit(),
                              "if (&bip_poster_value != nullptr) bip::processes::ask_poster(call, bip_poster_value);");
    calls_ += fmt::format(
        "extern \"C\" __attribute__((used)) inline const char* bip_module_poster_value(const char* poster) {{\n"
        "  return bip::processes::poster_of({}.call_by_name({}, poster, \"\"));\n}}\n",
        level_, k);
  }

  void value(const ValueRow& v) {
    const std::string name = value_function(modules_, v), type = cpp_type_of(v);
    const bool is_text = v.type == ValueType::Text;
    const std::size_t k = row(
        name, plain_limit(),
        is_text ? fmt::format("call.out = {}();", name) : fmt::format("bip::processes::append(call.out, {}());", name));
    // A process that has died leaves it as it was.
    calls_ += fmt::format(
        "{0}{1} {2}() {{\n  static {1} last{{}};\n  if (const auto bytes = {3}.call({4}, {5}, {{}})) {6};\n  return "
        "last;\n}}\n",
        inline_, type, called_value_function(modules_[v.poster.module], v, true), level_, k, v.poster.module,
        is_text ? "last = *bytes" : "(void)bip::processes::Taker(*bytes).take(last)");
  }

  void module(std::size_t m, std::string& modules, std::string& owners, std::string& starts) const {
    const Plan& plan = plans_[m];
    const auto flag = [](bool is_set) { return is_set ? "true" : "false"; };
    BIP_ASSERT(plan.first_owner == static_cast<std::size_t>(std::count(owners.begin(), owners.end(), '\n')),
               "the owners of `{}` begin with {}, not in this row", plan.component, plan.first_owner);
    modules +=
        fmt::format("    {{\"{}\", {}}},\n", plan.module->name.text,
                    flag(std::any_of(plan.module->services.begin(), plan.module->services.end(), has_init_codel)));
    for (std::size_t k = 0; k < plan.activities.size(); ++k)
      owners += fmt::format("    {{{}, false, {}}},\n", m, flag(has_init_codel(plan.service_of(k))));
    for (std::size_t t = 0; t < plan.module->tasks.size(); ++t) {
      owners += fmt::format("    {{{}, true, false}},\n", m);
      const Activity& own = plan.module->tasks[t].activity;
      if (own.states.empty() || !own.states[own.start].codel.name.is_set()) continue;
      const std::string name = bip_name(own.states[own.start].codel.name.text);
      const auto found = std::find_if(functions_.begin(), functions_.end(),
                                      [&](const CodelFunction& f) { return f.has_report && f.name == name; });
      BIP_ASSERT(found != functions_.end(), "codel `{}`, with which a task starts, is in no table", name);
      starts += fmt::format("    {{{}, {}}},\n", found - functions_.begin(), plan.owner_of_task(t));
    }
  }

  const std::vector<Module>& modules_;
  const GenerateOptions& options_;
  std::vector<Plan> plans_;
  std::vector<CodelFunction> functions_;
  std::string level_, inline_, rows_, calls_;
  std::size_t row_count_ = 0;
};

}  // namespace

std::string process_declarations(const std::vector<Module>& modules, const GenerateOptions& options) {
  if (!options.calls_c) {
    // Need not be there.
    const std::string weak =
        options.executive == Executive::Served
            ? "extern \"C\" __attribute__((weak)) const char* bip_poster_value(const char* poster);\n"
            : "";
    return weak + ProcessWriter(modules, options).run("", "");
  }
  std::string out = "void service_accepted(int owner);\n";
  for (const ValueRow& v : options.constraints.values)
    out += fmt::format("{} {}();\n", cpp_type_of(v), called_value_function(modules[v.poster.module], v, true));
  return out;
}

std::string process_definitions(const std::vector<Module>& modules, const GenerateOptions& options,
                                const std::string& posters, const std::string& readers) {
  return "\n// ---- Processes of modules\n" + ProcessWriter(modules, options).run(posters, readers);
}

}  // namespace bip::genom
