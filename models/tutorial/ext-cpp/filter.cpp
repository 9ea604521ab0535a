#include "filter.hpp"

#include <numeric>
#include <stdexcept>

void Window::add(int reading) {
  readings_.push_back(reading);
  if (readings_.size() > kSize) readings_.pop_front();
}

double Window::mean() const {
  if (readings_.empty()) throw std::logic_error("the mean of nothing");
  return std::accumulate(readings_.begin(), readings_.end(), 0.0) / static_cast<double>(readings_.size());
}

void push(Window& window, int reading) { window.add(reading); }
bool const_full(const Window& window) { return window.is_full(); }
double mean(const Window& window) { return window.mean(); }
int read_sensor(int step) { return 20 + (step * 7) % 5; }
