// The lines of the published BIP2 engine, so that scripts made for it keep working. See trace.hpp.
#include <algorithm>
#include <cstring>

#include "runtime/core/text.hpp"
#include "bip/assert.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

namespace {

constexpr const char* kPrefix = "[BIP ENGINE]: ";

void append_values(std::string& out, const Core& core, const PortType& type, VariableId first, Span<u32> variables) {
  out += '(';
  for (u32 i = 0; i < variables.size; ++i) {
    out += type.vars[i].name;
    out += '=';
    append_value(out, core.image(), type.vars[i].type, core.cell(first + variables[i]));
    out += ';';
  }
  out += ')';
}

// Names as the compound that declares the connector sees them.
const char* seen_from(const Image& image, u32 compound, const char* path) {
  if (compound < image.compounds.size) {
    const char* prefix = image.compounds[compound].path;
    const std::size_t length = std::strlen(prefix);
    if (std::strncmp(path, prefix, length) == 0 && path[length] == '.') return path + length + 1;
  }
  return relative(path);
}

// The exported port through which the connector's compound sees a parameter; null if it is bound directly.
const ShownPort* shown_port(const Image& image, const Connector& connector, u32 param) {
  const ShownPort* row = std::lower_bound(image.shown_ports.begin(), image.shown_ports.end(), connector.ports + param,
                                          [](const ShownPort& shown, u32 wanted) { return shown.port_ref < wanted; });
  return row != image.shown_ports.end() && row->port_ref == connector.ports + param ? row : nullptr;
}

// `c.out`: a parameter as its compound sees it; `own` is the path of the port's owner and `port` its name there.
void append_port_name(std::string& out, const Image& image, const Connector& connector, u32 param,
                      const std::string& own, const char* port) {
  const char* merged = nullptr;
  if (const u32 choice = image.port_refs[connector.ports + param].choice; choice != kNone)
    merged = image.choices[choice].name;
  if (const ShownPort* shown = shown_port(image, connector, param)) {
    out += seen_from(image, connector.parent, image.compounds[shown->compound].path);
    out += '.';
    out += shown->name;
  } else if (merged != nullptr) {
    out += seen_from(image, connector.parent, merged);
  } else {
    out += seen_from(image, connector.parent, own.c_str());
    out += '.';
    out += port;
  }
}

// Of a port for events: what the event that it takes brings.
void append_event_values(std::string& out, const Core& core, u32 atom, u32 port) {
  const Image& image = core.image();
  const PortType& type = image.port_types[image.atom_types[image.atoms[atom].type].ports[port].type];
  out += '(';
  for (u32 i = 0; i < type.vars.size; ++i) {
    out += type.vars[i].name;
    out += '=';
    append_value(out, image, type.vars[i].type, core.events().shown(atom, port, i));
    out += ';';
  }
  out += ')';
}

void append_count(std::string& out, std::uint64_t count, const char* what) {
  append_number(out, count);
  out += ' ';
  out += what;
  if (count != 1) out += 's';
}

void append_instant(std::string& out, const Core& core) {
  if (!core.is_timed()) return;
  out += " and global time ";
  append_time(out, core.now());
}

}  // namespace

void Bip2Writer::begin(std::string& out, const TraceHead& head) {
  is_interactive_ = head.is_interactive;
  out += kPrefix;
  out += "initialize components...\n";
  out += kPrefix;
  if (head.is_uniform) {
    out += "random scheduling based on seed=";
    append_number(out, head.seed);
  } else {
    out += head.policy;
    out += " scheduling";
  }
  out += '\n';
}

void Bip2Writer::append(std::string& out, Core& core, std::uint64_t k) {
  out += '[';
  append_number(out, k);
  out += "] ";
  append_body(out, core, core.candidate(k));
}

void Bip2Writer::append_body(std::string& out, Core& core, const Candidate& candidate) {
  const Image& image = core.image();
  append_candidate(out, core, candidate);
  if (candidate.connector == kNone) {
    if (core.is_timed() && core.events().is_event_port(candidate.atom, candidate.port))
      append_event_values(out, core, candidate.atom, candidate.port);
    return;
  }
  out += ':';
  core.direct_participants(candidate, participants_);
  const Connector& connector = image.connectors[candidate.connector];
  for (const Participant& participant : participants_) {
    out += ' ';
    if (participant.connector != kNone) {
      const Connector& below = image.connectors[participant.connector];
      const ConnectorType& type = image.connector_types[below.type];
      append_port_name(out, image, connector, participant.param, below.path(), type.export_name);
      append_values(out, core, image.port_types[type.export_type], below.variable(0), type.export_variables);
    } else {
      const Atom& atom = image.atoms[participant.atom];
      const Port& port = image.atom_types[atom.type].ports[participant.port];
      append_port_name(out, image, connector, participant.param, atom.path(), port.name);
      append_values(out, core, image.port_types[port.type], atom.variable(0), port.variables);
    }
  }
}

void Bip2Writer::state(std::string& out, Core& core, std::uint64_t number) {
  out += kPrefix;
  out += "state #";
  append_number(out, number);
  append_instant(out, core);
  out += ": ";
  const std::uint64_t count = core.candidate_count();
  // Internal ports come last in canonical order.
  std::uint64_t interactions = count;
  while (interactions > 0 && core.candidate(interactions - 1).connector == kNone) --interactions;
  if (interactions > 0) append_count(out, interactions, "interaction");
  if (interactions > 0 && interactions < count) out += " and ";
  if (interactions < count) append_count(out, count - interactions, "internal port");
  out += ":\n";
  for (std::uint64_t k = 0; k < count; ++k) {
    out += kPrefix;
    out += "  ";
    append(out, core, k);
    out += '\n';
  }
}

void Bip2Writer::choice(std::string& out, Core& core, std::uint64_t k) {
  out += kPrefix;
  out += "-> choose ";
  append(out, core, k);
  out += '\n';
}

void Bip2Writer::step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t number,
                      std::uint64_t k) {
  if (core.is_timed() && !is_interactive_) return foreseen(out, core, number, core.candidate(position));
  if (!is_interactive_) state(out, core, number);
  choice(out, core, k);
}

void Bip2Writer::foresee(Core& core) {
  foreseen_at_ = core.now();
  future_ = future_candidates(
      core, [this](std::string& text, Core& c, const Candidate& candidate) { append_body(text, c, candidate); });
}

void Bip2Writer::append_foreseen(std::string& out, std::size_t k) const {
  out += '[';
  append_number(out, k);
  out += "] ";
  BIP_ASSERT(k < future_.size(), "candidate {} of {}", k, future_.size());
  out += future_[k].text;
}

void Bip2Writer::future_state(std::string& out, std::uint64_t number) const {
  out += kPrefix;
  out += "state #";
  append_number(out, number);
  out += " and global time ";
  append_time(out, foreseen_at_);
  out += ": ";
  std::size_t interactions = 0;
  for (const FutureCandidate& f : future_) interactions += f.is_internal ? 0 : 1;
  if (interactions > 0) append_count(out, interactions, "interaction");
  if (interactions > 0 && interactions < future_.size()) out += " and ";
  if (interactions < future_.size()) append_count(out, future_.size() - interactions, "internal port");
  out += ":\n";
  for (std::size_t k = 0; k < future_.size(); ++k) {
    out += kPrefix;
    out += "  ";
    append_foreseen(out, k);
    for (const Interval& interval : future_[k].intervals) {
      out += ' ';
      append_interval(out, interval);
    }
    out += '\n';
  }
}

void Bip2Writer::foreseen(std::string& out, Core& core, std::uint64_t number, const Candidate& chosen) {
  BIP_ASSERT(foreseen_at_ <= core.now(), "foresee() looked at {}, the step is at {}", foreseen_at_, core.now());
  future_state(out, number);
  std::string text;
  append_body(text, core, chosen);
  for (std::size_t k = 0; k < future_.size(); ++k) {
    if (future_[k].interaction != chosen.interaction || future_[k].text != text) continue;
    out += kPrefix;
    out += "-> choose ";
    append_foreseen(out, k);
    out += " at global time ";
    append_time(out, core.now());
    out += '\n';
    return;
  }
}

// The published engine's own words, for scripts that look for them.
void Bip2Writer::fault(std::string& out, const Core& core) {
  const Fault& fault = core.fault();
  const Image& image = core.image();
  const std::string atom = fault.atom == kNone ? "" : image.atoms[fault.atom].path();
  std::string text;
  switch (fault.code) {
    case FaultCode::TwoTransitions:
    case FaultCode::TwoInternals: text = "non deterministic Petri net in " + atom; break;
    case FaultCode::NotOneSafe: text = "Petri net not 1-safe in " + atom; break;
    case FaultCode::InvariantViolated: text = "invariant " + atom + '.' + fault.rule + " violated"; break;
    case FaultCode::PriorityCycle: text = "cycle in priorities of compound: " + fault.rule; break;
    case FaultCode::AtomPriorityCycle: text = "cycle in priorities of atom " + atom + ": " + fault.rule; break;
    case FaultCode::EventRefused:
      text = "unexpected event " + atom + '.' + image.atom_types[image.atoms[fault.atom].type].ports[fault.port].name;
      break;
    case FaultCode::LateStep:
      text = "timing violation in " + (fault.connector != kNone ? image.connectors[fault.connector].path() : atom);
      break;
    // Told by the line of the state.
    case FaultCode::TimeLock:
    case FaultCode::None:
    case FaultCode::EndlessInternals:
    case FaultCode::DivisionByZero:
    case FaultCode::DivisionOverflow:
    case FaultCode::TooManyInteractions:
    case FaultCode::Exception:
    case FaultCode::BadClock:
    case FaultCode::SourceFailed:
    case FaultCode::ReplayDiffers:
    case FaultCode::BadDraw:
    case FaultCode::UntriedDraw: return;
  }
  out += kPrefix;
  out += "ERROR: " + text + "!\n";
}

void Bip2Writer::end(std::string& out, const Core& core, End end, std::uint64_t number) {
  const bool is_time_lock = end == End::Fault && core.fault().code == FaultCode::TimeLock;
  if (end == End::Fault) fault(out, core);
  out += kPrefix;
  out += "state #";
  append_number(out, number);
  if (is_time_lock) {
    // The state was reached before time came to its end.
    out += " and global time ";
    append_time(out, std::min(foreseen_at_, core.now()));
    out += ": time-lock at ";
    append_time(out, core.now());
    out += "!\n";
    return;
  }
  append_instant(out, core);
  switch (end) {
    case End::Deadlock: out += ": deadlock!\n"; break;
    case End::Limit: out += ": limit reached\n"; break;
    case End::Fault: out += ": error\n"; break;
    case End::Interrupted: out += ": interrupted\n"; break;
    case End::Final: out += ": final state\n"; break;
  }
}

}  // namespace bip::rt
