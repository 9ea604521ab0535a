// Atoms alone, in an environment that may do anything: what they begin in and what each port leads to are modes of their class. One
// that fits is enough, one that the components can be in is preferred; where values are not known, Z3 tells which modes can be met
// and that there is no other way.
#include <algorithm>

#include "tools/certcheck/check.hpp"
#include "tools/certcheck/terms.hpp"

namespace certcheck {

namespace {

class Modes {
 public:
  Modes(const Model& model, const Certificate& certificate) : m_(model), c_(certificate), terms_(model, z_) {}

  ModeMoves run() {
    ModeMoves all;
    std::map<std::pair<std::size_t, std::set<std::size_t>>, std::size_t> groups;
    std::map<std::pair<std::size_t, std::string>, std::set<std::size_t>> starts;
    for (std::size_t atom = 0; atom < m_.atoms.size(); ++atom) {
      const Class& row = c_.classes[c_.class_of[atom]];
      const std::set<std::size_t>& reachable = c_.reachable[atom];
      const auto [group, is_new] = groups.try_emplace({c_.class_of[atom], reachable}, groups.size());
      if (is_new) all.by_port.push_back(moves(row, reachable));
      all.group_of.push_back(group->second);
      std::string args;
      for (const Tree& arg : m_.atoms[atom].args->items) args.append(arg.text) += '\n';
      const auto [start, is_other] = starts.try_emplace({group->second, args});
      if (is_other) {
        Trouble trouble(z_);
        const Local local = terms_.initial(m_.atoms[atom], trouble);
        start->second = met(row, reachable, local, terms_.truth(true), trouble, "the beginning of `" + std::string(m_.atoms[atom].path) + "` leads");
      }
      all.first.push_back(start->second);
      if (!std::includes(reachable.begin(), reachable.end(), start->second.begin(), start->second.end())) {
        throw Rejected("`" + std::string(m_.atoms[atom].path) + "` starts in a mode that is not among the reachable ones");
      }
    }
    return all;
  }

 private:
  std::vector<Moves> moves(const Class& row, const std::set<std::size_t>& reachable) {
    const AtomType& type = m_.atom_types[row.type];
    std::vector<Moves> by_port(type.ports.size());
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
        for (std::size_t to : met(row, reachable, next, on, trouble, "a mode of `" + std::string(type.name) + "` leads")) by_port[transition.port].emplace_back(from, to);
      }
    }
    return by_port;
  }

  // A run that ends with an error leads nowhere.
  std::set<std::size_t> met(const Class& row, const std::set<std::size_t>& reachable, const Local& local, const z3::expr& when, const Trouble& trouble, const std::string& what) {
    const AtomType& type = m_.atom_types[row.type];
    z3::expr other = both(when, no(trouble.fault));
    if (terms_.may_be(both(other, trouble.lost))) throw NotCheckable(what + " through too many internal transitions");
    const std::optional<Mode> clear = clear_mode(row, local);
    const auto found = clear ? row.numbers.find(*clear) : row.numbers.end();
    if (found != row.numbers.end() && reachable.contains(found->second)) return {found->second};
    std::set<std::size_t> result;
    for (const bool is_liked : {true, false}) {
      for (std::size_t mode = 0; mode < row.modes.size(); ++mode) {
        if (reachable.contains(mode) != is_liked) continue;
        z3::expr here = other;
        for (std::size_t p = 0; p < type.places.size(); ++p) here = both(here, row.modes[mode].places.contains(p) ? local.marks[p] : no(local.marks[p]));
        if (!is(here, false)) here = both(here, terms_.has_values(type, local, row.modes[mode].values));
        if (!terms_.may_be(here)) continue;
        result.insert(mode);
        other = both(other, no(here));
      }
    }
    if (terms_.may_be(other)) throw Rejected(what + " to one that is not listed");
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
      if (row.followed[k]) mode.values[k] = Terms::value(local.slots[k]);
    }
    return mode;
  }

  const Model& m_;
  const Certificate& c_;
  z3::context z_;
  Terms terms_;
};

}  // namespace

ModeMoves check_modes(const Model& model, const Certificate& certificate) { return Modes(model, certificate).run(); }

}  // namespace certcheck
