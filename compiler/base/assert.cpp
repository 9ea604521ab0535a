// The end of the line for our own bugs: says what, where and during which stage, then leaves with exit code 70.
//
// The stage stack is thread-local bookkeeping for this one message: nothing else reads it, so two compilations in one
// process still never meet. fprintf and _Exit on purpose: after a broken invariant nothing heavier can be trusted.
#include "compiler/base/assert.hpp"

#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace bip {
namespace {
thread_local const StageScope* innermost_stage = nullptr;
}

StageScope::StageScope(const char* doing, std::string_view what) : doing_(doing), what_(what), outer_(innermost_stage) {
  innermost_stage = this;
}
StageScope::~StageScope() { innermost_stage = outer_; }

namespace {
// From the repository's folder on: the rest is the machine that built us.
const char* short_path(const char* file) {
  const std::string_view path(file);
  for (const char* folder : {"/compiler/", "/runtime/", "/tests/", "/tools/"}) {
    if (const std::size_t at = path.rfind(folder); at != std::string_view::npos) return file + at + 1;
  }
  return file;
}
}  // namespace

void report_bug(const char* what, const char* file, int line) {
  std::fprintf(stderr, "bipc: internal error: %s (%s:%d)\n", what, short_path(file), line);
  for (const StageScope* s = innermost_stage; s != nullptr; s = s->outer_) {
    std::fprintf(stderr, "  while %s `%.*s`\n", s->doing_, static_cast<int>(s->what_.size()), s->what_.data());
  }
  std::fprintf(stderr, "this is a bug of bipc, not of your model: please report it with the input\n");
  std::fflush(nullptr);
  std::_Exit(70);
}

}  // namespace bip
