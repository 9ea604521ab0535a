// The C++ side of filter.bip: a sliding mean over the last readings of a sensor.
#pragma once
#include <cstddef>
#include <deque>

/// The last `kSize` readings. A default one is empty; copies are independent.
class Window {
 public:
  void add(int reading);
  bool is_full() const { return readings_.size() == kSize; }
  double mean() const;
  friend bool operator==(const Window&, const Window&) = default;

 private:
  static constexpr std::size_t kSize = 4;
  std::deque<int> readings_;
};

/// Changes its first argument.
void push(Window& window, int reading);
/// Called where nothing may change: in guards.
bool const_full(const Window& window);
double mean(const Window& window);
/// A reading of a simulated sensor: the same sequence in every run.
int read_sensor(int step);
