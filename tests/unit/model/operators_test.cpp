// Tables generated from ops.def: names are unique, every operator folds and prints.
#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "compiler/model/fold.hpp"
#include "compiler/model/print_expr.hpp"
#include "tests/unit/parse/parsed.hpp"

using namespace bip;

namespace {

template <class See>
void for_each_operator(const See& see) {
  for (std::size_t row = 0; row < kOperators.size(); ++row) see(static_cast<Op>(row));
}

ExprText variable(const char* name) { return {name}; }

// Returns the parsed expression with all parentheses.
std::string parsed(const std::string& expr) {
  const test::Parsed p("package p\nconst data int x = " + expr + "\nend");
  const std::string shape = p.shape();
  const std::size_t begin = shape.find("x=") + 2;
  return p.codes().empty() ? shape.substr(begin, shape.find('\n', begin) - begin) : p.codes();
}

}  // namespace

TEST_CASE("names of operators are unique") {
  std::set<std::string> texts, words, symbols;
  std::size_t binaries = 0;
  for_each_operator([&](Op op) {
    const OperatorInfo& info = info_of(op);
    CHECK(texts.insert(info.text).second);
    CHECK((info.word == nullptr) == (operand_count(op) == 0));
    if (info.word != nullptr) CHECK(words.insert(info.word).second);
    if (operand_count(op) != 2) return;
    CHECK(symbols.insert(info.symbol).second);
    ++binaries;
  });
  CHECK(binaries >= 16);
  CHECK_FALSE(is_operator(static_cast<Op>(kOperators.size())));
}

TEST_CASE("operands and results of operators") {
  for_each_operator([&](Op op) {
    if (operand_count(op) == 0) return;
    const OperandTypes operands = info_of(op).operands;
    bool takes_some = false;
    for (const Type type : {Type::Int, Type::Bool, Type::Float, Type::String}) {
      if (!takes(operands, type)) continue;
      takes_some = true;
      if (is_comparison(op)) CHECK(result_of(op, type) == Type::Bool);
      if (family_of(op) == OpFamily::Arithmetic || is_division(op)) CHECK(result_of(op, type) == type);
    }
    CHECK(takes_some);
    CHECK_FALSE(takes(operands, static_cast<Type>(kFirstFfiType)));
  });
}

TEST_CASE("a comparison and its negation differ on all ints") {
  for (const Op op : {BIP_COMPARISON_OPS(BIP_OP_ITEM)}) {
    CHECK(negation_of(negation_of(op)) == op);
    for (const std::int32_t a : {INT32_MIN, -1, 0, 1, INT32_MAX}) {
      for (const std::int32_t b : {INT32_MIN, -1, 0, 1, INT32_MAX})
        CHECK(fold_int(op, a, b) + fold_int(negation_of(op), a, b) == 1);
    }
  }
}

TEST_CASE("parentheses by dialect") {
  const auto nested = [](Dialect dialect, Op outer, Op inner) {
    return print_binary(dialect, outer, print_binary(dialect, inner, variable("a"), variable("b")),
                        print_binary(dialect, inner, variable("c"), variable("d")))
        .text;
  };
  CHECK(nested(Dialect::Bip, Op::Add, Op::Mul) == "a * b + c * d");
  CHECK(nested(Dialect::Bip, Op::Sub, Op::Sub) == "a - b - (c - d)");
  CHECK(nested(Dialect::Bip, Op::Eq, Op::Lt) == "(a < b) == (c < d)");
  CHECK(nested(Dialect::Bip, Op::BitOr, Op::Add) == "a + b | c + d");
  CHECK(nested(Dialect::Cpp, Op::And, Op::Eq) == "a == b && c == d");
  CHECK(nested(Dialect::Cpp, Op::Or, Op::And) == "(a && b) || (c && d)");
  CHECK(nested(Dialect::Cpp, Op::BitAnd, Op::Eq) == "(a == b) & (c == d)");
  CHECK(nested(Dialect::Promela, Op::Add, Op::Mul) == "((a * b) + (c * d))");
  const ExprText minus = print_unary(Dialect::Bip, Op::Neg, variable("x"));
  CHECK(print_unary(Dialect::Bip, Op::Neg, minus).text == "-(-x)");
  CHECK(print_unary(Dialect::Bip, Op::BitNot, minus).text == "~-x");
  CHECK(print_unary(Dialect::Cpp, Op::BitNot, minus).text == "~(-x)");
  CHECK(print_unary(Dialect::Promela, Op::Not, variable("x")).text == "(!x)");
  const ExprText denied = print_unary(Dialect::Cpp, Op::Not, variable("x"));
  CHECK(print_binary(Dialect::Cpp, Op::Eq, denied, denied).text == "(!x) == !x");
}

TEST_CASE("the grammar has each operator, at its precedence") {
  for_each_operator([&](Op first) {
    const std::string one = symbol_of(first);
    if (family_of(first) == OpFamily::Sign) CHECK(parsed(one + "a") == "(" + one + "a)");
    if (operand_count(first) != 2) return;
    CHECK(parsed("a " + one + " b") == "(a " + one + " b)");
    for_each_operator([&](Op second) {
      if (operand_count(second) != 2 || (is_order(first) && is_order(second))) return;
      const std::string two = symbol_of(second);
      const bool is_left = precedence_of(first) >= precedence_of(second);
      CHECK(parsed("a " + one + " b " + two + " c") ==
            (is_left ? "((a " + one + " b) " + two + " c)" : "(a " + one + " (b " + two + " c))"));
    });
  });
}
