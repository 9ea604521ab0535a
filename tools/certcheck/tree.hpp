// .bsys text as nested lists, read with a stack of its own, so that depth costs heap. Nothing of the compiler is used here, on purpose.
#pragma once
#include <algorithm>
#include <charconv>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace certcheck {

/// The certificate or the system is not what it should be.
struct Rejected : std::runtime_error { using std::runtime_error::runtime_error; };
/// It may be sound, but this program cannot tell.
struct NotCheckable : std::runtime_error { using std::runtime_error::runtime_error; };

inline constexpr std::size_t kNone = ~std::size_t{0};
using Rows = std::vector<std::size_t>;
using Text = std::string_view;

[[nodiscard]] inline std::string quoted(Text text) { return '`' + std::string(text) + '`'; }
template <class Range, class Value>
[[nodiscard]] bool contains(const Range& range, const Value& value) {
  return std::find(range.begin(), range.end(), value) != range.end();
}
/// The row that is called so.
template <class Range, class Member>
[[nodiscard]] std::size_t row_of(const Range& rows, Text name, Member member) {
  const auto found = std::ranges::find(rows, name, member);
  return found != rows.end() ? static_cast<std::size_t>(found - rows.begin()) : throw Rejected(quoted(name) + " is not there");
}

struct Tree {
  bool is_list = false, is_string = false;
  Text text;                // of a word or string, in the text that was read; escapes stay: strings are only compared with each other
  std::vector<Tree> items;  // of a list

  [[nodiscard]] Text head() const { return items.empty() ? Text() : items[0].text; }
  [[nodiscard]] const Tree& at(std::size_t k) const { return items.at(k); }
  [[nodiscard]] std::vector<const Tree*> all(Text name) const {
    std::vector<const Tree*> found;
    for (const Tree& item : items) if (item.head() == name) found.push_back(&item);
    return found;
  }
  /// The first list within this one with that head, or an empty one.
  [[nodiscard]] const Tree& operator[](Text name) const {
    static const Tree kEmpty{true, false, {}, {}};
    const auto found = std::find_if(items.begin(), items.end(), [&](const Tree& item) { return item.head() == name; });
    return found == items.end() ? kEmpty : *found;
  }
  /// The lists with one of these heads, at any depth.
  [[nodiscard]] std::vector<const Tree*> find(const std::vector<Text>& heads) const {
    std::vector<const Tree*> found;
    for (const Tree& item : items) {
      if (contains(heads, item.head())) found.push_back(&item);
      const std::vector<const Tree*> inner = item.find(heads);
      found.insert(found.end(), inner.begin(), inner.end());
    }
    return found;
  }
  /// Is that a word from item `first` on?
  [[nodiscard]] bool has_word(Text word, std::size_t first) const {
    for (std::size_t k = first; k < items.size(); ++k) if (!items[k].is_list && !items[k].is_string && items[k].text == word) return true;
    return false;
  }
  /// A word "7:name" or "7" as 7.
  [[nodiscard]] std::size_t row() const {
    std::uint32_t value = 0;
    const bool is_row = !is_list && std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
    return is_row ? value : throw Rejected("a row number was expected, not " + quoted(text));
  }
  /// The rows after a list's head.
  [[nodiscard]] Rows rows() const {
    Rows rows;
    for (std::size_t k = 1; k < items.size(); ++k) rows.push_back(items[k].row());
    return rows;
  }
};

/// A list of all that the text has; the text must stay.
[[nodiscard]] inline Tree read_trees(Text text) {
  // Code is followed by functions that call themselves.
  constexpr std::size_t kMaxDepth = 10000;
  std::vector<Tree> open(1, Tree{true, false, {}, {}});
  for (std::size_t at = 0, end = 0; at < text.size(); at = end) {
    const char c = text[at];
    end = at + 1;
    if (c == ';') {
      end = std::min(text.find('\n', at), text.size());
    } else if (c == '(') {
      open.push_back(Tree{true, false, {}, {}});
      if (open.size() > kMaxDepth) throw NotCheckable("lists are nested too deeply");
    } else if (c == ')') {
      if (open.size() < 2) throw Rejected("one `)` too many");
      Tree done = std::move(open.back());
      open.pop_back();
      open.back().items.push_back(std::move(done));
    } else if (c == '"') {
      while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
      if (end >= text.size()) throw Rejected("a string does not end");
      open.back().items.push_back({false, true, text.substr(at + 1, end - at - 1), {}});
      ++end;
    } else if (!contains(Text(" \n\t\r"), c)) {
      end = std::min(text.find_first_of(" \n\t\r()\";", at), text.size());
      // Places in the source are of no interest here.
      if (c != '@') open.back().items.push_back({false, false, text.substr(at, end - at), {}});
    }
  }
  return open.size() == 1 ? std::move(open[0]) : throw Rejected("a `)` is missing");
}

}  // namespace certcheck
