// See event_ports.hpp.
#include "runtime/engine/event_ports.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "bip/ffi.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

namespace {

const char* name_of(CellType type) {
  switch (type) {
    case CellType::Int: return "an int";
    case CellType::Bool: return "a bool";
    case CellType::Float: return "a float";
    case CellType::String: return "a string";
  }
  return "a C++ object";
}

bool fits(CellType type, const EventValue& value) {
  switch (type) {
    case CellType::Int: return std::holds_alternative<std::int32_t>(value);
    case CellType::Bool: return std::holds_alternative<bool>(value);
    case CellType::Float: return std::holds_alternative<double>(value);
    case CellType::String: return std::holds_alternative<std::string>(value);
  }
  return false;
}

}  // namespace

EventPorts::EventPorts(const Core& core) : image_(core.image()), rows_(core.events().ports()) {
  for (u32 row = 0; row < rows_.size(); ++row) by_path_.push_back(row);
  std::sort(by_path_.begin(), by_path_.end(), [this](u32 a, u32 b) { return path(a) < path(b); });
}

std::string EventPorts::path(u32 row) const {
  BIP_ASSERT(row < rows_.size(), "port {} of {}", row, rows_.size());
  const Atom& atom = image_.atoms[rows_[row].atom];
  return atom.path() + '.' + image_.atom_types[atom.type].ports[rows_[row].port].name;
}

u32 EventPorts::find(std::string_view text) const {
  const std::string wanted = whole_path(text);
  const auto at = std::lower_bound(by_path_.begin(), by_path_.end(), wanted,
                                   [this](u32 row, const std::string& key) { return path(row) < key; });
  return at != by_path_.end() && path(*at) == wanted ? *at : kNone;
}

u32 EventPorts::find_atom(std::string_view text) const {
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    const AtomTime* time = image_.atom_types[image_.atoms[atom].type].time;
    if (time == nullptr || text != image_.atoms[atom].path()) continue;
    for (const TransitionTime& transition : time->transitions) {
      if (transition.async.present) return atom;
    }
  }
  return kNone;
}

const Span<Var>& EventPorts::vars(u32 row) const {
  const AtomType& type = image_.atom_types[image_.atoms[rows_[row].atom].type];
  return image_.port_types[type.ports[rows_[row].port].type].vars;
}

std::string EventPorts::check(u32 row, std::vector<EventValue>& values) const {
  const Span<Var>& wanted = vars(row);
  std::string problem;
  if (values.size() != wanted.size) {
    problem = "`" + path(row) + "` takes ";
    append_number(problem, wanted.size);
    problem += wanted.size == 1 ? " value, not " : " values, not ";
    append_number(problem, values.size());
    return problem;
  }
  for (u32 i = 0; i < wanted.size; ++i) {
    if (const auto* whole = std::get_if<std::int32_t>(&values[i]);
        whole != nullptr && wanted[i].type == CellType::Float)
      values[i] = static_cast<double>(*whole);
    if (!fits(wanted[i].type, values[i]))
      return "`" + std::string(wanted[i].name) + "` of `" + path(row) + "` is " + name_of(wanted[i].type);
  }
  return problem;
}

void EventPorts::to_cells(u32 row, const std::vector<EventValue>& values, std::vector<Cell>& out) const {
  const Span<Var>& wanted = vars(row);
  BIP_ASSERT(values.size() == wanted.size, "{} values for {} variables", values.size(), wanted.size);
  out.clear();
  for (u32 i = 0; i < wanted.size; ++i) {
    Cell cell{0};
    if (const auto* truth = std::get_if<bool>(&values[i])) cell.i = *truth ? 1 : 0;
    else if (const auto* whole = std::get_if<std::int32_t>(&values[i])) cell.i = *whole;
    else if (const auto* real = std::get_if<double>(&values[i])) cell.f = *real;
    else if (const auto* text = std::get_if<std::string>(&values[i])) cell.i = image_.ffi->intern(*text);
    BIP_ASSERT(fits(wanted[i].type, values[i]), "value {} of port {} has another type", i, row);
    out.push_back(cell);
  }
}

EventValue EventPorts::from_cell(CellType type, Cell cell) const {
  switch (type) {
    case CellType::Int: break;
    case CellType::Bool: return cell.i != 0;
    case CellType::Float: return cell.f;
    case CellType::String: return std::string(string_of(image_, cell));
  }
  return cell.i;
}

}  // namespace bip::rt
