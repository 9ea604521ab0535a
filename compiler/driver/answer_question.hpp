// Answers a question about a compiled model as `bipc verify` does: runs of models with C++, then proofs and searches,
// with a line of progress on a terminal, until Ctrl-C.
#pragma once
#include "compiler/library/decide.hpp"

namespace bip::driver {

/// Requires an image. `note` ends the text. The verdict has no certificate and no counterexample if a first run or the
/// initialization decided.
[[nodiscard]] library::Verdict answer_question(const library::VerifyRequest& request, pipeline::Compilation& c,
                                               const verify::Question& question, const std::string& note);

}  // namespace bip::driver
