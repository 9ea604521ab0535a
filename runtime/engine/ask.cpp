// See ask.hpp. Lines are read whole, whatever their length, so that a wrong one costs one answer.
#include "runtime/engine/ask.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "runtime/engine/interrupt.hpp"

namespace bip::rt {

namespace {

// Waits until there is input, or its end. Returns false if a signal ends the run before.
bool wait_for_input(std::FILE* in) {
  struct pollfd input {
    .fd = ::fileno(in), .events = POLLIN, .revents = 0
  };
  while (input.fd >= 0 && ::poll(&input, 1, -1) < 0 && errno == EINTR) {
    if (is_interrupted()) return false;
  }
  return !is_interrupted();
}

// Without the white space around it. False at the end of input before any character.
bool read_word(std::FILE* in, std::string& word) {
  std::string line;
  int c = 0;
  while ((c = std::fgetc(in)) != EOF && c != '\n') line += static_cast<char>(c);
  if (c == EOF && line.empty()) return false;
  constexpr const char* kSpace = " \t\r";
  const std::size_t first = line.find_first_not_of(kSpace);
  word = first == std::string::npos ? "" : line.substr(first, line.find_last_not_of(kSpace) - first + 1);
  return true;
}

bool parse_below(const std::string& word, std::uint64_t count, std::uint64_t& k) {
  if (word.empty() || word.find_first_not_of("0123456789") != std::string::npos) return false;
  k = 0;
  for (const char digit : word) {
    k = k * 10 + static_cast<std::uint64_t>(digit - '0');
    if (k >= count) return false;
  }
  return true;
}

}  // namespace

bool ask_candidate(std::FILE* in, std::FILE* out, std::uint64_t count, std::uint64_t& k) {
  // What is in no buffer can be waited for.
  std::setvbuf(in, nullptr, _IONBF, 0);
  const bool is_terminal = ::isatty(::fileno(in)) == 1;
  const auto last = static_cast<unsigned long long>(count - 1);
  std::string word;
  while (true) {
    if (is_terminal) std::fprintf(out, "choose 0 to %llu (q ends): ", last);
    std::fflush(out);
    if (!wait_for_input(in) || !read_word(in, word) || word == "q") return false;
    if (parse_below(word, count, k)) return true;
    if (!word.empty()) std::fprintf(out, "`%.80s` is not a number from 0 to %llu\n", word.c_str(), last);
  }
}

}  // namespace bip::rt
