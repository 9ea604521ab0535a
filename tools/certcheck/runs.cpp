// The graph of listed states beside the tester of the claim: no strong component (Tarjan 1972) of it has a fair cycle
// that keeps all promises. Under strong fairness states in which something is possible that the component never does
// are removed, and the rest is decomposed again (Emerson, Lei 1987).
#include "tools/certcheck/runs.hpp"

namespace certcheck {
namespace {

const std::vector<Text> kAhead{"next", "until", "release"}, kBack{"previously", "since"};
const std::vector<Text> kAboutRuns{"next", "until", "release", "previously", "since", "happens", "happens-port"};

}  // namespace

Formula::Formula(const Tree& claim) : root_(claim.at(1)), is_of_points_(claim.head() == "points") {
  add(root_, 0);
  if (is_of_points_) {
    if (!Tree{true, false, {}, {root_}}.find(kAhead).empty()) throw Rejected("a claim about points looks ahead");
    return;
  }
  // Whether the root is true at first is a promise, too.
  const Tree promise = root_.head() == "until" || root_.head() == "release"
                           ? root_
                           : Tree{true, false, {}, {Tree{false, false, "next", {}}, root_}};
  if (!contains(bits_, promise)) bits_.push_back(promise);
  root_bit_ = static_cast<std::size_t>(std::find(bits_.begin(), bits_.end(), promise) - bits_.begin());
}

void Formula::add(const Tree& e, std::size_t depth) {
  constexpr std::size_t kMostDepth = 1000;
  if (depth > kMostDepth) throw NotCheckable("the claim is nested too deeply");
  const Text op = e.head();
  const bool is_bit = contains(kAhead, op) || contains(kBack, op);
  if (!is_bit && (is_about_step(e) || e.find(kAboutRuns).empty())) {
    if (!contains(leaves_, e)) leaves_.push_back(e);
    return;
  }
  const bool is_unary = op == "not" || op == "next" || op == "previously";
  if ((!is_bit && !is_unary && op != "and" && op != "or") || e.items.size() != (is_unary ? 2 : 3))
    throw Rejected("the claim has an unknown form " + quoted(op));
  for (std::size_t k = 1; k < e.items.size(); ++k) add(e.items[k], depth + 1);
  if (is_bit && !contains(bits_, e)) bits_.push_back(e);
}

std::size_t Formula::promises() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(bits_, [](const Tree& e) { return e.head() == "until" || e.head() == "release"; }));
}

expr happens(const Model& model, const Terms& terms, const Tree& leaf, std::size_t connector,
             const std::map<std::size_t, expr>& parts) {
  if (leaf.head() == "happens")
    return terms.truth(row_of(model.connectors, leaf.at(1).text, &Connector::path) == connector);
  const std::size_t atom = row_of(model.atoms, leaf.at(1).text, &Atom::path);
  const auto part =
      parts.find(model.first_port[atom] + row_of(model.type_of(atom).ports, leaf.at(2).text, &Port::name));
  return part == parts.end() ? terms.truth(false) : part->second;
}

bool Formula::looks_ahead(std::size_t bit) const { return contains(kAhead, bits_[bit].head()); }

std::optional<bool> Formula::first(std::size_t bit) const {
  return bit == root_bit_ || !looks_ahead(bit) ? std::optional(false) : std::nullopt;
}

expr Formula::value(const Tree& e, const Local& leaves, const Local& now, const Local& later) const {
  const auto leaf = std::find(leaves_.begin(), leaves_.end(), e);
  if (leaf != leaves_.end()) return leaves[static_cast<std::size_t>(leaf - leaves_.begin())];
  const Text op = e.head();
  const auto bit = static_cast<std::size_t>(std::find(bits_.begin(), bits_.end(), e) - bits_.begin());
  if (op == "next" || op == "previously") return (op == "next" ? later : now)[bit];
  const expr a = value(e.at(1), leaves, now, later);
  if (op == "not") return no(a);
  const expr b = value(e.at(2), leaves, now, later);
  if (op == "and" || op == "or") return op == "and" ? both(a, b) : either(a, b);
  const expr& other = (op == "since" ? now : later)[bit];
  return op == "release" ? both(b, either(a, other)) : either(b, both(a, other));
}

Formula::Point Formula::point(const Terms& terms, const Local& leaves, const Local& now, const Local& later) const {
  Point point{terms.truth(true), terms.truth(false), {}, {}};
  if (is_of_points_) point.violated = no(value(root_, leaves, now, later));
  for (std::size_t bit = 0; bit < bits_.size(); ++bit) {
    const Tree& e = bits_[bit];
    const Text op = e.head();
    // Of `next` and `previously` the bit is that of what they are about.
    const expr holds = value(op == "next" || op == "previously" ? e.at(1) : e, leaves, now, later);
    point.next.push_back(holds);
    if (looks_ahead(bit))
      point.possible = both(point.possible, either(both(holds, now[bit]), both(no(holds), no(now[bit]))));
    if (op != "until" && op != "release") continue;
    const expr comes = value(e.at(2), leaves, now, later);
    // To be false, the right side of `release` must become so.
    point.pending.push_back(op == "until" ? both(holds, no(comes)) : both(no(holds), comes));
  }
  return point;
}

Runs::Runs(const Certificate& certificate, const Tree& claim, const Terms& terms)
    : proof_(certificate), terms_(terms), formula_(claim), is_of_points_(claim.head() == "points") {
  // Of each of their values something is computed and stored.
  constexpr std::size_t kMostBits = 20;
  if (formula_.bits() > kMostBits) throw NotCheckable("the claim has too many operators");
}

Runs::Node Runs::row_of_state(const std::u32string& state) const {
  return static_cast<Node>(std::lower_bound(states_.begin(), states_.end(), state) - states_.begin());
}

void Runs::enter(const std::u32string& state, System& system) {
  now_ = row_of_state(state);
  truth_.clear();
  for (const Tree& leaf : formula_.leaves()) {
    const expr holds = Formula::is_about_step(leaf) ? terms_.truth(false) : system.claim(leaf);
    truth_.push_back(is(holds, true));
    if (!is(holds, true) && !is(holds, false))
      throw NotCheckable("a condition depends on values that are not followed");
  }
}

void Runs::add(const Model& model, const Step& step, const std::map<std::size_t, expr>& parts,
               const std::u32string& to) {
  Rows ports;
  for (const auto& [node, is_in] : parts)
    if (is(is_in, true)) ports.push_back(node);
  const auto [at, is_new] = labels_.try_emplace({step.connector, ports}, labels_.size());
  if (is_new) {
    Units& units = units_.emplace_back();
    for (std::size_t k = 0; k < proof_.fair.size(); ++k) {
      const Fair& fair = proof_.fair[k];
      if (fair.what == Fair::Interactions) units.emplace(k, at->second);
      if (fair.what == Fair::Connector && fair.row == step.connector) units.emplace(k, 0);
      for (std::size_t port : ports) {
        if (fair.what == Fair::Atoms) units.emplace(k, model.atom_of_port[port]);
        if ((fair.what == Fair::Atom && fair.row == model.atom_of_port[port]) ||
            (fair.what == Fair::Port && fair.row == port))
          units.emplace(k, 0);
      }
    }
  }
  std::vector<bool> truth = truth_;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const Tree& leaf = formula_.leaves()[k];
    if (Formula::is_about_step(leaf)) truth[k] = is(happens(model, terms_, leaf, step.connector, parts), true);
  }
  edges_[now_].push_back(
      {row_of_state(to), at->second, &changes_of(truth), is(step.sure, true) && is(step.fault, false)});
}

// Where all steps may end with errors there may be no next point, but this one.
void Runs::leave(const expr& has_step) {
  const bool has_sure = std::ranges::any_of(edges_[now_], &Edge::is_sure);
  if (!is(has_step, true)) edges_[now_].push_back({now_, kNone, &changes_of(truth_), false});
  else if (is_of_points_ && !has_sure) edges_[now_].push_back({kNowhere, kNone, &changes_of(truth_), false});
}

const Runs::Changes& Runs::changes_of(const std::vector<bool>& truth) {
  const auto [at, is_new] = changes_.try_emplace(truth);
  if (!is_new) return at->second;
  const Node count = Node{1} << formula_.bits();
  const auto bits_of = [&](Node node) {
    Local bits;
    for (std::size_t bit = 0; bit < formula_.bits(); ++bit) bits.push_back(terms_.truth((node >> bit & 1) != 0));
    return bits;
  };
  Local leaves;
  for (bool is_true : truth) leaves.push_back(terms_.truth(is_true));
  at->second.resize(count);
  // What looks back is known of this point, what looks ahead of the next one: the others follow.
  for (Node known = 0; known < count; ++known) {
    const Local bits = bits_of(known);
    const Formula::Point point = formula_.point(terms_, leaves, bits, bits);
    Node from = known, to = known;
    for (std::size_t bit = 0; bit < formula_.bits(); ++bit) {
      Node& other = formula_.looks_ahead(bit) ? from : to;
      other = (other & ~(Node{1} << bit)) | Node{is(point.next[bit], true)} << bit;
    }
    Change& change = at->second[from].emplace_back(Change{to, 0, is(point.violated, true)});
    for (std::size_t k = 0; k < point.pending.size(); ++k)
      change.pending |= std::uint64_t{is(point.pending[k], true)} << k;
  }
  return at->second;
}

std::vector<Runs::Move> Runs::moves(Node node) const {
  const Node mask = (Node{1} << formula_.bits()) - 1;
  std::vector<Move> moves;
  for (const Edge& edge : edges_[node >> formula_.bits()]) {
    for (const Change& change : (*edge.changes)[node & mask]) {
      if (change.is_violated) throw Rejected("the claim is false at a point");
      if (edge.to != kNowhere) moves.push_back({edge.to << formula_.bits() | change.to, &edge, change.pending});
    }
  }
  return moves;
}

Runs::Nodes Runs::reach_all(Node first) {
  Nodes nodes;
  const auto reach = [&](Node node) {
    if (marks_.try_emplace(node).second) nodes.push_back(node);
  };
  for (Node bits = 0; bits < Node{1} << formula_.bits(); ++bits) {
    bool is_first = true;
    for (std::size_t bit = 0; bit < formula_.bits(); ++bit)
      is_first = is_first && formula_.first(bit).value_or((bits >> bit & 1) != 0) == ((bits >> bit & 1) != 0);
    if (is_first) reach(first << formula_.bits() | bits);
  }
  for (std::size_t at = 0; at < nodes.size(); ++at)
    for (const Move& move : moves(nodes[at])) reach(move.to);
  return nodes;
}

void Runs::check(const std::u32string& first) {
  const Nodes all = reach_all(row_of_state(first));
  if (is_of_points_) return;
  for (std::vector<Nodes> todo{all}; !todo.empty();) {
    const Nodes nodes = std::move(todo.back());
    todo.pop_back();
    each_component(nodes, [&](const Nodes& component) {
      Nodes part = fair_part(component);
      if (!part.empty() && part.size() == component.size())
        throw Rejected("a run of the states that the certificate lists violates the claim");
      if (!part.empty()) todo.push_back(std::move(part));
    });
  }
}

void Runs::each_component(const Nodes& nodes, const std::function<void(const Nodes&)>& visit) {
  struct Frame {
    Node node = 0;
    std::vector<Move> moves;
    std::size_t at = 0;
  };
  const std::size_t within = ++regions_;
  for (Node node : nodes) marks_[node] = {within, 0, 0};
  std::vector<Frame> path;
  Nodes open;
  std::size_t count = 0;
  const auto enter = [&](Node node) {
    marks_[node].number = marks_[node].low = ++count;
    open.push_back(node);
    path.push_back({node, moves(node)});
  };
  for (Node root : nodes) {
    if (marks_[root].number == 0) enter(root);
    while (!path.empty()) {
      const Node node = path.back().node;
      Mark& mark = marks_[node];
      if (path.back().at < path.back().moves.size()) {
        const Node to = path.back().moves[path.back().at++].to;
        if (marks_[to].region != within) continue;
        if (marks_[to].number == 0) enter(to);
        else mark.low = std::min(mark.low, marks_[to].number);
        continue;
      }
      path.pop_back();
      if (!path.empty()) marks_[path.back().node].low = std::min(marks_[path.back().node].low, mark.low);
      if (mark.low != mark.number) continue;
      const auto own = std::find(open.rbegin(), open.rend(), node).base() - 1;
      const Nodes component(own, open.end());
      open.erase(own, open.end());
      ++regions_;
      for (Node member : component) marks_[member].region = regions_;
      visit(component);
    }
  }
}

// The nodes of the component in which a fair run that violates the claim may stay: all of them if there is one.
Runs::Nodes Runs::fair_part(const Nodes& component) const {
  const std::size_t own = marks_.at(component[0]).region;
  std::uint64_t always_pending = ~std::uint64_t{0};
  bool has_cycle = false;
  Units taken, always;
  const auto possible_in = [&](Node node) {
    Units possible;
    for (const Edge& edge : edges_[node >> formula_.bits()])
      if (edge.is_sure) possible.insert(units_[edge.label].begin(), units_[edge.label].end());
    return possible;
  };
  for (Node node : component) {
    for (const Move& move : moves(node)) {
      if (marks_.at(move.to).region != own) continue;
      has_cycle = true;
      always_pending &= move.pending;
      if (move.edge->label != kNone) taken.insert(units_[move.edge->label].begin(), units_[move.edge->label].end());
    }
  }
  if (!has_cycle || always_pending != 0) return {};
  if (proof_.fair.empty()) return component;
  // What is always possible is so in each part of the component.
  always = possible_in(component[0]);
  for (Node node : component) {
    const Units possible = possible_in(node);
    std::erase_if(always, [&](const auto& unit) { return !possible.contains(unit); });
  }
  if (std::ranges::any_of(always, [&](const auto& unit) { return !taken.contains(unit); })) return {};
  Nodes part;
  for (Node node : component) {
    if (std::ranges::none_of(possible_in(node), [&](const auto& unit) {
          return proof_.fair[unit.first].is_strong && !taken.contains(unit);
        }))
      part.push_back(node);
  }
  return part;
}

}  // namespace certcheck
