// The trace file: JSON lines, version 1. Byte-identical for the same model, seed and policy. See trace.hpp. Names are quoted once.
#include <cmath>

#include "runtime/core/text.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

namespace {

void append_json_value(std::string& out, const Image& image, SlotType type, Slot value) {
  // JSON has no word for these.
  const bool quoted = is_extern(type) || (type == SlotType::Float && !std::isfinite(value.f));
  if (quoted) out += '"';
  append_value(out, image, type, value);
  if (quoted) out += '"';
}

}  // namespace

void append_json_values(std::string& out, const Core& core, u32 atom, u32 port) {
  const Image& image = core.image();
  const Port& declared = image.atom_types[image.atoms[atom].type].ports[port];
  const PortType& type = image.port_types[declared.type];
  out += '{';
  for (u32 i = 0; i < declared.slots.size; ++i) {
    if (i != 0) out += ',';
    append_quoted(out, type.vars[i].name);
    out += ':';
    append_json_value(out, image, type.vars[i].type, core.shown(atom, port, i));
  }
  out += '}';
}

i64 instant_of_step(const Core& core, std::uint64_t number) {
  constexpr std::uint64_t kStep = 1'000'000, kMost = static_cast<std::uint64_t>(kForever) / kStep;
  return core.is_timed() ? core.now() : static_cast<i64>(std::min(number, kMost) * kStep);
}

void JsonWriter::begin(std::string& out, const Image& image, std::uint64_t seed, Policy policy, Engine engine) {
  out += R"({"format":"bipc-trace","version":1,"model":)";
  append_quoted(out, image.name);
  out += R"(,"seed":)";
  append_number(out, seed);
  out += R"(,"policy":")";
  out += name_of(policy);
  if (engine != Engine::Sequential) {
    out += R"(","engine":")";
    out += name_of(engine);
  }
  out += "\"}\n";
}

void JsonWriter::step(std::string& out, Core& core, const Candidate& candidate, std::uint64_t number, std::uint64_t k) {
  out += R"({"step":)";
  append_number(out, number);
  if (core.is_timed()) {
    out += R"(,"time":)";
    append_number(out, static_cast<u64>(core.now()));
  }
  if (k != kNoChoice) {
    out += R"(,"choice":)";
    append_number(out, k);
    out += R"(,"candidates":)";
    append_number(out, core.candidate_count());
  }
  if (slots_.empty()) slots_.resize(core.tables().slots.size());
  std::string& slot = slots_[candidate.slot];
  if (slot.empty()) {
    std::string name;
    append_candidate(name, core, candidate);
    slot = R"(,"interaction":)";
    append_quoted(slot, name.c_str());
    slot += R"(,"ports":[)";
  }
  out += slot;
  core.participants(candidate, participants_);
  bool first = true;
  for (const Participant& participant : participants_) {
    if (!first) out += ',';
    first = false;
    append_port(out, core, participant);
  }
  out += "]}\n";
}

void JsonWriter::append_port(std::string& out, const Core& core, const Participant& participant) {
  const Image& image = core.image();
  const Tables& tables = core.tables();
  const Port& port = tables.atom_type(participant.atom).ports[participant.port];
  if (ports_.empty()) {
    ports_.resize(tables.port_atom.size());
    for (const PortType& type : image.port_types) {
      first_variable_.push_back(static_cast<u32>(variables_.size()));
      for (const Var& variable : type.vars) {
        append_quoted(variables_.emplace_back(), variable.name);
        variables_.back() += ':';
      }
    }
  }
  std::string& text = ports_[tables.instance(participant.atom, participant.port)];
  if (text.empty()) {
    std::string name = image.atoms[participant.atom].path;
    name += '.';
    name += port.name;
    text = R"({"port":)";
    append_quoted(text, name.c_str());
    text += port.slots.size == 0 ? "}" : R"(,"values":{)";
  }
  out += text;
  if (port.slots.size == 0) return;
  const PortType& type = image.port_types[port.type];
  for (u32 i = 0; i < port.slots.size; ++i) {
    if (i != 0) out += ',';
    out += variables_[first_variable_[port.type] + i];
    append_json_value(out, image, type.vars[i].type, core.shown(participant.atom, participant.port, i));
  }
  out += "}}";
}

void append_json_fault(std::string& out, const Core& core) {
  out += R"(,"code":")";
  out += name_of(core.fault().code);
  out += R"(","message":)";
  append_quoted(out, core.fault().what.c_str());
}

void JsonWriter::end(std::string& out, const Core& core, End end, std::uint64_t steps) {
  out += R"({"end":")";
  out += name_of(end);
  out += R"(","steps":)";
  append_number(out, steps);
  if (core.is_timed()) {
    out += R"(,"time":)";
    append_number(out, static_cast<u64>(core.now()));
  }
  if (end == End::Fault) append_json_fault(out, core);
  out += "}\n";
}

}  // namespace bip::rt
