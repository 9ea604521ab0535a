// The stack of stages that a failed assertion prints. It is thread-local and read by nothing else, so two compilations
// in one process do not interfere.
#include "compiler/base/stage_scope.hpp"

#include <cstdio>
#include <string_view>

namespace bip {
namespace {
thread_local const StageScope* innermost_stage = nullptr;
}

void print_stages() {
  for (const StageScope* stage = innermost_stage; stage != nullptr; stage = stage->outer_) {
    std::fprintf(stderr, "  while %s `%.*s`\n", stage->doing_, static_cast<int>(stage->what_.size()),
                 stage->what_.data());
  }
}

StageScope::StageScope(const char* doing, std::string_view what) : doing_(doing), what_(what), outer_(innermost_stage) {
  innermost_stage = this;
  assertion_context = &print_stages;
}
StageScope::~StageScope() { innermost_stage = outer_; }

}  // namespace bip
