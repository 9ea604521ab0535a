// See debug_model.hpp.
#include "compiler/base/ascii.hpp"
#include "compiler/debug/debug_model.hpp"
#include "compiler/system/system.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/verify/property/expression.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/event_file.hpp"

namespace bip::debug {

namespace {

constexpr std::uint32_t kNoRow = 0xffffffffu;

template <class Rows>
std::uint32_t row_of_path(const Rows& rows, const std::string& path) {
  std::uint32_t row = 0;
  for (const auto& component : rows) {
    if (component.path == path) return row;
    ++row;
  }
  return kNoRow;
}

template <class Rows>
std::uint32_t row_of_name(const Rows& rows, std::string_view name) {
  for (std::uint32_t row = 0; row < rows.size(); ++row) {
    if (rows[row].name == name) return row;
  }
  return kNoRow;
}

bool is_number_text(std::string_view text) {
  return !text.empty() && text.size() <= 9 && text.find_first_not_of("0123456789") == std::string_view::npos;
}

std::string_view file_name(std::string_view path) { return path.substr(path.rfind('/') + 1); }

}  // namespace

std::uint32_t DebugModel::find_atom(const std::string& path) const { return row_of_path(system_->atoms, path); }
std::uint32_t DebugModel::find_connector(const std::string& path) const {
  return row_of_path(system_->connectors, path);
}

std::optional<Named> DebugModel::find(std::string_view given) const {
  BIP_ASSERT(system_->atoms.size() == image_->atoms.size && system_->connectors.size() == image_->connectors.size,
             "{} atoms of the system, {} of the image", system_->atoms.size(), image_->atoms.size);
  const std::string text = rt::whole_path(trimmed(given));
  if (const std::size_t at = text.find('@'); at != std::string::npos) {
    const std::uint32_t atom = find_atom(text.substr(0, at));
    if (atom == kNoRow) return std::nullopt;
    const std::vector<std::string>& places = system_->atom_types[system_->atoms[AtomId(std::size_t{atom})].type].places;
    const auto place = std::find(places.begin(), places.end(), text.substr(at + 1));
    if (place == places.end()) return std::nullopt;
    return Named{Named::Kind::Place, atom, static_cast<std::uint32_t>(place - places.begin())};
  }
  if (const std::uint32_t atom = find_atom(text); atom != kNoRow) return Named{Named::Kind::Atom, atom, 0};
  if (const std::uint32_t row = find_connector(text); row != kNoRow) return Named{Named::Kind::Connector, row, 0};
  const std::size_t dot = text.rfind('.');
  const std::uint32_t atom = dot == std::string::npos ? kNoRow : find_atom(text.substr(0, dot));
  if (atom == kNoRow) return std::nullopt;
  const AtomType& type = system_->atom_types[system_->atoms[AtomId(std::size_t{atom})].type];
  const std::string_view name = std::string_view(text).substr(dot + 1);
  if (const std::uint32_t row = row_of_name(type.ports, name); row != kNoRow)
    return Named{Named::Kind::Port, atom, row};
  if (const std::uint32_t row = row_of_name(type.variables, name); row != kNoRow)
    return Named{Named::Kind::Data, atom, row};
  return std::nullopt;
}

Result<std::function<bool(const rt::Core&)>> DebugModel::parse_condition(const std::string& text) const {
  const std::string_view shown = trimmed(text);
  const bool is_property = shown.starts_with("never ") || shown.starts_with("always ");
  Result<verify::Property> parsed =
      is_property ? verify::parse_property(text, *system_) : verify::parse_expression(text, *system_);
  if (!parsed) return Failure{parsed.error()};
  verify::Property property = std::move(*parsed);
  if (is_property)
    return std::function<bool(const rt::Core&)>(
        [property = std::move(property)](const rt::Core& core) { return verify::is_broken(property, core); });
  if (property.nodes[property.root].type != Type::Bool) return Failure{"a condition is true or false"};
  return std::function<bool(const rt::Core&)>(
      [property = std::move(property)](const rt::Core& core) { return verify::is_true(property, core); });
}

Result<std::string> DebugModel::evaluate(const std::string& text, const rt::Core& core) const {
  const Result<verify::Property> parsed = verify::parse_expression(text, *system_);
  if (!parsed) return Failure{parsed.error()};
  return verify::value_text(*parsed, core);
}

Result<rt::Cell> DebugModel::parse_value(const std::string& given, rt::CellType type) const {
  const std::string text(trimmed(given));
  rt::Cell cell{};
  const char* const end = text.data() + text.size();
  switch (type) {
    case rt::CellType::Int:
      if (const auto read = std::from_chars(text.data(), end, cell.i); read.ec == std::errc() && read.ptr == end)
        return cell;
      return Failure{fmt::format("`{}` is no int", text)};
    case rt::CellType::Bool:
      if (text != "true" && text != "false") return Failure{fmt::format("`{}` is neither true nor false", text)};
      cell.i = text == "true" ? 1 : 0;
      return cell;
    case rt::CellType::Float:
      if (const auto read = std::from_chars(text.data(), end, cell.f); read.ec == std::errc() && read.ptr == end)
        return cell;
      return Failure{fmt::format("`{}` is no float", text)};
    case rt::CellType::String: break;
  }
  if (rt::is_ffi(type)) return Failure{"an object of C++ cannot be set"};
  for (std::uint32_t row = 0; row < image_->strings.size; ++row) {
    std::string quoted;
    rt::append_quoted(quoted, image_->strings[row]);
    if (quoted != text) continue;
    cell.i = static_cast<std::int32_t>(row);
    return cell;
  }
  return Failure{fmt::format("{} is no string constant of the model", text)};
}

std::uint32_t DebugModel::next_line(std::uint32_t file, std::uint32_t line) const {
  std::uint32_t best = 0;
  const auto look = [&](const rt::SourceLine& loc) {
    if (loc.file == file && loc.line >= line && loc.line != 0 && (best == 0 || loc.line < best)) best = loc.line;
  };
  for (const rt::AtomType& type : image_->atom_types) {
    for (const rt::Transition& transition : type.transitions) {
      if (transition.port != rt::kNone) look(transition.loc);
    }
  }
  for (const rt::ConnectorType& type : image_->connector_types) look(type.loc);
  for (const rt::Connector& connector : image_->connectors) look(connector.loc);
  return best;
}

// `12`, `dine.bip:12`; the file's last name is enough.
std::optional<rt::Breakpoint> DebugModel::parse_line(const std::string& text, std::string& problem) const {
  const std::size_t colon = text.rfind(':');
  const std::string_view number = std::string_view(text).substr(colon == std::string::npos ? 0 : colon + 1);
  if (!is_number_text(number)) return std::nullopt;
  const std::string_view file = colon == std::string::npos ? "" : std::string_view(text).substr(0, colon);
  std::uint32_t row = 0;
  const auto is_meant = [&](const char* name) {
    return file.empty() || name == file || file_name(name) == file_name(file);
  };
  while (row < image_->files.size && !is_meant(image_->files[row])) ++row;
  if (row == image_->files.size) {
    problem = fmt::format("no file `{}` belongs to the model", file);
    return std::nullopt;
  }
  std::uint32_t line = 0;
  std::from_chars(number.data(), number.data() + number.size(), line);
  if (line == 0 || next_line(row, line) != line) {
    const std::uint32_t next = next_line(row, line);
    problem = fmt::format("no transition with a port and no connector is at line {}", line);
    if (next != 0) problem += fmt::format("; the next one is at line {}", next);
    return std::nullopt;
  }
  rt::Breakpoint made;
  made.kind = rt::BreakKind::Line;
  made.owner = row;
  made.row = line;
  return made;
}

Result<rt::Breakpoint> DebugModel::parse_breakpoint(const std::string& text) const {
  const std::string_view whole = trimmed(text);
  const std::size_t found = whole.find(" if ");
  const std::string what(trimmed(whole.substr(0, found)));
  std::function<bool(const rt::Core&)> condition;
  if (found != std::string_view::npos) {
    Result<std::function<bool(const rt::Core&)>> parsed = parse_condition(std::string(whole.substr(found + 4)));
    if (!parsed) return Failure{parsed.error()};
    condition = std::move(*parsed);
  }
  rt::Breakpoint made;
  std::string problem;
  if (what.starts_with('@')) {
    made.kind = rt::BreakKind::Time;
    made.instant = rt::parse_time(std::string_view(what).substr(1));
    if (made.instant < 0) return Failure{fmt::format("`{}` is no instant", what.substr(1))};
  } else if (std::optional<rt::Breakpoint> line = parse_line(what, problem)) {
    made = std::move(*line);
  } else if (!problem.empty()) {
    return Failure{problem};
  } else if (const std::optional<Named> named = find(what); named && named->kind != Named::Kind::Atom) {
    made.owner = named->owner;
    made.row = named->row;
    switch (named->kind) {
      case Named::Kind::Connector: made.kind = rt::BreakKind::Interaction; break;
      case Named::Kind::Port: made.kind = rt::BreakKind::Port; break;
      case Named::Kind::Place: made.kind = rt::BreakKind::Place; break;
      case Named::Kind::Data: made.kind = rt::BreakKind::Data; break;
      case Named::Kind::Atom: break;
    }
    if (made.kind == rt::BreakKind::Interaction && !system_->is_top(ConnectorId(std::size_t{named->owner})))
      return Failure{fmt::format("connector `{}` exports a port: it is a part of others", what)};
  } else {
    Result<std::function<bool(const rt::Core&)>> parsed = parse_condition(what);
    if (!parsed) return Failure{parsed.error()};
    made.kind = rt::BreakKind::Condition;
    if (!condition) {
      condition = std::move(*parsed);
    } else {
      condition = [both = std::move(condition), first = std::move(*parsed)](const rt::Core& core) {
        return first(core) && both(core);
      };
    }
  }
  made.condition = std::move(condition);
  made.text = std::string(whole);
  return made;
}

std::vector<std::string> DebugModel::complete(const std::string& begin, std::size_t most) const {
  std::vector<std::string> found;
  const auto offer = [&](const std::string& name) {
    if (found.size() < most && name.starts_with(begin)) found.push_back(name);
  };
  for (const Atom& atom : system_->atoms) {
    if (found.size() == most) break;
    const std::string path = rt::relative(atom.path.c_str());
    offer(path);
    // Its parts only if the text goes on behind the path.
    if (!begin.starts_with(path)) continue;
    const AtomType& type = system_->atom_types[atom.type];
    for (const auto& port : type.ports) offer(path + "." + port.name);
    for (const auto& variable : type.variables) offer(path + "." + variable.name);
    for (const std::string& place : type.places) offer(path + "@" + place);
  }
  for (const Connector& connector : system_->connectors) offer(rt::relative(connector.path.c_str()));
  return found;
}

}  // namespace bip::debug
