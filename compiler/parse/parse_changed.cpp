// See parse_changed.hpp. The text is cut (cut_pieces.cpp); a piece whose text, and whose next tokens, are those of a
// kept one gets its tree, moved to its new place. Each other one is read alone.
//
// That a piece is read alone as it is inside of the file follows from four facts, each of which is checked:
// - A cut is at the begin of a line, and no piece before it ends inside of a comment. Words end with a line, so the
//   lexer, which has no state, gives the same tokens.
// - The classification of words begins anew between declarations; each piece leaves it so, and begins with a word of
//   which it looks at nothing before. It looks at three tokens ahead, which are part of what must be equal; a piece of
//   which it looks further is not read alone.
// - Prediction without context does not depend on what surrounds a rule; what follows a declaration is among the three
//   tokens.
// - Nothing is to be reported: no piece gives a message. So no recovery reaches over a cut.
//
// Cost: a scan and a hash of the text, the lexer and the parser for the pieces that changed, and a few loads and stores
// for each node of the others.
#include "compiler/parse/parse_changed.hpp"

#include <algorithm>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "BipParser.h"
#include "antlr4-runtime.h"
#include "compiler/parse/convert.hpp"
#include "compiler/parse/cut_pieces.hpp"
#include "compiler/parse/read_in_pieces.hpp"
#include "compiler/parse/row_stream.hpp"
#include "compiler/parse/token_list.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {
namespace {

constexpr std::size_t kAhead = std::tuple_size_v<TokensAhead>;

/// A piece of the new text on its way to a tree.
struct NewPiece {
  std::uint32_t begin = 0, end = 0;
  KeptPiece* same = nullptr;  // the kept piece with this text, or null
  KeptPiece made;             // without one
  std::vector<TokenRow> rows;
  [[nodiscard]] const KeptPiece& piece() const { return same != nullptr ? *same : made; }
};

TokensAhead first_types(const std::vector<TokenRow>& rows) {
  TokensAhead types{};
  for (std::size_t i = 0; i < std::min(kAhead, rows.size()); ++i) types[i] = rows[i].type;
  return types;
}

class ChangedParser {
 public:
  ChangedParser(const SourceMap& sources, FileId file, KeptPieces& kept)
      : sources_(sources), file_(file), text_(sources.text(file)), kept_(kept) {}

  std::optional<syntax::Syntax> run() {
    cut();
    find_same();
    // A kept piece whose neighbour changed may have to be read again, and then its neighbour's tokens are the same as
    // before: one round is enough.
    for (NewPiece& p : pieces_) {
      if (p.same == nullptr && !read_words(p)) return std::nullopt;
    }
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (pieces_[i].same != nullptr && pieces_[i].same->ahead == ahead(i, &KeptPiece::first)) continue;
      if (!classify(i)) return std::nullopt;
    }
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (pieces_[i].same != nullptr && pieces_[i].same->ahead_classified == ahead(i, &KeptPiece::first_classified))
        continue;
      if (pieces_[i].same != nullptr && !classify(i)) return std::nullopt;
      if (!parse(i)) return std::nullopt;
    }
    if (!is_package_whole()) return std::nullopt;
    return keep_all();
  }

 private:
  void cut() {
    const std::vector<std::uint32_t> begins = cut_pieces(text_);
    pieces_.resize(begins.size());
    for (std::size_t i = 0; i < begins.size(); ++i) {
      pieces_[i].begin = begins[i];
      pieces_[i].end = i + 1 < begins.size() ? begins[i + 1] : static_cast<std::uint32_t>(text_.size());
    }
  }

  [[nodiscard]] std::string_view text_of(const NewPiece& p) const { return text_.substr(p.begin, p.end - p.begin); }

  // The first piece is the only one that may have a head, so it is only compared with the first.
  void find_same() {
    if (kept_.pieces.empty()) return;
    std::unordered_multimap<std::string_view, KeptPiece*> by_text;
    for (std::size_t i = kept_.pieces.size(); i-- > 1;) by_text.emplace(kept_.pieces[i].text, &kept_.pieces[i]);
    if (kept_.pieces.front().text == text_of(pieces_.front())) pieces_.front().same = &kept_.pieces.front();
    for (std::size_t i = 1; i < pieces_.size(); ++i) {
      const auto found = by_text.find(text_of(pieces_[i]));
      if (found == by_text.end()) continue;
      pieces_[i].same = found->second;
      by_text.erase(found);
    }
  }

  bool read_words(NewPiece& p) {
    std::optional<TokenList> list = read_sound_tokens(sources_, file_, p.begin, p.end);
    if (!list) return false;
    p.rows = std::move(list->rows);
    p.made.comments = std::move(list->comments);
    p.made.first = first_types(p.rows);
    p.made.token_count = p.rows.size();
    return true;
  }

  /// Of the tokens that follow piece `i`.
  [[nodiscard]] TokensAhead ahead(std::size_t i, TokensAhead KeptPiece::*first) const {
    TokensAhead types{};
    std::size_t count = 0;
    for (++i; i < pieces_.size() && count < kAhead; ++i) {
      const KeptPiece& next = pieces_[i].piece();
      for (std::size_t k = 0; k < std::min(next.token_count, kAhead) && count < kAhead; ++k)
        types[count++] = (next.*first)[k];
    }
    return types;
  }

  bool classify(std::size_t i) {
    NewPiece& p = pieces_[i];
    if (p.same != nullptr) {
      p.same = nullptr;
      if (!read_words(p)) return false;
    }
    p.made.ahead = ahead(i, &KeptPiece::first);
    const auto end = std::find(p.made.ahead.begin(), p.made.ahead.end(), std::size_t{0});
    if (!classify_piece(p.rows, {p.made.ahead.begin(), end}, text_)) return false;
    p.made.first_classified = first_types(p.rows);
    Diagnostics remarks;
    return check_depth(p.rows, file_, remarks);
  }

  bool parse(std::size_t i) {
    NewPiece& p = pieces_[i];
    KeptPiece& made = p.made;
    made.text = text_of(p);
    made.begin = p.begin;
    made.address = reinterpret_cast<std::uintptr_t>(text_.data() + p.begin);
    made.ahead_classified = ahead(i, &KeptPiece::first_classified);
    made.arena = std::make_unique<Arena>();
    const std::size_t end = p.rows.size();
    for (const std::size_t type : made.ahead_classified) {
      if (type != 0) p.rows.push_back({.type = type, .begin = p.end, .end = p.end});
    }
    RowStream stream(p.rows, text_.size());
    BipParser parser(&stream);
    give_up_at_errors(parser);
    Diagnostics remarks;
    Converter converter(sources_, file_, TreeArena(*made.arena, &made.made), remarks);
    PieceReader reader(parser, stream, converter);
    ++kept_.parsed;
    try {
      if (i == 0) made.head = TreeArena(*made.arena, &made.made).make(reader.read_head());
      reader.read_decls(end, made.decls);
      made.ends_package = reader.read_end(end);
    } catch (const antlr4::ParseCancellationException&) {
      return false;
    }
    return stream.index() == end && remarks.error_count() + remarks.warning_count() == 0;
  }

  /// Nothing follows the `end` of a package, and each package has one.
  [[nodiscard]] bool is_package_whole() const {
    std::size_t words = 0;
    bool is_ended = false;
    for (const NewPiece& p : pieces_) {
      const std::size_t count = p.piece().token_count;
      if (is_ended && count != 0) return false;
      words += count;
      is_ended = is_ended || p.piece().ends_package;
    }
    return words != 0 && is_ended == !pieces_.front().piece().head->name.parts.empty();
  }

  syntax::Syntax keep_all() {
    syntax::Syntax syntax;
    syntax.file = file_;
    syntax.arena = std::make_unique<Arena>();
    std::vector<KeptPiece> now;
    now.reserve(pieces_.size());
    std::vector<const syntax::Decl*> decls;
    for (NewPiece& p : pieces_) {
      if (p.same != nullptr) {
        ++kept_.reused;
        now.push_back(std::move(*p.same));
        move_to(now.back(), p.begin);
      } else {
        now.push_back(std::move(p.made));
      }
      decls.insert(decls.end(), now.back().decls.begin(), now.back().decls.end());
      syntax.comments.insert(syntax.comments.end(), now.back().comments.begin(), now.back().comments.end());
    }
    syntax::Package package = *now.front().head;
    package.decls = syntax.arena->list(decls);
    package.range = {file_, 0, static_cast<std::uint32_t>(text_.size())};
    syntax.package = syntax.arena->make(package);
    kept_.pieces = std::move(now);
    return syntax;
  }

  void move_to(KeptPiece& piece, std::uint32_t begin) const {
    const syntax::NodeMove by{.from = piece.address,
                              .size = piece.text.size(),
                              .to = text_.data() + begin,
                              .shift = begin - piece.begin,
                              .file = file_};
    for (const MadeNodes& nodes : piece.made) nodes.move(nodes.first, nodes.count, by);
    for (syntax::Comment& comment : piece.comments) move(comment, by);
    piece.begin = begin;
    piece.address = reinterpret_cast<std::uintptr_t>(by.to);
  }

  const SourceMap& sources_;
  FileId file_;
  std::string_view text_;
  KeptPieces& kept_;
  std::vector<NewPiece> pieces_;
};

}  // namespace

std::optional<syntax::Syntax> parse_changed(const SourceMap& sources, FileId file, KeptPieces& kept) {
  std::optional<syntax::Syntax> syntax = ChangedParser(sources, file, kept).run();
  if (!syntax) ++kept.whole;
  return syntax;
}

}  // namespace bip::parse
