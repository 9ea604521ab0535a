// Modes, the reachable ones, and sets of them. First atoms alone, in an environment that may do anything: what they begin in and what
// each port leads to are modes of their class. One that fits is enough, one that the components can be in is preferred; where values
// are not known, Z3 tells which modes can be met and that there is no other way. Then reachable modes are closed under steps, sets are
// marked at first and kept by steps: judged bottom up on the connectors' trees, without listing interactions, by what a subtree's
// choices can do to the set.
#include <algorithm>

#include "tools/certcheck/check.hpp"
#include "tools/certcheck/terms.hpp"

namespace certcheck {

namespace {

/// From which mode to which.
using Moves = std::vector<std::pair<std::size_t, std::size_t>>;
using Modes = std::set<std::size_t>;
/// What a choice does to a trap: nothing (0), take from it (1), put into it (2), of parts the most; to a sum: by how much it changes it.
using Effects = std::set<long>;

class Structure {
 public:
  Structure(const Model& model, const Certificate& certificate) : m_(model), c_(certificate), terms_(model, z_) {}

  void run() {
    check_modes();
    check_reachable();
    for (const Set& set : c_.sets) check_set(set);
  }

 private:
  // Components of one class that can be in the same modes are a group: modes may overlap, and which one a move meets is judged for those.
  void check_modes() {
    std::map<std::pair<std::size_t, Modes>, std::size_t> groups;
    std::map<std::pair<std::size_t, std::string>, Modes> starts;
    for (std::size_t atom = 0; atom < m_.atoms.size(); ++atom) {
      const Class& row = c_.classes[c_.class_of[atom]];
      const Modes& reachable = c_.reachable[atom];
      const auto [group, is_new] = groups.try_emplace({c_.class_of[atom], reachable}, groups.size());
      if (is_new) by_port_.push_back(moves(row, reachable));
      group_of_.push_back(group->second);
      std::string args;
      for (const Tree& arg : m_.atoms[atom].args->items) args.append(arg.text) += '\n';
      const auto [start, is_other] = starts.try_emplace({group->second, args});
      const std::string path = '`' + std::string(m_.atoms[atom].path) + '`';
      if (is_other) {
        z3::expr fault = terms_.truth(false);
        const Local local = terms_.initial(m_.atoms[atom], fault);
        start->second = met(row, reachable, local, no(fault), "the beginning of " + path + " leads");
      }
      first_.push_back(start->second);
      if (!std::includes(reachable.begin(), reachable.end(), start->second.begin(), start->second.end())) {
        throw Rejected(path + " starts in a mode that is not among the reachable ones");
      }
    }
  }

  std::vector<Moves> moves(const Class& row, const Modes& reachable) {
    const AtomType& type = m_.atom_types[row.type];
    std::vector<Moves> by_port(type.ports.size());
    for (std::size_t from = 0; from < row.modes.size(); ++from) {
      Local local;
      for (std::size_t k = 0; k < type.variables.size(); ++k) {
        const std::optional<int> value = row.modes[from][k];
        local.push_back(value ? terms_.constant(type.variables[k].type, *value) : terms_.fresh(type.variables[k].type));
      }
      z3::expr fault = terms_.truth(false);
      const Offer offer = terms_.offer(type, local, fault);
      for (std::size_t t = 0; t < type.transitions.size(); ++t) {
        const std::size_t port = type.transitions[t].port;
        const z3::expr on = port == kNone ? fault : both(offer.ports[port], offer.transitions[t]);
        if (port == kNone || is(on, false)) continue;
        Local next = local;
        for (std::size_t variable : type.ports[port].written) next[variable] = terms_.fresh(type.variables[variable].type);
        z3::expr ends = terms_.truth(false);
        terms_.take(type, type.transitions[t], next, on, ends);
        for (std::size_t to : met(row, reachable, next, both(on, no(ends)), "a mode of `" + std::string(type.name) + "` leads")) by_port[port].emplace_back(from, to);
      }
    }
    return by_port;
  }

  // Where it is clear what is marked, values that are no constants are left open.
  Modes met(const Class& row, const Modes& reachable, const Local& local, z3::expr other, const std::string& what) {
    Values clear(local.size());
    for (std::size_t k = 0; k < local.size(); ++k) clear[k] = row.followed[k] ? Terms::value(local[k]) : std::nullopt;
    const auto found = row.numbers.find(clear);
    if (found != row.numbers.end() && reachable.contains(found->second)) return {found->second};
    Modes result;
    for (const bool is_liked : {true, false}) {
      for (std::size_t mode = 0; mode < row.modes.size(); ++mode) {
        if (reachable.contains(mode) != is_liked) continue;
        const z3::expr here = both(other, terms_.has(local, row.modes[mode]));
        if (!terms_.may_be(here)) continue;
        result.insert(mode);
        other = both(other, no(here));
      }
    }
    if (terms_.may_be(other)) throw Rejected(what + " to one that is not listed");
    return result;
  }

  [[nodiscard]] const Moves& moves(std::size_t port) const {
    const std::size_t atom = m_.atom_of_port[port];
    return by_port_[group_of_[atom]][port - m_.first_port[atom]];
  }

  // What can take part in a step at all; where its ports lead to must be among the reachable modes.
  void check_reachable() {
    possible_.assign(m_.nodes.size(), false);
    used_.assign(m_.nodes.size(), false);
    for (std::size_t row = 0; row < m_.nodes.size(); ++row) {
      const Node& node = m_.nodes[row];
      const auto can = [&](const Edge& edge) { return possible_[edge.node] && (node.kind != Kind::Trigger || edge.is_trigger); };
      const auto begins = [&](const auto& move) { return c_.reachable[m_.atom_of_port[row]].contains(move.first); };
      if (node.kind == Kind::Port) possible_[row] = std::any_of(moves(row).begin(), moves(row).end(), begins);
      else if (node.kind == Kind::All) possible_[row] = std::all_of(node.children.begin(), node.children.end(), can);
      else possible_[row] = std::any_of(node.children.begin(), node.children.end(), can);
    }
    for (std::size_t row = m_.nodes.size(); row-- > 0;) {
      const Node& node = m_.nodes[row];
      used_[row] = (used_[row] || node.is_step) && possible_[row];
      if (!used_[row]) continue;
      for (const Edge& edge : node.children) used_[edge.node] = true;
      if (node.kind != Kind::Port) continue;
      const std::size_t atom = m_.atom_of_port[row];
      for (const auto& [from, to] : moves(row)) {
        if (!c_.reachable[atom].contains(from) || c_.reachable[atom].contains(to)) continue;
        throw Rejected("`" + std::string(m_.atoms[atom].path) + "` can reach a mode that is not among the reachable ones");
      }
    }
  }

  void check_set(const Set& set) {
    const auto weight = [&](std::size_t atom, std::size_t mode) -> long {
      const auto at = set.weights.find({atom, mode});
      return at == set.weights.end() ? 0 : at->second;
    };
    std::set<std::size_t> atoms, touched;
    for (const auto& [member, w] : set.weights) atoms.insert(member.first);
    long least = 0, most = 0;
    for (std::size_t atom : atoms) {
      std::set<long> begins;
      for (std::size_t mode : first_[atom]) begins.insert(weight(atom, mode));
      least += begins.empty() ? 0 : *begins.begin();
      most += begins.empty() ? 0 : *begins.rbegin();
      for (std::size_t port = m_.first_port[atom]; port < m_.first_port[atom + 1]; ++port) touched.insert(port);
    }
    if (set.is_trap ? least == 0 : least != set.total || most != set.total) throw Rejected(set.text + ": not marked at first as it should be");
    std::map<std::size_t, Effects> effects;
    while (!touched.empty()) {
      // Children have smaller rows than parents.
      const std::size_t row = *touched.begin();
      touched.erase(touched.begin());
      const Node& node = m_.nodes[row];
      if (!used_[row]) continue;
      Effects& effect = effects[row];
      if (node.kind != Kind::Port) effect = combine(set, node, effects);
      for (const auto& [from, to] : node.kind == Kind::Port ? moves(row) : Moves()) {
        const std::size_t atom = m_.atom_of_port[row];
        const long was = weight(atom, from), is = weight(atom, to);
        if (c_.reachable[atom].contains(from)) effect.insert(!set.is_trap ? is - was : is != 0 ? 2 : was != 0 ? 1 : 0);
      }
      if (node.is_step && set.is_trap && effect.contains(1)) throw Rejected(set.text + ": a step takes the last token out of the trap");
      if (node.is_step && !set.is_trap && effect != Effects{0}) throw Rejected(set.text + ": a step changes the sum");
      touched.insert(node.parents.begin(), node.parents.end());
    }
  }

  [[nodiscard]] Effects combine(const Set& set, const Node& node, const std::map<std::size_t, Effects>& effects) const {
    const auto join = [&](const Effects& some, const Effects& more, Effects into) {
      for (long one : some) {
        // Two changes of a sum that differ do so whatever else takes part, and are enough to know.
        for (auto other = more.begin(); other != more.end() && (set.is_trap || into.size() < 3); ++other) into.insert(set.is_trap ? std::max(one, *other) : one + *other);
      }
      return into;
    };
    // What has been chosen so far; of groups with triggers, without one.
    Effects good, open{0};
    if (node.kind == Kind::All) good.insert(0);
    for (const Edge& edge : node.children) {
      if (!possible_[edge.node]) continue;
      const auto found = effects.find(edge.node);
      const Effects effect = found == effects.end() ? Effects{0} : found->second;
      if (node.kind == Kind::All) good = join(good, effect, {});
      if (node.kind == Kind::Any) good.insert(effect.begin(), effect.end());
      if (node.kind != Kind::Trigger) continue;
      good = join(good, effect, good);
      if (edge.is_trigger) good = join(open, effect, good);
      else open = join(open, effect, open);
    }
    return good;
  }

  const Model& m_;
  const Certificate& c_;
  z3::context z_;
  Terms terms_;
  Rows group_of_;                                // by atom
  std::vector<std::vector<Moves>> by_port_;      // by group, and port of its type
  std::vector<Modes> first_;                     // by atom: modes that it can begin in
  std::vector<bool> possible_, used_;            // by node
};

}  // namespace

void check_structure(const Model& model, const Certificate& certificate) { Structure(model, certificate).run(); }

}  // namespace certcheck
