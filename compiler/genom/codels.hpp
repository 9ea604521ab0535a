// The C++ functions of the execution flavour; generate_package.hpp declares the functions that return their header and
// source. Internal to compiler/genom.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/constraints.hpp"
#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/module.hpp"

namespace bip::genom {

/// `extern function` lines of all codels, and of what tells the values of posters.
[[nodiscard]] std::string codel_prototypes(const std::vector<Module>& modules, const GenerateOptions& options);
/// The function that tells a value when its poster is written: MODULE_POSTER_VALUE.
[[nodiscard]] std::string value_function(const std::vector<Module>& modules, const ValueRow& value);
[[nodiscard]] std::string value_function(const Module& module, const ValueRow& value);
/// What BIP calls for it: that function, or the one that asks the module's process.
[[nodiscard]] std::string called_value_function(const Module& module, const ValueRow& value, bool has_processes);
/// The C++ function that BIP calls when a request is `what`: "asked", "input".
[[nodiscard]] std::string request_function(const GenerateOptions& options, const std::string& what);

/// The codel that a state of an activity or of a task has, or that does a request at once.
struct CodelFunction {
  std::string name{};
  std::string module{};
  bool has_report = false;             // of an activity: returns what is next, and may set a report
  std::string says{};                  // what it is, for a reader
  std::vector<std::string> answers{};  // "EXEC = 2"
  int first = 0;                       // answer of the skeleton
  bool is_unlimited = false;           // it runs beside its task without a budget
  std::int64_t budget_us = 0;
  std::int64_t wcet_us = 0;  // its longest time as description or side file say, async or not; 0: none is known
};
/// Each once, in the order of the descriptions.
[[nodiscard]] std::vector<CodelFunction> functions_of(const std::vector<Module>& modules);

}  // namespace bip::genom
