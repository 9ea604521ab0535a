// See exchange.hpp. Writes one process that takes one step at a time, with one alternative per interaction, each a
// `d_step`, so that SPIN's states are the stable ones. If no alternative is executable the process waits forever, which
// is SPIN's invalid end state; after a run-time error it ends. Cost: the number of interactions times the size of each.
#include "compiler/exchange/promela.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "compiler/analysis/graph_algorithms.hpp"
#include "compiler/system/uses_time.hpp"

namespace bip::exchange {

bool PromelaWriter::matches(const Priority& rule, bool high, const Step& step) const {
  const Pattern& pattern = high ? rule.high : rule.low;
  const Pattern& other = high ? rule.low : rule.high;
  if (pattern.any_connector)
    return system_.connectors[step.connector].parent == rule.parent &&
           (other.any_connector || !matches(rule, !high, step));
  if (pattern.connector != step.connector) return false;
  const std::vector<u32>& outer = high ? step.params : pattern.params;
  const std::vector<u32>& inner = high ? pattern.params : step.params;
  return pattern.any_interaction || std::includes(outer.begin(), outer.end(), inner.begin(), inner.end());
}

bool PromelaWriter::has_cycle(const std::vector<std::set<std::size_t>>& next) const {
  std::vector<u32> missing(next.size(), 0), order;
  for (const std::set<std::size_t>& successors : next) {
    for (std::size_t to : successors) ++missing[to];
  }
  return !topological_order(missing, order, [&](u32 from, const auto& see) {
    for (std::size_t to : next[from]) see(static_cast<u32>(to));
  });
}

// `hides0`: what rule 0 matches is hidden, by an interaction that its high side matches or through a chain of rules.
void PromelaWriter::add_priorities() {
  const std::size_t count = system_.priorities.size();
  std::vector<std::set<std::size_t>> next(count);
  for (std::size_t r = 0; r < count; ++r) {
    const Priority& rule = system_.priorities[PriorityId(r)];
    Names names;
    names.self = [](u32) { return std::string(); };
    names.bind = [&](u32 k) { return variable_name(rule.data[k].atom, rule.data[k].variable); };
    std::string above = "false";
    for (const Step& step : steps_) {
      if (!matches(rule, true, step)) continue;
      above += " || is" + step.name;
      for (std::size_t s = 0; s < count; ++s) {
        if (matches(system_.priorities[PriorityId(s)], false, step)) next[r].insert(s);
      }
    }
    for (std::size_t s : next[r]) above += fmt::format(" || hides{}", s);
    macros_ += fmt::format("#define hides{} ({} && ({})) /* {} */\n", r, code_.text(rule.guard, names), above,
                           plain(rule.name));
  }
  if (has_cycle(next)) code_.refuse("priorities that only guards keep from being a cycle");
}

Result<std::string> PromelaWriter::run() {
  if (const std::string timed = system::first_timed(system_); !timed.empty()) code_.refuse("time: " + timed);
  std::string initial, alternatives;
  for (u32 row = 0; row < system_.atoms.size(); ++row) {
    const AtomId atom(row);
    declare(atom);
    add_ports(atom);
    add_settle(atom);
    add_initial(atom, initial);
    declarations_ += fmt::format("hidden int t{};\n", row);
    if (!refusal_.empty()) return Failure{refusal_};
  }
  for (u32 row = 0; row < system_.connectors.size(); ++row) {
    if (system_.is_top(ConnectorId(row))) add_connector(ConnectorId(row));
    if (!refusal_.empty()) return Failure{refusal_};
  }
  add_priorities();
  for (const Step& step : steps_) {
    std::string guard = "!fault && is" + step.name;
    for (std::size_t r = 0; r < system_.priorities.size(); ++r) {
      if (matches(system_.priorities[PriorityId(r)], false, step)) guard += fmt::format(" && !hides{}", r);
    }
    alternatives +=
        fmt::format("  :: d_step {{ {} ->\n     printf(\"{}\\n\");\n{}     }}\n", guard, told(step), effect(step));
  }
  for (u32 row = 0; row < system_.atoms.size(); ++row) {
    const AtomId atom(row);
    for (u32 port = 0; port < type_of(atom).ports.size(); ++port) {
      if (type_of(atom).ports[port].exported) continue;
      const std::string name = plain(system_.atoms[atom].path) + '.' + plain(type_of(atom).ports[port].name);
      alternatives += fmt::format("  :: d_step {{ !fault && {} ->\n     printf(\"{}\\n\");\n{}{}     }}\n",
                                  port_name(atom, port), name, record(atom, port), fire(atom, port));
    }
  }
  if (!refusal_.empty()) return Failure{refusal_};
  return fmt::format(
      "/* {} by bipc export. Deadlocks are invalid end states:\n"
      "   spin -a m.pml && cc -O2 -fwrapv -DSAFETY -o pan pan.c && ./pan -m1000000, then spin -t m.pml */\n"
      "{}bool fault = false; /* a run-time error: the end, no deadlock */\n\n{}\n{}\n"
      "init {{\n  d_step {{\n{}    skip;\n  }}\n  do\n  :: fault -> break\n{}  od\n}}\n",
      plain(options_.root_name), declarations_, macros_, inlines_, initial, alternatives);
}

Result<std::string> promela(const System& system, const Options& options) {
  return PromelaWriter(system, options).run();
}

}  // namespace bip::exchange
