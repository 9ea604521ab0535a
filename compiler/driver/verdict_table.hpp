// The answers to several questions about one model: `bipc verify` of a model that states properties.
#pragma once
#include <string>
#include <vector>

#include "compiler/library/decide.hpp"

namespace bip::driver {

struct NamedVerdict {
  std::string name;  // "deadlock", "table.exclusion"
  library::Verdict verdict;
};

/// A line for each question; then, for each that does not hold, the whole answer; then the notes, each once.
[[nodiscard]] std::string verdict_table(const std::vector<NamedVerdict>& verdicts);
/// One line: the verdicts as `bipc verify --json` writes one, each with its name.
[[nodiscard]] std::string verdict_table_json(const std::vector<NamedVerdict>& verdicts);
/// The exit code of all: that of the first violation, else of what is unknown, else 0.
[[nodiscard]] int worst_exit_code(const std::vector<NamedVerdict>& verdicts);

}  // namespace bip::driver
