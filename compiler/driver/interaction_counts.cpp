// See interaction_counts.hpp.
#include "compiler/driver/interaction_counts.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"
#include "runtime/core/profile.hpp"
#include "runtime/engine/replay_record.hpp"
#include "runtime/trace/recorded.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {

namespace {

constexpr std::uint64_t kMostCount = std::uint64_t{1} << 40;
// A step of a declaration with many interactions is a part of a step for each.
constexpr std::uint64_t kShares = 1000;

Result<std::vector<std::uint64_t>> counts_of_trace(const rt::Tables& tables, const std::string& bytes) {
  if (const std::string problem = rt::recorded_problem(*tables.image, bytes); !problem.empty()) return Failure{problem};
  std::vector<std::uint64_t> counts(tables.interactions.size(), 0);
  rt::RecordedReader reader;
  rt::RecordedBegin begin;
  (void)reader.open(bytes, begin);
  rt::EnabledSet::Position at{};
  rt::RecordedEnd end;
  while (reader.next(at, end) == rt::RecordedReader::Next::Step) {
    if (!tables.interactions.contains(at.interaction)) return Failure{"it has steps that the model has not"};
    ++counts[at.interaction.value];
  }
  return counts;
}

Result<std::vector<std::uint64_t>> counts_of_profile(const rt::Tables& tables, const std::string& bytes) {
  const nlohmann::ordered_json json = parse_json(bytes);
  const bool is_profile = json.is_object() && json.value("format", nlohmann::ordered_json()) == "bipc-profile" &&
                          json.contains("interactions") && json["interactions"].is_array();
  if (!is_profile) return Failure{"it is neither a profile (`--profile-json`) nor a binary trace"};
  if (json.value("model", nlohmann::ordered_json()) != tables.image->name)
    return Failure{fmt::format("it is not of {}", tables.image->name)};
  std::map<std::string, std::uint64_t> steps, instances;
  for (const nlohmann::ordered_json& row : json["interactions"]) {
    if (!row.is_object() || !row.contains("name") || !row["name"].is_string() || !row.contains("steps") ||
        !row["steps"].is_number_unsigned())
      return Failure{"a row of its interactions is none"};
    steps[row["name"].get<std::string>()] += std::min(row["steps"].get<std::uint64_t>(), kMostCount);
  }
  // The declarations, by the names that a profile gives them.
  std::vector<rt::Code> no_code;
  rt::Profile profile(no_code);
  profile.start(tables);
  for (const rt::InteractionProfile& row : profile.interactions()) instances[row.name] += row.instances;
  std::vector<std::uint64_t> counts;
  for (const rt::InteractionId interaction : tables.interactions.ids()) {
    const std::string& name = profile.interactions()[profile.row_of(interaction)].name;
    BIP_ASSERT(instances[name] > 0, "`{}` has no instances", name);
    const auto found = steps.find(name);
    counts.push_back(found == steps.end() ? 0 : found->second * kShares / instances[name]);
  }
  return counts;
}

}  // namespace

std::string interaction_name(const rt::Tables& tables, rt::InteractionId interaction) {
  BIP_ASSERT(tables.interactions.contains(interaction), "interaction {} of {}", interaction,
             tables.interactions.size());
  const rt::Image& image = *tables.image;
  if (tables.is_of_connector(interaction)) return image.connectors[tables.connector_of(interaction)].path();
  const std::uint32_t port = tables.interactions[interaction].row;
  const std::uint32_t atom = tables.port_atom[port];
  return image.atoms[atom].path() + '.' + tables.atom_type(atom).ports[port - tables.port_base(atom)].name;
}

Result<std::vector<std::uint64_t>> read_counts(const rt::Tables& tables, const std::string& bytes) {
  return bytes.starts_with("BIPTRC") ? counts_of_trace(tables, bytes) : counts_of_profile(tables, bytes);
}

}  // namespace bip::driver
