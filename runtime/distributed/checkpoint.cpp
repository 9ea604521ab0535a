// See checkpoint.hpp. Numbers are LEB128, as in frames (codec.hpp).
#include "runtime/distributed/checkpoint.hpp"

#include "bip/assert.hpp"
#include "bip/ffi.hpp"

#include "runtime/distributed/codec.hpp"

namespace bip::rt {

namespace {

constexpr std::string_view kCheckpointMagic = "bipc checkpoint 1\n";

bool is_text_variable(const Image& image, const Var& variable) {
  return image.ffi != nullptr && variable.type == CellType::String;
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

std::string print_checkpoint(const Tables& tables, const Checkpoint& checkpoint) {
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
  return bytes;
}

std::string read_checkpoint(const Tables& tables, std::string_view bytes, Checkpoint& checkpoint) {
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
  return reader.is_sound() && reader.is_at_end() ? "" : "it is cut off, or the model has changed since";
}

}  // namespace bip::rt
