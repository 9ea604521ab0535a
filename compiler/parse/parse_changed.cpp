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
  CachedPiece* same = nullptr;  // the kept piece with this text, or null
  CachedPiece made;             // without one
  std::vector<TokenRow> rows;
  [[nodiscard]] const CachedPiece& piece() const { return same != nullptr ? *same : made; }
};

TokensAhead first_types(const std::vector<TokenRow>& rows) {
  TokensAhead types{};
  for (std::size_t i = 0; i < std::min(kAhead, rows.size()); ++i) types[i] = rows[i].type;
  return types;
}

void copy_all(const Diagnostics& from, Diagnostics& to) {
  for (const Diagnostic* d : from.sorted()) {
    DiagnosticBuilder copy = to.add(d->kind, d->range, d->message);
    if (!d->label.empty()) copy.label(d->label);
    for (const Label& label : d->labels) copy.label(label.range, label.text);
    for (const std::string& note : d->notes) copy.note(note);
    for (const Help& help : d->helps) copy.help(help.text, help.replace, help.with);
  }
}

class ChangedParser {
 public:
  ChangedParser(const SourceMap& sources, FileId file, PieceCache& kept)
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
      if (pieces_[i].same != nullptr && pieces_[i].same->ahead == ahead(i, &CachedPiece::first)) continue;
      if (!classify(i)) return std::nullopt;
    }
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (pieces_[i].same != nullptr && pieces_[i].same->ahead_classified == ahead(i, &CachedPiece::first_classified))
        continue;
      if (pieces_[i].same != nullptr && !classify(i)) return std::nullopt;
      if (!parse(i)) return std::nullopt;
    }
    if (!is_package_whole()) return std::nullopt;
    return keep_all();
  }

  std::optional<syntax::Syntax> run_damaged(Diagnostics& diags, const ReadDamaged& read) {
    cut();
    find_same();
    const auto is_new = [](const NewPiece& p) { return p.same == nullptr; };
    const auto first = std::find_if(pieces_.begin(), pieces_.end(), is_new);
    if (first == pieces_.end()) return std::nullopt;
    const auto from = static_cast<std::size_t>(first - pieces_.begin());
    const auto to =
        static_cast<std::size_t>(std::find_if(pieces_.rbegin(), pieces_.rend(), is_new).base() - pieces_.begin());
    // Where much is new, or the beginning, there is little to gain.
    if (from == 0 || (to - from) * 4 > pieces_.size()) return std::nullopt;
    const bool is_last = to == pieces_.size();
    const CachedPiece& head = *pieces_.front().same;

    Diagnostics found;
    std::optional<TokenList> words = read_part(sources_, file_, 0, pieces_.front().end, found);
    const std::uint32_t begin = pieces_[from].begin;
    const std::uint32_t behind = is_last ? static_cast<std::uint32_t>(text_.size()) : pieces_[to].begin;
    std::optional<TokenList> damaged = read_part(sources_, file_, begin, is_last ? behind : pieces_[to].end, found);
    if (!words || !damaged || damaged->rows.empty()) return std::nullopt;
    // Requires that the kept pieces were parsed with the same lookahead tokens.
    if (!looks_at(from, to, damaged->rows, &CachedPiece::ahead, &CachedPiece::first)) return std::nullopt;
    TokensAhead ahead_of_head = head.ahead;
    const auto head_end = std::find(ahead_of_head.begin(), ahead_of_head.end(), std::size_t{0});
    if (!classify_piece(words->rows, {ahead_of_head.begin(), head_end}, text_)) return std::nullopt;
    if (is_last) {
      classify_tokens(damaged->rows, text_);
    } else {
      const TokensAhead next = ahead(to, &CachedPiece::first);
      if (!classify_piece(damaged->rows, {next.begin(), std::find(next.begin(), next.end(), std::size_t{0})}, text_))
        return std::nullopt;
    }
    if (!looks_at(from, to, damaged->rows, &CachedPiece::ahead_classified, &CachedPiece::first_classified))
      return std::nullopt;
    Diagnostics depth;
    if (!check_depth(damaged->rows, file_, depth)) return std::nullopt;
    const auto behind_row = std::find_if(damaged->rows.begin(), damaged->rows.end(),
                                         [behind](const TokenRow& row) { return row.begin >= behind; });
    const std::uint32_t most = behind_row == damaged->rows.end() ? behind : behind_row->end;
    words->rows.insert(words->rows.end(), damaged->rows.begin(), damaged->rows.end());
    if (const CachedPiece* last = pieces_.back().same;
        last != nullptr && to + 1 < pieces_.size() && last->ends_package) {
      const std::uint32_t at = pieces_.back().begin + last->end_word;
      words->rows.push_back({.type = BipParser::END, .begin = at, .end = at + 3, .line = sources_.loc(file_, at).line});
    }

    syntax::Syntax syntax;
    syntax.file = file_;
    syntax.arena = std::make_unique<Arena>();
    const syntax::Package* read_package = read(*words, *syntax.arena, found);
    if (read_package == nullptr) return std::nullopt;
    for (const Diagnostic* d : found.sorted()) {
      if (d->range.file != file_ || d->range.begin < begin || d->range.end > most) return std::nullopt;
    }
    // What stands before is as it was, and reading came to the end of the piece behind as it does without errors. (Of
    // what that begins with, recovery may have skipped the annotations.)
    const std::uint32_t end = is_last ? behind : pieces_[to].end;
    std::vector<const syntax::Decl*> read_here;
    std::size_t before = 0;
    for (const syntax::Decl* d : read_package->decls) {
      if (d->range.begin >= begin) read_here.push_back(d);
      else ++before;
    }
    if (before != head.decls.size()) return std::nullopt;
    if (!is_last) {
      const CachedPiece& next = *pieces_[to].same;
      if (read_here.empty() || next.decls.empty()) return std::nullopt;
      const syntax::Decl& last = *read_here.back();
      const std::uint32_t shift = pieces_[to].begin - next.begin;
      if (last.range.begin < behind || last.range.end != next.decls.back()->range.end + shift) return std::nullopt;
    }
    std::vector<const syntax::Decl*> decls;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (i == from) {
        decls.insert(decls.end(), read_here.begin(), read_here.end());
        syntax.comments.insert(syntax.comments.end(), damaged->comments.begin(), damaged->comments.end());
      }
      if (pieces_[i].begin >= begin && pieces_[i].begin < end) continue;
      CachedPiece& piece = *pieces_[i].same;
      move_to(piece, pieces_[i].begin);
      decls.insert(decls.end(), piece.decls.begin(), piece.decls.end());
      syntax.comments.insert(syntax.comments.end(), piece.comments.begin(), piece.comments.end());
    }
    syntax::Package package = *read_package;
    package.decls = syntax.arena->list(decls);
    syntax.package = syntax.arena->make(package);
    copy_all(found, diags);
    return syntax;
  }

 private:
  /// Do all kept pieces but those from `from` to `to` look ahead at what they were read with? `rows`: the words that
  /// stand there.
  [[nodiscard]] bool looks_at(std::size_t from, std::size_t to, const std::vector<TokenRow>& rows,
                              TokensAhead CachedPiece::*ahead_of, TokensAhead CachedPiece::*first) const {
    if (rows.size() < kAhead) return false;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (i >= from && i < to) continue;
      TokensAhead types{};
      std::size_t count = 0;
      for (std::size_t k = i + 1; k < pieces_.size() && count < kAhead; ++k) {
        if (k == from) {
          // No fewer than it takes.
          for (std::size_t row = 0; count < kAhead; ++row) types[count++] = rows[row].type;
          break;
        }
        const CachedPiece& next = *pieces_[k].same;
        for (std::size_t t = 0; t < std::min(next.token_count, kAhead) && count < kAhead; ++t)
          types[count++] = (next.*first)[t];
      }
      if ((*pieces_[i].same).*ahead_of != types) return false;
    }
    return true;
  }

  void cut() {
    const std::vector<std::uint32_t> begins = cut_pieces(text_);
    BIP_ASSERT(begins.front() == 0 && begins.back() <= text_.size(), "pieces from {} to {} of {} bytes", begins.front(),
               begins.back(), text_.size());
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
    std::unordered_multimap<std::string_view, CachedPiece*> by_text;
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
  [[nodiscard]] TokensAhead ahead(std::size_t i, TokensAhead CachedPiece::*first) const {
    TokensAhead types{};
    std::size_t count = 0;
    for (++i; i < pieces_.size() && count < kAhead; ++i) {
      const CachedPiece& next = pieces_[i].piece();
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
    p.made.ahead = ahead(i, &CachedPiece::first);
    const auto end = std::find(p.made.ahead.begin(), p.made.ahead.end(), std::size_t{0});
    if (!classify_piece(p.rows, {p.made.ahead.begin(), end}, text_)) return false;
    p.made.first_classified = first_types(p.rows);
    Diagnostics remarks;
    return check_depth(p.rows, file_, remarks);
  }

  bool parse(std::size_t i) {
    NewPiece& p = pieces_[i];
    CachedPiece& made = p.made;
    made.text = text_of(p);
    made.begin = p.begin;
    made.address = reinterpret_cast<std::uintptr_t>(text_.data() + p.begin);
    made.ahead_classified = ahead(i, &CachedPiece::first_classified);
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
      BIP_ASSERT(made.decls.empty() && made.head == nullptr, "piece {} is parsed again", i);
      if (i == 0) made.head = TreeArena(*made.arena, &made.made).make(reader.read_head());
      reader.read_decls(end, made.decls);
      made.ends_package = reader.read_end(end);
      if (made.ends_package) made.end_word = p.rows[stream.index() - 1].begin - p.begin;
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
    std::vector<CachedPiece> now;
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
    BIP_ASSERT(std::is_sorted(decls.begin(), decls.end(),
                              [](const auto* a, const auto* b) { return a->range.begin < b->range.begin; }),
               "{} declarations are not in the order of the text", decls.size());
    BIP_ASSERT(now.front().head != nullptr && now.size() == pieces_.size(), "{} of {} pieces are kept", now.size(),
               pieces_.size());
    syntax::Package package = *now.front().head;
    package.decls = syntax.arena->list(decls);
    package.range = {file_, 0, static_cast<std::uint32_t>(text_.size())};
    syntax.package = syntax.arena->make(package);
    kept_.pieces = std::move(now);
    return syntax;
  }

  void move_to(CachedPiece& piece, std::uint32_t begin) const {
    BIP_ASSERT(text_.substr(begin, piece.text.size()) == piece.text, "another text is at {}", begin);
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
  PieceCache& kept_;
  std::vector<NewPiece> pieces_;
};

}  // namespace

std::optional<syntax::Syntax> parse_changed(const SourceMap& sources, FileId file, PieceCache& kept) {
  return ChangedParser(sources, file, kept).run();
}

std::optional<syntax::Syntax> parse_damaged(const SourceMap& sources, FileId file, PieceCache& kept, Diagnostics& diags,
                                            const ReadDamaged& read) {
  return kept.pieces.empty() ? std::nullopt : ChangedParser(sources, file, kept).run_damaged(diags, read);
}

}  // namespace bip::parse
