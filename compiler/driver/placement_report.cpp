// See placement_report.hpp.
#include "compiler/driver/placement_report.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bip/assert.hpp"
#include "compiler/base/json_text.hpp"
#include "compiler/driver/distributed_runs.hpp"
#include "compiler/driver/interaction_counts.hpp"
#include "runtime/core/fire/partial.hpp"
#include "runtime/distributed/split_sets.hpp"

namespace bip::driver {

namespace {

using PlacementJson = nlohmann::ordered_json;

constexpr std::size_t kMostConnectors = 3;  // of a reason, in the text

TextPlace text_place(const rt::Image& image, const rt::SourceLine& loc) {
  BIP_ASSERT(loc.line == 0 || loc.file < image.files.size, "line {} of file {} of {}", loc.line, loc.file,
             image.files.size);
  if (loc.line == 0) return {};
  return {image.files[loc.file], loc.line, loc.column};
}

ReportedConnector reported(const rt::Image& image, std::uint32_t connector) {
  const rt::Connector row = image.connectors[connector];
  return {row.path(), text_place(image, row.loc)};
}

SetReason reported(const rt::Tables& tables, const rt::JoinReason& reason) {
  const rt::Image& image = *tables.image;
  SetReason to;
  to.interactions = reason.joined.size();
  switch (reason.kind) {
    case rt::JoinReason::Kind::Connector: {
      ReportedConnector connector = reported(image, tables.connector_of(rt::InteractionId(reason.row)));
      to.kind = SetReason::Kind::Connector;
      to.name = std::move(connector.path);
      to.place = std::move(connector.place);
      return to;
    }
    case rt::JoinReason::Kind::Rule:
      to.kind = SetReason::Kind::Rule;
      to.name = image.priorities[reason.row].name;
      to.place = text_place(image, image.priorities[reason.row].loc);
      return to;
    case rt::JoinReason::Kind::Place: break;
  }
  to.name = image.atoms[reason.row].path();
  if (reason.place != rt::kNone) to.at = tables.atom_type(reason.row).places[reason.place];
  std::vector<std::uint32_t> rows;
  for (const rt::InteractionId interaction : reason.joined) rows.push_back(tables.connector_of(interaction));
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  for (const std::uint32_t row : rows) to.connectors.push_back(reported(image, row));
  return to;
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
std::vector<WholeSets> find_whole(const LinkedModel& linked, const rt::Distribution& distribution,
                                  std::uint32_t split_above) {
  std::map<rt::WholeSet, WholeSets> found;
  for (const auto& [set, why] : rt::find_whole_sets(linked.tables, linked.rules, distribution, split_above)) {
    WholeSets& sets = found[why];
    sets.why = whole_text(why);
    ++sets.count;
    BIP_ASSERT(set < distribution.sets.count && distribution.sets.interactions[set].size > split_above,
               "set {} has one coordinator as it is not larger than {}", set, split_above);
    sets.largest = std::max<std::size_t>(sets.largest, distribution.sets.interactions[set].size);
  }
  std::vector<WholeSets> rows;
  for (auto& [why, sets] : found) rows.push_back(std::move(sets));
  return rows;
}

ReportedSet reported(const rt::Distribution& distribution, std::uint32_t set) {
  BIP_ASSERT(set < distribution.sets.count && distribution.is_split.size() == distribution.sets.count,
             "set {} of {}, of which {} may be split", set, distribution.sets.count, distribution.is_split.size());
  const rt::ConflictSets& sets = distribution.sets;
  const std::vector<std::string>& names = distribution.placement.nodes;
  ReportedSet to;
  to.interactions = sets.interactions[set].size;
  to.components = sets.atoms[set].size;
  if (distribution.is_split[set] == 0) {
    to.coordinator = names[distribution.coordinator[set]];
    return to;
  }
  std::vector<std::size_t> coordinates(names.size(), 0);
  std::vector<std::uint32_t> locked;
  for (const rt::InteractionId interaction : sets.interactions[set]) {
    ++coordinates[distribution.coordinator_of[interaction]];
    locked.insert(locked.end(), distribution.locks[interaction].begin(), distribution.locks[interaction].end());
  }
  std::sort(locked.begin(), locked.end());
  to.locked = static_cast<std::size_t>(std::unique(locked.begin(), locked.end()) - locked.begin());
  BIP_ASSERT(to.locked <= to.components, "{} of {} components are locked", to.locked, to.components);
  for (std::size_t node = 0; node < names.size(); ++node) {
    if (coordinates[node] != 0) to.coordinates.emplace_back(names[node], coordinates[node]);
  }
  return to;
}

void add_sets(PlacementReport& report, const LinkedModel& linked, const rt::Distribution& distribution,
              std::size_t most_reasons) {
  const rt::ConflictSets& sets = distribution.sets;
  std::vector<std::uint32_t> order(sets.count);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return sets.interactions[a].size > sets.interactions[b].size;
  });
  report.set_count = sets.count;
  for (const std::uint32_t set : order) {
    const bool is_single = sets.interactions[set].size < 2;
    if (is_single && !report.sets.empty()) break;
    ReportedSet& to = report.sets.emplace_back(reported(distribution, set));
    if (!is_single && report.sets.size() <= most_reasons)
      to.reason = reported(linked.tables, rt::why_joined(linked.tables, linked.rules, sets, set));
  }
}

void add_border(PlacementReport& report, const LinkedModel& linked, const rt::Distribution& distribution,
                std::size_t most_listed) {
  const rt::Placement& placement = distribution.placement;
  const std::vector<std::uint64_t>& counts = placement.counts;
  BIP_ASSERT(counts.empty() || counts.size() == linked.tables.interactions.size(), "{} counts of {} interactions",
             counts.size(), linked.tables.interactions.size());
  double taken = 0, taken_between = 0, sent = 0;
  std::vector<std::uint32_t> atoms, nodes;
  for (const rt::InteractionId interaction : linked.tables.interactions.ids()) {
    const double count = counts.empty() ? 0 : static_cast<double>(counts[interaction.value]);
    taken += count;
    rt::atoms_of_interaction(linked.tables, linked.tables.interactions[interaction], atoms);
    atoms.erase(std::unique(atoms.begin(), atoms.end()), atoms.end());
    const std::size_t messages = most_messages(distribution, interaction, atoms, nodes);
    if (nodes.size() < 2) continue;
    taken_between += count;
    sent += count * static_cast<double>(messages);
    report.border_messages += messages;
    if (++report.border_count > most_listed) continue;
    BorderInteraction& to = report.border.emplace_back();
    to.name = interaction_name(linked.tables, interaction);
    to.place = reported(*linked.tables.image, linked.tables.connector_of(interaction)).place;
    to.messages = messages;
    for (const std::uint32_t node : nodes) to.nodes.push_back(placement.nodes[node]);
    if (!counts.empty()) to.count = counts[interaction.value];
  }
  BIP_ASSERT(taken_between <= taken && report.border_count <= linked.tables.interactions.size(),
             "{} of {} steps are of several nodes", taken_between, taken);
  if (taken > 0) report.counted = {taken_between / taken, sent / taken};
}

std::string set_text(const ReportedSet& set, std::size_t interactions) {
  BIP_ASSERT(set.interactions >= 1 && set.interactions <= interactions, "a set of {} of {} interactions",
             set.interactions, interactions);
  std::string text = fmt::format("the largest has {} interactions ({} %), {}\n", set.interactions,
                                 set.interactions * 100 / interactions,
                                 set.coordinator.empty() ? "split" : "coordinated by " + set.coordinator);
  if (!set.reason) return text;
  const auto place = [](const TextPlace& at) {
    return at.line == 0 ? std::string() : fmt::format(" ({}:{}:{})", at.file, at.line, at.column);
  };
  const SetReason& reason = *set.reason;
  switch (reason.kind) {
    case SetReason::Kind::Connector:
      return text + fmt::format(
                        "  `{}`{} is no plain rendezvous, and waits for whatever moves its components: {} "
                        "interactions\n",
                        reason.name, place(reason.place), reason.interactions);
    case SetReason::Kind::Rule:
      return text +
             fmt::format("  priority `{}`{} looks at what moves the components of its high side: {} interactions\n",
                         reason.name, place(reason.place), reason.interactions);
    case SetReason::Kind::Component: break;
  }
  text += fmt::format("  `{}`{} offers ports of {} interactions, of ", reason.name,
                      reason.at.empty() ? reason.at : " at " + reason.at, reason.interactions);
  const std::vector<ReportedConnector>& all = reason.connectors;
  for (std::size_t i = 0; i < std::min(all.size(), kMostConnectors); ++i)
    text += fmt::format("{}`{}`{}", i == 0 ? "" : ", ", all[i].path, place(all[i].place));
  if (all.size() > kMostConnectors) text += fmt::format(" and {} more connectors", all.size() - kMostConnectors);
  return text + '\n';
}

PlacementJson json_of(const TextPlace& place) {
  if (place.line == 0) return nullptr;
  return {{"file", place.file}, {"line", place.line}, {"column", place.column}};
}

PlacementJson json_of(const SetReason& reason) {
  constexpr const char* kKinds[] = {"component", "connector", "priority"};
  PlacementJson json{{"kind", kKinds[static_cast<std::size_t>(reason.kind)]}, {"name", reason.name}};
  if (reason.kind != SetReason::Kind::Component) json["place"] = json_of(reason.place);
  else json["at"] = reason.at.empty() ? PlacementJson(nullptr) : PlacementJson(reason.at);
  json["interactions"] = reason.interactions;
  if (reason.kind != SetReason::Kind::Component) return json;
  json["connectors"] = PlacementJson::array();
  for (const ReportedConnector& connector : reason.connectors)
    json["connectors"].push_back({{"name", connector.path}, {"place", json_of(connector.place)}});
  return json;
}

PlacementJson json_of(const ReportedSet& set) {
  PlacementJson json{{"interactions", set.interactions}, {"components", set.components}};
  if (set.coordinator.empty()) {
    json["coordinates"] = PlacementJson::object();
    for (const auto& [node, count] : set.coordinates) json["coordinates"][node] = count;
    json["locked"] = set.locked;
  } else {
    json["coordinator"] = set.coordinator;
  }
  if (set.reason) json["reason"] = json_of(*set.reason);
  return json;
}

PlacementJson json_of(const RemovedConflicts& removed) {
  constexpr const char* kQuestions[] = {"answered", "too-large", "out-of-time"};
  PlacementJson json{{"question", kQuestions[static_cast<std::size_t>(removed.question)]},
                     {"by_modes", removed.by_modes},
                     {"by_invariants", removed.by_invariants},
                     {"places", PlacementJson::array()}};
  for (const RemovedConflicts::At& at : removed.places)
    json["places"].push_back({{"component", at.component},
                              {"at", at.place},
                              {"by_places", at.by_places},
                              {"left", at.left},
                              {"by", at.by_invariants ? "invariants" : "modes"}});
  return json;
}

void add_report(PlacementJson& json, const PlacementReport& report) {
  json["nodes"] = PlacementJson::array();
  for (const PlacementReport::Node& node : report.nodes) {
    PlacementJson row{{"name", node.name}};
    if (!node.address.empty()) row["address"] = node.address;
    row["components"] = node.components;
    row["coordinates"] = node.coordinates;
    json["nodes"].push_back(std::move(row));
  }
  json["interactions"] = report.interactions;
  json["conflict_sets"] = report.set_count;
  json["sets"] = PlacementJson::array();
  for (const ReportedSet& set : report.sets) json["sets"].push_back(json_of(set));
  json["whole_sets"] = PlacementJson::array();
  for (const WholeSets& sets : report.whole_sets)
    json["whole_sets"].push_back({{"why", sets.why}, {"count", sets.count}, {"largest", sets.largest}});
  json["removed_conflicts"] = json_of(report.removed);
  json["border"] = {
      {"interactions", report.border_count},
      {"messages_each", report.border_count == 0 ? 0.0 : double(report.border_messages) / double(report.border_count)}};
  if (report.counted) {
    json["border"]["part_of_steps"] = report.counted->border_part;
    json["border"]["messages_per_step"] = report.counted->messages_per_step;
  }
  json["border_interactions"] = PlacementJson::array();
  for (const BorderInteraction& border : report.border) {
    PlacementJson row{{"name", border.name},
                      {"place", json_of(border.place)},
                      {"messages", border.messages},
                      {"nodes", border.nodes}};
    if (border.count) row["count"] = *border.count;
    json["border_interactions"].push_back(std::move(row));
  }
}

}  // namespace

std::optional<PlacementReport> report_placement(Compilation& c, const std::string& placement_path,
                                                PlacementReport::Limits limits) {
  rt::Placement placement;
  if (!is_distributable(c) || !read_placement(c, placement_path, placement)) return std::nullopt;
  const LinkedModel linked(c.lowered->image);
  const verify::NextMoves known = prove_next_moves(c);
  placement.next_moves = known.moves;
  const std::uint32_t split_above = placement.split_above;
  const rt::Distribution distribution = rt::distribute(linked.tables, linked.rules, std::move(placement));
  if (!crosses_nothing(c, linked, distribution)) return std::nullopt;

  PlacementReport report;
  const std::vector<std::string>& names = distribution.placement.nodes;
  for (std::size_t node = 0; node < names.size(); ++node)
    report.nodes.push_back({names[node], distribution.placement.addresses[node], 0, 0});
  BIP_ASSERT(distribution.placement.home.size() == linked.tables.image->atoms.size &&
                 distribution.coordinator_of.size() == linked.tables.interactions.size(),
             "{} components are at home, {} interactions have a coordinator", distribution.placement.home.size(),
             distribution.coordinator_of.size());
  for (const std::uint32_t home : distribution.placement.home) ++report.nodes[home].components;
  for (const std::uint32_t node : distribution.coordinator_of) ++report.nodes[node].coordinates;
  report.interactions = distribution.coordinator_of.size();
  add_sets(report, linked, distribution, limits.reasons);
  report.whole_sets = find_whole(linked, distribution, split_above);
  report.removed = removed_conflicts(linked.tables, known);
  add_border(report, linked, distribution, limits.border);
  return report;
}

std::string placement_text(const PlacementReport& report) {
  std::string text;
  for (const PlacementReport::Node& node : report.nodes)
    text += fmt::format("node {}: {} components at home, coordinates {} of {} interactions\n", node.name,
                        node.components, node.coordinates, report.interactions);
  if (!report.sets.empty())
    text += fmt::format("{} conflict sets; {}", report.set_count, set_text(report.sets.front(), report.interactions));
  bool has_locks = false;
  for (const ReportedSet& set : report.sets) {
    if (!set.coordinator.empty()) continue;
    has_locks = true;
    text += fmt::format("a set of {} interactions is split:", set.interactions);
    const char* before = " ";
    for (const auto& [node, count] : set.coordinates) {
      text += fmt::format("{}{} coordinates {}", before, node, count);
      before = ", ";
    }
    text += fmt::format("; locks at {} of {} components\n", set.locked, set.components);
  }
  for (const WholeSets& sets : report.whole_sets) {
    text += fmt::format("a set of {} interactions is not split: {}", sets.largest, sets.why);
    text += sets.count == 1 ? "\n" : fmt::format(" ({} more)\n", sets.count - 1);
  }
  text += removed_conflicts_text(report.removed);
  text += fmt::format("{} of {} interactions are of several nodes", report.border_count, report.interactions);
  text += report.border_count == 0 ? "\n"
                                   : fmt::format(", at most {:.2f} messages each{}\n",
                                                 double(report.border_messages) / double(report.border_count),
                                                 has_locks ? ", and three for each refusal of a lock" : "");
  if (report.counted)
    text += fmt::format("{:.1f} % of the counted steps are of several nodes: at most {:.2f} messages a step\n",
                        100 * report.counted->border_part, report.counted->messages_per_step);
  for (const BorderInteraction& border : report.border) {
    text += fmt::format("  {}: {} messages between {}\n", border.name, border.messages, fmt::join(border.nodes, ", "));
  }
  if (report.border_count > report.border.size())
    text += fmt::format("  and {} more\n", report.border_count - report.border.size());
  return text;
}

std::string placement_json(const Compilation& c, const std::string& file, const std::string& placement_path,
                           const PlacementReport* report) {
  PlacementJson json{{"format", "bipc-placement"},
                     {"version", 1},
                     {"model", file},
                     {"placement", placement_path},
                     {"refused", PlacementJson::array()}};
  const std::string lines = render(c.diags, c.sources, {DiagnosticFormat::Json});
  for (std::size_t begin = 0; begin < lines.size();) {
    const std::size_t end = lines.find('\n', begin);
    BIP_ASSERT(end != std::string::npos, "the last line of {} bytes has no end", lines.size());
    PlacementJson diagnostic = parse_json(lines.substr(begin, end - begin));
    if (diagnostic["severity"] == "error") json["refused"].push_back(std::move(diagnostic));
    begin = end + 1;
  }
  if (report != nullptr) add_report(json, *report);
  return json_line(json) + '\n';
}

}  // namespace bip::driver
