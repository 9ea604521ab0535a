// Decides whether a compiled model has a deadlock, ends with an error or violates a property, and says so as data, in
// words and as JSON. What `bipc verify` and `bip::compiler` answer; nothing is printed and no signal is handled here.
#pragma once
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "compiler/library/verify_request.hpp"
#include "compiler/pipeline/pipeline.hpp"
#include "compiler/verify/portfolio/portfolio.hpp"
#include "runtime/explore/counterexample.hpp"

namespace bip::library {

using namespace pipeline;

/// A run that breaks what was asked, or shows that something is possible; the core has taken it.
struct FoundRun {
  rt::CounterexampleEnd end = rt::CounterexampleEnd::Deadlock;
  rt::TimedPath path;
  std::string trace;  // JSON lines, if they were wanted
  // Properties of runs: the steps from here on repeat for ever; the path's length: it ends, and its last state repeats.
  std::optional<std::size_t> cycle = std::nullopt;
};
struct Verdict {
  bool is_answered = false;  // false: the compilation's diagnostics say why there is none
  int exit_code = 0;         // of `bipc verify`
  std::string text;          // the answer with its run and its notes
  std::string figures;       // lines that `--stats` adds
  [[nodiscard]] std::string text_with_figures() const { return text + figures; }
  // What `--json` prints; its `text` is the text above.
  nlohmann::ordered_json json;
  std::string certificate;  // if it was wanted and the answer has one
  // Also the run that shows a property to hold which begins with `possibly`.
  std::optional<FoundRun> counterexample;
};

/// Returns the question that the text asks: `deadlock` (also the empty text), `errors`, the name of a property that the
/// model states, or a property of states or of runs; else what is wrong with it.
[[nodiscard]] Result<verify::Question> read_question(const std::string& text, const System& system);
[[nodiscard]] Result<verify::Question> read_question(const VerifyRequest& request, const System& system);
/// Of a property by its text; `reader` lists a system's paths once for many properties.
[[nodiscard]] Result<verify::Question> read_question(const std::string& property, const verify::PropertyReader& reader);

/// The data that the question's property reads.
[[nodiscard]] std::vector<DataRef> data_of(const verify::Question& question);

/// Returns whether steps depend on what no state determines: results of C++, random numbers. Then states are not
/// visited and steps are not replayed.
[[nodiscard]] bool has_undetermined_values(const System& system);

/// Models with C++, without a certificate: takes out what decides about no state, so that they can be searched; `data`
/// is what all questions to come read. Returns a note for the answers, empty if the system is as before.
[[nodiscard]] std::string remove_unread_cpp(const VerifyRequest& request, Compilation& c,
                                            const std::vector<DataRef>& data);

/// The verdict if the initialization ends with an error, so that no run reaches a state that is asked about.
[[nodiscard]] std::optional<Verdict> decide_initial_fault(const Compilation& c, const verify::Question& question);

/// Answers the question until the token or the request's time is over; `note` ends the text. Requires an image.
[[nodiscard]] Verdict decide(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                             const std::string& note, const verify::CancellationToken& token,
                             const verify::Report& report);
/// The same for a model with time, which `decide` calls: by parts, else by the zone graph.
[[nodiscard]] Verdict decide_timed(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                                   const std::string& note, const verify::CancellationToken& token);

/// The same for `within`, and for a model with time also for a response without a limit: on the zone graph with an
/// observer.
[[nodiscard]] Verdict decide_response(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                                      const std::string& note, const verify::CancellationToken& token);

/// The same for `always E` and `never E` of a model with time where E looks back: on the zone graph with a monitor.
[[nodiscard]] Verdict decide_timed_past(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                                        const std::string& note, const verify::CancellationToken& token);

/// The same for a property of runs, on the graph of all reachable states.
[[nodiscard]] Verdict decide_liveness(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                                      const std::string& note, const verify::CancellationToken& token,
                                      const verify::Report& report);

/// The same for a property of branching time, on the same graph.
[[nodiscard]] Verdict decide_branching(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                                       const std::string& note, const verify::CancellationToken& token,
                                       const verify::Report& report);

/// The same for a property `possibly …` that is the negation of a property of all runs, which any of the engines above
/// can decide: the run that violates the one shows the other, and a proof of the one, with its certificate, excludes
/// the other. Nothing if the graph has to be asked, and has an answer.
[[nodiscard]] std::optional<Verdict> decide_possible(const VerifyRequest& request, Compilation& c,
                                                     const verify::Question& question, const std::string& note,
                                                     const verify::CancellationToken& token,
                                                     const verify::Report& report);

/// A question that no engine answers yet.
struct Unsupported {
  std::string what;  // "fairness for a model with time"
  std::string note, help;
};
/// Reports it (B1900) and returns no answer, or returns the answer `unknown` if the question is one of many.
[[nodiscard]] Verdict refuse(const VerifyRequest& request, Compilation& c, const verify::Question& question,
                             const Unsupported& unsupported);

/// A verdict that needed no proof.
[[nodiscard]] Verdict plain_verdict(const verify::Question& question, int exit_code, const std::string& name,
                                    const std::string& text);

}  // namespace bip::library
