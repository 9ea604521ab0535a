// The work of build_transition_system, shared by its files: atoms, connectors, priorities.
#pragma once
#include <algorithm>
#include <map>
#include <memory>
#include <optional>

#include "compiler/analysis/interaction_tree.hpp"
#include "compiler/verify/net/net.hpp"
#include "compiler/verify/symbolic/transition_system.hpp"
#include "runtime/core/link/priorities.hpp"

namespace bip::verify {

class TransitionSystemBuilder {
 public:
  TransitionSystemBuilder(const System& system, const rt::Image& image, std::size_t megabytes,
                          const CancellationToken& cancellation)
      : system_(system),
        image_(image),
        tables_(rt::link(image, rt::MaximalProgress::On)),
        aig_(transition_system_.aig),
        code_(aig_, system.code),
        megabytes_(megabytes),
        cancellation_(cancellation) {
    aig_.set_bound(std::min(Aig::kMostNodes, megabytes * 1000000 / Aig::kBytesPerNode));
  }
  TransitionSystem build();

 private:
  /// Of one connector with guards, and nodes of the tree of one connector: they grow with the memory. Each two
  /// interactions are compared, which takes seconds for the most that there may be.
  [[nodiscard]] std::size_t most_interactions() const { return std::clamp<std::size_t>(megabytes_, 512, 16'384); }
  [[nodiscard]] std::size_t most_nodes() const { return std::max<std::size_t>(1000, megabytes_ * 1000); }

  /// The state of one atom.
  struct Local {
    std::vector<Signal> marks;
    std::vector<Word> variables;
  };
  /// What firing a port participants to.
  struct Post {
    Local local;
    Signal fault = kFalse, lost = kFalse;
  };
  struct Move {
    Signal when = kFalse;
    Local to;
  };

  // encode_atoms.cpp
  void add_state();
  void add_ports();
  void hide_ports(u32 atom);
  [[nodiscard]] const AtomType& type_of(u32 atom) const {
    return system_.atom_types[system_.atoms[AtomId(std::size_t{atom})].type];
  }
  [[nodiscard]] Variables variables_of(Local& local) const;
  [[nodiscard]] Signal marked(const Local& local, const std::vector<u32>& places);
  void move(u32 atom, const Transition& t, Local& local, Signal when, Signal& fault);
  void check_invariants(u32 atom, Local& local, Signal when, Signal& fault);
  void run_internals(u32 atom, Local& local, Signal& fault, Signal& lost);
  [[nodiscard]] Post fire(u32 port, const Local& before);
  void merge(Signal when, const Local& from, Local& into);
  void finish_state();
  [[nodiscard]] Signal fits(const Word& word, const Range& range);

  // encode_connectors.cpp
  using Tree = analysis::InteractionTree;
  using Node = Tree::Node;
  using Use = Tree::Use;
  using Kind = Tree::Kind;
  using Leaves = analysis::Leaves;
  /// What a step writes before atoms fire: atoms that it touches, and connectors' own data.
  struct Store {
    std::map<u32, Local> atoms;
    std::map<u32, Word> frames;  // by row among all variables
  };
  enum class Participants : std::uint8_t { Given, OfState };  // OfState: a function of the state
  enum class RuleSide : std::uint8_t { Low, High };
  void add_connectors();
  void add_internal_ports();
  void add_connector(rt::InteractionId interaction, u32 connector);
  [[nodiscard]] u32 port_of(const Node& leaf) const { return tables_.instance(leaf.atom.value, leaf.port); }
  [[nodiscard]] bool is_plain(const Tree& tree) const;
  [[nodiscard]] bool has_free_choices(const Tree& tree) const;
  void choose_one(const std::vector<u32>& rows, const std::vector<Signal>& available, Signal when,
                  std::vector<Signal>& chosen);
  [[nodiscard]] std::vector<Signal> fixed_choice(const Tree& tree, const Leaves& leaves) const;
  [[nodiscard]] std::vector<Signal> largest_choice(const Tree& tree);
  [[nodiscard]] Signal is_enabled(const Tree& tree, u32 root, const Leaves& leaves, Participants participants,
                                  const std::vector<Signal>& chosen, Store& store);
  [[nodiscard]] std::vector<Signal> clause_choice(const Tree& tree, const Use& use, const std::vector<Signal>& chosen);
  [[nodiscard]] Variables variables_of(const Tree& tree, const Use& use, const std::vector<Signal>& chosen,
                                       Store& store);
  [[nodiscard]] Local& local_in(Store& store, u32 atom);
  void fire_use(const Tree& tree, u32 use, const std::vector<Signal>& chosen, Store& store,
                const std::vector<std::vector<Signal>>& clauses, SystemStep& step, Signal& fault, Signal& lost);
  void add_step(rt::InteractionId interaction, const Tree& tree, const std::vector<Signal>& chosen, Store store,
                Signal candidate);
  void record(Signal when, u32 port, const Local& before, const Post& post);

  // encode_priorities.cpp
  [[nodiscard]] Signal final_state();
  void apply_priorities();
  [[nodiscard]] Signal matches(const rt::Priority& rule, RuleSide side, const SystemStep& step,
                               const std::vector<Signal>& params);

  const System& system_;
  const rt::Image& image_;
  rt::Tables tables_;
  TransitionSystem transition_system_;
  Aig& aig_;
  SymbolicCode code_;
  std::size_t megabytes_;
  CancellationToken cancellation_;
  std::vector<Local> now_;                      // by atom
  std::vector<std::vector<Signal>> enabled_;    // by atom, by transition
  std::vector<std::optional<Post>> posts_;      // by port: fired from the state as it is
  std::vector<Signal> fired_plainly_;           // by port: when a step fires it so
  std::vector<std::vector<Move>> moves_;        // by atom: other ways to move
  std::vector<std::vector<Signal>> params_;     // by step: its connector's parameters that take part
  std::vector<Signal> step_fault_, step_lost_;  // by step
  std::vector<u32> atom_of_cell_;               // by variable of atoms
  Signal state_fault_ = kFalse, guard_fault_ = kFalse;
};

}  // namespace bip::verify
