// Files are replaced whole or not at all, and nothing is left beside them; a cache is private or not used.
#include "compiler/base/write_file.hpp"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <thread>

#include "compiler/base/build_id.hpp"
#include "compiler/base/content_cache.hpp"
#include "compiler/base/read_file.hpp"
#include "tests/unit/base/scratch_folder.hpp"

namespace fs = std::filesystem;

namespace bip {
namespace {

std::size_t files_in(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

}  // namespace

TEST_CASE("a new file that is not committed leaves the old one and nothing else") {
  const testing::ScratchFolder folder;
  const std::string path = folder.path() + "/a";
  REQUIRE(write_file(path, "old"));
  {
    Result<NewFile> file = NewFile::create(path);
    REQUIRE(file);
    CHECK(files_in(folder.path()) == 2);
    REQUIRE(file->write("new"));
    CHECK(read_file(path) == "old");
  }
  CHECK(read_file(path) == "old");
  CHECK(files_in(folder.path()) == 1);
}

TEST_CASE("links are followed, also those that lead nowhere yet") {
  const testing::ScratchFolder folder;
  fs::create_symlink("target", folder.path() + "/link");
  REQUIRE(write_file(folder.path() + "/link", "text"));
  CHECK(fs::is_symlink(folder.path() + "/link"));
  CHECK(read_file(folder.path() + "/target") == "text");
  CHECK(is_same_file(folder.path() + "/link", folder.path() + "/target"));
  CHECK_FALSE(is_same_file(folder.path() + "/link", folder.path()));
  CHECK_FALSE(is_same_file(folder.path() + "/none", folder.path() + "/none"));
}

TEST_CASE("a pipe stays a pipe when a new file is written to its name") {
  const testing::ScratchFolder folder;
  const std::string path = folder.path() + "/pipe";
  REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
  std::optional<std::string> got;
  std::thread reader([&] { got = read_file(path); });
  {
    Result<NewFile> file = NewFile::create(path);
    REQUIRE(file);
    CHECK(files_in(folder.path()) == 1);
    CHECK(file->write("text"));
    CHECK(file->commit(Durability::Synced));
  }
  reader.join();
  CHECK(got == "text");
  CHECK(fs::is_fifo(path));
  CHECK(NewFile::create(folder.path()).error() == "Is a directory");
}

TEST_CASE("a signal that ends the process while a file is written comes when the file is gone") {
  const testing::ScratchFolder folder;
  const std::string path = folder.path() + "/a";
  REQUIRE(write_file(path, "old"));
  for (const int ending : {SIGINT, SIGTERM, SIGHUP}) {
    const pid_t child = ::fork();
    if (child == 0) {
      std::signal(ending, SIG_DFL);
      Result<NewFile> file = NewFile::create(path);
      (void)std::raise(ending);
      const bool is_alive_meanwhile = file && file->write("new");
      { const Result<NewFile> dropped = std::move(file); }
      ::_exit(is_alive_meanwhile ? 1 : 2);
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == ending);
    CHECK(files_in(folder.path()) == 1);
    CHECK(read_file(path) == "old");
  }
}

TEST_CASE("signals that somebody handles or ignores are not delayed") {
  static volatile std::sig_atomic_t handled = 0;
  struct sigaction before {};
  struct sigaction own {};
  own.sa_handler = [](int) { handled = 1; };
  REQUIRE(::sigaction(SIGTERM, &own, &before) == 0);
  {
    const DelayedSignals first;
    const DelayedSignals second;
    REQUIRE(std::raise(SIGTERM) == 0);
    CHECK(handled == 1);
  }
  struct sigaction after {};
  REQUIRE(::sigaction(SIGTERM, &before, &after) == 0);
  CHECK(after.sa_handler == own.sa_handler);
}

TEST_CASE("a file for its owner alone is so whatever the umask") {
  const testing::ScratchFolder folder;
  const mode_t before = ::umask(0);
  {
    Result<NewFile> file = NewFile::create(folder.path() + "/key", Readers::OwnerAlone);
    REQUIRE(file);
    CHECK(file->write("secret"));
    CHECK(file->commit(Durability::Synced));
  }
  ::umask(before);
  struct stat made {};
  REQUIRE(::stat((folder.path() + "/key").c_str(), &made) == 0);
  CHECK((made.st_mode & 0777) == 0600);
}

TEST_CASE("what cannot be written or read is a failure with its reason") {
  const testing::ScratchFolder folder;
  CHECK(write_file("/dev/full", "x").error() == "No space left on device");
  CHECK(write_file(folder.path(), "x").error() == "Is a directory");
  CHECK(write_file(folder.path() + "/no/file", "x").error() == "No such file or directory");
  CHECK_FALSE(read_file(folder.path()));
  CHECK(files_in(folder.path()) == 0);
}

TEST_CASE("a cache is made private, and one that others can write to is not used") {
  const testing::ScratchFolder folder;
  const std::string path = folder.path() + "/above/cache";
  CHECK(ContentCache(ContentKind::Object, path, 1 << 20).store("a", "bytes"));
  for (const char* part : {"/above", "/above/cache"})
    CHECK((fs::status(folder.path() + part).permissions() & fs::perms::mask) == fs::perms::owner_all);
  ContentCache cache(ContentKind::Object, path, 1 << 20);
  CHECK(cache.load("a") == "bytes");
  fs::permissions(path, fs::perms::group_write, fs::perm_options::add);
  CHECK_FALSE(cache.load("a"));
  CHECK_FALSE(cache.store("b", "bytes"));
}

TEST_CASE("a program has a build id") {
  const std::string id = build_id_of(reinterpret_cast<const void*>(&build_id_of));
  CHECK(id.size() >= 16);
  CHECK(id.find_first_not_of("0123456789abcdef") == std::string::npos);
  CHECK(build_id_of(nullptr).empty());
}

}  // namespace bip
