// Names of some files: what each declares, and where each is used. For editors, not for compiling: it takes the tree as
// it is, so it works on a file with errors, and a name that it cannot resolve is simply no use of anything.
//
// Needs parsed files, a package after those it uses (as the driver orders them). The texts must outlive the index, the
// trees need not. Rules of scope are those of the model; where a wrong program leaves a choice the first declaration
// wins. Cost: linear in the trees.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/include/bip/ids.hpp"
#include "compiler/syntax/syntax.hpp"

namespace bip::index {

using SymbolId = Id<struct SymbolTag>;

enum class SymbolKind : std::uint8_t {
  Package,
  Constant,
  ExternType,
  Function,
  PortType,
  ConnectorType,
  AtomType,
  CompoundType,  // of a file
  Parameter,     // of a type or a function; of a port type: a variable; of a connector type: a port
  Data,
  Clock,
  Port,
  Place,
  Priority,
  Invariant,  // of an atom, some of others
  Component,
  Connector,
  LoopVariable,
  ExportedPort,
  ExportedData  // of a compound, a connector
};
[[nodiscard]] const char* name_of(SymbolKind kind);  // "atom type", "place"

struct Symbol {
  SymbolKind kind = SymbolKind::Data;
  std::string_view name;
  SourceRange name_range;
  SourceRange range;  // the whole declaration, annotations included
  SymbolId parent;    // the declaration it is in; none for those of a file
  SymbolId type;      // of a component, connector, port, parameter, datum: what it is declared with, if that is known
  std::string_view type_text;     // the same as written
  bool is_visible = false;        // may be named from outside its parent as `a.name`
  std::vector<SymbolId> members;  // in source order
  std::string detail;             // the declaration on one line, where that is not the text of `range`; see detail_of
  std::string doc;                // the comment above it, without its slashes
  double interactions = 0;        // of a connector type: how many its `define` gives
};

enum class UseKind : std::uint8_t { Declaration, Read, Write };
struct Use {
  SourceRange range;
  SymbolId symbol;
  UseKind kind = UseKind::Read;
};

struct Index {
  IndexVector<SymbolId, Symbol> symbols;
  std::vector<Use> uses;               // by file and offset, declarations included
  std::vector<SymbolId> file_symbols;  // packages and their declarations, in source order

  /// The use whose name holds the offset or ends at it; null if there is none.
  [[nodiscard]] const Use* use_at(FileId file, std::uint32_t offset) const;
  [[nodiscard]] std::vector<Use> uses_of(SymbolId symbol) const;
  /// The member of `owner` that `a.name` means where a is `owner` or of that type.
  [[nodiscard]] SymbolId member(SymbolId owner, std::string_view name) const;
  /// What may stand behind `owner` and a dot.
  [[nodiscard]] std::vector<SymbolId> members_behind_dot(SymbolId owner) const;
  /// The innermost declaration of a type (or inline connector) around the offset.
  [[nodiscard]] SymbolId enclosing(FileId file, std::uint32_t offset) const;
  /// May `enclosing` return it for the offset, or a parent's parent of what it returns?
  [[nodiscard]] bool is_around(SymbolId symbol, FileId file, std::uint32_t offset) const;
};

/// The declaration on one line.
[[nodiscard]] std::string detail_of(const Symbol& symbol, const SourceMap& sources);

[[nodiscard]] Index build_index(std::span<const syntax::Syntax* const> files, const SourceMap& sources);

}  // namespace bip::index
