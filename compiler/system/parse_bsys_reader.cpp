// The cursor over the tree of a .bsys text: see parse_bsys_reader.hpp.
#include "compiler/system/parse_bsys_reader.hpp"

#include <fmt/format.h>

#include <charconv>

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
  if (!type && !s_.code.ffi_types.empty()) {
    list.at = node;
    return ffi_type(ref(list, s_.code.ffi_types.size(), "type",
                        [&](std::uint32_t k) -> const std::string& { return s_.code.ffi_types[k].name; }));
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
    if (s_.code.strings.empty()) add_string("");
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
  if (!strings_.emplace(text, static_cast<std::uint32_t>(s_.code.strings.size())).second) return false;
  s_.code.strings.push_back(text);
  return true;
}

}  // namespace bip::system::text
