// A proof about runs without a list of states: no run has more than so many rounds (Claessen, Sörensson 2012). The
// tester of the claim (runs.hpp) and what fairness demands are bits beside the states of the system, of which the
// certificate's lemmas may speak: one more atom, the monitor.
//
// In a round each promise that is pending was not so once, and each turn that the certificate names has come or was not
// possible. A fair run that violates the claim would have rounds without end; so a bound is a proof.
#pragma once
#include "tools/certcheck/runs.hpp"

namespace certcheck {

class Rounds {
 public:
  Rounds(const Model& model, const Certificate& certificate, const Tree& claim, const Terms& terms);

  /// The monitor's bits by Monitor::row. At first, or any.
  [[nodiscard]] Local bits(bool are_first) const;
  /// Sets what the monitor does in each of the steps of the state that the system looks at, and when it allows them.
  void add_monitor(const Local& now, System& system, std::vector<Step>& steps) const;
  /// More rounds are over than the certificate says.
  [[nodiscard]] expr is_bad(const Local& now) const;

 private:
  [[nodiscard]] expr takes_turn(const Turn& turn, const Step& step) const;

  const Model& model_;
  const Certificate& proof_;
  const Terms& terms_;
  const Formula formula_;
  std::size_t demands_ = 0;
  const bool is_strong_ = std::ranges::any_of(proof_.fair, &Fair::is_strong);
};

}  // namespace certcheck
