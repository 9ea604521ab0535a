// Reads a property: a small precedence climber over a system's names. Depth is limited.
#include <array>
#include <charconv>
#include <cstdlib>

#include "compiler/verify/property/property.hpp"

namespace bip::verify {

namespace {

constexpr int kMaxPropertyDepth = 200;

struct Binary {
  std::string_view sign;
  Op op;
  int level;
};
// Longer signs first.
constexpr std::array<Binary, 14> kBinaries{{{"||", Op::Or, 1},
                                            {"&&", Op::And, 2},
                                            {"==", Op::Eq, 6},
                                            {"!=", Op::Ne, 6},
                                            {"<=", Op::Le, 7},
                                            {">=", Op::Ge, 7},
                                            {"<", Op::Lt, 7},
                                            {">", Op::Gt, 7},
                                            {"|", Op::BitOr, 3},
                                            {"^", Op::BitXor, 4},
                                            {"&", Op::BitAnd, 5},
                                            {"+", Op::Add, 8},
                                            {"-", Op::Sub, 8},
                                            {"*", Op::Mul, 9}}};

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

class PropertyParser {
 public:
  PropertyParser(const std::string& text, const System& system) : text_(text), system_(system) {
    property_.text = text;
  }

  Result<Property> run() {
    const std::string word = path();
    if (word != "never" && word != "always") {
      at_ = 0;
      return fail("a property starts with `never` or `always`");
    }
    property_.is_never = word == "never";
    property_.root = expr(1, 0);
    skip();
    if (problem_.empty() && at_ != text_.size()) set_problem("this does not belong to the property");
    if (problem_.empty() && type(property_.root) != Type::Bool)
      set_problem("a property is true or false, this is " + std::string(name_of(type(property_.root))));
    if (!problem_.empty()) return Failure{problem_};
    return std::move(property_);
  }

 private:
  Result<Property> fail(const std::string& why) {
    set_problem(why);
    return Failure{problem_};
  }
  void set_problem(const std::string& why) {
    if (problem_.empty()) problem_ = "column " + std::to_string(at_ + 1) + ": " + why;
  }
  void skip() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n')) ++at_;
  }
  bool take(std::string_view sign) {
    skip();
    if (text_.compare(at_, sign.size(), sign) != 0) return false;
    at_ += sign.size();
    return true;
  }
  // "a", "a[3].b"; empty: no name here.
  std::string path() {
    skip();
    const std::size_t first = at_;
    while (at_ < text_.size() && is_letter(text_[at_])) {
      while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
      while (at_ < text_.size() && text_[at_] == '[') {
        std::size_t end = at_ + 1;
        while (end < text_.size() && is_digit(text_[end])) ++end;
        if (end == at_ + 1 || end >= text_.size() || text_[end] != ']') break;
        at_ = end + 1;
      }
      if (at_ + 1 >= text_.size() || text_[at_] != '.' || !is_letter(text_[at_ + 1])) break;
      ++at_;
    }
    return text_.substr(first, at_ - first);
  }
  [[nodiscard]] Type type(std::uint32_t row) const {
    return row < property_.nodes.size() ? property_.nodes[row].type : Type::Bool;
  }
  std::uint32_t add(PropertyNode node) {
    property_.nodes.push_back(node);
    return static_cast<std::uint32_t>(property_.nodes.size() - 1);
  }

  static std::string whole(const std::string& path) { return path.starts_with("ROOT.") ? path : "ROOT." + path; }
  [[nodiscard]] std::uint32_t atom_row(const std::string& path) const {
    for (std::size_t k = 0; k < system_.atoms.size(); ++k) {
      if (system_.atoms[AtomId(k)].path == whole(path)) return static_cast<std::uint32_t>(k);
    }
    return kNoAtom;
  }
  template <class Rows>
  static std::uint32_t row_of(const Rows& rows, const std::string& name) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (rows[k].name == name) return static_cast<std::uint32_t>(k);
    }
    return kNoAtom;
  }
  const AtomType& type_of(std::uint32_t atom) const {
    return system_.atom_types[system_.atoms[AtomId(std::size_t{atom})].type];
  }

  std::uint32_t named(const std::string& name, std::size_t start) {
    const auto wrong = [&](const std::string& why) {
      at_ = start;
      set_problem(why);
      return 0u;
    };
    if (take("@")) {
      const std::uint32_t atom = atom_row(name);
      if (atom == kNoAtom) return wrong("there is no component `" + name + "`");
      const std::string place = path();
      const std::vector<std::string>& places = type_of(atom).places;
      for (std::size_t k = 0; k < places.size(); ++k) {
        if (places[k] == place)
          return add({.kind = PropertyKind::At, .owner = atom, .row = static_cast<std::uint32_t>(k)});
      }
      return wrong("there is no place `" + place + "` in `" + name + "`");
    }
    const std::size_t dot = name.rfind('.');
    const std::uint32_t atom = dot == std::string::npos ? kNoAtom : atom_row(name.substr(0, dot));
    if (atom == kNoAtom) return wrong("`" + name + "` is no data: COMPONENT.DATA, or COMPONENT@PLACE");
    const std::uint32_t variable = row_of(type_of(atom).variables, name.substr(dot + 1));
    if (variable == kNoAtom)
      return wrong("there is no data `" + name.substr(dot + 1) + "` in `" + name.substr(0, dot) + "`");
    const Type cell_type = type_of(atom).variables[variable].type;
    if (is_ffi(cell_type)) return wrong("`" + name + "` is a C++ object");
    return add({.kind = PropertyKind::Data, .type = cell_type, .owner = atom, .row = variable});
  }
  std::uint32_t can(std::size_t start) {
    const std::string name = path();
    for (std::size_t k = 0; k < system_.connectors.size(); ++k) {
      if (system_.connectors[ConnectorId(k)].path != whole(name)) continue;
      if (system_.is_top(ConnectorId(k)))
        return add({.kind = PropertyKind::CanConnector, .owner = static_cast<std::uint32_t>(k)});
      at_ = start;
      set_problem("connector `" + name + "` exports a port: it is a part of others");
      return 0;
    }
    const std::size_t dot = name.rfind('.');
    const std::uint32_t atom = dot == std::string::npos ? kNoAtom : atom_row(name.substr(0, dot));
    const std::uint32_t port = atom == kNoAtom ? kNoAtom : row_of(type_of(atom).ports, name.substr(dot + 1));
    if (port != kNoAtom) return add({.kind = PropertyKind::CanPort, .owner = atom, .row = port});
    at_ = start;
    set_problem("there is no connector and no port `" + name + "`");
    return 0;
  }

  std::uint32_t string_constant() {
    std::string value;
    while (at_ < text_.size() && text_[at_] != '"') value += text_[at_++];
    if (!take("\"")) set_problem("this string has no end");
    PropertyNode node{.type = Type::String, .int_value = -1};
    for (std::size_t k = 0; k < system_.code.strings.size(); ++k) {
      if (system_.code.strings[k] == value) node.int_value = static_cast<std::int32_t>(k);
    }
    if (value.empty()) node.int_value = 0;
    return add(node);
  }
  std::uint32_t number() {
    std::size_t end = at_;
    bool is_float = false;
    while (end < text_.size() && (is_digit(text_[end]) || text_[end] == '.'))
      is_float = is_float || text_[end++] == '.';
    PropertyNode node{.type = is_float ? Type::Float : Type::Int};
    const char* first = text_.data() + at_;
    const char* last = text_.data() + end;
    if (is_float) node.float_value = std::strtod(std::string(first, last).c_str(), nullptr);
    else if (std::from_chars(first, last, node.int_value).ec != std::errc())
      set_problem("this number does not fit an `int`");
    at_ = end;
    return add(node);
  }

  std::uint32_t operand(int depth) {
    if (depth > kMaxPropertyDepth) {
      set_problem("nested too deeply");
      return 0;
    }
    skip();
    const std::size_t start = at_;
    if (take("(")) {
      const std::uint32_t inside = expr(1, depth + 1);
      if (!take(")")) set_problem("a `)` is missing");
      return inside;
    }
    if (take("!")) return unary(Op::Not, operand(depth + 1), start);
    if (take("-")) return unary(Op::Neg, operand(depth + 1), start);
    if (take("\"")) return string_constant();
    if (at_ < text_.size() && is_digit(text_[at_])) return number();
    const std::string name = path();
    if (name == "true" || name == "false") return add({.int_value = name == "true" ? 1 : 0});
    if (name == "can") return can(start);
    if (name.empty()) {
      set_problem(at_ == text_.size() ? "the property ends too early" : "a value was expected here");
      return 0;
    }
    return named(name, start);
  }
  std::uint32_t unary(Op op, std::uint32_t a, std::size_t start) {
    const bool fits = op == Op::Not ? type(a) == Type::Bool : type(a) == Type::Int || type(a) == Type::Float;
    if (!fits && problem_.empty()) {
      at_ = start;
      set_problem(op == Op::Not ? "`!` needs a truth value" : "`-` needs a number");
    }
    return add({.kind = PropertyKind::Operator, .type = type(a), .op = op, .a = a, .b = a});
  }
  std::uint32_t expr(int level, int depth) {
    std::uint32_t left = operand(depth);
    while (problem_.empty()) {
      skip();
      const std::size_t start = at_;
      const Binary* found = nullptr;
      for (const Binary& binary : kBinaries) {
        if (found == nullptr && text_.compare(at_, binary.sign.size(), binary.sign) == 0) found = &binary;
      }
      if (found == nullptr || found->level < level) return left;
      at_ += found->sign.size();
      const std::uint32_t right = expr(found->level + 1, depth + 1);
      if (!problem_.empty()) return left;
      left = join(*found, left, right, start);
    }
    return left;
  }
  std::uint32_t join(const Binary& sign, std::uint32_t a, std::uint32_t b, std::size_t start) {
    const auto is_number = [&](std::uint32_t row) { return type(row) == Type::Int || type(row) == Type::Float; };
    const bool numbers = is_number(a) && is_number(b), ints = type(a) == Type::Int && type(b) == Type::Int;
    bool fits = false;
    Type result = Type::Bool;
    switch (sign.op) {
      case Op::And:
      case Op::Or: fits = type(a) == Type::Bool && type(b) == Type::Bool; break;
      case Op::Eq:
      case Op::Ne: fits = numbers || type(a) == type(b); break;
      case Op::Lt:
      case Op::Le:
      case Op::Gt:
      case Op::Ge: fits = numbers; break;
      case Op::Add:
      case Op::Sub:
      case Op::Mul:
        fits = numbers;
        result = ints ? Type::Int : Type::Float;
        break;
      default:
        fits = ints;
        result = Type::Int;
        break;
    }
    if (!fits) {
      at_ = start;
      set_problem("`" + std::string(sign.sign) + "` does not take " + name_of(type(a)) + " and " + name_of(type(b)));
    }
    return add({.kind = PropertyKind::Operator, .type = result, .op = sign.op, .a = a, .b = b});
  }

  static constexpr std::uint32_t kNoAtom = 0xffffffffu;
  const std::string& text_;
  const System& system_;
  Property property_;
  std::string problem_;
  std::size_t at_ = 0;
};

}  // namespace

Result<Property> parse_property(const std::string& text, const System& system) {
  return PropertyParser(text, system).run();
}

}  // namespace bip::verify
