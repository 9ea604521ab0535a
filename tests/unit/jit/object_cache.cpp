// The cache of machine code: what is stored comes back, what is broken does not, and it stays as small as asked.
#include "compiler/jit/object_cache.hpp"

#include <catch2/catch.hpp>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <thread>

#include "compiler/jit/jit.hpp"
#include "tests/unit/jit/units.hpp"

namespace fs = std::filesystem;

namespace bip::jit {
namespace {

class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "bipc-cache-test-XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~Folder() { fs::remove_all(path_); }
  [[nodiscard]] std::string path() const { return path_.string(); }
  [[nodiscard]] std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(path_)) found.push_back(entry.path());
    return found;
  }

 private:
  fs::path path_;
};

constexpr std::uint64_t kLarge = 1 << 20;

}  // namespace

TEST_CASE("hashes tell texts and their borders apart") {
  CHECK(content_hash({"ab", "c"}) == content_hash({"ab", "c"}));
  CHECK(content_hash({"ab", "c"}) != content_hash({"a", "bc"}));
  CHECK(content_hash({"abc"}) != content_hash({"abc", ""}));
  CHECK(content_hash({""}).size() == 64);
}

TEST_CASE("what is stored comes back, bytes of all kinds") {
  const Folder folder;
  const std::string bytes("\0\n\xff bipc object 1\n", 18);
  {
    ObjectCache cache(folder.path() + "/made/when/needed", kLarge);
    CHECK_FALSE(cache.load("a"));
    cache.store("a", bytes);
    cache.store("empty", "");
  }
  ObjectCache cache(folder.path() + "/made/when/needed", kLarge);
  CHECK(cache.load("a") == bytes);
  CHECK(cache.load("empty") == "");
  CHECK_FALSE(cache.load("b"));
  CHECK(cache.broken().empty());
}

TEST_CASE("a file that is cut, changed or foreign counts as none") {
  const Folder folder;
  const std::string bytes(1000, 'x');
  { ObjectCache(folder.path(), kLarge).store("a", bytes); }
  const fs::path path = fs::path(folder.path()) / "a.o";
  std::ifstream in(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  const auto write = [&](const std::string& text) { std::ofstream(path, std::ios::binary) << text; };
  std::string changed = whole;
  changed.back() = 'y';
  std::string head = whole;
  head[20] = static_cast<char>(head[20] == '0' ? '1' : '0');
  for (const std::string& text : {whole.substr(0, whole.size() - 1), whole + "z", changed, head, std::string(), std::string("ELF"), whole.substr(0, 30)}) {
    write(text);
    ObjectCache cache(folder.path(), kLarge);
    CHECK_FALSE(cache.load("a"));
    CHECK(cache.broken().size() == 1);
    cache.store("a", bytes);
    CHECK(cache.load("a") == bytes);
  }
}

TEST_CASE("what was not used longest goes first") {
  const Folder folder;
  const std::string bytes(1000, 'x');
  const auto age = [&](const char* name, int hours) {
    fs::last_write_time(fs::path(folder.path()) / name, fs::file_time_type::clock::now() - std::chrono::hours(hours));
  };
  {
    ObjectCache cache(folder.path(), kLarge);
    for (const char* name : {"a", "b", "c"}) cache.store(name, bytes);
  }
  std::ofstream(fs::path(folder.path()) / "left.new") << "half";
  std::ofstream(fs::path(folder.path()) / "fresh.new") << "half";
  std::ofstream(fs::path(folder.path()) / "notes.txt") << bytes << bytes << bytes << bytes;
  age("a.o", 5);
  age("b.o", 4);
  age("c.o", 3);
  age("left.new", 2);
  // Used again: b is the oldest then.
  CHECK(ObjectCache(folder.path(), kLarge).load("a"));
  { ObjectCache(folder.path(), 4000).store("d", bytes); }
  CHECK_FALSE(fs::exists(folder.path() + "/b.o"));
  CHECK(fs::exists(folder.path() + "/a.o"));
  CHECK(fs::exists(folder.path() + "/d.o"));
  CHECK_FALSE(fs::exists(folder.path() + "/left.new"));
  CHECK(fs::exists(folder.path() + "/fresh.new"));
  CHECK(fs::exists(folder.path() + "/notes.txt"));
}

TEST_CASE("without a folder, or with one that cannot be, nothing is kept and nothing fails") {
  ObjectCache off("", kLarge);
  off.store("a", "x");
  CHECK_FALSE(off.load("a"));
  const Folder folder;
  std::ofstream(folder.path() + "/file") << "no folder";
  ObjectCache cache(folder.path() + "/file", kLarge);
  cache.store("a", "x");
  CHECK_FALSE(cache.load("a"));
}

TEST_CASE("several writers at a time leave whole files") {
  const Folder folder;
  const auto text = [](int k) { return std::string(5000 + static_cast<std::size_t>(k), static_cast<char>('a' + k)); };
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k) {
    threads.emplace_back([&, k] {
      for (int round = 0; round < 50; ++round) ObjectCache(folder.path(), kLarge).store("same", text(k));
    });
  }
  int broken = 0, seen = 0;
  for (int round = 0; round < 400; ++round) {
    ObjectCache cache(folder.path(), kLarge);
    const std::optional<std::string> bytes = cache.load("same");
    broken += static_cast<int>(cache.broken().size());
    if (bytes) seen += *bytes == text((*bytes)[0] - 'a') ? 1 : -1000;
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(broken == 0);
  CHECK(seen >= 0);
  CHECK(folder.files().size() == 1);
}

TEST_CASE("a second compilation takes its code from the cache, and it is the same code") {
  const Folder folder;
  test::Units units;
  std::mt19937 random(7);
  for (int k = 0; k < 20; ++k) {
    units.add_guard(units.random_expr(random, Type::Bool, 4));
    units.add_action(units.random_body(random, 3));
  }
  const auto compile = [&](OptLevel level, const std::string& version) {
    MadeCode made;
    const auto jit = Jit::compile(units.lowered(), {.level = level, .cache_folder = folder.path(), .version = version}, made);
    REQUIRE(jit);
    REQUIRE(made.codes.size() == units.size());
    return made;
  };
  CHECK(compile(OptLevel::O2, "1").from_cache == 0);
  const MadeCode second = compile(OptLevel::O2, "1");
  CHECK(second.from_cache == second.modules);
  CHECK(second.modules == 1);
  // Another level, another version, other code: none of them are the same.
  CHECK(compile(OptLevel::O0, "1").from_cache == 0);
  CHECK(compile(OptLevel::O2, "2").from_cache == 0);
  units.add_guard(units.random_expr(random, Type::Bool, 2));
  CHECK(compile(OptLevel::O2, "1").from_cache == 0);
  // A broken file is told and made anew.
  for (const fs::path& file : folder.files()) std::ofstream(file, std::ios::binary) << "broken";
  const MadeCode again = compile(OptLevel::O2, "1");
  CHECK(again.from_cache == 0);
  CHECK(again.broken_files.size() == 1);
  CHECK(compile(OptLevel::O2, "1").from_cache == 1);
}

}  // namespace bip::jit
