// What `--property` asks, and of which runs (`--fair`), of `bipc verify` and `bipc export`.
#pragma once
#include <optional>
#include <string>

#include "compiler/base/result.hpp"
#include "compiler/verify/portfolio/question.hpp"
#include "compiler/verify/property/fairness.hpp"

namespace bip::driver {

/// The question that was read. Nothing: the text is none, and that has been said on stderr, with what may have been
/// meant.
[[nodiscard]] std::optional<verify::Question> read_question(const std::string& text, Result<verify::Question> read,
                                                            const System& system);

/// What `--fair` says. Nothing: its names are none, and that has been said.
[[nodiscard]] std::optional<verify::Fairness> read_fairness(const std::string& text, const System& system);

}  // namespace bip::driver
