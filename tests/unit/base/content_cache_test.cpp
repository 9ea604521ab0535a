// What is kept on disk: what is stored comes back, what is broken does not, and it stays as small as asked. And its
// hash.
#include "compiler/base/content_cache.hpp"

#include <sys/stat.h>

#include <fstream>
#include <thread>

#include "compiler/base/content_hash.hpp"
#include "tests/unit/base/scratch_folder.hpp"

namespace fs = std::filesystem;

namespace bip {
namespace {

using Folder = testing::ScratchFolder;

constexpr std::uint64_t kLarge = 1 << 20;

}  // namespace

TEST_CASE("the hash is BLAKE2b") {
  // As `b2sum -l 256` has them: no byte, one, a whole block, one more, several blocks.
  CHECK(blake2b("") == "0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8");
  CHECK(blake2b("abc") == "bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319");
  CHECK(blake2b(std::string(128, 'x')) == "164ffb7089bae6f5a62fb0795e751dc9e88eac92e1a5b2fafe93a25abf2d9c3b");
  CHECK(blake2b(std::string(129, 'x')) == "03b0758fa71d249c846c2304a2b9996e6ae66ffa7e5528f9e612e089a360fc8d");
  CHECK(blake2b(std::string(1000, 'x')) == "ab75119ede14ef06ebf31f745fb655ed006cccfe8054c635308a557f7c9beaba");
}

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
    ContentCache cache(ContentKind::Object, folder.path() + "/made/when/needed", kLarge);
    CHECK_FALSE(cache.load("a"));
    cache.store("a", bytes);
    cache.store("empty", "");
  }
  ContentCache cache(ContentKind::Object, folder.path() + "/made/when/needed", kLarge);
  CHECK(cache.load("a") == bytes);
  CHECK(cache.load("empty") == "");
  CHECK_FALSE(cache.load("b"));
  CHECK(cache.broken().empty());
}

TEST_CASE("a file that is cut, changed or foreign counts as none") {
  const Folder folder;
  const std::string bytes(1000, 'x');
  { ContentCache(ContentKind::Object, folder.path(), kLarge).store("a", bytes); }
  const fs::path path = fs::path(folder.path()) / "a.o";
  std::ifstream in(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  const auto write = [&](const std::string& text) { std::ofstream(path, std::ios::binary) << text; };
  std::string changed = whole;
  changed.back() = 'y';
  std::string head = whole;
  head[20] = static_cast<char>(head[20] == '0' ? '1' : '0');
  for (const std::string& text : {whole.substr(0, whole.size() - 1), whole + "z", changed, head, std::string(),
                                  std::string("ELF"), whole.substr(0, 30)}) {
    write(text);
    ContentCache cache(ContentKind::Object, folder.path(), kLarge);
    CHECK_FALSE(cache.load("a"));
    CHECK(cache.broken().size() == 1);
    cache.store("a", bytes);
    CHECK(cache.load("a") == bytes);
  }
}

TEST_CASE("a sound file under another name counts as none") {
  const Folder folder;
  ContentCache cache(ContentKind::Object, folder.path(), kLarge);
  cache.store("a", "code of a");
  cache.store("b", "code of b");
  const fs::path of_folder = folder.path();
  fs::copy_file(of_folder / "a.o", of_folder / "b.o", fs::copy_options::overwrite_existing);
  fs::copy_file(of_folder / "a.o", of_folder / "a.so");
  CHECK(cache.load("a") == "code of a");
  CHECK_FALSE(cache.load("b"));
  CHECK_FALSE(ContentCache(ContentKind::Library, folder.path(), kLarge).load("a"));
  CHECK(cache.broken().size() == 1);
}

TEST_CASE("what was not used longest goes first") {
  const Folder folder;
  const std::string bytes(1000, 'x');
  const auto age = [&](const char* name, int hours) {
    fs::last_write_time(fs::path(folder.path()) / name, fs::file_time_type::clock::now() - std::chrono::hours(hours));
  };
  {
    ContentCache cache(ContentKind::Object, folder.path(), kLarge);
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
  CHECK(ContentCache(ContentKind::Object, folder.path(), kLarge).load("a"));
  { ContentCache(ContentKind::Object, folder.path(), 4000).store("d", bytes); }
  CHECK_FALSE(fs::exists(folder.path() + "/b.o"));
  CHECK(fs::exists(folder.path() + "/a.o"));
  CHECK(fs::exists(folder.path() + "/d.o"));
  CHECK_FALSE(fs::exists(folder.path() + "/left.new"));
  CHECK(fs::exists(folder.path() + "/fresh.new"));
  CHECK(fs::exists(folder.path() + "/notes.txt"));
}

TEST_CASE("without a folder, or with one that cannot be, nothing is kept and nothing fails") {
  ContentCache off(ContentKind::Object, "", kLarge);
  off.store("a", "x");
  CHECK_FALSE(off.load("a"));
  const Folder folder;
  std::ofstream(folder.path() + "/file") << "no folder";
  ContentCache cache(ContentKind::Object, folder.path() + "/file", kLarge);
  cache.store("a", "x");
  CHECK_FALSE(cache.load("a"));
}

TEST_CASE("several writers at a time leave whole files") {
  const Folder folder;
  const auto text = [](int k) { return std::string(5000 + static_cast<std::size_t>(k), static_cast<char>('a' + k)); };
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k) {
    threads.emplace_back([&, k] {
      for (int round = 0; round < 50; ++round)
        ContentCache(ContentKind::Object, folder.path(), kLarge).store("same", text(k));
    });
  }
  int broken = 0, seen = 0;
  for (int round = 0; round < 400; ++round) {
    ContentCache cache(ContentKind::Object, folder.path(), kLarge);
    const std::optional<std::string> bytes = cache.load("same");
    broken += static_cast<int>(cache.broken().size());
    if (bytes) seen += *bytes == text((*bytes)[0] - 'a') ? 1 : -1000;
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(broken == 0);
  CHECK(seen >= 0);
  CHECK(folder.files().size() == 1);
}

TEST_CASE("kinds have files of their own, and a pipe or a folder by that name is none") {
  const Folder folder;
  ContentCache objects(ContentKind::Object, folder.path(), kLarge), proofs(ContentKind::Proof, folder.path(), kLarge);
  CHECK(objects.store("a", "code"));
  CHECK_FALSE(proofs.load("a"));
  CHECK(proofs.store("a", "proof"));
  CHECK(objects.load("a") == "code");
  CHECK(proofs.load("a") == "proof");
  fs::rename(folder.path() + "/a.o", folder.path() + "/a.proof");
  CHECK_FALSE(proofs.load("a"));
  CHECK(proofs.broken().size() == 1);
  REQUIRE(::mkfifo((folder.path() + "/pipe.proof").c_str(), 0600) == 0);
  fs::create_directory(folder.path() + "/folder.proof");
  CHECK_FALSE(proofs.load("pipe"));
  CHECK_FALSE(proofs.load("folder"));
  // Larger than all that may be kept.
  CHECK(proofs.store("large", std::string(5000, 'x')));
  CHECK_FALSE(ContentCache(ContentKind::Proof, folder.path(), 4000).load("large"));
  CHECK(proofs.load("large"));
}

}  // namespace bip
