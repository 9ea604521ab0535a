// What Dala's cameras see of its world: images of some columns by some rows, red, green, blue, a column a ray; and
// where red rocks are in them. Obstacles are grey, rocks bright red, both a metre high; ground below the horizon, sky
// above.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "world.hpp"

namespace dala {

struct Pixel {
  std::uint8_t red, green, blue;
};

inline constexpr std::size_t kMostPixels = 1280UL * 480;

struct Image {
  int columns = 0, rows = 0;
  double from = 0, to = 0;  // directions of the first column and past the last one, from the rover's heading
  std::array<Pixel, kMostPixels> pixels;  // column after column

  [[nodiscard]] double direction(int column) const { return from + (to - from) * column / columns; }
};

inline constexpr double kRockRadius = 0.15;

inline void take(Image& image, const World& w, int columns, int rows, double from, double to) {
  image.columns = columns;
  image.rows = rows;
  image.from = from;
  image.to = to;
  const double to_rock = std::hypot(w.rock_x - w.x, w.rock_y - w.y),
               rock_at = std::atan2(w.rock_y - w.y, w.rock_x - w.x) - w.heading;
  for (int c = 0; c < columns; ++c) {
    const double direction = image.direction(c), wall = w.distance(w.heading + direction);
    const bool is_rock = to_rock < wall && std::abs(wrapped(direction - rock_at)) < std::atan2(kRockRadius, to_rock);
    const double distance = is_rock ? to_rock : wall;
    const int high = distance < kRange ? static_cast<int>(rows / (2 * std::max(0.5, distance))) : 0;
    const Pixel thing = is_rock ? Pixel{200, 40, 30} : Pixel{130, 120, 110};
    Pixel* pixel = image.pixels.data() + static_cast<std::size_t>(c) * static_cast<std::size_t>(rows);
    for (int r = 0; r < rows; ++r)
      pixel[r] = std::abs(2 * r - rows) < high ? thing
                 : r < rows / 2                ? Pixel{170, 190, 220}
                                               : Pixel{190, 160, static_cast<std::uint8_t>(90 + r % 32)};
  }
}

/// The direction of the reddest column with enough red pixels; false if there is none.
inline bool find_red(const Image& image, double& direction) {
  int best = image.rows / 16;
  bool found = false;
  for (int c = 0; c < image.columns; ++c) {
    const Pixel* pixel = image.pixels.data() + static_cast<std::size_t>(c) * static_cast<std::size_t>(image.rows);
    int red = 0;
    for (int r = 0; r < image.rows; ++r)
      red += pixel[r].red > 2 * pixel[r].green && pixel[r].red > 2 * pixel[r].blue ? 1 : 0;
    if (red <= best) continue;
    best = red;
    direction = image.direction(c);
    found = true;
  }
  return found;
}

}  // namespace dala
