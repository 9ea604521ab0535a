// The states that the rows allow: the first one is among them, every step stays among them, and none of them is bad.
// All at once, as terms with the rows as facts. That none is without a step may be said by weights, row by row.
#include "tools/certcheck/branches.hpp"
#include "tools/certcheck/rounds.hpp"
#include "tools/certcheck/waits.hpp"

#include <ranges>

namespace certcheck {
namespace {

class States {
 public:
  States(const Model& model, const Certificate& certificate, z3::context& z)
      : model_(model), proof_(certificate), z3_(z), terms_(model, z), system_(model, terms_) {
    if (proof_.rounds && !proof_.claim.starts_with("runs ")) throw Rejected("rounds of a claim that is not about runs");
    if (proof_.claim == "local-deadlock-free") {
      if (proof_.states.empty()) throw Rejected("no states are listed");
      waits_.emplace(model_, proof_);
    }
    if (waits_ || proof_.claim == "deadlock-free" || proof_.claim == "error-free") return;
    claim_ = read_trees(proof_.claim);
    const Text form = claim_.head();
    is_of_runs_ = form == "runs" || form == "points";
    const bool is_of_branches = form == "branches";
    if (claim_.items.size() != 2 || (form != "never" && !is_of_runs_ && !is_of_branches))
      throw Rejected("the claim " + quoted(proof_.claim));
    if (is_of_branches && proof_.states.empty()) throw Rejected("no states are listed");
    if (is_of_branches) branches_.emplace(proof_, claim_);
    if (!is_of_runs_) return;
    if (proof_.states.empty() && !proof_.rounds) throw Rejected("neither states nor rounds are given");
    if (proof_.states.empty()) rounds_.emplace(model_, proof_, claim_, terms_);
    else runs_.emplace(proof_, claim_, terms_);
  }

  void run() {
    const bool no_errors = proof_.claim == "error-free",
               wants_steps = no_errors || !proof_.facts.empty() || !proof_.states.empty();
    expr fault = terms_.truth(false);
    State first;
    for (const Atom& atom : model_.atoms) first.push_back(terms_.initial(atom, fault));
    if (no_errors) demand(fault, "the run ends before its first state");
    if (rounds_) first.push_back(rounds_->bits(true));
    for (const Fact& fact : proof_.facts)
      demand(both(no(fault), no(says(fact, {first}))), fact.line + ": does not hold at first");
    if (proof_.states.empty()) {
      State now = allowed();
      const bool are_kept = keep_alone(now) && !no_errors && !rounds_;
      return check_from(now, wants_steps && !are_kept, nullptr);
    }
    std::map<std::size_t, Local> all;
    for (const Local& local : first) all.emplace(all.size(), local);
    const std::optional<std::u32string> begin = listed(*proof_.states.begin(), all);
    if (!is(fault, true) && !begin) throw Rejected("the first state is not among those that the certificate lists");
    for (const std::u32string& state : proof_.states) {
      for (std::size_t a = 0; a < first.size(); ++a) first[a] = terms_.local(model_.atoms[a], proof_.locals[state[a]]);
      check_from(first, true, &state);
    }
    if (runs_ && begin) runs_->check(*begin);
    if (branches_ && begin) branches_->check(*begin);
    if (waits_) waits_->check();
  }

 private:
  // No such state is bad, and no step leads out of what the rows allow. `listed`: it is one state.
  void check_from(const State& now, bool wants_steps, const std::u32string* listed) {
    const bool no_errors = proof_.claim == "error-free";
    if (!proof_.unless.empty()) check_weights(now);
    if (!proof_.unless.empty() && !wants_steps) return;
    system_.look_at(now, wants_steps || !claim_.items.empty());
    if (no_errors)
      demand(either(system_.state_fault(), system_.guard_fault()),
             "a state that the certificate allows ends with an error");
    // Where the run has ended with an error nothing follows.
    if (is(system_.state_fault(), true)) return;
    if (listed != nullptr && !is(system_.state_fault(), false))
      throw NotCheckable("what a state does depends on values that are not followed");
    terms_.assume(no(system_.state_fault()));
    if (runs_) runs_->enter(*listed, system_);
    if (branches_) branches_->enter(*listed, system_);
    if (waits_) waits_->enter(*listed, system_);
    const auto check_step = [&](const Step& step) {
      // First without what priorities hide, and only for the atoms that move.
      const auto can = [&](const expr& e) {
        std::set<std::size_t> moving;
        for (const auto& [atom, local] : step.next) moving.insert(atom);
        return terms_.may_be(both(step.offered, e), moving) && terms_.may_be(both(step.possible, e));
      };
      if (no_errors && can(step.fault)) throw Rejected("a step ends with an error");
      const expr goes_on = no(step.fault);
      if (waits_) waits_->take(step);
      if (is(both(step.possible, goes_on), false)) return;
      if (listed != nullptr) return check_listed(*listed, step, goes_on);
      std::map<std::size_t, std::set<const Case*>> touched;
      for (const auto& [atom, local] : step.next) {
        const bool is_same = std::equal(local.begin(), local.end(), now[atom].begin(),
                                        [](const expr& a, const expr& b) { return z3::eq(a, b); });
        if (!is_same)
          for (const auto& [fact, cases] : facts_of_[atom]) touched[fact].insert(cases.begin(), cases.end());
      }
      const View from{now, &step.now}, after{now, &step.next};
      expr leaves = terms_.some(touched, [&](const auto& cases_of_fact) {
        const Fact& fact = proof_.facts[cases_of_fact.first];
        return no(fact.total ? stays(fact, cases_of_fact.second, from, after) : says(fact, after));
      });
      if (can(both(goes_on, leaves))) throw Rejected("a step leads out of what the certificate allows");
    };
    if (rounds_) {
      std::vector<Step> steps;
      system_.each_step([&](const Step& step) { steps.push_back(step); });
      rounds_->add_monitor(now.back(), system_, steps);
      for (const Step& step : steps) check_step(step);
      return demand(rounds_->is_bad(now.back()), "a state that the certificate allows has more rounds before it");
    }
    if (wants_steps) system_.each_step(check_step);
    if (proof_.claim == "deadlock-free" && proof_.unless.empty())
      demand(no(either(system_.has_step(), system_.is_final())), "a state that the certificate allows has no step");
    if (runs_) return runs_->leave(system_.has_step());
    if (!branches_ && !claim_.items.empty())
      demand(system_.claim(claim_.items[1]), "a state that the certificate allows is what should never be");
  }
  // Lemmas about one atom that it keeps whatever its connectors do and write: no step need be looked at for these. Are
  // all facts such lemmas?
  bool keep_alone(State& now) {
    std::map<std::size_t, Rows> alone;
    for (std::size_t k = 0; k < proof_.facts.size(); ++k) {
      const Fact& fact = proof_.facts[k];
      const std::size_t atom = fact.cases.empty() ? kNone : fact.cases[0].literals[0].atom;
      const bool is_alone =
          !fact.total && atom < model_.atoms.size() && std::ranges::all_of(fact.cases, [&](const Case& row) {
            return std::ranges::all_of(row.literals, [&](const Literal& l) { return l.atom == atom; });
          });
      if (is_alone) alone[atom].push_back(k);
    }
    std::size_t kept = 0;
    for (const auto& [atom, facts] : alone) {
      if (!keeps(atom, facts, now)) continue;
      kept += facts.size();
      for (std::size_t k : facts) facts_of_[atom].erase(k);
    }
    return kept == proof_.facts.size();
  }
  bool keeps(std::size_t atom, const Rows& facts, State& now) {
    const AtomType& type = model_.type_of(atom);
    expr leaves = terms_.truth(false), fault = leaves;
    const Offer offer = terms_.offer(type, now[atom], fault);
    for (std::size_t t = 0; t < type.transitions.size(); ++t) {
      const std::size_t port = type.transitions[t].port;
      if (port == kNone) continue;
      std::map<std::size_t, Local> next{{atom, now[atom]}};
      for (std::size_t variable : type.ports[port].written)
        next.at(atom)[variable] = terms_.fresh(type.variables[variable].type);
      const expr on = both(offer.ports[port], offer.transitions[t]);
      expr ends = terms_.truth(false);
      terms_.take(type, type.transitions[t], next.at(atom), on, ends);
      const expr breaks = terms_.some(facts, [&](std::size_t k) {
        return no(says(proof_.facts[k], View{now, &next}));
      });
      leaves = either(leaves, both(both(on, no(ends)), breaks));
    }
    return !terms_.may_be(leaves, std::set<std::size_t>{atom});
  }
  using Weights = std::map<std::vector<Literal>, std::int64_t>;  // of cases of an atom, of which at most one holds
  // By weight: where do the cases that hold have it? Where none holds it is 0.
  std::map<std::int64_t, expr> by_weight(const Weights& weights, const State& now) const {
    std::map<std::int64_t, expr> result{{0, terms_.truth(false)}};
    expr none = terms_.truth(true);
    for (const auto& [literals, weight] : weights) {
      const expr is_so = holds({literals}, View{now});
      none = both(none, no(is_so));
      expr& some = result.try_emplace(weight, terms_.truth(false)).first->second;
      some = either(some, is_so);
    }
    result.at(0) = either(result.at(0), none);
    return result;
  }
  // Do the weights of the cases that hold add up to more than 0?
  expr exceeds(const std::map<std::size_t, Weights>& weights, const State& now) const {
    std::map<std::int64_t, expr> sums{{0, terms_.truth(true)}};
    for (const auto& [atom, its] : weights) {
      std::map<std::int64_t, expr> next;
      for (const auto& [weight, is_so] : by_weight(its, now)) {
        for (const auto& [sum, holds] : sums) {
          expr& some = next.try_emplace(sum + weight, terms_.truth(false)).first->second;
          some = either(some, both(holds, is_so));
        }
      }
      sums = std::move(next);
    }
    return terms_.some(sums, [&](const auto& sum) { return sum.first > 0 ? sum.second : terms_.truth(false); });
  }
  // Where no step is possible, the weights of the cases that hold add up to 0 at most in each row `unless`, so in all
  // rows together. But they are more, if the least weights that the atoms can have, each by itself, are: so there is no
  // such state. Rows that begin with the same atom are one question.
  void check_weights(const State& now) {
    system_.offer(now);
    std::map<std::size_t, Weights> all;
    for (std::size_t k = 0, end = 0; k < proof_.unless.size(); k = end) {
      expr bad = terms_.truth(false);
      std::set<std::size_t> atoms;
      const auto first_of = [&](std::size_t row) { return proof_.unless[row].cases[0].literals[0].atom; };
      for (end = k; end < proof_.unless.size() && first_of(end) == first_of(k); ++end) {
        const Fact& fact = proof_.unless[end];
        std::map<std::size_t, Weights> own;
        for (const Case& row : fact.cases) {
          own[row.literals[0].atom][row.literals] += row.weight;
          all[row.literals[0].atom][row.literals] += row.weight;
          atoms.insert(row.literals[0].atom);
        }
        atoms.merge(system_.atoms_of(fact.step));
        bad = either(bad, both(exceeds(own, now), no(system_.is_possible(fact.step))).simplify());
      }
      if (terms_.may_be(bad, atoms))
        throw Rejected(proof_.unless[k].line + " or after: weights add up to more than 0 in a state without a step");
    }
    std::int64_t sum = 0;
    for (const auto& [atom, weights] : all) sum += least_weight(atom, weights, now);
    if (sum <= 0) throw Rejected("weights do not exclude a state without a step");
  }
  std::int64_t least_weight(std::size_t atom, const Weights& weights, const State& now) {
    for (auto row = weights.begin(); row != weights.end(); ++row) {
      for (auto other = weights.begin(); other != row; ++other)
        if (!are_exclusive(model_, row->first, other->first))
          throw Rejected("two cases of " + quoted(model_.atoms[atom].path) + " do not exclude each other");
    }
    for (const auto& [weight, is_so] : by_weight(weights, now))
      if (terms_.may_be(is_so, std::set<std::size_t>{atom})) return weight;
    throw Rejected(quoted(model_.atoms[atom].path) + " has no state");
  }
  // Is all that a step can lead to listed? Where ports are merged there are several such states.
  void check_listed(const std::u32string& state, const Step& step, const expr& goes_on) {
    std::map<std::size_t, Local> next = step.next;
    // Of runs it matters which ports take part, too.
    if (runs_)
      for (const auto& [node, is_in] : step.parts) next[kNone].push_back(is_in);
    const bool is_clear =
        !runs_ || std::ranges::all_of(next[kNone], [](const expr& e) { return value_of(e).has_value(); });
    if (is_clear && goes_to(state, step, next, true)) return;
    terms_.each_solution(both(step.possible, goes_on), next, [&](const std::map<std::size_t, Local>& next_state) {
      if (!goes_to(state, step, next_state, false)) throw Rejected("a step leads out of what the certificate allows");
    });
  }
  bool goes_to(const std::u32string& state, const Step& step, const std::map<std::size_t, Local>& next, bool is_clear) {
    const std::optional<std::u32string> to = listed(state, next);
    if (to && waits_ && is_clear) waits_->lead(step, *to);
    if (to && branches_) branches_->lead(step, *to, is_clear);
    if (!to || !runs_) return to.has_value();
    std::map<std::size_t, expr> parts = step.parts;
    auto value = next.at(kNone).begin();
    for (auto& [node, is_in] : parts) is_in = *value++;
    runs_->add(model_, step, parts, *to);
    return true;
  }
  // The listed state that is, for sure, this one but for some atoms; or nothing.
  [[nodiscard]] std::optional<std::u32string> listed(std::u32string state,
                                                     const std::map<std::size_t, Local>& others) const {
    for (const auto& [atom, local] : others) {
      if (atom == kNone) continue;
      Values values(local.size(), 0);
      for (std::size_t k = 0; k < local.size(); ++k) {
        if (!model_.type_of(atom).variables[k].is_param) values[k] = value_of(local[k]);
      }
      const auto row = proof_.row_of_local.find(values);
      if (row == proof_.row_of_local.end()) return std::nullopt;
      state[atom] = row->second;
    }
    return proof_.states.contains(state) ? std::optional(state) : std::nullopt;
  }
  // There is no state like that.
  void demand(const expr& bad, const std::string& otherwise) {
    if (terms_.may_be(bad)) throw Rejected(otherwise);
  }
  // A state, of some atoms another one.
  struct View {
    const State& state;
    const std::map<std::size_t, Local>* others = nullptr;

    [[nodiscard]] const expr& of(const Literal& l) const {
      return (others != nullptr && others->contains(l.atom) ? others->at(l.atom) : state[l.atom])[l.variable];
    }
  };
  [[nodiscard]] expr says(const Fact& fact, const View& view) const {
    if (!fact.total) return terms_.some(fact.cases, [&](const Case& row) { return holds(row, view); });
    const expr sum = sum_of(fact, fact.cases | std::views::transform([](const Case& row) { return &row; }), view);
    return fact.is_bound ? (sum <= terms_.constant("int", *fact.total)).simplify() : equals(sum, *fact.total);
  }
  // A sum does, or one with a bound does not rise, if these of its cases are all that a step may change.
  [[nodiscard]] expr stays(const Fact& fact, const std::set<const Case*>& cases, const View& from,
                           const View& after) const {
    const expr now = sum_of(fact, cases, from), then = sum_of(fact, cases, after);
    if (z3::eq(now, then)) return terms_.truth(true);
    return fact.is_bound ? (then <= now).simplify() : equals((then - now).simplify(), 0);
  }
  template <class Cases>
  [[nodiscard]] expr sum_of(const Fact& fact, const Cases& cases, const View& view) const {
    expr sum = zero_;
    std::map<std::size_t, expr> of_atoms;  // of a bound: one case of each holds
    for (const Case* row : cases) {
      const expr weight = terms_.constant("int", row->weight);
      if (row->is_value) sum = sum + weight * view.of(row->literals[0]);
      else if (const expr is_so = holds(*row, view); !is(is_so, false) && fact.is_bound)
        of_atoms.insert_or_assign(
            row->literals[0].atom,
            choose(is_so, weight, of_atoms.try_emplace(row->literals[0].atom, zero_).first->second));
      else if (!is(is_so, false)) sum = sum + choose(is_so, weight, zero_);
    }
    for (const auto& [atom, value] : of_atoms) sum = sum + value;
    return sum.simplify();
  }
  [[nodiscard]] expr holds(const Case& row, const View& view) const {
    return terms_.all(row.literals, [&](const Literal& l) {
      const expr& v = view.of(l);
      const auto within = [&](int value) { return l.low <= value && value <= l.high; };
      expr result = v;
      if (v.is_bool()) result = within(1) == within(0) ? terms_.truth(within(1)) : within(1) ? v : no(v);
      else if (l.bit) result = equals(v.extract(*l.bit, *l.bit).simplify(), 1);
      else result = l.low == l.high ? equals(v, l.low) : (v >= l.low && v <= l.high).simplify();
      return l.is_negated ? no(result) : result;
    });
  }
  // A sum without values as one of truths, whose opposites count where they would take away: if no sum comes near to
  // 2^32.
  void assume(const Fact& fact, const View& view, std::size_t atom) {
    z3::expr_vector all(z3_);
    std::vector<int> weights;
    std::int64_t total = fact.total.value_or(0), most = 0;
    for (const Case& row : fact.cases) {
      const expr is_so = row.is_value ? terms_.truth(true) : holds(row, view);
      all.push_back(row.weight < 0 ? no(is_so) : is_so);
      weights.push_back(std::abs(row.weight));
      total += row.weight < 0 ? weights.back() : 0;
      most += row.is_value ? kMostWeight : weights.back();
    }
    if (!fact.total || most >= kMostWeight || std::abs(total) >= kMostWeight)
      return terms_.assume(says(fact, view), atom);
    if (fact.is_bound) {
      const expr is_within = all.empty() ? terms_.truth(true) : z3::pble(all, weights.data(), *fact.total);
      return terms_.assume(is_within, atom);
    }
    assume_sum(all, weights, static_cast<int>(total), atom);
  }
  // Their weights add up to the total.
  void assume_sum(const z3::expr_vector& all, const std::vector<int>& weights, int total, std::size_t atom) {
    terms_.assume(all.empty() ? terms_.truth(total == 0) : z3::pbeq(all, weights.data(), total), atom);
  }
  // All states of which what has been found holds: a mode for each atom, which says where it is; the sets; the facts.
  State allowed() {
    State now;
    const bool has_modes = !proof_.classes.empty();
    State modes(model_.atoms.size());                         // by number
    std::map<std::size_t, std::vector<const Literal*>> told;  // values that lemmas tell
    for (const Fact& fact : proof_.facts) {
      if (fact.total || fact.cases.size() != 1 || fact.cases[0].literals.size() != 1) continue;
      const Literal& l = fact.cases[0].literals[0];
      const bool is_data = l.atom < model_.atoms.size() && l.variable >= model_.type_of(l.atom).places;
      if (is_data && l.low == l.high && !l.bit && !l.is_negated) told[l.atom].push_back(&l);
    }
    for (std::size_t a = 0; a < model_.atoms.size(); ++a) {
      const AtomType& type = model_.type_of(a);
      // What is the same in all modes is known.
      Values same(type.variables.size());
      const auto values_of = [&](std::size_t number) -> const Values& {
        return proof_.classes[proof_.class_of[a]].modes[number];
      };
      if (!proof_.reachable[a].empty()) same = values_of(*proof_.reachable[a].begin());
      for (std::size_t number : proof_.reachable[a])
        for (std::size_t k = 0; k < same.size(); ++k)
          same[k] = same[k] == values_of(number)[k] ? same[k] : std::nullopt;
      for (const Literal* l : told[a]) same[l->variable] = l->low;
      if (has_modes) std::fill_n(same.begin(), type.places, 0);
      Local& local = now.emplace_back(terms_.local(model_.atoms[a], same));
      if (has_modes) modes[a].resize(proof_.classes[proof_.class_of[a]].modes.size(), terms_.truth(false));
      z3::expr_vector all(z3_);
      for (std::size_t p = 0; p < type.places && !has_modes && type.is_automaton; ++p) all.push_back(local[p]);
      for (std::size_t number : proof_.reachable[a]) {
        const Values& values = values_of(number);
        const bool is_other = proof_.reachable[a].size() == 2 && all.size() == 1;
        const expr mode = modes[a][number] = is_other ? !all[0] : terms_.fresh("bool");
        all.push_back(mode);
        for (std::size_t p = 0; p < type.places; ++p) local[p] = *values[p] != 0 ? either(local[p], mode) : local[p];
        terms_.assume(either(no(mode), terms_.has(local, values, type.places)), a);
      }
      if (has_modes ? all.size() != 2 : type.is_automaton) assume_sum(all, std::vector<int>(all.size(), 1), 1, a);
    }
    for (const Fact& set : proof_.sets) assume(set, {modes}, kNone);
    // Between steps no internal transition is left.
    for (std::size_t a = 0; a < now.size(); ++a) terms_.assume(no(terms_.goes_on(model_.type_of(a), now[a])), a);
    if (rounds_) now.push_back(rounds_->bits(false));
    for (std::size_t k = 0; k < proof_.facts.size(); ++k) {
      std::set<std::size_t> atoms;
      for (const Case& row : proof_.facts[k].cases)
        for (const Literal& l : row.literals) atoms.insert(l.atom), facts_of_[l.atom][k].insert(&row);
      assume(proof_.facts[k], {now}, atoms.size() == 1 ? *atoms.begin() : kNone);
    }
    return now;
  }

  const Model& model_;
  const Certificate& proof_;
  z3::context& z3_;
  Terms terms_;
  System system_;
  const expr zero_ = terms_.constant("int", 0);
  Tree claim_;
  bool is_of_runs_ = false;
  std::optional<Runs> runs_;
  std::optional<Branches> branches_;
  std::optional<Rounds> rounds_;
  std::optional<Waits> waits_;
  std::map<std::size_t, std::map<std::size_t, std::set<const Case*>>> facts_of_;  // by atom and fact
};

}  // namespace

// Is the claim, in the third row, one that something comes?
static bool is_observed(std::istream& text) {
  const auto start = text.tellg();
  std::string line;
  for (int k = 0; k < 3; ++k) std::getline(text, line);
  text.clear();
  text.seekg(start);
  return line.starts_with("claim within ") || line.starts_with("claim eventually ");
}

std::string check(const Model& model, std::istream& text, z3::context& z) {
  if (!model.is_timed || !is_observed(text)) return check(model, read_certificate(model, text), z);
  const Model observed = with_observer(model);
  return check(observed, read_certificate(observed, text), z);
}

std::string check(const Model& model, const Certificate& c, z3::context& z) {
  if (!c.set_rows.empty()) throw Rejected("rows about all sizes, of a system of one size");
  const std::size_t observers = model.atoms.empty() || model.atoms.back().path != "observer" ? 0 : 1;
  const std::string components = std::to_string(model.atoms.size() - observers) + " components, ";
  if (!c.classes.empty()) check_structure(model, c, z);
  if (c.pair) {
    const PairModel pair = model_of_pair(model, c);
    check_zones(pair.model, c, z, &pair);
  } else if (model.is_timed) {
    check_zones(model, c, z);
  } else {
    States(model, c, z).run();
  }
  const auto count = [](std::size_t number, const std::string& what) {
    return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
  };
  std::size_t zones = 0;
  for (const auto& [state, of] : c.zones) zones += of.size();
  const std::string states = count(c.states.size(), "state");
  if (c.claim.starts_with("runs ") || c.claim.starts_with("points "))
    return components + (c.rounds ? count(*c.rounds, "round") + ", " + count(c.facts.size(), "fact") : states) +
           (c.claim.starts_with("r") ? "; fairness of runs: " + (c.fairness.empty() ? "none" : c.fairness) : "");
  if (!c.states.empty())
    return components + (zones == 0 ? "" : count(zones, "zone") + " of ") + states + (c.pair ? " of any two" : "");
  return components + count(c.sets.size(), "invariant") +
         (c.facts.empty() ? "" : ", " + count(c.facts.size(), "fact")) +
         (c.unless.empty() ? "" : ", " + count(c.unless.size(), "sum") + " of states without a step");
}

}  // namespace certcheck
