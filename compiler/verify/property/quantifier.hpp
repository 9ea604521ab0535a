// Quantifiers of properties over the positions of arrays.
//
//   quantified = ('forall' | 'exists') NAME 'in' range ':' formula
//              | ('at most' | 'at least' | 'exactly') INDEX NAME 'in' range ':' condition
//   range      = INDEX '..' INDEX          the upper bound excluded, as in `for`
//              | PATH                      all positions of an array of components
//   INDEX      = C's `+ - * / %` of whole numbers and variables that are bound around it
//
// What follows the colon reaches as far as an expression can; it is written out for each position, and what the
// variables alone decide (`i != j`) is left out.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bip::verify {

enum class IndexQuantifier : std::uint8_t { ForAll, Exists, AtMost, AtLeast, Exactly };
struct QuantifierWord {
  std::string_view word;
  IndexQuantifier meaning;
};
inline constexpr QuantifierWord kQuantifiers[] = {{"forall", IndexQuantifier::ForAll},
                                                  {"exists", IndexQuantifier::Exists},
                                                  {"at most", IndexQuantifier::AtMost},
                                                  {"at least", IndexQuantifier::AtLeast},
                                                  {"exactly", IndexQuantifier::Exactly}};
[[nodiscard]] constexpr bool counts(IndexQuantifier quantifier) {
  return quantifier != IndexQuantifier::ForAll && quantifier != IndexQuantifier::Exists;
}
inline constexpr std::string_view kQuantifierForms =
    "`forall i in ARRAY: …`, `exists i in 0..3: …`, `at most 1 i in ARRAY: …`";

/// What a quantifier stands before: at the beginning of a formula over all of it, else over C's operators.
enum class Reach : std::uint8_t { Expression, Formula };
/// Returns where the text ends over which a quantifier reaches, without reading it: before a `)` that closes none in
/// it, or a connective of formulas.
[[nodiscard]] std::size_t end_of_body(std::string_view text, std::size_t begin, Reach reach);

/// The variables around a place of the text; an inner one hides an outer one of its name.
class BoundVariables {
 public:
  void bind(std::string name, std::int64_t value) { values_.emplace_back(std::move(name), value); }
  void release() { values_.pop_back(); }
  [[nodiscard]] bool is_empty() const { return values_.empty(); }
  [[nodiscard]] std::optional<std::int64_t> value_of(std::string_view name) const {
    const auto found =
        std::find_if(values_.rbegin(), values_.rend(), [&](const auto& bound) { return bound.first == name; });
    return found == values_.rend() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::vector<std::pair<std::string, std::int64_t>> values_;
};

/// Joins the rows [begin, end), at least one, two halves at a time, so that the result is as low as can be.
template <class Join>
[[nodiscard]] std::uint32_t join_rows(const std::uint32_t* begin, const std::uint32_t* end, const Join& join) {
  if (end - begin == 1) return *begin;
  const std::uint32_t* const middle = begin + (end - begin) / 2;
  const std::uint32_t left = join_rows(begin, middle, join);
  return join(left, join_rows(middle, end, join));
}

/// Are at least `count` of the rows true, 1 <= count <= end - begin? `both` and `either` join two rows; n log(n)^(count
/// - 1) of them. `is_too_large()` ends it.
template <class Both, class Either, class IsTooLarge>
[[nodiscard]] std::uint32_t at_least(std::size_t count, const std::uint32_t* begin, const std::uint32_t* end,
                                     const Both& both, const Either& either, const IsTooLarge& is_too_large) {
  const auto size = static_cast<std::size_t>(end - begin);
  if (count == 1 || is_too_large()) return join_rows(begin, end, either);
  if (count == size) return join_rows(begin, end, both);
  const std::uint32_t* const middle = begin + size / 2;
  const std::size_t left = size / 2, right = size - left;
  std::vector<std::uint32_t> ways;  // so many in the left half, the others in the right one
  for (std::size_t k = count > right ? count - right : 0; k <= std::min(count, left); ++k) {
    const auto in_left = [&] { return at_least(k, begin, middle, both, either, is_too_large); };
    const auto in_right = [&] { return at_least(count - k, middle, end, both, either, is_too_large); };
    if (k == 0 || k == count) {
      ways.push_back(k == 0 ? in_right() : in_left());
      continue;
    }
    const std::uint32_t first = in_left();
    ways.push_back(both(first, in_right()));
  }
  return join_rows(ways.data(), ways.data() + ways.size(), either);
}

}  // namespace bip::verify
