// See c_codels.hpp. Types and names are those of c_mapping.hpp and cxx_mapping.hpp, what codels are called with is
// found by codel_arguments.hpp.
#include "compiler/genom/c_codels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "compiler/genom/c_mapping.hpp"
#include "compiler/genom/codel_arguments.hpp"
#include "compiler/genom/codel_processes.hpp"
#include "compiler/genom/codels.hpp"
#include "compiler/genom/cxx_mapping.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"
#include "compiler/genom/remote_services.hpp"
#include "compiler/genom/standard_services.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

using idl::Component;
using idl::Direction;
using idl::Kind;

// States of all services and tasks.
std::set<std::string> states_of(const Module& m) {
  std::set<std::string> states{"ether"};
  const auto add = [&](const Activity& activity) {
    for (const State& s : activity.states) states.insert(s.name.text);
  };
  for (const Service& s : m.services) add(s.activity);
  for (const Task& t : m.tasks) add(t.activity);
  return states;
}

// One prototype a codel.
std::string prototypes(const Module& m) {
  const Component& c = *m.component;
  const CodelArguments names(c);
  std::string out;
  std::set<std::string> done;
  const auto add = [&](const std::vector<idl::Codel>& codels, const std::vector<idl::Member>& locals) {
    for (const idl::Codel& codel : codels) {
      if (!done.insert(codel.name).second) continue;
      out += fmt::format("genom_event {}(", codel.name);
      for (const idl::Argument& a : codel.arguments) out += names.argument(a, locals)->type + ", ";
      out += "genom_context self);\n";
    }
  };
  for (const idl::Task& t : c.tasks) add(t.codels, t.locals);
  for (const idl::Service& s : c.services) add(s.codels, names.locals_of(s));
  return out;
}

std::string event_declarations(const Module& m) {
  const Component& c = *m.component;
  std::string out;
  for (const std::string& state : states_of(m)) {
    out += fmt::format("extern const genom_event {}_{};\n", c.name, state);
    if (state != "ether") out += fmt::format("extern const genom_event {}_pause_{};\n", c.name, state);
  }
  return out;
}

std::string component_header(const Module& m) {
  const Component& c = *m.component;
  std::string out = fmt::format(
      "/* What codels of {0} see. Written by `bipc genom --codels`. */\n#ifndef GENOM_AC_{0}_H\n#define "
      "GENOM_AC_{0}_H\n"
      "#include \"{0}_c_types.h\"\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n",
      c.name);
  out += fmt::format("\ntypedef struct {0}_ids {{\n{1}}} {0}_ids;\n", c.name, c_members(c, c.ids, "  "));
  for (const idl::Port& p : c.ports) out += c_port_struct(c, p);
  for (const idl::Service* const s : called_remotes(c)) out += remote_struct(c, *s);
  out += "\n" + event_declarations(m) + "\n" + prototypes(m);
  return out + "\n#ifdef __cplusplus\n}\n#endif\n#endif\n";
}

// ---- the C++ in between

// Of what a port holds.
std::string port_type(const Component& c, const idl::Port& p) {
  return c.is_cxx ? cxx_type(c, p.type) : c.types[p.type].c_name;
}

class Glue {
 public:
  Glue(const std::vector<Module>& modules, const GenerateOptions& options)
      : modules_(modules), options_(options), plans_(make_plans(modules, options)) {}

  std::string run() {
    out_ = fmt::format(
        "// Between {0}.bip and the codels of its components. Written by `bipc genom --codels`.\n#include "
        "\"{0}_codels.hpp\"\n\n#include \"bip/genom3_{1}.hpp\"\n#include \"bip/genom3_remotes.hpp\"\n",
        options_.package, options_.processes.are_own || are_mixed() ? "bytes" : "codels");
    if (options_.processes.are_own) here_ = "here_";
    for (const Module& m : modules_)
      out_ += fmt::format("#include \"ac{}.h{}\"\n", m.component->name, m.component->is_cxx ? "pp" : "");
    out_ += "\n";
    std::set<std::string> done;
    for (const Module& m : modules_)
      out_ += m.component->is_cxx ? cxx_members_functions(*m.component, done) : c_members_functions(*m.component, done);
    out_ += "\nnamespace g3 = bip::genom3;\n\nextern \"C\" {\n";
    events();
    out_ += "}\n\nnamespace {\n";
    exceptions();
    for (const Module& m : modules_) {
      out_ += fmt::format("\n// ---- {}\n{}_ids ids_{};\n", m.component->name, m.component->name, m.component->name);
      for (const idl::Port& p : m.component->ports) port(*m.component, p);
    }
    for (const Module& m : modules_) out_ += remote_functions(modules_, *m.component);
    for (std::size_t i = 0; i < modules_.size(); ++i) data(i);
    start();
    out_ += "}  // namespace\n\nstatic void take_input(int owner);\n";
    for (const Module& m : modules_) {
      connects(*m.component);
      out_ += connect_service_function(*m.component);
    }
    for (std::size_t i = 0; i < modules_.size(); ++i) codels(i);
    requests();
    if (!options_.processes.are_own) return std::move(out_);
    posters();
    out_ += process_definitions(modules_, options_, posters_, readers_);
    return std::move(out_);
  }

 private:
  [[nodiscard]] const char* scope() const { return here_.empty() ? "" : "static "; }

  // Are there components of both mappings?
  [[nodiscard]] bool are_mixed() const {
    return std::any_of(modules_.begin(), modules_.end(),
                       [&](const Module& m) { return m.component->is_cxx != modules_.front().component->is_cxx; });
  }

  void events() {
    std::set<std::string> done, done_in_c;
    for (const Module& m : modules_) {
      const Component& c = *m.component;
      for (const std::string& state : states_of(m)) {
        out_ += fmt::format("extern const genom_event {}_{} = \"{}\";\n", c.name, state, state);
        if (state != "ether")
          out_ += fmt::format("extern const genom_event {}_pause_{} = \"pause::{}\";\n", c.name, state, state);
      }
      for (const idl::Exception& e : c.exceptions) {
        if (done.insert(e.c_name).second)
          out_ += fmt::format("extern const genom_event {}_id = \"{}\";\n", e.c_name, e.full_name);
        if (c.is_cxx || !done_in_c.insert(e.c_name).second) continue;
        out_ += e.members.empty()
                    ? fmt::format(
                          "genom_event {0}(genom_context self) {{ return self->raise({0}_id, nullptr, 0, self); }}\n",
                          e.c_name)
                    : fmt::format(
                          "genom_event {0}(const {0}_detail* detail, genom_context self) {{ return self->raise({0}_id, "
                          "detail, sizeof *detail, self); }}\n",
                          e.c_name);
      }
    }
  }

  void exceptions() {
    struct Row {
      std::string in_c = "nullptr", in_cxx = "nullptr", again = "nullptr", object_again = "nullptr";
    };
    std::vector<std::string> names;
    std::map<std::string, Row> all;
    for (const Module& m : modules_) {
      for (const idl::Exception& e : m.component->exceptions) {
        const auto [at, is_new] = all.try_emplace(e.c_name);
        if (is_new) names.push_back(e.c_name);
        if (e.members.empty()) continue;
        const bool is_cxx = m.component->is_cxx;
        (is_cxx ? at->second.in_cxx : at->second.in_c) = fmt::format(
            "[](std::string& json, const void* detail) {{ g3::to_json(json, *static_cast<const {}_detail*>(detail)); "
            "}}",
            is_cxx ? e.full_name : e.c_name);
        (is_cxx ? at->second.object_again : at->second.again) = fmt::format(
            "[](const g3::Json* json, genom_context self) {{ {}_detail detail{{}}; g3::clear(detail); if (json != "
            "nullptr) g3::from_json(*json, detail, \"detail\"); return {}; }}",
            is_cxx ? e.full_name : e.c_name,
            is_cxx ? fmt::format("::genom::raise({}(detail), self)", e.full_name)
                   : fmt::format("self->raise({}_id, &detail, sizeof detail, self)", e.c_name));
      }
    }
    std::string rows;
    for (const std::string& name : names)
      rows += fmt::format("    {{{}_id, {}, {}, {}, {}}},\n", name, all[name].in_c, all[name].in_cxx, all[name].again,
                          all[name].object_again);
    out_ += fmt::format("const g3::ExceptionRow kExceptions[] = {{\n{}}};\n", rows);
  }

  void port(const Component& c, const idl::Port& p) {
    const std::string type = fmt::format("{}Port_{}_{}", p.is_out ? "Out" : "In", c.name, p.name);
    out_ += fmt::format("using {} = g3::{}Port<{}, {}>;\n", type, p.is_out ? "Out" : "In", port_type(c, p), ports_++);
    const char* const of = p.is_multiple ? "_of" : "";
    const char* const does = p.is_out ? "write" : "read";
    out_ += fmt::format("const {0}_{1} port_{0}_{1} = {{&{2}::data{3}, &{2}::{4}{3}{5}}};\n", c.name, p.name, type, of,
                        does, p.is_multiple ? fmt::format(", &{0}::open, &{0}::close", type) : "");
  }

  // Of each activity and task: its parameters and locals.
  void data(std::size_t i) {
    const Plan& plan = plans_[i];
    const Component& c = *modules_[i].component;
    const CodelArguments names(c);
    out_ += "\n";
    const auto write_owner = [&](const std::string& name, const std::vector<idl::Member>& members,
                                 const std::vector<std::size_t>& owners, const Activity& activity,
                                 const std::vector<std::string>& reports) {
      out_ += fmt::format("struct Data_{}_{} {{\n{}}}", c.name, name,
                          c.is_cxx ? cxx_members(c, members, "  ") : c_members(c, members, "  "));
      std::string list;
      for (const std::size_t owner : owners) list += fmt::format("{} data_{}", list.empty() ? "" : ",", owner);
      out_ += list + ";\n";
      std::string states, texts;
      for (const State& s : activity.states) states += fmt::format("\"{}\", ", s.name.text);
      for (const std::string& r : reports) texts += fmt::format("\"{}\", ", r);
      out_ += fmt::format(
          "const char* const kStates_{0}_{1}[] = {{{2}\"\"}};\nconst char* const kReports_{0}_{1}[] = {{{3}\"\"}};\n",
          c.name, name, states, texts);
      out_ += fmt::format(
          "const g3::Behaviour kBehaviour_{0}_{1}{{{{kStates_{0}_{1}, {2}}}, {{kReports_{0}_{1}, {3}}}}};\n", c.name,
          name, activity.states.size(), reports.size());
    };
    for (std::size_t s = 0; s < plan.module->services.size(); ++s) {
      const Service& service = plan.module->services[s];
      BIP_ASSERT(find_row(c.services, service.name.text) != nullptr, "service `{}` has no parameters in the IDL",
                 service.name.text);
      const idl::Service& parameters = *find_row(c.services, service.name.text);
      std::vector<std::size_t> owners;
      for (const std::size_t activity : plan.services[s].activities) owners.push_back(plan.owner_of_activity(activity));
      std::vector<std::string> reports;
      for (const Name& r : service.reports) reports.push_back(r.text);
      write_owner(service.name.text, names.locals_of(parameters), owners, service.activity, reports);
      reads(c, parameters);
    }
    for (std::size_t t = 0; t < plan.module->tasks.size(); ++t) {
      const Task& task = plan.module->tasks[t];
      BIP_ASSERT(find_row(c.tasks, task.name.text) != nullptr, "task `{}` is not in the IDL", task.name.text);
      write_owner("task_" + task.name.text, find_row(c.tasks, task.name.text)->locals, {plan.owner_of_task(t)},
                  task.activity, {});
    }
  }

  // The functions that read a service's input and write its output.
  void reads(const Component& c, const idl::Service& s) {
    const std::string type = fmt::format("Data_{}_{}", c.name, s.name);
    out_ += fmt::format(
        "[[maybe_unused]] void read_{0}_{1}(std::string_view input, {2}& data) {{\n  const g3::Json json = "
        "g3::read_input(input);\n",
        c.name, s.name, type);
    std::string names, outputs, cleared;
    for (const idl::Parameter& p : s.parameters) {
      if (p.direction != Direction::Out) {
        names += fmt::format("\"{}\", ", p.name);
        out_ += fmt::format("  g3::read_parameter(json, \"{0}\", R\"json({1})json\", data.{0});\n", p.name,
                            idl::json_of(p.initial));
      } else {
        cleared += fmt::format("  g3::release(data.{0}), g3::clear(data.{0});\n", p.name);
      }
      if (p.direction != Direction::In)
        outputs += fmt::format("  g3::write_output(members, \"{0}\", data.{0});\n", p.name);
    }
    for (const idl::Member& m : s.locals)
      cleared += fmt::format("  g3::release(data.{0}), g3::clear(data.{0});\n", m.name);
    out_ += fmt::format("{}  g3::check_names(json, {{{}}});\n  (void)data;\n}}\n", cleared, names);
    out_ += fmt::format(
        "[[maybe_unused]] std::string outputs_{0}_{1}(const {2}& data) {{\n  std::string members;\n{3}  (void)data;\n  "
        "return "
        "g3::end_outputs(members);\n}}\n",
        c.name, s.name, type, outputs);
  }

  // An out port that an in port can read.
  [[nodiscard]] static bool fits(const Component& reader, const idl::Port& in, const Component& writer,
                                 const idl::Port& out) {
    return !in.is_out && out.is_out && writer.types[out.type].c_name == reader.types[in.type].c_name;
  }
  // The port that it reads before `connect_port` names another.
  [[nodiscard]] static bool is_source(const Component& reader, const idl::Port& in, const Component& writer,
                                      const idl::Port& out) {
    return fits(reader, in, writer, out) && out.name == in.name && out.is_multiple == in.is_multiple;
  }
  [[nodiscard]] std::string fetch_text(const Component& reader, const idl::Port& in, const Component& writer,
                                       const idl::Port& out) const {
    return fmt::format("[](std::string_view id, {}& into) {{ return g3::fetch{}(OutPort_{}_{}::written, id, into); }}",
                       port_type(reader, in), reader.is_cxx == writer.is_cxx ? "" : "_converted", writer.name,
                       out.name);
  }

  // What crosses processes.
  void posters() {
    std::size_t count = 0;
    for (std::size_t i = 0; i < modules_.size(); ++i) {
      const Component& c = *modules_[i].component;
      for (const idl::Port& out : c.ports) {
        if (!out.is_out) continue;
        posters_ += fmt::format(
            "    {{.writer = {0},\n     .pack = [](std::string& out) {{ return g3::pack(OutPort_{1}_{2}::written, "
            "out); "
            "}},\n     .version = [] {{ return OutPort_{1}_{2}::written.version.load(); }},\n     .unpack = "
            "[](std::string_view in) {{ return g3::unpack(OutPort_{1}_{2}::written, in); }}}},\n",
            i, c.name, out.name);
        for (std::size_t reader = 0; reader < modules_.size(); ++reader) {
          const Component& other = *modules_[reader].component;
          if (reader != i && std::any_of(other.ports.begin(), other.ports.end(),
                                         [&](const idl::Port& in) { return fits(other, in, c, out); }))
            readers_ += fmt::format("    {{{}, {}}},\n", reader, count);
        }
        ++count;
      }
    }
  }

  // Bounds of sequences; and an in port reads the out port of its name and type.
  void start() {
    out_ += "\n// Before anything runs.\nconst bool kStarted = [] {\n";
    for (std::size_t i = 0; i < modules_.size(); ++i) {
      const Component& c = *modules_[i].component;
      for (const idl::Member& m : c.ids) out_ += fmt::format("  g3::clear(ids_{}.{});\n", c.name, m.name);
      for (std::size_t t = 0; t < modules_[i].tasks.size(); ++t) {
        for (const idl::Member& m : find_row(c.tasks, modules_[i].tasks[t].name.text)->locals)
          out_ += fmt::format("  g3::clear(data_{}.{});\n", plans_[i].owner_of_task(t), m.name);
      }
      for (const idl::Port& p : c.ports) {
        if (p.is_out) continue;
        std::string rows;
        for (const Module& other : modules_) {
          for (const idl::Port& out : other.component->ports) {
            const Component& writer = *other.component;
            if (!fits(c, p, writer, out)) continue;
            rows += fmt::format("    {{\"{}/{}\", {}, {}}},\n", writer.name, out.name, out.is_multiple,
                                fetch_text(c, p, writer, out));
            if (is_source(c, p, writer, out))
              out_ += fmt::format("  InPort_{}_{}::source = {};\n", c.name, p.name, fetch_text(c, p, writer, out));
          }
        }
        if (!rows.empty())
          out_ += fmt::format(
              "  static constexpr g3::SourceRow<{0}> kSources_{1}_{2}[] = {{\n{3}  }};\n  InPort_{1}_{2}::sources = "
              "kSources_{1}_{2};\n",
              port_type(c, p), c.name, p.name, rows);
      }
    }
    out_ += "  return true;\n}();\n";
  }

  // The codel of `connect_port`.
  void connects(const Component& c) {
    if (!connects_ports(c)) return;
    std::string rows;
    for (const idl::Port& p : c.ports) {
      if (!p.is_out)
        rows += fmt::format("    {{\"{1}\", {2}, &InPort_{0}_{1}::connect}},\n", c.name, p.name, p.is_multiple);
    }
    const char* const text = c.is_cxx ? "const std::string&" : "const char*";
    out_ += fmt::format(
        "\nstatic constexpr g3::InPortRow kInPorts_{0}[] = {{\n{1}}};\nextern \"C\" genom_event {2}({3} local, {3} "
        "remote, genom_context self) {{ return g3::connect_port(kInPorts_{0}, local, remote, self); }}\n",
        c.name, rows, connect_function(c, kConnectPort), text);
  }

  struct Owner {
    std::size_t number;
    std::string call, behaviour, outputs, before;
  };

  // What BIP calls: for each codel, by whose it is.
  void codels(std::size_t i) {
    const Plan& plan = plans_[i];
    const Module& m = modules_[i];
    const Component& c = *m.component;
    const CodelArguments names(c);
    std::map<std::string, std::vector<Owner>> steps, controls;
    const auto add = [&](auto& into, const auto& owner_row, const std::vector<idl::Member>& locals, const Name& codel,
                         std::size_t owner, const std::string& behaviour, const std::string& outputs,
                         const std::string& before) {
      if (!codel.is_set()) return;
      BIP_ASSERT(find_row(owner_row.codels, codel.text) != nullptr, "codel `{}` has no arguments in the IDL",
                 codel.text);
      const idl::Codel& called = *find_row(owner_row.codels, codel.text);
      std::string call = codel.text + "(";
      for (const idl::Argument& a : called.arguments) call += names.argument(a, locals)->value_of(owner) + ", ";
      auto& all = into[codel.text];
      if (std::none_of(all.begin(), all.end(), [&](const Owner& known) { return known.number == owner; }))
        all.push_back({owner, call + "self)", behaviour, outputs, before});
    };
    for (std::size_t s = 0; s < m.services.size(); ++s) {
      const Service& service = m.services[s];
      BIP_ASSERT(find_row(c.services, service.name.text) != nullptr, "service `{}` has no codels in the IDL",
                 service.name.text);
      const idl::Service& row = *find_row(c.services, service.name.text);
      const std::vector<idl::Member> locals = names.locals_of(row);
      const std::string id = c.name + "_" + service.name.text, behaviour = "kBehaviour_" + id;
      for (const std::size_t activity : plan.services[s].activities) {
        const std::size_t owner = plan.owner_of_activity(activity);
        const std::string outputs = fmt::format("outputs_{}(data_{})", id, owner);
        add(controls, row, locals, service.validate.name, owner, behaviour, "", fmt::format("take_input({}); ", owner));
        // In a process of its own it is called once more, with its input, when that was started again.
        const bool is_repeated = is_connection(c, service.name.text);
        for (const genom::Codel& codel : service.body)
          add(controls, row, locals, codel.name, owner, behaviour, "",
              is_repeated ? fmt::format("take_input({}); ", owner) : "");
        for (const State& state : service.activity.states)
          add(steps, row, locals, state.codel.name, owner, behaviour, outputs, "");
      }
    }
    for (std::size_t t = 0; t < m.tasks.size(); ++t) {
      BIP_ASSERT(find_row(c.tasks, m.tasks[t].name.text) != nullptr, "task `{}` has no codels in the IDL",
                 m.tasks[t].name.text);
      const idl::Task& row = *find_row(c.tasks, m.tasks[t].name.text);
      for (const State& state : m.tasks[t].activity.states)
        add(steps, row, row.locals, state.codel.name, plan.owner_of_task(t),
            fmt::format("kBehaviour_{}_task_{}", c.name, row.name), "std::string()", "");
    }
    for (const auto& [name, owners] : controls) {
      out_ += fmt::format("\n{}int {}{}(int owner) {{\n  switch (owner) {{\n", scope(), here_, codel_function(name));
      for (const Owner& o : owners)
        out_ += fmt::format(
            "    case {0}: return g3::run_control(\"{1}\", kCodelOwners[owner], kExceptions, {2}, [](genom_context "
            "self) {{ {3}return {4}; }});\n",
            o.number, name, o.behaviour, o.before, o.call);
      out_ += "    default: return bip::kCodelRefuses;\n  }\n}\n";
    }
    for (const auto& [name, owners] : steps) {
      out_ += fmt::format("\n{}int {}{}(int owner, int& report) {{\n  switch (owner) {{\n", scope(), here_,
                          codel_function(name));
      for (const Owner& o : owners)
        out_ += fmt::format(
            "    case {0}: return g3::run_step(\"{1}\", kCodelOwners[owner], kExceptions, {2}, report, "
            "[](genom_context self) {{ return {3}; }}, [] {{ return {4}; }});\n",
            o.number, name, o.behaviour, o.call, o.outputs);
      out_ += "    default: return bip::kCodelThrew;\n  }\n}\n";
    }
  }

  // Inputs before the codels of a service, outputs after them; attributes are the IDS.
  void requests() {
    std::string begins, ends, checks;
    for (std::size_t i = 0; i < modules_.size(); ++i) {
      const Module& m = modules_[i];
      const Component& c = *m.component;
      for (std::size_t s = 0; s < m.services.size(); ++s) {
        const idl::Service& row = *find_row(c.services, m.services[s].name.text);
        const std::string id = c.name + "_" + row.name, service = m.name.text + "." + row.name;
        checks += fmt::format(
            "    if (name == \"{0}\") {{\n      static thread_local Data_{1} data;\n      read_{1}(input, data);\n    "
            "}}\n",
            service, id);
        for (const std::size_t activity : plans_[i].services[s].activities) {
          const std::size_t owner = plans_[i].owner_of_activity(activity);
          begins += fmt::format("    case {}: return read_{}(input, data_{});\n", owner, id, owner);
          if (m.services[s].kind != ServiceKind::Control) continue;
          ends += fmt::format("    case {}: {{\n", owner);
          for (const idl::Parameter& p : row.parameters) {
            if (row.kind != idl::ServiceKind::Attribute) continue;
            std::string path;
            for (const std::string& step : p.path) path += step.starts_with("[") ? step : "." + step;
            if (p.direction != Direction::Out)
              ends += fmt::format("      g3::assign(ids_{}{}, data_{}.{});\n", c.name, path, owner, p.name);
            else ends += fmt::format("      g3::assign(data_{}.{}, ids_{}{});\n", owner, p.name, c.name, path);
          }
          ends += fmt::format(
              "      bip::service_notes().note(kCodelOwners[owner].service, outputs_{}(data_{}));\n      return;\n    "
              "}}\n",
              id, owner);
        }
      }
    }
    out_ += fmt::format(
        "\nstatic void take_input(int owner) {{\n  const std::string_view input = "
        "g3::asked_inputs()[kCodelOwners[owner].service];\n"
        "  switch (owner) {{\n{0}    default: return;\n  }}\n}}\n{2}void {3}service_begin(int owner) {{ "
        "g3::begin(kCodelOwners[owner], [&] {{ take_input(owner); }}); }}\n"
        "\n{2}void {3}service_end(int owner) {{\n  switch (owner) {{\n{1}    default: return;\n  }}\n}}\n",
        begins, ends, scope(), here_);
    if (options_.executive != Executive::Served) return;
    out_ +=
        "\nvoid request_asked(const char* service, const char* input) { g3::note_asked(service, input); }\n"
        "void request_input(const char*, const char*) {}\n"
        "extern \"C\" const char* bip_input_problem(const char* service, const char* input) {\n"
        "  static thread_local std::string problem;\n  const std::string_view name = service;\n  problem.clear();\n"
        "  try {\n" +
        checks +
        "  } catch (const std::exception& wrong) {\n    problem = wrong.what();\n  }\n  return problem.c_str();\n}\n";
    std::string shows;
    for (const Module& m : modules_) {
      for (const idl::Port& p : m.component->ports) {
        if (p.is_out && !p.is_multiple)
          shows +=
              fmt::format("  if (name == \"{0}.{1}\") return g3::show(OutPort_{2}_{1}::written, json), json.c_str();\n",
                          m.name.text, p.name, m.component->name);
      }
    }
    out_ +=
        "extern \"C\" const char* bip_poster_value(const char* poster) {\n  static thread_local std::string json;\n"
        "  [[maybe_unused]] const std::string_view name = poster;\n  json.clear();\n" +
        shows + "  return nullptr;\n}\n";
  }

  const std::vector<Module>& modules_;
  const GenerateOptions& options_;
  std::vector<Plan> plans_;
  std::string out_;
  // What runs in a module's process has this before its name; and the tables of what crosses processes.
  std::string here_, posters_, readers_;
  int ports_ = 0;
};

}  // namespace

std::optional<std::size_t> type_of_parameter(const Component& component, const idl::Service& service,
                                             const idl::Parameter& parameter) {
  return CodelArguments(component).type_of(service, parameter);
}

bool check_c_codels(const std::vector<Module>& modules, Diagnostics& diags) {
  for (const Module& m : modules) {
    // Of GenoM 3 what is wrong has been reported.
    if (!m.component && m.generation == 2) diags.report(Diag::kB6014, m.name.range, "component of GenoM 3");
  }
  const std::size_t errors = diags.error_count();
  check_remotes(modules, diags);
  return diags.error_count() == errors &&
         std::all_of(modules.begin(), modules.end(), [](const Module& m) { return m.component.has_value(); });
}

std::vector<std::pair<std::string, std::string>> c_codel_files(const std::vector<Module>& modules,
                                                               const GenerateOptions& options) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const Module& m : modules) {
    const Component& c = *m.component;
    files.emplace_back(c.name + (c.is_cxx ? "_cxx_types.hpp" : "_c_types.h"),
                       c.is_cxx ? cxx_types_header(c) : c_types_header(c));
    files.emplace_back(fmt::format("ac{}.h{}", c.name, c.is_cxx ? "pp" : ""),
                       c.is_cxx ? cxx_component_header(c, event_declarations(m), prototypes(m)) : component_header(m));
  }
  files.emplace_back(options.package + "_codels.hpp", codel_header(modules, options));
  files.emplace_back(options.package + "_codels.cpp", Glue(modules, options).run());
  return files;
}

}  // namespace bip::genom
