// Atoms in Promela. Names: `p3` is the place of atom 3 (`m3_1`: whether place 1 of a Petri net atom is marked), `d3_0`
// its variable 0, `on3_1` whether its port 1 is enabled; `settle3()` runs its internal transitions after a step.
#include <algorithm>

#include <fmt/format.h>

#include "compiler/exchange/promela.hpp"

namespace bip::exchange {

namespace {
const char* type_name(Type type) { return type == Type::Bool ? "bool" : "int"; }
}  // namespace

std::string PromelaWriter::variable_name(AtomId atom, u32 variable) const {
  if (type_of(atom).variables[variable].is_param && type_of(atom).variables[variable].type != Type::Float) {
    const std::int32_t value = system_.atoms[atom].args[variable].int_value;
    return value < 0 ? fmt::format("({})", value) : std::to_string(value);
  }
  return fmt::format("d{}_{}", atom.value, variable);
}

Names PromelaWriter::names_of(AtomId atom) const {
  Names names;
  names.self = [this, atom](u32 k) { return variable_name(atom, k); };
  names.bind = [](u32) { return std::string(); };
  return names;
}

std::string PromelaWriter::marked(AtomId atom, const std::vector<u32>& places) const {
  if (type_of(atom).is_automaton()) return fmt::format("p{} == {}", atom.value, places[0]);
  std::string all;
  for (u32 place : places) all += fmt::format("{}m{}_{}", all.empty() ? "" : " && ", atom.value, place);
  return all;
}

std::string PromelaWriter::enabled(AtomId atom, const Transition& t) {
  const std::string here = marked(atom, t.from);
  return t.guard.is_valid() ? fmt::format("({} && {})", here, code_.text(t.guard, names_of(atom))) : '(' + here + ')';
}

// Both at once; empty if their places exclude each other.
std::string PromelaWriter::both(AtomId atom, const Transition& a, const Transition& b) {
  if (type_of(atom).is_automaton() && a.from != b.from) return {};
  return fmt::format("({} && {})", enabled(atom, a), enabled(atom, b));
}

// Tokens, action, invariants. A run-time error sets `fault`; what is done after that no longer matters.
std::string PromelaWriter::move(AtomId atom, const Transition& t, const std::string& indent) {
  const AtomType& type = type_of(atom);
  std::string out;
  if (type.is_automaton()) {
    out += fmt::format("{}p{} = {};\n", indent, atom.value, t.to[0]);
  } else {
    for (u32 place : t.from) out += fmt::format("{}m{}_{} = false;\n", indent, atom.value, place);
    for (u32 place : t.to) {
      out += fmt::format("{0}if\n{0}:: m{1}_{2} -> fault = true;\n{0}:: else -> m{1}_{2} = true;\n{0}fi;\n", indent,
                         atom.value, place);
    }
  }
  out += code_.statements(t.action, names_of(atom), indent);
  if (!type.invariants.empty()) out += fmt::format("{}keep{}();\n", indent, atom.value);
  return out;
}

void PromelaWriter::declare(AtomId atom) {
  const AtomType& type = type_of(atom);
  declarations_ += fmt::format("/* {}:", plain(system_.atoms[atom].path));
  for (std::size_t place = 0; place < type.places.size(); ++place)
    declarations_ += fmt::format(" {} {}", place, plain(type.places[place]));
  declarations_ += " */\n";
  const auto is_initial = [&](std::size_t place) {
    return std::find(type.initial.begin(), type.initial.end(), place) != type.initial.end();
  };
  if (type.is_automaton())
    declarations_ +=
        fmt::format("{} p{} = {};\n", type.places.size() > 255 ? "int" : "byte", atom.value, type.initial[0]);
  for (std::size_t place = 0; !type.is_automaton() && place < type.places.size(); ++place) {
    declarations_ += fmt::format("bool m{}_{} = {};\n", atom.value, place, is_initial(place));
  }
  for (std::size_t k = 0; k < type.variables.size(); ++k) {
    const DataVariable& variable = type.variables[k];
    if (is_ffi(variable.type)) code_.refuse("data of type " + system_.code.type_name(variable.type), variable.loc);
    if (!variable.is_param && variable.type != Type::Float)
      declarations_ +=
          fmt::format("{} d{}_{}; /* {} */\n", type_name(variable.type), atom.value, k, plain(variable.name));
  }
}

void PromelaWriter::add_ports(AtomId atom) {
  const AtomType& type = type_of(atom);
  const std::size_t count = type.ports.size();
  std::vector<std::set<std::size_t>> above(count);
  std::vector<std::vector<std::string>> guards(count, std::vector<std::string>(count));
  for (const AtomPriority& rule : type.priorities) {
    for (u32 low = 0; low < count; ++low) {
      for (u32 high = 0; high < count; ++high) {
        const bool fits_low = rule.low == AtomPriority::kAnyPort
                                  ? rule.high == AtomPriority::kAnyPort || low != rule.high
                                  : rule.low == low;
        const bool fits_high = rule.high == AtomPriority::kAnyPort
                                   ? rule.low == AtomPriority::kAnyPort || high != rule.low
                                   : rule.high == high;
        if (!fits_low || !fits_high) continue;
        above[low].insert(high);
        std::string& guard = guards[low][high];
        guard += (guard.empty() ? "" : " || ") + code_.text(rule.guard, names_of(atom));
      }
    }
  }
  if (has_cycle(above)) return code_.refuse("priorities of an atom that only guards keep from being a cycle", type.loc);
  const bool has_rules = !type.priorities.empty();
  for (u32 port = 0; port < count; ++port) {
    std::string some;
    for (const Transition& t : type.transitions) {
      if (t.port == port) some += (some.empty() ? "" : " || ") + enabled(atom, t);
    }
    if (some.empty()) some = "false";
    const std::string name = port_name(atom, port);
    macros_ += fmt::format("#define {}{} ({})", has_rules ? "raw_" : "", name, some);
    macros_ += fmt::format(" /* {}.{} */\n", plain(system_.atoms[atom].path), plain(type.ports[port].name));
    if (!has_rules) continue;
    std::string covered = "false";
    for (std::size_t high : above[port]) {
      const std::string other = port_name(atom, static_cast<u32>(high));
      covered += fmt::format(" || (({}) && (raw_{} || covers_{}))", guards[port][high], other, other);
    }
    macros_ += fmt::format("#define covers_{0} ({1})\n#define {0} (raw_{0} && !covers_{0})\n", name, covered);
  }
}

// Invariants; internal transitions until there is none; two transitions at once.
void PromelaWriter::add_settle(AtomId atom) {
  const AtomType& type = type_of(atom);
  if (!type.invariants.empty()) {
    inlines_ += fmt::format("inline keep{}() {{\n", atom.value);
    for (const Invariant& row : type.invariants) {
      std::string here = "true";
      if (row.scope != InvariantScope::Always && !type.is_automaton())
        here = row.places.empty() ? "true" : marked(atom, row.places);
      else if (row.scope != InvariantScope::Always)
        here = row.places.size() > 1 ? "false"
               : row.places.empty()  ? (row.scope == InvariantScope::At ? "false" : "true")
                                     : marked(atom, row.places);
      for (u32 place = 0; row.scope == InvariantScope::At && !type.is_automaton() && place < type.places.size();
           ++place) {
        if (!std::binary_search(row.places.begin(), row.places.end(), place))
          here += fmt::format(" && !m{}_{}", atom.value, place);
      }
      inlines_ += fmt::format("  if\n  :: ({}) && !({}) -> fault = true;\n  :: else -> skip;\n  fi;\n", here,
                              code_.text(row.condition, names_of(atom)));
    }
    inlines_ += "}\n";
  }
  std::string internals, twice, ports_twice;
  for (std::size_t k = 0; k < type.transitions.size(); ++k) {
    const Transition& t = type.transitions[k];
    for (std::size_t j = 0; j < k; ++j) {
      if (type.transitions[j].port != t.port) continue;
      const std::string pair = both(atom, type.transitions[j], t);
      if (pair.empty()) continue;
      std::string& list = t.port == Transition::kInternal ? twice : ports_twice;
      list += (list.empty() ? "" : " || ") + pair;
    }
    if (t.port == Transition::kInternal)
      internals += fmt::format("  :: !fault && {} ->\n{}", enabled(atom, t), move(atom, t, "     "));
  }
  inlines_ += fmt::format("inline settle{}() {{\n", atom.value);
  if (!internals.empty()) {
    inlines_ += "  do\n";
    if (!twice.empty()) inlines_ += fmt::format("  :: !fault && ({}) -> fault = true;\n", twice);
    inlines_ += internals + "  :: else -> break;\n  od;\n";
  }
  if (!ports_twice.empty())
    inlines_ += fmt::format("  if\n  :: ({}) -> fault = true;\n  :: else -> skip;\n  fi;\n", ports_twice);
  if (internals.empty() && ports_twice.empty()) inlines_ += "  skip;\n";
  inlines_ += "}\n";
}

void PromelaWriter::add_initial(AtomId atom, std::string& out) {
  const AtomType& type = type_of(atom);
  out += code_.statements(type.initial_action, names_of(atom), "    ");
  if (!type.invariants.empty()) out += fmt::format("    keep{}();\n", atom.value);
  out += fmt::format("    settle{}();\n", atom.value);
}

}  // namespace bip::exchange
