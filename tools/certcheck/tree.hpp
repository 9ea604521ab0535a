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
using Text = std::string_view;

struct Tree {
  bool is_list = false, is_string = false;
  Text text;                // of a word or string, in the text that was read; escapes stay: strings are only compared with each other
  std::vector<Tree> items;  // of a list

  [[nodiscard]] Text head() const { return items.empty() ? Text() : items[0].text; }
  [[nodiscard]] const Tree& at(std::size_t k) const { return items.at(k); }
  /// The first list within this one with that head, or an empty one.
  [[nodiscard]] const Tree& operator[](Text head) const;
  [[nodiscard]] std::vector<const Tree*> all(Text head) const;
  /// The lists with one of these heads, at any depth.
  [[nodiscard]] std::vector<const Tree*> find(const std::vector<Text>& heads) const;
  [[nodiscard]] bool has_word(Text word, std::size_t first) const;
  /// A word "7:name" or "7" as 7.
  [[nodiscard]] std::size_t row() const;
  /// The rows after a list's head.
  [[nodiscard]] Rows rows() const;
};

/// A list of all that the text has; the text must stay.
[[nodiscard]] Tree read_trees(Text text);

}  // namespace certcheck
