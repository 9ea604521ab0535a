// The interface of an engine: one way to answer a question about a system. The portfolio (portfolio.cpp) has the table
// that says which engine is tried when, with which share of the time.
//
// A new engine is a function and one `Engine` row in a file of its own, and one row or more in the portfolio's table.
#pragma once
#include <limits>

#include "compiler/verify/portfolio/proof_context.hpp"

namespace bip::verify {

/// What one attempt may use.
struct Budget {
  double seconds = std::numeric_limits<double>::infinity();  // of processor time
};

/// Pointless: the engine would do the same again with more time.
enum class Retry : std::uint8_t { Useful, Pointless };

/// What one attempt has found. A verdict comes with its evidence; without verdict the reason says why, if the user
/// should know.
struct EngineResult {
  Outcome outcome = Outcome::Unknown;
  Evidence evidence;
  Retry retry = Retry::Useful;
  std::string reason;                   // Unknown
  std::optional<std::uint64_t> states;  // visited by a search
  std::vector<std::string> permuted;    // by a search up to symmetry: groups of equal components
  std::optional<u32> frames;            // of IC3
  std::string fault;                    // a run-time error that a search met and that was not asked about
};

struct Engine {
  const char* name;
  /// Can the engine answer such a question at all? Cheap; it prepares nothing.
  bool (*applies_to)(const ProofContext& context);
  /// Tries within the budget and until `cancellation`, which ends the whole question, is over. Facts that it finds on
  /// the way stay in the context. The evidence of a verdict has been checked: a counterexample was replayed.
  EngineResult (*attempt)(ProofContext& context, const Budget& budget, const CancellationToken& cancellation);
};

}  // namespace bip::verify
