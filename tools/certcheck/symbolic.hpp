// The system over Z3 terms: what a state is, which steps it has, what each leads to. Bits as the language has them; floats and
// calls of C++ are any value.
#pragma once
#include <functional>
#include <memory>
#include <optional>

#include <z3++.h>

#include "tools/certcheck/model.hpp"

namespace certcheck {

struct Local {
  std::vector<z3::expr> marks, slots;
};
using State = std::vector<Local>;
struct Step {
  z3::expr possible, fault, lost;  // lost: more internal transitions than are followed
  std::map<std::size_t, Local> next;  // of the atoms that may move
};
/// What code reads and writes.
struct Variables {
  std::function<z3::expr(std::size_t)> self, bind;
  std::function<void(std::size_t, const z3::expr&)> set_self, set_bind;
};

class Symbolic {
 public:
  Symbolic(const Model& model, z3::context& z) : m_(model), z_(z) {}
  [[nodiscard]] z3::expr truth(bool b) { return z_.bool_val(b); }
  [[nodiscard]] State any_state(const std::string& name);
  [[nodiscard]] State initial_state(z3::expr& fault);
  /// Ports, connectors and priorities in the state; null state: no step is asked for.
  void look(const State& state);
  [[nodiscard]] std::vector<Step> steps();
  [[nodiscard]] z3::expr evaluate(const Tree& e, const Variables& v, const z3::expr& when, z3::expr& fault);
  [[nodiscard]] z3::expr state_fault() const { return *state_fault_; }
  [[nodiscard]] z3::expr guard_fault() const { return *guard_fault_; }
  [[nodiscard]] z3::expr connector_can(std::size_t connector);

 private:
  struct Part {                    // of a connector's expanded tree
    Kind kind = Kind::Port;
    bool is_trigger = false, has_trigger = false, maximal = false;
    std::size_t use = 0, port = 0;  // kind Port, not a link
    bool is_link = false;
    std::vector<std::size_t> children;
  };
  struct Use {
    std::size_t connector = 0, root = 0;
    std::vector<std::size_t> params;
  };
  struct Expanded {
    std::vector<Part> parts;
    std::vector<Use> uses;
    bool is_plain = true;
  };
  using Leaves = std::set<std::size_t>;
  struct Store {
    std::map<std::size_t, Local> atoms;
    std::map<std::pair<std::size_t, std::size_t>, z3::expr> frames;  // use, slot
  };
  struct Candidate {
    std::size_t connector = 0;
    Expanded tree;
    std::vector<z3::expr> chosen;  // by part
    Store store;
    z3::expr possible;
  };

  [[nodiscard]] z3::expr about_state(const Tree& e);
  [[nodiscard]] z3::expr fresh(const std::string& type);
  [[nodiscard]] z3::expr zero(const std::string& type) { return type == "bool" ? truth(false) : z_.bv_val(0, 32); }
  void execute(const Tree* body, std::size_t first, const Variables& v, const z3::expr& when, z3::expr& fault);
  [[nodiscard]] Variables own(const AtomType& type, Local& local);
  [[nodiscard]] z3::expr marked(const Local& local, const std::vector<std::size_t>& places);
  void merge(const z3::expr& when, const Local& from, Local& into);
  void move(const AtomType& type, const Transition& t, Local& local, const z3::expr& when, z3::expr& fault);
  void invariants(const AtomType& type, Local& local, const z3::expr& when, z3::expr& fault);
  void internals(const AtomType& type, Local& local, z3::expr& fault, z3::expr& lost);
  void hide_ports(std::size_t atom);
  void fire(std::size_t port, Local& local, const z3::expr& when, z3::expr& fault, z3::expr& lost);
  std::size_t add_use(Expanded& tree, std::size_t connector, int depth);
  std::size_t add_group(Expanded& tree, std::size_t use, const Tree& group, int depth);
  std::size_t add_binding(Expanded& tree, std::size_t use, const Tree& binding, bool is_trigger, int depth);
  [[nodiscard]] bool list(const Expanded& tree, std::size_t part, std::vector<Leaves>& out) const;
  [[nodiscard]] std::vector<z3::expr> fixed(const Expanded& tree, const Leaves& leaves);
  [[nodiscard]] std::vector<z3::expr> largest(const Expanded& tree);
  [[nodiscard]] bool below(const Expanded& tree, std::size_t root, std::size_t part) const;
  [[nodiscard]] Variables variables(const Expanded& tree, std::size_t use, const std::vector<z3::expr>& chosen, Store& store);
  [[nodiscard]] z3::expr clause_is(const Use& use, const Tree& clause, const std::vector<z3::expr>& chosen);
  [[nodiscard]] z3::expr enabled(const Expanded& tree, std::size_t root, const Leaves* leaves, const std::vector<z3::expr>& chosen, Store& store);
  void fire_use(const Candidate& c, std::size_t use, Store& store, Step& step);
  [[nodiscard]] bool candidates(std::size_t connector, std::vector<Candidate>& out);
  [[nodiscard]] z3::expr matches(const Tree& rule, const char* side, const Candidate& c);
  void hide_candidates();

  const Model& m_;
  z3::context& z_;
  State now_;
  std::vector<std::vector<z3::expr>> going_;  // by atom, by transition
  std::vector<z3::expr> on_;                  // by port
  std::vector<Candidate> all_;
  std::optional<z3::expr> state_fault_, guard_fault_;
  bool is_complete_ = false;
};

}  // namespace certcheck
