// See validate_model.hpp. One function per table.
#include "compiler/model/validate_model.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace bip::model {
namespace {

class ModelValidator {
 public:
  explicit ModelValidator(const Model& model) : model_(model) {}

  std::vector<std::string> run() {
    packages();
    code();
    for (const PortType& type : model_.port_types) {
      owner_ = &type.name;
      for (const Variable& v : type.variables) expect(is_type(v.type), "a variable has a type");
    }
    for (const AtomType& type : model_.atom_types) atom(type);
    for (const ConnectorType& type : model_.connector_types) connector(type);
    for (const CompoundType& type : model_.compound_types) compound(type);
    names();
    return std::move(broken_);
  }

 private:
  void expect(bool holds, const char* promise) {
    if (holds || broken_.size() >= kMaxBrokenPromises) return;
    broken_.push_back(owner_ == nullptr ? fmt::format("model: {}", promise)
                                        : fmt::format("model: `{}`: {}", *owner_, promise));
  }
  [[nodiscard]] bool is_type(Type type) const { return !is_ffi(type) || ffi_row(type) < model_.code.ffi_types.size(); }
  void optional_expr(ExprId id, const char* promise) {
    expect(!id.is_valid() || model_.code.exprs.contains(id), promise);
  }
  void optional_stmt(StmtId id, const char* promise) {
    expect(!id.is_valid() || model_.code.stmts.contains(id), promise);
  }
  void rows(const std::vector<std::uint32_t>& list, std::size_t count, const char* promise) {
    for (const std::uint32_t row : list) expect(row < count, promise);
  }

  void packages() {
    expect(!model_.packages.empty(), "there is a package");
    for (std::uint32_t row = 0; row < model_.packages.size(); ++row) {
      for (const std::uint32_t used : model_.packages[row].uses) expect(used < row, "a package follows those it uses");
    }
    for (const syntax::Decl* decl : model_.decls) expect(decl != nullptr, "a declaration is there");
  }

  void code() {
    const CodeTable& code = model_.code;
    for (const Expr& e : code.exprs) {
      expect(is_type(e.type), "an expression has a type");
      optional_expr(e.a, "an operand is a row");
      optional_expr(e.b, "an operand is a row");
      if (e.op == Op::Call) {
        const bool is_row = e.index < code.functions.size();
        expect(is_row, "a call has a function");
        expect(!is_row ||
                   static_cast<std::size_t>(e.int_value) + code.functions[e.index].params.size() <= code.args.size(),
               "a call has its arguments");
      }
      if (e.op == Op::ConstString)
        expect(static_cast<std::size_t>(e.int_value) < code.strings.size(), "a string constant is a row");
    }
    for (const Stmt& s : code.stmts) {
      expect(code.exprs.contains(s.value), "a statement has an expression");
      optional_stmt(s.then_body, "a body is a row");
      optional_stmt(s.else_body, "a body is a row");
      optional_stmt(s.next, "the next statement is a row");
    }
    for (const ExprId arg : code.args) expect(code.exprs.contains(arg), "an argument is a row");
    for (const FfiType& type : code.ffi_types) {
      for (const Type base : type.refines) expect(is_type(base), "a refined type is a row");
    }
    expect(model_.code_shapes.size() <= code.exprs.size(), "a shape belongs to an expression");
  }

  void atom(const AtomType& type) {
    owner_ = &type.name;
    for (const DataVariable& v : type.variables) expect(is_type(v.type), "a variable has a type");
    const auto first_data =
        std::find_if(type.variables.begin(), type.variables.end(), [](const DataVariable& v) { return !v.is_param; });
    expect(std::none_of(first_data, type.variables.end(), [](const DataVariable& v) { return v.is_param; }),
           "parameters come first");
    for (const Port& port : type.ports) {
      expect(model_.port_types.contains(port.type), "a port has a type");
      rows(port.variables, type.variables.size(), "a port shows variables of its atom");
      if (model_.port_types.contains(port.type))
        expect(port.variables.size() == model_.port_types[port.type].variables.size(),
               "a port shows one variable per variable of its type");
    }
    rows(type.initial, type.places.size(), "an initial place is a place");
    expect(!type.initial.empty(), "an atom begins somewhere");
    rows(type.final_places, type.places.size(), "a final place is a place");
    optional_stmt(type.initial_action, "the initial action is a row");
    for (const Transition& t : type.transitions) {
      expect(t.port == Transition::kInternal || t.port < type.ports.size(), "a transition has a port or is internal");
      expect(!t.from.empty(), "a transition begins somewhere");
      rows(t.from, type.places.size(), "a transition begins at places");
      rows(t.to, type.places.size(), "a transition ends at places");
      optional_expr(t.guard, "a guard is a row");
      optional_stmt(t.action, "an action is a row");
      time_guard(t.when, type);
    }
    for (const AtomPriority& p : type.priorities) {
      expect(p.low == AtomPriority::kAnyPort || p.low < type.ports.size(), "the low side of a priority is a port");
      expect(p.high == AtomPriority::kAnyPort || p.high < type.ports.size(), "the high side of a priority is a port");
      optional_expr(p.guard, "a guard is a row");
    }
    for (const Invariant& i : type.invariants) {
      rows(i.places, type.places.size(), "an invariant is about places");
      expect(std::is_sorted(i.places.begin(), i.places.end()), "places of an invariant are sorted");
      optional_expr(i.condition, "an invariant's condition is a row");
      time_guard(i.when, type);
    }
    for (const MergedPort& m : type.merged) {
      expect(m.ports.size() >= 2, "a merged port has two ports");
      rows(m.ports, type.ports.size(), "a merged port has ports of its atom");
    }
    for (const Clock& clock : type.clocks)
      expect(clock.variable + kClockVariables <= type.variables.size(), "a clock has its hidden variables");
  }
  void time_guard(const TimeGuard& when, const AtomType& type) {
    for (const Bound& bound : when.bounds) {
      expect(bound.clock < type.clocks.size(), "a bound is on a clock");
      expect(bound.minus == Bound::kNone || bound.minus < type.clocks.size(), "a difference is of two clocks");
      expect(bound.variable == Bound::kNone || bound.variable < type.variables.size(), "a limit is a variable");
    }
    optional_stmt(when.measure, "code that measures is a row");
  }

  void connector(const ConnectorType& type) {
    owner_ = &type.name;
    std::uint32_t next_bind = 0;
    for (const ConnectorParam& param : type.params) {
      expect(model_.port_types.contains(param.type), "a parameter has a port type");
      expect(param.first_bind == next_bind, "bound variables of parameters follow each other");
      if (model_.port_types.contains(param.type))
        next_bind += static_cast<std::uint32_t>(model_.port_types[param.type].variables.size());
    }
    std::vector<std::uint8_t> has_parent(type.define.size(), 0);
    for (std::uint32_t row = 0; row < type.define.size(); ++row) {
      const DefineNode& node = type.define[row];
      expect(!node.is_leaf || (node.param < type.params.size() && node.children.empty()),
             "a leaf of `define` is a parameter");
      for (const std::uint32_t child : node.children) {
        const bool is_below = child > row && child < type.define.size();
        expect(is_below && has_parent[child] == 0, "`define` is a tree in preorder");
        if (is_below) has_parent[child] = 1;
      }
    }
    for (const Clause& clause : type.clauses) {
      rows(clause.params, type.params.size(), "a clause is about parameters");
      expect(std::is_sorted(clause.params.begin(), clause.params.end()), "parameters of a clause are sorted");
      optional_expr(clause.guard, "a guard is a row");
      optional_stmt(clause.up, "`up` is a row");
      optional_stmt(clause.down, "`down` is a row");
    }
    if (type.exports) rows(type.export_variables, type.variables.size(), "an exported port shows the connector's data");
  }

  void compound(const CompoundType& type) {
    owner_ = &type.name;
    for (const ComponentFamily& family : type.components)
      expect(family.is_compound ? model_.compound_types.contains(family.compound)
                                : model_.atom_types.contains(family.atom),
             "a component has a type");
    items(type, type.items);
    for (const PortExport& e : type.exports) {
      expect(!e.targets.empty(), "an export has a target");
      for (const PortPath& target : e.targets) port_path(type, target);
    }
    for (const DataExport& e : type.data_exports)
      expect(e.target.element.family < type.components.size(), "exported data belong to a component");
  }
  void port_path(const CompoundType& type, const PortPath& path) {
    const std::size_t count = path.is_connector ? type.connectors.size() : type.components.size();
    expect(path.element.family < count, "a path begins with a component or connector");
    optional_expr(path.element.index, "an index is a row");
  }
  void items(const CompoundType& type, const std::vector<CompoundItem>& list) {
    for (const CompoundItem& item : list) {
      optional_expr(item.index, "an index is a row");
      switch (item.kind) {
        case ItemKind::Component:
          expect(item.family < type.components.size(), "a component has a family");
          for (const ExprId arg : item.args) expect(model_.code.exprs.contains(arg), "an argument is a row");
          break;
        case ItemKind::Connector:
          expect(item.family < type.connectors.size(), "a connector has a family");
          expect(!item.type.is_valid() || model_.connector_types.contains(item.type), "a connector's type is a row");
          for (const PortPath& path : item.ports) port_path(type, path);
          break;
        case ItemKind::For:
          expect(model_.code.exprs.contains(item.low) && model_.code.exprs.contains(item.high), "a loop has bounds");
          items(type, item.items);
          break;
        case ItemKind::Property: expect(item.syntax != nullptr, "a property has a text"); break;
        case ItemKind::Priority: expect(item.family < type.priorities.size(), "a priority is a row"); break;
      }
    }
  }

  void names() {
    owner_ = nullptr;
    for (const auto& [name, type] : model_.type_names) {
      owner_ = &name;
      std::size_t count = 0;
      switch (type.kind) {
        case TypeName::Kind::Port: count = model_.port_types.size(); break;
        case TypeName::Kind::Connector: count = model_.connector_types.size(); break;
        case TypeName::Kind::Atom: count = model_.atom_types.size(); break;
        case TypeName::Kind::Compound: count = model_.compound_types.size(); break;
      }
      expect(type.row < count, "a type's name stands for a row");
    }
  }

  const Model& model_;
  const std::string* owner_ = nullptr;  // whose promise it is, for messages
  std::vector<std::string> broken_;
};

}  // namespace

std::vector<std::string> validate(const Model& model) { return ModelValidator(model).run(); }

}  // namespace bip::model
