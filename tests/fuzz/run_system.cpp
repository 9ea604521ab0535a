// A few steps of an accepted system, chosen by a walk that reaches different candidates. What is looked for are
// crashes, broken asserts and sanitizers' reports; the meaning of a step is what tools/gen checks.
//
// The core's bounds are lowered: a model whose internal transitions never end, or whose connector has 2^30
// interactions, must be told so, and it need not take a million steps to see that.
#include "tests/fuzz/run_system.hpp"

#include <memory>
#include <vector>

#include "compiler/interp/interp.hpp"
#include "compiler/lower/lower.hpp"
#include "runtime/core/core.hpp"
#include "runtime/include/bip/ffi.hpp"

namespace bip::fuzz {
namespace {

constexpr int kSteps = 20;
constexpr rt::CoreOptions kBounds{.internal_bound = 1000, .enumeration_bound = 1u << 10};

std::int32_t answer_zero(rt::FfiContext*, rt::Cell* result, rt::Cell* const*) {
  *result = rt::Cell{.bits = 0};
  return 0;
}
std::int32_t answer_empty(rt::FfiContext* ffi, rt::Cell* result, rt::Cell* const*) {
  *result = rt::Cell{.bits = static_cast<std::uint32_t>(ffi->intern(""))};
  return 0;
}
// The object that the cell points to stays as it is.
std::int32_t answer_object(rt::FfiContext*, rt::Cell*, rt::Cell* const*) { return 0; }

void stand_in(lower::LoweredSystem& lowered, const CodeTable& code) {
  for (std::size_t row = 0; row < lowered.functions.size(); ++row) {
    const Function& function = code.functions[row];
    const bool gives = function.has_result;
    lowered.functions[row] = gives && is_ffi(function.result)           ? &answer_object
                             : gives && function.result == Type::String ? &answer_empty
                                                                        : &answer_zero;
  }
  for (rt::FfiType& type : lowered.ffi_types) type = rt::ffi_type_of<int>(type.name);
}

}  // namespace

std::string try_running(const System& system) {
  const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(system, "fuzz");
  stand_in(*lowered, system.code);
  const interp::Interpreter interpreter(*lowered);
  rt::Core core(lowered->image, kBounds);
  if (!core.initialize()) return core.fault().what.empty() ? "a fault without words" : std::string();
  std::vector<rt::Participant> participants;
  for (std::uint64_t step = 0; step < kSteps && core.candidate_count() > 0; ++step) {
    const std::uint64_t k = step * 7919 % core.candidate_count();
    const rt::Candidate candidate = core.candidate(k);
    core.participants(candidate, participants);
    if (participants.empty()) return "a step in which nobody takes part";
    if (!core.fire(candidate)) return core.fault().what.empty() ? "a fault without words" : std::string();
  }
  return {};
}

}  // namespace bip::fuzz
