// See bip/compiler.hpp: a Compilation, its executor, and what the answers look like as plain data.
#include "compiler/library/include/bip/compiler.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "compiler/base/json_text.hpp"
#include "compiler/graph/graph.hpp"
#include "compiler/interp/interp.hpp"
#include "compiler/library/decide.hpp"
#include "compiler/library/observer_estimate.hpp"
#include "compiler/library/read_observer.hpp"
#include "compiler/library/read_verdict.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/ffi_build.hpp"
#include "compiler/pipeline/limits.hpp"
#include "compiler/pipeline/machine.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/net/unread_data.hpp"
#include "runtime/engine/simulate.hpp"
#include "runtime/explore/counterexample.hpp"
#include "runtime/explore/follow_path.hpp"
#include "runtime/trace/trace.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::compiler {

namespace {

pipeline::Backend backend_of(Backend backend) {
  switch (backend) {
    case Backend::Auto: return pipeline::Backend::Auto;
    case Backend::Jit: return pipeline::Backend::Jit;
    case Backend::Interpreter: return pipeline::Backend::Interp;
  }
  BIP_UNREACHABLE("a back end");
}

rt::StateReduction reduction_of(Reduction reduction) {
  switch (reduction) {
    case Reduction::None: return rt::StateReduction::None;
    case Reduction::PartialOrder: return rt::StateReduction::Por;
    case Reduction::Symmetry: return rt::StateReduction::Symmetry;
  }
  BIP_UNREACHABLE("a reduction");
}

pipeline::CompileOptions internal(const CompileOptions& options) {
  pipeline::CompileOptions all;
  all.root = options.root;
  all.folders = options.folders;
  all.refuses_cpp = !options.allows_cpp;
  all.cache.is_off = !options.uses_cache;
  all.max_instances = options.max_instances;
  return all;
}

Diagnostic plain(const bip::Diagnostic& d, const SourceMap& sources) {
  Diagnostic out;
  out.code = info(d.kind).code;
  out.severity = d.severity == bip::Severity::Error ? Severity::Error : Severity::Warning;
  out.message = d.message;
  out.label = d.label;
  out.notes = d.notes;
  for (const Help& help : d.helps) out.help.push_back(help.text);
  if (!d.range.is_valid()) return out;
  const Loc begin = sources.loc(d.range.file, d.range.begin), end = sources.loc(d.range.file, d.range.end);
  out.file = sources.name(d.range.file);
  out.line = begin.line;
  out.column = begin.column;
  out.end_line = end.line;
  out.end_column = end.column;
  return out;
}

std::vector<Diagnostic> plain(const pipeline::Compilation& c) {
  std::vector<Diagnostic> all;
  for (const bip::Diagnostic* d : c.diags.sorted()) all.push_back(plain(*d, c.sources));
  return all;
}

const char* name_of(rt::CounterexampleEnd end) {
  switch (end) {
    case rt::CounterexampleEnd::Deadlock: return "deadlock";
    case rt::CounterexampleEnd::Error: return "error";
    case rt::CounterexampleEnd::TimeLock: return "time lock";
    case rt::CounterexampleEnd::State: return "state";
  }
  BIP_UNREACHABLE("an end");
}

// The names of a path's steps, by a core that takes them. The image has its code.
Counterexample replayed(const rt::Image& image, rt::MaximalProgress maximal, rt::CounterexampleEnd end,
                        const rt::TimedPath& path) {
  Counterexample out;
  out.end = name_of(end);
  rt::Core core(image, {.progress = maximal});
  const auto tell = [&](std::uint64_t, std::uint64_t choice) {
    CounterexampleStep row{core.is_timed() ? core.now() : 0, choice, {}};
    rt::append_candidate(row.interaction, core, core.candidate(core.position(choice)));
    out.steps.push_back(std::move(row));
  };
  (void)rt::follow_path(core, end, path, tell, [] {});
  return out;
}

Estimate plain(const library::ObserverEstimate& of) {
  return {.count = of.values.count,
          .mean = of.values.mean,
          .deviation = of.values.deviation,
          .least = of.values.least,
          .greatest = of.values.greatest,
          .q05 = of.values.quantiles[0],
          .median = of.values.quantiles[1],
          .q95 = of.values.quantiles[2],
          .low = of.interval.low,
          .high = of.interval.high};
}

// What the two kinds of reports have in common.
template <class Report>
void fill(Exploration& out, const Report& found) {
  out.end = rt::name_of(found.end);
  out.steps = found.steps;
  out.deadlocks = found.deadlocks;
  out.finals = found.finals;
  out.errors = found.errors;
  out.depth = found.depth;
  out.seconds = found.seconds;
  out.bytes = found.bytes;
  out.text = rt::summary_line(found);
}

}  // namespace

struct Model::Impl {
  explicit Impl(const CompileOptions& o) : options(o), compilation(internal(o)) {}
  CompileOptions options;
  pipeline::Compilation compilation;
  std::unique_ptr<pipeline::Executor> executor;  // ends before the compilation
  bool is_ready = false;
};

/// Makes models, for the functions below.
class ModelAccess {
 public:
  static std::unique_ptr<Model> make(std::unique_ptr<Model::Impl> impl) {
    std::unique_ptr<Model> model(new Model);
    model->impl_ = std::move(impl);
    return model;
  }
  using Impl = Model::Impl;
};

Model::Model() = default;
Model::~Model() = default;

const std::string& Model::root() const { return impl_->compilation.root_name; }
const std::string& Model::path() const { return impl_->compilation.path; }

std::vector<std::string> Model::components() const {
  std::vector<std::string> paths;
  const rt::Image& image = impl_->compilation.lowered->image;
  for (rt::u32 atom = 0; atom < image.atoms.size; ++atom) paths.push_back(image.atoms[atom].path());
  return paths;
}

std::vector<std::string> Model::variables(const std::string& component) const {
  std::vector<std::string> paths;
  const rt::Image& image = impl_->compilation.lowered->image;
  for (rt::u32 atom = 0; atom < image.atoms.size; ++atom) {
    const rt::Atom row = image.atoms[atom];
    if (row.path() != component) continue;
    const rt::AtomType& type = image.atom_types[row.type];
    for (rt::u32 k = 0; k < type.variables.size; ++k) paths.push_back(component + "." + type.variables[k].name);
    break;
  }
  return paths;
}

std::vector<Diagnostic> Model::prepare() {
  if (impl_->is_ready) return {};
  pipeline::Compilation& c = impl_->compilation;
  const std::size_t known = plain(c).size();
  if (!impl_->executor) {
    impl_->executor = std::make_unique<pipeline::Executor>();
    impl_->is_ready = impl_->executor->prepare(c, backend_of(impl_->options.backend), pipeline::Optimisation::Auto);
  }
  std::vector<Diagnostic> all = plain(c);
  if (impl_->is_ready) return {};
  BIP_ASSERT(known <= all.size(), "{} diagnostics became {}", known, all.size());
  std::erase_if(all, [](const Diagnostic& d) { return d.severity != Severity::Error; });
  return all;
}

const rt::Image* Model::image() { return prepare().empty() ? &impl_->compilation.lowered->image : nullptr; }

Execution Model::start(const ExecutionOptions& options) {
  const rt::Image* code = image();
  BIP_ENSURE(code != nullptr, "`{}` has no code", path());
  return Execution(*code, options);
}

Exploration Model::explore(const ExploreOptions& options) {
  Exploration out;
  pipeline::Compilation& c = impl_->compilation;
  const CodeTable& code = c.system->code;
  rt::ExploreOptions wanted;
  wanted.progress = options.maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off;
  wanted.reduction = reduction_of(options.reduction);
  wanted.limit = options.max_states;
  wanted.seconds = options.seconds;
  wanted.bytes = options.megabytes == 0 ? pipeline::available_memory() / 4 * 3 : options.megabytes * pipeline::kMega;
  wanted.threads = options.threads == 0 ? pipeline::processors() : std::min(options.threads, 256u);
  wanted.is_stopped = [&options] { return options.stop.stop_requested(); };
  Diagnostics refused;
  if (!options.trusts_cpp && code.has_cpp()) {
    refused.report(Diag::kB5041, {}, code.first_cpp());
  } else if (const std::string problem = rt::reduction_problem(c.lowered->image, wanted); !problem.empty()) {
    refused.report(Diag::kB5040, {}, options.reduction == Reduction::PartialOrder ? "partial-order" : "symmetry",
                   problem);
  }
  for (const bip::Diagnostic* d : refused.sorted()) out.diagnostics.push_back(plain(*d, c.sources));
  if (out.diagnostics.empty()) out.diagnostics = prepare();
  if (!out.diagnostics.empty()) return out;
  out.is_answered = true;
  const rt::Image& image = c.lowered->image;
  wanted.unread_cells = verify::find_unread_cells(*c.system, image);
  const auto found_run = [&](rt::CounterexampleEnd end, const rt::TimedPath& path) {
    Counterexample run = replayed(image, wanted.progress, end, path);
    const rt::CounterexampleText text =
        rt::describe_counterexample(image, wanted.progress, end, path, pipeline::kStepsShown);
    run.text = text.steps + text.error;
    return run;
  };
  using enum rt::CounterexampleEnd;
  if (system::is_timed(*c.system)) {
    const rt::ZoneReport found = rt::explore_zones(image, wanted);
    fill(out, found);
    if (!found.inexact.empty()) out.end = "inexact";
    out.states = found.zones;
    out.time_locks = found.time_locks;
    if (!found.are_paths_known) return out;
    if (found.has_deadlock) out.deadlock = found_run(Deadlock, found.deadlock);
    if (found.has_time_lock) out.time_lock = found_run(TimeLock, found.time_lock);
    if (found.has_error) out.error = found_run(Error, found.error);
    return out;
  }
  const rt::ExploreReport found = rt::explore_states(image, wanted);
  fill(out, found);
  out.states = found.states;
  if (!found.are_paths_known) return out;
  if (found.has_deadlock) out.deadlock = found_run(Deadlock, rt::at_once(found.deadlock));
  if (found.has_error) out.error = found_run(Error, rt::at_once(found.error));
  return out;
}

Simulation Model::simulate(const SimulateOptions& options) {
  Simulation out;
  pipeline::Compilation& c = impl_->compilation;
  rt::SimulateOptions wanted;
  wanted.runs = options.runs;
  wanted.seed = options.seed;
  wanted.limit = options.steps;
  wanted.policy = options.policy;
  wanted.asap = options.asap;
  wanted.is_stopped = [&options] { return options.stop.stop_requested(); };
  for (const std::string& text : options.observers) {
    Result<rt::Observer> observer = library::read_observer(text, *c.system);
    if (!observer) {
      out.problem = observer.error();
      return out;
    }
    wanted.observers.push_back(std::move(*observer));
  }
  if (!options.stop_condition.empty()) {
    Result<std::function<bool(const rt::Core&)>> stop = library::read_condition(options.stop_condition, *c.system);
    if (!stop) {
      out.problem = stop.error();
      return out;
    }
    wanted.stop = std::move(*stop);
  }
  if (options.until >= 0) {
    if (!system::is_timed(*c.system)) {
      out.problem = "a run ends at an instant, and the model has no clocks";
      return out;
    }
    wanted.until = options.until;
  }
  const std::uint64_t bytes = library::bytes_of_run(wanted);
  if (options.runs > pipeline::available_memory() / 2 / bytes) {
    out.problem = fmt::format("{} runs of {} bytes each are more than the free memory", options.runs, bytes);
    return out;
  }
  out.diagnostics = prepare();
  if (!out.diagnostics.empty()) return out;
  const std::uint32_t threads = options.threads == 0 ? pipeline::processors() : std::min(options.threads, 256u);
  wanted.threads = pipeline::uses_ffi(c) ? 1 : threads;
  rt::SimulateReport found = rt::simulate(c.lowered->image, wanted);
  out.is_answered = true;
  BIP_ASSERT(found.values.size() == wanted.observers.size(), "values of {} observers of {}", found.values.size(),
             wanted.observers.size());
  out.is_complete = found.is_complete;
  for (const rt::SimulatedEnd end : found.ends) out.ends.emplace_back(rt::name_of(end));
  for (std::size_t k = 0; k < wanted.observers.size(); ++k)
    out.estimates.push_back(plain(library::estimate_of(wanted.observers[k], found.values[k])));
  out.steps = std::move(found.steps);
  out.times = std::move(found.times);
  out.values = std::move(found.values);
  out.first_error = std::move(found.first_fault);
  return out;
}

Verdict Model::verify(const VerifyOptions& options) const {
  const pipeline::Compilation& own = impl_->compilation;
  // The texts as they were read, whatever the files say by now.
  pipeline::Compilation c(own.options);
  c.open_texts = own.open_texts;
  for (const auto& [file, path] : own.paths) c.open_texts[path] = std::string(own.sources.text(file));
  Verdict out;
  if (!pipeline::compile(c, own.path, pipeline::Stage::Image)) {
    out.diagnostics = plain(c);
    return out;
  }
  library::VerifyRequest request;
  request.backend = backend_of(impl_->options.backend);
  request.timeout = options.timeout;
  request.wall_timeout = options.wall_timeout;
  request.megabytes = options.megabytes;
  request.property = options.property;
  if (!options.fairness.empty()) {
    Result<verify::Fairness> fairness = verify::read_fairness(options.fairness, *c.system);
    if (!fairness) {
      out.problem = fmt::format("fairness `{}`, {}", options.fairness, fairness.error());
      return out;
    }
    request.fairness = std::move(*fairness);
  }
  request.partial = options.partial;
  request.why = options.explains;
  request.reuses = impl_->options.uses_cache;
  request.wants_certificate = options.wants_certificate;
  request.wants_run = true;
  const Result<verify::Question> question = library::read_question(request, *c.system);
  if (!question) {
    out.problem = question.error();
    return out;
  }
  const std::string note = library::remove_unread_cpp(request, c, library::data_of(*question));
  std::optional<library::Verdict> verdict = library::decide_initial_fault(c, *question);
  if (!verdict) {
    verify::CancellationSource source;
    const std::stop_callback on_stop(options.stop, [&source] { source.cancel(); });
    verdict = library::decide(request, c, *question, note, verify::CancellationToken(source),
                              [](const char*, std::uint64_t, const char*) {});
  }
  out.diagnostics = plain(c);
  out.is_answered = verdict->is_answered;
  if (!out.is_answered) return out;
  out.outcome = verdict->exit_code == pipeline::kOk        ? Outcome::Holds
                : verdict->exit_code == pipeline::kUnknown ? Outcome::Unknown
                                                           : Outcome::Violated;
  out.text = verdict->text_with_figures();
  out.json = json_line(verdict->json) + '\n';
  out.certificate = std::move(verdict->certificate);
  library::read_verdict(verdict->json, out);
  if (verdict->counterexample) {
    // Small and seen once: the interpreter.
    const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(*c.system, c.root_name);
    const interp::Interpreter interpreter(*lowered);
    out.counterexample =
        replayed(lowered->image, rt::MaximalProgress::On, verdict->counterexample->end, verdict->counterexample->path);
    out.counterexample->cycle = verdict->counterexample->cycle;
    out.counterexample->text = out.text;
  }
  return out;
}

std::string Model::graph(GraphFormat format, GraphPart part) const {
  const graph::Show show = part == GraphPart::All         ? graph::Show::All
                           : part == GraphPart::Structure ? graph::Show::Structure
                                                          : graph::Show::Automata;
  const System& system = *impl_->compilation.system;
  switch (format) {
    case GraphFormat::Dot: return graph::dot(system, show);
    case GraphFormat::Json: return graph::json(system, show);
    case GraphFormat::Svg: break;
  }
  graph::PictureOptions options;
  options.show = show;
  return graph::svg(system, options);
}

std::string Model::system_text() const { return system::print(*impl_->compilation.system); }

namespace {

CompileResult compiled(std::unique_ptr<ModelAccess::Impl> impl, const std::string& path) {
  pipeline::Compilation& c = impl->compilation;
  const bool is_sound = pipeline::compile(c, path, pipeline::Stage::Image) && !c.diags.has_errors();
  CompileResult result;
  result.diagnostics = plain(c);
  result.text = render(c.diags, c.sources, RenderOptions{});
  if (is_sound) result.model = ModelAccess::make(std::move(impl));
  return result;
}

CheckResult checked(pipeline::Compilation& c, const std::string& path) {
  const bool is_sound = pipeline::check(c, path);
  return {plain(c), render(c.diags, c.sources, RenderOptions{}), !is_sound || c.diags.has_errors()};
}

}  // namespace

CompileResult compile_file(const std::string& path, const CompileOptions& options) {
  return compiled(std::make_unique<ModelAccess::Impl>(options), path);
}

CompileResult compile_text(const std::string& text, const CompileOptions& options, const std::string& path) {
  auto impl = std::make_unique<ModelAccess::Impl>(options);
  impl->compilation.open_texts[path] = text;
  return compiled(std::move(impl), path);
}

CheckResult check_file(const std::string& path, const CompileOptions& options) {
  pipeline::Compilation c(internal(options));
  return checked(c, path);
}

CheckResult check_text(const std::string& text, const CompileOptions& options, const std::string& path) {
  pipeline::Compilation c(internal(options));
  c.open_texts[path] = text;
  return checked(c, path);
}

const char* version() { return BIPC_VERSION; }

}  // namespace bip::compiler
