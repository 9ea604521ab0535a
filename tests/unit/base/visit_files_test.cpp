#include "compiler/base/visit_files.hpp"

#include <sys/resource.h>

#include "compiler/base/write_file.hpp"
#include "tests/unit/base/scratch_folder.hpp"

namespace fs = std::filesystem;

namespace bip {

TEST_CASE("files below a folder are listed whole, sorted, with links to files and no others") {
  const testing::ScratchFolder folder;
  const fs::path root = folder.path();
  fs::create_directories(root / "b" / "deep");
  for (const char* name : {"z", "a", "b/m", "b/deep/k"}) REQUIRE(write_file(root / name, name));
  fs::create_symlink("z", root / "link");
  fs::create_symlink("nowhere", root / "dead");
  fs::create_symlink("around", root / "around");
  fs::create_directory_symlink("..", root / "b" / "up");
  std::error_code error;
  const std::vector<fs::path> wanted{root / "a", root / "b" / "deep" / "k", root / "b" / "m", root / "link",
                                     root / "z"};
  CHECK(files_below(root, error) == wanted);
  CHECK_FALSE(error);
}

TEST_CASE("a folder is skipped, a visit is stopped") {
  const testing::ScratchFolder folder;
  const fs::path root = folder.path();
  fs::create_directories(root / "b" / "deep");
  for (const char* name : {"b/m", "b/deep/k"}) REQUIRE(write_file(root / name, name));
  int entries = 0;
  CHECK_FALSE(visit_files(root, [&](const FolderEntry& entry) {
    ++entries;
    return entry.is_folder && entry.depth == 1 ? Visit::SkipFolder : Visit::GoOn;
  }));
  CHECK(entries == 3);
  entries = 0;
  CHECK_FALSE(visit_files(root, [&](const FolderEntry&) { return ++entries == 2 ? Visit::Stop : Visit::GoOn; }));
  CHECK(entries == 2);
}

TEST_CASE("a folder below that cannot be opened for want of files is an error, not an empty folder") {
  const testing::ScratchFolder folder;
  const fs::path root = folder.path();
  fs::create_directories(root / "b");
  REQUIRE(write_file(root / "b" / "m", "m"));
  struct rlimit before {};
  REQUIRE(::getrlimit(RLIMIT_NOFILE, &before) == 0);
  int entries = 0;
  const std::error_code error = visit_files(root, [&](const FolderEntry&) {
    ++entries;
    const struct rlimit none { .rlim_cur = 0, .rlim_max = before.rlim_max };
    REQUIRE(::setrlimit(RLIMIT_NOFILE, &none) == 0);
    return Visit::GoOn;
  });
  REQUIRE(::setrlimit(RLIMIT_NOFILE, &before) == 0);
  CHECK(entries == 1);
  CHECK(error == std::errc::too_many_files_open);
}

TEST_CASE("what is no folder is an error") {
  const testing::ScratchFolder folder;
  const fs::path root = folder.path();
  REQUIRE(write_file(root / "file", ""));
  std::error_code error;
  CHECK(files_below(root / "file", error).empty());
  CHECK(error == std::errc::not_a_directory);
  CHECK(files_below(root / "missing", error).empty());
  CHECK(error == std::errc::no_such_file_or_directory);
}

}  // namespace bip
