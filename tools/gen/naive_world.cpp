// Instantiation by recursion over compounds (depth at most that of the generated types).
#include "tools/gen/naive_world.hpp"

#include <cstdlib>

namespace bip::gen {
namespace {

struct Instance {
  const CompoundType* type = nullptr;
  std::string path;
  int number = 0;
  Values params;
  std::map<std::string, int> atoms, connectors;
  std::map<std::string, std::unique_ptr<Instance>> children;
};

class NaiveWorldBuilder {
 public:
  explicit NaiveWorldBuilder(const Description& model) : model_(model) {}

  World build() {
    (void)instantiate(model_.compound_types.back(), "ROOT", {});
    return std::move(world_);
  }

 private:
  static Lookup params_of(Instance& at) {
    return [&at](const std::string&, const std::string& name) -> Value& { return at.params[name]; };
  }
  static int size_of(Instance& at, const std::string& size) {
    return size == "n" ? at.params["n"].i : std::atoi(size.c_str());
  }
  static std::string element(const std::string& name, int k) { return name + "[" + std::to_string(k) + "]"; }

  std::unique_ptr<Instance> instantiate(const CompoundType& type, const std::string& path, Values params) {
    auto at = std::make_unique<Instance>();
    at->type = &type;
    at->path = path;
    at->number = instances_++;
    at->params = std::move(params);
    for (const Component& component : type.components) {
      if (component.size.empty()) {
        add_component(*at, component, component.name);
      } else {
        for (int k = 0, n = size_of(*at, component.size); k < n; ++k)
          add_component(*at, component, element(component.name, k));
      }
    }
    for (const Connector& connector : type.connectors) {
      if (connector.size.empty()) {
        add_connector(*at, connector, connector.name, 0);
      } else {
        for (int k = 0, n = size_of(*at, connector.size); k < n; ++k)
          add_connector(*at, connector, element(connector.name, k), k);
      }
    }
    for (const Priority& rule : type.priorities) add_rule(*at, rule);
    return at;
  }

  Values arguments(Instance& at, const std::vector<Var>& params, const Component& component) {
    Values args;
    Place code;
    for (std::size_t k = 0; k < params.size(); ++k) {
      args[params[k].name] = converted(evaluate(component.args[k], params_of(at), code), params[k].type);
    }
    return args;
  }
  void add_component(Instance& at, const Component& component, const std::string& name) {
    std::string path = at.path + "." + name;
    if (const AtomType* atom = find_named(model_.atom_types, component.type)) {
      at.atoms[name] = static_cast<int>(world_.atoms.size());
      world_.atoms.push_back({path, atom, arguments(at, atom->params, component)});
    } else {
      const CompoundType& inner = *find_named(model_.compound_types, component.type);
      at.children[name] = instantiate(inner, path, arguments(at, inner.params, component));
    }
  }

  static std::string key_of(Instance& at, const PortPath& path, int loop) {
    switch (path.index.kind) {
      case Index::Kind::None: return path.component;
      case Index::Kind::Constant: return element(path.component, path.index.value);
      case Index::Kind::Loop: break;
    }
    return element(path.component, (loop + path.index.value) % size_of(at, path.index.size));
  }
  WorldPort resolve(Instance& at, const PortPath& path, int loop) {
    std::string key = key_of(at, path, loop);
    WorldPort result;
    if (auto atom = at.atoms.find(key); atom != at.atoms.end()) {
      for (const Port& port : world_.atoms[static_cast<std::size_t>(atom->second)].type->ports) {
        if (port.exported && port.outer_name() == path.port) result.push_back({atom->second, port.name, -1, false});
      }
      return result;
    }
    if (auto connector = at.connectors.find(key); connector != at.connectors.end())
      return {{-1, "", connector->second, false}};
    Instance& child = *at.children.at(key);
    for (const PortPath& target : find_named(child.type->port_exports, path.port)->targets) {
      for (WorldOption option : resolve(child, target, 0)) {
        option.maximal_only = option.connector >= 0;
        result.push_back(option);
      }
    }
    return result;
  }
  void add_connector(Instance& at, const Connector& connector, const std::string& name, int loop) {
    WorldConnector row;
    row.path = at.path + "." + name;
    row.type = find_named(model_.connector_types, connector.type);
    row.compound = at.number;
    for (const PortPath& path : connector.ports) {
      row.ports.push_back(resolve(at, path, loop));
      for (const WorldOption& option : row.ports.back()) {
        if (option.connector < 0) continue;
        WorldConnector& below = world_.connectors[static_cast<std::size_t>(option.connector)];
        below.bound = true;
        below.bound_by_sibling = below.bound_by_sibling || below.compound == at.number;
      }
    }
    at.connectors[name] = static_cast<int>(world_.connectors.size());
    world_.connectors.push_back(row);
  }

  static WorldPattern pattern(Instance& at, const Pattern& source) {
    WorldPattern result;
    if (source.any_connector) return result;
    result.connector = at.connectors.at(source.connector);
    result.any_interaction = source.any_interaction;
    result.params.insert(source.params.begin(), source.params.end());
    return result;
  }
  /// The atom and the variable behind a compound's exported data, through any number of compounds.
  static std::pair<int, std::string> exported(Instance& at, const std::string& name) {
    const DataExport& e = *find_named(at.type->data_exports, name);
    const auto atom = at.atoms.find(e.component);
    return atom != at.atoms.end() ? std::pair(atom->second, e.data) : exported(*at.children.at(e.component), e.data);
  }
  void find_data(Instance& at, const Expr& expr, WorldRule& rule) {
    if (expr.kind == ExprKind::Name && expr.scope != "$") {
      std::string name = expr.scope + "." + expr.name;
      if (auto atom = at.atoms.find(expr.scope); atom != at.atoms.end()) {
        rule.data[name] = {atom->second, expr.name};
      } else {
        rule.data[name] = exported(*at.children.at(expr.scope), expr.name);
      }
    }
    for (const Expr& arg : expr.args) find_data(at, arg, rule);
  }
  void add_rule(Instance& at, const Priority& source) {
    WorldRule rule{at.number, pattern(at, source.low), pattern(at, source.high), &source, {}};
    if (source.guard) find_data(at, *source.guard, rule);
    world_.rules.push_back(std::move(rule));
  }

  const Description& model_;
  World world_;
  int instances_ = 0;
};

}  // namespace

World build_world(const Description& model) { return NaiveWorldBuilder(model).build(); }

std::vector<Node> structural_interactions(const World& world, int connector, std::size_t limit) {
  const WorldConnector& row = world.connectors[static_cast<std::size_t>(connector)];
  std::vector<Node> result;
  for (const auto& set : expand(row.type->define)) {
    std::vector<Node> partial = {{connector, std::set<int>(set.begin(), set.end()), {}}};
    for (int p : set) {
      std::vector<Leaves> options;
      for (const WorldOption& option : row.ports[static_cast<std::size_t>(p)]) {
        if (option.atom >= 0) {
          options.push_back({{option.atom, option.port}});
        } else {
          for (Node& inner : structural_interactions(world, option.connector, limit))
            options.push_back(std::move(inner.leaves));
        }
      }
      std::vector<Node> next;
      for (const Node& node : partial) {
        for (const Leaves& option : options) {
          if (next.size() > limit) break;
          next.push_back(node);
          next.back().leaves.insert(option.begin(), option.end());
        }
      }
      partial = std::move(next);
    }
    for (Node& node : partial) result.push_back(std::move(node));
    if (result.size() > limit) break;
  }
  return result;
}

}  // namespace bip::gen
