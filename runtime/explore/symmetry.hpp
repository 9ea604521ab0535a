// Components that may change places: states that differ only by such a permutation count as one.
//
// A family is a component array, `c[0] … c[n-1]` (or several arrays of one compound that go together). Two of its
// members are interchangeable if exchanging them, with all that is inside, maps every connector onto a connector: same
// type, same ports, same arguments of the atoms. That is checked for each pair that is used, so the permutations of a
// group are automorphisms of the system and its quotient has the same deadlocks and errors up to permutation (Ip, Dill
// 1996; Clarke, Emerson, Jha, Sistla 1998). The representative of a state has the members of each group in ascending
// order.
#pragma once
#include <vector>

#include "runtime/explore/locals.hpp"

namespace bip::rt {

class Symmetry {
 public:
  /// Finds the groups. Systems with priority rules have none.
  Symmetry(const Image& image, const Locals& locals);

  /// No two members of any array are interchangeable.
  [[nodiscard]] bool is_trivial() const { return groups_.empty(); }
  /// "worker[0..7]", for people.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// Replaces the state by its representative. scratch: of the caller's thread.
  void normalize(u64* state, const Layout& layout, std::vector<u64>& scratch) const;

 private:
  struct Group {
    u32 members = 0, width = 0;  // width: atoms of a member
    std::vector<u32> atoms;      // member after member
  };
  std::vector<Group> groups_;
  std::vector<std::string> names_;
};

}  // namespace bip::rt
