// Enforces the depth limit on tokens. ANTLR's parser, the conversion and every later stage recurse over nested
// expressions and statements, so input that is too deep must be refused before any of them starts. One pass.
#include "BipLexer.h"
#include "antlr4-runtime.h"
#include "compiler/parse/parse.hpp"
#include "compiler/parse/token_list.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {

using antlr::BipLexer;

bool check_depth(const std::vector<TokenRow>& rows, FileId file, Diagnostics& diags) {
  // Unary operators before each open bracket count too: `-(-(-(x` nests by both.
  std::vector<int> runs_outside;
  int brackets = 0;
  int run = 0;
  int runs = 0;
  int ifs = 0;
  int fors = 0;
  for (const TokenRow& row : rows) {
    switch (row.type) {
      case BipLexer::LPAREN:
      case BipLexer::LBRACK:
      case BipLexer::GROUP_OPEN:
      case BipLexer::LBRACE:
        ++brackets;
        runs += run;
        runs_outside.push_back(run);
        run = 0;
        break;
      case BipLexer::RPAREN:
      case BipLexer::RBRACK:
      case BipLexer::RBRACE:
        if (brackets > 0) {
          --brackets;
          runs -= runs_outside.back();
          runs_outside.pop_back();
        }
        run = 0;
        break;
      case BipLexer::MINUS:
      case BipLexer::PLUS:
      case BipLexer::TILDE:
      case BipLexer::BANG:
      case BipLexer::NOT_WORD: ++run; break;
      case BipLexer::IF:
        ++ifs;
        run = 0;
        break;
      case BipLexer::FI:
        if (ifs > 0) --ifs;
        run = 0;
        break;
      case BipLexer::FOR:
        ++fors;
        run = 0;
        break;
      case BipLexer::END:
        // Ends every expression and block, however broken: what was left open before must not add up.
        brackets = runs = run = ifs = fors = 0;
        runs_outside.clear();
        break;
      case BipLexer::CONNECTOR:
      case BipLexer::COMPONENT:
        fors = 0;
        run = 0;
        break;
      default: run = 0;
    }
    BIP_ASSERT(static_cast<std::size_t>(brackets) == runs_outside.size() && runs >= 0,
               "{} brackets are open, with {} runs", brackets, runs_outside.size());
    if (brackets + runs + run + ifs + fors > kMaxDepth) {
      diags.report(Diag::kB0008, SourceRange{file, row.begin, row.end}, kMaxDepth)
          .help("name a part of it in a variable or a function of its own");
      return false;
    }
  }
  return true;
}

}  // namespace bip::parse
