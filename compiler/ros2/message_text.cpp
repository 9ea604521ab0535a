// See message_text.hpp.
#include "compiler/ros2/message_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/base/ascii.hpp"

namespace bip::ros2 {
namespace {

// "SLOW": in a .msg file.
std::string constant(const std::string& field, const std::string& word) {
  std::string out = snake(field) + "_" + snake(word);
  std::transform(out.begin(), out.end(), out.begin(), [](char c) { return large(c); });
  return out;
}

}  // namespace

std::string snake(const std::string& name) {
  std::string out;
  for (std::size_t k = 0; k < name.size(); ++k) {
    const char c = name[k];
    const bool is_word = is_small(c) || is_large(c) || is_digit(c);
    const bool is_new = is_large(c) && k > 0 && (is_small(name[k - 1]) || is_digit(name[k - 1]));
    if ((is_new || !is_word) && !out.empty() && out.back() != '_') out += '_';
    if (is_word) out += small(c);
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out.empty() || is_digit(out[0]) ? "x" + out : out;
}

std::string type_text(const Field& f, const std::string& package, Dialect dialect) {
  const bool has_bounds = dialect == Dialect::Ros2;
  std::string out;
  switch (f.kind) {
    case Kind::Message:
      out = f.message;
      // Of the same package without its name; "time" of ROS 1 has none.
      if (const std::size_t slash = out.rfind('/'); out.starts_with(package + "/")) out.erase(0, slash + 1);
      else if (slash != std::string::npos) out = out.substr(0, out.find('/')) + out.substr(slash);
      break;
    case Kind::Int8: out = "int8"; break;
    case Kind::UInt8: out = "uint8"; break;
    case Kind::Int16: out = "int16"; break;
    case Kind::UInt16: out = "uint16"; break;
    case Kind::Int32: out = "int32"; break;
    case Kind::UInt32: out = "uint32"; break;
    case Kind::Int64: out = "int64"; break;
    case Kind::UInt64: out = "uint64"; break;
    case Kind::Float32: out = "float32"; break;
    case Kind::Float64: out = "float64"; break;
    case Kind::Bool: out = "bool"; break;
    case Kind::String: out = "string"; break;
    case Kind::BoundedString: out = has_bounds ? fmt::format("string<={}", f.text_bound) : "string"; break;
  }
  switch (f.shape) {
    case Shape::One: break;
    case Shape::Array: out += fmt::format("[{}]", f.count); break;
    case Shape::Bounded: out += has_bounds ? fmt::format("[<={}]", f.count) : "[]"; break;
    case Shape::Sequence: out += "[]"; break;
  }
  return out;
}

std::string constants_text(const std::vector<Field>& fields) {
  std::string out;
  for (const Field& f : fields) {
    for (std::size_t k = 0; k < f.words.size(); ++k)
      out += fmt::format("int32 {}={}\n", constant(f.name, f.words[k]), k);
  }
  return out;
}

std::string fields_text(const std::vector<Field>& fields, const std::string& package, Dialect dialect) {
  std::string out = constants_text(fields);
  for (const Field& f : fields) {
    const bool is_initial = !f.initial.empty() && dialect == Dialect::Ros2;
    out += fmt::format("{} {}{}{}\n", type_text(f, package, dialect), f.name, is_initial ? " " : "",
                       is_initial ? f.initial : "");
  }
  return out;
}

}  // namespace bip::ros2
