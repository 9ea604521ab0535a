// Unfolding the root: components depth first, in declaration order; then each compound's connectors and priorities.
#include "compiler/system/instantiate.hpp"
#include "runtime/include/bip/assert.hpp"

#include <algorithm>
#include <string_view>
#include <unordered_set>

#include "compiler/model/code_builder.hpp"
#include "compiler/model/packages.hpp"
#include "compiler/model/evaluate.hpp"
#include "compiler/system/expand_property.hpp"
#include "compiler/system/instantiator.hpp"
#include "compiler/system/system.hpp"

namespace bip::system {

std::optional<Value> Instantiator::value(ExprId expr, const std::vector<Value>& self, SourceRange at) {
  const model::Evaluated v = model::evaluate(model.code, expr, self);
  if (v.fault == model::Fault::None) return v.value;
  if (v.fault == model::Fault::Call) {
    diags.report(Diag::kB4008, at, "a C++ function, which runs with the system, is called");
    return std::nullopt;
  }
  diags.report(Diag::kB4008, at,
               v.fault == model::Fault::DivisionByZero ? "division by zero" : "-2147483648 / -1 does not fit an `int`");
  return std::nullopt;
}

bool Instantiator::is_beyond(std::size_t limit, std::size_t count, const char* what, SourceRange at) {
  if (count < limit || stopped) return stopped;
  diags.report(Diag::kB4006, at, limit, what).help("`--max-instances` sets another limit");
  return stopped = true;
}

// The arguments that are weights are above 0.
bool Instantiator::are_weights(const AtomType& type, const std::vector<Value>& args, SourceRange at) {
  for (const Transition& t : type.transitions) {
    if (t.weight.param >= args.size()) continue;
    const Value& arg = args[t.weight.param];
    const double weight = arg.type == Type::Float ? arg.float_value : arg.int_value;
    if (is_weight(weight)) continue;
    diags.report(Diag::kB4026, at, weight, type.variables[t.weight.param].name, type.ports[t.port].name);
    return false;
  }
  return true;
}

void Instantiator::component(std::uint32_t instance, const CompoundItem& item, const std::vector<Value>& self,
                             bool in_loop, std::size_t depth) {
  BIP_ASSERT(instance < instances.size(), "instance {} of {}", instance, instances.size());
  BIP_ASSERT(self.size() >= instances[instance].params.size(), "loop variables follow the parameters");
  const CompoundTypeId type_id = instances[instance].type;
  BIP_ASSERT(item.family < model.compound_types[type_id].components.size(), "component {} of {}", item.family,
             model.compound_types[type_id].components.size());
  const ComponentFamily& family = model.compound_types[type_id].components[item.family];
  std::int64_t first = 0;
  std::int64_t last = 0;
  if (item.index.is_valid()) {
    const SourceRange at = item.syntax->index->range;
    const std::optional<Value> n = value(item.index, self, at);
    if (!n) return;
    first = in_loop ? n->int_value : 0;
    last = in_loop ? first : static_cast<std::int64_t>(n->int_value) - 1;
    if (n->int_value < 0) {
      if (in_loop) diags.report(Diag::kB4014, at, fmt::format("{}[{}]", family.name, first), "an index is at least 0");
      else diags.report(Diag::kB4016, at, family.name, n->int_value);
      stopped = true;
      return;
    }
    // Before the first of them takes memory.
    const std::size_t others = family.is_compound ? out.compounds.size() : out.atoms.size();
    if (last > first &&
        too_many(others + static_cast<std::size_t>(last - first), family.is_compound ? "compounds" : "atoms", at))
      return;
    if (in_loop && too_many(static_cast<std::size_t>(first), "elements in an array", at)) return;
  }
  std::vector<Value> args;
  for (std::size_t k = 0; k < item.args.size(); ++k) {
    const auto& written = item.syntax->args;
    const bool by_position = k < written.size() && written[k].name.text.empty();
    const std::optional<Value> v =
        value(item.args[k], self, by_position ? written[k].value->range : item.syntax->name.range);
    if (!v) return;
    args.push_back(*v);
  }
  BIP_ASSERT(args.size() == item.args.size(), "one value per argument");
  if (!family.is_compound && !are_weights(model.atom_types[family.atom], args, item.syntax->name.range)) return;
  const CompoundId parent = instances[instance].row;
  const Loc loc = model.loc(item.range);
  for (std::int64_t i = first; i <= last && !stopped; ++i) {
    if (too_many(out.atoms.size(), "atoms", item.range) || too_many(out.compounds.size(), "compounds", item.range))
      return;
    std::string path = out.compounds[parent].path + "." + family.name;
    if (family.is_array) path += fmt::format("[{}]", i);
    auto& elements = instances[instance].components[item.family];
    if (elements.size() <= static_cast<std::size_t>(i)) elements.resize(static_cast<std::size_t>(i) + 1);
    if (elements[static_cast<std::size_t>(i)].row != Element::kHole) {
      diags.report(Diag::kB4015, item.syntax->name.range, fmt::format("{}[{}]", family.name, i));
      return;
    }
    std::uint32_t row = 0;
    if (family.is_compound) {
      row = compound(family.compound, args, std::move(path), parent, loc, depth + 1);
    } else {
      row = out.atoms.push({std::move(path), family.atom, parent, args, loc}).value;
    }
    BIP_ASSERT(family.is_compound ? row < instances.size() : row < out.atoms.size(), "row {} of component {}", row,
               family.name);
    instances[instance].components[item.family][static_cast<std::size_t>(i)].row = row;
  }
}

void Instantiator::declare_connector(std::uint32_t instance, const CompoundItem& item, const std::vector<Value>& self) {
  Instance& in = instances[instance];
  BIP_ASSERT(item.family < in.connectors.size(), "connector {} of {}", item.family, in.connectors.size());
  const ConnectorFamily& family = model.compound_types[in.type].connectors[item.family];
  if (too_many(out.connectors.size() + in.pending.size(), "connectors", item.range)) return;
  std::size_t index = 0;
  std::string name = family.name;
  if (item.index.is_valid()) {
    const SourceRange at = item.syntax->index->range;
    const std::optional<Value> n = value(item.index, self, at);
    if (!n) return;
    name += fmt::format("[{}]", n->int_value);
    if (n->int_value < 0) {
      diags.report(Diag::kB4014, at, name, "an index is at least 0");
      return;
    }
    if (too_many(static_cast<std::size_t>(n->int_value), "elements in an array", at)) return;
    index = static_cast<std::size_t>(n->int_value);
  }
  auto& elements = in.connectors[item.family];
  if (elements.size() <= index) elements.resize(index + 1, Element::kHole);
  if (elements[index] != Element::kHole) {
    diags.report(Diag::kB4015, item.syntax->name.range, name);
    return;
  }
  elements[index] = static_cast<std::uint32_t>(in.pending.size());
  in.pending.push_back({&item, self, item.family, std::move(name), {}, false});
}

void Instantiator::property(std::uint32_t instance, const CompoundItem& item, const std::vector<Value>& self) {
  const Instance& in = instances[instance];
  if (too_many(out.properties.size(), "properties", item.range)) return;
  // Without `ROOT.`, as traces have it.
  const std::string& path = out.compounds[in.row].path;
  const std::string scope = in.row.value == 0 ? std::string() : path.substr(path.find('.') + 1) + ".";
  std::string name = scope + std::string(item.syntax->name.text);
  if (item.index.is_valid()) {
    const std::optional<Value> n = value(item.index, self, item.syntax->index->range);
    if (!n) return;
    name += fmt::format("[{}]", n->int_value);
  }
  std::map<std::string, Value, std::less<>> constants;
  for (const OuterValue& v : item.values) {
    BIP_ASSERT(v.variable < self.size(), "value {} of {}", v.variable, self.size());
    constants.emplace(v.name, self[v.variable]);
  }
  const SourceRange written = item.syntax->property.range;
  Result<ExpandedProperty> whole = expand_property(item.syntax->property.text, scope, constants, model.code.strings);
  if (!whole) {
    diags.report(Diag::kB4030, written, name, whole.error());
    return;
  }
  if (!property_names.insert(name).second) {
    diags.report(Diag::kB4015, item.syntax->name.range, name);
    return;
  }
  StatedProperty& stated = out.properties.emplace_back();
  stated.name = std::move(name);
  stated.text = whole->text;
  stated.file = written.file;
  for (const std::uint32_t offset : whole->source) stated.source.push_back(written.begin + offset);
}

void Instantiator::items(std::uint32_t instance, const std::vector<CompoundItem>& list, std::vector<Value>& self,
                         std::size_t depth) {
  const std::size_t params = instances[instance].params.size();
  for (const CompoundItem& item : list) {
    if (stopped || diags.error_count() >= kEnoughErrors) return;
    switch (item.kind) {
      case ItemKind::Component: component(instance, item, self, self.size() > params, depth); break;
      case ItemKind::Connector: declare_connector(instance, item, self); break;
      case ItemKind::Priority: declare_priority(instance, item, self); break;
      case ItemKind::Property: property(instance, item, self); break;
      case ItemKind::For: {
        const std::optional<Value> low = value(item.low, self, item.syntax->low->range);
        const std::optional<Value> high = value(item.high, self, item.syntax->high->range);
        if (!low || !high) return;
        self.push_back({});
        // A round may declare nothing, so rounds are counted, too.
        for (std::int32_t i = low->int_value; i < high->int_value && !stopped && diags.error_count() < kEnoughErrors;
             ++i) {
          if (is_beyond(limits.instances * limits.rounds_per_instance, rounds++, "rounds of loops",
                        item.syntax->high->range))
            break;
          self.back() = {Type::Int, i, 0};
          const std::size_t scope = self.size();
          items(instance, item.items, self, depth);
          BIP_ASSERT(self.size() == scope, "a round of a loop leaves {} of {} variables", self.size(), scope);
        }
        self.pop_back();
        break;
      }
    }
  }
}

std::uint32_t Instantiator::compound(CompoundTypeId type, std::vector<Value> params, std::string path,
                                     CompoundId parent, Loc loc, std::size_t depth) {
  const CompoundType& t = model.compound_types[type];
  BIP_ASSERT(params.size() == t.params.size(), "{} values for {} parameters", params.size(), t.params.size());
  BIP_ASSERT(!parent.is_valid() || parent.value < out.compounds.size(), "parents come before their parts");
  const std::uint32_t row = static_cast<std::uint32_t>(instances.size());
  Instance in{
      .type = type, .row = {}, .params = params, .components = {}, .connectors = {}, .pending = {}, .priorities = {}};
  in.row = out.compounds.push({std::move(path), t.name, parent, loc});
  in.components.resize(t.components.size());
  in.connectors.resize(t.connectors.size());
  BIP_ASSERT(in.row.value == row, "compound {} is instance {}", in.row, row);
  instances.push_back(std::move(in));
  std::vector<Value> self = std::move(params);
  items(row, t.items, self, depth);
  // Each wrong connector is reported, but not what follows from a wrong component.
  if (diags.has_errors()) return row;
  // Not for each of many small compounds, which would move all rows each time.
  if (const std::size_t pending = instances[row].pending.size(); pending > out.connectors.size())
    out.connectors.reserve(out.connectors.size() + pending);
  for (std::uint32_t p = 0; p < instances[row].pending.size() && !stopped && diags.error_count() < kEnoughErrors; ++p)
    resolve_connector(row, p, 0);
  for (std::uint32_t e = 0; e < t.exports.size() && !stopped && !diags.has_errors(); ++e) exported_port(row, e, 0);
  if (!stopped && !diags.has_errors()) priorities(row);
  return row;
}

namespace {

/// The compound types that no other one instantiates and that need no parameter.
bool is_of_compiled_package(const Model& model, const CompoundType& type) {
  return type.decl->name.range.file == model.packages.back().file;
}

std::vector<CompoundTypeId> possible_roots(const Model& model) {
  std::vector<bool> used(model.compound_types.size());
  for (const CompoundType& t : model.compound_types) {
    for (const ComponentFamily& c : t.components) {
      if (c.compound.is_valid()) used[c.compound.value] = true;
    }
  }
  std::vector<CompoundTypeId> roots;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const CompoundType& t = model.compound_types[CompoundTypeId(i)];
    if (!used[i] && t.params.empty() && is_of_compiled_package(model, t)) roots.emplace_back(i);
  }
  return roots;
}

std::optional<CompoundTypeId> find_root(const Model& model, const std::string& name, Diagnostics& diags,
                                        SourceRange at) {
  if (name.empty()) {
    const std::vector<CompoundTypeId> roots = possible_roots(model);
    if (roots.size() == 1) return roots[0];
    if (roots.empty()) {
      const bool has_compounds =
          !model.compound_types.empty() && is_of_compiled_package(model, model.compound_types.rows().back());
      auto d = diags.report(Diag::kB4003, at,
                            has_compounds ? "every compound type has parameters or is part of another"
                                          : "there is no compound type to run");
      if (has_compounds) {
        const CompoundType& last = model.compound_types[CompoundTypeId(model.compound_types.size() - 1)];
        std::string params;
        for (const DataVariable& p : last.params) params += (params.empty() ? "" : ", ") + p.name;
        d.help(fmt::format("name the root and its arguments: `--root '{}({})'`", last.name, params));
      }
      return std::nullopt;
    }
    std::string names;
    for (const CompoundTypeId r : roots) names += (names.empty() ? "`" : ", `") + model.compound_types[r].name + "`";
    diags.report(Diag::kB4004, at, names)
        .help(fmt::format("choose one: `--root '{}()'`", model.compound_types[roots.back()].name));
    return std::nullopt;
  }
  const TypeName* type = model::find_visible(model, model.type_names, name, at, diags);
  if (type != nullptr && type->kind == TypeName::Kind::Compound) return CompoundTypeId(type->row);
  auto d = diags.report(Diag::kB4005, at, name);
  std::vector<std::string> known;
  for (const CompoundType& t : model.compound_types) known.push_back(t.name);
  if (type != nullptr && type->kind == TypeName::Kind::Atom)
    d.note(fmt::format("`{}` is an atom type; a root is a compound, which joins components by connectors", name));
  const std::vector<std::string> similar = similar_names(name, known);
  const SourceRange named{at.file, at.begin, std::min(at.end, at.begin + static_cast<std::uint32_t>(name.size()))};
  for (const std::string& s : similar) d.help(fmt::format("`{}` has a similar name", s), named, s);
  if (similar.empty() && !known.empty()) {
    std::string list;
    for (std::size_t k = 0; k < std::min<std::size_t>(known.size(), 8); ++k)
      list += (list.empty() ? "`" : ", `") + known[k] + "`";
    d.note("the compound types are " + list + (known.size() > 8 ? " and others" : ""));
    const std::vector<CompoundTypeId> roots = possible_roots(model);
    if (!roots.empty()) {
      const std::string& root = model.compound_types[roots.back()].name;
      d.help(fmt::format("`--root '{}'`", root), at, root);
    }
  }
  return std::nullopt;
}

[[maybe_unused]] bool paths_are_unique(const System& system) {
  std::unordered_set<std::string_view> paths;
  const auto is_new = [&paths](const auto& row) { return paths.insert(row.path).second; };
  return std::all_of(system.compounds.begin(), system.compounds.end(), is_new) &&
         std::all_of(system.atoms.begin(), system.atoms.end(), is_new) &&
         std::all_of(system.connectors.begin(), system.connectors.end(), is_new);
}

}  // namespace

std::optional<System> instantiate(Model& model, const std::string& root_type,
                                  const std::vector<const syntax::Expr*>& args, Diagnostics& diags,
                                  SourceRange root_range, const UnfoldingLimits& limits) {
  BIP_ASSERT(limits.instances <= kMostInstances, "{} instances have no numbers", limits.instances);
  const std::optional<CompoundTypeId> root = find_root(model, root_type, diags, root_range);
  if (!root) return std::nullopt;
  const CompoundType& type = model.compound_types[*root];
  if (args.size() != type.params.size()) {
    std::string params, with;
    for (const DataVariable& p : type.params) {
      params += (params.empty() ? "" : ", ") + std::string(name_of(p.type)) + " " + p.name;
      with += (with.empty() ? "" : ", ") + std::string(p.type == Type::Bool     ? "true"
                                                       : p.type == Type::String ? "\"\""
                                                                                : "1");
    }
    with = type.name + "(" + with + ")";
    diags
        .report(Diag::kB1015, root_range, model::counted(args.size(), "argument"),
                fmt::format("compound type `{}`", type.name), type.params.size())
        .note(fmt::format("it is declared `compound type {}({})`", type.name, params))
        .help(fmt::format("write `--root '{}'`{}", with, type.params.empty() ? "" : ", for example"), root_range, with);
    return std::nullopt;
  }
  Instantiator unfold{model, diags, limits};
  std::vector<Value> params;
  const model::Scope empty{.names = {}, .owner = "the root's arguments"};
  for (std::size_t i = 0; i < args.size(); ++i) {
    model::CodeBuilder code(model, diags, empty);
    const ExprId id = code.expr_as(args[i], type.params[i].type, fmt::format("argument `{}`", type.params[i].name));
    const std::optional<Value> v = unfold.value(id, {}, args[i]->range);
    if (v) params.push_back(*v);
  }
  if (diags.has_errors()) return std::nullopt;
  if (unfold.is_too_large(*root)) return std::nullopt;
  unfold.out.files = model.files;
  unfold.compound(*root, std::move(params), "ROOT", {}, type.loc, 0);
  if (diags.has_errors()) return std::nullopt;
  System system = std::move(unfold.out);
  system.code = model.code;
  system.port_types = model.port_types;
  system.atom_types = model.atom_types;
  system.connector_types = model.connector_types;
  drop_unused_types(system, model.packages.back().file.value);
  BIP_ASSERT(paths_are_unique(system), "no two instances have one path");
  return system;
}

}  // namespace bip::system
