// A few components of a system as a system of their own, in which the others may do anything: what the whole does, seen
// through these components, the part does, too, at the same instants.
//
// A connector all of whose components are in the part stays what it is. Of any other only its ports in the part are
// left, as steps that may be taken whenever these are enabled and that nobody is in a hurry to take: a rendezvous of
// all of them, or, where triggers, merged ports or other connectors decide who takes part, each set of them. Of a
// rendezvous' guard stays what is decided in the part and by data of others that never change. Rules between connectors
// only hide steps and are left out, with the urgency of what they might hide. What a cut connector would write into
// data that is read, or let resume together, cannot be cut: the components that belong to it are told instead. Names
// and places in the source are left out: parts that are alike are equal.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "compiler/system/system.hpp"
#include "compiler/verify/net/abstract_code.hpp"

namespace bip::verify {

using u32 = std::uint32_t;

/// Who takes part in what: the connectors whose interactions are steps, with all components that are below them.
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
  /// Rows of tops that an atom belongs to, ascending.
  [[nodiscard]] const std::vector<u32>& tops_of(u32 atom) const { return of_atom_[atom]; }

 private:
  void walk(const System& system, Top& top);
  std::vector<Top> tops_;
  std::vector<std::vector<u32>> of_atom_;
};

struct LocalizedSystem {
  std::string problem;      // not empty: it cannot be cut out
  std::vector<u32> needed;  // not empty: only with these atoms, too
  System system;
  std::vector<u32> members;            // by atom of the part: its row in the whole; ascending
  std::vector<std::uint8_t> is_whole;  // by connector of the part
};

/// What is known of an atom's variable.
using KnownVariable = std::function<AbstractValue(u32 atom, u32 variable)>;

/// members: ascending rows of atoms. is_read: find_read_data of the whole. constant: of what never changes.
[[nodiscard]] LocalizedSystem localize(const System& whole, const Neighbours& neighbours,
                                       const std::vector<std::vector<std::uint8_t>>& is_read,
                                       const KnownVariable& constant, const std::vector<u32>& members);

/// May the guard of a rendezvous be true where this is known of its atoms? Of others than rendezvous: yes.
[[nodiscard]] bool may_hold(const System& system, const Neighbours::Top& top, const KnownVariable& value);

}  // namespace bip::verify
