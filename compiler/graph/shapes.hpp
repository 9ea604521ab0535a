// A picture as a flat list of shapes, and its text as SVG. Coordinates are pixels; y grows downwards.
//
// Widths of text are computed with the metrics of DejaVu Sans, which is wider than Helvetica and the other fonts that
// systems have instead of it, so that a label keeps to its room with each of them. Colours are classes of the style
// sheet, with a second set for dark screens. Deterministic: numbers are rounded to a tenth.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace bip::graph {

struct Point {
  double x = 0, y = 0;
};

enum class Weight : std::uint8_t { Plain, Bold };
/// Returns the most that the text takes at this size.
[[nodiscard]] double text_width(std::string_view text, double size, Weight weight = Weight::Plain);
/// Returns the text for SVG and HTML: the five signs escaped, bytes that are no UTF-8 and control characters as ?.
[[nodiscard]] std::string escaped_markup(std::string_view text);

enum class Align : std::uint8_t { Left, Middle };

/// Appends SVG elements; groups nest.
class Shapes {
 public:
  /// `attributes` has the rest of the element, with values that are escaped already: ` id="a3"`.
  void begin_group(std::string_view classes, std::string_view attributes = "");
  void end_group();
  /// The text that a pointer resting on the group shows.
  void title(std::string_view text);
  void box(double x, double y, double width, double height, double radius, std::string_view classes);
  void circle(Point centre, double radius, std::string_view classes);
  /// `path` is SVG path data.
  void path(std::string_view path, std::string_view classes);
  /// y: of the baseline.
  void text(Point at, std::string_view text, double size, Align align, std::string_view classes);
  /// A bold name and what it is, in one line.
  void heading(Point at, std::string_view name, std::string_view rest, double size);
  /// A picture inside of this one, moved.
  void place(const std::string& elements, Point at);

  [[nodiscard]] const std::string& elements() const { return out_; }

 private:
  std::string out_;
};

/// "12.5"; "-0" is "0".
[[nodiscard]] std::string coordinate(double value);
/// Path data of a line through the points whose corners are round.
[[nodiscard]] std::string round_line(const std::vector<Point>& points, double radius);

struct Picture {
  std::string elements;
  double width = 0, height = 0;
};
/// Returns a whole SVG document with the style sheet and a ground.
[[nodiscard]] std::string svg_document(const Picture& picture, std::string_view title);
/// The style sheet alone, for pages that have several pictures.
[[nodiscard]] std::string_view picture_styles();

}  // namespace bip::graph
