// `ndd.RflexPoster.read`: what a compound exports, named by where it lies within it. A path goes through a compound
// only where this exports what the rest of the path names: nothing becomes visible that is not exported. An index along
// the way is compared as written. Cost: the exports of each compound on the path.
#include <algorithm>

#include "compiler/model/compound_builder.hpp"

namespace bip::model {

namespace {

const ComponentFamily* component_named(const CompoundType& type, std::string_view name) {
  const auto found = std::find_if(type.components.begin(), type.components.end(),
                                  [&](const ComponentFamily& f) { return f.name == name; });
  return found == type.components.end() ? nullptr : &*found;
}

// The rest of a path as two parts, `PolarPoster.read`: what lies deeper goes by the name under which it comes that far.
struct Through {
  const Model& model;
  const SourceMap& sources;

  [[nodiscard]] std::string key(std::span<const syntax::PathPart> parts) const {
    return path_key({parts, {}}, sources);
  }

  // What an export of `type` shows, "component.port", as it is called there.
  [[nodiscard]] std::string shown(const CompoundType& type, const PortPath& target) const {
    const auto& parts = target.path->parts;
    std::string_view last = parts.back().name.text;
    if (target.is_connector) {
      last = type.connectors[target.element.family].export_name;
    } else if (parts.size() > 2) {
      last = model.compound_types[type.components[target.element.family].compound].exports[target.port].name;
    }
    return fmt::format("{}.{}", key(parts.subspan(0, 1)), last);
  }
  [[nodiscard]] std::string shown(const CompoundType& type, const DataPath& target) const {
    const auto& parts = target.path->parts;
    std::string_view last = parts.back().name.text;
    if (parts.size() > 2)
      last = model.compound_types[type.components[target.element.family].compound].data_exports[target.variable].name;
    return fmt::format("{}.{}", key(parts.subspan(0, 1)), last);
  }

  // The row of `type`'s exports that shows `parts`, of at least two. `merged`: an export that shows others, too.
  [[nodiscard]] std::optional<std::uint32_t> port(const CompoundType& type, std::span<const syntax::PathPart> parts,
                                                  const PortExport** merged) const {
    std::string wanted = key(parts);
    if (parts.size() > 2) {
      const ComponentFamily* inner = component_named(type, parts[0].name.text);
      if (inner == nullptr || !inner->compound.is_valid()) return std::nullopt;
      const CompoundType& within = model.compound_types[inner->compound];
      const std::optional<std::uint32_t> row = port(within, parts.subspan(1), merged);
      if (!row) return std::nullopt;
      wanted = fmt::format("{}.{}", key(parts.subspan(0, 1)), within.exports[*row].name);
    }
    for (std::uint32_t e = 0; e < type.exports.size(); ++e) {
      for (const PortPath& target : type.exports[e].targets) {
        if (shown(type, target) != wanted) continue;
        if (type.exports[e].targets.size() == 1) return e;
        *merged = &type.exports[e];
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<std::uint32_t> data(const CompoundType& type,
                                                  std::span<const syntax::PathPart> parts) const {
    std::string wanted = key(parts);
    if (parts.size() > 2) {
      const ComponentFamily* inner = component_named(type, parts[0].name.text);
      if (inner == nullptr || !inner->compound.is_valid()) return std::nullopt;
      const CompoundType& within = model.compound_types[inner->compound];
      const std::optional<std::uint32_t> row = data(within, parts.subspan(1));
      if (!row) return std::nullopt;
      wanted = fmt::format("{}.{}", key(parts.subspan(0, 1)), within.data_exports[*row].name);
    }
    for (std::uint32_t e = 0; e < type.data_exports.size(); ++e) {
      if (shown(type, type.data_exports[e].target) == wanted) return e;
    }
    return std::nullopt;
  }
};

}  // namespace

bool CompoundBuilder::deep_port_path(const syntax::Path& path, PortPath& ref) {
  const syntax::PathPart& first = path.parts[0];
  const auto c = components.find(std::string(first.name.text));
  if (c == components.end() || !out.components[c->second].is_compound) {
    b.diags.report(Diag::kB2017, path.range, b.text(path)).note(fmt::format("`{}` is no compound", first.name.text));
    return false;
  }
  const ComponentFamily& family = out.components[c->second];
  ref.element.family = c->second;
  if (!element(first, family.is_array, ref.element, fmt::format("component `{}`", first.name.text)) ||
      !family.compound.is_valid())
    return false;
  const CompoundType& type = b.model.compound_types[family.compound];
  const auto rest = path.parts.subspan(1);
  const PortExport* merged = nullptr;
  if (const auto row = Through{b.model, b.sources}.port(type, rest, &merged)) {
    ref.port = *row, ref.type = type.exports[*row].type;
    bound_ports[c->second][*row] = true;
    return true;
  }
  const syntax::Path inner{rest, {path.range.file, rest.front().name.range.begin, path.range.end}};
  auto d = b.diags.report(Diag::kB2050, inner.range, b.text(inner), type.name);
  if (merged != nullptr) {
    d.note(fmt::format("`{}` shows it together with others", merged->name));
  } else if (component_named(type, rest[0].name.text) == nullptr) {
    std::vector<std::string> known;
    for (const ComponentFamily& f : type.components) known.push_back(f.name);
    d.note(fmt::format("there is no component `{}` in `{}`", rest[0].name.text, type.name));
    help_similar(d, rest[0].name.text, rest[0].name.range, known);
  } else {
    d.help(fmt::format("write `export port {} as {}` in `{}`", b.text(inner), rest.back().name.text, type.name));
  }
  return false;
}

std::optional<std::pair<std::uint32_t, Type>> CompoundBuilder::deep_data(
    const ComponentFamily& family, std::span<const syntax::PathPart> parts) const {
  if (parts.size() == 1) return exported_data(b.model, family, parts[0].name.text);
  if (!family.compound.is_valid()) return std::nullopt;
  const CompoundType& type = b.model.compound_types[family.compound];
  const auto row = Through{b.model, b.sources}.data(type, parts);
  if (!row) return std::nullopt;
  return std::pair{*row, type.data_exports[*row].target.type};
}

}  // namespace bip::model
