// See checkpoint.hpp. Numbers are LEB128, as in frames (codec.hpp).
#include "runtime/distributed/checkpoint.hpp"

#include "bip/assert.hpp"
#include "bip/ffi.hpp"

#include "runtime/distributed/codec.hpp"
#include "runtime/distributed/node.hpp"

namespace bip::rt {

namespace {

constexpr std::string_view kCheckpointMagic = "bipc checkpoint 1\n";
constexpr const char* kCut = "it is cut off, or the model has changed since";

bool is_text_variable(const Image& image, const Var& variable) {
  return image.ffi != nullptr && variable.type == CellType::String;
}

// The instant, and of each atom how many words its clocks have, and these; where there are actions beside the others,
// how many are at work, and each as AsyncActions says it, in the order in which they began. There are no events.
void print_time(ByteWriter& writer, const Core& core, const SavedTime& time) {
  BIP_ASSERT(time.clocks.size() == core.image().atoms.size, "clocks of {} of {} atoms", time.clocks.size(),
             core.image().atoms.size);
  BIP_ASSERT(time.beside.empty() || core.actions().any(), "{} actions at work", time.beside.size());
  writer.number(static_cast<u64>(time.now));
  for (const std::vector<i64>& words : time.clocks) {
    writer.number(words.size());
    for (const i64 word : words) writer.number(static_cast<u64>(word));
  }
  if (!core.actions().any()) return;
  std::vector<SavedTime::Beside> beside = time.beside;
  sort_by_begin(beside);
  writer.number(beside.size());
  for (const SavedTime::Beside& action : beside) {
    for (const i64 word : action.words) writer.number(static_cast<u64>(word));
  }
}

// What is at work was begun before now, and ends when its atom is busy no longer.
bool read_actions(ByteReader& reader, const Core& core, SavedTime& time) {
  time.beside.clear();
  if (!core.actions().any()) return true;
  std::vector<bool> is_at_work(core.image().atoms.size);
  for (u64 left = reader.count(); left != 0 && reader.is_sound(); --left) {
    SavedTime::Beside action{0, static_cast<u32>(time.beside.size()), {}};
    for (std::size_t k = 0; k < AsyncActions::kSavedWords; ++k)
      action.words.push_back(static_cast<i64>(reader.number()));
    if (!reader.is_sound() || !core.actions().is_saved(action.words.data())) return false;
    const u32 atom = static_cast<u32>(action.words[0]);
    if (is_at_work[atom] || action.words[3] <= time.now || action.words[3] != time.clocks[atom].back()) return false;
    is_at_work[atom] = true;
    time.beside.push_back(std::move(action));
  }
  return reader.is_sound();
}

bool read_time(ByteReader& reader, const Core& core, SavedTime& time) {
  const u64 instant = reader.number();
  if (instant > static_cast<u64>(kMaxTicks)) return false;
  time.now = static_cast<i64>(instant);
  time.clocks.assign(core.image().atoms.size, {});
  for (u32 atom = 0; atom < time.clocks.size() && reader.is_sound(); ++atom) {
    for (u64 left = reader.count(); left != 0 && reader.is_sound(); --left)
      time.clocks[atom].push_back(static_cast<i64>(reader.number()));
    if (!reader.is_sound() || !core.time().is_saved(atom, time.clocks[atom])) return false;
  }
  return reader.is_sound() && read_actions(reader, core, time);
}

}  // namespace

std::string object_without_checkpoint(const Image& image) {
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    for (const Var& variable : image.atom_types[image.atoms[atom].type].variables) {
      if (is_ffi(variable.type)) return image.atoms[atom].path() + std::string(".") + variable.name;
    }
  }
  return {};
}

std::string print_checkpoint(const Core& core, const Checkpoint& checkpoint) {
  const Tables& tables = core.tables();
  const Image& image = *tables.image;
  BIP_ASSERT(checkpoint.history.size() == image.atoms.size && checkpoint.state.places.size() == image.atoms.size,
             "a checkpoint of {} of {} atoms", checkpoint.history.size(), image.atoms.size);
  std::string bytes(kCheckpointMagic);
  ByteWriter writer(bytes);
  writer.text(image.name);
  writer.number(image.atoms.size);
  writer.number(image.connectors.size);
  writer.number(checkpoint.steps);
  for (u32 atom = 0; atom < image.atoms.size; ++atom) {
    const AtomType& type = tables.atom_type(atom);
    writer.number(checkpoint.state.places[atom]);
    for (u32 i = 0; i < tables.types[tables.atoms[atom].type].mark_words; ++i)
      writer.number(checkpoint.state.marks[tables.first_mark(atom) + i]);
    for (u32 i = 0; i < type.variables.size; ++i) {
      const u64 bits = checkpoint.state.data[tables.atoms[atom].first_cell + i];
      if (is_text_variable(image, type.variables[i])) writer.text(string_of(image, Cell{.bits = bits}));
      else writer.number(bits);
    }
    writer.number(checkpoint.history[atom] == kNone ? 0 : u64{checkpoint.history[atom]} + 1);
  }
  if (core.is_timed()) print_time(writer, core, checkpoint.time);
  return bytes;
}

std::string read_checkpoint(const Core& core, std::string_view bytes, Checkpoint& checkpoint) {
  const Tables& tables = core.tables();
  const Image& image = *tables.image;
  if (!bytes.starts_with(kCheckpointMagic)) return "it is no checkpoint of this version";
  ByteReader reader(bytes.substr(kCheckpointMagic.size()));
  const std::string_view name = reader.text();
  if (name != image.name) return "it is of `" + std::string(name) + "`, not of `" + image.name + "`";
  if (reader.number() != image.atoms.size || reader.number() != image.connectors.size)
    return "the model has changed since";
  checkpoint.steps = reader.number();
  checkpoint.history.assign(image.atoms.size, kNone);
  for (u32 atom = 0; atom < image.atoms.size && reader.is_sound(); ++atom) {
    const AtomType& type = tables.atom_type(atom);
    const u32 words = tables.types[tables.atoms[atom].type].mark_words;
    checkpoint.state.places[atom] = words == 0 ? reader.row(type.places.size) : static_cast<u32>(reader.number());
    for (u32 i = 0; i < words; ++i) checkpoint.state.marks[tables.first_mark(atom) + i] = reader.number();
    for (u32 i = 0; i < type.variables.size; ++i) {
      u64& bits = checkpoint.state.data[tables.atoms[atom].first_cell + i];
      if (is_text_variable(image, type.variables[i])) {
        Cell value{.bits = 0};
        value.i = image.ffi->intern(reader.text());
        bits = value.bits;
      } else {
        bits = reader.number();
      }
    }
    const u32 history = reader.row(u64{image.connectors.size} + 1);
    if (history != 0) checkpoint.history[atom] = history - 1;
  }
  if (core.is_timed()) {
    if (!reader.is_sound() || !read_time(reader, core, checkpoint.time)) return kCut;
    add_time(core, checkpoint.time, checkpoint.state);
  }
  return reader.is_sound() && reader.is_at_end() ? "" : kCut;
}

}  // namespace bip::rt
