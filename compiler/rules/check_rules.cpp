// Each rule to constraints, a pair of services at a time. What no controller can do is told here: it can refuse a
// request, let an accepted activity wait, and tell one to stop; it cannot delay an end, and a control service is over
// at once.
#include "compiler/rules/check_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "compiler/genom/names.hpp"
#include "compiler/rules/scope.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::rules {
namespace {

using genom::Condition;
using genom::ConditionKind;
using genom::Constraint;
using genom::ConstraintKind;
using genom::ServiceRef;

Condition leaf(ConditionKind kind, ServiceRef s) {
  Condition c;
  c.kind = kind;
  c.service = s;
  return c;
}

Condition negated(Condition of) {
  Condition c;
  c.kind = ConditionKind::Not;
  c.operands.push_back(std::move(of));
  return c;
}

// Blanks and line ends of the source as one blank.
std::string one_line(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool is_blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!is_blank) {
      out += c;
    } else if (!out.empty() && out.back() != ' ') {
      out += ' ';
    }
  }
  while (out.ends_with(' ')) out.pop_back();
  return out;
}

class Checker {
 public:
  Checker(const SourceMap& sources, const RuleFile& file, const std::vector<genom::Module>& modules, Diagnostics& diags)
      : sources_(sources), file_(file), diags_(diags), names_(modules, out_.constraints, diags) {}

  std::optional<Checked> run() {
    for (const ParameterDecl& p : file_.parameters) {
      for (const std::string& v : p.values) {
        if (p.type == genom::ValueType::Text) plain(v, p.name.range);
      }
      names_.parameter(p);
    }
    for (const ValueDecl& v : file_.values) {
      for (const std::string& text : v.values) plain(text, v.name.range);
      names_.value(v);
    }
    for (row_ = 0; row_ < file_.rules.size(); ++row_) rule(file_.rules[row_]);
    for (const Promise& p : file_.promises) promise(p);
    BIP_ASSERT(out_.rule.size() == out_.constraints.rows.size() && std::is_sorted(out_.rule.begin(), out_.rule.end()),
               "{} constraints, rules of {}", out_.constraints.rows.size(), out_.rule.size());
    if (diags_.has_errors()) return std::nullopt;
    return std::move(out_);
  }

 private:
  // It stands between quotes in BIP, too.
  void plain(const std::string& text, SourceRange range) {
    const auto is_plain = [](char c) {
      return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
             std::string_view(" -_.:+/").find(c) != std::string_view::npos;
    };
    if (!std::all_of(text.begin(), text.end(), is_plain)) diags_.report(Diag::kB6108, range, text);
  }
  void plain(const Expr& e) {
    if (e.kind == ExprKind::Text || e.kind == ExprKind::Word) plain(e.text, e.range);
    for (const Expr& operand : e.operands) plain(operand);
  }

  std::vector<ServiceRef> services(const std::vector<Path>& paths) {
    std::vector<ServiceRef> all;
    for (const Path& p : paths) {
      if (const auto s = names_.service(p)) all.push_back(*s);
    }
    return all;
  }

  [[nodiscard]] bool is_control(ServiceRef s) const { return names_.at(s).kind == genom::ServiceKind::Control; }
  [[nodiscard]] std::string bare(ServiceRef s) const { return genom::bip_name(names_.at(s).name.text); }

  void add(const Rule& r, Constraint c, const std::string& made) {
    c.name = r.name.is_set() ? genom::bip_name(r.name.text) : made;
    c.text = one_line(sources_.text(r.range.file).substr(r.range.begin, r.range.end - r.range.begin));
    if (r.report.is_set()) {
      c.report = r.report.text;
    } else {
      for (const char sign : c.name) c.report += sign == '_' ? '-' : genom::upper(std::string(1, sign))[0];
    }
    c.recovery = recovery_;
    BIP_ASSERT(row_ < file_.rules.size(), "rule {} of {}", row_, file_.rules.size());
    out_.constraints.rows.push_back(std::move(c));
    out_.rule.push_back(row_);
  }
  void add(const Rule& r, ConstraintKind kind, ServiceRef subject, Condition condition, const std::string& made) {
    Constraint c;
    c.kind = kind;
    c.subject = subject;
    c.condition = std::move(condition);
    add(r, std::move(c), made);
  }

  // Of states, so about no request.
  void promise(const Promise& p) {
    plain(p.condition);
    if (!promise_names_.insert(p.name.text).second) diags_.report(Diag::kB6013, p.name.range, "promise", p.name.text);
    genom::PromiseRow row{.name = genom::bip_name(p.name.text), .is_never = p.is_never, .condition = {}};
    if (names_.condition(p.condition, std::nullopt, NameScope::Moment::Run, row.condition))
      out_.constraints.promises.push_back(std::move(row));
  }

  // Asks for a service when its condition has become true; about no request and no activity.
  void when(const Rule& r) {
    BIP_ASSERT(recovery_.has_value(), "the rule at byte {} asks for nothing", r.range.begin);
    Constraint c;
    c.kind = ConstraintKind::When;
    if (names_.condition(r.condition, std::nullopt, NameScope::Moment::Run, c.condition))
      add(r, std::move(c), fmt::format("{}_when", bare(*recovery_)));
  }

  void rule(const Rule& r) {
    const std::size_t errors = diags_.error_count();
    const std::vector<ServiceRef> left = services(r.left);
    const std::vector<ServiceRef> right = services(r.right);
    if (r.report.is_set()) plain(r.report.text, r.report.range);
    plain(r.condition);
    if (r.name.is_set() && !rule_names_.insert(r.name.text).second)
      diags_.report(Diag::kB6013, r.name.range, "rule", r.name.text);
    recovery_.reset();
    if (r.recovery) recovery_ = names_.service(*r.recovery);
    if (diags_.error_count() > errors) return;
    BIP_ASSERT(left.size() == r.left.size() && right.size() == r.right.size(), "{} of {} services are found",
               left.size(), r.left.size());
    if (r.verb == Verb::When) return when(r);
    if (r.verb == Verb::AtMostOf) return at_most_of(r, left);
    for (std::size_t i = 0; i < left.size(); ++i) {
      if (right.empty()) check_service(r, r.left[i], left[i]);
      for (std::size_t k = 0; k < right.size(); ++k) {
        if (left[i] == right[k] && r.verb != Verb::AtLeast) {
          diags_.report(Diag::kB6102, r.right[k].range(), names_.text(left[i])).label(r.left[i].range(), "here too");
        } else {
          pair(r, r.left[i], left[i], r.right[k], right[k]);
        }
      }
    }
  }

  // Each of them is accepted only if fewer than `count` of the others are active. Who stands in the list twice counts
  // once.
  void at_most_of(const Rule& r, const std::vector<ServiceRef>& listed) {
    std::vector<ServiceRef> all;
    for (const ServiceRef s : listed) {
      if (std::find(all.begin(), all.end(), s) == all.end()) all.push_back(s);
    }
    for (const ServiceRef s : all) {
      std::vector<ServiceRef> others;
      std::copy_if(all.begin(), all.end(), std::back_inserter(others), [&](ServiceRef o) { return o != s; });
      if (static_cast<std::size_t>(r.count) > others.size()) continue;
      std::size_t leaves = 0;
      const std::optional<Condition> too_many = some_active(others, 0, static_cast<std::size_t>(r.count), leaves);
      if (!too_many) {
        diags_.report(Diag::kB6107, r.range);
        return;
      }
      add(r, ConstraintKind::Admit, s, negated(*too_many), fmt::format("{}_at_most_{}", bare(s), r.count));
    }
  }

  static Condition joined(const char* sign, Condition a, Condition b) {
    Condition c;
    c.kind = ConditionKind::Operator;
    c.text = sign;
    c.operands = {std::move(a), std::move(b)};
    return c;
  }

  // So many of the services from `from` on are active: the first one and fewer of the others, or all of the others.
  // None if that takes too many leaves.
  static std::optional<Condition> some_active(const std::vector<ServiceRef>& services, std::size_t from,
                                              std::size_t count, std::size_t& leaves) {
    constexpr std::size_t kMostLeaves = 2000;
    BIP_ASSERT(count >= 1 && from + count <= services.size(), "{} of the services from {} of {} on", count, from,
               services.size());
    if (++leaves > kMostLeaves) return std::nullopt;
    Condition first = leaf(ConditionKind::Active, services[from]);
    if (count > 1) {
      std::optional<Condition> rest = some_active(services, from + 1, count - 1, leaves);
      if (!rest) return std::nullopt;
      first = joined("&&", std::move(first), std::move(*rest));
    }
    if (services.size() - from == count) return first;
    std::optional<Condition> without = some_active(services, from + 1, count, leaves);
    if (!without) return std::nullopt;
    return joined("||", std::move(first), std::move(*without));
  }

  // A rule about one service and a condition.
  void check_service(const Rule& r, const Path& path, ServiceRef s) {
    const std::string name = bare(s) + (r.verb == Verb::Requires    ? "_requires"
                                        : r.verb == Verb::Maintains ? "_maintains"
                                                                    : "_at_most");
    if (r.verb != Verb::Requires && !can_stop(path, s)) return;
    if (r.verb == Verb::AtMost) {
      if (measured(r, path, s)) add(r, ConstraintKind::Keep, s, stopwatch(s, true, r.span), name);
      return;
    }
    Condition admitted;
    Condition kept;
    if (!names_.condition(r.condition, s, NameScope::Moment::Request, admitted)) return;
    if (r.verb == Verb::Maintains && !names_.condition(r.condition, s, NameScope::Moment::Run, kept)) return;
    add(r, ConstraintKind::Admit, s, std::move(admitted), name);
    if (r.verb == Verb::Maintains) add(r, ConstraintKind::Keep, s, std::move(kept), name);
  }

  void pair(const Rule& r, const Path& left_path, ServiceRef left, const Path& right_path, ServiceRef right) {
    switch (r.verb) {
      case Verb::Before:
        if (r.since || r.within) {
          if (const auto condition = recent(r, left))
            add(r, ConstraintKind::Admit, right, *condition, fmt::format("{}_before_{}", bare(left), bare(right)));
        } else {
          add(r, ConstraintKind::Admit, right, leaf(ConditionKind::Done, left),
              fmt::format("{}_before_{}", bare(left), bare(right)));
        }
        break;
      case Verb::During:
        add(r, ConstraintKind::Admit, left, leaf(ConditionKind::Active, right),
            fmt::format("{}_during_{}", bare(left), bare(right)));
        if (!is_control(left))
          add(r, ConstraintKind::Keep, left, leaf(ConditionKind::Active, right),
              fmt::format("{}_during_{}", bare(left), bare(right)));
        break;
      case Verb::AtLeast:
        if (measured(r, right_path, right)) {
          // The stopwatch runs while the earlier one does not.
          Condition is_over = negated(stopwatch(right, false, r.span));
          add(r, ConstraintKind::Admit, left, std::move(is_over), fmt::format("{}_after_{}", bare(left), bare(right)));
        }
        break;
      case Verb::Apart:
        apart(r, left_path, left, right, r.policy[0]);
        apart(r, right_path, right, left, r.policy[1]);
        late(r, left, right, r.policy[0], r.policy[1]);
        late(r, right, left, r.policy[1], r.policy[0]);
        break;
      case Verb::Requires:
      case Verb::Maintains:
      case Verb::AtMost:
      case Verb::AtMostOf:
      case Verb::When: BIP_UNREACHABLE("a rule of one service");
    }
  }

  // The left one has ended with OK since, or not longer ago.
  std::optional<Condition> recent(const Rule& r, ServiceRef left) {
    genom::SuccessRow row{left, {}, r.within};
    if (r.since) {
      row.since = names_.service(*r.since);
      if (!row.since) return std::nullopt;
    }
    Condition c;
    c.kind = ConditionKind::Recent;
    c.row = out_.constraints.successes.size();
    out_.constraints.successes.push_back(row);
    return c;
  }

  // What a request for `asked` does while `running` runs.
  void apart(const Rule& r, const Path& path, ServiceRef asked, ServiceRef running, Policy policy) {
    const std::string name = fmt::format("{}_without_{}", bare(asked), bare(running));
    if (policy == Policy::Reject) {
      add(r, ConstraintKind::Admit, asked, negated(leaf(ConditionKind::Active, running)), name);
      return;
    }
    if (is_control(asked)) {
      diags_.report(Diag::kB6103, path.range(), names_.text(asked)).help("say `reject` for its requests");
      return;
    }
    if (is_control(running)) return;  // over before anybody else is asked for
    Constraint c;
    c.subject = asked;
    c.other = running;
    if (policy == Policy::Interrupt) {
      c.kind = ConstraintKind::Interrupt;
      add(r, c, name);
    }
    c.kind = ConstraintKind::Wait;
    add(r, std::move(c), name);
  }

  // Whose requests are rejected while the other runs may have been accepted before, and still wait for something else
  // when the other, which waits only for what runs, begins.
  void late(const Rule& r, ServiceRef accepted, ServiceRef other, Policy policy, Policy of_other) {
    BIP_ASSERT(accepted != other, "service {} of module {} overlaps itself", accepted.service, accepted.module);
    if (policy != Policy::Reject || of_other != Policy::Wait || is_control(accepted) || is_control(other)) return;
    Constraint c;
    c.kind = ConstraintKind::Wait;
    c.subject = accepted;
    c.other = other;
    add(r, std::move(c), fmt::format("{}_without_{}", bare(accepted), bare(other)));
  }

  bool can_stop(const Path& path, ServiceRef s) {
    if (!is_control(s)) return true;
    diags_.report(Diag::kB6103, path.range(), names_.text(s))
        .help("say `requires`: it is looked at when it is asked for");
    return false;
  }

  // Stopwatches look at a service, not at each of its activities: of several the last one, if it ends the others.
  bool measured(const Rule& r, const Path& path, ServiceRef s) {
    const std::vector<std::size_t>& interrupted = names_.at(s).interrupted;
    const bool follows_itself = std::find(interrupted.begin(), interrupted.end(), s.service) != interrupted.end();
    if (r.verb != Verb::AtMost || names_.at(s).instances == 1 || follows_itself) return true;
    diags_.report(Diag::kB6109, path.range(), names_.text(s), names_.at(s).instances);
    return false;
  }

  Condition stopwatch(ServiceRef s, bool counts_active, genom::Span limit) {
    Condition c;
    c.kind = ConditionKind::Below;
    c.row = out_.constraints.stopwatches.size();
    out_.constraints.stopwatches.push_back({s, counts_active, limit});
    return c;
  }

  const SourceMap& sources_;
  const RuleFile& file_;
  Diagnostics& diags_;
  Checked out_;
  NameScope names_;
  std::size_t row_ = 0;
  std::optional<ServiceRef> recovery_;
  std::set<std::string> rule_names_, promise_names_;
};

}  // namespace

std::optional<Checked> check_rules(const SourceMap& sources, const RuleFile& file,
                                   const std::vector<genom::Module>& modules, Diagnostics& diags) {
  return Checker(sources, file, modules, diags).run();
}

}  // namespace bip::rules
