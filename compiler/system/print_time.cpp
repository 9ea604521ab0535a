// Bounds on clocks and `resume` as .bsys text: see print_code.hpp.
#include <fmt/format.h>

#include <iterator>

#include "compiler/system/print_code.hpp"

namespace bip::system::text {

void put_when(std::string& out, const CodeTable& code, const AtomType& type, const TimeGuard& when,
              const CodeScope& scope) {
  for (const Bound& bound : when.bounds) {
    fmt::format_to(std::back_inserter(out), " (bound {} ", name_of(bound.op));
    put_ref(out, bound.clock, type.clocks[bound.clock].name);
    if (bound.minus != Bound::kNone) {
      out += " (minus ";
      put_ref(out, bound.minus, type.clocks[bound.minus].name);
      out += ')';
    }
    if (bound.variable == Bound::kNone) {
      fmt::format_to(std::back_inserter(out), " {}ns", bound.ticks);
    } else {
      out += " (slot ";
      put_ref(out, bound.variable, type.variables[bound.variable].name);
      out += ')';
    }
    put_loc(out, bound.loc);
    out += ')';
  }
  if (!when.measure.is_valid()) return;
  out += " (measure";
  put_stmts(out, code, when.measure, scope);
  out += ')';
}

void put_resume(std::string& out, const CodeTable& code, const AtomType& type, const Resume& resume,
                const CodeScope& scope) {
  if (!resume.present) return;
  out += " (resume";
  if (resume.guard.is_valid()) {
    out += " (guard ";
    put_expr(out, code, resume.guard, scope);
    out += ')';
  }
  put_when(out, code, type, resume.when, scope);
  put_loc(out, resume.loc);
  out += ')';
}

}  // namespace bip::system::text
