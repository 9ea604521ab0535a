// What is said when a session cannot go back, on the console and for pages.
#pragma once
#include <string>

namespace bip::debug {

inline constexpr const char* kGoesBackHelp =
    "`--trust-cpp` goes back all the same: C++ functions are then taken to depend on nothing but their arguments";

/// `problem`: of the session.
[[nodiscard]] inline std::string back_refused(const std::string& problem) {
  return "error[B5041]: the session cannot go back: " + problem;
}

}  // namespace bip::debug
