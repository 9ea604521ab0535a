// Names of what `--emit` takes.
#include "compiler/pipeline/options.hpp"

#include "bip/assert.hpp"

namespace bip::pipeline {

const char* name_of(EmitKind kind) {
  static constexpr const char* kNames[] = {"none", "tokens", "syntax", "model", "system",
                                           "llvm", "asm",    "cpp",    "dot",   "json"};
  return kNames[static_cast<std::size_t>(kind)];
}

}  // namespace bip::pipeline
