// The language reference, grammar/README.md, is whole: each rule of the parser is named in a section, on a line that
// begins with `Grammar:`, and an example of that section uses it. Each token occurs in some example. That the examples
// are sound is for tests/meta/test_snippets.py to check.
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "BipLexer.h"
#include "BipParser.h"
#include "antlr4-runtime.h"
#include "compiler/parse/row_stream.hpp"
#include "compiler/parse/token_list.hpp"

// After the grammar, whose accessors are called like its macros.
#include <catch2/catch.hpp>

using namespace bip;

namespace {

struct Section {
  std::string title;
  std::set<std::string> named;               // on its `Grammar:` line
  std::vector<std::string> examples, roots;  // ```bip fences; what --root says in its commands
};

bool is_rule_char(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// The words in backticks.
std::set<std::string> words_of(const std::string& line) {
  std::set<std::string> words;
  for (std::size_t open = line.find('`'); open != std::string::npos; open = line.find('`', open + 1)) {
    const std::size_t close = line.find('`', open + 1);
    if (close == std::string::npos) break;
    words.insert(line.substr(open + 1, close - open - 1));
    open = close;
  }
  return words;
}

std::vector<Section> sections_of(std::istream& in) {
  std::vector<Section> sections(1);
  std::string line, fence, info;
  bool is_open = false;
  while (std::getline(in, line)) {
    if (line.starts_with("```")) {
      // An example that must fail uses the grammar, too; one that is no whole file could not be parsed.
      if (is_open && (info == "bip" || info == "bip fail")) sections.back().examples.push_back(fence);
      is_open = !is_open;
      info = is_open ? line.substr(3) : "";
      fence.clear();
    } else if (is_open) {
      fence += line + "\n";
      if (const std::size_t at = line.find("--root '"); at != std::string::npos)
        sections.back().roots.push_back(line.substr(at + 8, line.find('\'', at + 8) - at - 8));
    } else if (line.starts_with("#")) {
      sections.push_back({.title = line, .named = {}, .examples = {}, .roots = {}});
    } else if (line.starts_with("Grammar:")) {
      sections.back().named.merge(words_of(line));
    }
  }
  return sections;
}

/// Names of all rules in the tree of a text, and of all its tokens.
void collect(const std::string& text, bool is_root, std::set<std::string>& rules, std::set<std::string>& tokens) {
  SourceMap sources;
  Diagnostics diags;
  const FileId file = sources.add("example", text);
  const parse::TokenList list = parse::read_tokens(sources, file, diags);
  parse::RowStream stream(list.rows, text.size());
  antlr::BipParser parser(&stream);
  parser.removeErrorListeners();
  antlr4::tree::ParseTree* tree = is_root ? static_cast<antlr4::tree::ParseTree*>(parser.rootSpec()) : parser.file();
  INFO(text);
  REQUIRE(parser.getNumberOfSyntaxErrors() == 0);
  std::vector<antlr4::tree::ParseTree*> open{tree};
  while (!open.empty()) {
    antlr4::tree::ParseTree* node = open.back();
    open.pop_back();
    if (antlr4::tree::TerminalNode* leaf = antlr::TreeNode::as_leaf(node)) {
      tokens.insert(std::string(parser.getVocabulary().getSymbolicName(leaf->getSymbol()->getType())));
      continue;
    }
    rules.insert(parser.getRuleNames()[static_cast<antlr4::ParserRuleContext*>(node)->getRuleIndex()]);
    open.insert(open.end(), node->children.begin(), node->children.end());
  }
}

}  // namespace

TEST_CASE("the reference names each rule where an example uses it, and shows each token") {
  const std::filesystem::path root = BIP_TEST_SOURCE_DIR;
  std::ifstream in(root / "grammar" / "README.md");
  REQUIRE(in);
  std::set<std::string> covered, named, tokens;
  for (const Section& section : sections_of(in)) {
    std::set<std::string> used;
    for (const std::string& example : section.examples) collect(example, false, used, tokens);
    for (const std::string& spec : section.roots) collect(spec, true, used, tokens);
    for (const std::string& rule : section.named) {
      INFO(section.title);
      if (!is_rule_char(rule.front())) continue;
      named.insert(rule);
      CHECK((rule + (used.contains(rule) ? "" : " is used by no example here")) == rule);
      if (used.contains(rule)) covered.insert(rule);
    }
  }
  SourceMap sources;
  const std::vector<parse::TokenRow> none;
  parse::RowStream stream({{antlr4::Token::EOF, 0, 0, 1}}, 0);
  antlr::BipParser parser(&stream);
  const std::set<std::string> rules(parser.getRuleNames().begin(), parser.getRuleNames().end());
  CHECK(rules.size() > 60);
  for (const std::string& rule : rules)
    CHECK((rule + (covered.contains(rule) ? "" : " is not covered by grammar/README.md")) == rule);
  for (const std::string& rule : named)
    CHECK((rule + (rules.contains(rule) ? "" : " is no rule of the grammar")) == rule);
  // Those that only the pass over the token list sees.
  const std::set<std::string> unseen{"DASHED",        "INT_RANGE",        "UNCLOSED_STRING", "LINE_COMMENT",
                                     "BLOCK_COMMENT", "UNCLOSED_COMMENT", "SPACE",           "STRAY"};
  const antlr4::dfa::Vocabulary& vocabulary = parser.getVocabulary();
  for (std::size_t type = 1; type <= vocabulary.getMaxTokenType(); ++type) {
    const std::string name = vocabulary.getSymbolicName(type);
    const bool is_shown = unseen.contains(name) || tokens.contains(name);
    CHECK((name + (is_shown ? "" : " is in no example of grammar/README.md")) == name);
  }
}
