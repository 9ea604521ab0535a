#include "compiler/base/json_text.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

namespace bip {
namespace {

TEST_CASE("JSON is written on one line, or indented, in the order in which it was built") {
  const nlohmann::ordered_json value{{"z", 1}, {"a", {1, 2}}};
  CHECK(json_line(value) == R"({"z":1,"a":[1,2]})");
  CHECK(indented_json(value) == "{\n  \"z\": 1,\n  \"a\": [\n    1,\n    2\n  ]\n}");
}

TEST_CASE("bytes that are no UTF-8 are written as U+FFFD") { CHECK(json_line("a\xff") == "\"a\xef\xbf\xbd\""); }

TEST_CASE("JSON is read in its order, and what is none is discarded") {
  CHECK(json_line(parse_json(R"( {"z": 1, "a": null} )")) == R"({"z":1,"a":null})");
  CHECK(parse_json("{").is_discarded());
  CHECK(parse_json("").is_discarded());
  CHECK(parse_json("\"\xff\"").is_discarded());
}

}  // namespace
}  // namespace bip
