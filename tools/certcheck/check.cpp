// Local states closed under what atoms do; reachable ones closed under steps; sets marked at first and kept by steps; and, by
// Z3, no state of all that without a sure step. Steps are judged bottom up on the connectors' trees: which choices can
// a subtree make, of those that put nothing into the set, and does one of them take something out?
#include "tools/certcheck/check.hpp"

#include <algorithm>

#include <z3++.h>

#include "tools/certcheck/certificate.hpp"
#include "tools/certcheck/induction.hpp"

namespace certcheck {

namespace {

class Checker {
 public:
  explicit Checker(const Model& model) : m_(model) {}

  std::string run(const std::string& text) {
    const Certificate certificate = read_certificate(m_, text);
    classes_ = certificate.classes;
    class_of_ = certificate.class_of;
    reachable_ = certificate.reachable;
    sets_ = certificate.sets;
    if (!classes_.empty()) {
      check_locally();
      check_reachability();
      for (const Set& set : sets_) check_set(set);
    }
    if (certificate.is_induction) {
      check_induction(m_, certificate);
      return std::to_string(m_.atoms.size()) + " components, " + std::to_string(sets_.size()) + " invariants, " + std::to_string(certificate.facts.size()) + " ranges and lemmas";
    }
    try {
      check_steps();
    } catch (const Rejected&) {
      // What is sure is judged coarsely above, by port and mode. Exactly, then.
      check_induction(m_, certificate);
    }
    return std::to_string(m_.atoms.size()) + " components, " + std::to_string(sets_.size()) + " invariants";
  }

 private:
  // ---- atoms
  void check_locally() {
    for (Class& row : classes_) {
      const AtomType& type = m_.atom_types[row.type];
      row.moves.resize(type.exported.size());
      for (std::size_t from = 0; from < row.states.size(); ++from) {
        for (std::size_t port = 0; port < type.exported.size(); ++port) {
          for (const LocalState& next : m_.after(type, row.states[from], port, row.followed)) {
            const auto to = row.numbers.find(next);
            if (to == row.numbers.end()) throw Rejected("a mode of `" + type.name + "` leads to one that is not listed");
            row.moves[port].emplace_back(from, to->second);
          }
        }
      }
    }
    std::map<std::pair<std::size_t, std::string>, std::set<std::size_t>> starts;
    for (std::size_t atom = 0; atom < m_.atoms.size(); ++atom) {
      const Class& row = classes_[class_of_[atom]];
      std::string key;
      for (const Tree* arg : m_.atoms[atom].args) key += arg->text + '\n';
      const auto [found, is_new] = starts.try_emplace({class_of_[atom], key});
      if (is_new) {
        for (const LocalState& state : m_.initial_states(m_.atoms[atom], row.followed)) {
          const auto number = row.numbers.find(state);
          if (number == row.numbers.end()) throw Rejected("`" + m_.atoms[atom].path + "` starts in a mode that is not listed");
          found->second.insert(number->second);
        }
      }
      initial_.push_back(found->second);
      for (std::size_t state : found->second) {
        if (!reachable_[atom].contains(state)) throw Rejected("`" + m_.atoms[atom].path + "` starts in a mode that is not among the reachable ones");
      }
    }
  }

  [[nodiscard]] const std::vector<std::pair<std::size_t, std::size_t>>& moves(std::size_t port) const {
    const std::size_t atom = m_.atom_of_port[port];
    return classes_[class_of_[atom]].moves[port - m_.first_port[atom]];
  }

  // ---- what can take part in a step at all, and that steps stay within the reachable modes
  void check_reachability() {
    possible_.assign(m_.nodes.size(), false);
    used_.assign(m_.nodes.size(), false);
    for (std::size_t row = 0; row < m_.nodes.size(); ++row) {
      const Node& node = m_.nodes[row];
      if (node.kind == Kind::Port) {
        for (const auto& [from, to] : moves(row)) possible_[row] = possible_[row] || reachable_[m_.atom_of_port[row]].contains(from);
        continue;
      }
      bool all = true, any = false;
      for (const auto& [child, trigger] : node.children) {
        all = all && possible_[child];
        any = any || (possible_[child] && (node.kind == Kind::Any || trigger));
      }
      possible_[row] = node.kind == Kind::All ? all : any;
    }
    for (std::size_t row = m_.nodes.size(); row-- > 0;) {
      const Node& node = m_.nodes[row];
      used_[row] = (used_[row] || node.is_step) && possible_[row];
      if (!used_[row]) continue;
      for (const auto& [child, trigger] : node.children) used_[child] = true;
      if (node.kind != Kind::Port) continue;
      const std::size_t atom = m_.atom_of_port[row];
      for (const auto& [from, to] : moves(row)) {
        if (reachable_[atom].contains(from) && !reachable_[atom].contains(to)) {
          throw Rejected("`" + m_.atoms[atom].path + "` can reach a mode that is not among the reachable ones");
        }
      }
    }
  }

  // ---- sets
  struct Effect {
    bool quiet = false;   // a choice in which nobody puts anything into the set
    bool takes = false;   // such a choice in which somebody takes something out
    long low = 0, high = 0;  // by how much a choice changes the sum, at least and at most
  };

  void check_set(const Set& set) {
    const auto weight = [&](std::size_t atom, std::size_t state) -> long {
      const auto at = std::lower_bound(set.members.begin(), set.members.end(), std::pair(atom, state));
      return at != set.members.end() && *at == std::pair(atom, state) ? set.weights[static_cast<std::size_t>(at - set.members.begin())] : 0;
    };
    std::set<std::size_t> atoms, touched;
    for (const auto& [atom, state] : set.members) atoms.insert(atom);
    long sum = 0;
    for (std::size_t atom : atoms) {
      std::set<long> first;
      for (std::size_t state : initial_[atom]) first.insert(weight(atom, state));
      if (first.size() > 1 && !set.is_trap) throw Rejected(set.text + ": not surely the total at first");
      if (!first.empty()) sum += *first.begin();
      for (std::size_t port = m_.first_port[atom]; port < m_.first_port[atom + 1]; ++port) touched.insert(port);
    }
    if (set.is_trap ? sum == 0 : sum != set.total) throw Rejected(set.text + ": not marked at first as it should be");
    std::map<std::size_t, Effect> effects;
    while (!touched.empty()) {
      // Children have smaller rows than parents.
      const std::size_t row = *touched.begin();
      touched.erase(touched.begin());
      const Node& node = m_.nodes[row];
      if (!used_[row]) continue;
      Effect effect;
      if (node.kind == Kind::Port) {
        const std::size_t atom = m_.atom_of_port[row];
        bool is_first = true;
        for (const auto& [from, to] : moves(row)) {
          if (!reachable_[atom].contains(from)) continue;
          const long was = weight(atom, from), is = weight(atom, to);
          effect.quiet = effect.quiet || is == 0;
          effect.takes = effect.takes || (was != 0 && is == 0);
          const long change = is - was;
          effect.low = is_first ? change : std::min(effect.low, change);
          effect.high = is_first ? change : std::max(effect.high, change);
          is_first = false;
        }
      } else {
        effect = combine(node, effects);
      }
      effects[row] = effect;
      if (node.is_step && set.is_trap && effect.takes) throw Rejected(set.text + ": a step takes the last token out of the trap");
      if (node.is_step && !set.is_trap && (effect.low != 0 || effect.high != 0)) throw Rejected(set.text + ": a step changes the sum");
      touched.insert(node.parents.begin(), node.parents.end());
    }
  }
  Effect combine(const Node& node, const std::map<std::size_t, Effect>& effects) const {
    Effect result;
    bool all_quiet = true, any_takes = false, quiet_trigger = false, taking_trigger = false;
    bool is_first = true;
    std::size_t live = 0;
    for (const auto& [child, trigger] : node.children) live += possible_[child] ? 1 : 0;
    for (const auto& [child, trigger] : node.children) {
      if (!possible_[child]) continue;
      const auto found = effects.find(child);
      const Effect effect = found == effects.end() ? Effect{true, false, 0, 0} : found->second;
      all_quiet = all_quiet && effect.quiet;
      any_takes = any_takes || effect.takes;
      quiet_trigger = quiet_trigger || (trigger && effect.quiet);
      taking_trigger = taking_trigger || (trigger && effect.takes);
      if (node.kind == Kind::Any) {
        result.quiet = result.quiet || effect.quiet;
        result.takes = result.takes || effect.takes;
        result.low = is_first ? effect.low : std::min(result.low, effect.low);
        result.high = is_first ? effect.high : std::max(result.high, effect.high);
      } else {
        const bool must = node.kind == Kind::All || live == 1;
        result.low += must ? effect.low : std::min(effect.low, 0L);
        result.high += must ? effect.high : std::max(effect.high, 0L);
      }
      is_first = false;
    }
    if (node.kind == Kind::All) {
      result.quiet = all_quiet;
      result.takes = all_quiet && any_takes;
    } else if (node.kind == Kind::Trigger) {
      result.quiet = quiet_trigger;
      result.takes = taking_trigger || (quiet_trigger && any_takes);
    }
    return result;
  }

  // ---- a state of all that has a step
  void check_steps() {
    z3::context z;
    z3::solver solver(z);
    std::vector<std::map<std::size_t, z3::expr>> marked(m_.atoms.size());
    const auto exactly_one = [&](const z3::expr_vector& all) {
      solver.add(z3::mk_or(all));
      if (all.size() > 1) solver.add(z3::atmost(all, 1));
    };
    for (std::size_t atom = 0; atom < m_.atoms.size(); ++atom) {
      z3::expr_vector all(z);
      for (std::size_t state : reachable_[atom]) {
        const std::string name = std::to_string(atom) + ":" + std::to_string(state);
        all.push_back(marked[atom].emplace(state, z.bool_const(name.c_str())).first->second);
      }
      exactly_one(all);
    }
    for (const Set& set : sets_) {
      solver.add(satisfied(set, z, marked));
    }
    std::vector<z3::expr> sure;
    for (std::size_t row = 0; row < m_.nodes.size(); ++row) {
      const Node& node = m_.nodes[row];
      z3::expr_vector parts(z);
      if (node.kind == Kind::Port) {
        for (const auto& [state, variable] : marked[m_.atom_of_port[row]]) {
          if (is_sure(row, state)) parts.push_back(variable);
        }
        sure.push_back(z3::mk_or(parts));
      } else {
        const bool has_guards = node.connector_type != nullptr && guarded(*node.connector_type, nullptr);
        for (std::size_t k = 0; k < node.children.size(); ++k) {
          const auto& [child, trigger] = node.children[k];
          if (node.kind == Kind::Trigger && !trigger) continue;
          if (has_guards && !is_free_alone(node, k)) continue;
          parts.push_back(sure[child]);
        }
        if (has_guards && node.kind == Kind::All) sure.push_back(guarded_rendezvous(z, node, marked, sure));
        else sure.push_back(node.kind == Kind::All ? z3::mk_and(parts) : z3::mk_or(parts));
      }
      if (node.is_step) solver.add(!sure.back());
    }
    const z3::check_result answer = solver.check();
    if (answer == z3::sat) throw Rejected("the invariants allow a state without a sure step");
    if (answer != z3::unsat) throw NotCheckable("the solver gives up");
  }
  [[nodiscard]] bool is_sure(std::size_t port, std::size_t state) const {
    const std::size_t atom = m_.atom_of_port[port];
    const Class& row = classes_[class_of_[atom]];
    return m_.is_sure(m_.atom_types[row.type], row.states[state], port - m_.first_port[atom]);
  }
  // Does a clause (for these params, if given) have a guard that is not simply true?
  [[nodiscard]] bool guarded(const Tree& type, const std::vector<std::size_t>* params) const {
    for (const Tree& item : type.items) {
      if (item.head() != "clause") continue;
      const Tree* guard = item.find("guard");
      if (guard == nullptr || m_.evaluate(guard->items.at(1), {}, {}) == Value{true, 1}) continue;
      if (params == nullptr) return true;
      const Tree* own = item.find("params");
      bool same = own != nullptr && own->items.size() == params->size() + 1;
      for (std::size_t k = 0; same && k < params->size(); ++k) same = own->items[k + 1].row() == (*params)[k];
      if (same) return true;
    }
    return false;
  }
  // A trigger that is a parameter, alone, without guard.
  [[nodiscard]] bool is_free_alone(const Node& node, std::size_t k) const {
    if (node.kind != Kind::Trigger) return false;
    const Tree& group = node.connector_type->find("define")->items.at(1);
    const Tree& child = group.items.at(1 + k);
    if (child.items.at(1).is_list) return false;
    const std::vector<std::size_t> alone{child.items[1].row()};
    return !guarded(*node.connector_type, &alone);
  }

  // Everybody is sure, and the guard is true for the values of the modes.
  z3::expr guarded_rendezvous(z3::context& z, const Node& node, const std::vector<std::map<std::size_t, z3::expr>>& marked,
                              const std::vector<z3::expr>& sure) const {
    const Connector& connector = m_.connectors[node.connector];
    const Tree& type = *node.connector_type;
    const z3::expr no = z.bool_val(false);
    const Tree* guard = nullptr;
    std::size_t clauses = 0, params = 0;
    for (const Tree& item : type.items) {
      if (item.head() == "param") ++params;
      if (item.head() != "clause") continue;
      ++clauses;
      const Tree* own = item.find("params");
      if (own != nullptr && own->items.size() == connector.ports->items.size() && item.find("guard") != nullptr) guard = &item.find("guard")->items.at(1);
    }
    if (clauses != 1 || guard == nullptr || node.children.size() != params) return no;
    std::vector<std::pair<std::size_t, std::size_t>> sources;  // atom, slot
    std::vector<std::size_t> ports;
    for (std::size_t k = 1; k < connector.ports->items.size(); ++k) {
      const Tree& b = connector.ports->items[k];
      if (b.head() != "atom") return no;
      const std::size_t atom = b.items.at(1).row(), port = b.items.at(2).row();
      ports.push_back(m_.first_port.at(atom) + port);
      for (std::size_t slot : m_.atom_types[m_.atoms[atom].type].port_slots.at(port)) sources.emplace_back(atom, slot);
    }
    for (std::size_t k = 1; connector.data != nullptr && k < connector.data->items.size(); ++k) {
      const Tree& d = connector.data->items[k];
      sources.emplace_back(d.items.at(1).row(), d.items.at(2).row());
    }
    std::set<std::size_t> read;
    std::vector<const Tree*> todo{guard};
    while (!todo.empty()) {
      const Tree& e = *todo.back();
      todo.pop_back();
      for (const Tree& item : e.items) {
        if (item.is_list) todo.push_back(&item);
      }
      if (e.head() == "bind") read.insert(sources.at(e.items.at(1).row()).first);
    }
    const std::vector<std::size_t> atoms(read.begin(), read.end());
    std::size_t combinations = 1;
    for (std::size_t atom : atoms) {
      combinations *= marked[atom].size();
      if (combinations > 1000000) return no;
    }
    z3::expr_vector cases(z);
    for (std::size_t number = 0; number < combinations; ++number) {
      std::map<std::size_t, std::size_t> state_of;
      std::size_t rest = number;
      z3::expr_vector together(z);
      for (std::size_t atom : atoms) {
        auto at = marked[atom].begin();
        std::advance(at, static_cast<long>(rest % marked[atom].size()));
        rest /= marked[atom].size();
        state_of[atom] = at->first;
        together.push_back(at->second);
      }
      std::vector<Value> bind;
      for (const auto& [atom, slot] : sources) {
        bind.push_back(state_of.contains(atom) ? classes_[class_of_[atom]].states[state_of[atom]].values.at(slot) : Value{});
      }
      if (m_.evaluate(*guard, {}, bind) == Value{true, 1}) cases.push_back(z3::mk_and(together));
    }
    z3::expr_vector all(z);
    for (std::size_t port : ports) all.push_back(sure[port]);
    all.push_back(z3::mk_or(cases));
    return z3::mk_and(all);
  }

  const Model& m_;
  std::vector<Class> classes_;
  std::vector<std::size_t> class_of_;             // by atom
  std::vector<std::set<std::size_t>> reachable_;  // by atom: its reachable modes
  std::vector<std::set<std::size_t>> initial_;
  std::vector<Set> sets_;
  std::vector<bool> possible_, used_;             // by node
};

}  // namespace

std::string check(const Model& model, const std::string& certificate) { return Checker(model).run(certificate); }

}  // namespace certcheck
