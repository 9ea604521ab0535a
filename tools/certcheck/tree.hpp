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

struct Tree {
  bool is_list = false, is_string = false;
  std::string text;          // word or string
  std::vector<Tree> items;   // list

  [[nodiscard]] const std::string& head() const {
    static const std::string kNone;
    return is_list && !items.empty() && !items[0].is_list ? items[0].text : kNone;
  }
  /// The first list within this one with that head, or null.
  [[nodiscard]] const Tree* find(std::string_view name) const;
  /// A word "7:name" or "7" as 7.
  [[nodiscard]] std::size_t row() const;
};

[[nodiscard]] std::vector<Tree> read_trees(std::string_view text);

}  // namespace certcheck
