// See value_classes.hpp. A union-find structure over the variables of atom types and connector types.
#include "compiler/verify/regions/value_classes.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <tuple>

#include "compiler/model/code_uses.hpp"
#include "compiler/model/operators.hpp"
#include "compiler/verify/net/abstract_code.hpp"

namespace bip::verify {

namespace {

// Whose code it is: what its variables are numbered from, and whether parameters are constants in it.
struct CodeOwner {
  u32 self = 0, bind = 0;
  const AtomType* atom_type = nullptr;  // null: a connector
};
// Where the value of an expression may come from.
struct ValueFlow {
  struct Constant {
    ExprId expr;
    std::int64_t offset = 0;
  };
  std::vector<u32> nodes;
  std::vector<Constant> constants;
};
struct NodeConstant {
  u32 node = 0;
  std::size_t atom_type = 0;
  ValueFlow::Constant constant;
};

class ValueClassifier {
 public:
  explicit ValueClassifier(const System& system) : system_(system), code_(system.code) {
    u32 nodes = 0;
    for (const AtomType& type : system.atom_types) {
      atom_base_.push_back(nodes);
      nodes += static_cast<u32>(type.variables.size());
    }
    for (const ConnectorType& type : system.connector_types) {
      connector_base_.push_back(nodes);
      nodes += static_cast<u32>(type.variables.size()) + type.bind_count(system.port_types);
    }
    parent_.resize(nodes);
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  ValueClasses run() {
    for (std::size_t row = 0; row < atom_base_.size(); ++row) read_atom_type(row);
    for (std::size_t row = 0; row < connector_base_.size(); ++row) read_connector_type(row);
    for (const Connector& connector : system_.connectors) bind(connector);
    return result();
  }

 private:
  u32 root_of(u32 node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }
  void unite(u32 a, u32 b) { parent_[root_of(a)] = root_of(b); }

  [[nodiscard]] bool is_constant(ExprId id, const CodeOwner& owner) const {
    bool is = true;
    model::for_each_expr(code_, id, [&](const Expr& e) {
      const bool is_param =
          e.op == Op::LoadSelf && owner.atom_type != nullptr && owner.atom_type->variables[e.index].is_param;
      is = is && e.op != Op::Call && e.type != Type::Float && (!is_load(e.op) || is_param);
    });
    return is;
  }
  void add_flow(ExprId id, const CodeOwner& owner, ValueFlow& flow) const {
    if (is_constant(id, owner)) {
      flow.constants.push_back({id, 0});
      return;
    }
    const Expr& e = code_.exprs[id];
    if (e.op == Op::LoadSelf) flow.nodes.push_back(owner.self + e.index);
    if (e.op == Op::LoadBind) flow.nodes.push_back(owner.bind + e.index);
    // A constant that is added is a distance, and no value.
    if (e.op == Op::Add || e.op == Op::Sub) {
      if (!is_constant(e.a, owner)) add_flow(e.a, owner, flow);
      if (!is_constant(e.b, owner)) add_flow(e.b, owner, flow);
    }
    if (e.op == Op::Mod) {
      add_flow(e.a, owner, flow);
      // The last value before it begins anew.
      if (is_constant(e.b, owner)) flow.constants.push_back({e.b, -1});
    }
  }
  void unite(const ValueFlow& flow, std::size_t atom_type) {
    if (flow.nodes.empty()) return;
    for (const u32 node : flow.nodes) unite(node, flow.nodes.front());
    for (const ValueFlow::Constant& constant : flow.constants)
      constants_.push_back({flow.nodes.front(), atom_type, constant});
  }
  void read(ExprId root, const CodeOwner& owner, std::size_t atom_type) {
    model::for_each_expr(code_, root, [&](const Expr& e) {
      if (!is_comparison(e.op)) return;
      ValueFlow flow;
      add_flow(e.a, owner, flow);
      add_flow(e.b, owner, flow);
      unite(flow, atom_type);
    });
  }
  void read(StmtId first, const CodeOwner& owner, std::size_t atom_type) {
    model::for_each_stmt(code_, first, [&](const Stmt& s) {
      read(s.value, owner, atom_type);
      ValueFlow flow;
      if (const auto variable = model::assigned_variable(s, Op::LoadSelf)) flow.nodes.push_back(owner.self + *variable);
      if (const auto variable = model::assigned_variable(s, Op::LoadBind)) flow.nodes.push_back(owner.bind + *variable);
      if (flow.nodes.empty()) return;
      add_flow(s.value, owner, flow);
      unite(flow, atom_type);
    });
  }
  void read_atom_type(std::size_t row) {
    const AtomType& type = system_.atom_types[AtomTypeId(row)];
    const CodeOwner owner{atom_base_[row], 0, &type};
    read(type.initial_action, owner, row);
    for (const Transition& t : type.transitions) {
      read(t.guard, owner, row);
      read(t.action, owner, row);
    }
  }
  void read_connector_type(std::size_t row) {
    const ConnectorType& type = system_.connector_types[ConnectorTypeId(row)];
    const u32 base = connector_base_[row];
    const CodeOwner owner{base, base + static_cast<u32>(type.variables.size()), nullptr};
    for (const Clause& clause : type.clauses) {
      read(clause.guard, owner, kOfConnector);
      read(clause.up, owner, kOfConnector);
      read(clause.down, owner, kOfConnector);
    }
  }
  void bind(const Connector& connector) {
    const ConnectorType& type = system_.connector_types[connector.type];
    const u32 first = connector_base_[connector.type.value] + static_cast<u32>(type.variables.size());
    u32 after = first;
    for (u32 param = 0; param < connector.ports.size(); ++param) {
      const PortRef& ref = connector.ports[param];
      const AtomTypeId atom_type = system_.atoms[ref.atom].type;
      const Port& port = system_.atom_types[atom_type].ports[ref.port];
      const u32 bound = first + type.params[param].first_bind;
      after = std::max(after, bound + static_cast<u32>(port.variables.size()));
      if (!bound_.insert({connector.type.value, param, atom_type.value, ref.port}).second) continue;
      for (u32 k = 0; k < port.variables.size(); ++k) unite(bound + k, atom_base_[atom_type.value] + port.variables[k]);
    }
    for (const DataRef& ref : connector.data)
      unite(after++, atom_base_[system_.atoms[ref.atom].type.value] + ref.variable);
  }
  ValueClasses result() {
    ValueClasses classes;
    std::vector<u32> number(parent_.size(), ~u32{0});
    const auto class_of = [&](u32 node) {
      u32& of_root = number[root_of(node)];
      if (of_root == ~u32{0}) of_root = classes.count++;
      return of_root;
    };
    for (std::size_t row = 0; row < atom_base_.size(); ++row) {
      classes.class_of.emplace_back();
      for (u32 k = 0; k < system_.atom_types[AtomTypeId(row)].variables.size(); ++k)
        classes.class_of.back().push_back(class_of(atom_base_[row] + k));
    }
    for (std::size_t row = 0; row < connector_base_.size(); ++row) {
      const ConnectorType& type = system_.connector_types[ConnectorTypeId(row)];
      classes.class_of_bind.emplace_back();
      const u32 first = connector_base_[row] + static_cast<u32>(type.variables.size());
      for (u32 k = 0; k < type.bind_count(system_.port_types); ++k)
        classes.class_of_bind.back().push_back(class_of(first + k));
    }
    classes.attached.resize(atom_base_.size());
    classes.general.resize(parent_.size());
    for (const NodeConstant& row : constants_) {
      const u32 value_class = class_of(row.node);
      if (row.atom_type != kOfConnector) {
        classes.attached[row.atom_type].push_back({row.constant.expr, value_class, row.constant.offset});
        continue;
      }
      const AbstractValue value = evaluate(code_, row.constant.expr, {}, {});
      if (value.is_known) classes.general[value_class].push_back(value.value + row.constant.offset);
    }
    classes.general.resize(classes.count);
    for (std::vector<std::int64_t>& values : classes.general) {
      std::sort(values.begin(), values.end());
      values.erase(std::unique(values.begin(), values.end()), values.end());
    }
    return classes;
  }

  static constexpr std::size_t kOfConnector = ~std::size_t{0};
  const System& system_;
  const CodeTable& code_;
  std::vector<u32> atom_base_, connector_base_;
  std::vector<u32> parent_;
  std::vector<NodeConstant> constants_;
  std::set<std::tuple<u32, u32, u32, u32>> bound_;
};

}  // namespace

ValueClasses find_value_classes(const System& system) { return ValueClassifier(system).run(); }

}  // namespace bip::verify
