// Decides a question about a system with a portfolio of engines, tried in an order with budgets: first what mostly
// suffices and costs little, then the searches and IC3 in turns, for as long as time and memory last.
//
// Nothing is guessed: a counterexample has been replayed before it is returned, a proof comes with its evidence.
#pragma once
#include "compiler/verify/portfolio/decision.hpp"
#include "compiler/verify/portfolio/proof_context.hpp"

namespace bip::verify {

class Portfolio {
 public:
  /// Refers to `system` and `image`, of one compilation, which must outlive it; `prepare_code` gives the image its
  /// code, and returns false if it cannot be had. Cost: the net, linear in the system.
  Portfolio(const System& system, const rt::Image& image, StateAccess access, std::function<bool()> prepare_code,
            Report report)
      : parts_(system, image, access, std::move(prepare_code)), report_(std::move(report)) {}

  /// Answers the question, or says why it could not, at the latest when the limits' token is over. Proofs in one
  /// process run independently of each other if each has its own portfolio. Not for two threads at once.
  [[nodiscard]] Decision decide(const Question& question, const PortfolioLimits& limits);
  /// From now on decisions begin with the cached proof, checked anew, and store what they found. `cache` must outlive
  /// the portfolio; null: neither.
  void use_cache(ProofCache* cache) { cache_ = cache; }

  /// From now on lemmas are learnt from smaller instances of the model, too. `instances` must outlive the portfolio.
  void use_small_instances(const SmallInstances* instances) { small_instances_ = instances; }

  [[nodiscard]] const Net& net() const { return parts_.net(); }
  /// Returns null until an engine has needed it.
  [[nodiscard]] const TransitionSystem* transition_system() const { return parts_.built_transition_system(); }

 private:
  SystemParts parts_;
  Report report_;
  ProofCache* cache_ = nullptr;
  const SmallInstances* small_instances_ = nullptr;
};

/// Returns "m.bip:12: a call of `f`", one line per imprecision of the transition system, at most `count`.
[[nodiscard]] std::string imprecision_text(const TransitionSystem& machine, const System& system, std::size_t count);

}  // namespace bip::verify
