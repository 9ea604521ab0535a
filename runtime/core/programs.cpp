// Whole steps as short programs. A rendezvous of atoms of simple types has the same effect every time: these places, these
// counters of the availability network, each by a known amount. Listed once, firing is two loops over one array, without
// a look at ports (PERFORMANCE's "superinstruction"; about twice as fast as following ports one by one).
//
// A program: a header (1: has a transfer, 2: pure; moves << 2; deltas << 16), then (atom, transition) pairs, then deltas,
// packed into one word each, node << 5 | difference + 16. Pure: all nodes are slots whose counter is all there is to
// know; then nothing branches on what becomes enabled, which under a random policy nobody can predict.
// Only for rendezvous that touch few counters: a hub's ports would make the tables quadratic. Slot k's program is at row k
// of equal rows, so that reaching it costs one cache line; what is longer than a row lies elsewhere, where the row says.
#include <algorithm>

#include "runtime/core/core.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kDeltasKept = 32;
constexpr u32 kMovesKept = 4096;
constexpr u32 kNodesKept = 1u << 27;
constexpr u32 kTransfer = 1, kPure = 2;
constexpr u32 kFar = 1u << 31;
constexpr u32 kRowWords = 16;  // a cache line

}  // namespace

void Core::build_programs() {
  std::vector<u32> words;  // all programs, each after its slot and length
  std::size_t longest = 1;
  std::vector<std::pair<u32, std::int32_t>> deltas;
  std::vector<u32> atoms;
  for (u32 slot = 0; slot < tables_.connector_slots; ++slot) {
    const SlotInfo& info = tables_.slots[slot];
    if (info.kind != SlotKind::Flat || info.searched || info.count > kMovesKept) continue;
    deltas.clear();
    atoms.clear();
    bool fits = true;
    for (u32 i = 0; i < info.count && fits; ++i) {
      const u32 instance = tables_.flat_ports[info.first + i];
      const PortState& port = ports_[instance];
      const AtomInfo& atom = atoms_[port.atom];
      fits = port.place != kNone && atom.watched == 0;
      if (!fits) break;
      atoms.push_back(port.atom);
      const LinkedTransition& transition = tables_.transitions[port.transition];
      for (u32 d = 0; d < transition.delta_count && fits; ++d) {
        const PortDelta& delta = tables_.deltas[transition.delta_first + d];
        const u32 moved = atom.port_base + delta.port;
        fits = tables_.port_watch[moved].size == 0 && deltas.size() <= 4 * kDeltasKept;
        for (u32 node : tables_.port_out[moved]) deltas.emplace_back(node, delta.transition != kNone ? 1 : -1);
      }
    }
    if (!fits) continue;
    std::sort(atoms.begin(), atoms.end());
    if (std::adjacent_find(atoms.begin(), atoms.end()) != atoms.end()) continue;
    std::sort(deltas.begin(), deltas.end());
    std::size_t kept = 0;
    for (std::size_t i = 0; i < deltas.size();) {
      std::pair<u32, std::int32_t> sum = deltas[i];
      for (++i; i < deltas.size() && deltas[i].first == sum.first; ++i) sum.second += deltas[i].second;
      if (sum.second != 0) deltas[kept++] = sum;
    }
    if (kept > kDeltasKept || values_.size() >= kNodesKept) continue;
    bool pure = !tables_.any_searched;
    for (std::size_t i = 0; i < kept; ++i) {
      fits = fits && deltas[i].second >= -16 && deltas[i].second < 16;
      pure = pure && deltas[i].first < is_direct_.size() && is_direct_[deltas[i].first] != 0;
    }
    if (!fits) continue;
    const u32 kept_count = static_cast<u32>(kept);
    const std::size_t start = words.size();
    words.insert(words.end(), {slot, 0});
    words.push_back((info.clause != kNone ? kTransfer : 0) | (pure ? kPure : 0) | info.count << 2 | kept_count << 16);
    for (u32 i = 0; i < info.count; ++i) {
      const PortState& port = ports_[tables_.flat_ports[info.first + i]];
      words.insert(words.end(), {port.atom, port.transition});
    }
    for (std::size_t i = 0; i < kept; ++i) words.push_back(deltas[i].first << 5 | static_cast<u32>(deltas[i].second + 16));
    words[start + 1] = static_cast<u32>(words.size() - start) - 2;
    longest = std::max(longest, std::size_t{std::min(words[start + 1], kRowWords)});
  }
  row_words_ = static_cast<u32>(longest);
  rows_.assign(tables_.slots.size() * longest, kNone);
  for (std::size_t at = 0; at < words.size(); at += words[at + 1] + 2) {
    const u32 length = words[at + 1];
    const auto program = words.begin() + static_cast<std::ptrdiff_t>(at) + 2;
    u32* row = rows_.data() + std::size_t{words[at]} * row_words_;
    if (length <= row_words_) {
      std::copy(program, program + length, row);
    } else {
      row[0] = kFar | static_cast<u32>(programs_.size());
      programs_.insert(programs_.end(), program, program + length);
    }
  }
}

bool Core::run_program(const u32* word, u32 slot) {
  if ((*word & kFar) != 0) word = programs_.data() + (*word & ~kFar);
  const u32 header = *word++;
  remember(slot);
  if ((header & kTransfer) != 0 && !run_transfer(tables_.slots[slot], tables_.slots[slot].clause)) return false;
  for (u32 i = header >> 2 & 0x3fff; i > 0; --i, word += 2) {
    const u32 atom = word[0];
    const LinkedTransition& transition = tables_.transitions[word[1]];
    places_[atom] = transition.to;
    if (transition.action.fn == nullptr) continue;
    const std::int32_t status =
        transition.action.fn(transition.action.context, all_.data() + atoms_[atom].slot_base, all_.data(), nullptr);
    if (status >= 2) return fail_code(status, atom, kNone, transition.source);
  }
  const u32* end = word + (header >> 16);
  if ((header & kPure) != 0) {
    for (; word != end; ++word) {
      const u32 node = *word >> 5;
      const std::int32_t before = values_[node];
      const std::int32_t after = before + static_cast<std::int32_t>(*word & 31) - 16;
      values_[node] = after;
      enabled_.follow(node, before, after);
    }
    return true;
  }
  for (; word != end; ++word) {
    const u32 node = *word >> 5;
    const std::int32_t before = values_[node];
    const std::int32_t after = before + static_cast<std::int32_t>(*word & 31) - 16;
    values_[node] = after;
    if ((before ^ after) < 0) crossed(node, after >= 0);
  }
  return (dirty_.empty() && dirty_rules_.empty()) || settle();
}

}  // namespace bip::rt
