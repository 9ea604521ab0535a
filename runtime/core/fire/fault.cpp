// Codes and text of faults. See fault.hpp.
#include "runtime/core/fire/fault.hpp"

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
    case FaultCode::BadDraw: return "R0070";
    case FaultCode::UntriedDraw: return "R0071";
  }
  return "";
}

int published_exit_code(FaultCode code) {
  switch (code) {
    case FaultCode::NotOneSafe: return 2;
    case FaultCode::PriorityCycle: return 3;
    case FaultCode::AtomPriorityCycle: return 4;
    case FaultCode::InvariantViolated: return 5;
    case FaultCode::EventRefused: return 6;
    case FaultCode::LateStep: return 7;
    // An end like a deadlock.
    case FaultCode::TimeLock: return 0;
    case FaultCode::None:
    case FaultCode::TwoTransitions:
    case FaultCode::TwoInternals:
    case FaultCode::EndlessInternals:
    case FaultCode::DivisionByZero:
    case FaultCode::DivisionOverflow:
    case FaultCode::TooManyInteractions:
    case FaultCode::Exception:
    case FaultCode::BadClock:
    case FaultCode::SourceFailed:
    case FaultCode::ReplayDiffers:
    case FaultCode::BadDraw:
    case FaultCode::UntriedDraw: break;
  }
  return 1;
}

namespace {

void append_position(std::string& out, const Image& image, SourceLine loc) {
  append_line(out, image, loc);
  if (loc.line == 0 || loc.column == 0) return;
  out += ':';
  append_number(out, loc.column);
}

}  // namespace

std::string fault_text(const Core& core, std::uint64_t seed, std::uint64_t step,
                       const std::function<std::string(SourceLine)>& show_source) {
  const Fault& fault = core.fault();
  const Image& image = core.image();
  std::string out = "error[";
  out += name_of(fault.code);
  out += "]: " + fault.what + "   (step ";
  append_number(out, step);
  // Errors of time itself say when.
  if (core.is_timed() && (fault.code < FaultCode::TimeLock || fault.code >= FaultCode::BadDraw)) {
    out += ", at ";
    append_time(out, core.now());
  }
  out += ", seed ";
  append_number(out, seed);
  out += ")\n";
  for (const SourceLine place : {fault.loc, fault.other}) {
    if (place.line == 0) continue;
    const std::string shown = show_source ? show_source(place) : std::string();
    out += shown;
    if (!shown.empty()) continue;
    out += "  --> ";
    append_position(out, image, place);
    out += '\n';
  }
  if (!fault.data.empty()) out += "  data: " + fault.data + '\n';
  return out;
}

}  // namespace bip::rt
