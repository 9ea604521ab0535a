// Selects the renderer, limits the number of messages, and prints the counts at the end.
//
// Frame and short print at most `max_errors` errors and as many warnings; JSON and SARIF are read by machines and
// contain all of them without a closing line.
#include "compiler/diag/render.hpp"

#include <algorithm>

#include "compiler/source/utf8.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip {
namespace {

std::string count_of(std::size_t n, std::string_view what) {
  return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
}

std::string closing_line(std::size_t errors, std::size_t warnings, std::size_t hidden) {
  std::string line;
  if (errors > 0) line += count_of(errors, "error");
  if (warnings > 0) line += (errors > 0 ? ", " : "") + count_of(warnings, "warning");
  if (hidden > 0) line += fmt::format(" ({} not shown)", hidden);
  return line + "\n";
}

}  // namespace

namespace diag {

const char* severity_name(Severity severity) { return severity == Severity::Error ? "error" : "warning"; }

Palette palette(Color color) {
  if (color == Color::Off) return {};
  return {.error = "\x1b[1;31m",
          .warning = "\x1b[1;33m",
          .note = "\x1b[1;36m",
          .gutter = "\x1b[34m",
          .bold = "\x1b[1m",
          .reset = "\x1b[0m"};
}

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const auto byte = static_cast<unsigned char>(text.front());
    const std::size_t length = std::max<std::size_t>(1, utf8_length(text));
    if (byte == '\n') {
      out += "\\n";
    } else if (byte < 0x20 || byte == 0x7f || is_c1_control(text) || is_bidi_control(text)) {
      out += "\xEF\xBF\xBD";
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(length);
  }
  return out;
}

std::string with_hidden_escaped(std::string_view json) {
  std::string out;
  out.reserve(json.size());
  while (!json.empty()) {
    const std::size_t length = std::max<std::size_t>(1, utf8_length(json));
    if (is_c1_control(json) || is_bidi_control(json)) {
      // Two bytes (C1, U+061C) or three.
      std::uint32_t character = static_cast<unsigned char>(json[0]) & (length == 2 ? 0x1fu : 0x0fu);
      for (std::size_t k = 1; k < length; ++k)
        character = character << 6u | (static_cast<unsigned char>(json[k]) & 0x3fu);
      out += fmt::format("\\u{:04x}", character);
    } else {
      out += json.substr(0, length);
    }
    json.remove_prefix(length);
  }
  return out;
}

}  // namespace diag

std::string render(const Diagnostics& diags, const SourceMap& sources, const RenderOptions& options) {
  if (options.format == DiagnosticFormat::Sarif) return diag::render_sarif(diags.sorted(), sources);
  const diag::Palette colors = diag::palette(options.color);
  std::string out;
  std::size_t shown[2] = {0, 0};
  std::size_t total[2] = {0, 0};
  for (const Diagnostic* d : diags.sorted()) {
    const auto which = static_cast<std::size_t>(d->severity);
    ++total[which];
    if (options.format == DiagnosticFormat::Json) {
      diag::render_json(out, *d, sources);
      continue;
    }
    if (shown[which] == options.max_errors) continue;
    ++shown[which];
    if (options.format == DiagnosticFormat::Frame) {
      diag::render_frame(out, *d, sources, colors);
    } else {
      diag::render_short(out, *d, sources, colors);
    }
  }
  BIP_ASSERT(shown[0] <= total[0] && shown[1] <= total[1], "{} of {} errors, {} of {} warnings are shown", shown[0],
             total[0], shown[1], total[1]);
  if (options.format == DiagnosticFormat::Json || total[0] + total[1] == 0) return out;
  return out + closing_line(total[0], total[1], total[0] + total[1] - shown[0] - shown[1]);
}

}  // namespace bip
