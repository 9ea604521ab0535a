// See word_proof.hpp. Both automata are one machine over *signatures*. A signature says of each event and each of its
// places in a window: Blocked, Neutral or Hit.
//
//   of a set of modes (trap):  Blocked  every move of the port puts into the set, or there is none
//                              Neutral  some move does not put, but no such move takes from the set
//                              Hit      some move takes from the set and does not put
//   of modes (no step):        Blocked  the port is not surely enabled;  Hit: it is
//
// An event whose parts are all unblocked, one at least a hit, is *complete*: it empties the trap, or it is a step.
//
// A set of modes may also bound a count: of a set that no event makes larger (or none smaller), a reachable word has at
// most (at least) as many modes as the initial one. There the signature has the greatest change by the port's moves,
// changes add up, and an event is complete if their sum is positive.
//
// Less is better: a run of the automaton whose values are nowhere greater than another's makes that one superfluous.
#include "compiler/verify/sizes/word_proof.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_map>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

using u8 = std::uint8_t;
using u32 = std::uint32_t;

constexpr std::size_t kMostLetterModes = 14, kMostLetters = 4096, kMostRuns = 20'000, kMostNodes = 100'000,
                      kMostTransitions = 5'000'000;
constexpr u32 kNoState = 0xffffffffu;
constexpr const char* kTooLarge = "the automaton of all invariants is too large";

constexpr u8 kBlocked = 0;
// Traps, and whether there is a step.
constexpr u8 kNeutral = 1, kHit = 2;
// Counts: changes from this one; a sum below the least is taken as the least, one above the greatest ends the run.
constexpr u8 kNoChange = 8, kLeastSum = 5, kGreatestSum = 11, kSumTooLarge = 255;
// Counts: how many more there are than initially. A run that is further behind ends; one more is enough.
constexpr u8 kEven = 4, kFurthestBehind = 3, kOneMore = 5;

u8 neutral(SetPromise kind) { return kind == SetPromise::Trap ? kNeutral : kNoChange; }

u8 joined(SetPromise kind, u8 a, u8 b) {
  if (a == kBlocked || b == kBlocked) return kBlocked;
  if (kind == SetPromise::Trap) return std::max(a, b);
  const int sum = int(a) + int(b) - int(kNoChange);
  return sum > kGreatestSum ? kSumTooLarge : static_cast<u8>(std::max(sum, int(kLeastSum)));
}

bool is_complete(SetPromise kind, u8 value) { return value > neutral(kind); }

constexpr std::size_t kKindByte = 0, kFlagByte = 1, kFirstByte = 2;
using RunBytes = std::string;
using Signature = RunBytes;  // kind, flag, then by event its places
using RunState = RunBytes;   // kind, flag, by event what it has so far, then the windows

u8 byte(const RunBytes& bytes, std::size_t k) { return static_cast<u8>(bytes[k]); }
void set_byte(RunBytes& bytes, std::size_t k, u8 value) { bytes[k] = static_cast<char>(value); }
SetPromise kind_of(const RunBytes& bytes) { return static_cast<SetPromise>(bytes[kKindByte]); }

// Of one kind, no value of `a` is greater, and its flag is not less.
bool is_at_least_as_good(const RunBytes& a, const RunBytes& b) {
  BIP_ASSERT(a.size() == b.size(), "runs of {} and {} bytes", a.size(), b.size());
  if (a[kKindByte] != b[kKindByte] || byte(a, kFlagByte) < byte(b, kFlagByte)) return false;
  for (std::size_t k = kFirstByte; k < a.size(); ++k) {
    if (byte(a, k) > byte(b, k)) return false;
  }
  return true;
}

// Those to which no other is preferable; each once. Cost: quadratic.
std::vector<RunBytes> best_of(const std::vector<RunBytes>& rows) {
  std::vector<RunBytes> best;
  for (const RunBytes& a : rows) {
    const bool is_best =
        std::none_of(rows.begin(), rows.end(), [&a](const RunBytes& b) { return a != b && is_at_least_as_good(b, a); });
    if (is_best) best.push_back(a);
  }
  return best;
}

// A part of an event that reads one letter.
struct LetterPart {
  std::size_t place = 0;  // of the signature
  u32 atom = 0, port = 0;
  bool is_optional = false;
};

// The atoms that one letter stands for, or those outside of all arrays.
struct Letters {
  const std::vector<WordAtom>* atoms = nullptr;
  std::vector<u32> first_mode;  // by atom: bit of its first mode
  std::size_t modes = 0;
  std::vector<LetterPart> parts;
  std::vector<std::vector<u32>> all;   // modes by atom
  std::vector<u32> no_step;            // by letter: its signature
  std::vector<std::vector<u32>> sets;  // by letter: signatures of the best sets, of traps those that it does not meet
  std::vector<std::vector<u32>> bits;  // by letter: a set for each of these
};

class WordProver {
 public:
  /// Which sets take part: traps, or also those that bound a count.
  enum class Promises : std::uint8_t { Traps, All };
  WordProver(const WordProblem& problem, Promises promises, WordEvidence evidence,
             const CancellationToken& cancellation)
      : problem_(problem), promises_(promises), evidence_(evidence), cancellation_(cancellation) {}

  WordAnswer prove();

 private:
  struct Node {
    std::size_t zone = 0;  // of the next letter; all zones: the end
    u32 dead = 0;          // row of states_
    u32 runs = 0;          // row of sets_
    u32 parent = 0, letter = 0, single = 0;
  };
  [[nodiscard]] std::size_t zone_count() const { return problem_.zones.size(); }
  [[nodiscard]] const WordEvent& event(std::size_t e) const { return problem_.events[e]; }
  void lay_out();
  [[nodiscard]] bool is_active(std::size_t e, std::size_t zone) const;
  [[nodiscard]] bool list_letters(Letters& letters, const std::vector<WordAtom>& atoms);
  [[nodiscard]] Signature signature_of_modes(const Letters& letters, const std::vector<u32>& modes) const;
  [[nodiscard]] Signature signature_of_set(const Letters& letters, SetPromise kind, u32 set) const;
  [[nodiscard]] u8 flag_of_set(const Letters& letters, SetPromise kind, u32 set, const std::vector<u32>& modes) const;
  [[nodiscard]] bool leave_out_local(const Letters& letters, Signature& signature) const;
  [[nodiscard]] RunState initial_state(const Signature& singles) const;
  [[nodiscard]] std::optional<RunState> read(const RunState& state, std::size_t zone, const Signature& letter) const;
  // The row of the state after the letter; kNoState: an event is complete.
  [[nodiscard]] u32 next(u32 state, std::size_t zone, u32 signature);
  [[nodiscard]] bool is_accepted(const RunState& state) const;
  u32 state_row(const RunState& state);
  u32 signature_row(const Signature& signature);
  u32 set_row(std::vector<u32> runs);
  u32 add_node(const Node& node);
  void add_children(u32 at);
  [[nodiscard]] WordAnswer candidate(const Node& last) const;
  [[nodiscard]] std::vector<WordSetRow> needed_sets();

  const WordProblem& problem_;
  Promises promises_ = Promises::Traps;
  WordEvidence evidence_ = WordEvidence::None;
  const CancellationToken& cancellation_;
  std::vector<std::int64_t> base_offset_;  // by event: least offset of a loop's window
  std::vector<std::size_t> width_;         // by event: letters of its window; 1: not a loop, or no neighbours
  std::vector<std::size_t> place_;         // by event: its first place in a signature
  std::vector<std::size_t> window_;        // by event: its first byte of the windows in a state
  std::vector<u8> is_local_;               // by event: a loop without neighbours and without parts outside of arrays
  std::size_t places_ = kFirstByte, bytes_ = 0;
  std::vector<Letters> zones_;
  Letters singles_;
  std::unordered_map<RunBytes, u32> state_rows_, signature_rows_;
  std::vector<RunState> states_;
  std::vector<Signature> signatures_;
  std::vector<std::unordered_map<std::uint64_t, u32>> next_rows_;  // by zone, by state and signature
  std::map<std::vector<u32>, u32> set_rows_;
  std::vector<std::vector<u32>> sets_;
  std::size_t transitions_ = 0;
  std::vector<Node> nodes_;
  std::map<std::pair<std::size_t, std::pair<u32, u32>>, u32> node_rows_;
  std::vector<u32> begins_;                                 // by letter outside of arrays: its node
  std::vector<std::vector<std::pair<u32, u32>>> incoming_;  // by node, if sets are wanted: nodes before, and letters
  std::string reason_;
};

// A state: by event what was read of it outside of windows, and for each loop with a window of w letters 2 (w - 1)
// bytes: of the one that began k letters ago, k = 1 … w - 1, and of the one that begins k letters before the end, what
// its places in the first letters give.
void WordProver::lay_out() {
  const std::size_t events = problem_.events.size();
  bytes_ = kFirstByte + events;
  for (std::size_t e = 0; e < events; ++e) {
    std::int64_t least = problem_.margin + 1, greatest = -problem_.margin - 1;
    for (const WordPort& port : event(e).ports) {
      if (port.place != ElementPlace::AtLoop) continue;
      least = std::min(least, port.offset);
      greatest = std::max(greatest, port.offset);
    }
    const bool is_loop = event(e).is_loop;
    BIP_ENSURE(!is_loop || (least <= greatest && greatest - least <= problem_.margin), "a window of {} to {}", least,
               greatest);
    base_offset_.push_back(is_loop ? least : 0);
    width_.push_back(is_loop ? static_cast<std::size_t>(greatest - least) + 1 : 1);
    place_.push_back(places_);
    places_ += width_.back();
    window_.push_back(bytes_);
    bytes_ += 2 * (width_.back() - 1);
    const bool has_single = std::any_of(event(e).ports.begin(), event(e).ports.end(),
                                        [](const WordPort& p) { return p.place == ElementPlace::Single; });
    is_local_.push_back(is_loop && width_.back() == 1 && !has_single ? 1 : 0);
  }
  zones_.resize(zone_count());
  next_rows_.resize(zone_count());
  for (std::size_t e = 0; e < events; ++e) {
    for (const WordPort& port : event(e).ports) {
      const LetterPart part{place_[e], port.atom, port.port, port.is_optional};
      if (port.place == ElementPlace::Single) {
        singles_.parts.push_back(part);
        continue;
      }
      for (std::size_t zone = 0; zone < zone_count(); ++zone) {
        const auto position = static_cast<std::int64_t>(zone);
        const auto last = static_cast<std::int64_t>(zone_count()) - 1;
        if (port.place == ElementPlace::FromStart && position != port.offset) continue;
        if (port.place == ElementPlace::FromEnd && position != last - port.offset) continue;
        LetterPart own = part;
        if (port.place == ElementPlace::AtLoop) own.place += static_cast<std::size_t>(port.offset - base_offset_[e]);
        zones_[zone].parts.push_back(own);
      }
    }
  }
}

// Whether a window of the loop begins at a letter of the zone: whether i = position - base offset, round the word, is
// within the loop's bounds. The same at all sizes, because offsets and bounds are within the margin.
bool WordProver::is_active(std::size_t e, std::size_t zone) const {
  const auto size = static_cast<std::int64_t>(zone_count());
  const std::int64_t i = ((static_cast<std::int64_t>(zone) - base_offset_[e]) % size + size) % size;
  return i >= event(e).low && i < size - event(e).high;
}

Signature WordProver::signature_of_modes(const Letters& letters, const std::vector<u32>& modes) const {
  Signature out(places_, static_cast<char>(kNeutral));
  set_byte(out, kKindByte, static_cast<u8>(SetPromise::Trap));
  set_byte(out, kFlagByte, 0);
  for (std::size_t a = 0; a < modes.size(); ++a) {
    if ((*letters.atoms)[a].is_final[modes[a]] == 0) set_byte(out, kFlagByte, 1);
  }
  for (const LetterPart& part : letters.parts) {
    if (part.is_optional) continue;
    const bool is_sure = (*letters.atoms)[part.atom].modes->is_sure[part.port][modes[part.atom]] != 0;
    set_byte(out, part.place, joined(SetPromise::Trap, byte(out, part.place), is_sure ? kHit : kBlocked));
  }
  return out;
}

// Without the flag.
Signature WordProver::signature_of_set(const Letters& letters, SetPromise kind, u32 set) const {
  Signature out(places_, static_cast<char>(neutral(kind)));
  set_byte(out, kKindByte, static_cast<u8>(kind));
  set_byte(out, kFlagByte, 0);
  for (const LetterPart& part : letters.parts) {
    const u32 first = letters.first_mode[part.atom];
    u8 value = kBlocked;
    for (const Move& move : (*letters.atoms)[part.atom].modes->moves[part.port]) {
      const int takes = static_cast<int>(set >> (first + move.from) & 1);
      const int puts = static_cast<int>(set >> (first + move.to) & 1);
      if (kind == SetPromise::Trap) {
        if (puts == 0) value = std::max(value, takes != 0 ? kHit : kNeutral);
      } else {
        const int change = kind == SetPromise::AtMost ? puts - takes : takes - puts;
        value = std::max(value, static_cast<u8>(int(kNoChange) + change));
      }
    }
    if (part.is_optional) value = std::max(value, neutral(kind));
    set_byte(out, part.place, joined(kind, byte(out, part.place), value));
  }
  return out;
}

// Traps: 1 if the set is marked initially. Counts: how many more of the modes it has than the initial state.
u8 WordProver::flag_of_set(const Letters& letters, SetPromise kind, u32 set, const std::vector<u32>& modes) const {
  bool is_marked = false;
  int more = 0;
  for (std::size_t a = 0; a < modes.size(); ++a) {
    const auto has = [&](u32 mode) { return (set >> (letters.first_mode[a] + mode) & 1) != 0; };
    const std::vector<u32>& initial = (*letters.atoms)[a].modes->initial;
    const bool all = !initial.empty() && std::all_of(initial.begin(), initial.end(), has);
    const bool any = initial.empty() || std::any_of(initial.begin(), initial.end(), has);
    is_marked = is_marked || all;
    if (kind == SetPromise::AtMost) more += int(has(modes[a])) - int(any);
    else more += int(all) - int(has(modes[a]));
  }
  if (kind == SetPromise::Trap) return is_marked ? 1 : 0;
  return static_cast<u8>(std::clamp(int(kEven) + more, 0, int(kOneMore)));
}

// What only this letter takes part in is decided here: false if it is complete.
bool WordProver::leave_out_local(const Letters& letters, Signature& signature) const {
  if (&letters == &singles_) return true;
  const SetPromise kind = kind_of(signature);
  const auto zone = static_cast<std::size_t>(&letters - zones_.data());
  for (std::size_t e = 0; e < problem_.events.size(); ++e) {
    if (is_local_[e] == 0) continue;
    if (is_active(e, zone) && is_complete(kind, byte(signature, place_[e]))) return false;
    set_byte(signature, place_[e], kBlocked);
  }
  return true;
}

bool WordProver::list_letters(Letters& letters, const std::vector<WordAtom>& atoms) {
  letters.atoms = &atoms;
  std::size_t count = 1;
  for (const WordAtom& atom : atoms) {
    letters.first_mode.push_back(static_cast<u32>(letters.modes));
    letters.modes += atom.modes->modes.size();
    count = std::min(count * atom.modes->modes.size(), kMostLetters + 1);
  }
  if (letters.modes > kMostLetterModes || count > kMostLetters) {
    reason_ = "the components at one position have more than " + std::to_string(kMostLetterModes) + " local states";
    return false;
  }
  std::vector<u32> modes(atoms.size(), 0);
  for (std::size_t k = 0; k < count; ++k) {
    letters.all.push_back(modes);
    for (std::size_t a = 0; a < modes.size() && ++modes[a] == atoms[a].modes->modes.size(); ++a) modes[a] = 0;
  }
  // All sets once, then for each letter the best of each signature.
  std::map<Signature, std::vector<u32>> sets;
  for (const SetPromise kind : {SetPromise::Trap, SetPromise::AtMost, SetPromise::AtLeast}) {
    if (kind != SetPromise::Trap && promises_ == Promises::Traps) break;
    for (u32 set = 0; set < (u32(1) << letters.modes); ++set) {
      Signature signature = signature_of_set(letters, kind, set);
      if (leave_out_local(letters, signature)) sets[std::move(signature)].push_back(set);
    }
  }
  for (const std::vector<u32>& own : letters.all) {
    u32 mask = 0;
    for (std::size_t a = 0; a < own.size(); ++a) mask |= u32(1) << (letters.first_mode[a] + own[a]);
    std::vector<Signature> found;
    std::map<Signature, u32> set_of;
    for (const auto& [signature, rows] : sets) {
      const SetPromise kind = kind_of(signature);
      std::optional<u8> flag;
      u32 chosen = 0;
      for (const u32 set : rows) {
        if (kind == SetPromise::Trap && (set & mask) != 0) continue;
        const u8 its_flag = flag_of_set(letters, kind, set, own);
        if (!flag || its_flag > *flag) chosen = set;
        flag = std::max(flag.value_or(0), its_flag);
      }
      if (!flag) continue;
      found.push_back(signature);
      set_byte(found.back(), kFlagByte, *flag);
      set_of.emplace(found.back(), chosen);
    }
    std::vector<u32>&best = letters.sets.emplace_back(), &bits = letters.bits.emplace_back();
    for (const Signature& signature : best_of(found)) {
      best.push_back(signature_row(signature));
      bits.push_back(set_of.at(signature));
    }
    letters.no_step.push_back(signature_row(signature_of_modes(letters, own)));
    if (cancellation_.is_over()) {
      reason_ = "the limit of time is met";
      return false;
    }
  }
  return true;
}

RunState WordProver::initial_state(const Signature& singles) const {
  RunState state(bytes_, static_cast<char>(kBlocked));
  state[kKindByte] = singles[kKindByte];
  state[kFlagByte] = singles[kFlagByte];
  for (std::size_t e = 0; e < problem_.events.size(); ++e) {
    state[kFirstByte + e] = singles[place_[e]];
    const std::size_t w = width_[e];
    for (std::size_t k = 1; k < w; ++k) {
      const bool begins = is_active(e, zone_count() - k);
      set_byte(state, window_[e] + (w - 1) + (k - 1), begins ? neutral(kind_of(singles)) : kBlocked);
    }
  }
  return state;
}

// nullopt: an event is complete, or the run ends.
std::optional<RunState> WordProver::read(const RunState& state, std::size_t zone, const Signature& letter) const {
  BIP_ASSERT(state.size() == bytes_ && letter.size() == places_ && zone < zone_count(),
             "a state of {} bytes, a letter of {}, zone {}", state.size(), letter.size(), zone);
  const SetPromise kind = kind_of(state);
  RunState next = state;
  if (kind == SetPromise::Trap) {
    set_byte(next, kFlagByte, std::max(byte(state, kFlagByte), byte(letter, kFlagByte)));
  } else {
    const int more = int(byte(state, kFlagByte)) + int(byte(letter, kFlagByte)) - int(kEven);
    if (more < int(kFurthestBehind)) return std::nullopt;
    set_byte(next, kFlagByte, static_cast<u8>(std::min(more, int(kOneMore))));
  }
  for (std::size_t e = 0; e < problem_.events.size(); ++e) {
    const auto part = [&](std::size_t k) { return byte(letter, place_[e] + k); };
    if (!event(e).is_loop) {
      const u8 sum = joined(kind, byte(state, kFirstByte + e), part(0));
      if (sum == kSumTooLarge) return std::nullopt;
      set_byte(next, kFirstByte + e, sum);
      continue;
    }
    const std::size_t w = width_[e];
    const std::size_t begun = window_[e], wrapped = begun + (w - 1);
    // The window that began k letters ago has its place k here.
    u8 carried = is_active(e, zone) ? joined(kind, byte(state, kFirstByte + e), part(0)) : kBlocked;
    for (std::size_t k = 1; k < w; ++k) {
      if (carried == kSumTooLarge) return std::nullopt;
      const u8 sum = joined(kind, byte(state, begun + k - 1), part(k));
      set_byte(next, begun + k - 1, carried);
      carried = sum;
    }
    if (is_complete(kind, carried)) return std::nullopt;
    // The one that begins k letters before the end has its place k + p in letter p.
    for (std::size_t k = 1; k + zone < w; ++k) {
      const u8 sum = joined(kind, byte(state, wrapped + k - 1), part(k + zone));
      if (sum == kSumTooLarge) return std::nullopt;
      set_byte(next, wrapped + k - 1, sum);
    }
  }
  return next;
}

u32 WordProver::next(u32 state, std::size_t zone, u32 signature) {
  if (states_[state][kKindByte] != signatures_[signature][kKindByte]) return kNoState;
  const auto [row, is_new] =
      next_rows_[zone].try_emplace(std::uint64_t(state) << 32 | std::uint64_t(signature), kNoState);
  if (!is_new) return row->second;
  if (++transitions_ > kMostTransitions) reason_ = kTooLarge;
  const std::optional<RunState> found = read(states_[state], zone, signatures_[signature]);
  if (found) row->second = state_row(*found);
  return row->second;
}

// After the last letter: no event is complete, and the set promises what the word breaks.
bool WordProver::is_accepted(const RunState& state) const {
  const SetPromise kind = kind_of(state);
  for (std::size_t e = 0; e < problem_.events.size(); ++e) {
    if (!event(e).is_loop && is_complete(kind, byte(state, kFirstByte + e))) return false;
    const std::size_t w = width_[e];
    for (std::size_t k = 1; k < w; ++k) {
      const u8 begun = byte(state, window_[e] + k - 1), wrapped = byte(state, window_[e] + (w - 1) + k - 1);
      if (is_complete(kind, joined(kind, begun, wrapped))) return false;
    }
  }
  return byte(state, kFlagByte) == (kind == SetPromise::Trap ? 1 : kOneMore);
}

u32 WordProver::state_row(const RunState& state) {
  const auto [row, is_new] = state_rows_.try_emplace(state, static_cast<u32>(states_.size()));
  if (is_new) states_.push_back(state);
  return row->second;
}

u32 WordProver::signature_row(const Signature& signature) {
  const auto [row, is_new] = signature_rows_.try_emplace(signature, static_cast<u32>(signatures_.size()));
  if (is_new) signatures_.push_back(signature);
  return row->second;
}

// Of the best of the runs. Cost: quadratic in them.
u32 WordProver::set_row(std::vector<u32> runs) {
  std::sort(runs.begin(), runs.end());
  runs.erase(std::unique(runs.begin(), runs.end()), runs.end());
  if (runs.size() > kMostRuns) {
    reason_ = kTooLarge;
    return 0;
  }
  std::vector<u32> best;
  for (const u32 a : runs) {
    const bool is_best = std::none_of(runs.begin(), runs.end(),
                                      [&](u32 b) { return a != b && is_at_least_as_good(states_[b], states_[a]); });
    if (is_best) best.push_back(a);
  }
  const auto [row, is_new] = set_rows_.try_emplace(best, static_cast<u32>(sets_.size()));
  if (is_new) sets_.push_back(best);
  return row->second;
}

u32 WordProver::add_node(const Node& node) {
  const auto [at, is_new] =
      node_rows_.try_emplace({node.zone, {node.dead, node.runs}}, static_cast<u32>(nodes_.size()));
  if (is_new) nodes_.push_back(node);
  if (evidence_ == WordEvidence::Sets) {
    incoming_.resize(nodes_.size());
    if (node.letter != 0) incoming_[at->second].emplace_back(node.parent, node.letter - 1);
  }
  return at->second;
}

// One for each letter after which no step is complete; after the middle zone comes itself again, or the next one.
void WordProver::add_children(u32 at) {
  const Node node = nodes_[at];
  BIP_ASSERT(node.zone < zone_count(), "node {} is at the end", at);
  const Letters& letters = zones_[node.zone];
  for (std::size_t l = 0; l < letters.all.size() && reason_.empty(); ++l) {
    const u32 dead = next(node.dead, node.zone, letters.no_step[l]);
    if (dead == kNoState) continue;
    if (cancellation_.is_over()) reason_ = "the limit of time is met";
    std::vector<u32> runs;
    for (const u32 run : sets_[node.runs]) {
      if (runs.size() > kMostTransitions) reason_ = kTooLarge;
      if (!reason_.empty()) return;
      for (const u32 set : letters.sets[l]) {
        if (const u32 after = next(run, node.zone, set); after != kNoState) runs.push_back(after);
      }
    }
    Node child{node.zone + 1, dead, set_row(std::move(runs)), at, static_cast<u32>(l) + 1, node.single};
    add_node(child);
    if (node.zone != static_cast<std::size_t>(problem_.margin)) continue;
    child.zone = node.zone;
    add_node(child);
  }
}

WordAnswer WordProver::candidate(const Node& last) const {
  WordAnswer answer;
  answer.outcome = WordAnswer::Outcome::Candidate;
  answer.nodes = nodes_.size();
  BIP_ASSERT(last.zone == zone_count() && last.single < singles_.all.size(), "a candidate that ends in zone {}",
             last.zone);
  answer.singles = singles_.all[last.single];
  for (Node node = last; node.letter != 0; node = nodes_[node.parent])
    answer.letters.push_back(zones_[nodes_[node.parent].zone].all[node.letter - 1]);
  std::reverse(answer.letters.begin(), answer.letters.end());
  return answer;
}

// Of each word without a step that comes to its end one run that excludes it, back to the beginning: at each node the
// runs that those after it need, each by one set for each letter. Of sets that bound a count it does not matter how
// many of them a word has.
std::vector<WordSetRow> WordProver::needed_sets() {
  std::set<std::pair<u32, u32>> needed;  // node, run
  std::vector<std::pair<u32, u32>> open;
  const auto need = [&](u32 node, u32 run) {
    if (needed.emplace(node, run).second) open.emplace_back(node, run);
  };
  for (u32 at = 0; at < nodes_.size(); ++at) {
    if (nodes_[at].zone != zone_count() || !is_accepted(states_[nodes_[at].dead])) continue;
    const std::vector<u32>& runs = sets_[nodes_[at].runs];
    const auto run = std::find_if(runs.begin(), runs.end(), [this](u32 r) { return is_accepted(states_[r]); });
    BIP_ENSURE(run != runs.end(), "node {} is excluded", at);
    need(at, *run);
  }
  // Zone of the next letter, and the run.
  std::map<std::pair<std::size_t, RunState>, u32> numbers;
  const auto number = [&](std::size_t zone, u32 run) {
    RunState state = states_[run];
    if (kind_of(state) != SetPromise::Trap) set_byte(state, kFlagByte, 0);
    return numbers.try_emplace({zone, std::move(state)}, static_cast<u32>(numbers.size())).first->second;
  };
  std::set<std::tuple<std::size_t, u32, u32, u32, u8>> rows;  // 0 or the letter's zone + 1, from, set, to, kind
  enum class Runs : std::uint8_t { Needed, All };
  const auto link = [&](u32 node, u32 run, u32 before, u32 letter, Runs runs) {
    const std::size_t zone = nodes_[before].zone;
    const Letters& letters = zones_[zone];
    for (const u32 from : sets_[nodes_[before].runs]) {
      if (runs == Runs::Needed && !needed.contains({before, from})) continue;
      for (std::size_t k = 0; k < letters.sets[letter].size(); ++k) {
        if (next(from, zone, letters.sets[letter][k]) != run) continue;
        rows.emplace(zone + 1, number(zone, from), letters.bits[letter][k], number(nodes_[node].zone, run),
                     static_cast<u8>(kind_of(states_[run])));
        need(before, from);
        return true;
      }
    }
    return false;
  };
  while (!open.empty() && reason_.empty()) {
    const auto [node, run] = open.back();
    open.pop_back();
    if (cancellation_.is_over()) reason_ = "the limit of time is met";
    for (const auto& [before, letter] : incoming_[node]) {
      const bool is_linked =
          link(node, run, before, letter, Runs::Needed) || link(node, run, before, letter, Runs::All);
      BIP_ENSURE(is_linked, "run {} of node {} comes from node {}", run, node, before);
    }
    for (std::size_t s = 0; s < begins_.size(); ++s) {
      if (begins_[s] != node) continue;
      const std::vector<u32>& sets = singles_.sets[s];
      const auto set = std::find_if(sets.begin(), sets.end(), [&, this, run = run](u32 row) {
        return state_row(initial_state(signatures_[row])) == run;
      });
      BIP_ENSURE(set != sets.end(), "run {} of node {} begins with a set", run, node);
      rows.emplace(0, 0, singles_.bits[s][static_cast<std::size_t>(set - sets.begin())], number(0, run),
                   static_cast<u8>(kind_of(states_[run])));
    }
  }
  std::vector<WordSetRow> out;
  for (const auto& [zone, from, set, to, kind] : rows) {
    const Letters& letters = zone == 0 ? singles_ : zones_[zone - 1];
    WordSetRow& row =
        out.emplace_back(WordSetRow{zone == 0, static_cast<SetPromise>(kind), from, to, zone == 0 ? 0 : zone - 1, {}});
    for (u32 atom = 0; atom < letters.first_mode.size(); ++atom) {
      for (u32 mode = 0; mode < (*letters.atoms)[atom].modes->modes.size(); ++mode) {
        if ((set >> (letters.first_mode[atom] + mode) & 1) != 0) row.modes.emplace_back(atom, mode);
      }
    }
  }
  return out;
}

WordAnswer WordProver::prove() {
  WordAnswer answer;
  lay_out();
  bool is_listed = list_letters(singles_, problem_.singles);
  for (std::size_t zone = 0; zone < zone_count() && is_listed; ++zone)
    is_listed = list_letters(zones_[zone], problem_.zones[zone]);
  for (std::size_t s = 0; s < singles_.all.size() && is_listed; ++s) {
    Signature no_step = signatures_[singles_.no_step[s]];
    for (std::size_t e = 0; e < problem_.events.size(); ++e) {
      if (!event(e).is_sure) set_byte(no_step, place_[e], kBlocked);
    }
    std::vector<u32> runs;
    for (const u32 set : singles_.sets[s]) runs.push_back(state_row(initial_state(signatures_[set])));
    const u32 row = set_row(std::move(runs));
    begins_.push_back(add_node({0, state_row(initial_state(no_step)), row, 0, 0, static_cast<u32>(s)}));
  }
  for (u32 at = 0; at < nodes_.size() && reason_.empty(); ++at) {
    if (nodes_.size() > kMostNodes) reason_ = kTooLarge;
    if (nodes_[at].zone != zone_count()) {
      add_children(at);
      continue;
    }
    const std::vector<u32>& runs = sets_[nodes_[at].runs];
    const bool is_excluded =
        std::any_of(runs.begin(), runs.end(), [this](u32 run) { return is_accepted(states_[run]); });
    if (is_accepted(states_[nodes_[at].dead]) && !is_excluded) return candidate(nodes_[at]);
  }
  if (reason_.empty() && evidence_ == WordEvidence::Sets) answer.sets = needed_sets();
  answer.outcome = reason_.empty() ? WordAnswer::Outcome::Proved : WordAnswer::Outcome::TooLarge;
  answer.nodes = nodes_.size();
  answer.reason = reason_;
  return answer;
}

}  // namespace

WordAnswer prove_words(const WordProblem& problem, const CancellationToken& cancellation, WordEvidence evidence) {
  BIP_ASSERT(problem.zones.size() == static_cast<std::size_t>(2 * problem.margin + 1), "{} zones",
             problem.zones.size());
  WordAnswer answer = WordProver(problem, WordProver::Promises::Traps, evidence, cancellation).prove();
  if (answer.outcome != WordAnswer::Outcome::Candidate) return answer;
  WordAnswer counted = WordProver(problem, WordProver::Promises::All, evidence, cancellation).prove();
  // A candidate says more than a limit does.
  return counted.outcome == WordAnswer::Outcome::TooLarge ? answer : counted;
}

}  // namespace bip::verify
