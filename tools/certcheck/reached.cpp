// A set of states that was reached by a search, as a diagram. Its states are taken one by one, with all terms constants: no solver
// is asked. Cost: the states times what is in one.
#include <algorithm>

#include "tools/certcheck/check.hpp"
#include "tools/certcheck/system.hpp"

namespace certcheck {

namespace {

using Row = std::vector<int>;  // by atom: its places, then its slots

class Reached {
 public:
  Reached(const Model& model, const Certificate& certificate) : m_(model), c_(certificate), terms_(model, z_) {
    for (const Atom& atom : m_.atoms) {
      first_.push_back(width_);
      width_ += m_.atom_types[atom.type].places.size() + m_.atom_types[atom.type].slots.size();
    }
    list(c_.reached, Row(width_, 0), std::vector<bool>(width_, false), 0);
  }

  std::string run() {
    Trouble begin(z_);
    State state;
    for (const Atom& atom : m_.atoms) state.push_back(terms_.initial(atom, begin));
    if (!is(begin.lost, false)) throw NotCheckable("internal transitions at the beginning go on for too long");
    Row row(width_);
    for (std::size_t a = 0; a < state.size(); ++a) write(a, state[a], row);
    if (!truth_of(begin.fault) && !states_.contains(row)) throw Rejected("the first state is not among those that are listed");
    if (truth_of(begin.fault) && c_.claim == "error-free") throw Rejected("the run ends before its first state");
    const std::vector<Tree> claim = c_.claim == "deadlock-free" || c_.claim == "error-free" ? std::vector<Tree>() : read_trees(c_.claim);
    if (!claim.empty() && (claim.size() != 2 || claim[0].text != "never")) throw Rejected("the claim `" + c_.claim + "`");
    for (const Row& one : states_) check_state(one, claim);
    return std::to_string(m_.atoms.size()) + " components, " + std::to_string(states_.size()) + " states";
  }

 private:
  // All ways through the diagram: each must say everything of a state.
  void list(std::size_t node, const Row& before, const std::vector<bool>& known_before, int depth) {
    if (depth > 10000) throw NotCheckable("the diagram is too deep");
    for (const Case& one : c_.nodes[node]) {
      Row row = before;
      std::vector<bool> known = known_before;
      bool is_way = true;  // no place or slot has two values on it
      const auto say = [&](std::size_t at, int value) {
        is_way = is_way && (!known[at] || row[at] == value);
        row[at] = value;
        known[at] = true;
      };
      for (const Literal& l : one.literals) {
        const AtomType& type = m_.type_of(l.atom);
        const std::size_t first = first_[l.atom], places = type.places.size();
        const bool is_only = l.about == Literal::Place && type.is_automaton && !l.is_negated;
        if (l.about == Literal::Bit || (l.about == Literal::Value && l.is_negated)) throw Rejected("a case is of places and values");
        for (std::size_t p = 0; p < places && is_only; ++p) say(first + p, p == l.row ? 1 : 0);
        if (!is_only) say(first + l.row + (l.about == Literal::Place ? 0 : places), l.about == Literal::Place ? !l.is_negated : l.low);
      }
      if (!is_way) continue;
      if (one.next != kNone) {
        list(one.next, row, known, depth + 1);
        continue;
      }
      for (std::size_t a = 0; a < m_.atoms.size(); ++a) {
        const AtomType& type = m_.type_of(a);
        for (std::size_t k = 0; k < type.places.size() + type.slots.size(); ++k) {
          const bool is_param = k >= type.places.size() && type.is_param[k - type.places.size()];
          if (!known[first_[a] + k] && !is_param) throw Rejected("a case leaves something of `" + m_.atoms[a].path + "` open");
          if (is_param) row[first_[a] + k] = 0;
        }
      }
      states_.insert(std::move(row));
      if (states_.size() > 5000000) throw NotCheckable("the states are too many");
    }
  }

  [[nodiscard]] static bool truth_of(const z3::expr& e) {
    const z3::expr simple = e.simplify();
    if (!is(simple, true) && !is(simple, false)) throw NotCheckable("what a state does depends on values that are not followed");
    return is(simple, true);
  }

  Local read(std::size_t a, const Row& row) const {
    const AtomType& type = m_.type_of(a);
    Local local;
    std::size_t arg = 0;
    z3::expr fault = terms_.truth(false);
    for (std::size_t p = 0; p < type.places.size(); ++p) local.marks.push_back(terms_.truth(row[first_[a] + p] != 0));
    for (std::size_t k = 0; k < type.slots.size(); ++k) {
      local.slots.push_back(type.is_param[k] ? terms_.evaluate(*m_.atoms[a].args.at(arg++), {}, terms_.truth(false), fault)
                                             : terms_.constant(type.types[k], row[first_[a] + type.places.size() + k]));
    }
    return local;
  }
  void write(std::size_t a, const Local& local, Row& row) const {
    const AtomType& type = m_.type_of(a);
    for (std::size_t p = 0; p < type.places.size(); ++p) row[first_[a] + p] = truth_of(local.marks[p]) ? 1 : 0;
    for (std::size_t k = 0; k < type.slots.size(); ++k) {
      const z3::expr& v = local.slots[k];
      if (!v.is_bool() && !v.is_numeral()) throw NotCheckable("a value is not followed");
      row[first_[a] + type.places.size() + k] = type.is_param[k] ? 0 : v.is_bool() ? static_cast<int>(truth_of(v)) : static_cast<int>(static_cast<unsigned>(v.get_numeral_uint64()));
    }
  }

  void check_state(const Row& row, const std::vector<Tree>& claim) {
    State state;
    for (std::size_t a = 0; a < m_.atoms.size(); ++a) state.push_back(read(a, row));
    System system(m_, terms_, state);
    const bool asks_errors = c_.claim == "error-free";
    bool has_step = false;
    system.each_step([&](const Step& step) {
      if (truth_of(system.state_fault()) || !truth_of(step.possible)) return;
      has_step = true;
      if (truth_of(step.trouble.lost)) throw NotCheckable("internal transitions go on for too long to be followed");
      if (truth_of(step.trouble.fault)) {
        if (asks_errors) throw Rejected("a step ends with an error");
        return;
      }
      Row after = row;
      for (const auto& [atom, local] : step.next) write(atom, local, after);
      if (!states_.contains(after)) throw Rejected("a step leads to a state that is not listed");
    });
    const bool has_ended = truth_of(system.state_fault());
    if (asks_errors && (has_ended || truth_of(system.guard_fault()))) throw Rejected("a state that is listed ends with an error");
    if (c_.claim == "deadlock-free" && !has_ended && !has_step) throw Rejected("a state that is listed has no step");
    if (!claim.empty() && !has_ended && truth_of(system.claim(claim[1]))) throw Rejected("a state that is listed is what should never be");
  }

  const Model& m_;
  const Certificate& c_;
  z3::context z_;
  Terms terms_;
  Rows first_;  // by atom: its first value in a row
  std::size_t width_ = 0;
  std::set<Row> states_;
};

}  // namespace

std::string check_reached(const Model& model, const Certificate& certificate) { return Reached(model, certificate).run(); }

}  // namespace certcheck
