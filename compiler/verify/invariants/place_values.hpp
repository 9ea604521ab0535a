// Ints that have one value wherever their atom is at a place: "machine.sum is 0 at CARD_IN, 20 at CHOSEN".
// What an assignment takes away is then known (affine_invariants.hpp), though no guard says so.
//
// A fixpoint over all atoms and connectors from the initial places on; guards of the form `n == 4` and transfers of
// plain rendezvous are followed, what else may be written is unknown. Only automata are looked at, one place at a time.
// Cost: a few passes over the code of all instances. G. Kildall: A Unified Approach to Global Program Optimization
// (1973).
#pragma once
#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/net/net.hpp"

namespace bip::verify {

struct PlaceValue {
  u32 atom = 0, place = 0, variable = 0;
  std::int32_t value = 0;
};
struct PlaceValues {
  std::vector<PlaceValue> rows;                       // by atom and place; ints that are stored somewhere
  std::vector<std::vector<std::uint8_t>> is_reached;  // by atom, by place; empty: not looked at
};

[[nodiscard]] PlaceValues find_place_values(const Net& net, const std::vector<std::uint8_t>& is_automaton);
/// A rendezvous of different atoms with one transfer and nothing else, or without any transfer: what it writes is
/// decided there alone.
[[nodiscard]] bool has_plain_transfer(const System& system, const Connector& connector);
[[nodiscard]] bool stores_into_ports(const CodeTable& code, StmtId body);

}  // namespace bip::verify
