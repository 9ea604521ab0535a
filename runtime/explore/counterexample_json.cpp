// A counterexample as data. See counterexample.hpp.
#include <memory>

#include "runtime/core/deadlock_explanation.hpp"
#include "runtime/core/text.hpp"
#include "runtime/explore/counterexample.hpp"
#include "runtime/explore/follow_path.hpp"
#include "runtime/trace/trace.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::rt {

namespace {

void append_component(std::string& out, const Core& core, u32 atom) {
  std::string path;
  append_relative(path, core.image().atoms[atom]);
  append_quoted(out, path.c_str());
}

void append_port(std::string& out, const Core& core, u32 atom, u32 port) {
  std::string path;
  append_relative(path, core.image().atoms[atom]);
  path += '.';
  path += core.tables().atom_type(atom).ports[port].name;
  append_quoted(out, path.c_str());
}

// `"table.phil[0]":{"places":["HUNGRY"],"data":{"meals":3}}`
void append_state(std::string& out, const Core& core, u32 atom) {
  const AtomType& type = core.tables().atom_type(atom);
  append_component(out, core, atom);
  out += ":{\"places\":[";
  bool is_first = true;
  for (u32 place = 0; place < type.places.size; ++place) {
    if (!core.is_marked(atom, place)) continue;
    if (!is_first) out += ',';
    is_first = false;
    append_quoted(out, type.places[place]);
  }
  out += ']';
  const u32 clocks = type.time == nullptr ? 0 : type.time->clocks.size;
  // Clocks are behind the data.
  const u32 variables = visible_variables(type);
  if (variables != 0) {
    out += ",\"data\":{";
    for (u32 k = 0; k < variables; ++k) {
      if (k != 0) out += ',';
      append_quoted(out, type.variables[k].name);
      out += ':';
      append_json_value(out, core.image(), type.variables[k].type, core.cell(core.tables().atoms[atom].first_cell + k));
    }
    out += '}';
  }
  if (clocks != 0) {
    out += ",\"clocks\":{";
    for (u32 k = 0; k < clocks; ++k) {
      if (k != 0) out += ',';
      append_quoted(out, type.time->clocks[k].name);
      out += ':';
      append_number(out, static_cast<u64>(core.parts().clocks.clock_value(atom, k)));
    }
    out += '}';
  }
  out += '}';
}

void append_waits(std::string& out, const Core& core) {
  out += ",\"waits\":[";
  const char* before = "";
  const DeadlockWaits waits = deadlock_waits(core);
  for (const DeadlockWait& wait : waits.rows) {
    out += before;
    out += "{\"offers\":";
    append_port(out, core, wait.atom, wait.port);
    if (wait.missing_atom != kNone) {
      out += ",\"needs\":";
      append_port(out, core, wait.missing_atom, wait.missing_port);
    }
    out += '}';
    before = ",";
  }
  out += ']';
  before = ",\"wait_cycle\":[";
  for (const u32 atom : waits.cycle) {
    out += before;
    append_component(out, core, atom);
    before = ",";
  }
  if (!waits.cycle.empty()) out += ']';
}

}  // namespace

std::string counterexample_json(const Image& image, MaximalProgress progress, CounterexampleEnd end,
                                const TimedPath& path) {
  Core core(image, {.progress = progress});
  const std::unique_ptr<TraceSink> sink = row_of(TraceFormat::Json).make();
  std::string head, out = "{\"run\":[", line;
  sink->begin(head, {.image = &image, .policy = "first", .maximal_progress = progress == MaximalProgress::On});
  const char* before = "";
  follow_path(
      core, end, path,
      [&](u64 number, u64 choice) {
        line.clear();
        sink->step(line, core, core.position(choice), number, choice);
        if (!line.empty() && line.back() == '\n') line.pop_back();
        out += before + line;
        before = ",";
      },
      [&] { sink->foresee(core); });
  out += "],\"state\":{";
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    if (atom != 0) out += ',';
    append_state(out, core, atom);
  }
  out += '}';
  if (core.is_timed()) {
    out += ",\"time\":";
    append_number(out, static_cast<u64>(core.now()));
  }
  if (core.fault()) {
    std::string fault;
    append_json_fault(fault, core);
    // Its members follow others.
    fault.front() = '{';
    out += ",\"error\":" + fault + '}';
  } else if (end == CounterexampleEnd::Deadlock && core.candidate_count() == 0) {
    append_waits(out, core);
  }
  return out + '}';
}

}  // namespace bip::rt
