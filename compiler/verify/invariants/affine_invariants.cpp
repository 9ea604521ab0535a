// See affine_invariants.hpp. Unknowns: by how much each port changes the sum; the weights of places; the weights of
// ints. The latter are reluctant pivots, so that each one that stays free gives an equation.
//
// Steps, in the words of S. Sankaranarayanan, H. Sipma, Z. Manna (2003):
//   1. Template: one sum of places and ints with unknown weights.
//   2. Consecution: each path through the code of a transition or a transfer changes the sum by a constant (the factor
//      of each variable is 0), and the changes of an interaction's parts cancel out. What guards and places say is
//      substituted first. Assignments act on affine forms as in M. Karr (1976); a value that is no affine form gives
//      its variable weight 0.
//   3. Solve the homogeneous equations over the integers. A solution holds modulo 2^32 as well, as the ring has fewer
//      inverses but all sums and products (M. Müller-Olm, H. Seidl 2005).
//   4. Check each solution again in all equations.
//   5. Initiation: the total is the sum in the initial state (affine_bounds.cpp, set_total).
#include "compiler/verify/invariants/affine_invariants.hpp"

#include <algorithm>
#include <set>
#include <span>

#include "compiler/system/system.hpp"
#include "compiler/verify/invariants/affine_bounds.hpp"
#include "compiler/verify/invariants/affine_code.hpp"
#include "compiler/verify/invariants/step_equations.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::size_t kMaxTerms = 20000;
// Of candidate equations: sums stay within 64 bits.
constexpr std::int64_t kMaxCandidateWeight = 1 << 16;

using Term = SparseSystem::Term;
using Row = SparseSystem::Row;
/// What code stores into variables, as affine forms; nothing: not known.
using Stored = std::vector<std::pair<u32, std::optional<AffineForm>>>;

class AffineAnalysis {
 public:
  AffineAnalysis(const Net& net, const TransitionSystem& transition_system, const rt::Image& image)
      : net_(net), system_(*net.system), transition_system_(transition_system), image_(image), code_(system_.code) {
    first_place_ = net.graph.port_count();
    first_variable_ = first_place_;
    for (const Atom& atom : system_.atoms) {
      place_base_.push_back(first_variable_);
      first_variable_ += static_cast<u32>(system_.atom_types[atom.type].places.size());
    }
    is_counter_.assign(image.cell_count, 0);
    // Step 1.
    for (u32 atom = 0; atom < system_.atoms.size(); ++atom) start_.push_back(values_of(atom));
  }

  AffineInvariants run(const CancellationToken& cancellation) {
    SparseSystem system(first_variable_ + image_.cell_count, first_variable_, cancellation);
    // Steps 2 and 3.
    if (!collect(system)) return {};
    system.solve(equations_);
    AffineInvariants facts;
    std::vector<AffineEquation>& found = facts.equations;
    for (u32 variable = 0; variable < image_.cell_count && !system.is_given_up(); ++variable) {
      const u32 unknown = first_variable_ + variable;
      if (is_counter_[variable] == 0 || !system.is_free(unknown) || system.uses(unknown) == 0) continue;
      const std::vector<Term> solution = system.solution(unknown);
      BIP_ASSERT(solution.empty() || solution[0].unknown == unknown, "the solution of unknown {} has another first",
                 unknown);
      // Step 4.
      if (!solves(solution)) continue;
      AffineEquation equation = equation_of(solution);
      if (!equation.terms.empty() && equation.terms.size() <= kMaxTerms) found.push_back(std::move(equation));
    }
    if (!found.empty()) facts.places = places_.rows;
    return facts;
  }

  // Checks candidates: what a port changes follows from what its transitions do, so no elimination is needed.
  AffineInvariants those_that_hold(const std::vector<AffineEquation>& candidates,
                                   const CancellationToken& cancellation) {
    SparseSystem system(first_variable_ + image_.cell_count, first_variable_, cancellation);
    if (!collect(system) || system.is_given_up()) return {};
    AffineInvariants facts;
    for (const AffineEquation& candidate : candidates) {
      if (cancellation.is_over()) return {};
      std::optional<std::vector<Term>> values = values_in(candidate);
      if (values && solves(*values)) facts.equations.push_back(candidate);
    }
    if (!facts.equations.empty()) facts.places = places_.rows;
    return facts;
  }

 private:
  // Step 2: collects the equations of all transitions and steps. False: there is nothing to find.
  bool collect(SparseSystem& system) {
    if (std::find(is_counter_.begin(), is_counter_.end(), 1) == is_counter_.end()) return false;
    ModeReachability reachable(net_, Direction::Forward, nullptr);
    Proof proof;
    spread_from_initial(net_, reachable, proof);
    places_ = find_place_values(net_, transition_system_.is_automaton);
    std::erase_if(places_.rows, [&](const PlaceValue& row) {
      return is_counter_[image_.atoms[row.atom].first_cell + row.variable] == 0 ||
             std::abs(std::int64_t{row.value}) > AffineForm::kMaxNumber;
    });
    for (u32 atom = 0; atom < system_.atoms.size(); ++atom) add_atom(atom, reachable);
    for (std::size_t c = 0; c < system_.connectors.size(); ++c) {
      const Connector& connector = system_.connectors[ConnectorId(c)];
      if (!has_plain_transfer(system_, connector)) leave_out(connector);
    }
    add_step_equations(net_, reachable, system, equations_, [this](u32 node) { return transfers(node); });
    if (is_too_large_) return false;
    rows_with_.assign(first_variable_ + image_.cell_count, {});
    for (u32 row = 0; row < equations_.size(); ++row) {
      for (const Term& term : equations_[row]) rows_with_[term.unknown].push_back(row);
    }
    return true;
  }
  [[nodiscard]] const AtomType& type_of(u32 atom) const {
    return system_.atom_types[system_.atoms[AtomId(std::size_t{atom})].type];
  }
  [[nodiscard]] u32 unknown_of(u32 atom, u32 variable) const {
    BIP_ASSERT(variable < type_of(atom).variables.size(), "variable {} of atom {}", variable, atom);
    return first_variable_ + image_.atoms[atom].first_cell + variable;
  }

  // Step 1: the atom's ints as affine forms: constants, unknowns of their own, or nothing.
  AffineValues values_of(u32 atom) {
    const AtomType& type = type_of(atom);
    const analysis::DataAccess& access = net_.access[net_.class_at(atom).type.value];
    const std::vector<AbstractValue> constants = constants_of(net_.class_at(atom));
    std::vector<std::uint8_t> is_stored(type.variables.size(), 0);
    for (const Transition& t : type.transitions) {
      for_each_assigned(system_.code, t.action, Op::LoadSelf, [&](u32 variable) { is_stored[variable] = 1; });
    }
    for (const std::vector<u32>& variables : access.written) {
      for (u32 variable : variables) is_stored[variable] = 1;
    }
    AffineValues values(type.variables.size());
    for (u32 k = 0; k < type.variables.size(); ++k) {
      if (type.variables[k].type != Type::Int || access.unfollowed[k] != 0) continue;
      if (is_stored[k] == 0 && k < constants.size() && constants[k].is_known) {
        if (std::abs(std::int64_t{constants[k].value}) <= AffineForm::kMaxNumber)
          values[k] = AffineForm{{}, constants[k].value};
        continue;
      }
      if (type.variables[k].is_param || is_stored[k] == 0) continue;
      values[k] = AffineForm{{{unknown_of(atom, k), 1}}, 0};
      is_counter_[image_.atoms[atom].first_cell + k] = 1;
    }
    return values;
  }

  // Step 2, one path: requires that the sum changes by a constant, whatever the variables are: the factor of each
  // variable is 0. Returns that constant as a row. Forms that are 0 (from guards and places) are substituted first.
  Row changed(std::vector<Term> constant, const Stored& stored, const std::vector<AffineForm>& zeros) {
    std::map<u32, std::vector<Term>> rows;
    for (const auto& [unknown, form] : stored) {
      if (is_counter_[unknown - first_variable_] == 0) continue;
      if (!form) {
        equations_.push_back({{unknown, 1}});
        continue;
      }
      for (const auto& [variable, factor] : form->factors) rows[variable].push_back({unknown, factor});
      rows[unknown].push_back({unknown, -1});
      constant.push_back({unknown, form->constant});
    }
    for (const Substitution& substitution : substitutions(zeros)) {
      const auto found = rows.find(substitution.variable);
      if (found == rows.end()) continue;
      const std::vector<Term> taken = std::move(found->second);
      rows.erase(found);
      for (const Term& term : taken) {
        for (const auto& [variable, factor] : substitution.by.factors)
          rows[variable].push_back({term.unknown, term.factor * factor});
        constant.push_back({term.unknown, term.factor * substitution.by.constant});
      }
    }
    for (auto& [variable, terms] : rows) add(SparseSystem::row_of_terms(std::move(terms)));
    Row row = SparseSystem::row_of_terms(std::move(constant));
    is_too_large_ = is_too_large_ || !is_small(row);
    return row;
  }
  [[nodiscard]] static bool is_small(const Row& row) {
    return std::all_of(row.begin(), row.end(),
                       [](const Term& t) { return std::abs(t.factor) <= SparseSystem::kMaxNumber; });
  }
  void add(Row row) {
    is_too_large_ = is_too_large_ || !is_small(row);
    if (!row.empty()) equations_.push_back(std::move(row));
  }

  [[nodiscard]] AffineForm zero_of(const PlaceValue& row) const {
    return {{{unknown_of(row.atom, row.variable), 1}}, -std::int64_t{row.value}};
  }
  [[nodiscard]] std::span<const PlaceValue> values_at(u32 atom, u32 place) const {
    const auto before = [](const PlaceValue& value, const std::pair<u32, u32>& key) {
      return std::pair(value.atom, value.place) < key;
    };
    const auto first = std::lower_bound(places_.rows.begin(), places_.rows.end(), std::pair(atom, place), before);
    const auto last = std::lower_bound(first, places_.rows.end(), std::pair(atom, place + 1), before);
    return {first, last};
  }
  void assume_place(u32 atom, u32 place, AffinePath& path) const {
    for (const PlaceValue& value : values_at(atom, place)) path.zeros.push_back(zero_of(value));
  }
  // Assumes what holds at every place in which the port may be enabled.
  void assume_port(u32 atom, u32 port, AffinePath& path) const {
    if (places_.is_reached[atom].empty()) return;
    std::map<u32, std::int32_t> values;
    bool is_first = true;
    for (const Transition& t : type_of(atom).transitions) {
      if (t.port != port || places_.is_reached[atom][t.from[0]] == 0) continue;
      std::map<u32, std::int32_t> known;
      for (const PlaceValue& row : values_at(atom, t.from[0])) known.emplace(row.variable, row.value);
      if (is_first) values = std::move(known);
      else
        std::erase_if(values, [&](const auto& value) {
          return !known.contains(value.first) || known.at(value.first) != value.second;
        });
      is_first = false;
    }
    for (const auto& [variable, value] : values) path.zeros.push_back(zero_of({atom, 0, variable, value}));
  }

  // Step 2, transitions: moving the tokens and executing the action changes the sum by what the port stands for; an
  // internal transition, which has no port, by nothing.
  void add_atom(u32 atom, const ModeReachability& reachable) {
    const AtomType& type = type_of(atom);
    const analysis::DataAccess& access = net_.access[net_.class_at(atom).type.value];
    for (const Transition& t : type.transitions) {
      const bool has_port = t.port != Transition::kInternal;
      if (has_port && !reachable.in_context(net_.graph.port_base[atom] + t.port)) continue;
      std::vector<Term> constant;
      // An automaton's first place weighs nothing: one more of all its places would change nothing.
      const auto put = [&](const std::vector<u32>& places, std::int64_t sign) {
        for (u32 place : places) {
          if (transition_system_.is_automaton[atom] == 0 || place != 0)
            constant.push_back({place_base_[atom] + place, sign});
        }
      };
      put(t.from, -1);
      put(t.to, 1);
      if (has_port) constant.push_back({net_.graph.port_base[atom] + t.port, -1});
      std::vector<AffinePath> paths(1);
      paths[0].self = start_[atom];
      if (t.from.size() == 1) assume_place(atom, t.from[0], paths[0]);
      code_.assume(t.guard, paths[0]);
      // A transfer may change the data between the guard and the action.
      for (u32 variable : has_port ? access.written[t.port] : std::vector<u32>()) {
        std::erase_if(paths[0].zeros,
                      [&](const AffineForm& form) { return form.factors.contains(unknown_of(atom, variable)); });
      }
      std::set<u32> variables;
      for_each_assigned(system_.code, t.action, Op::LoadSelf, [&](u32 variable) { variables.insert(variable); });
      const bool is_followed = code_.execute(t.action, paths);
      if (!is_followed) paths.resize(1);
      for (const AffinePath& path : paths) {
        Stored stored;
        for (u32 variable : variables)
          stored.emplace_back(unknown_of(atom, variable), is_followed ? path.self[variable] : std::nullopt);
        add(changed(constant, stored, path.zeros));
      }
    }
  }

  // Gives weight 0 to what the connector's transfers may write.
  void leave_out(const Connector& connector) {
    for (const PortRef& ref : connector.ports) leave_out(ref);
  }
  void leave_out(const PortRef& ref) {
    if (ref.kind == PortRef::Kind::Choice) {
      for (const PortRef& port : system_.choices[ref.choice].ports) leave_out(port);
    } else if (ref.kind == PortRef::Kind::Atom) {
      for (u32 variable : net_.access[net_.class_at(ref.atom.value).type.value].written[ref.port])
        add({{unknown_of(ref.atom.value, variable), 1}});
    }
  }

  // Step 2, transfers: returns by how much the transfer of a rendezvous changes the sum, one row per path through its
  // code.
  std::vector<Row> transfers(u32 node) {
    if (net_.graph.nodes[node].connector == kNoRow) return {};
    const Connector& connector = system_.connectors[ConnectorId(std::size_t{net_.graph.nodes[node].connector})];
    const ConnectorType& type = system_.connector_types[connector.type];
    if (!has_plain_transfer(system_, connector) || type.clauses.empty() ||
        !stores_into_ports(system_.code, type.clauses[0].down))
      return {};
    std::vector<AffinePath> paths(1);
    std::vector<u32> unknowns;
    paths[0].self.resize(type.variables.size());
    for (std::size_t p = 0; p < type.params.size(); ++p) {
      const PortRef& ref = connector.ports[p];
      const std::vector<u32>& variables = type_of(ref.atom.value).ports[ref.port].variables;
      unknowns.resize(type.params[p].first_bind + variables.size(), kNoRow);
      paths[0].bind.resize(unknowns.size());
      for (std::size_t v = 0; v < variables.size(); ++v) {
        unknowns[type.params[p].first_bind + v] = unknown_of(ref.atom.value, variables[v]);
        paths[0].bind[type.params[p].first_bind + v] = start_[ref.atom.value][variables[v]];
      }
    }
    for (const PortRef& ref : connector.ports) assume_port(ref.atom.value, ref.port, paths[0]);
    for (const DataRef& ref : connector.data) paths[0].bind.push_back(start_[ref.atom.value][ref.variable]);
    // Transfers of connectors around it come between its guard and its own.
    if (!type.exports) code_.assume(type.clauses[0].guard, paths[0]);
    std::set<u32> written;
    for_each_assigned(system_.code, type.clauses[0].down, Op::LoadBind, [&](u32 bind) {
      if (bind < unknowns.size()) written.insert(bind);
    });
    const bool is_followed = code_.execute(type.clauses[0].down, paths);
    if (!is_followed) paths.resize(1);
    std::vector<Row> alternatives;
    for (const AffinePath& path : paths) {
      Stored stored;
      for (u32 bind : written) stored.emplace_back(unknowns[bind], is_followed ? path.bind[bind] : std::nullopt);
      alternatives.push_back(changed({}, stored, path.zeros));
    }
    return alternatives;
  }

  // Step 4: re-checks a solution: all equations hold. Equations whose unknowns are all 0 do.
  [[nodiscard]] bool solves(const std::vector<Term>& solution) const {
    std::map<u32, std::int64_t> values;
    std::vector<u32> rows;
    for (const Term& term : solution) {
      if (std::abs(term.factor) > SparseSystem::kMaxNumber) return false;
      values[term.unknown] = term.factor;
      rows.insert(rows.end(), rows_with_[term.unknown].begin(), rows_with_[term.unknown].end());
    }
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    return std::all_of(rows.begin(), rows.end(), [&](u32 row) { return sum_of(equations_[row], values) == 0; });
  }
  [[nodiscard]] static std::int64_t sum_of(const Row& row, const std::map<u32, std::int64_t>& values) {
    std::int64_t sum = 0;
    for (const Term& term : row) {
      const auto found = values.find(term.unknown);
      if (found != values.end()) sum += term.factor * found->second;
    }
    return sum;
  }

  // Returns the weights of a candidate equation and by how much each port changes its sum. Nothing: it speaks of what
  // the system does not have.
  [[nodiscard]] std::optional<std::vector<Term>> values_in(const AffineEquation& candidate) const {
    std::map<u32, std::int64_t> values;
    for (const AffineEquation::Term& term : candidate.terms) {
      if (term.atom >= system_.atoms.size() || term.weight == 0 ||
          std::abs(std::int64_t{term.weight}) > kMaxCandidateWeight)
        return std::nullopt;
      const AtomType& type = type_of(term.atom);
      if (term.row >= (term.is_place ? type.places.size() : type.variables.size())) return std::nullopt;
      const u32 unknown = term.is_place ? place_base_[term.atom] + term.row : unknown_of(term.atom, term.row);
      // An automaton's first place has no unknown; what is no counter has none either.
      if (term.is_place ? transition_system_.is_automaton[term.atom] != 0 && term.row == 0
                        : is_counter_[unknown - first_variable_] == 0)
        return std::nullopt;
      if (!values.emplace(unknown, term.weight).second) return std::nullopt;
    }
    std::map<u32, std::int64_t> changes;
    for (const auto& [unknown, weight] : values) {
      for (u32 row : rows_with_[unknown]) {
        const u32 port = port_given_by(equations_[row]);
        if (port != kNoRow) changes.try_emplace(port, sum_of(equations_[row], values));
      }
    }
    std::vector<Term> result;
    for (const auto& [unknown, value] : values) result.push_back({unknown, value});
    for (const auto& [port, change] : changes) result.push_back({port, change});
    return result;
  }
  // Returns the port of a transition's row (what the transition does, less what its port changes the sum by).
  [[nodiscard]] u32 port_given_by(const Row& row) const {
    u32 port = kNoRow;
    for (const Term& term : row) {
      if (term.unknown >= first_place_) continue;
      if (port != kNoRow || term.factor != -1) return kNoRow;
      port = term.unknown;
    }
    return port;
  }

  [[nodiscard]] AffineEquation equation_of(std::vector<Term> values) const {
    AffineEquation equation;
    // The one that was free weighs more than nothing.
    std::sort(values.begin(), values.end(), [](const Term& a, const Term& b) { return a.unknown < b.unknown; });
    for (const Term& value : values) {
      if (value.unknown < first_place_ || value.factor == 0) continue;
      if (std::abs(value.factor) > SparseSystem::kMaxNumber) return {};
      AffineEquation::Term term;
      term.is_place = value.unknown < first_variable_;
      term.weight = static_cast<std::int32_t>(value.factor);
      if (term.is_place) {
        term.atom = static_cast<u32>(std::upper_bound(place_base_.begin(), place_base_.end(), value.unknown) -
                                     place_base_.begin()) -
                    1;
        term.row = value.unknown - place_base_[term.atom];
      } else {
        const u32 variable = value.unknown - first_variable_;
        while (term.atom + 1 < system_.atoms.size() && image_.atoms[term.atom + 1].first_cell <= variable) ++term.atom;
        term.row = variable - image_.atoms[term.atom].first_cell;
      }
      equation.terms.push_back(term);
    }
    return equation;
  }

  const Net& net_;
  const System& system_;
  const TransitionSystem& transition_system_;
  const rt::Image& image_;
  AffineCode code_;
  u32 first_place_ = 0, first_variable_ = 0;
  std::vector<u32> place_base_;           // by atom: the unknown of its first place
  std::vector<std::uint8_t> is_counter_;  // by variable among all: an int that changes and is followed
  std::vector<AffineValues> start_;       // by atom, by variable
  std::vector<Row> equations_;
  std::vector<std::vector<u32>> rows_with_;  // by unknown: equations that it stands in
  PlaceValues places_;
  bool is_too_large_ = false;
};

}  // namespace

AffineInvariants equations_that_hold(const Net& net, const TransitionSystem& transition_system, const rt::Image& image,
                                     const std::vector<AffineEquation>& candidates,
                                     const CancellationToken& cancellation) {
  if (candidates.empty()) return {};
  return AffineAnalysis(net, transition_system, image).those_that_hold(candidates, cancellation);
}

AffineInvariants find_affine_invariants(const Net& net, TransitionSystem& transition_system, const rt::Image& image,
                                        const std::vector<std::vector<Signal>>& assumed,
                                        const CancellationToken& cancellation) {
  return with_bounds(net, transition_system, image, assumed, cancellation,
                     AffineAnalysis(net, transition_system, image).run(cancellation));
}

namespace {
std::string term_text(const AffineEquation::Term& term, const System& system) {
  const Atom& atom = system.atoms[AtomId(std::size_t{term.atom})];
  const AtomType& type = system.atom_types[atom.type];
  return atom.path + (term.is_place ? '@' + type.places[term.row] : '.' + type.variables[term.row].name);
}
}  // namespace

std::string equation_row(const AffineEquation& equation, const System& system) {
  std::string out = "equation " + std::to_string(equation.total);
  for (const AffineEquation::Term& term : equation.terms)
    out += ' ' + term_text(term, system) + '*' + std::to_string(term.weight);
  return out;
}

std::string equation_text(const AffineEquation& equation, const System& system) {
  constexpr std::size_t kShown = 12;
  std::string out = "always " + std::to_string(equation.total) + " =";
  for (std::size_t k = 0; k < equation.terms.size() && k < kShown; ++k) {
    const std::int32_t weight = equation.terms[k].weight;
    const std::string name = term_text(equation.terms[k], system);
    out += weight < 0 ? " - " : k == 0 ? " " : " + ";
    if (weight != 1 && weight != -1) out += std::to_string(std::abs(weight)) + ' ';
    out += name.starts_with("ROOT.") ? name.substr(5) : name;
  }
  if (equation.terms.size() > kShown) out += " … (" + std::to_string(equation.terms.size()) + " in all)";
  return out;
}

}  // namespace bip::verify
