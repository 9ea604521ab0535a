// The work of build_transition_system, shared by its files: atoms, connectors, priorities.
#pragma once
#include <map>
#include <memory>
#include <optional>

#include "compiler/verify/symbolic/transition_system.hpp"
#include "compiler/verify/net/net.hpp"
#include "runtime/core/link/priorities.hpp"

namespace bip::verify {

class TransitionSystemBuilder {
 public:
  TransitionSystemBuilder(const System& system, const rt::Image& image)
      : system_(system),
        image_(image),
        tables_(rt::link(image, rt::MaximalProgress::On)),
        aig_(transition_system_.aig),
        code_(aig_, system.code) {}
  TransitionSystem build();

 private:
  static constexpr std::size_t kMaxConfigurations = 512, kMaxTree = 50000;
  static constexpr u32 kMaxDepth = 200, kMaxInternals = 24;

  /// The state of one atom.
  struct Local {
    std::vector<Signal> marks;
    std::vector<Word> variables;
  };
  /// What firing a port leads to.
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

  // connector_tree.cpp
  enum class Kind : std::uint8_t { Group, Leaf, Link, Choice };
  struct Node {
    Kind kind = Kind::Group;
    bool is_trigger = false, has_trigger = false, maximal_only = false;
    u32 use = 0;   // the use it belongs to; Link: the one it leads to
    u32 port = 0;  // Leaf: instance
    std::vector<u32> children;
  };
  struct Use {
    u32 connector = 0, root = 0;
    std::vector<u32> param_nodes;  // by param
  };
  struct Tree {
    std::vector<Node> nodes;  // parents before children
    std::vector<Use> uses;    // parents before children
    bool is_plain = true;     // neither guards nor merged ports with values
    bool is_too_large = false;
  };
  using Leaves = std::vector<u32>;  // nodes, sorted
  /// What a step writes before atoms fire: atoms that it touches, and connectors' own data.
  struct Store {
    std::map<u32, Local> atoms;
    std::map<u32, Word> frames;  // by row among all variables
  };
  // encode_connectors.cpp
  void add_connectors();
  void add_internal_ports();
  void add_connector(u32 variable, u32 connector);
  u32 add_use(Tree& tree, u32 connector, u32 depth);
  u32 add_binding(Tree& tree, const PortRef& ref, u32 use, bool is_trigger, u32 depth);
  u32 bind_param(Tree& tree, const Connector& connector, u32 param, u32 use, bool is_trigger, u32 depth);
  [[nodiscard]] bool has_free_choices(const Tree& tree) const;
  void choose_one(const std::vector<u32>& rows, const std::vector<Signal>& available, Signal when,
                  std::vector<Signal>& chosen);
  [[nodiscard]] bool configurations(const Tree& tree, u32 node, std::vector<Leaves>& out) const;
  [[nodiscard]] std::vector<Signal> fixed_choice(const Tree& tree, const Leaves& leaves) const;
  [[nodiscard]] std::vector<Signal> largest_choice(const Tree& tree);
  [[nodiscard]] Signal is_enabled(const Tree& tree, u32 root, const Leaves& leaves, bool fixed,
                                  const std::vector<Signal>& chosen, Store& store);
  [[nodiscard]] bool is_below(const Tree& tree, u32 root, u32 node) const;
  [[nodiscard]] std::vector<Signal> clause_choice(const Tree& tree, const Use& use, const std::vector<Signal>& chosen);
  [[nodiscard]] Variables variables_of(const Tree& tree, const Use& use, const std::vector<Signal>& chosen,
                                       Store& store);
  [[nodiscard]] Local& local_in(Store& store, u32 atom);
  void fire_use(const Tree& tree, u32 use, const std::vector<Signal>& chosen, Store& store,
                const std::vector<std::vector<Signal>>& clauses, SystemStep& step, Signal& fault, Signal& lost);
  void add_step(u32 variable, const Tree& tree, const std::vector<Signal>& chosen, Store store, Signal candidate);
  void record(Signal when, u32 port, const Local& before, const Post& post);

  // encode_priorities.cpp
  void apply_priorities();
  [[nodiscard]] Signal matches(const rt::Priority& rule, bool high, const SystemStep& step,
                               const std::vector<Signal>& params);

  const System& system_;
  const rt::Image& image_;
  rt::Tables tables_;
  TransitionSystem transition_system_;
  Aig& aig_;
  SymbolicCode code_;
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
