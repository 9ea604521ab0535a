// See word_certificate.hpp. Deterministic: rows in the order of the description and of the automaton.
#include "compiler/verify/evidence/word_certificate.hpp"

#include <fmt/format.h>

#include "compiler/system/system.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

std::string joined_port(const SizedPort& port, const SizedFamily& family, const std::string& name) {
  const std::string array = "ROOT." + family.name;
  switch (port.place) {
    case ElementPlace::Single: return fmt::format(" (one {} {})", element_path(family, port.offset), name);
    case ElementPlace::FromStart: return fmt::format(" (first {} {} {})", port.offset, array, name);
    case ElementPlace::FromEnd: return fmt::format(" (last {} {} {})", port.offset, array, name);
    case ElementPlace::AtLoop: return fmt::format(" (at {} {} {})", port.offset, array, name);
    case ElementPlace::Every: return fmt::format(" (all {} {})", array, name);
  }
  BIP_UNREACHABLE("a place");
}

}  // namespace

std::string for_all_rows(const SizedCompound& sized, const Model& model, const CompoundType& type) {
  std::string out = fmt::format("(for-all {} {}\n", type.params.front().name, sized.least_size());
  for (const SizedFamily& family : sized.families) {
    if (family.kind == ArrayKind::Sized) out += fmt::format("  (array ROOT.{})\n", family.name);
  }
  for (const SizedConnector& connector : sized.connectors) {
    out += fmt::format("  (join ROOT.{}", type.connectors[connector.family].name);
    if (connector.is_loop) out += fmt::format(" (each {} {})", connector.low, connector.high);
    for (const SizedPort& port : connector.ports) {
      const SizedFamily& family = sized.families[port.family];
      out += joined_port(port, family, model.atom_types[family.type].ports[port.port].name);
    }
    out += ")\n";
  }
  return out + ")\n";
}

std::string certificate_of_sizes(const SizedCompound& sized, const Net& net, const WordAnswer& answer,
                                 const std::string& root_name) {
  Proof all_modes;
  all_modes.reachable.assign(net.mode_count(), 1);
  std::string out = certificate_head({}, *net.system, root_name) + "method words\n" + structure_rows(net, all_modes);
  std::vector<std::string> alone;
  std::vector<const SizedFamily*> arrays;
  for (const SizedFamily& family : sized.families) {
    if (family.kind == ArrayKind::Sized) arrays.push_back(&family);
    for (std::int64_t k = 0; family.kind != ArrayKind::Sized && k < family.count; ++k)
      alone.push_back(element_path(family, k));
  }
  for (const WordSetRow& row : answer.sets) {
    const char* const promise = row.promise == SetPromise::Trap     ? "trap"
                                : row.promise == SetPromise::AtMost ? "at-most"
                                                                    : "at-least";
    out += row.is_first ? fmt::format("begin {} {}", promise, row.to)
                        : fmt::format("next {} {} {}", row.from, row.zone, row.to);
    for (const auto& [atom, mode] : row.modes) {
      const std::string path =
          row.is_first ? alone[atom] : element_path(*arrays[atom], static_cast<std::int64_t>(row.zone));
      out += fmt::format(" {}:{}", path, mode);
    }
    out += '\n';
  }
  return out + "end\n";
}

}  // namespace bip::verify
