// Checks many seeds in several processes. A worker that crashes or hangs fails its seed and does not end the session.
#pragma once
#include "tools/gen/check_model.hpp"

namespace bip::gen {

struct Totals {
  std::uint64_t models = 0, emitted = 0;
  std::uint64_t unsupported = 0;  // of them, what the compiler said "not yet" to: their plain models were checked
  Counts counts;
  std::vector<Failure> failures;  // by seed
};

/// Seeds first … first + count - 1. `batch`: models a program of emitted C++.
[[nodiscard]] Totals check_seeds(std::uint64_t first, std::uint64_t count, int jobs, std::size_t batch,
                                 const CheckOptions& options);

/// The checks of one model in a process of its own, emitted C++ included if wanted; a crash is a failure "crash: …".
[[nodiscard]] std::string check_isolated(const Description& model, std::uint64_t seed, const CheckOptions& options);

}  // namespace bip::gen
