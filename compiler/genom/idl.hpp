// Types and data of a GenoM 3 component, for what is written in C: `parse_genom3` reads what happens when, this reads
// what it happens to.
//
// `read_idl` goes over the same tokens and keeps what that parser skips: types with their members, constants,
// exceptions, the IDS, ports, parameters of services and of codels. Rows are in the order of the file, a type after
// those that it is made of. Cost: linear, with a lookup a name.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/genom/constant_value.hpp"
#include "compiler/genom/tokens.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom::idl {

enum class Kind : std::uint8_t { Primitive, String, Sequence, Optional, Array, Struct, Union, Enum, Native, Alias };
struct Member {
  std::string name;
  std::size_t type = 0;
  std::vector<std::string> labels;  // of a union, in C; none: `default`
};
struct Type {
  Kind kind = Kind::Primitive;
  std::string c_name{};     // "double", "demo_state", "sequence8_double"
  std::size_t element = 0;  // of sequence, optional, array, alias; of a union the type of its labels
  std::int64_t bound = 0;   // of strings and sequences (0: none), arrays
  std::vector<Member> members{};
  std::vector<std::string> enumerators{};  // as written
  std::string prefix{};                    // of enumerators in C: "demo_"
  // Of types with a name: "demo::drive_s::limit_s". The first `namespaces` names are those of modules and components,
  // the others of what the type is declared in.
  std::string full_name{};
  std::size_t namespaces = 0;
};
struct Constant {
  std::string c_name, value;  // an expression of C
  std::string full_name{};
  std::size_t type = 0;
};
struct Exception {
  std::string c_name, full_name;  // "demo_e_far", "::demo::e_far"
  std::vector<Member> members;
};
struct Port {
  std::string name;
  std::size_t type = 0;
  bool is_out = false, is_multiple = false;
};
enum class Direction : std::uint8_t { In, Out, InOut };
/// Of a service. `path`: of an attribute, in the IDS.
struct Parameter {
  Direction direction = Direction::In;
  std::string name;
  std::size_t type = 0;
  Value initial;  // its expressions are folded
  SourceRange range{};
  std::vector<std::string> path;
};
enum class Place : std::uint8_t { Any, Ids, Local, Port, Remote };
/// Of a codel. `path`: names and indices "[2]"; empty: the whole IDS.
struct Argument {
  Place place = Place::Any;
  Direction direction = Direction::In;
  std::vector<std::string> path;
  SourceRange range;
};
struct Codel {
  std::string name;
  std::vector<Argument> arguments;
};
enum class ServiceKind : std::uint8_t { Attribute, Function, Activity };
struct Service {
  std::string name;
  ServiceKind kind = ServiceKind::Function;
  std::vector<Parameter> parameters;
  std::vector<Member> locals;
  std::vector<Codel> codels;
};
struct Task {
  std::string name;
  std::vector<Member> locals;
  std::vector<Codel> codels;
};

struct Component {
  std::string name;
  std::string language = "c";  // as `lang` has it
  SourceRange language_range{};
  bool is_cxx = false;  // its codels use genom3's C++ mapping
  std::vector<Type> types;
  std::vector<Constant> constants;
  std::vector<Exception> exceptions;
  std::vector<Member> ids;
  std::vector<Port> ports;
  std::vector<Service> services;
  std::vector<Task> tasks;
  // Services of the interfaces that it uses, which its codels may call. Attributes are there as functions.
  std::vector<Service> remotes;
  bool knows_remotes = true;  // the files of all these interfaces are here

  /// Without aliases.
  [[nodiscard]] const Type& plain(std::size_t type) const {
    BIP_ASSERT(type < types.size(), "type {} of {}", type, types.size());
    while (types[type].kind == Kind::Alias) type = types[type].element;
    return types[type];
  }
};

/// Check: whether the description is right. Codels: for codels in C, which know less: no `any`, `fixed`.
enum class Purpose : std::uint8_t { Check, Codels };
/// The component of the description in `file`, with what it provides and extends. Nothing after an error.
[[nodiscard]] std::optional<Component> read_idl(const std::vector<Token>& tokens, FileId file, Purpose purpose,
                                                Diagnostics& diags);

}  // namespace bip::genom::idl
