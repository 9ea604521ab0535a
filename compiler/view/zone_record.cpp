// See zone_record.hpp.
#include "compiler/view/zone_record.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/system/system.hpp"

namespace bip::view {
namespace {

bool read_number(std::string_view text, long long& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size();
}

// Of a limit of time: what is left without it are the clocks of the model.
bool is_of_observer(std::string_view word) {
  return word.starts_with("observer.") || word.find("-observer.") != std::string_view::npos;
}

}  // namespace

ZoneRecorder::ZoneRecorder(const System& system) : system_(system) {
  for (std::size_t atom = 0; atom < system.atoms.size(); ++atom) {
    const Atom& instance = system.atoms[AtomId(atom)];
    const AtomType& type = system.atom_types[instance.type];
    atoms_.emplace(instance.path, atom);
    for (std::size_t k = 0; k < type.clocks.size(); ++k)
      clocks_.emplace(instance.path + '.' + type.clocks[k].name, Name{atom, k});
    for (std::size_t k = 0; k < type.visible_variables(); ++k)
      variables_.emplace(instance.path + '.' + type.variables[k].name, Name{atom, k});
    marks_.emplace_back(type.places.size(), false);
  }
  is_placed_.assign(marks_.size(), false);
  waits_.assign(marks_.size(), false);
}

void ZoneRecorder::add_state(const std::vector<std::string_view>& words) {
  for (const std::string_view word : words) take_word(word);
  Json places = Json::array(), values = Json::array(), waits = Json::array();
  for (std::size_t atom = 0; atom < marks_.size(); ++atom) {
    const AtomType& type = system_.atom_types[system_.atoms[AtomId(atom)].type];
    std::string text;
    for (std::size_t place = 0; place < type.places.size(); ++place) {
      if (!marks_[atom][place]) continue;
      text += (text.empty() ? "" : ", ") + type.places[place];
    }
    places.push_back(is_placed_[atom] ? Json(text) : Json(nullptr));
    if (waits_[atom]) waits.push_back(atom);
  }
  for (const auto& [name, value] : values_) values.push_back({name.first, name.second, value});
  Json location{{"places", std::move(places)},
                {"values", std::move(values)},
                {"waits", std::move(waits)},
                {"zones", Json::array()}};
  // With an observer the same state may come twice.
  const auto [row, is_new] = rows_.try_emplace(location.dump(), locations_.size());
  if (is_new) locations_.push_back(std::move(location));
  now_ = row->second;
}

void ZoneRecorder::take_word(std::string_view word) {
  if (is_of_observer(word)) return;
  const bool is_marked = !word.starts_with('!');
  if (!is_marked) word.remove_prefix(1);
  if (const std::size_t at = word.find('@'); at != std::string_view::npos)
    return take_place(word.substr(0, at), word.substr(at + 1), is_marked);
  const std::size_t sign = word.find('=');
  if (sign == std::string_view::npos) return void(problem_ = fmt::format("a word `{}`", word));
  take_value(word.substr(0, sign), word.substr(sign + 1));
}

void ZoneRecorder::take_place(std::string_view path, std::string_view place, bool is_marked) {
  const auto found = atoms_.find(path);
  if (found == atoms_.end()) return void(problem_ = fmt::format("the model has no component `{}`", path));
  const AtomType& type = system_.atom_types[system_.atoms[AtomId(found->second)].type];
  std::vector<bool>& marks = marks_[found->second];
  is_placed_[found->second] = true;
  if (type.is_automaton()) marks.assign(marks.size(), false);
  for (std::size_t k = 0; k < type.places.size(); ++k) {
    if (type.places[k] == place) return void(marks[k] = is_marked);
  }
  problem_ = fmt::format("no place `{}` of `{}`", place, path);
}

// Also `PATH.resume=N` and `PATH.resume-with=N`; with whom it goes on is not shown. Strings are rows of a table that
// the page does not have.
void ZoneRecorder::take_value(std::string_view name, std::string_view value) {
  long long number = 0;
  if (!read_number(value, number)) return void(problem_ = fmt::format("a value `{}`", value));
  if (const auto found = variables_.find(name); found != variables_.end()) {
    const AtomType& type = system_.atom_types[system_.atoms[AtomId(found->second.atom)].type];
    if (type.variables[found->second.row].type != Type::String)
      values_[{found->second.atom, found->second.row}] = number;
    return;
  }
  const std::size_t dot = name.rfind('.');
  const auto atom = atoms_.find(name.substr(0, dot));
  const std::string_view last = name.substr(dot + 1);
  if (atom == atoms_.end() || (last != "resume" && last != "resume-with"))
    return void(problem_ = fmt::format("no variable `{}`", name));
  if (last == "resume") waits_[atom->second] = number != 0;
}

void ZoneRecorder::add_zone(const std::vector<std::string_view>& words) {
  if (locations_.empty()) return void(problem_ = "a zone before the first state");
  if (zones_ == kMostZones) return void(++left_out_);
  ++zones_;
  Json zone = Json::array();
  for (const std::string_view word : words) {
    if (is_of_observer(word)) continue;
    if (Json bound = bound_of(word); !bound.is_null()) zone.push_back(std::move(bound));
  }
  locations_[now_]["zones"].push_back(std::move(zone));
}

bool ZoneRecorder::find_clock(std::string_view name, Name& out) {
  const auto found = clocks_.find(name);
  if (found == clocks_.end()) problem_ = fmt::format("no clock `{}`", name);
  else out = found->second;
  return found != clocks_.end();
}

// `PATH.CLOCK<=N`, `PATH.CLOCK>=N`: [atom, clock, low or null, high or null]; of a difference: [atom, clock, atom,
// clock, low or null, high or null].
ZoneRecorder::Json ZoneRecorder::bound_of(std::string_view word) {
  const std::size_t sign = word.find_first_of("<>");
  long long limit = 0;
  if (sign == std::string_view::npos || sign + 1 >= word.size() || word[sign + 1] != '=' ||
      !read_number(word.substr(sign + 2), limit)) {
    problem_ = fmt::format("a word `{}`", word);
    return nullptr;
  }
  const std::string_view left = word.substr(0, sign);
  const std::size_t minus = left.find('-');
  Name first, second;
  if (!find_clock(left.substr(0, minus), first)) return nullptr;
  Json bound{first.atom, first.row};
  if (minus != std::string_view::npos) {
    if (!find_clock(left.substr(minus + 1), second)) return nullptr;
    bound.push_back(second.atom);
    bound.push_back(second.row);
  }
  BIP_ASSERT(first.atom < marks_.size() && second.atom < marks_.size(), "a clock of atom {} or {}", first.atom,
             second.atom);
  const bool is_most = word[sign] == '<';
  bound.push_back(is_most ? Json(nullptr) : Json(limit));
  bound.push_back(is_most ? Json(limit) : Json(nullptr));
  return bound;
}

}  // namespace bip::view
