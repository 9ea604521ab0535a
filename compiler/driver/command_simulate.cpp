// `bipc simulate`: many runs in one process, and estimates of what observers saw in them.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/driver/simulate_queries.hpp"
#include "compiler/library/observer_estimate.hpp"
#include "compiler/library/read_observer.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/ffi_build.hpp"
#include "compiler/pipeline/machine.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/terminal.hpp"
#include "compiler/system/uses_time.hpp"
#include "runtime/engine/event_file.hpp"
#include "runtime/engine/interrupt.hpp"
#include "runtime/engine/scheduler.hpp"
#include "runtime/engine/simulate.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {
namespace {

using library::Estimate;

constexpr std::size_t kBins = 20;
constexpr std::uint32_t kMostThreads = 256;

using Json = nlohmann::ordered_json;
using EndCounts = std::array<std::uint64_t, rt::kSimulatedEnds>;

struct Histogram {
  double first = 0, width = 0;
  std::vector<std::uint64_t> counts;
};

// Of equal widths from the least to the greatest value; one bin if they are equal.
Histogram histogram_of(const std::vector<double>& values, const Estimate& of) {
  Histogram made{of.least, (of.greatest - of.least) / kBins, {}};
  // An infinite value, or a range beyond all numbers: bins would have no bounds.
  if (!std::isfinite(made.width)) made.width = 0;
  if (of.count == 0) return made;
  made.counts.assign(made.width > 0 ? kBins : 1, 0);
  for (const double value : values) {
    if (std::isnan(value)) continue;
    const double bin = made.width > 0 ? std::floor((value - made.first) / made.width) : 0;
    BIP_ASSERT(bin >= 0 && bin <= kBins, "{} from {} on is in bin {}", value, made.first, bin);
    ++made.counts[std::min(static_cast<std::size_t>(bin), made.counts.size() - 1)];
  }
  BIP_ASSERT(std::accumulate(made.counts.begin(), made.counts.end(), std::uint64_t{0}) == of.count,
             "{} bins do not hold all of {} values", made.counts.size(), of.count);
  return made;
}

std::string number(double value) { return std::isnan(value) ? "-" : fmt::format("{:.6g}", value); }

std::uint64_t total_of(const std::vector<std::uint64_t>& steps) {
  std::uint64_t sum = 0;
  for (const std::uint64_t count : steps) sum += count;
  return sum;
}

EndCounts ends_of(const rt::SimulateReport& report) {
  EndCounts counts{};
  for (const rt::SimulatedEnd end : report.ends) {
    if (end != rt::SimulatedEnd::NotRun) ++counts[static_cast<std::size_t>(end)];
  }
  return counts;
}

std::string ends_text(const EndCounts& counts) {
  std::string text;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (counts[k] != 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts[k], name_of(static_cast<rt::SimulatedEnd>(k)));
  }
  return text;
}

std::string text_of(const rt::SimulateReport& report, const rt::SimulateOptions& options, bool shows_bins,
                    double confidence) {
  const EndCounts ends = ends_of(report);
  std::uint64_t runs = 0;
  for (const std::uint64_t count : ends) runs += count;
  std::string text =
      fmt::format("{}: {} run{}, seeds from {}, {} steps; ends: {}\n", report.is_complete ? "simulated" : "interrupted",
                  runs, runs == 1 ? "" : "s", options.seed, total_of(report.steps), ends_text(ends));
  std::size_t width = std::string_view("observer").size();
  for (const rt::Observer& o : options.observers) width = std::max(width, o.text.size());
  if (!options.observers.empty())
    text += fmt::format(
        "{:<{}}  {:>8}  {:>10}  {:>10}  {:>10}  {:>10}  {:>10}  {:>10}  {:>10}  {}% interval of the mean\n", "observer",
        width, "runs", "mean", "deviation", "least", "5%", "median", "95%", "greatest", 100 * confidence);
  for (std::size_t k = 0; k < options.observers.size(); ++k) {
    const auto [of, interval] = library::estimate_of(options.observers[k], report.values[k], confidence);
    text += fmt::format("{:<{}}  {:>8}", options.observers[k].text, width, of.count);
    if (of.count == 0) {
      text += "  in no run\n";
      continue;
    }
    for (const double value :
         {of.mean, of.deviation, of.least, of.quantiles[0], of.quantiles[1], of.quantiles[2], of.greatest})
      text += fmt::format("  {:>10}", number(value));
    text += fmt::format("  [{}, {}]\n", number(interval.low), number(interval.high));
    if (!shows_bins) continue;
    const Histogram bins = histogram_of(report.values[k], of);
    const std::uint64_t most = *std::max_element(bins.counts.begin(), bins.counts.end());
    constexpr std::uint64_t kLongestBar = 50;
    for (std::size_t bin = 0; bin < bins.counts.size(); ++bin) {
      text += fmt::format("  {:>12}  {:>8}  {}\n", number(bins.first + static_cast<double>(bin) * bins.width),
                          bins.counts[bin], std::string(bins.counts[bin] * kLongestBar / most, '#'));
    }
  }
  return text;
}

Json json_of(const rt::SimulateReport& report, const rt::SimulateOptions& options, double confidence) {
  Json json{{"format", "bipc-simulation"},
            {"version", 1},
            {"complete", report.is_complete},
            {"seed", options.seed},
            {"steps", total_of(report.steps)}};
  const EndCounts ends = ends_of(report);
  BIP_ASSERT(report.values.size() >= options.observers.size(), "values of {} observers of {}", report.values.size(),
             options.observers.size());
  std::uint64_t runs = 0;
  for (std::size_t k = 0; k < ends.size(); ++k) {
    json["ends"][name_of(static_cast<rt::SimulatedEnd>(k))] = ends[k];
    runs += ends[k];
  }
  json["runs"] = runs;
  json["observers"] = Json::array();
  for (std::size_t k = 0; k < options.observers.size(); ++k) {
    const auto [of, interval] = library::estimate_of(options.observers[k], report.values[k], confidence);
    Json row{{"observer", options.observers[k].text}, {"runs", of.count}};
    if (of.count != 0) {
      const Histogram bins = histogram_of(report.values[k], of);
      row.update({{"mean", of.mean},
                  {"deviation", of.deviation},
                  {"least", of.least},
                  {"q05", of.quantiles[0]},
                  {"median", of.quantiles[1]},
                  {"q95", of.quantiles[2]},
                  {"greatest", of.greatest},
                  {"confidence", confidence},
                  {"interval", {interval.low, interval.high}},
                  {"histogram", {{"first", bins.first}, {"width", bins.width}, {"counts", bins.counts}}}});
    }
    json["observers"].push_back(std::move(row));
  }
  return json;
}

// RFC 4180: a field with a comma or a quote is quoted.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

std::string csv_of(const rt::SimulateReport& report, const rt::SimulateOptions& options) {
  BIP_ASSERT(
      report.steps.size() == report.ends.size() && (report.times.empty() || report.times.size() == report.ends.size()),
      "{} ends of runs, {} lengths, {} instants", report.ends.size(), report.steps.size(), report.times.size());
  std::string text = "seed,end,steps";
  if (!report.times.empty()) text += ",time";
  for (const rt::Observer& o : options.observers) text += "," + csv_field(o.text);
  text += "\n";
  for (std::size_t run = 0; run < report.ends.size(); ++run) {
    if (report.ends[run] == rt::SimulatedEnd::NotRun) continue;
    text += fmt::format("{},{},{}", options.seed + run, name_of(report.ends[run]), report.steps[run]);
    if (!report.times.empty()) text += fmt::format(",{}", report.times[run]);
    for (std::size_t k = 0; k < options.observers.size(); ++k)
      text += std::isnan(report.values[k][run]) ? "," : fmt::format(",{}", report.values[k][run]);
    text += "\n";
  }
  return text;
}

// One line on a terminal, ten times a second at most.
class RunsProgressLine {
 public:
  explicit RunsProgressLine(std::uint64_t runs) : runs_(runs), is_on_(::isatty(STDERR_FILENO) != 0) {}
  void tell(std::uint64_t done) {
    const auto now = std::chrono::steady_clock::now();
    if (!is_on_ || now < next_) return;
    next_ = now + std::chrono::milliseconds(100);
    is_shown_ = true;
    write_now(stderr, fmt::format("\r{} of {} runs   ", done, runs_));
  }
  void clear() const {
    if (is_shown_) write_now(stderr, "\r\x1b[K");
  }

 private:
  std::uint64_t runs_;
  bool is_on_, is_shown_ = false;
  std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
};

bool refuse(const char* option, const std::string& why) {
  usage_error(fmt::format("{}, {}", option, why));
  return false;
}

// Parses the observers and the stop condition, and resolves their names in the system. Returns false after it has
// printed an error.
bool read_questions(const SimulateArguments& a, const System& system, rt::SimulateOptions& options) {
  for (const std::string& text : a.observers) {
    Result<rt::Observer> observer = library::read_observer(text, system);
    if (!observer) return refuse("--observe", observer.error());
    options.observers.push_back(std::move(*observer));
  }
  if (a.stop.empty()) return true;
  Result<std::function<bool(const rt::Core&)>> stop = library::read_condition(a.stop, system);
  if (!stop) return refuse("--stop", stop.error());
  options.stop = std::move(*stop);
  return true;
}

// Compiled steps are worth their milliseconds where there are many.
Optimisation optimisation_of(const SimulateArguments& a, const rt::SimulateOptions& options) {
  constexpr std::uint64_t kManySteps = 1'000'000;
  const bool are_many = options.limit != 0 && options.runs > kManySteps / options.limit;
  return a.optimisation == Optimisation::Auto && are_many ? Optimisation::O2 : a.optimisation;
}

// False: the values of all runs do not fit into half of what is free.
bool fits_memory(const rt::SimulateOptions& options) {
  const std::uint64_t bytes = library::bytes_of_run(options);
  if (options.runs <= available_memory() / 2 / bytes) return true;
  return refuse("--runs", fmt::format("{} runs of {} bytes each are more than the free memory", options.runs, bytes));
}

}  // namespace

namespace {

// Makes the runs that observers and estimates need, if any, and then those of each test. `observers`: how many of
// options.observers are options; the others belong to queries. Returns kOk, or the exit code after an error was
// reported.
int simulate_all(const SimulateArguments& arguments, Compilation& c, rt::SimulateOptions options, std::size_t observers,
                 const std::vector<library::Query>& queries, QueryReport& answers, std::string& text, Json& json) {
  const bool has_runs = queries.empty() || !options.observers.empty() || !options.queries.empty();
  BIP_ASSERT(observers <= options.observers.size(), "{} of {} observers are options", observers,
             options.observers.size());
  if (has_runs) {
    RunsProgressLine progress(options.runs);
    options.on_progress = [&](std::uint64_t done) { progress.tell(done); };
    const rt::SimulateReport found = rt::simulate(c.lowered->image, options);
    progress.clear();
    options.on_progress = {};
    report_estimates(queries, found, arguments.confidence, answers);
    answers.is_complete = found.is_complete;
    answers.first_fault = found.first_fault;
    // Queries print what they observe.
    options.observers.resize(observers);
    if (!arguments.csv_path.empty()) {
      if (const Result<bool> written = write_file(arguments.csv_path, csv_of(found, options)); !written) {
        c.diags.report(Diag::kB5004, {}, arguments.csv_path, written.error());
        return report(c);
      }
    }
    text = text_of(found, options, arguments.shows_histogram, arguments.confidence);
    json = json_of(found, options, arguments.confidence);
  }
  if (answers.is_complete) report_tests(queries, arguments, c.lowered->image, options, answers);
  return kOk;
}

}  // namespace

int command_simulate(const SimulateArguments& arguments) {
  Compilation c(arguments.compile);
  if (!compile(c, arguments.file, Stage::Image) || !check_outputs(c, {arguments.csv_path}) ||
      !check_writable(c, {arguments.csv_path}))
    return report(c);
  rt::SimulateOptions options = arguments.simulate;
  if (arguments.within > 0) options.runs = library::runs_for(arguments.within, arguments.confidence);
  if (!read_questions(arguments, *c.system, options)) return kUsage;
  const std::optional<std::vector<library::Query>> queries = read_queries(arguments, c);
  if (!queries) return kUsage;
  if (!arguments.until.empty()) {
    if (!system::is_timed(*c.system)) return refuse("--until", "the model has no clocks"), kUsage;
    options.until = rt::parse_time(arguments.until);
    if (options.until < 0)
      return refuse("--until", fmt::format("`{}` is no duration such as 1s500ms", arguments.until)), kUsage;
  }
  if (!fits_memory(options)) return kUsage;
  Executor executor;
  const bool ready = executor.prepare(c, arguments.backend, optimisation_of(arguments, options));
  if (const int code = report(c); code != 0 || !ready) return code;
  if (!arguments.has_seed) options.seed = rt::draw_seed();
  // The model's C++ may keep what no core knows of.
  options.threads = uses_ffi(c) ? 1
                    : arguments.threads == 0
                        ? processors()
                        : static_cast<std::uint32_t>(std::min<std::uint64_t>(arguments.threads, kMostThreads));
  const rt::InterruptGuard guard;
  QueryReport answers;
  std::string text;
  Json json{{"format", "bipc-simulation"}, {"version", 1}, {"complete", true}, {"seed", options.seed}};
  if (arguments.exact) {
    if (!report_exact(*queries, c, options.progress, answers)) return kUsage;
    json.erase("seed");
  } else if (!arguments.importance.empty()) {
    if (!report_split(*queries, arguments, c, options, answers)) return kUsage;
    text = fmt::format("seed {}\n", options.seed);
  } else {
    const std::size_t observers = options.observers.size();
    add_queries(*queries, options);
    if (const int code = simulate_all(arguments, c, options, observers, *queries, answers, text, json); code != kOk)
      return code;
  }
  json["complete"] = answers.is_complete;
  if (!queries->empty()) json["queries"] = answers.json;
  if (!answers.first_fault.empty()) {
    json["first_error"] = answers.first_fault;
    answers.text += "the first error:\n" + answers.first_fault;
  }
  write_now(stdout, arguments.json ? json_line(json) + '\n' : text + answers.text);
  if (!answers.is_complete) return 128 + rt::interrupting_signal();
  if (!answers.first_fault.empty()) return kModelErrors;
  return answers.is_violated ? kViolated : answers.is_unknown ? kUnknown : kOk;
}

}  // namespace bip::driver
