// Faults as data and as text. See fault.hpp.
#include "runtime/core/fire/fault.hpp"

#include "bip/ffi.hpp"
#include "runtime/core/core.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

const char* name_of(FaultCode code) {
  switch (code) {
    case FaultCode::None: return "";
    case FaultCode::TwoTransitions: return "R0001";
    case FaultCode::TwoInternals: return "R0002";
    case FaultCode::NotOneSafe: return "R0003";
    case FaultCode::EndlessInternals: return "R0004";
    case FaultCode::DivisionByZero: return "R0005";
    case FaultCode::DivisionOverflow: return "R0006";
    case FaultCode::InvariantViolated: return "R0007";
    case FaultCode::PriorityCycle: return "R0008";
    case FaultCode::TooManyInteractions: return "R0009";
    case FaultCode::AtomPriorityCycle: return "R0010";
    case FaultCode::Exception: return "R0011";
    case FaultCode::TimeLock: return "R0020";
    case FaultCode::BadClock: return "R0021";
    case FaultCode::LateStep: return "R0022";
    case FaultCode::EventRefused: return "R0023";
    case FaultCode::SourceFailed: return "R0024";
    case FaultCode::ReplayDiffers: return "R0025";
  }
  return "";
}

int published_exit_code(FaultCode code) {
  switch (code) {
    case FaultCode::NotOneSafe: return 2;
    case FaultCode::PriorityCycle: return 3;
    case FaultCode::AtomPriorityCycle: return 4;
    case FaultCode::InvariantViolated: return 5;
    case FaultCode::LateStep: return 7;
    default: return 1;
  }
}

namespace {

void append_position(std::string& out, const Image& image, Loc loc) {
  append_line(out, image, loc);
  if (loc.line == 0 || loc.column == 0) return;
  out += ':';
  append_number(out, loc.column);
}
std::string quoted(const std::string& name) { return '`' + name + '`'; }

}  // namespace

std::string fault_text(const Core& core, std::uint64_t seed, std::uint64_t step) {
  const Fault& fault = core.fault();
  const Image& image = core.image();
  std::string out = "error[";
  out += name_of(fault.code);
  out += "]: " + fault.what + "   (step ";
  append_number(out, step);
  // Errors of time itself say when.
  if (core.is_timed() && fault.code < FaultCode::TimeLock) {
    out += ", at ";
    append_time(out, core.now());
  }
  out += ", seed ";
  append_number(out, seed);
  out += ")\n";
  if (fault.loc.line != 0) {
    out += "  --> ";
    append_position(out, image, fault.loc);
    out += '\n';
  }
  if (fault.other.line != 0) {
    out += "  --> ";
    append_position(out, image, fault.other);
    out += '\n';
  }
  if (!fault.data.empty()) out += "  data: " + fault.data + '\n';
  return out;
}

bool Core::fail(FaultCode code, u32 atom, const Transition* transition, const Transition* other) {
  const AtomType& type = tables_.atom_type(atom);
  fault_ = {};
  fault_.code = code;
  fault_.atom = atom;
  fault_.port = transition->port;
  fault_.loc = transition->loc;
  if (other != nullptr) fault_.other = other->loc;
  fault_.places = places_of(*this, atom);
  fault_.data = data_of(*this, atom);
  const std::string where = quoted(image().atoms[atom].path()) + " at `" + fault_.places + "`";
  const std::string port =
      transition->port == kNone ? "an internal transition" : "port " + quoted(type.ports[transition->port].name);
  switch (code) {
    case FaultCode::TwoTransitions: fault_.what = "two transitions of " + port + " are enabled in " + where; break;
    case FaultCode::TwoInternals: fault_.what = "two internal transitions are enabled in " + where; break;
    case FaultCode::NotOneSafe: {
      // The tokens were taken: name the place that gets a second one.
      std::string place;
      for (u32 to : transition->to) {
        if (place.empty() && is_marked(atom, to)) place = type.places[to];
      }
      fault_.what = port + " puts a second token on `" + place + "` in " + where;
      break;
    }
    default:
      fault_.what = "internal transitions run on without end in " + where + " (bound ";
      append_number(fault_.what, options_.internal_bound);
      fault_.what += ")";
      break;
  }
  return false;
}

bool Core::fail_code(std::int32_t status, u32 atom, u32 connector, const Transition* transition, const char* rule) {
  const u32 site = static_cast<u32>(status - 2) / 2;
  const bool overflow = (static_cast<u32>(status - 2) & 1) == static_cast<u32>(FaultKind::DivisionOverflow);
  fault_ = {};
  fault_.code = overflow ? FaultCode::DivisionOverflow : FaultCode::DivisionByZero;
  fault_.atom = atom;
  fault_.connector = connector;
  const char* function = site < image().sites.size ? image().sites[site].function : nullptr;
  if (site < image().sites.size) fault_.loc = image().sites[site].loc;
  fault_.what = overflow ? "the smallest int divided by -1" : "division by zero";
  if (function != nullptr) {
    fault_.code = FaultCode::Exception;
    fault_.what = "exception in " + quoted(function);
    const std::string message = image().ffi != nullptr ? image().ffi->message() : "";
    if (!message.empty()) fault_.what += ": " + message;
  }
  if (atom != kNone) {
    const AtomType& type = tables_.atom_type(atom);
    fault_.places = places_of(*this, atom);
    fault_.data = data_of(*this, atom);
    fault_.what += " in " + quoted(image().atoms[atom].path()) + " at `" + fault_.places + "`";
    if (rule != nullptr) {
      fault_.rule = rule;
      fault_.what += ", in " + quoted(rule);
    } else if (transition == nullptr) {
      fault_.what += ", while it is initialized";
    } else if (transition->port == kNone) {
      fault_.what += ", in an internal transition";
    } else {
      fault_.port = transition->port;
      fault_.what += ", port " + quoted(type.ports[transition->port].name);
    }
  } else if (connector != kNone) {
    fault_.what += " in connector " + quoted(image().connectors[connector].path());
    // What the code read: the variables of the ports that are bound.
    binds_.make(image());
    const Tables& t = tables_;
    const ConnectorType& type = t.connector_type(connector);
    for (u32 param = 0; param < type.params.size; ++param) {
      const PortType& port = image().port_types[type.params[param].type];
      for (u32 i = 0; i < port.vars.size; ++i) {
        if (!fault_.data.empty()) fault_.data += ", ";
        fault_.data += std::string(type.params[param].name) + "." + port.vars[i].name + " = ";
        const u32 bind = image().connectors[connector].binds + type.params[param].first_bind + i;
        append_value(fault_.data, image(), port.vars[i].type, all_[binds_.rows[bind]]);
      }
    }
  } else {
    fault_.what += " in the guard of a priority";
  }
  return false;
}

bool Core::fail_invariant(u32 atom, const Invariant& invariant, const Transition* fired) {
  fault_ = {};
  fault_.code = FaultCode::InvariantViolated;
  fault_.atom = atom;
  fault_.loc = invariant.loc;
  fault_.rule = invariant.name;
  fault_.places = places_of(*this, atom);
  fault_.data = data_of(*this, atom);
  fault_.what = "invariant " + quoted(invariant.name) + " is violated in " + quoted(image().atoms[atom].path()) +
                " at `" + fault_.places + "`, ";
  if (fired == nullptr) {
    fault_.what += "after it is initialized";
  } else {
    fault_.other = fired->loc;
    fault_.port = fired->port;
    fault_.what += fired->port == kNone ? "after an internal transition"
                                        : "after port " + quoted(tables_.atom_type(atom).ports[fired->port].name);
  }
  return false;
}

bool Core::fail_atom_rules(u32 atom, const std::vector<u32>& rules) {
  fault_ = {};
  fault_.code = FaultCode::AtomPriorityCycle;
  fault_.atom = atom;
  fault_.places = places_of(*this, atom);
  fault_.data = data_of(*this, atom);
  for (u32 row : rules) {
    const AtomPriority& rule = tables_.atom_type(atom).priorities[row];
    if (fault_.loc.line == 0) fault_.loc = rule.loc;
    else if (fault_.other.line == 0) fault_.other = rule.loc;
    fault_.what += fault_.what.empty() ? "priorities close a cycle: " : ", ";
    fault_.what += quoted(rule.name);
    fault_.rule += (fault_.rule.empty() ? "" : ", ") + std::string(rule.name);
  }
  fault_.what += " in " + quoted(image().atoms[atom].path()) + " at `" + fault_.places + "`";
  return false;
}

bool Core::fail_connector(FaultCode code, u32 connector) {
  fault_ = {};
  fault_.code = code;
  fault_.connector = connector;
  fault_.loc = image().connectors[connector].loc;
  fault_.what =
      "too many interactions to enumerate in connector " + quoted(image().connectors[connector].path()) + " (bound ";
  append_number(fault_.what, options_.enumeration_bound);
  fault_.what += ")";
  return false;
}

bool Core::fail_rules(const std::vector<u32>& rules) {
  fault_ = {};
  fault_.code = FaultCode::PriorityCycle;
  for (u32 rule : rules) {
    const Priority& row = image().priorities[rule];
    if (fault_.loc.line == 0) fault_.loc = row.loc;
    else if (fault_.other.line == 0) fault_.other = row.loc;
    fault_.what += fault_.what.empty() ? "priorities close a cycle: " : ", ";
    fault_.what += quoted(row.name);
    fault_.rule += (fault_.rule.empty() ? "" : ", ") + std::string(row.name);
  }
  if (!rules.empty()) {
    const u32 compound = image().priorities[rules[0]].parent;
    if (compound < image().compounds.size)
      fault_.what += std::string(" in ") + quoted(image().compounds[compound].path);
  }
  return false;
}

}  // namespace bip::rt
