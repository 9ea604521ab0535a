// What the options of several commands have in common: closed sets of values, checks, groups of options.
#pragma once
#include <map>
#include <string>

#include "compiler/driver/cli_options.hpp"
#include "runtime/distributed/distribution.hpp"
#include "runtime/engine/policies.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::driver {

template <class T>
using Names = std::map<std::string, T>;

// The policies and trace formats of the runtime's tables: which are choices of an option, and how the help shows them.
struct PolicyChoices {
  PolicyChoices() {
    for (const rt::PolicyRow& row : rt::policies()) {
      names.emplace(row.name, row.policy);
      shown += shown.empty() ? row.name : std::string("|") + row.name;
    }
  }
  Names<rt::Policy> names;
  std::string shown;
};
struct FormatChoices {
  explicit FormatChoices(bool (*has)(const rt::TraceFormatRow&)) {
    for (const rt::TraceFormatRow& row : rt::trace_formats()) {
      if (!has(row)) continue;
      names.emplace(row.name, row.format);
      shown += shown.empty() ? row.name : std::string("|") + row.name;
      if (*row.help != '\0') help += fmt::format("{} {} {}", help.empty() ? ":" : ",", row.name, row.help);
    }
  }
  Names<rt::TraceFormat> names;
  std::string shown;
  std::string help;  // ": bip2 is …, binary is …"
};
extern const Names<DiagnosticFormat> kFormats;
extern const Names<ColorChoice> kColors;
extern const Names<EmitKind> kEmits;
extern const Names<PrintAfter> kPrintAfter;
extern const Names<GraphFormat> kGraphFormats;
extern const Names<Shown> kShown;
extern const Names<Shell> kShells;
extern const Names<Backend> kBackends;
extern const PolicyChoices kPolicies;
extern const FormatChoices kRunFormats;
extern const FormatChoices kTextFormats;
extern const Names<rt::Engine> kEngines;
extern const Names<rt::OnLoss> kOnLoss;
extern const Names<ExportFormat> kExportFormats;
extern const Names<rt::StateReduction> kReductions;

/// An option with a closed set of values; `shown` is how the help writes them.
template <class T>
void add_choice(CLI::App& app, const std::string& name, T& value, const Names<T>& names, const std::string& shown,
                const std::string& help, const std::string& group = "Options") {
  app.add_option_function<std::string>(
         name, [&value, &names](const std::string& text) { value = names.at(text); }, help)
      ->check(CLI::Validator(
          [&names, shown](std::string& text) { return names.contains(text) ? "" : not_one_of(text, shown); }, ""))
      ->type_name(shown)
      ->group(group);
}

/// A whole number from 0 to 2^64 - 1.
[[nodiscard]] CLI::Validator is_number();
/// A whole number of a range.
[[nodiscard]] CLI::Validator is_number(std::uint64_t least, std::uint64_t greatest);
/// An option whose value is such a number.
template <class T>
void add_number(CLI::App& app, const std::string& name, T& value, const std::string& help, const char* shown = "N") {
  app.add_option(name, value, help)->check(is_number())->type_name(shown);
}
/// The model that a command is about, its only positional.
void add_model(CLI::App& command, std::string& file);
/// `--backend`, the JIT where it is built in.
void add_backend(CLI::App& command, Backend& backend);
/// Identifiers with `::` between them.
[[nodiscard]] bool is_namespace(const std::string& text);
/// A number of a range.
[[nodiscard]] CLI::Validator is_real(double least, double greatest);
/// An option whose value is a time, "10ms"; `ns` gets it in ns.
CLI::Option* add_duration(CLI::App& command, const char* name, std::int64_t& ns, const char* help);
/// Where machine code and proofs are kept, and how much of them.
void add_cache_options(CLI::App& command, CacheOptions& cache);
/// `--no-cpp`, of commands that compile and load what a model brings.
void add_no_cpp(CLI::App& command, CompileOptions& options);
/// Which levels `-O` takes.
enum class CompilerLevels : std::uint8_t { O0O2, O0O1O2 };
/// `-O`; `-O1` is for the C++ compiler only.
void add_optimisation(CLI::App& app, Optimisation& level, CompilerLevels levels, const std::string& help);
/// Of `run`: options about the code that it makes and how it is watched. After `--explore`.
void add_code_options(CLI::App& command, RunArguments& a);
/// `--priority` of the thread that takes the steps.
void add_real_time_priority(CLI::App& command, int& priority);
/// `--color`.
void add_color(CLI::App& app, ColorChoice& color);
/// `-I`.
void add_folders(CLI::App& app, CompileOptions& options);
/// What is compiled, and how far: `--root`, `--emit`, …, with add_folders and add_diagnostics.
void add_compile(CLI::App& app, CompileOptions& options);
/// A seed without which one is drawn.
void add_seed(CLI::App& command, std::uint64_t& seed, bool& is_given, const std::string& help);
/// Of debugging sessions: what is run, `trace` is the option that names one.
void add_session(CLI::App& command, SessionArguments& a, CLI::Option* trace);

}  // namespace bip::driver
