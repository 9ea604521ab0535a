// Errors of the command line.
#pragma once
#include <string>

namespace bip::driver {

/// Writes what is wrong with the command line to standard error, and if there is one a line of help. Returns kUsage.
int usage_error(const std::string& problem, const std::string& help = {});

}  // namespace bip::driver
