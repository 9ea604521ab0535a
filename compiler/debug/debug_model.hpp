// What a person types in a debugging session, resolved in a model: places to stop at, expressions, names to complete.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/base/result.hpp"
#include "runtime/debug/breakpoint.hpp"

namespace bip {
struct System;
}

namespace bip::debug {

/// A component, connector, port, place or variable that a text names; owner: row of the atom or connector.
struct Named {
  enum class Kind : std::uint8_t { Atom, Connector, Port, Place, Data };
  Kind kind = Kind::Atom;
  std::uint32_t owner = 0, row = 0;
};

/// A model as sessions need it; refers to both, which must outlive it.
class DebugModel {
 public:
  DebugModel(const System& system, const rt::Image& image) : system_(&system), image_(&image) {}
  [[nodiscard]] const System& system() const { return *system_; }
  [[nodiscard]] const rt::Image& image() const { return *image_; }

  /// `phil[0]`, `left[2]`, `phil[0].put`, `phil[0]@EATS`, `pump.level`; with or without `ROOT.`. O(atoms).
  [[nodiscard]] std::optional<Named> find(std::string_view text) const;
  /// The place to stop that the text describes: what find() knows (but no atom), `12` or `dine.bip:12` (a line),
  /// `@1s500ms` (an instant), `never EXPR` or `always EXPR` (a property), or a condition; each may end in ` if EXPR`.
  [[nodiscard]] Result<rt::Breakpoint> parse_breakpoint(const std::string& text) const;
  /// A condition of the language of properties.
  [[nodiscard]] Result<std::function<bool(const rt::Core&)>> parse_condition(const std::string& text) const;
  /// The value of an expression in the core's state, as text.
  [[nodiscard]] Result<std::string> evaluate(const std::string& text, const rt::Core& core) const;
  /// A value for a variable of this type: `3`, `true`, `2.5`, `"text"` (one that the model has).
  [[nodiscard]] Result<rt::Cell> parse_value(const std::string& text, rt::CellType type) const;
  /// Lines from `line` on at which a step can stop: of a transition with a port, a connector or its type. 0: none.
  [[nodiscard]] std::uint32_t next_line(std::uint32_t file, std::uint32_t line) const;
  /// Paths that begin with the text, at most `most`; without `ROOT.`.
  [[nodiscard]] std::vector<std::string> complete(const std::string& begin, std::size_t most) const;

 private:
  [[nodiscard]] std::uint32_t find_atom(const std::string& path) const;
  [[nodiscard]] std::uint32_t find_connector(const std::string& path) const;
  [[nodiscard]] std::optional<rt::Breakpoint> parse_line(const std::string& text, std::string& problem) const;

  const System* system_;
  const rt::Image* image_;
};

}  // namespace bip::debug
