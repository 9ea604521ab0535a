// Fills the code of an image. The interpreter is always available; the JIT is a plug-in that may be missing.
//
// By default the JIT is used if it is available. A system without any code needs neither: then libLLVM is not loaded.
#include "compiler/pipeline/executor.hpp"

#include <chrono>

#include "bip/ffi.hpp"
#include "compiler/base/stage_scope.hpp"
#include "compiler/pipeline/cache_folder.hpp"
#include "compiler/pipeline/ffi_build.hpp"
#include "compiler/steps/derive_steps.hpp"

namespace bip::pipeline {

jit::OptLevel opt_level(const lower::LoweredSystem& lowered, Optimisation optimisation) {
  if (optimisation == Optimisation::Auto) {
    return lowered.units.size() <= kMaxUnitsForO2 ? jit::OptLevel::O2 : jit::OptLevel::O0;
  }
  return optimisation == Optimisation::O0 ? jit::OptLevel::O0 : jit::OptLevel::O2;
}

Executor::~Executor() {
  tiers_.reset();
  if (lowered_ != nullptr) lowered_->results.clear();
}

namespace {

// Most runs are shorter than loading libLLVM takes.
constexpr unsigned kPatienceMs = 20;

jit::JitOptions jit_options(const CacheOptions& cache, jit::OptLevel level) {
  jit::JitOptions options;
  options.level = level;
  options.cache_folder = cache_folder(cache).string();
  options.cache_bytes = cache.megabytes << 20;
  options.version = cache_version();
  return options;
}

}  // namespace

CacheOptions Executor::cache_of(const Compilation& c) const {
  CacheOptions cache = c.options.cache;
  cache.is_off = cache.is_off || code_ == MachineCode::Fresh;
  return cache;
}

bool Executor::prepare(Compilation& c, Backend backend, Optimisation optimisation, ForDebuggers for_debuggers) {
  const StageScope doing("preparing the code of", c.path);
  BIP_ASSERT(c.lowered != nullptr, "`{}` was not lowered", c.path);
  if (backend != Backend::Interp || uses_ffi(c)) warn_of_unusable_cache(c, cache_of(c));
  if (!load_ffi(c, cache_of(c))) return false;
  lowered_ = c.lowered.get();
  // With -O2 steps have code even if nothing else has.
  const bool has_code = !c.lowered->units.empty() || optimisation == Optimisation::O2;
  if (backend != Backend::Interp && (backend == Backend::Jit || has_code)) {
    const Result<JitPlugin> plugin = load_jit();
    if (plugin) {
      const jit::OptLevel level = opt_level(*c.lowered, optimisation);
      // Code that is not optimised would make them no faster than the core.
      if (level != jit::OptLevel::O0) steps::derive_steps(*c.lowered);
      const auto started = std::chrono::steady_clock::now();
      jit::JitOptions options = jit_options(cache_of(c), level);
      options.for_debuggers = for_debuggers == ForDebuggers::Yes;
      Result<JitCode> code = (*plugin).compile(*c.lowered, options, made_);
      if (!code) {
        c.diags.report(Diag::kB5007, {}, "jit", code.error());
        return false;
      }
      jit_ = std::move(*code);
      BIP_ASSERT(made_.codes.size() == c.lowered->units.size(), "{} codes of {} units", made_.codes.size(),
                 c.lowered->units.size());
      jit::install(*c.lowered, made_);
      seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
      return true;
    }
    if (backend == Backend::Jit) {
      c.diags.report(Diag::kB5007, {}, "jit", plugin.error());
      return false;
    }
  }
  interpreter_ = std::make_unique<interp::Interpreter>(*c.lowered);
  return true;
}

bool Executor::prepare_tiered(Compilation& c) {
  warn_of_unusable_cache(c, cache_of(c));
  if (!prepare(c, Backend::Interp, Optimisation::Auto)) return false;
  tiers_ = std::make_unique<Tiers>(*c.lowered, jit_options(cache_of(c), jit::OptLevel::O2), kPatienceMs);
  return true;
}

std::string Executor::summary() {
  if (tiers_) return tiers_->summary();
  if (!jit_) return {};
  return text_of(made_, "code:", "", seconds_);
}

}  // namespace bip::pipeline
