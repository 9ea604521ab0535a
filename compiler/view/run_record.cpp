// See run_record.hpp.
#include "compiler/view/run_record.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>

#include "bip/assert.hpp"
#include "compiler/base/json_text.hpp"
#include "compiler/system/system.hpp"
#include "runtime/core/deadlock_explanation.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/text.hpp"
#include "runtime/trace/future.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::view {

using Json = RunRecorder::Json;

namespace {

rt::u32 clock_count(const rt::Core& core, rt::u32 atom) {
  const rt::AtomTime* const time = core.tables().atom_type(atom).time;
  return time == nullptr ? 0 : static_cast<rt::u32>(time->clocks.size);
}

}  // namespace

RunRecorder::RunRecorder(const System& system, rt::DebugSession& session) : system_(system), session_(session) {
  BIP_ASSERT(system.atoms.size() == session.core().image().atoms.size, "{} atoms of the system, {} of the session",
             system.atoms.size(), session.core().image().atoms.size);
}

Json RunRecorder::state() {
  const rt::Core& core = session_.core();
  Json out{{"timed", core.is_timed()}, {"places", Json::array()}, {"data", Json::array()}};
  for (rt::u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    out["places"].push_back(rt::places_of(core, atom));
    Json values = Json::array();
    for (std::uint32_t k = 0; k < shown_variables(atom); ++k) values.push_back(value(atom, k));
    out["data"].push_back(std::move(values));
  }
  if (!core.is_timed()) return out;
  out["clock_names"] = Json::array();
  for (const rt::AtomType& type : core.image().atom_types) {
    Json names = Json::array();
    if (type.time != nullptr)
      for (const rt::Clock& row : type.time->clocks) names.push_back({row.name, row.unit});
    out["clock_names"].push_back(std::move(names));
  }
  out["clocks"] = Json::array();
  for (rt::u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    Json clocks = Json::array();
    for (rt::u32 row = 0; row < clock_count(core, atom); ++row) clocks.push_back(clock(atom, row));
    out["clocks"].push_back(std::move(clocks));
  }
  return out;
}

Json RunRecorder::clock(rt::u32 atom, rt::u32 row) const {
  const rt::Clocks& time = session_.core().time();
  const rt::ClockState& state = time.clock_state(time.first_clock(atom) + row);
  return {state.value, state.since, static_cast<double>(state.speed) / static_cast<double>(rt::kUnitSpeed)};
}

// Clocks of those who have moved that were set at this instant; one that was set by the step before is again among
// them.
Json RunRecorder::set_clocks(const rt::LastMove& move) const {
  Json out = Json::array();
  const rt::Core& core = session_.core();
  if (!core.is_timed()) return out;
  std::set<rt::u32> atoms;
  for (const rt::MovePart& part : move.parts) atoms.insert(part.atom);
  for (const rt::AtomChange& change : move.changes) atoms.insert(change.atom);
  for (const rt::u32 atom : atoms)
    for (rt::u32 row = 0; row < clock_count(core, atom); ++row) {
      const Json now = clock(atom, row);
      if (now[1] == core.now()) out.push_back({atom, row, now[0], now[1], now[2]});
    }
  return out;
}

// Without the hidden variables of time.
std::uint32_t RunRecorder::shown_variables(rt::u32 atom) const {
  return static_cast<std::uint32_t>(system_.atom_types[system_.atoms[AtomId(atom)].type].visible_variables());
}

std::string RunRecorder::value(rt::u32 atom, std::uint32_t variable) const {
  const rt::Core& core = session_.core();
  BIP_ASSERT(variable < shown_variables(atom), "variable {} of atom {} is not shown", variable, atom);
  std::string out;
  rt::append_value(out, core.image(), core.tables().atom_type(atom).variables[variable].type,
                   core.cell(core.image().atoms[atom].variable(variable)));
  return out;
}

Json RunRecorder::candidates() {
  rt::Core& core = session_.core();
  const std::uint64_t count = core.candidate_count();
  Json rows = Json::array();
  if (count <= kMostCandidates) {
    std::string text;
    rt::StepWriter().state(text, core);
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = text.find('\n', at);
      // "    [3] ROOT.k  p.put(v=1)"
      const std::size_t begin = text.find("] ", at) + 2;
      rows.push_back(row_of(text.substr(begin, end - begin)));
      at = end + 1;
    }
  } else {
    for (std::uint64_t k = 0; k < kMostCandidates; ++k) {
      std::string name;
      rt::append_candidate(name, core, core.candidate(k));
      rows.push_back(row_of(name));
    }
  }
  BIP_ASSERT(rows.size() == std::min(count, kMostCandidates), "{} rows of {} candidates", rows.size(), count);
  Json out{{"rows", std::move(rows)}, {"count", count}};
  return out;
}

Json RunRecorder::later() {
  rt::Core& core = session_.core();
  Json out = Json::array();
  if (!core.is_timed() || session_.is_at_fault()) return out;
  const auto tell = [](std::string& text, rt::Core& of, const rt::Candidate& candidate) {
    rt::append_candidate(text, of, candidate);
  };
  for (const rt::FutureCandidate& later : rt::future_candidates(core, tell)) {
    if (later.intervals.empty() || later.intervals.front().has(core.now())) continue;
    std::string instants;
    for (const rt::Interval& interval : later.intervals) {
      if (!instants.empty()) instants += ' ';
      rt::append_interval(instants, interval);
    }
    out.push_back({later.text, instants, later.intervals.front().low});
  }
  return out;
}

std::size_t RunRecorder::row_of(const std::string& name) {
  const auto [found, is_new] = rows_.try_emplace(name, names_.size());
  if (is_new) names_.push_back(name);
  return found->second;
}

Json RunRecorder::step(const rt::LastMove& move) {
  const rt::Core& core = session_.core();
  // "#3  @1s500ms  ROOT.k  p.put(v=1)"
  std::string text = move.text;
  for (const char sign : {'#', '@'})
    if (text.starts_with(sign)) text.erase(0, std::min(text.find_first_not_of(' ', text.find(' ')), text.size()));
  const std::int64_t connector = move.connector == rt::kNone ? -1 : std::int64_t{move.connector};
  Json parts = Json::array(), changes = Json::array();
  for (const rt::MovePart& part : move.parts) parts.push_back({part.atom, part.port, transition(part)});
  for (const rt::AtomChange& change : move.changes) {
    Json values = Json::array();
    for (const rt::u32 variable : change.variables)
      if (variable < shown_variables(change.atom)) values.push_back({variable, value(change.atom, variable)});
    Json places(nullptr);
    if (!change.places.empty()) places = rt::places_of(core, change.atom);
    changes.push_back({change.atom, std::move(places), std::move(values)});
  }
  std::string line;
  rt::append_line(line, core.image(), move.loc);
  Json out{connector, text, std::move(parts), std::move(changes), core.now(), line};
  if (Json clocks = set_clocks(move); !clocks.empty()) out.push_back(std::move(clocks));
  return out;
}

// The row of the transition at the part's line.
std::int64_t RunRecorder::transition(const rt::MovePart& part) const {
  const std::vector<Transition>& rows = system_.atom_types[system_.atoms[AtomId(part.atom)].type].transitions;
  for (std::size_t t = 0; t < rows.size(); ++t)
    if (rows[t].port == part.port && rows[t].loc.line == part.loc.line && rows[t].loc.file == part.loc.file)
      return static_cast<std::int64_t>(t);
  return -1;
}

Json RunRecorder::end(rt::Halt halt, std::uint64_t seed) {
  Json cycle = Json::array();
  rt::Core& core = session_.core();
  if (session_.is_at_fault()) return {{"story", session_.fault()}, {"cycle", cycle}};
  // A trace may end where nothing is possible; with time, something may be possible later.
  const bool is_stuck = halt == rt::Halt::Deadlock || (!core.is_timed() && core.candidate_count() == 0);
  if (!is_stuck) return nullptr;
  for (const rt::u32 atom : rt::deadlock_cycle(core)) cycle.push_back(atom);
  return {{"story", rt::end_story(core, session_.position(), seed)}, {"cycle", std::move(cycle)}};
}

namespace {

// Equal rows are in the record once; steps and states are numbers of rows.
class Rows {
 public:
  std::size_t number_of(const Json& row) {
    std::string text = json_line(row);
    const std::size_t size = text.size();
    const auto [found, is_new] = numbers_.try_emplace(std::move(text), rows_.size());
    if (is_new) {
      bytes_ += size;
      rows_.push_back(row);
    }
    return found->second;
  }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  Json take() { return std::move(rows_); }

 private:
  std::unordered_map<std::string, std::size_t> numbers_;
  Json rows_ = Json::array();
  std::size_t bytes_ = 0;
};

}  // namespace

Json record_run(const System& system, rt::DebugSession& session, std::uint64_t steps, std::uint64_t seed) {
  BIP_ASSERT(session.position() == 0, "the record of a run begins at {}", session.position());
  RunRecorder recorder(system, session);
  session.track(rt::Tracking::Every);
  Json out = recorder.state();
  const bool is_timed = session.core().is_timed();
  Rows rows, states;
  Json step_rows = Json::array(), state_rows = Json::array(), instants = Json::array(), sets = Json::array();
  std::size_t bytes = 0;
  rt::Halt halt = session.is_at_fault() ? rt::Halt::Fault : rt::Halt::Done;
  while (halt == rt::Halt::Done) {
    state_rows.push_back(states.number_of(recorder.candidates()));
    if (session.position() >= steps) break;
    if (rows.bytes() + states.bytes() + bytes > kMostRecord) {
      out["is_cut"] = true;
      break;
    }
    const std::uint64_t before = session.position();
    halt = session.step();
    if (session.position() == before) break;
    const rt::LastMove* const move = session.last_move();
    if (move == nullptr) continue;
    Json row = recorder.step(*move);
    if (is_timed) {
      instants.push_back(row[4]);
      bytes += 12;
      if (row.size() > 6) {
        bytes += 40 * row[6].size();
        sets.push_back({step_rows.size(), std::move(row[6])});
        row.erase(6);
      }
    }
    row[4] = 0;
    step_rows.push_back(rows.number_of(row));
    bytes += 8;
  }
  BIP_ASSERT(step_rows.size() <= state_rows.size() && state_rows.size() <= step_rows.size() + 1,
             "{} states of {} steps", state_rows.size(), step_rows.size());
  out["rows"] = rows.take();
  out["steps"] = std::move(step_rows);
  if (is_timed) out.update({{"instants", std::move(instants)}, {"sets", std::move(sets)}});
  out["states"] = states.take();
  out["candidates"] = std::move(state_rows);
  out["end"] = recorder.end(halt, seed);
  out["names"] = Json(recorder.names());
  return out;
}

}  // namespace bip::view
