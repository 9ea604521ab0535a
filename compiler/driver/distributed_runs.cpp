// See distributed_runs.hpp.
#include "compiler/driver/distributed_runs.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/base/read_file.hpp"
#include "compiler/driver/interaction_counts.hpp"
#include "compiler/driver/known_conflicts.hpp"
#include "runtime/core/fire/partial.hpp"
#include "runtime/distributed/faults.hpp"
#include "runtime/distributed/place_free_atoms.hpp"
#include "runtime/distributed/split_sets.hpp"

namespace bip::driver {

namespace {

constexpr std::size_t kMostListed = 20;
constexpr std::size_t kMostConnectors = 3;  // of a reason

// What is linked without code.
struct Linked {
  explicit Linked(const rt::Image& image, rt::MaximalProgress progress = rt::MaximalProgress::On)
      : tables(rt::link(image, progress)), rules(rt::link_priorities(tables)) {}
  rt::Tables tables;
  rt::PriorityTables rules;
};

bool is_distributable(Compilation& c) {
  const rt::TimeOnNodes time = rt::time_on_nodes(c.lowered->image);
  if (time.problem.empty()) return true;
  c.diags.report(Diag::kB5071, {}, time.problem).note(time.why).help(time.help);
  return false;
}

std::string place_text(const rt::Image& image, const rt::SourceLine& loc) {
  return loc.line == 0 ? std::string() : fmt::format(" ({}:{}:{})", image.files[loc.file], loc.line, loc.column);
}

std::string connector_text(const rt::Image& image, const rt::Connector& connector) {
  return fmt::format("`{}`{}", connector.path(), place_text(image, connector.loc));
}

// Of a place of the image, if its text was read: one byte. A .bsys file has none.
SourceRange range_of(const Compilation& c, const rt::SourceLine& loc) {
  const FileId file(loc.file);
  if (loc.line == 0 || loc.file >= c.sources.size() || c.sources.name(file) != c.lowered->image.files[loc.file])
    return {};
  const std::string_view text = c.sources.text(file), line = c.sources.line(file, loc.line);
  if (loc.column == 0 || loc.column > line.size()) return {};
  const auto begin = static_cast<std::uint32_t>(line.data() - text.data()) + loc.column - 1;
  return {file, begin, begin + 1};
}

bool crosses_nothing(Compilation& c, const Linked& linked, const rt::Distribution& distribution) {
  const rt::Image& image = c.lowered->image;
  for (const rt::CrossingObject& object : distribution.crossing) {
    const auto node = [&](std::uint32_t atom) { return distribution.placement.nodes[distribution.home(atom)]; };
    const std::string path = image.atoms[object.atom].path(), other = image.atoms[object.other].path();
    const rt::Connector connector = image.connectors[linked.tables.connector_of(object.meeting)];
    c.diags
        .report(Diag::kB5072, range_of(c, connector.loc),
                linked.tables.atom_type(object.atom).variables[object.variable].name, path, node(object.atom), other,
                node(object.other))
        .note(fmt::format("what C++ keeps in an object cannot be sent over {}", connector_text(image, connector)))
        .help(fmt::format("put `{}` and `{}` on one node", path, other));
  }
  return distribution.crossing.empty();
}

// The first connectors of interactions, in the order of the model.
std::string connectors_text(const rt::Tables& tables, const std::vector<rt::InteractionId>& interactions) {
  std::vector<std::uint32_t> rows;
  for (const rt::InteractionId interaction : interactions) rows.push_back(tables.connector_of(interaction));
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  std::string text;
  for (std::size_t i = 0; i < std::min(rows.size(), kMostConnectors); ++i) {
    text += (i == 0 ? "" : ", ") + connector_text(*tables.image, tables.image->connectors[rows[i]]);
  }
  if (rows.size() > kMostConnectors) text += fmt::format(" and {} more connectors", rows.size() - kMostConnectors);
  return text;
}

std::string reason_text(const rt::Tables& tables, const rt::JoinReason& reason) {
  const rt::Image& image = *tables.image;
  switch (reason.kind) {
    case rt::JoinReason::Kind::Connector: {
      const rt::Connector row = image.connectors[tables.connector_of(rt::InteractionId(reason.row))];
      return fmt::format("{} is no plain rendezvous, and waits for whatever moves its components: {} interactions",
                         connector_text(image, row), reason.joined.size());
    }
    case rt::JoinReason::Kind::Rule: {
      const rt::Priority& row = image.priorities[reason.row];
      return fmt::format("priority `{}`{} looks at what moves the components of its high side: {} interactions",
                         row.name, place_text(image, row.loc), reason.joined.size());
    }
    case rt::JoinReason::Kind::Place: break;
  }
  const std::string place = reason.place == rt::kNone
                                ? std::string()
                                : fmt::format(" at {}", tables.atom_type(reason.row).places[reason.place]);
  return fmt::format("`{}`{} offers ports of {} interactions, of {}", image.atoms[reason.row].path(), place,
                     reason.joined.size(), connectors_text(tables, reason.joined));
}

// Of a rendezvous; of others if all take part. Of split sets: if no attempt is refused.
std::size_t most_messages(const rt::Distribution& distribution, rt::InteractionId interaction,
                          const std::vector<std::uint32_t>& atoms, std::vector<std::uint32_t>& nodes) {
  const std::uint32_t coordinator = distribution.coordinator_of[interaction];
  const rt::Span<std::uint32_t> locks = distribution.locks[interaction];
  const auto keep_unique = [&nodes] {
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    return nodes.size() - 1;
  };
  // One LOCK to each home of what is locked; the last one of them begins.
  nodes.assign(1, coordinator);
  for (const std::uint32_t atom : locks) nodes.push_back(distribution.home(atom));
  std::size_t messages = keep_unique();
  const std::uint32_t begins = nodes.back();
  nodes.assign({coordinator, begins});
  for (const std::uint32_t atom : atoms) {
    nodes.push_back(distribution.home(atom));
    const bool is_locked = std::find(locks.begin(), locks.end(), atom) != locks.end();
    if (!is_locked && distribution.home(atom) != coordinator) ++messages;
  }
  return messages + keep_unique();
}

// Of each split set: who coordinates how much, and what is locked.
std::string split_text(const rt::Distribution& distribution) {
  const rt::ConflictSets& sets = distribution.sets;
  std::string text;
  for (std::uint32_t set = 0; set < sets.count; ++set) {
    if (distribution.is_split[set] == 0) continue;
    std::vector<std::size_t> coordinates(distribution.placement.nodes.size(), 0);
    std::vector<std::uint32_t> locked;
    for (const rt::InteractionId interaction : sets.interactions[set]) {
      ++coordinates[distribution.coordinator_of[interaction]];
      locked.insert(locked.end(), distribution.locks[interaction].begin(), distribution.locks[interaction].end());
    }
    std::sort(locked.begin(), locked.end());
    locked.erase(std::unique(locked.begin(), locked.end()), locked.end());
    text += fmt::format("a set of {} interactions is split:", sets.interactions[set].size);
    const char* before = " ";
    for (std::size_t node = 0; node < coordinates.size(); ++node) {
      if (coordinates[node] == 0) continue;
      text += fmt::format("{}{} coordinates {}", before, distribution.placement.nodes[node], coordinates[node]);
      before = ", ";
    }
    text += fmt::format("; locks at {} of {} components\n", locked.size(), sets.atoms[set].size);
  }
  return text;
}

std::string_view whole_text(rt::WholeSet why) {
  switch (why) {
    case rt::WholeSet::Time: return "nodes do not split sets of models with time";
    case rt::WholeSet::OneNode: return "all of its components are at home on one node";
    case rt::WholeSet::Fault: return "a guard, an `up` or a priority may end in a run-time error between two steps";
    case rt::WholeSet::Objects: return "its components show C++ objects, which cannot be sent";
    case rt::WholeSet::NothingShared: return "no component would be offered to several coordinators";
  }
  BIP_UNREACHABLE("why a set is whole");
}

// Why sets that are larger than `split_above` have one coordinator nevertheless: of each reason the largest one.
std::string whole_sets_text(const Linked& linked, const rt::Distribution& distribution, std::uint32_t split_above) {
  struct Sets {
    std::size_t count = 0, largest = 0;
  };
  std::map<rt::WholeSet, Sets> found;
  for (const auto& [set, why] : rt::find_whole_sets(linked.tables, linked.rules, distribution, split_above)) {
    Sets& sets = found[why];
    ++sets.count;
    sets.largest = std::max<std::size_t>(sets.largest, distribution.sets.interactions[set].size);
  }
  std::string text;
  for (const auto& [why, sets] : found) {
    text += fmt::format("a set of {} interactions is not split: {}", sets.largest, whole_text(why));
    text += sets.count == 1 ? "\n" : fmt::format(" ({} more)\n", sets.count - 1);
  }
  return text;
}

}  // namespace

bool prepare_distributed(Compilation& c, const RunArguments& arguments, rt::Placement& placement) {
  if (!rt::has_nodes(arguments.run.engine) && arguments.placement_path.empty()) return true;
  if (!is_distributable(c)) return false;
  const Linked linked(c.lowered->image,
                      arguments.run.maximal_progress ? rt::MaximalProgress::On : rt::MaximalProgress::Off);
  if (arguments.placement_path.empty()) placement = rt::place_atoms(linked.tables, linked.rules, arguments.run.nodes);
  else if (!read_placement(c, arguments.placement_path, placement)) return false;
  if (arguments.split_above != 0) placement.split_above = arguments.split_above;
  if (const Result<rt::NetworkFaults> faults = rt::read_faults(arguments.run.network_faults, placement.nodes);
      !faults) {
    c.diags.report(Diag::kB5070, {}, faults.error());
    return false;
  }
  placement.next_moves = prove_next_moves(c).moves;
  return crosses_nothing(c, linked, rt::distribute(linked.tables, linked.rules, placement));
}

bool prepare_deployed(Compilation& c, const std::string& placement_path, const std::string& moves_path,
                      rt::Placement& placement) {
  if (!is_distributable(c) || !read_placement(c, placement_path, placement)) return false;
  if (moves_path.empty()) {
    placement.next_moves = prove_next_moves(c).moves;
  } else {
    const std::optional<std::string> text = read_file(moves_path);
    Result<std::vector<rt::NextMove>> moves = Failure{"it cannot be read"};
    if (text) moves = read_next_moves(c.lowered->image, *text);
    if (!moves) {
      c.diags.report(Diag::kB6120, {}, moves_path, moves.error()).help("deploy again, and copy all folders");
      return false;
    }
    placement.next_moves = std::move(*moves);
  }
  const Linked linked(c.lowered->image);
  return crosses_nothing(c, linked, rt::distribute(linked.tables, linked.rules, placement));
}

std::string distribution_text(Compilation& c, const std::string& placement_path) {
  rt::Placement placement;
  if (!is_distributable(c) || !read_placement(c, placement_path, placement)) return {};
  const Linked linked(c.lowered->image);
  const verify::NextMoves known = prove_next_moves(c);
  placement.next_moves = known.moves;
  const rt::Distribution distribution = rt::distribute(linked.tables, linked.rules, placement);
  if (!crosses_nothing(c, linked, distribution)) return {};
  const rt::ConflictSets& sets = distribution.sets;
  const std::size_t interactions = sets.of_interaction.size();

  std::vector<std::size_t> components(placement.nodes.size(), 0), coordinates(placement.nodes.size(), 0);
  for (const std::uint32_t home : placement.home) ++components[home];
  for (const std::uint32_t node : distribution.coordinator_of) ++coordinates[node];
  std::string text;
  for (std::size_t node = 0; node < placement.nodes.size(); ++node)
    text += fmt::format("node {}: {} components at home, coordinates {} of {} interactions\n", placement.nodes[node],
                        components[node], coordinates[node], interactions);

  std::uint32_t largest = 0;
  for (std::uint32_t set = 1; set < sets.count; ++set) {
    if (sets.interactions[set].size > sets.interactions[largest].size) largest = set;
  }
  if (sets.count != 0) {
    const std::uint32_t size = sets.interactions[largest].size;
    text += fmt::format(
        "{} conflict sets; the largest has {} interactions ({} %), {}\n", sets.count, size, size * 100 / interactions,
        distribution.is_split[largest] != 0 ? std::string("split")
                                            : "coordinated by " + placement.nodes[distribution.coordinator[largest]]);
    if (size > 1)
      text += "  " + reason_text(linked.tables, rt::why_joined(linked.tables, linked.rules, sets, largest)) + '\n';
  }

  const std::string split = split_text(distribution);
  text += split;
  text += whole_sets_text(linked, distribution, placement.split_above);
  text += removed_conflicts_text(linked.tables, known);
  std::string rows;
  std::size_t border = 0, sum = 0;
  std::vector<std::uint32_t> atoms, nodes;
  for (const rt::InteractionId interaction : linked.tables.interactions.ids()) {
    rt::atoms_of_interaction(linked.tables, linked.tables.interactions[interaction], atoms);
    atoms.erase(std::unique(atoms.begin(), atoms.end()), atoms.end());
    const std::size_t messages = most_messages(distribution, interaction, atoms, nodes);
    if (nodes.size() < 2) continue;
    sum += messages;
    if (++border > kMostListed) continue;
    rows += fmt::format("  {}: {} messages between", interaction_name(linked.tables, interaction), messages);
    for (std::size_t i = 0; i < nodes.size(); ++i) rows += (i == 0 ? " " : ", ") + placement.nodes[nodes[i]];
    rows += '\n';
  }
  text += fmt::format("{} of {} interactions are of several nodes", border, interactions);
  text += border == 0 ? "\n"
                      : fmt::format(", at most {:.2f} messages each{}\n", double(sum) / double(border),
                                    split.empty() ? "" : ", and three for each refusal of a lock");
  if (!placement.counts.empty())
    text += fmt::format("{:.1f} % of the counted steps are of several nodes\n",
                        100 * rt::border_part(linked.tables, placement.counts, placement));
  if (border > kMostListed) rows += fmt::format("  and {} more\n", border - kMostListed);
  return text + rows;
}

}  // namespace bip::driver
