// A broken assertion ends with code 70 and says what was being done.
#include "compiler/base/stage_scope.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <string>

TEST_CASE("a bug is reported with its stages and exit code 70") {
  std::array<int, 2> ends{};
  REQUIRE(::pipe(ends.data()) == 0);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    ::dup2(ends[1], STDERR_FILENO);
    const bip::StageScope outer("flattening connector", "sync");
    { const bip::StageScope closed("counting", "sheep"); }
    BIP_ENSURE(1 + 1 == 3);
    ::_exit(0);
  }
  ::close(ends[1]);
  std::string text;
  std::array<char, 256> chunk{};
  for (ssize_t got = 0; (got = ::read(ends[0], chunk.data(), chunk.size())) > 0;)
    text.append(chunk.data(), static_cast<std::size_t>(got));
  ::close(ends[0]);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 70);
  REQUIRE(text.find("internal error: 1 + 1 == 3 (tests/unit/base/assert_test.cpp:") != std::string::npos);
  REQUIRE(text.find("while flattening connector `sync`") != std::string::npos);
  REQUIRE(text.find("sheep") == std::string::npos);
}
