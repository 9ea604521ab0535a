// Firing such programs (programs.cpp lists them).
#include "runtime/core/core.hpp"
#include "runtime/core/programs/program_words.hpp"

namespace bip::rt {

// Whose code it was is looked up by listing the program once more: faults are rare.
bool Core::fail_program(std::int32_t status, u32 interaction, bool is_before, u32 index) {
  ProgramParts parts;
  (void)list_program(interaction, parts);
  const auto [is_port, row] = (is_before ? parts.before : parts.after).owners[index];
  if (!is_port) return fail_code(status, kNone, row, nullptr);
  return fail_code(status, tables_.port_atom[row], kNone, tables_.transitions[ports_[row].transition].source);
}

inline bool Core::run_codes(const u32* word, u32 count, u32 interaction, bool is_before) {
  // Locals: a call might change members, for all that the compiler knows.
  Cell* all = all_.data();
  const u32* binds = binds_.rows;
  const ProgramCode* codes = codes_.data();
  for (u32 i = 0; i < count; ++i, word += 3) {
    const ProgramCode& row = codes[word[0]];
    Cell* own = all + word[1];
    for (u32 k = 0; k < row.zeroed; ++k) own[k] = Cell{0};
    if (row.code.fn == nullptr) continue;
    const std::int32_t status = row.code.fn(row.code.context, own, all, binds + word[2]);
    if (status >= 2) return fail_program(status, interaction, is_before, i);
  }
  return true;
}

bool Core::run_program(const u32* word, u32 interaction) {
  if ((*word & kFar) != 0) word = programs_.data() + (*word & ~kFar);
  const u32 header = *word++;
  remember(interaction);
  u32 before = header >> 14 & 63, places = header >> 20 & 63, after = header >> 26;
  if ((header & kWide) != 0) {
    before = word[0], places = word[1], after = word[2];
    word += 3;
  }
  if (before != 0) {
    if (!run_codes(word, before, interaction, true)) return false;
    word += std::size_t{before} * 3;
  }
  for (; places > 0; --places, word += 2) places_[word[0]] = word[1];
  if (after != 0) {
    if (!run_codes(word, after, interaction, false)) return false;
    word += std::size_t{after} * 3;
  }
  const u32* touched = word;
  word += header >> 8 & 63;
  const u32* end = word + (header >> 2 & 63);
  std::int32_t* values = values_.data();
  if ((header & kPure) != 0) {
    while (word != end) {
      // The nodes of one word of the enabled set together: its counts change once.
      u64 flips = 0;
      u32 difference = 0, delta = 0;
      do {
        delta = *word++;
        const u32 node = delta >> 6;
        const std::int32_t was = values[node];
        const std::int32_t is = was + static_cast<std::int32_t>(delta & 31) - 16;
        values[node] = is;
        const u32 was_out = static_cast<u32>(was) >> 31, is_out = static_cast<u32>(is) >> 31;
        flips |= u64{was_out ^ is_out} << (node & 63);
        difference += was_out - is_out;
      } while ((delta & kDeltaLast) == 0);
      enabled_.flip(delta >> 12, flips, difference);
    }
    return true;
  }
  for (; word != end; ++word) {
    const u32 node = *word >> 6;
    const std::int32_t was = values[node];
    const std::int32_t is = was + static_cast<std::int32_t>(*word & 31) - 16;
    values[node] = is;
    if ((was ^ is) < 0) crossed(node, is >= 0);
  }
  // What is not available has nothing to evaluate; an interaction that just became unavailable was marked above.
  for (u32 left = header >> 8 & 63; left > 0; --left, ++touched) {
    if (values_[*touched] >= 0) mark_dirty(*touched);
  }
  return settle();
}

}  // namespace bip::rt
