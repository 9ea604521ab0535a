// Atoms over Z3 terms: what they offer, where they begin, what a transition and the internal ones after it lead to.
#include <algorithm>

#include "tools/certcheck/terms.hpp"

namespace certcheck {

namespace {
// Internal transitions in a row: in general, and where it is clear which.
constexpr int kMaxInternals = 24, kMaxClear = 100000;
}  // namespace

Variables Terms::own(const AtomType& type, Local& local) const {
  Variables v;
  v.self = [this, &type, &local](std::size_t k) { return is_exact(type.types.at(k)) ? local.slots.at(k) : fresh(type.types[k]); };
  v.set_self = [&local](std::size_t k, const z3::expr& value) { local.slots.at(k) = value; };
  return v;
}

Local Terms::any(const Atom& atom) const {
  const AtomType& type = m_.atom_types[atom.type];
  Local local;
  std::size_t arg = 0;
  z3::expr fault = truth(false);
  for (std::size_t p = 0; p < type.places.size(); ++p) local.marks.push_back(fresh("bool"));
  for (std::size_t k = 0; k < type.slots.size(); ++k) local.slots.push_back(type.is_param[k] ? evaluate(*atom.args.at(arg++), {}, truth(false), fault) : fresh(type.types[k]));
  return local;
}

Local Terms::initial(const Atom& atom, Trouble& trouble) const {
  const AtomType& type = m_.atom_types[atom.type];
  Local local = any(atom);
  for (std::size_t p = 0; p < type.places.size(); ++p) local.marks[p] = truth(std::find(type.initial.begin(), type.initial.end(), p) != type.initial.end());
  for (std::size_t k = 0; k < type.slots.size(); ++k) {
    if (!type.is_param[k]) local.slots[k] = first(type.types[k]);
  }
  execute(type.initial_action, 1, own(type, local), truth(true), trouble.fault);
  check_invariants(type, local, truth(true), trouble.fault);
  settle(type, local, truth(true), trouble);
  return local;
}

z3::expr Terms::marked(const Local& local, const Rows& places) const {
  z3::expr all = truth(true);
  for (std::size_t place : places) all = both(all, local.marks.at(place));
  return all;
}

z3::expr Terms::has_values(const AtomType& type, const Local& local, const std::vector<std::optional<int>>& values) const {
  z3::expr all = truth(true);
  for (std::size_t k = 0; k < type.slots.size(); ++k) {
    if (values[k]) all = both(all, (local.slots[k] == constant(type.types[k], *values[k])).simplify());
  }
  return all;
}

void Terms::check_invariants(const AtomType& type, Local& local, const z3::expr& when, z3::expr& fault) const {
  for (const Tree* row : type.invariants) {
    const std::string& scope = row->items.at(3).text;
    const Rows places = rows_of(row->find("places"));
    z3::expr here = scope == "always" ? when : both(when, marked(local, places));
    for (std::size_t p = 0; scope == "at" && p < type.places.size(); ++p) {
      if (std::find(places.begin(), places.end(), p) == places.end()) here = both(here, no(local.marks[p]));
    }
    const z3::expr holds = evaluate(row->find("guard")->items.at(1), own(type, local), here, fault);
    fault = either(fault, both(here, no(holds)));
  }
}

void Terms::move(const AtomType& type, const Transition& t, Local& local, const z3::expr& when, z3::expr& fault) const {
  // An automaton is where the transition leads to, and nowhere else.
  if (type.is_automaton) std::fill(local.marks.begin(), local.marks.end(), truth(false));
  for (std::size_t place : t.from) local.marks.at(place) = truth(false);
  for (std::size_t place : t.to) {
    fault = either(fault, both(when, local.marks.at(place)));
    local.marks[place] = truth(true);
  }
  execute(t.action, 1, own(type, local), when, fault);
  check_invariants(type, local, when, fault);
}

namespace {
void merge(const z3::expr& when, const Local& from, Local& into) {
  for (std::size_t p = 0; p < into.marks.size(); ++p) into.marks[p] = choose(when, from.marks[p], into.marks[p]);
  for (std::size_t k = 0; k < into.slots.size(); ++k) into.slots[k] = choose(when, from.slots[k], into.slots[k]);
}
}  // namespace

void Terms::settle(const AtomType& type, Local& local, const z3::expr& when, Trouble& trouble) const {
  Local now = local;
  z3::expr active = when;
  for (int round = 0;; ++round) {
    z3::expr any = truth(false);
    std::optional<Local> next;
    for (const Transition& t : type.transitions) {
      if (t.port != kNone) continue;
      const z3::expr there = both(active, marked(now, t.from));
      if (is(there, false)) continue;
      const z3::expr on = t.guard == nullptr ? there : both(there, evaluate(*t.guard, own(type, now), there, trouble.fault));
      if (is(on, false)) continue;
      trouble.fault = either(trouble.fault, both(any, on));
      any = either(any, on);
      Local moved = now;
      move(type, t, moved, on, trouble.fault);
      if (next) merge(on, moved, *next);
      else next = std::move(moved);
    }
    merge(both(active, no(any)), now, local);
    active = any;
    if (is(active, false)) return;
    if (round >= (is(active, true) ? kMaxClear : kMaxInternals)) {
      trouble.lost = either(trouble.lost, active);
      return;
    }
    now = std::move(*next);
  }
}

Offer Terms::offer(const AtomType& type, Local& local, z3::expr& fault) const {
  Offer offer;
  offer.ports.assign(type.ports.size(), truth(false));
  for (const Transition& t : type.transitions) {
    offer.transitions.push_back(t.port == kNone ? truth(false) : marked(local, t.from));
    if (t.port == kNone) continue;
    z3::expr& going = offer.transitions.back();
    if (t.guard != nullptr) going = both(going, evaluate(*t.guard, own(type, local), going, fault));
    // Two transitions of a port at a time are an error.
    fault = either(fault, both(offer.ports[t.port], going));
    offer.ports[t.port] = either(offer.ports[t.port], going);
  }
  if (!type.priorities.empty()) hide(type, local, offer.ports, fault);
  return offer;
}

// A port is hidden by one above it that is enabled or hidden; ports above themselves are an error.
void Terms::hide(const AtomType& type, Local& local, std::vector<z3::expr>& on, z3::expr& fault) const {
  const std::size_t ports = on.size();
  std::vector<std::vector<z3::expr>> above(ports, std::vector<z3::expr>(ports, truth(false)));
  for (const Tree* row : type.priorities) {
    const Tree* guard = row->find("guard");
    const z3::expr holds = guard == nullptr ? truth(true) : evaluate(guard->items.at(1), own(type, local), truth(true), fault);
    const Tree& low = row->find("low")->items.at(1);
    const Tree& high = row->find("high")->items.at(1);
    for (std::size_t l = 0; l < ports; ++l) {
      for (std::size_t h = 0; h < ports; ++h) {
        const bool fits = (low.text == "any" ? high.text == "any" || l != high.row() : l == low.row()) && (high.text == "any" ? low.text == "any" || h != low.row() : h == high.row());
        if (fits) above[l][h] = either(above[l][h], holds);
      }
    }
  }
  std::vector<z3::expr> covered(ports, truth(false)), cycle(ports, truth(true));
  for (std::size_t round = 0; round < ports; ++round) {
    std::vector<z3::expr> covers(ports, truth(false)), cycles(ports, truth(false));
    for (std::size_t l = 0; l < ports; ++l) {
      for (std::size_t h = 0; h < ports; ++h) {
        covers[l] = either(covers[l], both(above[l][h], either(on[h], covered[h])));
        cycles[l] = either(cycles[l], both(above[l][h], cycle[h]));
      }
    }
    covered = covers;
    cycle = cycles;
  }
  for (std::size_t p = 0; p < ports; ++p) {
    fault = either(fault, cycle[p]);
    on[p] = both(on[p], no(covered[p]));
  }
}

void Terms::take(const AtomType& type, const Transition& t, Local& local, const z3::expr& when, Trouble& trouble) const {
  move(type, t, local, when, trouble.fault);
  settle(type, local, when, trouble);
}

void Terms::fire(const AtomType& type, const Offer& offer, std::size_t port, Local& local, const z3::expr& when, Trouble& trouble) const {
  const Local before = local;
  for (std::size_t t = 0; t < type.transitions.size(); ++t) {
    const z3::expr on = both(when, offer.transitions[t]);
    if (type.transitions[t].port != port || is(on, false)) continue;
    Local next = before;
    take(type, type.transitions[t], next, on, trouble);
    merge(on, next, local);
  }
}

}  // namespace certcheck
