// What rules leave out: services that do what a rule's services do, and of which the rule says nothing. A rule about
// one way to move does not hold another one back.
#pragma once
#include <string>
#include <vector>

#include "compiler/rules/check_rules.hpp"

namespace bip::rules {

/// A line for each rule and service that it leaves out: the service interrupts one of the rule's, or is interrupted by
/// it, or both write a poster. Initialisation, and services without an activity, are no such services.
[[nodiscard]] std::vector<std::string> find_left_out(const std::vector<genom::Module>& modules, const Checked& checked);

}  // namespace bip::rules
