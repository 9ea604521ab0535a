// .bsys text as nested lists. Nothing of the compiler is used here, on purpose.
#pragma once
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace certcheck {

/// The certificate or the system is not what it should be.
struct Rejected : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// It may be sound, but this program cannot tell.
struct NotCheckable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline constexpr std::size_t kNone = ~std::size_t{0};
using Rows = std::vector<std::size_t>;

struct Tree {
  bool is_list = false, is_string = false;
  std::string_view text;     // of a word or string, in the text that was read; escapes stay: strings are only compared with each other
  std::vector<Tree> items;   // of a list

  [[nodiscard]] std::string_view head() const { return items.empty() ? std::string_view() : items[0].text; }
  [[nodiscard]] const Tree& at(std::size_t k) const { return items.at(k); }
  /// The first list within this one with that head, or an empty one.
  [[nodiscard]] const Tree& operator[](std::string_view head) const;
  /// All of them.
  [[nodiscard]] std::vector<const Tree*> all(std::string_view head) const;
  /// Is there a list with one of these heads in it, at any depth, or is it one? They are added to `found`, if it is there.
  bool contains(const std::vector<std::string_view>& heads, std::vector<const Tree*>* found = nullptr) const;
  [[nodiscard]] bool has_word(std::string_view word, std::size_t first) const;
  /// A word "7:name" or "7" as 7.
  [[nodiscard]] std::size_t row() const;
  /// The rows after a list's head.
  [[nodiscard]] Rows rows() const;
};

/// A list of all that the text has; the text must stay.
[[nodiscard]] Tree read_trees(std::string_view text);

}  // namespace certcheck
