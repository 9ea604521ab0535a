// See compiler_errors.hpp. C++ compilers name locations; the emitted text makes them locations of the model: `#line`
// where it contains code of the model, "bip-prototype-3", "bip-type-3" and "bip-class-3" where it calls C++
// (emit_cpp/ffi_text.hpp).
#include "compiler/pipeline/compiler_errors.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "compiler/emit_cpp/ffi_text.hpp"
#include "compiler/lower/event_classes.hpp"
#include "compiler/system/system.hpp"

namespace bip::pipeline {

bool has_word(const std::string& text, const std::string& word) {
  const auto is_word = [](char ch) {
    return (ch >= 'a' && ch <= 'z') || (ch >= 'A' && ch <= 'Z') || (ch >= '0' && ch <= '9') || ch == '_';
  };
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !is_word(text[at - 1])) && (end == text.size() || !is_word(text[end]))) return true;
  }
  return false;
}

namespace {

/// The compiler's text is cut after so many lines.
constexpr int kMaxLines = 20;

// The range of a place, up to the end of its line.
SourceRange range_of(const Compilation& c, const Loc& loc) {
  if (c.is_bsys() || loc.line == 0 || loc.file >= c.sources.size()) return {};
  const FileId file(loc.file);
  const std::string_view line = c.sources.line(file, loc.line);
  const auto start = static_cast<std::uint32_t>(line.data() - c.sources.text(file).data());
  const std::size_t close = line.find(')', loc.column - 1);
  const auto end = static_cast<std::uint32_t>(close == std::string_view::npos ? line.size() : close + 1);
  return {file, start + loc.column - 1, start + end};
}

// "filter.hpp:12: " of the first error, without folders and columns; empty if it has no place.
std::string place_of_error(const std::string& said) {
  const std::size_t at = said.find(": error: ");
  if (at == std::string::npos) return {};
  const std::size_t line = said.rfind('\n', at);
  const std::string place =
      said.substr(line == std::string::npos ? 0 : line + 1, at - (line == std::string::npos ? 0 : line + 1));
  const std::string name = place.substr(place.rfind('/') == std::string::npos ? 0 : place.rfind('/') + 1);
  const std::size_t first = name.find(':');
  return first == std::string::npos ? "" : name.substr(0, name.find(':', first + 1)) + ": ";
}

// Where the first error of a compiler or linker begins, behind its "error: ". "collect2: error: ld returned 1 exit
// status" and clang's "linker command failed" come after what was wrong.
std::size_t first_problem(const std::string& said) {
  constexpr std::string_view kMark = "error: ";
  for (std::size_t at = said.find(kMark); at != std::string::npos; at = said.find(kMark, at + 1)) {
    const std::size_t line = said.rfind('\n', at) + 1;  // 0 at the beginning
    const std::string_view before = std::string_view(said).substr(line, at - line);
    const std::string_view behind = std::string_view(said).substr(at + kMark.size());
    if (!before.starts_with("collect2:") && !behind.starts_with("linker command failed")) return at + kMark.size();
  }
  for (const char* words : {"undefined reference", "multiple definition", "cannot find"}) {
    if (const std::size_t at = said.find(words); at != std::string::npos) return at;
  }
  return 0;
}

// A class has an alias of ours, which GCC names first: "‘using a = struct T’ {aka ‘struct T’}" becomes "‘struct T’".
std::string without_alias(std::string error) {
  constexpr std::string_view kAlias = "‘using ", kMeant = "’ {aka ";
  const std::size_t begin = error.find(kAlias);
  const std::size_t meant = begin == std::string::npos ? begin : error.find(kMeant, begin);
  const std::size_t end = meant == std::string::npos ? meant : error.find('}', meant);
  if (end == std::string::npos) return error;
  error.erase(end, 1);
  return error.erase(begin, meant + kMeant.size() - begin);
}

std::string first_error(const std::string& said) {
  const std::size_t at = first_problem(said);
  const std::string error = said.substr(at, said.find('\n', at) - at);
  // It would suggest our wrapper.
  return without_alias(error.substr(0, error.find("; did you mean")));
}

DiagnosticBuilder missing_file(Compilation& c, const std::string& name) {
  auto problem = c.diags.report(Diag::kB5010, c.is_bsys() ? SourceRange{} : c.root_range, name);
  const bool is_in_brackets = name.size() > 2 && name.front() == '<' && name.back() == '>';
  if (is_in_brackets)
    problem.help("write `" + name.substr(1, name.size() - 2) + "`: C++ looks it up as `" + name + "`, too");
  else problem.help("names are relative to the folder of the package's file, to its `ext-cpp`, or to a folder of -I");
  return problem;
}

// What a header, a prototype or an FFI type is to blame for: B5010 or B5011, and null if none is.
std::optional<DiagnosticBuilder> report_prototype(Compilation& c, const std::string& said) {
  const CodeTable& code = c.system->code;
  const std::string error = first_error(said);
  for (const CppFile& file : code.cpp.includes) {
    // GCC writes the name plainly, clang in quotes.
    if (!error.starts_with(file.name + ": ") && !error.starts_with("'" + file.name + "' file not found")) continue;
    return missing_file(c, file.name).help("no folder of the C++ compiler has it either");
  }
  constexpr std::string_view kTypeMark = "bip-type-";
  if (const std::string place = place_of_error(said); place.starts_with(kTypeMark)) {
    const std::size_t row = std::strtoul(place.c_str() + kTypeMark.size(), nullptr, 10);
    if (row < code.ffi_types.size()) {
      const FfiType& type = code.ffi_types[row];
      return c.diags.report(Diag::kB5011, range_of(c, type.loc), fmt::format("type `{}`", type.name))
          .note("C++: " + error);
    }
  }
  constexpr std::string_view kClassMark = "bip-class-";
  if (const std::size_t at = said.find(kClassMark); at != std::string::npos) {
    const std::vector<lower::EventClassUse> uses = lower::event_class_uses(*c.system);
    const std::size_t row = std::strtoul(said.c_str() + at + kClassMark.size(), nullptr, 10);
    if (row < uses.size()) {
      const Port& port = c.system->atom_types[uses[row].type].ports[uses[row].port];
      return c.diags
          .report(Diag::kB5011, range_of(c, port.loc),
                  fmt::format("class `{}` of port `{}`", port.event_class, port.name))
          .note("C++: " + error);
    }
  }
  constexpr std::string_view kMark = "bip-prototype-";
  if (const std::size_t at = said.find(kMark); at != std::string::npos) {
    const std::size_t row = std::strtoul(said.c_str() + at + kMark.size(), nullptr, 10);
    if (row < code.functions.size()) {
      const Function& function = code.functions[row];
      return c.diags
          .report(Diag::kB5011, range_of(c, function.loc),
                  fmt::format("`{}`", emit_cpp::signature_text(code, function)))
          .note("C++: " + error);
    }
  }
  for (const char* marker : {"undefined reference to `", "undefined symbol: "}) {
    const std::size_t at = said.find(marker);
    if (at == std::string::npos) continue;
    const std::size_t begin = at + std::string_view(marker).size();
    const std::string symbol = said.substr(begin, said.find_first_of("'\n", begin) - begin);
    for (const Function& function : code.functions) {
      if (!has_word(symbol.substr(0, symbol.find('(')), function.name)) continue;
      return c.diags
          .report(Diag::kB5011, range_of(c, function.loc),
                  fmt::format("`{}`", emit_cpp::signature_text(code, function)))
          .note(fmt::format("C++: `{}` is declared but no `src` or `obj` defines it", symbol));
    }
  }
  return std::nullopt;
}

// The line of the model that the first error names by a `#line`; no range if it names none.
SourceRange line_of_model(const Compilation& c, const std::string& said) {
  const std::size_t at = said.find(": error: ");
  if (at == std::string::npos) return {};
  const std::size_t before = said.rfind('\n', at);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  const std::string place = said.substr(begin, at - begin);
  for (std::uint32_t file = 0; file < c.sources.size(); ++file) {
    const std::string name = c.sources.name(FileId(file)) + ":";
    if (!place.starts_with(name)) continue;
    const auto line = static_cast<std::uint32_t>(std::strtoul(place.c_str() + name.size(), nullptr, 10));
    if (line == 0 ||
        line > c.sources.loc(FileId(file), static_cast<std::uint32_t>(c.sources.text(FileId(file)).size())).line)
      return {};
    const std::string_view text = c.sources.line(FileId(file), line);
    const std::size_t blanks = std::min(text.find_first_not_of(" \t"), text.size());
    const auto start = static_cast<std::uint32_t>(text.data() - c.sources.text(FileId(file)).data());
    return {FileId(file), start + static_cast<std::uint32_t>(blanks), start + static_cast<std::uint32_t>(text.size())};
  }
  return {};
}

// The compiler's own words, a line a note.
void add_lines(DiagnosticBuilder problem, const std::string& said) {
  std::size_t at = 0;
  for (int lines = 0; at < said.size(); ++lines) {
    if (lines == kMaxLines) {
      problem.note(fmt::format("and {} more lines",
                               std::count(said.begin() + static_cast<std::ptrdiff_t>(at), said.end(), '\n')));
      return;
    }
    const std::size_t end = std::min(said.find('\n', at), said.size());
    problem.note("| " + said.substr(at, end - at));
    at = end + 1;
  }
}

}  // namespace

void report_missing_file(Compilation& c, const std::string& name) { missing_file(c, name); }

std::string missing_c_function(const std::string& said) {
  constexpr std::string_view kMark = "undefined reference to `";
  const std::size_t at = said.find(kMark);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + kMark.size();
  const std::string symbol = said.substr(begin, said.find_first_of("'\n", begin) - begin);
  return symbol.find_first_of("(:") == std::string::npos ? symbol : "";
}

std::string other_declaration(const std::string& warnings, const std::string& name) {
  constexpr std::string_view kMark = ": warning: no previous declaration for ";
  for (std::size_t at = warnings.find(kMark); at != std::string::npos; at = warnings.find(kMark, at + 1)) {
    const std::size_t end = std::min(warnings.find(" [-W", at), warnings.find('\n', at));
    const std::string what = warnings.substr(at + 11, end - at - 11);
    const std::size_t found = what.find(" " + name + "(");
    if (found == std::string::npos) continue;
    // FILE:LINE:COLUMN
    const std::size_t line_end = warnings.rfind(':', at - 1);
    const std::size_t before = warnings.rfind('\n', at);
    std::string place = warnings.substr(before == std::string::npos ? 0 : before + 1,
                                        line_end - (before == std::string::npos ? 0 : before + 1));
    place.erase(0, place.rfind('/') == std::string::npos ? 0 : place.rfind('/') + 1);
    return place + ": " + what;
  }
  return {};
}

void report_cpp_failure(Compilation& c, const std::string& said, const std::string& near) {
  if (report_prototype(c, said)) return;
  const std::string error = first_error(said);
  auto problem = c.diags.report(Diag::kB5012, {}, "does not compile");
  problem.note("C++: " + place_of_error(said) + error);
  if (!near.empty()) problem.note("C++: " + near);
  // Headers of the published engine that have no counterpart in include/published.
  for (const char* header :
       {"AtomItf.hpp", "BipError.hpp", "Component.hpp", "ComponentItf.hpp", "Compound.hpp", "Connector.hpp",
        "Engine.hpp", "Launcher.hpp", "PortItf.hpp", "bip-engineiface-config.hpp"}) {
    if (!error.starts_with(std::string(header) + ": ") && !error.starts_with("'" + std::string(header) + "'")) continue;
    problem.help(
        "of the published engine's headers there are `AtomExternalPort.hpp`, `Atom.hpp` and `TimeValue.hpp`; derive "
        "the "
        "class of an external port from `AtomExternalPort`, or from `bip::EventSource` of `bip/event_source.hpp`");
  }
}

void report_build_failure(Compilation& c, const std::string& compiler, const std::string& how, std::string said,
                          const std::string& work) {
  for (std::size_t at = said.find(work + "/"); at != std::string::npos; at = said.find(work + "/", at))
    said.erase(at, work.size() + 1);
  std::optional<DiagnosticBuilder> problem = report_prototype(c, said);
  if (!problem) problem = c.diags.report(Diag::kB5003, line_of_model(c, said), compiler).note(how);
  add_lines(*problem, said);
}

}  // namespace bip::pipeline
