// What `--property` asks, of `bipc verify` and `bipc export`.
#pragma once
#include <optional>
#include <string>

#include "compiler/verify/portfolio/question.hpp"

namespace bip::driver {

/// The question that the text asks: `deadlock` (also the empty text), `errors`, or a property of states. Nothing: it is
/// none, and that has been said on stderr in the name of the command.
[[nodiscard]] std::optional<verify::Question> read_question(const char* command, const std::string& text,
                                                            const System& system);

}  // namespace bip::driver
