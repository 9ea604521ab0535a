// Atoms over Z3 terms: what they offer, where they begin, what a transition and the internal ones after it lead to.
#include <algorithm>

#include "tools/certcheck/terms.hpp"

namespace certcheck {

namespace {
// Internal transitions in a row: in general, and where it is clear which.
constexpr int kMaxInternals = 24, kMaxClear = 100000;

Scope own(const AtomType& type, Local& local) { return {std::span(local).subspan(type.places), {}, {}}; }

z3::expr marked(const Local& local, const Rows& places) {
  z3::expr all = local.at(0).ctx().bool_val(true);
  for (std::size_t place : places) all = both(all, local[place]);
  return all;
}

void merge(const z3::expr& when, const Local& from, Local& into) {
  for (std::size_t k = 0; k < into.size(); ++k) into[k] = choose(when, from[k], into[k]);
}
}  // namespace

Local Terms::initial(const Atom& atom, z3::expr& fault) const {
  const AtomType& type = m_.atom_types[atom.type];
  Local start = local(atom, [&](std::size_t k) { return first(type.variables[k].type); });
  for (std::size_t place : type.initial) start[place] = truth(true);
  execute(*type.initial_action, own(type, start), truth(true), fault);
  check_invariants(type, start, truth(true), fault);
  settle(type, start, truth(true), fault);
  return start;
}

void Terms::check_invariants(const AtomType& type, Local& local, const z3::expr& when, z3::expr& fault) const {
  for (const Invariant& row : type.invariants) {
    z3::expr here = when;
    for (std::size_t p = 0; row.scope != "always" && p < type.places; ++p) {
      if (std::find(row.places.begin(), row.places.end(), p) != row.places.end()) here = both(here, local[p]);
      else if (row.scope == "at") here = both(here, no(local[p]));
    }
    const z3::expr good = holds(*row.guard, own(type, local), here, fault);
    fault = either(fault, both(here, no(good)));
  }
}

void Terms::move(const AtomType& type, const Transition& t, Local& local, const z3::expr& when, z3::expr& fault) const {
  // An automaton is where the transition leads to, and nowhere else.
  if (type.is_automaton) std::fill_n(local.begin(), type.places, truth(false));
  for (std::size_t place : t.from) local[place] = truth(false);
  for (std::size_t place : t.to) {
    fault = either(fault, both(when, local[place]));
    local[place] = truth(true);
  }
  execute(*t.action, own(type, local), when, fault);
  check_invariants(type, local, when, fault);
}

// Where it does not come to an end nothing is known, not even whether that is an error.
void Terms::settle(const AtomType& type, Local& local, const z3::expr& when, z3::expr& fault) const {
  Local now = local;
  z3::expr active = when;
  for (int round = 0; !is(active, false); ++round) {
    z3::expr any = truth(false);
    Local next = now;
    if (round > (is(active, true) ? kMaxClear : kMaxInternals)) {
      fault = either(fault, both(active, fresh("bool")));
      for (std::size_t k = 0; k < now.size(); ++k) now[k] = fresh(type.variables[k].type);
    } else {
      for (const Transition& t : type.transitions) {
        if (t.port != kNone) continue;
        const z3::expr there = both(active, marked(now, t.from));
        if (is(there, false)) continue;
        const z3::expr on = both(there, holds(*t.guard, own(type, now), there, fault));
        if (is(on, false)) continue;
        Local moved = now;
        move(type, t, moved, on, fault);
        if (is(any, false)) next = std::move(moved);
        else merge(on, moved, next);
        fault = either(fault, both(any, on));
        any = either(any, on);
      }
    }
    merge(both(active, no(any)), now, local);
    active = any;
    now = std::move(next);
  }
}

Offer Terms::offer(const AtomType& type, Local& local, z3::expr& fault) const {
  Offer offer{{}, std::vector<z3::expr>(type.ports.size(), truth(false))};
  for (const Transition& t : type.transitions) {
    z3::expr& going = offer.transitions.emplace_back(t.port == kNone ? truth(false) : marked(local, t.from));
    if (t.port == kNone) continue;
    going = both(going, holds(*t.guard, own(type, local), going, fault));
    // Two transitions of a port at a time are an error.
    fault = either(fault, both(offer.ports[t.port], going));
    offer.ports[t.port] = either(offer.ports[t.port], going);
  }
  if (!type.priorities.empty()) hide(type, local, offer.ports, fault);
  return offer;
}

// A port is hidden by one above it, by way of others, that is enabled; ports above themselves are an error.
void Terms::hide(const AtomType& type, Local& local, std::vector<z3::expr>& on, z3::expr& fault) const {
  const std::size_t ports = on.size();
  std::vector<std::vector<z3::expr>> above(ports, std::vector<z3::expr>(ports, truth(false)));
  const auto fits = [](const Tree& side, const Tree& other, std::size_t port) {
    return side.text != "any" ? port == side.row() : other.text == "any" || port != other.row();
  };
  for (const Tree* row : type.priorities) {
    const z3::expr rule = holds((*row)["guard"], own(type, local), truth(true), fault);
    const Tree &low = (*row)["low"].at(1), &high = (*row)["high"].at(1);
    for (std::size_t l = 0; l < ports; ++l) {
      for (std::size_t h = 0; h < ports; ++h) above[l][h] = fits(low, high, l) && fits(high, low, h) ? either(above[l][h], rule) : above[l][h];
    }
  }
  for (std::size_t k = 0; k < ports; ++k) {
    for (std::size_t l = 0; l < ports; ++l) {
      for (std::size_t h = 0; h < ports; ++h) above[l][h] = either(above[l][h], both(above[l][k], above[k][h]));
    }
  }
  const std::vector<z3::expr> offered = on;
  for (std::size_t l = 0; l < ports; ++l) {
    fault = either(fault, above[l][l]);
    for (std::size_t h = 0; h < ports; ++h) on[l] = both(on[l], no(both(above[l][h], offered[h])));
  }
}

void Terms::take(const AtomType& type, const Transition& t, Local& local, const z3::expr& when, z3::expr& fault) const {
  move(type, t, local, when, fault);
  settle(type, local, when, fault);
}

void Terms::fire(const AtomType& type, const Offer& offer, std::size_t port, Local& local, const z3::expr& when, z3::expr& fault) const {
  const Local before = local;
  for (std::size_t t = 0; t < type.transitions.size(); ++t) {
    const z3::expr on = both(when, offer.transitions[t]);
    if (type.transitions[t].port != port || is(on, false)) continue;
    Local next = before;
    take(type, type.transitions[t], next, on, fault);
    merge(on, next, local);
  }
}

}  // namespace certcheck
