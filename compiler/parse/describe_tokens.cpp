// See describe_tokens.hpp. These tables replace all phrases of the parser generator.
#include "compiler/parse/describe_tokens.hpp"

#include <algorithm>

#include "BipParser.h"
#include "compiler/syntax/ops.def"

namespace bip::parse {
namespace {

using antlr::BipParser;
using antlr4::misc::IntervalSet;

struct Spelling {
  std::size_t type;
  std::string_view text;
};
// Binary operators come from ops.def; rows above them fix the order.
#define BIP_OP_SPELLING(name, family, text, word, symbol, precedence, operands, result, function, promela, token) \
  {BipParser::token, symbol},
constexpr Spelling kSpellings[] = {
    {BipParser::FROM, "from"},
    {BipParser::TO, "to"},
    {BipParser::PROVIDED, "provided"},
    {BipParser::DO, "do"},
    {BipParser::UP, "up"},
    {BipParser::DOWN, "down"},
    {BipParser::THEN, "then"},
    {BipParser::ELSE, "else"},
    {BipParser::ELSE_CHAIN, "else"},
    {BipParser::FI, "fi"},
    {BipParser::DEFINE, "define"},
    {BipParser::TYPE, "type"},
    {BipParser::DATA, "data"},
    {BipParser::PORT, "port"},
    {BipParser::PORT_DECL, "port"},
    {BipParser::CONNECTOR, "connector"},
    {BipParser::CONNECTOR_DECL, "connector"},
    {BipParser::ATOM, "atom"},
    {BipParser::COMPOUND, "compound"},
    {BipParser::COMPONENT, "component"},
    {BipParser::COMPONENT_DECL, "component"},
    {BipParser::EXTERN, "extern"},
    {BipParser::EXTERN_DECL, "extern"},
    {BipParser::FUNCTION, "function"},
    {BipParser::OPERATOR, "operator"},
    {BipParser::REFINE, "refine"},
    {BipParser::CONST, "const"},
    {BipParser::EXPORT, "export"},
    {BipParser::ON, "on"},
    {BipParser::INTERNAL, "internal"},
    {BipParser::PLACE, "place"},
    {BipParser::INITIAL, "initial"},
    {BipParser::PRIORITY, "priority"},
    {BipParser::FINAL, "final"},
    {BipParser::INVARIANT, "invariant"},
    {BipParser::CLOCK, "clock"},
    {BipParser::UNIT, "unit"},
    {BipParser::AT, "at"},
    {BipParser::LAZY, "lazy"},
    {BipParser::DELAYABLE, "delayable"},
    {BipParser::EAGER, "eager"},
    {BipParser::RESUME, "resume"},
    {BipParser::RESET, "reset"},
    {BipParser::REMEMBER, "remember"},
    {BipParser::IGNORE, "ignore"},
    {BipParser::ERROR, "error"},
    {BipParser::BEHAVIOR, "behavior"},
    {BipParser::STATE, "state"},
    {BipParser::CONTAINS, "contains"},
    {BipParser::FOR, "for"},
    {BipParser::PROPERTY, "property"},
    {BipParser::PROPERTY_TEXT, "{ … }"},
    {BipParser::IN, "in"},
    {BipParser::IF, "if"},
    {BipParser::PACKAGE, "package"},
    {BipParser::USE, "use"},
    {BipParser::AS, "as"},
    {BipParser::END, "end"},
    {BipParser::TRUE, "true"},
    {BipParser::FALSE, "false"},
    {BipParser::AND_WORD, "and"},
    {BipParser::OR_WORD, "or"},
    {BipParser::NOT_WORD, "not"},
    {BipParser::LPAREN, "("},
    {BipParser::RPAREN, ")"},
    {BipParser::LBRACK, "["},
    {BipParser::GROUP_OPEN, "["},
    {BipParser::RBRACK, "]"},
    {BipParser::LBRACE, "{"},
    {BipParser::RBRACE, "}"},
    {BipParser::SEMI, ";"},
    {BipParser::ASSIGN, "="},
    {BipParser::ARROW, "<-"},
    {BipParser::LT, "<"},
    {BipParser::COLON, ":"},
    {BipParser::DOTDOT, ".."},
    {BipParser::COMMA, ","},
    {BipParser::ELLIPSIS, "\u2026"},
    {BipParser::AT_SIGN, "@"},
    {BipParser::STAR, "*"},
    {BipParser::PRIME, "'"},
    {BipParser::DOT, "."},
    {BipParser::GT, ">"},
    {BipParser::LE, "<="},
    {BipParser::GE, ">="},
    {BipParser::EQ, "=="},
    {BipParser::NE, "!="},
    BIP_BINARY_OPS(BIP_OP_SPELLING)  //
    {BipParser::BANG, "!"},
    {BipParser::TILDE, "~"},
};
#undef BIP_OP_SPELLING

constexpr std::size_t kLateWords[] = {
    BipParser::CLOCK,     BipParser::UNIT,     BipParser::INVARIANT, BipParser::AT,       BipParser::LAZY,
    BipParser::DELAYABLE, BipParser::EAGER,    BipParser::RESUME,    BipParser::REMEMBER, BipParser::IGNORE,
    BipParser::ERROR,     BipParser::AND_WORD, BipParser::OR_WORD,   BipParser::FINAL};
#define BIP_OP_TOKEN_ITEM(name, family, text, word, symbol, precedence, operands, result, function, promela, token) \
  BipParser::token,
constexpr std::size_t kBinarySigns[] = {BIP_BINARY_OPS(BIP_OP_TOKEN_ITEM) BipParser::ASSIGN, BipParser::AND_WORD,
                                        BipParser::OR_WORD};
#undef BIP_OP_TOKEN_ITEM
constexpr std::size_t kExprStarts[] = {BipParser::INT,   BipParser::FLOAT,  BipParser::STRING,   BipParser::TRUE,
                                       BipParser::FALSE, BipParser::REPORT, BipParser::MINUS,    BipParser::PLUS,
                                       BipParser::TILDE, BipParser::BANG,   BipParser::NOT_WORD, BipParser::LPAREN,
                                       BipParser::ID};
constexpr std::size_t kItemStarts[] = {
    BipParser::DATA,      BipParser::EXPORT,   BipParser::PORT,     BipParser::EXTERN,    BipParser::CLOCK,
    BipParser::PLACE,     BipParser::INITIAL,  BipParser::ON,       BipParser::INTERNAL,  BipParser::PRIORITY,
    BipParser::INVARIANT, BipParser::BEHAVIOR, BipParser::CONTAINS, BipParser::COMPONENT, BipParser::CONNECTOR,
    BipParser::FOR,       BipParser::AT_SIGN,  BipParser::DEFINE,   BipParser::FINAL,     BipParser::PROPERTY};
constexpr std::size_t kDeclStarts[] = {BipParser::ATOM,      BipParser::COMPOUND,    BipParser::CONNECTOR_DECL,
                                       BipParser::PORT_DECL, BipParser::EXTERN_DECL, BipParser::COMPONENT_DECL,
                                       BipParser::CONST,     BipParser::DATA,        BipParser::FUNCTION,
                                       BipParser::AT_SIGN};
constexpr std::size_t kPostfix[] = {BipParser::SUBSCRIPT, BipParser::LBRACK, BipParser::GROUP_OPEN, BipParser::DOT,
                                    BipParser::PRIME};

template <std::size_t N>
void drop(std::vector<std::size_t>& types, const std::size_t (&set)[N]) {
  std::erase_if(types, [&](std::size_t t) { return std::find(std::begin(set), std::end(set), t) != std::end(set); });
}

std::vector<std::size_t> types_of(const IntervalSet& expected) {
  std::vector<std::size_t> types;
  for (const ssize_t t : expected.toList()) {
    if (t > 0) types.push_back(static_cast<std::size_t>(t));
  }
  return types;
}

bool has(const std::vector<std::size_t>& types, std::size_t type) {
  return std::find(types.begin(), types.end(), type) != types.end();
}

/// What a rule is called inside its owner; empty if it is too small to name.
std::string_view construct(std::size_t rule) {
  switch (rule) {
    case BipParser::RuleTransition: return "a transition";
    case BipParser::RuleClause: return "an `on` clause";
    case BipParser::RulePortDecl: return "a port declaration";
    case BipParser::RuleDataDecl:
    case BipParser::RuleConstData: return "a `data` declaration";
    case BipParser::RuleClockDecl: return "a clock declaration";
    case BipParser::RulePlaces: return "the list of places";
    case BipParser::RuleInitial: return "the `initial` line";
    case BipParser::RuleFinals: return "the `final` line";
    case BipParser::RulePriority: return "a priority";
    case BipParser::RuleInvariant: return "an invariant";
    case BipParser::RuleContains: return "a `contains` line";
    case BipParser::RuleComponentDecl: return "a component line";
    case BipParser::RuleConnectorDecl:
    case BipParser::RuleInlineConnector: return "a connector";
    case BipParser::RuleDefine: return "a `define` line";
    case BipParser::RuleForItems: return "a `for` line";
    case BipParser::RuleCompoundExport:
    case BipParser::RuleConnectorExport: return "an export";
    case BipParser::RuleExternType: return "an extern type";
    case BipParser::RuleExternFunction: return "an extern function";
    case BipParser::RuleExternOperator: return "an extern operator";
    case BipParser::RuleFunctionDecl: return "a function";
    case BipParser::RuleAnnotation: return "an annotation";
    case BipParser::RuleUse: return "a `use` line";
    case BipParser::RuleIfStmt: return "an `if`";
    case BipParser::RuleSimple: return "a statement";
    case BipParser::RuleBlock: return "a block";
    case BipParser::RuleState: return "a state";
    case BipParser::RuleBehavior: return "the behavior";
    default: return {};
  }
}

std::string named(std::string_view what, const antlr4::ParserRuleContext* id, std::string_view text) {
  if (id == nullptr || id->exception != nullptr || id->start == nullptr || id->stop == nullptr)
    return std::string("this ").append(what);
  const std::size_t begin = id->start->getStartIndex();
  const std::size_t end = id->stop != nullptr ? id->stop->getStopIndex() : id->start->getStopIndex();
  return std::string(what).append(" `").append(text.substr(begin, end - begin)).append("`");
}

std::string owner_phrase(const antlr4::RuleContext* context, std::string_view text) {
  auto* any = const_cast<antlr4::RuleContext*>(context);
  switch (context->getRuleIndex()) {
    case BipParser::RuleAtomType: return named("atom type", static_cast<BipParser::AtomTypeContext*>(any)->id(), text);
    case BipParser::RuleCompoundType:
      return named("compound type", static_cast<BipParser::CompoundTypeContext*>(any)->id(), text);
    case BipParser::RuleConnectorType:
      return named("connector type", static_cast<BipParser::ConnectorTypeContext*>(any)->id(), text);
    case BipParser::RulePortType: return named("port type", static_cast<BipParser::PortTypeContext*>(any)->id(), text);
    case BipParser::RuleComponent:
      return named("component", static_cast<BipParser::ComponentContext*>(any)->id(), text);
    case BipParser::RulePackage: return named("package", static_cast<BipParser::PackageContext*>(any)->path(), text);
    default: return {};
  }
}

const antlr4::RuleContext* parent_of(const antlr4::RuleContext* context) {
  return static_cast<const antlr4::RuleContext*>(context->parent);
}

}  // namespace

std::string_view spelling(std::size_t type) {
  for (const Spelling& s : kSpellings) {
    if (s.type == type) return s.text;
  }
  return {};
}

std::string describe_token_type(std::size_t type) {
  switch (type) {
    case antlr4::Token::EOF: return "end of file";
    case BipParser::ID: return "a name";
    case BipParser::INT:
    case BipParser::FLOAT: return "a number";
    case BipParser::STRING: return "a string";
    case BipParser::NATIVE: return "a native type";
    case BipParser::REPORT: return "a report";
    default: break;
  }
  const std::string_view s = spelling(type);
  return s.empty() ? "another word" : std::string("`").append(s).append("`");
}

std::vector<std::string> words_of(const IntervalSet& expected) {
  std::vector<std::string> words;
  for (const std::size_t t : types_of(expected)) {
    const std::string_view s = spelling(t);
    if (s.size() > 1 && s.front() >= 'a' && s.front() <= 'z') words.emplace_back(s);
  }
  return words;
}

std::string describe_expected(const IntervalSet& expected) {
  std::vector<std::size_t> types = types_of(expected);
  std::vector<std::string> words;
  const bool end_of_file = expected.contains(static_cast<ssize_t>(antlr4::Token::EOF));
  if (has(types, BipParser::ID) && has(types, BipParser::INT)) {
    words.emplace_back("an expression");
    drop(types, kExprStarts);
    drop(types, kLateWords);
  } else if (has(types, BipParser::ID)) {
    words.emplace_back(has(types, BipParser::NATIVE) ? "a type" : "a name");
    drop(types, kLateWords);
    std::erase_if(types, [](std::size_t t) { return t == BipParser::ID || t == BipParser::NATIVE; });
  }
  // The `<` of a `<-` that is written apart.
  if (has(types, BipParser::ARROW)) std::erase(types, BipParser::LT);
  const bool operators = has(types, BipParser::SLASH) && has(types, BipParser::PIPE);
  if (operators) drop(types, kBinarySigns);
  const bool items = has(types, BipParser::ON) && has(types, BipParser::DATA) && has(types, BipParser::EXPORT);
  const bool declarations = has(types, BipParser::ATOM) && has(types, BipParser::COMPOUND);
  if (items) drop(types, kItemStarts);
  if (declarations) drop(types, kDeclStarts);
  std::vector<std::size_t> without_postfix = types;
  drop(without_postfix, kPostfix);
  if (!without_postfix.empty() || items || declarations || operators) types = without_postfix;
  // The table is in the order of what a reader most likely left out.
  for (const Spelling& s : kSpellings) {
    const std::string quoted = std::string("`").append(s.text).append("`");
    if (has(types, s.type) && std::find(words.begin(), words.end(), quoted) == words.end()) words.push_back(quoted);
    std::erase(types, s.type);
  }
  for (const std::size_t t : types) {
    std::string word = describe_token_type(t);
    if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(std::move(word));
  }
  if (operators) words.emplace_back("an operator");
  if (items) words.emplace_back("another item");
  if (declarations) words.emplace_back("a declaration");
  if (end_of_file) words.emplace_back("end of file");
  if (words.size() > 5) {
    words.resize(4);
    words.emplace_back("another continuation");
  }
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) out += i + 1 == words.size() ? " or " : ", ";
    out += words[i];
  }
  return out.empty() ? "something else" : out;
}

Owner find_owner(const antlr4::RuleContext* context, std::string_view text) {
  for (; context != nullptr; context = parent_of(context)) {
    const auto* rule = static_cast<const antlr4::ParserRuleContext*>(context);
    if (context->getRuleIndex() == BipParser::RuleBehavior) return {"this `behavior`", rule->start};
    std::string phrase = owner_phrase(context, text);
    if (!phrase.empty()) return {std::move(phrase), rule->start};
  }
  return {};
}

Owner find_closed_by(const antlr4::RuleContext* context, const antlr4::Token* last, std::string_view text) {
  Owner found;
  while (context != nullptr && !context->children.empty()) {
    const auto* rule = dynamic_cast<const antlr4::ParserRuleContext*>(context->children.back());
    if (rule == nullptr || rule->stop != last) break;
    if (Owner owner = find_owner(rule, text); owner.opener == rule->start) found = std::move(owner);
    context = rule;
  }
  return found;
}

std::string describe_place(const antlr4::RuleContext* context, std::string_view text) {
  std::string_view inner;
  for (; context != nullptr; context = parent_of(context)) {
    if (inner.empty()) inner = construct(context->getRuleIndex());
    const std::string owner = owner_phrase(context, text);
    if (owner.empty()) continue;
    if (inner.empty()) return " in " + owner;
    return std::string(" in ")
        .append(inner)
        .append(context->getRuleIndex() == BipParser::RulePackage ? " in " : " of ")
        .append(owner);
  }
  return inner.empty() ? std::string() : std::string(" in ").append(inner);
}

}  // namespace bip::parse
