// Reachable modes are closed under steps, sets are marked at first and kept by steps. Judged bottom up on the connectors' trees, without
// listing interactions, by what a subtree's choices can do to the set.
#include <algorithm>

#include "tools/certcheck/check.hpp"

namespace certcheck {

namespace {

class Structure {
 public:
  Structure(const Model& model, const Certificate& certificate) : m_(model), c_(certificate), modes_(check_modes(model, certificate)) {}

  void run() {
    check_reachable();
    for (const Set& set : c_.sets) check_set(set);
  }

 private:
  /// What a choice does to a trap: nothing (0), take from it (1), put into it (2), of parts the most; to a sum: by how much it changes it.
  using Effects = std::set<long>;

  [[nodiscard]] const Moves& moves(std::size_t port) const {
    const std::size_t atom = m_.atom_of_port[port];
    return modes_.by_port[modes_.group_of[atom]][port - m_.first_port[atom]];
  }

  // What can take part in a step at all; where its ports lead to must be among the reachable modes.
  void check_reachable() {
    possible_.assign(m_.nodes.size(), false);
    used_.assign(m_.nodes.size(), false);
    for (std::size_t row = 0; row < m_.nodes.size(); ++row) {
      const Node& node = m_.nodes[row];
      const auto can = [&](const Edge& edge) { return possible_[edge.node] && (node.kind != Kind::Trigger || edge.is_trigger); };
      if (node.kind == Kind::Port) possible_[row] = std::any_of(moves(row).begin(), moves(row).end(), [&](const auto& move) { return c_.reachable[m_.atom_of_port[row]].contains(move.first); });
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
        if (c_.reachable[atom].contains(from) && !c_.reachable[atom].contains(to)) throw Rejected("`" + std::string(m_.atoms[atom].path) + "` can reach a mode that is not among the reachable ones");
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
      for (std::size_t mode : modes_.first[atom]) begins.insert(weight(atom, mode));
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
  const ModeMoves modes_;
  std::vector<bool> possible_, used_;  // by node
};

}  // namespace

void check_structure(const Model& model, const Certificate& certificate) { Structure(model, certificate).run(); }

}  // namespace certcheck
