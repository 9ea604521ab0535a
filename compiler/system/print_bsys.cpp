// The System as .bsys text: one row a line, in table order. Grammar and an example: compiler/docs/bsys.md.
//
// Needs a System that `validate` accepts. Linear in the output, iterative, deterministic. What is written is all that
// a System means: rows of code that nothing refers to, and places of expressions that cannot fault, are left out.
#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "compiler/system/bsys.hpp"
#include "compiler/system/print_bsys_code.hpp"

namespace bip::system {
namespace {

using namespace text;

class BsysPrinter {
 public:
  explicit BsysPrinter(const System& system) : system_(system) {}

  std::string run() {
    out_ = "(bsys 1)\n";
    for (std::size_t k = 0; k < system_.files.size(); ++k) quoted_row("(file", k, system_.files[k]);
    for (std::size_t k = 0; k < system_.code.strings.size(); ++k) quoted_row("(string", k, system_.code.strings[k]);
    for (const auto& [head, files] : {std::pair("(cpp include ", &system_.code.cpp.includes),
                                      {"(cpp source ", &system_.code.cpp.sources},
                                      {"(cpp object ", &system_.code.cpp.objects}})
      for (const CppFile& file : *files) cpp_file(head, file);
    for (std::size_t k = 0; k < system_.code.ffi_types.size(); ++k) ffi_type_row(system_.code.ffi_types[k], k);
    for (std::size_t k = 0; k < system_.code.functions.size(); ++k) function(system_.code.functions[k], k);
    each(system_.port_types, [this](const PortType& row, std::size_t k) { port_type(row, k); });
    each(system_.atom_types, [this](const AtomType& row, std::size_t k) { atom_type(row, k); });
    each(system_.connector_types, [this](const ConnectorType& row, std::size_t k) { connector_type(row, k); });
    each(system_.compounds, [this](const Compound& row, std::size_t k) { compound(row, k); });
    each(system_.atoms, [this](const Atom& row, std::size_t k) { atom(row, k); });
    each(system_.choices, [this](const Choice& row, std::size_t k) { choice(row, k); });
    each(system_.connectors, [this](const Connector& row, std::size_t k) { connector(row, k); });
    each(system_.priorities, [this](const Priority& row, std::size_t k) { priority(row, k); });
    return std::move(out_);
  }

 private:
  template <class Rows, class F>
  void each(const Rows& rows, F f) {
    std::size_t k = 0;
    for (const auto& row : rows) f(row, k++);
  }
  /// "(head 3 "
  void begin(const char* head, std::size_t k) {
    out_ += head;
    out_ += ' ';
    put_number(out_, k);
    out_ += ' ';
  }
  void quoted_row(const char* head, std::size_t k, const std::string& text) {
    begin(head, k);
    put_quoted(out_, text);
    out_ += ")\n";
  }
  /// "(head 3 name"
  void open(const char* head, std::size_t k, const std::string& name) {
    begin(head, k);
    put_name(out_, name);
  }
  void close(const Loc& loc, const char* end = ")\n") {
    put_loc(out_, loc);
    out_ += end;
  }
  void ref(std::uint32_t row, const std::string& name) {
    out_ += ' ';
    put_ref(out_, row, name);
  }
  /// " (head 0:a 1:b)" from rows of `names`, which has a member `name` or is a string.
  template <class Rows>
  void refs(const char* head, const std::vector<std::uint32_t>& rows, const Rows& names) {
    if (rows.empty()) return;
    out_ += head;
    for (const std::uint32_t row : rows) {
      if constexpr (requires { names[row].name; }) {
        ref(row, names[row].name);
      } else {
        ref(row, names[row]);
      }
    }
    out_ += ')';
  }
  void guard(ExprId expr, const CodeScope& scope) {
    if (!expr.is_valid()) return;
    out_ += " (guard ";
    put_expr(out_, system_.code, expr, scope);
    out_ += ')';
  }
  void body(const char* head, StmtId first, const CodeScope& scope) {
    if (!first.is_valid()) return;
    out_ += head;
    put_stmts(out_, system_.code, first, scope);
    out_ += ')';
  }
  /// A native type's word; of an FFI type number:name.
  [[nodiscard]] std::string type_text(Type type) const {
    if (!is_ffi(type)) return word_of(type);
    std::string text;
    put_ref(text, static_cast<std::uint32_t>(ffi_row(type)), system_.code.type_name(type));
    return text;
  }
  void cpp_file(const char* head, const CppFile& file) {
    out_ += head;
    put_quoted(out_, file.folder);
    out_ += ' ';
    put_quoted(out_, file.name);
    out_ += ")\n";
  }
  void ffi_type_row(const FfiType& row, std::size_t k) {
    open("(extern-type", k, row.name);
    out_ += ' ';
    put_quoted(out_, row.cpp);
    close(row.loc);
  }
  void function(const Function& row, std::size_t k) {
    open("(function", k, row.name);
    out_ += row.kind == FunctionKind::Cast       ? " cast"
            : row.kind == FunctionKind::Operator ? " operator"
            : row.kind == FunctionKind::Draw     ? " draw"
                                                 : "";
    if (row.is_const) out_ += " const";
    if (row.has_result) fmt::format_to(std::back_inserter(out_), " (result {})", type_text(row.result));
    for (const FunctionParam& param : row.params)
      fmt::format_to(std::back_inserter(out_), " ({} {})", param.by_reference ? "ref" : "value", type_text(param.type));
    close(row.loc);
  }
  void variables(const std::vector<DataVariable>& variables) {
    for (std::size_t k = 0; k < variables.size(); ++k) {
      open("  (slot", k, variables[k].name);
      fmt::format_to(std::back_inserter(out_), " {}", type_text(variables[k].type));
      if (variables[k].is_param) out_ += " param";
      if (variables[k].exported) out_ += " export";
      close(variables[k].loc);
    }
  }
  void parent(CompoundId id) {
    if (!id.is_valid()) return;
    out_ += " (in";
    ref(id.value, system_.compounds[id].path);
    out_ += ')';
  }
  void data(const std::vector<DataRef>& refs) {
    if (refs.empty()) return;
    out_ += " (data";
    for (const DataRef& r : refs) {
      out_ += " (of";
      ref(r.atom.value, system_.atoms[r.atom].path);
      ref(r.variable, system_.atom_types[system_.atoms[r.atom].type].variables[r.variable].name);
      out_ += ')';
    }
    out_ += ')';
  }

  void port_type(const PortType& row, std::size_t k) {
    open("(port-type", k, row.name);
    for (const Variable& v : row.variables) {
      out_ += " (var ";
      put_name(out_, v.name);
      fmt::format_to(std::back_inserter(out_), " {}", type_text(v.type));
      close(v.loc, ")");
    }
    close(row.loc);
  }

  void atom_type(const AtomType& row, std::size_t k) {
    const CodeScope scope = scope_of(row);
    open("(atom-type", k, row.name);
    close(row.loc, "\n");
    variables(row.variables);
    for (std::size_t p = 0; p < row.ports.size(); ++p) {
      const Port& port = row.ports[p];
      open("  (port", p, port.name);
      ref(port.type.value, system_.port_types[port.type].name);
      if (port.exported) out_ += " export";
      if (port.external) {
        fmt::format_to(std::back_inserter(out_), " (extern {} ", name_of(port.policy));
        put_quoted(out_, port.event_class);
        out_ += ')';
      }
      refs(" (slots", port.variables, row.variables);
      close(port.loc);
    }
    for (std::size_t p = 0; p < row.places.size(); ++p) {
      open("  (place", p, row.places[p]);
      out_ += ")\n";
    }
    for (std::size_t c = 0; c < row.clocks.size(); ++c) {
      open("  (clock", c, row.clocks[c].name);
      fmt::format_to(std::back_inserter(out_), " {}ns", row.clocks[c].unit);
      ref(row.clocks[c].variable, row.variables[row.clocks[c].variable].name);
      close(row.clocks[c].loc);
    }
    if (row.draws != AtomType::kNoDraws) {
      out_ += "  (draws";
      ref(row.draws, row.variables[row.draws].name);
      out_ += ")\n";
    }
    out_ += " ";
    refs(" (initial", row.initial, row.places);
    body(" (do", row.initial_action, scope);
    put_resume(out_, system_.code, row, row.initial_resume, scope);
    refs(" (final", row.final_places, row.places);
    out_ += '\n';
    for (std::size_t t = 0; t < row.transitions.size(); ++t) transition(row, t, scope);
    for (std::size_t p = 0; p < row.priorities.size(); ++p) atom_priority(row, p, scope);
    for (std::size_t i = 0; i < row.invariants.size(); ++i) invariant(row, i, scope);
    for (std::size_t m = 0; m < row.merged.size(); ++m) merged(row, m);
    out_ += ")\n";
  }
  void atom_priority(const AtomType& type, std::size_t k, const CodeScope& scope) {
    const AtomPriority& row = type.priorities[k];
    const auto side = [&](const char* head, std::uint32_t port) {
      out_ += head;
      if (port == AtomPriority::kAnyPort) {
        out_ += " any";
      } else {
        ref(port, type.ports[port].name);
      }
      out_ += ')';
    };
    open("  (priority", k, row.name);
    side(" (low", row.low);
    side(" (high", row.high);
    guard(row.guard, scope);
    close(row.loc);
  }
  void invariant(const AtomType& type, std::size_t k, const CodeScope& scope) {
    const Invariant& row = type.invariants[k];
    open("  (invariant", k, row.name);
    out_ += ' ';
    out_ += word_of(row.scope);
    refs(" (places", row.places, type.places);
    guard(row.condition, scope);
    put_when(out_, system_.code, type, row.when, scope);
    close(row.loc);
  }
  void merged(const AtomType& type, std::size_t k) {
    const MergedPort& row = type.merged[k];
    open("  (merged", k, row.name);
    ref(row.type.value, system_.port_types[row.type].name);
    refs(" (ports", row.ports, type.ports);
    close(row.loc);
  }
  void transition(const AtomType& type, std::size_t k, const CodeScope& scope) {
    const Transition& row = type.transitions[k];
    fmt::format_to(std::back_inserter(out_), "  (transition {}", k);
    if (row.port != Transition::kInternal) {
      out_ += " (on";
      ref(row.port, type.ports[row.port].name);
      out_ += ')';
    }
    refs(" (from", row.from, type.places);
    refs(" (to", row.to, type.places);
    guard(row.guard, scope);
    put_when(out_, system_.code, type, row.when, scope);
    if (row.urgency != Urgency::Lazy) fmt::format_to(std::back_inserter(out_), " {}", name_of(row.urgency));
    if (row.async.present) {
      out_ += " (async";
      if (row.async.budget >= 0) fmt::format_to(std::back_inserter(out_), " {}ns", row.async.budget);
      if (row.async.overrun != Async::kNone) {
        out_ += " (overrun";
        ref(row.async.overrun, type.ports[row.async.overrun].name);
        out_ += ')';
      }
      out_ += ')';
    }
    body(" (do", row.action, scope);
    put_resume(out_, system_.code, type, row.resume, scope);
    if (row.weight.param != Weight::kNone) {
      out_ += " (weight (slot";
      ref(row.weight.param, type.variables[row.weight.param].name);
      out_ += "))";
    } else {
      weight(row.weight.value);
    }
    close(row.loc);
  }

  void connector_type(const ConnectorType& row, std::size_t k) {
    const CodeScope scope = scope_of(system_, row);
    open("(connector-type", k, row.name);
    close(row.loc, "\n");
    for (std::size_t p = 0; p < row.params.size(); ++p) {
      open("  (param", p, row.params[p].name);
      ref(row.params[p].type.value, system_.port_types[row.params[p].type].name);
      close(row.params[p].loc);
    }
    for (std::size_t r = 0; r < row.data_reads.size(); ++r) {
      open("  (read", r, row.data_reads[r].path);
      fmt::format_to(std::back_inserter(out_), " {})\n", type_text(row.data_reads[r].type));
    }
    variables(row.variables);
    define(row);
    if (row.resume == ResumeMode::Sync) out_ += "  (resume sync)\n";
    for (std::size_t c = 0; c < row.clauses.size(); ++c) {
      const Clause& clause = row.clauses[c];
      fmt::format_to(std::back_inserter(out_), "  (clause {}", c);
      refs(" (params", clause.params, row.params);
      guard(clause.guard, scope);
      body(" (up", clause.up, scope);
      body(" (down", clause.down, scope);
      close(clause.loc);
    }
    if (row.exports) {
      out_ += "  (export ";
      put_name(out_, row.export_name);
      ref(row.export_type.value, system_.port_types[row.export_type].name);
      refs(" (slots", row.export_variables, row.variables);
      out_ += ")\n";
    }
    out_ += ")\n";
  }
  /// Preorder rows, so one pass; `open_groups` holds how many children each open group still lacks.
  void define(const ConnectorType& type) {
    out_ += "  (define";
    std::vector<std::size_t> open_groups;
    for (const DefineNode& node : type.define) {
      out_ += node.trigger ? " (trigger" : " (synchron";
      if (!node.is_leaf) {
        open_groups.push_back(node.children.size());
        continue;
      }
      ref(node.param, type.params[node.param].name);
      out_ += ')';
      while (!open_groups.empty() && --open_groups.back() == 0) {
        open_groups.pop_back();
        out_ += ')';
      }
    }
    out_ += ")\n";
  }

  void compound(const Compound& row, std::size_t k) {
    open("(compound", k, row.path);
    out_ += ' ';
    put_name(out_, row.type);
    parent(row.parent);
    close(row.loc);
  }
  void atom(const Atom& row, std::size_t k) {
    open("(atom", k, row.path);
    ref(row.type.value, system_.atom_types[row.type].name);
    parent(row.parent);
    if (!row.args.empty()) {
      out_ += " (args";
      for (const Value& value : row.args) {
        out_ += ' ';
        put_literal(out_, value, system_.code);
      }
      out_ += ')';
    }
    close(row.loc);
  }
  /// Choices stand above the connectors that they name, so there the number stands alone.
  // Whether the reference to a connector tells its path.
  enum class PathOf : std::uint8_t { None, Connector };
  void binding(const PortRef& port, PathOf shown) {
    switch (port.kind) {
      case PortRef::Kind::Atom:
        out_ += " (atom";
        ref(port.atom.value, system_.atoms[port.atom].path);
        ref(port.port, system_.atom_types[system_.atoms[port.atom].type].ports[port.port].name);
        break;
      case PortRef::Kind::Connector:
        out_ += port.maximal_only ? " (maximal" : " (connector";
        ref(port.connector.value, shown == PathOf::Connector ? system_.connectors[port.connector].path : std::string());
        break;
      case PortRef::Kind::Choice:
        out_ += " (choice";
        ref(port.choice, system_.choices[port.choice].name);
        break;
    }
    out_ += ')';
  }
  void choice(const Choice& row, std::size_t k) {
    open("(choice", k, row.name);
    out_ += " (ports";
    for (const PortRef& port : row.ports) binding(port, PathOf::None);
    out_ += "))\n";
  }
  void connector(const Connector& row, std::size_t k) {
    open("(connector", k, row.path);
    ref(row.type.value, system_.connector_types[row.type].name);
    if (row.bound) out_ += " bound";
    parent(row.parent);
    out_ += " (ports";
    for (const PortRef& port : row.ports) binding(port, PathOf::Connector);
    out_ += ')';
    for (const ShownPort& shown : row.shown) {
      out_ += " (shown";
      ref(shown.param, system_.connector_types[row.type].params[shown.param].name);
      ref(shown.compound.value, system_.compounds[shown.compound].path);
      out_ += ' ';
      put_name(out_, shown.name);
      out_ += ')';
    }
    data(row.data);
    weight(row.weight);
    close(row.loc);
  }
  void weight(double value) {
    if (value == 1) return;
    out_ += " (weight ";
    put_literal(out_, {.type = Type::Float, .int_value = 0, .float_value = value}, system_.code);
    out_ += ')';
  }
  void pattern(const char* head, const Pattern& p) {
    out_ += head;
    if (!p.any_connector) {
      const Connector& connector = system_.connectors[p.connector];
      ref(p.connector.value, connector.path);
      if (!p.any_interaction)
        for (const std::uint32_t param : p.params)
          ref(param, system_.connector_types[connector.type].params[param].name);
    }
    out_ += p.any_connector || p.any_interaction ? " any)" : ")";
  }
  void priority(const Priority& row, std::size_t k) {
    open("(priority", k, row.name);
    parent(row.parent);
    pattern(" (low", row.low);
    pattern(" (high", row.high);
    data(row.data);
    if (row.guard.is_valid()) guard(row.guard, scope_of(system_, row));
    close(row.loc);
  }

  const System& system_;
  std::string out_;
};

}  // namespace

std::string print(const System& system) { return BsysPrinter(system).run(); }

}  // namespace bip::system
