// Parses a property by precedence climbing (Richards, Whitby-Strevens 1979), with the names of a system
// resolved on the way. Nesting and the number of nodes are limited: what follows the tree of nodes recurs. The first
// problem ends the parse. Cost: linear in the text and in the number of atoms and connectors.
#include <algorithm>
#include <charconv>
#include <unordered_map>

#include "compiler/model/operators.hpp"
#include "compiler/verify/property/expression.hpp"
#include "compiler/base/ascii.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr int kMaxPropertyDepth = 200;
// A chain `a || b || c …` is a tree half as deep as it has nodes; the checker of certificates reads 10,000 levels.
constexpr std::size_t kMaxPropertyNodes = 16'000;

struct BinaryOperator {
  std::string_view sign;
  Op op;
  int level;
};
// Returns all binary operators but divisions, longer signs first.
const std::vector<BinaryOperator>& binary_operators() {
  static const std::vector<BinaryOperator> kBinaryOperators = [] {
    std::vector<BinaryOperator> rows;
    for (std::size_t row = 0; row < kOperators.size(); ++row) {
      const Op op = static_cast<Op>(row);
      if (operand_count(op) == 2 && !is_division(op))
        rows.push_back({symbol_of(op), op, static_cast<int>(precedence_of(op))});
    }
    std::stable_sort(rows.begin(), rows.end(),
                     [](const BinaryOperator& a, const BinaryOperator& b) { return a.sign.size() > b.sign.size(); });
    return rows;
  }();
  return kBinaryOperators;
}

bool begins_name(char c) { return is_letter(c) || c == '_'; }

class PropertyParser {
 public:
  PropertyParser(const std::string& text, const System& system) : text_(text), system_(system) {
    property_.text = text;
  }

  Result<Property> run_expression() {
    property_.root = parse_expression(1, 0);
    skip_blanks();
    if (problem_.empty() && at_ != text_.size()) set_problem("this does not belong to the expression");
    if (!problem_.empty()) return Failure{problem_};
    return std::move(property_);
  }

  Result<Property> run() {
    const std::string word = parse_path();
    if (word != "never" && word != "always") {
      at_ = 0;
      return fail("a property starts with `never` or `always`");
    }
    property_.is_never = word == "never";
    parse_whole("this does not belong to the property");
    if (problem_.empty() && type(property_.root) != Type::Bool)
      set_problem("a property is true or false, this is " + std::string(name_of(type(property_.root))));
    if (!problem_.empty()) return Failure{problem_};
    return std::move(property_);
  }
  Result<Property> run_value() {
    parse_whole("this does not belong to the expression");
    if (problem_.empty() && !is_numeric(type(property_.root)) && type(property_.root) != Type::Bool)
      set_problem("a number or a condition was expected, this is " + std::string(name_of(type(property_.root))));
    if (!problem_.empty()) return Failure{problem_};
    return std::move(property_);
  }

 private:
  void parse_whole(const char* about_the_rest) {
    property_.root = parse_expression(1, 0);
    skip_blanks();
    if (problem_.empty() && at_ != text_.size()) set_problem(about_the_rest);
  }
  Result<Property> fail(const std::string& why) {
    set_problem(why);
    return Failure{problem_};
  }
  void set_problem(const std::string& why) {
    if (problem_.empty()) problem_ = "column " + std::to_string(at_ + 1) + ": " + why;
  }
  void skip_blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n')) ++at_;
  }
  bool take_sign(std::string_view sign) {
    skip_blanks();
    if (text_.compare(at_, sign.size(), sign) != 0) return false;
    at_ += sign.size();
    return true;
  }
  // "a", "a[3].b"; empty: no name here.
  std::string parse_path() {
    skip_blanks();
    const std::size_t first = at_;
    while (at_ < text_.size() && begins_name(text_[at_])) {
      while (at_ < text_.size() && (begins_name(text_[at_]) || is_digit(text_[at_]))) ++at_;
      while (at_ < text_.size() && text_[at_] == '[') {
        std::size_t end = at_ + 1;
        while (end < text_.size() && is_digit(text_[end])) ++end;
        if (end == at_ + 1 || end >= text_.size() || text_[end] != ']') break;
        at_ = end + 1;
      }
      if (at_ + 1 >= text_.size() || text_[at_] != '.' || !begins_name(text_[at_ + 1])) break;
      ++at_;
    }
    return text_.substr(first, at_ - first);
  }
  [[nodiscard]] Type type(std::uint32_t row) const {
    return row < property_.nodes.size() ? property_.nodes[row].type : Type::Bool;
  }
  std::uint32_t add(PropertyNode node) {
    // After a problem rows are placeholders.
    BIP_ASSERT(!problem_.empty() || node.kind != PropertyKind::Operator ||
                   (node.a < property_.nodes.size() && node.b < property_.nodes.size()),
               "an operator before its operands");
    if (property_.nodes.size() == kMaxPropertyNodes)
      set_problem("the property has more than " + std::to_string(kMaxPropertyNodes) + " values and operators");
    property_.nodes.push_back(node);
    return static_cast<std::uint32_t>(property_.nodes.size() - 1);
  }

  static std::string absolute_path(const std::string& path) {
    return path.starts_with("ROOT.") ? path : "ROOT." + path;
  }
  using RowsByPath = std::unordered_map<std::string_view, std::uint32_t>;
  template <class Rows>
  static RowsByPath rows_by_path(const Rows& rows) {
    RowsByPath found;
    std::uint32_t row = 0;
    for (const auto& row_of_path : rows) found.try_emplace(row_of_path.path, row++);
    return found;
  }
  static std::uint32_t find_path(const RowsByPath& rows, const std::string& path) {
    const auto found = rows.find(absolute_path(path));
    return found == rows.end() ? kNotFound : found->second;
  }
  [[nodiscard]] std::uint32_t find_atom(const std::string& path) const { return find_path(atoms_, path); }
  template <class Rows>
  static std::uint32_t find_row(const Rows& rows, const std::string& name) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (rows[k].name == name) return static_cast<std::uint32_t>(k);
    }
    return kNotFound;
  }
  const AtomType& type_of(std::uint32_t atom) const {
    return system_.atom_types[system_.atoms[AtomId(std::size_t{atom})].type];
  }

  std::uint32_t parse_reference(const std::string& name, std::size_t start) {
    const auto wrong = [&](const std::string& why) {
      at_ = start;
      set_problem(why);
      return 0u;
    };
    if (take_sign("@")) {
      const std::uint32_t atom = find_atom(name);
      if (atom == kNotFound) return wrong("there is no component `" + name + "`");
      const std::string place = parse_path();
      const std::vector<std::string>& places = type_of(atom).places;
      for (std::size_t k = 0; k < places.size(); ++k) {
        if (places[k] == place)
          return add({.kind = PropertyKind::At, .owner = atom, .row = static_cast<std::uint32_t>(k)});
      }
      return wrong("there is no place `" + place + "` in `" + name + "`");
    }
    const std::size_t dot = name.rfind('.');
    const std::uint32_t atom = dot == std::string::npos ? kNotFound : find_atom(name.substr(0, dot));
    if (atom == kNotFound) return wrong("`" + name + "` is no data: COMPONENT.DATA, or COMPONENT@PLACE");
    const std::uint32_t variable = find_row(type_of(atom).variables, name.substr(dot + 1));
    if (variable == kNotFound)
      return wrong("there is no data `" + name.substr(dot + 1) + "` in `" + name.substr(0, dot) + "`");
    const Type cell_type = type_of(atom).variables[variable].type;
    if (is_ffi(cell_type)) return wrong("`" + name + "` is a C++ object");
    return add({.kind = PropertyKind::Data, .type = cell_type, .owner = atom, .row = variable});
  }
  std::uint32_t parse_can(std::size_t start) {
    const std::string name = parse_path();
    const std::uint32_t connector = find_path(connectors_, name);
    if (connector != kNotFound) {
      if (system_.is_top(ConnectorId(std::size_t{connector})))
        return add({.kind = PropertyKind::CanConnector, .owner = connector});
      at_ = start;
      set_problem("connector `" + name + "` exports a port: it is a part of others");
      return 0;
    }
    const std::size_t dot = name.rfind('.');
    const std::uint32_t atom = dot == std::string::npos ? kNotFound : find_atom(name.substr(0, dot));
    const std::uint32_t port = atom == kNotFound ? kNotFound : find_row(type_of(atom).ports, name.substr(dot + 1));
    if (port != kNotFound) return add({.kind = PropertyKind::CanPort, .owner = atom, .row = port});
    at_ = start;
    set_problem("there is no connector and no port `" + name + "`");
    return 0;
  }

  std::uint32_t parse_string() {
    std::string value;
    while (at_ < text_.size() && text_[at_] != '"') value += text_[at_++];
    if (!take_sign("\"")) set_problem("this string has no end");
    PropertyNode node{.type = Type::String, .int_value = -1};
    for (std::size_t k = 0; k < system_.code.strings.size(); ++k) {
      if (system_.code.strings[k] == value) node.int_value = static_cast<std::int32_t>(k);
    }
    if (value.empty()) node.int_value = 0;
    return add(node);
  }
  // As in models: "3", "1.5", ".5", "2.", "1e3".
  std::uint32_t parse_number() {
    const std::size_t first = at_;
    const auto skip_digits = [&] {
      while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
    };
    skip_digits();
    bool is_float = at_ < text_.size() && text_[at_] == '.';
    if (is_float) ++at_;
    skip_digits();
    if (at_ < text_.size() && (text_[at_] == 'e' || text_[at_] == 'E')) {
      std::size_t digits = at_ + 1;
      if (digits < text_.size() && (text_[digits] == '+' || text_[digits] == '-')) ++digits;
      if (digits < text_.size() && is_digit(text_[digits])) {
        is_float = true;
        at_ = digits;
        skip_digits();
      }
    }
    PropertyNode node{.type = is_float ? Type::Float : Type::Int};
    const char* begin = text_.data() + first;
    const char* end = text_.data() + at_;
    const bool fits = is_float ? std::from_chars(begin, end, node.float_value).ec == std::errc()
                               : std::from_chars(begin, end, node.int_value).ec == std::errc();
    if (!fits) {
      at_ = first;
      set_problem(is_float ? "this number does not fit a `float`" : "this number does not fit an `int`");
    }
    return add(node);
  }
  [[nodiscard]] bool is_at_number() const {
    const std::size_t digit = at_ < text_.size() && text_[at_] == '.' ? at_ + 1 : at_;
    return digit < text_.size() && is_digit(text_[digit]);
  }

  std::uint32_t parse_operand(int depth) {
    if (depth > kMaxPropertyDepth) {
      set_problem("nested too deeply");
      return 0;
    }
    skip_blanks();
    const std::size_t start = at_;
    if (take_sign("(")) {
      const std::uint32_t inside = parse_expression(1, depth + 1);
      if (!take_sign(")")) set_problem("a `)` is missing");
      return inside;
    }
    if (take_sign("!")) return make_unary(Op::Not, parse_operand(depth + 1), start);
    if (take_sign("-")) return make_unary(Op::Neg, parse_operand(depth + 1), start);
    if (take_sign("\"")) return parse_string();
    if (is_at_number()) return parse_number();
    const std::string name = parse_path();
    if (name == "true" || name == "false") return add({.int_value = name == "true" ? 1 : 0});
    if (name == "can") return parse_can(start);
    if (name.empty()) {
      set_problem(at_ == text_.size() ? "the property ends too early" : "a value was expected here");
      return 0;
    }
    return parse_reference(name, start);
  }
  std::uint32_t make_unary(Op op, std::uint32_t a, std::size_t start) {
    const bool fits = op == Op::Not ? type(a) == Type::Bool : type(a) == Type::Int || type(a) == Type::Float;
    if (!fits && problem_.empty()) {
      at_ = start;
      set_problem(op == Op::Not ? "`!` needs a truth value" : "`-` needs a number");
    }
    return add({.kind = PropertyKind::Operator, .type = type(a), .op = op, .a = a, .b = a});
  }
  std::uint32_t parse_expression(int level, int depth) {
    std::uint32_t left = parse_operand(depth);
    while (problem_.empty()) {
      skip_blanks();
      const std::size_t start = at_;
      const BinaryOperator* found = nullptr;
      for (const BinaryOperator& binary : binary_operators()) {
        if (found == nullptr && text_.compare(at_, binary.sign.size(), binary.sign) == 0) found = &binary;
      }
      if (found == nullptr || found->level < level) return left;
      at_ += found->sign.size();
      const std::uint32_t right = parse_expression(found->level + 1, depth + 1);
      if (!problem_.empty()) return left;
      left = make_binary(*found, left, right, start);
    }
    return left;
  }
  std::uint32_t make_binary(const BinaryOperator& binary, std::uint32_t a, std::uint32_t b, std::size_t start) {
    const bool numbers = is_numeric(type(a)) && is_numeric(type(b));
    const OperandTypes operands = info_of(binary.op).operands;
    const bool fits = operands == OperandTypes::Native ? numbers || type(a) == type(b)
                                                       : takes(operands, type(a)) && takes(operands, type(b));
    const bool is_float = type(a) == Type::Float || type(b) == Type::Float;
    const Type result = result_of(binary.op, is_float ? Type::Float : Type::Int);
    if (!fits) {
      at_ = start;
      set_problem("`" + std::string(binary.sign) + "` does not take " + name_of(type(a)) + " and " + name_of(type(b)));
    }
    return add({.kind = PropertyKind::Operator, .type = result, .op = binary.op, .a = a, .b = b});
  }

  static constexpr std::uint32_t kNotFound = 0xffffffffu;
  const std::string& text_;
  const System& system_;
  const RowsByPath atoms_ = rows_by_path(system_.atoms), connectors_ = rows_by_path(system_.connectors);
  Property property_;
  std::string problem_;
  std::size_t at_ = 0;
};

}  // namespace

Result<Property> parse_property(const std::string& text, const System& system) {
  return PropertyParser(text, system).run();
}

Result<Property> parse_value(const std::string& text, const System& system) {
  return PropertyParser(text, system).run_value();
}

Result<Property> parse_expression(const std::string& text, const System& system) {
  return PropertyParser(text, system).run_expression();
}

}  // namespace bip::verify
