// See text.hpp.
#include "runtime/core/text.hpp"

#include <charconv>
#include <cstring>

#include "bip/ffi.hpp"

namespace bip::rt {

void append_number(std::string& out, std::uint64_t value) {
  char buffer[24];
  out.append(buffer, static_cast<std::size_t>(std::to_chars(buffer, buffer + sizeof buffer, value).ptr - buffer));
}

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t k = 0; k < text.size();) {
    const auto at = [&](std::size_t i) { return k + i < text.size() ? static_cast<unsigned char>(text[k + i]) : 0u; };
    const unsigned first = at(0), second = at(1), third = at(2);
    // C1 and U+061C have two bytes in UTF-8; U+200E, U+200F, U+202A to U+202E and U+2066 to U+2069 three.
    const bool is_c1 = first == 0xc2 && second >= 0x80 && second <= 0x9f;
    const bool is_letter_mark = first == 0xd8 && second == 0x9c;
    const bool is_general = first == 0xe2 && second == 0x80 && (third == 0x8e || third == 0x8f);
    const bool is_embedding = first == 0xe2 && second == 0x80 && third >= 0xaa && third <= 0xae;
    const bool is_isolate = first == 0xe2 && second == 0x81 && third >= 0xa6 && third <= 0xa9;
    std::size_t length = 1;
    if (is_c1 || is_letter_mark) length = 2;
    if (is_general || is_embedding || is_isolate) length = 3;
    if (first == '\n') out += "\\n";
    else if (length > 1 || first < 0x20 || first == 0x7f) out += "\xEF\xBF\xBD";
    else out += text[k];
    k += length;
  }
  return out;
}

void append_double(std::string& out, double value) {
  // IEEE 754 leaves the sign of a computed NaN open, and compilers use that: it must not show.
  if (value != value) {
    out += "nan";
    return;
  }
  char buffer[40];
  out.append(buffer, static_cast<std::size_t>(std::to_chars(buffer, buffer + sizeof buffer, value).ptr - buffer));
}

void append_quoted(std::string& out, const char* text) {
  static constexpr char kHex[] = "0123456789abcdef";
  out += '"';
  for (; *text != '\0'; ++text) {
    const auto c = static_cast<unsigned char>(*text);
    switch (c) {
      case '"': out += "\\\""; break;
      case '\\': out += "\\\\"; break;
      case '\n': out += "\\n"; break;
      case '\t': out += "\\t"; break;
      case '\r': out += "\\r"; break;
      case '\b': out += "\\b"; break;
      case '\f': out += "\\f"; break;
      default:
        if (c < 0x20) {
          out += "\\u00";
          out += kHex[c >> 4];
          out += kHex[c & 15];
        } else {
          out += static_cast<char>(c);
        }
    }
  }
  out += '"';
}

void append_value(std::string& out, const Image& image, CellType type, Cell value) {
  if (is_ffi(type)) {
    out += '<';
    out += image.ffi_types[static_cast<u32>(type) - kFirstFfiType].name;
    out += '>';
    return;
  }
  switch (type) {
    case CellType::Int: {
      char buffer[16];
      out.append(buffer, static_cast<std::size_t>(std::to_chars(buffer, buffer + sizeof buffer, value.i).ptr - buffer));
      break;
    }
    case CellType::Bool: out += value.i != 0 ? "true" : "false"; break;
    case CellType::Float: append_double(out, value.f); break;
    case CellType::String: append_quoted(out, string_of(image, value)); break;
  }
}

void append_line(std::string& out, const Image& image, SourceLine loc) {
  if (loc.line == 0 || loc.file >= image.files.size) return;
  out += image.files[loc.file];
  out += ':';
  append_number(out, loc.line);
}

void append_name(std::string& out, const char* name, u32 index) {
  if (index == kNone) {
    out += name;
    return;
  }
  const char* mark = std::strchr(name, '#');
  out.append(name, mark);
  append_number(out, index);
  out += mark + 1;
}

std::string whole_path(std::string_view path) {
  return std::string(path.starts_with("ROOT.") || path == "ROOT" ? "" : "ROOT.").append(path);
}

const char* relative(const char* path) { return std::strncmp(path, "ROOT.", 5) == 0 ? path + 5 : path; }

std::string places_of(const CoreParts& core, u32 atom) {
  const AtomType& type = core.tables.atom_type(atom);
  std::string out;
  for (u32 place = 0; place < type.places.size; ++place) {
    if (!core.is_marked(atom, place)) continue;
    if (!out.empty()) out += ", ";
    out += type.places[place];
  }
  return out;
}

std::string data_of(const CoreParts& core, u32 atom) {
  const AtomType& type = core.tables.atom_type(atom);
  const VariableId first = core.tables.atoms[atom].first_cell;
  std::string out;
  const u32 clocks = type.time == nullptr ? 0 : type.time->clocks.size;
  for (u32 i = 0; i < visible_variables(type); ++i) {
    if (i != 0) out += ", ";
    out += type.variables[i].name;
    out += " = ";
    append_value(out, core.image(), type.variables[i].type, core.memory.cells[first + i]);
  }
  for (u32 i = 0; i < clocks; ++i) {
    if (!out.empty()) out += ", ";
    out += type.time->clocks[i].name;
    out += " = ";
    append_time(out, static_cast<i64>(core.clocks.clock_value(atom, i)));
  }
  return out;
}

std::string state_text(const Core& core) {
  std::string out;
  for (u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    out += "  ";
    append_relative(out, core.image().atoms[atom]);
    out += " at `" + places_of(core, atom) + '`';
    if (const std::string data = data_of(core, atom); !data.empty()) out += "   " + data;
    out += '\n';
  }
  return out;
}

}  // namespace bip::rt
