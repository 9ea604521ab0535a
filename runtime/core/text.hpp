// Small pieces of text that traces, stories and faults share: values, places, locations, paths without the root's name.
#pragma once
#include <string>
#include <string_view>

#include "runtime/core/core.hpp"
#include "runtime/core/time/time_text.hpp"

namespace bip::rt {

/// Shortest text that reads back as the same number.
void append_double(std::string& out, double value);
void append_number(std::string& out, std::uint64_t value);
/// A string constant with quotes and escapes (JSON's).
void append_quoted(std::string& out, const char* text);
/// `1`, `true`, `2.5`, `"text"`.
void append_value(std::string& out, const Image& image, CellType type, Cell value);
/// One line of a message, from texts of others (names of files): characters that a terminal would obey, and
/// bidirectional controls, as U+FFFD, ends of lines as `\n`.
[[nodiscard]] std::string printable(std::string_view text);
/// `dine.bip:21`; nothing if there is no location.
void append_line(std::string& out, const Image& image, SourceLine loc);
/// A name with the index where `#` is (rows.hpp).
void append_name(std::string& out, const char* name, u32 index);
/// The path with "ROOT.", which a person may leave out.
[[nodiscard]] std::string whole_path(std::string_view path);
/// The path without "ROOT.".
[[nodiscard]] const char* relative(const char* path);
/// The path of an atom or a connector, as path() gives it; the same without "ROOT.".
template <class Row>
void append_path(std::string& out, const Row& row) {
  append_name(out, row.name, row.index);
}
template <class Row>
void append_relative(std::string& out, const Row& row) {
  append_name(out, relative(row.name), row.index);
}
/// The marked places, "A, B".
[[nodiscard]] std::string places_of(const CoreParts& core, u32 atom);
[[nodiscard]] inline std::string places_of(const Core& core, u32 atom) { return places_of(core.parts(), atom); }
/// `x = 1, b = true`, or empty.
[[nodiscard]] std::string data_of(const CoreParts& core, u32 atom);
[[nodiscard]] inline std::string data_of(const Core& core, u32 atom) { return data_of(core.parts(), atom); }

/// A line an atom: "  sum at `ADDING`   term = 25, total = 55".
[[nodiscard]] std::string state_text(const Core& core);

}  // namespace bip::rt
