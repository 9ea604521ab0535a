// Navigation by vision over a simulated ground: a pair of images (VIAM), the points that are found in it (Stereo), the
// map of heights to which they are added (DTM), and arcs over that map (P3D). What a module makes is all that the next
// one reads, as with the posters of the rover's modules.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>

#include "terrain.hpp"

namespace dala {

inline constexpr std::size_t kColumns = 40, kRows = 28;
inline constexpr double kMast = 1.1, kFarthest = 4.0;

/// What the cameras took: the disparity of each pixel, of which correlation finds quarters of a pixel.
struct Pair {
  double at = -1, x = 0, y = 0, heading = 0, pan = 0;
  bool is_blurred = false;
  std::array<float, kColumns * kRows> disparities{};

  // Cameras look 0.55 rad down from the mast.
  [[nodiscard]] static double left_of(std::size_t column) {
    return 0.8 - 1.6 * static_cast<double>(column) / (kColumns - 1);
  }
  [[nodiscard]] static double down_of(std::size_t row) { return 1.1 - 1.0 * static_cast<double>(row) / (kRows - 1); }
};

struct Point {
  float x, y, z;
};
struct Cloud {
  double at = -1;
  double x = 0, y = 0;  // of the rover, when the pair was taken
  std::size_t count = 0;
  std::array<Point, kColumns * kRows> points{};
};

inline constexpr double kFocus = 300 * 0.12;  // pixels times the base in metres
inline constexpr double kSharp = 0.25;        // m/s
inline constexpr double kRoughStep = 0.10;    // m
inline constexpr double kSteepest = 0.17;     // rad: of arcs that are driven
inline constexpr double kOldImage = 1.0;      // s

/// A pair of images from where the rover is.
inline void take_pair(Pair& pair, const World& w) {
  pair.at = w.now;
  pair.x = w.x;
  pair.y = w.y;
  pair.heading = w.heading;
  pair.pan = w.pan;
  pair.is_blurred = std::abs(w.v) > kSharp;
  const double eye = ground_at(w.x, w.y) + kMast;
  for (std::size_t c = 0; c < kColumns; ++c) {
    const double direction = w.heading + w.pan + Pair::left_of(c), dx = std::cos(direction), dy = std::sin(direction);
    for (std::size_t r = 0; r < kRows; ++r) {
      const double down = Pair::down_of(r), flat = std::cos(down), drop = std::sin(down);
      // From the height of the highest stone on, in steps of 3 cm, to the ground.
      double along = std::max(0.0, (eye - kHighest) / drop);
      while (along < kFarthest && eye - along * drop > ground_at(w.x + along * flat * dx, w.y + along * flat * dy))
        along += 0.03;
      pair.disparities[c * kRows + r] =
          along < kFarthest ? static_cast<float>(std::round(4 * kFocus / along) / 4) : 0.0F;
    }
  }
}

/// The points of a pair; none of one that is blurred.
inline void correlate(Cloud& cloud, const Pair& pair) {
  cloud.at = pair.at;
  cloud.x = pair.x;
  cloud.y = pair.y;
  cloud.count = 0;
  const double eye = ground_at(pair.x, pair.y) + kMast;
  for (std::size_t k = 0; k < pair.disparities.size() && !pair.is_blurred; ++k) {
    if (pair.disparities[k] <= 0) continue;
    const double along = kFocus / static_cast<double>(pair.disparities[k]),
                 direction = pair.heading + pair.pan + Pair::left_of(k / kRows), down = Pair::down_of(k % kRows);
    cloud.points[cloud.count++] = {static_cast<float>(pair.x + along * std::cos(down) * std::cos(direction)),
                                   static_cast<float>(pair.y + along * std::cos(down) * std::sin(direction)),
                                   static_cast<float>(eye - along * std::sin(down))};
  }
}

/// Heights in cells of 0.1 m by 0.1 m, and when the youngest pair was taken that they are from.
struct HeightMap {
  static constexpr int kSide = 140;
  static constexpr double kCell = 0.1, kLeft = -6, kBottom = -11;
  double at = -1;
  std::array<float, static_cast<std::size_t>(kSide* kSide)> heights{};
  std::array<double, static_cast<std::size_t>(kSide* kSide)> seen{};  // when; 0: never

  [[nodiscard]] static int cell(double x, double y) {
    const int column = static_cast<int>(std::floor((x - kLeft) / kCell)),
              row = static_cast<int>(std::floor((y - kBottom) / kCell));
    return column < 0 || column >= kSide || row < 0 || row >= kSide ? -1 : row * kSide + column;
  }
  [[nodiscard]] bool is_known(int cell) const { return cell >= 0 && seen[static_cast<std::size_t>(cell)] > 0; }

  // In each cell the highest point of the youngest cloud that has one there.
  void put(double x, double y, float z, double when) {
    const int here = cell(x, y);
    if (here < 0) return;
    const auto k = static_cast<std::size_t>(here);
    heights[k] = seen[k] < when ? z : std::max(heights[k], z);
    seen[k] = when;
  }
  void fuse(const Cloud& cloud) {
    if (cloud.count == 0 || cloud.at <= at) return;
    at = cloud.at;
    for (std::size_t k = 0; k < cloud.count; ++k)
      put(static_cast<double>(cloud.points[k].x), static_cast<double>(cloud.points[k].y), cloud.points[k].z, at);
    // What is too near for the cameras carries the rover, or is next to what does.
    const auto level = static_cast<float>(ground_at(cloud.x, cloud.y));
    for (double dx = -0.6; dx <= 0.6; dx += kCell) {
      for (double dy = -0.6; dy <= 0.6; dy += kCell) {
        if (std::hypot(dx, dy) <= 0.6 && !is_known(cell(cloud.x + dx, cloud.y + dy)))
          put(cloud.x + dx, cloud.y + dy, level, at);
      }
    }
  }

  /// The difference of heights on the way ahead, as far as the rover needs to stop; negative if that was not seen.
  [[nodiscard]] double roughness(const World& w) const {
    double low = 10, high = -10;
    int known = 0, all = 0;
    for (double ahead = 0.3; ahead < 1.15; ahead += kCell) {
      for (double left = -0.35; left < 0.4; left += kCell, ++all) {
        const int here = cell(w.x + ahead * std::cos(w.heading) - left * std::sin(w.heading),
                              w.y + ahead * std::sin(w.heading) + left * std::cos(w.heading));
        if (!is_known(here)) continue;
        ++known;
        low = std::min(low, static_cast<double>(heights[static_cast<std::size_t>(here)]));
        high = std::max(high, static_cast<double>(heights[static_cast<std::size_t>(here)]));
      }
    }
    return 10 * known < 6 * all ? -1 : high - low;
  }
};

/// Chooses the arc to drive: of those that are known and nowhere steep, the one that ends nearest to the goal, or
/// rather where the goal is ahead. False: there is none.
struct ArcPlanner {
  double goal_x = 0, goal_y = 0, fastest = 0.15, blocked_since = -1;
  double v = 0, turn = 0;  // P3D's speed reference

  static constexpr int kArcs = 17;
  static constexpr double kLength = 1.5;

  [[nodiscard]] double cost(const HeightMap& map, const World& w, double curvature) const {
    double x = w.x, y = w.y, heading = w.heading, driven = 0, steepest = 0;
    const auto height = [&](double at_x, double at_y) {
      const int here = HeightMap::cell(at_x, at_y);
      return map.is_known(here) ? static_cast<double>(map.heights[static_cast<std::size_t>(here)]) : 10.0;
    };
    for (; driven < kLength; driven += 0.1) {
      x += 0.1 * std::cos(heading);
      y += 0.1 * std::sin(heading);
      heading += 0.1 * curvature;
      const double tilt = tilt_over(height, x, y, heading);
      if (tilt > kSteepest) break;
      steepest = std::max(steepest, tilt);
      if (std::hypot(goal_x - x, goal_y - y) < 0.2) break;
    }
    if (driven < 0.5 && std::hypot(goal_x - x, goal_y - y) >= 0.2) return 1e9;
    const double to_goal = std::hypot(goal_x - x, goal_y - y),
                 off = std::abs(wrapped(std::atan2(goal_y - y, goal_x - x) - heading));
    return to_goal + 0.25 * off + 3 * steepest + 0.8 * (kLength - driven);
  }

  bool plan(const HeightMap& map, const World& w) {
    double best = 1e8, chosen = 0;
    for (int k = 0; k < kArcs; ++k) {
      const double curvature = -1.6 + 3.2 * k / (kArcs - 1), price = cost(map, w, curvature);
      if (price < best) {
        best = price;
        chosen = curvature;
      }
    }
    const bool is_free = best < 1e8;
    // Without an arc it looks around: cameras turn with it.
    v = is_free ? fastest : 0;
    turn = is_free ? fastest * chosen : 0.3;
    return is_free;
  }
};

}  // namespace dala
