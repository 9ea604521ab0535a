// The three layers of Bonakdarpour, Bozga, Jaber, Quilbeuf and Sifakis ("A framework for automated distributed
// implementation of component-based models", Distributed Computing 25(5), 2012) on the simulated network, as a
// reference for the messages of runtime/distributed: components, interaction protocols, conflict resolution.
//
// Each node has the interaction protocol of the interactions of which most ports are at home there. A component offers
// what it can do to each protocol that knows one of its ports; a protocol that has all offers of an interaction asks
// the one conflict resolution (on the first node) if the interaction conflicts with one of another protocol, and begins
// it otherwise; each component that takes part gets a message. Messages within a node are
// free, and those for several components of one node are one; the layers as processes of their own pay for all. Places
// alone: of rendezvous without guards; the first transition of a port is the one that it takes.
//
// Built by tools/bench/distributed with the C++ that `bipc emit` writes of a model. Arguments: nodes, steps, seed.
// Prints steps, those of several nodes, messages between nodes, and all messages.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <map>

#include "runtime/core/fire/partial.hpp"
#include "runtime/distributed/distribution.hpp"
#include "runtime/distributed/network.hpp"

namespace model {
const bip::rt::Image& image();
}

namespace {

using namespace bip::rt;

// What a Begin is here: its step has the interaction in the low half.
enum class Says : u64 { Reserve, Granted, Refused, Notify };
u64 coded(Says what, u32 interaction) { return static_cast<u64>(what) << 32 | interaction; }

class ThreeLayers {
 public:
  ThreeLayers(const Image& image, u32 nodes, u64 steps, u64 seed)
      : tables_(link(image, MaximalProgress::On)),
        rules_(link_priorities(tables_)),
        placement_(place_atoms(tables_, rules_, nodes)),
        network_(faults_, seed),
        draws_(seed),
        limit_(steps) {
    const u32 count = static_cast<u32>(tables_.interactions.size());
    std::vector<Csr::Pair> pairs;
    for (u32 i = 0; i < count; ++i) {
      std::vector<u32> found;
      ports_of_interaction(tables_, tables_.interactions[InteractionId(i)], found);
      std::vector<u32> votes(nodes, 0);
      for (const u32 port : found) {
        ++votes[home(port)];
        pairs.push_back({tables_.port_atom[port], i});
      }
      ports_.push_back(found);
      protocol_.push_back(static_cast<u32>(std::max_element(votes.begin(), votes.end()) - votes.begin()));
    }
    interactions_ = Csr::build(image.atoms.size, pairs);
    known_.resize(nodes);
    working_.resize(nodes);
    newest_.assign(nodes, std::vector<u64>(image.atoms.size, 0));
    participations_.assign(image.atoms.size, 1);
    used_.assign(image.atoms.size, 0);
    for (u32 atom = 0; atom < image.atoms.size; ++atom) place_.push_back(tables_.atom_type(atom).initial[0]);
    asked_.assign(count, 0);
  }

  void run() {
    for (u32 atom = 0; atom < place_.size(); ++atom) offer(atom);
    deliver();
    sent_ = all_ = 0;  // what all nodes know at the start costs nothing in either
    for (NetworkEvent event; network_.next(event);) {
      if (event.kind == NetworkEvent::Kind::Turn) {
        offer(working_[event.node].front());
        working_[event.node].pop_front();
      }
      for (const Message& message : event.frame.messages) take(event.frame.from, event.frame.to, message);
      deliver();
    }
    std::printf("%llu %llu %llu %llu\n", as_printed(steps_), as_printed(border_), as_printed(sent_), as_printed(all_));
  }

 private:
  static unsigned long long as_printed(u64 number) { return number; }
  [[nodiscard]] u32 home(u32 port) const { return placement_.home[tables_.port_atom[port]]; }
  // The transition that the port takes from the place; null: none.
  [[nodiscard]] const LinkedTransition* taken(u32 port, u32 place) const {
    const u32 atom = tables_.port_atom[port];
    const LinkedType& type = tables_.types[tables_.atoms[atom].type];
    for (u32 row = type.first_transition; row < type.first_transition + type.transition_count; ++row) {
      const LinkedTransition& transition = tables_.transitions[row];
      if (transition.port == port - tables_.port_base(atom) && transition.from == place) return &transition;
    }
    return nullptr;
  }
  [[nodiscard]] bool can(u32 atom, u32 place, u32 interaction) const {
    for (const u32 port : ports_[interaction]) {
      if (tables_.port_atom[port] == atom) return taken(port, place) != nullptr;
    }
    return false;
  }

  void send(u32 from, u32 to, Message message) {
    ++all_;
    if (from == to) {
      inside_.push_back({from, std::move(message)});
      return;
    }
    ++sent_;
    network_.send({.from = from, .to = to, .messages = {std::move(message)}});
  }
  void deliver() {
    for (; !inside_.empty(); inside_.pop_front()) {
      const Outgoing outgoing = inside_.front();
      take(outgoing.to, outgoing.to, outgoing.message);
    }
  }
  void take(u32 from, u32 to, const Message& message) {
    if (const Offer* offered = std::get_if<Offer>(&message)) {
      // Frames overtake each other.
      u64& newest = newest_[to][offered->atom];
      if (offered->n <= newest) return;
      newest = offered->n;
      known_[to][offered->atom] = {offered->n, offered->offer.place, kNone};
      look(to);
      return;
    }
    const Begin& begin = std::get<Begin>(message);
    const u32 interaction = static_cast<u32>(begin.step);
    switch (static_cast<Says>(begin.step >> 32)) {
      case Says::Reserve: return reserve(from, begin);
      case Says::Granted: asked_[interaction] = 0; return fire(interaction);
      case Says::Refused:
        asked_[interaction] = 0;
        // Newer offers may have come since it asked, and another interaction may have asked for these.
        for (const u32 port : ports_[interaction]) {
          const auto known = known_[to].find(tables_.port_atom[port]);
          if (known != known_[to].end() && known->second.asked_by == interaction) known->second.asked_by = kNone;
        }
        for (const Part& part : begin.parts) {
          const auto stale = known_[to].find(part.atom);
          if (stale != known_[to].end() && stale->second.n <= part.n && stale->second.asked_by == kNone)
            known_[to].erase(stale);
        }
        return look(to);
      case Says::Notify:
        for (const Part& part : begin.parts) {
          ++participations_[part.atom];
          place_[part.atom] = part.transition;
          working_[to].push_back(part.atom);
          network_.await_turn(to);
        }
        return;
    }
  }

  // -- components
  void offer(u32 atom) {
    std::vector<std::uint8_t> is_told(known_.size(), 0);
    for (const u32 interaction : interactions_[atom]) {
      const u32 to = protocol_[interaction];
      if (is_told[to] != 0 || !can(atom, place_[atom], interaction)) continue;
      is_told[to] = 1;
      Offer offered{atom, participations_[atom], {}, {}};
      offered.offer.place = place_[atom];
      send(placement_.home[atom], to, std::move(offered));
    }
  }

  // -- interaction protocols
  [[nodiscard]] bool has_offers(u32 node, u32 interaction) const {
    return std::all_of(ports_[interaction].begin(), ports_[interaction].end(), [&](u32 port) {
      const auto known = known_[node].find(tables_.port_atom[port]);
      return known != known_[node].end() && known->second.asked_by == kNone &&
             taken(port, known->second.place) != nullptr;
    });
  }
  [[nodiscard]] bool conflicts(u32 node, u32 interaction) const {
    for (const u32 port : ports_[interaction]) {
      const u32 atom = tables_.port_atom[port], place = known_[node].at(atom).place;
      for (const u32 other : interactions_[atom]) {
        if (protocol_[other] != node && can(atom, place, other)) return true;
      }
    }
    return false;
  }
  void look(u32 node) {
    std::vector<u32> ready;
    for (u32 i = 0; i < ports_.size(); ++i) {
      if (protocol_[i] == node && asked_[i] == 0 && has_offers(node, i)) ready.push_back(i);
    }
    while (!ready.empty() && steps_ < limit_) {
      std::swap(ready[draws_.below(ready.size())], ready.back());
      const u32 chosen = ready.back();
      ready.pop_back();
      if (!has_offers(node, chosen)) continue;
      if (!conflicts(node, chosen)) {
        fire(chosen);
        continue;
      }
      asked_[chosen] = 1;
      Begin asks{coded(Says::Reserve, chosen), {}};
      for (const u32 port : ports_[chosen]) {
        const u32 atom = tables_.port_atom[port];
        known_[node].at(atom).asked_by = chosen;
        asks.parts.push_back({atom, known_[node].at(atom).n, kNone, 0, {}});
      }
      send(node, 0, std::move(asks));
    }
  }
  void fire(u32 interaction) {
    const u32 node = protocol_[interaction];
    std::map<u32, Begin> told;
    bool is_border = false;
    for (const u32 port : ports_[interaction]) {
      const u32 atom = tables_.port_atom[port];
      Begin& notify = told.emplace(home(port), Begin{coded(Says::Notify, interaction), {}}).first->second;
      notify.parts.push_back({atom, 0, taken(port, known_[node].at(atom).place)->to, 0, {}});
      known_[node].erase(atom);
      is_border = is_border || home(port) != node;
    }
    ++steps_;
    border_ += is_border ? 1 : 0;
    for (auto& [to, notify] : told) send(node, to, std::move(notify));
  }

  // -- conflict resolution
  void reserve(u32 from, const Begin& begin) {
    Begin answer{coded(Says::Refused, static_cast<u32>(begin.step)), {}};
    for (const Part& part : begin.parts) {
      if (part.n <= used_[part.atom]) answer.parts.push_back({part.atom, used_[part.atom], kNone, 0, {}});
    }
    if (answer.parts.empty()) {
      answer.step = coded(Says::Granted, static_cast<u32>(begin.step));
      for (const Part& part : begin.parts) used_[part.atom] = part.n;
    }
    send(0, from, std::move(answer));
  }

  struct Known {
    u64 n;
    u32 place;
    u32 asked_by;  // the interaction that waits for an answer, and alone may take it; kNone: none
  };
  Tables tables_;
  PriorityTables rules_;
  Placement placement_;
  NetworkFaults faults_;
  Network network_;
  Prng draws_;
  u64 limit_, steps_ = 0, border_ = 0, sent_ = 0, all_ = 0;
  std::vector<std::vector<u32>> ports_;      // by interaction
  std::vector<u32> protocol_;                // by interaction: node
  Csr interactions_;                         // by atom
  std::vector<std::map<u32, Known>> known_;  // by node: offers
  std::vector<std::vector<u64>> newest_;     // by node and atom: number of the newest offer
  std::vector<u64> participations_, used_;   // by atom
  std::vector<u32> place_;
  std::vector<std::uint8_t> asked_;       // by interaction
  std::vector<std::deque<u32>> working_;  // by node: components whose actions take their time
  std::deque<Outgoing> inside_;           // messages within a node
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  ThreeLayers(model::image(), static_cast<u32>(std::atoi(argv[1])), std::strtoull(argv[2], nullptr, 10),
              std::strtoull(argv[3], nullptr, 10))
      .run();
  return 0;
}
