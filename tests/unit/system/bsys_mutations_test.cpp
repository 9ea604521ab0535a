// Thousands of damaged texts: each gives a failure with a place, or a System that validates and round-trips.
#include <catch2/catch.hpp>

#include <random>

#include "compiler/system/bsys.hpp"
#include "tests/unit/system/bsys_sample.hpp"

using namespace bip;

namespace {

/// One to four edits: a byte changed, cut or doubled, a piece moved, a number bumped.
std::string damaged(const std::string& text, std::mt19937& random) {
  std::string out = text;
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const std::size_t edits = 1 + below(4);
  for (std::size_t k = 0; k < edits && !out.empty(); ++k) {
    const std::size_t at = below(out.size());
    switch (below(6)) {
      case 0: out[at] = static_cast<char>(random() & 0xff); break;
      case 1: out[at] = "()\" @:0123456789-.;\n\\x"[below(22)]; break;
      case 2: out.erase(at, 1 + below(20)); break;
      case 3: out.insert(at, out.substr(below(out.size()), below(60))); break;
      case 4: std::swap(out[at], out[below(out.size())]); break;
      default: {
        const std::size_t digit = out.find_first_of("0123456789", at);
        if (digit != std::string::npos) out[digit] = static_cast<char>('0' + below(10));
        break;
      }
    }
  }
  return out;
}

}  // namespace

TEST_CASE("damaged texts are refused or sound") {
  const std::string text = system::print(test::make_sample_system());
  std::mt19937 random(20260101);
  std::size_t accepted = 0, refused = 0;
  for (int k = 0; k < 20'000; ++k) {
    const std::string mutant = damaged(text, random);
    const Result<System> result = system::parse_bsys(mutant);
    if (!result) {
      ++refused;
      const std::size_t colon = result.error().find(':');
      const bool has_place = colon != std::string::npos && result.error().find_first_not_of("0123456789") == colon;
      if (!has_place) FAIL("no place in: " << result.error());
      continue;
    }
    ++accepted;
    if (!system::validate(*result).empty()) FAIL("unsound System from:\n" << mutant);
    const std::string printed = system::print(*result);
    const Result<System> again = system::parse_bsys(printed);
    if (!again) FAIL(again.error() << " in what was printed for:\n" << mutant);
    if (system::print(*again) != printed) FAIL("no round trip of:\n" << mutant);
  }
  // Both kinds occur: digits of places and comments can change without harm.
  CHECK(accepted > 100);
  CHECK(refused > 1000);
}
