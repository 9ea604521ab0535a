// Log lines for work on an algorithm: BIP_LOG(Ic3, 1, "frame {}: {} lemmas", frame, count) writes "[ic3] …" to stderr.
//
// Compiled in with the CMake option BIPC_LOG and in the presets debug and checked (BIP_CHECKED), and to nothing
// elsewhere: arguments are type-checked and never evaluated. `bipc verify --log=ic3:2,traps` or the environment
// variable BIPC_LOG chooses areas and levels; level 1 is one line per phase, 2 one per query or invariant, 3 one per
// lemma. Process-wide, set before any thread starts: no result depends on it.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace bip {

#define BIP_LOG_AREAS(AREA)      \
  AREA(Affine, "affine")         \
  AREA(Components, "components") \
  AREA(Houdini, "houdini")       \
  AREA(Ic3, "ic3")               \
  AREA(Places, "places")         \
  AREA(Portfolio, "portfolio")   \
  AREA(Time, "time")             \
  AREA(Traps, "traps")

enum class LogArea : std::uint8_t {
#define BIP_LOG_AREA(name, text) name,
  BIP_LOG_AREAS(BIP_LOG_AREA)
#undef BIP_LOG_AREA
};

#if defined(BIPC_LOG) || defined(BIP_CHECKED)
inline constexpr bool kHasLog = true;
#else
inline constexpr bool kHasLog = false;
#endif

/// 0: the area is silent.
[[nodiscard]] int log_level(LogArea area);
/// Turns areas on by a list "AREA[:LEVEL],…" (level 1 if none is given). Returns what is wrong with the list or that
/// this build has no log lines; then no level has changed. Empty: done.
[[nodiscard]] std::string set_log_levels(std::string_view list);
/// Writes one line to stderr.
void write_log(LogArea area, const std::string& line);

}  // namespace bip

#define BIP_LOG(area, level, ...)                                         \
  do {                                                                    \
    if constexpr (::bip::kHasLog) {                                       \
      if (::bip::log_level(::bip::LogArea::area) >= (level))              \
        ::bip::write_log(::bip::LogArea::area, fmt::format(__VA_ARGS__)); \
    }                                                                     \
  } while (false)
