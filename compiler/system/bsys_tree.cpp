// S-expressions of .bsys: see bsys_tree.hpp.
#include "compiler/system/bsys_tree.hpp"
#include "runtime/include/bip/assert.hpp"

#include <fmt/format.h>

#include "compiler/system/bsys_text.hpp"

namespace bip::system::text {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool ends_word(char c) { return is_blank(c) || c == '(' || c == ')' || c == '"' || c == ';'; }
int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// The byte after a quoted string that begins at `at`, or npos if it does not end on its line.
std::size_t end_of_quoted(std::string_view text, std::size_t at) {
  for (std::size_t k = at + 1; k < text.size() && text[k] != '\n'; ++k) {
    if (text[k] == '"') return k + 1;
    if (text[k] == '\\') ++k;
  }
  return std::string_view::npos;
}

struct OpenList {
  std::uint32_t node;
  std::uint32_t last = kNoNode;
};

}  // namespace

Failure failure_at(std::string_view text, std::size_t offset, std::string_view message) {
  std::size_t line = 1, line_start = 0;
  for (std::size_t k = 0; k < offset && k < text.size(); ++k)
    if (text[k] == '\n') {
      ++line;
      line_start = k + 1;
    }
  return Failure{fmt::format("{}:{}: {}", line, offset - line_start + 1, message)};
}

Result<Tree> read_tree(std::string_view text) {
  if (text.size() > kMaxBytes) return failure_at(text, 0, fmt::format("text is larger than {} bytes", kMaxBytes));
  Tree tree{.text = text, .nodes = {}};
  tree.nodes.push_back({.kind = Node::Kind::List, .begin = 0, .end = static_cast<std::uint32_t>(text.size())});
  std::vector<OpenList> open{{.node = 0}};

  const auto add = [&](Node::Kind kind, std::size_t begin, std::size_t end) {
    const auto node = static_cast<std::uint32_t>(tree.nodes.size());
    tree.nodes.push_back(
        {.kind = kind, .begin = static_cast<std::uint32_t>(begin), .end = static_cast<std::uint32_t>(end)});
    BIP_ASSERT(begin <= end && end <= text.size(), "element {}..{} of {} bytes", begin, end, text.size());
    OpenList& list = open.back();
    BIP_ASSERT(begin >= tree.nodes[list.node].begin, "an element lies in its list");
    (list.last == kNoNode ? tree.nodes[list.node].first : tree.nodes[list.last].next) = node;
    list.last = node;
    return node;
  };

  std::size_t at = 0;
  while (at < text.size()) {
    const char c = text[at];
    if (is_blank(c)) {
      ++at;
    } else if (c == ';') {
      while (at < text.size() && text[at] != '\n') ++at;
    } else if (c == '(') {
      if (open.size() > kMaxParentheses)
        return failure_at(text, at, fmt::format("nested deeper than {}", kMaxParentheses));
      const std::uint32_t node = add(Node::Kind::List, at, at + 1);
      open.push_back({.node = node});
      ++at;
    } else if (c == ')') {
      if (open.size() == 1) return failure_at(text, at, "`)` without `(`");
      tree.nodes[open.back().node].end = static_cast<std::uint32_t>(++at);
      open.pop_back();
    } else if (c == '"') {
      const std::size_t end = end_of_quoted(text, at);
      if (end == std::string_view::npos) return failure_at(text, at, "string does not end on its line");
      add(Node::Kind::Quoted, at, end);
      at = end;
    } else {
      const std::size_t begin = at;
      while (at < text.size() && !ends_word(text[at])) ++at;
      add(Node::Kind::Word, begin, at);
    }
  }
  if (open.size() > 1) return failure_at(text, tree.nodes[open.back().node].begin, "`(` is never closed");
  BIP_ASSERT(tree.nodes.front().end == text.size(), "node 0 is the whole text");
  return tree;
}

bool unquote(std::string_view quoted, std::string& out, std::size_t& bad) {
  BIP_ASSERT(quoted.size() >= 2 && quoted.front() == '"' && quoted.back() == '"', "`{}` is quoted", quoted);
  out.clear();
  for (std::size_t k = 1; k + 1 < quoted.size(); ++k) {
    if (quoted[k] != '\\') {
      out += quoted[k];
      continue;
    }
    bad = k++;
    switch (quoted[k]) {
      case '"':
      case '\\': out += quoted[k]; break;
      case 'n': out += '\n'; break;
      case 't': out += '\t'; break;
      case 'x': {
        const int high = k + 2 < quoted.size() ? hex_digit(quoted[k + 1]) : -1;
        const int low = high >= 0 ? hex_digit(quoted[k + 2]) : -1;
        if (low < 0) return false;
        out += static_cast<char>(high * 16 + low);
        k += 2;
        break;
      }
      default: return false;
    }
  }
  return true;
}

}  // namespace bip::system::text
