// See option_groups.hpp.
#include "compiler/driver/option_groups.hpp"

#include <charconv>
#include <optional>

namespace bip::driver {

std::string not_one_of(const std::string& text, const std::string& shown) {
  return fmt::format("`{}` is not one of {}", text, shown);
}

const Names<DiagnosticFormat> kFormats{{"frame", DiagnosticFormat::Frame},
                                       {"short", DiagnosticFormat::Short},
                                       {"json", DiagnosticFormat::Json},
                                       {"sarif", DiagnosticFormat::Sarif}};
const Names<ColorChoice> kColors{
    {"auto", ColorChoice::Auto}, {"always", ColorChoice::Always}, {"never", ColorChoice::Never}};
const Names<EmitKind> kEmits{{"tokens", EmitKind::Tokens}, {"syntax", EmitKind::Syntax}, {"model", EmitKind::Model},
                             {"system", EmitKind::System}, {"llvm", EmitKind::Llvm},     {"asm", EmitKind::Asm},
                             {"cpp", EmitKind::Cpp},       {"dot", EmitKind::Dot},       {"json", EmitKind::Json}};
const Names<PrintAfter> kPrintAfter{
    {"parse", PrintAfter::Parse}, {"build-model", PrintAfter::BuildModel}, {"instantiate", PrintAfter::Instantiate}};
const Names<GraphFormat> kGraphFormats{{"dot", GraphFormat::Dot},
                                       {"json", GraphFormat::Json},
                                       {"svg", GraphFormat::Svg},
                                       {"png", GraphFormat::Png},
                                       {"html", GraphFormat::Html}};
const Names<Shown> kShown{
    {"all", Shown::All}, {"structure", Shown::Structure}, {"automata", Shown::Automata}, {"modules", Shown::Modules}};
const Names<Shell> kShells{{"bash", Shell::Bash}, {"zsh", Shell::Zsh}, {"fish", Shell::Fish}};
const Names<Backend> kBackends{{"jit", Backend::Jit}, {"interp", Backend::Interp}};

const PolicyChoices kPolicies;
const FormatChoices kRunFormats([](const rt::TraceFormatRow&) { return true; });
const FormatChoices kTextFormats([](const rt::TraceFormatRow& row) { return row.is_text; });
const Names<rt::Engine> kEngines{{"sequential", rt::Engine::Sequential},
                                 {"threads", rt::Engine::Threads},
                                 {"batch", rt::Engine::Batch},
                                 {"simulated", rt::Engine::Simulated},
                                 {"distributed", rt::Engine::Distributed}};
const Names<rt::OnLoss> kOnLoss{{"stop", rt::OnLoss::Stop}, {"go-on", rt::OnLoss::GoOn}};

const Names<ExportFormat> kExportFormats{{"promela", ExportFormat::Promela},
                                         {"pnml", ExportFormat::Pnml},
                                         {"aiger", ExportFormat::Aiger},
                                         {"net", ExportFormat::Net},
                                         {"prism", ExportFormat::Prism}};
const Names<rt::StateReduction> kReductions{
    {"none", rt::StateReduction::None}, {"por", rt::StateReduction::Por}, {"symmetry", rt::StateReduction::Symmetry}};

namespace {

std::optional<std::uint64_t> whole_number(const std::string& text) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// Without an exponent and without zeros behind.
std::string decimal(double number) {
  std::string text = fmt::format("{:.6f}", number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

// CLI11 alone would take "5x" and "-1" for a number, or call them inconvertible.
CLI::Validator is_number() {
  return CLI::Validator(
      [](std::string& text) {
        return whole_number(text) ? std::string() : fmt::format("`{}` is not a whole number from 0 to 2^64 - 1", text);
      },
      "");
}

CLI::Validator is_number(std::uint64_t least, std::uint64_t greatest) {
  return CLI::Validator(
      [least, greatest](std::string& text) {
        const std::optional<std::uint64_t> number = whole_number(text);
        const bool is_good = number && *number >= least && *number <= greatest;
        return is_good ? std::string() : fmt::format("`{}` is not a whole number from {} to {}", text, least, greatest);
      },
      "");
}

void add_model(CLI::App& command, std::string& file) {
  command.add_option("FILE", file, "model file (.bip or .bsys)")->required()->type_name("");
}

void add_backend(CLI::App& command, Backend& backend) {
  add_choice(command, "--backend", backend, kBackends, "jit|interp",
             "executor of guards, actions and transfers (default: jit if it is built in)");
}

// Identifiers with `::` between them.
bool is_namespace(const std::string& text) {
  bool begins = true;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    if (c == ':' && !begins && text.compare(i, 2, "::") == 0) {
      ++i;
      begins = true;
    } else if (is_letter || (!begins && c >= '0' && c <= '9')) {
      begins = false;
    } else {
      return false;
    }
  }
  return !begins;
}

// CLI11's ranges let NaN pass, and are worded otherwise in each of its versions.
CLI::Validator is_real(double least, double greatest) {
  return CLI::Validator(
      [least, greatest](std::string& text) {
        double number = 0;
        const bool is_good = CLI::detail::lexical_cast(text, number) && number >= least && number <= greatest;
        return is_good ? std::string()
                       : fmt::format("`{}` is not a number from {} to {}", text, decimal(least), decimal(greatest));
      },
      "");
}

CLI::Option* add_duration(CLI::App& command, const char* name, std::int64_t& ns, const char* help) {
  return command
      .add_option_function<std::string>(
          name, [&ns](const std::string& text) { ns = rt::parse_time(text); }, help)
      ->check(CLI::Validator(
          [](std::string& text) {
            return rt::parse_time(text) < 0 ? fmt::format("`{}` is no duration such as 1s500ms", text) : std::string();
          },
          ""))
      ->type_name("TIME");
}

// ---- machine code and who runs it: how it is made, kept and watched, and its priority

void add_cache_options(CLI::App& command, CacheOptions& cache) {
  CLI::Option* off = command.add_flag("--no-cache", cache.is_off, "neither read nor write the cache");
  command
      .add_option("--cache", cache.folder, "folder of the cache (default: $XDG_CACHE_HOME/bipc, else ~/.cache/bipc)")
      ->type_name("DIR")
      ->excludes(off);
  command
      .add_option("--cache-size", cache.megabytes,
                  "size limit of the cache; the least recently used entries are removed (default: 256)")
      ->check(is_number(1, 1 << 20))
      ->type_name("MB");
}

// Of commands that compile and load what a model brings.
void add_no_cpp(CLI::App& command, CompileOptions& options) {
  command.add_flag("--no-cpp", options.refuses_cpp,
                   "refuse models that call C++: nothing that a model brings is compiled or loaded");
}

void add_optimisation(CLI::App& app, Optimisation& level, CompilerLevels levels, const std::string& help) {
  const bool with_o1 = levels == CompilerLevels::O0O1O2;
  const std::string shown = with_o1 ? "0|1|2" : "0|2";
  app.add_option_function<std::string>(
         "-O",
         [&level](const std::string& text) {
           level = text == "0" ? Optimisation::O0 : text == "1" ? Optimisation::O1 : Optimisation::O2;
         },
         help)
      ->check(CLI::Validator(
          [shown, with_o1](std::string& text) {
            return text == "0" || text == "2" || (with_o1 && text == "1") ? "" : not_one_of(text, shown);
          },
          ""))
      ->type_name(shown);
}

// Of `run`: options about the code that it makes and how it is watched. After --explore.
void add_code_options(CLI::App& command, RunArguments& a) {
  command
      .add_flag(
          "-g", a.for_debuggers,
          "generate debug information that maps machine code to lines of the model, for gdb and perf (--backend=jit)")
      ->excludes("--explore");
  CLI::Option* explores = command.get_option("--explore");
  command.add_flag("--profile", a.profile, "print a profile at the end: time per interaction, type, guard and action")
      ->excludes(explores);
  command.add_option("--profile-json", a.profile_path, "write the profile as JSON to PATH")
      ->type_name("PATH")
      ->excludes(explores);
}

void add_real_time_priority(CLI::App& command, int& priority) {
  command
      .add_option("--real-time-priority", priority,
                  "in real time, run with scheduling priority N (SCHED_FIFO, 1 to 99) and locked memory; a refusal is "
                  "a warning")
      ->check(is_number(1, 99))
      ->type_name("N");
}

void add_color(CLI::App& app, ColorChoice& color) {
  add_choice(app, "--color", color, kColors, "auto|always|never",
             "coloured diagnostics (default: auto, which means on a terminal unless NO_COLOR is set)");
}

void add_diagnostics(CLI::App& app, CompileOptions& options) {
  add_choice(app, "--diagnostics", options.render.format, kFormats, "frame|short|json|sarif",
             "format of errors and warnings (default: frame)");
  add_color(app, options.color);
  app.add_flag("--Werror", options.fatal_warnings,
               "treat all warnings as errors; --Werror=CODE treats warnings of one code as errors and may be repeated")
      ->check(CLI::Validator(
          [](std::string& text) {
            const std::optional<Diag> kind = find_diag(text);
            if (text == "true" || (kind && info(*kind).severity == Severity::Warning)) return std::string();
            return fmt::format("`{}` is not the code of a warning", text);
          },
          ""));
  app.add_flag("--explain", options.explain,
               "print the explain page of the first error, or of the first warning if there is no error");
}

void add_folders(CLI::App& app, CompileOptions& options) {
  app.add_option("-I", options.folders,
                 "search DIR for packages, before the folder of the file and the standard library; may be repeated")
      ->allow_extra_args(false)
      ->type_name("DIR");
}

void add_compile(CLI::App& app, CompileOptions& options) {
  add_folders(app, options);
  app.add_option(
         "--root", options.root,
         "root component, for example 'Ring(10)' (default: the only parameterless compound that nothing instantiates)")
      ->type_name("TYPE(ARGS)");
  add_number(app, "--max-instances", options.max_instances,
             "refuse a system of more than N atoms, or as many compounds, connectors or priorities (default: what "
             "three quarters of "
             "the free memory hold, at least 2000000)");
  add_choice(app, "--emit", options.emit, kEmits, "tokens|syntax|model|system|llvm|asm|cpp|dot|json",
             "print the product of this stage of the compiler and stop");
  add_choice(app, "--print-after", options.print_after, kPrintAfter, "parse|build-model|instantiate",
             "print the product of this pass to standard error and go on");
  app.add_flag("--time-passes", options.time_passes, "print the duration of each pass to standard error");
  app.add_flag("--verify-each", options.verify_each,
               "check the invariants of the compiler's data structures after each pass");
  add_diagnostics(app, options);
}

// A seed without which one is drawn.
void add_seed(CLI::App& command, std::uint64_t& seed, bool& is_given, const std::string& help) {
  command
      .add_option_function<std::uint64_t>(
          "--seed",
          [&seed, &is_given](const std::uint64_t& value) {
            seed = value;
            is_given = true;
          },
          help)
      ->check(is_number())
      ->type_name("N");
}

// How a debugging session's steps are chosen.
void add_session(CLI::App& command, SessionArguments& a, CLI::Option* trace) {
  rt::SessionOptions& session = a.session;
  add_number(command, "--seed", session.seed, "seed of the random choices (default: 0)");
  add_choice(command, "--policy", session.policy, kPolicies.names, kPolicies.shown,
             "how the next step is chosen among the candidates (default: uniform)");
  command.add_flag("-a,--asap", session.asap,
                   "take each step at the earliest instant at which it is possible (for models with clocks)");
  command
      .add_option("--events", a.events_path,
                  "read external events from PATH, one JSON object per line, ordered by time")
      ->excludes(trace)
      ->type_name("PATH");
  command.add_flag("--trust-cpp", session.trusts_cpp,
                   "assume that the model's C++ functions depend on their arguments only, so that the session can go "
                   "back");
  command.add_flag_callback(
      "--disable-maximal-progress", [&session] { session.progress = rt::MaximalProgress::Off; },
      "disable maximal progress: an interaction may fire although a larger one of its connector is enabled");
  add_choice(command, "--backend", a.backend, kBackends, "jit|interp",
             "executor of guards, actions and transfers (default: interp)");
}

}  // namespace bip::driver
