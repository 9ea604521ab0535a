// Smaller instances of the model that a question is about: its root with smaller sizes. Who compiles models hands them
// out; the engines only ask.
#pragma once
#include <functional>
#include <optional>

#include "runtime/include/bip/image.hpp"
#include "compiler/verify/portfolio/question.hpp"
#include "compiler/verify/scaling/index_families.hpp"

namespace bip::verify {

/// Both live as long as who made them.
struct SmallInstance {
  const System* system = nullptr;
  const rt::Image* image = nullptr;  // its code is not called
};
/// Returns the instance whose sizes are at most `size`; nothing if there is none, or if it would not be smaller.
using SmallInstances = std::function<std::optional<SmallInstance>(std::uint32_t size)>;

/// Returns the question that the small instance is to be asked instead: elements near the beginning of an array stand
/// for those near its beginning, elements near its end for those near its end, and of a conjunction or a disjunction
/// the operands about others are left out. Nothing if nothing is left. What is learnt from the answer is a guess in any
/// case.
[[nodiscard]] std::optional<Question> question_at(const Question& question, const System& large_system,
                                                  const IndexFamilies& large, const Dimensions& dimensions,
                                                  const System& small_system, const InstanceView& small);

}  // namespace bip::verify
