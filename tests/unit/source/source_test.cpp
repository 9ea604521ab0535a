// Lines, columns and loading.
#include "compiler/source/source.hpp"

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>

namespace {

// A file that disappears with the test.
class TestFile {
 public:
  explicit TestFile(const std::string& bytes)
      : path_((std::filesystem::temp_directory_path() / ("source_test_" + std::to_string(std::rand()))).string()) {
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  ~TestFile() { std::filesystem::remove(path_); }
  TestFile(const TestFile&) = delete;
  TestFile& operator=(const TestFile&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::string failure_of(const std::string& bytes) {
  const TestFile file(bytes);
  bip::SourceMap sources;
  const auto loaded = sources.load(file.path());
  return loaded ? "" : loaded.error();
}

}  // namespace

TEST_CASE("lines and columns start at 1 and count bytes") {
  bip::SourceMap sources;
  const bip::FileId file = sources.add("a.bip", "one\ntw\xC3\xA4o\r\n\nlast");
  REQUIRE(sources.loc(file, 0) == bip::Loc{0, 1, 1});
  REQUIRE(sources.loc(file, 3) == bip::Loc{0, 1, 4});
  REQUIRE(sources.loc(file, 4) == bip::Loc{0, 2, 1});
  REQUIRE(sources.loc(file, 8) == bip::Loc{0, 2, 5});
  REQUIRE(sources.line(file, 2) == "tw\xC3\xA4o");
  REQUIRE(sources.line(file, 3).empty());
  REQUIRE(sources.line(file, 4) == "last");
  REQUIRE(sources.line(file, 5).empty());
  REQUIRE(sources.line(file, 0).empty());
  REQUIRE(sources.text({file, 0, 3}) == "one");
  REQUIRE(sources.text({file, 14, 900}) == "st");
  REQUIRE(sources.loc(bip::SourceRange{}) == bip::Loc{});
}

TEST_CASE("an empty text has one empty line") {
  bip::SourceMap sources;
  const bip::FileId file = sources.add("empty", "");
  REQUIRE(sources.loc(file, 0) == bip::Loc{0, 1, 1});
  REQUIRE(sources.line(file, 1).empty());
}

TEST_CASE("texts do not move when more are added") {
  bip::SourceMap sources;
  const bip::FileId first = sources.add("first", "x");
  const char* at = sources.text(first).data();
  for (int i = 0; i < 1000; ++i) sources.add("more", "y");
  REQUIRE(sources.text(first).data() == at);
}

TEST_CASE("loading says in a line why it failed") {
  bip::SourceMap sources;
  REQUIRE(sources.load("/nowhere/at/all").error() == "no such file");
  REQUIRE(sources.load(std::filesystem::temp_directory_path().string()).error() == "is a directory");
  REQUIRE(sources.size() == 0);
  REQUIRE(failure_of("good\nb\xFF") == "not UTF-8: byte 0xff at 2:2");
  REQUIRE(failure_of(std::string("a\n\n\0b", 5)) == "not a text: NUL byte at 3:1");
  REQUIRE(failure_of("").empty());
  REQUIRE(failure_of("\xE2\x89\xA4").empty());
}

TEST_CASE("a file over the limit is refused without reading it whole into the map") {
  const TestFile file("");
  std::filesystem::resize_file(file.path(), bip::SourceMap::kMaxFileBytes + 1);
  bip::SourceMap sources;
  REQUIRE(sources.load(file.path()).error() == "larger than the limit of 64 MiB");
}
