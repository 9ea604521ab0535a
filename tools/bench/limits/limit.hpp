// Shared by the programs by hand: random numbers, an exact set of enabled interactions, and two loops. `limit` updates
// the set incrementally, as a careful programmer would for that one model; `naive` evaluates every interaction in each
// step, which is the classic cycle of BIP engines without their other costs.
//
// A world provides interactions(), is_enabled(i), apply(i) and update(set, i), which updates the set after i was
// applied. Interactions are drawn uniformly. Prints one line of JSON: CPU nanoseconds per interaction and a checksum.
#pragma once
#include <time.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace limit {

using u8 = std::uint8_t;
using u32 = std::uint32_t;
using u64 = std::uint64_t;

class Random {
 public:
  explicit Random(u64 seed) : state_(seed * 0x9e3779b97f4a7c15u | 1) {}
  /// Below n, by multiplication: the bias of 2^-32 does not matter here.
  u32 below(u32 n) {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return static_cast<u32>((state_ * 0x2545f4914f6cdd1du >> 32) * n >> 32);
  }

 private:
  u64 state_;
};

/// The members in one dense array, and where each of them is.
class EnabledSet {
 public:
  explicit EnabledSet(u32 capacity) : members_(capacity + 1), position_(capacity, kAbsent) {}
  [[nodiscard]] u32 size() const { return size_; }
  [[nodiscard]] u32 operator[](u32 k) const { return members_[k]; }
  [[nodiscard]] bool contains(u32 i) const { return position_[i] != kAbsent; }
  void insert(u32 i) {
    position_[i] = size_;
    members_[size_++] = i;
  }
  void erase(u32 i) {
    const u32 at = position_[i], last = members_[--size_];
    members_[at] = last;
    position_[last] = at;
    position_[i] = kAbsent;
  }
  /// j takes i's place: the cheapest way for a pair of which one ends where the other begins.
  void replace(u32 i, u32 j) {
    members_[position_[i]] = j;
    position_[j] = position_[i];
    position_[i] = kAbsent;
  }
  void put(u32 i, bool on) {
    if (contains(i) == on) return;
    if (on) insert(i);
    else erase(i);
  }

 private:
  static constexpr u32 kAbsent = 0xffffffffu;
  std::vector<u32> members_, position_;
  u32 size_ = 0;
};

inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

struct Arguments {
  u32 n;
  u64 steps, seed;
  bool naive;
};
inline Arguments read_arguments(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: %s N STEPS SEED limit|naive\n", argv[0]);
    std::exit(2);
  }
  return {static_cast<u32>(std::strtoul(argv[1], nullptr, 10)), std::strtoull(argv[2], nullptr, 10),
          std::strtoull(argv[3], nullptr, 10), std::strcmp(argv[4], "naive") == 0};
}

inline void report(u64 steps, double seconds, u64 checksum) {
  std::printf("{\"ns\": %.3f, \"steps\": %llu, \"checksum\": %llu}\n", seconds * 1e9 / static_cast<double>(steps),
              static_cast<unsigned long long>(steps), static_cast<unsigned long long>(checksum));
}

template <class World>
int run(World& world, const Arguments& arguments) {
  Random random(arguments.seed);
  u64 done = 0;
  double start = 0;
  if (arguments.naive) {
    std::vector<u32> enabled(world.interactions() + 1);
    start = cpu_seconds();
    for (; done < arguments.steps; ++done) {
      u32 count = 0;
      for (u32 i = 0; i < world.interactions(); ++i) {
        enabled[count] = i;
        count += world.is_enabled(i) ? 1u : 0u;
      }
      if (count == 0) break;
      world.apply(enabled[random.below(count)]);
    }
  } else {
    EnabledSet enabled(world.interactions());
    for (u32 i = 0; i < world.interactions(); ++i) {
      if (world.is_enabled(i)) enabled.insert(i);
    }
    start = cpu_seconds();
    for (; done < arguments.steps && enabled.size() != 0; ++done) {
      const u32 i = enabled[random.below(enabled.size())];
      world.apply(i);
      world.update(enabled, i);
    }
  }
  report(done, cpu_seconds() - start, world.checksum());
  return 0;
}

/// Of a world that lists its candidates at each step: list_limit() or list_naive() fill `found`, apply(row) takes one.
template <class World>
int run_listed(World& world, const Arguments& arguments) {
  Random random(arguments.seed);
  u64 candidates = 0;
  const double start = cpu_seconds();
  for (u64 step = 0; step < arguments.steps; ++step) {
    if (arguments.naive) world.list_naive();
    else world.list_limit();
    candidates += world.found.size();
    world.apply(world.found[random.below(static_cast<u32>(world.found.size()))]);
  }
  report(arguments.steps, cpu_seconds() - start, candidates);
  return 0;
}

}  // namespace limit
