// The system over Z3 terms: which steps it has in a state, and what each leads to. A connector without guards has one configuration,
// the largest, as terms; of the others all are listed. Guards, maximal progress and priorities decide which are candidates.
#pragma once
#include <list>

#include "tools/certcheck/terms.hpp"

namespace certcheck {

using State = std::vector<Local>;  // by atom
struct Step {
  z3::expr possible, offered, fault;  // offered: whatever priorities hide; shorter
  std::map<std::size_t, Local> next;  // of the atoms that may move
};

class System {
 public:
  System(const Model& model, const Terms& terms) : m_(model), t_(terms), state_fault_(terms.truth(false)), guard_fault_(state_fault_) {}
  /// The state that all else is said of.
  void look_at(const State& now);
  /// Who may step, and what is hidden; in faults from then on. Throws where there are too many to be listed.
  void find_candidates();
  /// Is there a step? What has too many interactions is seen by its smallest ones. Priorities only hide what something else outdoes.
  [[nodiscard]] z3::expr has_step();
  /// All steps, one by one.
  void each_step(const std::function<void(const Step&)>& visit);
  /// What a claim says of the state.
  [[nodiscard]] z3::expr claim(const Tree& e);
  /// The run has ended with an error in this state; with one in a connector's guard, too.
  [[nodiscard]] z3::expr state_fault() const { return state_fault_; }
  [[nodiscard]] z3::expr guard_fault() const { return guard_fault_; }

 private:
  using Parts = std::set<std::size_t>;             // nodes that take part in a configuration
  using Chosen = std::map<std::size_t, z3::expr>;  // by node of a connector's tree: does it take part?
  struct Store {
    std::map<std::size_t, Local> atoms, frames;  // by atom and by connector
    std::list<z3::expr> any;                     // variables of merged ports of which none is known to take part
  };
  struct Candidate {
    std::size_t node = 0;
    Chosen chosen;
    Store store;
    z3::expr possible, offered;
  };
  /// The tree of a connector, or of a port alone, parents before children, and what is known of it whatever the state is.
  struct Shape {
    Rows tree;
    bool is_plain = false;  // its largest configurations, as terms, are all that matter
    bool is_listed = false, is_complete = true;
    std::vector<Parts> all;  // configurations; only the smallest, where it is not complete
  };

  [[nodiscard]] const Shape& shape_of(std::size_t node, bool wants_list);
  [[nodiscard]] bool is_plain(const Rows& tree) const;
  [[nodiscard]] bool list(std::size_t node, bool only_smallest, std::vector<Parts>& out) const;
  [[nodiscard]] static bool is_larger(const Parts& a, const Parts& b);
  [[nodiscard]] Chosen choice_of(const Rows& tree, const Parts& parts) const;
  [[nodiscard]] Chosen largest(const Rows& tree) const;
  [[nodiscard]] Scope scope_of(std::size_t connector, const Chosen& chosen, Store& store);
  [[nodiscard]] z3::expr clause_is(const Connector& c, const Clause& clause, const Chosen& chosen) const;
  [[nodiscard]] z3::expr enabled(const Rows& tree, bool is_listed, const Chosen& chosen, Store& store);
  void add_candidates(std::size_t node);
  [[nodiscard]] z3::expr matches(const Tree& rule, bool is_high, const Candidate& c) const;
  void hide();
  void fire(const Candidate& c, std::size_t node, const z3::expr& when, Store& store, Step& step);
  Local& local_of(std::size_t atom, Store& store) { return store.atoms.try_emplace(atom, now_.at(atom)).first->second; }
  z3::expr& data(const Tree& of, Store& store);

  const Model& m_;
  const Terms& t_;
  std::map<std::size_t, Shape> shapes_;  // by node
  State now_;
  std::vector<Offer> offers_;
  std::vector<z3::expr> on_;  // by port
  std::vector<Candidate> all_;
  z3::expr state_fault_, guard_fault_;
  bool is_complete_ = false;  // all_: all candidates, and what hides them is known
};

}  // namespace certcheck
