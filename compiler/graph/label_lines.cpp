// See label_lines.hpp.
#include "compiler/graph/label_lines.hpp"

#include <algorithm>

namespace bip::graph {
namespace {

constexpr std::size_t kColumns = 44;

}  // namespace

double width_of(const std::vector<LabelLine>& lines, double size) {
  double width = 0;
  for (const LabelLine& line : lines) width = std::max(width, text_width(line.text, size, weight_of(line)));
  return width;
}

void add_broken(std::vector<LabelLine>& out, std::string text, const char* classes, std::size_t most_lines) {
  for (std::size_t line = 1; !text.empty(); ++line) {
    if (text.size() <= kColumns) {
      out.push_back({text, classes});
      return;
    }
    std::size_t cut = text.rfind(' ', kColumns);
    if (cut == std::string::npos || cut < kColumns / 3) {
      cut = kColumns;
      while (cut > 1 && (static_cast<unsigned char>(text[cut]) & 0xc0) == 0x80) --cut;
    }
    std::string part = text.substr(0, cut);
    text.erase(0, text[cut] == ' ' ? cut + 1 : cut);
    if (line == most_lines) {
      out.push_back({part + " …", classes});
      return;
    }
    out.push_back({std::move(part), classes});
  }
}

}  // namespace bip::graph
