// With time, certificates list states with zones, that is sets of values of the clocks. The first state is among them,
// whatever is a step, the return of an action or the passing of one tick stays among them, and none of them is bad.
// Time is in whole ns (compiler/docs/semantics.md, Time), so what holds tick by tick holds always: there is no
// arithmetic of zones here. A state's clocks are integers of which its zones are the facts.
#include "tools/certcheck/successors.hpp"

namespace certcheck {
namespace {

class Zones {
 public:
  Zones(const Model& model, const Certificate& certificate, z3::context& z, const PairModel* pair)
      : model_(model), proof_(certificate), z3_(z), pair_(pair) {
    for (const AtomType& type : model_.atom_types) {
      const auto has = [&](Text op) {
        return std::any_of(type.transitions.begin(), type.transitions.end(), [&](const Transition& t) {
          const std::vector<const Tree*> bounds = t.row->all("bound");
          return std::any_of(bounds.begin(), bounds.end(), [&](const Tree* b) { return b->at(1).text == op; });
        });
      };
      has_open_ = has_open_ || has("gt");
    }
    if (pair_ != nullptr) let_numbers();
    if (is_about("deadlock-free") || is_about("error-free")) return;
    claim_ = read_trees(proof_.claim);
    if (claim_.head() == "within" || claim_.head() == "eventually") {
      const bool has_limit = claim_.head() == "within";
      if (claim_.items.size() != (has_limit ? 4 : 3) || model_.atoms.back().path != "observer" ||
          has_limit == proof_.later.has_value())
        throw Rejected("the claim " + quoted(proof_.claim));
      if (!claim_.find({"can", "can-port"}).empty()) throw NotCheckable("that something comes which can be done");
      is_observed_ = true;
      if (has_limit) limit_ = claim_.at(1).ticks();
      return;
    }
    if (claim_.items.size() != 2 || claim_.items[0].text != "never")
      throw Rejected("the claim " + quoted(proof_.claim));
    if (pair_ != nullptr && !claim_.find({"can", "can-port"}).empty())
      throw NotCheckable("what can be done, of a pair of components");
  }

  void run() {
    if (pair_ != nullptr && claim_.head() != "never") throw Rejected("a pair shows nothing but what never is");
    expr fault = terms_.truth(false);
    State first;
    for (const Atom& atom : model_.atoms) {
      Local& local = first.emplace_back(terms_.initial(atom, fault));
      const AtomType& type = model_.atom_types[atom.type];
      if (type.is_timed && !is(equals(local[type.waits], 0), true))
        local[type.waits + 1] = terms_.constant("int", static_cast<int>(first.size()) - 1);
    }
    if (is_about("error-free")) demand(fault, "the run ends before its first state");
    if (is_observed_) observe(system_, first, nullptr, first, terms_.truth(true));
    stays(no(fault), first, "the first state is not among those that the certificate lists");
    for (const auto& [key, zones] : proof_.zones) {
      std::set<std::size_t> ranks;
      for (const Zone& zone : zones) ranks.insert(zone.rank);
      for (std::size_t rank : ranks) {
        terms_.begin();
        check_from(key, rank);
        terms_.end();
      }
    }
  }

 private:
  // Of all points of the state's zones of this rank.
  void check_from(const std::u32string& key, std::size_t rank) {
    State now;
    for (std::size_t a = 0; a < model_.atoms.size(); ++a) {
      Values values = proof_.locals[key[a]];
      for (std::size_t k = 0; k < values.size(); ++k)
        if (!proof_.is_told[a][k]) values[k] = std::nullopt;
      now.push_back(terms_.local(model_.atoms[a], values));
    }
    terms_.assume(is_inside(key, now, [&](const Zone& zone) { return zone.rank == rank; }));
    if (pair_ != nullptr) look_at_third(now);
    State later = now;
    for (std::size_t a = 0; a < later.size(); ++a) {
      const AtomType& type = model_.type_of(a);
      for (std::size_t k = type.first_clock; k < type.first_clock + type.clocks.size(); ++k)
        later[a][k] = now[a][k] + 1;
    }
    expr opens = terms_.truth(false), may_open = opens;
    if (has_open_) {
      system_.look_at(later, true);
      opens = system_.opens(true);
      may_open = system_.opens(false);
    }
    system_.look_at(now, true);
    expr fault = system_.state_fault();
    // What busy atoms wait for, by the atom with whom they go on; and what lets time pass, for sure and perhaps.
    std::map<int, std::pair<expr, expr>> groups;
    expr may_pass = terms_.truth(true);
    for (std::size_t a = 0; a < now.size(); ++a) {
      const AtomType& type = model_.type_of(a);
      may_pass =
          both(may_pass, both(terms_.may_be_then(type, now[a], 0, fault), terms_.may_be_then(type, now[a], 1, fault)));
      if (!type.is_timed || is(equals(now[a][type.waits], 0), true)) continue;
      const int leader = value_of(now[a][type.waits + 1]).value_or(0);
      auto& [is_over, is_over_then] = groups.try_emplace(leader, terms_.truth(true), terms_.truth(true)).first->second;
      is_over = both(is_over, terms_.may_resume(type, now[a], 0, fault));
      is_over_then = both(is_over_then, terms_.may_resume(type, now[a], 1, fault));
    }
    if (is_about("error-free"))
      demand(either(fault, system_.guard_fault()), "a state that the certificate allows ends with an error");
    // Where the run has ended with an error nothing follows.
    terms_.assume(no(fault));
    // While a request waits: the rank does not rise; an action that may return, and never does while it stays.
    const bool is_ranked = proof_.later && is(now.back()[0], true);
    const std::optional<std::size_t> most = is_ranked ? std::optional(rank) : std::nullopt;
    const auto returns = proof_.returns.find(rank);
    const std::optional<std::size_t> returning =
        is_ranked && returns != proof_.returns.end() ? std::optional(returns->second) : std::nullopt;
    system_.each_step([&](const Step& step) {
      if (is_about("error-free") && terms_.may_be(both(step.possible, step.fault)))
        throw Rejected("a step ends with an error");
      State next = replaced(now, step.next);
      expr still_waits = terms_.truth(false), is_taken = both(step.possible, no(step.fault));
      if (is_observed_) {
        still_waits = now.back()[0];
        observe(system_, now, &step, next, terms_.truth(false));
        still_waits = both(still_waits, next.back()[0]);
        observe(after_, next, nullptr, next, terms_.truth(false));
        still_waits = both(still_waits, next.back()[0]);
      }
      if (!proof_.later) return stays(is_taken, next, "a step leads out of what the certificate allows");
      stays(both(is_taken, no(still_waits)), next, "a step leads out of what the certificate allows");
      const auto group = returning ? groups.find(leader_of(now, *returning).value_or(kNobody)) : groups.end();
      comes_to_end(both(is_taken, still_waits), next, rank,
                   group == groups.end() ? terms_.truth(false) : group->second.first);
    });
    expr resumes = terms_.truth(false), must_resume = resumes;
    for (const auto& [leader, is_over] : groups) {
      resumes = either(resumes, is_over.first);
      must_resume = either(must_resume, both(is_over.first, no(is_over.second)));
      State next = now;
      for (std::size_t a = 0; a < next.size(); ++a) {
        if (leader_of(now, a) != leader) continue;
        const std::size_t waits = model_.type_of(a).waits;
        next[a][waits] = next[a][waits + 1] = terms_.constant("int", 0);
      }
      const std::string otherwise = "an action's return leads out of what the certificate allows";
      if (returning && leader_of(now, *returning) == leader) falls(is_over.first, next, rank, otherwise);
      else stays(is_over.first, next, otherwise, most);
    }
    may_pass = both(may_pass, no(must_resume));
    const expr passes = both(may_pass, both(no(system_.is_urgent(true)), no(opens)));
    stays(passes, later, "time leads out of what the certificate allows", most);
    const expr waits = is_observed_ ? now.back()[0] : terms_.truth(false);
    if (limit_)
      demand(both(waits, (now.back()[model_.atom_types.back().first_clock] > z3_.int_val(*limit_)).simplify()),
             "a state that the certificate allows comes too late");
    else if (!claim_.items.empty() && !is_observed_)
      demand(both(own_numbers_, system_.claim(claim_.items[1])),
             "a state that the certificate allows is what should never be");
    if (!is_about("deadlock-free") && !is_observed_) return;
    const expr is_stuck = no(system_.has_step()),
               may_stop = either(no(may_pass), either(system_.is_urgent(false), may_open)),
               is_locked = both(both(is_stuck, may_stop), no(must_resume));
    // What is waited for does not come after the end of a run.
    if (is_observed_) demand(both(is_locked, waits), "a state that the certificate allows ends before it comes");
    else demand(is_locked, "a state that the certificate allows locks time");
    if (limit_) return;
    // Where no step ever comes, time brings all clocks beyond any bound, in states that are listed, too. What waits for
    // something to come may not wait for steps that nothing forces.
    expr is_far =
        is_observed_ ? both(both(waits, passes), no(resumes)) : both(is_stuck, no(either(resumes, system_.is_final())));
    for (std::size_t a = 0; a < now.size(); ++a) {
      const AtomType& type = model_.type_of(a);
      for (std::size_t k = type.first_clock; k < type.first_clock + type.clocks.size(); ++k)
        is_far = both(is_far, now[a][k] > z3_.int_val(kFar));
    }
    demand(is_far, is_observed_ ? "time may go on for ever in a state that the certificate allows before it comes"
                                : "a state that the certificate allows has no step");
  }

  // With whom the atom goes on; none: it is not busy.
  [[nodiscard]] std::optional<int> leader_of(const State& now, std::size_t atom) const {
    const AtomType& type = model_.type_of(atom);
    if (!type.is_timed || is(equals(now[atom][type.waits], 0), true)) return std::nullopt;
    return value_of(now[atom][type.waits + 1]).value_or(0);
  }
  // A step after which the same request waits. Where time has passed since the last such one the rank falls; or an
  // action may return, which it does some time if that is so again and again.
  void comes_to_end(const expr& is_taken, State next, std::size_t rank, const expr& may_return) {
    const std::string otherwise = "steps that the certificate allows may go on for ever before it comes";
    expr& since = next.back()[model_.atom_types.back().first_clock];
    const expr is_later = (since >= z3_.int_val(*proof_.later)).simplify();
    stays(both(is_taken, no(is_later)), next, otherwise, rank);
    since = z3_.int_val(0);
    stays(both(is_taken, both(is_later, may_return)), next, otherwise, rank);
    falls(both(is_taken, both(is_later, no(may_return))), next, rank, otherwise);
  }
  // It stays, at a lower rank.
  void falls(const expr& when, const State& next, std::size_t rank, const std::string& otherwise) {
    if (rank == 0) demand(when, otherwise);
    else stays(when, next, otherwise, rank - 1);
  }

  // What the observer makes of a point: a state (`is_first`: of a run), or a step that leaves it.
  void observe(System& system, const State& at, const Step* step, State& next, const expr& is_first) {
    system.stand(at);
    const std::size_t last = claim_.items.size() - 1;
    const Tree &request = claim_.at(last - 1), &response = claim_.at(last);
    const expr asked = request.text == "first" && !request.is_list ? is_first : system.claim(request, step);
    const expr is_open = no(system.claim(response, step));
    expr &waits = next.back()[0], &since = next.back()[model_.atom_types.back().first_clock];
    since = choose(both(no(waits), both(asked, is_open)), z3_.int_val(0), since);
    waits = both(is_open, either(waits, asked));
  }

  // Where `when` holds, and the run does not end in an error, this is a listed state in one of its zones, of a rank of
  // at most `most`.
  void stays(const expr& when, const State& next, const std::string& otherwise,
             std::optional<std::size_t> most = std::nullopt) {
    const auto is_meant = [&](const Zone& zone) { return zone.rank <= most.value_or(zone.rank); };
    if (is(when, false)) return;
    std::u32string key = proof_.zones.begin()->first;
    std::map<std::size_t, Local> open;  // what need not be constant
    State told = next;
    for (std::size_t a = 0; a < next.size(); ++a) {
      for (std::size_t k = 0; k < next[a].size(); ++k) {
        if (!proof_.is_told[a][k]) continue;
        if (holds_number(a, k)) told[a][k] = number_told(next[a][k], 0, 1);
        if (!value_of(told[a][k])) open[a].push_back(told[a][k]);
      }
    }
    const auto check = [&](const expr& there, const std::map<std::size_t, Local>& solution) {
      bool is_listed = true;
      State there_is = next;
      for (std::size_t a = 0; a < next.size(); ++a) {
        // Nothing is said of it.
        if (!contains(proof_.is_told[a], true)) continue;
        Values values(next[a].size(), 0);
        for (std::size_t k = 0, at = 0; k < values.size(); ++k) {
          if (!proof_.is_told[a][k]) continue;
          const expr value = value_of(told[a][k]) ? told[a][k] : solution.at(a).at(at++);
          if (!holds_number(a, k)) there_is[a][k] = value;
          values[k] = value_of(value);
        }
        const auto row = proof_.row_of_local.find(values);
        if (row != proof_.row_of_local.end()) key[a] = row->second;
        else is_listed = false;
      }
      const bool has_zones = is_listed && proof_.zones.contains(key);
      const expr leaves = has_zones ? both(there, no(is_inside(key, next, is_meant))) : there;
      if (!terms_.may_be(leaves)) return;
      // Where a state ends with an error the run has no further point.
      if (is_about("error-free")) throw Rejected(otherwise);
      after_.look_at(there_is, false);
      demand(both(leaves, no(after_.state_fault())), otherwise);
    };
    if (open.empty()) return check(when, open);
    terms_.each_solution(when, open, [&](const std::map<std::size_t, Local>& solution) {
      expr there = when;
      for (const auto& [atom, values] : solution)
        for (std::size_t k = 0; k < values.size(); ++k) there = both(there, values[k] == open.at(atom)[k]);
      check(there, solution);
    });
  }
  // The clocks are in one of the state's zones that are meant.
  [[nodiscard]] expr is_inside(const std::u32string& key, const State& state, const auto& is_meant) const {
    return terms_.some(proof_.zones.at(key), [&](const Zone& zone) {
      if (!is_meant(zone)) return terms_.truth(false);
      return terms_.all(zone.bounds, [&](const Bound& b) {
        const auto value = [&](std::size_t atom, std::size_t clock) {
          return atom == kNone ? z3_.int_val(0) : state[atom][clock];
        };
        return (value(b.atom, b.clock) - value(b.other_atom, b.other_clock) <= z3_.int_val(b.limit)).simplify();
      });
    });
  }
  // Any three numbers that differ, of those that there are; the claim is about their own.
  void let_numbers() {
    if (pair_->numbers.empty()) return;
    for (std::size_t k = 0; k < 3; ++k) {
      numbers_.push_back(terms_.fresh("int"));
      for (const Tree* arg : pair_->args[k]) terms_.let(arg, numbers_[k]);
      own_numbers_ = both(own_numbers_, equals(numbers_[k], pair_->numbers[k]));
      terms_.assume(is_number(numbers_[k]));
      for (std::size_t j = 0; j < k; ++j) terms_.assume(numbers_[k] != numbers_[j]);
    }
  }
  [[nodiscard]] expr is_number(const expr& e) const {
    const auto [least, most] = std::ranges::minmax(pair_->numbers);
    if (std::int64_t{most} - least + 1 == static_cast<std::int64_t>(pair_->numbers.size()))
      return (e >= terms_.constant("int", least) && e <= terms_.constant("int", most)).simplify();
    return terms_.some(pair_->numbers, [&](int number) { return equals(e, number); });
  }
  [[nodiscard]] bool holds_number(std::size_t atom, std::size_t variable) const {
    return !numbers_.empty() && proof_.pair->holders.contains({atom, variable});
  }
  // As states say it of members `a` and `b`: their numbers are those of the first and the second one, all others that
  // of the third.
  [[nodiscard]] expr number_told(const expr& e, std::size_t a, std::size_t b) const {
    const std::vector<int>& all = pair_->numbers;
    if (const auto known = value_of(e); known && !contains(all, *known)) return e;
    const expr first = terms_.constant("int", all[0]), second = terms_.constant("int", all[1]),
               third = terms_.constant("int", all[2]);
    for (std::size_t k = 0; k < 3; ++k)
      if (z3::eq(e, numbers_[k])) return k == a ? first : k == b ? second : third;
    return choose((e == numbers_[a]).simplify(), first,
                  choose((e == numbers_[b]).simplify(), second, choose(is_number(e), third, e)));
  }
  // Turns the numbers of a listed state of the first two into unknowns, and restricts the third one: with each of the
  // two it is in a listed state, too.
  void look_at_third(State& now) {
    for (std::size_t a = 0; a < now.size(); ++a) {
      for (std::size_t k = 0; k < now[a].size(); ++k) {
        if (!holds_number(a, k)) continue;
        expr& value = now[a][k];
        const std::optional<int> told = value_of(value);
        for (std::size_t j = 0; j < 2; ++j) value = told == pair_->numbers[j] ? numbers_[j] : value;
        if (told != pair_->numbers[2]) continue;
        value = terms_.fresh("int");
        terms_.assume(both(is_number(value), value != numbers_[0] && value != numbers_[1]));
      }
    }
    Local& third = now[pair_->members[2]];
    const std::size_t waits = model_.type_of(pair_->members[2]).waits;
    if (model_.type_of(pair_->members[2]).is_timed) third[waits] = third[waits + 1] = terms_.constant("int", 0);
    for (std::size_t with = 0; with < 2; ++with) {
      for (const bool is_first : {true, false}) {
        const std::size_t a = is_first ? with : 2, b = is_first ? 2 : with;
        terms_.assume(terms_.some(proof_.zones, [&](const auto& listed) { return is_told(listed.first, now, a, b); }));
      }
    }
  }
  // Is that what the state is of members `a` and `b`, but for clocks?
  [[nodiscard]] expr is_told(const std::u32string& key, const State& now, std::size_t a, std::size_t b) const {
    expr result = terms_.truth(true);
    for (std::size_t atom = 0; atom < now.size() && !is(result, false); ++atom) {
      const std::size_t whose = atom == pair_->members[0]   ? pair_->members[a]
                                : atom == pair_->members[1] ? pair_->members[b]
                                                            : atom;
      for (std::size_t k = 0; k < now[whose].size(); ++k) {
        if (!proof_.is_told[atom][k]) continue;
        const expr value = holds_number(atom, k) ? number_told(now[whose][k], a, b) : now[whose][k];
        result = both(result, equals(value, *proof_.locals[key[atom]][k]));
      }
    }
    return result;
  }
  [[nodiscard]] static State replaced(State state, const std::map<std::size_t, Local>& others) {
    for (const auto& [atom, local] : others) state[atom] = local;
    return state;
  }
  [[nodiscard]] bool is_about(Text claim) const { return proof_.claim == claim; }
  // There is no state like that.
  void demand(const expr& bad, const std::string& otherwise) {
    if (terms_.may_be(bad)) throw Rejected(otherwise);
  }

  // Beyond all constants that a certificate should depend on. Any number would be right.
  static constexpr std::int64_t kFar = std::int64_t{1} << 62;
  static constexpr int kNobody = -1;

  const Model& model_;
  const Certificate& proof_;
  z3::context& z3_;
  const PairModel* pair_;
  Terms terms_{model_, z3_};
  System system_{model_, terms_}, after_{model_, terms_};
  Local numbers_;  // of the pair and the third one; none: there are no numbers
  expr own_numbers_ = terms_.truth(true);
  Tree claim_;
  bool is_observed_ = false;           // the claim is that something comes: the last atom observes
  std::optional<std::int64_t> limit_;  // within it
  bool has_open_ = false;
};

}  // namespace

void check_zones(const Model& model, const Certificate& certificate, z3::context& z, const PairModel* pair) {
  Zones(model, certificate, z, pair).run();
}

}  // namespace certcheck
