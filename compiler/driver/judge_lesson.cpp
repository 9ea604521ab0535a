// See judge_lesson.hpp. A check is what a person would do: `bipc verify --property …`, or `bipc run --show-state` and
// reading what it prints. Each has a compilation of its own, since a question may take C++ out of the model.
#include "compiler/driver/judge_lesson.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include <fmt/format.h>

#include "compiler/driver/answer_question.hpp"
#include "compiler/driver/lessons.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/ffi_build.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::driver {
namespace {

constexpr double kSecondsOfCheck = 20;
constexpr std::size_t kLinesShown = 14;  // at most so many of the last lines of a run or a verdict

struct Selection {
  int lesson = 0, exercise = 0;  // exercise 0: all of them
};

// `3` or `3.2`.
std::optional<Selection> read_selection(std::string_view text) {
  Selection selection;
  const char* end = text.data() + text.size();
  auto [at, error] = std::from_chars(text.data(), end, selection.lesson);
  if (error != std::errc()) return std::nullopt;
  if (at == end) return selection;
  if (*at != '.') return std::nullopt;
  const auto [rest, second_error] = std::from_chars(at + 1, end, selection.exercise);
  if (second_error != std::errc() || rest != end || selection.exercise < 1) return std::nullopt;
  return selection;
}

std::string indented(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    result += fmt::format("    {}\n", line);
  }
  return result;
}

std::string last_lines(const std::string& text) {
  std::size_t at = text.size();
  for (std::size_t lines = 0; at > 0; --at) {
    if (text[at - 1] == '\n' && at != text.size() && ++lines == kLinesShown) break;
  }
  return (at > 0 ? "...\n" : "") + text.substr(at);
}

// What the run prints on either stream.
std::string run_text(Compilation& c, const LessonCheck& check) {
  Executor executor;
  if (!executor.prepare(c, Backend::Interp, Optimisation::Auto)) return {};
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* file = ::open_memstream(&text, &size);
  if (file == nullptr) return {};
  rt::RunOptions options;
  options.seed = check.seed;
  options.has_seed = true;
  options.limit = check.limit;
  options.show_state = true;
  rt::run(c.lowered->image, options, file, file);
  std::fclose(file);
  std::string result(text, size);
  std::free(text);
  return result;
}

struct Judgement {
  bool is_met = false;
  std::string found;  // what was found instead
};

Judgement judge_property(Compilation& c, const LessonCheck& check) {
  library::VerifyRequest request;
  request.backend = Backend::Interp;
  request.timeout = kSecondsOfCheck;
  request.property = check.text;
  request.reuses = false;
  const Result<verify::Question> question = library::read_question(request, *c.system);
  if (!question) return {.found = fmt::format("this model cannot be asked that: {}\n", question.error())};
  Result<verify::Fairness> fairness = verify::read_fairness(check.fair, *c.system);
  if (!fairness) return {.found = fmt::format("this model cannot be asked that: --fair, {}\n", fairness.error())};
  request.fairness = std::move(*fairness);
  const std::string note = library::remove_unread_cpp(request, c, library::data_of(*question));
  const library::Verdict verdict = answer_question(request, c, *question, note);
  const int wanted = check.kind == CheckKind::Holds ? kOk : kViolated;
  return {.is_met = verdict.is_answered && verdict.exit_code == wanted, .found = verdict.text};
}

Judgement judge_check(Compilation& c, const LessonCheck& check) {
  if (check.kind != CheckKind::Prints) return judge_property(c, check);
  const std::string text = run_text(c, check);
  return {.is_met = text.find(check.text) != std::string::npos, .found = text};
}

std::string expectation(const LessonCheck& check) {
  const std::string fairness = check.fair == "none" ? "" : fmt::format(" with --fair={}", check.fair);
  if (check.text == "errors" && check.kind == CheckKind::Holds) return "no run must end with an error";
  if (check.text == "deadlock" && check.kind == CheckKind::Holds) return "there must be no deadlock";
  switch (check.kind) {
    case CheckKind::Holds: return fmt::format("`{}` must hold{}", check.text, fairness);
    case CheckKind::Violated: return fmt::format("`{}` must be violated{}", check.text, fairness);
    case CheckKind::Prints:
      return fmt::format("`bipc run --show-state --seed {} --limit {}` must print `{}`", check.seed, check.limit,
                         check.text);
  }
  return {};
}

// The exit code, after the answer was printed.
int judge_exercise(const CheckArguments& arguments, int lesson, const Exercise& exercise) {
  const std::string name = fmt::format("exercise {}.{}, {}", lesson, exercise.number, exercise.title);
  std::string answer = name + ": solved\n";
  int code = kOk;
  for (const LessonCheck& check : exercise.checks) {
    CompileOptions options = arguments.compile;
    if (!exercise.root.empty()) options.root = exercise.root;
    Compilation c(options);
    if (!compile(c, arguments.files.front(), Stage::Image)) return report(c);
    if (c.options.refuses_cpp && uses_ffi(c)) {
      c.diags.report(Diag::kB5014, {}, "compile and load");
      return report(c);
    }
    const Judgement judgement = judge_check(c, check);
    if (c.diags.has_errors()) return report(c);
    if (judgement.is_met) continue;
    answer = fmt::format("{}: not solved\n  {}:\n{}  = hint: {}\n", name, expectation(check),
                         indented(last_lines(judgement.found)), check.hint);
    code = kViolated;
    break;
  }
  std::fwrite(answer.data(), 1, answer.size(), stdout);
  return code;
}

}  // namespace

int judge_lesson(const CheckArguments& arguments) {
  if (arguments.files.size() != 1 || arguments.files.front() == "-") return usage_error("--lesson judges one file");
  const std::span<const LessonText> texts = lesson_texts();
  const std::optional<Selection> selection = read_selection(arguments.lesson);
  const LessonText* chosen = nullptr;
  for (const LessonText& text : texts) {
    if (selection && text.number == selection->lesson) chosen = &text;
  }
  if (chosen == nullptr)
    return usage_error(fmt::format("there is no lesson `{}`", arguments.lesson),
                       fmt::format("--lesson 1 to --lesson {}; --lesson 1.2 is the second exercise of the first",
                                   texts.back().number));
  const std::vector<Exercise> exercises = parse_lesson(chosen->text);
  if (selection->exercise > static_cast<int>(exercises.size()))
    return usage_error(fmt::format("lesson {} has {} exercises", selection->lesson, exercises.size()));
  // Warnings are said once; the checks compile the file again.
  Compilation c(arguments.compile);
  (void)check(c, arguments.files.front());
  if (const int code = report(c); code != kOk) return code;
  int worst = kOk;
  for (const Exercise& exercise : exercises) {
    if (selection->exercise != 0 && selection->exercise != exercise.number) continue;
    const int code = judge_exercise(arguments, chosen->number, exercise);
    if (code == kModelErrors) return code;
    worst = std::max(worst, code);
  }
  return worst;
}

}  // namespace bip::driver
