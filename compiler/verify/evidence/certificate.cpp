// See certificate.hpp. Deterministic: rows in the order of the system and of finding.
#include "compiler/verify/evidence/certificate.hpp"

#include <algorithm>
#include <map>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// A parameter of the compiler's own ("initial x") has a name that no row can hold; the checker knows its value from the
// system.
bool is_listed(const ModeClass& mode_class, const DataVariable& variable, std::size_t k) {
  return mode_class.followed[k] != 0 && variable.name.find(' ') == std::string::npos;
}

// The same sum without weights below 0: an atom's weights may all be moved, as it is in one of its modes.
TokenInvariant without_negative(const Net& net, const Proof& proof, const TokenInvariant& invariant) {
  if (std::none_of(invariant.weights.begin(), invariant.weights.end(), [](std::int64_t w) { return w < 0; }))
    return invariant;
  TokenInvariant result{invariant.kind, {}, {}, invariant.total};
  for (std::size_t k = 0; k < invariant.modes.size();) {
    const u32 atom = net.atom_of_mode[invariant.modes[k]];
    std::map<u32, std::int64_t> weights;
    std::int64_t least = 0;
    for (; k < invariant.modes.size() && net.atom_of_mode[invariant.modes[k]] == atom; ++k) {
      weights[invariant.modes[k]] = invariant.weights[k];
      least = std::min(least, invariant.weights[k]);
    }
    for (u32 mode = net.mode_base[atom]; mode < net.mode_base[atom + 1]; ++mode) {
      if (proof.reachable[mode] == 0) continue;
      const auto found = weights.find(mode);
      const std::int64_t weight = (found == weights.end() ? 0 : found->second) - least;
      if (weight == 0) continue;
      result.modes.push_back(mode);
      result.weights.push_back(weight);
    }
    result.total -= least;
  }
  return result;
}

void add_structure(const Net& net, const Proof& proof, std::string& out) {
  const System& system = *net.system;
  for (std::size_t row = 0; row < net.classes.size(); ++row) {
    const ModeClass& mode_class = net.classes[row];
    const AtomType& type = system.atom_types[mode_class.type];
    out += "class " + std::to_string(row) + ' ' + type.name + '\n';
    for (std::size_t m = 0; m < mode_class.modes.size(); ++m) {
      out += "  mode " + std::to_string(m);
      for (u32 place : mode_class.modes[m].places) out += " @" + type.places[place];
      for (std::size_t k = 0; k < type.variables.size(); ++k) {
        const AbstractValue& value = mode_class.modes[m].values[k];
        if (value.is_known && is_listed(mode_class, type.variables[k], k))
          out += " ." + type.variables[k].name + '=' + std::to_string(value.value);
      }
      out += '\n';
    }
  }
  for (std::size_t atom = 0; atom < system.atoms.size(); ++atom) {
    out +=
        "component " + system.atoms[AtomId(atom)].path + " class " + std::to_string(net.class_of[atom]) + " reachable";
    for (u32 mode = net.mode_base[atom]; mode < net.mode_base[atom + 1]; ++mode) {
      if (proof.reachable[mode] != 0) out += ' ' + std::to_string(mode - net.mode_base[atom]);
    }
    out += '\n';
  }
  for (const TokenInvariant& found : proof.invariants) {
    const TokenInvariant invariant = without_negative(net, proof, found);
    const bool is_sum = invariant.kind == InvariantKind::Sum;
    if (is_sum) out += "sum " + std::to_string(invariant.total);
    else out += invariant.kind == InvariantKind::Trap ? "trap" : "one-token";
    for (std::size_t k = 0; k < invariant.modes.size(); ++k) {
      BIP_ASSERT(invariant.modes[k] < net.mode_count(), "mode {} of {}", invariant.modes[k], net.mode_count());
      const u32 mode = invariant.modes[k], atom = net.atom_of_mode[mode];
      out += ' ' + system.atoms[AtomId(std::size_t{atom})].path + ':' + std::to_string(mode - net.mode_base[atom]);
      if (is_sum) out += '*' + std::to_string(invariant.weights[k]);
    }
    out += '\n';
  }
}

void add_lemmas(const TransitionSystem& machine, const std::vector<Cube>& lemmas, const System& system,
                std::string& out) {
  std::size_t row = 0;
  for (const Atom& atom : system.atoms) {
    for (const DataVariable& variable : system.atom_types[atom.type].variables) {
      const Range& range = machine.ranges[row];
      const bool is_narrow = !machine.words[row].empty() && range != kAnyInt && !variable.is_param;
      if (is_narrow)
        out += "lemma " + atom.path + '.' + variable.name + '=' + std::to_string(range.low) + ".." +
               std::to_string(range.high) + '\n';
      ++row;
    }
  }
  for (const Cube& cube : lemmas) {
    out += "lemma";
    for (u32 code : cube) out += ' ' + literal_text(machine.bits[code / 2], (code & 1) == 0, system);
    out += '\n';
  }
}

void add_affine(const AffineInvariants& affine, const System& system, std::string& out) {
  for (const AffineEquation& equation : affine.equations) out += equation_row(equation, system) + '\n';
  for (const VariableBound& bound : affine.bounds) {
    const Atom& atom = system.atoms[AtomId(std::size_t{bound.atom})];
    out += "lemma " + atom.path + '.' + system.atom_types[atom.type].variables[bound.variable].name + "=0.." +
           std::to_string(bound.high) + '\n';
  }
  for (const PlaceValue& value : affine.places) {
    const Atom& atom = system.atoms[AtomId(std::size_t{value.atom})];
    const AtomType& type = system.atom_types[atom.type];
    out += "lemma !" + atom.path + '@' + type.places[value.place] + ' ' + atom.path + '.' +
           type.variables[value.variable].name + '=' + std::to_string(value.value) + '\n';
  }
}

}  // namespace

// "!ROOT.a@EATS", "ROOT.a.n:3"
std::string literal_text(const StateBit& bit, bool value, const System& system) {
  const Atom& atom = system.atoms[AtomId(std::size_t{bit.atom})];
  const AtomType& type = system.atom_types[atom.type];
  std::string out = (value ? "" : "!") + atom.path;
  if (bit.is_place) return out + '@' + type.places[bit.row];
  return out + '.' + type.variables[bit.row].name + ':' + std::to_string(bit.position);
}

std::string structure_rows(const Net& net, const Proof& proof) {
  std::string out;
  add_structure(net, proof, out);
  return out;
}

std::string invariant_rows(const Net& net, const Proof* proof, const AffineInvariants& affine,
                           const TransitionSystem& machine, const System& system) {
  std::string out;
  if (proof != nullptr) add_structure(net, *proof, out);
  add_affine(affine, system, out);
  add_lemmas(machine, {}, system, out);
  return out;
}

namespace {
std::string head_of_claim(const std::string& root_name) { return "bipc-certificate 1\nroot " + root_name + "\nclaim "; }
}  // namespace

std::string certificate_head(const Question& question, const System& system, const std::string& root_name) {
  std::string out = head_of_claim(root_name);
  switch (question.what) {
    case QuestionKind::DeadlockFreedom: out += "deadlock-free"; break;
    case QuestionKind::NoErrors: out += "error-free"; break;
    case QuestionKind::State: out += "never " + certificate_text(question.property, system); break;
    case QuestionKind::NoLocalDeadlock: out += "local-deadlock-free"; break;
    case QuestionKind::Runs:
    case QuestionKind::Branching: BIP_UNREACHABLE("runs and branching time have certificates of their own");
  }
  return out + '\n';
}

std::string certificate(const Portfolio& portfolio, const Question& question, const Decision& decision,
                        const System& system, const std::string& root_name) {
  BIP_ASSERT(decision.outcome == Outcome::Holds, "a certificate for the outcome {}", decision.outcome);
  std::string out = certificate_head(question, system, root_name);
  const auto add_facts = [&] {
    if (decision.facts.proof) add_structure(net_of(decision, portfolio.net()), *decision.facts.proof, out);
    add_affine(decision.facts.affine, system, out);
  };
  std::visit(EvidenceVisitor{
                 [&](const InvariantProof& evidence) {
                   if (const auto& projection = evidence.projection) {
                     out += "method induction\n";
                     add_structure(projection->net, projection->proof, out);
                     for (const std::string& row : projection->rows) out += row + '\n';
                   } else {
                     out += "method invariants\n";
                     add_facts();
                   }
                 },
                 [&](const InductiveProof& evidence) {
                   out += "method induction\n";
                   add_facts();
                   add_lemmas(*portfolio.transition_system(), evidence.lemmas, system, out);
                 },
                 [&](const ReachedStates& evidence) { out += "method induction\n" + evidence.rows; },
                 [&](const StateCount&) {
                   out += "method exhaustive\ncomponents " + std::to_string(system.atoms.size()) + "\nstates " +
                          std::to_string(decision.states) + '\n';
                 },
                 [&](const CountingProof& evidence) { out += "method induction\n" + evidence.rows; },
                 [&](const RegionProof& evidence) { out += "method regions\n" + evidence.rows; },
                 [](const Counterexample&) { BIP_UNREACHABLE("a counterexample has no certificate"); },
                 [](const std::monostate&) { BIP_UNREACHABLE("no verdict has no certificate"); },
             },
             decision.evidence);
  return out + "end\n";
}

// Of an invariant that looks back its inner part is claimed, of each point, with those before errors.
std::optional<std::string> certificate_of_runs(const Formula& formula, const Fairness& fairness,
                                               const std::string& rows, const System& system,
                                               const std::string& root_name) {
  Formula claimed = formula;
  const bool is_of_points = is_invariant_of_past(formula);
  if (is_of_points) claimed.root = formula.nodes[formula.root].b;
  const std::optional<std::string> text = certificate_text(claimed, system);
  if (!text) return std::nullopt;
  return head_of_claim(root_name) +
         (is_of_points ? "points " + *text : "runs " + *text + "\nfairness " + certificate_text(fairness, system)) +
         "\nmethod induction\n" + rows + "end\n";
}

std::optional<std::string> certificate_of_branches(const BranchingFormula& formula, const std::string& rows,
                                                   const System& system, const std::string& root_name) {
  const std::optional<std::string> text = certificate_text(formula, system);
  if (!text) return std::nullopt;
  return head_of_claim(root_name) + "branches " + *text + "\nmethod induction\n" + rows + "end\n";
}

std::optional<std::string> certificate_of_response(const Formula& formula, const rt::ZoneReport& report,
                                                   const std::string& rows, const System& system,
                                                   const std::string& root_name) {
  BIP_ASSERT(formula.has_limit() || report.later > 0, "no limit, and steps are later after {} ticks", report.later);
  const auto text_of = [&](u32 row) {
    Formula part = formula;
    part.root = row;
    return certificate_text(part, system);
  };
  const std::optional<std::string> request =
      formula.response->asks_once ? std::optional<std::string>("first") : text_of(formula.response->request);
  const std::optional<std::string> response = text_of(formula.response->response);
  if (!request || !response) return std::nullopt;
  const std::string claim =
      formula.has_limit() ? "within " + std::to_string(*formula.response->within) + "ns" : "eventually";
  std::string ranks;
  if (!formula.has_limit()) ranks = "later " + std::to_string(report.later) + "ns\n";
  for (const auto& [rank, atom] : report.returning)
    ranks += "returns " + std::to_string(rank) + ' ' + system.atoms[AtomId(std::size_t{atom})].path + '\n';
  return head_of_claim(root_name) + claim + ' ' + *request + ' ' + *response + "\nmethod zones\n" + ranks + rows +
         "end\n";
}

std::string cube_text(const TransitionSystem& machine, const System& system, const Cube& cube) {
  std::string out;
  for (std::size_t k = 0; k < cube.size(); ++k) {
    const StateBit& bit = machine.bits[cube[k] / 2];
    const Atom& atom = system.atoms[AtomId(std::size_t{bit.atom})];
    const AtomType& type = system.atom_types[atom.type];
    const std::string path = atom.path.starts_with("ROOT.") ? atom.path.substr(5) : atom.path;
    if (!out.empty()) out += " and ";
    if (bit.is_place) {
      out += (cube[k] & 1) != 0 ? path + '@' : "not " + path + '@';
      out += type.places[bit.row];
    } else if (type.variables[bit.row].type == Type::Bool) {
      out += path + '.' + type.variables[bit.row].name + ((cube[k] & 1) != 0 ? "" : " = false");
    } else {
      // Bits of one int stand together: as a pattern, highest first, with dots for those that do not matter.
      std::size_t end = k;
      std::string pattern;
      while (end < cube.size() && machine.bits[cube[end] / 2].atom == bit.atom &&
             !machine.bits[cube[end] / 2].is_place && machine.bits[cube[end] / 2].row == bit.row)
        ++end;
      for (u32 position = 0; position <= machine.bits[cube[end - 1] / 2].position; ++position) {
        char digit = '.';
        for (std::size_t j = k; j < end; ++j) {
          if (machine.bits[cube[j] / 2].position == position) digit = (cube[j] & 1) != 0 ? '1' : '0';
        }
        pattern.insert(pattern.begin(), digit);
      }
      out += path + '.' + type.variables[bit.row].name + " with low bits " + pattern;
      k = end - 1;
    }
  }
  return out;
}

std::string invariant_text(const Net& net, const TokenInvariant& invariant) {
  constexpr std::size_t kShown = 12;
  const bool is_sum = invariant.kind == InvariantKind::Sum;
  std::string out = is_sum                                  ? "always " + std::to_string(invariant.total) + " = "
                    : invariant.kind == InvariantKind::Trap ? "always one of "
                                                            : "exactly one of ";
  for (std::size_t k = 0; k < invariant.modes.size() && k < kShown; ++k) {
    const std::int64_t weight = weight_of(invariant, k);
    if (k != 0) out += !is_sum ? ", " : weight < 0 ? " - " : " + ";
    else if (weight < 0) out += '-';
    if (weight != 1 && weight != -1) out += std::to_string(std::abs(weight)) + ' ';
    out += net.mode_name(invariant.modes[k]);
  }
  if (invariant.modes.size() > kShown) out += " … (" + std::to_string(invariant.modes.size()) + " in all)";
  return out;
}

}  // namespace bip::verify
