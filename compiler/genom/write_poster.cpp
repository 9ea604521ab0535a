// A poster with values that rules read: the library's Poster and its values. In the verification flavour a write is a
// choice among all combinations of the values that the rules declare (scope.cpp limits their number), fractions as
// ten-thousandths; in the execution flavour C++ functions return them.
#include <fmt/format.h>

#include "compiler/genom/codels.hpp"
#include "compiler/genom/level_condition.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

const char* type_of(const ValueRow& value, bool calls) {
  return value.type == ValueType::Text ? "string" : value.type == ValueType::Float && calls ? "float" : "int";
}

std::string text_of(const ValueRow& value, std::size_t k, bool calls) {
  BIP_ASSERT(k < value.values.size(), "value {} of {} of `{}`", k, value.values.size(), value.name);
  return value.type == ValueType::Float && !calls ? ten_thousandths(value.values[k]) : value.values[k];
}

}  // namespace

void write_poster(std::string& out, const Plan& plan, std::size_t poster) {
  BIP_ASSERT(poster < plan.poster_types.size() && !plan.poster_types[poster].values.empty(),
             "poster {} of {} holds no values", poster, plan.poster_types.size());
  const PosterPlan& p = plan.poster_types[poster];
  std::string variables, names, data;
  std::size_t choices = 1;
  for (const ValueRow* v : p.values) {
    const std::string name = bip_name(v->name);
    variables += fmt::format(", {} {}", type_of(*v, plan.calls), name);
    names += ", " + name;
    data += fmt::format("    data {} {} = {}\n", type_of(*v, plan.calls), name, text_of(*v, 0, plan.calls));
    choices *= v->values.size();
  }
  out += fmt::format("\n  // Poster {} and what it holds.\n  port type {}(int PosterAge{})\n",
                     plan.module->posters[poster].name.text, p.port_type, variables);
  out += fmt::format("  atom type {}(int oldest)\n    data int PosterAge = 0\n{}", p.type, data);
  std::string ports, transitions;
  for (std::size_t k = 0; k < (plan.calls ? 1 : choices); ++k) {
    const std::string port = plan.calls || choices == 1 ? "write" : fmt::format("write_{}", k + 1);
    ports += (k == 0 ? "" : ", ") + port + "()";
    transitions += fmt::format("    on {} from idle to idle do {{ PosterAge = 0;", port);
    std::size_t rest = k;
    for (const ValueRow* v : p.values) {
      transitions += fmt::format(" {} = {};", bip_name(v->name),
                                 plan.calls ? called_value_function(*plan.module, *v, plan.has_processes) + "()"
                                            : text_of(*v, rest % v->values.size(), false));
      rest /= v->values.size();
    }
    transitions += " }\n";
  }
  out += fmt::format(
      "    export port Signal {}{}\n    export port {} read(PosterAge{})\n    export port Signal grow()\n\n    place "
      "idle\n\n    initial to idle\n\n",
      ports, !plan.calls && choices > 1 ? " as write" : "", p.port_type, names);
  out += transitions +
         "    on read from idle to idle\n    on grow from idle to idle do {\n      if (PosterAge < oldest) then\n      "
         "  PosterAge = PosterAge + 1;\n      fi\n    }\n  end\n";
}

}  // namespace bip::genom
