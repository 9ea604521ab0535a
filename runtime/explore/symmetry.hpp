// Components that may change places: states that differ only by such a permutation count as one.
//
// A family is a component array, `c[0] … c[n-1]` (or several arrays of one compound that go together). Two of its
// members are interchangeable if exchanging them, with all that is inside, maps every connector onto a connector: same
// type, same ports, same arguments of the atoms. That is checked for each pair that is used, so the permutations of a
// group are automorphisms of the system and its quotient has the same deadlocks and errors up to permutation (Ip, Dill
// 1996; Clarke, Emerson, Jha, Sistla 1998). The representative of a state has the members of each group in ascending
// order. A predicate on states restricts the exchanges to those that preserve it (Clarke, Enders, Filkorn, Jha 1996),
// so that it holds in a state exactly if it holds in the representative.
//
// Members with equal local states are neighbours in a representative. Exchanging two of them preserves the state, so of
// the interactions that each have with the same other components only those of the first member are expanded.
#pragma once
#include <span>
#include <vector>

#include "runtime/explore/explore.hpp"
#include "runtime/explore/locals.hpp"
#include "runtime/explore/shapes.hpp"

namespace bip::rt {

class Symmetry {
 public:
  /// Finds the groups. Systems with priority rules have none, nor has what takes more work than the limits allow.
  Symmetry(const Image& image, const Locals& locals, const SymmetryLimits& limits = {});

  /// Removes the first member of each group, which is then never permuted: each component that still is has an
  /// automorphism that maps it to one that is not.
  void fix_first_members();

  /// No two members of any array are interchangeable.
  [[nodiscard]] bool is_trivial() const { return groups_.empty(); }
  /// "worker[0..7]", for people.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// Replaces the state by its representative. scratch: of the caller's thread.
  void normalize(u64* state, const Layout& layout, std::vector<u64>& scratch) const;
  /// The same of the numbers of all atoms. Returns whether any has changed.
  bool normalize(std::vector<u32>& numbers, std::vector<u64>& scratch) const;
  /// By group and member its atoms, those of all members in one order.
  [[nodiscard]] std::vector<std::vector<std::vector<u32>>> members() const;
  /// Returns the atoms that are permuted, in no order.
  [[nodiscard]] std::vector<u32> permuted_atoms() const;

  /// Prepares multiplicity(). Linear in the interactions' atoms.
  void index_interactions(const Shapes& shapes);
  /// By member of all groups: how many have its local states, if it is the first of them; else 0. `state`: a
  /// representative.
  void find_equal_members(const u64* state, const Layout& layout, std::vector<u32>& counts) const;
  /// Returns how many interactions lead to the same representatives as this one does, itself included; 0: another one
  /// counts for it.
  [[nodiscard]] u64 multiplicity(InteractionId interaction, const std::vector<u32>& counts) const {
    u64 product = 1;
    for (const u32 member : lone_members_[interaction]) product *= counts[member];
    return product;
  }

 private:
  struct Group {
    u32 members = 0, width = 0;       // width: atoms of a member
    std::vector<u32> atoms;           // member after member
    std::vector<std::string> arrays;  // "worker"; of members of several arrays "client", "session"
    std::vector<u32> indices;         // by member
  };
  template <class Get, class Set>
  static bool sort_members(const Group& group, const Get& get, const Set& set, std::vector<u64>& scratch);
  void name_groups();

  std::vector<Group> groups_;
  std::vector<std::string> names_;
  // By interaction: members (numbered over all groups) that are the only ones of their group in it.
  IndexVector<InteractionId, std::vector<u32>> lone_members_;
};

}  // namespace bip::rt
