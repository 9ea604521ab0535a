// What verdicts about models with time share. Internal to compiler/library.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "compiler/library/decide.hpp"
#include "runtime/explore/counterexample.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::library {

/// Why a search of zones has no answer.
[[nodiscard]] std::string limit_text(const rt::ZoneReport& found, const verify::CancellationToken& cancellation);
/// "5 zones of 4 locations".
[[nodiscard]] std::string size_text(const rt::ZoneReport& found);
/// Notes in the JSON of a verdict, and returns as text, why it is unknown: `has_run` says that the search has found a
/// way that the core could not take.
[[nodiscard]] std::string unknown_text(const rt::ZoneReport& found, bool has_run,
                                       const verify::CancellationToken& cancellation, nlohmann::ordered_json& json);
/// The note of a verdict that holds: with which error a run can end, if the search has met one; else empty. The image
/// has its code.
[[nodiscard]] std::string error_note(const rt::Image& image, const rt::ZoneReport& found);
/// What goes on for ever after so many steps, without a full stop: the steps from number `cycle` on, or time alone; or
/// the run ends there in a time lock.
[[nodiscard]] std::string endless_text(rt::CounterexampleEnd end, std::size_t steps, std::optional<std::size_t> cycle);
/// "57ms".
[[nodiscard]] std::string time_text(std::int64_t ticks);
[[nodiscard]] Verdict verdict_of(nlohmann::ordered_json json, std::string text, int exit_code);
/// Why a certificate of a zone graph says less than it should: guards of connectors or priorities that can fault, for
/// which of several faults, or of a fault and a false guard, comes first is not for a checker to know.
[[nodiscard]] bool can_fault_in_guards(const System& system);
/// The refusal of `can` in a property of runs of a model with time; nothing: it has none.
[[nodiscard]] std::optional<Verdict> refuse_offers(const VerifyRequest& request, Compilation& c,
                                                   const verify::Question& question);
/// Options of a search of zones for the question, which `cancellation` ends; it must live as long as the search.
[[nodiscard]] rt::ExploreOptions zone_options(const VerifyRequest& request, const Compilation& c,
                                              const verify::Question& question,
                                              const verify::CancellationToken& cancellation);
/// Notes in the JSON of a verdict, and returns, the run along a path to what was found, with what the request wants of
/// it. The image has its code.
[[nodiscard]] FoundRun found_run(const VerifyRequest& request, const rt::Image& image, rt::CounterexampleEnd end,
                                 const rt::TimedPath& path, nlohmann::ordered_json& json);
/// Of a model with C++ or random numbers, which zones cannot follow.
[[nodiscard]] Verdict unknown_because_of_values(const System& system);

}  // namespace bip::library
