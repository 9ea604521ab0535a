// Properties of a fixed system: an error with its column, or a property that can be evaluated, encoded and written.
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/interp/interp.hpp"
#include "compiler/lower/lower.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/verify/liveness/automaton.hpp"
#include "compiler/verify/property/property.hpp"
#include "compiler/verify/symbolic/property_signal.hpp"
#include "tests/fuzz/targets.hpp"

namespace bip::fuzz {
namespace {

// Places, data of each type, a connector, a port that no connector has alone.
constexpr const char* kModel =
    "package fuzz\n"
    "  port type Signal()\n"
    "  connector type Two(Signal a, Signal b)\n"
    "    define a b\n"
    "  end\n"
    "  atom type Tank(int size)\n"
    "    data int level = 0\n"
    "    data float heat = 1.5\n"
    "    data bool open = false\n"
    "    data string name = \"tank\"\n"
    "    export port Signal fill(), drain()\n"
    "    place LOW, HIGH\n"
    "    initial to LOW\n"
    "    on fill from LOW to HIGH provided (level < size) do { level = level + 1; heat = heat * 2.0; }\n"
    "    on drain from HIGH to LOW do { open = !open; }\n"
    "  end\n"
    "  compound type Root()\n"
    "    component Tank tank(3), other(4)\n"
    "    connector Two fills(tank.fill, other.fill), drains(tank.drain, other.drain)\n"
    "  end\n"
    "end\n";

struct FixedSystem {
  pipeline::Compilation compilation{pipeline::CompileOptions{}};
  std::unique_ptr<interp::Interpreter> interpreter;

  FixedSystem() {
    compilation.open_texts["/nowhere/fuzz.bip"] = kModel;
    if (pipeline::compile(compilation, "/nowhere/fuzz.bip", pipeline::Stage::Image))
      interpreter = std::make_unique<interp::Interpreter>(*compilation.lowered);
  }
};

}  // namespace

Verdict try_property(std::string_view input) {
  static const FixedSystem fixed;
  if (fixed.interpreter == nullptr) return {"property: the fixed system does not compile", false};
  const System& system = *fixed.compilation.system;
  const rt::Image& image = fixed.compilation.lowered->image;
  // The larger language first; what is a property of states there is one here.
  Result<verify::ParsedProperty> any = verify::PropertyReader(system).read(std::string(input));
  if (any && any->form == verify::PropertyForm::Branching) {
    const std::optional<std::string> claim = verify::certificate_text(any->branching, system);
    return {claim && (claim->empty() || claim->find('\n') != std::string::npos) ? "property: the claim is not one line"
                                                                                : "",
            true};
  }
  if (any && any->form == verify::PropertyForm::Runs) {
    const Result<verify::Automaton> automaton = verify::make_automaton(any->formula, verify::RunsOf::Negation);
    return {!automaton && automaton.error().empty() ? "property: no automaton, and no reason" : "", true};
  }
  Result<verify::Property> property = verify::parse_property(std::string(input), system);
  if (!any && property) return {"property: a property of states that only the smaller language has", false};
  // `always (a implies b)` is one, in words of the larger language.
  if (any && !property) property = any->state;
  if (!property) return {property.error().starts_with("column ") ? "" : "property: an error without its column", false};
  rt::Core core(image);
  if (!core.initialize()) return {"property: the fixed system does not start", false};
  (void)verify::is_broken(*property, core);
  verify::TransitionSystem machine = verify::build_transition_system(system, image);
  (void)verify::broken_signal(*property, machine, image);
  // The claim of a certificate is one line.
  const std::string claim = verify::certificate_text(*property, system);
  return {claim.empty() || claim.find('\n') != std::string::npos ? "property: the claim is not one line" : "", true};
}

}  // namespace bip::fuzz
