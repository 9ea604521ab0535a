// A verdict in words and as JSON.
#pragma once
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "compiler/pipeline/pipeline.hpp"
#include "compiler/verify/evidence/relevant_steps.hpp"
#include "compiler/verify/portfolio/portfolio.hpp"

namespace bip::library {

using namespace pipeline;

enum class Finding : std::uint8_t { Holds, Violated };
/// The verdict's name in text and JSON: "deadlock-free", "deadlock", "holds" …
[[nodiscard]] const char* name_of(verify::QuestionKind asked, Finding finding);

struct VerdictText {
  int exit_code = 0;
  std::string name;  // "deadlock-free", "violated", "unknown" …
  std::string text;
  // Of a run that breaks what was asked.
  std::size_t left_out = 0;  // steps that it does not need
  std::optional<verify::DecidingStep> decided = std::nullopt;
};
/// Evidence: after the verdict the invariants, equations and lemmas of the proof.
enum class Explanation : std::uint8_t { None, Evidence };

/// Processor time for the question about errors, which the user did not ask, in seconds.
inline constexpr double kErrorSeconds = 0.5;
/// What a verdict that holds says of errors that it was not about.
inline constexpr const char* kErrorsNotAsked =
    "note: errors were not asked for: `--property errors` shows whether a run can end with one\n";
/// The same for all sizes: errors are asked of one system.
inline constexpr const char* kErrorsNotAskedOfSizes =
    "note: errors were not asked for: `--property errors` with the root of one size shows whether a run of it can end "
    "with one\n";
/// What a verdict that holds of runs says of those that end with an error.
inline constexpr const char* kEndsInError =
    "note: this holds, but a run can end with an error: `--property errors` shows it\n";
/// The note of a verdict that holds.
[[nodiscard]] std::string error_note(const std::string& fault);
/// What a verdict that holds of a model with C++ says of this.
inline constexpr const char* kCppReturns =
    "note: the model's C++ is taken to return, with any value; a crash or an endless loop in it is not looked at\n";

/// Says the verdict, with the counterexample's steps or the reason of an unknown. The image has its code if the
/// decision is Violated.
[[nodiscard]] VerdictText verdict_text(const Compilation& c, const verify::Question& question,
                                       const verify::Decision& d, const verify::Portfolio& portfolio,
                                       Explanation explanation);
/// What `--stats` adds. `engine`: the name of the one with the verdict; null: none has one. `cache` null: proofs were
/// neither reused nor stored.
struct VerifyStats {
  const char* engine = nullptr;
  double seconds = 0;  // of the processor
  std::uint64_t candidates = 0;
  const verify::ProofCache* cache = nullptr;
  const std::vector<std::string>* permuted = nullptr;  // groups of equal components, of a search up to symmetry
};
/// Returns the verdict as one object; `stats` may be null; `run`: of counterexample_json, may be empty.
[[nodiscard]] nlohmann::ordered_json verdict_json(const VerdictText& text, const verify::Question& question,
                                                  const verify::Decision& d, const VerifyStats* stats,
                                                  const std::string& run = {});
/// Of a quantifier that was asked of its first conditions, which stand for all: how many it has, how many were asked.
[[nodiscard]] nlohmann::ordered_json quantifier_json(const verify::Property& property);
/// Returns a line each: the engine that decided, time and candidates; the symmetry that a search used; reuse of proofs.
[[nodiscard]] std::string stats_text(const VerifyStats& stats);

}  // namespace bip::library
