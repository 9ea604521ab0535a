// Where Dala drives: a plane with round obstacles, and the devices of the rover. Metres, seconds, radians; nothing is
// random.
//
// Codels advance it, each its own device in its own period, so that a suspended task leaves its device as it was. It
// has no memory of its own, so that processes can share it.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

namespace dala {

struct Disc {
  double x, y, r;
};
struct Window {
  double from, to;
};

inline constexpr int kRays = 72;
inline constexpr double kTick = 0.01, kRange = 4.0, kRadius = 0.35, kPi = 3.14159265358979323846;

inline double wrapped(double angle) { return std::remainder(angle, 2 * kPi); }

struct World {
  double now = 0;
  double x = 0, y = 0, heading = 0;      // truth
  double v = 0, turn = 0;                // what the wheels do
  double wanted_v = 0, wanted_turn = 0;  // the newer one of the speed references of NDD and P3D
  double goal_x = 0, goal_y = 0, blocked_since = -1;
  bool is_tracking = false, is_mapping = false, is_scanning = false;
  std::array<double, kRays> scan{}, map{};  // distances round the rover, from its heading on
  double temperature = -30, heat_to = 0;
  bool is_heating = false;
  double charge = 5000, drawn = 0;  // joules, watts
  double pan = 0, pan_to = 0;
  int pictures = 0, sent = 0;
  double busy_until = 0;  // of the camera
  double rock_x = 3.4, rock_y = 1.8;
  double fastest = 0.5;  // of NDD
  long cycles = 0;       // of the wheels
  std::array<Disc, 4> obstacles{{{2.0, 0.1, 0.35}, {4.4, 1.2, 0.4}, {1.2, 2.2, 0.3}, {3.6, 2.6, 0.35}}};
  std::array<Window, 2> windows{{{20, 75}, {79, 400}}};
  double driven = 0, nearest = kRange;
  double steepest = 0;  // of how the chassis has tilted

  [[nodiscard]] bool orbiter_is_visible() const {
    return std::any_of(windows.begin(), windows.end(), [&](const Window& w) { return w.from <= now && now < w.to; });
  }

  // The first obstacle that a ray meets.
  [[nodiscard]] double distance(double angle) const {
    const double dx = std::cos(angle), dy = std::sin(angle);
    double nearest_hit = kRange;
    for (const Disc& o : obstacles) {
      const double along = (o.x - x) * dx + (o.y - y) * dy;
      const double across = (o.x - x) * dy - (o.y - y) * dx;
      if (along > 0 && std::abs(across) < o.r)
        nearest_hit = std::min(nearest_hit, along - std::sqrt(o.r * o.r - across * across));
    }
    return nearest_hit;
  }

  void look() {
    for (int k = 0; k < kRays; ++k) scan[static_cast<std::size_t>(k)] = distance(heading + 2 * kPi * k / kRays);
  }

  // The wheels, for `dt`: they follow what they are told, with some delay.
  void move(double dt) {
    const double target_v = is_tracking ? wanted_v : 0, target_turn = is_tracking ? wanted_turn : 0;
    v += std::clamp(target_v - v, -0.8 * dt, 0.8 * dt);
    turn += std::clamp(target_turn - turn, -4 * dt, 4 * dt);
    x += v * std::cos(heading) * dt;
    y += v * std::sin(heading) * dt;
    heading = wrapped(heading + turn * dt);
    driven += std::abs(v) * dt;
    for (const Disc& o : obstacles) nearest = std::min(nearest, std::hypot(o.x - x, o.y - y) - o.r);
  }

  // Nearness-diagram-like: of the directions in which there is room for the rover, the one next to the goal; slower
  // where it is close. False: there is no way.
  bool avoid() {
    const double to_goal = std::hypot(goal_x - x, goal_y - y);
    const double goal_direction = wrapped(std::atan2(goal_y - y, goal_x - x) - heading);
    const double needed = std::min(1.2, to_goal);
    double best = 10, closest = kRange;
    for (int k = 0; k < kRays; ++k) {
      closest = std::min(closest, map[static_cast<std::size_t>(k)]);
      const double direction = wrapped(2 * kPi * k / kRays);
      if (is_free(direction, needed) &&
          std::abs(wrapped(direction - goal_direction)) < std::abs(wrapped(best - goal_direction)))
        best = direction;
      if (best > 9 && is_free(direction, needed)) best = direction;
    }
    if (is_free(goal_direction, needed)) best = goal_direction;
    if (best > 9) {
      wanted_v = wanted_turn = 0;
      return false;
    }
    wanted_turn = std::clamp(2.0 * best, -1.2, 1.2);
    wanted_v = fastest * std::clamp(std::cos(best), 0.0, 1.0) * std::clamp(closest / 1.0, 0.25, 1.0) *
               std::clamp(to_goal / 0.6, 0.2, 1.0);
    return true;
  }

 private:
  [[nodiscard]] bool is_free(double direction, double needed) const {
    for (int k = 0; k < kRays; ++k) {
      const double d = map[static_cast<std::size_t>(k)];
      const double off = std::abs(wrapped(2 * kPi * k / kRays - direction));
      // A point at distance d is in the way of a corridor as wide as the rover.
      if (off < kPi / 2 && d < kRange && d * std::sin(off) < kRadius + 0.1 && d * std::cos(off) < needed) return false;
    }
    return true;
  }
};

}  // namespace dala
