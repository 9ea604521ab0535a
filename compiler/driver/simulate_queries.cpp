// See simulate_queries.hpp.
#include "compiler/driver/simulate_queries.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "compiler/driver/report.hpp"
#include "compiler/library/markov_chain.hpp"
#include "compiler/library/read_observer.hpp"
#include "compiler/pipeline/ffi_build.hpp"
#include "compiler/system/uses_time.hpp"
#include "runtime/engine/splitting.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {
namespace {

using library::Interval;
using library::Query;
using library::QueryAnswer;
using library::QueryKind;
using library::QueryVerdict;
using QueryJson = nlohmann::ordered_json;

constexpr std::uint32_t kMostChainStates = 2'000'000;

bool refuse_query(const std::string& text, const std::string& why) {
  usage_error(fmt::format("--query '{}': {}", text, why));
  return false;
}

bool is_test(const Query& query) { return query.kind == QueryKind::AtLeast || query.kind == QueryKind::AtMost; }

const char* word_of(QueryVerdict verdict) {
  switch (verdict) {
    case QueryVerdict::Holds: return "holds";
    case QueryVerdict::Violated: return "violated";
    case QueryVerdict::Unknown: return "unknown";
    case QueryVerdict::None: break;
  }
  return "";
}

std::string digits(double value) { return fmt::format("{:.6g}", value); }
std::string interval_text(const Interval& i) { return fmt::format("[{}, {}]", digits(i.low), digits(i.high)); }

// A number for JSON, which has no infinity.
QueryJson json_number(double value) { return std::isfinite(value) ? QueryJson(value) : QueryJson("infinity"); }

void note_verdict(QueryVerdict verdict, QueryReport& out) {
  out.is_violated |= verdict == QueryVerdict::Violated;
  out.is_unknown |= verdict == QueryVerdict::Unknown;
}

void report_answer(const Query& query, const QueryAnswer& answer, double confidence, QueryReport& out) {
  BIP_ASSERT(answer.successes + answer.open <= answer.runs, "{} successes and {} runs without an answer of {}",
             answer.successes, answer.open, answer.runs);
  const std::string value =
      answer.open == 0 ? digits(answer.low()) : fmt::format("{} to {}", digits(answer.low()), digits(answer.high()));
  out.text += fmt::format("{}: {}, {}% interval {}, {} of {} runs", query.text, value, 100 * confidence,
                          interval_text(answer.interval), answer.successes, answer.runs);
  if (answer.open != 0) out.text += fmt::format(", {} without an answer", answer.open);
  out.text += "\n";
  out.json.push_back({{"query", query.text},
                      {"method", "runs"},
                      {"runs", answer.runs},
                      {"successes", answer.successes},
                      {"open", answer.open},
                      {"value", answer.low()},
                      {"confidence", confidence},
                      {"interval", {answer.interval.low, answer.interval.high}}});
}

// A test is about a share that the interval has on one side, or not.
QueryVerdict verdict_of(const Query& query, const Interval& value) {
  BIP_ASSERT(is_test(query), "a verdict on {}", query.text);
  if (value.low >= query.share && value.high <= query.share) return QueryVerdict::Holds;
  if (value.low >= query.share) return query.kind == QueryKind::AtLeast ? QueryVerdict::Holds : QueryVerdict::Violated;
  if (value.high <= query.share) return query.kind == QueryKind::AtMost ? QueryVerdict::Holds : QueryVerdict::Violated;
  return QueryVerdict::Unknown;
}

}  // namespace

std::optional<std::vector<Query>> read_queries(const SimulateArguments& a, const Compilation& c) {
  std::vector<Query> queries;
  for (const std::string& text : a.queries) {
    Result<Query> query = library::read_query(text, *c.system);
    if (!query) return refuse_query(text, query.error()), std::nullopt;
    if (is_test(*query) && !a.exact && (query->share - a.test.delta <= 0 || query->share + a.test.delta >= 1))
      return refuse_query(text, fmt::format("a test of {} needs a --delta below {}", query->share,
                                            digits(std::min(query->share, 1 - query->share)))),
             std::nullopt;
    const bool is_time = query->kind == QueryKind::Expectation && query->observer.kind == rt::ObserverKind::Time;
    if (a.exact && query->kind == QueryKind::Expectation && !is_time)
      return refuse_query(text, "of expectations, --exact knows `E=? [ time until EXPR ]`"), std::nullopt;
    if (!a.importance.empty() && (query->kind != QueryKind::Probability || query->path.is_negated))
      return refuse_query(text, "splitting (--importance) estimates `P=? [ F … ]` and `P=? [ … U … ]`"), std::nullopt;
    queries.push_back(std::move(*query));
  }
  if (queries.empty() && (a.exact || !a.importance.empty())) {
    usage_error("--exact and --importance need a --query");
    return std::nullopt;
  }
  return queries;
}

void add_queries(const std::vector<Query>& queries, rt::SimulateOptions& options) {
  for (const Query& query : queries) {
    if (query.kind == QueryKind::Probability) options.queries.push_back(query.path);
    if (query.kind == QueryKind::Expectation) options.observers.push_back(query.observer);
  }
}

void report_estimates(const std::vector<Query>& queries, const rt::SimulateReport& found, double confidence,
                      QueryReport& out) {
  std::size_t path = 0;
  std::size_t observer = found.values.size();
  for (const Query& query : queries) observer -= query.kind == QueryKind::Expectation ? 1 : 0;
  BIP_ASSERT(observer <= found.values.size(), "{} observers for {} queries", found.values.size(), queries.size());
  for (const Query& query : queries) {
    if (query.kind == QueryKind::Probability)
      report_answer(query, library::answer_from(found, path++, confidence), confidence, out);
    if (query.kind != QueryKind::Expectation) continue;
    const auto [of, interval] = library::estimate_of(query.observer, found.values[observer++], confidence);
    QueryJson row{{"query", query.text}, {"method", "runs"}, {"runs", of.count}};
    if (of.count == 0) {
      out.text += fmt::format("{}: in no run\n", query.text);
    } else {
      out.text += fmt::format("{}: {}, {}% interval {}, {} runs\n", query.text, digits(of.mean), 100 * confidence,
                              interval_text(interval), of.count);
      row.update({{"value", of.mean}, {"confidence", confidence}, {"interval", {interval.low, interval.high}}});
    }
    out.json.push_back(std::move(row));
  }
}

void report_tests(const std::vector<Query>& queries, const SimulateArguments& a, const rt::Image& image,
                  const rt::SimulateOptions& options, QueryReport& out) {
  constexpr std::uint64_t kMostTestRuns = 10'000'000;
  for (const Query& query : queries) {
    if (!is_test(query)) continue;
    rt::SimulateOptions runs = options;
    if (!a.has_runs && a.within == 0) runs.runs = kMostTestRuns;
    const library::TestRun found = library::test_query(query, image, runs, a.test);
    out.is_complete &= found.is_complete;
    if (out.first_fault.empty()) out.first_fault = found.first_fault;
    note_verdict(found.answer.verdict, out);
    out.text +=
        fmt::format("{}: {}, {} of {} runs (alpha {}, beta {}, delta {})\n", query.text, word_of(found.answer.verdict),
                    found.answer.successes, found.answer.runs, a.test.alpha, a.test.beta, a.test.delta);
    if (found.answer.open != 0) out.text += fmt::format("  run {} ended without an answer\n", found.answer.runs);
    out.json.push_back({{"query", query.text},
                        {"method", "test"},
                        {"verdict", word_of(found.answer.verdict)},
                        {"runs", found.answer.runs},
                        {"successes", found.answer.successes},
                        {"open", found.answer.open},
                        {"alpha", a.test.alpha},
                        {"beta", a.test.beta},
                        {"delta", a.test.delta}});
  }
}

bool report_exact(const std::vector<Query>& queries, const Compilation& c, rt::MaximalProgress progress,
                  QueryReport& out) {
  if (system::is_timed(*c.system)) return refuse_query(queries[0].text, "--exact is for models without time");
  if (uses_ffi(c)) return refuse_query(queries[0].text, "--exact is for models without C++");
  std::vector<std::function<bool(const rt::Core&)>> conditions;
  const auto always = [](const rt::Core&) { return true; };
  for (const Query& query : queries) {
    if (query.kind == QueryKind::Expectation) {
      conditions.emplace_back(always);
      conditions.emplace_back([of = query.observer.value](const rt::Core& core) { return of(core) != 0; });
    } else {
      conditions.push_back(query.path.stays ? query.path.stays : always);
      conditions.push_back(query.path.goal);
    }
  }
  std::vector<library::StateSet> sets;
  Result<library::MarkovChain> chain =
      library::build_chain(c.lowered->image, progress, kMostChainStates, conditions, sets);
  if (!chain) return refuse_query(queries[0].text, "no Markov chain of this model: " + chain.error());
  BIP_ASSERT(sets.size() == conditions.size() && sets.size() == 2 * queries.size(), "{} sets of {} conditions",
             sets.size(), conditions.size());
  for (std::size_t k = 0; k < queries.size(); ++k) {
    const Query& query = queries[k];
    Interval value;
    if (query.kind == QueryKind::Expectation) {
      value.low = value.high = library::expected_steps(*chain, sets[2 * k + 1]);
    } else {
      value = library::reach_probability(*chain, sets[2 * k], sets[2 * k + 1], query.path.most_steps);
      if (query.path.is_negated) value = {1 - value.high, 1 - value.low};
    }
    const bool is_too_small =
        query.kind != QueryKind::Expectation && value.high > 0 && value.high <= library::kLeastProbability;
    const double middle = is_too_small ? 0 : value.low + (value.high > value.low ? (value.high - value.low) / 2 : 0);
    out.text += fmt::format("{}: ", query.text);
    QueryJson row{{"query", query.text}, {"method", "exact"}, {"states", chain->states()}};
    if (is_test(query)) {
      const QueryVerdict verdict = verdict_of(query, value);
      note_verdict(verdict, out);
      out.text += fmt::format("{}, as it is ", word_of(verdict));
      row["verdict"] = word_of(verdict);
    }
    const std::string shown = is_too_small ? fmt::format("below {:.3g}", value.high) : fmt::format("{:.10g}", middle);
    out.text += fmt::format("{}, {} states\n", shown, chain->states());
    row["value"] = json_number(middle);
    row["interval"] = {json_number(value.low), json_number(value.high)};
    out.json.push_back(std::move(row));
  }
  return true;
}

bool report_split(const std::vector<Query>& queries, const SimulateArguments& a, const Compilation& c,
                  const rt::SimulateOptions& options, QueryReport& out) {
  if (uses_ffi(c)) return refuse_query(queries[0].text, "splitting is for models without C++");
  Result<std::function<double(const rt::Core&)>> importance = library::read_number(a.importance, *c.system);
  if (!importance) {
    usage_error("--importance, " + importance.error());
    return false;
  }
  for (const Query& query : queries) {
    rt::SplittingOptions split{.query = query.path,
                               .importance = *importance,
                               .levels = a.levels,
                               .effort = a.effort,
                               .replications = a.replications,
                               .seed = options.seed,
                               .limit = a.has_limit ? options.limit : rt::SplittingOptions{}.limit,
                               .threads = options.threads,
                               .asap = options.asap,
                               .progress = options.progress,
                               .is_stopped = {}};
    std::sort(split.levels.begin(), split.levels.end());
    const rt::SplittingReport found = rt::split(c.lowered->image, split);
    out.is_complete &= found.is_complete || !found.fault.empty();
    if (out.first_fault.empty()) out.first_fault = found.fault;
    if (!found.is_complete) continue;
    const library::Estimate of = library::estimate(found.estimates, {}, a.confidence);
    out.text += fmt::format("{}: {}, {}% interval {}, {} levels, {} replications of {} runs a level, {} steps",
                            query.text, digits(of.mean), 100 * a.confidence, interval_text(of.mean_interval),
                            found.levels.size(), split.replications, split.effort, found.steps);
    if (found.open != 0) out.text += fmt::format(", {} runs without an answer", found.open);
    out.text += "\n";
    out.json.push_back({{"query", query.text},
                        {"method", "splitting"},
                        {"value", of.mean},
                        {"confidence", a.confidence},
                        {"interval", {of.mean_interval.low, of.mean_interval.high}},
                        {"levels", found.levels},
                        {"replications", split.replications},
                        {"effort", split.effort},
                        {"open", found.open},
                        {"steps", found.steps}});
  }
  return true;
}

}  // namespace bip::driver
