// See cxx_mapping.hpp. Modules and components are namespaces. A type inside of another type stands beside it, named
// after both (`demo::drive_s_limit_s`), and the outer one has an alias of its short name.
#include "compiler/genom/cxx_mapping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "compiler/genom/remote_services.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

using idl::Component;
using idl::Kind;

// The place of a name in C++: "demo::inner", and the rest of the name with `_`.
struct CxxName {
  std::string scope, name;
  [[nodiscard]] std::string whole() const { return (scope.empty() ? "::" : "::" + scope + "::") + name; }
};

CxxName cxx_name(const std::string& full_name, std::size_t namespaces) {
  CxxName result;
  std::size_t begin = 0;
  for (std::size_t k = 0;; ++k) {
    const std::size_t end = full_name.find("::", begin);
    const std::string step = full_name.substr(begin, end == std::string::npos ? end : end - begin);
    std::string& into = k < namespaces ? result.scope : result.name;
    if (!into.empty()) into += k < namespaces ? "::" : "_";
    into += step;
    if (end == std::string::npos) return result;
    begin = end + 2;
  }
}
CxxName cxx_name(const idl::Type& t) { return cxx_name(t.full_name, t.namespaces); }

std::string outer_of(const std::string& full_name) {
  const std::size_t at = full_name.rfind("::");
  return at == std::string::npos ? "" : full_name.substr(0, at);
}
std::string last_of(const std::string& full_name) {
  const std::size_t at = full_name.rfind("::");
  return at == std::string::npos ? full_name : full_name.substr(at + 2);
}

// They belong to the scope around the enumeration.
CxxName enumerator_name(const idl::Type& t, const std::string& enumerator) {
  const std::string outer = outer_of(t.full_name);
  return cxx_name(outer.empty() ? enumerator : outer + "::" + enumerator, t.namespaces);
}

std::string in_namespace(const std::string& scope, const std::string& text) {
  return scope.empty() ? text : fmt::format("namespace {} {{\n{}}}\n", scope, text);
}

// A type that several components know is defined once in a program.
std::string guarded_in_cxx(const std::string& name, const std::string& text) {
  return fmt::format("\n#ifndef GENOM_CXX_TYPE_{0}\n#define GENOM_CXX_TYPE_{0}\n{1}#endif\n", name, text);
}

// `using limit_s = ::demo::drive_s_limit_s;`, for types that are declared inside of `full_name`.
std::string aliases_of(const Component& c, const std::string& full_name, const std::string& indent) {
  std::string out;
  std::set<std::string> done;
  for (const idl::Type& t : c.types) {
    if (!t.full_name.empty() && outer_of(t.full_name) == full_name && done.insert(t.full_name).second)
      out += fmt::format("{}using {} = {};\n", indent, last_of(t.full_name), cxx_name(t).whole());
  }
  return out;
}

// Names in C of enumerators become those in C++.
std::string expression_in_cxx(const Component& c, const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const auto is_part = [&](std::size_t i) {
      return i < text.size() && (std::isalnum(static_cast<unsigned char>(text[i])) != 0 || text[i] == '_');
    };
    if (!is_part(at)) {
      out += text[at++];
      continue;
    }
    std::size_t end = at;
    while (is_part(end)) ++end;
    std::string word = text.substr(at, end - at);
    for (const idl::Type& t : c.types) {
      for (const std::string& e : t.enumerators) {
        if (t.prefix + e == text.substr(at, end - at)) word = enumerator_name(t, e).whole();
      }
    }
    out += word;
    at = end;
  }
  return out;
}

// What a union holds while its discriminant is `label`; the default member has none of its own.
std::string union_definition(const Component& c, const idl::Type& t, const std::string& name) {
  BIP_ASSERT(t.kind == Kind::Union && !t.full_name.empty(), "`{}` is of kind {}, no union", name, t.kind);
  const std::string tag = cxx_type(c, t.element);
  std::string kinds, cases, accessors;
  bool has_default = false;
  for (std::size_t k = 0; k < t.members.size(); ++k) {
    const idl::Member& m = t.members[k];
    const std::string type = cxx_type(c, m.type);
    kinds += ", " + type;
    for (const std::string& label : m.labels) cases += fmt::format("      case {}:\n", expression_in_cxx(c, label));
    if (m.labels.empty()) cases += "      default:\n";
    has_default = has_default || m.labels.empty();
    cases += fmt::format("        if (u_.index() != {0}) u_.template emplace<{0}>();\n        break;\n", k + 1);
    accessors += fmt::format(
        "  const {0}& {1}() const {{ return std::get<{2}>(u_); }}\n  {0}& {1}() {{ return std::get<{2}>(u_); }}\n",
        type, m.name, k + 1);
    // With several labels, and without one, the caller says which.
    if (m.labels.empty()) {
      accessors +=
          fmt::format("  void {}(const {}& v, {} d) {{ _d(d), std::get<{}>(u_) = v; }}\n", m.name, type, tag, k + 1);
    } else {
      accessors += fmt::format("  void {}(const {}& v, {} d = {}) {{ _d(d), std::get<{}>(u_) = v; }}\n", m.name, type,
                               tag, expression_in_cxx(c, m.labels.front()), k + 1);
    }
  }
  if (!has_default) cases += "      default: u_.template emplace<0>();\n";
  return fmt::format(
      "// Another member than the discriminant names throws std::bad_variant_access.\nclass {0} {{\n public:\n{5}  "
      "{0}() "
      "{{ _d({1}{{}}); }}\n  {1} _d() const {{ return d_; }}\n  void _d({1} d) {{\n    d_ = d;\n    switch (d) {{\n{2} "
      " "
      "  }}\n  }}\n{3}\n private:\n  {1} d_{{}};\n  std::variant<std::monostate{4}> u_;\n}};\n",
      name, tag, cases, accessors, kinds, aliases_of(c, t.full_name, "  "));
}

std::string cxx_definition(const Component& c, const idl::Type& t) {
  const CxxName name = cxx_name(t);
  const auto in_its_namespace = [&](const std::string& text) {
    return guarded_in_cxx(t.c_name, in_namespace(name.scope, text));
  };
  switch (t.kind) {
    case Kind::Primitive:
    case Kind::String:
    case Kind::Array:
    case Kind::Sequence:
    case Kind::Optional: return {};
    case Kind::Alias: return in_its_namespace(fmt::format("using {} = {};\n", name.name, cxx_type(c, t.element)));
    case Kind::Native: return in_its_namespace(fmt::format("struct {};\n", name.name));
    case Kind::Enum: {
      std::string list;
      for (const std::string& e : t.enumerators) list += (list.empty() ? "" : ", ") + enumerator_name(t, e).name;
      return in_its_namespace(fmt::format("enum {} {{ {} }};\n", name.name, list));
    }
    case Kind::Struct:
      return in_its_namespace(fmt::format("struct {} {{\n{}{}}};\n", name.name, aliases_of(c, t.full_name, "  "),
                                          cxx_members(c, t.members, "  ")));
    case Kind::Union: return in_its_namespace(union_definition(c, t, name.name));
  }
  return {};
}

std::string cxx_constant(const Component& c, const idl::Constant& k) {
  const std::string outer = outer_of(k.full_name);
  std::string type = cxx_type(c, k.type);
  if (c.plain(k.type).kind == Kind::String) type = "const char*";
  return guarded_in_cxx(k.c_name,
                        in_namespace(outer, fmt::format("inline constexpr {} {} = {};\n", type, last_of(k.full_name),
                                                        expression_in_cxx(c, k.value))));
}

std::string cxx_exception_text(const Component& c, const idl::Exception& e) {
  BIP_ASSERT(e.full_name.starts_with("::"), "exception `{}` is in no namespace", e.full_name);
  const std::string full = e.full_name.substr(2), name = last_of(full);
  std::string text = aliases_of(c, full, "");
  if (e.members.empty()) {
    text += fmt::format(
        "class {0} : public ::genom::exception {{\n public:\n  genom_event event() const noexcept override {{ return "
        "{1}_id; }}\n  std::unique_ptr<::genom::exception> copy() const override {{ return "
        "std::make_unique<{0}>(*this); "
        "}}\n}};\n",
        name, e.c_name);
  } else {
    text += fmt::format(
        "struct {0}_detail {{\n{2}}};\nclass {0} : public ::genom::exception {{\n public:\n  {0}() = default;\n  "
        "explicit "
        "{0}({0}_detail d) : detail(std::move(d)) {{}}\n  genom_event event() const noexcept override {{ return "
        "{1}_id; "
        "}}\n  const void* details() const noexcept override {{ return &detail; }}\n  "
        "std::unique_ptr<::genom::exception> "
        "copy() const override {{ return std::make_unique<{0}>(*this); }}\n  {0}_detail detail;\n}};\n",
        name, e.c_name, cxx_members(c, e.members, "  "));
  }
  return guarded_in_cxx(
      e.c_name, fmt::format("extern \"C\" const genom_event {}_id;\n", e.c_name) + in_namespace(outer_of(full), text));
}

// Once for all components: of a function, where `data` and the others lead.
std::string cxx_port(const Component& c, const idl::Port& p) {
  const std::string type = cxx_type(c, p.type), does = p.is_out ? "write" : "read";
  if (!p.is_multiple)
    return fmt::format(
        "\nstruct {}_{} {{\n  {}* (*data)(genom_context self);\n  genom_event (*{})(genom_context self);\n}};\n",
        c.name, p.name, type, does);
  std::string out =
      fmt::format("\nstruct {}_{} {{\n  {}* (*data_)(const char* id, genom_context self);\n", c.name, p.name, type);
  for (const std::string& f : {does, std::string("open"), std::string("close")})
    out += fmt::format("  genom_event (*{}_)(const char* id, genom_context self);\n", f);
  out += fmt::format(
      "  {}* data(const std::string& id, genom_context self) const {{ return data_(id.c_str(), self); }}\n", type);
  for (const std::string& f : {does, std::string("open"), std::string("close")})
    out += fmt::format(
        "  genom_event {0}(const std::string& id, genom_context self) const {{ return {0}_(id.c_str(), self); }}\n", f);
  return out + "};\n";
}

}  // namespace

std::string cxx_type(const Component& c, std::size_t type) {
  BIP_ASSERT(type < c.types.size(), "type {} of {}", type, c.types.size());
  const idl::Type& t = c.types[type];
  switch (t.kind) {
    case Kind::Primitive: return t.c_name;
    case Kind::String: return t.bound == 0 ? "std::string" : fmt::format("::genom::bounded_string<{}>", t.bound);
    case Kind::Sequence:
      return t.bound == 0 ? fmt::format("std::vector<{}>", cxx_type(c, t.element))
                          : fmt::format("::genom::bounded_vector<{}, {}>", cxx_type(c, t.element), t.bound);
    case Kind::Optional: return fmt::format("std::optional<{}>", cxx_type(c, t.element));
    case Kind::Array: return fmt::format("std::array<{}, {}>", cxx_type(c, t.element), t.bound);
    case Kind::Native: return cxx_name(t).whole() + "*";
    case Kind::Struct:
    case Kind::Union:
    case Kind::Enum:
    case Kind::Alias: return cxx_name(t).whole();
  }
  return {};
}

std::string cxx_members(const Component& c, const std::vector<idl::Member>& members, const std::string& indent) {
  std::string out;
  for (const idl::Member& m : members) out += fmt::format("{}{} {}{{}};\n", indent, cxx_type(c, m.type), m.name);
  return out;
}

std::string cxx_parameter_type(const Component& c, std::size_t type, idl::Direction direction) {
  const Kind kind = c.plain(type).kind;
  const std::string text = cxx_type(c, type);
  if (direction != idl::Direction::In) return text + "&";
  if (kind == Kind::Native) return fmt::format("const {}", text);
  return kind == Kind::Primitive || kind == Kind::Enum ? text : fmt::format("const {}&", text);
}

std::string cxx_types_header(const Component& c) {
  std::string out = fmt::format(
      "// Types of {0} in C++. Written by `bipc genom --codels`.\n#ifndef GENOM_{0}_CXX_TYPES_HPP\n"
      "#define GENOM_{0}_CXX_TYPES_HPP\n#include \"bip/genom3.hpp\"\n",
      c.name);
  for (const idl::Type& t : c.types) out += cxx_definition(c, t);
  for (const idl::Constant& k : c.constants) out += cxx_constant(c, k);
  for (const idl::Exception& e : c.exceptions) out += cxx_exception_text(c, e);
  return out + "\n#endif\n";
}

std::string cxx_component_header(const Component& c, const std::string& events, const std::string& prototypes) {
  std::string out = fmt::format(
      "// What codels of {0} see. Written by `bipc genom --codels`.\n#ifndef GENOM_AC_{0}_HPP\n#define "
      "GENOM_AC_{0}_HPP\n"
      "#include \"{0}_cxx_types.hpp\"\n\nstruct {0}_ids {{\n{1}{2}}};\nnamespace {0} {{\nusing ids = ::{0}_ids;\n}}\n",
      c.name, aliases_of(c, c.name + "::ids", "  "), cxx_members(c, c.ids, "  "));
  for (const idl::Port& p : c.ports) out += cxx_port(c, p);
  for (const idl::Service* const s : called_remotes(c)) out += remote_struct(c, *s);
  return out + fmt::format("\nextern \"C\" {{\n{}\n{}}}\n#endif\n", events, prototypes);
}

std::string cxx_members_functions(const Component& c, std::set<std::string>& done) {
  std::string out;
  const auto visits = [](const std::vector<idl::Member>& members) {
    std::string text;
    for (const idl::Member& m : members) text += fmt::format(" f(\"{0}\", v.{0});", m.name);
    return text;
  };
  const auto function = [&](const std::string& scope, const std::string& type, const std::string& body) {
    if (!done.insert(scope + "::" + type).second) return;
    out +=
        in_namespace(scope, fmt::format("template <class F>\nvoid genom_cxx_members({}& v, F f) {{{} (void)v, (void)f; "
                                        "}}\n",
                                        type, body));
  };
  for (const idl::Type& t : c.types) {
    const CxxName name = cxx_name(t);
    if (t.kind == Kind::Struct) function(name.scope, name.name, visits(t.members));
    if (t.kind == Kind::Enum && done.insert(name.whole()).second) {
      std::string rows;
      for (const std::string& e : t.enumerators)
        rows += fmt::format("{{\"{}\", {}}}, ", e, enumerator_name(t, e).whole());
      out += in_namespace(
          name.scope, fmt::format("inline auto genom_enumerators({0}) {{\n  static constexpr std::pair<const char*, "
                                  "{0}> kRows[] = {{{1}}};\n  return std::span(kRows);\n}}\n",
                                  name.name, rows));
    }
    if (t.kind != Kind::Union) continue;
    std::string body = " auto d = v._d();\n  f(\"_d\", d);\n  v._d(d);\n  switch (d) {\n";
    bool has_default = false;
    for (const idl::Member& m : t.members) {
      for (const std::string& label : m.labels) body += fmt::format("    case {}:\n", expression_in_cxx(c, label));
      if (m.labels.empty()) body += "    default:\n";
      has_default = has_default || m.labels.empty();
      body += fmt::format("      return f(\"{0}\", v.{0}());\n", m.name);
    }
    function(name.scope, name.name, body + (has_default ? "  }\n" : "    default: break;\n  }\n"));
  }
  for (const idl::Exception& e : c.exceptions) {
    const std::string full = e.full_name.substr(2);
    if (!e.members.empty()) function(outer_of(full), last_of(full) + "_detail", visits(e.members));
  }
  return out;
}

}  // namespace bip::genom
