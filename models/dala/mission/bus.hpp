// The wires between Dala's controller and a rover that is a process of its own (rover.cpp): a file that both map, named
// by DALA_ROVER. The rover keeps the last command, as motors do, whatever becomes of the controller.
#pragma once
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace dala {

struct Bus {
  // What sensors say; seconds are those of the rover's clock.
  std::atomic<double> now{0}, x{0}, y{0}, heading{0}, v{0};
  // What the controller commands, and when it found the speed that the wheels follow.
  std::atomic<double> wanted_v{0}, wanted_turn{0}, found_at{0};
  // When NDD and P3D found one, and when the youngest images were taken that P3D's map is made of.
  std::atomic<double> laser_at{-1e6}, vision_at{-1e6}, mapped_at{-1e6};
  std::atomic<bool> follows{false}, exposes{false}, exposes_pair{false}, sends{false}, is_stopped{false};
};
static_assert(std::atomic<double>::is_always_lock_free, "two processes share it");

/// The bus in the file; null if it cannot be mapped. A new one has the values of a rover that stands.
inline Bus* open_bus(const char* path, bool is_new) {
  const int file = ::open(path, O_RDWR | (is_new ? O_CREAT | O_TRUNC : 0), 0600);
  if (file < 0) return nullptr;
  void* place = MAP_FAILED;
  if (!is_new || ::ftruncate(file, sizeof(Bus)) == 0)
    place = ::mmap(nullptr, sizeof(Bus), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  ::close(file);
  if (place == MAP_FAILED) return nullptr;
  return is_new ? new (place) Bus : static_cast<Bus*>(place);
}

/// The controller's: null if the world is simulated in its codels.
inline Bus* bus() {
  static Bus* const opened = [] {
    const char* const path = std::getenv("DALA_ROVER");
    Bus* const found = path == nullptr ? nullptr : open_bus(path, false);
    if (path != nullptr && found == nullptr) std::abort();
    return found;
  }();
  return opened;
}

}  // namespace dala
