// See shapes.hpp.
#include "compiler/graph/shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "compiler/source/utf8.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::graph {
namespace {

// Advance widths of DejaVu Sans from U+0020 to U+007E, in thousandths of the size; then those of its bold letters.
constexpr std::array<std::uint16_t, 95> kPlainWidths = {
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361,  318, 337, 636, 636, 636,
    636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632,
    575, 775, 752, 295, 295, 656, 557, 863, 748, 787, 603, 787, 695, 635,  611, 732, 684, 989, 685,
    611, 685, 390, 337, 390, 838, 500, 500, 613, 635, 550, 635, 615, 352,  635, 634, 278, 278, 579,
    278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818, 592, 592,  525, 636, 337, 636, 838};
constexpr std::array<std::uint16_t, 95> kBoldWidths = {
    348, 456,  521, 838, 696, 1002, 872, 306, 457, 457, 523, 838, 380, 415,  380, 365, 696, 696,  696,
    696, 696,  696, 696, 696, 696,  696, 400, 400, 838, 838, 838, 580, 1000, 774, 762, 734, 830,  683,
    683, 821,  837, 372, 372, 775,  637, 995, 837, 850, 733, 850, 770, 720,  682, 812, 774, 1103, 771,
    724, 725,  457, 365, 457, 838,  500, 500, 675, 716, 593, 716, 678, 435,  716, 712, 343, 343,  665,
    343, 1042, 712, 687, 716, 716,  493, 595, 478, 712, 652, 924, 645, 652,  582, 712, 365, 712,  838};
constexpr std::uint16_t kNarrowSign = 800, kWideSign = 1000;
constexpr unsigned kFirstWide = 0x1100;  // Hangul, CJK and what follows; signs before are narrow letters

constexpr std::string_view kStyles = R"(text{font-family:Helvetica,Arial,"Liberation Sans",sans-serif;fill:#1f2328}
.bold{font-weight:bold}.dim{fill:#59636e}
.ground{fill:#fff}
.compound>.frame{fill:#f6f8fa;stroke:#8c959f;stroke-width:1.2}
.compound .compound>.frame{fill:#eef1f4}.compound .compound .compound>.frame{fill:#e4e8ec}
.frame,.behind{stroke:#59636e;stroke-width:1.2}.sheet{fill:#f6f8fa;stroke:#d1d9e0}
.tab{stroke:#59636e;stroke-width:.8}.exit{fill:#59636e}
.c0{fill:#dbeafe}.c1{fill:#fef3c7}.c2{fill:#dcfce7}.c3{fill:#fce7f3}.c4{fill:#ede9fe}.c5{fill:#ffedd5}.c6{fill:#cffafe}.c7{fill:#e5e7eb}
.tab.c0{fill:#bfdbfe}.tab.c1{fill:#fde68a}.tab.c2{fill:#bbf7d0}.tab.c3{fill:#fbcfe8}.tab.c4{fill:#ddd6fe}.tab.c5{fill:#fed7aa}.tab.c6{fill:#a5f3fc}.tab.c7{fill:#d1d5db}
.plain .wire{stroke:#59636e}.plain .mark{fill:#59636e}
.wire{fill:none;stroke-width:1.5;stroke-linejoin:round}.mark{stroke:none}
.w0 .wire{stroke:#2563eb}.w1 .wire{stroke:#c2410c}.w2 .wire{stroke:#15803d}.w3 .wire{stroke:#a21caf}.w4 .wire{stroke:#0e7490}.w5 .wire{stroke:#854d0e}
.w0 .mark,.w0 .name{fill:#1d4ed8}.w1 .mark,.w1 .name{fill:#c2410c}.w2 .mark,.w2 .name{fill:#15803d}.w3 .mark,.w3 .name{fill:#a21caf}.w4 .mark,.w4 .name{fill:#0e7490}.w5 .mark,.w5 .name{fill:#854d0e}
.name{paint-order:stroke;stroke:#f6f8fa;stroke-width:3px;stroke-linejoin:round}
.place{fill:#fff;stroke:#59636e;stroke-width:1.3}.final{fill:none;stroke:#59636e}
.arrow{fill:none;stroke:#59636e;stroke-width:1.3}.internal .arrow{stroke-dasharray:4 3}.head,.dot,.bar{fill:#59636e}
.guard{fill:#a21caf}.action{fill:#0e7490}
@media (prefers-color-scheme:dark){
text{fill:#e6edf3}.dim{fill:#9da7b3}.ground{fill:#0d1117}
.compound>.frame{fill:#151b23;stroke:#656c76}.compound .compound>.frame{fill:#1c232c}.compound .compound .compound>.frame{fill:#242c36}
.frame,.behind,.tab{stroke:#9198a1}.exit{fill:#9198a1}.sheet{fill:#151b23;stroke:#3d444d}
.c0{fill:#172f4f}.c1{fill:#42340f}.c2{fill:#12351f}.c3{fill:#451a32}.c4{fill:#2c2350}.c5{fill:#43260d}.c6{fill:#0d3640}.c7{fill:#2a3038}
.tab.c0{fill:#1e4478}.tab.c1{fill:#5f4a10}.tab.c2{fill:#19502d}.tab.c3{fill:#642447}.tab.c4{fill:#3f3175}.tab.c5{fill:#633611}.tab.c6{fill:#124e5c}.tab.c7{fill:#3d444d}
.plain .wire{stroke:#9198a1}.plain .mark{fill:#9198a1}
.w0 .wire{stroke:#60a5fa}.w1 .wire{stroke:#fb923c}.w2 .wire{stroke:#4ade80}.w3 .wire{stroke:#e879f9}.w4 .wire{stroke:#22d3ee}.w5 .wire{stroke:#facc15}
.w0 .mark,.w0 .name{fill:#60a5fa}.w1 .mark,.w1 .name{fill:#fb923c}.w2 .mark,.w2 .name{fill:#4ade80}.w3 .mark,.w3 .name{fill:#e879f9}.w4 .mark,.w4 .name{fill:#22d3ee}.w5 .mark,.w5 .name{fill:#facc15}
.name{stroke:#151b23}.place{fill:#0d1117;stroke:#9198a1}.final{stroke:#9198a1}
.arrow{stroke:#9198a1}.head,.dot,.bar{fill:#9198a1}.guard{fill:#e879f9}.action{fill:#22d3ee}
}
)";

template <class... Args>
void put(std::string& out, fmt::format_string<Args...> text, Args&&... args) {
  fmt::format_to(std::back_inserter(out), text, std::forward<Args>(args)...);
}

unsigned sign_at(std::string_view text, std::size_t at, std::size_t length) {
  unsigned sign = static_cast<unsigned char>(text[at]);
  if (length > 1) sign &= 0xffu >> (length + 1);
  for (std::size_t k = 1; k < length; ++k) sign = (sign << 6) | (static_cast<unsigned char>(text[at + k]) & 0x3fu);
  return sign;
}

}  // namespace

std::string_view picture_styles() { return kStyles; }

double text_width(std::string_view text, double size, Weight weight) {
  const std::array<std::uint16_t, 95>& widths = weight == Weight::Bold ? kBoldWidths : kPlainWidths;
  double thousandths = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text.substr(at));
    const unsigned sign = length == 0 ? '?' : sign_at(text, at, length);
    const bool is_ascii = sign >= 0x20 && sign < 0x20 + widths.size();
    thousandths += is_ascii ? widths[sign - 0x20] : sign >= kFirstWide ? kWideSign : kNarrowSign;
    at += length == 0 ? 1 : length;
  }
  return thousandths * size / 1000;
}

std::string escaped_markup(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text.substr(at));
    const char c = text[at];
    const bool is_control = static_cast<unsigned char>(c) < 0x20 && c != '\n';
    // XML has no U+FFFE and no U+FFFF.
    if (length == 0 || is_control || (length == 3 && sign_at(text, at, length) >= 0xfffe)) out += '?';
    else if (c == '&') out += "&amp;";
    else if (c == '<') out += "&lt;";
    else if (c == '>') out += "&gt;";
    else if (c == '"') out += "&quot;";
    else if (c == '\'') out += "&#39;";
    else out += text.substr(at, length);
    at += length == 0 ? 1 : length;
  }
  return out;
}

std::string coordinate(double value) {
  const double rounded = std::round(value * 10) / 10;
  return rounded == 0 ? "0" : fmt::format("{}", rounded);
}

std::string round_line(const std::vector<Point>& points, double radius) {
  if (points.empty()) return "";
  std::string out = "M" + coordinate(points[0].x) + " " + coordinate(points[0].y);
  for (std::size_t k = 1; k < points.size(); ++k) {
    const Point p = points[k];
    if (k + 1 == points.size()) {
      out += "L" + coordinate(p.x) + " " + coordinate(p.y);
      break;
    }
    const auto towards = [&](Point to) {
      const double length = std::hypot(to.x - p.x, to.y - p.y);
      const double part = length == 0 ? 0 : std::min(radius, length / 2) / length;
      return Point{p.x + (to.x - p.x) * part, p.y + (to.y - p.y) * part};
    };
    const Point before = towards(points[k - 1]), after = towards(points[k + 1]);
    out += "L" + coordinate(before.x) + " " + coordinate(before.y) + "Q" + coordinate(p.x) + " " + coordinate(p.y) +
           " " + coordinate(after.x) + " " + coordinate(after.y);
  }
  return out;
}

void Shapes::begin_group(std::string_view classes, std::string_view attributes) {
  put(out_, "<g class=\"{}\"{}>\n", classes, attributes);
}
void Shapes::end_group() { out_ += "</g>\n"; }
void Shapes::title(std::string_view text) { put(out_, "<title>{}</title>\n", escaped_markup(text)); }

void Shapes::box(double x, double y, double width, double height, double radius, std::string_view classes) {
  put(out_, "<rect class=\"{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"", classes, coordinate(x), coordinate(y),
      coordinate(width), coordinate(height));
  if (radius > 0) put(out_, " rx=\"{}\"", coordinate(radius));
  out_ += "/>\n";
}
void Shapes::circle(Point centre, double radius, std::string_view classes) {
  put(out_, "<circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n", classes, coordinate(centre.x),
      coordinate(centre.y), coordinate(radius));
}
void Shapes::path(std::string_view path, std::string_view classes) {
  put(out_, "<path class=\"{}\" d=\"{}\"/>\n", classes, path);
}
void Shapes::text(Point at, std::string_view text, double size, Align align, std::string_view classes) {
  if (text.empty()) return;
  put(out_, "<text x=\"{}\" y=\"{}\" font-size=\"{}\"", coordinate(at.x), coordinate(at.y), coordinate(size));
  if (align == Align::Middle) out_ += " text-anchor=\"middle\"";
  if (!classes.empty()) put(out_, " class=\"{}\"", classes);
  put(out_, ">{}</text>\n", escaped_markup(text));
}
void Shapes::heading(Point at, std::string_view name, std::string_view rest, double size) {
  put(out_,
      "<text x=\"{}\" y=\"{}\" font-size=\"{}\"><tspan class=\"bold\">{}</tspan><tspan class=\"dim\"> "
      "{}</tspan></text>\n",
      coordinate(at.x), coordinate(at.y), coordinate(size), escaped_markup(name), escaped_markup(rest));
}
void Shapes::place(const std::string& elements, Point at) {
  put(out_, "<g transform=\"translate({} {})\">\n", coordinate(at.x), coordinate(at.y));
  out_ += elements;
  out_ += "</g>\n";
}

std::string svg_document(const Picture& picture, std::string_view title) {
  BIP_ASSERT(std::isfinite(picture.width) && std::isfinite(picture.height) && picture.width >= 0 && picture.height >= 0,
             "a picture of {} x {}", picture.width, picture.height);
  const std::string width = coordinate(std::ceil(picture.width)), height = coordinate(std::ceil(picture.height));
  std::string out;
  put(out,
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\">\n",
      width, height);
  put(out, "<title>{}</title>\n<style>\n{}</style>\n", escaped_markup(title), kStyles);
  put(out, "<rect class=\"ground\" width=\"{}\" height=\"{}\"/>\n", width, height);
  return out + picture.elements + "</svg>\n";
}

}  // namespace bip::graph
