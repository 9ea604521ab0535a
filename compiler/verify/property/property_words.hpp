// The words of properties of runs and of branching time, and the signs of other notations for them; internal to
// compiler/verify/property.
#pragma once
#include <string_view>

#include "compiler/verify/property/property.hpp"

namespace bip::verify {

struct TemporalWord {
  std::string_view word;
  TemporalOperator meaning;
};
[[nodiscard]] constexpr bool is_of_past(TemporalOperator op) {
  return op == TemporalOperator::Previously || op == TemporalOperator::Once || op == TemporalOperator::Historically ||
         op == TemporalOperator::Since;
}
inline constexpr TemporalWord kPrefixes[] = {{"always", TemporalOperator::Always},
                                             {"never", TemporalOperator::Never},
                                             {"eventually", TemporalOperator::Eventually},
                                             {"next", TemporalOperator::Next},
                                             {"previously", TemporalOperator::Previously},
                                             {"once", TemporalOperator::Once},
                                             {"historically", TemporalOperator::Historically},
                                             {"possibly", TemporalOperator::Possibly}};
// `implies` is one of C's operators in other words.
inline constexpr TemporalWord kConnectives[] = {{"leads to", TemporalOperator::LeadsTo},
                                                {"until", TemporalOperator::Until},
                                                {"unless", TemporalOperator::Unless},
                                                {"since", TemporalOperator::Since}};
// How others write it, and how it is written here.
struct OtherSign {
  std::string_view sign, word;
};
inline constexpr OtherSign kOtherPrefixes[] = {{"[]", "always"},
                                               {"<>", "eventually"},
                                               {"G", "always"},
                                               {"F", "eventually"},
                                               {"X", "next"},
                                               {"Y", "previously"},
                                               {"O", "once"},
                                               {"H", "historically"},
                                               {"E<>", "possibly"},
                                               {"EF", "possibly"},
                                               {"E[]", "possibly always"},
                                               {"EG", "possibly always"},
                                               {"EX", "possibly next"},
                                               {"A[]", "always"},
                                               {"AG", "always"},
                                               {"A<>", "eventually"},
                                               {"AF", "eventually"},
                                               {"AX", "next"},
                                               {"yesterday", "previously"}};
inline constexpr OtherSign kOtherConnectives[] = {{"-->", "leads to"}, {"->", "implies"}, {"=>", "implies"},
                                                  {"~>", "leads to"},  {"U", "until"},    {"W", "unless"},
                                                  {"S", "since"}};

inline constexpr const char* kWithinAlone =
    "`within` stands in a property of its own: `E leads to F within 50 ms` or `eventually E within 50 ms`";
// Words of other notations where data was expected.
inline constexpr OtherSign kOtherFunctions[] = {
    {"sum", "`sum` is no word of properties: `at most 1 i in ARRAY: …`, `at least` and `exactly` count"},
    {"count", "`count` is no word of properties: `at most 1 i in ARRAY: …`, `at least` and `exactly` count"},
    {"P", "`P` asks how probable something is, which `bipc simulate --query` answers"}};

}  // namespace bip::verify
