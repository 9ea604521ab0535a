// The embedding API: a Core and a Scheduler in one object. See bip/bip.hpp.
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "bip/assert.hpp"
#include "bip/bip.hpp"
#include "bip/ffi.hpp"
#include "runtime/core/deadlock_explanation.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/text.hpp"
#include "runtime/core/why_not.hpp"
#include "runtime/engine/collect_strings.hpp"
#include "runtime/engine/limiting_ports.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/engine/timed_scheduler.hpp"
#include "runtime/trace/trace.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip {

/// A trace on its way to its file.
struct Execution::TraceFile {
  TraceFile(std::FILE* opened, const rt::TraceFormatRow& row) : format(row.make()), file(opened) {}
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;
  ~TraceFile() { (void)close(); }
  bool close() {
    if (file == nullptr) return true;
    drain(0);
    const bool is_sound = std::ferror(file) == 0;
    return std::fclose(std::exchange(file, nullptr)) == 0 && is_sound;
  }
  void drain(std::size_t threshold) {
    out.drain(threshold, [this](std::string_view text) { std::fwrite(text.data(), 1, text.size(), file); });
  }
  static constexpr std::size_t kPiece = 1 << 16;
  std::unique_ptr<rt::TraceSink> format;
  std::FILE* file;
  rt::Sink out;
};

struct Execution::Impl {
  Impl(const rt::Image& image, const ExecutionOptions& options)
      : core(image, {.progress = options.maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off}),
        feed(core, options.event_capacity),
        scheduler(options.policy, options.asap, options.seed),
        wall(options.speed > 0 ? options.speed : 1),
        is_real(options.speed > 0),
        is_strict(options.strict),
        policy(options.policy),
        seed(options.seed) {
    for (rt::u32 atom = 0; atom < image.atoms.size; ++atom) by_path.push_back(atom);
    std::sort(by_path.begin(), by_path.end(),
              [&](rt::u32 a, rt::u32 b) { return image.atoms[a].path() < image.atoms[b].path(); });
    if (image.ffi != nullptr) std::srand(static_cast<unsigned>(options.seed));
    core.seed_draws(options.seed);
    if (options.speed <= 0) scheduler.prepare(core);
    outcome = core.initialize() ? Outcome::Stepped : Outcome::Fault;
    if (outcome == Outcome::Stepped) scheduler.start(core);
    feed.open_inbox();
    if (!is_strict) feed.relax();
    if (options.speed > 0) feed.follow(wall);
    if (options.speed > 0) feed.open_pool(core);
    wall.start(core.now());
    if (outcome == Outcome::Stepped && !feed.open_sources(core)) outcome = Outcome::Fault;
  }

  [[nodiscard]] rt::u32 find_atom(const std::string& path) const {
    const rt::Image& image = core.image();
    const auto at = std::lower_bound(by_path.begin(), by_path.end(), path, [&](rt::u32 atom, const std::string& key) {
      return image.atoms[atom].path() < key;
    });
    BIP_ASSERT(by_path.size() == image.atoms.size, "{} of {} paths are sorted", by_path.size(), image.atoms.size);
    return at != by_path.end() && image.atoms[*at].path() == path ? *at : rt::kNone;
  }
  [[nodiscard]] std::string path_of(const rt::Participant& participant) const {
    return core.image().atoms[participant.atom].path() + "." +
           core.tables().atom_type(participant.atom).ports[participant.port].name;
  }
  [[nodiscard]] const rt::Cell* find_cell(const std::string& path, rt::CellType type) const {
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) return nullptr;
    const rt::u32 atom = find_atom(path.substr(0, dot));
    if (atom == rt::kNone) return nullptr;
    const rt::AtomType& atom_type = core.tables().atom_type(atom);
    for (rt::u32 i = 0; i < atom_type.variables.size; ++i) {
      if (path.compare(dot + 1, std::string::npos, atom_type.variables[i].name) != 0) continue;
      return atom_type.variables[i].type == type ? &core.cell(core.tables().atoms[atom].first_cell + i) : nullptr;
    }
    return nullptr;
  }
  [[nodiscard]] EventValue value_of(rt::CellType type, rt::Cell cell) const {
    switch (type) {
      case rt::CellType::Int: return cell.i;
      case rt::CellType::Bool: return cell.i != 0;
      case rt::CellType::Float: return cell.f;
      case rt::CellType::String: return std::string(rt::string_of(core.image(), cell));
    }
    std::string text;
    rt::append_value(text, core.image(), type, cell);
    return text;
  }
  // Returns whether a callback needs the names of the candidate's step; `participants` are then its ports.
  [[nodiscard]] bool finds_names(const rt::Candidate& candidate) {
    const bool are_all = needed.empty() || names_all.load(std::memory_order_relaxed);
    // Most interactions have no port that anybody needs: their participants are not looked for.
    if (!are_all && !may_be_needed[candidate.interaction.value]) return false;
    core.participants(candidate, participants);
    return are_all || std::any_of(participants.begin(), participants.end(), [&](const rt::Participant& p) {
             return needed[core.tables().instance(p.atom, p.port)];
           });
  }
  // Ports and values, of `participants`.
  void name(Step& step, const rt::Candidate& candidate) const {
    rt::append_candidate(step.interaction, core, candidate);
    for (const rt::Participant& p : participants) {
      const rt::Port& port = core.tables().atom_type(p.atom).ports[p.port];
      step.ports.push_back(path_of(p));
      const rt::PortType& type = core.image().port_types[port.type];
      for (rt::u32 i = 0; i < port.variables.size; ++i) {
        step.values.push_back({static_cast<std::uint32_t>(step.ports.size() - 1), type.vars[i].name,
                               value_of(type.vars[i].type, core.events().shown(p.atom, p.port, i))});
      }
    }
  }
  void set_needs(const std::function<bool(const std::string&)>& needs) {
    const rt::Tables& tables = core.tables();
    needed.clear();
    may_be_needed.clear();
    if (!needs) return;
    for (rt::u32 atom = 0; atom < core.image().atoms.size; ++atom) {
      for (rt::u32 port = 0; port < tables.atom_type(atom).ports.size; ++port) {
        const rt::Participant p{.atom = atom, .port = port};
        needed.push_back(needs(path_of(p)));
      }
    }
    BIP_ASSERT(needed.size() == tables.port_atom.size(), "{} of {} ports", needed.size(), tables.port_atom.size());
    for (const rt::InteractionId interaction : IdRange<rt::InteractionId>(tables.interactions.size()))
      may_be_needed.push_back(has_needed_port(interaction));
  }
  // Among all ports that may take part.
  [[nodiscard]] bool has_needed_port(rt::InteractionId interaction) const {
    const rt::Tables& tables = core.tables();
    const rt::InteractionInfo info = tables.interactions[interaction];
    switch (info.kind) {
      case rt::InteractionKind::Port: return needed[info.row];
      case rt::InteractionKind::Flat:
      case rt::InteractionKind::Star: {
        const auto first = tables.flat_ports.begin() + info.first;
        return std::any_of(first, first + info.count, [&](rt::u32 instance) { return needed[instance]; });
      }
      case rt::InteractionKind::Planned: {
        const rt::Plan& plan = tables.plans[info.plan()];
        const auto first = tables.plan_nodes.begin() + plan.first_node;
        return std::any_of(first, first + plan.node_count, [&](const rt::PlanNode& node) {
          return node.kind == rt::NodeKind::Leaf && needed[node.ref];
        });
      }
    }
    BIP_UNREACHABLE("an interaction of no kind");
  }
  Outcome take(rt::EnabledSet::Position at) {
    BIP_ASSERT(core.enabled().has(at) && outcome != Outcome::Fault, "interaction {} is no candidate", at.interaction);
    Step step;
    if (callback) {
      const rt::Candidate candidate = core.candidate(at);
      step.number = steps;
      if (finds_names(candidate)) name(step, candidate);
    }
    if (trace) {
      trace->format->step(trace->out.text, core, at, steps, core.enabled().number(at));
      trace->drain(TraceFile::kPiece);
    }
    if (!(core.is_timed() ? core.time().take(at) : core.take(at))) return outcome = Outcome::Fault;
    BIP_ASSERT(!core.fault(), "a step without a fault left one");
    scheduler.fired(at.interaction);
    if (!feed.resume(core)) return outcome = Outcome::Fault;
    ++steps;
    rt::collect_strings(core);
    if (callback) callback(step);
    return outcome = Outcome::Stepped;
  }

  [[nodiscard]] Outcome end_without_candidates() const {
    return rt::is_final_state(core) ? Outcome::Final : Outcome::Deadlock;
  }

  // Compiled steps; the same ones as step by step. What precedes and follows them is worth it for many.
  static constexpr std::uint64_t kManySteps = 256;
  [[nodiscard]] bool can_run_compiled(std::uint64_t n) {
    return n >= kManySteps && !callback && !trace && outcome != Outcome::Fault && !core.is_timed() &&
           scheduler.untimed().knows_steps() && core.steps().has_steps();
  }
  std::uint64_t run_compiled(std::uint64_t n) {
    bool sound = true;
    const std::uint64_t done = scheduler.untimed().run_steps(
        core, n, [] { return false; }, sound);
    BIP_ASSERT(done <= n, "{} steps of {}", done, n);
    steps += done;
    outcome = !sound ? Outcome::Fault : done < n ? end_without_candidates() : Outcome::Stepped;
    return done;
  }

  // In real time, before the scheduler's choice is taken. False: a timing violation.
  bool is_in_time() {
    if (!is_real || !core.is_timed()) return true;
    lateness = wall.note_late(core.now());
    const rt::i64 actual = core.now() + wall.in_model(lateness);
    // No interval ends before now: what is in time for that needs no look at the candidates.
    if (!wall.is_too_late(actual, core.now())) return true;
    if (!wall.is_too_late(actual, limiting.latest(core, scheduler))) return true;
    if (core.time().is_resumed(core.candidate(scheduler.choice()))) return true;
    ++late;
    return !is_strict || core.time().fail_late(core.candidate(scheduler.choice()), scheduler.latest(core), actual);
  }

  rt::Core core;
  rt::EventFeed feed;
  rt::TimedScheduler scheduler;
  rt::LimitingPorts limiting{core};
  rt::RealTime wall;
  bool is_real, is_strict;
  std::uint64_t late = 0;
  std::int64_t lateness = 0;  // of the last step, on the wall
  rt::Policy policy;
  std::uint64_t seed;
  std::uint64_t steps = 0;
  std::unique_ptr<TraceFile> trace;
  Outcome outcome = Outcome::Stepped;
  std::function<void(const Step&)> callback;
  // By port instance: who is called needs the names of its steps; by interaction: such a port may take part. Empty: all
  // are needed.
  std::vector<bool> needed, may_be_needed;
  std::atomic<bool> names_all{false};
  std::vector<rt::u32> by_path;
  std::vector<rt::Participant> participants;
};

struct Execution::Snapshot::Impl {
  rt::State state;
  std::vector<rt::InteractionId> order;  // of the list that `uniform` draws from
  rt::TimedScheduler scheduler;
  std::uint64_t steps;
  Outcome outcome;
};

namespace {

// Does the core hold the state that a snapshot was made of? Objects of C++ may not know equality. For assertions.
[[maybe_unused]] bool is_same_state(const rt::Core& core, const rt::State& state) {
  const rt::State now = core.snapshot();
  return now.places == state.places && now.marks == state.marks && now.data == state.data && now.time == state.time;
}

}  // namespace

Execution::Execution(const rt::Image& image, ExecutionOptions options)
    : impl_(std::make_unique<Impl>(image, options)) {}
Execution::~Execution() = default;
Execution::Execution(Execution&&) noexcept = default;
Execution& Execution::operator=(Execution&&) noexcept = default;
Execution::Snapshot::Snapshot() = default;
Execution::Snapshot::~Snapshot() = default;
Execution::Snapshot::Snapshot(Snapshot&&) noexcept = default;
Execution::Snapshot& Execution::Snapshot::operator=(Snapshot&&) noexcept = default;

Outcome Execution::outcome() const { return impl_->outcome; }
std::uint64_t Execution::steps() const { return impl_->steps; }
std::uint64_t Execution::candidate_count() const {
  return impl_->outcome == Outcome::Fault ? 0 : impl_->core.candidate_count();
}

Outcome Execution::step() {
  if (impl_->outcome == Outcome::Fault) return Outcome::Fault;
  while (true) {
    switch (impl_->scheduler.wait(impl_->core, impl_->feed)) {
      case rt::Due::Event: break;
      case rt::Due::Stopped: return impl_->outcome = Outcome::Stopped;
      case rt::Due::Deadlock: return impl_->outcome = impl_->end_without_candidates();
      case rt::Due::Fault: return impl_->outcome = Outcome::Fault;
      case rt::Due::Step:
        return impl_->is_in_time() ? impl_->take(impl_->scheduler.choice()) : impl_->outcome = Outcome::Fault;
    }
  }
}

Posted Execution::post(const std::string& port, std::vector<EventValue> values) {
  return post(event_port(port), std::move(values));
}

std::uint32_t Execution::event_port(const std::string& port) const { return impl_->feed.ports().find(port); }

Posted Execution::post(std::uint32_t event_port, std::vector<EventValue> values) {
  rt::EventFeed& feed = impl_->feed;
  if (event_port >= feed.ports().size()) return Posted::NoSuchPort;
  if (!feed.ports().check(event_port, values).empty()) return Posted::BadValues;
  return feed.post(event_port, std::move(values)) ? Posted::Taken : Posted::Full;
}

void Execution::stop() { impl_->feed.stop(); }
void Execution::go_on() { impl_->feed.go_on(); }
void Execution::restart_clock() { impl_->feed.restart(impl_->wall, impl_->core.now()); }

std::uint64_t Execution::overruns() const { return impl_->feed.overruns(); }
std::uint64_t Execution::late_steps() const { return impl_->late; }
std::int64_t Execution::lateness() const { return impl_->lateness; }
std::int64_t Execution::awake_since() const { return std::as_const(impl_->feed).waker().awake_since(); }

std::int64_t Execution::now() const { return impl_->core.now(); }

std::uint64_t Execution::run(std::uint64_t n) {
  if (impl_->can_run_compiled(n)) return impl_->run_compiled(n);
  for (std::uint64_t i = 0; i < n; ++i) {
    if (step() != Outcome::Stepped) return i;
  }
  return n;
}

std::string Execution::candidate(std::uint64_t k) const {
  std::string name;
  rt::append_candidate(name, impl_->core, impl_->core.candidate(k));
  return name;
}

std::vector<std::string> Execution::candidate_ports(std::uint64_t k) const {
  std::vector<rt::Participant> participants;
  impl_->core.participants(impl_->core.candidate(k), participants);
  std::vector<std::string> paths;
  paths.reserve(participants.size());
  for (const rt::Participant& p : participants) paths.push_back(impl_->path_of(p));
  return paths;
}

Outcome Execution::fire(std::uint64_t k) {
  if (impl_->outcome == Outcome::Fault) return Outcome::Fault;
  if (k >= impl_->core.candidate_count())
    return impl_->outcome = impl_->core.candidate_count() == 0 ? impl_->end_without_candidates() : Outcome::Deadlock;
  BIP_ASSERT(impl_->core.enabled().number(impl_->core.position(k)) == k, "candidate {} has the number {}", k,
             impl_->core.enabled().number(impl_->core.position(k)));
  return impl_->take(impl_->core.position(k));
}

void Execution::on_step(std::function<void(const Step&)> callback) { on_step(std::move(callback), {}); }
void Execution::on_step(std::function<void(const Step&)> callback,
                        const std::function<bool(const std::string& port)>& needs) {
  impl_->callback = std::move(callback);
  impl_->set_needs(needs);
}
void Execution::name_all_steps(bool on) { impl_->names_all.store(on, std::memory_order_relaxed); }

bool Execution::trace(const std::string& path, rt::TraceFormat format) {
  const rt::TraceFormatRow& row = rt::row_of(format);
  if (!row.can_embed) return false;
  std::FILE* file = std::fopen(path.c_str(), "wbe");
  if (file == nullptr) return false;
  rt::RunOptions options;
  options.policy = impl_->policy;
  options.draws_resumes = impl_->core.time().draws_resumes();
  impl_->trace = std::make_unique<TraceFile>(file, row);
  impl_->trace->format->begin(impl_->trace->out.text, rt::head_of(impl_->core.image(), options, impl_->seed));
  return true;
}

bool Execution::end_trace() {
  if (!impl_->trace) return true;
  const rt::End how = impl_->outcome == Outcome::Deadlock ? rt::End::Deadlock
                      : impl_->outcome == Outcome::Final  ? rt::End::Final
                      : impl_->outcome == Outcome::Fault  ? rt::End::Fault
                                                          : rt::End::Interrupted;
  BIP_ASSERT(impl_->trace->format != nullptr && impl_->trace->file != nullptr, "a trace that was closed");
  impl_->trace->format->end(impl_->trace->out.text, impl_->core, how, impl_->steps);
  const bool is_written = impl_->trace->close();
  impl_->trace.reset();
  return is_written;
}

std::string Execution::place(const std::string& atom_path) const {
  const rt::u32 atom = impl_->find_atom(atom_path);
  return atom == rt::kNone ? std::string() : rt::places_of(impl_->core, atom);
}

bool Execution::read(const std::string& path, std::int32_t& value) const {
  const rt::Cell* cell = impl_->find_cell(path, rt::CellType::Int);
  if (cell != nullptr) value = cell->i;
  return cell != nullptr;
}
bool Execution::read(const std::string& path, bool& value) const {
  const rt::Cell* cell = impl_->find_cell(path, rt::CellType::Bool);
  if (cell != nullptr) value = cell->i != 0;
  return cell != nullptr;
}
bool Execution::read(const std::string& path, double& value) const {
  const rt::Cell* cell = impl_->find_cell(path, rt::CellType::Float);
  if (cell != nullptr) value = cell->f;
  return cell != nullptr;
}
bool Execution::read(const std::string& path, std::string& value) const {
  const rt::Cell* cell = impl_->find_cell(path, rt::CellType::String);
  if (cell != nullptr) value = rt::string_of(impl_->core.image(), *cell);
  return cell != nullptr;
}

std::vector<Execution::ClockReading> Execution::clocks(const std::string& atom_path) const {
  std::vector<ClockReading> out;
  const rt::u32 atom = impl_->find_atom(atom_path);
  if (atom == rt::kNone || !impl_->core.is_timed()) return out;
  const rt::AtomTime* const time = impl_->core.tables().atom_type(atom).time;
  if (time == nullptr) return out;
  const rt::Clocks& clocks = impl_->core.time();
  rt::u32 row = clocks.first_clock(atom);
  for (const rt::Clock& clock : time->clocks) {
    const rt::ClockState& state = clocks.clock_state(row++);
    out.push_back({.name = clock.name,
                   .value = state.value,
                   .since = state.since,
                   .speed = static_cast<double>(state.speed) / static_cast<double>(rt::kUnitSpeed),
                   .unit = clock.unit});
  }
  return out;
}

Execution::Snapshot Execution::snapshot() const {
  rt::pin_strings(impl_->core);
  Snapshot snapshot;
  snapshot.impl_ = std::make_unique<Snapshot::Impl>(Snapshot::Impl{
      impl_->core.snapshot(), impl_->core.enabled().list_order(), impl_->scheduler, impl_->steps, impl_->outcome});
  return snapshot;
}

void Execution::restore(const Snapshot& snapshot) {
  const bool sound = impl_->core.restore(snapshot.impl_->state);
  BIP_ASSERT(snapshot.impl_ != nullptr, "a snapshot that was moved away");
  if (sound) impl_->core.set_list_order(snapshot.impl_->order);
  impl_->scheduler = snapshot.impl_->scheduler;
  BIP_ASSERT(!sound || is_same_state(impl_->core, snapshot.impl_->state), "the restored state is another one");
  impl_->steps = snapshot.impl_->steps;
  impl_->feed.restart(impl_->wall, impl_->core.now());
  impl_->feed.recount(impl_->core);
  impl_->outcome = sound ? snapshot.impl_->outcome : Outcome::Fault;
}

std::string Execution::fault() const {
  if (impl_->outcome != Outcome::Fault) return {};
  return rt::fault_text(impl_->core, impl_->seed, impl_->steps);
}

std::string Execution::story() const {
  if (impl_->outcome == Outcome::Fault || impl_->core.candidate_count() != 0) return {};
  return rt::end_story(impl_->core, impl_->steps, impl_->seed);
}

std::size_t Execution::Snapshot::bytes() const {
  const rt::State& state = impl_->state;
  return sizeof(Impl) + (state.places.size() + impl_->order.size()) * sizeof(rt::u32) +
         (state.marks.size() + state.data.size() + state.time.size()) * sizeof(rt::u64) +
         state.objects.size() * sizeof(rt::FfiValue);
}

std::string Execution::why(const std::string& given) const {
  if (impl_->outcome == Outcome::Fault) return {};
  const std::string path = rt::whole_path(given);
  const rt::Image& image = impl_->core.image();
  for (rt::u32 connector = 0; connector < image.connectors.size; ++connector) {
    if (image.connectors[connector].path() == path) return rt::why_not_connector(impl_->core, connector);
  }
  const std::size_t dot = path.rfind('.');
  const rt::u32 atom = impl_->find_atom(path.substr(0, dot));
  if (atom == rt::kNone) return {};
  const rt::Span<rt::Port>& ports = impl_->core.tables().atom_type(atom).ports;
  for (rt::u32 port = 0; port < ports.size; ++port) {
    if (path.compare(dot + 1, std::string::npos, ports[port].name) == 0)
      return rt::why_not_port(impl_->core, atom, port);
  }
  return {};
}

}  // namespace bip
