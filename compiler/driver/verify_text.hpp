// Prints the verdict of `bipc verify`, in words and as JSON.
#pragma once
#include <string>

#include "compiler/driver/pipeline.hpp"
#include "compiler/verify/portfolio/portfolio.hpp"

namespace bip::driver {

struct VerdictText {
  int exit_code = 0;
  std::string name;  // "deadlock-free", "violated", "unknown" …
  std::string text;
};
[[nodiscard]] VerdictText verdict_text(const Compilation& c, const verify::Question& question,
                                       const verify::Decision& d, const verify::Portfolio& decider, bool why);
/// Of a decision; `memory` null: proofs were neither used again nor kept.
struct VerifyStats {
  double seconds = 0;  // of the processor
  std::uint64_t candidates = 0;
  const verify::ProofCache* memory = nullptr;
};
/// `stats` may be null.
[[nodiscard]] std::string verdict_json(const VerdictText& text, const verify::Question& question,
                                       const verify::Decision& d, const VerifyStats* stats);
[[nodiscard]] std::string stats_text(const VerifyStats& stats);

}  // namespace bip::driver
