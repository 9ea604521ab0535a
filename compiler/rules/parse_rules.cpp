// One row a rule; words of the language are words only where a rule expects them, so modules may use them as names.
//
//   file      = 'rules' NAME ';' { item }        (a VALUE is a word, a string, or a number, of which `-` may stand
//             before)
//   item      = 'extends' STRING ';'
//             | 'modules' STRING { ',' STRING } [ 'with' STRING ] ';'
//             | 'parameter' NAME 'of' paths ':' VALUE { ',' VALUE } ';'
//             | 'value' NAME 'of' path ':' VALUE { ',' VALUE } ';'
//             | 'services' NAME ':' paths ';'
//             | 'promise' NAME ':' ( 'always' | 'never' ) condition ';'
//             | [ NAME ':' ] rule { 'report' STRING | 'on' 'violation' 'run' path } ';'
//             | 'request' path [ '(' '?' NAME { ',' '?' NAME } ')' ] '{' 'fail' '{' { ( 'check' | 'maintain' ) ':' |
//             condition ';' } '}' '}'
//   rule      = paths ( 'before' paths [ 'since' path ] [ 'within' TIME ] | 'does' 'not' 'overlap' paths [ ':' policy [
//   ',' policy ] ] | 'only' 'during' path
//             | 'requires' condition | 'maintains' condition | 'takes' 'at' 'most' TIME | 'at' 'least' TIME 'after'
//             path ) | 'at' 'most' NUMBER 'of' paths | 'never' path [ '.' 'active' ] '&&' path [ '.' 'active' ]
//             | 'when' condition 'run' path
//   policy    = 'reject' | 'wait' | 'interrupt'
#include "compiler/rules/parse_rules.hpp"

#include <utility>

#include "compiler/rules/parser.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::rules {
namespace {

class RulesParser {
 public:
  RulesParser(const std::vector<genom::Token>& tokens, Diagnostics& diags) : at_(tokens, diags) {}

  RuleFile run() {
    if (!at_.expect("rules") || !at_.name(file_.package, "a name") || !at_.expect(";")) at_.skip_past_semicolon();
    while (!at_.at_end()) {
      if (item()) continue;
      at_.skip_past_semicolon();
      at_.accept("}");
    }
    return std::move(file_);
  }

 private:
  bool item() {
    const genom::Token& next = at_.peek(1);
    if (at_.at("extends") && next.kind == genom::TokenKind::String) return extends();
    if (at_.at("modules") && next.kind == genom::TokenKind::String) return modules();
    if (at_.at("parameter") && next.kind == genom::TokenKind::Word) return parameter();
    if (at_.at("value") && next.kind == genom::TokenKind::Word && at_.peek(2).is("of")) return value();
    if (at_.at("request") && next.kind == genom::TokenKind::Word) return request();
    if (at_.at("services") && next.kind == genom::TokenKind::Word && at_.peek(2).is(":")) return group();
    if (at_.at("promise") && next.kind == genom::TokenKind::Word && at_.peek(2).is(":")) return promise();
    return rule();
  }

  bool promise() {
    Promise p;
    p.range = at_.take().range;
    if (!at_.name(p.name, "a name") || !at_.expect(":")) return false;
    p.is_never = at_.accept("never");
    if (!p.is_never && !at_.accept("always")) {
      at_.unexpected("`always` or `never`");
      return false;
    }
    if (!parse_condition(at_, p.condition)) return false;
    p.range.end = at_.peek().range.begin;
    file_.promises.push_back(std::move(p));
    return at_.expect(";");
  }

  bool group() {
    at_.take();
    ServiceGroup g;
    if (!at_.name(g.name, "a name") || !at_.expect(":") || !paths(g.services, "a service")) return false;
    file_.groups.push_back(std::move(g));
    return at_.expect(";");
  }

  bool quoted(Name& into, const char* what) {
    if (at_.peek().kind != genom::TokenKind::String) {
      at_.unexpected(what);
      return false;
    }
    const genom::Token& token = at_.take();
    into = {std::string(token.text), token.range};
    return true;
  }

  bool extends() {
    at_.take();
    return quoted(file_.extends.emplace_back(), "a path in quotes") && at_.expect(";");
  }

  bool modules() {
    at_.take();
    do {
      if (!quoted(file_.modules.emplace_back(), "a path in quotes")) return false;
    } while (at_.accept(","));
    if (at_.accept("with") && !quoted(file_.side_file, "a path in quotes")) return false;
    return at_.expect(";");
  }

  bool paths(std::vector<Path>& into, const char* what) {
    do {
      if (!parse_path(at_, into.emplace_back(), what)) return false;
    } while (at_.accept(","));
    return true;
  }

  bool parameter() {
    at_.take();
    ParameterDecl p;
    if (!at_.name(p.name, "a parameter") || !at_.expect("of") || !paths(p.services, "a service") || !at_.expect(":"))
      return false;
    if (!listed(p.type, p.values)) return false;
    file_.parameters.push_back(std::move(p));
    return at_.expect(";");
  }

  // Numbers, of which one with a fraction makes fractions of all, or words.
  bool listed(genom::ValueType& all, std::vector<std::string>& values) {
    do {
      const bool is_negative = at_.at("-") && at_.peek(1).kind == genom::TokenKind::Number;
      if (is_negative) at_.take();
      const genom::Token& token = at_.peek();
      std::int64_t whole = 0;
      const bool is_int =
          token.kind == genom::TokenKind::Number && genom::whole_number(token.text, whole) && whole <= 2147483647;
      const bool is_fraction = !is_int && token.kind == genom::TokenKind::Number && is_decimal(token.text);
      const bool is_text = token.kind == genom::TokenKind::String || token.kind == genom::TokenKind::Word;
      const genom::ValueType type = is_text  ? genom::ValueType::Text
                                    : is_int ? genom::ValueType::Int
                                             : genom::ValueType::Float;
      const bool was_text = all == genom::ValueType::Text;
      if ((!is_int && !is_fraction && !is_text) || (!values.empty() && is_text != was_text)) {
        at_.unexpected(values.empty() ? "a value" : was_text ? "a word, as before" : "a number, as before");
        return false;
      }
      all = values.empty() || type == genom::ValueType::Float ? type : all;
      values.push_back((is_negative ? "-" : "") + (is_int ? std::to_string(whole) : std::string(token.text)));
      at_.take();
    } while (at_.accept(","));
    return true;
  }

  bool value() {
    at_.take();
    ValueDecl v;
    if (!at_.name(v.name, "a value") || !at_.expect("of") || !parse_path(at_, v.poster, "a poster") || !at_.expect(":"))
      return false;
    if (!listed(v.type, v.values)) return false;
    file_.values.push_back(std::move(v));
    return at_.expect(";");
  }

  bool rule() {
    Rule r;
    r.range = at_.peek().range;
    if (at_.peek().kind == genom::TokenKind::Word && at_.peek(1).is(":")) {
      r.name = {std::string(at_.peek().text), at_.peek().range};
      at_.take();
      at_.take();
    }
    if (at_.at("at") && at_.peek(1).is("most")) {
      if (!count(r)) return false;
    } else if (at_.at("never") && at_.peek(1).kind == genom::TokenKind::Word &&
               (at_.peek(2).is("&&") || at_.peek(2).is("."))) {
      at_.take();
      r.verb = Verb::Apart;
      if (!active(r.left) || !at_.expect("&&") || !active(r.right)) return false;
    } else if (at_when()) {
      at_.take();
      r.verb = Verb::When;
      if (!parse_condition(at_, r.condition) || !at_.expect("run") ||
          !parse_path(at_, r.recovery.emplace(), "a service"))
        return false;
    } else if (!paths(r.left, "a rule") || !verb(r)) {
      return false;
    }
    while (!at_.at(";")) {
      if (at_.accept("report")) {
        if (!quoted(r.report, "a report in quotes")) return false;
      } else if (r.verb != Verb::When && at_.accept("on")) {
        if (!at_.expect("violation") || !at_.expect("run") || !parse_path(at_, r.recovery.emplace(), "a service"))
          return false;
      } else {
        return at_.expect(";");
      }
    }
    r.range.end = at_.take().range.begin;
    file_.rules.push_back(std::move(r));
    return true;
  }

  // No service of that name, which a verb, a comma or a dot follows.
  bool at_when() {
    if (!at_.at("when")) return false;
    for (const char* next : {",", ".", "before", "does", "only", "requires", "maintains", "takes", "ends", "at"}) {
      if (at_.peek(1).is(next)) return false;
    }
    return true;
  }

  // A service or a group, or `.active` of it.
  bool active(std::vector<Path>& into) {
    Path path;
    if (!parse_path(at_, path, "a service")) return false;
    if (at_.accept(".")) {
      if (!at_.expect("active")) return false;
    } else if (path.module.is_set() && path.name.text == "active") {
      path.name = std::exchange(path.module, {});
    }
    into.push_back(std::move(path));
    return true;
  }

  // at most NUMBER of paths
  bool count(Rule& r) {
    r.verb = Verb::AtMostOf;
    at_.take();
    at_.take();
    if (at_.peek().kind != genom::TokenKind::Number || !genom::whole_number(at_.peek().text, r.count) || r.count < 1) {
      at_.unexpected("a number from 1 on");
      return false;
    }
    at_.take();
    return at_.expect("of") && paths(r.left, "a service");
  }

  bool verb(Rule& r) {
    if (at_.accept("before")) {
      if (!set(r, Verb::Before) || !paths(r.right, "a service")) return false;
      if (at_.accept("since") && !parse_path(at_, r.since.emplace(), "a service")) return false;
      return !at_.accept("within") || parse_span(at_, r.within.emplace());
    }
    if (at_.accept("does"))
      return set(r, Verb::Apart) && at_.expect("not") && at_.expect("overlap") && paths(r.right, "a service") &&
             policies(r);
    if (at_.accept("only"))
      return set(r, Verb::During) && at_.expect("during") && parse_path(at_, r.right.emplace_back(), "a service");
    if (at_.accept("requires")) return set(r, Verb::Requires) && parse_condition(at_, r.condition);
    if (at_.accept("maintains")) return set(r, Verb::Maintains) && parse_condition(at_, r.condition);
    if (at_.at("takes") || at_.at("ends")) {
      const SourceRange range = at_.take().range;
      if (range.end - range.begin == 5 && at_.expect("at") && at_.accept("most"))
        return set(r, Verb::AtMost) && parse_span(at_, r.span);
      // How long something takes at least, or what ends first, nobody can decide who only hears of it.
      at_.diags().report(Diag::kB6104, r.range, r.left[0].text());
      return false;
    }
    if (at_.accept("at")) {
      return set(r, Verb::AtLeast) && at_.expect("least") && parse_span(at_, r.span) && at_.expect("after") &&
             parse_path(at_, r.right.emplace_back(), "a service");
    }
    at_.unexpected(
        "`before`, `does not overlap`, `only during`, `requires`, `maintains`, `takes at most` or `at least`");
    return false;
  }

  static bool set(Rule& r, Verb verb) {
    r.verb = verb;
    return true;
  }

  bool policies(Rule& r) {
    if (!at_.accept(":")) return true;
    if (!policy(r.policy[0])) return false;
    r.policy[1] = r.policy[0];
    return !at_.accept(",") || policy(r.policy[1]);
  }

  bool policy(Policy& into) {
    for (const auto& [word, meaning] : {std::pair("reject", Policy::Reject), std::pair("wait", Policy::Wait),
                                        std::pair("interrupt", Policy::Interrupt)}) {
      if (!at_.accept(word)) continue;
      into = meaning;
      return true;
    }
    at_.unexpected("`reject`, `wait` or `interrupt`");
    return false;
  }

  // R2C's form: what a service fails by. Each condition is a rule that says the opposite.
  bool request() {
    const SourceRange begin = at_.take().range;
    Path service;
    if (!parse_path(at_, service, "a service")) return false;
    if (at_.at("(") && !at_.skip_group()) return false;
    if (!at_.expect("{") || !at_.expect("fail") || !at_.expect("{")) return false;
    Verb verb = Verb::Maintains;
    while (!at_.at("}")) {
      const bool is_check = at_.at("check") && at_.peek(1).is(":");
      if (is_check || (at_.at("maintain") && at_.peek(1).is(":"))) {
        verb = is_check ? Verb::Requires : Verb::Maintains;
        at_.take();
        at_.take();
        continue;
      }
      Rule r;
      r.verb = verb;
      r.left.push_back(service);
      r.range = at_.peek().range;
      r.condition = {.kind = ExprKind::Not, .range = begin};
      if (!parse_condition(at_, r.condition.operands.emplace_back())) return false;
      r.condition.range = r.condition.operands[0].range;
      r.range.end = at_.peek().range.begin;
      if (!at_.expect(";")) return false;
      file_.rules.push_back(std::move(r));
    }
    at_.take();
    if (!at_.expect("}")) return false;
    at_.accept(";");
    return true;
  }

  genom::Cursor at_;
  RuleFile file_;
};

}  // namespace

bool parse_path(genom::Cursor& at, Path& into, const char* what) {
  if (!at.name(into.name, what)) return false;
  if (!at.accept(".")) return true;
  into.module = std::move(into.name);
  return at.name(into.name, "a name");
}

bool is_decimal(std::string_view text) {
  const std::size_t dot = text.find('.');
  const auto digits = [](std::string_view part) {
    return !part.empty() && part.size() <= 4 && part.find_first_not_of("0123456789") == std::string_view::npos;
  };
  return dot != std::string_view::npos && digits(text.substr(0, dot)) && digits(text.substr(dot + 1));
}

bool parse_span(genom::Cursor& at, genom::Span& into) {
  std::int64_t value = 0;
  if (at.peek().kind != genom::TokenKind::Number || !genom::whole_number(at.peek().text, value) || value > 1000000000) {
    at.unexpected("a length of time, such as `500 ms`");
    return false;
  }
  at.take();
  for (const auto& [unit, us] :
       {std::pair("us", 1), std::pair("ms", 1000), std::pair("s", 1000000), std::pair("min", 60000000)}) {
    if (!at.accept(unit)) continue;
    into = {value * us, false};
    return true;
  }
  if (!at.accept("tick") && !at.accept("ticks")) {
    at.unexpected("`ticks`, `us`, `ms`, `s` or `min`");
    return false;
  }
  into = {value, true};
  return true;
}

RuleFile parse_rules(const SourceMap& sources, FileId file, Diagnostics& diags) {
  const std::vector<genom::Token> tokens = genom::lex(sources, file, diags);
  return RulesParser(tokens, diags).run();
}

}  // namespace bip::rules
