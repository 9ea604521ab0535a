// See interfaces.hpp. Names: a message is the words of its C name, each with a capital (`geometry_point`:
// GeometryPoint), a member is in small letters with underscores, as rosidl wants both.
#include "compiler/ros2/interfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "compiler/base/ascii.hpp"
#include "compiler/base/json_text.hpp"
#include "compiler/genom/c_codels.hpp"
#include "compiler/ros2/message_text.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::ros2 {
namespace {

using genom::Module;
namespace idl = genom::idl;

// "set_speed", "GoTo": "SetSpeed", "GoTo".
std::string camel(const std::string& name) {
  std::string out;
  bool begins = true;
  for (const char c : name) {
    if (!is_small(c) && !is_large(c) && !is_digit(c)) {
      begins = true;
      continue;
    }
    out += begins ? large(c) : c;
    begins = false;
  }
  return out.empty() || is_digit(out[0]) ? "X" + out : out;
}

// The names of one message.
class Members {
 public:
  explicit Members(std::vector<Field>& fields) : fields_(fields) {}
  void add(Field field, const std::string& json) {
    const std::string wanted = snake(json);
    field.name = wanted;
    for (int k = 2; !taken_.insert(field.name).second; ++k) field.name = fmt::format("{}_{}", wanted, k);
    field.member = field.name == json ? "" : json;
    fields_.push_back(std::move(field));
  }

 private:
  std::vector<Field>& fields_;
  std::set<std::string> taken_;
};

const std::map<std::string_view, Kind> kPrimitives{{"bool", Kind::Bool},
                                                   {"uint8_t", Kind::UInt8},
                                                   {"int8_t", Kind::Int8},
                                                   {"char", Kind::UInt8},
                                                   {"int16_t", Kind::Int16},
                                                   {"uint16_t", Kind::UInt16},
                                                   {"int32_t", Kind::Int32},
                                                   {"uint32_t", Kind::UInt32},
                                                   {"int64_t", Kind::Int64},
                                                   {"uint64_t", Kind::UInt64},
                                                   {"float", Kind::Float32},
                                                   {"double", Kind::Float64},
                                                   // GenoM 2, on a machine of 64 bits.
                                                   {"short", Kind::Int16},
                                                   {"unsigned short", Kind::UInt16},
                                                   {"int", Kind::Int32},
                                                   {"unsigned int", Kind::UInt32},
                                                   {"unsigned", Kind::UInt32},
                                                   {"long", Kind::Int64},
                                                   {"unsigned long", Kind::UInt64},
                                                   {"unsigned char", Kind::UInt8}};

class Maker {
 public:
  Maker(const std::vector<Module>& modules, const genom::Constraints& constraints, Diagnostics& diags, Interfaces& out)
      : modules_(modules), constraints_(constraints), diags_(diags), out_(out) {}

  void module(std::size_t index) {
    const Module& m = modules_[index];
    for (std::size_t s = 0; s < m.services.size(); ++s) service(index, s);
    if (m.component) {
      for (const idl::Port& p : m.component->ports) {
        if (p.is_out) port(m, p);
      }
    } else if (m.generation == 2) {
      for (const genom::Poster& p : m.posters) poster(m, p);
    }
  }

 private:
  // ---- services
  void service(std::size_t index, std::size_t s) {
    const Module& m = modules_[index];
    const genom::Service& row = m.services[s];
    Action action{.service = m.name.text + "." + row.name.text,
                  .name = m.name.text + "/" + row.name.text,
                  .type = own_name("action", camel(m.name.text) + camel(row.name.text)),
                  .values = {},
                  .takes_text = true};
    std::vector<Field> goal, result, feedback;
    Members goal_names(goal), result_names(result), feedback_names(feedback);
    for (const genom::ParameterRow& p : constraints_.parameters) {
      if (p.service != genom::ServiceRef{index, s}) continue;
      if (p.name == kInput) return left_out(row.name, "service", "`input` is the goal's own member");
      action.values.push_back(p.name);
      // One member, of the codels' type: what the rule judges is what they get.
      if (is_input(m, row, p.name)) {
        action.shared_values.push_back(p.name);
        continue;
      }
      const bool is_text = p.type == genom::ValueType::Text;
      goal_names.add({.name = "", .kind = is_text ? Kind::String : Kind::Float64}, p.name);
    }
    std::string wrong;
    if (m.component) {
      action.takes_text = false;
      for (const idl::Service& parameters : m.component->services) {
        if (parameters.name != row.name.text) continue;
        for (const idl::Parameter& p : parameters.parameters) {
          Field field;
          const std::optional<std::size_t> type = genom::type_of_parameter(*m.component, parameters, p);
          wrong = type ? field_of(*m.component, *type, field) : fmt::format("there is no `{}`", p.name);
          if (p.name == kReport || p.name == kDetail) wrong = fmt::format("`{}` is the result's own member", p.name);
          if (!wrong.empty()) break;
          if (p.direction != idl::Direction::Out) {
            Field asked = field;
            asked.initial = initial_of(asked, genom::idl::json_of(p.initial));
            goal_names.add(std::move(asked), p.name);
          }
          if (p.direction != idl::Direction::In) result_names.add(field, p.name);
        }
      }
    } else {
      goal_names.add({.name = "", .kind = Kind::String}, kInput);
    }
    if (wrong.empty() && out_.messages.has(action.type + "_Goal")) wrong = kTaken;
    if (!wrong.empty()) return left_out(row.name, "service", wrong);
    result_names.add({.name = "", .kind = Kind::String}, kReport);
    result_names.add({.name = "", .kind = Kind::String}, kDetail);
    feedback_names.add({.name = "", .kind = Kind::String}, kReport);
    feedback_names.add({.name = "", .kind = Kind::String}, kDetail);
    out_.messages.add_action(action.type, std::move(goal), std::move(result), std::move(feedback));
    out_.actions.push_back(std::move(action));
  }

  // Is it a parameter that codels of genom3 get with a request?
  static bool is_input(const Module& m, const genom::Service& row, const std::string& name) {
    if (!m.component) return false;
    for (const idl::Service& service : m.component->services) {
      if (service.name != row.name.text) continue;
      for (const idl::Parameter& p : service.parameters) {
        if (p.name == name && p.direction != idl::Direction::Out) return true;
      }
    }
    return false;
  }

  // A default of a .action file: of numbers, truth values and texts.
  static std::string initial_of(const Field& field, const std::string& json) {
    if (json.empty() || field.shape != Shape::One || field.kind == Kind::Message || field.is_character) return {};
    const Json value = parse_json(json);
    if (value.is_discarded() || value.is_structured() || value.is_null()) return {};
    if (field.kind == Kind::Bool) return value.is_boolean() ? (value.get<bool>() ? "true" : "false") : "";
    if (!field.words.empty()) {
      for (std::size_t k = 0; k < field.words.size(); ++k) {
        if (value.is_string() && value.get<std::string>().ends_with(field.words[k])) return std::to_string(k);
      }
    }
    const bool is_text = field.kind == Kind::String || field.kind == Kind::BoundedString;
    return is_text == value.is_string() ? value.dump() : "";
  }

  // ---- posters
  void port(const Module& m, const idl::Port& p) {
    const idl::Component& c = *m.component;
    const genom::Name name{p.name, m.name.range};
    if (p.is_multiple) return left_out(name, "port", "its names are known only when it runs (`multiple`)");
    Topic topic{.poster = m.name.text + "." + p.name, .name = m.name.text + "/" + p.name, .type = {}};
    Field field;
    if (const std::string wrong = field_of(c, p.type, field); !wrong.empty()) return left_out(name, "port", wrong);
    topic.is_bare = field.kind != Kind::Message || field.shape != Shape::One;
    topic.type = field.message;
    if (topic.is_bare) {
      topic.type = own_name("msg", camel(m.name.text) + camel(p.name));
      if (out_.messages.has(topic.type)) return left_out(name, "port", kTaken);
      std::vector<Field> fields;
      Members(fields).add(std::move(field), kData);
      add_own({topic.type, std::move(fields)});
    }
    out_.topics.push_back(std::move(topic));
  }

  // GenoM 2: members NAME::PATH of the module's data.
  void poster(const Module& m, const genom::Poster& p) {
    Topic topic{.poster = m.name.text + "." + p.name.text,
                .name = m.name.text + "/" + p.name.text,
                .type = own_name("msg", camel(m.name.text) + camel(p.name.text))};
    std::vector<Field> fields;
    Members names(fields);
    for (const genom::DataRef& ref : p.data) {
      Field field;
      if (const std::string wrong = field_of(m, ref, field); !wrong.empty()) return left_out(p.name, "poster", wrong);
      names.add(std::move(field), ref.name);
    }
    if (fields.empty()) return left_out(p.name, "poster", "its data are not described");
    if (out_.messages.has(topic.type)) return left_out(p.name, "poster", kTaken);
    add_own({topic.type, std::move(fields)});
    out_.topics.push_back(std::move(topic));
  }

  // ---- types
  static const genom::CStruct* find_struct(const Module& m, const std::string& name) {
    for (const genom::CStruct& s : m.structs) {
      if (s.name == name || "struct " + s.tag == name) return &s;
    }
    return nullptr;
  }
  std::string field_of(const Module& m, const genom::DataRef& ref, Field& field) {
    std::string type = m.data_type;
    for (std::size_t k = 0; k < ref.path.size(); ++k) {
      const genom::CStruct* const in = find_struct(m, type);
      if (in == nullptr) return fmt::format("`{}` is not described here", type);
      const auto found = std::find_if(in->members.begin(), in->members.end(),
                                      [&](const genom::CMember& member) { return member.name == ref.path[k]; });
      if (found == in->members.end()) return fmt::format("`{}` has no `{}`", type, ref.path[k]);
      if (k + 1 == ref.path.size()) return c_field(m, *found, field, 0);
      type = found->type;
    }
    return c_field(m, {type, "", {}}, field, 0);
  }
  std::string c_field(const Module& m, const genom::CMember& member, Field& field, int depth) {
    // C's structs do not contain themselves, but a file may say so.
    if (depth > 32) return fmt::format("`{}` is too deep", member.type);
    if (member.dimensions.size() > 1)
      return "a member of a message cannot be an array of arrays; put the inner array into a struct";
    if (!member.dimensions.empty() && member.dimensions[0] <= 0) return "the length of an array is not known";
    if (!member.dimensions.empty()) {
      field.shape = Shape::Array;
      field.count = static_cast<std::size_t>(member.dimensions[0]);
    }
    if (member.type == "char" && field.shape == Shape::Array) {
      // A text with its NUL.
      field.kind = Kind::BoundedString;
      field.text_bound = std::max<std::size_t>(1, field.count - 1);
      field.shape = Shape::One;
      field.count = 0;
      return {};
    }
    if (const auto known = kPrimitives.find(member.type); known != kPrimitives.end()) {
      field.kind = known->second;
      return {};
    }
    const genom::CStruct* const row = find_struct(m, member.type);
    if (row == nullptr) return fmt::format("`{}` is not described here", member.type);
    field.kind = Kind::Message;
    field.message = own_name("msg", camel(m.name.text) + camel(row->name));
    if (out_.messages.has(field.message)) return of_same(field.message, row->name);
    Message message{field.message, {}, row->name};
    Members names(message.fields);
    for (const genom::CMember& inner : row->members) {
      Field part;
      if (std::string wrong = c_field(m, inner, part, depth + 1); !wrong.empty()) return wrong;
      names.add(std::move(part), inner.name);
    }
    return add_struct(std::move(message));
  }

  // Empty, or why there is no such field.
  std::string field_of(const idl::Component& c, std::size_t index, Field& field) {
    const idl::Type& type = c.plain(index);
    switch (type.kind) {
      case idl::Kind::Primitive: {
        const auto known = kPrimitives.find(type.c_name);
        if (known == kPrimitives.end()) return fmt::format("messages have no type for `{}`", type.c_name);
        field.kind = known->second;
        field.is_character = type.c_name == "char";
        return {};
      }
      case idl::Kind::String:
        field.kind = type.bound == 0 ? Kind::String : Kind::BoundedString;
        field.text_bound = static_cast<std::size_t>(type.bound);
        return {};
      case idl::Kind::Enum:
        field.kind = Kind::Int32;
        field.words = type.enumerators;
        return {};
      case idl::Kind::Sequence:
      case idl::Kind::Array:
      case idl::Kind::Optional: {
        if (field.shape != Shape::One) return nested_in(field, type.kind);
        field.shape = type.kind == idl::Kind::Array                         ? Shape::Array
                      : type.kind == idl::Kind::Optional || type.bound != 0 ? Shape::Bounded
                                                                            : Shape::Sequence;
        field.is_optional = type.kind == idl::Kind::Optional;
        field.count = field.is_optional ? 1 : static_cast<std::size_t>(type.bound);
        return field_of(c, type.element, field);
      }
      case idl::Kind::Struct: return struct_of(c, type, field);
      case idl::Kind::Union: return fmt::format("`{}` is a union, and messages have none", type.c_name);
      case idl::Kind::Native: return fmt::format("`{}` is native: only codels know what it holds", type.c_name);
      case idl::Kind::Alias: break;
    }
    return "an alias of nothing";
  }
  // Why there is no member of a message for a `kind` of which `outer` is a sequence, an array or an optional.
  static std::string nested_in(const Field& outer, idl::Kind kind) {
    const char* const inner = kind == idl::Kind::Array      ? "array"
                              : kind == idl::Kind::Optional ? "optional"
                                                            : "sequence";
    const char* const around = outer.is_optional             ? "an optional"
                               : outer.shape == Shape::Array ? "an array of"
                                                             : "a sequence of";
    return fmt::format("a member of a message cannot be {} {}{}; put the inner one into a struct", around, inner,
                       outer.is_optional ? "" : "s");
  }

  std::string struct_of(const idl::Component& c, const idl::Type& type, Field& field) {
    field.kind = Kind::Message;
    field.message = own_name("msg", camel(type.c_name));
    if (out_.messages.has(field.message)) return of_same(field.message, type.c_name);
    Message message{field.message, {}, type.c_name};
    Members names(message.fields);
    for (const idl::Member& member : type.members) {
      Field inner;
      if (std::string wrong = field_of(c, member.type, inner); !wrong.empty()) return wrong;
      names.add(std::move(inner), member.name);
    }
    return add_struct(std::move(message));
  }

  // `a_b` and `aB` would be one message.
  [[nodiscard]] std::string of_same(const std::string& message, const std::string& c_name) const {
    return out_.messages.at(message).comment == c_name ? "" : kTaken;
  }
  static constexpr const char* kTaken = "its type would have the name of another one";

  void left_out(const genom::Name& name, const char* kind, const std::string& why) {
    diags_.report(Diag::kB6130, name.range, kind, name.text, why);
  }
  // A struct inside of it may have taken its name.
  std::string add_struct(Message message) {
    if (out_.messages.has(message.name)) return kTaken;
    add_own(std::move(message));
    return {};
  }
  void add_own(Message message) {
    BIP_ASSERT(!out_.messages.has(message.name), "message `{}` is there already", message.name);
    out_.own.push_back(message.name);
    out_.messages.add(std::move(message));
  }
  [[nodiscard]] std::string own_name(const char* folder, const std::string& name) const {
    return fmt::format("{}/{}/{}", out_.package, folder, name);
  }

  const std::vector<Module>& modules_;
  const genom::Constraints& constraints_;
  Diagnostics& diags_;
  Interfaces& out_;
};

}  // namespace

bool is_package_name(const std::string& name) {
  if (name.empty() || !is_small(name[0]) || name.back() == '_' || name.find("__") != std::string::npos) return false;
  return std::all_of(name.begin(), name.end(), [](char c) { return is_small(c) || is_digit(c) || c == '_'; });
}

std::string package_for(const std::string& name) { return snake(name) + "_msgs"; }

Interfaces make_interfaces(const std::vector<Module>& modules, const genom::Constraints& constraints,
                           const std::string& package, const std::vector<std::string>& only, Diagnostics& diags) {
  Interfaces interfaces;
  interfaces.package = package;
  Maker maker(modules, constraints, diags, interfaces);
  for (std::size_t k = 0; k < modules.size(); ++k) {
    if (only.empty() || std::find(only.begin(), only.end(), modules[k].name.text) != only.end()) maker.module(k);
  }
  return interfaces;
}

std::vector<std::pair<std::string, std::string>> package_files(const Interfaces& interfaces) {
  std::vector<std::pair<std::string, std::string>> files;
  std::string list;
  const std::string& package = interfaces.package;
  for (const std::string& name : interfaces.own) {
    const std::string file = fmt::format("msg/{}.msg", name.substr(name.rfind('/') + 1));
    list += fmt::format("  \"{}\"\n", file);
    BIP_ASSERT(interfaces.messages.has(name) && name.starts_with(package + "/"), "message `{}` is not of package `{}`",
               name, package);
    files.emplace_back(file, fields_text(interfaces.messages.at(name).fields, package, Dialect::Ros2));
  }
  for (const Action& action : interfaces.actions) {
    const std::string file = fmt::format("action/{}.action", action.type.substr(action.type.rfind('/') + 1));
    list += fmt::format("  \"{}\"\n", file);
    std::string text = fmt::format("# {}\n", action.service);
    for (const char* part : {"_Goal", "_Result", "_Feedback"}) {
      text += fields_text(interfaces.messages.at(action.type + part).fields, package, Dialect::Ros2);
      if (std::string_view(part) != "_Feedback") text += "---\n";
    }
    files.emplace_back(file, std::move(text));
  }
  files.emplace_back(
      "CMakeLists.txt",
      fmt::format(
          "cmake_minimum_required(VERSION 3.8)\nproject({})\nfind_package(ament_cmake REQUIRED)\n"
          "find_package(rosidl_default_generators REQUIRED)\nrosidl_generate_interfaces(${{PROJECT_NAME}}\n{})\n"
          "ament_export_dependencies(rosidl_default_runtime)\nament_package()\n",
          package, list));
  files.emplace_back(
      "package.xml",
      fmt::format("<?xml version=\"1.0\"?>\n<package format=\"3\">\n  <name>{}</name>\n  <version>0.0.0</version>\n"
                  "  <description>Services and posters of robot modules, written by bipc ros2</description>\n"
                  "  <maintainer email=\"nobody@localhost.localdomain\">nobody</maintainer>\n"
                  "  <license>unknown</license>\n"
                  "  <buildtool_depend>ament_cmake</buildtool_depend>\n"
                  "  <buildtool_depend>rosidl_default_generators</buildtool_depend>\n"
                  "  <depend>action_msgs</depend>\n  <exec_depend>rosidl_default_runtime</exec_depend>\n"
                  "  <member_of_group>rosidl_interface_packages</member_of_group>\n"
                  "  <export>\n    <build_type>ament_cmake</build_type>\n  </export>\n</package>\n",
                  package));
  return files;
}

}  // namespace bip::ros2
