// See told_state.hpp.
#include "runtime/engine/told_state.hpp"

#include <algorithm>
#include <utility>

#include "bip/assert.hpp"

namespace bip::rt {

void ToldState::start(const State& initial) {
  state_ = initial;
  history_.assign(core_.image().atoms.size, kNone);
  locked_.assign(core_.image().atoms.size, false);
  time_.clocks.resize(core_.image().atoms.size);
}

bool ToldState::take(u32 node, const Control& control) {
  BIP_ASSERT(!history_.empty() || core_.image().atoms.size == 0, "a state without atoms is told");
  if (control.numbers.size() < 2 || control.texts.size() != (core_.is_timed() ? 2u : 1u)) return false;
  const Tables& tables = core_.tables();
  if (control.numbers[0] >= core_.image().atoms.size) return false;
  const u32 atom = static_cast<u32>(control.numbers[0]);
  const u32 words = tables.types[tables.atoms[atom].type].mark_words;
  if (distribution_.home(atom) != node || control.numbers.size() != 4 + words) return false;
  if (control.numbers[1] < tables.atom_type(atom).places.size)
    state_.places[atom] = static_cast<u32>(control.numbers[1]);
  for (u32 i = 0; i < words; ++i) state_.marks[tables.first_mark(atom) + i] = control.numbers[2 + i];
  const u64 history = control.numbers[2 + words];
  history_[atom] = history < core_.image().connectors.size ? static_cast<u32>(history) : kNone;
  locked_[atom] = control.numbers[3 + words] != 0;
  ByteReader reader(control.texts[0]);
  for (u32 i = 0; i < tables.atom_type(atom).variables.size; ++i) {
    const VariableId cell = tables.atoms[atom].first_cell + i;
    const u64 bits = codec_.read_cell(reader, cell);
    if (reader.is_sound()) state_.data[cell] = bits;
  }
  return !core_.is_timed() || take_clocks(atom, control.texts[1]);
}

// NodeProcess::append_clocks.
bool ToldState::take_clocks(u32 atom, std::string_view text) {
  ByteReader reader(text);
  const auto word = [&reader] { return static_cast<i64>(reader.number()); };
  const i64 instant = word();
  std::vector<i64> words;
  for (u64 left = reader.count(); left != 0 && reader.is_sound(); --left) words.push_back(word());
  if (!reader.is_sound() || instant < 0 || !core_.time().is_saved(atom, words)) return false;
  time_.now = std::max(time_.now, instant);
  time_.clocks[atom] = std::move(words);
  if (reader.is_at_end() || !core_.actions().any()) return true;
  SavedTime::Beside beside{reader.number(), reader.row(kNone), {}};
  for (std::size_t k = 0; k < AsyncActions::kSavedWords; ++k) beside.words.push_back(word());
  if (!reader.is_sound() || beside.words[0] != i64{atom} || !core_.actions().is_saved(beside.words.data()))
    return false;
  time_.beside.push_back(std::move(beside));
  return true;
}

State ToldState::finish() {
  add_time(core_, std::exchange(time_, {}), state_);
  return state_;
}

}  // namespace bip::rt
