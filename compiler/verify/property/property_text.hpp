// The text of a property while it is parsed, and what stands at a place of it: signs, words, paths, indices. Internal
// to compiler/verify/property.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "compiler/base/ascii.hpp"
#include "compiler/verify/property/quantifier.hpp"

namespace bip::verify {

[[nodiscard]] inline bool begins_name(char c) { return is_letter(c) || c == '_'; }

/// The first problem stays, with the place at which the text was then.
class PropertyText {
 protected:
  explicit PropertyText(const std::string& text) : text_(text) {}
  ~PropertyText() = default;
  PropertyText(const PropertyText&) = delete;
  PropertyText& operator=(const PropertyText&) = delete;

  void set_problem(const std::string& why);

  void skip_blanks();
  bool take_sign(std::string_view sign);
  /// Takes the words if they stand here: `leads to`, and no `leads.to`, `leads@to`, `leadsto`.
  bool take_words(std::string_view words);
  /// "a", "a[3].b"; empty: no name here. Of an index that names bound variables, its value.
  std::string parse_path();
  /// The value of an index from `at` on, which moves behind it.
  [[nodiscard]] std::optional<std::int64_t> evaluate(std::size_t& at) const;
  [[nodiscard]] bool is_next(char c);
  [[nodiscard]] bool is_at_number() const;
  [[nodiscard]] std::string word_at(std::size_t start) const;

  const std::string& text_;
  std::size_t at_ = 0;
  BoundVariables bound_;
  std::string problem_;

 private:
  // `[(i + 1) % 3]` behind the path. False: it has no value.
  bool take_index(std::string& path);
};

}  // namespace bip::verify
