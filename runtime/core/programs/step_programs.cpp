// See step_programs.hpp.
#include "runtime/core/programs/step_programs.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kDeltasKept = 32;
constexpr u32 kOpsKept = 1u << 17;
constexpr u32 kNodesKept = 1u << 26;
constexpr u32 kRowWords = 16;  // a cache line

constexpr u32 kPure = 1, kWide = 2;
constexpr u32 kDeltaLast = 1u << 5;
constexpr u32 kFar = 1u << 31;  // the program is elsewhere: at the row that the other bits say

// Are all of the interaction's ports of simple types? Else its effects are not the same each time. Found before its
// code is listed, for of many systems no interaction has a program.
bool has_simple_ports(const CoreParts& core, const InteractionInfo& info) {
  const Tables& tables = core.tables;
  const auto is_simple = [&](u32 instance) { return core.ports.port(instance).place != kNone; };
  if (info.kind == InteractionKind::Flat) {
    const auto first = tables.flat_ports.begin() + info.first;
    return std::all_of(first, first + info.count, is_simple);
  }
  const Plan& plan = tables.plans[info.plan()];
  const auto first = tables.plan_nodes.begin() + plan.first_node;
  return std::all_of(first, first + plan.node_count,
                     [&](const PlanNode& node) { return node.kind != NodeKind::Leaf || is_simple(node.ref); });
}

}  // namespace

u32 StepPrograms::code_row(Code code, u32 zeroed) {
  const auto [row, is_new] = code_rows_.try_emplace({code.fn, code.context, zeroed}, static_cast<u32>(codes_.size()));
  if (is_new) codes_.push_back({code, zeroed});
  return row->second;
}

// Code of a connector's clause; what runs first zeroes the connector's own data.
void StepPrograms::list_code(u32 connector, Code code, OwnData own, Codes& out) {
  const Connector& row = core_.tables.image->connectors[connector];
  const u32 size = own == OwnData::Zeroed ? core_.tables.connector_type(connector).variables.size : 0;
  if (code.fn == nullptr && size == 0) return;
  out.words.insert(out.words.end(), {code_row(code, size), row.first_cell, row.binds});
  out.owners.push_back({false, connector});
}

void StepPrograms::list_port(u32 instance, Parts& parts) {
  const PortState& port = core_.ports.port(instance);
  const u32 atom = core_.tables.port_atom[instance];
  parts.instances.push_back(instance);
  if (port.transition == kNone) return;
  const LinkedTransition& transition = core_.tables.transitions[port.transition];
  BIP_ASSERT(transition.port == instance - core_.tables.port_base(atom), "the transition of port {} is of port {}",
             instance, transition.port);
  if (transition.from != transition.to) parts.places.insert(parts.places.end(), {atom, transition.to});
  if (transition.action.fn != nullptr) {
    parts.after.words.insert(parts.after.words.end(),
                             {code_row(transition.action, 0), core_.atoms[atom].first_cell.value, 0});
    parts.after.owners.push_back({true, instance});
  }
}

// The plan's codes and ports, as fire_rigid would run them.
void StepPrograms::list_plan(const Plan& plan, Parts& parts) {
  u32 fired = 0;
  const auto list_ports = [&](u32 end) {
    for (; fired < end; ++fired) list_port(core_.tables.plan_ports[plan.first_port + fired], parts);
  };
  for (u32 row = plan.first_transfer; row < plan.end_transfer; ++row) {
    const PlanTransfer& transfer = core_.tables.plan_transfers[row];
    list_ports(transfer.port_end);
    list_code(transfer.connector, core_.tables.code(transfer.code),
              transfer.zeroed != 0 ? OwnData::Zeroed : OwnData::Kept, fired == 0 ? parts.before : parts.after);
  }
  list_ports(plan.port_count);
}

// Counters and guards that the step moves. False: not a step for a program.
bool StepPrograms::list_effects(Parts& parts) {
  std::vector<u32> atoms;
  std::vector<std::pair<u32, std::int32_t>>& deltas = parts.deltas;
  for (u32 instance : parts.instances) {
    const PortState& port = core_.ports.port(instance);
    const u32 row = core_.tables.port_atom[instance];
    const AtomInfo& atom = core_.atoms[row];
    BIP_ASSERT(port.place != kNone, "port {} is of a type that is not simple", instance);
    atoms.push_back(row);
    if (atom.watched != 0) {
      // Rules of priorities follow another way.
      if (core_.tables.atom_rules[row].size != 0) return false;
      for (const InteractionId interaction : core_.tables.atom_watch[row]) parts.touched.push_back(interaction);
    }
    const LinkedTransition& transition = core_.tables.transitions[port.transition];
    for (u32 d = 0; d < transition.delta_count; ++d) {
      const PortDelta& delta = core_.tables.deltas[transition.delta_first + d];
      const u32 moved = atom.port_base + delta.port;
      if (core_.tables.port_watch[moved].size != 0 || deltas.size() > 4 * kDeltasKept) return false;
      for (u32 node : core_.tables.port_out[moved]) deltas.emplace_back(node, delta.transition != kNone ? 1 : -1);
    }
    if (parts.touched.size() > 4 * kDeltasKept) return false;
  }
  std::sort(atoms.begin(), atoms.end());
  if (std::adjacent_find(atoms.begin(), atoms.end()) != atoms.end()) return false;
  std::sort(parts.touched.begin(), parts.touched.end());
  parts.touched.erase(std::unique(parts.touched.begin(), parts.touched.end()), parts.touched.end());
  std::sort(deltas.begin(), deltas.end());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < deltas.size();) {
    std::pair<u32, std::int32_t> sum = deltas[i];
    for (++i; i < deltas.size() && deltas[i].first == sum.first; ++i) sum.second += deltas[i].second;
    if (sum.second != 0) deltas[kept++] = sum;
  }
  deltas.resize(kept);
  if (kept > kDeltasKept || parts.touched.size() > kDeltasKept) return false;
  return std::all_of(deltas.begin(), deltas.end(), [](const auto& d) { return d.second >= -16 && d.second < 16; });
}

bool StepPrograms::list_program(InteractionId interaction, Parts& parts) {
  const InteractionInfo info = core_.tables.interactions[interaction];
  parts = {};
  if (info.kind == InteractionKind::Flat) {
    if (info.count > kOpsKept || !has_simple_ports(core_, info)) return false;
    if (info.clause() != kNone) {
      if (!core_.memory.ffi_data.empty()) return false;
      const Clause& clause = core_.tables.connector_type(info.row).clauses[info.clause()];
      const Code up = core_.tables.code(clause.up), down = core_.tables.code(clause.down);
      if (up.fn != nullptr) list_code(info.row, up, OwnData::Zeroed, parts.before);
      if (down.fn != nullptr)
        list_code(info.row, down, up.fn == nullptr ? OwnData::Zeroed : OwnData::Kept, parts.before);
    }
    for (u32 i = 0; i < info.count; ++i) list_port(core_.tables.flat_ports[info.first + i], parts);
  } else {
    if (info.kind != InteractionKind::Planned || info.searched || !core_.memory.ffi_data.empty()) return false;
    const Plan& plan = core_.tables.plans[info.plan()];
    if (!plan.rigid || plan.guarded || plan.has_choice || plan.node_count > kOpsKept) return false;
    if (!has_simple_ports(core_, info)) return false;
    list_plan(plan, parts);
  }
  return list_effects(parts);
}

// Building the programs of all interactions takes as long as about 16 steps an interaction without them. A replay of a
// few steps does not pay for it, a run soon does. Steps need what code is bound to all the same.
bool StepPrograms::build_if_worthwhile() {
  if (asked_ == 0) core_.memory.binds.make(*core_.tables.image);
  if (asked_++ < core_.tables.connector_interactions) return false;
  build();
  return true;
}

void StepPrograms::build() {
  std::vector<u32> words;  // all programs, each after its interaction and length
  std::size_t longest = 1;
  Parts parts;
  const std::size_t listed = core_.tables.node_count() < kNodesKept ? core_.tables.connector_interactions : 0;
  for (const InteractionId interaction : IdRange<InteractionId>(listed)) {
    if (!list_program(interaction, parts)) continue;
    bool pure = !core_.search.is_weighted() && parts.touched.empty();
    for (const auto& [node, by] : parts.deltas) pure = pure && core_.ports.direct().has(node);
    const std::size_t start = words.size();
    words.insert(words.end(), {interaction.value, 0});
    const u32 before = static_cast<u32>(parts.before.owners.size()),
              after = static_cast<u32>(parts.after.owners.size());
    const u32 places = static_cast<u32>(parts.places.size() / 2);
    const u32 deltas = static_cast<u32>(parts.deltas.size()), touched = static_cast<u32>(parts.touched.size());
    const bool wide = before > 63 || places > 63 || after > 31;
    words.push_back((pure ? kPure : 0) | (wide ? kWide : before << 14 | places << 20 | after << 26) | deltas << 2 |
                    touched << 8);
    if (wide) words.insert(words.end(), {before, places, after});
    for (const std::vector<u32>* part : {&parts.before.words, &parts.places, &parts.after.words})
      words.insert(words.end(), part->begin(), part->end());
    for (const InteractionId changed : parts.touched) words.push_back(changed.value);
    for (u32 i = 0; i < deltas; ++i) {
      const auto [node, by] = parts.deltas[i];
      const bool last = i + 1 == deltas || parts.deltas[i + 1].first >> 6 != node >> 6;
      words.push_back(node << 6 | (last ? kDeltaLast : 0) | static_cast<u32>(by + 16));
    }
    words[start + 1] = static_cast<u32>(words.size() - start) - 2;
    BIP_ASSERT(deltas < 64 && touched < 64, "{} counters, {} interactions", deltas, touched);
    longest = std::max(longest, std::size_t{std::min(words[start + 1], kRowWords)});
  }
  BIP_ASSERT(programs_.empty(), "programs were made before");
  BIP_ASSERT(longest <= kRowWords, "a row of {} words", longest);
  row_words_ = static_cast<u32>(longest);
  rows_.assign(core_.tables.interactions.size() * longest, kNone);
  for (std::size_t at = 0; at < words.size(); at += words[at + 1] + 2) {
    const u32 length = words[at + 1];
    BIP_ASSERT(words[at] < core_.tables.interactions.size() && at + 2 + length <= words.size(), "a program of {} words",
               length);
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

void StepPrograms::drop() {
  rows_ = {};
  programs_ = {};
}

// Whose code it was is looked up by listing the program once more: faults are rare.
bool StepPrograms::fail_program(std::int32_t status, InteractionId interaction, Half half, u32 index) {
  Parts parts;
  (void)list_program(interaction, parts);
  const auto [is_port, row] = (half == Half::Before ? parts.before : parts.after).owners[index];
  BIP_ASSERT(status >= 2, "no fault: {}", status);
  if (!is_port) return core_.faults.fail_code(status, kNone, row, nullptr);
  return core_.faults.fail_code(status, core_.tables.port_atom[row], kNone,
                                core_.tables.transitions[core_.ports.port(row).transition].source);
}

inline bool StepPrograms::run_codes(const u32* word, u32 count, InteractionId interaction, Half half) {
  // Locals: a call might change members, for all that the compiler knows.
  Cell* all = core_.memory.cells.all();
  const u32* binds = core_.memory.binds.rows;
  const ProgramCode* codes = codes_.data();
  for (u32 i = 0; i < count; ++i, word += 3) {
    const ProgramCode& row = codes[word[0]];
    BIP_ASSERT(word[0] < codes_.size() && word[1] + row.zeroed <= core_.memory.cells.size(), "code {} of {}", word[0],
               codes_.size());
    Cell* own = all + word[1];
    for (u32 k = 0; k < row.zeroed; ++k) own[k] = Cell{0};
    if (row.code.fn == nullptr) continue;
    const std::int32_t status = row.code.fn(row.code.context, own, all, binds + word[2]);
    if (status >= 2) return fail_program(status, interaction, half, i);
  }
  return true;
}

bool StepPrograms::run(const u32* word, InteractionId interaction) {
  BIP_ASSERT(core_.enabled.weight(interaction) != 0, "interaction {} has no candidate", interaction);
  if ((*word & kFar) != 0) word = programs_.data() + (*word & ~kFar);
  const u32 header = *word++;
  core_.history.remember(interaction);
  u32 before = header >> 14 & 63, places = header >> 20 & 63, after = header >> 26;
  if ((header & kWide) != 0) {
    before = word[0], places = word[1], after = word[2];
    word += 3;
  }
  if (before != 0) {
    if (!run_codes(word, before, interaction, Half::Before)) return false;
    word += std::size_t{before} * 3;
  }
  BIP_ASSERT(!core_.partial.is_beginning(), "a program takes a step as a whole");
  for (; places > 0; --places, word += 2) core_.memory.places[word[0]] = word[1];
  if (after != 0) {
    if (!run_codes(word, after, interaction, Half::After)) return false;
    word += std::size_t{after} * 3;
  }
  const u32* touched = word;
  word += header >> 8 & 63;
  const u32* end = word + (header >> 2 & 63);
  std::int32_t* values = core_.ports.values();
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
      BIP_ASSERT(word <= end, "a program goes on behind its end");
      core_.enabled.flip(delta >> 12, flips, difference);
    }
    return true;
  }
  for (; word != end; ++word) {
    const u32 node = *word >> 6;
    const std::int32_t was = values[node];
    const std::int32_t is = was + static_cast<std::int32_t>(*word & 31) - 16;
    values[node] = is;
    if ((was ^ is) < 0) core_.ports.crossed(node, is >= 0);
  }
  // What is not available has nothing to evaluate; an interaction that just became unavailable was marked above.
  for (u32 left = header >> 8 & 63; left > 0; --left, ++touched) {
    const InteractionId changed(*touched);
    if (core_.ports.is_available(changed)) core_.ports.mark_dirty(changed);
  }
  return core_.partial.is_on() ? core_.partial.settle() : core_.settle();
}

}  // namespace bip::rt
