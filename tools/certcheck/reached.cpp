// The states of a diagram, by all ways through it. Cost: the states times what is in one.
#include "tools/certcheck/check.hpp"
#include "tools/certcheck/terms.hpp"

namespace certcheck {

namespace {

constexpr int kMaxDepth = 10000;
constexpr std::size_t kMaxStates = 5000000;

class Reached {
 public:
  Reached(const Model& model, const Certificate& certificate) : m_(model), c_(certificate) {
    z3::context z;
    const Terms terms(m_, z);
    for (const Atom& atom : m_.atoms) {
      const AtomType& type = m_.atom_types[atom.type];
      const Local local = terms.local(atom, [&](std::size_t) { return terms.truth(false); }, [&](std::size_t k) { return terms.first(type.types[k]); });
      first_.push_back(open_.size());
      open_.resize(open_.size() + type.places.size());
      // Parameters are what the system says.
      for (std::size_t k = 0; k < type.slots.size(); ++k) open_.push_back(type.is_param[k] ? std::optional(Terms::value(local.slots[k]).value_or(0)) : std::nullopt);
    }
  }

  std::set<Values> run() {
    list(c_.reached, open_, 0);
    return std::move(states_);
  }

 private:
  using Known = std::vector<std::optional<int>>;

  // Each way must say everything of a state.
  void list(std::size_t node, const Known& before, int depth) {
    if (depth > kMaxDepth) throw NotCheckable("the diagram is too deep");
    for (const Case& one : c_.nodes[node]) {
      Known known = before;
      bool is_way = true;  // no place or slot has two values on it
      const auto say = [&](std::size_t at, int value) {
        is_way = is_way && known[at].value_or(value) == value;
        known[at] = value;
      };
      for (const Literal& l : one.literals) {
        const AtomType& type = m_.type_of(l.atom);
        const std::size_t first = first_[l.atom], places = type.places.size();
        if (l.about == Literal::Bit || (l.about == Literal::Value && l.is_negated)) throw Rejected("a case is of places and values");
        if (l.about == Literal::Value) {
          say(first + places + l.row, l.low);
          continue;
        }
        say(first + l.row, l.is_negated ? 0 : 1);
        for (std::size_t p = 0; p < places && type.is_automaton && !l.is_negated; ++p) say(first + p, p == l.row ? 1 : 0);
      }
      if (!is_way) continue;
      if (one.next != kNone) {
        list(one.next, known, depth + 1);
        continue;
      }
      Values state;
      for (std::size_t a = 0, at = 0; at < known.size(); ++at) {
        while (a + 1 < first_.size() && first_[a + 1] <= at) ++a;
        if (!known[at]) throw Rejected("a case leaves something of `" + std::string(m_.atoms[a].path) + "` open");
        state.push_back(*known[at]);
      }
      states_.insert(std::move(state));
      if (states_.size() > kMaxStates) throw NotCheckable("the states are too many");
    }
  }

  const Model& m_;
  const Certificate& c_;
  Rows first_;  // by atom: its first value
  Known open_;
  std::set<Values> states_;
};

}  // namespace

std::set<Values> reached_states(const Model& model, const Certificate& certificate) { return Reached(model, certificate).run(); }

}  // namespace certcheck
