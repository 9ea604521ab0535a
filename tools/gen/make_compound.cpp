// Random compound types: components (also arrays), connectors over ports of disjoint components (also hierarchical
// ones, and loops over arrays), exports. A connector's weight counts its alternatives, nested ones included, so that
// the naive oracle can enumerate them.
#include <algorithm>

#include "tools/gen/make.hpp"

namespace bip::gen {
namespace {

/// A port that a connector of the compound may bind.
struct Offer {
  PortPath path;
  std::string port_type;
  std::set<std::string> atoms;
  int weight = 1, depth = 0;
  bool connector = false;
};

constexpr int kLargestArray = 4;

class CompoundMaker {
 public:
  CompoundMaker(Prng& random, const Style& style, Description& model, std::map<std::string, Interface>& interfaces)
      : random_(random), style_(style), model_(model), interfaces_(interfaces), code_(random, style) {}

  CompoundType make(const std::string& name, CompoundLevel level) {
    const bool is_root = level == CompoundLevel::Root;
    compound_.name = name;
    if (!is_root && random_.percent(25)) compound_.params.push_back({"n", Ty::Int, false, {}});
    make_components(is_root);
    int connectors = style_.large ? random_.between(6, 14) : random_.between(1, 5);
    if (style_.ruled) connectors += random_.between(1, 3);
    for (int k = 0; k < connectors; ++k) connect(random_.percent(style_.deep ? 50 : 30));
    for (const Component& component : compound_.components) connect_array(component);
    if (is_root || random_.percent(30)) bind_exports();
    if (!is_root) make_exports();
    make_data_exports();
    if (random_.percent(style_.ruled ? 90 : 35)) make_priorities(random_, style_, model_, compound_);
    choose_notation(is_root);
    return compound_;
  }

 private:
  void make_components(bool is_root) {
    int count = style_.large ? random_.between(8, 20) : random_.between(is_root ? 2 : 1, 4);
    for (int k = 0; k < count; ++k) {
      Component component;
      component.name = "a" + std::to_string(k);
      bool nested = !model_.compound_types.empty() && random_.percent(style_.deep ? 65 : is_root ? 35 : 25);
      const CompoundType* type = nested ? &random_.pick(model_.compound_types) : nullptr;
      if (type != nullptr && atoms_ + kLargestArray * interfaces_[type->name].atoms <= style_.max_atoms) {
        add_nested(component, *type);
      } else {
        add_atom(component, random_.pick(model_.atom_types));
      }
      compound_.components.push_back(component);
    }
    interfaces_[compound_.name].atoms = atoms_;
  }
  struct Shown {
    std::string name, port_type;
    int weight = 1;
  };
  /// The ports of an atom type as others see them.
  static std::vector<Shown> shown_by(const AtomType& type) {
    std::vector<Shown> result;
    for (const Port& port : type.ports) {
      if (!port.exported) continue;
      if (!port.merged.empty() && !result.empty() && result.back().name == port.merged) {
        ++result.back().weight;
      } else {
        result.push_back({port.outer_name(), port.type, 1});
      }
    }
    return result;
  }
  void add_nested(Component& component, const CompoundType& type) {
    component.type = type.name;
    if (!type.params.empty()) component.args.push_back(int_literal(random_.between(2, kLargestArray)));
    if (random_.percent(12)) component.size = std::to_string(random_.between(2, 3));
    const int elements = component.size.empty() ? 1 : std::stoi(component.size);
    atoms_ += elements * interfaces_[type.name].atoms;
    for (int k = 0; k < elements; ++k) {
      std::string name = component.name;
      Index index;
      if (!component.size.empty()) {
        name += "[" + std::to_string(k) + "]";
        index = {Index::Kind::Constant, k, component.size};
      }
      for (const Interface::Item& item : interfaces_[type.name].ports) {
        Offer offer{{component.name, index, item.name}, item.port_type, {}, item.weight, item.depth, false};
        for (const std::string& atom : item.atoms) offer.atoms.insert(name + "." + atom);
        offers_.push_back(offer);
      }
    }
  }
  void add_atom(Component& component, const AtomType& type) {
    component.type = type.name;
    bool has_param = !compound_.params.empty();
    if (random_.percent(12))
      component.size = has_param && random_.percent(60) ? "n" : std::to_string(random_.between(2, kLargestArray));
    for (const Var& param : type.params) component.args.push_back(argument(param.type, has_param));
    int elements = component.size.empty() ? 1 : component.size == "n" ? 2 : std::stoi(component.size);
    atoms_ += component.size == "n" ? kLargestArray : elements;
    for (int k = 0; k < elements; ++k) {
      for (const auto& [name, port_type, weight] : shown_by(type)) {
        Offer offer{{component.name, {}, name}, port_type, {component.name}, weight, 0, false};
        if (!component.size.empty()) {
          offer.path.index = {Index::Kind::Constant, k, component.size};
          offer.atoms = {component.name + "[" + std::to_string(k) + "]"};
        }
        offers_.push_back(offer);
      }
    }
  }
  Expr argument(Ty type, bool has_param) {
    if (type == Ty::Int && has_param && random_.percent(50)) {
      Expr n;
      n.kind = ExprKind::Name;
      n.name = "n";
      return random_.percent(50) ? n : binary("*", n, int_literal(random_.between(1, 9)), Ty::Int);
    }
    if (type == Ty::Int && random_.percent(20)) return unary("-", int_literal(random_.between(1, 99)), Ty::Int);
    return code_.literal(type);
  }

  /// One more connector over ports that share no atom. Nothing if the choice would be too heavy.
  void connect(bool exports) {
    std::vector<Offer> pool = offers_;
    random_.shuffle(pool);
    if (random_.percent(50)) {
      std::stable_partition(pool.begin(), pool.end(), [](const Offer& o) { return o.weight > 1 || o.connector; });
    }
    std::size_t want = 1 + random_.below(style_.large ? 7 : 4);
    std::vector<Offer> members;
    std::set<std::string> atoms;
    for (const Offer& offer : pool) {
      bool free =
          std::none_of(offer.atoms.begin(), offer.atoms.end(), [&](const auto& a) { return atoms.contains(a); });
      if (!free || offer.depth >= 3 || members.size() == want) continue;
      members.push_back(offer);
      atoms.insert(offer.atoms.begin(), offer.atoms.end());
    }
    if (members.empty()) return;
    add_connector(members, atoms, exports);
  }
  void add_connector(const std::vector<Offer>& members, const std::set<std::string>& atoms, bool exports) {
    std::vector<std::string> params;
    for (const Offer& m : members) params.push_back(m.port_type);
    ConnectorType type = fitting_type(params, exports);
    int weight = 0, depth = 0;
    for (const auto& set : expand(type.define)) {
      int product = 1;
      for (int p : set) product = std::min(product * members[static_cast<std::size_t>(p)].weight, 100000);
      weight = std::min(weight + product, 100000);
    }
    if (weight > style_.max_weight) return;
    for (const Offer& m : members) depth = std::max(depth, m.depth);
    if (find_named(model_.connector_types, type.name) == nullptr) model_.connector_types.push_back(type);
    Connector connector;
    connector.name = "c" + std::to_string(compound_.connectors.size());
    connector.type = type.name;
    for (const Offer& m : members) {
      connector.ports.push_back(m.path);
      if (m.connector) bound_.insert(m.path.component);
    }
    compound_.connectors.push_back(connector);
    if (type.exports)
      offers_.push_back({{connector.name, {}, type.export_name}, type.export_type, atoms, weight, depth + 1, true});
  }
  ConnectorType fitting_type(const std::vector<std::string>& params, bool exports) {
    for (const ConnectorType& type : model_.connector_types) {
      bool fits = type.exports == exports && type.params.size() == params.size();
      for (std::size_t k = 0; fits && k < params.size(); ++k) fits = type.params[k].type == params[k];
      if (fits && random_.percent(40)) return type;
    }
    return make_connector(random_, style_, model_.port_types, params, exports,
                          "K" + std::to_string(model_.connector_types.size()));
  }
  /// `for i in 0..n connector K c[i](a[i].p, a[(i + 1) % n].q)`
  void connect_array(const Component& component) {
    if (component.size.empty() || !random_.percent(75)) return;
    std::vector<Shown> ports;
    if (const AtomType* type = find_named(model_.atom_types, component.type)) {
      ports = shown_by(*type);
    } else {
      // Pairs of them are bound: few alternatives each.
      for (const Interface::Item& item : interfaces_[component.type].ports) {
        if (item.weight <= 8 && item.depth <= 2) ports.push_back({item.name, item.port_type, item.weight});
      }
    }
    if (ports.empty()) return;
    Connector connector;
    std::vector<std::string> params;
    for (int k = 0, n = random_.between(1, 2); k < n; ++k) {
      const Shown& port = random_.pick(ports);
      connector.ports.push_back({component.name, {Index::Kind::Loop, k, component.size}, port.name});
      params.push_back(port.port_type);
    }
    ConnectorType made = fitting_type(params, false);
    if (find_named(model_.connector_types, made.name) == nullptr) model_.connector_types.push_back(made);
    connector.name = "c" + std::to_string(compound_.connectors.size());
    connector.type = made.name;
    connector.size = component.size;
    compound_.connectors.push_back(connector);
  }
  void bind_exports() {
    for (std::size_t k = 0; k < offers_.size(); ++k) {
      Offer offer = offers_[k];
      if (!offer.connector || bound_.contains(offer.path.component) || offer.depth >= 4) continue;
      add_connector({offer}, offer.atoms, false);
    }
  }
  void make_exports() {
    std::vector<Offer> pool = offers_;
    random_.shuffle(pool);
    std::stable_partition(pool.begin(), pool.end(), [](const Offer& o) { return o.connector; });
    if (style_.deep) std::stable_partition(pool.begin(), pool.end(), [](const Offer& o) { return o.weight > 1; });
    std::size_t count = std::min<std::size_t>(pool.size(), 1 + random_.below(3));
    Interface& interface = interfaces_[compound_.name];
    for (std::size_t k = 0; k < count; ++k) {
      std::string name = "out" + std::to_string(k);
      PortExport exported{{pool[k].path}, name};
      Interface::Item item{name, pool[k].port_type, pool[k].atoms, pool[k].weight, pool[k].depth};
      if (style_.merged && random_.percent(50)) merge_into(exported, item, pool);
      compound_.port_exports.push_back(exported);
      interface.ports.push_back(item);
    }
  }
  /// More ports of the same type under one name; of other atoms, so that no alternative contains another.
  static void merge_into(PortExport& exported, Interface::Item& item, const std::vector<Offer>& pool) {
    for (const Offer& offer : pool) {
      bool free =
          std::none_of(offer.atoms.begin(), offer.atoms.end(), [&](const auto& a) { return item.atoms.contains(a); });
      if (!free || offer.port_type != item.port_type || exported.targets.size() == 3) continue;
      exported.targets.push_back(offer.path);
      item.atoms.insert(offer.atoms.begin(), offer.atoms.end());
      item.weight += offer.weight;
      item.depth = std::max(item.depth, offer.depth);
    }
  }
  void export_data(const Component& component, const std::string& data, Ty type) {
    compound_.data_exports.push_back({component.name, data, "d" + std::to_string(compound_.data_exports.size()), type});
  }
  void make_data_exports() {
    for (const Component& component : compound_.components) {
      if (!component.size.empty()) continue;
      if (const AtomType* type = find_named(model_.atom_types, component.type)) {
        for (const Var& var : type->data) {
          if (var.exported && random_.percent(40)) export_data(component, var.name, var.type);
        }
      } else {
        for (const DataExport& inner : find_named(model_.compound_types, component.type)->data_exports) {
          if (random_.percent(50)) export_data(component, inner.name, inner.type);
        }
      }
    }
  }
  void choose_notation(bool is_root) {
    bool fits = style_.paper && is_root && compound_.priorities.empty() && compound_.data_exports.empty();
    for (const Component& component : compound_.components) fits = fits && component.size.empty();
    for (const Connector& connector : compound_.connectors) {
      const ConnectorType& type = *find_named(model_.connector_types, connector.type);
      fits = fits && connector.size.empty() && !type.exports && type.data.empty();
    }
    compound_.paper = fits;
  }

  Prng& random_;
  const Style& style_;
  Description& model_;
  std::map<std::string, Interface>& interfaces_;
  CodeMaker code_;
  CompoundType compound_;
  int atoms_ = 0;
  std::vector<Offer> offers_;
  std::set<std::string> bound_;
};

}  // namespace

void make_compound(Prng& random, const Style& style, Description& model, std::map<std::string, Interface>& interfaces,
                   const std::string& name, CompoundLevel level) {
  model.compound_types.push_back(CompoundMaker(random, style, model, interfaces).make(name, level));
}

}  // namespace bip::gen
