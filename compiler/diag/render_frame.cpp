// The frame: the source lines of a diagnostic with their marks, as in compiler/docs/diagnostics.md.
//
// Lines of the primary file come first, in order, `:` stands for a gap; lines of other files follow under `:::`.
// Columns are terminal columns: tabs stop every 4, combining marks take none, wide characters two. Long lines are cut
// to a window around their first mark, so the text stays bounded whatever the input.
#include <algorithm>
#include <map>

#include "compiler/diag/render.hpp"
#include "compiler/source/utf8.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::diag {
namespace {

constexpr std::size_t kTabStop = 4;
constexpr std::size_t kWindow = 160;
constexpr std::size_t kWindowBefore = 60;

enum class MarkKind : std::uint8_t { Primary, Label };
struct Mark {
  std::size_t begin_byte = 0;  // within the line
  std::size_t end_byte = 0;
  MarkKind kind = MarkKind::Label;
  std::string_view text;
  std::size_t begin = 0;  // columns on the screen
  std::size_t end = 0;
};
using MarksByLine = std::map<std::uint32_t, std::vector<Mark>>;

struct File {
  FileId id;
  MarksByLine lines;
};

File& file_of(std::vector<File>& files, FileId id) {
  for (File& f : files) {
    if (f.id == id) return f;
  }
  return files.emplace_back(File{id, {}});
}

// A range over several lines is marked on its first one, to that line's end.
void add_mark(std::vector<File>& files, const SourceMap& sources, SourceRange range, MarkKind kind,
              std::string_view text) {
  if (!range.is_valid()) return;
  const Loc at = sources.loc(range);
  BIP_ASSERT(at.line >= 1 && at.column >= 1, "a place at line {}, column {}", at.line, at.column);
  const std::size_t length = sources.line(range.file, at.line).size();
  const std::size_t begin = std::min<std::size_t>(at.column - 1, length);
  const std::size_t end =
      std::min<std::size_t>(begin + (range.end > range.begin ? range.end - range.begin : 0), length);
  file_of(files, range.file)
      .lines[at.line]
      .push_back({.begin_byte = begin, .end_byte = end, .kind = kind, .text = text});
}

struct ScreenLine {
  std::string text;
  std::vector<std::size_t> column;  // by byte; one past the end too
};

ScreenLine on_screen(std::string_view line) {
  ScreenLine screen;
  screen.column.resize(line.size() + 1);
  std::size_t column = 0;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t length = std::max<std::size_t>(1, utf8_length(line.substr(at)));
    const std::string_view character = line.substr(at, length);
    for (std::size_t i = 0; i < length; ++i) screen.column[at + i] = column;
    if (character == "\t") {
      const std::size_t stop = (column / kTabStop + 1) * kTabStop;
      screen.text.append(stop - column, ' ');
      column = stop;
    } else {
      screen.text += printable(character);
      column += utf8_columns(character);
    }
    at += length;
  }
  screen.column[line.size()] = column;
  BIP_ASSERT(std::ranges::is_sorted(screen.column), "columns of a line run backwards");
  return screen;
}

// Cuts the bytes that are shown; marks move with them.
std::string_view cut(std::string_view line, std::vector<Mark>& marks, bool& cut_left, bool& cut_right) {
  cut_left = cut_right = false;
  if (line.size() <= kWindow) return line;
  std::size_t from = marks.front().begin_byte > kWindowBefore ? marks.front().begin_byte - kWindowBefore : 0;
  const auto is_inside = [&](std::size_t at) { return (static_cast<unsigned char>(line[at]) & 0xC0u) == 0x80u; };
  while (from > 0 && is_inside(from)) --from;
  std::size_t to = std::min(line.size(), from + kWindow);
  while (to < line.size() && is_inside(to)) ++to;
  cut_left = from > 0;
  cut_right = to < line.size();
  for (Mark& m : marks) {
    m.begin_byte = std::clamp(m.begin_byte, from, to) - from;
    m.end_byte = std::clamp(m.end_byte, from, to) - from;
  }
  return line.substr(from, to - from);
}

class Frame {
 public:
  Frame(std::string& out, const Palette& colors, Severity severity, std::size_t digits)
      : out_(out), colors_(colors), severity_(severity), digits_(digits) {}

  void place(std::string_view arrow, std::string_view name, Loc at) {
    out_ += fmt::format("{:{}}{}{}{} {}:{}:{}\n", "", digits_, colors_.gutter, arrow, colors_.reset, printable(name),
                        at.line, at.column);
  }
  void gutter(char mark, std::string_view rest = {}) {
    out_ += fmt::format("{:{}} {}{}{}{}{}\n", "", digits_, colors_.gutter, mark, colors_.reset, rest.empty() ? "" : " ",
                        rest);
  }
  void attached(std::string_view kind, std::string_view text) {
    out_ += fmt::format("{:{}} {}={} {}{}{}: {}\n", "", digits_, colors_.gutter, colors_.reset, colors_.bold, kind,
                        colors_.reset, text);
  }
  void source_line(std::uint32_t number, std::string_view line, std::vector<Mark> marks) {
    std::stable_sort(marks.begin(), marks.end(),
                     [](const Mark& a, const Mark& b) { return a.begin_byte < b.begin_byte; });
    bool cut_left = false, cut_right = false;
    const ScreenLine screen = on_screen(cut(line, marks, cut_left, cut_right));
    const std::size_t shift = cut_left ? 1 : 0;
    for (Mark& m : marks) {
      BIP_ASSERT(m.begin_byte <= m.end_byte && m.end_byte < screen.column.size(), "a mark from byte {} to {} of {}",
                 m.begin_byte, m.end_byte, screen.column.size());
      m.begin = screen.column[m.begin_byte] + shift;
      m.end = std::max(screen.column[m.end_byte] + shift, m.begin + 1);
    }
    out_ += fmt::format("{}{:>{}} |{}{}{}{}{}\n", colors_.gutter, number, digits_, colors_.reset,
                        screen.text.empty() ? "" : " ", cut_left ? "…" : "", screen.text, cut_right ? "…" : "");
    marks_of_line(std::move(marks));
  }

 private:
  // Marks that do not overlap share a row, the last one's text behind it, the others' below; else a row each.
  void marks_of_line(std::vector<Mark> marks) {
    while (!marks.empty()) {
      std::vector<Mark> row, rest;
      for (Mark& m : marks) (row.empty() || row.back().end <= m.begin ? row : rest).push_back(m);
      mark_row(row);
      marks = std::move(rest);
    }
  }
  void mark_row(const std::vector<Mark>& row) {
    std::string text;
    std::size_t column = 0;
    for (const Mark& m : row) {
      BIP_ASSERT(column <= m.begin, "marks overlap at column {}", m.begin);
      text.append(m.begin - column, ' ');
      text += color_of(m);
      text.append(m.end - m.begin, m.kind == MarkKind::Primary ? '^' : '-');
      text += colors_.reset;
      column = m.end;
    }
    if (!row.back().text.empty()) text += fmt::format(" {}{}{}", color_of(row.back()), row.back().text, colors_.reset);
    gutter('|', text);
    for (std::size_t i = row.size() - 1; i-- > 0;) {
      if (row[i].text.empty()) continue;
      gutter('|', stems(row, i + 1));
      std::string line = stems(row, i);
      line.append(row[i].begin - width_of_stems(row, i), ' ');
      line += fmt::format("{}{}{}", color_of(row[i]), row[i].text, colors_.reset);
      gutter('|', line);
    }
  }
  // The `|` under the marks before `count` whose text is still to come.
  std::string stems(const std::vector<Mark>& row, std::size_t count) {
    std::string text;
    std::size_t column = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (row[i].text.empty()) continue;
      text.append(row[i].begin - column, ' ');
      text += fmt::format("{}|{}", color_of(row[i]), colors_.reset);
      column = row[i].begin + 1;
    }
    return text;
  }
  static std::size_t width_of_stems(const std::vector<Mark>& row, std::size_t count) {
    std::size_t width = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (!row[i].text.empty()) width = row[i].begin + 1;
    }
    return width;
  }
  [[nodiscard]] std::string_view color_of(const Mark& m) const {
    return m.kind == MarkKind::Primary ? colors_.of(severity_) : colors_.note;
  }

  std::string& out_;
  const Palette& colors_;
  Severity severity_;
  std::size_t digits_;
};

}  // namespace

void render_frame(std::string& out, const Diagnostic& d, const SourceMap& sources, const Palette& colors) {
  out += fmt::format("{}{}[{}]{}{}: {}{}\n", colors.of(d.severity), severity_name(d.severity), info(d.kind).code,
                     colors.reset, colors.bold, printable(d.message), colors.reset);
  std::vector<File> files;
  add_mark(files, sources, d.range, MarkKind::Primary, d.label);
  for (const Label& label : d.labels) add_mark(files, sources, label.range, MarkKind::Label, label.text);
  std::uint32_t last_line = 1;
  for (const File& f : files) last_line = std::max(last_line, f.lines.rbegin()->first);
  Frame frame(out, colors, d.severity, std::to_string(last_line).size());
  for (const File& f : files) {
    const bool first = &f == &files.front();
    const std::uint32_t top = f.lines.begin()->first;
    const Loc at =
        first && d.range.is_valid()
            ? sources.loc(d.range)
            : Loc{f.id.value, top, static_cast<std::uint32_t>(f.lines.begin()->second.front().begin_byte + 1)};
    frame.place(first ? "-->" : ":::", sources.name(f.id), at);
    frame.gutter('|');
    std::uint32_t previous = top;
    for (const auto& [number, marks] : f.lines) {
      if (number > previous + 1) frame.gutter(':');
      frame.source_line(number, sources.line(f.id, number), marks);
      previous = number;
    }
  }
  for (const std::string& note : d.notes) frame.attached("note", note);
  for (const Help& help : d.helps) frame.attached("help", help.text);
}

std::string excerpt(const SourceMap& sources, Loc at, const Palette& colors) {
  std::string out;
  Frame frame(out, colors, Severity::Error, std::to_string(at.line).size());
  const FileId file(at.file);
  const std::string_view line = sources.line(file, at.line);
  const std::size_t begin = std::min<std::size_t>(at.column == 0 ? 0 : at.column - 1, line.size());
  frame.place("-->", sources.name(file), at);
  frame.gutter('|');
  frame.source_line(at.line, line, {{.begin_byte = begin, .end_byte = begin, .kind = MarkKind::Primary, .text = {}}});
  return out;
}

}  // namespace bip::diag
