// Small random systems, for the tests of the prover: denser in deadlocks and triggers than tools/gen's.
#pragma once
#include <cstdint>
#include <string>

namespace bip::verify::test {

[[nodiscard]] inline std::string number(std::uint64_t n) { return std::to_string(n); }

/// The text of a model. The same seed gives the same text on every machine.
[[nodiscard]] std::string small_net(std::uint64_t seed);
/// Users that take locks: their proofs need invariants.
[[nodiscard]] std::string lock_net(std::uint64_t seed);
/// Clerks that remember a number from outside and serve whom it means.
[[nodiscard]] std::string value_net(std::uint64_t seed);
/// A monitor that counts who comes and goes.
[[nodiscard]] std::string counter_net(std::uint64_t seed);

}  // namespace bip::verify::test
