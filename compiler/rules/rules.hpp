// A .rules file as parsed: names are unresolved, and every row has its source location.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/genom/constraints.hpp"
#include "compiler/genom/module.hpp"

namespace bip::rules {

using genom::Name;

/// `NDD.GoTo`, or `GoTo` if only one module has it.
struct Path {
  Name module, name;
  [[nodiscard]] SourceRange range() const {
    SourceRange r = name.range;
    if (module.is_set()) r.begin = module.range.begin;
    return r;
  }
  [[nodiscard]] std::string text() const { return module.is_set() ? module.text + "." + name.text : name.text; }
};

enum class ExprKind : std::uint8_t {
  Number,
  Text,
  Word,
  Of,
  Active,
  Done,
  Request,
  Total,
  Fresh,
  Age,
  Ordered,
  Silent,
  Failed,
  Lost,
  Late,
  Missed,
  Not,
  Operator
};
/// `Of` is a parameter of a service or a value of a poster, Word such a value or a text; Active and Done of a service,
/// Fresh and Age of a poster; Silent of a module or of all; Failed, Lost and Late of a service, Missed of a task.
struct Expr {
  ExprKind kind = ExprKind::Number;
  SourceRange range;
  std::int64_t number = 0;
  std::string text{};     // of a string or word; a fraction; an operator's sign
  Path path{}, second{};  // of Silent the name is that of a module, if there is one
  Name name{};            // of a parameter
  genom::Span span{};
  std::vector<Expr> operands{};
};

enum class Verb : std::uint8_t {
  Before,     // right only after left has succeeded (since, within)
  Apart,      // does not overlap
  During,     // left only while right is active
  Requires,   // condition when left is asked for
  Maintains,  // and as long as it runs
  AtMost,     // left takes at most `span`
  AtLeast,    // left begins at least `span` after right ended
  AtMostOf,   // so many of left are active at a time
  When        // `recovery` each time the condition becomes true
};
enum class Policy : std::uint8_t { Reject, Wait, Interrupt };

struct Rule {
  Verb verb = Verb::Before;
  Name name;  // as given; else made of the rule
  std::vector<Path> left, right;
  Policy policy[2] = {Policy::Reject,
                      Policy::Reject};  // for requests to the left while the right runs, and the other way
  Expr condition;
  genom::Span span;
  std::int64_t count = 0;             // of AtMostOf
  std::optional<Path> since;          // Before: the success has to be later than the last request for this
  std::optional<genom::Span> within;  // and not longer ago
  Name report;
  std::optional<Path> recovery;
  SourceRange range;
};

struct ParameterDecl {
  Name name;
  std::vector<Path> services;
  genom::ValueType type = genom::ValueType::Int;
  std::vector<std::string> values;
};

/// What a poster holds.
struct ValueDecl {
  Name name;
  Path poster;
  genom::ValueType type = genom::ValueType::Int;
  std::vector<std::string> values;
};

/// A name for several services; a word for them in rules, which expand_groups() replaces by them.
struct ServiceGroup {
  Name name;
  std::vector<Path> services;
};

/// What the rules are to achieve: a property of all states, enforced by nothing, for the prover.
struct Promise {
  Name name;
  bool is_never = false;
  Expr condition;
  SourceRange range;
};

struct RuleFile {
  Name package;
  std::vector<Name> extends;  // paths of .rules files, relative to the rules
  std::vector<Name> modules;  // paths of .gen files, relative to the rules
  Name side_file;
  std::vector<ServiceGroup> groups;
  std::vector<ParameterDecl> parameters;
  std::vector<ValueDecl> values;
  std::vector<Rule> rules;
  std::vector<Promise> promises;
};

}  // namespace bip::rules
