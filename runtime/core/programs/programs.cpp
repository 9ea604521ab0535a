// Whole steps as short programs. A rendezvous of atoms of simple types has the same effect every time: these pieces of
// code on these rows, these places, these counters of the availability network each by a known amount, these guards to
// look at again. Listed once, firing is a few loops over one array, without a look at ports or at the image
// (a superinstruction, see compiler/docs/performance.md; two to four times as fast as following ports one by one).
// Hierarchies without triggers, guards and merged ports are such rendezvous too.
//
// A program: a header (1: pure; deltas << 2, touched << 8, codes before the places << 14, places << 20, codes after <<
// 26; if a count does not fit, kWide and a word each), then codes (row of codes_, row in `all` of their own
// interactions, row of binds), (atom, place) pairs, codes, touched interactions, and deltas: node << 6 | last << 5 |
// difference + 16, `last` ends the nodes of one word of the enabled set. Pure: nothing is touched and all nodes are
// interactions whose counter is all there is to know; then nothing branches on what becomes enabled, which under a
// random policy nobody can predict. Only for rendezvous that touch few counters: a hub's ports would make the tables
// quadratic. Cell k's program is at row k of equal rows, a cache line at most, so that reaching it costs one; what is
// longer lies elsewhere, where the row says.
#include <algorithm>

#include "runtime/core/core.hpp"
#include "runtime/core/programs/program_words.hpp"

namespace bip::rt {

namespace {

constexpr std::size_t kDeltasKept = 32;
constexpr u32 kOpsKept = 1u << 17;
constexpr u32 kNodesKept = 1u << 26;
constexpr u32 kRowWords = 16;  // a cache line

}  // namespace

u32 Core::code_row(Code code, u32 zeroed) {
  const auto [row, is_new] = code_rows_.try_emplace({code.fn, code.context, zeroed}, static_cast<u32>(codes_.size()));
  if (is_new) codes_.push_back({code, zeroed});
  return row->second;
}

// Code of a connector's clause; what runs first zeroes the connector's own data.
void Core::list_code(u32 connector, Code code, bool zeroes, ProgramCodes& out) {
  const Connector& row = tables_.image->connectors[connector];
  const u32 size = zeroes ? tables_.connector_type(connector).variables.size : 0;
  if (code.fn == nullptr && size == 0) return;
  out.words.insert(out.words.end(), {code_row(code, size), row.first_cell, row.binds});
  out.owners.push_back({false, connector});
}

void Core::list_port(u32 instance, ProgramParts& parts) {
  const PortState& port = ports_[instance];
  const u32 atom = tables_.port_atom[instance];
  parts.instances.push_back(instance);
  if (port.transition == kNone) return;
  const LinkedTransition& transition = tables_.transitions[port.transition];
  if (transition.from != transition.to) parts.places.insert(parts.places.end(), {atom, transition.to});
  if (transition.action.fn != nullptr) {
    parts.after.words.insert(parts.after.words.end(), {code_row(transition.action, 0), atoms_[atom].first_cell, 0});
    parts.after.owners.push_back({true, instance});
  }
}

// The plan's codes and ports in the order in which fire_planned would run them.
void Core::list_plan(const Plan& plan, ProgramParts& parts) {
  const auto clause_code = [&](const PlanUse& use, bool up) {
    if (use.clause == kNone) return Code{};
    const Clause& clause = tables_.connector_type(use.connector).clauses[use.clause];
    return tables_.code(up ? clause.up : clause.down);
  };
  for (u32 i = plan.use_count; i-- > 0;) {
    const PlanUse& use = tables_.plan_uses[plan.first_use + i];
    list_code(use.connector, clause_code(use, true), true, parts.before);
  }
  std::vector<std::pair<u32, u32>> stack{{0, 0}};
  while (!stack.empty()) {
    const PlanUse& use = tables_.plan_uses[plan.first_use + stack.back().first];
    const u32 param = stack.back().second++;
    if (param == 0)
      list_code(use.connector, clause_code(use, false), false, parts.instances.empty() ? parts.before : parts.after);
    if (param == tables_.connector_type(use.connector).params.size) {
      stack.pop_back();
      continue;
    }
    const u32 node = tables_.plan_params[use.first_param + param];
    if (node == kNone) continue;
    const PlanNode& at = tables_.plan_nodes[plan.first_node + node];
    if (at.kind == NodeKind::Link) stack.emplace_back(at.use, 0);
    else list_port(at.ref, parts);
  }
}

// Counters and guards that the step moves. False: not a step for a program.
bool Core::list_effects(ProgramParts& parts) {
  std::vector<u32> atoms;
  std::vector<std::pair<u32, std::int32_t>>& deltas = parts.deltas;
  for (u32 instance : parts.instances) {
    const PortState& port = ports_[instance];
    const u32 row = tables_.port_atom[instance];
    const AtomInfo& atom = atoms_[row];
    if (port.place == kNone) return false;
    atoms.push_back(row);
    if (atom.watched != 0) {
      for (u32 item : tables_.atom_watch[row]) {
        // Rules of priorities follow another way.
        if (item >= tables_.interactions.size()) return false;
        parts.touched.push_back(item);
      }
    }
    const LinkedTransition& transition = tables_.transitions[port.transition];
    for (u32 d = 0; d < transition.delta_count; ++d) {
      const PortDelta& delta = tables_.deltas[transition.delta_first + d];
      const u32 moved = atom.port_base + delta.port;
      if (tables_.port_watch[moved].size != 0 || deltas.size() > 4 * kDeltasKept) return false;
      for (u32 node : tables_.port_out[moved]) deltas.emplace_back(node, delta.transition != kNone ? 1 : -1);
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

bool Core::list_program(u32 interaction, ProgramParts& parts) {
  const InteractionInfo info = tables_.interactions[interaction];
  parts = {};
  if (info.kind == InteractionKind::Flat) {
    if (info.count > kOpsKept) return false;
    if (info.clause() != kNone) {
      if (!ffi_data_.empty()) return false;
      const Clause& clause = tables_.connector_type(info.row).clauses[info.clause()];
      const Code up = tables_.code(clause.up), down = tables_.code(clause.down);
      if (up.fn != nullptr) list_code(info.row, up, true, parts.before);
      if (down.fn != nullptr) list_code(info.row, down, up.fn == nullptr, parts.before);
    }
    for (u32 i = 0; i < info.count; ++i) list_port(tables_.flat_ports[info.first + i], parts);
  } else {
    if (info.kind != InteractionKind::Planned || info.searched || !ffi_data_.empty()) return false;
    const Plan& plan = tables_.plans[info.plan()];
    if (!plan.rigid || plan.guarded || plan.has_choice || plan.node_count > kOpsKept) return false;
    list_plan(plan, parts);
  }
  return list_effects(parts);
}

void Core::build_programs() {
  binds_.make(*tables_.image);
  std::vector<u32> words;  // all programs, each after its interaction and length
  std::size_t longest = 1;
  ProgramParts parts;
  for (u32 interaction = 0; interaction < tables_.connector_interactions && values_.size() < kNodesKept;
       ++interaction) {
    if (!list_program(interaction, parts)) continue;
    bool pure = !tables_.any_searched && parts.touched.empty();
    for (const auto& [node, by] : parts.deltas) pure = pure && direct_.has(node);
    const std::size_t start = words.size();
    words.insert(words.end(), {interaction, 0});
    const u32 before = static_cast<u32>(parts.before.owners.size()),
              after = static_cast<u32>(parts.after.owners.size());
    const u32 places = static_cast<u32>(parts.places.size() / 2);
    const u32 deltas = static_cast<u32>(parts.deltas.size()), touched = static_cast<u32>(parts.touched.size());
    const bool wide = before > 63 || places > 63 || after > 31;
    words.push_back((pure ? kPure : 0) | (wide ? kWide : before << 14 | places << 20 | after << 26) | deltas << 2 |
                    touched << 8);
    if (wide) words.insert(words.end(), {before, places, after});
    for (const std::vector<u32>* part : {&parts.before.words, &parts.places, &parts.after.words, &parts.touched}) {
      words.insert(words.end(), part->begin(), part->end());
    }
    for (u32 i = 0; i < deltas; ++i) {
      const auto [node, by] = parts.deltas[i];
      const bool last = i + 1 == deltas || parts.deltas[i + 1].first >> 6 != node >> 6;
      words.push_back(node << 6 | (last ? kDeltaLast : 0) | static_cast<u32>(by + 16));
    }
    words[start + 1] = static_cast<u32>(words.size() - start) - 2;
    longest = std::max(longest, std::size_t{std::min(words[start + 1], kRowWords)});
  }
  row_words_ = static_cast<u32>(longest);
  rows_.assign(tables_.interactions.size() * longest, kNone);
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

void Core::drop_programs() {
  if (!can_batch()) return;
  rows_ = {};
  programs_ = {};
  if (!looks_at_binds()) binds_ = {};
}

}  // namespace bip::rt
