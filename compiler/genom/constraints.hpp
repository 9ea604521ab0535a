// The constraints of rules on a functional level, as the generator reads them: which requests are admitted, which
// activities are stopped and when, which wait for others. compiler/rules fills them from a .rules file; nothing in them
// refers to text.
#pragma once
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace bip::genom {

struct ServiceRef {
  std::size_t module = 0, service = 0;
  auto operator<=>(const ServiceRef&) const = default;
};
struct PosterRef {
  std::size_t module = 0, poster = 0;
  auto operator<=>(const PosterRef&) const = default;
};
struct TaskRef {
  std::size_t module = 0, task = 0;
  auto operator<=>(const TaskRef&) const = default;
};

/// A length of time: ticks, else microseconds.
struct Span {
  std::int64_t value = 0;
  bool is_ticks = false;
  bool operator==(const Span&) const = default;
};

enum class ConditionKind : std::uint8_t {
  Number,   // `number`
  Text,     // `text`
  Active,   // `service` was accepted and has not ended
  Done,     // it has ended with OK at least once
  Asked,    // parameter `row` of the request that is looked at
  Value,    // parameter `row` of the last one accepted
  Total,    // the sum of parameters `rows` over the services that are active
  Fresh,    // `poster` is not older than `span`
  Age,      // its PosterAge
  Below,    // stopwatch `row` shows less than its limit
  Recent,   // success `row`: its service has ended with OK, and that still counts
  Held,     // value `row` of a poster
  Ordered,  // pair `row`: the first service was accepted, and the second after it
  Silent,   // silence `row`: no request has come for so long
  Failed,   // failure `row` of a service
  Missed,   // task `row` of those that rules watch has missed its period
  Not,      // one operand
  Operator  // `text`, two operands
};
struct Condition {
  ConditionKind kind = ConditionKind::Number;
  std::int64_t number = 0;
  std::string text;  // of a text; a fraction's digits; an operator's sign
  ServiceRef service;
  PosterRef poster;
  Span span;
  std::size_t row = 0;
  std::vector<std::size_t> rows;
  std::vector<Condition> operands;
};

enum class ConstraintKind : std::uint8_t {
  Admit,      // `subject` is accepted only if the condition holds, else rejected
  Keep,       // and is stopped as soon as it does not
  Interrupt,  // a request for `subject` tells `other` to stop
  Wait,       // `subject`, accepted, begins only when `other` does not run
  When        // `recovery` is asked for each time the condition becomes true; no subject
};
struct Constraint {
  ConstraintKind kind = ConstraintKind::Admit;
  std::string name;
  std::string text;  // the rule, for a reader
  ServiceRef subject, other;
  Condition condition;
  std::string report;
  std::optional<ServiceRef> recovery;  // asked for when the rule rejects or stops, or its time has come
};

enum class ValueType : std::uint8_t { Int, Float, Text };
/// A parameter of a request, and which values verification tries; an executive's requests bring any.
struct ParameterRow {
  std::string name;
  ServiceRef service;
  ValueType type = ValueType::Int;
  std::vector<std::string> values;  // as BIP writes them
};
/// Counts ticks in which `service` is active, or in which it is not.
struct StopwatchRow {
  ServiceRef service;
  bool counts_active = true;
  Span limit;
};
/// Which of two services was accepted last.
struct PairRow {
  ServiceRef first, second;
};

/// Has `service` ended with OK since `since` was last accepted, and not longer ago than `within`?
struct SuccessRow {
  ServiceRef service;
  std::optional<ServiceRef> since;
  std::optional<Span> within;
};
/// For `limit` the decisional level has requested nothing of `module`, or of any module.
struct SilenceRow {
  std::optional<std::size_t> module;
  Span limit;
  bool operator==(const SilenceRow&) const = default;
};
/// How an activity or control service may have ended other than well or interrupted. `Failed`: with any other report;
/// `Lost`: a codel exceeded its budget and was given up. `Late`: that, or one that its task waits for took longer,
/// which is no end.
enum class FailureKind : std::uint8_t { Failed, Lost, Late };
/// Has the last end of `service` been such a one (has it been late), and was it not accepted since?
struct FailureRow {
  ServiceRef service;
  FailureKind kind = FailureKind::Failed;
  bool operator==(const FailureRow&) const = default;
};
/// What a poster holds: one of `values` (as BIP writes them) if codels answer freely, else what a C++ function says
/// when it is written.
struct ValueRow {
  PosterRef poster;
  std::string name;
  ValueType type = ValueType::Int;
  std::vector<std::string> values;
};

/// What is to be true of all states, which the prover is asked: `always`, or `never` the condition.
struct PromiseRow {
  std::string name;
  bool is_never = false;
  Condition condition;
};

struct Constraints {
  std::vector<Constraint> rows;
  std::vector<PromiseRow> promises;
  std::vector<ParameterRow> parameters;
  std::vector<StopwatchRow> stopwatches;
  std::vector<PairRow> pairs;
  std::vector<SuccessRow> successes;
  std::vector<ValueRow> values;
  std::vector<SilenceRow> silences;
  std::vector<FailureRow> failures;
  std::vector<TaskRef> watched_tasks;
  /// Is there anything that the level has to remember, or do?
  [[nodiscard]] bool has_parts() const {
    return !(rows.empty() && parameters.empty() && stopwatches.empty() && pairs.empty() && successes.empty() &&
             silences.empty() && failures.empty() && watched_tasks.empty());
  }
};

}  // namespace bip::genom
