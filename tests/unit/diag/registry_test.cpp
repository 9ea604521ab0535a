// The registry's own rules, and similar names.
#include <catch2/catch.hpp>
#include <cctype>
#include <set>
#include <string>

#include "compiler/diag/diagnostics.hpp"

using namespace bip;

TEST_CASE("codes are unique, ordered, and found again") {
  std::set<std::string> codes;
  std::set<std::string> slugs;
  std::string previous;
  for (const Diag kind : all_diags()) {
    const DiagInfo& row = info(kind);
    CAPTURE(row.code);
    REQUIRE(codes.insert(row.code).second);
    REQUIRE(slugs.insert(row.slug).second);
    REQUIRE(previous < row.code);
    REQUIRE(find_diag(row.code) == kind);
    previous = row.code;
  }
  REQUIRE_FALSE(find_diag("B9999"));
}

TEST_CASE("messages read as the house style wants") {
  for (const Diag kind : all_diags()) {
    const std::string message = info(kind).message;
    CAPTURE(message);
    REQUIRE_FALSE(message.empty());
    REQUIRE(message.back() != '.');
    REQUIRE(message.back() != '?');
    REQUIRE(message.find("illegal") == std::string::npos);
    REQUIRE(message.find("invalid") == std::string::npos);
    const bool starts_with_word = std::isalpha(static_cast<unsigned char>(message.front())) != 0;
    const bool is_name = message.starts_with("C++");
    REQUIRE((!starts_with_word || is_name || std::islower(static_cast<unsigned char>(message.front())) != 0));
  }
}

TEST_CASE("similar names: typos, swaps and case, best first, at most two") {
  using Names = std::vector<std::string>;
  REQUIRE(similar_names("taek", {"take", "put", "tick"}) == Names{"take"});
  REQUIRE(similar_names("Take", {"take"}) == Names{"take"});
  REQUIRE(similar_names("tick", {"tack", "tock", "tuck"}) == Names{"tack", "tock"});
  REQUIRE(similar_names("x", {"quite_another"}).empty());
  REQUIRE(similar_names("same", {"same"}).empty());
  REQUIRE(similar_names("", {"a"}).empty());
  REQUIRE(similar_names(std::string(1000, 'a'), {"a"}).empty());
}
