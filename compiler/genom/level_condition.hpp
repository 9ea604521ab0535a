// Translates conditions of rules to guards: the text, and the ports that must take part so that the guard can be
// evaluated. Internal to compiler/genom.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/plan.hpp"

namespace bip::genom {

/// Names of the parts that rules need, by row of Constraints.
struct LevelParts {
  std::vector<std::string> parameters, stopwatches, pairs, successes, silences, failures, edges, recoveries;
};

class ConditionWriter {
 public:
  ConditionWriter(const std::vector<Plan>& plans, const GenerateOptions& options, const LevelParts& parts,
                  std::int64_t tick_us)
      : plans_(plans), options_(options), parts_(parts), tick_us_(tick_us) {}

  /// The guard; ports that are not yet in `ports` are added.
  [[nodiscard]] std::string text(const Condition& condition, std::vector<std::string>& ports) const;
  /// The same as a property has it, which names components and their data, not ports.
  [[nodiscard]] std::string property(const Condition& condition) const;
  /// "NDD.stat_GoTo" of each instance.
  [[nodiscard]] std::vector<std::string> stats(ServiceRef s) const;
  /// `span` in ticks, at least one.
  [[nodiscard]] std::int64_t ticks(Span span) const;

 private:
  [[nodiscard]] std::string any_of(ServiceRef s, const char* what, const char* sign,
                                   std::vector<std::string>* ports) const;
  [[nodiscard]] std::string read(const std::string& part, const char* what, std::vector<std::string>* ports) const;
  // `ports`: null for a property.
  [[nodiscard]] std::string write(const Condition& condition, std::vector<std::string>* ports) const;

  const std::vector<Plan>& plans_;
  const GenerateOptions& options_;
  const LevelParts& parts_;
  std::int64_t tick_us_;
};

/// In steps of PosterAge: the oldest that is within `span`.
[[nodiscard]] std::int64_t steps_of_age(Span span, const GenerateOptions& options, std::int64_t tick_us);
/// A fraction, digits with at most four behind the dot, as a whole number: the prover does not compute with fractions.
[[nodiscard]] std::string ten_thousandths(const std::string& fraction);
/// Adds what is not there yet.
void add_port(std::vector<std::string>& ports, const std::string& port);

}  // namespace bip::genom
