// Smaller instances of a compiled model: the same file with smaller numbers in its root, `Ring(100)` as `Ring(3)`. What
// the verifier learns lemmas from (compiler/verify/scaling).
#pragma once
#include <memory>
#include <vector>

#include "compiler/pipeline/pipeline.hpp"
#include "compiler/verify/scaling/small_instance.hpp"

namespace bip::library {

class SmallInstanceCompiler {
 public:
  /// `model` must outlive it.
  explicit SmallInstanceCompiler(const pipeline::Compilation& model) : model_(model) {}

  /// Compiles the root with its ints above `size` replaced by it. Nothing if none is above, if that root does not
  /// compile, or if it was named without arguments.
  [[nodiscard]] std::optional<verify::SmallInstance> at(std::uint32_t size);

 private:
  const pipeline::Compilation& model_;
  std::vector<std::unique_ptr<pipeline::Compilation>> made_;
};

/// "Ring(100, true)" with ints of at most 3: "Ring(3, true)".
[[nodiscard]] std::string scaled_root(const std::string& root, std::uint32_t size);

}  // namespace bip::library
