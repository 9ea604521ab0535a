// See left_out.hpp.
#include "compiler/rules/left_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "runtime/include/bip/assert.hpp"

namespace bip::rules {
namespace {

using genom::Module;
using genom::Service;
using genom::ServiceKind;
using genom::ServiceRef;

// The services that a condition speaks of.
void collect(const genom::Condition& c, const genom::Constraints& constraints, std::set<ServiceRef>& into) {
  switch (c.kind) {
    case genom::ConditionKind::Active:
    case genom::ConditionKind::Done: into.insert(c.service); break;
    case genom::ConditionKind::Asked:
    case genom::ConditionKind::Value: into.insert(constraints.parameters[c.row].service); break;
    case genom::ConditionKind::Total:
      for (const std::size_t row : c.rows) into.insert(constraints.parameters[row].service);
      break;
    case genom::ConditionKind::Below: into.insert(constraints.stopwatches[c.row].service); break;
    case genom::ConditionKind::Recent: into.insert(constraints.successes[c.row].service); break;
    case genom::ConditionKind::Failed: into.insert(constraints.failures[c.row].service); break;
    case genom::ConditionKind::Ordered:
      into.insert(constraints.pairs[c.row].first);
      into.insert(constraints.pairs[c.row].second);
      break;
    case genom::ConditionKind::Number:
    case genom::ConditionKind::Text:
    case genom::ConditionKind::Fresh:
    case genom::ConditionKind::Age:
    case genom::ConditionKind::Held:
    case genom::ConditionKind::Silent:
    case genom::ConditionKind::Missed:
    case genom::ConditionKind::Not:
    case genom::ConditionKind::Operator: break;
  }
  for (const genom::Condition& operand : c.operands) collect(operand, constraints, into);
}

bool writes_in_codel(const Service& s, const std::string& port) {
  return std::any_of(s.activity.states.begin(), s.activity.states.end(), [&](const genom::State& state) {
    return std::any_of(state.codel.uses.begin(), state.codel.uses.end(),
                       [&](const genom::DataUse& use) { return use.writes && use.data == port; });
  });
}

// GenoM 2 does not say which services of a task write its posters, so all of them do.
bool writes(const Module& m, const Service& s, const genom::Poster& p) {
  return m.generation == 2 ? s.task_index == p.task_index : writes_in_codel(s, p.name.text);
}

bool interrupts(const Service& s, std::size_t other) {
  return std::find(s.interrupted.begin(), s.interrupted.end(), other) != s.interrupted.end();
}

// Why a rule about `named` is likely to be meant for `other`, too; empty: it is not.
std::string reason(const Module& m, std::size_t named, std::size_t other) {
  BIP_ASSERT(named != other && named < m.services.size() && other < m.services.size(), "services {} and {} of {}",
             named, other, m.services.size());
  const Service& a = m.services[named];
  const Service& b = m.services[other];
  const std::string name = m.name.text + "." + a.name.text;
  if (interrupts(a, other)) return fmt::format("which {} interrupts", name);
  if (interrupts(b, named)) return fmt::format("which interrupts {}", name);
  for (const genom::Poster& p : m.posters) {
    if (writes(m, a, p) && writes(m, b, p))
      return fmt::format("which writes {}.{}, as {} does", m.name.text, p.name.text, name);
  }
  return {};
}

}  // namespace

std::vector<std::string> find_left_out(const std::vector<Module>& modules, const Checked& checked) {
  struct Named {
    std::string rule;
    std::set<ServiceRef> services;
  };
  std::map<std::size_t, Named> rules;
  for (std::size_t k = 0; k < checked.constraints.rows.size(); ++k) {
    const genom::Constraint& row = checked.constraints.rows[k];
    BIP_ASSERT(k < checked.rule.size(), "constraint {} is of no rule", k);
    Named& named = rules[checked.rule[k]];
    if (named.rule.empty()) named.rule = row.name;
    // What `when` asks for is a remedy, for which another one is no substitute.
    if (row.kind != genom::ConstraintKind::When) named.services.insert(row.subject);
    if (row.kind == genom::ConstraintKind::Interrupt || row.kind == genom::ConstraintKind::Wait)
      named.services.insert(row.other);
    collect(row.condition, checked.constraints, named.services);
  }
  const auto counts = [&](ServiceRef s) {
    BIP_ASSERT(s.module < modules.size(), "module {} of {}", s.module, modules.size());
    const Service& service = modules[s.module].services[s.service];
    return service.kind == ServiceKind::Execution && !service.is_init;
  };
  std::vector<std::string> lines;
  for (const auto& [number, named] : rules) {
    std::set<ServiceRef> told;
    for (const ServiceRef s : named.services) {
      if (!counts(s)) continue;
      const Module& m = modules[s.module];
      for (std::size_t other = 0; other < m.services.size(); ++other) {
        const ServiceRef o{s.module, other};
        if (!counts(o) || named.services.contains(o) || told.contains(o)) continue;
        const std::string why = reason(m, s.service, other);
        if (why.empty()) continue;
        told.insert(o);
        lines.push_back(
            fmt::format("{}: nothing is said of {}.{}, {}", named.rule, m.name.text, m.services[other].name.text, why));
      }
    }
  }
  return lines;
}

}  // namespace bip::rules
