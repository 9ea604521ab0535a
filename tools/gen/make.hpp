// The parts of the generator: expressions and bodies, atom types, connector types, compounds. Each receives what it may
// use and the random numbers; there is no global state.
#pragma once
#include <map>
#include <set>

#include "tools/gen/description.hpp"
#include "tools/gen/random.hpp"

namespace bip::gen {

/// A variable that code may name.
struct Known {
  std::string scope, name;
  Ty type = Ty::Int;
  bool writable = true;
};
[[nodiscard]] inline Expr name_of(const Known& known) {
  Expr e;
  e.kind = ExprKind::Name;
  e.type = known.type;
  e.scope = known.scope;
  e.name = known.name;
  return e;
}

/// What a seed's model is like as a whole.
struct Style {
  bool faults = false;      // divisions whose divisor may be zero
  bool large = false;       // many atoms, wide connectors
  bool paper = false;       // what fits goes into the paper's notation
  bool odd_names = false;   // contextual words as identifiers
  bool lively = false;      // ports enabled nearly always, so that many interactions compete
  bool deep = false;        // compounds of compounds, exporting connectors with many alternatives
  bool merged = false;      // ports exported under one name
  bool atom_rules = false;  // priorities of atoms
  bool invariants = false;
  bool calls = false;    // functions of the C and C++ libraries in code
  bool ffi = false;      // and those of random_ffi.hpp
  bool objects = false;  // and its types
  bool regular =
      false;  // what can be compiled as whole steps: ports of one transition, no faults, few guards and triggers
  bool narrow = false;              // no floats: data that a loop over steps may have in columns
  bool has_initial_values = false;  // of connectors' data
  bool ruled = false;               // many priority rules, in chains, with guards
  int max_weight = 120;             // alternatives of one connector
  int max_atoms = 800;              // of a whole model: four levels of wide arrays would have a million
  std::vector<Var> constants;
  std::vector<InlineFunction> functions;
};

class CodeMaker {
 public:
  CodeMaker(Prng& random, const Style& style) : random_(&random), style_(&style) {}
  Expr expression(Ty type, const std::vector<Known>& known, int depth);
  Expr guard(const std::vector<Known>& known);
  /// `count` statements; empty if nothing is writable. Where calls may not change anything (`up`) none does.
  enum class Changes : std::uint8_t { ByCalls, ByAssignment };
  Body body(const std::vector<Known>& known, int count, int depth, Changes changes = Changes::ByCalls);
  /// A literal, for initialisers and arguments.
  Expr literal(Ty type);
  Ty type();
  /// One of the native types.
  Ty native_type();

 private:
  Expr call(Ty type, const std::vector<Known>& known, int depth);
  Expr inline_call(const InlineFunction& function, const std::vector<Known>& known, int depth);
  Expr pair_of(Expr a, Expr b);
  std::optional<Stmt> call_statement(const std::vector<Known>& known, int depth);
  Expr leaf(Ty type, const std::vector<Known>& known);
  Expr int_operation(const std::vector<Known>& known, int depth);
  Expr bool_operation(const std::vector<Known>& known, int depth);
  Expr float_operation(const std::vector<Known>& known, int depth);
  Stmt assignment(const Known& target, const std::vector<Known>& known, int depth);

  Prng* random_;
  const Style* style_;
};

[[nodiscard]] Expr unary(std::string op, Expr a, Ty type);
[[nodiscard]] Expr binary(std::string op, Expr a, Expr b, Ty type);
[[nodiscard]] Expr int_literal(int value);
[[nodiscard]] Expr constant(const Var& var);

[[nodiscard]] std::vector<Var> make_constants(CodeMaker& code, Prng& random);
[[nodiscard]] std::vector<InlineFunction> make_functions(CodeMaker& code, Prng& random);

[[nodiscard]] AtomType make_atom(Prng& random, const Style& style, const std::vector<PortType>& types,
                                 const std::string& name);

/// A connector type over ports of the named types.
[[nodiscard]] ConnectorType make_connector(Prng& random, const Style& style, const std::vector<PortType>& port_types,
                                           const std::vector<std::string>& params, bool exports,
                                           const std::string& name);

/// What a compound type shows to those that contain it.
struct Interface {
  struct Item {
    std::string name, port_type;
    std::set<std::string> atoms;  // reached through it, paths within the compound
    int weight = 1, depth = 0;
  };
  std::vector<Item> ports;
  int atoms = 0;  // within one element, arrays of `n` counted at their largest
};
/// Adds a compound type (and the connector types it needs) to the model.
enum class CompoundLevel : std::uint8_t { Inner, Root };
void make_compound(Prng& random, const Style& style, Description& model, std::map<std::string, Interface>& interfaces,
                   const std::string& name, CompoundLevel level);
/// Gives a finished model time: clocks, bounds, urgency, invariants, `resume`, `@async`, ports for events.
void make_time(Prng& random, Description& model);
/// Adds draws of random numbers to a finished model.
void make_draws(Prng& random, Description& model);
/// Adds priority rules without cycles.
void make_priorities(Prng& random, const Style& style, const Description& model, CompoundType& compound);

}  // namespace bip::gen
