// A reader with a stack of its own, so that depth costs heap.
#include "tools/certcheck/tree.hpp"

namespace certcheck {

const Tree* Tree::find(std::string_view name) const {
  for (const Tree& item : items) {
    if (item.head() == name) return &item;
  }
  return nullptr;
}

std::size_t Tree::row() const {
  std::size_t value = 0, digits = 0;
  for (; digits < text.size() && text[digits] >= '0' && text[digits] <= '9'; ++digits) value = value * 10 + static_cast<std::size_t>(text[digits] - '0');
  if (is_list || digits == 0 || digits > 10) throw Rejected("a row number was expected, not `" + text + "`");
  return value;
}

std::vector<Tree> read_trees(std::string_view text) {
  std::vector<Tree> open(1);
  std::size_t at = 0;
  while (at < text.size()) {
    const char c = text[at];
    if (c == ' ' || c == '\n' || c == '\t' || c == '\r') {
      ++at;
    } else if (c == ';') {
      while (at < text.size() && text[at] != '\n') ++at;
    } else if (c == '(') {
      open.emplace_back().is_list = true;
      ++at;
    } else if (c == ')') {
      if (open.size() < 2) throw Rejected("one `)` too many");
      Tree done = std::move(open.back());
      open.pop_back();
      open.back().items.push_back(std::move(done));
      ++at;
    } else if (c == '"') {
      Tree word;
      word.is_string = true;
      for (++at; at < text.size() && text[at] != '"'; ++at) {
        // The escape as it stands: strings are only compared with each other.
        if (text[at] == '\\' && at + 1 < text.size()) word.text += text[at++];
        word.text += text[at];
      }
      ++at;
      open.back().items.push_back(std::move(word));
    } else {
      Tree word;
      while (at < text.size() && std::string_view(" \n\t\r()\";").find(text[at]) == std::string_view::npos) word.text += text[at++];
      // Places in the source are of no interest here.
      if (word.text[0] != '@') open.back().items.push_back(std::move(word));
    }
  }
  if (open.size() != 1) throw Rejected("a `)` is missing");
  return std::move(open[0].items);
}

}  // namespace certcheck
