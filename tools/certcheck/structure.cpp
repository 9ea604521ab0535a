// Reachable modes are closed under steps, sets are marked at first and kept by steps. Judged bottom up on the connectors' trees, without
// listing interactions: which choices can a subtree make, of those that put nothing into the set, and does one of them take
// something out; by how much can it change the sum?
#include <algorithm>

#include "tools/certcheck/check.hpp"

namespace certcheck {

namespace {

class Structure {
 public:
  Structure(const Model& model, const Certificate& certificate)
      : m_(model), c_(certificate), moves_(check_modes(model, certificate)), first_(check_first_modes(model, certificate)) {}

  void run() {
    check_reachable();
    for (const Set& set : c_.sets) check_set(set);
  }

 private:
  /// Of a node's choices: one puts nothing into the set; one of those takes something out; the least and greatest change of the sum.
  struct Effect {
    bool is_quiet = true, takes = false;
    long low = 0, high = 0;
    // One or the other.
    void join(const Effect& o, bool is_first) {
      is_quiet = (!is_first && is_quiet) || o.is_quiet;
      takes = (!is_first && takes) || o.takes;
      low = is_first ? o.low : std::min(low, o.low);
      high = is_first ? o.high : std::max(high, o.high);
    }
  };

  [[nodiscard]] const std::vector<std::pair<std::size_t, std::size_t>>& moves(std::size_t port) const {
    const std::size_t atom = m_.atom_of_port[port];
    return moves_[c_.class_of[atom]][port - m_.first_port[atom]];
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
        if (c_.reachable[atom].contains(from) && !c_.reachable[atom].contains(to)) throw Rejected("`" + m_.atoms[atom].path + "` can reach a mode that is not among the reachable ones");
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
    std::map<std::size_t, Effect> effects;
    while (!touched.empty()) {
      // Children have smaller rows than parents.
      const std::size_t row = *touched.begin();
      touched.erase(touched.begin());
      const Node& node = m_.nodes[row];
      if (!used_[row]) continue;
      Effect effect = node.kind == Kind::Port ? Effect() : combine(node, effects);
      bool is_first = true;
      for (const auto& [from, to] : node.kind == Kind::Port ? moves(row) : std::vector<std::pair<std::size_t, std::size_t>>()) {
        const std::size_t atom = m_.atom_of_port[row];
        if (!c_.reachable[atom].contains(from)) continue;
        const long was = weight(atom, from), is = weight(atom, to);
        effect.join({is == 0, was != 0 && is == 0, is - was, is - was}, is_first);
        is_first = false;
      }
      effects[row] = effect;
      if (node.is_step && set.is_trap && effect.takes) throw Rejected(set.text + ": a step takes the last token out of the trap");
      if (node.is_step && !set.is_trap && (effect.low != 0 || effect.high != 0)) throw Rejected(set.text + ": a step changes the sum");
      touched.insert(node.parents.begin(), node.parents.end());
    }
  }

  [[nodiscard]] Effect combine(const Node& node, const std::map<std::size_t, Effect>& effects) const {
    Effect result;
    bool is_first = true, has_quiet = false, has_taking = false;  // triggers
    const auto live = std::count_if(node.children.begin(), node.children.end(), [&](const Edge& edge) { return possible_[edge.node]; });
    for (const Edge& edge : node.children) {
      if (!possible_[edge.node]) continue;
      const auto found = effects.find(edge.node);
      const Effect effect = found == effects.end() ? Effect() : found->second;
      if (node.kind == Kind::Any) {
        result.join(effect, is_first);
        is_first = false;
        continue;
      }
      const bool must = node.kind == Kind::All || live == 1;
      result.is_quiet = result.is_quiet && effect.is_quiet;
      result.takes = result.takes || effect.takes;
      result.low += must ? effect.low : std::min(effect.low, 0L);
      result.high += must ? effect.high : std::max(effect.high, 0L);
      has_quiet = has_quiet || (edge.is_trigger && effect.is_quiet);
      has_taking = has_taking || (edge.is_trigger && effect.takes);
    }
    if (node.kind == Kind::All) result.takes = result.is_quiet && result.takes;
    if (node.kind == Kind::Trigger) result.takes = has_taking || (has_quiet && result.takes);
    if (node.kind == Kind::Trigger) result.is_quiet = has_quiet;
    return result;
  }

  const Model& m_;
  const Certificate& c_;
  const Moves moves_;
  const std::vector<std::set<std::size_t>> first_;
  std::vector<bool> possible_, used_;  // by node
};

}  // namespace

void check_structure(const Model& model, const Certificate& certificate) { Structure(model, certificate).run(); }

}  // namespace certcheck
