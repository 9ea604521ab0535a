// The frame of the DOT text, and the quoting that structure and automata share.
#include "compiler/graph/dot.hpp"

#include "compiler/graph/graph.hpp"
#include "compiler/source/utf8.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::graph {

namespace {

// Graphviz reads backslashes in labels, and in records the signs of `more`.
std::string escaped(std::string_view text, std::string_view more) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text.substr(at));
    const char c = text[at];
    if (length == 0) {
      out += '?';
    } else if (c == '\n') {
      out += "\\n";
    } else {
      if (c == '"' || c == '\\' || more.find(c) != std::string_view::npos) out += '\\';
      out += text.substr(at, length);
    }
    at += length == 0 ? 1 : length;
  }
  return out;
}

}  // namespace

std::string dot_string(std::string_view text) { return '"' + escaped(text, "") + '"'; }

std::string record_field(std::string_view text) { return escaped(text, "{}|<>"); }

std::string shortened(std::string text) {
  if (text.size() <= kMaxLabel) return text;
  std::size_t end = kMaxLabel - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  text.resize(end);
  return text + "...";
}

std::string lines_of(const std::vector<std::string>& lines) {
  std::string out;
  for (const std::string& line : lines) {
    if (line.empty()) continue;
    if (!out.empty()) out += '\n';
    out += line;
  }
  return out;
}

std::string dot(const System& system, Show show) {
  std::string out =
      "// bipc graph: `dot -Tsvg` draws it.\n"
      "digraph bip {\n"
      "  rankdir=LR;\n"
      "  fontname=\"Helvetica\"; fontsize=11;\n"
      "  node [fontname=\"Helvetica\", fontsize=10];\n"
      "  edge [fontname=\"Helvetica\", fontsize=9];\n";
  if (show != Show::Automata) put_structure(out, system);
  if (show != Show::Structure) put_automata(out, system);
  return out + "}\n";
}

}  // namespace bip::graph
