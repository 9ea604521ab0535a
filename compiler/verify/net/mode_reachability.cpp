// See mode_reachability.hpp.
//
// The facts "mode is on", "node is ready" and "node is in context" are the least model of Horn clauses, computed as by
// W. Dowling, J. Gallier: Linear-Time Algorithms for Testing the Satisfiability of Propositional Horn Formulae (1984):
// a counter per clause of the premises that are missing, and a queue of facts whose clauses have not been visited.
//   1. Begin with the clauses without premises: roots are in context; the caller turns on the initial modes, or those
//      outside of the set.
//   2. Take a fact from a queue, and count it in the clauses whose premise it is:
//        mode on, move of port p at that mode      => p ready
//        ready: all children of a rendezvous, a trigger of a trigger group, a choice => the node ready
//        node in context, the other children that it needs ready => child in context
//        p ready by a move and in context          => the mode at the move's other end on
//   3. A clause with no premise missing gives its conclusion, which enters a queue once.
// Departure: the clauses are never written down, they are read off the net; tokens are never taken away, so modes that
// exclude each other may both be on. Forward, this over-approximates the reachable modes. Backward, what stays off is
// the greatest trap within the set (J. Desel, J. Esparza 1995, chapter 4), of the steps that are possible by structure.
#include "compiler/verify/net/mode_reachability.hpp"

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

ModeReachability::ModeReachability(const Net& net, Direction direction, const ModeReachability* forward)
    : net_(net),
      direction_(direction),
      forward_(forward),
      on_(net.mode_count(), 0),
      ready_(net.graph.nodes.size(), 0),
      context_(net.graph.nodes.size(), 0),
      count_(net.graph.nodes.size(), 0) {
  BIP_ASSERT(net.too_large_atom == kNoRow, "atom {} has too many modes", net.too_large_atom);
  BIP_ASSERT(forward == nullptr || direction == Direction::Backward, "a search forward follows all moves");
  // Step 1.
  for (u32 row = 0; row < net.graph.nodes.size(); ++row) {
    const Node& node = net.graph.nodes[row];
    if (node.kind == ConnectorNodeKind::All) count_[row] = node.children;
    if (node.is_root) put_in_context(row);
  }
}

void ModeReachability::turn_on(u32 mode) {
  BIP_ASSERT(mode < on_.size(), "mode {} of {}", mode, on_.size());
  if (on_[mode] != 0) return;
  on_[mode] = 1;
  mode_todo_.push_back(mode);
}

// Step 3, as are turn_on() and put_in_context().
void ModeReachability::make_ready(u32 node) {
  if (ready_[node] != 0) return;
  ready_[node] = 1;
  ready_todo_.push_back(node);
}

void ModeReachability::put_in_context(u32 node) {
  if (context_[node] != 0) return;
  context_[node] = 1;
  context_todo_.push_back(node);
}

// Step 2, the third clause: children of a group in context, as far as the others are ready.
void ModeReachability::spread_context(u32 group) {
  const ConnectorNodeKind kind = net_.graph.nodes[group].kind;
  for (const Edge& child : net_.graph.children(group)) {
    bool others_are_ready = true;
    if (kind == ConnectorNodeKind::All)
      others_are_ready = count_[group] == 0 || (count_[group] == 1 && ready_[child.node] == 0);
    if (kind == ConnectorNodeKind::Trigger) others_are_ready = child.is_trigger || count_[group] != 0;
    if (others_are_ready) put_in_context(child.node);
  }
}

// Step 2, the fourth clause, for a port that came into context: all its moves whose one end is on.
void ModeReachability::fire_port(u32 port) {
  const u32 base = net_.mode_base[net_.graph.atom_of_port[port]];
  for (const Move& move : net_.moves(port)) {
    if (!is_possible(port, base + move.from)) continue;
    const u32 near = base + (direction_ == Direction::Forward ? move.from : move.to);
    const u32 far = base + (direction_ == Direction::Forward ? move.to : move.from);
    if (on_[near] != 0) turn_on(far);
  }
}

void ModeReachability::run() {
  while (true) {
    if (!context_todo_.empty()) {
      const u32 node = context_todo_.back();
      context_todo_.pop_back();
      if (net_.graph.nodes[node].kind == ConnectorNodeKind::Port) fire_port(node);
      else spread_context(node);
    } else if (!ready_todo_.empty()) {
      // Step 2, the second clause; `count_` has the missing premises of a rendezvous.
      const u32 node = ready_todo_.back();
      ready_todo_.pop_back();
      for (const Edge& parent : net_.graph.parents(node)) {
        const u32 group = parent.node;
        switch (net_.graph.nodes[group].kind) {
          case ConnectorNodeKind::All:
            BIP_ASSERT(count_[group] != 0, "node {} has more children that are ready than children", group);
            if (--count_[group] == 0) make_ready(group);
            if (context_[group] != 0 && count_[group] <= 1) spread_context(group);
            break;
          case ConnectorNodeKind::Trigger:
            if (!parent.is_trigger || count_[group]++ != 0) break;
            make_ready(group);
            if (context_[group] != 0) spread_context(group);
            break;
          case ConnectorNodeKind::Port:
          case ConnectorNodeKind::Any: make_ready(group); break;
        }
      }
    } else if (!mode_todo_.empty()) {
      // Step 2, the first clause, and the fourth for ports that are in context already.
      const u32 mode = mode_todo_.back();
      mode_todo_.pop_back();
      const u32 atom = net_.atom_of_mode[mode];
      const u32 base = net_.mode_base[atom];
      for (const PortMove& move : direction_ == Direction::Forward ? net_.moves_out(mode) : net_.moves_in(mode)) {
        const u32 port = net_.graph.port_base[atom] + move.port;
        if (!is_possible(port, direction_ == Direction::Forward ? mode : base + move.other)) continue;
        make_ready(port);
        if (context_[port] != 0) turn_on(base + move.other);
      }
    } else {
      BIP_ASSERT(is_closed(), "a possible move leads out of the modes that are on");
      return;
    }
  }
}

// Does each possible move of a port in its context keep to the modes that are on?
bool ModeReachability::is_closed() const {
  for (u32 port = 0; port < net_.graph.atom_of_port.size(); ++port) {
    if (context_[port] == 0) continue;
    const u32 base = net_.mode_base[net_.graph.atom_of_port[port]];
    for (const Move& move : net_.moves(port)) {
      if (!is_possible(port, base + move.from)) continue;
      const bool is_forward = direction_ == Direction::Forward;
      if (on_[base + (is_forward ? move.from : move.to)] != 0 && on_[base + (is_forward ? move.to : move.from)] == 0)
        return false;
    }
  }
  return true;
}

}  // namespace bip::verify
