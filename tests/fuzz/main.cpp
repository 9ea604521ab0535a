// bip-fuzz: kept inputs again, or random edits of good sources, in one process.
//
//   bip-fuzz TARGET FILE...                          each file once
//   bip-fuzz TARGET --edits N --seed S FILE...       N edits of the files
//
// An input that crashes or takes more than ten seconds is left in `fuzz-failed` in the working directory. The last line
// is "N inputs, N accepted, N failed". Exit code 1 if one failed.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <fcntl.h>
#include <sys/time.h>
#include <unistd.h>

#include "tests/fuzz/mutate.hpp"
#include "tests/fuzz/targets.hpp"

namespace {

// Of the processor: on a busy machine the clock says nothing about the input.
constexpr int kSeconds = 10;

void limit_time(int seconds) {
  const itimerval limit{.it_interval = {}, .it_value = {.tv_sec = seconds, .tv_usec = 0}};
  setitimer(ITIMER_PROF, &limit, nullptr);
}

// What the signal handler writes down: set before each input.
const char* current = nullptr;
std::size_t current_size = 0;

extern "C" void leave_input(int signal) {
  const int file = open("fuzz-failed", O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0 && write(file, current, current_size) >= 0) close(file);
  const char* what =
      signal == SIGPROF ? "too slow; the input is in fuzz-failed\n" : "crashed; the input is in fuzz-failed\n";
  if (write(2, what, std::strlen(what)) < 0) _exit(3);
  _exit(2);
}

void catch_signals() {
  // A stack of its own: it may be the stack that is full.
  static char stack[1 << 16];
  stack_t own{};
  own.ss_sp = stack;
  own.ss_size = sizeof stack;
  sigaltstack(&own, nullptr);
  struct sigaction action {};
  action.sa_handler = leave_input;
  action.sa_flags = SA_ONSTACK;
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGPROF}) sigaction(signal, &action, nullptr);
}

std::size_t failed = 0;
std::size_t accepted = 0;

void run(bip::fuzz::Target target, const std::string& input, const std::string& name) {
  current = input.data();
  current_size = input.size();
  limit_time(kSeconds);
  const auto [problem, is_accepted] = target(input);
  limit_time(0);
  if (is_accepted) ++accepted;
  if (problem.empty()) return;
  std::printf("%s: %s\n", name.c_str(), problem.c_str());
  if (++failed > 20) return;
  std::ofstream("fuzz-failed-" + std::to_string(failed), std::ios::binary) << input;
}

}  // namespace

int main(int argc, char** argv) {
  const bip::fuzz::Target target = argc > 1 ? bip::fuzz::find_target(argv[1]) : nullptr;
  if (target == nullptr) {
    std::fprintf(stderr,
                 "usage: bip-fuzz text|bsys|format|lsp|genom|rules|property|frame [--edits N] [--seed S] FILE...\n");
    return 64;
  }
  std::size_t edits = 0;
  std::uint64_t seed = 1;
  std::vector<std::string> names;
  std::vector<std::string> sources;
  for (int i = 2; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--edits" && i + 1 < argc) {
      edits = std::strtoull(argv[++i], nullptr, 10);
    } else if (argument == "--seed" && i + 1 < argc) {
      seed = std::strtoull(argv[++i], nullptr, 10);
    } else {
      std::ifstream file(argument, std::ios::binary);
      names.push_back(argument);
      sources.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
  }
  catch_signals();
  if (edits > 0 && !sources.empty()) {
    for (std::size_t i = 0; i < edits; ++i) {
      bip::fuzz::Random random(seed * 0x100000001u + i);
      run(target, bip::fuzz::mutated(sources, random),
          "edit " + std::to_string(i) + " of seed " + std::to_string(seed));
    }
    std::printf("%zu inputs, %zu accepted, %zu failed\n", edits, accepted, failed);
  } else {
    for (std::size_t i = 0; i < sources.size(); ++i) run(target, sources[i], names[i]);
    std::printf("%zu inputs, %zu accepted, %zu failed\n", sources.size(), accepted, failed);
  }
  return failed == 0 ? 0 : 1;
}
