// Code and atoms over Z3 terms: bits as the language has them; floats and what C++ gives are any value. An atom's state may be
// all constants, and then so is what it does: the same functions serve single modes and all states at once.
#pragma once
#include <functional>
#include <span>

#include <z3++.h>

#include "tools/certcheck/certificate.hpp"

namespace certcheck {

[[nodiscard]] inline bool is(const z3::expr& e, bool value) { return value ? e.is_true() : e.is_false(); }
/// Connectives that fold constants; `simplify` of large terms is slow.
[[nodiscard]] z3::expr both(const z3::expr& a, const z3::expr& b);
[[nodiscard]] z3::expr either(const z3::expr& a, const z3::expr& b);
[[nodiscard]] z3::expr no(const z3::expr& a);
[[nodiscard]] z3::expr choose(const z3::expr& when, const z3::expr& yes, const z3::expr& otherwise);

/// An atom's state, by variable.
using Local = std::vector<z3::expr>;
/// What it can do: its transitions (internal ones: false) and ports, after the atom's priorities.
struct Offer {
  std::vector<z3::expr> transitions, ports;
};
/// What code reads and writes, terms that somebody keeps; `about` is for claims (at …), (can …).
struct Scope {
  std::span<z3::expr> self;
  std::vector<z3::expr*> bind;
  std::function<z3::expr(const Tree&)> about;
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
  [[nodiscard]] z3::expr fresh(Text type) const;
  /// An int, a bool or the row of a string.
  [[nodiscard]] z3::expr constant(Text type, int value) const { return type == "bool" ? truth(value != 0) : z_.bv_val(value, 32); }
  /// The value that a variable begins with.
  [[nodiscard]] z3::expr first(Text type) const { return is_exact(type) ? constant(type, 0) : fresh(type); }
  /// Of a term that is one; nothing of all others.
  [[nodiscard]] static std::optional<int> value(const z3::expr& e);
  [[nodiscard]] static z3::expr equals(const z3::expr& e, int value);
  /// From variable `first` on, the values that are told.
  [[nodiscard]] z3::expr has(const Local& local, const Values& values, std::size_t first = 0) const;

  [[nodiscard]] z3::expr evaluate(const Tree& e, const Scope& s, const z3::expr& when, z3::expr& fault) const;
  /// Of (guard EXPR); an empty list holds.
  [[nodiscard]] z3::expr holds(const Tree& guard, const Scope& s, const z3::expr& when, z3::expr& fault) const;
  /// The statements of a list after its head. A run ends with an error where `fault` holds then.
  void execute(const Tree& body, const Scope& s, const z3::expr& when, z3::expr& fault) const;

  /// Parameters as the system says, and the others.
  [[nodiscard]] Local local(const Atom& atom, const std::function<z3::expr(std::size_t)>& others) const;
  [[nodiscard]] Local initial(const Atom& atom, z3::expr& fault) const;
  [[nodiscard]] Offer offer(const AtomType& type, Local& local, z3::expr& fault) const;
  /// Takes the transition and the internal ones that follow, from where `when` holds.
  void take(const AtomType& type, const Transition& t, Local& local, const z3::expr& when, z3::expr& fault) const;
  /// Fires a port of the offer.
  void fire(const AtomType& type, const Offer& offer, std::size_t port, Local& local, const z3::expr& when, z3::expr& fault) const;

 private:
  void move(const AtomType& type, const Transition& t, Local& local, const z3::expr& when, z3::expr& fault) const;
  void check_invariants(const AtomType& type, Local& local, const z3::expr& when, z3::expr& fault) const;
  void settle(const AtomType& type, Local& local, const z3::expr& when, z3::expr& fault) const;
  void hide(const AtomType& type, Local& local, std::vector<z3::expr>& ports, z3::expr& fault) const;

  const Model& m_;
  z3::context& z_;
  z3::solver solver_;
  std::map<std::size_t, std::vector<z3::expr>> assumed_;  // by atom
};

}  // namespace certcheck
