// See level_condition.hpp. Every operator is parenthesised, so that readers need not know two precedences.
#include "compiler/genom/level_condition.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/genom/names.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {

void add_port(std::vector<std::string>& ports, const std::string& port) {
  if (std::find(ports.begin(), ports.end(), port) == ports.end()) ports.push_back(port);
}

std::vector<std::string> ConditionWriter::stats(ServiceRef s) const {
  const Plan& p = plans_[s.module];
  std::vector<std::string> all;
  for (const std::size_t activity : p.services[s.service].activities)
    all.push_back(fmt::format("{}.stat_{}", p.component, p.activities[activity].component));
  return all;
}

std::int64_t ConditionWriter::ticks(Span span) const {
  BIP_ASSERT(tick_us_ > 0 && span.value >= 0, "{} in ticks of {} us", span.value, tick_us_);
  return std::max<std::int64_t>(1, span.is_ticks ? span.value : (span.value + tick_us_ - 1) / tick_us_);
}

std::int64_t steps_of_age(Span span, const GenerateOptions& options, std::int64_t tick_us) {
  BIP_ASSERT(tick_us > 0 && options.poster_period > 0, "ticks of {} us, posters grow older in every {}", tick_us,
             options.poster_period);
  return (span.is_ticks ? span.value : span.value / tick_us) / options.poster_period;
}

std::string ten_thousandths(const std::string& fraction) {
  const bool is_negative = fraction.starts_with('-');
  const std::string_view size = std::string_view(fraction).substr(is_negative ? 1 : 0);
  const std::size_t dot = std::min(size.find('.'), size.size());
  BIP_ASSERT(dot <= 14 && size.find_first_not_of("0123456789.") == std::string_view::npos,
             "`{}` does not fit 64 bits in ten-thousandths", fraction);
  std::int64_t value = 0;
  for (std::size_t i = 0, digits = 0; digits < dot + 4; ++i) {
    if (i == dot) continue;
    value = value * 10 + (i < size.size() ? size[i] - '0' : 0);
    ++digits;
  }
  return std::to_string(is_negative ? -value : value);
}

std::string ConditionWriter::any_of(ServiceRef s, const char* what, const char* sign,
                                    std::vector<std::string>* ports) const {
  const Plan& p = plans_[s.module];
  std::vector<std::string> all;
  if (ports != nullptr) all = stats(s);
  const bool is_control = p.module->services[s.service].kind == ServiceKind::Control;
  for (const std::size_t activity : p.services[s.service].activities) {
    if (ports == nullptr)
      all.push_back(
          fmt::format("{}.{}{}", p.component, p.activities[activity].component, is_control ? "" : ".controller"));
  }
  std::string out;
  for (const std::string& stat : all) {
    if (ports != nullptr) add_port(*ports, stat);
    out += (out.empty() ? "" : std::string(" ") + sign + " ") + stat + "." + what;
  }
  return all.size() == 1 ? out : "(" + out + ")";
}

std::string ConditionWriter::read(const std::string& part, const char* what, std::vector<std::string>* ports) const {
  if (ports == nullptr) return fmt::format("{}.{}", part, what);
  add_port(*ports, part + ".read");
  return fmt::format("{}.read.{}", part, what);
}

std::string ConditionWriter::text(const Condition& c, std::vector<std::string>& ports) const {
  return write(c, &ports);
}
std::string ConditionWriter::property(const Condition& c) const { return write(c, nullptr); }

std::string ConditionWriter::write(const Condition& c, std::vector<std::string>* ports) const {
  const auto of_poster = [&](PosterRef poster, const std::string& what) {
    const Plan& p = plans_[poster.module];
    if (ports == nullptr) return fmt::format("{}.{}.{}", p.component, p.posters[poster.poster], what);
    const std::string port = fmt::format("{}.read_{}", p.component, p.posters[poster.poster]);
    add_port(*ports, port);
    return port + "." + what;
  };
  const auto poster_age = [&] { return of_poster(c.poster, "PosterAge"); };
  switch (c.kind) {
    case ConditionKind::Number:
      return c.text.empty()                           ? std::to_string(c.number)
             : options_.flavour == Flavour::Execution ? c.text
                                                      : ten_thousandths(c.text);
    case ConditionKind::Text: return "\"" + c.text + "\"";
    case ConditionKind::Active: return any_of(c.service, "active", "||", ports);
    case ConditionKind::Done: return any_of(c.service, "done", "||", ports);
    case ConditionKind::Asked: return read(parts_.parameters[c.row], "asked", ports);
    case ConditionKind::Value: return read(parts_.parameters[c.row], "value", ports);
    case ConditionKind::Total: {
      std::string sum;
      for (const std::size_t row : c.rows) {
        BIP_ASSERT(row < parts_.parameters.size(), "parameter {} of {}", row, parts_.parameters.size());
        const std::string value = read(parts_.parameters[row], "value", ports);
        sum += fmt::format("{}{} * {}", sum.empty() ? "" : " + ",
                           any_of(options_.constraints.parameters[row].service, "running", "+", ports), value);
      }
      return "(" + sum + ")";
    }
    case ConditionKind::Fresh: return fmt::format("{} <= {}", poster_age(), steps_of_age(c.span, options_, tick_us_));
    case ConditionKind::Age: return poster_age();
    case ConditionKind::Below:
      BIP_ASSERT(c.row < parts_.stopwatches.size(), "stopwatch {} of {}", c.row, parts_.stopwatches.size());
      return fmt::format("{} < {}", read(parts_.stopwatches[c.row], "t", ports),
                         ticks(options_.constraints.stopwatches[c.row].limit));
    case ConditionKind::Recent: return read(parts_.successes[c.row], "counts", ports);
    case ConditionKind::Held:
      BIP_ASSERT(c.row < options_.constraints.values.size(), "value {} of {}", c.row,
                 options_.constraints.values.size());
      return of_poster(options_.constraints.values[c.row].poster, bip_name(options_.constraints.values[c.row].name));
    case ConditionKind::Ordered: return read(parts_.pairs[c.row], "ordered", ports);
    case ConditionKind::Silent: return read(parts_.silences[c.row], "silent", ports);
    case ConditionKind::Failed: return read(parts_.failures[c.row], "failed", ports);
    case ConditionKind::Missed: {
      BIP_ASSERT(c.row < options_.constraints.watched_tasks.size(), "watched task {} of {}", c.row,
                 options_.constraints.watched_tasks.size());
      const TaskRef task = options_.constraints.watched_tasks[c.row];
      const Plan& p = plans_[task.module];
      if (ports == nullptr) return fmt::format("{}.{}.timer.missed", p.component, p.tasks[task.task].component);
      const std::string port = fmt::format("{}.missed_{}", p.component, p.tasks[task.task].component);
      add_port(*ports, port);
      return port + ".missed";
    }
    case ConditionKind::Not: {
      BIP_ASSERT(c.operands.size() == 1, "`not` has {} operands", c.operands.size());
      const Condition& of = c.operands[0];
      const bool is_bare = of.kind == ConditionKind::Ordered || of.kind == ConditionKind::Recent ||
                           of.kind == ConditionKind::Active || of.kind == ConditionKind::Done ||
                           of.kind == ConditionKind::Silent || of.kind == ConditionKind::Failed ||
                           of.kind == ConditionKind::Missed || of.kind == ConditionKind::Not;
      return is_bare ? "!" + write(of, ports) : "!(" + write(of, ports) + ")";
    }
    case ConditionKind::Operator: break;
  }
  BIP_ASSERT(c.operands.size() == 2, "`{}` has {} operands", c.text, c.operands.size());
  std::string sides[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const Condition& of = c.operands[i];
    const bool is_negative = of.kind == ConditionKind::Number && (of.number < 0 || of.text.starts_with('-'));
    const bool is_bare = of.kind != ConditionKind::Operator && of.kind != ConditionKind::Fresh &&
                         of.kind != ConditionKind::Below && !(is_negative && i == 1);
    sides[i] = is_bare ? write(of, ports) : "(" + write(of, ports) + ")";
  }
  return fmt::format("{} {} {}", sides[0], c.text, sides[1]);
}

}  // namespace bip::genom
