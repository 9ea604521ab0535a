// Reads the text trace of the published engine (and of --trace-format=bip2).
//
// Relevant lines begin with `[BIP ENGINE]: `; output of the model in between is skipped. A state consists of its
// candidates and of the choice; the last state may be a deadlock or be truncated anywhere.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/base/result.hpp"

namespace bip::driver {

struct TraceState {
  std::uint64_t number = 0;
  std::size_t line = 0;                 // of its first line, from 1
  std::vector<std::string> candidates;  // without "[k] ", with their intervals
  std::string chosen;                   // empty: none
  std::string instant;                  // "1s500ms", when it was taken; empty: the trace has no time
  bool is_deadlock = false;
  bool is_complete = false;  // as many candidates as its first line says
};

/// Fails if no state is found or a line of one cannot be read; the message names the line.
[[nodiscard]] Result<std::vector<TraceState>> read_published_trace(std::string_view text);

/// A candidate in the form in which two engines' are compared: white space, truth values and digits of floats apart.
[[nodiscard]] std::string normal_candidate(std::string_view candidate);

}  // namespace bip::driver
