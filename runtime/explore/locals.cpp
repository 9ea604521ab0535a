// See locals.hpp.
#include "runtime/explore/locals.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>

#include "bip/assert.hpp"
#include "runtime/explore/word_set.hpp"

namespace bip::rt {

namespace {

// Above so many bits a state has several words; each is kept well below 64, for words that states share are stored
// once.
constexpr u32 kBitsOfSharedWord = 48;
constexpr u32 kInPlace = 32;  // words of a key that need no allocation

u64 hash_of(const u64* key, u32 width) {
  u64 hash = 0;
  for (u32 k = 0; k < width; ++k) hash = WordSet::hash_of(hash ^ (key[k] + 0x9e3779b97f4a7c15ull * (k + 1)));
  return hash;
}

}  // namespace

Locals::Locals(const Core& core, const std::vector<VariableId>& unread_cells) : image_(core.image()) {
  const Tables& tables = core.tables();
  IndexVector<VariableId, bool> is_unread(image_.cell_count, false);
  for (const VariableId cell : unread_cells) is_unread[cell] = true;
  std::map<std::vector<u64>, u32> rows;
  u32 objects = 0;
  for (u32 atom = 0; atom < image_.atoms.size; ++atom) {
    const Atom& row = image_.atoms[atom];
    const AtomType& type = image_.atom_types[row.type];
    std::vector<u64> key{row.type};
    u32 arg = row.args, own_objects = 0;
    for (const Var& var : type.variables) {
      if (var.is_param) key.push_back(image_.args[arg++].bits);
      own_objects += is_ffi(var.type) ? 1u : 0u;
    }
    const auto [found, is_new] = rows.try_emplace(std::move(key), static_cast<u32>(classes_.size()));
    class_of_.push_back(found->second);
    mark_base_.push_back(tables.first_mark(atom));
    object_base_.push_back(objects);
    objects += own_objects;
    if (!is_new) continue;
    auto made = std::make_unique<Class>();
    made->type = row.type;
    made->places = type.places.size;
    made->mark_words = tables.types[row.type].mark_words;
    for (u32 cell = 0; cell < type.variables.size; ++cell) {
      if (is_ffi(type.variables[cell].type)) made->objects.push_back(cell);
      else if (!type.variables[cell].is_param && !is_unread[row.variable(cell)]) made->cells.push_back(cell);
    }
    made->is_direct = made->mark_words == 0 && made->cells.empty() && made->objects.empty();
    made->width = std::max(1u, made->mark_words) + static_cast<u32>(made->cells.size());
    if (!made->is_direct) made->index.assign(2 * kFirst, 0);
    classes_.push_back(std::move(made));
  }
}

u32 Locals::bits(u32 row) const {
  const Class& at = *classes_[row];
  if (at.is_direct) return static_cast<u32>(std::bit_width(at.places - 1));
  const std::lock_guard guard(at.lock);
  // Room for one more at least, and for as many again where the table is full.
  return static_cast<u32>(std::bit_width(std::max(at.size, 1u)));
}

std::pair<u32, u32> Locals::position(u32 number) {
  const u32 piece = static_cast<u32>(std::bit_width(number / kFirst + 1)) - 1;
  return {piece, number - kFirst * ((1u << piece) - 1)};
}

const u64* Locals::entry(const Class& row, u32 number) {
  const auto [piece, at] = position(number);
  return row.pieces[piece].get() + std::size_t{at} * row.width;
}

u32 Locals::find_or_add(Class& row, const u64* key, std::vector<FfiValue>&& objects) {
  const u64 hash = hash_of(key, row.width);
  const std::lock_guard guard(row.lock);
  std::size_t mask = row.index.size() - 1;
  std::size_t at = hash & mask;
  for (; row.index[at] != 0; at = (at + 1) & mask) {
    const u32 number = row.index[at] - 1;
    if (std::memcmp(entry(row, number), key, row.width * sizeof(u64)) != 0) continue;
    if (row.objects.empty()) return number;
    const auto [piece, rank] = position(number);
    if (row.object_pieces[piece][rank] == objects) return number;
  }
  const u32 number = row.size;
  const auto [piece, rank] = position(number);
  if (row.pieces[piece] == nullptr) {
    row.pieces[piece].reset(new u64[std::size_t{row.width} * (std::size_t{kFirst} << piece)]);
    if (!row.objects.empty()) row.object_pieces[piece].reset(new std::vector<FfiValue>[std::size_t{kFirst} << piece]);
  }
  std::memcpy(row.pieces[piece].get() + std::size_t{rank} * row.width, key, row.width * sizeof(u64));
  if (!row.objects.empty()) row.object_pieces[piece][rank] = std::move(objects);
  ++row.size;
  BIP_ASSERT(row.index[at] == 0 && row.size <= row.index.size(), "{} local states", row.size);
  row.index[at] = number + 1;
  if (row.size * 2 > row.index.size()) {
    std::vector<u32> wider(row.index.size() * 2, 0);
    mask = wider.size() - 1;
    for (u32 k = 0; k < row.size; ++k) {
      at = hash_of(entry(row, k), row.width) & mask;
      while (wider[at] != 0) at = (at + 1) & mask;
      wider[at] = k + 1;
    }
    row.index = std::move(wider);
  }
  return number;
}

u32 Locals::number(u32 atom, const Core& core) {
  Class& row = *classes_[class_of_[atom]];
  u32 place = 0;
  if (row.mark_words == 0) {
    while (place + 1 < row.places && !core.is_marked(atom, place)) ++place;
    if (row.is_direct) return place;
  }
  u64 in_place[kInPlace];
  std::vector<u64> large;
  if (row.width > kInPlace) large.resize(row.width);
  u64* key = row.width > kInPlace ? large.data() : in_place;
  u64* out = key;
  if (row.mark_words == 0) *out++ = place;
  for (u32 word = 0; word < row.mark_words; ++word) {
    u64 marks = 0;
    for (u32 bit = 0; bit < 64 && word * 64 + bit < row.places; ++bit)
      marks |= u64{core.is_marked(atom, word * 64 + bit)} << bit;
    *out++ = marks;
  }
  const VariableId base = core.tables().atoms[atom].first_cell;
  for (u32 cell : row.cells) *out++ = core.cell(base + cell).bits;
  std::vector<FfiValue> objects;
  for (u32 cell : row.objects) {
    const CellType type = image_.atom_types[row.type].variables[cell].type;
    const FfiType& ffi_type = image_.ffi_types[static_cast<u32>(type) - kFirstFfiType];
    objects.emplace_back(ffi_type,
                         reinterpret_cast<const void*>(static_cast<std::uintptr_t>(core.cell(base + cell).bits)));
  }
  return find_or_add(row, key, std::move(objects));
}

void Locals::write(u32 atom, u32 number, State& state) const {
  BIP_ASSERT(atom < class_of_.size(), "atom {} of {}", atom, class_of_.size());
  const Class& row = *classes_[class_of_[atom]];
  BIP_ASSERT(!row.is_direct || number < row.places, "place {} of {}", number, row.places);
  if (row.is_direct) {
    state.places[atom] = number;
    return;
  }
  const u64* from = entry(row, number);
  if (row.mark_words == 0) state.places[atom] = static_cast<u32>(*from++);
  for (u32 word = 0; word < row.mark_words; ++word) state.marks[mark_base_[atom] + word] = *from++;
  for (u32 cell : row.cells) state.data[image_.atoms[atom].variable(cell)] = *from++;
  if (row.objects.empty()) return;
  const auto [piece, rank] = position(number);
  for (std::size_t k = 0; k < row.objects.size(); ++k)
    state.objects[object_base_[atom] + k] = row.object_pieces[piece][rank][k];
}

std::size_t Locals::bytes() const {
  std::size_t sum = 0;
  for (const auto& row : classes_) {
    const std::lock_guard guard(row->lock);
    sum += row->index.size() * sizeof(u32);
    for (u32 piece = 0; piece < row->pieces.size() && row->pieces[piece] != nullptr; ++piece) {
      sum += std::size_t{row->width} * (std::size_t{kFirst} << piece) * sizeof(u64);
    }
  }
  return sum;
}

Layout::Layout(const Locals& locals) {
  std::vector<u32> widths;
  for (u32 row = 0; row < locals.classes(); ++row) widths.push_back(locals.bits(row));
  for (u32 atom = 0; atom < locals.atoms(); ++atom) bits_ += widths[locals.class_of(atom)];
  const u32 words = bits_ <= 64 ? 1 : (bits_ + kBitsOfSharedWord - 1) / kBitsOfSharedWord;
  const u32 share = words == 1 ? 64 : (bits_ + words - 1) / words;
  u32 used = 0;
  words_ = 1;
  for (u32 atom = 0; atom < locals.atoms(); ++atom) {
    const u32 width = widths[locals.class_of(atom)];
    // A word is filled to its share, the last field may reach beyond it.
    if (used + width > 64 || (words > 1 && used >= share)) {
      ++words_;
      used = 0;
    }
    fields_.push_back(
        {words_ - 1, static_cast<std::uint8_t>(used), static_cast<std::uint8_t>(width), (u64{1} << width) - 1});
    used += width;
    BIP_ASSERT(used <= 64, "{} bits in word {}", used, words_ - 1);
  }
}

}  // namespace bip::rt
