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

Local Terms::local(const Atom& atom, const std::function<z3::expr(std::size_t)>& mark, const std::function<z3::expr(std::size_t)>& value) const {
  const AtomType& type = m_.atom_types[atom.type];
  Local local;
  std::size_t arg = 0;
  z3::expr fault = truth(false);
  for (std::size_t p = 0; p < type.places.size(); ++p) local.marks.push_back(mark(p));
  for (std::size_t k = 0; k < type.slots.size(); ++k) local.slots.push_back(type.is_param[k] ? evaluate(atom.args->at(++arg), {}, fault, fault) : value(k));
  return local;
}

Local Terms::initial(const Atom& atom, Trouble& trouble) const {
  const AtomType& type = m_.atom_types[atom.type];
  const auto is_marked = [&](std::size_t p) { return truth(std::find(type.initial.begin(), type.initial.end(), p) != type.initial.end()); };
  Local start = local(atom, is_marked, [&](std::size_t k) { return first(type.types[k]); });
  execute(*type.initial_action, own(type, start), truth(true), trouble.fault);
  check_invariants(type, start, truth(true), trouble.fault);
  settle(type, start, truth(true), trouble);
  return start;
}

z3::expr Terms::marked(const Local& local, const Rows& places) const {
  z3::expr all = truth(true);
  for (std::size_t place : places) all = both(all, local.marks.at(place));
  return all;
}

z3::expr Terms::has_values(const AtomType& type, const Local& local, const std::vector<std::optional<int>>& values) const {
  z3::expr all = truth(true);
  for (std::size_t k = 0; k < type.slots.size(); ++k) {
    if (!values[k]) continue;
    const std::optional<int> known = value(local.slots[k]);
    all = both(all, known ? truth(*known == *values[k]) : local.slots[k] == constant(type.types[k], *values[k]));
  }
  return all;
}

void Terms::check_invariants(const AtomType& type, Local& local, const z3::expr& when, z3::expr& fault) const {
  for (const Tree* row : type.invariants) {
    const std::string_view scope = row->at(3).text;
    const Rows places = (*row)["places"].rows();
    z3::expr here = scope == "always" ? when : both(when, marked(local, places));
    for (std::size_t p = 0; scope == "at" && p < type.places.size(); ++p) {
      if (std::find(places.begin(), places.end(), p) == places.end()) here = both(here, no(local.marks[p]));
    }
    const z3::expr good = holds((*row)["guard"], own(type, local), here, fault);
    fault = either(fault, both(here, no(good)));
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
  execute(*t.action, own(type, local), when, fault);
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
      const z3::expr on = both(there, holds(*t.guard, own(type, now), there, trouble.fault));
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
