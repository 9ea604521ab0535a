// Compiles one generated model in process, stage by stage, without files.
#pragma once
#include <memory>
#include <string>

#include "compiler/lower/lower.hpp"
#include "compiler/system/system.hpp"
#include "tools/gen/bind_ffi.hpp"

namespace bip::gen {

struct Compiled {
  std::string problem;  // empty: sound. Else the first stage that failed and what it said
  std::unique_ptr<System> system;
  std::unique_ptr<lower::LoweredSystem> lowered;
  std::vector<std::string> formatted;  // the texts as `fmt` writes them
};

/// From .bip texts, a package each, after those that they use. Every diagnostic of severity error, and every broken
/// promise of the System, is a problem.
[[nodiscard]] Compiled compile_texts(const std::vector<std::string>& texts);
/// From .bsys text.
[[nodiscard]] Compiled compile_bsys(const std::string& text);

/// Sets every place in the source to none, so that systems of differently laid out texts can be compared.
void forget_places(System& system);

}  // namespace bip::gen
