// The system over Z3 terms: which steps it has in a state, and what each leads to. A connector without guards has one
// configuration, the largest, as terms; of the others all are listed. Guards, maximal progress and priorities decide
// which are candidates.
#pragma once
#include <list>

#include "tools/certcheck/terms.hpp"

namespace certcheck {

using State = std::vector<Local>;  // by atom
struct Step {
  expr possible, offered, sure, fault;     // offered: whatever priorities hide; shorter; sure: by no chain of these
  std::size_t connector = kNone;           // kNone: of a port alone
  std::map<std::size_t, expr> parts;       // by node of a port: does it take part?
  std::map<std::size_t, Local> now, next;  // of the atoms that may move; what is known of them if the step is taken
};

/// Is what the leaf is about what happens: does the step have that connector, or does the port take part?
[[nodiscard]] expr happens(const Model& model, const Terms& terms, const Tree& leaf, std::size_t connector,
                           const std::map<std::size_t, expr>& parts);

class System {
 public:
  System(const Model& model, const Terms& terms) : model_(model), terms_(terms) {}

  /// The state that all else is said of: the enabled interactions, and, if wanted, what priorities hide.
  void look_at(const State& now, bool with_priorities) {
    offer(now);
    all_.clear();
    for (std::size_t node = 0; node < model_.nodes.size(); ++node)
      if (model_.nodes[node].is_step) add_candidates(node);
    Store store;
    std::vector<Rule> rules;
    for (const Tree* row : with_priorities ? model_.priorities : std::vector<const Tree*>()) {
      Scope reads;
      for (const Tree* of : (*row)["data"].all("of")) reads.bind.push_back(&data(*of, store));
      Rule& rule =
          rules.emplace_back(Rule{terms_.holds((*row)["guard"], reads, terms_.truth(true), state_fault_), {}, {}});
      for (const Candidate& c : all_) rule.low.push_back(matches(*row, "low", "high", c));
      for (const Candidate& c : all_) rule.high.push_back(matches(*row, "high", "low", c));
    }
    if (rules.empty()) return;
    // A chain goes through interactions that need not be enabled: here through those that are candidates' own, and for
    // connectors without guards through none, so that less is hidden than the engine hides and more steps are checked.
    Local on;
    for (const Candidate& c : all_) on.push_back(c.possible);
    for (std::size_t r = 0; r < rules.size(); ++r) {
      expr above = terms_.truth(can_lead_on(*model_.priorities[r]));
      for (std::size_t k = 0; k < on.size(); ++k) above = either(above, both(rules[r].high[k], on[k]));
      const expr hides = both(rules[r].guard, above);
      for (std::size_t k = 0; k < on.size(); ++k) all_[k].sure = both(all_[k].sure, no(both(hides, rules[r].low[k])));
    }
    (void)terms_.hide(rules, on);
    for (std::size_t k = 0; k < all_.size(); ++k) all_[k].possible = on[k];
  }
  /// The same without interactions: only what atoms offer.
  void offer(const State& now) {
    now_ = now;
    offers_.clear();
    on_.clear();
    state_fault_ = guard_fault_ = terms_.truth(false);
    for (std::size_t atom = 0; atom < model_.atoms.size(); ++atom) {
      offers_.push_back(terms_.offer(model_.type_of(atom), now_[atom], state_fault_));
      on_.insert(on_.end(), offers_[atom].ports.begin(), offers_[atom].ports.end());
    }
  }
  /// Is an interaction of the node possible, whatever priorities hide? All others are forgotten.
  [[nodiscard]] expr is_possible(std::size_t node) {
    all_.clear();
    add_candidates(node);
    return has_step();
  }
  /// The atoms that may take part in it.
  [[nodiscard]] std::set<std::size_t> atoms_of(std::size_t node) {
    std::set<std::size_t> atoms;
    for (std::size_t part : shape_of(node, false).tree)
      if (model_.nodes[part].kind == Kind::Port) atoms.insert(model_.atom_of_port[part]);
    return atoms;
  }
  /// Is there a step? Priorities only hide what something else outdoes.
  [[nodiscard]] expr has_step() const {
    return terms_.some(all_, [](const Candidate& c) { return c.offered; });
  }
  /// Is each atom at final places only?
  [[nodiscard]] expr is_final() const {
    expr final = terms_.truth(true);
    for (std::size_t atom = 0; atom < model_.atoms.size(); ++atom) final = both(final, is_final(atom));
    return final;
  }
  [[nodiscard]] expr is_final(std::size_t atom) const {
    expr final = terms_.truth(true);
    const AtomType& type = model_.type_of(atom);
    for (std::size_t place = 0; place < type.places; ++place)
      if (!contains(type.finals, place)) final = both(final, no(now_[atom][place]));
    return final;
  }
  /// Could the atom take a port, by itself, and has it not come to its end?
  [[nodiscard]] expr wants(std::size_t atom) const {
    const expr has_ended = model_.type_of(atom).finals.empty() ? terms_.truth(false) : is_final(atom);
    return both(terms_.some(offers_[atom].ports, [](const expr& port) { return port; }), no(has_ended));
  }
  /// All steps, one by one.
  void each_step(const std::function<void(const Step&)>& visit) {
    for (const Candidate& c : all_) {
      if (is(c.possible, false)) continue;
      Step step{c.possible, c.offered, c.sure, terms_.truth(false), model_.nodes[c.node].connector, {}, {}, {}};
      // What takes part in any case does so for sure.
      Candidate taken = c;
      for (auto& [node, is_in] : taken.chosen) is_in = z3::eq(is_in, c.chosen.at(c.node)) ? terms_.truth(true) : is_in;
      for (const auto& [node, is_in] : taken.chosen)
        if (model_.nodes[node].kind == Kind::Port) step.parts.emplace(node, is_in);
      fire(taken, c.node, terms_.truth(true), taken.store, step);
      resume(taken, step);
      visit(step);
    }
  }
  /// Does a candidate let no time pass: an eager one, or a delayable one that a tick later is not there any more? Of
  /// those that no priority hides for sure, or of all.
  [[nodiscard]] expr is_urgent(bool is_sure) const {
    return terms_.some(all_, [&](const Candidate& c) {
      const expr urgent = either(has(c, &Offer::eager), both(has(c, &Offer::delayable), has(c, &Offer::ends)));
      return both(is_sure ? c.sure : c.possible, urgent);
    });
  }
  /// Is there an eager candidate that a bound with `>` has let in at this instant?
  [[nodiscard]] expr opens(bool is_sure) const {
    return terms_.some(all_, [&](const Candidate& c) {
      return both(is_sure ? c.sure : c.possible, both(has(c, &Offer::eager), has(c, &Offer::opens)));
    });
  }
  /// What a claim says of the state.
  [[nodiscard]] expr claim(const Tree& e) {
    if (!Tree{true, false, {}, {e}}.find({"happens", "happens-port"}).empty())
      throw Rejected("a state does not happen");
    return claim(e, nullptr);
  }
  /// Of a point: the state alone, in which nothing happens, or with a step that leaves it.
  [[nodiscard]] expr claim(const Tree& e, const Step* step) {
    expr fault = terms_.truth(false);
    const auto leaf_of = [this, step](const Tree& leaf) {
      if (leaf.head() != "happens" && leaf.head() != "happens-port") return about(leaf);
      return step == nullptr ? terms_.truth(false) : happens(model_, terms_, leaf, step->connector, step->parts);
    };
    return terms_.evaluate(e, {{}, {}, leaf_of}, terms_.truth(true), fault);
  }
  /// The state that `claim` speaks of, if it does not say what can be done.
  void stand(const State& now) { now_ = now; }
  /// The run has ended with an error in this state; with one in a connector's guard, too.
  [[nodiscard]] expr state_fault() const { return state_fault_; }
  [[nodiscard]] expr guard_fault() const { return guard_fault_; }

 private:
  static constexpr std::size_t kMaxConfigurations = 1024;

  using Parts = std::set<std::size_t>;         // nodes that take part in a configuration
  using Chosen = std::map<std::size_t, expr>;  // by node of a connector's tree: does it take part?
  struct Store {
    std::map<std::size_t, Local> atoms, frames;  // by atom and by connector
    std::list<expr> any;                         // variables of merged ports of which none is known to take part
  };
  struct Candidate {
    std::size_t node = 0;
    Chosen chosen;
    Store store;
    expr possible, offered, sure;  // sure: whatever chains of priorities there are
  };
  /// The tree of a connector, or of a port alone, parents before children, and what is known of it whatever the state
  /// is.
  struct Shape {
    Rows tree;
    bool is_plain = false;   // its largest configurations, as terms, are all that matter
    std::vector<Parts> all;  // configurations
  };

  const Shape& shape_of(std::size_t node, bool wants_list) {
    Shape& shape = shapes_[node];
    if (shape.tree.empty()) {
      // Children have smaller rows, and so come later.
      std::set<std::size_t, std::greater<>> tree{node};
      for (std::size_t row : tree)
        for (const Edge& edge : model_.nodes[row].children) tree.insert(edge.node);
      shape.tree.assign(tree.begin(), tree.end());
      shape.is_plain = is_plain(shape.tree);
    }
    if (shape.all.empty() && (wants_list || !shape.is_plain)) list(node, shape.all);
    return shape;
  }
  // No guards, no errors, free choices at which no code looks. Free: any alternatives fit each other, for what two
  // children of a node share, ports and with alternatives atoms, they share as alternatives.
  [[nodiscard]] bool is_plain(const Rows& tree) const {
    const bool has_choice =
        std::any_of(tree.begin(), tree.end(), [&](std::size_t row) { return model_.nodes[row].kind == Kind::Any; });
    std::map<std::size_t, std::set<std::size_t>> below;
    for (auto row = tree.rbegin(); row != tree.rend(); ++row) {
      const Node& node = model_.nodes[*row];
      std::set<std::size_t>& mine = below[*row];
      if (node.kind == Kind::Port) mine.insert(has_choice ? model_.atom_of_port[*row] : *row);
      for (const Edge& edge : node.children) {
        for (std::size_t id : below[edge.node])
          if (!mine.insert(id).second && node.kind != Kind::Any) return false;
      }
      if (node.connector == kNone) continue;
      const Connector& c = model_.connectors[node.connector];
      const bool chooses = std::any_of(c.params.begin(), c.params.end(),
                                       [&](const Edge& edge) { return model_.nodes[edge.node].kind == Kind::Any; });
      for (const Clause& clause : c.clauses) {
        if ((!clause.guard->items.empty() && clause.guard->at(1).text != "true") ||
            !clause.up->find({"div", "mod", "call"}).empty())
          return false;
        if (chooses && clause.up->items.size() + clause.down->items.size() != 0) return false;
      }
    }
    return true;
  }
  void list(std::size_t row, std::vector<Parts>& out) const {
    const Node& node = model_.nodes[row];
    std::vector<std::pair<Parts, bool>> found{{{row}, node.kind == Kind::Port || node.kind == Kind::All}};
    for (const Edge& edge : node.children) {
      std::vector<Parts> inner;
      list(edge.node, inner);
      std::vector<std::pair<Parts, bool>> next;
      if (node.kind != Kind::All) next = found;
      for (const auto& [parts, is_good] : found) {
        if (node.kind == Kind::Any && parts.size() > 1) break;
        for (const Parts& more : inner) {
          Parts& with = next.emplace_back(parts, is_good || edge.is_trigger || node.kind == Kind::Any).first;
          with.insert(more.begin(), more.end());
          if (with.size() != parts.size() + more.size()) throw NotCheckable("a connector reaches a port in two ways");
        }
      }
      if (next.size() > kMaxConfigurations) throw NotCheckable("a connector has too many interactions");
      found = std::move(next);
    }
    for (auto& [parts, is_good] : found)
      if (is_good) out.push_back(std::move(parts));
  }
  static bool is_larger(const Parts& a, const Parts& b) {
    return a.size() > b.size() && std::includes(a.begin(), a.end(), b.begin(), b.end());
  }

  [[nodiscard]] Chosen choice_of(const Rows& tree, const Parts& parts) const {
    Chosen chosen;
    for (std::size_t row : tree) chosen.emplace(row, terms_.truth(parts.contains(row)));
    return chosen;
  }
  [[nodiscard]] Chosen largest(const Rows& tree) const {
    Chosen available, chosen;
    for (auto row = tree.rbegin(); row != tree.rend(); ++row) {
      const Node& node = model_.nodes[*row];
      expr can = node.kind == Kind::Port ? on_[*row] : terms_.truth(node.kind == Kind::All);
      for (const Edge& edge : node.children) {
        if (node.kind == Kind::All) can = both(can, available.at(edge.node));
        else if (edge.is_trigger || node.kind == Kind::Any) can = either(can, available.at(edge.node));
      }
      available.emplace(*row, can);
    }
    chosen.emplace(tree[0], available.at(tree[0]));
    for (std::size_t row : tree) {
      // Of alternatives that can, any one: the first that is liked, or the last.
      expr open = chosen.at(row);
      const std::vector<Edge>& children = model_.nodes[row].children;
      for (auto edge = children.begin(); edge != children.end(); ++edge) {
        expr joins = model_.nodes[row].kind == Kind::Trigger ? both(open, available.at(edge->node)) : open;
        if (model_.nodes[row].kind == Kind::Any) {
          expr others = terms_.truth(false);
          for (auto other = edge + 1; other != children.end(); ++other)
            others = either(others, available.at(other->node));
          joins = both(open, both(available.at(edge->node), either(no(others), terms_.fresh("bool"))));
          open = both(open, no(joins));
        }
        const auto [at, is_new] = chosen.emplace(edge->node, joins);
        if (!is_new) at->second = either(at->second, joins);
      }
    }
    return chosen;
  }

  void add_candidates(std::size_t node) {
    const Shape& shape = shape_of(node, false);
    const std::size_t first = all_.size(), count = shape.is_plain ? 1 : shape.all.size();
    for (std::size_t k = 0; k < count; ++k) {
      Candidate& c =
          all_.emplace_back(Candidate{node, {}, {}, terms_.truth(false), terms_.truth(false), terms_.truth(false)});
      c.chosen = shape.is_plain ? largest(shape.tree) : choice_of(shape.tree, shape.all[k]);
      c.offered = c.possible = enabled(shape.tree, !shape.is_plain, c.chosen, c.store);
    }
    // Maximal progress: nothing larger is enabled.
    for (std::size_t k = 0; k < count && !shape.is_plain; ++k) {
      for (std::size_t j = 0; j < count; ++j) {
        if (is_larger(shape.all[j], shape.all[k]))
          all_[first + k].possible = both(all_[first + k].possible, no(all_[first + j].offered));
      }
    }
    const std::size_t connector = model_.nodes[node].connector;
    const bool is_cut = connector != kNone && model_.connectors[connector].is_cut;
    for (std::size_t k = 0; k < count; ++k) {
      all_[first + k].offered = all_[first + k].possible;
      all_[first + k].sure = is_cut ? terms_.truth(false) : all_[first + k].possible;
    }
  }
  // Does a port that takes part have that?
  [[nodiscard]] expr has(const Candidate& c, Local Offer::*what) const {
    return terms_.some(c.chosen, [&](const auto& part) {
      if (model_.nodes[part.first].kind != Kind::Port) return terms_.truth(false);
      const std::size_t atom = model_.atom_of_port[part.first];
      return both(part.second, (offers_[atom].*what)[part.first - model_.first_port[atom]]);
    });
  }
  // May a chain go on from what the rule has as high: is that low in another one?
  [[nodiscard]] bool can_lead_on(const Tree& rule) const {
    const Tree& high = rule["high"];
    return std::any_of(model_.priorities.begin(), model_.priorities.end(), [&](const Tree* other) {
      const Tree& low = (*other)["low"];
      return high.at(1).text == "any" || low.at(1).text == "any" || high.at(1).row() == low.at(1).row();
    });
  }
  // `waits` says which transition each atom took: now whether it is busy after that, and with whom it goes on.
  void resume(const Candidate& c, Step& step) const {
    const std::size_t connector = model_.nodes[c.node].connector;
    const bool is_sync = connector != kNone && model_.connectors[connector].is_sync;
    std::map<std::size_t, expr> takes_part, resumes;
    for (const auto& [node, is_in] : c.chosen) {
      if (model_.nodes[node].kind != Kind::Port || !model_.type_of(model_.atom_of_port[node]).is_timed ||
          is(is_in, false))
        continue;
      const std::size_t atom = model_.atom_of_port[node];
      if (!step.next.contains(atom)) continue;
      const AtomType& type = model_.type_of(atom);
      expr waits_for = terms_.truth(false);
      for (std::size_t t = 0; t < type.transitions.size(); ++t)
        if (!type.transitions[t].resume->items.empty())
          waits_for = either(waits_for, equals(step.next.at(atom)[type.waits], static_cast<int>(t) + 1));
      takes_part.emplace(atom, is_in);
      resumes.emplace(atom, both(is_in, waits_for));
    }
    expr leader = terms_.constant("int", 0);
    for (auto part = takes_part.rbegin(); part != takes_part.rend(); ++part)
      leader = choose(part->second, terms_.constant("int", static_cast<int>(part->first)), leader);
    const expr any = terms_.some(resumes, [](const auto& part) { return part.second; });
    for (const auto& [atom, is_in] : takes_part) {
      const std::size_t waits = model_.type_of(atom).waits;
      const expr is_busy = is_sync ? any : resumes.at(atom), none = terms_.constant("int", 0);
      Local& next = step.next.at(atom);
      const expr with = is_sync ? leader : terms_.constant("int", static_cast<int>(atom));
      next[waits + 1] = choose(is_in, choose(is_busy, with, none), now_[atom][waits + 1]);
      next[waits] = choose(is_in, choose(is_busy, next[waits], none), now_[atom][waits]);
    }
  }
  // Do ports, guards and the largest configurations of inner connectors allow it? Computes what is passed upwards.
  [[nodiscard]] expr enabled(const Rows& tree, bool is_listed, const Chosen& chosen, Store& store) {
    expr result = chosen.at(tree[0]);
    for (std::size_t row : tree)
      if (model_.nodes[row].kind == Kind::Port && is(chosen.at(row), true)) result = both(result, on_[row]);
    const expr there = result;
    // Inner connectors first: what they compute is read above.
    for (auto row = tree.rbegin(); row != tree.rend(); ++row) {
      const std::size_t connector = model_.nodes[*row].connector;
      if (connector == kNone || is(chosen.at(*row), false)) continue;
      const Connector& c = model_.connectors[connector];
      Local& frame = store.frames[connector];
      for (Text variable : c.variables)
        frame.push_back(is_exact(variable) ? terms_.constant(variable, 0) : terms_.fresh(variable));
      for (const Clause& clause : c.clauses) {
        const expr is_taken = clause_is(c, clause, chosen);
        if (is(is_taken, false) || clause.guard->items.size() + clause.up->items.size() == 0) continue;
        const Scope read = scope_of(connector, chosen, store);
        expr fault = terms_.truth(false), holds = terms_.holds(*clause.guard, read, is_taken, fault);
        terms_.execute(*clause.up, read, is_taken, fault);
        if (!is(fault, false)) {
          guard_fault_ = either(guard_fault_, both(there, fault));
          holds = z3::ite(fault, terms_.fresh("bool"), holds);
        }
        result = both(result, either(no(is_taken), holds));
      }
    }
    // Where only the largest configurations of an inner connector are seen, none that is larger there is enabled.
    for (std::size_t row : is_listed ? tree : Rows()) {
      for (const Edge& edge : model_.nodes[row].children) {
        if (!edge.is_maximal || is(chosen.at(edge.node), false)) continue;
        const Shape& inner = shape_of(edge.node, true);
        Parts own;
        std::copy_if(inner.tree.begin(), inner.tree.end(), std::inserter(own, own.end()),
                     [&](std::size_t part) { return is(chosen.at(part), true); });
        for (const Parts& larger : inner.all) {
          Store other;
          if (is_larger(larger, own))
            result = both(result, no(enabled(inner.tree, true, choice_of(inner.tree, larger), other)));
        }
      }
    }
    return result;
  }

  [[nodiscard]] expr clause_is(const Connector& c, const Clause& clause, const Chosen& chosen) const {
    expr is_taken = chosen.at(c.root);
    for (std::size_t p = 0; p < c.params.size(); ++p) {
      const expr& part = chosen.at(c.params[p].node);
      is_taken = both(is_taken, contains(clause.params, p) ? part : no(part));
    }
    return is_taken;
  }
  Local& local_of(std::size_t atom, Store& store) { return store.atoms.try_emplace(atom, now_.at(atom)).first->second; }
  // (of ATOM VARIABLE)
  expr& data(const Tree& of, Store& store) {
    const std::size_t atom = of.at(1).row();
    return local_of(atom, store).at(model_.type_of(atom).places + of.at(2).row());
  }
  // `bind` of a connector: the variables of its ports, one after the other, then data of the compound.
  Scope scope_of(std::size_t connector, const Chosen& chosen, Store& store) {
    const Connector& c = model_.connectors[connector];
    Scope scope{store.frames.at(connector), {}, {}};
    for (const auto& [param, variable, type] : c.bound) {
      std::size_t row = c.params[param].node;
      if (model_.nodes[row].kind == Kind::Any) {
        const std::vector<Edge>& of = model_.nodes[row].children;
        const auto taken =
            std::find_if(of.begin(), of.end(), [&](const Edge& edge) { return is(chosen.at(edge.node), true); });
        row = taken == of.end() ? kNone : model_.nodes[taken->node].children[0].node;
      }
      const std::size_t inner = row == kNone ? kNone : model_.nodes[row].connector;
      const auto frame = store.frames.find(inner);
      if (row == kNone || (inner != kNone && frame == store.frames.end()))
        scope.bind.push_back(&store.any.emplace_back(terms_.fresh(type)));
      else if (inner != kNone) scope.bind.push_back(&frame->second.at(model_.connectors[inner].exported.at(variable)));
      else
        scope.bind.push_back(&local_of(model_.atom_of_port.at(row), store).at(model_.port(row).variables.at(variable)));
    }
    for (const Tree* of : c.data->all("of")) scope.bind.push_back(&data(*of, store));
    return scope;
  }

  // Does the candidate match that side of the rule? The sides are `low` and `high`.
  [[nodiscard]] expr matches(const Tree& rule, Text side, Text other_side, const Candidate& c) const {
    const Tree &pattern = rule[side], &other = rule[other_side];
    const std::size_t connector = model_.nodes[c.node].connector;
    if (pattern.at(1).text == "any") {
      if (connector == kNone || model_.connectors[connector].compound != rule["in"].at(1).row())
        return terms_.truth(false);
      return other.at(1).text == "any" ? terms_.truth(true) : no(matches(rule, other_side, side, c));
    }
    if (pattern.at(1).row() != connector) return terms_.truth(false);
    expr result = terms_.truth(true);
    if (pattern.at(2).text == "any") return result;
    const Rows named = pattern.rows();
    const std::vector<Edge>& params = model_.connectors[connector].params;
    for (std::size_t p = 0; p < params.size(); ++p) {
      const bool is_named = contains(std::span(named).subspan(1), p);
      const expr& is_chosen = c.chosen.at(params[p].node);
      if ((side == "high") == is_named) result = both(result, is_named ? is_chosen : no(is_chosen));
    }
    return result;
  }
  // Of a connector the `down`s from the outside in, then the ports in the order of parameters.
  void fire(const Candidate& candidate, std::size_t node, const expr& when, Store& store, Step& step) {
    if (is(when, false)) return;
    if (model_.nodes[node].connector == kNone) {
      const std::size_t atom = model_.atom_of_port.at(node);
      Local& local = local_of(atom, store);
      Local& now = step.now.try_emplace(atom, now_[atom]).first->second;
      terms_.fire(model_.type_of(atom), offers_[atom], node - model_.first_port[atom], now, local, when, step.fault);
      step.next.insert_or_assign(atom, local);
      return;
    }
    const Connector& c = model_.connectors[model_.nodes[node].connector];
    for (const Clause& clause : c.clauses) {
      if (clause.down->items.empty()) continue;
      terms_.execute(*clause.down, scope_of(model_.nodes[node].connector, candidate.chosen, store),
                     clause_is(c, clause, candidate.chosen), step.fault);
    }
    // A port may be chosen below another alternative.
    const auto part = [&](std::size_t chosen, std::size_t row) {
      fire(candidate, row, both(candidate.chosen.at(node), candidate.chosen.at(chosen)), store, step);
    };
    for (const Edge& edge : c.params) {
      if (model_.nodes[edge.node].kind != Kind::Any) part(edge.node, edge.node);
      else
        for (const Edge& child : model_.nodes[edge.node].children)
          part(child.node, model_.nodes[child.node].children[0].node);
    }
  }
  // (at PATH PLACE), (data PATH VARIABLE), (can-port PATH PORT), (can CONNECTOR)
  expr about(const Tree& e) {
    const Text what = e.head(), path = e.at(1).text;
    if (what == "can") {
      const std::size_t root = model_.connectors[row_of(model_.connectors, path, &Connector::path)].root;
      // Which chains of priorities there are may be unclear: then it is any value.
      const auto some = [&](expr Candidate::*is) {
        return terms_.some(all_, [&](const Candidate& c) { return c.node == root ? c.*is : terms_.truth(false); });
      };
      const expr may = some(&Candidate::possible), must = some(&Candidate::sure);
      return z3::eq(may, must) ? may : either(must, both(may, terms_.fresh("bool")));
    }
    const std::size_t atom = row_of(model_.atoms, path, &Atom::path);
    const AtomType& type = model_.type_of(atom);
    if (what == "can-port") return on_[model_.first_port[atom] + row_of(type.ports, e.at(2).text, &Port::name)];
    return now_[atom].at(type.find(e.at(2).text, what == "at"));
  }

  const Model& model_;
  const Terms& terms_;
  std::map<std::size_t, Shape> shapes_;  // by node
  State now_;
  std::vector<Offer> offers_;
  Local on_;  // by port
  std::vector<Candidate> all_;
  expr state_fault_ = terms_.truth(false), guard_fault_ = state_fault_;
};

}  // namespace certcheck
