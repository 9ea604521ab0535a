// A reader with a stack of its own, so that depth costs heap.
#include "tools/certcheck/tree.hpp"

#include <algorithm>
#include <charconv>

namespace certcheck {

namespace {
// Code is followed by functions that call themselves.
constexpr std::size_t kMaxDepth = 10000;
}  // namespace

const Tree& Tree::operator[](Text name) const {
  static const Tree kEmpty{true, false, {}, {}};
  const auto found = std::find_if(items.begin(), items.end(), [&](const Tree& item) { return item.head() == name; });
  return found == items.end() ? kEmpty : *found;
}

std::vector<const Tree*> Tree::all(Text name) const {
  std::vector<const Tree*> found;
  for (const Tree& item : items) {
    if (item.head() == name) found.push_back(&item);
  }
  return found;
}

std::vector<const Tree*> Tree::find(const std::vector<Text>& heads) const {
  std::vector<const Tree*> found;
  for (const Tree& item : items) {
    if (std::find(heads.begin(), heads.end(), item.head()) != heads.end()) found.push_back(&item);
    const std::vector<const Tree*> inner = item.find(heads);
    found.insert(found.end(), inner.begin(), inner.end());
  }
  return found;
}

bool Tree::has_word(Text word, std::size_t first) const {
  const auto is_it = [&](const Tree& item) { return !item.is_list && !item.is_string && item.text == word; };
  return items.size() > first && std::any_of(items.begin() + static_cast<long>(first), items.end(), is_it);
}

std::size_t Tree::row() const {
  std::uint32_t value = 0;
  const bool is_row = !is_list && std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
  return is_row ? value : throw Rejected("a row number was expected, not `" + std::string(text) + "`");
}

Rows Tree::rows() const {
  Rows rows;
  for (std::size_t k = 1; k < items.size(); ++k) rows.push_back(items[k].row());
  return rows;
}

Tree read_trees(Text text) {
  constexpr Text kBlanks = " \n\t\r", kEnds = " \n\t\r()\";";
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
    } else if (kBlanks.find(c) == Text::npos) {
      end = std::min(text.find_first_of(kEnds, at), text.size());
      // Places in the source are of no interest here.
      if (c != '@') open.back().items.push_back({false, false, text.substr(at, end - at), {}});
    }
  }
  if (open.size() != 1) throw Rejected("a `)` is missing");
  return std::move(open[0]);
}

}  // namespace certcheck
