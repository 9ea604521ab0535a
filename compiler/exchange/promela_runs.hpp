// Writes what a property of runs needs beside the states: points with the step that is taken, and rounds of fair steps.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compiler/exchange/exchange.hpp"
#include "compiler/system/system_ids.hpp"
#include "compiler/verify/property/fairness.hpp"
#include "compiler/verify/property/formula.hpp"

namespace bip::exchange {

/// One alternative of the process: an interaction, or a port that needs no connector.
struct StepText {
  std::string possible;  // is it a candidate?
  std::optional<ConnectorId> connector;
  std::vector<std::pair<AtomId, u32>> ports;  // that take part
};

enum class MayFault : std::uint8_t { No, Yes };

/// Texts for the process of a model whose runs are asked about.
class PromelaRuns {
 public:
  PromelaRuns(std::vector<StepText> steps, const verify::Formula& formula, const verify::Fairness& fairness);

  /// Variables, macros, and what looks at the state after each step.
  [[nodiscard]] std::string declarations() const;
  /// The condition of a step, and statements at the end of its `d_step`.
  [[nodiscard]] std::string before_step(std::size_t step) const;
  [[nodiscard]] std::string after_step(std::size_t step) const;
  /// Alternatives of the process that take no step of the model.
  [[nodiscard]] std::string alternatives() const;
  /// The statements that say that the initial state is reached.
  [[nodiscard]] std::string start() const {
    return std::string(has_chosen_ ? "skip" : "ready = true") + (is_fair() ? "; note_end()" : "");
  }
  /// "(! ([] (<> fair))) || ": runs that are not fair, or that end in an error, do not matter.
  [[nodiscard]] std::string premise(MayFault may_fault) const;
  /// `happens` and `next` as formulas. Requires that the formula has them.
  [[nodiscard]] std::string happens(const verify::StepCondition& condition) const;
  [[nodiscard]] std::string next(const std::string& operand) const;

 private:
  [[nodiscard]] bool is_fair() const { return !fairness_.is_none(); }
  [[nodiscard]] bool is_strong() const { return fairness_.has(verify::FairnessKind::Strong); }
  [[nodiscard]] std::size_t none() const { return steps_.size(); }
  [[nodiscard]] std::string condition() const;
  [[nodiscard]] std::string rounds() const;

  /// Takes its turn in each round.
  struct Unit {
    std::vector<std::size_t> steps;
    bool is_strong = false;
  };
  void add_units(const verify::FairnessTerm& term);

  std::vector<StepText> steps_;
  verify::Fairness fairness_;
  std::vector<Unit> units_;
  bool has_chosen_ = false;  // is a step chosen before it is taken?
};

}  // namespace bip::exchange
