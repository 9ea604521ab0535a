// Well-formedness of UTF-8 at its edges, and widths.
#include "compiler/source/utf8.hpp"

#include <catch2/catch.hpp>
#include <string>

TEST_CASE("well-formed sequences have their length") {
  REQUIRE(bip::utf8_length("a") == 1);
  REQUIRE(bip::utf8_length("\xC2\x80") == 2);
  REQUIRE(bip::utf8_length("\xE0\xA0\x80") == 3);
  REQUIRE(bip::utf8_length("\xED\x9F\xBF") == 3);
  REQUIRE(bip::utf8_length("\xF0\x90\x80\x80") == 4);
  REQUIRE(bip::utf8_length("\xF4\x8F\xBF\xBF") == 4);
  REQUIRE(bip::utf8_length("") == 0);
}

TEST_CASE("overlong forms, surrogates, cut-off and too large ones are refused") {
  for (const char* bad : {"\x80", "\xC0\x80", "\xC1\xBF", "\xE0\x9F\xBF", "\xED\xA0\x80", "\xF0\x8F\xBF\xBF",
                          "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xC2", "\xE2\x89", "\xF0\x90\x80", "\xC2g"}) {
    CAPTURE(bad);
    REQUIRE(bip::utf8_length(bad) == 0);
    REQUIRE(bip::first_bad_utf8(std::string("0123456789abc\xC3\xA4") + bad) == 15u);
  }
  REQUIRE_FALSE(bip::first_bad_utf8("plain text of more than eight bytes \xE2\x89\xA4 and more"));
}

TEST_CASE("columns on a terminal") {
  REQUIRE(bip::utf8_columns("a") == 1);
  REQUIRE(bip::utf8_columns("\xE2\x89\xA4") == 1);      // <=
  REQUIRE(bip::utf8_columns("\xCC\x81") == 0);          // combining acute
  REQUIRE(bip::utf8_columns("\xE6\x97\xA5") == 2);      // wide
  REQUIRE(bip::utf8_columns("\xF0\x9F\x98\x80") == 2);  // emoji
  REQUIRE(bip::utf8_columns("\xFF") == 1);
}
