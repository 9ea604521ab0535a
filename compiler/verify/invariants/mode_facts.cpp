// See mode_facts.hpp.
#include "compiler/verify/invariants/mode_facts.hpp"

#include "compiler/verify/portfolio/prove_by_invariants.hpp"

namespace bip::verify {

namespace {
constexpr double kComponentSeconds = 2;
}  // namespace

ModeFacts::ModeFacts(const Net& net, Encoded what, const CancellationToken& cancellation)
    : net_(net), cancellation_(cancellation), reachable_(net, Direction::Forward, nullptr) {
  Proof ignored;
  spread_from_initial(net, reachable_, ignored);
  encoding_ = std::make_unique<Encoding>(net, reachable_, what);
  traps_ = std::make_unique<TrapFinder>(net, reachable_);
  place_invariants_ = std::make_unique<PlaceInvariantFinder>(net, reachable_, cancellation);
  components_ = std::make_unique<StateMachineComponentFinder>(net, reachable_);
}

void ModeFacts::exclude(u32 mode) {
  if (const Lit literal = encoding_->literal(mode); literal != 0) encoding_->add_clause(std::vector<Lit>{-literal});
}

bool ModeFacts::add_all(std::vector<TokenInvariant> found) {
  const std::size_t before = invariants_;
  for (const TokenInvariant& invariant : found) invariants_ += encoding_->add(invariant) ? 1 : 0;
  return invariants_ != before;
}

// Returns a literal that implies that one of the modes is marked. A mode that is not reachable has no literal.
Lit ModeFacts::one_of(const std::vector<u32>& modes) {
  const auto [entry, is_new] = literals_.try_emplace(modes, 0);
  if (!is_new) return entry->second;
  entry->second = encoding_->new_switch();
  std::vector<Lit> clause{-entry->second};
  for (const u32 mode : modes) {
    if (const Lit literal = encoding_->literal(mode); literal != 0) clause.push_back(literal);
  }
  encoding_->add_clause(clause);
  return entry->second;
}

bool ModeFacts::may_be(const std::vector<std::vector<u32>>& sets, u32 rounds) {
  std::vector<Lit> assumed;
  for (const std::vector<u32>& modes : sets) assumed.push_back(one_of(modes));
  for (u32 round = 0;; ++round) {
    for (const Lit literal : assumed) encoding_->assume(literal);
    const Answer answer = encoding_->solve(cancellation_);
    if (answer != Answer::Satisfiable) return answer != Answer::Unsatisfiable;
    if (round == rounds || cancellation_.is_over()) return true;
    const std::vector<std::uint8_t> marked = encoding_->marked();
    if (add_all(traps_->find(marked)) || add_all(place_invariants_->find(marked))) continue;
    if (place_invariants_->satisfies_all()) return true;
    if (!add_all(components_->find(marked, kComponentBatch, cancellation_.within(kComponentSeconds)))) return true;
  }
}

}  // namespace bip::verify
