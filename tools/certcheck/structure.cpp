// Modes, the reachable ones, and sets of them. First atoms alone, in an environment that may do anything: what they
// begin in and what each port leads to are modes of their class. One that fits is enough, one that the components can
// be in is preferred; where values are not known, Z3 tells which modes can be met and that there is no other way. Then
// reachable modes are closed under steps, sets are marked at first and kept by steps: judged bottom up on the
// connectors' trees, without listing interactions, by what a subtree's choices can do to the set.
#include <numeric>

#include "tools/certcheck/terms.hpp"

namespace certcheck {
namespace {

/// What a choice does to a trap: nothing (0), take from it (1), put into it (2), of parts the most; to a sum: by how
/// much it changes it.
using Effects = std::set<long>;

class Structure {
 public:
  Structure(const Model& model, const Certificate& certificate, z3::context& z)
      : model_(model), proof_(certificate), terms_(model, z) {}

  std::vector<AtomMoves> moves_by_atom() {
    for (std::size_t atom = 0; atom < model_.atoms.size(); ++atom)
      group(model_.atoms[atom], proof_.classes.at(proof_.class_of[atom]), proof_.reachable[atom]);
    std::vector<AtomMoves> result;
    for (const AtomMoves* group : group_of_) result.push_back(*group);
    return result;
  }
  void run() {
    (void)moves_by_atom();
    check_reachable();
    for (const Fact& set : proof_.sets) check_set(set);
  }

 private:
  // Components of one class and with the same arguments that can be in the same modes: modes may overlap, and which one
  // a move meets is judged for those.
  void group(const Atom& atom, const Class& row, const Modes& reachable) {
    const AtomType& type = model_.atom_types[atom.type];
    std::string args;
    for (const Tree& arg : atom.args->items) args.append(arg.text) += '\n';
    const auto [found, is_new] = groups_.try_emplace({&row, reachable, args});
    group_of_.push_back(&found->second);
    if (!is_new) return;
    expr fault = terms_.truth(false);
    const Local start = terms_.initial(atom, fault);
    found->second.first = met(row, reachable, start, no(fault));
    if (!std::includes(reachable.begin(), reachable.end(), found->second.first.begin(), found->second.first.end())) {
      throw Rejected(quoted(atom.path) + " starts in a mode that is not among the reachable ones");
    }
    std::vector<Moves>& by_port = found->second.by_port;
    by_port.resize(type.ports.size());
    for (std::size_t from : reachable) {
      Local local = terms_.local(atom, row.modes[from]);
      const Offer offer = terms_.offer(type, local, fault);
      for (std::size_t t = 0; t < type.transitions.size(); ++t) {
        const std::size_t port = type.transitions[t].port;
        const expr on = port == kNone ? offer.transitions[t] : both(offer.ports[port], offer.transitions[t]);
        if (is(on, false)) continue;
        Local next = local;
        for (std::size_t variable : type.ports[port].written)
          next[variable] = terms_.fresh(type.variables[variable].type);
        expr ends = terms_.truth(false);
        // Where it is on, and nowhere else: then what it assigns is what is there.
        terms_.take(type, type.transitions[t], next, terms_.truth(true), ends);
        for (std::size_t to : met(row, reachable, next, both(on, no(ends)))) by_port[port].emplace_back(from, to);
      }
    }
  }
  // Modes, kNone for one that is not listed. Where it is clear what is marked, values that are no constants are left
  // open.
  Modes met(const Class& row, const Modes& reachable, const Local& local, expr other) {
    Values clear(local.size());
    for (std::size_t k = 0; k < local.size(); ++k) clear[k] = row.followed[k] ? value_of(local[k]) : std::nullopt;
    const auto found = row.numbers.find(clear);
    if (found != row.numbers.end() && reachable.contains(found->second)) return {found->second};
    Modes result;
    // First, by where it is, the mode that knows most of those that know nothing but what is so: as the values would
    // lead there. Then any; none that the component cannot be in while there is another.
    std::vector<std::size_t> order(row.modes.size());
    std::iota(order.begin(), order.end(), 0);
    const auto rank = [&](std::size_t mode) {
      return std::pair(!reachable.contains(mode),
                       std::count(row.modes[mode].begin(), row.modes[mode].end(), std::nullopt));
    };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
    for (const bool is_whole : {true, false}) {
      for (std::size_t mode : order) {
        Values said = row.modes[mode];
        if (is_whole)
          std::fill(said.begin() + static_cast<long>(model_.atom_types[row.type].places), said.end(), std::nullopt);
        const expr in_mode = both(other, terms_.has(local, said));
        if ((is_whole && !reachable.contains(mode)) || !terms_.may_be(in_mode)) continue;
        if (is_whole && terms_.may_be(both(in_mode, no(terms_.has(local, row.modes[mode]))))) continue;
        result.insert(mode);
        other = both(other, no(in_mode));
      }
    }
    if (terms_.may_be(other)) result.insert(kNone);
    return result;
  }

  [[nodiscard]] const Moves& moves(std::size_t row) const {
    static const Moves kNoPort;
    const std::size_t atom = row < model_.atom_of_port.size() ? model_.atom_of_port[row] : kNone;
    return atom == kNone ? kNoPort : group_of_[atom]->by_port[row - model_.first_port[atom]];
  }
  // What can take part in a step at all; where its ports lead to must be among the reachable modes.
  void check_reachable() {
    for (std::size_t row = 0; row < model_.nodes.size(); ++row) {
      const Node& node = model_.nodes[row];
      const auto can = [&](const Edge& edge) {
        return possible_[edge.node] && (node.kind != Kind::Trigger || edge.is_trigger);
      };
      if (node.kind == Kind::Port) possible_.push_back(!moves(row).empty());
      else if (node.kind == Kind::All)
        possible_.push_back(std::all_of(node.children.begin(), node.children.end(), can));
      else possible_.push_back(std::any_of(node.children.begin(), node.children.end(), can));
    }
    used_.assign(model_.nodes.size(), false);
    for (std::size_t row = model_.nodes.size(); row-- > 0;) {
      const Node& node = model_.nodes[row];
      used_[row] = (used_[row] || node.is_step) && possible_[row];
      if (!used_[row]) continue;
      for (const Edge& edge : node.children) used_[edge.node] = true;
      for (const auto& [from, to] : moves(row)) {
        const std::size_t atom = model_.atom_of_port[row];
        if (!proof_.reachable[atom].contains(to))
          throw Rejected(quoted(model_.atoms[atom].path) + " can reach a mode that is not among the reachable ones");
      }
    }
  }

  void check_set(const Fact& set) {
    const bool is_trap = !set.total;
    std::map<std::size_t, std::map<std::size_t, long>> weights;  // by atom and mode
    for (const Case& row : set.cases) weights[row.literals[0].atom][row.literals[0].variable] += row.weight;
    const auto weight = [](const std::map<std::size_t, long>& its, std::size_t mode) {
      return its.contains(mode) ? its.at(mode) : 0;
    };
    std::set<std::size_t> touched;
    long least = 0, most = 0;
    for (const auto& [atom, its] : weights) {
      Effects begins;
      for (std::size_t mode : group_of_[atom]->first) begins.insert(weight(its, mode));
      least += begins.empty() ? 0 : *begins.begin();
      most += begins.empty() ? 0 : *begins.rbegin();
      for (std::size_t port = model_.first_port[atom]; port < model_.first_port[atom + 1]; ++port) touched.insert(port);
    }
    if (is_trap ? least == 0 : least != *set.total || most != *set.total)
      throw Rejected(set.line + ": not marked at first as it should be");
    std::map<std::size_t, Effects> effects;
    // Children have smaller rows than parents.
    for (; !touched.empty(); touched.erase(touched.begin())) {
      const std::size_t row = *touched.begin();
      const Node& node = model_.nodes[row];
      if (!used_[row]) continue;
      Effects& effect = effects[row];
      if (node.kind != Kind::Port) effect = combine(is_trap, node, effects);
      for (const auto& [from, to] : moves(row)) {
        const auto& its = weights[model_.atom_of_port[row]];
        const long was = weight(its, from), is = weight(its, to);
        effect.insert(!is_trap ? is - was : is != 0 ? 2 : was != 0 ? 1 : 0);
      }
      if (node.is_step && is_trap && effect.contains(1))
        throw Rejected(set.line + ": a step takes the last token out of the trap");
      if (node.is_step && !is_trap && effect != Effects{0}) throw Rejected(set.line + ": a step changes the sum");
      touched.insert(node.parents.begin(), node.parents.end());
    }
  }

  [[nodiscard]] Effects combine(bool is_trap, const Node& node, const std::map<std::size_t, Effects>& effects) const {
    const auto join = [&](const Effects& some, const Effects& more, Effects into) {
      for (long weight : some) {
        for (long other : more) {
          // Two changes of a sum that differ do so whatever else takes part, and are enough to know.
          if (is_trap || into.size() < 3) into.insert(is_trap ? std::max(weight, other) : weight + other);
        }
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
      if (node.kind == Kind::Any) good.insert(effect.begin(), effect.end());
      else good = join(good, effect, node.kind == Kind::All ? Effects() : good);
      if (edge.is_trigger) good = join(open, effect, good);
      else if (node.kind == Kind::Trigger) open = join(open, effect, open);
    }
    return good;
  }

  const Model& model_;
  const Certificate& proof_;
  Terms terms_;
  std::map<std::tuple<const Class*, Modes, std::string>, AtomMoves> groups_;
  std::vector<const AtomMoves*> group_of_;  // by atom
  std::vector<bool> possible_, used_;       // by node
};

}  // namespace

std::vector<AtomMoves> moves_of(const Model& model, const Certificate& certificate, z3::context& z) {
  return Structure(model, certificate, z).moves_by_atom();
}

void check_structure(const Model& model, const Certificate& certificate, z3::context& z) {
  Structure(model, certificate, z).run();
}

}  // namespace certcheck
