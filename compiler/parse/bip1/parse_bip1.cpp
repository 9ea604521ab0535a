// Parses BIP1: tokens, depth check, ANTLR in two stages as parse_file.cpp does. The first syntax error ends it: who
// migrates a file has one that its own compiler took.
#include "compiler/parse/bip1/parse_bip1.hpp"

#include <algorithm>
#include <memory>
#include <string>

#include "Bip1Lexer.h"
#include "Bip1Parser.h"
#include "antlr4-runtime.h"
#include "compiler/parse/bip1/convert_bip1.hpp"
#include "compiler/parse/each_token.hpp"
#include "compiler/parse/row_stream.hpp"

namespace bip::parse {
namespace {

using antlr::Bip1Lexer;
using antlr::Bip1Parser;

/// What ANTLR expects, in BIP1's words. Groups of tokens that begin an expression or a name are told as such.
std::vector<std::string> bip1_words(antlr4::misc::IntervalSet expected) {
  const antlr4::dfa::Vocabulary& names = []() -> const antlr4::dfa::Vocabulary& {
    static antlr4::ANTLRInputStream none;
    static const Bip1Lexer lexer(&none);
    return lexer.getVocabulary();
  }();
  std::vector<std::string> words;
  const auto has = [&expected](std::size_t type) { return expected.contains(static_cast<ssize_t>(type)); };
  const auto drop = [&expected](std::initializer_list<std::size_t> types) {
    for (const std::size_t type : types) expected.remove(type);
  };
  if (has(Bip1Lexer::INT) && has(Bip1Lexer::STRING)) {
    words.emplace_back("an expression");
    drop({Bip1Lexer::INT, Bip1Lexer::HEX, Bip1Lexer::FLOAT, Bip1Lexer::STRING, Bip1Lexer::TRUE, Bip1Lexer::FALSE,
          Bip1Lexer::ID, Bip1Lexer::LPAREN, Bip1Lexer::MINUS, Bip1Lexer::PLUS, Bip1Lexer::TILDE, Bip1Lexer::BANG,
          Bip1Lexer::PRIME});
  }
  if (has(Bip1Lexer::STAR) && has(Bip1Lexer::OROR)) {
    words.emplace_back("an operator");
    for (std::size_t type = Bip1Lexer::OROR; type <= Bip1Lexer::PERCENT; ++type) expected.remove(type);
  }
  if (has(Bip1Lexer::ID)) words.emplace_back("a name");
  if (has(Bip1Lexer::LBRACE)) words.emplace_back("code in braces");
  drop({Bip1Lexer::ID, Bip1Lexer::WHEN, Bip1Lexer::RESET, Bip1Lexer::IN, Bip1Lexer::UNIT, Bip1Lexer::LAZY,
        Bip1Lexer::DELAYABLE, Bip1Lexer::EAGER, Bip1Lexer::AS, Bip1Lexer::LBRACE, Bip1Lexer::RAW_OPEN,
        Bip1Lexer::CODE_TEXT, Bip1Lexer::RAW_TEXT});
  for (const ssize_t type : expected.toList()) {
    if (words.size() == 6) break;
    if (type == static_cast<ssize_t>(antlr4::Token::EOF)) {
      words.emplace_back("end of file");
      continue;
    }
    std::string word(names.getLiteralName(static_cast<std::size_t>(type)));
    if (type == Bip1Lexer::ATOMIC) word = "'atomic'";
    if (type == Bip1Lexer::BEHAVIOR) word = "'behavior'";
    if (type == Bip1Lexer::HEADER) word = "'header'";
    if (word.size() > 2) words.push_back("`" + word.substr(1, word.size() - 2) + "`");
  }
  return words;
}

std::string listed_words(const std::vector<std::string>& words) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) out += i + 1 == words.size() ? " or " : ", ";
    out += words[i];
  }
  return out;
}

/// Reports the first error and gives up.
class Bip1Strategy final : public antlr4::DefaultErrorStrategy {
 public:
  Bip1Strategy(std::string_view text, FileId file, Diagnostics& diags) : text_(text), file_(file), diags_(diags) {}

  void reportError(antlr4::Parser* parser, const antlr4::RecognitionException& e) override {
    antlr4::misc::IntervalSet expected = parser->getExpectedTokens();
    if (const auto* stuck = dynamic_cast<const antlr4::NoViableAltException*>(&e);
        stuck != nullptr && stuck->getDeadEndConfigs() != nullptr) {
      antlr4::misc::IntervalSet next;
      for (const auto& config : stuck->getDeadEndConfigs()->configs) {
        next.addAll(parser->getATN().nextTokens(config->state));
      }
      next.remove(antlr4::Token::EPSILON);
      if (!next.isEmpty()) expected = next;
    }
    report(parser, e.getOffendingToken(), expected);
  }
  void recover(antlr4::Parser* /*parser*/, std::exception_ptr /*e*/) override {
    throw antlr4::ParseCancellationException();
  }
  antlr4::Token* recoverInline(antlr4::Parser* parser) override {
    report(parser, parser->getCurrentToken(), parser->getExpectedTokens());
    throw antlr4::ParseCancellationException();
  }
  // Where a list may go on or end: what may continue it and what may follow it are expected alike.
  void sync(antlr4::Parser* parser) override {
    const antlr4::misc::IntervalSet expected = parser->getExpectedTokens();
    const antlr4::Token* found = parser->getCurrentToken();
    if (expected.contains(static_cast<ssize_t>(found->getType()))) return;
    report(parser, found, expected);
    throw antlr4::ParseCancellationException();
  }

 private:
  [[nodiscard]] std::string phrase(const antlr4::Token* token) const {
    if (token->getType() == antlr4::Token::EOF) return "end of file";
    const std::size_t begin = token->getStartIndex();
    const std::string_view word = text_.substr(begin, token->getStopIndex() - begin);
    return token->getType() == Bip1Lexer::STRING ? "a string"
                                                 : "`" + std::string(word.substr(0, word.find('\n'))) + "`";
  }
  [[nodiscard]] SourceRange range(const antlr4::Token* token) const {
    return {file_, static_cast<std::uint32_t>(token->getStartIndex()),
            static_cast<std::uint32_t>(token->getStopIndex())};
  }
  void report(antlr4::Parser* parser, const antlr4::Token* found, const antlr4::misc::IntervalSet& expected) {
    if (auto* block = dynamic_cast<Bip1Parser::BlockContext*>(parser->getContext());
        block != nullptr && found->getType() == antlr4::Token::EOF) {
      const bool is_raw = block->start->getType() == Bip1Lexer::RAW_OPEN;
      diags_.report(Diag::kB0007, range(block->start), is_raw ? "{#" : "{", is_raw ? "#}" : "}", "", phrase(found));
      return;
    }
    const std::size_t index = found->getTokenIndex();
    const std::string after = index == 0 ? "" : " after " + phrase(parser->getTokenStream()->get(index - 1));
    const std::vector<std::string> words = bip1_words(expected);
    auto diagnostic = diags_.report(Diag::kB0001, range(found), listed_words(words), after, phrase(found));
    if (found->getType() != Bip1Lexer::ID) return;
    std::vector<std::string> keywords;
    for (const ssize_t type : expected.toList()) {
      const std::string word(
          parser->getVocabulary().getLiteralName(static_cast<std::size_t>(std::max<ssize_t>(type, 0))));
      if (word.size() > 3 && word[1] >= 'a' && word[1] <= 'z') keywords.push_back(word.substr(1, word.size() - 2));
    }
    const SourceRange at = range(found);
    const std::vector<std::string> similar =
        similar_names(std::string(text_.substr(at.begin, at.end - at.begin)), keywords);
    if (!similar.empty()) diagnostic.help("there is a word `" + similar.front() + "`", at, similar.front());
  }

  std::string_view text_;
  FileId file_;
  Diagnostics& diags_;
};

/// Reports and drops what the lexer could not read.
std::vector<TokenRow> sound_bip1_tokens(const std::vector<TokenRow>& all, std::string_view text, FileId file,
                                        Diagnostics& diags) {
  std::vector<TokenRow> rows;
  for (const TokenRow& row : all) {
    const SourceRange at{file, row.begin, row.end};
    if (row.type == Bip1Lexer::UNCLOSED_COMMENT) {
      diags.report(Diag::kB0003, SourceRange{file, row.begin, row.begin + 2})
          .label("opened here, open to the end of the file");
    } else if (row.type == Bip1Lexer::UNCLOSED_STRING) {
      diags.report(Diag::kB0004, at).label("the line ends inside the string");
    } else if (row.type == Bip1Lexer::STRAY) {
      const std::string_view sign = text.substr(row.begin, row.end - row.begin);
      const auto first = static_cast<unsigned char>(sign.empty() ? '\0' : sign.front());
      diags
          .report(Diag::kB0002, at, first < 0x20 || first == 0x7F ? fmt::format("\\x{:02x}", first) : std::string(sign))
          .help("C code stands in braces");
    } else {
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace

TokenList read_bip1_tokens(std::string_view part, std::uint32_t begin) {
  TokenList list;
  each_token<Bip1Lexer>(part, begin, [&list](const TokenRow& row) {
    if (row.type == Bip1Lexer::LINE_COMMENT || row.type == Bip1Lexer::BLOCK_COMMENT) {
      list.comments.push_back({{FileId(), row.begin, row.end}});
    } else {
      list.rows.push_back(row);
    }
  });
  for (std::size_t i = 0; i < list.rows.size(); ++i) {
    TokenRow& row = list.rows[i];
    const std::size_t next = i + 1 < list.rows.size() ? list.rows[i + 1].type : antlr4::Token::EOF;
    const bool is_first = i == 0 || list.rows[i - 1].line != row.line;
    if (row.type == Bip1Lexer::HEADER && next != Bip1Lexer::LBRACE && next != Bip1Lexer::RAW_OPEN) {
      row.type = Bip1Lexer::ID;
    }
    if (row.type == Bip1Lexer::CLOCK && (!is_first || next != Bip1Lexer::ID)) row.type = Bip1Lexer::ID;
  }
  return list;
}

bool is_flat_bip1(const std::vector<TokenRow>& rows, TokenRow& deep) {
  // Operators of a chain count as if each nested: between two words that begin a construct there are few.
  int brackets = 0, operators = 0, ifs = 0;
  for (const TokenRow& row : rows) {
    switch (row.type) {
      case Bip1Lexer::LPAREN:
      case Bip1Lexer::LBRACK:
      case Bip1Lexer::LBRACE:
      case Bip1Lexer::RAW_OPEN: ++brackets; break;
      case Bip1Lexer::RPAREN:
      case Bip1Lexer::RBRACK:
      case Bip1Lexer::RBRACE:
      case Bip1Lexer::RAW_CLOSE: brackets -= brackets > 0 ? 1 : 0; break;
      case Bip1Lexer::IF:
      case Bip1Lexer::ELSE: ++ifs; break;
      case Bip1Lexer::END: brackets = operators = ifs = 0; break;
      case Bip1Lexer::PRIORITY: operators = ifs = 0; break;
      case Bip1Lexer::ON:
      case Bip1Lexer::DATA:
      case Bip1Lexer::COMPONENT:
      case Bip1Lexer::CONNECTOR:
      case Bip1Lexer::SEMI:
      case Bip1Lexer::PROVIDED: operators = 0; break;
      default:
        if (row.type >= Bip1Lexer::OROR && row.type <= Bip1Lexer::TILDE) ++operators;
    }
    if (brackets + operators + ifs > kMaxBip1Depth) {
      deep = row;
      return false;
    }
  }
  return true;
}

std::optional<syntax::bip1::Model> parse_bip1(const SourceMap& sources, FileId file, Diagnostics& diags) {
  const std::string_view text = sources.text(file);
  TokenList list = read_bip1_tokens(text, 0);
  list.rows = sound_bip1_tokens(list.rows, text, file, diags);
  if (diags.has_errors()) return std::nullopt;
  if (TokenRow deep; !is_flat_bip1(list.rows, deep)) {
    diags.report(Diag::kB0008, SourceRange{file, deep.begin, deep.end}, kMaxBip1Depth);
    return std::nullopt;
  }
  RowStream stream(list.rows, text.size());
  Bip1Parser parser(&stream);
  parser.removeErrorListeners();
  auto* simulator = parser.getInterpreter<antlr4::atn::ParserATNSimulator>();
  Bip1Parser::FileContext* tree = nullptr;
  try {
    simulator->setPredictionMode(antlr4::atn::PredictionMode::SLL);
    parser.setErrorHandler(std::make_shared<antlr4::BailErrorStrategy>());
    tree = parser.file();
  } catch (const antlr4::ParseCancellationException&) {
    parser.reset();
    simulator->setPredictionMode(antlr4::atn::PredictionMode::LL);
    parser.setErrorHandler(std::make_shared<Bip1Strategy>(text, file, diags));
    try {
      tree = parser.file();
    } catch (const antlr4::ParseCancellationException&) {
      return std::nullopt;
    }
  }
  if (diags.has_errors()) return std::nullopt;
  std::vector<syntax::Comment> comments = std::move(list.comments);
  syntax::bip1::Model model = Bip1Converter(text, file, comments).model(tree);
  for (syntax::Comment& comment : comments) comment.range.file = file;
  std::sort(comments.begin(), comments.end(),
            [](const syntax::Comment& a, const syntax::Comment& b) { return a.range.begin < b.range.begin; });
  model.comments = std::move(comments);
  return model;
}

}  // namespace bip::parse
