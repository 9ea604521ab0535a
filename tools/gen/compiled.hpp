// One generated text through the compiler, in process: the stages one by one, no files.
#pragma once
#include <memory>
#include <string>

#include "compiler/lower/lower.hpp"
#include "compiler/system/system.hpp"

namespace bip::gen {

struct Compiled {
  std::string problem;  // empty: sound. Else the first stage that failed and what it said
  std::unique_ptr<System> system;
  std::unique_ptr<lower::LoweredSystem> lowered;
  std::string formatted;  // the text as `fmt` writes it
};

/// From .bip text. Every diagnostic of severity error, and every broken promise of the System, is a problem.
[[nodiscard]] Compiled compile_text(const std::string& text);
/// From .bsys text.
[[nodiscard]] Compiled compile_bsys(const std::string& text);

/// Sets every place in the source to none, so that systems of differently laid out texts can be compared.
void forget_places(System& system);

}  // namespace bip::gen
