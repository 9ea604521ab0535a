// The whole decision: structure first, then the engine's own search for what is near, then IC3 over the machine, then
// the search for as long as time and memory last. Nothing is guessed: a way to a bad state has been replayed, a proof
// is one.
#pragma once
#include "compiler/verify/invariants/affine_invariants.hpp"
#include "compiler/verify/evidence/evidence.hpp"
#include "compiler/verify/symbolic/ic3.hpp"
#include "compiler/verify/evidence/proof_cache.hpp"
#include "compiler/verify/property/property.hpp"
#include "compiler/verify/portfolio/prove_by_invariants.hpp"
#include "compiler/verify/evidence/reached_states.hpp"
#include "compiler/verify/portfolio/search.hpp"

namespace bip::verify {

/// NoLocalDeadlock: that no component waits for ever while others move.
enum class QuestionKind : std::uint8_t { DeadlockFreedom, NoErrors, State, NoLocalDeadlock };
struct Question {
  QuestionKind what = QuestionKind::DeadlockFreedom;
  Property property;  // State
};

enum class Outcome : std::uint8_t { Holds, Violated, Unknown };
/// How a property was found to hold.
enum class Method : std::uint8_t {
  Invariants,  // of the structure alone
  Induction,   // lemmas that no step leaves, with the structure's
  Exhaustive   // every reachable state was visited
};
struct Decision {
  Outcome outcome = Outcome::Unknown;
  Method method = Method::Invariants;
  Proof proof;  // structure: invariants, reachable modes, the candidate that survived
  bool has_structure = false;
  AffineInvariants linear;             // Induction: equations between data and places, and bounds
  std::vector<Cube> lemmas;            // Induction
  std::vector<std::uint64_t> choices;  // Violated
  std::vector<u32> stuck;              // Violated, NoLocalDeadlock: rows of atoms
  std::uint64_t states = 0;            // visited by the last search
  std::string reached;                 // Exhaustive, with a certificate wanted: the states, as its rows
  bool is_only_counted = false;        // Exhaustive, with a certificate wanted: there are no such rows
  std::string fault;                   // a run-time error that a search met and that was not asked about
  std::string reason;                  // Unknown
  u32 frames = 0;
};

/// What happens, for a terminal: a phase and how far it is.
using Report = std::function<void(const char* phase, std::uint64_t count, const char* unit)>;

struct PortfolioLimits {
  CancellationToken cancellation;  // ends everything: cancelled by whoever asks, or the time is over
  std::size_t megabytes = 2048;
  bool wants_few = false;          // of a proof's invariants only those that it needs
  bool wants_certificate = false;  // an exhaustive search is followed by a proof, or keeps what it has reached
  std::uint32_t threads = 1;       // of the visit of all states
  bool may_search = true;          // states may be visited; a way that a proof's failure gives is replayed in any case
};

class Portfolio {
 public:
  /// `prepare` gives the image its code; false: it cannot be had. `can_run`: no C++ that would have to be called.
  Portfolio(const System& system, const rt::Image& image, bool can_run, std::function<bool()> prepare, Report report)
      : system_(system),
        image_(image),
        can_run_(can_run),
        prepare_(std::move(prepare)),
        report_(std::move(report)),
        net_(build_net(system)) {}

  [[nodiscard]] Decision decide(const Question& question, const PortfolioLimits& limits);
  /// Decisions begin with what is known from before, checked anew, and leave what they found. Null: they do not.
  void remember_in(ProofCache* memory) { memory_ = memory; }
  /// What the proof's modes are of.
  [[nodiscard]] const Net& net() const { return told_ ? *told_ : net_; }
  /// Not null: a proof whose modes a certificate cannot name, in other words.
  [[nodiscard]] const Evidence* evidence() const { return evidence_ ? &*evidence_ : nullptr; }
  /// Null until induction was tried.
  [[nodiscard]] const TransitionSystem* machine() const { return machine_ ? &*machine_ : nullptr; }

 private:
  enum class Tried : std::uint8_t { Done, Open };
  void look_at_structure();
  bool look_at_uses();
  Tried try_search(std::uint64_t states);
  Tried try_all_states(double seconds);
  void look_for_evidence();
  void look_for_stuck();
  /// Facts: what structure and equations give, without looking for lemmas.
  enum class Effort : std::uint8_t { Facts, Lemmas };
  Tried try_induction(double seconds, Effort effort = Effort::Lemmas);
  bool is_proved_with(AffineInvariants facts, const Ic3Problem& problem, bool needs_bounds);
  [[nodiscard]] std::optional<AffineInvariants> known_facts(const CancellationToken& cancellation);
  void recall();
  Tried try_known();
  void decide_in_order();
  [[nodiscard]] bool wants_needed(ProofMethod way, const Proof& proof) const;
  void note_found(ProofMethod way, const Net& net, const Proof& proof);
  void keep_found();
  [[nodiscard]] bool is_stopped() const { return limits_.cancellation.is_over(); }
  [[nodiscard]] bool ready();
  [[nodiscard]] std::vector<std::vector<Signal>> structural_clauses();
  [[nodiscard]] std::vector<std::vector<Signal>> linear_clauses();
  void add_reason(const std::string& reason);

  const System& system_;
  const rt::Image& image_;
  bool can_run_;
  std::function<bool()> prepare_;
  Report report_;
  Net net_;
  std::optional<Net> told_;  // uses of ports told apart: only if that proved it
  std::optional<Evidence> evidence_;
  std::optional<TransitionSystem> machine_;
  Question question_;
  PortfolioLimits limits_;
  Decision d_;
  ProofCache* memory_ = nullptr;
  CachedProof known_, found_;  // from before; now
  bool is_ready_ = false, cannot_prepare_ = false, is_exhausted_ = false, is_strengthened_ = false,
       are_ranges_confirmed_ = false, lemmas_mislead_ = false;
  bool induction_failed_ = false, has_seen_uses_ = false, is_memory_over_ = false;
};

/// "m.bip:12: a call of `f`", a line each, at most `count`.
[[nodiscard]] std::string imprecision_text(const TransitionSystem& machine, const System& system, std::size_t count);

}  // namespace bip::verify
