// The example of compiler/docs/bsys.md is a System, and `print` writes it as it stands there (comments apart).
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "compiler/system/bsys.hpp"
#include "compiler/system/system.hpp"

using namespace bip;

namespace {

/// The last fenced block of a text.
std::string last_block(const std::string& text) {
  const std::size_t end = text.rfind("\n```");
  const std::size_t begin = text.rfind("```\n", end);
  REQUIRE(end != std::string::npos);
  REQUIRE(begin != std::string::npos);
  return text.substr(begin + 4, end + 1 - begin - 4);
}

/// Without comments and the blanks before them. Strings of the example hold no semicolon.
std::string without_comments(const std::string& text) {
  std::istringstream lines(text);
  std::string out, line;
  while (std::getline(lines, line)) {
    line.erase(std::min(line.find(';'), line.size()));
    while (!line.empty() && line.back() == ' ') line.pop_back();
    out += line + "\n";
  }
  return out;
}

}  // namespace

TEST_CASE("the example in the docs holds") {
  const std::filesystem::path root = BIP_TEST_SOURCE_DIR;
  std::ifstream file(root / "compiler" / "docs" / "bsys.md");
  REQUIRE(file);
  std::stringstream content;
  content << file.rdbuf();
  const std::string block = last_block(content.str());
  const Result<System> system = system::parse_bsys(block);
  if (!system) FAIL(system.error());
  CHECK(system::print(*system) == without_comments(block));
}
