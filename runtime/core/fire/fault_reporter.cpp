// See fault_reporter.hpp.
#include "runtime/core/fire/fault_reporter.hpp"

#include "bip/assert.hpp"
#include "bip/draws.hpp"
#include "bip/ffi.hpp"
#include "runtime/core/core_parts.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

namespace {

std::string quoted(const std::string& name) { return '`' + name + '`'; }

}  // namespace

bool FaultReporter::fail(FaultCode code, u32 atom, const Transition* transition, const Transition* other) {
  const AtomType& type = core_.tables.atom_type(atom);
  core_.fault = {};
  core_.fault.code = code;
  core_.fault.atom = atom;
  core_.fault.port = transition->port;
  core_.fault.loc = transition->loc;
  if (other != nullptr) core_.fault.other = other->loc;
  core_.fault.places = places_of(core_, atom);
  core_.fault.data = data_of(core_, atom);
  const std::string where = quoted(core_.image().atoms[atom].path()) + " at `" + core_.fault.places + "`";
  const std::string port =
      transition->port == kNone ? "an internal transition" : "port " + quoted(type.ports[transition->port].name);
  switch (code) {
    case FaultCode::TwoTransitions: core_.fault.what = "two transitions of " + port + " are enabled in " + where; break;
    case FaultCode::TwoInternals: core_.fault.what = "two internal transitions are enabled in " + where; break;
    case FaultCode::NotOneSafe: {
      // The tokens were taken: name the place that gets a second one.
      std::string place;
      for (u32 to : transition->to) {
        if (place.empty() && core_.is_marked(atom, to)) place = type.places[to];
      }
      core_.fault.what = port + " puts a second token on `" + place + "` in " + where;
      break;
    }
    case FaultCode::EndlessInternals:
      core_.fault.what = "internal transitions run on without end in " + where + " (bound ";
      append_number(core_.fault.what, core_.options.internal_bound);
      core_.fault.what += ")";
      break;
    case FaultCode::None:
    case FaultCode::DivisionByZero:
    case FaultCode::DivisionOverflow:
    case FaultCode::InvariantViolated:
    case FaultCode::PriorityCycle:
    case FaultCode::TooManyInteractions:
    case FaultCode::AtomPriorityCycle:
    case FaultCode::Exception:
    case FaultCode::TimeLock:
    case FaultCode::BadClock:
    case FaultCode::LateStep:
    case FaultCode::EventRefused:
    case FaultCode::SourceFailed:
    case FaultCode::ReplayDiffers:
    case FaultCode::BadDraw:
    case FaultCode::UntriedDraw: BIP_UNREACHABLE("not a fault of a transition");
  }
  return false;
}

bool FaultReporter::fail_code(std::int32_t status, u32 atom, u32 connector, const Transition* transition,
                              const char* rule) {
  const u32 site = static_cast<u32>(status - 2) / 2;
  const bool overflow = (static_cast<u32>(status - 2) & 1) == static_cast<u32>(FaultKind::DivisionOverflow);
  core_.fault = {};
  core_.fault.code = overflow ? FaultCode::DivisionOverflow : FaultCode::DivisionByZero;
  core_.fault.atom = atom;
  core_.fault.connector = connector;
  const char* function = site < core_.image().sites.size ? core_.image().sites[site].function : nullptr;
  if (site < core_.image().sites.size) core_.fault.loc = core_.image().sites[site].loc;
  core_.fault.what = overflow ? "the smallest int divided by -1" : "division by zero";
  if (function != nullptr && core_.image().sites[site].is_draw) {
    core_.fault.code = draw_problem().is_of_search ? FaultCode::UntriedDraw : FaultCode::BadDraw;
    core_.fault.what = draw_problem().text;
  } else if (function != nullptr) {
    core_.fault.code = FaultCode::Exception;
    core_.fault.what = "exception in " + quoted(function);
    const std::string message = core_.image().ffi != nullptr ? core_.image().ffi->message() : "";
    if (!message.empty()) core_.fault.what += ": " + message;
  }
  if (atom != kNone) {
    const AtomType& type = core_.tables.atom_type(atom);
    core_.fault.places = places_of(core_, atom);
    core_.fault.data = data_of(core_, atom);
    core_.fault.what += " in " + quoted(core_.image().atoms[atom].path()) + " at `" + core_.fault.places + "`";
    if (rule != nullptr) {
      core_.fault.rule = rule;
      core_.fault.what += ", in " + quoted(rule);
    } else if (transition == nullptr) {
      core_.fault.what += ", while it is initialized";
    } else if (transition->port == kNone) {
      core_.fault.what += ", in an internal transition";
    } else {
      core_.fault.port = transition->port;
      core_.fault.what += ", port " + quoted(type.ports[transition->port].name);
    }
  } else if (connector != kNone) {
    core_.fault.what += " in connector " + quoted(core_.image().connectors[connector].path());
    // What the code read: the variables of the ports that are bound.
    core_.memory.binds.make(core_.image());
    const Tables& t = core_.tables;
    const ConnectorType& type = t.connector_type(connector);
    for (u32 param = 0; param < type.params.size; ++param) {
      const PortType& port = core_.image().port_types[type.params[param].type];
      for (u32 i = 0; i < port.vars.size; ++i) {
        if (!core_.fault.data.empty()) core_.fault.data += ", ";
        core_.fault.data += std::string(type.params[param].name) + "." + port.vars[i].name + " = ";
        const u32 bind = core_.image().connectors[connector].binds + type.params[param].first_bind + i;
        append_value(core_.fault.data, core_.image(), port.vars[i].type,
                     core_.memory.cells[VariableId(core_.memory.binds.rows[bind])]);
      }
    }
  } else {
    core_.fault.what += " in the guard of a priority";
  }
  return false;
}

bool FaultReporter::fail_invariant(u32 atom, const Invariant& invariant, const Transition* fired) {
  core_.fault = {};
  core_.fault.code = FaultCode::InvariantViolated;
  core_.fault.atom = atom;
  core_.fault.loc = invariant.loc;
  core_.fault.rule = invariant.name;
  core_.fault.places = places_of(core_, atom);
  core_.fault.data = data_of(core_, atom);
  core_.fault.what = "invariant " + quoted(invariant.name) + " is violated in " +
                     quoted(core_.image().atoms[atom].path()) + " at `" + core_.fault.places + "`, ";
  if (fired == nullptr) {
    core_.fault.what += "after it is initialized";
  } else {
    core_.fault.other = fired->loc;
    core_.fault.port = fired->port;
    core_.fault.what += fired->port == kNone
                            ? "after an internal transition"
                            : "after port " + quoted(core_.tables.atom_type(atom).ports[fired->port].name);
  }
  return false;
}

bool FaultReporter::fail_atom_rules(u32 atom, const std::vector<u32>& rules) {
  core_.fault = {};
  core_.fault.code = FaultCode::AtomPriorityCycle;
  core_.fault.atom = atom;
  core_.fault.places = places_of(core_, atom);
  core_.fault.data = data_of(core_, atom);
  for (u32 row : rules) {
    const AtomPriority& rule = core_.tables.atom_type(atom).priorities[row];
    if (core_.fault.loc.line == 0) core_.fault.loc = rule.loc;
    else if (core_.fault.other.line == 0) core_.fault.other = rule.loc;
    core_.fault.what += core_.fault.what.empty() ? "priorities close a cycle: " : ", ";
    core_.fault.what += quoted(rule.name);
    core_.fault.rule += (core_.fault.rule.empty() ? "" : ", ") + std::string(rule.name);
  }
  core_.fault.what += " in " + quoted(core_.image().atoms[atom].path()) + " at `" + core_.fault.places + "`";
  return false;
}

bool FaultReporter::fail_connector(FaultCode code, u32 connector) {
  core_.fault = {};
  core_.fault.code = code;
  core_.fault.connector = connector;
  core_.fault.loc = core_.image().connectors[connector].loc;
  core_.fault.what = "too many interactions to enumerate in connector " +
                     quoted(core_.image().connectors[connector].path()) + " (bound ";
  append_number(core_.fault.what, core_.options.enumeration_bound);
  core_.fault.what += ")";
  return false;
}

bool FaultReporter::fail_rules(const std::vector<u32>& rules) {
  core_.fault = {};
  core_.fault.code = FaultCode::PriorityCycle;
  for (u32 rule : rules) {
    const Priority& row = core_.image().priorities[rule];
    if (core_.fault.loc.line == 0) core_.fault.loc = row.loc;
    else if (core_.fault.other.line == 0) core_.fault.other = row.loc;
    core_.fault.what += core_.fault.what.empty() ? "priorities close a cycle: " : ", ";
    core_.fault.what += quoted(row.name);
    core_.fault.rule += (core_.fault.rule.empty() ? "" : ", ") + std::string(row.name);
  }
  if (!rules.empty()) {
    const u32 compound = core_.image().priorities[rules[0]].parent;
    if (compound < core_.image().compounds.size)
      core_.fault.what += std::string(" in ") + quoted(core_.image().compounds[compound].path);
  }
  return false;
}

}  // namespace bip::rt
