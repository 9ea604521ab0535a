// See bsys_reader.hpp: the cursor, then expressions and statements.
//
// Types of operators and loads follow from their operands and from the scope. Only ids and shapes are checked here;
// `validate` checks types. Code is read recursively; its depth is limited by kMaxParentheses.
#include "compiler/system/bsys_reader.hpp"
#include "runtime/include/bip/assert.hpp"

#include <fmt/format.h>

#include <charconv>

#include "compiler/model/statements.hpp"

namespace bip::system::text {
namespace {

/// The whole of `text` as a number.
template <class T>
bool to_number(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

void BsysReader::fail(std::uint32_t node, std::string_view message) {
  if (failed()) return;
  BIP_ASSERT(node == kNoNode || node < tree_.nodes.size(), "node {} of {}", node, tree_.nodes.size());
  const std::size_t offset = node == kNoNode ? tree_.text.size() : tree_.nodes[node].begin;
  failure_ = failure_at(tree_.text, offset, message);
}

List BsysReader::open(std::uint32_t node, std::string_view& head) {
  head = {};
  if (failed()) return {};
  if (tree_.nodes[node].kind != Node::Kind::List) {
    fail(node, "expected a list");
    return {};
  }
  List list = open_bare(node);
  if (list.at == kNoNode || tree_.nodes[list.at].kind != Node::Kind::Word) {
    fail(node, "a list begins with a word");
    return {};
  }
  head = tree_.word(list.at);
  list.at = tree_.nodes[list.at].next;
  return list;
}

bool BsysReader::more(List& list) {
  while (!failed() && list.at != kNoNode) {
    const std::uint32_t node = list.at;
    if (tree_.nodes[node].kind != Node::Kind::Word || tree_.text[tree_.nodes[node].begin] != '@') return true;
    take_loc(list, node);
  }
  return false;
}

void BsysReader::take_loc(List& list, std::uint32_t node) {
  BIP_ASSERT(tree_.word(node).starts_with('@'), "a place begins with @");
  const std::string_view word = tree_.word(node).substr(1);
  const std::size_t first = word.find(':');
  const std::size_t second = first == std::string_view::npos ? first : word.find(':', first + 1);
  Loc loc;
  if (second == std::string_view::npos || !to_number(word.substr(0, first), loc.file) ||
      !to_number(word.substr(first + 1, second - first - 1), loc.line) ||
      !to_number(word.substr(second + 1), loc.column) || loc.line == 0)
    return fail(node, "a place is `@file:line:column`, lines from 1");
  if (list.loc.line != 0) return fail(node, "a list has one place");
  list.loc = loc;
  list.at = tree_.nodes[node].next;
}

std::uint32_t BsysReader::next(List& list, std::string_view wanted) {
  if (!more(list)) {
    if (!failed()) fail(list.node, fmt::format("the list ends where {} should be", wanted));
    return kNoNode;
  }
  const std::uint32_t node = list.at;
  BIP_ASSERT(tree_.nodes[node].next == kNoNode || tree_.nodes[node].next > node, "elements of a list are in order");
  list.at = tree_.nodes[node].next;
  return node;
}

std::string BsysReader::text_of(std::uint32_t node) {
  std::string text;
  std::size_t bad = 0;
  if (!unquote(tree_.word(node), text, bad)) {
    fail(node, R"(an escape is one of \" \\ \n \t \xHH)");
    text.clear();
  }
  return text;
}

std::string BsysReader::name(List& list) {
  const std::uint32_t node = next(list, "a name");
  if (node == kNoNode) return {};
  if (tree_.nodes[node].kind == Node::Kind::Quoted) return text_of(node);
  if (tree_.nodes[node].kind == Node::Kind::Word && is_bare(tree_.word(node))) return std::string(tree_.word(node));
  fail(node, "expected a name; odd names are quoted");
  return {};
}

std::string BsysReader::quoted(List& list) {
  const std::uint32_t node = next(list, "a string");
  if (node == kNoNode) return {};
  if (tree_.nodes[node].kind == Node::Kind::Quoted) return text_of(node);
  fail(node, "expected a quoted string");
  return {};
}

Type BsysReader::type(List& list) {
  const std::uint32_t node = next(list, "a type");
  if (node == kNoNode) return Type::Int;
  const std::optional<Type> type =
      tree_.nodes[node].kind == Node::Kind::Word ? type_of(tree_.word(node)) : std::nullopt;
  if (!type && !system_.code.ffi_types.empty()) {
    list.at = node;
    return ffi_type(ref(list, system_.code.ffi_types.size(), "type",
                        [&](std::uint32_t k) -> const std::string& { return system_.code.ffi_types[k].name; }));
  }
  if (!type) fail(node, "expected int, bool, float or string");
  return type.value_or(Type::Int);
}

void BsysReader::row(List& list, std::size_t expected) {
  const std::uint32_t node = next(list, "the row's number");
  std::size_t number = 0;
  if (node != kNoNode && (!to_number(tree_.word(node), number) || number != expected))
    fail(node, fmt::format("this row's number is {}", expected));
}

std::uint32_t BsysReader::number_of_ref(List& list, std::size_t count, const char* what, std::string_view& hint,
                                        std::uint32_t& node) {
  node = next(list, what);
  if (node == kNoNode) return 0;
  std::string_view word = tree_.nodes[node].kind == Node::Kind::Word ? tree_.word(node) : std::string_view();
  if (const std::size_t colon = word.find(':'); colon != std::string_view::npos) {
    hint = word.substr(colon + 1);
    word = word.substr(0, colon);
  }
  std::uint32_t number = 0;
  if (!to_number(word, number)) {
    fail(node, fmt::format("expected {}: a row number, or number:name", what));
    return 0;
  }
  if (number >= count) {
    fail(node, fmt::format("{} {} is out of range: {} rows before here", what, number, count));
    return 0;
  }
  return number;
}

bool BsysReader::flag(List& list, std::string_view word) {
  if (!more(list) || tree_.nodes[list.at].kind != Node::Kind::Word || tree_.word(list.at) != word) return false;
  list.at = tree_.nodes[list.at].next;
  return true;
}

std::optional<List> BsysReader::sub(List& list, std::string_view head) {
  if (!more(list) || tree_.nodes[list.at].kind != Node::Kind::List) return std::nullopt;
  const std::uint32_t first = tree_.nodes[list.at].first;
  if (first == kNoNode || tree_.nodes[first].kind != Node::Kind::Word || tree_.word(first) != head) return std::nullopt;
  const std::uint32_t node = list.at;
  list.at = tree_.nodes[node].next;
  return List{.node = node, .at = tree_.nodes[first].next, .loc = {}};
}

List BsysReader::need(List& list, const char* head) {
  const std::optional<List> found = sub(list, head);
  if (!found) fail(list.at == kNoNode ? list.node : list.at, fmt::format("expected `({} …)` here", head));
  return found.value_or(List{});
}

void BsysReader::close(List& list) {
  if (more(list)) fail(list.at, "unexpected here");
}

Value BsysReader::literal(std::uint32_t node) {
  if (failed() || node == kNoNode) return {};
  if (tree_.nodes[node].kind == Node::Kind::Quoted) {
    const std::string text = text_of(node);
    // Row 0 of the constants is the empty string, which every string variable holds at first.
    if (system_.code.strings.empty()) add_string("");
    add_string(text);
    return {.type = Type::String, .int_value = static_cast<std::int32_t>(strings_[text]), .float_value = 0};
  }
  const std::string_view word = tree_.nodes[node].kind == Node::Kind::Word ? tree_.word(node) : std::string_view();
  if (word == "true" || word == "false")
    return {.type = Type::Bool, .int_value = word == "true" ? 1 : 0, .float_value = 0};
  // Each into its own variable: a number that is read in part writes too.
  std::int32_t as_int = 0;
  double as_float = 0;
  if (to_number(word, as_int)) return {.type = Type::Int, .int_value = as_int, .float_value = 0};
  // Without one of these it would be an int that does not fit.
  if (word.find_first_of(".eni") != std::string_view::npos && to_number(word, as_float))
    return {.type = Type::Float, .int_value = 0, .float_value = as_float};
  fail(node, "expected a constant: 32-bit int, double, true, false or a string");
  return {};
}

bool BsysReader::add_string(const std::string& text) {
  BIP_ASSERT(strings_.size() == system_.code.strings.size(), "each string constant has one row");
  if (!strings_.emplace(text, static_cast<std::uint32_t>(system_.code.strings.size())).second) return false;
  system_.code.strings.push_back(text);
  return true;
}

// ---- code

namespace {

Op constant_of(Type type) {
  switch (type) {
    case Type::Int: return Op::ConstInt;
    case Type::Bool: return Op::ConstBool;
    case Type::Float: return Op::ConstFloat;
    case Type::String: break;
  }
  return Op::ConstString;
}

}  // namespace

std::uint32_t BsysReader::variable(List& list, const std::vector<ScopeVariable>& variables) {
  return ref(list, variables.size(), "variable",
             [&](std::uint32_t k) -> const std::string& { return variables[k].name; });
}

ExprId BsysReader::expr(List& list, const CodeScope& scope) {
  const std::uint32_t node = next(list, "an expression");
  return node == kNoNode ? ExprId() : expr(node, scope);
}

ExprId BsysReader::expr(std::uint32_t node, const CodeScope& scope) {
  if (failed()) return {};
  if (tree_.nodes[node].kind != Node::Kind::List) {
    const Value value = literal(node);
    Expr constant;
    constant.op = constant_of(value.type);
    constant.type = value.type;
    constant.int_value = value.int_value;
    constant.float_value = value.float_value;
    return system_.code.exprs.push(constant);
  }
  std::string_view head;
  List list = open(node, head);
  Expr e;
  if (head == "self" || head == "bind") {
    e.op = head == "self" ? Op::LoadSelf : Op::LoadBind;
    const std::vector<ScopeVariable>& variables = head == "self" ? scope.self : scope.bind;
    e.index = variable(list, variables);
    if (!failed()) e.type = variables[e.index].type;
  } else if (head == "call") {
    e.op = Op::Call;
    e.index = ref(list, system_.code.functions.size(), "function",
                  [&](std::uint32_t k) -> const std::string& { return system_.code.functions[k].name; });
    std::vector<ExprId> args;
    while (more(list)) args.push_back(expr(list, scope));
    if (!failed() && args.size() != system_.code.functions[e.index].params.size())
      fail(node, "a call has not one argument a parameter");
    if (!failed()) e.type = system_.code.functions[e.index].result;
    e.int_value = static_cast<std::int32_t>(system_.code.args.size());
    system_.code.args.insert(system_.code.args.end(), args.begin(), args.end());
  } else if (const std::optional<Op> op = op_of(head)) {
    e.op = *op;
    e.a = expr(list, scope);
    if (operand_count(e.op) == 2) e.b = expr(list, scope);
    if (!failed()) e.type = result_of(e.op, system_.code.exprs[e.a].type);
  } else {
    fail(node, "expected an expression; no operator has this name");
  }
  close(list);
  e.loc = list.loc;
  return failed() ? ExprId() : system_.code.exprs.push(e);
}

StmtId BsysReader::stmt(std::uint32_t node, const CodeScope& scope) {
  std::string_view head;
  List list = open(node, head);
  Stmt s;
  const auto store = [&](const std::vector<ScopeVariable>& variables) {
    s.index = variable(list, variables);
    if (!failed()) s.type = variables[s.index].type;
    s.value = expr(list, scope);
  };
  if (const std::optional<StmtOp> op = stmt_op_of(head)) {
    s.op = *op;
    switch (shape_of(s)) {
      case StmtShape::StoresSelf: store(scope.self); break;
      case StmtShape::StoresBind: store(scope.bind); break;
      case StmtShape::Chooses: {
        s.value = expr(list, scope);
        List then_list = need(list, "then");
        s.then_body = body(then_list, scope);
        if (std::optional<List> else_list = sub(list, "else")) s.else_body = body(*else_list, scope);
        break;
      }
      case StmtShape::Evaluates:
        s.value = expr(list, scope);
        if (!failed()) s.type = system_.code.exprs[s.value].type;
        break;
    }
  } else {
    fail(node, "expected a statement: set, set-bind, do or if");
  }
  close(list);
  s.loc = list.loc;
  return failed() ? StmtId() : system_.code.stmts.push(s);
}

StmtId BsysReader::body(List& list, const CodeScope& scope) {
  StmtId first, last;
  while (more(list)) {
    const StmtId id = stmt(next(list, "a statement"), scope);
    if (failed()) return {};
    (first.is_valid() ? system_.code.stmts[last].next : first) = id;
    last = id;
  }
  // A body's list has no place of its own.
  if (!failed() && list.loc.line != 0) fail(list.node, "no place belongs here");
  return first;
}

}  // namespace bip::system::text
