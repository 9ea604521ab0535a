// The steps of a system as few of its components see them, value by value: each component has local states by regions
// (local_space.hpp), in which each value of a variable with few of them is a region of its own, the same in all
// neighbourhoods.
//
// A step is an interaction of a plain rendezvous, or a port that moves by itself. Components that are not followed have
// any values that they ever have. What a step does to local states is computed once. Cost: the tuples of local states
// that are asked for.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "compiler/verify/liveness/faultless_code.hpp"
#include "compiler/verify/regions/local_space.hpp"
#include "compiler/verify/regions/region_step.hpp"
#include "compiler/verify/solver/cancellation.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

class NeighbourhoodSteps {
 public:
  static constexpr u32 kMostMembers = 3;
  struct Member {
    u32 atom = 0, state = 0;
    friend bool operator==(const Member&, const Member&) = default;
  };
  /// Those that are followed of a step, ascending.
  class Members {
   public:
    void add(Member member) {
      BIP_ASSERT(count_ < kMostMembers, "more than {} members of a step", kMostMembers);
      members_[count_++] = member;
    }
    [[nodiscard]] std::size_t size() const { return count_; }
    [[nodiscard]] const Member& operator[](std::size_t row) const { return members_[row]; }
    [[nodiscard]] const Member* begin() const { return members_.data(); }
    [[nodiscard]] const Member* end() const { return members_.data() + count_; }

   private:
    std::array<Member, kMostMembers> members_{};
    std::size_t count_ = 0;
  };
  /// By member its next state.
  using Move = std::array<u32, kMostMembers>;

  /// Requires is_plain_rendezvous(), no C++ and no time. Connectors' steps have their numbers.
  NeighbourhoodSteps(const System& system, const rt::Image& image);

  [[nodiscard]] u32 size() const { return static_cast<u32>(atoms_of_.size()); }
  /// The steps that a component takes part in, and the components that take part in a step, ascending.
  [[nodiscard]] const std::vector<u32>& steps_of(u32 atom) const { return steps_of_[atom]; }
  [[nodiscard]] const std::vector<u32>& atoms_of(u32 step) const { return atoms_of_[step]; }
  /// Is it a connector's, so that its number is that of the connector?
  [[nodiscard]] bool is_connector(u32 step) const { return step < net_.system->connectors.size(); }
  /// The port with which a component takes part in a step.
  [[nodiscard]] u32 port_of(u32 step, u32 atom) const;
  [[nodiscard]] const RegionNet& net() const { return net_; }
  [[nodiscard]] const FaultlessCode& faultless() const { return faultless_; }

  /// Returns the local states of a component, explored at the first call; null: they are too many, or the time is over.
  [[nodiscard]] const LocalSpace* space(u32 atom, const CancellationToken& cancellation);
  /// The states of a component, whose space is there, that it may be in at first.
  [[nodiscard]] std::vector<u32> initial(u32 atom) { return spaces_[atom]->initial(); }
  /// Returns what the followed components that take part in a step may do together. `members`: those, at least one;
  /// their spaces are there. Each move once.
  [[nodiscard]] const std::vector<Move>& moves(u32 step, const Members& members);
  /// Is the step possible for sure, and does it end in no error? `members` as above, and all that take part.
  [[nodiscard]] bool is_sure(u32 step, const Members& members);

 private:
  using Key = std::array<u32, 2 * kMostMembers + 1>;
  struct KeyHash {
    std::size_t operator()(const Key& key) const;
  };
  [[nodiscard]] static Key key_of(u32 step, const Members& members);
  // What a port of a component is in a local state.
  enum Offer : std::uint8_t { kNo, kMaybe, kSurely };
  [[nodiscard]] Offer offer(const Member& member, u32 port);
  // Can the step never be taken, because one of them is in its state?
  [[nodiscard]] bool is_excluded_by_one(u32 step, const Members& members);
  [[nodiscard]] bool excludes(u32 step, std::size_t row, const Member& member);
  [[nodiscard]] std::size_t row_in(u32 step, u32 atom) const;
  std::unique_ptr<LocalSpace> explore(u32 atom, const CancellationToken& cancellation) const;
  [[nodiscard]] std::vector<Move> find_moves(u32 step, const Members& members);
  [[nodiscard]] bool is_guard_sure(u32 step, const Members& members) const;
  void bind(RegionStep& step, const Members& members) const;

  RegionNet net_;
  FaultlessCode faultless_;
  std::vector<std::vector<u32>> steps_of_, atoms_of_;
  std::vector<std::unique_ptr<LocalSpace>> spaces_;
  std::vector<std::uint8_t> is_explored_;   // by atom
  std::vector<std::vector<Offer>> offers_;  // by atom: by state and port
  std::vector<std::vector<u32>> ports_;     // by step: of its atoms
  // By step and row of its atoms: by state of the atom, as far as was asked.
  enum Exclusion : std::uint8_t { kUnknown, kPossible, kExcluded };
  std::vector<std::vector<std::vector<Exclusion>>> exclusions_;
  const std::vector<Move> no_moves_;
  std::unordered_map<Key, std::vector<Move>, KeyHash> moves_;
  std::unordered_map<Key, bool, KeyHash> sure_;
};

}  // namespace bip::verify
