// See proof_context.hpp.
#include "compiler/verify/portfolio/proof_context.hpp"

#include "compiler/system/inner_priorities.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

SystemParts::SystemParts(const System& system, const rt::Image& image, StateAccess access,
                         std::function<bool()> prepare_code)
    : system_(system),
      image_(image),
      access_(access),
      prepare_code_(std::move(prepare_code)),
      net_(build_net(system)),
      inner_priority_(system::first_inner_priority(system)) {
  BIP_ASSERT(system.atoms.size() == image.atoms.size, "{} atoms in the system, {} in the image", system.atoms.size(),
             image.atoms.size);
}

bool SystemParts::has_code() {
  if (!is_searchable()) return false;
  if (code_ == Code::NotPrepared) code_ = prepare_code_() ? Code::Ready : Code::Unavailable;
  return code_ == Code::Ready;
}

TransitionSystem* SystemParts::transition_system(std::size_t megabytes, const CancellationToken& cancellation) {
  if (!transition_system_) {
    TransitionSystem built = build_transition_system(system_, image_, megabytes, cancellation);
    if (built.is_stopped) return nullptr;
    transition_system_ = std::move(built);
  }
  return &*transition_system_;
}

bool ProofContext::wants_minimal(ProofMethod method, const Proof& proof) const {
  if (cache == nullptr) return limits.wants_minimal_proof;
  if (cache->counts.is_whole && proof.candidates == 0) return false;
  return limits.wants_minimal_proof || method == ProofMethod::Induction || proof.candidates > kCheapCandidates ||
         cache->policy() == StorePolicy::All;
}

}  // namespace bip::verify
