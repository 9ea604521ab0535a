// Lines of text beside arrows and in boxes. Internal to graph/.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "compiler/graph/shapes.hpp"

namespace bip::graph {

struct LabelLine {
  std::string text;
  const char* classes = "";
};

[[nodiscard]] inline Weight weight_of(const LabelLine& line) {
  return std::string_view(line.classes) == "bold" ? Weight::Bold : Weight::Plain;
}
/// Of the widest line.
[[nodiscard]] double width_of(const std::vector<LabelLine>& lines, double size);

/// Appends the text, broken at blanks, as at most `most_lines` lines; the rest is dropped, with a sign.
void add_broken(std::vector<LabelLine>& out, std::string text, const char* classes, std::size_t most_lines = 3);

}  // namespace bip::graph
