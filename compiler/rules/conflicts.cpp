// See conflicts.hpp.
#include "compiler/rules/conflicts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "runtime/include/bip/assert.hpp"

namespace bip::rules {
namespace {

using genom::Condition;
using genom::ConditionKind;
using genom::Constraint;
using genom::ConstraintKind;
using genom::Module;

bool is_same(const Condition& a, const Condition& b) {
  return a.kind == b.kind && a.number == b.number && a.text == b.text && a.service == b.service &&
         a.poster == b.poster && a.span.value == b.span.value && a.span.is_ticks == b.span.is_ticks && a.row == b.row &&
         a.rows == b.rows &&
         std::equal(a.operands.begin(), a.operands.end(), b.operands.begin(), b.operands.end(), is_same);
}

enum class Truth : std::uint8_t { False, True, Unknown };
Truth truth_of(bool value) { return value ? Truth::True : Truth::False; }

// What is known when a rule is violated, or when the condition of `when` has become true.
class ViolationFacts {
 public:
  explicit ViolationFacts(const Constraint& violated) {
    assume(violated.condition, violated.kind == ConstraintKind::When);
    if (violated.kind != ConstraintKind::Keep) return;
    is_active(violated.subject);
  }
  // What is known when a service is accepted.
  explicit ViolationFacts(genom::ServiceRef accepted) { is_active(accepted); }
  ViolationFacts(const ViolationFacts&) = delete;  // facts_ points into it
  ViolationFacts& operator=(const ViolationFacts&) = delete;

  [[nodiscard]] Truth judge(const Condition& c) const {
    for (const auto& [fact, value] : facts_) {
      if (is_same(*fact, c)) return truth_of(value);
    }
    if (c.kind == ConditionKind::Not) {
      const Truth of = judge(c.operands[0]);
      return of == Truth::Unknown ? of : truth_of(of == Truth::False);
    }
    if (c.kind != ConditionKind::Operator || (c.text != "&&" && c.text != "||")) return Truth::Unknown;
    BIP_ASSERT(c.operands.size() == 2, "`{}` of {} operands", c.text, c.operands.size());
    // One operand may decide.
    const Truth strong = truth_of(c.text == "||");
    const Truth left = judge(c.operands[0]);
    const Truth right = judge(c.operands[1]);
    if (left == strong || right == strong) return strong;
    return left == Truth::Unknown || right == Truth::Unknown ? Truth::Unknown : left;
  }

 private:
  void is_active(genom::ServiceRef s) {
    active_.kind = ConditionKind::Active;
    active_.service = s;
    facts_.emplace_back(&active_, true);
  }

  void assume(const Condition& c, bool value) {
    BIP_ASSERT(c.operands.size() == (c.kind == ConditionKind::Operator ? 2u
                                     : c.kind == ConditionKind::Not    ? 1u
                                                                       : 0u),
               "a condition of kind {} has {} operands", c.kind, c.operands.size());
    facts_.emplace_back(&c, value);
    if (c.kind == ConditionKind::Not) assume(c.operands[0], !value);
    if (c.kind != ConditionKind::Operator || c.text != (value ? "&&" : "||")) return;
    for (const Condition& operand : c.operands) assume(operand, value);
  }

  Condition active_;
  std::vector<std::pair<const Condition*, bool>> facts_;
};

std::string text_of(std::int64_t us) {
  if (us % 1'000'000 == 0) return fmt::format("{} s", us / 1'000'000);
  return us % 1000 == 0 ? fmt::format("{} ms", us / 1000) : fmt::format("{} us", us);
}

// The period of the task that writes the poster, of several the shortest; 0: there is none, or one without a period.
std::int64_t writer_period(const Module& m, const genom::Poster& p) {
  BIP_ASSERT(m.generation != 2 || p.task_index < m.tasks.size(), "poster `{}` is of task {} of {}", p.name.text,
             p.task_index, m.tasks.size());
  if (m.generation == 2) return m.tasks[p.task_index].period_us;
  const std::string port = "port_" + p.name.text;
  const auto writes = [&](const genom::Activity& a) {
    return std::any_of(a.states.begin(), a.states.end(), [&](const genom::State& s) {
      return std::any_of(s.codel.uses.begin(), s.codel.uses.end(),
                         [&](const genom::DataUse& use) { return use.writes && use.data == port; });
    });
  };
  std::set<std::int64_t> periods;
  for (const genom::Task& t : m.tasks) {
    if (writes(t.activity)) periods.insert(t.period_us);
  }
  for (const genom::Service& s : m.services) {
    if (writes(s.activity)) periods.insert(m.tasks[s.task_index].period_us);
  }
  return periods.empty() ? 0 : *periods.begin();
}

class ConflictFinder {
 public:
  ConflictFinder(const RuleFile& file, const std::vector<Module>& modules, const Checked& checked, std::int64_t tick_us,
                 Diagnostics& diags)
      : file_(file),
        modules_(modules),
        rows_(checked.constraints.rows),
        rule_(checked.rule),
        tick_us_(tick_us),
        diags_(diags) {
    BIP_ASSERT(rows_.size() == rule_.size(), "{} constraints of {} rules", rows_.size(), rule_.size());
    BIP_ASSERT(rule_.empty() || rule_.back() < file_.rules.size(), "rule {} of {}", rule_.back(), file_.rules.size());
    BIP_ASSERT(tick_us_ > 0, "ticks of {} us", tick_us_);
  }

  void run() {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      fresh(i, rows_[i].condition);
      if (rows_[i].recovery) refused(i);
    }
    for (std::size_t i = 0; i < rows_.size(); ++i) endless(i);
    for (std::size_t i = 0; i < rows_.size(); ++i) circle(i);
  }

 private:
  [[nodiscard]] SourceRange range(std::size_t row) const { return file_.rules[rule_[row]].range; }
  [[nodiscard]] std::string text(genom::ServiceRef s) const {
    return modules_[s.module].name.text + "." + modules_[s.module].services[s.service].name.text;
  }
  [[nodiscard]] static bool rejects(const Constraint& c) { return c.kind == ConstraintKind::Admit; }
  [[nodiscard]] static bool asks(const Constraint& c) {
    return rejects(c) || c.kind == ConstraintKind::Keep || c.kind == ConstraintKind::When;
  }

  // Where the rule says it: the same poster with the same bound.
  static const Expr* find_fresh(const Expr& e, const std::string& poster, genom::Span span) {
    if (e.kind == ExprKind::Fresh && e.path.name.text == poster && e.span.value == span.value &&
        e.span.is_ticks == span.is_ticks)
      return &e;
    for (const Expr& operand : e.operands) {
      if (const Expr* const found = find_fresh(operand, poster, span)) return found;
    }
    return nullptr;
  }

  void fresh(std::size_t row, const Condition& c) {
    for (const Condition& operand : c.operands) fresh(row, operand);
    if (c.kind != ConditionKind::Fresh) return;
    const Module& m = modules_[c.poster.module];
    const genom::Poster& p = m.posters[c.poster.poster];
    const std::int64_t bound = c.span.is_ticks ? c.span.value * tick_us_ : c.span.value;
    const std::int64_t period = writer_period(m, p);
    const Expr* const written = find_fresh(file_.rules[rule_[row]].condition, p.name.text, c.span);
    const SourceRange where = written != nullptr ? written->range : range(row);
    if (bound >= period || !stale_.insert(where.begin).second) return;
    auto d = diags_.report(Diag::kB6111, where, m.name.text + "." + p.name.text, text_of(period), text_of(bound));
    d.help(fmt::format("a bound of {} allows for one late cycle", text_of(2 * period)));
  }

  // Rules that refuse the recovery of this one, and have none of their own to go on with.
  void refused(std::size_t row) {
    const Constraint& violated = rows_[row];
    if (!asks(violated)) return;
    const ViolationFacts facts(violated);
    std::set<std::size_t> surely;
    std::set<std::size_t> perhaps;
    for (std::size_t other = 0; other < rows_.size(); ++other) {
      const Constraint& c = rows_[other];
      if (!rejects(c) || c.subject != *violated.recovery || c.recovery) continue;
      const Truth truth = facts.judge(c.condition);
      if (truth == Truth::False) surely.insert(rule_[other]);
      if (truth == Truth::Unknown) perhaps.insert(rule_[other]);
    }
    if (!surely.empty()) refusal(Diag::kB6112, row, surely, "by this rule");
    else if (!perhaps.empty()) refusal(Diag::kB6113, row, perhaps, "this rule does not allow it always");
  }
  void refusal(Diag code, std::size_t row, const std::set<std::size_t>& rules, const char* label) {
    BIP_ASSERT(!rules.empty() && *rules.rbegin() < file_.rules.size() && rows_[row].recovery.has_value(),
               "the recovery of row {} is refused by {} rules", row, rules.size());
    auto d = diags_.report(code, range(row), text(*rows_[row].recovery));
    for (const std::size_t rule : rules) d.label(file_.rules[rule].range, label);
  }

  // Refused, a service is asked for as the recovery of its own refusal. Each rule has one recovery, so there is one
  // way.
  void endless(std::size_t first) {
    std::vector<std::size_t> way;
    std::size_t row = first;
    while (rejects(rows_[row]) && rows_[row].recovery) {
      if (!way.empty() && row == first) break;
      way.push_back(row);
      const auto next = std::find_if(rows_.begin(), rows_.end(), [&](const Constraint& c) {
        return rejects(c) && c.recovery && c.subject == *rows_[row].recovery;
      });
      if (next == rows_.end() || way.size() > rows_.size()) return;
      row = static_cast<std::size_t>(next - rows_.begin());
    }
    if (way.empty() || row != first) return;
    std::set<std::size_t> rules;
    for (const std::size_t r : way) rules.insert(rule_[r]);
    if (!circles_.insert(rules).second) return;
    auto d = diags_.report(Diag::kB6114, range(first), text(rows_[first].subject));
    d.label(way.size() == 1 ? "by this rule alone" : "this rule refuses it");
    for (std::size_t k = 1; k < way.size(); ++k)
      d.label(range(way[k]), fmt::format("this one refuses its recovery `{}`", text(rows_[way[k]].subject)));
  }

  // By `when` rules alone: does the recovery of one, accepted, make the condition of the next one true, and so on back
  // to the first one? Breadth first, so the circle is a shortest one.
  void circle(std::size_t first) {
    if (rows_[first].kind != ConstraintKind::When) return;
    std::vector<std::size_t> seen{first};
    std::vector<std::size_t> from{0};
    for (std::size_t i = 0; i < seen.size(); ++i) {
      BIP_ASSERT(rows_[seen[i]].recovery.has_value(), "`when` in row {} asks for nothing", seen[i]);
      const genom::ServiceRef recovery = *rows_[seen[i]].recovery;
      // A control service is over at once.
      if (modules_[recovery.module].services[recovery.service].kind == genom::ServiceKind::Control) continue;
      const ViolationFacts facts(recovery);
      for (std::size_t next = 0; next < rows_.size(); ++next) {
        if (rows_[next].kind != ConstraintKind::When || facts.judge(rows_[next].condition) != Truth::True) continue;
        if (next == first) return circle(first, seen, from, i);
        if (std::find(seen.begin(), seen.end(), next) != seen.end()) continue;
        seen.push_back(next);
        from.push_back(i);
      }
    }
  }
  void circle(std::size_t first, const std::vector<std::size_t>& seen, const std::vector<std::size_t>& from,
              std::size_t last) {
    BIP_ASSERT(seen.size() == from.size() && last < seen.size(), "{} rows seen from {}", seen.size(), from.size());
    std::vector<std::size_t> way;
    for (std::size_t i = last; i != 0; i = from[i]) way.insert(way.begin(), seen[i]);
    std::set<std::size_t> rules{rule_[first]};
    for (const std::size_t row : way) rules.insert(rule_[row]);
    if (!circles_.insert(rules).second) return;
    auto d = diags_.report(Diag::kB6116, range(first), text(*rows_[first].recovery));
    d.label(way.empty() ? "by this rule alone" : "this rule asks for it");
    for (const std::size_t row : way)
      d.label(range(row), fmt::format("this one then asks for `{}`", text(*rows_[row].recovery)));
  }

  const RuleFile& file_;
  const std::vector<Module>& modules_;
  const std::vector<Constraint>& rows_;
  const std::vector<std::size_t>& rule_;
  std::int64_t tick_us_;
  Diagnostics& diags_;
  std::set<std::uint32_t> stale_;
  std::set<std::set<std::size_t>> circles_;
};

}  // namespace

void report_conflicts(const RuleFile& file, const std::vector<Module>& modules, const Checked& checked,
                      std::int64_t tick_us, Diagnostics& diags) {
  ConflictFinder(file, modules, checked, tick_us, diags).run();
}

}  // namespace bip::rules
