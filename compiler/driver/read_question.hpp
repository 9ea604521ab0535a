// What `--property` asks, of `bipc verify` and `bipc export`.
#pragma once
#include <optional>
#include <string>

#include "compiler/base/result.hpp"
#include "compiler/verify/portfolio/question.hpp"

namespace bip::driver {

/// The question that was read. Nothing: the text is none, and that has been said on stderr, with what may have been
/// meant.
[[nodiscard]] std::optional<verify::Question> read_question(const std::string& text, Result<verify::Question> read,
                                                            const System& system);

}  // namespace bip::driver
