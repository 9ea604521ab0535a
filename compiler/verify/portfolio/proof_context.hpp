// What the engines of a portfolio share: the parts of a system that are expensive to build, and what has been found
// about one question so far.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "compiler/verify/evidence/evidence.hpp"
#include "compiler/verify/evidence/proof_cache.hpp"
#include "compiler/verify/portfolio/question.hpp"
#include "compiler/verify/scaling/small_instance.hpp"
#include "compiler/verify/symbolic/transition_system.hpp"

namespace bip::verify {

/// A proof that needed no more candidates than this is found again as fast as it is read: it is not stored.
inline constexpr std::uint64_t kCheapCandidates = 64;

/// Undetermined: steps depend on what no state determines (what C++ returns, random numbers), so states can be neither
/// visited nor replayed.
enum class StateAccess : std::uint8_t { Searchable, Undetermined };

/// One system in the forms that engines need. Net: built at once, all use it. Transition system and executable code:
/// built on first use, once. They outlive questions.
class SystemParts {
 public:
  /// Refers to `system` and `image`, of one compilation, which must outlive it. `prepare_code` gives the image its
  /// code and returns false if it cannot be had; it is called at most once. Cost: the net is linear in the system.
  SystemParts(const System& system, const rt::Image& image, StateAccess access, std::function<bool()> prepare_code);

  [[nodiscard]] const System& system() const { return system_; }
  [[nodiscard]] const rt::Image& image() const { return image_; }
  [[nodiscard]] const Net& net() const { return net_; }
  /// Are the atoms' local states few enough for reasoning about the net?
  /// And does every interaction that is offered, hidden or not, mean that there is a step?
  [[nodiscard]] bool has_usable_net() const { return net_.too_large_atom == kNoRow && inner_priority_.empty(); }
  /// The first priority that orders connectors that export a port; empty: none.
  [[nodiscard]] const std::string& inner_priority() const { return inner_priority_; }
  [[nodiscard]] bool is_searchable() const { return access_ == StateAccess::Searchable; }
  /// Prepares the code on first use. Returns whether states can be visited and counterexamples replayed.
  [[nodiscard]] bool has_code();
  /// Builds the transition system on first use; it may be unsupported (TransitionSystem::unsupported), for example
  /// because its circuit takes more than `megabytes`. Null: the time is over before it is built.
  [[nodiscard]] TransitionSystem* transition_system(std::size_t megabytes, const CancellationToken& cancellation);
  /// Returns null if no engine has needed it.
  [[nodiscard]] const TransitionSystem* built_transition_system() const {
    return transition_system_ ? &*transition_system_ : nullptr;
  }

 private:
  enum class Code : std::uint8_t { NotPrepared, Ready, Unavailable };
  const System& system_;
  const rt::Image& image_;
  StateAccess access_;
  std::function<bool()> prepare_code_;
  Net net_;
  std::string inner_priority_;
  std::optional<TransitionSystem> transition_system_;
  Code code_ = Code::NotPrepared;
};

/// How far induction has come with a question. Unusable: it has nothing to add, whatever the budget.
enum class InductionStage : std::uint8_t { Untried, RangesConfirmed, InvariantsRefined, Unusable };
/// Cached lemmas that hold may still lead IC3 away from those that suffice: then the next attempt goes without.
enum class CachedLemmaUse : std::uint8_t { Try, Skip };

/// One question about a system, and what engines have found about it.
struct ProofContext {
  SystemParts& parts;
  const Question& question;
  const PortfolioLimits& limits;
  const Report& report;
  ProofCache* cache = nullptr;  // null: proofs are neither reused nor stored

  CachedProof cached;     // of an earlier run, unchecked
  StructuralFacts facts;  // hold; engines add to them
  InductionStage induction = InductionStage::Untried;
  CachedLemmaUse cached_lemmas = CachedLemmaUse::Try;
  const SmallInstances* small_instances = nullptr;  // of the model; null: there are none
  std::optional<bool> is_symmetric = std::nullopt;  // may a search permute components? absent: not yet asked

  /// Is the cached proof about this very system?
  [[nodiscard]] bool is_cached_system() const { return cache != nullptr && cache->counts.is_whole; }
  /// Shall the invariants of a proof be reduced to those that it needs: because it is asked for, or because they will
  /// be stored? A cached proof has been reduced before.
  [[nodiscard]] bool wants_minimal(ProofMethod method, const Proof& proof) const;
  /// Notes how many invariants of the proof come from the cache.
  void count_reused(const Proof& proof) const {
    if (cache != nullptr) cache->counts.invariants = proof.reused;
  }
};

}  // namespace bip::verify
