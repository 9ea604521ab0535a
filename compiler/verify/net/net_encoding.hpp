// The question as clauses: exactly one reachable mode an atom; no connector and no internal port has a step for sure;
// some atom is not at final places; the invariants found so far.
//
// One variable a reachable mode, one auxiliary variable a group of a connector's tree. What data decides is known only
// where the values of the modes decide it, or guards together (guard_literals.hpp): a port counts as enabled only in
// modes in which it surely is, or with its guard's literal; so does a guarded interaction. So every deadlock is a model
// of the clauses, and models may be spurious.
#pragma once
#include "compiler/verify/net/guard_literals.hpp"
#include "compiler/verify/net/mode_reachability.hpp"
#include "compiler/verify/invariants/unsat_core.hpp"
#include "compiler/verify/solver/solver.hpp"
#include "compiler/verify/invariants/token_invariant.hpp"

namespace bip::verify {

/// Nothing: modes and invariants alone.
enum class Encoded : std::uint8_t { NoStep, Nothing };

class Encoding {
 public:
  Encoding(const Net& net, const ModeReachability& reachable, Encoded what = Encoded::NoStep);

  /// False: it is a sum too large for clauses. One given a switch counts only where minimize_invariants() assumes it
  /// (of one-token sets: only that there is one).
  bool add(const TokenInvariant& invariant, Lit on = 0);
  void add_clause(std::span<const Lit> clause) { solver_.add(clause); }
  /// Of a reachable mode.
  [[nodiscard]] Lit literal(u32 mode) const { return marked_[mode]; }
  [[nodiscard]] Lit new_switch() { return solver_.new_variable(); }
  /// Holds for the next solve only.
  void assume(Lit literal) { solver_.assume(literal); }
  /// Which traps does the contradiction need? False: there is none in the time.
  bool minimize_invariants(std::vector<TokenInvariant>& invariants, const std::vector<Lit>& on,
                           const CancellationToken& cancellation) {
    return minimize_by_unsat_core(solver_, invariants, on, cancellation);
  }
  [[nodiscard]] Answer solve(const CancellationToken& cancellation) { return solver_.solve(cancellation); }
  /// By mode: 1 if marked in the model.
  [[nodiscard]] std::vector<std::uint8_t> marked() const;

 private:
  // "not surely available" of a node: always, never, or a literal that implies it.
  struct Lacking {
    enum class Kind : std::uint8_t { Always, Never, Literal } kind = Kind::Always;
    Lit literal = 0;
  };
  void add_atoms();
  void add_no_end();
  [[nodiscard]] bool is_use(u32 row) const;
  [[nodiscard]] std::vector<u32> sources_of_moves(u32 row) const;
  [[nodiscard]] Lacking port(u32 row);
  [[nodiscard]] Lacking group(u32 row);
  [[nodiscard]] Lacking all_of(const std::vector<u32>& children);
  [[nodiscard]] Lacking any_of(const std::vector<u32>& children);
  [[nodiscard]] Lacking guarded(u32 row);
  [[nodiscard]] bool is_guarded_rendezvous(u32 row) const;
  [[nodiscard]] std::vector<GuardLiterals::Place> sources_of(u32 row) const;
  [[nodiscard]] Lacking rendezvous(u32 row);
  void add_guarded_rendezvous(u32 row);
  void add_step(const Lacking& lacking);

  const Net& net_;
  const ModeReachability& reachable_;
  Solver solver_;
  GuardLiterals guards_;
  std::vector<Lit> marked_;                 // by mode; 0: not reachable
  std::vector<std::uint8_t> is_reachable_;  // by mode
  std::vector<Lacking> lacking_;            // by node
};

}  // namespace bip::verify
