// What the cache keeps of a model's C++: rules of make as compilers write them, and texts that have changed.
#include "compiler/pipeline/ffi_cache.hpp"

#include <catch2/catch.hpp>

namespace bip::pipeline {

TEST_CASE("prerequisites of a make rule") {
  CHECK(prerequisites("").empty());
  CHECK(prerequisites("0.o: a.cpp\n") == std::vector<std::string>{"a.cpp"});
  CHECK(prerequisites("/tmp/0.o: a.cpp b.h \\\n  /usr/include/c++/12/vector \\\n c.h\n") ==
        std::vector<std::string>{"a.cpp", "b.h", "/usr/include/c++/12/vector", "c.h"});
  CHECK(prerequisites("0.o: two\\ words.h cost$$.h a\\#b.h\n") ==
        std::vector<std::string>{"two words.h", "cost$.h", "a#b.h"});
}

TEST_CASE("a library is used as long as it would be made of the same texts") {
  const std::string library("\177ELF\n\n\0x", 8);
  const std::string entry = pack_library("0123", library);
  CHECK(unpack_library("0123", entry) == library);
  CHECK_FALSE(unpack_library("0124", entry));
  // Without a hash nothing is known of the texts.
  CHECK_FALSE(unpack_library("", pack_library("", library)));
  for (const char* broken : {"", "0123", "012\n", "01234\n", "\177ELF"}) CHECK_FALSE(unpack_library("0123", broken));
}

}  // namespace bip::pipeline
