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

// The checker cannot follow priorities below connectors.
StateCollector::StateCollector(const System& system, const rt::Image& image, std::size_t bytes)
    : is_listable_(system::first_inner_priority(system).empty()), bytes_(bytes) {
  u32 mark_word = 0;
  for (std::size_t a = 0; a < system.atoms.size(); ++a) {
    const Atom& instance = system.atoms[AtomId(a)];
    const AtomType& type = system.atom_types[instance.type];
    const u32 atom = static_cast<u32>(a);
    if (type.is_automaton()) {
      columns_.push_back({About::Automaton, atom, instance.path + '@', &type.places});
    } else {
      for (std::size_t p = 0; p < type.places.size(); ++p)
        columns_.push_back({About::Place, mark_word * 64 + static_cast<u32>(p), instance.path + '@' + type.places[p]});
      mark_word += static_cast<u32>((type.places.size() + 63) / 64);
    }
    for (std::size_t k = 0; k < type.variables.size(); ++k) {
      const Type of = type.variables[k].type;
      if (type.variables[k].is_param) continue;
      is_listable_ = is_listable_ && (of == Type::Int || of == Type::Bool || of == Type::String);
      columns_.push_back({About::Value, image.atoms[atom].first_cell + static_cast<u32>(k),
                          instance.path + '.' + type.variables[k].name + '='});
    }
  }
}

void StateCollector::add(const rt::State& state) {
  if (!is_listable_ || values_.size() > bytes_ / sizeof values_[0]) return;
  BIP_ASSERT(columns_.empty() || values_.size() % columns_.size() == 0, "a state with values missing");
  for (const StateColumn& q : columns_) {
    const u32 at = q.position;
    if (q.about == About::Automaton) values_.push_back(static_cast<std::int32_t>(state.places[at]));
    else if (q.about == About::Place)
      values_.push_back(static_cast<std::int32_t>(state.marks[at / 64] >> (at % 64) & 1));
    else values_.push_back(static_cast<std::int32_t>(static_cast<u32>(state.data[at])));
  }
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
      const StateColumn& question = columns_[q];
      out += question.about == About::Place && value == 0 ? " !" : " ";
      out += question.name;
      if (question.about == About::Automaton) out += (*question.places)[static_cast<std::size_t>(value)];
      if (question.about == About::Value) out += std::to_string(value);
    }
    out += '\n';
    if (out.size() > bytes_) return {};
  }
  return out;
}

}  // namespace bip::verify
