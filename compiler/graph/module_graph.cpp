// DOT and JSON of robot modules. See module_graph.hpp.
#include "compiler/graph/module_graph.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"
#include "compiler/graph/dot.hpp"

namespace bip::graph {
namespace {

using ModuleJson = nlohmann::ordered_json;

// Fields of a record, with the ports by which edges find them.
std::string fields(const std::vector<std::string>& names, char port) {
  std::string out;
  for (std::size_t k = 0; k < names.size(); ++k)
    out += fmt::format("{}<{}{}> {}", k == 0 ? "" : "|", port, k, record_field(names[k]));
  return out;
}

std::string record_of(const ModuleRow& module) {
  std::vector<std::string> tasks, services;
  for (const ModuleRow::Task& task : module.tasks)
    tasks.push_back("task " + task.name + (task.period.empty() ? "" : ", " + task.period));
  for (const ModuleRow::Service& service : module.services)
    services.push_back(service.is_activity ? service.name : service.name + "()");
  std::string out = "{" + record_field(module.name);
  if (!tasks.empty()) out += "|{" + fields(tasks, 't') + "}";
  std::string columns;
  const auto add_column = [&](const std::vector<std::string>& names, char port) {
    if (!names.empty()) columns += fmt::format("{}{{{}}}", columns.empty() ? "" : "|", fields(names, port));
  };
  add_column(module.in_ports, 'i');
  add_column(services, 's');
  add_column(module.posters, 'p');
  if (!columns.empty()) out += "|{" + columns + "}";
  return out + "}";
}

}  // namespace

std::string dot(const ModuleGraph& graph) {
  std::string out =
      "// bipc graph --show modules: `dot -Tsvg` draws it.\n"
      "digraph modules {\n"
      "  rankdir=LR;\n"
      "  fontname=\"Helvetica\"; fontsize=11;\n"
      "  node [fontname=\"Helvetica\", fontsize=10];\n"
      "  edge [fontname=\"Helvetica\", fontsize=9];\n";
  for (std::size_t m = 0; m < graph.modules.size(); ++m)
    out += fmt::format("  m{} [shape=record, label=\"{}\"];\n", m, record_of(graph.modules[m]));
  for (std::size_t r = 0; r < graph.rules.size(); ++r) {
    const RuleRow& rule = graph.rules[r];
    out += fmt::format("  r{} [shape=box, style=\"rounded,dashed\", label={}];\n", r,
                       dot_string(lines_of({rule.name, shortened(rule.text), rule.report})));
  }
  for (const PosterRead& read : graph.reads)
    out += fmt::format("  m{}:p{} -> m{}:t{};\n", read.poster.module, read.poster.row, read.module, read.task);
  for (const PortConnection& c : graph.connections)
    out += fmt::format("  m{}:p{} -> m{}:i{};\n", c.poster.module, c.poster.row, c.in_port.module, c.in_port.row);
  for (std::size_t r = 0; r < graph.rules.size(); ++r) {
    const RuleRow& rule = graph.rules[r];
    const auto sees = [&](const std::vector<ModuleMember>& members, char port) {
      for (const ModuleMember& member : members)
        out += fmt::format("  m{}:{}{} -> r{} [style=dashed, arrowhead=open];\n", member.module, port, member.row, r);
    };
    sees(rule.services, 's');
    sees(rule.posters, 'p');
    sees(rule.tasks, 't');
    for (const ModuleMember& subject : rule.subjects)
      out += fmt::format("  r{} -> m{}:s{} [style=dashed, arrowhead=tee];\n", r, subject.module, subject.row);
    if (rule.recovery)
      out += fmt::format("  r{} -> m{}:s{} [style=dashed, label=\"runs\"];\n", r, rule.recovery->module,
                         rule.recovery->row);
  }
  return out + "}\n";
}

std::string json(const ModuleGraph& graph) {
  const auto service = [&](const ModuleMember& at) {
    return graph.modules[at.module].name + "." + graph.modules[at.module].services[at.row].name;
  };
  const auto poster = [&](const ModuleMember& at) {
    return graph.modules[at.module].name + "." + graph.modules[at.module].posters[at.row];
  };
  const auto in_port = [&](const ModuleMember& at) {
    return graph.modules[at.module].name + "." + graph.modules[at.module].in_ports[at.row];
  };
  const auto task = [&](const ModuleMember& at) {
    return graph.modules[at.module].name + "." + graph.modules[at.module].tasks[at.row].name;
  };
  const auto list = [](const auto& rows, const auto& text) {
    ModuleJson out = ModuleJson::array();
    for (const auto& row : rows) out.push_back(text(row));
    return out;
  };
  ModuleJson out{{"format", "bipc-modules"}, {"version", 1}, {"name", graph.name}};
  out["modules"] = list(graph.modules, [&](const ModuleRow& m) {
    return ModuleJson{
        {"name", m.name},
        {"tasks", list(m.tasks,
                       [](const ModuleRow::Task& t) {
                         return ModuleJson{{"name", t.name},
                                           {"period", t.period.empty() ? ModuleJson(nullptr) : ModuleJson(t.period)}};
                       })},
        {"services", list(m.services,
                          [](const ModuleRow::Service& s) {
                            return ModuleJson{{"name", s.name}, {"kind", s.is_activity ? "activity" : "control"}};
                          })},
        {"posters", m.posters},
        {"in_ports", m.in_ports}};
  });
  out["reads"] = list(graph.reads, [&](const PosterRead& read) {
    return ModuleJson{{"poster", poster(read.poster)}, {"task", task({read.module, read.task})}};
  });
  out["connections"] = list(graph.connections, [&](const PortConnection& c) {
    return ModuleJson{{"poster", poster(c.poster)}, {"in_port", in_port(c.in_port)}};
  });
  out["rules"] = list(graph.rules, [&](const RuleRow& rule) {
    return ModuleJson{{"name", rule.name},
                      {"text", rule.text},
                      {"report", rule.report},
                      {"subjects", list(rule.subjects, service)},
                      {"services", list(rule.services, service)},
                      {"posters", list(rule.posters, poster)},
                      {"tasks", list(rule.tasks, task)},
                      {"recovery", rule.recovery ? ModuleJson(service(*rule.recovery)) : ModuleJson(nullptr)}};
  });
  return indented_json(out) + "\n";
}

}  // namespace bip::graph
