// See certificate.hpp. Deterministic: rows in the order of the system and of finding.
#include "compiler/verify/certificate.hpp"

namespace bip::verify {

namespace {

std::string head(const char* method, const std::string& root_name) {
  return "bipc-certificate 1\nroot " + root_name + "\nclaim deadlock-free\nmethod " + method + "\n";
}

std::string value_text(const AbstractValue& value) { return value.is_known ? std::to_string(value.value) : "?"; }

}  // namespace

std::string certificate(const Net& net, const Proof& proof, const std::string& root_name) {
  const System& system = *net.system;
  std::string out = head("invariants", root_name);
  for (std::size_t row = 0; row < net.classes.size(); ++row) {
    const ModeClass& mode_class = net.classes[row];
    const AtomType& type = system.atom_types[mode_class.type];
    out += "class " + std::to_string(row) + ' ' + type.name;
    for (std::size_t k = 0; k < type.slots.size(); ++k) {
      if (mode_class.followed[k] != 0) out += ' ' + type.slots[k].name;
    }
    out += '\n';
    for (std::size_t m = 0; m < mode_class.modes.size(); ++m) {
      out += "  mode " + std::to_string(m) + " at";
      for (u32 place : mode_class.modes[m].places) out += ' ' + type.places[place];
      for (std::size_t k = 0; k < type.slots.size(); ++k) {
        if (mode_class.followed[k] != 0) out += ' ' + type.slots[k].name + '=' + value_text(mode_class.modes[m].values[k]);
      }
      out += '\n';
    }
  }
  for (std::size_t atom = 0; atom < system.atoms.size(); ++atom) {
    out += "component " + system.atoms[AtomId(atom)].path + " class " + std::to_string(net.class_of[atom]) + " reachable";
    for (u32 mode = net.mode_base[atom]; mode < net.mode_base[atom + 1]; ++mode) {
      if (proof.reachable[mode] != 0) out += ' ' + std::to_string(mode - net.mode_base[atom]);
    }
    out += '\n';
  }
  for (const TokenInvariant& invariant : proof.invariants) {
    out += invariant.kind == InvariantKind::Trap ? "trap" : "one-token";
    for (u32 mode : invariant.modes) {
      const u32 atom = net.atom_of_mode[mode];
      out += ' ' + system.atoms[AtomId(std::size_t{atom})].path + ':' + std::to_string(mode - net.mode_base[atom]);
    }
    out += '\n';
  }
  return out + "end\n";
}

std::string exhaustive_certificate(const System& system, const std::string& root_name, std::uint64_t states) {
  return head("exhaustive", root_name) + "components " + std::to_string(system.atoms.size()) + "\nstates " + std::to_string(states) + "\nend\n";
}

std::string invariant_text(const Net& net, const TokenInvariant& invariant) {
  constexpr std::size_t kShown = 12;
  std::string out = invariant.kind == InvariantKind::Trap ? "always one of " : "exactly one of ";
  for (std::size_t k = 0; k < invariant.modes.size() && k < kShown; ++k) {
    if (k != 0) out += ", ";
    out += net.mode_name(invariant.modes[k]);
  }
  if (invariant.modes.size() > kShown) out += " … (" + std::to_string(invariant.modes.size()) + " in all)";
  return out;
}

}  // namespace bip::verify
