// After an edit: removes dangling references, then the declarations that need them, then unused declarations.
#include <algorithm>
#include <set>

#include "tools/gen/shrink.hpp"

namespace bip::gen {
namespace {

class Tidier {
 public:
  explicit Tidier(Description& model) : model_(model) {}

  void run() {
    do {
      changed_ = false;
      for (AtomType& type : model_.atom_types) tidy(type);
      for (CompoundType& type : model_.compound_types) tidy(type);
      drop_unused_types();
    } while (changed_);
  }

 private:
  template <class T, class F>
  void drop_if(std::vector<T>& items, F gone) {
    if (std::erase_if(items, gone) > 0) changed_ = true;
  }

  static void names_in(const Expr& e, std::set<std::string>& names) {
    if (e.kind == ExprKind::Name) names.insert(e.name);
    for (const Expr& arg : e.args) names_in(arg, names);
  }
  static void names_in(const Body& body, std::set<std::string>& names) {
    for (const Stmt& stmt : body) {
      if (!stmt.is_if && !stmt.is_call) names.insert(stmt.name);
      names_in(stmt.value, names);
      names_in(stmt.then_body, names);
      names_in(stmt.else_body, names);
    }
  }
  static bool rules_a_port(const AtomType& type, const std::string& port) {
    return port == "*" || find_named(type.ports, port) != nullptr;
  }
  void tidy(AtomType& type) {
    drop_if(type.transitions,
            [&](const Transition& t) { return !t.port.empty() && find_named(type.ports, t.port) == nullptr; });
    std::set<std::string> names, places(type.initial.begin(), type.initial.end());
    names_in(type.initial_action, names);
    for (const Transition& t : type.transitions) {
      if (t.guard) names_in(*t.guard, names);
      names_in(t.action, names);
      places.insert(t.from.begin(), t.from.end());
      places.insert(t.to.begin(), t.to.end());
    }
    drop_if(type.rules, [&](const AtomRule& r) { return !rules_a_port(type, r.low) || !rules_a_port(type, r.high); });
    for (const AtomRule& r : type.rules) {
      if (r.guard) names_in(*r.guard, names);
    }
    drop_if(type.invariants, [&](const Invariant& i) {
      return !std::all_of(i.places.begin(), i.places.end(), [&](const std::string& p) { return places.contains(p); });
    });
    for (const Invariant& i : type.invariants) names_in(i.condition, names);
    drop_if(type.finals, [&](const std::string& p) { return !places.contains(p); });
    for (Port& port : type.ports) {
      names.insert(port.vars.begin(), port.vars.end());
      auto same = [&](const Port& p) { return p.merged == port.merged; };
      if (!port.merged.empty() && std::count_if(type.ports.begin(), type.ports.end(), same) == 1) {
        // None is left to merge with; connectors know it by this name.
        for (Transition& t : type.transitions) {
          if (t.port == port.name) t.port = port.merged;
        }
        for (AtomRule& r : type.rules) {
          if (r.low == port.name) r.low = port.merged;
          if (r.high == port.name) r.high = port.merged;
        }
        port.name = port.merged;
        port.merged.clear();
        changed_ = true;
      }
    }
    for (const CompoundType& compound : model_.compound_types) {
      for (const DataExport& e : compound.data_exports) names.insert(e.data);
    }
    drop_if(type.data, [&](const Var& v) { return !names.contains(v.name) && !v.exported; });
    drop_if(type.places, [&](const std::string& p) { return !places.contains(p); });
  }

  [[nodiscard]] bool leads_somewhere(const CompoundType& at, const PortPath& path) const {
    if (const Component* component = find_named(at.components, path.component)) {
      if (const AtomType* atom = find_named(model_.atom_types, component->type)) {
        return std::any_of(atom->ports.begin(), atom->ports.end(),
                           [&](const Port& p) { return p.outer_name() == path.port; });
      }
      const CompoundType* inner = find_named(model_.compound_types, component->type);
      return inner != nullptr && find_named(inner->port_exports, path.port) != nullptr;
    }
    return find_named(at.connectors, path.component) != nullptr;
  }
  [[nodiscard]] bool names_data(const CompoundType& at, const Expr& e) const {
    if (e.kind == ExprKind::Name && e.scope != "$") {
      const Component* component = find_named(at.components, e.scope);
      if (component == nullptr) return false;
      const CompoundType* inner = find_named(model_.compound_types, component->type);
      if (inner != nullptr && find_named(inner->data_exports, e.name) == nullptr) return false;
    }
    return std::all_of(e.args.begin(), e.args.end(), [&](const Expr& arg) { return names_data(at, arg); });
  }
  void tidy(CompoundType& type) {
    drop_if(type.connectors, [&](const Connector& c) {
      return !std::all_of(c.ports.begin(), c.ports.end(), [&](const PortPath& p) { return leads_somewhere(type, p); });
    });
    for (PortExport& e : type.port_exports) {
      drop_if(e.targets, [&](const PortPath& path) { return !leads_somewhere(type, path); });
    }
    drop_if(type.port_exports, [](const PortExport& e) { return e.targets.empty(); });
    drop_if(type.data_exports, [&](const DataExport& e) {
      const Component* component = find_named(type.components, e.component);
      const CompoundType* inner = component == nullptr ? nullptr : find_named(model_.compound_types, component->type);
      return component == nullptr || (inner != nullptr && find_named(inner->data_exports, e.data) == nullptr);
    });
    auto gone = [&](const Pattern& p) {
      return !p.any_connector && find_named(type.connectors, p.connector) == nullptr;
    };
    drop_if(type.priorities,
            [&](const Priority& p) { return gone(p.low) || gone(p.high) || (p.guard && !names_data(type, *p.guard)); });
  }
  void drop_unused_types() {
    std::set<std::string> used;
    for (const CompoundType& type : model_.compound_types) {
      for (const Component& c : type.components) used.insert(c.type);
      for (const Connector& c : type.connectors) used.insert(c.type);
    }
    if (!model_.compound_types.empty()) used.insert(model_.compound_types.back().name);
    drop_if(model_.compound_types, [&](const CompoundType& t) { return !used.contains(t.name); });
    drop_if(model_.atom_types, [&](const AtomType& t) { return !used.contains(t.name); });
    drop_if(model_.connector_types, [&](const ConnectorType& t) { return !used.contains(t.name); });
    for (const AtomType& type : model_.atom_types) {
      for (const Port& port : type.ports) used.insert(port.type);
    }
    for (const ConnectorType& type : model_.connector_types) {
      used.insert(type.export_type);
      for (const ConnectorParam& p : type.params) used.insert(p.type);
    }
    drop_if(model_.port_types, [&](const PortType& t) { return !used.contains(t.name); });
  }

  Description& model_;
  bool changed_ = false;
};

}  // namespace

void tidy(Description& model) { Tidier(model).run(); }

}  // namespace bip::gen
