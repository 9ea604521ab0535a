// The exercises of the book's lessons, embedded at build time from compiler/docs/book/exercises/*.lesson. A file is a
// list of exercises; an exercise is a title and checks, a line each; the indented lines below a check are its hint:
//
//   exercise 1: Repair the kitchen
//   root Kitchen()                          (without it the model's own)
//   holds [--fair=F] PROPERTY               `bipc verify` must answer that it holds
//   violated [--fair=F] PROPERTY            … that it is violated
//   prints [--seed N] [--limit N] TEXT      a line of a run, or of the state at its end, has TEXT in it
//     hint, shown if the check fails
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/verify/property/fairness.hpp"

namespace bip::driver {

struct LessonText {
  int number;
  std::string_view text;
};
/// All files, by number. Generated.
[[nodiscard]] std::span<const LessonText> lesson_texts();

enum class CheckKind : std::uint8_t { Holds, Violated, Prints };
struct LessonCheck {
  CheckKind kind = CheckKind::Holds;
  std::string text;           // a property, or a part of a line
  std::string fair = "none";  // of properties of runs
  std::uint64_t seed = 1, limit = 100;
  std::string hint;
};
struct Exercise {
  int number = 0;
  std::string title;
  std::string root;  // empty: the model's
  std::vector<LessonCheck> checks;
};
[[nodiscard]] std::vector<Exercise> parse_lesson(std::string_view text);

}  // namespace bip::driver
