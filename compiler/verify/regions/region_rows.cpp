// See region_rows.hpp.
//
// In a state without a step each implication of the proof, times its multiplier, says that weights add up to 0 at most:
// those of its states, less those of the states that it implies. The checker adds up all rows, and looks for the least
// weight of each component. It knows nothing of impossible states, so these must not have less than the least of the
// possible ones: a reason why a state is impossible is a row, too, by which its weight rises as far as that takes.
// Where the reason are impossible states of another component, their weights fall, so what was found out last comes
// first.
#include "compiler/verify/regions/region_rows.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "compiler/verify/evidence/case_rows.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// The checker adds up all weights of a row in 31 bits.
constexpr std::int64_t kMostRowWeight = (std::int64_t{1} << 30) - 1;

class CaseWriter {
 public:
  CaseWriter(const RegionNet& net, const RegionSpaces& spaces)
      : net_(net), spaces_(spaces), columns_(spaces.spaces.size()) {}

  [[nodiscard]] const std::vector<CaseColumn>& columns_of(u32 atom) {
    std::vector<CaseColumn>& columns = columns_[atom];
    if (!columns.empty()) return columns;
    const AtomType& type = net_.type_of(atom);
    columns = place_columns(type);
    for (u32 k = 0; k < type.variables.size(); ++k) {
      if (spaces_.spaces[atom].follows(k) && is_nameable(type.variables[k]))
        columns.push_back({CaseColumn::About::Value, k, type.variables[k].type == Type::Int});
    }
    return columns;
  }
  [[nodiscard]] ValueBox box_of(u32 atom, u32 state) {
    const LocalSpace& space = spaces_.spaces[atom];
    ValueBox box;
    for (const CaseColumn& column : columns_of(atom)) {
      switch (column.about) {
        case CaseColumn::About::Automaton: box.push_back(exactly(space.marking(state).front())); break;
        case CaseColumn::About::Place: box.push_back(exactly(space.is_marked(state, column.row) ? 1 : 0)); break;
        case CaseColumn::About::Value: {
          const Range& range = space.range(state, column.row);
          box.push_back({static_cast<std::int32_t>(range.low), static_cast<std::int32_t>(range.high)});
          break;
        }
      }
    }
    return box;
  }
  [[nodiscard]] std::string text_of(u32 atom, const ValueBox& box) {
    return case_text(net_.system->atoms[AtomId(std::size_t{atom})], net_.type_of(atom), columns_of(atom), box);
  }

 private:
  static ValueRange exactly(u32 value) { return {static_cast<std::int32_t>(value), static_cast<std::int32_t>(value)}; }

  const RegionNet& net_;
  const RegionSpaces& spaces_;
  std::vector<std::vector<CaseColumn>> columns_;  // by atom
};

class DeadlockRowWriter {
 public:
  DeadlockRowWriter(const RegionNet& net, const RegionSpaces& spaces, const ExclusionProgram& program)
      : net_(net), spaces_(spaces), program_(program), cases_(net, spaces), weight_(program.size(), 0) {}

  std::optional<std::string> run(const ExclusionProgram::Proof& proof) {
    for (const Implication& each : proof.used) {
      std::vector<u32> implied = each.implied;
      // It has been shortened by these.
      const std::vector<u32> impossible = program_.impossible_states(each.other);
      implied.insert(implied.end(), impossible.begin(), impossible.end());
      add_row(each.source, each.states, implied, each.multiplier);
    }
    const std::vector<std::int64_t> least = least_weights();
    for (auto row = program_.forbidden().rbegin(); row != program_.forbidden().rend(); ++row) {
      std::int64_t missing = 0;
      for (const u32 state : row->states)
        missing = std::max(missing, least[program_.component_of(state)] - weight_[state]);
      if (missing > 0) add_row(row->source, row->states, row->others, missing);
    }
    if (is_incomplete_) return std::nullopt;
    std::string out = local_state_rows(net_, spaces_, {atoms_.begin(), atoms_.end()});
    for (const auto& [first, rows] : rows_) out += rows;
    return out;
  }

 private:
  // By component, of its possible states. One without any has 1: it is the proof.
  [[nodiscard]] std::vector<std::int64_t> least_weights() const {
    std::vector<std::int64_t> least(spaces_.spaces.size(), std::numeric_limits<std::int64_t>::max());
    for (u32 state = 0; state < program_.size(); ++state) {
      std::int64_t& of_component = least[program_.component_of(state)];
      if (program_.is_possible(state)) of_component = std::min(of_component, weight_[state]);
    }
    for (std::int64_t& each : least) each = each == std::numeric_limits<std::int64_t>::max() ? 1 : each;
    return least;
  }
  void add_row(u32 source, const std::vector<u32>& states, const std::vector<u32>& implied, std::int64_t multiplier) {
    BIP_ASSERT(!states.empty() && multiplier > 0, "a row of {} states, times {}", states.size(), multiplier);
    const auto cases = static_cast<std::int64_t>(states.size() + implied.size());
    is_incomplete_ = is_incomplete_ || source == ExclusionProgram::kNone || multiplier > kMostRowWeight / cases;
    if (is_incomplete_) return;
    std::string& out = rows_[program_.component_of(states.front())];
    out += "unless " + name_of(source);
    add_cases(states, multiplier, out);
    add_cases(implied, -multiplier, out);
    out += '\n';
  }
  void add_cases(const std::vector<u32>& states, std::int64_t weight, std::string& out) {
    for (const u32 state : states) {
      const u32 atom = program_.component_of(state);
      atoms_.insert(atom);
      weight_[state] += weight;
      out +=
          ' ' + cases_.text_of(atom, cases_.box_of(atom, state - spaces_.first[atom])) + '*' + std::to_string(weight);
    }
  }
  [[nodiscard]] std::string name_of(u32 source) {
    const System& system = *net_.system;
    if (source < system.connectors.size()) {
      for (const PortRef& ref : net_.connector(source).ports) atoms_.insert(ref.atom.value);
      return net_.connector(source).path;
    }
    const auto after = std::upper_bound(net_.first_own_step.begin(), net_.first_own_step.end(), source);
    const u32 atom = static_cast<u32>(after - net_.first_own_step.begin()) - 1;
    atoms_.insert(atom);
    return system.atoms[AtomId(std::size_t{atom})].path + '.' +
           net_.type_of(atom).ports[source - net_.first_own_step[atom]].name;
  }

  const RegionNet& net_;
  const RegionSpaces& spaces_;
  const ExclusionProgram& program_;
  CaseWriter cases_;
  std::vector<std::int64_t> weight_;  // by state
  std::map<u32, std::string> rows_;   // by the component of the first case
  std::set<u32> atoms_;               // that the checker needs to know something of
  bool is_incomplete_ = false;
};

}  // namespace

std::string local_state_rows(const RegionNet& net, const RegionSpaces& spaces, const std::vector<u32>& atoms) {
  CaseWriter cases(net, spaces);
  std::string out;
  // What connectors write depends on the others.
  std::vector<u32> all(spaces.spaces.size());
  for (u32 atom = 0; atom < all.size(); ++atom) all[atom] = atom;
  for (const u32 atom : net.writing == Writing::Anything ? atoms : all) {
    const LocalSpace& space = spaces.spaces[atom];
    const AtomType& type = net.type_of(atom);
    const std::string& path = net.system->atoms[AtomId(std::size_t{atom})].path;
    std::vector<ValueBox> boxes;
    for (u32 state = 0; state < space.size(); ++state) boxes.push_back(cases.box_of(atom, state));
    out += "lemma";
    for (const ValueBox& box : joined_boxes(std::move(boxes), cases.columns_of(atom)))
      out += ' ' + cases.text_of(atom, box);
    out += '\n';
    for (u32 k = 0; k < type.variables.size(); ++k) {
      const Range& range = net.range(atom, k);
      const Type of = type.variables[k].type;
      const bool is_narrow = of == Type::Int ? range != kAnyInt : of == Type::Bool && range != kAnyBool;
      if (!is_narrow || range.is_empty() || !is_nameable(type.variables[k])) continue;
      out += "lemma " + path + '.' + type.variables[k].name + '=' + std::to_string(range.low);
      if (range.low != range.high) out += ".." + std::to_string(range.high);
      out += '\n';
    }
  }
  return out;
}

std::optional<std::string> deadlock_rows(const RegionNet& net, const RegionSpaces& spaces,
                                         const ExclusionProgram& program, const ExclusionProgram::Proof& proof) {
  return DeadlockRowWriter(net, spaces, program).run(proof);
}

}  // namespace bip::verify
