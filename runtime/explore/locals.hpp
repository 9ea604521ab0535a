// Local states of atoms as small numbers, and where these lie in the words of a state.
//
// What an atom is in (its marking and data, parameters and unread data apart) is numbered as it is first seen. An
// automaton without data needs no table: its number is its place. Atoms of one type with the same arguments share the
// numbers. A state is one number an atom, side by side in as few bits as the numbers need; when a table outgrows its
// bits, a wider layout is made. Numbering is thread-safe; reading a number needs no lock once the number was handed
// over (a barrier, a mutex).
#pragma once
#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "bip/assert.hpp"

#include "runtime/core/core.hpp"

namespace bip::rt {

class Locals {
 public:
  /// core: of the image, initialized or not. At most 2^31 local states a class. unread_cells: of no local state; all
  /// atoms of a type agree about them.
  explicit Locals(const Core& core, const std::vector<VariableId>& unread_cells = {});

  [[nodiscard]] u32 atoms() const { return static_cast<u32>(class_of_.size()); }
  [[nodiscard]] u32 class_of(u32 atom) const { return class_of_[atom]; }
  [[nodiscard]] u32 classes() const { return static_cast<u32>(classes_.size()); }
  /// The number is the place, and there is nothing else.
  [[nodiscard]] bool is_direct(u32 atom) const { return classes_[class_of_[atom]]->is_direct; }
  /// Bits that the class's numbers need now.
  [[nodiscard]] u32 bits(u32 row) const;

  /// What the atom is in now.
  u32 number(u32 atom, const Core& core);
  /// Puts what the number stands for into a state that has the parameters in it.
  void write(u32 atom, u32 number, State& state) const;
  /// The place of that local state, for an automaton.
  [[nodiscard]] u32 place(u32 atom, u32 number) const {
    const Class& row = *classes_[class_of_[atom]];
    return row.is_direct ? number : static_cast<u32>(*entry(row, number));
  }
  /// Memory of all tables.
  [[nodiscard]] std::size_t bytes() const;

 private:
  static constexpr u32 kFirst = 64;  // entries of the first piece; each piece is twice the one before
  struct Class {
    u32 type = 0, places = 0, mark_words = 0, width = 0;  // width: words of an entry
    bool is_direct = false;
    std::vector<u32> cells;    // of data that is read, and is no parameter and no object
    std::vector<u32> objects;  // of FFI types
    mutable std::mutex lock;
    u32 size = 0;
    std::array<std::unique_ptr<u64[]>, 26> pieces;  // never moved, so that numbers can be read while others are added
    std::array<std::unique_ptr<std::vector<FfiValue>[]>, 26> object_pieces;
    std::vector<u32> index;  // open addressing: number + 1, 0 is empty
  };
  [[nodiscard]] static std::pair<u32, u32> position(u32 number);
  [[nodiscard]] static const u64* entry(const Class& row, u32 number);
  u32 find_or_add(Class& row, const u64* key, std::vector<FfiValue>&& objects);

  const Image& image_;
  std::vector<u32> class_of_, mark_base_, object_base_;
  std::vector<std::unique_ptr<Class>> classes_;
};

/// Where an atom's number lies.
struct Field {
  u32 word = 0;
  std::uint8_t shift = 0, width = 0;
  u64 mask = 0;  // of the number, before the shift
};
class Layout {
 public:
  Layout() = default;
  /// As many bits as the numbers need now.
  explicit Layout(const Locals& locals);

  [[nodiscard]] u32 words() const { return words_; }
  [[nodiscard]] u32 bits() const { return bits_; }
  [[nodiscard]] const Field& operator[](u32 atom) const { return fields_[atom]; }
  [[nodiscard]] u32 get(const u64* state, u32 atom) const {
    const Field& field = fields_[atom];
    return static_cast<u32>(state[field.word] >> field.shift & field.mask);
  }
  void set(u64* state, u32 atom, u32 number) const {
    BIP_ASSERT(fits(atom, number), "number {} of atom {}", number, atom);
    const Field& field = fields_[atom];
    u64& word = state[field.word];
    word = (word & ~(field.mask << field.shift)) | u64{number} << field.shift;
  }
  [[nodiscard]] bool fits(u32 atom, u32 number) const { return number <= fields_[atom].mask; }

 private:
  std::vector<Field> fields_;
  u32 words_ = 1, bits_ = 0;
};

}  // namespace bip::rt
