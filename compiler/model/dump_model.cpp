// The type model as text, for --emit=model and goldens: a line a row, code in prefix form.
#include <fmt/format.h>

#include <algorithm>

#include "compiler/model/model.hpp"
#include "compiler/model/statements.hpp"

namespace bip::model {

namespace {

struct Dumper {
  const Model& m;
  std::string out{};

  std::string expr(ExprId id) const {
    if (!id.is_valid()) return "true";
    const Expr& e = m.code.exprs[id];
    switch (e.op) {
      case Op::ConstInt: return fmt::format("{}", e.int_value);
      case Op::ConstBool: return e.int_value != 0 ? "true" : "false";
      case Op::ConstFloat: return fmt::format("{}", e.float_value);
      case Op::ConstString: return fmt::format("\"{}\"", m.code.strings[static_cast<std::size_t>(e.int_value)]);
      case Op::LoadSelf: return fmt::format("self{}", e.index);
      case Op::LoadBind: return fmt::format("bind{}", e.index);
      case Op::Call: {
        std::string text = fmt::format("(call {}", m.code.functions[e.index].name);
        for (const ExprId arg : m.code.args_of(e)) text += " " + expr(arg);
        return text + ")";
      }
        BIP_UNARY_OPS(BIP_OP_CASE)
        BIP_BINARY_OPS(BIP_OP_CASE)
        break;
    }
    if (!e.b.is_valid()) return fmt::format("({} {})", name_of(e.op), expr(e.a));
    return fmt::format("({} {} {})", name_of(e.op), expr(e.a), expr(e.b));
  }
  std::string stmts(StmtId id) const {
    std::string text;
    for (; id.is_valid(); id = m.code.stmts[id].next) {
      const Stmt& s = m.code.stmts[id];
      if (!text.empty()) text += "; ";
      const StmtInfo& info = info_of(s.op);
      const std::string value = info.before + expr(s.value);
      switch (info.shape) {
        case StmtShape::StoresSelf: text += fmt::format("self{} = {}", s.index, value); break;
        case StmtShape::StoresBind: text += fmt::format("bind{} = {}", s.index, value); break;
        case StmtShape::Chooses:
          text += fmt::format("{} {{{}}}", value, stmts(s.then_body));
          if (s.else_body.is_valid()) text += fmt::format(" else {{{}}}", stmts(s.else_body));
          break;
        case StmtShape::Evaluates: text += value; break;
      }
    }
    return text;
  }
  template <class... Args>
  void line(fmt::format_string<Args...> format, Args&&... args) {
    out += fmt::format(format, std::forward<Args>(args)...);
    out += '\n';
  }
  static std::string places(const AtomType& t, const std::vector<std::uint32_t>& rows) {
    std::string text;
    for (const std::uint32_t p : rows) text += (text.empty() ? "" : ", ") + t.places[p];
    return text;
  }
  std::string port_type(PortTypeId id) const { return id.is_valid() ? m.port_types[id].name : "-"; }

  std::string when(const AtomType& t, const TimeGuard& guard) const {
    std::string text;
    for (const Bound& b : guard.bounds) {
      text +=
          fmt::format(" when ({} {}{} {})", name_of(b.op), t.clocks[b.clock].name,
                      b.minus == Bound::kNone ? "" : " - " + t.clocks[b.minus].name,
                      b.variable == Bound::kNone ? fmt::format("{}ns", b.ticks) : fmt::format("self{}", b.variable));
    }
    if (guard.measure.is_valid()) text += fmt::format(" measured by {{{}}}", stmts(guard.measure));
    return text;
  }
  static std::string weight(const AtomType& t, const Weight& w) {
    if (w.is_one()) return "";
    return w.param == Weight::kNone ? fmt::format(" weight {}", w.value) : " weight " + t.variables[w.param].name;
  }
  static std::string async(const AtomType& t, const Async& a) {
    const std::string budget = a.budget < 0 ? "" : fmt::format(" budget {}ns", a.budget);
    return " async" + budget + (a.overrun == Async::kNone ? "" : " overrun " + t.ports[a.overrun].name);
  }
  std::string resume(const AtomType& t, const Resume& r) const {
    return r.present ? fmt::format(" resume {}{}", expr(r.guard), when(t, r.when)) : "";
  }
  void variables(const std::vector<DataVariable>& list) {
    for (std::size_t k = 0; k < list.size(); ++k) {
      const DataVariable& s = list[k];
      line("  self{} {} {}{}{}", k, name_of(s.type), s.name, s.is_param ? " (parameter)" : "",
           s.exported ? " (exported)" : "");
    }
  }
  void atom(const AtomType& t) {
    line("atom type {}", t.name);
    variables(t.variables);
    for (const Port& p : t.ports) {
      std::string vars;
      for (const std::uint32_t s : p.variables) vars += (vars.empty() ? "" : ", ") + t.variables[s].name;
      const std::string event = p.external ? fmt::format(" as \"{}\" {}", p.event_class, name_of(p.policy)) : "";
      line("  {}port {} {}({}){}",
           p.exported   ? "export "
           : p.external ? "extern "
                        : "",
           port_type(p.type), p.name, vars, event);
    }
    std::vector<std::uint32_t> all(t.places.size());
    for (std::uint32_t p = 0; p < all.size(); ++p) all[p] = p;
    line("  places {}", places(t, all));
    for (const Clock& c : t.clocks) line("  clock {} of {}ns", c.name, c.unit);
    line("  initial to {} do {{{}}}{}", places(t, t.initial), stmts(t.initial_action), resume(t, t.initial_resume));
    if (!t.final_places.empty()) line("  final {}", places(t, t.final_places));
    for (const Transition& x : t.transitions) {
      const std::string urgency = x.urgency == Urgency::Lazy ? "" : fmt::format(" {}", name_of(x.urgency));
      line("  on {} from {} to {} provided {}{}{} do {{{}}}{}",
           x.port == Transition::kInternal ? "(internal)" : t.ports[x.port].name, places(t, x.from), places(t, x.to),
           expr(x.guard), when(t, x.when), urgency, stmts(x.action),
           resume(t, x.resume) + (x.async.present ? async(t, x.async) : "") + weight(t, x.weight));
    }
    const auto side = [&](std::uint32_t p) { return p == AtomPriority::kAnyPort ? std::string("*") : t.ports[p].name; };
    for (const AtomPriority& p : t.priorities)
      line("  priority {} {} < {} provided {}", p.name, side(p.low), side(p.high), expr(p.guard));
    for (const Invariant& i : t.invariants) {
      static constexpr const char* kScopes[] = {"", " at ", " from "};
      line("  invariant {}{}{} provided {}{}", i.name, kScopes[static_cast<int>(i.scope)], places(t, i.places),
           expr(i.condition), when(t, i.when));
    }
    for (const MergedPort& merged : t.merged) {
      std::string parts;
      for (const std::uint32_t p : merged.ports) parts += (parts.empty() ? "" : ", ") + t.ports[p].name;
      line("  export {} as {}", parts, merged.name);
    }
  }
  std::string define(const ConnectorType& t, std::uint32_t n) const {
    const DefineNode& node = t.define[n];
    std::string text;
    if (node.is_leaf) {
      text = t.params[node.param].name;
    } else {
      for (const std::uint32_t child : node.children) text += (text.empty() ? "" : " ") + define(t, child);
      if (n != 0) text = "(" + text + ")";
    }
    return node.trigger ? text + "'" : text;
  }
  void connector(const ConnectorType& t) {
    line("connector type {}", t.name);
    for (const ConnectorParam& p : t.params) {
      const std::size_t n = p.type.is_valid() ? m.port_types[p.type].variables.size() : 0;
      if (n == 0) line("  port {} {}", port_type(p.type), p.name);
      else line("  port {} {} = bind{}..{}", port_type(p.type), p.name, p.first_bind, p.first_bind + n - 1);
    }
    for (const DataRead& d : t.data_reads) line("  reads {} {}", name_of(d.type), d.path);
    variables(t.variables);
    if (t.exports) line("  export port {} {}", port_type(t.export_type), t.export_name);
    if (!t.define.empty()) line("  define {}{}", define(t, 0), t.resume == ResumeMode::Sync ? " resume sync" : "");
    for (const Clause& c : t.clauses) {
      std::string ports;
      for (const std::uint32_t p : c.params) ports += (ports.empty() ? "" : " ") + t.params[p].name;
      line("  on {} provided {} up {{{}}} down {{{}}}", ports, expr(c.guard), stmts(c.up), stmts(c.down));
    }
  }
  void items(const CompoundType& t, const std::vector<CompoundItem>& list, const std::string& indent) {
    for (const CompoundItem& i : list) {
      const std::string index = i.index.is_valid() ? fmt::format("[{}]", expr(i.index)) : "";
      if (i.kind == ItemKind::For) {
        line("{}for self{} in {}..{}", indent, i.loop_variable, expr(i.low), expr(i.high));
        items(t, i.items, indent + "  ");
      } else if (i.kind == ItemKind::Priority) {
        line("{}priority {}{}", indent, t.priorities[i.family].name, index);
      } else if (i.kind == ItemKind::Property) {
        line("{}property {}{}", indent, i.syntax->name.text, index);
      } else if (i.kind == ItemKind::Component) {
        const ComponentFamily& f = t.components[i.family];
        std::string args;
        for (const ExprId a : i.args) args += (args.empty() ? "" : ", ") + expr(a);
        line("{}component {} {}{}({})", indent,
             f.is_compound ? m.compound_types[f.compound].name : m.atom_types[f.atom].name, f.name, index, args);
      } else {
        std::string ports;
        for (const PortPath& p : i.ports) ports += (ports.empty() ? "" : ", ") + std::string(m.sources->text(p.range));
        line("{}connector {} {}{}({})", indent, m.connector_types[i.type].name, t.connectors[i.family].name, index,
             ports);
      }
    }
  }
};

}  // namespace

std::string dump(const Model& model) {
  Dumper d{model};
  for (const PortType& t : model.port_types) {
    std::string vars;
    for (const Variable& v : t.variables)
      vars += fmt::format("{}{} {}", vars.empty() ? "" : ", ", name_of(v.type), v.name);
    d.line("port type {}({})", t.name, vars);
  }
  for (const AtomType& t : model.atom_types) d.atom(t);
  for (const ConnectorType& t : model.connector_types) d.connector(t);
  for (const CompoundType& t : model.compound_types) {
    d.line("compound type {}", t.name);
    d.variables(t.params);
    d.items(t, t.items, "  ");
    for (const PriorityRule& p : t.priorities)
      d.line("  priority {} {} < {} provided {}", p.name, model.sources->text(p.low.range),
             model.sources->text(p.high.range), d.expr(p.guard));
    for (const PortExport& e : t.exports) {
      std::string targets;
      for (const PortPath& p : e.targets)
        targets += (targets.empty() ? "" : ", ") + std::string(model.sources->text(p.range));
      d.line("  export port {} as {}", targets, e.name);
    }
    for (const DataExport& e : t.data_exports)
      d.line("  export data {} as {}", model.sources->text(e.target.range), e.name);
  }
  return std::move(d.out);
}

}  // namespace bip::model
