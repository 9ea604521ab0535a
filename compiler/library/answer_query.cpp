// See answer_query.hpp.
#include "compiler/library/answer_query.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::library {

QueryAnswer answer_from(const rt::SimulateReport& report, std::size_t k, double confidence) {
  BIP_ASSERT(k < report.answers.size(), "query {} of {}", k, report.answers.size());
  QueryAnswer out;
  BIP_ASSERT(report.answers[k].size() == report.ends.size(), "{} answers of {} runs", report.answers[k].size(),
             report.ends.size());
  for (std::size_t run = 0; run < report.ends.size(); ++run) {
    if (report.ends[run] == rt::SimulatedEnd::NotRun) continue;
    ++out.runs;
    if (report.answers[k][run] == rt::Answer::Yes) ++out.successes;
    if (report.answers[k][run] == rt::Answer::Open) ++out.open;
  }
  out.interval = {clopper_pearson(out.successes, out.runs, confidence).low,
                  clopper_pearson(out.successes + out.open, out.runs, confidence).high};
  return out;
}

TestRun test_query(const Query& query, const rt::Image& image, rt::SimulateOptions options, const TestOptions& test) {
  constexpr std::uint64_t kFirstRound = 256, kMostPerRound = 1 << 16;
  BIP_ASSERT(query.kind == QueryKind::AtLeast || query.kind == QueryKind::AtMost, "`{}` is no test", query.text);
  TestRun out;
  SequentialTest ratio(query.share, test);
  options.queries = {query.path};
  options.observers.clear();
  const std::uint64_t most = options.runs, first_seed = options.seed;
  auto verdict = SequentialTest::Verdict::Open;
  for (std::uint64_t round = kFirstRound; out.answer.runs < most && verdict == SequentialTest::Verdict::Open;
       round = std::min(2 * round, kMostPerRound)) {
    options.seed = first_seed + out.answer.runs;
    options.runs = std::min(round, most - out.answer.runs);
    const rt::SimulateReport report = rt::simulate(image, options);
    out.is_complete = report.is_complete;
    for (std::size_t run = 0; run < report.ends.size() && verdict == SequentialTest::Verdict::Open; ++run) {
      if (report.ends[run] == rt::SimulatedEnd::NotRun) break;
      const rt::Answer answer = report.answers[0][run];
      ++out.answer.runs;
      if (answer == rt::Answer::Open) {
        ++out.answer.open;
        out.first_fault = report.first_fault;
        break;
      }
      if (answer == rt::Answer::Yes) ++out.answer.successes;
      verdict = ratio.add(answer == rt::Answer::Yes);
    }
    if (out.answer.open != 0 || !out.is_complete) break;
  }
  out.answer.interval = {clopper_pearson(out.answer.successes, out.answer.runs, kConfidence).low,
                         clopper_pearson(out.answer.successes + out.answer.open, out.answer.runs, kConfidence).high};
  BIP_ASSERT(out.answer.runs <= most && out.answer.successes + out.answer.open <= out.answer.runs,
             "{} of {} runs, {} successes", out.answer.runs, most, out.answer.successes);
  const bool is_wanted = (verdict == SequentialTest::Verdict::Yes) == (query.kind == QueryKind::AtLeast);
  out.answer.verdict = verdict == SequentialTest::Verdict::Open ? QueryVerdict::Unknown
                       : is_wanted                              ? QueryVerdict::Holds
                                                                : QueryVerdict::Violated;
  return out;
}

}  // namespace bip::library
