// See reached_states.hpp.
#include "compiler/verify/evidence/reached_states.hpp"

#include <algorithm>

#include "compiler/system/inner_priorities.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

using u32 = std::uint32_t;
}  // namespace

std::int32_t StateColumn::value_in(const rt::State& state) const {
  if (about == About::Automaton) return static_cast<std::int32_t>(state.places[position]);
  if (about == About::Place) return static_cast<std::int32_t>(state.marks[position / 64] >> (position % 64) & 1);
  return static_cast<std::int32_t>(static_cast<u32>(state.data[rt::VariableId(position)]));
}

void StateColumn::append(std::int32_t value, std::string& out) const {
  out += about == About::Place && value == 0 ? " !" : " ";
  out += name;
  if (about == About::Automaton) out += (*places)[static_cast<std::size_t>(value)];
  if (about == About::Value) out += std::to_string(value);
}

std::vector<StateColumn> state_columns(const System& system, const rt::Image& image,
                                       const std::vector<rt::VariableId>& left_out_cells) {
  using About = StateColumn::About;
  std::vector<StateColumn> columns;
  u32 mark_word = 0;
  for (std::size_t a = 0; a < system.atoms.size(); ++a) {
    const Atom& instance = system.atoms[AtomId(a)];
    const AtomType& type = system.atom_types[instance.type];
    const u32 atom = static_cast<u32>(a);
    if (type.is_automaton()) {
      columns.push_back({About::Automaton, atom, instance.path + '@', &type.places});
    } else {
      for (std::size_t p = 0; p < type.places.size(); ++p)
        columns.push_back({About::Place, mark_word * 64 + static_cast<u32>(p), instance.path + '@' + type.places[p]});
      mark_word += static_cast<u32>((type.places.size() + 63) / 64);
    }
    for (std::size_t k = 0; k < type.variables.size(); ++k) {
      const Type of = type.variables[k].type;
      const rt::VariableId variable = image.atoms[atom].variable(static_cast<u32>(k));
      const bool is_hidden = type.variables[k].name.find(' ') != std::string::npos;
      if (type.variables[k].is_param || is_hidden ||
          std::binary_search(left_out_cells.begin(), left_out_cells.end(), variable))
        continue;
      columns.push_back({About::Value, variable.value, instance.path + '.' + type.variables[k].name + '=', nullptr,
                         of == Type::Int || of == Type::Bool || of == Type::String});
    }
  }
  return columns;
}

// The checker cannot follow priorities below connectors.
StateCollector::StateCollector(const System& system, const rt::Image& image, std::size_t bytes)
    : is_listable_(system::first_inner_priority(system).empty()),
      bytes_(bytes),
      columns_(state_columns(system, image)) {
  is_listable_ = is_listable_ && std::all_of(columns_.begin(), columns_.end(),
                                             [](const StateColumn& column) { return column.is_nameable; });
}

void StateCollector::add(const rt::State& state) {
  if (!is_listable_ || values_.size() > bytes_ / sizeof values_[0]) return;
  BIP_ASSERT(columns_.empty() || values_.size() % columns_.size() == 0, "a state with values missing");
  for (const StateColumn& column : columns_) values_.push_back(column.value_in(state));
}

std::string StateCollector::rows() const {
  const std::size_t width = columns_.size(), count = width == 0 ? 0 : values_.size() / width;
  if (!is_listable_ || values_.size() > bytes_ / sizeof values_[0]) return {};
  std::vector<const std::int32_t*> states(count);
  for (std::size_t s = 0; s < count; ++s) states[s] = values_.data() + s * width;
  std::sort(states.begin(), states.end(), [&](const std::int32_t* a, const std::int32_t* b) {
    return std::lexicographical_compare(a, a + width, b, b + width);
  });
  std::string out;
  for (std::size_t s = 0; s < count; ++s) {
    out += "state";
    for (std::size_t q = 0; q < width; ++q) {
      const std::int32_t value = states[s][q];
      if (s != 0 && states[s - 1][q] == value) continue;
      columns_[q].append(value, out);
    }
    out += '\n';
    if (out.size() > bytes_) return {};
  }
  return out;
}

}  // namespace bip::verify
