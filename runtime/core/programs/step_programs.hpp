// Whole steps as short programs. A rendezvous of atoms of simple types has the same effect every time: these pieces of
// code on these rows, these places, these counters of the availability network each by a known amount, these guards to
// look at again. Listed once, firing is a few loops over one array, without a look at ports or at the image
// (a superinstruction, see compiler/docs/performance.md; two to four times as fast as following ports one by one).
// Hierarchies without triggers, guards and merged ports are such rendezvous too.
//
// A program: a header (1: pure; deltas << 2, touched << 8, codes before the places << 14, places << 20, codes after <<
// 26; if a count does not fit, kWide and a word each), then codes (row of codes_, row of their own first cell, row of
// binds), (atom, place) pairs, codes, touched interactions, and deltas: node << 6 | last << 5 | difference + 16, `last`
// ends the nodes of one word of the enabled set. Pure: nothing is touched and all nodes are interactions whose counter
// is all there is to know; then nothing branches on what becomes enabled, which under a random policy cannot be
// predicted. Only for rendezvous that touch few counters: a hub's ports would make the tables quadratic. Interaction
// k's program is at row k of equal rows, a cache line at most, so that reaching it costs one; what is longer lies
// elsewhere, where the row says.
#pragma once
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "runtime/core/link/tables.hpp"

namespace bip::rt {

struct CoreParts;

/// What programs call.
struct ProgramCode {
  Code code;
  u32 zeroed = 0;  // own cells that are zeroed before it runs
};

class StepPrograms {
 public:
  explicit StepPrograms(CoreParts& core) : core_(core) {}

  /// Returns the interaction's program for run(), or a word kNone if it has none (yet).
  [[nodiscard]] const u32* program_of(InteractionId interaction) {
    if (rows_.empty() && !build_if_worthwhile()) return &kNoProgram;
    return rows_.data() + std::size_t{interaction.value} * row_words_;
  }
  /// Takes the step of an interaction that has a candidate; the core is settled then. False: a fault.
  bool run(const u32* word, InteractionId interaction);
  /// Gives the memory back; program_of builds them anew.
  void drop();
  /// Returns the row of a piece of code that first zeroes so many cells of its own; adds it if it is new.
  u32 code_row(Code code, u32 zeroed);
  [[nodiscard]] const ProgramCode& code(u32 row) const { return codes_[row]; }
  /// Calls renew(code) for each piece of code.
  template <class Renew>
  void renew_codes(const Renew& renew) {
    code_rows_.clear();
    for (u32 row = 0; row < codes_.size(); ++row) {
      renew(codes_[row].code);
      code_rows_.try_emplace({codes_[row].code.fn, codes_[row].code.context, codes_[row].zeroed}, row);
    }
  }
  /// Of programs; of what they call.
  [[nodiscard]] std::size_t bytes() const { return (rows_.size() + programs_.size()) * sizeof(u32); }
  [[nodiscard]] std::size_t code_bytes() const { return codes_.size() * sizeof(ProgramCode); }

 private:
  struct Codes {
    std::vector<u32> words;                    // three a code
    std::vector<std::pair<bool, u32>> owners;  // by code: a port instance (true) or a connector
  };
  enum class OwnData : std::uint8_t { Zeroed, Kept };  // of a connector, before its code runs
  enum class Half : std::uint8_t { Before, After };    // the places change
  struct Parts {
    Codes before, after;  // the places
    std::vector<u32> places, instances;
    std::vector<InteractionId> touched;
    std::vector<std::pair<u32, std::int32_t>> deltas;
  };
  bool build_if_worthwhile();
  void build();
  void list_code(u32 connector, Code code, OwnData own, Codes& out);
  void list_port(u32 instance, Parts& parts);
  void list_plan(const Plan& plan, Parts& parts);
  bool list_effects(Parts& parts);
  bool list_program(InteractionId interaction, Parts& parts);
  bool run_codes(const u32* word, u32 count, InteractionId interaction, Half half);
  bool fail_program(std::int32_t status, InteractionId interaction, Half half, u32 index);

  static constexpr u32 kNoProgram = kNone;

  CoreParts& core_;
  std::size_t asked_ = 0;      // for programs, before they were built
  std::vector<u32> rows_;      // by interaction, row_words_ each: its program; kNone: it has none. Made when needed
  std::vector<u32> programs_;  // those longer than a row
  u32 row_words_ = 1;
  std::vector<ProgramCode> codes_;
  std::map<std::tuple<CodeFn, const void*, u32>, u32> code_rows_;
};

}  // namespace bip::rt
