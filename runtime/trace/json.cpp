// The trace file: JSON lines, version 1. Byte-identical for the same model, seed and policy. See trace.hpp.
//
// Names are quoted once. Where a cell has one set of participants all of its line is known but for numbers: a step
// copies the pieces between them, and the string that all goes to grows once.
#include <charconv>
#include <cmath>
#include <cstring>

#include "runtime/core/text.hpp"
#include "bip/assert.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

void append_json_value(std::string& out, const Image& image, CellType type, Cell value) {
  // JSON has no word for these.
  const bool quoted = is_ffi(type) || (type == CellType::Float && !std::isfinite(value.f));
  if (quoted) out += '"';
  append_value(out, image, type, value);
  if (quoted) out += '"';
}

namespace {

constexpr std::size_t kRoom = 2048, kHeadRoom = 192, kValueRoom = 12,
                      kNumberRoom = 20;  // of a line; before its name; of an int or bool; of any
// Writes where there is room.
struct Pen {
  static constexpr std::size_t kBlock = 32;
  char* at;
  void put(std::string_view text) {
    BIP_ASSERT(text.size() <= kRoom, "a piece of {} bytes", text.size());
    std::memcpy(at, text.data(), text.size());
    at += text.size();
  }
  /// The same in whole blocks, which is quicker: behind both there must be as much again.
  void put_blocks(const char* text, std::size_t size) {
    for (std::size_t k = 0; k < size; k += kBlock) std::memcpy(at + k, text + k, kBlock);
    at += size;
  }
  template <class Number>
  void number(Number value) {
    at = std::to_chars(at, at + kNumberRoom, value).ptr;
  }
};

// `{"port":"ROOT.a.p"}`, or the beginning up to the first variable.
void append_port_head(std::string& out, const Core& core, const Participant& participant) {
  const Port& port = core.tables().atom_type(participant.atom).ports[participant.port];
  std::string name = core.image().atoms[participant.atom].path();
  name += '.';
  name += port.name;
  out += R"({"port":)";
  append_quoted(out, name.c_str());
  out += port.variables.size == 0 ? "}" : R"(,"values":{)";
}

}  // namespace

void append_json_values(std::string& out, const Core& core, u32 atom, u32 port) {
  const Image& image = core.image();
  const Port& declared = core.tables().atom_type(atom).ports[port];
  const PortType& type = image.port_types[declared.type];
  out += '{';
  for (u32 i = 0; i < declared.variables.size; ++i) {
    if (i != 0) out += ',';
    append_quoted(out, type.vars[i].name);
    out += ':';
    append_json_value(out, image, type.vars[i].type, core.events().shown(atom, port, i));
  }
  out += '}';
}

i64 instant_of_step(const Core& core, std::uint64_t number) {
  constexpr std::uint64_t kStep = 1'000'000, kMost = static_cast<std::uint64_t>(kForever) / kStep;
  return core.is_timed() ? core.now() : static_cast<i64>(std::min(number, kMost) * kStep);
}

void JsonWriter::begin(std::string& out, const TraceHead& head) {
  out += R"({"format":"bipc-trace","version":1,"model":)";
  append_quoted(out, head.image->name);
  out += R"(,"seed":)";
  append_number(out, head.seed);
  out += R"(,"policy":")";
  out += head.policy;
  if (head.engine != Engine::Sequential) {
    out += R"(","engine":")";
    out += name_of(head.engine);
  }
  out += head.draws_resumes ? "\",\"resumes\":\"drawn\"}\n" : "\"}\n";
}

void JsonWriter::step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t number,
                      std::uint64_t k) {
  const Candidate candidate = core.candidate(position);
  if (lines_.empty()) begin_lines(core);
  BIP_ASSERT(lines_.contains(candidate.interaction), "a writer of another image");
  BIP_ASSERT(k == kNoChoice || k < core.candidate_count(), "candidate {}", k);
  Line& line = lines_[candidate.interaction];
  if (line.text.empty()) begin_line(line, core, candidate);
  char room[kRoom + kNumberRoom + Pen::kBlock];
  Pen pen{room};
  pen.put(R"({"step":)");
  pen.number(number);
  if (core.is_timed()) {
    pen.put(R"(,"time":)");
    pen.number(static_cast<u64>(core.now()));
  }
  if (k != kNoChoice) {
    pen.put(R"(,"choice":)");
    pen.number(k);
    pen.put(R"(,"candidates":)");
    pen.number(core.candidate_count());
  }
  const auto flush = [&] {
    out.append(room, static_cast<std::size_t>(pen.at - room));
    pen.at = room;
  };
  if (!line.is_whole) {
    flush();
    out += line.text;
    append_ports(out, core, candidate);
    return;
  }
  const char* const text = line.text.data();
  std::size_t from = 0;
  for (u32 row = line.first_value; row < line.first_value + line.values; ++row) {
    const Value& value = values_[row];
    BIP_ASSERT(value.at >= from, "value {} of a line before the one before it", row);
    pen.put_blocks(text + from, value.at - from);
    from = value.at;
    const Cell& cell =
        core.is_timed() ? core.events().shown(value.atom, value.port, value.variable) : core.cell(value.id);
    if (value.type == CellType::Int) {
      pen.number(cell.i);
    } else if (value.type == CellType::Bool) {
      pen.put(cell.i != 0 ? "true" : "false");
    } else {
      flush();
      append_json_value(out, core.image(), value.type, cell);
    }
  }
  BIP_ASSERT(line.text.size() >= Pen::kBlock + from, "a line of {} bytes, {} are written", line.text.size(), from);
  BIP_ASSERT(static_cast<std::size_t>(pen.at - room) + line.text.size() - from <= sizeof room,
             "no room behind {} bytes", pen.at - room);
  pen.put_blocks(text + from, line.text.size() - Pen::kBlock - from);
  flush();
}

void JsonWriter::begin_lines(const Core& core) {
  lines_.assign(core.tables().interactions.size(), {});
  ports_.resize(core.tables().port_atom.size());
  for (const PortType& type : core.image().port_types) {
    first_variable_.push_back(static_cast<u32>(variables_.size()));
    for (const Var& variable : type.vars) {
      append_quoted(variables_.emplace_back(), variable.name);
      variables_.back() += ':';
    }
  }
}

// All of the line if who takes part is always the same and there is room for it.
void JsonWriter::begin_line(Line& line, Core& core, const Candidate& candidate) {
  std::string name;
  append_candidate(name, core, candidate);
  line.text = R"(,"interaction":)";
  append_quoted(line.text, name.c_str());
  line.text += R"(,"ports":[)";
  const InteractionKind kind = core.tables().interactions[candidate.interaction].kind;
  if (kind != InteractionKind::Port && kind != InteractionKind::Flat) return;
  std::string whole = line.text;
  line.first_value = static_cast<u32>(values_.size());
  core.participants(candidate, participants_);
  for (const Participant& participant : participants_) {
    if (whole.back() != '[') whole += ',';
    append_port_head(whole, core, participant);
    const Port& port = core.tables().atom_type(participant.atom).ports[participant.port];
    for (u32 i = 0; i < port.variables.size; ++i) {
      if (i != 0) whole += ',';
      whole += variables_[first_variable_[port.type] + i];
      const VariableId id = core.tables().atoms[participant.atom].first_cell + port.variables[i];
      values_.push_back({static_cast<u32>(whole.size()), participant.atom, participant.port, i, id,
                         core.image().port_types[port.type].vars[i].type});
    }
    if (port.variables.size != 0) whole += "}}";
  }
  whole += "]}\n";
  whole.append(Pen::kBlock, ' ');
  BIP_ASSERT(values_.size() >= line.first_value, "{} values, the line begins at {}", values_.size(), line.first_value);
  line.values = static_cast<u32>(values_.size()) - line.first_value;
  line.is_whole = kHeadRoom + whole.size() + line.values * kValueRoom <= kRoom;
  if (line.is_whole) line.text = std::move(whole);
  else values_.resize(line.first_value);
}

void JsonWriter::append_ports(std::string& out, Core& core, const Candidate& candidate) {
  core.participants(candidate, participants_);
  bool first = true;
  for (const Participant& participant : participants_) {
    if (!first) out += ',';
    first = false;
    std::string& text = ports_[core.tables().instance(participant.atom, participant.port)];
    if (text.empty()) append_port_head(text, core, participant);
    out += text;
    const Port& port = core.tables().atom_type(participant.atom).ports[participant.port];
    if (port.variables.size == 0) continue;
    const PortType& type = core.image().port_types[port.type];
    for (u32 i = 0; i < port.variables.size; ++i) {
      if (i != 0) out += ',';
      out += variables_[first_variable_[port.type] + i];
      append_json_value(out, core.image(), type.vars[i].type,
                        core.events().shown(participant.atom, participant.port, i));
    }
    out += "}}";
  }
  out += "]}\n";
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
