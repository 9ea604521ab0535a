// Answers queries (read_query.hpp) by runs: estimates with intervals, and tests that end when they know enough.
#pragma once
#include <string>
#include <vector>

#include "compiler/library/observer_estimate.hpp"
#include "compiler/library/read_query.hpp"
#include "compiler/library/sequential_test.hpp"

namespace bip::library {

enum class QueryVerdict : std::uint8_t { None, Holds, Violated, Unknown };
struct QueryAnswer {
  std::uint64_t runs = 0;                     // that were made for it
  std::uint64_t successes = 0;                // in which the path is
  std::uint64_t open = 0;                     // that ended before it was known, at a limit or in an error
  Interval interval;                          // of the probability, open runs may be either
  QueryVerdict verdict = QueryVerdict::None;  // of a test

  [[nodiscard]] double low() const {
    return runs == 0 ? 0 : static_cast<double>(successes) / static_cast<double>(runs);
  }
  [[nodiscard]] double high() const {
    return runs == 0 ? 1 : static_cast<double>(successes + open) / static_cast<double>(runs);
  }
};

/// What the runs of a simulation say of its query k; the interval has that confidence.
[[nodiscard]] QueryAnswer answer_from(const rt::SimulateReport& report, std::size_t k, double confidence);

struct TestRun {
  QueryAnswer answer;
  bool is_complete = true;  // false: interrupted
  std::string first_fault;
};
/// Tests AtLeast or AtMost by as many runs as it takes, at most `options.runs`, from options.seed on. Runs are judged
/// in their order, so the result does not depend on the number of threads. The answer is Unknown if they do not
/// suffice, or as soon as one is open. Requires that the query's share allows the test.
[[nodiscard]] TestRun test_query(const Query& query, const rt::Image& image, rt::SimulateOptions options,
                                 const TestOptions& test);

}  // namespace bip::library
