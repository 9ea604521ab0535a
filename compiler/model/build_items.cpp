// Items of a compound: components with their arguments, connectors with their bindings, loops.
#include <algorithm>

#include "compiler/model/build_weight.hpp"
#include "compiler/model/compound_builder.hpp"
#include "compiler/model/suggest.hpp"

namespace bip::model {

CompoundItem CompoundBuilder::item(const syntax::CompoundItem& i) {
  CompoundItem row{.range = i.range,
                   .index = {},
                   .args = {},
                   .type = {},
                   .ports = {},
                   .data = {},
                   .syntax = &i,
                   .low = {},
                   .high = {},
                   .items = {}};
  switch (i.kind) {
    case syntax::ItemKind::Component:
      row.kind = ItemKind::Component;
      component_item(i, row);
      break;
    case syntax::ItemKind::Connector:
      row.kind = ItemKind::Connector;
      connector_item(i, row);
      break;
    case syntax::ItemKind::Priority:
      row.kind = ItemKind::Priority;
      if (i.index != nullptr) row.index = CodeBuilder(b.model, b.diags, scope).expr_as(i.index, Type::Int, "the index");
      row.family = static_cast<std::uint32_t>(out.priorities.size());
      build_priority(*i.priority);
      out.priorities[row.family].in_loop = true;
      break;
    case syntax::ItemKind::Property:
      row.kind = ItemKind::Property;
      if (i.index != nullptr) row.index = CodeBuilder(b.model, b.diags, scope).expr_as(i.index, Type::Int, "the index");
      for (const auto& [name, known] : scope.names) row.values.push_back({name, known.index, known.type});
      break;
    case syntax::ItemKind::For: {
      row.kind = ItemKind::For;
      CodeBuilder code(b.model, b.diags, scope);
      row.low = code.expr_as(i.low, Type::Int, "the loop's start");
      row.high = code.expr_as(i.high, Type::Int, "the loop's end");
      row.loop_variable = static_cast<std::uint32_t>(out.params.size()) + loop_depth;
      const std::string name(i.name.text);
      if (const auto taken = scope.names.find(name); taken != scope.names.end()) {
        b.diags.report(Diag::kB1002, i.name.range, name, fmt::format("compound type `{}`", out.name))
            .label(taken->second.declared, "declared here");
        break;
      }
      scope.names[name] = {.load = Op::LoadSelf,
                           .index = row.loop_variable,
                           .type = Type::Int,
                           .read_only = "a loop variable",
                           .value = {},
                           .declared = i.name.range};
      ++loop_depth;
      for (const syntax::CompoundItem* inner : i.items) row.items.push_back(item(*inner));
      --loop_depth;
      scope.names.erase(name);
      break;
    }
  }
  return row;
}

std::vector<ExprId> CompoundBuilder::arguments(const syntax::CompoundItem& i, const ComponentFamily& family) {
  static const std::vector<DataVariable> kNone;
  const std::vector<DataVariable>& variables = family.atom.is_valid() ? b.model.atom_types[family.atom].variables
                                               : family.compound.is_valid()
                                                   ? b.model.compound_types[family.compound].params
                                                   : kNone;
  std::vector<const DataVariable*> params;
  for (const DataVariable& s : variables) {
    if (s.is_param) params.push_back(&s);
  }
  const std::string what = fmt::format("component type `{}`", b.text(i.type.name));
  std::vector<ExprId> args(params.size());
  std::vector<SourceRange> given(params.size());
  bool sound = true;
  CodeBuilder code(b.model, b.diags, scope);
  std::size_t position = 0;
  std::size_t positional = 0;
  for (const syntax::NamedArg& arg : i.args) {
    std::size_t k = 0;
    if (arg.name.text.empty()) {
      ++positional;
      k = position++;
      if (k >= params.size()) continue;
    } else {
      const std::string name(arg.name.text);
      while (k < params.size() && shown_name(params[k]->name) != name) ++k;
      if (k == params.size()) {
        std::vector<std::string> known;
        for (const DataVariable* s : params) known.emplace_back(shown_name(s->name));
        auto d = b.diags.report(Diag::kB1032, arg.name.range, what, name);
        if (!known.empty()) d.note(fmt::format("its parameters: {}", quoted_list(known)));
        help_similar(d, name, arg.name.range, known);
        code.expr(arg.value);
        sound = false;
        continue;
      }
    }
    if (given[k].is_valid()) {
      b.diags.report(Diag::kB1033, arg.value->range, shown_name(params[k]->name)).label(given[k], "given here");
      sound = false;
    }
    given[k] = arg.value->range;
    args[k] = code.expr_as(arg.value, params[k]->type, fmt::format("argument `{}`", shown_name(params[k]->name)));
  }
  const std::size_t required = static_cast<std::size_t>(std::count_if(
      params.begin(), params.end(), [](const DataVariable* s) { return !s->name.starts_with("initial "); }));
  const bool all_given = std::all_of(args.begin(), args.begin() + static_cast<std::ptrdiff_t>(required),
                                     [](ExprId a) { return a.is_valid(); });
  const bool is_known = family.atom.is_valid() || family.compound.is_valid();
  if (sound && is_known && (positional > params.size() || !all_given)) {
    std::vector<const DataVariable*> wanted(params.begin(), params.begin() + static_cast<std::ptrdiff_t>(required));
    std::vector<SourceRange> ranges;
    for (const syntax::NamedArg& arg : i.args) ranges.push_back(arg.value->range);
    auto d = b.diags
                 .report(Diag::kB1015, i.name.range, counted(i.args.size(), "argument"), what,
                         required == params.size() ? fmt::format("{}", required)
                                                   : fmt::format("{} to {}", required, params.size()))
                 .label(b.declared(i.type.name), "declared here");
    if (positional > params.size()) wanted = params;
    if (positional == i.args.size() && i.index == nullptr) help_arguments(d, b.model, wanted, i.name.range, ranges);
  }
  for (std::size_t k = 0; k < args.size(); ++k) {
    if (!args[k].is_valid()) args[k] = b.initial_value(family, params[k]->name, params[k]->type);
  }
  return args;
}

void CompoundBuilder::component_item(const syntax::CompoundItem& i, CompoundItem& row) {
  const auto it = components.find(std::string(i.name.text));
  if (it == components.end()) return;
  row.family = it->second;
  const ComponentFamily& family = out.components[row.family];
  if (i.index != nullptr)
    row.index =
        CodeBuilder(b.model, b.diags, scope).expr_as(i.index, Type::Int, loop_depth > 0 ? "the index" : "the size");
  const TypeName* type = b.find_type(i.type.name);
  const bool same = type != nullptr &&
                    (family.is_compound ? type->kind == TypeName::Kind::Compound && family.compound.value == type->row
                                        : type->kind == TypeName::Kind::Atom && family.atom.value == type->row);
  if (!same && (family.atom.is_valid() || family.compound.is_valid())) {
    b.diags.report(Diag::kB4013, i.type.name.range, family.name)
        .label("another type")
        .label(family.range, "first declared here");
    return;
  }
  row.args = arguments(i, family);
}

// The elements of an array of connectors may have several types; what others bind, the exported port, may not.
void CompoundBuilder::check_same_export(const syntax::CompoundItem& i, const ConnectorType& type,
                                        const ConnectorFamily& family) {
  const bool same_type = !type.exports || !family.export_type.is_valid() || type.export_type == family.export_type;
  if (type.exports == family.exports && same_type) return;
  b.diags.report(Diag::kB4013, i.name.range, family.name)
      .label("another exported port")
      .label(family.range, "first declared here");
}

void CompoundBuilder::connector_item(const syntax::CompoundItem& i, CompoundItem& row) {
  const auto it = connectors.find(std::string(i.name.text));
  if (it == connectors.end()) return;
  row.family = it->second;
  const bool first_time = connector_states[row.family] == BuildState::Untouched;
  if (first_time) connector_states[row.family] = BuildState::Building;
  if (i.index != nullptr) row.index = CodeBuilder(b.model, b.diags, scope).expr_as(i.index, Type::Int, "the index");
  bool sound = true;
  for (const syntax::Path& path : i.ports) {
    PortPath& port = row.ports.emplace_back();
    sound &= port_path(path, port);
    row.has_star |= port.element.star;
  }
  if (i.inline_body != nullptr) {
    ConnectorType type{.name = out.name + "." + std::string(i.name.text), .loc = b.loc(i.name.range)};
    const std::vector<DataRead> reads = data_reads(i, row);
    if (sound)
      build_inline_connector(b, i, row.ports, std::vector<std::uint32_t>(row.ports.size(), 1), reads,
                             outer_bindings(b.model.code, row.values, nullptr), type);
    if (sound) check_same_export(i, type, out.connectors[row.family]);
    out.connectors[row.family].export_type = type.export_type;
    row.type = b.model.connector_types.push(std::move(type));
  } else if (const TypeName* t = b.find_type(i.type.name); t != nullptr && t->kind == TypeName::Kind::Connector) {
    row.type = ConnectorTypeId(t->row);
    const ConnectorType& type = b.model.connector_types[row.type];
    check_same_export(i, type, out.connectors[row.family]);
    if (!row.has_star && type.params.size() != i.ports.size()) {
      auto d =
          b.diags.report(Diag::kB2022, i.name.range, counted(i.ports.size(), "port"), type.name, type.params.size())
              .label(b.declared(type.name), "declared here");
      for (std::size_t k = i.ports.size(); k < type.params.size(); ++k)
        d.note(fmt::format("`{}` is not bound; it is {}", type.params[k].name,
                           port_type_text(b.model, type.params[k].type)));
      if (i.ports.size() > type.params.size() && !type.params.empty()) {
        const SourceRange surplus{i.name.range.file, i.ports[type.params.size() - 1].range.end,
                                  i.ports.back().range.end};
        d.help(fmt::format("leave `{}` out", b.model.sources->text(surplus)), surplus, "");
      }
    } else if (!row.has_star && sound) {
      for (std::size_t k = 0; k < i.ports.size(); ++k) {
        const ConnectorParam& param = type.params[k];
        if (fits(b.model, row.ports[k].type, param.type)) continue;
        b.diags
            .report(Diag::kB2023, i.ports[k].range, b.text(i.ports[k]), port_type_text(b.model, row.ports[k].type),
                    param.name, type.name, port_type_text(b.model, param.type))
            .label(b.declared(type.name), "declared here");
      }
    }
  }
  row.weight = build_weight(b, i, row.type.is_valid() && b.model.connector_types[row.type].exports);
  if (first_time) connector_states[row.family] = BuildState::Done;
}

}  // namespace bip::model
