// Quoting in DOT: whatever a model's names and strings hold, the text stays DOT.
#include <catch2/catch.hpp>

#include "compiler/graph/dot.hpp"

using namespace bip::graph;

TEST_CASE("quoted for DOT") {
  CHECK(dot_string("a\"b\\c\nd") == "\"a\\\"b\\\\c\\nd\"");
  CHECK(dot_string("\xc3\xa4\xff") == "\"\xc3\xa4?\"");
}

TEST_CASE("signs of records are escaped once more") { CHECK(record_field("a<b>|{c}\"") == "a\\<b\\>\\|\\{c\\}\\\""); }

TEST_CASE("long labels are cut at a character") {
  const std::string fits(kMaxLabel, 'x');
  CHECK(shortened(fits) == fits);
  std::string umlauts;
  while (umlauts.size() <= kMaxLabel) umlauts += "\xc3\xa4";
  const std::string cut = shortened(umlauts);
  CHECK(cut.size() <= kMaxLabel);
  CHECK(cut.ends_with("\xa4..."));
}
