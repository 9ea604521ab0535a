// A state of the runtime's core beside one of the naive oracle: places, data, clocks, candidates.
#pragma once
#include <algorithm>
#include <cstring>
#include <map>

#include <fmt/format.h>

#include "bip/ffi.hpp"
#include "runtime/core/core.hpp"
#include "tools/gen/check_model.hpp"
#include "tools/gen/naive.hpp"
#include "tools/gen/random.hpp"

namespace bip::gen {

inline std::string cell_text(const rt::Image& image, rt::CellType type, rt::Cell cell) {
  if (type == rt::CellType::String) return std::string("\"") + rt::string_of(image, cell) + "\"";
  if (rt::is_ffi(type)) return fmt::format("({}, {})", rt::object_in<Pair>(cell).a, rt::object_in<Pair>(cell).b);
  if (type == rt::CellType::Float) return fmt::format("{}", cell.f);
  return std::to_string(cell.i);
}
inline std::string value_text(const Value& value) {
  if (value.type == Ty::String) return "\"" + value.s + "\"";
  if (value.type == Ty::Float) return fmt::format("{}", value.f);
  if (value.type == Ty::Pair || value.type == Ty::Wide)
    return fmt::format("({}, {}, {})", value.w.a, value.w.b, value.w.c);
  return std::to_string(value.i);
}
inline bool is_equal(const rt::Image& image, rt::Cell cell, const Value& value) {
  switch (value.type) {
    case Ty::Int: return cell.i == value.i;
    case Ty::Bool: return cell.bits == static_cast<std::uint64_t>(value.i);
    case Ty::Float:
      return std::memcmp(&cell.f, &value.f, sizeof value.f) == 0 || (cell.f != cell.f && value.f != value.f);
    case Ty::String: return value.s == rt::string_of(image, cell);
    case Ty::Pair: return rt::object_in<Pair>(cell) == value.w;
    case Ty::Wide: return rt::object_in<Pair>(cell) == value.w && rt::object_in<Wide>(cell).c == value.w.c;
  }
  return false;
}

/// The number of each atom in the image, by its path.
inline std::map<std::string, std::uint64_t> atom_numbers(const rt::Image& image) {
  std::map<std::string, std::uint64_t> numbers;
  for (std::uint32_t a = 0; a < image.atoms.size; ++a) numbers[image.atoms[a].path()] = a;
  return numbers;
}

class Comparison {
 public:
  Comparison(const rt::Image& image, rt::Core& core, NaiveEngine& naive) : image_(image), core_(core), naive_(naive) {
    for (std::uint32_t a = 0; a < image.atoms.size; ++a) row_of_[image.atoms[a].path()] = a;
  }

  /// Empty if the states are equal.
  std::string states() {
    if (naive_.world().atoms.size() != image_.atoms.size) return "number of atoms differs";
    for (std::size_t a = 0; a < naive_.states().size(); ++a) {
      const WorldAtom& atom = naive_.world().atoms[a];
      auto row = row_of_.find(atom.path);
      if (row == row_of_.end()) return "no atom " + atom.path;
      std::string difference = atom_state(atom.path, row->second, naive_.states()[a]);
      if (difference.empty()) difference = clocks(a, row->second);
      if (!difference.empty()) return difference;
    }
    return "";
  }

  std::string candidates(const std::vector<Choice>& choices) {
    keys_.clear();
    std::map<std::string, int> wanted;
    for (const Choice& choice : choices) ++wanted[naive_.key_of(choice)];
    for (std::uint64_t k = 0; k < core_.candidate_count(); ++k) {
      keys_.push_back(key_of(core_.candidate(k)));
      if (--wanted[keys_.back()] < 0) return "engine offers " + keys_.back() + ", the oracle does not";
    }
    for (const auto& [key, count] : wanted) {
      if (count > 0) return "the oracle offers " + key + ", the engine does not";
    }
    return "";
  }
  const std::string& key(std::uint64_t k) const { return keys_[k]; }
  std::uint32_t row_of(const std::string& path) const { return row_of_.at(path); }

 private:
  std::string atom_state(const std::string& path, std::uint32_t row, const NaiveEngine::AtomState& state) {
    const rt::Atom& atom = image_.atoms[row];
    const rt::AtomType& type = image_.atom_types[atom.type];
    for (std::uint32_t p = 0; p < type.places.size; ++p) {
      if (core_.is_marked(row, p) != state.marking.contains(type.places[p])) return path + ": place " + type.places[p];
    }
    for (std::uint32_t v = 0; v < type.variables.size; ++v) {
      // Hidden ones, which clocks own.
      if (!state.vars.contains(type.variables[v].name)) continue;
      rt::Cell cell = core_.cell(atom.variable(v));
      const Value& value = state.vars.at(type.variables[v].name);
      if (is_equal(image_, cell, value)) continue;
      return path + "." + type.variables[v].name + " is " + cell_text(image_, type.variables[v].type, cell) +
             ", the oracle says " + value_text(value);
    }
    return "";
  }
  std::string clocks(std::size_t atom, std::uint32_t row) {
    const rt::AtomTime* time = image_.atom_types[image_.atoms[row].type].time;
    for (std::uint32_t c = 0; time != nullptr && c < time->clocks.size; ++c) {
      const std::int64_t wanted = naive_.clock_value(atom, time->clocks[c].name);
      if (core_.time().clock_value(row, c) == wanted) continue;
      return fmt::format("clock {}.{} is {}, the oracle says {}", image_.atoms[row].path(), time->clocks[c].name,
                         static_cast<std::int64_t>(core_.time().clock_value(row, c)), wanted);
    }
    return "";
  }
  std::string port_name(std::uint32_t atom, std::uint32_t port) const {
    const rt::Atom& row = image_.atoms[atom];
    return row.path() + "." + image_.atom_types[row.type].ports[port].name;
  }
  std::string key_of(const rt::Candidate& candidate) {
    if (candidate.connector == rt::kNone) return port_name(candidate.atom, candidate.port);
    std::vector<rt::Participant> participants;
    core_.participants(candidate, participants);
    std::vector<std::string> leaves;
    for (const rt::Participant& p : participants) leaves.push_back(port_name(p.atom, p.port));
    std::sort(leaves.begin(), leaves.end());
    std::string text = image_.connectors[candidate.connector].path() + ":";
    for (const std::string& leaf : leaves) text += " " + leaf;
    return text;
  }

  const rt::Image& image_;
  rt::Core& core_;
  NaiveEngine& naive_;
  std::map<std::string, std::uint32_t> row_of_;
  std::vector<std::string> keys_;
};

/// The same for a model with time.
[[nodiscard]] std::string check_naive_time(const Description& model, const rt::Image& image, std::uint64_t seed,
                                           std::uint64_t steps, OracleCounts& counts);

}  // namespace bip::gen
