// A system as a net that counts: how many of like components are in each local state.
//
// A *kind* is one component, or all members of a group of interchangeable ones. Its local states (marking and data,
// exact, as the core has them) are the places of the net; a place holds as many tokens as there are components of this
// kind in this local state. What an interaction does is a function of the local states of the atoms that it depends on
// (runtime/explore/shapes.hpp), so each combination of these that has a candidate, fired by the core, is a transition:
// it takes one token from the place of each of these atoms and puts one into its next place. Of the interactions that a
// permutation maps to each other one is tabulated. Every reachable state of the system is a reachable marking of the
// net; the net may reach more, as it forgets which of several atoms of a member belong together. Ints wrap as the core
// has it.
//
// Counter abstraction: A. Pnueli, J. Xu, L. Zuck, Liveness with (0, 1, infinity)-Counter Abstraction (CAV 2002); S.
// German, A. P. Sistla, Reasoning about Systems with Many Processes (1992), with exact counts. Cost: a step of the core
// for each combination of local states whose ports are enabled.
#pragma once
#include <string>
#include <vector>

#include "compiler/verify/solver/cancellation.hpp"
#include "runtime/explore/locals.hpp"
#include "runtime/explore/shapes.hpp"

namespace bip::verify {

using rt::u32;

/// By group and member its atoms, those of all members of a group in one order (rt::interchangeable_members).
using InterchangeableGroups = std::vector<std::vector<std::vector<u32>>>;

struct CountedNet {
  static constexpr u32 kNone = ~u32{0};
  /// Places, sorted; a place stands as often as it has tokens that are taken or put. As many `from` as `to`.
  struct Transition {
    std::vector<u32> from, to;
  };
  struct Place {
    u32 kind = 0, local = 0;  // local: number in the table of local states
  };

  std::vector<Place> places;
  std::vector<std::vector<u32>> places_of_kind;
  std::vector<u32> kind_of_atom;
  std::vector<u32> atom_of_kind;  // one of them
  std::vector<u32> tokens;        // by place, initially
  std::vector<Transition> transitions;
  std::string problem;  // why it is not complete; empty: it is
};

struct CountedNetLimits {
  CancellationToken cancellation;
  std::size_t places = 4'000, transitions = 200'000;
};

/// Makes the net, and evaluates conditions about local states of single components.
class CountedNetBuilder {
 public:
  /// `image` has its code and neither time nor C++ nor priorities; it must outlive the builder. `groups`: exchanging
  /// two members of one is an automorphism. `unread_cells`: of no local state.
  CountedNetBuilder(const rt::Image& image, const InterchangeableGroups& groups,
                    const std::vector<rt::VariableId>& unread_cells);

  /// Explores local states until there are no more. Once.
  void build(const CountedNetLimits& limits);
  [[nodiscard]] const CountedNet& net() const { return net_; }
  /// Puts the core to a state in which these atoms have the local states of these places and all others the initial
  /// ones; no interaction is evaluated. False: a fault.
  [[nodiscard]] bool enter_atoms(const std::vector<u32>& atoms, const std::vector<u32>& places);
  [[nodiscard]] const rt::Core& core() const { return core_; }

 private:
  // One interaction that stands for all that permutations map it to.
  struct Tabulated {
    rt::InteractionId interaction;
    std::vector<u32> atoms;
    std::vector<std::size_t> explored;  // by atom: so many places of its kind were combined with each other
  };

  void choose_interactions(const InterchangeableGroups& groups);
  u32 place_of(u32 kind, u32 local);
  [[nodiscard]] bool is_offered(u32 place, u32 port) const;
  void write(u32 atom, u32 place) { locals_.write(atom, net_.places[place].local, scratch_); }
  bool explore(Tabulated& row, const CountedNetLimits& limits);
  bool combine(Tabulated& row, std::size_t newest, std::size_t position, std::vector<u32>& chosen,
               const CountedNetLimits& limits);
  bool fire(const Tabulated& row, const std::vector<u32>& chosen, const CountedNetLimits& limits);
  bool give_up(const std::string& problem);

  const rt::Image& image_;
  rt::Core core_;
  bool is_initial_sound_;
  rt::Locals locals_;
  rt::Shapes shapes_;
  rt::State scratch_;
  std::vector<u32> initial_;  // by atom: its number
  CountedNet net_;
  std::vector<std::vector<u32>> place_by_local_;    // by kind and number
  std::vector<std::vector<std::uint8_t>> offered_;  // by place and port
  std::vector<std::vector<std::size_t>> watchers_;  // by kind: rows of tabulated_
  std::vector<Tabulated> tabulated_;
  u32 combinations_ = 0;
};

}  // namespace bip::verify
