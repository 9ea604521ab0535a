// See wires.hpp. All connectors have one form: name, data, exported port, define, and a clause if it is not trivial.
#include "compiler/genom/wires.hpp"

#include <fmt/format.h>

#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

std::string joined(const std::vector<std::string>& parts, std::size_t begin, std::size_t end) {
  std::string text;
  for (std::size_t i = begin; i < end; ++i) text += (i == begin ? "" : ", ") + parts[i];
  return text;
}

std::string tree(const Wire& w) {
  BIP_ASSERT(!w.ports.empty() && w.triggers <= w.ports.size(), "connector `{}` has {} triggers among {} ports", w.name,
             w.triggers, w.ports.size());
  if (w.triggers == 0) return joined(w.ports, 0, w.ports.size());
  std::string text = w.triggers == 1 ? w.ports[0] + "'" : "[" + joined(w.ports, 0, w.triggers) + "]'";
  if (w.ports.size() > w.triggers) text += ", " + joined(w.ports, w.triggers, w.ports.size());
  return text;
}

}  // namespace

void write_wire(std::string& out, const Wire& w) {
  const std::string all = joined(w.ports, 0, w.ports.size());
  out += fmt::format("\n    connector {}({})\n", w.name, all);
  if (!w.report_to.empty()) out += "      data string rep\n      export port Report out(rep)\n";
  if (w.exported && w.report_to.empty()) out += "      export port Signal out\n";
  out += fmt::format("      define [{}]\n", tree(w));
  if (!w.report_to.empty()) {
    out += fmt::format("      on {} up {{ rep <- \"{}\"; }} down {{ {}.rep <- rep; }}\n", all, w.report, w.report_to);
  } else if (!w.guard.empty() || !w.action.empty()) {
    const char* down = w.exported ? "down" : "do";
    out += fmt::format("      on {}{}{}\n", all, w.guard.empty() ? "" : " provided " + w.guard,
                       w.action.empty()
                           ? std::string(w.exported ? "" : " do {}")
                           : fmt::format(" {} {{ {}{} }}", down, w.action, w.action.ends_with("fi") ? "" : ";"));
  }
}

void write_export(std::string& out, const std::string& inner, const std::string& name) {
  out += fmt::format("    export port {} as {}\n", inner, name);
}

}  // namespace bip::genom
