// See lessons.hpp. The texts are part of the program, so a line that cannot be read is a fault of the build.
#include "compiler/driver/lessons.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include "bip/assert.hpp"

namespace bip::driver {
namespace {

// Removes `word` and the blanks behind it from the beginning of `line`.
bool take_prefix(std::string_view& line, std::string_view word) {
  if (!line.starts_with(word)) return false;
  line.remove_prefix(word.size());
  while (line.starts_with(' ')) line.remove_prefix(1);
  return true;
}

std::string_view take_word(std::string_view& line) {
  const std::string_view word = line.substr(0, line.find(' '));
  line.remove_prefix(word.size());
  take_prefix(line, " ");
  return word;
}

std::uint64_t take_number(std::string_view& line) {
  const std::string_view word = take_word(line);
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  BIP_ENSURE(error == std::errc() && end == word.data() + word.size(), "lesson: `{}` is no number", word);
  return number;
}

LessonCheck read_check(CheckKind kind, std::string_view line) {
  LessonCheck check;
  check.kind = kind;
  while (true) {
    if (take_prefix(line, "--seed ")) {
      check.seed = take_number(line);
    } else if (take_prefix(line, "--limit ")) {
      check.limit = take_number(line);
    } else if (take_prefix(line, "--fair=")) {
      check.fair = take_word(line);
      const std::string problem = verify::problem_of_fairness(check.fair);
      BIP_ENSURE(problem.empty(), "lesson: {} before `{}`", problem, line);
    } else {
      check.text = line;
      return check;
    }
  }
}

Exercise read_exercise(std::string_view line) {
  const std::size_t colon = line.find(": ");
  BIP_ENSURE(colon != std::string_view::npos, "lesson: no title in `{}`", line);
  std::string_view number = line.substr(0, colon);
  Exercise exercise;
  exercise.number = static_cast<int>(take_number(number));
  exercise.title = line.substr(colon + 2);
  return exercise;
}

}  // namespace

std::vector<Exercise> parse_lesson(std::string_view text) {
  std::vector<Exercise> exercises;
  while (!text.empty()) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.empty() || line.starts_with('#')) continue;
    if (take_prefix(line, "exercise ")) {
      exercises.push_back(read_exercise(line));
      continue;
    }
    BIP_ENSURE(!exercises.empty(), "lesson: `{}` belongs to no exercise", line);
    Exercise& exercise = exercises.back();
    if (take_prefix(line, "root ")) {
      exercise.root = line;
    } else if (take_prefix(line, "holds ")) {
      exercise.checks.push_back(read_check(CheckKind::Holds, line));
    } else if (take_prefix(line, "violated ")) {
      exercise.checks.push_back(read_check(CheckKind::Violated, line));
    } else if (take_prefix(line, "prints ")) {
      exercise.checks.push_back(read_check(CheckKind::Prints, line));
    } else {
      BIP_ENSURE(take_prefix(line, "  ") && !exercise.checks.empty(), "lesson: `{}` is nothing", line);
      std::string& hint = exercise.checks.back().hint;
      hint += (hint.empty() ? "" : " ") + std::string(line);
    }
  }
  return exercises;
}

}  // namespace bip::driver
