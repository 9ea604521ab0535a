// The default format: one readable line a step. See trace.hpp.
#include "runtime/core/text.hpp"

#include "bip/assert.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

const char* name_of(End end) {
  switch (end) {
    case End::Limit: return "limit";
    case End::Deadlock: return "deadlock";
    case End::Fault: return "error";
    case End::Interrupted: return "interrupted";
    case End::Final: return "final";
  }
  return "";
}

const char* name_of(Engine engine) {
  switch (engine) {
    case Engine::Sequential: return "sequential";
    case Engine::Threads: return "threads";
    case Engine::Batch: return "batch";
    case Engine::Simulated: return "simulated";
    case Engine::Distributed: return "distributed";
  }
  return "";
}

void append_candidate(std::string& out, const Core& core, const Candidate& candidate) {
  if (candidate.connector != kNone) {
    append_path(out, core.image().connectors[candidate.connector]);
    return;
  }
  BIP_ASSERT(
      candidate.atom < core.image().atoms.size && candidate.port < core.tables().atom_type(candidate.atom).ports.size,
      "port {} of atom {}", candidate.port, candidate.atom);
  append_path(out, core.image().atoms[candidate.atom]);
  out += '.';
  out += core.tables().atom_type(candidate.atom).ports[candidate.port].name;
}

void append_interaction(std::string& out, const Core& core, InteractionId interaction) {
  const Tables& tables = core.tables();
  const InteractionInfo info = tables.interactions[interaction];
  Candidate candidate;
  if (info.kind == InteractionKind::Port) {
    candidate.atom = tables.port_atom[info.row];
    candidate.port = info.row - tables.port_base(candidate.atom);
  } else {
    candidate.connector = info.row;
  }
  append_candidate(out, core, candidate);
}

void StepWriter::begin(std::string& out, const TraceHead& head) {
  out += "bipc: seed ";
  append_number(out, head.seed);
  out += ", policy ";
  out += head.policy;
  out += '\n';
}

void StepWriter::append_values(std::string& out, const Core& core, u32 atom, u32 port) {
  const Port& declared = core.tables().atom_type(atom).ports[port];
  const PortType& type = core.image().port_types[declared.type];
  for (u32 i = 0; i < declared.variables.size; ++i) {
    out += i == 0 ? "(" : ", ";
    out += type.vars[i].name;
    out += '=';
    append_value(out, core.image(), type.vars[i].type, core.events().shown(atom, port, i));
  }
  if (declared.variables.size != 0) out += ')';
}

void StepWriter::append_ports(std::string& out, Core& core, const Candidate& candidate) {
  const Image& image = core.image();
  if (candidate.connector == kNone) {
    append_relative(out, image.atoms[candidate.atom]);
    out += '.';
    out += core.tables().atom_type(candidate.atom).ports[candidate.port].name;
    if (core.events().is_event_port(candidate.atom, candidate.port)) {
      append_values(out, core, candidate.atom, candidate.port);
      out += " (event)";
    } else {
      out += " (internal)";
    }
    return;
  }
  append_candidate(out, core, candidate);
  out += ' ';
  core.participants(candidate, participants_);
  for (const Participant& participant : participants_) {
    const Port& port = core.tables().atom_type(participant.atom).ports[participant.port];
    out += ' ';
    append_relative(out, image.atoms[participant.atom]);
    out += '.';
    out += port.name;
    append_values(out, core, participant.atom, participant.port);
  }
}

void StepWriter::step(std::string& out, Core& core, const Candidate& candidate, std::uint64_t number) {
  out += '#';
  append_number(out, number);
  out += "  ";
  if (core.is_timed()) {
    out += '@';
    append_time(out, core.now());
    out += "  ";
  }
  append_ports(out, core, candidate);
  out += '\n';
}

void StepWriter::state(std::string& out, Core& core) {
  for (std::uint64_t k = 0; k < core.candidate_count(); ++k) {
    out += "    [";
    append_number(out, k);
    out += "] ";
    append_ports(out, core, core.candidate(k));
    out += '\n';
  }
}

}  // namespace bip::rt
