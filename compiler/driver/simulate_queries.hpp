// `bipc simulate --query`: reads the questions, and answers them by runs, exactly or by splitting.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "compiler/driver/options.hpp"
#include "compiler/library/answer_query.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::driver {

/// What is printed about the queries, and what the exit code is.
struct QueryReport {
  std::string text;
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  bool is_complete = true;
  std::string first_fault;
  bool is_violated = false, is_unknown = false;
};

/// Parses the queries and checks that the options allow them. nullopt: an error has been printed.
[[nodiscard]] std::optional<std::vector<library::Query>> read_queries(const SimulateArguments& arguments,
                                                                      const Compilation& c);
/// Adds what one simulation answers: paths whose probability is asked, and observers.
void add_queries(const std::vector<library::Query>& queries, rt::SimulateOptions& options);
/// What the simulation says of those.
void report_estimates(const std::vector<library::Query>& queries, const rt::SimulateReport& found, double confidence,
                      QueryReport& out);
/// Tests queries of the form `P>=share [ … ]`.
void report_tests(const std::vector<library::Query>& queries, const SimulateArguments& arguments,
                  const rt::Image& image, const rt::SimulateOptions& options, QueryReport& out);
/// Answers all queries on the Markov chain. False: an error has been printed.
[[nodiscard]] bool report_exact(const std::vector<library::Query>& queries, const Compilation& c,
                                rt::MaximalProgress progress, QueryReport& out);
/// Answers all queries by importance splitting. False: an error has been printed.
[[nodiscard]] bool report_split(const std::vector<library::Query>& queries, const SimulateArguments& arguments,
                                const Compilation& c, const rt::SimulateOptions& options, QueryReport& out);

}  // namespace bip::driver
