// Answers a question about a compiled model as `bipc verify` does: runs of models with C++, then proofs and searches,
// with a line of progress on a terminal, until Ctrl-C.
#pragma once
#include "compiler/library/decide.hpp"

namespace bip::driver {

/// Models with C++, without a certificate: takes out what decides about no state; `data` is what all questions to come
/// read. Returns a note for the answers, empty if nothing was taken out.
[[nodiscard]] std::string remove_unread_cpp(const library::VerifyRequest& request, pipeline::Compilation& c,
                                            const std::vector<DataRef>& data);

/// Requires an image. `note` ends the text. The verdict has no certificate and no counterexample if a first run or the
/// initialization decided.
[[nodiscard]] library::Verdict answer_question(const library::VerifyRequest& request, pipeline::Compilation& c,
                                               const verify::Question& question, const std::string& note);

}  // namespace bip::driver
