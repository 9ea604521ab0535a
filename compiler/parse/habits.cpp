// See habits.hpp. A pattern is matched forward from each of the sixteen tokens before the one that was found; the table
// has some ninety rows, so the cost is a few thousand comparisons for each reported error.
#include "compiler/parse/habits.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "BipParser.h"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {
namespace {

using antlr::BipParser;
using antlr4::Token;

/// Where a row applies, by the rules that are open at the word that was found.
enum class Where : std::uint8_t {
  Anywhere,
  Statement,
  Transition,
  Clause,
  Define,
  Priority,
  Port,
  Params,
  Behavior,
  Atom,
  Compound,
  Paper,
  Package
};

/// `pattern`: words of the source, and
///   N a name, P a path, T a native type, I a whole number, F a fraction, S a string, E an expression, O operands of a
///   priority, B what stands between braces, R the rest of the line; these are $1, $2, ... of `with`.
///   @ stands before the word that was found (at the end: it follows), / allows a new line, $ is the end of a line.
/// `with`: `$(1)` adds parentheses if there are several words, `$l1` is in lower case, `$=` assigns. Empty: no edit;
/// "-": what matches is left out.
struct Row {
  Where where;
  std::string_view pattern;
  std::string_view with;
  std::string_view note;
};

constexpr std::string_view kAssigns = "an action assigns, as in `n = n + 1`";
constexpr std::string_view kThen = "an `if` is written `if (…) then … else … fi`";
constexpr std::string_view kTransition = "a transition is written `on PORT from PLACE to PLACE provided (…) do { … }`";
constexpr std::string_view kNoDirection = "ports have no direction: connectors say what happens together";
constexpr std::string_view kEndAlone = "`end` stands alone";
constexpr std::string_view kNoBraces = "what belongs to a declaration goes to its `end`, without braces";
constexpr std::string_view kData = "data are declared by `data TYPE NAME`";
constexpr std::string_view kInstance = "a component is declared by `component TYPE NAME(ARGUMENTS)`";
constexpr std::string_view kDefine = "`define` lists ports; `'` behind a port makes it a trigger";
constexpr std::string_view kPriority = "a priority is written `priority NAME LOWER < HIGHER`";
constexpr std::string_view kParam = "a parameter is written `TYPE NAME`";
constexpr std::string_view kTypes =
    "a package holds types: `atom type`, `compound type`, `connector type`, `port type`";
constexpr std::string_view kUnit = "a bound counts in the unit of its clock, which `clock NAME unit millisecond` gives";
constexpr std::string_view kInvariant = "an invariant is written `invariant NAME at PLACE provided (…)`";
constexpr std::string_view kLoop = "an action has no loops: an `internal` transition with a guard repeats";
constexpr std::string_view kProperty = "a property is written `property NAME { never … }`";
constexpr std::string_view kPlaces = "places are declared by `place NAME, NAME`";

constexpr Row kRows[] = {
    // ---- actions, from C and Python
    {Where::Statement, "P @ ++", "$1 $= $1 + 1", kAssigns},
    {Where::Statement, "P @ --", "$1 $= $1 - 1", kAssigns},
    {Where::Statement, "@ ++ P", "$1 $= $1 + 1", kAssigns},
    {Where::Statement, "@ -- P", "$1 $= $1 - 1", kAssigns},
    {Where::Statement, "P @ += E", "$1 $= $1 + $(2)", kAssigns},
    {Where::Statement, "P @ -= E", "$1 $= $1 - $(2)", kAssigns},
    {Where::Statement, "P @ *= E", "$1 $= $1 * $(2)", kAssigns},
    {Where::Statement, "P @ /= E", "$1 $= $1 / $(2)", kAssigns},
    {Where::Statement, "P @ %= E", "$1 $= $1 % $(2)", kAssigns},
    {Where::Statement, "P @ |= E", "$1 $= $1 | $(2)", kAssigns},
    {Where::Statement, "P @ &= E", "$1 $= $1 & $(2)", kAssigns},
    {Where::Statement, "P @ == E", "$1 $= $2", "`==` compares, and an action assigns"},
    {Where::Statement, "P @ -> P", "$2 $= $1", "the target of an assignment stands on the left"},
    {Where::Statement, "P @ : = E", "$1 := $2", "`:=` is one word"},
    {Where::Statement, "P @ + I -> P", "$3 $= $1 + $2", "the target of an assignment stands on the left"},
    {Where::Statement, "@ T N = E", "$2 = $3", "an action has no variables of its own: declare `data` of the atom"},
    {Where::Statement, "@ T N", "", "an action has no variables of its own: declare `data` of the atom"},
    {Where::Statement, "return @ E", "", "an action returns nothing: it assigns data, which ports show"},
    {Where::Statement, "while ( E ) @ {", "", kLoop},
    {Where::Statement, "for ( N = E @ ;", "", kLoop},
    {Where::Statement, "if ( E ) @ {B} / else {B}", "if ($1) then$2else$3fi", kThen},
    {Where::Statement, "if ( E ) @ {B}", "if ($1) then$2fi", kThen},
    {Where::Statement, "else @ {B} / fi", "else$1fi", kThen},
    {Where::Statement, "if ( E ) / @ P", "if ($1) then $2", kThen},
    {Where::Statement, "if @ E then", "if ($1) then", kThen},
    {Where::Statement, "elif ( E ) @ then", "else if ($1) then", kThen},
    {Where::Statement, "elsif ( E ) @ then", "else if ($1) then", kThen},
    {Where::Statement, "elseif ( E ) @ then", "else if ($1) then", kThen},
    // ---- expressions
    {Where::Anywhere, "< @ >", "!=", "`!=` compares"},
    {Where::Statement, "= @ >", ">=", "`>=` compares"},
    {Where::Transition, "= @ >", ">=", "`>=` compares"},
    {Where::Anywhere, "= @ <", "<=", "`<=` compares"},
    {Where::Anywhere, "@ ' N '", "\"$1\"", "strings are in double quotes"},
    {Where::Anywhere, "I @ ms", "$1", kUnit},
    {Where::Anywhere, "I @ s", "$1", kUnit},
    {Where::Anywhere, "I @ us", "$1", kUnit},
    {Where::Anywhere, "I @ ns", "$1", kUnit},
    // ---- `on` clauses and `define` of connectors
    {Where::Clause, "down @ E ;", "down { $1; }", "a transfer is a block: `down { … }`"},
    {Where::Clause, "up @ E ;", "up { $1; }", "a transfer is a block: `up { … }`"},
    {Where::Clause, "@ {", "down {", "`down { … }` moves values when the interaction happens"},
    {Where::Define, "define @ =", "define", kDefine},
    {Where::Define, "@ &", "-", kDefine},
    {Where::Define, "@ +", "-", kDefine},
    {Where::Define, "@ |", "-", kDefine},
    {Where::Define, "@ ' N", "$1'", kDefine},
    {Where::Define, "N @ !", "$1'", kDefine},
    // ---- transitions, from UPPAAL and others
    {Where::Transition, "@ N -> N", "from $1 to $2", kTransition},
    {Where::Transition, "from N @ -> N", "from $1 to $2", kTransition},
    {Where::Transition, "on N @ -> N", "on $1 to $2", kTransition},
    {Where::Transition, "from N @ goto N", "from $1 to $2", kTransition},
    {Where::Transition, "on N @ goto N", "on $1 to $2", kTransition},
    {Where::Transition, "on N @ !", "on $1", kNoDirection},
    {Where::Transition, "@ {", "do {", "an action begins with `do`"},
    {Where::Transition, "@ when ( E )", "provided ($1)", "a guard begins with `provided`"},
    {Where::Transition, "@ when E", "provided ($1)", "a guard begins with `provided`"},
    {Where::Transition, "@ if ( E )", "provided ($1)", "a guard begins with `provided`"},
    {Where::Transition, "@ if E", "provided ($1)", "a guard begins with `provided`"},
    {Where::Transition, "@ guard ( E )", "provided ($1)", "a guard begins with `provided`"},
    {Where::Transition, "@ guard E", "provided ($1)", "a guard begins with `provided`"},
    {Where::Transition, "@ urgent", "eager", "urgency is `lazy`, `delayable` or `eager`"},
    {Where::Transition, "@ P <- E", "do $1 <- $2", "an action begins with `do`"},
    {Where::Transition, "@ P := E", "do $1 := $2", "an action begins with `do`"},
    {Where::Transition, "@ P = E", "do $1 = $2", "an action begins with `do`"},
    {Where::Atom, "@ from N to N on N", "on $3 from $1 to $2", kTransition},
    {Where::Atom, "@ transition N from", "on $1 from", kTransition},
    {Where::Atom, "@ trans N from", "on $1 from", kTransition},
    {Where::Atom, "@ N -> N", "", kTransition},
    {Where::Atom, "state N @ {", "state $1", kNoBraces},
    {Where::Atom, "state N @ :", "state $1", "the transitions of a state follow its name"},
    // ---- priorities
    {Where::Priority, "priority N O @ > O", "priority $1 $3 < $2", kPriority},
    {Where::Priority, "priority N @ < O", "priority order $1 < $2", kPriority},
    {Where::Priority, "priority N @ : O < O", "priority order $1:$2 < $3", kPriority},
    {Where::Priority, "< @ <", "<", kPriority},
    {Where::Priority, "@ <=", "<", kPriority},
    // ---- properties
    {Where::Compound, "@ property N never R", "property $1 { never $2 }", kProperty},
    {Where::Compound, "@ property N always R", "property $1 { always $2 }", kProperty},
    {Where::Compound, "@ property N eventually R", "property $1 { eventually $2 }", kProperty},
    {Where::Compound, "@ property N : R", "property $1 { $2 }", kProperty},
    {Where::Compound, "@ property N = R", "property $1 { $2 }", kProperty},
    {Where::Compound, "@ property N", "", kProperty},
    // ---- ports, parameters
    {Where::Port, "@ T N", "$2", "a port names the data that it shows; its port type has their types"},
    {Where::Params, "N @ : T", "$2 $1", kParam},
    {Where::Params, "N @ : N", "$2 $1", kParam},
    {Where::Params, "N @ )", "", kParam},
    {Where::Params, "N @ ,", "", kParam},
    // ---- data, places and clocks
    {Where::Anywhere, "atom type N / @", "atom type $1()", "a type has parentheses, for its parameters"},
    {Where::Anywhere, "compound type N / @", "compound type $1()", "a type has parentheses, for its parameters"},
    {Where::Anywhere, "port type N / @", "port type $1()", "a type has parentheses, for its parameters"},
    {Where::Package, "const @ T N", "const data $1 $2", "a constant is declared by `const data TYPE NAME = VALUE`"},
    {Where::Anywhere, "data N @ : T", "data $2 $1", kData},
    {Where::Anywhere, "data N @ = I", "data int $1 = $2", kData},
    {Where::Anywhere, "data N @ = F", "data float $1 = $2", kData},
    {Where::Anywhere, "data N @ = S", "data string $1 = $2", kData},
    {Where::Anywhere, "data N @ = true", "data bool $1 = true", kData},
    {Where::Anywhere, "data N @ = false", "data bool $1 = false", kData},
    {Where::Anywhere, "data T @ [", "", "a type has no range of values: an `invariant` bounds data"},
    {Where::Anywhere, "data T N @ [", "", "data are no arrays; components and connectors may be: `component T t[3]()`"},
    {Where::Atom, "clock N @ = I", "clock $1", "every clock begins at 0"},
    {Where::Atom, "invariant P @ <= E", "invariant bound provided ($1 <= $2)", kInvariant},
    {Where::Atom, "invariant P @ < E", "invariant bound provided ($1 < $2)", kInvariant},
    {Where::Atom, "invariant P @ == E", "invariant bound provided ($1 == $2)", kInvariant},
    {Where::Atom, "place R @ {", "", kInvariant},
    {Where::Behavior, "@ place R", "-", "the places of a `behavior` are its states: `state NAME`"},
    {Where::Behavior, "behavior / @ data R", "data $1\n  behavior", "data stand before `behavior`"},
    {Where::Atom, "@ data R", "", "data stand before `behavior`"},
    {Where::Atom, "@ state N ,", "place $1,", kPlaces},
    {Where::Atom, "@ state N $", "place $1", kPlaces},
    {Where::Atom, "@ states N", "place $1", kPlaces},
    {Where::Atom, "@ places N", "place $1", kPlaces},
    {Where::Atom, "@ location N", "place $1", kPlaces},
    {Where::Atom, "@ locations N", "place $1", kPlaces},
    {Where::Atom, "place N @ N", "place $1, $2", kPlaces},
    {Where::Atom, "initial @ N", "initial to $1", "the first place is given by `initial to PLACE`"},
    {Where::Atom, "@ init to N", "initial to $1", "the first place is given by `initial to PLACE`"},
    {Where::Atom, "@ init N", "initial to $1", "the first place is given by `initial to PLACE`"},
    {Where::Atom, "@ T N", "data $1 $2", kData},
    // ---- compounds
    {Where::Compound, "component N @ : N", "component $2 $1", kInstance},
    {Where::Compound, "component N @ (", "component $1 $l1(", kInstance},
    {Where::Compound, "@ N = new N", "component $2 $1", kInstance},
    {Where::Compound, "@ N N (", "component $1 $2(", kInstance},
    {Where::Compound, "@ P -> P", "connector link($1, $2)", "ports are joined by connectors"},
    {Where::Paper, "@ P -> P", "connector link($1, $2)", "ports are joined by connectors"},
    {Where::Compound, "connector N @ = N", "connector $2 $1",
     "a connector is declared by `connector TYPE NAME(PORTS)`"},
    {Where::Compound, "for N in range ( E ) / @", "for $1 in 0..$2", "a range is written `0..3`, without its end"},
    {Where::Compound, "for R", "", "items are repeated by `for i in 0..3 { … }`"},
    // ---- packages and declarations
    {Where::Anywhere, "end @ ;", "end", kEndAlone},
    {Where::Anywhere, "end @ N $", "end", kEndAlone},
    {Where::Anywhere, "@ endatom", "end", kEndAlone},
    {Where::Anywhere, "@ endcompound", "end", kEndAlone},
    {Where::Anywhere, "@ endconnector", "end", kEndAlone},
    {Where::Anywhere, "@ endpackage", "end", kEndAlone},
    {Where::Anywhere, "atom @ N", "atom type $1", kTypes},
    {Where::Anywhere, "compound @ N", "compound type $1", kTypes},
    {Where::Package, "@ connector N (", "connector type $1(", kTypes},
    {Where::Package, "@ port N (", "port type $1(", kTypes},
    {Where::Package, "@ main compound", "compound",
     "the root is the compound type that nothing instantiates, or `--root`"},
    {Where::Package, "@ import P", "use $1", "packages are used by `use NAME`, first in the package"},
    {Where::Package, "@ include P", "use $1", "packages are used by `use NAME`, first in the package"},
    {Where::Package, "@ use P", "", "`use` lines come first in a package"},
    {Where::Anywhere, "package P @ {", "package $1", kNoBraces},
    {Where::Anywhere, "@ ; $", "-", "a declaration ends without `;`"},
    {Where::Package, "@ {", "-", kNoBraces},
    {Where::Atom, "@ {", "-", kNoBraces},
    {Where::Compound, "@ {", "-", kNoBraces},
};

char to_lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

struct Chain {
  [[nodiscard]] bool is_in(Where where) const {
    return where == Where::Anywhere || in[static_cast<std::size_t>(where)];
  }
  void add(Where where) { in[static_cast<std::size_t>(where)] = true; }
  std::array<bool, 16> in{};
};

/// In the paper's notation the parser stops at a state or a clause: the words before say what it was reading.
void add_part(antlr4::TokenStream& tokens, const Token& found, Chain& chain) {
  for (std::size_t i = found.getTokenIndex(); i-- > 0 && tokens.get(i)->getLine() == found.getLine();) {
    switch (tokens.get(i)->getType()) {
      case BipParser::DO: return chain.add(Where::Statement);
      case BipParser::ON:
      case BipParser::INTERNAL:
      case BipParser::FROM:
      case BipParser::TO:
      case BipParser::PROVIDED: return chain.add(Where::Transition);
      default: break;
    }
  }
}

Chain read_chain(antlr4::TokenStream& tokens, const Token& found, const antlr4::RuleContext* context) {
  Chain chain;
  bool is_in_type = false;
  for (; context != nullptr; context = static_cast<const antlr4::RuleContext*>(context->parent)) {
    switch (context->getRuleIndex()) {
      case BipParser::RuleStmts:
      case BipParser::RuleBlock:
      case BipParser::RuleSimple:
      case BipParser::RuleAction: chain.add(Where::Statement); break;
      case BipParser::RuleState: add_part(tokens, found, chain); break;
      case BipParser::RuleTransition: chain.add(Where::Transition); break;
      case BipParser::RuleClause: chain.add(Where::Clause); break;
      case BipParser::RuleDefine: chain.add(Where::Define); break;
      case BipParser::RulePriority: chain.add(Where::Priority); break;
      case BipParser::RulePortDecl: chain.add(Where::Port); break;
      case BipParser::RuleParam:
      case BipParser::RuleParams: chain.add(Where::Params); break;
      case BipParser::RuleBehavior: chain.add(Where::Behavior); break;
      case BipParser::RuleAtomType:
        chain.add(Where::Atom);
        is_in_type = true;
        break;
      case BipParser::RuleCompoundType:
        chain.add(Where::Compound);
        is_in_type = true;
        break;
      case BipParser::RuleComponent:
        chain.add(Where::Atom);
        chain.add(Where::Paper);
        is_in_type = true;
        break;
      case BipParser::RuleConnectorType: is_in_type = true; break;
      case BipParser::RulePackage:
      case BipParser::RuleFile:
        if (!is_in_type) chain.add(Where::Package);
        break;
      default: break;
    }
  }
  return chain;
}

bool is_late_name(std::size_t type) {
  switch (type) {
    case BipParser::ID:
    case BipParser::CLOCK:
    case BipParser::UNIT:
    case BipParser::AT:
    case BipParser::FINAL:
    case BipParser::ERROR: return true;
    default: return false;
  }
}

/// Words that end an expression.
bool ends_expression(std::size_t type) {
  switch (type) {
    case antlr4::Token::EOF:
    case BipParser::SEMI:
    case BipParser::LBRACE:
    case BipParser::RBRACE:
    case BipParser::DO:
    case BipParser::TO:
    case BipParser::FROM:
    case BipParser::PROVIDED:
    case BipParser::THEN:
    case BipParser::ELSE:
    case BipParser::ELSE_CHAIN:
    case BipParser::FI:
    case BipParser::END:
    case BipParser::ON: return true;
    default: return false;
  }
}

class Matcher {
 public:
  Matcher(antlr4::TokenStream& tokens, std::string_view text, std::size_t found)
      : tokens_(tokens), text_(text), found_(found) {}

  /// Whether the pattern fits at token `start`; then `captures` and the range are set.
  bool matches(std::string_view pattern, std::size_t start) {
    captures.clear();
    at_ = start;
    bool has_mark = false, line_may_end = true;
    while (!pattern.empty()) {
      const std::size_t blank = std::min(pattern.find(' '), pattern.size());
      const std::string_view element = pattern.substr(0, blank);
      pattern.remove_prefix(std::min(blank + 1, pattern.size()));
      if (element == "@") {
        if (at_ != found_) return false;
        has_mark = true;
      } else if (element == "/") {
        line_may_end = true;
      } else if (element == "$") {
        if (type(at_) != Token::EOF && !begins_line(at_)) return false;
      } else {
        if (!line_may_end && begins_line(at_)) return false;
        line_may_end = false;
        if (!element_matches(element)) return false;
      }
    }
    if (at_ == start || (!has_mark && !(start <= found_ && found_ <= at_))) return false;
    begin = begin_of(start);
    end = end_of(at_ - 1);
    return true;
  }

  struct Capture {
    std::string text;
    std::size_t words = 1;
  };
  std::vector<Capture> captures;
  std::size_t begin = 0, end = 0;

 private:
  [[nodiscard]] std::size_t type(std::size_t i) const {
    return i < tokens_.size() ? tokens_.get(i)->getType() : Token::EOF;
  }
  [[nodiscard]] std::size_t begin_of(std::size_t i) const { return tokens_.get(i)->getStartIndex(); }
  // Rows of tokens store the end, not the last byte.
  [[nodiscard]] std::size_t end_of(std::size_t i) const { return tokens_.get(i)->getStopIndex(); }
  [[nodiscard]] bool begins_line(std::size_t i) const {
    return i == 0 || type(i) == Token::EOF || tokens_.get(i)->getLine() != tokens_.get(i - 1)->getLine();
  }
  bool capture(std::size_t first) {
    if (at_ == first) return false;
    captures.push_back({std::string(text_.substr(begin_of(first), end_of(at_ - 1) - begin_of(first))), at_ - first});
    return true;
  }
  bool take(std::size_t first, bool fits) {
    if (!fits) return false;
    ++at_;
    return capture(first);
  }

  bool element_matches(std::string_view element) {
    const std::size_t first = at_;
    if (element == "N") return take(first, is_late_name(type(at_)));
    if (element == "T") return take(first, type(at_) == BipParser::NATIVE);
    if (element == "I") return take(first, type(at_) == BipParser::INT);
    if (element == "F") return take(first, type(at_) == BipParser::FLOAT);
    if (element == "S") return take(first, type(at_) == BipParser::STRING);
    if (element == "P") return path_matches(first);
    if (element == "E") return expression_matches(first);
    if (element == "{B}") return block_matches();
    if (element == "O") {
      while (type(at_) != BipParser::LT && type(at_) != BipParser::GT && type(at_) != BipParser::PROVIDED &&
             !begins_line(at_) && type(at_) != Token::EOF)
        ++at_;
      return capture(first);
    }
    if (element == "R") {
      while (at_ == first || (!begins_line(at_) && at_ != found_)) {
        if (type(at_) == Token::EOF) return false;
        ++at_;
      }
      return capture(first);
    }
    return words_match(element);
  }

  /// Tokens that touch each other and together spell `word`.
  bool words_match(std::string_view word) {
    if (type(at_) == Token::EOF) return false;
    const std::size_t from = begin_of(at_);
    if (text_.substr(from, word.size()) != word) return false;
    while (type(at_) != Token::EOF && end_of(at_) < from + word.size()) ++at_;
    if (type(at_) == Token::EOF || end_of(at_) != from + word.size()) return false;
    ++at_;
    return true;
  }

  bool path_matches(std::size_t first) {
    if (first > 0 && type(first - 1) == BipParser::DOT) return false;
    for (;;) {
      if (!is_late_name(type(at_))) return false;
      ++at_;
      if (type(at_) == BipParser::LBRACK) {
        while (type(at_) != BipParser::RBRACK) {
          if (begins_line(at_) || type(at_) == Token::EOF) return false;
          ++at_;
        }
        ++at_;
      }
      if (type(at_) != BipParser::DOT) return capture(first);
      ++at_;
    }
  }

  bool expression_matches(std::size_t first) {
    int open = 0;
    while (!ends_expression(type(at_)) && (at_ == first || !begins_line(at_))) {
      if (type(at_) == BipParser::LPAREN) ++open;
      if (type(at_) == BipParser::RPAREN && open-- == 0) break;
      ++at_;
    }
    return capture(first);
  }

  bool block_matches() {
    if (type(at_) != BipParser::LBRACE) return false;
    const std::size_t inside = end_of(at_);
    int open = 0;
    for (;; ++at_) {
      if (type(at_) == Token::EOF || type(at_) == BipParser::END) return false;
      if (type(at_) == BipParser::LBRACE) ++open;
      if (type(at_) == BipParser::RBRACE && --open == 0) break;
    }
    // Words that replace the braces need blanks around what stands inside.
    std::string body(text_.substr(inside, begin_of(at_) - inside));
    if (body.empty() || body.front() != '\n') body.insert(0, 1, ' ');
    if (body.back() != ' ' && body.back() != '\n') body += ' ';
    captures.push_back({std::move(body), 1});
    ++at_;
    return true;
  }

  antlr4::TokenStream& tokens_;
  std::string_view text_;
  std::size_t found_;
  std::size_t at_ = 0;
};

std::string fill(std::string_view with, const Matcher& matcher, bool is_paper) {
  std::string out;
  for (std::size_t i = 0; i < with.size(); ++i) {
    if (with[i] != '$') {
      out += with[i];
      continue;
    }
    ++i;
    if (with[i] == '=') {
      out += is_paper ? "<-" : "=";
      continue;
    }
    const bool parenthesised = with[i] == '(', lower = with[i] == 'l';
    if (parenthesised || lower) ++i;
    BIP_ASSERT(with[i] >= '1' && static_cast<std::size_t>(with[i] - '1') < matcher.captures.size(),
               "`{}` names a part that its pattern has not", with);
    const Matcher::Capture& capture = matcher.captures[static_cast<std::size_t>(with[i] - '1')];
    if (parenthesised) ++i;
    std::string text = capture.text;
    if (lower) std::transform(text.begin(), text.end(), text.begin(), to_lower);
    out += parenthesised && capture.words > 1 ? "(" + text + ")" : text;
  }
  return out;
}

}  // namespace

std::optional<Habit> find_habit(antlr4::TokenStream& tokens, const antlr4::RuleContext* context, const Token& found,
                                std::string_view text) {
  constexpr std::size_t kTokensBefore = 16;
  const Chain chain = read_chain(tokens, found, context);
  const std::size_t index = found.getTokenIndex();
  Matcher matcher(tokens, text, index);
  for (const Row& row : kRows) {
    if (!chain.is_in(row.where)) continue;
    for (std::size_t back = 0; back <= std::min(index, kTokensBefore); ++back) {
      if (!matcher.matches(row.pattern, index - back)) continue;
      Habit habit{
          .note = row.note, .has_edit = !row.with.empty(), .begin = matcher.begin, .end = matcher.end, .with = {}};
      if (row.with != "-") habit.with = fill(row.with, matcher, chain.is_in(Where::Paper));
      return habit;
    }
  }
  return std::nullopt;
}

}  // namespace bip::parse
