// The compiler as a library: from the text of a model to runs, explorations, proofs and pictures, in this process.
//
//   bip::compiler::CompileResult compiled = bip::compiler::compile_file("philosophers.bip", {.root = "Table(5)"});
//   if (!compiled.model) return fail(compiled.diagnostics);
//   bip::Execution system = compiled.model->start({.seed = 42});
//   system.run(1000);
//   bip::compiler::Verdict verdict = compiled.model->verify({.property = "errors"});
//
// Nothing is printed, no signal is handled, and no function throws. What a user can do wrong comes back as diagnostics.
// Functions without a model are independent of each other and may be called by several threads. One model is used by
// one thread at a time; the executions that it started are independent of it and of each other, and must not outlive
// it. A model that calls C++ is compiled by the host's compiler, as by `bipc run`; `allows_cpp` refuses that.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "bip/bip.hpp"

namespace bip::compiler {

enum class Severity : std::uint8_t { Error, Warning };
/// What is wrong with a model. Lines and columns count from 1, columns count bytes; line 0: there is no place.
struct Diagnostic {
  std::string code;  // "B1003"; compiler/docs/diagnostics.md
  Severity severity = Severity::Error;
  std::string message;
  std::string file;
  std::uint32_t line = 0, column = 0, end_line = 0, end_column = 0;
  std::string label;  // what stands under the place, may be empty
  std::vector<std::string> notes;
  std::vector<std::string> help;
};

enum class Backend : std::uint8_t { Auto, Jit, Interpreter };
struct CompileOptions {
  std::string root;                  // "Ring(10)"; empty: the parameterless compound that no other one instantiates
  std::vector<std::string> folders;  // where packages are looked for first
  Backend backend = Backend::Auto;   // Auto: the JIT if it is installed
  bool allows_cpp = true;            // the model's C++ may be compiled and loaded
  bool uses_cache = true;            // machine code and proofs are kept for the next time, in the user's cache folder
  std::uint64_t max_instances = 0;   // of atoms, of connectors; 0: what free memory holds
};

enum class Reduction : std::uint8_t { None, PartialOrder, Symmetry };
struct ExploreOptions {
  std::uint64_t max_states = ~0ull;
  double seconds = 0;           // 0: no limit
  std::uint64_t megabytes = 0;  // 0: three quarters of the free memory
  std::uint32_t threads = 0;    // 0: all processors
  Reduction reduction = Reduction::None;
  bool maximal_progress = true;
  bool trusts_cpp = false;  // C++ functions depend on their arguments alone
  std::stop_token stop;     // ends the search early
};

/// A step of a counterexample.
struct CounterexampleStep {
  std::int64_t time = 0;     // instant in ns; 0 in a model without clocks
  std::uint64_t choice = 0;  // the candidate's number in the state before it, for Execution::fire
  std::string interaction;   // "ROOT.take0"
};
/// A run from the initial state to what was found. The core has taken it.
struct Counterexample {
  std::string end;  // "deadlock", "error", "time lock", "state"
  std::vector<CounterexampleStep> steps;
  // Properties of runs: the steps from here on repeat for ever; steps.size(): none, the last state does.
  std::optional<std::size_t> cycle = std::nullopt;
  std::string text;  // for people
};

struct Exploration {
  bool is_answered = false;  // false: `diagnostics` say why
  std::string end;           // "complete", or what ended it: "limit", "memory", "time", "interrupted", "inexact"
  std::uint64_t states = 0;  // in a model with clocks: zones
  std::uint64_t steps = 0, deadlocks = 0, time_locks = 0, errors = 0;
  std::uint64_t finals = 0;  // final states: no step, and no deadlock
  std::uint32_t depth = 0;   // steps to the state that is farthest
  double seconds = 0;
  std::uint64_t bytes = 0;  // of the states
  std::optional<Counterexample> deadlock, time_lock, error;
  std::string text;  // the line that `bipc explore` prints
  std::vector<Diagnostic> diagnostics;
};

struct VerifyOptions {
  // "deadlock" or empty, "errors", "never EXPR", "always EXPR", or of runs: "eventually EXPR", "EXPR leads to EXPR" …,
  // or of what is possible: "possibly EXPR", "always possibly EXPR" …
  std::string property;
  // Properties of runs: which count, as `--fair` has it: "none" or empty, "weak", "strong:atoms",
  // "weak,strong:p.enter".
  std::string fairness;
  bool partial = false;     // instead: does a component wait for ever while others move?
  double timeout = 60;      // seconds of the processor
  double wall_timeout = 0;  // seconds of wall-clock time; 0: no limit
  std::uint64_t megabytes = 2048;
  bool wants_certificate = false;  // for certcheck; takes longer
  bool explains = false;           // the invariants of the proof are part of the text
  std::stop_token stop;            // ends the proof early; the verdict is then unknown
};
enum class Outcome : std::uint8_t { Holds, Violated, Unknown };
struct Verdict {
  bool is_answered = false;  // false: `diagnostics`, or `problem` says what is wrong with the property
  Outcome outcome = Outcome::Unknown;
  std::string name;      // "deadlock-free", "deadlock", "holds", "violated", "error-free", "error", "unknown" …
  std::string property;  // as it was read; empty: deadlock-freedom
  std::string method;    // Holds: "invariants", "induction", "exhaustive", "parts", "branching", "run"
  std::string reason;    // Unknown
  std::uint64_t states = 0, invariants = 0, lemmas = 0;
  std::string certificate;  // text for certcheck, if it was wanted and the answer has one
  // Of a violation; also the run that shows a property to hold which begins with `possibly`.
  std::optional<Counterexample> counterexample;
  std::string text;  // for people, as `bipc verify` prints it
  std::string json;  // as `bipc verify --json` prints it
  std::string problem;
  std::vector<Diagnostic> diagnostics;
};

/// Many runs, each with a seed of its own, and what is observed in each. Results depend on the seeds alone, not on the
/// number of threads.
struct SimulateOptions {
  std::uint64_t runs = 1000;
  std::uint64_t seed = 0;      // of the first run; the next one has the next
  std::uint64_t steps = 1000;  // of a run, at most
  std::int64_t until = -1;     // instant in ns at which a run ends, in a model with clocks; below 0: none
  std::string stop_condition;  // a run ends in the first state in which it holds; empty: none
  // "count NAME", "reaches EXPR", "time until EXPR", "duration of EXPR", "max EXPR", "min EXPR", "mean EXPR", "last
  // EXPR"
  std::vector<std::string> observers;
  rt::Policy policy = rt::Policy::Uniform;
  bool asap = false;          // each step at the earliest instant at which it is possible
  std::uint32_t threads = 0;  // 0: all processors; models that call C++ have one
  std::stop_token stop;       // ends the simulation early
};
/// Of the runs in which the observer is defined. Durations are in seconds, in a model without clocks in steps.
struct Estimate {
  std::uint64_t count = 0;
  double mean = 0, deviation = 0, least = 0, greatest = 0;
  double q05 = 0, median = 0, q95 = 0;  // quantiles
  double low = 0, high = 0;             // 95% interval of the mean; for `reaches` that of Clopper and Pearson
};
struct Simulation {
  bool is_answered = false;                 // false: `problem` or `diagnostics` say why
  bool is_complete = false;                 // false: stopped, and the runs that were not made have no values
  std::vector<std::string> ends;            // by run: "limit", "deadlock", "final", "error", "time", "stop", "not run"
  std::vector<std::uint64_t> steps;         // by run
  std::vector<double> times;                // by run: the instant of its end in seconds; empty without clocks
  std::vector<std::vector<double>> values;  // by observer, by run; NaN: undefined
  std::vector<Estimate> estimates;          // by observer
  std::string first_error;                  // of the first run that ended with an error
  std::string problem;                      // what is wrong with an observer or an option
  std::vector<Diagnostic> diagnostics;
};

enum class GraphFormat : std::uint8_t { Dot, Json, Svg };
enum class GraphPart : std::uint8_t { All, Structure, Automata };

/// A model that was compiled: its texts, its system and, once it is asked for, its code.
class Model {
 public:
  ~Model();
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  /// Returns the root with its arguments, "Table(5)".
  [[nodiscard]] const std::string& root() const;
  /// Returns the path of the file, or the name that the text was given.
  [[nodiscard]] const std::string& path() const;
  /// Returns the paths of all components, "ROOT.a", in the order of the system.
  [[nodiscard]] std::vector<std::string> components() const;
  /// Returns the paths of the variables of a component, "ROOT.a.x"; none if there is no such component.
  [[nodiscard]] std::vector<std::string> variables(const std::string& component) const;

  /// Makes code for execution, once. Returns what went wrong, empty if nothing did. By the JIT: tens of milliseconds.
  std::vector<Diagnostic> prepare();
  /// Returns the image with its code, for bip::Execution and the C ABI; null if prepare() fails.
  [[nodiscard]] const rt::Image* image();
  /// Starts a run. Requires that image() is not null.
  [[nodiscard]] Execution start(const ExecutionOptions& options = {});

  /// Visits all reachable states, or zones.
  [[nodiscard]] Exploration explore(const ExploreOptions& options = {});
  /// Decides a property. Compiles the same texts anew, so that the model stays as it is.
  [[nodiscard]] Verdict verify(const VerifyOptions& options = {}) const;
  /// Makes runs and estimates what the observers measure. Memory: a number an observer and a run.
  [[nodiscard]] Simulation simulate(const SimulateOptions& options = {});
  /// Returns the system as text for Graphviz, as JSON, or as a picture.
  [[nodiscard]] std::string graph(GraphFormat format = GraphFormat::Dot, GraphPart part = GraphPart::All) const;
  /// Returns the system in its text form, .bsys, which certcheck reads beside a certificate.
  [[nodiscard]] std::string system_text() const;

 private:
  friend class ModelAccess;
  Model();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct CompileResult {
  std::unique_ptr<Model> model;  // null: there are errors
  std::vector<Diagnostic> diagnostics;
  std::string text;  // the diagnostics as `bipc` prints them
};
/// Compiles a file, .bip or .bsys.
[[nodiscard]] CompileResult compile_file(const std::string& path, const CompileOptions& options = {});
/// Compiles a text. `path` is what diagnostics call it; packages are looked for in its folder.
[[nodiscard]] CompileResult compile_text(const std::string& text, const CompileOptions& options = {},
                                         const std::string& path = "model.bip");

struct CheckResult {
  std::vector<Diagnostic> diagnostics;
  std::string text;
  bool has_errors = false;
};
/// As `bipc check`: a file of types without a root is fine.
[[nodiscard]] CheckResult check_file(const std::string& path, const CompileOptions& options = {});
/// As check_file, for a text. `path` is what diagnostics call it; packages are looked for in its folder.
[[nodiscard]] CheckResult check_text(const std::string& text, const CompileOptions& options = {},
                                     const std::string& path = "model.bip");

/// The version of the library, "0.2.0".
[[nodiscard]] const char* version();

}  // namespace bip::compiler
