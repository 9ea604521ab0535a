// See remote_services.hpp. A call waits for the final reply, for which the engine has to go on: so only codels that run
// beside their task may call.
#include "compiler/genom/remote_services.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/genom/c_mapping.hpp"
#include "compiler/genom/codel_arguments.hpp"
#include "compiler/genom/cxx_mapping.hpp"
#include "compiler/genom/standard_services.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

using idl::Component;
using idl::Direction;
using idl::Kind;

template <class F>
void for_each_remote(const Component& c, F f) {
  const auto all = [&](const std::vector<idl::Codel>& codels) {
    for (const idl::Codel& codel : codels) {
      for (const idl::Argument& a : codel.arguments) {
        if (a.place == idl::Place::Remote && a.path.size() == 1) f(codel, a);
      }
    }
  };
  for (const idl::Task& t : c.tasks) all(t.codels);
  for (const idl::Service& s : c.services) all(s.codels);
}

std::string parameters_of(const Component& c, const idl::Service& s, bool with_names) {
  std::string text;
  for (const idl::Parameter& p : s.parameters) {
    const std::string name = with_names ? p.name : "";
    text += (c.is_cxx ? cxx_parameter_type(c, p.type, p.direction) + " " + name
                      : c_parameter(c, p.type, p.direction, name)) +
            ", ";
  }
  return text + "genom_context self";
}

// What is copied to the input: of C byte by byte, for nothing of it is changed.
std::string taken(const Component& c, const idl::Parameter& p) {
  const idl::Type& t = c.plain(p.type);
  if (c.is_cxx || (p.direction == Direction::In && (t.kind == Kind::Primitive || t.kind == Kind::Enum)))
    return fmt::format("    genom_in.{0} = {0};\n", p.name);
  if (p.direction == Direction::In && t.kind == Kind::String && t.bound == 0)
    return fmt::format("    genom_in.{0} = const_cast<char*>({0});\n", p.name);
  if (p.direction == Direction::In && t.kind == Kind::String)
    return fmt::format("    std::strncpy(genom_in.{0}, {0}, sizeof genom_in.{0} - 1);\n", p.name);
  return fmt::format("    std::memcpy(&genom_in.{0}, {0}, sizeof genom_in.{0});\n", p.name);
}

bool is_same_type(const Component& a, std::size_t in_a, const Component& b, std::size_t in_b) {
  BIP_ASSERT(in_a < a.types.size() && in_b < b.types.size(), "type {} of `{}`, type {} of `{}`", in_a, a.name, in_b,
             b.name);
  const idl::Type &x = a.types[in_a], &y = b.types[in_b];
  return x.kind == y.kind && x.c_name == y.c_name && x.bound == y.bound &&
         (x.kind != Kind::Array || is_same_type(a, x.element, b, y.element));
}

// Can the remote be that service?
bool fits(const Component& caller, const idl::Service& remote, const Component& c, const idl::Service& s) {
  const CodelArguments data(c);
  if (remote.parameters.size() != s.parameters.size()) return false;
  for (std::size_t k = 0; k < s.parameters.size(); ++k) {
    const idl::Parameter &a = remote.parameters[k], &b = s.parameters[k];
    const std::optional<std::size_t> type = data.type_of(s, b);
    if (a.name != b.name || a.direction != b.direction || !type || !is_same_type(caller, a.type, c, *type))
      return false;
  }
  return true;
}

}  // namespace

std::vector<const idl::Service*> called_remotes(const Component& c) {
  std::set<std::string> named;
  for_each_remote(c, [&](const idl::Codel&, const idl::Argument& a) { named.insert(a.path.front()); });
  std::vector<const idl::Service*> all;
  for (const idl::Service& s : c.remotes) {
    if (named.contains(s.name)) all.push_back(&s);
  }
  return all;
}

std::string remote_struct(const Component& c, const idl::Service& s) {
  const std::string member = fmt::format("  genom_event (*call)({});\n", parameters_of(c, s, false));
  return c.is_cxx ? fmt::format("\nstruct {}_{} {{\n{}}};\n", c.name, s.name, member)
                  : fmt::format("\ntypedef struct {0}_{1} {{\n{2}}} {0}_{1};\n", c.name, s.name, member);
}

std::string remote_functions(const std::vector<Module>& modules, const Component& c) {
  std::string out;
  for (const idl::Service* const s : called_remotes(c)) {
    std::string rows, source;
    int sources = 0;
    for (const Module& m : modules) {
      const Component& other = *m.component;
      for (const idl::Service& theirs : other.services) {
        if (&other == &c || !fits(c, *s, other, theirs)) continue;
        const std::string service = m.name.text + "." + theirs.name;
        rows += fmt::format("    {{\"{}/{}\", \"{}\"}},\n", other.name, theirs.name, service);
        if (theirs.name != s->name) continue;
        source = service;
        ++sources;
      }
    }
    std::vector<idl::Member> inputs, outputs;
    std::string takes, writes, reads;
    for (const idl::Parameter& p : s->parameters) {
      if (p.direction != Direction::Out) {
        inputs.push_back({p.name, p.type, {}});
        takes += taken(c, p);
        writes += fmt::format("    g3::write_input(genom_members, \"{0}\", genom_in.{0});\n", p.name);
      }
      if (p.direction == Direction::In) continue;
      outputs.push_back({p.name, p.type, {}});
      reads += fmt::format("      g3::read_output(genom_out, \"{0}\", genom_result.{0});\n", p.name);
      reads += c.is_cxx ? fmt::format("      {0} = std::move(genom_result.{0});\n", p.name)
                        : fmt::format("      g3::hand_over({0}, genom_result.{0}, {1});\n", p.name,
                                      p.direction == Direction::InOut);
    }
    const auto members = [&](const std::vector<idl::Member>& all) {
      return c.is_cxx ? cxx_members(c, all, "    ") : c_members(c, all, "    ");
    };
    const std::string name = c.name + "_" + s->name;
    if (!rows.empty()) out += fmt::format("static constexpr g3::RemoteTarget kTargets_{}[] = {{\n{}}};\n", name, rows);
    out += fmt::format(
        "struct Remote_{0} {{\n  static inline g3::RemoteService service{{{1}, \"{2}\"}};\n  struct Input {{\n{3}  "
        "}};\n  struct Output {{\n{4}  }};\n  static genom_event call({5}) {{\n    [[maybe_unused]] Input "
        "genom_in{{}};\n"
        "    std::string genom_members;\n{6}{7}    return g3::call_service<g3::Mapping::{8}>(Remote_{0}::service, "
        "genom_members, kExceptions, "
        "self, [&]([[maybe_unused]] const g3::Json& genom_out) {{\n      [[maybe_unused]] Output "
        "genom_result{{}};\n{9}    "
        "}});\n  }}\n}};\nconst {0} remote_{0} = {{&Remote_{0}::call}};\n",
        name, rows.empty() ? "{}" : "kTargets_" + name, sources == 1 ? source : "", members(inputs), members(outputs),
        parameters_of(c, *s, true), takes, writes, c.is_cxx ? "Cxx" : "C", reads);
  }
  return out;
}

std::string connect_service_function(const Component& c) {
  if (!connects_services(c)) return {};
  std::string rows;
  for (const idl::Service* const s : called_remotes(c))
    rows += fmt::format("    {{\"{1}\", &Remote_{0}_{1}::service}},\n", c.name, s->name);
  const char* const text = c.is_cxx ? "const std::string&" : "const char*";
  return fmt::format(
      "\nstatic constexpr g3::RemoteRow kRemotes_{0}[] = {{\n{1}}};\nextern \"C\" genom_event {2}({3} local, {3} "
      "remote, genom_context self) {{ return g3::connect_service(kRemotes_{0}, local, remote, self); }}\n",
      c.name, rows, connect_function(c, kConnectService), text);
}

void check_remotes(const std::vector<Module>& modules, Diagnostics& diags) {
  for (const Module& m : modules) {
    if (!m.component) continue;
    std::set<std::string> beside, reported;
    const auto note = [&](const Activity& activity) {
      for (const State& s : activity.states) {
        if (s.codel.is_async) beside.insert(s.codel.name.text);
      }
    };
    for (const Service& s : m.services) note(s.activity);
    for (const Task& t : m.tasks) note(t.activity);
    for_each_remote(*m.component, [&](const idl::Codel& codel, const idl::Argument& a) {
      if (beside.contains(codel.name) || !reported.insert(codel.name).second) return;
      diags.report(Diag::kB6152, a.range, codel.name, a.path.front())
          .help(fmt::format("`async codel`, or the line `codel {} async 500 ms` of a side file", codel.name));
    });
  }
}

}  // namespace bip::genom
