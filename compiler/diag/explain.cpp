// Looks up an explain page and renders its little markdown (headings, fences, paragraphs) for a terminal.
#include "compiler/diag/explain.hpp"

#include "compiler/diag/render.hpp"

namespace bip {

const ExplainPage* find_page(std::string_view code) {
  for (const ExplainPage& page : explain_pages()) {
    if (page.code == code) return &page;
  }
  return nullptr;
}

std::string render_page(const ExplainPage& page, Color color) {
  const diag::Palette colors = diag::palette(color);
  std::string out;
  bool in_fence = false;
  std::string_view rest = page.text;
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    const std::string_view line = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
    if (line.starts_with("```")) {
      in_fence = !in_fence;
    } else if (in_fence) {
      if (!line.empty()) out += "    ";
      out += fmt::format("{}\n", line);
    } else if (line.starts_with("#")) {
      const std::string_view title = line.substr(std::min(line.find_first_not_of("# "), line.size()));
      out += fmt::format("{}{}{}\n", colors.bold, title, colors.reset);
    } else {
      out += fmt::format("{}\n", line);
    }
  }
  return out;
}

}  // namespace bip
