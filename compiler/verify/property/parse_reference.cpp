// The operands of a property that name what a system has (places, data, what is possible and what happens), and the
// values that are written as such.
#include <charconv>

#include "compiler/verify/property/property_parser.hpp"
#include "compiler/verify/property/property_words.hpp"
#include "runtime/core/text.hpp"

namespace bip::verify {

namespace {

constexpr std::uint32_t kNotFound = 0xffffffffu;

std::uint32_t find_path(const RowsByPath& rows, const std::string& path) {
  const auto found = rows.find(rt::whole_path(path));
  return found == rows.end() ? kNotFound : found->second;
}

template <class Rows>
std::uint32_t find_row(const Rows& rows, const std::string& name) {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (rows[k].name == name) return static_cast<std::uint32_t>(k);
  }
  return kNotFound;
}

}  // namespace

std::uint32_t PropertyParser::find_atom(const std::string& path) const { return find_path(rows_.atoms, path); }

const AtomType& PropertyParser::type_of(std::uint32_t atom) const {
  return system_.atom_types[system_.atoms[AtomId(std::size_t{atom})].type];
}

std::uint32_t PropertyParser::parse_reference(const std::string& name, std::size_t start) {
  const auto wrong = [&](const std::string& why) {
    at_ = start;
    set_problem(why);
    return 0u;
  };
  if (take_sign("@")) {
    const std::uint32_t atom = find_atom(name);
    if (atom == kNotFound) return wrong("there is no component `" + name + "`");
    const std::string place = parse_path();
    if (place.empty()) return wrong("a place of `" + name + "` is missing behind `@`");
    const std::vector<std::string>& places = type_of(atom).places;
    for (std::size_t k = 0; k < places.size(); ++k) {
      if (places[k] == place)
        return add({.kind = PropertyKind::At, .owner = atom, .row = static_cast<std::uint32_t>(k)});
    }
    return wrong("there is no place `" + place + "` in `" + name + "`");
  }
  const std::size_t dot = name.rfind('.');
  const std::uint32_t atom = dot == std::string::npos ? kNotFound : find_atom(name.substr(0, dot));
  for (const OtherSign& other : kOtherFunctions) {
    if (name == other.sign) return wrong(std::string(other.word));
  }
  if (!accepts_formulas_ && name == "possibly")
    return wrong("`possibly` asks what may follow a state, which `bipc verify --property` answers");
  // The first word of all.
  if (accepts_formulas_ && start == 0 && dot == std::string::npos)
    return wrong("a property starts with `never`, `always`, `eventually` or a condition, not with `" + name + "`");
  if (atom == kNotFound && (is_beside_text_ || is_before_text()))
    return wrong("`" + name + "` is no data: text is written in quotes, `\"" + name + "\"`");
  if (atom == kNotFound) return wrong("`" + name + "` is no data: COMPONENT.DATA, or COMPONENT@PLACE");
  const std::uint32_t variable = find_row(type_of(atom).variables, name.substr(dot + 1));
  if (variable == kNotFound)
    return wrong("there is no data `" + name.substr(dot + 1) + "` in `" + name.substr(0, dot) + "`");
  const Type cell_type = type_of(atom).variables[variable].type;
  if (is_ffi(cell_type)) return wrong("`" + name + "` is a C++ object");
  return add({.kind = PropertyKind::Data, .type = cell_type, .owner = atom, .row = variable});
}

bool PropertyParser::is_before_text() {
  if (!take_sign("==") && !take_sign("!=")) return false;
  const std::string path = parse_path();
  const std::size_t dot = path.rfind('.');
  const std::uint32_t atom = dot == std::string::npos ? kNotFound : find_atom(path.substr(0, dot));
  const std::uint32_t variable =
      atom == kNotFound ? kNotFound : find_row(type_of(atom).variables, path.substr(dot + 1));
  return variable != kNotFound && type_of(atom).variables[variable].type == Type::String;
}

std::uint32_t PropertyParser::parse_offer(std::size_t start, PropertyKind of_connector, PropertyKind of_port) {
  if (of_connector == PropertyKind::HappensConnector && !happens_at_) happens_at_ = start;
  const std::string name = parse_path();
  const std::uint32_t connector = find_path(rows_.connectors, name);
  if (connector != kNotFound) {
    if (system_.is_top(ConnectorId(std::size_t{connector}))) return add({.kind = of_connector, .owner = connector});
    at_ = start;
    set_problem("connector `" + name + "` exports a port: it is a part of others");
    return 0;
  }
  const std::size_t dot = name.rfind('.');
  const std::uint32_t atom = dot == std::string::npos ? kNotFound : find_atom(name.substr(0, dot));
  const std::uint32_t port = atom == kNotFound ? kNotFound : find_row(type_of(atom).ports, name.substr(dot + 1));
  if (port != kNotFound) return add({.kind = of_port, .owner = atom, .row = port});
  at_ = start;
  set_problem("there is no connector and no port `" + name + "`");
  return 0;
}

std::uint32_t PropertyParser::parse_string() {
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

std::uint32_t PropertyParser::parse_number() {
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

}  // namespace bip::verify
