// Atoms alone, in an environment that may do anything: what they begin in and what each port leads to are modes of their class. One
// that fits is enough, one that most components can be in is preferred; where values are not known, Z3 tells which modes can be met
// and that there is no other way.
#include <algorithm>
#include <numeric>

#include "tools/certcheck/check.hpp"
#include "tools/certcheck/terms.hpp"

namespace certcheck {

namespace {

class Modes {
 public:
  Modes(const Model& model, const Certificate& certificate) : m_(model), c_(certificate), terms_(model, z_), solver_(z_) {
    for (const Class& row : c_.classes) uses_.emplace(&row, Rows(row.modes.size(), 0));
    for (std::size_t atom = 0; atom < m_.atoms.size(); ++atom) {
      for (std::size_t mode : c_.reachable[atom]) ++uses_.at(&c_.classes[c_.class_of[atom]])[mode];
    }
  }

  Moves moves() {
    Moves all;
    for (const Class& row : c_.classes) {
      const AtomType& type = m_.atom_types[row.type];
      all.emplace_back(type.ports.size());
      for (std::size_t from = 0; from < row.modes.size(); ++from) {
        Local local;
        for (std::size_t p = 0; p < type.places.size(); ++p) local.marks.push_back(terms_.truth(row.modes[from].places.contains(p)));
        for (std::size_t k = 0; k < type.slots.size(); ++k) {
          const std::optional<int> value = row.modes[from].values[k];
          local.slots.push_back(value ? terms_.constant(type.types[k], *value) : terms_.fresh(type.types[k]));
        }
        z3::expr fault = terms_.truth(false);
        const Offer offer = terms_.offer(type, local, fault);
        for (std::size_t t = 0; t < type.transitions.size(); ++t) {
          const Transition& transition = type.transitions[t];
          if (transition.port == kNone) continue;
          const z3::expr on = both(offer.ports[transition.port], offer.transitions[t]);
          if (is(on, false)) continue;
          Local next = local;
          for (std::size_t slot : type.written[transition.port]) next.slots[slot] = terms_.fresh(type.types[slot]);
          Trouble trouble(z_);
          terms_.take(type, transition, next, on, trouble);
          for (std::size_t to : met(row, next, on, trouble, "a mode of `" + type.name + "` leads")) all.back()[transition.port].emplace_back(from, to);
        }
      }
    }
    return all;
  }

  std::vector<std::set<std::size_t>> first() {
    std::vector<std::set<std::size_t>> all;
    std::map<std::pair<std::size_t, std::string>, std::set<std::size_t>> known;
    for (std::size_t atom = 0; atom < m_.atoms.size(); ++atom) {
      std::string args;
      for (const Tree* arg : m_.atoms[atom].args) args += arg->text + '\n';
      const auto [found, is_new] = known.try_emplace({c_.class_of[atom], args});
      if (is_new) {
        Trouble trouble(z_);
        const Local start = terms_.initial(m_.atoms[atom], trouble);
        found->second = met(c_.classes[c_.class_of[atom]], start, terms_.truth(true), trouble, "the beginning of `" + m_.atoms[atom].path + "` leads");
      }
      all.push_back(found->second);
      for (std::size_t mode : all.back()) {
        if (!c_.reachable[atom].contains(mode)) throw Rejected("`" + m_.atoms[atom].path + "` starts in a mode that is not among the reachable ones");
      }
    }
    return all;
  }

 private:
  [[nodiscard]] bool may_be(const z3::expr& e) {
    if (is(e, true) || is(e, false)) return is(e, true);
    solver_.push();
    solver_.add(e);
    const z3::check_result answer = solver_.check();
    solver_.pop();
    if (answer == z3::unknown) throw NotCheckable("the solver gives up");
    return answer == z3::sat;
  }

  // A run that ends with an error leads nowhere.
  std::set<std::size_t> met(const Class& row, const Local& local, const z3::expr& when, const Trouble& trouble, const std::string& what) {
    const AtomType& type = m_.atom_types[row.type];
    z3::expr other = both(when, no(trouble.fault));
    if (may_be(both(other, trouble.lost))) throw NotCheckable(what + " through too many internal transitions");
    const Rows& uses = uses_.at(&row);
    const std::optional<Mode> clear = clear_mode(row, local);
    if (const auto found = clear ? row.numbers.find(*clear) : row.numbers.end(); found != row.numbers.end() && uses[found->second] == *std::max_element(uses.begin(), uses.end())) return {found->second};
    std::set<std::size_t> result;
    Rows order(row.modes.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return uses[a] > uses[b]; });
    for (std::size_t mode : order) {
      z3::expr here = other;
      for (std::size_t p = 0; p < type.places.size(); ++p) here = both(here, row.modes[mode].places.contains(p) ? local.marks[p] : no(local.marks[p]));
      if (!is(here, false)) here = both(here, terms_.has_values(type, local, row.modes[mode].values));
      if (!may_be(here)) continue;
      result.insert(mode);
      other = both(other, no(here));
    }
    if (may_be(other)) throw Rejected(what + " to one that is not listed");
    return result;
  }
  // Where it is clear what is marked; values that are no constants are left open.
  [[nodiscard]] static std::optional<Mode> clear_mode(const Class& row, const Local& local) {
    Mode mode;
    mode.values.resize(local.slots.size());
    for (std::size_t p = 0; p < local.marks.size(); ++p) {
      if (is(local.marks[p], true)) mode.places.insert(p);
      else if (!is(local.marks[p], false)) return std::nullopt;
    }
    for (std::size_t k = 0; k < local.slots.size(); ++k) {
      const z3::expr& v = local.slots[k];
      if (!row.followed[k]) continue;
      if (is(v, true) || is(v, false)) mode.values[k] = is(v, true) ? 1 : 0;
      else if (v.is_numeral()) mode.values[k] = static_cast<int>(static_cast<unsigned>(v.get_numeral_uint64()));
    }
    return mode;
  }

  const Model& m_;
  const Certificate& c_;
  z3::context z_;
  Terms terms_;
  z3::solver solver_;
  std::map<const Class*, Rows> uses_;  // by mode: how many components can be in it
};

}  // namespace

Moves check_modes(const Model& model, const Certificate& certificate) { return Modes(model, certificate).moves(); }
std::vector<std::set<std::size_t>> check_first_modes(const Model& model, const Certificate& certificate) { return Modes(model, certificate).first(); }

}  // namespace certcheck
