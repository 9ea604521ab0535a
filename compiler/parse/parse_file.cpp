// Parses a file: tokens, depth check, ANTLR in two stages, conversion.
//
// A file without errors and warnings is parsed in pieces (read_in_pieces.cpp). Any other file is parsed whole: stage
// one predicts without context (SLL) and gives up at the first error; it accepts every correct file. Only if it gives
// up does stage two predict with full context and report errors. No exception of ANTLR leaves this file.
#include "compiler/parse/parse.hpp"
#include "runtime/include/bip/assert.hpp"

#include <algorithm>

#include "BipLexer.h"
#include "BipParser.h"
#include "antlr4-runtime.h"
#include "compiler/parse/convert.hpp"
#include "compiler/parse/error_strategy.hpp"
#include "compiler/parse/head_of_bip1.hpp"
#include "compiler/parse/parse_changed.hpp"
#include "compiler/parse/read_in_pieces.hpp"
#include "compiler/parse/row_stream.hpp"
#include "compiler/parse/token_list.hpp"

namespace bip::parse {
namespace {

/// The package of a file about which there is nothing to say, else null: the whole tree is needed to say it well.
const syntax::Package* read_sound_file(const TokenList& list, const SourceMap& sources, FileId file, Arena& arena) {
  RowStream stream(list.rows, sources.text(file).size());
  BipParser parser(&stream);
  give_up_at_errors(parser);
  Diagnostics remarks;
  Converter converter(sources, file, TreeArena(arena), remarks);
  try {
    const syntax::Package* package = PieceReader(parser, stream, converter).read();
    return remarks.error_count() + remarks.warning_count() == 0 ? package : nullptr;
  } catch (const antlr4::ParseCancellationException&) {
    return nullptr;
  }
}

/// The parse tree of `rule`, from whichever stage could make it; null if neither could. `convert` runs while it lives.
template <class Rule, class Convert>
void with_tree(const TokenList& list, const SourceMap& sources, FileId file, Diagnostics& diags, Rule rule,
               Convert convert) {
  RowStream stream(list.rows, sources.text(file).size());
  BipParser parser(&stream);
  give_up_at_errors(parser);
  try {
    convert((parser.*rule)());
    return;
  } catch (const antlr4::ParseCancellationException&) {
    // Wrong, or needs context: the second stage knows.
  }
  parser.reset();
  parser.getInterpreter<antlr4::atn::ParserATNSimulator>()->setPredictionMode(antlr4::atn::PredictionMode::LL);
  parser.setErrorHandler(std::make_shared<ReportingStrategy>(sources, file, diags));
  try {
    convert((parser.*rule)());
  } catch (const antlr4::RecognitionException&) {
    // Reported where it was thrown.
  }
}

}  // namespace

std::optional<syntax::Syntax> parse_incrementally(const SourceMap& sources, FileId file, Diagnostics& diags,
                                                  PieceCache& kept) {
  if (head_of_bip1(sources, file).is_valid()) return std::nullopt;
  if (std::optional<syntax::Syntax> syntax = parse_changed(sources, file, kept)) return syntax;
  const ReadDamaged read = [&](const TokenList& list, Arena& arena, Diagnostics& found) {
    const syntax::Package* package = nullptr;
    with_tree(list, sources, file, found, &BipParser::file, [&](BipParser::FileContext* tree) {
      package = Converter(sources, file, TreeArena(arena), found).file(tree);
    });
    return package;
  };
  std::optional<syntax::Syntax> syntax = parse_damaged(sources, file, kept, diags, read);
  kept.partly += syntax.has_value() ? 1 : 0;
  return syntax;
}

std::optional<syntax::Syntax> parse_file(const SourceMap& sources, FileId file, Diagnostics& diags, PieceCache* kept) {
  if (kept != nullptr) {
    if (std::optional<syntax::Syntax> syntax = parse_incrementally(sources, file, diags, *kept)) return syntax;
    ++kept->whole;
  }
  if (const SourceRange head = head_of_bip1(sources, file); head.is_valid()) {
    diags.report(Diag::kB0001, head, "`package`", "", "`model`: this is BIP1, and bipc reads BIP2")
        .help("`bipc migrate " + sources.name(file) + " -o NEW.bip` writes it in BIP2");
    return std::nullopt;
  }
  TokenList list = read_tokens(sources, file, diags);
  if (list.rows.empty()) {
    const SourceRange start{file, 0, 0};
    if (!diags.has_errors())
      diags.report(Diag::kB0009, start).help("a file holds a `package … end`, or components of the paper's notation");
    return std::nullopt;
  }
  if (!check_depth(list.rows, file, diags)) return std::nullopt;
  syntax::Syntax syntax;
  syntax.file = file;
  syntax.arena = std::make_unique<Arena>();
  syntax.comments = std::move(list.comments);
  if (!diags.has_errors()) syntax.package = read_sound_file(list, sources, file, *syntax.arena);
  BIP_ASSERT(list.rows.back().end <= sources.text(file).size(), "tokens lie in the file");
  if (syntax.package != nullptr) return syntax;
  syntax.arena = std::make_unique<Arena>();
  with_tree(list, sources, file, diags, &BipParser::file, [&](BipParser::FileContext* tree) {
    Converter converter(sources, file, TreeArena(*syntax.arena), diags);
    syntax.package = converter.file(tree);
  });
  if (syntax.package == nullptr) return std::nullopt;
  return syntax;
}

std::string dump_tokens(const SourceMap& sources, FileId file) {
  Diagnostics ignored;
  std::string out;
  const TokenList list = read_tokens(sources, file, ignored);
  std::vector<TokenRow> rows = list.rows;
  for (const syntax::Comment& c : list.comments) rows.push_back({0, c.range.begin, c.range.end, 0});
  std::sort(rows.begin(), rows.end(), [](const TokenRow& a, const TokenRow& b) { return a.begin < b.begin; });
  const ::antlr4::dfa::Vocabulary& names = []() -> const ::antlr4::dfa::Vocabulary& {
    static antlr4::ANTLRInputStream none;
    static const antlr::BipLexer lexer(&none);
    return lexer.getVocabulary();
  }();
  for (const TokenRow& row : rows) {
    const Loc at = sources.loc(file, row.begin);
    const std::string_view text = sources.text(SourceRange{file, row.begin, row.end});
    out += fmt::format("{}:{}  {}  {}\n", at.line, at.column,
                       row.type == 0 ? "COMMENT" : names.getSymbolicName(row.type), text);
  }
  return out;
}

std::optional<RootSpec> parse_root(SourceMap& sources, const std::string& text, Diagnostics& diags) {
  const FileId file = sources.add("--root", text);
  const auto bad = [&]() -> std::optional<RootSpec> {
    if (!diags.has_errors())
      diags.report(Diag::kB0020, SourceRange{file, 0, static_cast<std::uint32_t>(text.size())}, text);
    return std::nullopt;
  };
  const TokenList list = read_tokens(sources, file, diags);
  if (list.rows.empty() || !check_depth(list.rows, file, diags)) return bad();
  RootSpec root;
  root.arena = std::make_unique<Arena>();
  const syntax::Expr* expr = nullptr;
  with_tree(list, sources, file, diags, &BipParser::rootSpec, [&](BipParser::RootSpecContext* tree) {
    Converter converter(sources, file, TreeArena(*root.arena), diags);
    if (tree->exception == nullptr && tree->expr() != nullptr) expr = converter.expr(tree->expr());
  });
  if (expr == nullptr || (expr->kind != syntax::ExprKind::Call && expr->kind != syntax::ExprKind::Path) ||
      expr->parenthesised)
    return bad();
  for (const syntax::PathPart& part : expr->path.parts) {
    if (part.index != nullptr || part.star) return bad();
    if (!root.type.empty()) root.type += '.';
    root.type += part.name.text;
  }
  root.args.assign(expr->operands.begin(), expr->operands.end());
  return root;
}

}  // namespace bip::parse
