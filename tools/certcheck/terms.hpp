// Code and atoms over Z3 terms: bits as the language has them; floats and what C++ gives are any value. An atom's state may be
// all constants, and then so is what it does: the same functions serve single modes and all states at once.
#pragma once
#include <functional>
#include <optional>

#include <z3++.h>

#include "tools/certcheck/model.hpp"

namespace certcheck {

[[nodiscard]] inline bool is(const z3::expr& e, bool value) { return value ? e.is_true() : e.is_false(); }
/// Connectives that fold constants; `simplify` of large terms is slow.
[[nodiscard]] z3::expr both(const z3::expr& a, const z3::expr& b);
[[nodiscard]] z3::expr either(const z3::expr& a, const z3::expr& b);
[[nodiscard]] z3::expr no(const z3::expr& a);
[[nodiscard]] z3::expr choose(const z3::expr& when, const z3::expr& yes, const z3::expr& otherwise);

/// An atom's state.
struct Local {
  std::vector<z3::expr> marks, slots;
};
/// What it can do: its transitions (internal ones: false) and ports, after the atom's priorities.
struct Offer {
  std::vector<z3::expr> transitions, ports;
};
/// What code reads and writes; `about` is for claims (at …), (can …).
struct Variables {
  std::function<z3::expr(std::size_t)> self, bind;
  std::function<void(std::size_t, const z3::expr&)> set_self, set_bind;
  std::function<z3::expr(const Tree&)> about;
};
/// Where a run ends with an error; where more internal transitions follow than are looked at.
struct Trouble {
  explicit Trouble(z3::context& z) : fault(z.bool_val(false)), lost(fault) {}
  z3::expr fault, lost;
};

class Terms {
 public:
  Terms(const Model& model, z3::context& z) : m_(model), z_(z), solver_(z, "QF_BV") {}
  /// What `may_be` takes for granted from now on; what speaks of one atom alone may say so.
  void assume(const z3::expr& e, std::size_t atom = kNone);
  /// Throws where the solver gives up.
  [[nodiscard]] bool may_be(const z3::expr& e);
  /// The same with what is assumed of these atoms alone: much quicker, and false only where `may_be` is, too.
  [[nodiscard]] bool may_be_alone(const z3::expr& e, const std::map<std::size_t, Local>& atoms);

  [[nodiscard]] z3::expr truth(bool b) const { return z_.bool_val(b); }
  /// A constant of its own, of a type of variables.
  [[nodiscard]] z3::expr fresh(std::string_view type) const;
  /// The value that a variable begins with.
  [[nodiscard]] z3::expr first(std::string_view type) const { return is_exact(type) ? constant(type, 0) : fresh(type); }
  /// An int, a bool or the row of a string.
  [[nodiscard]] z3::expr constant(std::string_view type, int value) const { return type == "bool" ? truth(value != 0) : z_.bv_val(value, 32); }
  /// Of a term that is one; nothing of all others.
  [[nodiscard]] static std::optional<int> value(const z3::expr& e);

  [[nodiscard]] z3::expr evaluate(const Tree& e, const Variables& v, const z3::expr& when, z3::expr& fault) const;
  /// Of (guard EXPR); an empty list holds.
  [[nodiscard]] z3::expr holds(const Tree& guard, const Variables& v, const z3::expr& when, z3::expr& fault) const;
  /// The statements of a list after its head.
  void execute(const Tree& body, const Variables& v, const z3::expr& when, z3::expr& fault) const;
  [[nodiscard]] Variables own(const AtomType& type, Local& local) const;

  /// Marks and values as these tell, but for parameters; of what they don't know anything.
  [[nodiscard]] Local local(const Atom& atom, const std::function<z3::expr(std::size_t)>& mark, const std::function<z3::expr(std::size_t)>& value) const;
  [[nodiscard]] Local initial(const Atom& atom, Trouble& trouble) const;
  [[nodiscard]] Offer offer(const AtomType& type, Local& local, z3::expr& fault) const;
  /// The slots have the values that are known.
  [[nodiscard]] z3::expr has_values(const AtomType& type, const Local& local, const std::vector<std::optional<int>>& values) const;
  /// Takes the transition and the internal ones that follow, from where `when` holds.
  void take(const AtomType& type, const Transition& t, Local& local, const z3::expr& when, Trouble& trouble) const;
  /// Fires a port of the offer.
  void fire(const AtomType& type, const Offer& offer, std::size_t port, Local& local, const z3::expr& when, Trouble& trouble) const;

 private:
  void move(const AtomType& type, const Transition& t, Local& local, const z3::expr& when, z3::expr& fault) const;
  void check_invariants(const AtomType& type, Local& local, const z3::expr& when, z3::expr& fault) const;
  void settle(const AtomType& type, Local& local, const z3::expr& when, Trouble& trouble) const;
  void hide(const AtomType& type, Local& local, std::vector<z3::expr>& ports, z3::expr& fault) const;
  [[nodiscard]] z3::expr marked(const Local& local, const Rows& places) const;

  const Model& m_;
  z3::context& z_;
  z3::solver solver_;
  std::map<std::size_t, std::vector<z3::expr>> assumed_;  // by atom
};

}  // namespace certcheck
