// See tiers.hpp. The thread reads the lowered system and writes the description of steps, which is not read before its
// functions exist; codes and functions are changed by the engine's thread only.
#include "compiler/pipeline/tiers.hpp"

#include <fmt/format.h>

#include <chrono>
#include <string>
#include <system_error>

#include "compiler/steps/derive_steps.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::pipeline {

Tiers::Tiers(lower::LoweredSystem& lowered, jit::JitOptions options, unsigned patience_ms)
    : lowered_(lowered), options_(std::move(options)) {
  options_.goes_on = [this] {
    const std::lock_guard guard(mutex_);
    return !is_stopped_;
  };
  new_code_.install = [this] { return install(); };
  try {
    thread_ = std::thread([this, patience_ms] { work(patience_ms); });
  } catch (const std::system_error& error) {
    problem_ = std::string("no thread for the compiler: ") + error.what();
  }
}

Tiers::~Tiers() { end(); }

void Tiers::end() {
  {
    const std::lock_guard guard(mutex_);
    is_stopped_ = true;
  }
  stop_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Tiers::work(unsigned patience_ms) {
  {
    std::unique_lock lock(mutex_);
    if (stop_.wait_for(lock, std::chrono::milliseconds(patience_ms), [this] { return is_stopped_; })) return;
  }
  const auto started = std::chrono::steady_clock::now();
  const Result<JitPlugin> plugin = load_jit();
  if (!plugin) {
    problem_ = plugin.error();
    return;
  }
  steps::derive_steps(lowered_);
  Result<JitCode> code = (*plugin).compile(lowered_, options_, made_);
  seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  if (!code) {
    problem_ = code.error();
    return;
  }
  code_ = std::move(*code);
  BIP_ASSERT(made_.codes.size() == lowered_.units.size(), "{} codes of {} units", made_.codes.size(),
             lowered_.units.size());
  new_code_.is_ready.store(true, std::memory_order_release);
}

std::vector<rt::Code> Tiers::install() {
  std::vector<rt::Code> before = lowered_.codes;
  BIP_ASSERT(new_code_.is_ready.load() && !is_installed_, "code is installed twice, or before it is ready");
  jit::install(lowered_, made_);
  is_installed_ = true;
  return before;
}

std::string Tiers::summary() {
  end();
  if (!is_installed_)
    return "code: interpreted" + (problem_.empty() || problem_.ends_with("stopped") ? "" : ": " + problem_) + "\n";
  return text_of(made_, "code: interpreted, then", "after ", seconds_);
}

std::string text_of(const jit::MadeCode& made, std::string_view begin, std::string_view when, double seconds) {
  std::string text = fmt::format("{} {} module{}, {} from the cache, {}{:.6f} s\n", begin, made.modules,
                                 made.modules == 1 ? "" : "s", made.from_cache, when, seconds);
  for (const std::string& file : made.broken_files)
    text += fmt::format("note: `{}` was broken and is made anew\n", file);
  return text;
}

}  // namespace bip::pipeline
