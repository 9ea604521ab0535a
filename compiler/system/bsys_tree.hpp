// S-expressions of .bsys as a flat tree: the reader's first half. Internal to system/.
//
// Words, quoted strings and lists; `;` comments to the end of the line. Any bytes give a tree or a failure; nesting is
// limited by kMaxParentheses, size by kMaxBytes. Iterative, linear.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/base/result.hpp"

namespace bip::system::text {

inline constexpr std::size_t kMaxBytes = std::size_t{1} << 30;
inline constexpr std::uint32_t kNoNode = 0xffffffffu;

/// One element: bytes [begin, end) of the text; a list's first element, and what follows in the list around it.
struct Node {
  enum class Kind : std::uint8_t { List, Word, Quoted } kind = Kind::Word;
  std::uint32_t begin = 0, end = 0;
  std::uint32_t first = kNoNode;
  std::uint32_t next = kNoNode;
};
struct Tree {
  std::string_view text;
  std::vector<Node> nodes;  // node 0: a list around the whole text

  [[nodiscard]] std::string_view word(std::uint32_t node) const {
    return text.substr(nodes[node].begin, nodes[node].end - nodes[node].begin);
  }
};

[[nodiscard]] Result<Tree> read_tree(std::string_view text);
/// "line:column: message" for a byte of the text.
[[nodiscard]] Failure failure_at(std::string_view text, std::size_t offset, std::string_view message);
/// What a Quoted node says. False if an escape is wrong; `bad` is then its offset.
[[nodiscard]] bool unquote(std::string_view quoted, std::string& out, std::size_t& bad);

}  // namespace bip::system::text
