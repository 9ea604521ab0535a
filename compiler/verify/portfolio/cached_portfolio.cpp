// The part of a decision that is about kept proofs (proof_cache.hpp). Nothing that they say is taken as said:
// invariants are checked by structure, lemmas by the solver, a way by the engine. What does not hold is left out, and
// what is missing is found as if there were none.
#include "compiler/verify/portfolio/portfolio.hpp"
#include "compiler/verify/evidence/counterexample_text.hpp"

namespace bip::verify {

namespace {

// What cost less is found again as soon as it is read.
constexpr std::uint64_t kFewCandidates = 64, kFewStates = 1000;

// What is asked, as proofs are named by it.
std::string text_of(const Question& question, const PortfolioLimits& limits) {
  std::string text = question.what == QuestionKind::State      ? "state " + question.property.text
                     : question.what == QuestionKind::NoErrors ? "errors"
                                                               : "deadlock";
  return (limits.wants_certificate ? "certified " : "") + text;
}

}  // namespace

void Portfolio::recall() {
  known_ = found_ = {};
  if (memory_ == nullptr) return;
  memory_->counts = {};
  if (net_.too_large_atom == kNoRow) known_ = memory_->recall(net_, text_of(question_, limits_));
}

// What has decided the very same system before, asked first: the way is taken again, the lemmas are checked. Invariants
// come by themselves.
Portfolio::Tried Portfolio::try_known() {
  if (memory_ == nullptr || !memory_->counts.is_whole) return Tried::Open;
  if (known_.way == ProofMethod::Steps) {
    if (known_.choices.empty() || !ready() || !reaches(image_, goal_of(question_), known_.choices)) return Tried::Open;
    d_.outcome = Outcome::Violated;
    d_.choices = known_.choices;
    memory_->counts.has_way = true;
    return Tried::Done;
  }
  if (known_.way != ProofMethod::Induction) return Tried::Open;
  d_.has_structure = net_.too_large_atom == kNoRow;
  if (d_.has_structure) d_.proof = find_reachable_modes(net_, invariants_of(known_, net_, false));
  if (try_induction(limits_.cancellation.seconds_left() / 3) == Tried::Done) return Tried::Done;
  d_ = {};
  is_strengthened_ = induction_failed_ = false;
  return Tried::Open;
}

// Of a proof's invariants only those that it needs: if that is asked for, and if they are to be kept. What was kept is
// few already.
bool Portfolio::wants_needed(ProofMethod way, const Proof& proof) const {
  if (memory_ == nullptr) return limits_.wants_few;
  if (memory_->counts.is_whole && proof.candidates == 0) return false;
  return limits_.wants_few || way == ProofMethod::Induction || proof.candidates > kFewCandidates ||
         memory_->keeps() == Keeps::All;
}

// The proof at hand, if it is worth a file.
void Portfolio::note_found(ProofMethod way, const Net& net, const Proof& proof) {
  if (memory_ == nullptr) return;
  memory_->counts.invariants = proof.known;
  found_ = {};
  if (way != ProofMethod::Induction && proof.candidates <= kFewCandidates && memory_->keeps() != Keeps::All) return;
  found_.way = way;
  for (const TokenInvariant& invariant : proof.invariants)
    found_.invariants.push_back(kept(net, invariant, way == ProofMethod::Told));
  for (const AffineEquation& equation : d_.linear.equations) found_.equations.push_back(equation.terms);
  found_.uses_bounds = !d_.linear.bounds.empty();
  for (const Cube& lemma : d_.lemmas) found_.lemmas.push_back(kept(*machine_, lemma));
}

void Portfolio::keep_found() {
  if (memory_ == nullptr || net_.too_large_atom != kNoRow) return;
  if (d_.outcome == Outcome::Violated) {
    if (d_.states < kFewStates && d_.frames == 0 && memory_->keeps() != Keeps::All) return;
    found_ = {};
    found_.way = ProofMethod::Steps;
    found_.choices = d_.choices;
  } else if (d_.outcome != Outcome::Holds || d_.method == Method::Exhaustive || found_.way == ProofMethod::None) {
    return;
  }
  if (memory_->counts.is_whole && found_ == known_) return;
  memory_->keep(net_, text_of(question_, limits_), found_);
}

}  // namespace bip::verify
