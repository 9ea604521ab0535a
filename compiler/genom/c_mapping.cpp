// See c_mapping.hpp.
#include "compiler/genom/c_mapping.hpp"

#include <fmt/format.h>

#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

using idl::Component;
using idl::Direction;
using idl::Kind;

// "double name[3]".
std::string declared(const Component& c, std::size_t type, const std::string& name) {
  BIP_ASSERT(type < c.types.size(), "`{}` is of type {} of {}", name, type, c.types.size());
  BIP_ASSERT(c.types[type].kind != Kind::Array || c.types[type].bound > 0, "array `{}` has {} elements", name,
             c.types[type].bound);
  const idl::Type& t = c.types[type];
  switch (t.kind) {
    case Kind::Array: return declared(c, t.element, fmt::format("{}[{}]", name, t.bound));
    case Kind::String: return t.bound == 0 ? "char *" + name : fmt::format("char {}[{}]", name, t.bound + 1);
    case Kind::Native: return fmt::format("{} *{}", t.c_name, name);
    case Kind::Primitive:
    case Kind::Sequence:
    case Kind::Optional:
    case Kind::Struct:
    case Kind::Union:
    case Kind::Enum:
    case Kind::Alias: break;
  }
  return t.c_name + " " + name;
}

// A type that several components know is defined once in a program.
std::string guarded_definition(const std::string& name, const std::string& text) {
  return fmt::format("\n#ifndef GENOM_TYPE_{0}\n#define GENOM_TYPE_{0}\n{1}#endif\n", name, text);
}

std::string definition(const Component& c, const idl::Type& t) {
  switch (t.kind) {
    case Kind::Primitive:
    case Kind::String:
    case Kind::Array: return {};
    case Kind::Alias:
      return guarded_definition(t.c_name, fmt::format("typedef {};\n", declared(c, t.element, t.c_name)));
    case Kind::Native: return guarded_definition(t.c_name, fmt::format("typedef struct {0} {0};\n", t.c_name));
    case Kind::Enum: {
      std::string list;
      for (const std::string& e : t.enumerators) list += (list.empty() ? "" : ", ") + t.prefix + e;
      return guarded_definition(t.c_name, fmt::format("typedef enum {0} {{ {1} }} {0};\n", t.c_name, list));
    }
    case Kind::Struct:
      return guarded_definition(
          t.c_name, fmt::format("typedef struct {0} {{\n{1}}} {0};\n", t.c_name, c_members(c, t.members, "  ")));
    case Kind::Union:
      return guarded_definition(
          t.c_name, fmt::format("typedef struct {0} {{\n  {1};\n  union {{\n{2}  }} _u;\n}} {0};\n", t.c_name,
                                declared(c, t.element, "_d"), c_members(c, t.members, "    ")));
    case Kind::Optional:
      return guarded_definition(t.c_name, fmt::format("typedef struct {0} {{\n  bool _present;\n  {1};\n}} {0};\n",
                                                      t.c_name, declared(c, t.element, "_value")));
    case Kind::Sequence:
      return guarded_definition(
          t.c_name, t.bound == 0
                        ? fmt::format("typedef struct {0} {{\n  uint32_t _maximum, _length;\n  {1};\n  void "
                                      "(*_release)(void *);\n}} {0};\n",
                                      t.c_name, declared(c, t.element, "*_buffer"))
                        : fmt::format("typedef struct {0} {{\n  uint32_t _maximum, _length;\n  {1};\n}} {0};\n",
                                      t.c_name, declared(c, t.element, fmt::format("_buffer[{}]", t.bound))));
  }
  return {};
}

}  // namespace

std::string c_members(const Component& c, const std::vector<idl::Member>& members, const std::string& indent) {
  std::string out;
  for (const idl::Member& m : members) out += indent + declared(c, m.type, m.name) + ";\n";
  return out.empty() ? indent + "char genom_nothing;\n" : out;
}

bool is_passed_by_value(const idl::Type& t) {
  return t.kind == Kind::Primitive || t.kind == Kind::Enum || t.kind == Kind::Native;
}
// In C the name of it is a pointer already.
bool decays(const idl::Type& t) { return t.kind == Kind::Array || (t.kind == Kind::String && t.bound != 0); }

// The type of a parameter, without its name.
std::string c_parameter(const Component& c, std::size_t type, Direction direction, const std::string& name) {
  const idl::Type& plain = c.plain(type);
  const bool is_in = direction == Direction::In, is_alias = c.types[type].kind == Kind::Alias;
  if (is_in && plain.kind == Kind::Native) return fmt::format("const {} *{}", plain.c_name, name);
  if (is_in && plain.kind == Kind::String) return "const char *" + name;
  std::string text;
  if (decays(plain)) text = is_alias ? c.types[type].c_name + " " + name : declared(c, type, name);
  else if (is_in && is_passed_by_value(plain)) return c.types[type].c_name + (name.empty() ? "" : " " + name);
  else text = declared(c, type, "*" + name);
  return (is_in ? "const " : "") + text;
}

std::string c_types_header(const Component& c) {
  std::string out = fmt::format(
      "/* Types of {0}, as genom3 names them in C. Written by `bipc genom --codels`. */\n#ifndef GENOM_{0}_C_TYPES_H\n"
      "#define GENOM_{0}_C_TYPES_H\n#include \"bip/genom3.h\"\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n",
      c.name);
  for (const idl::Constant& k : c.constants)
    out += fmt::format("\n#ifndef {0}\n#define {0} ({1})\n#endif\n", k.c_name, k.value);
  for (const idl::Type& t : c.types) out += definition(c, t);
  for (const idl::Exception& e : c.exceptions) {
    std::string text = fmt::format("extern const genom_event {}_id;\n", e.c_name);
    if (e.members.empty()) {
      text += fmt::format("genom_event {}(genom_context self);\n", e.c_name);
    } else {
      text += fmt::format(
          "typedef struct {0}_detail {{\n{1}}} {0}_detail;\ngenom_event {0}(const {0}_detail *detail, genom_context "
          "self);\n",
          e.c_name, c_members(c, e.members, "  "));
    }
    out += guarded_definition(e.c_name, text);
  }
  return out + "\n#ifdef __cplusplus\n}\n#endif\n#endif\n";
}

std::string c_port_struct(const Component& c, const idl::Port& p) {
  const char* const id = p.is_multiple ? "const char *id, " : "";
  std::string out = fmt::format("\ntypedef struct {}_{} {{\n  {};\n", c.name, p.name,
                                declared(c, p.type, fmt::format("*(*data)({}genom_context self)", id)));
  out += fmt::format("  genom_event (*{})({}genom_context self);\n", p.is_out ? "write" : "read", id);
  if (p.is_multiple)
    out +=
        "  genom_event (*open)(const char *id, genom_context self);\n  genom_event (*close)(const char *id, "
        "genom_context self);\n";
  return out + fmt::format("}} {}_{};\n", c.name, p.name);
}

std::string c_members_functions(const Component& c, std::set<std::string>& done) {
  std::string out;
  const auto visits = [](const std::vector<idl::Member>& members) {
    std::string text;
    for (const idl::Member& m : members) text += fmt::format(" f(\"{0}\", v.{0});", m.name);
    return text;
  };
  const auto function = [&](const std::string& type, const std::string& body) {
    if (done.insert(type).second)
      out += fmt::format("template <class F>\nvoid genom_members({}& v, F f) {{{} (void)v, (void)f; }}\n", type, body);
  };
  for (const idl::Type& t : c.types) {
    if (t.kind == Kind::Struct) function(t.c_name, visits(t.members));
    if (t.kind == Kind::Enum && done.insert(t.c_name).second) {
      std::string rows;
      for (const std::string& e : t.enumerators) rows += fmt::format("{{\"{}\", {}{}}}, ", e, t.prefix, e);
      out += fmt::format(
          "inline auto genom_enumerators({0}) {{\n  static constexpr std::pair<const char*, {0}> kRows[] = {{{1}}};\n  "
          "return "
          "std::span(kRows);\n}}\n",
          t.c_name, rows);
    }
    if (t.kind != Kind::Union) continue;
    std::string body = " f(\"_d\", v._d);\n  switch (v._d) {\n";
    bool has_default = false;
    for (const idl::Member& m : t.members) {
      for (const std::string& label : m.labels) body += fmt::format("    case {}:\n", label);
      if (m.labels.empty()) body += "    default:\n";
      has_default = has_default || m.labels.empty();
      body += fmt::format("      return f(\"{0}\", v._u.{0});\n", m.name);
    }
    function(t.c_name, body + (has_default ? "  }\n" : "    default: break;\n  }\n"));
  }
  for (const idl::Exception& e : c.exceptions) {
    if (!e.members.empty()) function(e.c_name + "_detail", visits(e.members));
  }
  return out;
}

}  // namespace bip::genom
