// Localization abstraction: a few components of a system as a system of their own, in an environment that may do
// anything. An over-approximation: whatever the whole does, seen through these components, the local system does at the
// same instants.
//
// R. Kurshan: Computer-Aided Verification of Coordinating Processes (1994), section 8.1, localization reduction. E.
// Clarke, O. Grumberg, S. Jha, Y. Lu, H. Veith: Counterexample-Guided Abstraction Refinement (2000): prove_time.hpp
// adds neighbours where an answer stays open.
//
// A connector whose components are all members is copied. Of any other one the member ports are left, as lazy
// (non-urgent) steps that may be taken whenever these ports are enabled: a rendezvous of all of them, or, where
// triggers, merged ports or other connectors decide which components take part, each subset. The guard of a rendezvous
// is weakened to the conjuncts that members and constant data of others decide (localize_guard.hpp). Priorities only
// hide steps and are left out, together with the urgency of what they might hide. A connector that writes data that is
// read, or lets members resume together, cannot be localized: its components are reported as required members. Names
// and places in the source are left out, so that equal local systems have equal texts.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "compiler/system/system.hpp"
#include "compiler/verify/net/abstract_code.hpp"
#include "compiler/verify/property/property.hpp"

namespace bip::verify {

using u32 = std::uint32_t;

/// The neighbour relation: the connectors whose interactions are steps, with all components below them.
class Neighbours {
 public:
  struct Leaf {
    u32 atom = 0, port = 0;
    friend auto operator<=>(const Leaf&, const Leaf&) = default;
  };
  struct Top {
    ConnectorId connector;
    std::vector<Leaf> leaves;                  // sorted
    std::vector<u32> atoms;                    // sorted; with those whose data it reads
    std::vector<u32> tree;                     // rows of the connectors in it, ascending
    std::vector<std::pair<u32, u32>> written;  // atom, variable: what it writes
    bool is_plain = true;                      // a rendezvous of atoms' ports
    bool is_sync = false;
  };
  explicit Neighbours(const System& system);
  [[nodiscard]] const std::vector<Top>& tops() const { return tops_; }
  /// Returns the rows of tops that an atom belongs to, ascending.
  [[nodiscard]] const std::vector<u32>& tops_of(u32 atom) const { return of_atom_[atom]; }

 private:
  void walk(const System& system, Top& top);
  std::vector<Top> tops_;
  std::vector<std::vector<u32>> of_atom_;
};

struct LocalizedSystem {
  std::string obstacle;       // not empty: why these members cannot be localized
  std::vector<u32> required;  // not empty: no system; these atoms have to be members, too
  System system;
  std::vector<u32> members;            // by atom of the local system: its row in the whole; ascending
  std::vector<std::uint8_t> is_whole;  // by connector of the local system: it is a copy
};

/// Returns the value of an atom's variable where it is known.
using VariableFacts = std::function<AbstractValue(u32 atom, u32 variable)>;

/// Localizes a system to some members (ascending rows of atoms). `is_read`: find_read_data of the whole. `constant`:
/// the values that never change. Cost: the types and connectors of the members, and a copy of the code.
[[nodiscard]] LocalizedSystem localize(const System& whole, const Neighbours& neighbours,
                                       const std::vector<std::vector<std::uint8_t>>& is_read,
                                       const VariableFacts& constant, const std::vector<u32>& members);

/// Adds a rendezvous of ports of atoms of a local system, given by their rows there, with the guard or `down` of the
/// clause, if it has any. `name`: of its type and its path, before a number.
void add_rendezvous(System& to, const std::string& name, const std::vector<Neighbours::Leaf>& leaves, Clause clause);
/// Translates a property of the members to their rows in the local system.
[[nodiscard]] Property localize(Property property, const std::vector<u32>& members);

/// May the guard of a rendezvous be true for these values of its atoms? Of other connectors: yes.
[[nodiscard]] bool may_hold(const System& system, const Neighbours::Top& top, const VariableFacts& value);

}  // namespace bip::verify
