// Atom types: variables, ports, places, transitions with their code.
#include <algorithm>

#include "compiler/model/build_time.hpp"
#include "compiler/model/build_weight.hpp"
#include "compiler/model/code_uses.hpp"
#include "compiler/model/ffi_declarations.hpp"
#include "compiler/model/packages.hpp"
#include "compiler/syntax/code_paths.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

namespace {

struct AtomBuilder {
  ModelBuilder& b;
  const syntax::Decl& decl;
  AtomType out{};
  NameSpace names;
  Scope scope;
  TimeBuilder time;
  std::unordered_map<std::string, std::uint32_t> variables, ports, places;
  std::unordered_map<std::string, SourceRange> constants;  // `data const`: after `initial` they keep their values
  StmtId initialisers;                                     // declared initial values, in reverse while collecting
  struct Init {
    std::uint32_t variable;
    const syntax::Expr* value;
    std::uint32_t param;  // hidden parameter that gives it, or kNone
    Loc loc;
  };
  std::vector<Init> inits;
  struct Change {
    SourceRange range;
    std::string by;  // the C++ function that is given it; empty: an assignment
  };
  std::unordered_map<std::string, Change> changed;  // names that actions assign or let C++ change: where first

  AtomBuilder(ModelBuilder& builder, const syntax::Decl& d)
      : b(builder),
        decl(d),
        names(builder.diags, fmt::format("atom type `{}`", d.name.text)),
        time(builder, out, scope) {
    out.name = b.key(decl);
    out.loc = b.loc(decl.name.range);
    scope.owner = fmt::format("atom type `{}`", decl.name.text);
    scope.drawing = &out;
  }

  enum class VariableKind : std::uint8_t { Data, ExportedData, Parameter };
  void add_variable(const syntax::Name& name, Type type, VariableKind kind) {
    const bool is_param = kind == VariableKind::Parameter;
    const std::uint32_t row = static_cast<std::uint32_t>(out.variables.size());
    out.variables.push_back(
        {std::string(name.text), type, is_param, kind == VariableKind::ExportedData, b.loc(name.range)});
    variables[std::string(name.text)] = row;
    scope.names[std::string(name.text)] = {.load = Op::LoadSelf,
                                           .index = row,
                                           .type = type,
                                           .read_only = is_param ? "a parameter keeps its value" : "",
                                           .value = {},
                                           .declared = name.range};
  }

  // C++ may change a variable that it is given without `const`, whatever prototype of the name is meant in the end.
  void note_given(const syntax::Expr& e) {
    if (e.kind == syntax::ExprKind::Call) {
      const std::string name = path_key(e.path, *b.model.sources);
      for (const syntax::Decl* prototype : visible_prototypes(b.model, name, e.path.range.file)) {
        for (std::size_t k = 0; k < e.operands.size() && prototype->params.size() == e.operands.size(); ++k) {
          const syntax::Expr& operand = *e.operands[k];
          if (operand.kind != syntax::ExprKind::Path || operand.path.parts.size() != 1) continue;
          const std::string argument(operand.path.parts[0].name.text);
          if (takes_reference(prototype->params[k].type, argument))
            changed.try_emplace(argument, Change{operand.range, name});
        }
      }
    }
    for (const syntax::Expr* operand : e.operands) note_given(*operand);
  }
  // Numbers of the parameter's own type are given by reference; what is converted, and the rest, as a copy.
  [[nodiscard]] bool takes_reference(const syntax::TypeRef& given, const std::string& param) const {
    const auto own = std::find_if(decl.params.begin(), decl.params.end(),
                                  [&](const syntax::Param& p) { return p.name.text == param; });
    if (own == decl.params.end() || given.is_const) return false;
    Diagnostics quiet;
    const std::optional<Type> type = native_type(own->type, quiet);
    return (type == Type::Int || type == Type::Float) && native_type(given, quiet) == type;
  }
  void note_changed(std::span<const syntax::Stmt* const> stmts) {
    for (const syntax::Stmt* s : stmts) {
      if (const syntax::Path* target = syntax::assigned_path(*s); target != nullptr && target->parts.size() == 1)
        changed.try_emplace(std::string(target->parts[0].name.text), Change{target->range, {}});
      if (s->value != nullptr) note_given(*s->value);
      note_changed(s->then_body);
      note_changed(s->else_body);
    }
  }
  // An action may change a parameter without `const`: then it is data, which begins with what a hidden parameter gives.
  [[nodiscard]] bool is_data(const syntax::Param& p) const {
    return !p.type.is_const && changed.contains(std::string(p.name.text));
  }
  void add_assigned_parameters() {
    std::uint32_t row = 0;
    for (const syntax::Param& p : decl.params) {
      const std::uint32_t given = row++;
      if (!is_data(p)) continue;
      add_variable(p.name, out.variables[given].type, VariableKind::Data);
      inits.push_back({variables[std::string(p.name.text)], nullptr, given, b.loc(p.name.range)});
      const Change& change = changed.at(std::string(p.name.text));
      auto d = b.diags.report(Diag::kB1053, change.range, p.name.text);
      d.label(p.name.range, "declared here");
      if (!change.by.empty())
        d.note(fmt::format("`{}` may change what it is given", change.by))
            .help("declare that parameter of the function `const` if it only reads it");
      d.help("write data that begins with it: `data … = " + std::string(p.name.text) + "`");
    }
  }

  void build_interactions() {
    note_changed(decl.initial.action.stmts);
    for (const syntax::Transition& t : decl.transitions) note_changed(t.action.stmts);
    for (const syntax::Param& p : decl.params) {
      names.declare(p.name, "parameter");
      if (is_data(p)) {
        const Type type = native_data_type(b.model, p.type, "a parameter of a component", b.diags);
        out.variables.push_back({fmt::format("given {}", p.name.text), type, true, false, b.loc(p.name.range)});
        continue;
      }
      add_variable(p.name, native_data_type(b.model, p.type, "a parameter of a component", b.diags),
                   VariableKind::Parameter);
      scope.names[std::string(p.name.text)].is_constant = p.type.is_const;
    }
    const auto given = b.initialised_data.find(out.name);
    std::unordered_map<std::string, std::uint32_t> hidden;
    if (given != b.initialised_data.end()) {
      for (const syntax::DataDecl& d : decl.data) {
        for (const syntax::Var& v : d.vars) {
          if (!given->second.contains(std::string(v.name.text))) continue;
          Diagnostics quiet;
          hidden[std::string(v.name.text)] = static_cast<std::uint32_t>(out.variables.size());
          out.variables.push_back({fmt::format("initial {}", v.name.text),
                                   native_type(d.type, quiet).value_or(Type::Int), true, false, b.loc(v.name.range)});
        }
      }
    }
    for (const syntax::DataDecl& d : decl.data) {
      const Type type = data_type(b.model, d.type, b.diags);
      for (const syntax::Var& v : d.vars) {
        names.declare(v.name, "data");
        add_variable(v.name, type, d.exported ? VariableKind::ExportedData : VariableKind::Data);
        if (d.type.is_const) constants[std::string(v.name.text)] = v.name.range;
        const auto h = hidden.find(std::string(v.name.text));
        const std::uint32_t param = h == hidden.end() ? Id<void>::kNone : h->second;
        if (v.init != nullptr || h != hidden.end())
          inits.push_back({variables[std::string(v.name.text)], v.init, param, b.loc(v.name.range)});
      }
    }
    add_assigned_parameters();
  }

  void build_port(const syntax::PortDecl& d, const syntax::PortItem& item) {
    names.declare(item.name, "port");
    Port port{.name = std::string(item.name.text),
              .type = {},
              .variables = {},
              .exported = d.role == syntax::PortRole::Exported,
              .loc = b.loc(item.name.range)};
    std::vector<Variable> shown;
    bool sound = true;
    for (const syntax::Name& var : item.vars) {
      for (const syntax::Name* other = item.vars.data(); other != &var; ++other) {
        if (other->text == var.text)
          b.diags.report(Diag::kB2031, var.range, port.name, var.text).label(other->range, "here first");
      }
      const auto variable = variables.find(std::string(var.text));
      if (variable == variables.end()) {
        std::vector<std::string> known;
        for (const DataVariable& s : out.variables) known.push_back(s.name);
        const auto clock = std::find_if(decl.clocks.begin(), decl.clocks.end(), [&](const syntax::ClockDecl& c) {
          return std::any_of(c.names.begin(), c.names.end(), [&](const syntax::Name& n) { return n.text == var.text; });
        });
        if (clock != decl.clocks.end())
          b.diags.report(Diag::kB1610, var.range, port.name, var.text).label(clock->range, "declared here");
        else help_data(b.diags.report(Diag::kB2001, var.range, port.name, var.text, scope.owner), var, known);
        port.variables.push_back(0);
        sound = false;
        shown.push_back({std::string(var.text), Type::Int, {}});
        continue;
      }
      const DataVariable& s = out.variables[variable->second];
      if (s.is_param)
        b.diags.report(Diag::kB2002, var.range, port.name, var.text)
            .help("copy the parameter into data, and show these");
      port.variables.push_back(variable->second);
      shown.push_back({s.name, s.type, s.loc});
    }
    if (!d.type.is_written()) {
      port.type = b.anonymous_port_type(shown);
    } else {
      port.type = b.port_type(d.type);
      if (port.type.is_valid() && sound) check_variables(port, shown, item, d.type);
    }
    ports[port.name] = static_cast<std::uint32_t>(out.ports.size());
    BIP_ASSERT(port.variables.size() == shown.size(), "port `{}` shows {} variables, {} are named", port.name,
               port.variables.size(), shown.size());
    out.ports.push_back(std::move(port));
  }

  static void help_data(DiagnosticBuilder d, const syntax::Name& var, const std::vector<std::string>& known) {
    help_similar(d, var.text, var.range, known);
    std::string list;
    for (const std::string& name : known) list += (list.empty() ? "`" : ", `") + name + "`";
    if (!list.empty() && known.size() <= 8 && similar_names(var.text, known).empty()) d.note("its data: " + list);
  }

  // The atom's data whose types fit, in their order.
  void help_variables(DiagnosticBuilder d, const PortType& wanted, const syntax::PortItem& item) {
    std::string list;
    std::size_t next = 0;
    for (const Variable& variable : wanted.variables) {
      while (next < out.variables.size() && (out.variables[next].is_param || out.variables[next].type != variable.type))
        ++next;
      if (next == out.variables.size()) return;
      list += (list.empty() ? "" : ", ") + out.variables[next++].name;
    }
    const std::string_view text = b.model.sources->text(item.name.range.file);
    std::uint32_t end = item.name.range.end;
    if (item.has_vars) end = static_cast<std::uint32_t>(std::min(text.find(')', end), text.size() - 1) + 1);
    d.help(fmt::format("name the data that it shows, such as `{}({})`", item.name.text, list),
           {item.name.range.file, item.name.range.end, end}, "(" + list + ")");
  }

  void check_variables(const Port& port, const std::vector<Variable>& given, const syntax::PortItem& item,
                       const syntax::TypeRef& type) {
    const PortType& wanted = b.model.port_types[port.type];
    for (std::size_t i = 0; i < std::min(given.size(), wanted.variables.size()); ++i) {
      const auto constant = constants.find(given[i].name);
      if (constant == constants.end() || wanted.variables[i].is_const) continue;
      b.diags
          .report(Diag::kB2030, item.vars[i].range, port.name, given[i].name, wanted.variables[i].name,
                  b.text(type.name))
          .label(constant->second, "declared here")
          .help(fmt::format("declare `const` what the port shows: `port type {}(const …)`", b.text(type.name)));
    }
    if (wanted.variables.size() != given.size()) {
      auto d = b.diags
                   .report(Diag::kB2003, item.name.range, port.name, counted(given.size(), "variable"), wanted.name,
                           wanted.variables.size())
                   .label(b.declared(wanted.name), "declared here");
      help_variables(d, wanted, item);
      return;
    }
    for (std::size_t i = 0; i < given.size(); ++i) {
      if (given[i].type == wanted.variables[i].type) continue;
      b.diags
          .report(Diag::kB2004, item.vars[i].range, given[i].name, b.model.code.type_name(given[i].type),
                  wanted.variables[i].name, b.text(type.name), b.model.code.type_name(wanted.variables[i].type))
          .label(b.declared(wanted.name), "declared here");
    }
  }

  void build_ports() {
    NameSpace exported(b.diags, fmt::format("the exports of atom type `{}`", decl.name.text));
    for (const syntax::PortDecl& d : decl.ports) {
      const bool merged = !d.merged_as.text.empty() && d.items.size() > 1;
      const std::size_t first = out.ports.size();
      for (const syntax::PortItem& item : d.items) {
        build_port(d, item);
        if (d.role == syntax::PortRole::External && !out.ports.empty()) declare_event(d, out.ports.back());
        if (d.role != syntax::PortRole::Exported || merged) continue;
        exported.declare(d.merged_as.text.empty() ? item.name : d.merged_as, "port");
        // What connectors see is the exported name; transitions still use the port's own.
        if (!d.merged_as.text.empty() && !out.ports.empty()) out.ports.back().name = std::string(d.merged_as.text);
      }
      if (merged) merge_ports(d, first, exported);
    }
    for (const syntax::ClockDecl& c : decl.clocks) {
      for (const syntax::Name& name : c.names) {
        if (names.declare(name, "clock")) time.add_clock(name, c.unit);
      }
    }
  }

  void declare_event(const syntax::PortDecl& d, Port& port) {
    port.external = true;
    port.event_class = std::string(d.extern_class);
    if (d.extern_policy.text == "ignore") port.policy = EventPolicy::Ignore;
    if (d.extern_policy.text == "error") port.policy = EventPolicy::Error;
    if (!is_class_name(d.extern_class)) b.diags.report(Diag::kB1613, d.range, port.name, d.extern_class);
  }

  // `Class` or `space::Class`; empty: none is given.
  static bool is_class_name(std::string_view name) {
    bool may_begin = false;
    for (std::size_t i = 0; i < name.size(); ++i) {
      const char c = name[i];
      const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
      if (c == ':' && may_begin && i + 2 < name.size() && name[i + 1] == ':') ++i, may_begin = false;
      else if (is_letter || (may_begin && c >= '0' && c <= '9')) may_begin = true;
      else return false;
    }
    return name.empty() || may_begin;
  }

  // The ports of the declaration, from row `first` on, are one to the connectors that bind them.
  void merge_ports(const syntax::PortDecl& d, std::size_t first, NameSpace& exported) {
    exported.declare(d.merged_as, "port");
    MergedPort row{.name = std::string(d.merged_as.text),
                   .type = out.ports[first].type,
                   .ports = {},
                   .loc = b.loc(d.merged_as.range)};
    for (std::size_t p = first; p < out.ports.size(); ++p) {
      BIP_ASSERT(p - first < d.items.size(), "port {} is none of the declaration's {}", p - first, d.items.size());
      row.ports.push_back(static_cast<std::uint32_t>(p));
      const PortTypeId type = out.ports[p].type;
      if (!type.is_valid() || !row.type.is_valid() || fits(b.model, type, row.type)) continue;
      b.diags
          .report(Diag::kB2027, d.items[p - first].name.range, out.ports[p].name, port_type_text(b.model, type),
                  out.ports[first].name, port_type_text(b.model, row.type))
          .label(d.items[0].name.range, "merged with this one");
    }
    out.merged.push_back(std::move(row));
  }

  std::optional<std::uint32_t> rule_side(const syntax::Name& side) {
    if (side.text == "*") return AtomPriority::kAnyPort;
    const auto port = ports.find(std::string(side.text));
    if (port != ports.end()) return port->second;
    std::vector<std::string> known;
    for (const auto& [name, row] : ports) known.push_back(name);
    help_similar(b.diags.report(Diag::kB1022, side.range, side.text, scope.owner), side.text, side.range, known);
    return std::nullopt;
  }

  void build_rules() {
    CodeBuilder code(b.model, b.diags, scope);
    for (const syntax::AtomPriority& p : decl.atom_priorities) {
      names.declare(p.name, "priority");
      const std::optional<std::uint32_t> low = rule_side(p.low);
      const std::optional<std::uint32_t> high = rule_side(p.high);
      AtomPriority row{.name = std::string(p.name.text),
                       .low = low.value_or(0),
                       .high = high.value_or(0),
                       .guard = code.guard(p.guard),
                       .loc = b.loc(p.range)};
      if (!low || !high) continue;
      if (row.low != row.high) {
        for (const AtomPriority& other : out.priorities) {
          if (other.low != row.low || other.high != row.high || other.guard.is_valid()) continue;
          b.diags.report(Diag::kB3013, p.name.range, p.name.text, other.name);
          break;
        }
        out.priorities.push_back(std::move(row));
      } else if (row.low == AtomPriority::kAnyPort) {
        b.diags.report(Diag::kB3011, p.high.range, p.name.text)
            .label(p.low.range, "and here")
            .help("name the port of one side");
      } else {
        b.diags.report(Diag::kB3012, p.high.range, p.name.text, p.high.text).label(p.low.range, "the same port");
      }
    }
    for (const syntax::Invariant& i : decl.invariants) {
      names.declare(i.name, "invariant");
      TimedCondition parts = time.condition(i.expr, "an invariant");
      Invariant row{.name = std::string(i.name.text),
                    .scope = static_cast<InvariantScope>(i.scope),
                    .places = place_rows(i.places),
                    .condition = parts.data,
                    .loc = b.loc(i.range),
                    .when = std::move(parts.when)};
      BIP_ASSERT(row.places.size() <= out.places.size(), "an invariant names {} of {} places", row.places.size(),
                 out.places.size());
      std::sort(row.places.begin(), row.places.end());
      out.invariants.push_back(std::move(row));
    }
  }

  void build_finals() {
    std::vector<syntax::Name> all;
    for (const syntax::FinalPlaces& f : decl.finals) all.insert(all.end(), f.places.begin(), f.places.end());
    out.final_places = place_rows(all);
    std::sort(out.final_places.begin(), out.final_places.end());
  }

  std::vector<std::uint32_t> place_rows(std::span<const syntax::Name> list) {
    std::vector<std::uint32_t> rows;
    for (const syntax::Name& name : list) {
      const auto it = places.find(std::string(name.text));
      if (it == places.end()) {
        help_similar(b.diags.report(Diag::kB1020, name.range, name.text, scope.owner), name.text, name.range,
                     out.places);
      } else if (std::find(rows.begin(), rows.end(), it->second) != rows.end()) {
        b.diags.report(Diag::kB1021, name.range, name.text);
      } else {
        rows.push_back(it->second);
      }
    }
    return rows;
  }

  void build_transition(const syntax::Transition& t) {
    Transition row{.port = Transition::kInternal,
                   .from = place_rows(t.from),
                   .to = place_rows(t.to),
                   .guard = {},
                   .action = {},
                   .loc = b.loc(t.range)};
    if (!t.internal) {
      const auto port = ports.find(std::string(t.port.text));
      if (port == ports.end()) {
        std::vector<std::string> known;
        for (const Port& p : out.ports) known.push_back(p.name);
        help_similar(b.diags.report(Diag::kB1022, t.port.range, t.port.text, scope.owner), t.port.text, t.port.range,
                     known);
      } else {
        row.port = port->second;
      }
    }
    row.urgency = t.urgency.text == "eager"       ? Urgency::Eager
                  : t.urgency.text == "delayable" ? Urgency::Delayable
                                                  : Urgency::Lazy;
    if (t.internal) check_internal(t);
    CodeBuilder code(b.model, b.diags, scope);
    TimedCondition parts = time.condition(t.guard, "the guard");
    row.guard = parts.data;
    if (row.guard.is_valid()) CodeBuilder(b.model, b.diags, scope).warn_never_true(t.guard, row.guard);
    row.when = std::move(parts.when);
    row.action = code.block(t.action.stmts);
    row.resume = time.resume(t.resumes, t.resume, t.range);
    row.async = build_async(b, t, out);
    row.weight = build_weight(b, t, out);
    out.transitions.push_back(std::move(row));
  }

  // Those of a C++ type begin as their class says.
  void check_constants() {
    std::vector<bool> written(out.variables.size());
    mark_writes(b.model.code, out.initial_action, Op::LoadSelf, written);
    for (const syntax::DataDecl& d : decl.data) {
      for (const syntax::Var& v : d.vars) {
        const std::uint32_t row = variables.at(std::string(v.name.text));
        if (!d.type.is_const || written[row] || is_ffi(out.variables[row].type)) continue;
        b.diags.report(Diag::kB1008, v.name.range, v.name.text)
            .help("write `= …` behind it, or assign it in `initial`");
      }
    }
  }

  // Internal transitions run at once, before anyone looks.
  void check_internal(const syntax::Transition& t) {
    if (const syntax::Expr* clock = time.clock_in(t.guard)) {
      b.diags.report(Diag::kB1611, clock->range, clock->path.parts[0].name.text)
          .help("label the transition with a port that is not exported, and make it `eager`");
    }
    if (!t.urgency.text.empty()) b.diags.report(Diag::kB1612, t.urgency.range, "urgency", t.urgency.text);
    if (t.resumes) b.diags.report(Diag::kB1612, t.range, "a", "resume");
  }

  AtomType build() {
    build_interactions();
    build_ports();
    for (const syntax::Name& place : decl.places) {
      names.declare(place, "place");
      if (places.try_emplace(std::string(place.text), static_cast<std::uint32_t>(out.places.size())).second)
        out.places.emplace_back(place.text);
    }
    out.initial = place_rows(decl.initial.to);
    build_finals();
    out.initial_resume = time.resume(decl.initial.resumes, decl.initial.resume, decl.initial.range);
    CodeBuilder code(b.model, b.diags, scope);
    StmtId next = code.block(decl.initial.action.stmts);
    for (std::size_t i = inits.size(); i-- > 0;) {
      const Init& init = inits[i];
      const Type type = out.variables[init.variable].type;
      ExprId value;
      if (init.param != Id<void>::kNone) {
        BIP_ASSERT(init.param < out.variables.size() && out.variables[init.param].type == type,
                   "variable {} gets parameter {}", init.variable, init.param);
        value = b.model.code.exprs.push(
            {.op = Op::LoadSelf, .type = type, .index = init.param, .a = {}, .b = {}, .loc = init.loc});
      } else {
        value = code.initial_value(init.value, type, fmt::format("`{}`", out.variables[init.variable].name));
      }
      next = code.store_self(init.variable, type, value, init.loc, next);
    }
    out.initial_action = next;
    check_constants();
    for (const auto& [name, range] : constants) {
      scope.names[name].read_only = "`const` data keep the value that `initial` gives";
      scope.names[name].is_constant = true;
    }
    for (const syntax::Transition& t : decl.transitions) build_transition(t);
    build_rules();
    BIP_ASSERT(b.diags.has_errors() || out.transitions.size() == decl.transitions.size(), "{} of {} transitions",
               out.transitions.size(), decl.transitions.size());
    return std::move(out);
  }
};

}  // namespace

void build_atom_types(ModelBuilder& b) {
  for (const syntax::Decl* decl : b.model.decls) {
    if (decl->kind != syntax::DeclKind::AtomType) continue;
    AtomType atom = AtomBuilder(b, *decl).build();
    check_atom(b, atom, *decl);
    b.model.atom_types.push(std::move(atom));
  }
}

}  // namespace bip::model
