// Connector bodies, typed and inline: own data, exported port, `define`, and one clause an interaction with its code.
#include <algorithm>

#include "compiler/model/ffi_declarations.hpp"
#include "compiler/syntax/code_paths.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

namespace {

// So many interactions without a clause get one.
constexpr std::size_t kMaxClausesOfInits = 4096;

struct BodyBuilder {
  ModelBuilder& b;
  const syntax::ConnectorBody& body;
  const ConnectorPorts& ports;
  ConnectorForm form;
  ConnectorType& out;
  Scope down_scope{}, up_scope{}, guard_scope{};
  std::unordered_map<std::string, std::uint32_t> variables{};
  std::size_t errors_before = 0;  // the pass
  // Data with an initial value, which it has whenever an interaction is evaluated.
  struct Init {
    std::uint32_t variable = 0;
    const syntax::Var* var = nullptr;
    ExprId value{};
  };
  std::vector<Init> inits{};
  bool has_errors_in_define = false;  // then what it gives is not known

  [[nodiscard]] bool has_errors() const { return b.diags.error_count() > errors_before; }

  void build_scopes() {
    NameSpace names(b.diags, down_scope.owner);
    for (const syntax::DataDecl& d : body.data) {
      const Type type = data_type(b.model, d.type, b.diags);
      for (const syntax::Var& v : d.vars) {
        if (ports.rows.contains(std::string(v.name.text))) {
          b.diags.report(Diag::kB1002, v.name.range, v.name.text, down_scope.owner).label("a port has this name");
        }
        names.declare(v.name, "data");
        const std::uint32_t row = static_cast<std::uint32_t>(out.variables.size());
        variables[std::string(v.name.text)] = row;
        down_scope.names[std::string(v.name.text)] = {.load = Op::LoadSelf,
                                                      .index = row,
                                                      .type = type,
                                                      .read_only = d.type.is_const ? "it is `const` data" : "",
                                                      .value = {},
                                                      .is_constant = d.type.is_const,
                                                      .declared = v.name.range};
        if (v.init != nullptr) inits.push_back({row, &v});
        else if (d.type.is_const && !is_ffi(type)) b.diags.report(Diag::kB1008, v.name.range, v.name.text);
        out.variables.push_back({std::string(v.name.text), type, false, d.exported, b.loc(v.name.range)});
      }
    }
    for (const auto& [key, rows] : ports.rows) {
      if (rows.size() != 1) continue;  // variables of t[*] have no single meaning
      const ConnectorParam& param = out.params[rows[0]];
      if (!param.type.is_valid()) continue;
      std::uint32_t bind = param.first_bind;
      for (const Variable& v : b.model.port_types[param.type].variables) {
        down_scope.names[key + "." + v.name] = {.load = Op::LoadBind,
                                                .index = bind++,
                                                .type = v.type,
                                                .read_only = v.is_const ? "its port type says `const`" : "",
                                                .value = {},
                                                .declared = {}};
      }
    }
    for (const auto& [key, binding] : ports.data) down_scope.names[key] = binding;
    build_inits();
    up_scope = down_scope;
    guard_scope = down_scope;
    // A guard is evaluated before `up`: it sees the values themselves.
    for (const Init& init : inits) {
      Binding& binding = guard_scope.names[out.variables[init.variable].name];
      binding.value = init.value;
      binding.is_fresh = false;
    }
    for (auto& [key, binding] : up_scope.names) {
      if (binding.load == Op::LoadBind && binding.read_only.empty())
        binding.read_only = "`up` writes only the connector's own data";
    }
  }

  // They are computed from constants and, in an inline connector, from the compound's parameters.
  void build_inits() {
    Scope scope;
    scope.owner = fmt::format("an initial value of {}", down_scope.owner);
    for (const auto& [name, binding] : ports.data) {
      if (binding.value.is_valid()) scope.names[name] = binding;
    }
    for (Init& init : inits) {
      CodeBuilder code(b.model, b.diags, scope);
      const DataVariable& variable = out.variables[init.variable];
      init.value = code.expr_as(init.var->init, variable.type, fmt::format("`{}`", variable.name));
      if (calls_cpp(b.model.code, init.value))
        b.diags.report(Diag::kB2021, init.var->init->range, variable.name).help("assign it in `up` or `down`");
    }
  }

  // Sets the data that have an initial value, then goes on with `code`.
  StmtId after_inits(StmtId code) {
    CodeBuilder builder(b.model, b.diags, down_scope);
    for (std::size_t i = inits.size(); i-- > 0;) {
      const DataVariable& variable = out.variables[inits[i].variable];
      const ExprId value = builder.copy(inits[i].value);
      code = builder.store_self(inits[i].variable, variable.type, value, variable.loc, code);
    }
    return code;
  }
  [[nodiscard]] bool exports_initial_values() const {
    return std::any_of(inits.begin(), inits.end(), [&](const Init& init) {
      return std::find(out.export_variables.begin(), out.export_variables.end(), init.variable) !=
             out.export_variables.end();
    });
  }

  void build_export(syntax::Annotations annotations) {
    const syntax::ConnectorExport& e = body.exported;
    if (!e.present) return;
    out.exports = true;
    out.export_name = std::string(e.name.text);
    std::vector<Variable> shown;
    for (const syntax::Name& var : e.vars) {
      const auto variable = variables.find(std::string(var.text));
      if (variable == variables.end()) {
        std::vector<std::string> known;
        for (const DataVariable& s : out.variables) known.push_back(s.name);
        help_similar(b.diags.report(Diag::kB2001, var.range, out.export_name, var.text, down_scope.owner), var.text,
                     var.range, known);
        continue;
      }
      out.export_variables.push_back(variable->second);
      shown.push_back({out.variables[variable->second].name, out.variables[variable->second].type, {}});
    }
    if (shown.size() != e.vars.size()) return;
    if (!e.type.is_written() ||
        (form == ConnectorForm::Inline && b.text(e.type.name) == "Port" && b.find_type(e.type.name) == nullptr)) {
      out.export_type = b.anonymous_port_type(shown);
      return;
    }
    out.export_type = b.port_type(e.type);
    if (!out.export_type.is_valid()) return;
    const PortType& wanted = b.model.port_types[out.export_type];
    if (wanted.variables.size() != shown.size()) {
      b.diags
          .report(Diag::kB2003, e.name.range, e.name.text, counted(shown.size(), "variable"), wanted.name,
                  wanted.variables.size())
          .label(b.declared(wanted.name), "declared here");
      return;
    }
    for (std::size_t i = 0; i < shown.size(); ++i) {
      if (shown[i].type == wanted.variables[i].type) continue;
      b.diags
          .report(Diag::kB2004, e.vars[i].range, shown[i].name, b.model.code.type_name(shown[i].type),
                  wanted.variables[i].name, wanted.name, b.model.code.type_name(wanted.variables[i].type))
          .label(b.declared(wanted.name), "declared here");
    }
    (void)annotations;
  }

  // ---- define --------------------------------------------------------------------------------------------------
  std::vector<SourceRange> seen{};  // by parameter: where `define` names it

  void add_leaf(const syntax::PortExpr& e, std::uint32_t parent) {
    const std::string key = b.text(e.port);
    const auto rows = ports.rows.find(key);
    if (rows == ports.rows.end()) {
      std::vector<std::string> known;
      for (const auto& [name, list] : ports.rows) known.push_back(name);
      help_similar(b.diags.report(Diag::kB2005, e.range, key, down_scope.owner), key, e.port.range, known);
      return;
    }
    for (const std::uint32_t param : rows->second) {
      if (seen[param].is_valid()) {
        b.diags.report(Diag::kB2006, e.range, key).label(seen[param], "here first").help("leave it out", e.range, "");
        return;
      }
      BIP_ASSERT(param < out.params.size() && parent < out.define.size(), "parameter {} below node {}", param, parent);
      seen[param] = e.range;
      out.define[parent].children.push_back(static_cast<std::uint32_t>(out.define.size()));
      out.define.push_back({.is_leaf = true, .trigger = e.trigger, .param = param, .children = {}});
    }
  }

  // `up` becomes `down`; the word stands before the block.
  void help_up(DiagnosticBuilder d, SourceRange block) {
    const std::string_view before = b.model.sources->text(block.file).substr(0, block.begin);
    const std::size_t end = before.find_last_not_of(" \t\n\r");
    if (end == std::string_view::npos || end == 0 || before.substr(end - 1, 2) != "up") return;
    const auto at = static_cast<std::uint32_t>(end);
    d.help("write `down`, or export a port", {block.file, at - 1, at + 1}, "down");
  }

  void add_node(const syntax::PortExpr& e, std::uint32_t parent) {
    if (e.kind == syntax::PortExprKind::Port) return add_leaf(e, parent);
    const auto row = static_cast<std::uint32_t>(out.define.size());
    out.define[parent].children.push_back(row);
    out.define.push_back({.is_leaf = false, .trigger = e.trigger, .param = 0, .children = {}});
    for (const syntax::PortExpr* child : e.children) add_node(*child, row);
  }

  void build_define() {
    seen.assign(out.params.size(), {});
    out.define.push_back({});
    if (body.define == nullptr) {
      for (std::uint32_t p = 0; p < out.params.size();
           ++p) {  // the paper: without a list, every subset; BIP2: reported by parse
        out.define[0].children.push_back(static_cast<std::uint32_t>(out.define.size()));
        out.define.push_back({.is_leaf = true, .trigger = true, .param = p, .children = {}});
      }
      return;
    }
    if (body.define->kind == syntax::PortExprKind::Port) {
      add_leaf(*body.define, 0);
    } else {
      for (const syntax::PortExpr* child : body.define->children) add_node(*child, 0);
    }
    if (has_errors()) return;
    for (std::size_t p = 0; p < seen.size(); ++p) {
      if (seen[p].is_valid()) continue;
      const SourceRange end{body.define->range.file, body.define->range.end, body.define->range.end};
      b.diags.report(Diag::kB2008, body.define->range, out.params[p].name)
          .help(fmt::format("add `{}`, or leave it out of the connector's ports", out.params[p].name), end,
                " " + out.params[p].name);
    }
    if (body.resume.text == "sync") out.resume = ResumeMode::Sync;
    if (!body.resume.text.empty() && out.exports)
      b.diags.report(Diag::kB1614, body.resume.range).label(body.exported.name.range, "exported here");
  }

  // ---- clauses -------------------------------------------------------------------------------------------------
  void build_clause(const syntax::Clause& c, std::unordered_map<std::string, SourceRange>& given) {
    Clause row{.params = {}, .guard = {}, .up = {}, .down = {}, .loc = b.loc(c.range)};
    for (const syntax::Path& path : c.ports) {
      const std::string key = b.text(path);
      const auto rows = ports.rows.find(key);
      if (rows == ports.rows.end()) {
        std::vector<std::string> known;
        for (const auto& [name, list] : ports.rows) known.push_back(name);
        help_similar(b.diags.report(Diag::kB2005, path.range, key, down_scope.owner), key, path.range, known);
        return;
      }
      for (const std::uint32_t p : rows->second) {
        if (std::find(row.params.begin(), row.params.end(), p) != row.params.end()) {
          b.diags.report(Diag::kB2009, path.range, key);
          return;
        }
        row.params.push_back(p);
      }
    }
    std::sort(row.params.begin(), row.params.end());
    const SourceRange at =
        c.ports.empty() ? c.range : SourceRange{c.range.file, c.ports.front().range.begin, c.ports.back().range.end};
    if (has_errors_in_define) return;
    BIP_ASSERT(std::adjacent_find(row.params.begin(), row.params.end()) == row.params.end(),
               "a clause names one of {} parameters twice", row.params.size());
    if (!is_interaction(out, row.params)) {
      auto d = b.diags.report(Diag::kB2010, at, interaction_text(out, row.params));
      if (body.define != nullptr) d.label(body.define->range, "the interactions are given here");
      const bool has_triggers = std::any_of(out.define[0].children.begin(), out.define[0].children.end(),
                                            [&](std::uint32_t child) { return out.define[child].trigger; });
      if (has_triggers) {
        d.help("an interaction holds at least one trigger, marked `'`");
      } else {
        std::string all;
        for (const ConnectorParam& param : out.params) all += (all.empty() ? "" : ", ") + param.name;
        d.help("without a trigger, marked `'`, all take part together", at, all);
      }
      return;
    }
    const auto [first, is_new] = given.try_emplace(interaction_text(out, row.params), at);
    if (!is_new) {
      b.diags.report(Diag::kB2011, at, interaction_text(out, row.params)).label(first->second, "here first");
      return;
    }
    if (c.up.present && !out.exports && c.up.stmts.empty()) b.diags.report(Diag::kB2038, c.up.range);
    else if (c.up.present && !out.exports) help_up(b.diags.report(Diag::kB2012, c.up.range), c.up.range);
    if (c.action.present && out.exports)
      b.diags.report(Diag::kB2013, c.action.range)
          .help("write `up { … }` for what the exported port shows, `down { … }` for the transfer");
    if (c.action.present && c.down.present)
      b.diags.report(Diag::kB2014, c.action.range).label(c.down.range, "`down` is here");
    CodeBuilder down(b.model, b.diags, down_scope);
    CodeBuilder up(b.model, b.diags, up_scope);
    up.set_const_calls();
    CodeBuilder guard(b.model, b.diags, guard_scope);
    guard.set_const_calls();
    row.guard = guard.guard(c.guard);
    if (out.exports) row.up = up.block(c.up.stmts);
    row.down = down.block(c.down.present ? c.down.stmts : c.action.stmts);
    // What exports no port has no `up`: no connector reads its data before `down`.
    if (out.exports) row.up = after_inits(row.up);
    else if (row.down.is_valid()) row.down = after_inits(row.down);
    check_participants(c, row.params, at);
    if (!out.export_variables.empty() && !c.up.present && !c.action.present && !exports_initial_values() &&
        !is_suppressed(c.annotations, "missingup")) {
      b.diags.report(Diag::kB2015, at, interaction_text(out, row.params), out.export_name);
    }
    out.clauses.push_back(std::move(row));
  }

  // Code of an interaction sees the variables of the ports that take part, no others: an atom that does not move keeps
  // its data, and a guard is about what would move.
  void check_participants(const syntax::Clause& c, const std::vector<std::uint32_t>& params, SourceRange at) {
    syntax::for_each_path(c, [&](const syntax::Path& path) {
      const auto found = down_scope.names.find(b.text(path));
      if (found == down_scope.names.end() || found->second.load != Op::LoadBind) return;
      const auto param = std::find_if(out.params.begin(), out.params.end(), [&](const ConnectorParam& p) {
        const std::size_t count = p.type.is_valid() ? b.model.port_types[p.type].variables.size() : 0;
        return found->second.index >= p.first_bind && found->second.index < p.first_bind + count;
      });
      // Exported data of a component, which inline connectors may read, belong to no port.
      if (param == out.params.end()) return;
      const auto row = static_cast<std::uint32_t>(param - out.params.begin());
      if (std::find(params.begin(), params.end(), row) != params.end()) return;
      b.diags.report(Diag::kB2037, path.range, b.text(path), param->name, interaction_text(out, params))
          .label(at, "only these take part")
          .help(fmt::format("write an `on` with `{}` for the interactions in which it takes part", param->name));
    });
  }

  // An interaction without a clause, found among the largest ones and those of one port; empty if there is none there.
  [[nodiscard]] std::string without_clause() const {
    std::vector<std::uint32_t> all(out.params.size());
    for (std::uint32_t p = 0; p < all.size(); ++p) all[p] = p;
    const auto is_missing = [&](const std::vector<std::uint32_t>& params) {
      return is_interaction(out, params) &&
             std::none_of(out.clauses.begin(), out.clauses.end(), [&](const Clause& c) { return c.params == params; });
    };
    if (is_missing(all)) return interaction_text(out, all);
    for (std::uint32_t p = 0; p < all.size(); ++p) {
      std::vector<std::uint32_t> rest = all;
      std::erase(rest, p);
      if (is_missing({p})) return interaction_text(out, {p});
      if (is_missing(rest)) return interaction_text(out, rest);
    }
    return {};
  }

  // An interaction without a clause shows the initial values, too.
  void add_clauses_of_inits(SourceRange range) {
    if (!out.exports || has_errors_in_define || b.diags.has_errors() || !exports_initial_values()) return;
    if (interaction_count(out) > kMaxClausesOfInits) {
      b.diags.report(Diag::kB4006, range, kMaxClausesOfInits,
                     "interactions of a connector whose data have initial values");
      return;
    }
    for (std::vector<std::uint32_t>& params : interactions_of(out)) {
      const bool has_clause =
          std::any_of(out.clauses.begin(), out.clauses.end(), [&](const Clause& c) { return c.params == params; });
      if (!has_clause)
        out.clauses.push_back(
            {.params = std::move(params), .guard = {}, .up = after_inits({}), .down = {}, .loc = b.loc(range)});
    }
  }

  void build(SourceRange range, syntax::Annotations annotations) {
    down_scope.owner = form == ConnectorForm::Inline ? fmt::format("connector `{}`", out.name)
                                                     : fmt::format("connector type `{}`", out.name);
    const std::size_t errors_at_start = b.diags.error_count();
    const auto is_silent = [&](const char* warning) {
      return is_suppressed(annotations, warning) || is_suppressed(body.exported.annotations, warning);
    };
    build_scopes();
    build_export(annotations);
    errors_before = b.diags.error_count();
    build_define();
    has_errors_in_define = has_errors();
    std::unordered_map<std::string, SourceRange> given;
    for (const syntax::Clause& c : body.clauses) build_clause(c, given);
    if (!b.diags.has_errors()) check_clauses(b, body, out, annotations);
    add_clauses_of_inits(range);
    if (out.exports && !out.export_variables.empty() && out.clauses.empty()) {
      if (b.diags.error_count() == errors_at_start && !is_silent("nointeraction") && !is_silent("missinginteraction")) {
        b.diags.report(Diag::kB2032, range, down_scope.owner, out.export_name)
            .help("write `on` with an `up` for each interaction");
      }
      return;
    }
    if (!out.export_variables.empty() && b.diags.error_count() == errors_at_start &&
        interaction_count(out) > static_cast<double>(out.clauses.size()) && !is_silent("missinginteraction")) {
      auto d = b.diags.report(Diag::kB2016, range, down_scope.owner, out.export_name);
      if (const std::string missing = without_clause(); !missing.empty())
        d.note(fmt::format("interaction `{}` has none", missing));
    }
  }
};

}  // namespace

void build_connector_body(ModelBuilder& b, const syntax::ConnectorBody& body, const ConnectorPorts& ports,
                          ConnectorForm form, SourceRange range, syntax::Annotations annotations, ConnectorType& out) {
  BIP_ASSERT(out.params.empty() && out.define.empty(), "connector type `{}` is built twice", out.name);
  out.params = ports.params;
  out.data_reads = ports.data_reads;
  BodyBuilder{b, body, ports, form, out}.build(range, annotations);
}

// How many variables the ports of the parameters have. For assertions.
[[maybe_unused]] static std::uint32_t bind_count_of(const Model& model, const ConnectorType& type) {
  std::size_t count = 0;
  for (const ConnectorParam& param : type.params) {
    if (param.type.is_valid()) count += model.port_types[param.type].variables.size();
  }
  return static_cast<std::uint32_t>(count);
}

void build_connector_types(ModelBuilder& b) {
  for (const syntax::Decl* decl : b.model.decls) {
    if (decl->kind != syntax::DeclKind::ConnectorType) continue;
    ConnectorType out{.name = b.key(*decl), .loc = b.loc(decl->name.range)};
    ConnectorPorts ports;
    NameSpace names(b.diags, fmt::format("connector type `{}`", decl->name.text));
    std::uint32_t bind = 0;
    for (const syntax::Param& p : decl->params) {
      names.declare(p.name, "port");
      const PortTypeId type = b.port_type(p.type);
      ports.rows[std::string(p.name.text)] = {static_cast<std::uint32_t>(ports.params.size())};
      ports.params.push_back({std::string(p.name.text), type, bind, b.loc(p.name.range)});
      if (type.is_valid()) bind += static_cast<std::uint32_t>(b.model.port_types[type].variables.size());
    }
    if (decl->connector != nullptr)
      build_connector_body(b, *decl->connector, ports, ConnectorForm::Type, decl->name.range, decl->annotations, out);
    BIP_ASSERT(b.diags.has_errors() || bind_count_of(b.model, out) == bind, "parameters bind {} variables", bind);
    b.model.connector_types.push(std::move(out));
  }
}

}  // namespace bip::model
