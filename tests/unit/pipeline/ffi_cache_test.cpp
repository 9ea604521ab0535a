// What the cache keeps of a model's C++: rules of make as compilers write them, and files that have changed.
#include "compiler/pipeline/ffi_cache.hpp"

#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>

#include "tests/unit/base/scratch_folder.hpp"

namespace bip::pipeline {

TEST_CASE("prerequisites of a make rule") {
  CHECK(prerequisites("").empty());
  CHECK(prerequisites("0.o: a.cpp\n") == std::vector<std::string>{"a.cpp"});
  CHECK(prerequisites("/tmp/0.o: a.cpp b.h \\\n  /usr/include/c++/12/vector \\\n c.h\n") ==
        std::vector<std::string>{"a.cpp", "b.h", "/usr/include/c++/12/vector", "c.h"});
  CHECK(prerequisites("0.o: two\\ words.h cost$$.h a\\#b.h\n") ==
        std::vector<std::string>{"two words.h", "cost$.h", "a#b.h"});
}

TEST_CASE("a library is used as long as its files are what they were") {
  const testing::ScratchFolder folder;
  const std::string header = folder.path() + "/a header.h", other = folder.path() + "/b.h";
  std::ofstream(header) << "int a;";
  std::ofstream(other) << "int b;";
  const std::string library("\177ELF\n\n\0x", 8);
  const std::optional<std::string> entry = pack_library({other, header, header}, library);
  REQUIRE(entry);
  CHECK(unpack_library(*entry) == library);
  std::ofstream(header) << "int c;";
  CHECK_FALSE(unpack_library(*entry));
  std::ofstream(header) << "int a;";
  CHECK(unpack_library(*entry) == library);
  std::filesystem::remove(other);
  CHECK_FALSE(unpack_library(*entry));
  CHECK_FALSE(pack_library({other}, library));
  for (const char* broken : {"", "x", "0123 a.h\n\n", "\177ELF"}) CHECK_FALSE(unpack_library(broken));
}

}  // namespace bip::pipeline
