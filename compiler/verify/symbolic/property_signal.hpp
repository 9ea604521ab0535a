// A property of states (property.hpp) as a signal of the circuit.
#pragma once
#include "compiler/verify/property/property.hpp"
#include "compiler/verify/symbolic/transition_system.hpp"

namespace bip::verify {

/// Adds the states that violate the property to the circuit and returns their signal. Floats are not followed: a
/// comparison of them is a free input, so the signal over-approximates.
[[nodiscard]] Signal broken_signal(const Property& property, TransitionSystem& machine, const rt::Image& image);
/// The same with states in which the run ends with a fault, so that it depends on the property's atoms only.
[[nodiscard]] Signal violating_signal(const Property& property, TransitionSystem& machine, const rt::Image& image);

}  // namespace bip::verify
