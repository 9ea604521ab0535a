// See describe_modules.hpp. What a rule looks at is seen from the conditions that it was translated to.
#include "compiler/driver/describe_modules.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/driver/genom_files.hpp"
#include "compiler/driver/rule_files.hpp"

namespace bip::driver {

namespace {

using graph::ModuleMember;

std::string period_text(std::int64_t microseconds) {
  if (microseconds == 0) return {};
  return microseconds % 1000 == 0 ? fmt::format("{} ms", microseconds / 1000) : fmt::format("{} us", microseconds);
}

graph::ModuleRow described(const genom::Module& module) {
  graph::ModuleRow row{module.name.text, {}, {}, {}, {}};
  for (const genom::Port& port : module.ports) {
    if (!port.is_out) row.in_ports.push_back(port.name);
  }
  for (const genom::Task& task : module.tasks) row.tasks.push_back({task.name.text, period_text(task.period_us)});
  for (const genom::Service& service : module.services)
    row.services.push_back({service.name.text, service.kind == genom::ServiceKind::Execution});
  for (const genom::Poster& poster : module.posters) row.posters.push_back(poster.name.text);
  return row;
}

void add_reads(graph::ModuleGraph& graph, const std::vector<genom::Module>& modules) {
  for (std::size_t m = 0; m < modules.size(); ++m) {
    for (std::size_t t = 0; t < modules[m].tasks.size(); ++t) {
      for (const genom::Name& read : modules[m].tasks[t].reads) {
        for (std::size_t w = 0; w < modules.size(); ++w) {
          for (std::size_t p = 0; p < modules[w].posters.size(); ++p) {
            if (modules[w].name.text + "." + modules[w].posters[p].name.text == read.text)
              graph.reads.push_back({m, t, {w, p}});
          }
        }
      }
    }
  }
}

// Where in ports read before anybody asks for `connect_port`. Of several out ports the last one, as in the C++ of
// codels.
void add_connections(graph::ModuleGraph& graph, const std::vector<genom::Module>& modules) {
  BIP_ASSERT(graph.modules.size() == modules.size(), "{} modules of {}", graph.modules.size(), modules.size());
  for (std::size_t m = 0; m < modules.size(); ++m) {
    std::size_t row = 0;
    for (const genom::Port& in : modules[m].ports) {
      if (in.is_out) continue;
      std::optional<ModuleMember> source;
      for (std::size_t w = 0; w < modules.size(); ++w) {
        for (const genom::Port& out : modules[w].ports) {
          if (!genom::reads_by_itself(in, out)) continue;
          const std::vector<std::string>& posters = graph.modules[w].posters;
          const auto poster = std::find(posters.begin(), posters.end(), out.name);
          BIP_ASSERT(poster != posters.end(), "the out port `{}` is no poster", out.name);
          source = {w, static_cast<std::size_t>(poster - posters.begin())};
        }
      }
      if (source) graph.connections.push_back({*source, {m, row}});
      ++row;
    }
  }
}

// What the constraints of one rule are about.
class RuleMembers {
 public:
  explicit RuleMembers(const genom::Constraints& all) : all_(all) {}

  void add(const genom::Constraint& constraint) {
    if (constraint.kind != genom::ConstraintKind::When) subjects_.insert(of(constraint.subject));
    const bool has_other =
        constraint.kind == genom::ConstraintKind::Interrupt || constraint.kind == genom::ConstraintKind::Wait;
    // A request tells it to stop, or waits for it.
    if (has_other) services_.insert(of(constraint.other));
    add(constraint.condition);
  }

  void write(graph::RuleRow& row) const {
    row.subjects.assign(subjects_.begin(), subjects_.end());
    std::set_difference(services_.begin(), services_.end(), subjects_.begin(), subjects_.end(),
                        std::back_inserter(row.services));
    row.posters.assign(posters_.begin(), posters_.end());
    row.tasks.assign(tasks_.begin(), tasks_.end());
  }

 private:
  static ModuleMember of(const genom::ServiceRef& at) { return {at.module, at.service}; }
  static ModuleMember of(const genom::PosterRef& at) { return {at.module, at.poster}; }

  void add(const genom::Condition& c) {
    using Kind = genom::ConditionKind;
    switch (c.kind) {
      case Kind::Number:
      case Kind::Text:
      // Of a module, or of all.
      case Kind::Silent:
      case Kind::Not:
      case Kind::Operator: break;
      case Kind::Active:
      case Kind::Done: services_.insert(of(c.service)); break;
      case Kind::Asked:
      case Kind::Value: services_.insert(of(all_.parameters[c.row].service)); break;
      case Kind::Total:
        for (const std::size_t row : c.rows) services_.insert(of(all_.parameters[row].service));
        break;
      case Kind::Fresh:
      case Kind::Age: posters_.insert(of(c.poster)); break;
      case Kind::Below: services_.insert(of(all_.stopwatches[c.row].service)); break;
      case Kind::Recent:
        services_.insert(of(all_.successes[c.row].service));
        if (all_.successes[c.row].since) services_.insert(of(*all_.successes[c.row].since));
        break;
      case Kind::Held: posters_.insert(of(all_.values[c.row].poster)); break;
      case Kind::Ordered:
        services_.insert(of(all_.pairs[c.row].first));
        services_.insert(of(all_.pairs[c.row].second));
        break;
      case Kind::Failed: services_.insert(of(all_.failures[c.row].service)); break;
      case Kind::Missed: tasks_.insert({all_.watched_tasks[c.row].module, all_.watched_tasks[c.row].task}); break;
    }
    for (const genom::Condition& operand : c.operands) add(operand);
  }

  const genom::Constraints& all_;
  std::set<ModuleMember> subjects_, services_, posters_, tasks_;
};

// The rule without its name and its report, which stand beside it.
std::string bare_text(std::string text, const std::string& name, const std::string& report) {
  if (text.starts_with(name + ":")) text.erase(0, text.find_first_not_of(' ', name.size() + 1));
  const std::string told = " report \"" + report + '"';
  if (const std::size_t at = text.find(told); at != std::string::npos) text.erase(at, told.size());
  return text;
}

void add_rules(graph::ModuleGraph& graph, const rules::Checked& checked) {
  const std::vector<genom::Constraint>& rows = checked.constraints.rows;
  BIP_ASSERT(rows.size() == checked.rule.size(), "{} constraints of {} rules", rows.size(), checked.rule.size());
  for (std::size_t begin = 0; begin < rows.size();) {
    const genom::Constraint& first = rows[begin];
    graph::RuleRow row{first.name,  bare_text(first.text, first.name, first.report), first.report, {}, {}, {}, {},
                       std::nullopt};
    RuleMembers members(checked.constraints);
    std::size_t end = begin;
    for (; end < rows.size() && checked.rule[end] == checked.rule[begin]; ++end) {
      members.add(rows[end]);
      if (rows[end].recovery) row.recovery = {rows[end].recovery->module, rows[end].recovery->service};
    }
    members.write(row);
    graph.rules.push_back(std::move(row));
    begin = end;
  }
}

graph::ModuleGraph described(const std::string& name, const std::vector<genom::Module>& modules) {
  graph::ModuleGraph graph;
  graph.name = name;
  for (const genom::Module& module : modules) graph.modules.push_back(described(module));
  add_reads(graph, modules);
  add_connections(graph, modules);
  return graph;
}

bool is_rules_file(const std::string& file) { return std::filesystem::path(file).extension() == ".rules"; }

}  // namespace

bool describes_modules(const std::string& file) {
  return is_rules_file(file) || std::filesystem::path(file).extension() == ".gen";
}

std::optional<graph::ModuleGraph> describe_modules(Compilation& c, const GenomArguments& arguments) {
  if (!is_rules_file(arguments.files.front())) {
    const auto modules =
        load_modules(c, arguments.files, arguments.side_file, translate_options(arguments, arguments.files, ""));
    if (!modules) return std::nullopt;
    return described(genom::package_of(*modules), *modules);
  }
  const std::optional<RuleLevel> level = load_rules(c, arguments);
  if (!level) return std::nullopt;
  graph::ModuleGraph graph = described(level->file.package.text, level->modules);
  add_rules(graph, level->checked);
  return graph;
}

}  // namespace bip::driver
