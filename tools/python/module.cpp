// The Python module bipc._bipc: bip/compiler.hpp and bip/bip.hpp as Python objects; bipc/__init__.py makes them handy.
//
// Work is done without the GIL. Long work is done by another thread, while the one that Python called looks for
// signals, so that Ctrl-C ends it. A model and a system have a mutex each: Python's threads may share them.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <future>
#include <mutex>
#include <stop_token>
#include <unordered_map>
#include <variant>

#include "bip/compiler.hpp"
#include "runtime/engine/policies.hpp"

namespace py = pybind11;
namespace bc = bip::compiler;

namespace {

constexpr auto kSignalPeriod = std::chrono::milliseconds(20);
// Steps between two looks for signals.
constexpr std::uint64_t kStepsAtOnce = 1 << 16;

const char* name_of(bip::Outcome outcome) {
  switch (outcome) {
    case bip::Outcome::Stepped: return "stepped";
    case bip::Outcome::Deadlock: return "deadlock";
    case bip::Outcome::Fault: return "fault";
    case bip::Outcome::Stopped: return "stopped";
    case bip::Outcome::Final: return "final";
  }
  return "";
}

/// Returns work(stop token), done by another thread without the GIL; a signal whose handler raises stops it.
template <class Work>
auto interruptible(Work work) {
  std::stop_source stop;
  auto result = std::async(std::launch::async, [&] { return work(stop.get_token()); });
  for (;;) {
    {
      const py::gil_scoped_release free;
      if (result.wait_for(kSignalPeriod) == std::future_status::ready) break;
    }
    if (PyErr_CheckSignals() == 0) continue;
    stop.request_stop();
    {
      const py::gil_scoped_release free;
      result.wait();
    }
    throw py::error_already_set();
  }
  return result.get();
}

struct PyModel {
  std::unique_ptr<bc::Model> model;
  std::mutex mutex;

  void prepare() {
    std::vector<bc::Diagnostic> problems;
    {
      const py::gil_scoped_release free;
      const std::scoped_lock lock(mutex);
      problems = model->prepare();
    }
    if (problems.empty()) return;
    py::module_::import("bipc").attr("_raise_compile_error")(problems, "");
  }
};

struct PySystem {
  explicit PySystem(PyModel& model, const bip::ExecutionOptions& options)
      : execution(model.model->start(options)), is_real(options.speed > 0) {}
  bip::Execution execution;
  std::mutex mutex;
  bool is_real;

  template <class Work>
  auto locked(Work work) {
    const py::gil_scoped_release free;
    const std::scoped_lock lock(mutex);
    return work();
  }
  std::uint64_t run(std::uint64_t n) {
    if (is_real) {
      return interruptible([&](const std::stop_token& stop) {
        const std::scoped_lock lock(mutex);
        const std::stop_callback on_stop(stop, [this] { execution.stop(); });
        const std::uint64_t done = execution.run(n);
        if (stop.stop_requested()) execution.go_on();
        return done;
      });
    }
    std::uint64_t done = 0;
    while (done < n) {
      const std::uint64_t wanted = std::min(n - done, kStepsAtOnce);
      const std::uint64_t taken = locked([&] { return execution.run(wanted); });
      done += taken;
      if (taken < wanted) break;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
    return done;
  }
};

// Steps as columns: an interaction is a row of `names`.
struct Columns {
  std::vector<std::string> names;
  std::vector<std::uint32_t> interactions;
  std::vector<std::int64_t> times;
  std::vector<std::tuple<std::uint64_t, std::string, bip::EventValue>> values;  // step, "ROOT.a.port.variable", value
};

py::tuple record(PySystem& system, std::uint64_t n, bool has_values) {
  Columns columns;
  std::unordered_map<std::string, std::uint32_t> rows;
  const std::uint64_t first = system.execution.steps();
  system.execution.on_step([&](const bip::Step& step) {
    const auto [at, is_new] = rows.emplace(step.interaction, static_cast<std::uint32_t>(columns.names.size()));
    if (is_new) columns.names.push_back(step.interaction);
    columns.interactions.push_back(at->second);
    columns.times.push_back(system.execution.now());
    if (!has_values) return;
    for (const bip::StepValue& value : step.values)
      columns.values.emplace_back(step.number - first, step.ports[value.port] + "." + value.name, value.value);
  });
  struct RemoveCallback {
    bip::Execution& execution;
    ~RemoveCallback() { execution.on_step(nullptr); }
  } remove{system.execution};
  system.run(n);
  return py::make_tuple(first, columns.names, columns.interactions, columns.times, columns.values);
}

py::object read_variable(PySystem& system, const std::string& path) {
  std::int32_t whole = 0;
  bool truth = false;
  double real = 0;
  std::string text;
  const std::scoped_lock lock(system.mutex);
  if (system.execution.read(path, whole)) return py::int_(whole);
  if (system.execution.read(path, truth)) return py::bool_(truth);
  if (system.execution.read(path, real)) return py::float_(real);
  if (system.execution.read(path, text)) return py::str(text);
  throw py::key_error(path);
}

bc::CompileOptions compile_options(const std::string& root, const std::vector<std::string>& folders,
                                   const std::string& backend, bool allows_cpp, bool uses_cache,
                                   std::uint64_t max_instances) {
  bc::CompileOptions options{.root = root,
                             .folders = folders,
                             .allows_cpp = allows_cpp,
                             .uses_cache = uses_cache,
                             .max_instances = max_instances};
  if (backend == "jit") options.backend = bc::Backend::Jit;
  else if (backend == "interp") options.backend = bc::Backend::Interpreter;
  else if (backend != "auto") throw py::value_error("backend: auto, jit or interp, not `" + backend + "`");
  return options;
}

bip::rt::Policy policy_of(const std::string& name) {
  if (const bip::rt::PolicyRow* row = bip::rt::find_policy(name)) return row->policy;
  std::string names;
  const auto rows = bip::rt::policies();
  for (std::size_t k = 0; k < rows.size(); ++k)
    names += (k == 0 ? "" : k + 1 == rows.size() ? " or " : ", ") + std::string(rows[k].name);
  throw py::value_error("policy: " + names + ", not `" + name + "`");
}

bc::Reduction reduction_of(const std::string& name) {
  if (name == "none") return bc::Reduction::None;
  if (name == "por") return bc::Reduction::PartialOrder;
  if (name == "symmetry") return bc::Reduction::Symmetry;
  throw py::value_error("reduction: none, por or symmetry, not `" + name + "`");
}

}  // namespace

PYBIND11_MODULE(_bipc, m) {
  m.doc() = "bip::compiler and bip::Execution; use the package bipc";
  m.attr("__version__") = bc::version();

  py::class_<bc::Diagnostic>(m, "Diagnostic")
      .def_readonly("code", &bc::Diagnostic::code)
      .def_property_readonly(
          "severity", [](const bc::Diagnostic& d) { return d.severity == bc::Severity::Error ? "error" : "warning"; })
      .def_readonly("message", &bc::Diagnostic::message)
      .def_readonly("file", &bc::Diagnostic::file)
      .def_readonly("line", &bc::Diagnostic::line)
      .def_readonly("column", &bc::Diagnostic::column)
      .def_readonly("end_line", &bc::Diagnostic::end_line)
      .def_readonly("end_column", &bc::Diagnostic::end_column)
      .def_readonly("label", &bc::Diagnostic::label)
      .def_readonly("notes", &bc::Diagnostic::notes)
      .def_readonly("help", &bc::Diagnostic::help)
      .def("__repr__", [](const bc::Diagnostic& d) {
        const std::string place =
            d.line == 0 ? "" : d.file + ":" + std::to_string(d.line) + ":" + std::to_string(d.column) + ": ";
        return "<" + place + d.code + ": " + d.message + ">";
      });

  py::class_<bc::CounterexampleStep>(m, "CounterexampleStep")
      .def_readonly("time", &bc::CounterexampleStep::time)
      .def_readonly("choice", &bc::CounterexampleStep::choice)
      .def_readonly("interaction", &bc::CounterexampleStep::interaction)
      .def("__repr__", [](const bc::CounterexampleStep& step) { return "<" + step.interaction + ">"; });
  py::class_<bc::Counterexample>(m, "Counterexample")
      .def_readonly("end", &bc::Counterexample::end)
      .def_readonly("steps", &bc::Counterexample::steps)
      .def_readonly("cycle", &bc::Counterexample::cycle)
      .def_readonly("text", &bc::Counterexample::text)
      .def("__len__", [](const bc::Counterexample& run) { return run.steps.size(); })
      .def("__str__", [](const bc::Counterexample& run) { return run.text; });

  py::class_<bc::Exploration>(m, "Exploration")
      .def_readonly("end", &bc::Exploration::end)
      .def_readonly("states", &bc::Exploration::states)
      .def_readonly("steps", &bc::Exploration::steps)
      .def_readonly("deadlocks", &bc::Exploration::deadlocks)
      .def_readonly("finals", &bc::Exploration::finals)
      .def_readonly("time_locks", &bc::Exploration::time_locks)
      .def_readonly("errors", &bc::Exploration::errors)
      .def_readonly("depth", &bc::Exploration::depth)
      .def_readonly("seconds", &bc::Exploration::seconds)
      .def_readonly("bytes", &bc::Exploration::bytes)
      .def_readonly("deadlock", &bc::Exploration::deadlock)
      .def_readonly("time_lock", &bc::Exploration::time_lock)
      .def_readonly("error", &bc::Exploration::error)
      .def_readonly("text", &bc::Exploration::text)
      .def("__str__", [](const bc::Exploration& found) { return found.text; });

  py::class_<bc::Verdict>(m, "Verdict")
      .def_readonly("name", &bc::Verdict::name)
      .def_property_readonly("holds", [](const bc::Verdict& v) { return v.outcome == bc::Outcome::Holds; })
      .def_property_readonly("violated", [](const bc::Verdict& v) { return v.outcome == bc::Outcome::Violated; })
      .def_property_readonly("unknown", [](const bc::Verdict& v) { return v.outcome == bc::Outcome::Unknown; })
      .def_readonly("property", &bc::Verdict::property)
      .def_readonly("method", &bc::Verdict::method)
      .def_readonly("reason", &bc::Verdict::reason)
      .def_readonly("states", &bc::Verdict::states)
      .def_readonly("invariants", &bc::Verdict::invariants)
      .def_readonly("lemmas", &bc::Verdict::lemmas)
      .def_readonly("certificate", &bc::Verdict::certificate)
      .def_readonly("counterexample", &bc::Verdict::counterexample)
      .def_readonly("text", &bc::Verdict::text)
      .def_readonly("json", &bc::Verdict::json)
      .def_readonly("diagnostics", &bc::Verdict::diagnostics)
      .def("__str__", [](const bc::Verdict& v) { return v.text; });

  py::class_<bip::Execution::Snapshot>(m, "Snapshot");

  py::class_<PySystem>(m, "System")
      .def("step",
           [](PySystem& s) {
             return s.is_real ? (s.run(1), name_of(s.execution.outcome()))
                              : name_of(s.locked([&] { return s.execution.step(); }));
           })
      .def("run", &PySystem::run, py::arg("steps"))
      .def("_record", &record)
      .def("candidates",
           [](PySystem& s) {
             const std::scoped_lock lock(s.mutex);
             std::vector<std::string> names;
             for (std::uint64_t k = 0; k < s.execution.candidate_count(); ++k)
               names.push_back(s.execution.candidate(k));
             return names;
           })
      .def("_fire", [](PySystem& s, std::uint64_t k) { return name_of(s.locked([&] { return s.execution.fire(k); })); })
      .def("snapshot", [](PySystem& s) { return s.locked([&] { return s.execution.snapshot(); }); })
      .def("restore",
           [](PySystem& s, const bip::Execution::Snapshot& saved) { s.locked([&] { s.execution.restore(saved); }); })
      .def("place",
           [](PySystem& s, const std::string& path) {
             const std::scoped_lock lock(s.mutex);
             const std::string place = s.execution.place(path);
             if (place.empty()) throw py::key_error(path);
             return place;
           })
      .def("read", &read_variable)
      .def(
          "post",
          [](PySystem& s, const std::string& port, std::vector<bip::EventValue> values) {
            switch (s.execution.post(port, std::move(values))) {
              case bip::Posted::Taken: return true;
              case bip::Posted::Full: return false;
              case bip::Posted::NoSuchPort: throw py::key_error(port);
              case bip::Posted::BadValues: break;
            }
            throw py::type_error("the values are not those of the port `" + port + "`");
          },
          py::arg("port"), py::arg("values") = std::vector<bip::EventValue>())
      .def("stop", [](PySystem& s) { s.execution.stop(); })
      .def("go_on", [](PySystem& s) { s.execution.go_on(); })
      .def_property_readonly("outcome", [](PySystem& s) { return name_of(s.execution.outcome()); })
      .def_property_readonly("steps", [](PySystem& s) { return s.execution.steps(); })
      .def_property_readonly("now", [](PySystem& s) { return s.execution.now(); })
      .def_property_readonly("fault", [](PySystem& s) { return s.execution.fault(); })
      .def_property_readonly("story", [](PySystem& s) { return s.execution.story(); });

  py::class_<bc::Estimate>(m, "Estimate")
      .def_readonly("count", &bc::Estimate::count)
      .def_readonly("mean", &bc::Estimate::mean)
      .def_readonly("deviation", &bc::Estimate::deviation)
      .def_readonly("least", &bc::Estimate::least)
      .def_readonly("greatest", &bc::Estimate::greatest)
      .def_readonly("q05", &bc::Estimate::q05)
      .def_readonly("median", &bc::Estimate::median)
      .def_readonly("q95", &bc::Estimate::q95)
      .def_readonly("low", &bc::Estimate::low)
      .def_readonly("high", &bc::Estimate::high)
      .def("__repr__", [](const bc::Estimate& e) {
        return "<bipc.Estimate: " + std::to_string(e.mean) + " in [" + std::to_string(e.low) + ", " +
               std::to_string(e.high) + "], " + std::to_string(e.count) + " runs>";
      });

  py::class_<PyModel>(m, "Model")
      .def_property_readonly("root", [](PyModel& p) { return p.model->root(); })
      .def_property_readonly("path", [](PyModel& p) { return p.model->path(); })
      .def_property_readonly("components", [](PyModel& p) { return p.model->components(); })
      .def("variables", [](PyModel& p, const std::string& path) { return p.model->variables(path); })
      .def("prepare", &PyModel::prepare)
      .def(
          "_start",
          [](PyModel& p, std::uint64_t seed, const std::string& policy, bool maximal_progress, bool asap, double speed,
             bool strict) {
            bip::ExecutionOptions options{.seed = seed,
                                          .policy = policy_of(policy),
                                          .maximal_progress = maximal_progress,
                                          .asap = asap,
                                          .speed = speed,
                                          .strict = strict};
            p.prepare();
            const py::gil_scoped_release free;
            const std::scoped_lock lock(p.mutex);
            return std::make_unique<PySystem>(p, options);
          },
          py::keep_alive<0, 1>())
      .def("_simulate",
           [](PyModel& p, std::uint64_t runs, std::uint64_t seed, std::uint64_t steps, std::int64_t until,
              const std::string& stop, const std::vector<std::string>& observers, const std::string& policy, bool asap,
              std::uint32_t threads) {
             bc::SimulateOptions options{.runs = runs,
                                         .seed = seed,
                                         .steps = steps,
                                         .until = until,
                                         .stop_condition = stop,
                                         .observers = observers,
                                         .policy = policy_of(policy),
                                         .asap = asap,
                                         .threads = threads,
                                         .stop = {}};
             bc::Simulation made = interruptible([&](const std::stop_token& token) {
               const std::scoped_lock lock(p.mutex);
               options.stop = token;
               return p.model->simulate(options);
             });
             if (!made.problem.empty()) throw py::value_error(made.problem);
             if (!made.is_answered) py::module_::import("bipc").attr("_raise_compile_error")(made.diagnostics, "");
             return py::make_tuple(std::move(made.ends), std::move(made.steps), std::move(made.times),
                                   std::move(made.values), std::move(made.estimates), std::move(made.first_error));
           })
      .def("_explore",
           [](PyModel& p, std::uint64_t max_states, double seconds, std::uint64_t megabytes, std::uint32_t threads,
              const std::string& reduction, bool maximal_progress, bool trusts_cpp) {
             bc::ExploreOptions options{.max_states = max_states,
                                        .seconds = seconds,
                                        .megabytes = megabytes,
                                        .threads = threads,
                                        .reduction = reduction_of(reduction),
                                        .maximal_progress = maximal_progress,
                                        .trusts_cpp = trusts_cpp,
                                        .stop = {}};
             bc::Exploration found = interruptible([&](const std::stop_token& stop) {
               const std::scoped_lock lock(p.mutex);
               options.stop = stop;
               return p.model->explore(options);
             });
             if (!found.is_answered) py::module_::import("bipc").attr("_raise_compile_error")(found.diagnostics, "");
             return found;
           })
      .def("_verify",
           [](PyModel& p, const std::string& property, bool partial, double timeout, double wall_timeout,
              std::uint64_t megabytes, bool certificate, bool explains, const std::string& fairness) {
             bc::VerifyOptions options{.property = property,
                                       .fairness = fairness,
                                       .partial = partial,
                                       .timeout = timeout,
                                       .wall_timeout = wall_timeout,
                                       .megabytes = megabytes,
                                       .wants_certificate = certificate,
                                       .explains = explains,
                                       .stop = {}};
             bc::Verdict verdict = interruptible([&](const std::stop_token& stop) {
               const std::scoped_lock lock(p.mutex);
               options.stop = stop;
               return p.model->verify(options);
             });
             if (!verdict.problem.empty()) throw py::value_error(verdict.problem);
             if (!verdict.is_answered)
               py::module_::import("bipc").attr("_raise_compile_error")(verdict.diagnostics, "");
             return verdict;
           })
      .def("_graph",
           [](PyModel& p, const std::string& format, const std::string& part) {
             if (format != "dot" && format != "json" && format != "svg")
               throw py::value_error("format: svg, dot or json, not `" + format + "`");
             if (part != "all" && part != "structure" && part != "automata")
               throw py::value_error("part: all, structure or automata, not `" + part + "`");
             return p.model->graph(format == "dot"    ? bc::GraphFormat::Dot
                                   : format == "json" ? bc::GraphFormat::Json
                                                      : bc::GraphFormat::Svg,
                                   part == "all"         ? bc::GraphPart::All
                                   : part == "structure" ? bc::GraphPart::Structure
                                                         : bc::GraphPart::Automata);
           })
      .def_property_readonly("system_text", [](PyModel& p) { return p.model->system_text(); });

  m.def("_compile", [](const std::string& text, const std::string& path, bool is_text, const std::string& root,
                       const std::vector<std::string>& folders, const std::string& backend, bool allows_cpp,
                       bool uses_cache, std::uint64_t max_instances) {
    const bc::CompileOptions options = compile_options(root, folders, backend, allows_cpp, uses_cache, max_instances);
    bc::CompileResult result = interruptible([&](const std::stop_token&) {
      return is_text ? bc::compile_text(text, options, path) : bc::compile_file(path, options);
    });
    std::unique_ptr<PyModel> model;
    if (result.model) {
      model = std::make_unique<PyModel>();
      model->model = std::move(result.model);
    }
    return py::make_tuple(std::move(model), result.diagnostics, result.text);
  });
  m.def("_check", [](const std::string& text, const std::string& path, bool is_text, const std::string& root,
                     const std::vector<std::string>& folders) {
    const bc::CompileOptions options{.root = root, .folders = folders};
    const bc::CheckResult result = interruptible([&](const std::stop_token&) {
      return is_text ? bc::check_text(text, options, path) : bc::check_file(path, options);
    });
    return py::make_tuple(result.has_errors, result.diagnostics, result.text);
  });
}
