// Conditions, by precedence climbing; depth is limited, so that a text can't exhaust the stack.
//
//   condition = C's || && == != < <= > >= + - * ! ( ) over
//               [ '-' ] NUMBER | STRING | NAME | SERVICE.active | SERVICE.done | SERVICE.PARAMETER | request.PARAMETER
//               | total(PARAMETER)
//             | POSTER is fresh within TIME | POSTER.age
//             | POSTER.VALUE | VALUE | … in '[' LEAST ',' MOST ']'
//             | silent for TIME | MODULE is silent for TIME | SERVICE.failed | SERVICE.lost | SERVICE.late |
//             TASK.missed | past(SERVICE [() | (?P) with condition]) | running(SERVICE) | '[' SERVICE < SERVICE ']' |
//             ?PARAMETER
#include "compiler/rules/parser.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::rules {
namespace {

constexpr int kMaxDepth = 60;

class ConditionParser {
 public:
  explicit ConditionParser(genom::Cursor& at) : at_(at) {}

  bool expression(Expr& into, int least, int depth) {
    if (!operand(into, depth) || (at_.at("in") && !range_of(into, depth))) return false;
    while (true) {
      const int strength = strength_of(at_.peek().text);
      if (at_.peek().kind != genom::TokenKind::Sign || strength < least) return true;
      const genom::Token& sign = at_.take();
      Expr right;
      if (!expression(right, strength + 1, depth + 1)) return false;
      Expr whole{.kind = ExprKind::Operator, .range = into.range, .text = std::string(sign.text)};
      whole.range.end = right.range.end;
      whole.operands.push_back(std::move(into));
      whole.operands.push_back(std::move(right));
      into = std::move(whole);
      if (++chain_ > kMaxChain) return too_deep(into);
    }
  }

 private:
  static constexpr int kMaxChain = 200;

  static int strength_of(std::string_view sign) {
    if (sign == "||") return 1;
    if (sign == "&&") return 2;
    if (sign == "==" || sign == "!=") return 3;
    if (sign == "<" || sign == "<=" || sign == ">" || sign == ">=") return 4;
    if (sign == "+" || sign == "-") return 5;
    if (sign == "*") return 6;
    return -1;
  }

  bool too_deep(const Expr& e) {
    at_.diags().report(Diag::kB6107, e.range);
    return false;
  }

  bool operand(Expr& into, int depth) {
    const genom::Token& token = at_.peek();
    into.range = token.range;
    if (depth > kMaxDepth) return too_deep(into);
    if (at_.accept("!")) {
      into.kind = ExprKind::Not;
      into.operands.emplace_back();
      if (!operand(into.operands[0], depth + 1)) return false;
      into.range.end = into.operands[0].range.end;
      return true;
    }
    if (at_.accept("(")) return expression(into, 1, depth + 1) && at_.expect(")");
    if (at_.accept("[")) {
      into.kind = ExprKind::Ordered;
      return called(into.path) && at_.expect("<") && called(into.second) && at_.expect("]");
    }
    if (at_.accept("?")) {
      into.kind = owner_.name.is_set() ? ExprKind::Of : ExprKind::Request;
      into.path = owner_;
      return at_.name(into.name, "a parameter");
    }
    if (token.kind == genom::TokenKind::Number) return number(into);
    if (at_.accept("-")) {
      if (at_.peek().kind == genom::TokenKind::Number) return negative(into);
      at_.unexpected("a number after `-`");
      return false;
    }
    if (token.kind == genom::TokenKind::String) {
      into.kind = ExprKind::Text;
      into.text = at_.take().text;
      return true;
    }
    if (token.kind != genom::TokenKind::Word) {
      at_.unexpected("a condition");
      return false;
    }
    if (at_.peek(1).is("(") && at_.accept("past")) return past(into, depth);
    if (at_.peek(1).is("(") && at_.accept("running")) {
      into.kind = ExprKind::Active;
      return at_.expect("(") && called(into.path) && at_.expect(")");
    }
    if (at_.peek(1).is("(") && at_.accept("total")) {
      into.kind = ExprKind::Total;
      return at_.expect("(") && at_.name(into.name, "a parameter") && at_.expect(")");
    }
    if (at_.peek(1).is(".") && at_.accept("request")) {
      into.kind = ExprKind::Request;
      return at_.expect(".") && at_.name(into.name, "a parameter");
    }
    if (at_.peek(1).is("for") && at_.accept("silent")) return silent(into);
    return property(into);
  }

  // … silent for TIME
  bool silent(Expr& into) {
    into.kind = ExprKind::Silent;
    if (!at_.expect("for")) return false;
    into.range.end = at_.peek(1).range.end;
    if (!parse_span(at_, into.span)) return false;
    if (into.span.value > 0) return true;
    at_.diags().report(Diag::kB6115, into.range, "silent for 0", "always", "a silence has a length");
    return false;
  }

  // X in [A, B]: X >= A && X <= B.
  bool range_of(Expr& into, int depth) {
    at_.take();
    Expr bounds[2];
    if (!at_.expect("[") || !expression(bounds[0], 5, depth + 1) || !at_.expect(",") ||
        !expression(bounds[1], 5, depth + 1))
      return false;
    Expr both{.kind = ExprKind::Operator, .range = into.range, .text = "&&"};
    both.range.end = at_.peek().range.end;
    for (int k = 0; k < 2; ++k) {
      Expr side{.kind = ExprKind::Operator, .range = both.range, .text = k == 0 ? ">=" : "<="};
      side.operands.push_back(into);
      side.operands.push_back(std::move(bounds[k]));
      both.operands.push_back(std::move(side));
    }
    into = std::move(both);
    if (++chain_ > kMaxChain) return too_deep(into);
    return at_.expect("]");
  }

  bool number(Expr& into) {
    if (genom::whole_number(at_.peek().text, into.number) && into.number <= 2147483647) {
      at_.take();
      return true;
    }
    if (is_decimal(at_.peek().text)) {
      into.text = at_.take().text;
      return true;
    }
    at_.unexpected("a whole number that fits 32 bits, or digits with a dot, at most four on either side");
    return false;
  }

  bool negative(Expr& into) {
    into.range.end = at_.peek().range.end;
    if (!number(into)) return false;
    into.number = -into.number;
    if (!into.text.empty()) into.text.insert(0, "-");
    return true;
  }

  // S or S().
  bool called(Path& into) {
    if (!parse_path(at_, into, "a service")) return false;
    return !at_.accept("(") || at_.expect(")");
  }

  // past(S(?p) with ?p == V): S has succeeded, and its last accepted request had p == V.
  bool past(Expr& into, int depth) {
    into.kind = ExprKind::Done;
    if (!at_.expect("(") || !parse_path(at_, into.path, "a service")) return false;
    if (at_.accept("(")) {
      Name parameter;
      while (at_.accept("?")) {
        if (!at_.name(parameter, "a parameter")) return false;
        if (!at_.accept(",")) break;
      }
      if (!at_.expect(")")) return false;
    }
    if (at_.accept("with")) {
      Expr with;
      const Path outer = owner_;
      owner_ = into.path;
      const bool is_good = expression(with, 1, depth + 1);
      owner_ = outer;
      if (!is_good) return false;
      Expr both{.kind = ExprKind::Operator, .range = into.range, .text = "&&"};
      both.operands.push_back(std::move(into));
      both.operands.push_back(std::move(with));
      into = std::move(both);
    }
    return at_.expect(")");
  }

  // MODULE.NAME.what | NAME.what | POSTER is fresh within TIME | a value
  bool property(Expr& into) {
    std::vector<Name> parts(1);
    if (!at_.name(parts[0], "a condition")) return false;
    while (at_.accept(".")) {
      if (!at_.name(parts.emplace_back(), "a name")) return false;
    }
    into.range.end = parts.back().range.end;
    const auto path = [&](std::size_t count) {
      BIP_ASSERT(count >= 1 && count <= parts.size(), "{} of {} names", count, parts.size());
      into.path.name = parts[count - 1];
      if (count > 1) into.path.module = parts[count - 2];
    };
    if (parts.size() == 1 && at_.at("is") && at_.peek(1).is("silent")) {
      at_.take();
      at_.take();
      path(1);
      return silent(into);
    }
    if (parts.size() <= 2 && at_.accept("is")) {
      into.kind = ExprKind::Fresh;
      path(parts.size());
      return at_.expect("fresh") && at_.expect("within") && parse_span(at_, into.span);
    }
    if (parts.size() > 3) {
      at_.unexpected("a condition");
      return false;
    }
    if (parts.size() == 1) {
      // A bare name is a value of a poster, or a value by itself: STEREO, GPS.
      into.kind = ExprKind::Word;
      into.name = parts[0];
      into.text = parts[0].text;
      return true;
    }
    const Name& what = parts.back();
    path(parts.size() - 1);
    into.kind = what.text == "active"   ? ExprKind::Active
                : what.text == "done"   ? ExprKind::Done
                : what.text == "age"    ? ExprKind::Age
                : what.text == "failed" ? ExprKind::Failed
                : what.text == "lost"   ? ExprKind::Lost
                : what.text == "late"   ? ExprKind::Late
                : what.text == "missed" ? ExprKind::Missed
                                        : ExprKind::Of;
    into.name = what;
    return true;
  }

  genom::Cursor& at_;
  Path owner_;
  int chain_ = 0;
};

}  // namespace

bool parse_condition(genom::Cursor& at, Expr& into) { return ConditionParser(at).expression(into, 1, 0); }

}  // namespace bip::rules
