// What the files of the GenoM 3 parser share. Inside compiler/genom only.
//
// Uses of data are kept as written while parsing ("ids:x", "local:x", "port:x", "?x", "*" for the whole IDS) and are
// settled when the component is complete, for ports and members may be declared later.
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "compiler/genom/cursor.hpp"

namespace bip::genom::v3 {

/// What `settle` needs beside the module: names that only one service knows, parallel to its services; then tasks.
struct Scopes {
  std::vector<std::set<std::string>> service_locals;
  std::vector<std::set<std::string>> task_locals;
  std::set<std::string> members;  // of the IDS
  std::set<std::string> ports;
};

/// A codel as written.
struct ParsedCodel {
  Codel codel;
  std::vector<Name> states;
  std::vector<Yield> yields;
};

/// `codel [<ev,…>] id(params) [yield ev,…]` from after the word `codel`.
[[nodiscard]] bool parse_codel(Cursor& in, ParsedCodel& into);
/// `id(params)`.
[[nodiscard]] bool parse_call(Cursor& in, Codel& into);
/// The parameters of a service, from `(` to `)`; `inputs` are those that a request brings. Of an attribute the paths
/// are ids members: they become `uses`.
enum class ParametersOf : std::uint8_t { Attribute, Codel };
[[nodiscard]] bool parse_parameters(Cursor& in, ParametersOf owner, std::set<std::string>& locals,
                                    std::vector<DataUse>& uses, std::vector<std::string>& inputs);
/// Names that are declared by `type declarator{,declarator}`, up to and without the `;`.
[[nodiscard]] bool parse_declared_names(Cursor& in, std::vector<Name>& names);

/// States from codels: checks that every state has one codel, that those yielded exist and all are reached, that `stop`
/// comes to `ether`. `owner` as in "activity `goto`".
[[nodiscard]] Activity make_activity(const std::vector<ParsedCodel>& codels, const Name& owner, const std::string& kind,
                                     Diagnostics& diags);

/// Turns the uses of all codels into names of shared data, and drops local ones.
void settle_uses(Module& module, const Scopes& scopes, Diagnostics& diags);

}  // namespace bip::genom::v3
