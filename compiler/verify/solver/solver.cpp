// CaDiCaL (Biere et al.) behind Solver.
#include "compiler/verify/solver/solver.hpp"

#include <cstdlib>

#include <cadical.hpp>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

class TokenTerminator : public CaDiCaL::Terminator {
 public:
  explicit TokenTerminator(const CancellationToken& cancellation) : cancellation_(cancellation) {}
  bool terminate() override {
    return cancellation_.is_cancelled() || (calls_++ % kCallsBetweenLooks == 0 && cancellation_.is_over());
  }

 private:
  // The library asks before each decision; a look at the clock is a system call.
  static constexpr unsigned kCallsBetweenLooks = 16;
  CancellationToken cancellation_;
  unsigned calls_ = 0;
};

}  // namespace

struct Solver::Impl {
  CaDiCaL::Solver solver;
  int variables = 0;
  Answer answer = Answer::Unknown;  // of the last solve, while models and cores are valid
};

Solver::Solver(SolverStyle style) : impl_(std::make_unique<Impl>()) {
  if (style != SolverStyle::Usual) impl_->solver.configure("plain");
  if (style == SolverStyle::Backjumping) impl_->solver.set("chrono", 0);
  impl_->solver.set("quiet", 1);
}
Solver::~Solver() = default;

Lit Solver::new_variable() { return ++impl_->variables; }

void Solver::add(std::span<const Lit> clause) {
  for (Lit literal : clause) {
    BIP_ASSERT(literal != 0 && std::abs(literal) <= impl_->variables, "literal {} of {} variables", literal,
               impl_->variables);
    impl_->solver.add(literal);
  }
  impl_->solver.add(0);
}

void Solver::assume(Lit literal) {
  BIP_ASSERT(literal != 0 && std::abs(literal) <= impl_->variables, "literal {} of {} variables", literal,
             impl_->variables);
  impl_->solver.assume(literal);
}
void Solver::prefer(Lit literal) { impl_->solver.phase(literal); }

Answer Solver::solve(const CancellationToken& cancellation) {
  impl_->answer = Answer::Unknown;
  if (cancellation.is_over()) return Answer::Unknown;
  TokenTerminator terminator(cancellation);
  impl_->solver.connect_terminator(&terminator);
  const int status = impl_->solver.solve();
  impl_->solver.disconnect_terminator();
  impl_->answer = status == 10 ? Answer::Satisfiable : status == 20 ? Answer::Unsatisfiable : Answer::Unknown;
  return impl_->answer;
}

bool Solver::is_true(Lit literal) const {
  BIP_ASSERT(impl_->answer == Answer::Satisfiable, "there is no model");
  // Of a negative literal the library's releases give different signs.
  const bool value = impl_->solver.val(std::abs(literal)) > 0;
  return literal > 0 ? value : !value;
}

bool Solver::is_needed(Lit assumption) const {
  BIP_ASSERT(impl_->answer == Answer::Unsatisfiable, "there is no core");
  return impl_->solver.failed(assumption);
}

void add_at_most_one(Solver& solver, std::span<const Lit> literals) {
  if (literals.size() <= 6) {
    for (std::size_t i = 0; i < literals.size(); ++i) {
      for (std::size_t j = i + 1; j < literals.size(); ++j) solver.add({-literals[i], -literals[j]});
    }
    return;
  }
  Lit before = 0;
  for (Lit literal : literals) {
    const Lit seen = solver.new_variable();
    solver.add({-literal, seen});
    if (before != 0) {
      solver.add({-before, seen});
      solver.add({-before, -literal});
    }
    before = seen;
  }
}

}  // namespace bip::verify
