// See line_reader.hpp. libedit's interface is global: one reader at a time.
#include "compiler/debug/line_reader.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "bip/assert.hpp"

#ifdef BIPC_LIBEDIT
#include <editline/readline.h>
#endif

namespace bip::debug {

#ifdef BIPC_LIBEDIT
namespace {

// What libedit's callbacks reach, which take no argument of ours.
const LineReader::Complete* complete_at_hand = nullptr;
std::vector<std::string> offered_words;

char* next_offered_word(const char* text, int state) {
  static std::size_t next = 0;
  if (state == 0) {
    offered_words = (*complete_at_hand)(text);
    next = 0;
  }
  return next < offered_words.size() ? ::strdup(offered_words[next++].c_str()) : nullptr;
}

char** complete_line(const char* text, int, int) {
  // Names end neither in a blank nor are they files.
  rl_attempted_completion_over = 1;
  rl_completion_append_character = 0;
  return rl_completion_matches(text, next_offered_word);
}

}  // namespace
#endif

LineReader::LineReader(Complete complete)
    : complete_(std::move(complete)), is_terminal_(::isatty(STDIN_FILENO) == 1 && ::isatty(STDOUT_FILENO) == 1) {
#ifdef BIPC_LIBEDIT
  BIP_ASSERT(complete_at_hand == nullptr, "there is another reader of lines");
  complete_at_hand = &complete_;
  rl_attempted_completion_function = complete_line;
  // Paths contain dots, brackets and `@`.
  static char breaks[] = " \t\n()!&|<>=+-*";
  rl_completer_word_break_characters = breaks;
  if (is_terminal_) using_history();
#endif
}

LineReader::~LineReader() {
#ifdef BIPC_LIBEDIT
  complete_at_hand = nullptr;
#endif
}

std::optional<std::string> LineReader::read(const std::string& prompt) {
#ifdef BIPC_LIBEDIT
  if (is_terminal_) {
    char* const line = ::readline(prompt.c_str());
    if (line == nullptr) return std::nullopt;
    std::string text(line);
    if (!text.empty()) add_history(line);
    std::free(line);
    return text;
  }
#endif
  if (is_terminal_) std::fputs(prompt.c_str(), stdout);
  std::fflush(stdout);
  std::string line;
  int c = 0;
  while ((c = std::fgetc(stdin)) != EOF && c != '\n') line += static_cast<char>(c);
  if (c == EOF && line.empty()) return std::nullopt;
  return line;
}

}  // namespace bip::debug
