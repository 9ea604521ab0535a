// The trees of a file's declarations, kept between two parses so that the second parses only those that changed.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "compiler/base/arena.hpp"
#include "compiler/parse/tree_arena.hpp"
#include "compiler/syntax/syntax.hpp"

namespace bip::parse {

/// Types of the tokens that follow a piece, as many as a decision about its last token may look at; 0 behind the end.
using TokensAhead = std::array<std::size_t, 3>;

/// Some declarations of a sound file (all between two cuts), or its beginning, with their tree.
struct CachedPiece {
  std::string text;
  std::uint32_t begin = 0;     // where its ranges say that it is
  std::uintptr_t address = 0;  // where its views say that it is
  TokensAhead first{};         // its own first tokens as the lexer has them: the piece before it looks at them
  TokensAhead first_classified{};
  std::size_t token_count = 0;
  TokensAhead ahead{};  // with which it was read
  TokensAhead ahead_classified{};

  std::unique_ptr<Arena> arena;
  std::vector<MadeNodes> made;            // all nodes of the arena
  const syntax::Package* head = nullptr;  // name, annotations and `use` lines; null but for the first piece
  std::vector<const syntax::Decl*> decls;
  bool ends_package = false;
  std::uint32_t end_word = 0;  // where its `end` begins in the piece, if it ends the package
  std::vector<syntax::Comment> comments;
};

/// The pieces of one file as it was last parsed.
struct PieceCache {
  std::vector<CachedPiece> pieces;
  // So far, for tests: what an edit costs.
  std::uint64_t parsed = 0;  // pieces
  std::uint64_t reused = 0;
  std::uint64_t partly = 0;  // texts that were not sound, and of which only the place with the errors was read
  std::uint64_t whole = 0;   // others that were not sound, and were read as a whole
};

}  // namespace bip::parse
