// See run_statistics.hpp.
#include "compiler/traces/run_statistics.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "runtime/core/final_state.hpp"
#include "runtime/core/text.hpp"

namespace bip::traces {

using Json = nlohmann::ordered_json;

void RunStatistics::begin(const rt::Core& core) {
  is_timed_ = core.is_timed();
  for (rt::u32 atom = 0; atom < core.image().atoms.size; ++atom) {
    const std::string path = core.image().atoms[atom].path();
    if (!selection_.takes_component(path)) continue;
    Component& component = components_[atom];
    component.path = path;
    component.place = rt::places_of(core, atom);
    component.places[component.place].entered = 1;
  }
}

void RunStatistics::step(const rt::Core& core, const TracedStep& step) {
  BIP_ASSERT(step.parts != nullptr && step.instant >= now_, "step {} is at {}, after {}", step.number, step.instant,
             now_);
  ++steps_;
  now_ = step.instant;
  // Who moved is among the parts.
  for (const rt::MovePart& part : *step.parts) {
    const auto found = components_.find(part.atom);
    if (found == components_.end()) continue;
    Component& component = found->second;
    std::string place = rt::places_of(core, part.atom);
    if (place == component.place) continue;
    Place& left = component.places[component.place];
    left.steps += steps_ - component.since_step;
    left.ns += step.instant - component.since;
    component.place = std::move(place);
    component.since = step.instant;
    component.since_step = steps_;
    ++component.places[component.place].entered;
  }
  if (!selection_.takes(core.image(), step)) return;
  if (wanted_++ == 0) from_ = step.instant;
  to_ = step.instant;
  Count& count = interactions_[step.interaction];
  if (count.steps++ == 0) count.first = step.number;
  count.last = step.number;
  for (const rt::MovePart& part : *step.parts)
    if (const auto found = components_.find(part.atom); found != components_.end()) ++found->second.steps;
}

Json RunStatistics::json() const {
  BIP_ASSERT(wanted_ <= steps_, "{} of {} steps are wanted", wanted_, steps_);
  Json out{{"steps", steps_}, {"wanted", wanted_}};
  if (is_timed_) out.update({{"from", from_}, {"to", to_}});
  std::vector<const std::pair<const std::string, Count>*> rows;
  for (const auto& row : interactions_) rows.push_back(&row);
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto* a, const auto* b) { return a->second.steps > b->second.steps; });
  out["interactions"] = Json::array();
  for (const auto* row : rows)
    out["interactions"].push_back({{"interaction", row->first},
                                   {"steps", row->second.steps},
                                   {"first", row->second.first},
                                   {"last", row->second.last}});
  std::vector<const Component*> components;
  for (const auto& [atom, component] : components_) components.push_back(&component);
  std::stable_sort(components.begin(), components.end(),
                   [](const Component* a, const Component* b) { return a->steps > b->steps; });
  out["components"] = Json::array();
  for (const Component* component : components) {
    Json places = Json::array();
    for (const auto& [name, place] : component->places) {
      const bool is_here = name == component->place;
      Json row{{"place", name},
               {"entered", place.entered},
               {"steps", place.steps + (is_here ? steps_ - component->since_step : 0)}};
      if (is_timed_) row["ns"] = place.ns + (is_here ? now_ - component->since : 0);
      places.push_back(std::move(row));
    }
    out["components"].push_back(
        {{"component", component->path}, {"steps", component->steps}, {"places", std::move(places)}});
  }
  return out;
}

std::string RunStatistics::text() const {
  constexpr std::size_t kMostRows = 50;
  const Json all = json();
  const auto name = [](const Json& path) { return rt::relative(path.get_ref<const std::string&>().c_str()); };
  std::string out = fmt::format("{} of {} steps", wanted_, steps_);
  if (is_timed_) {
    out += ", from ";
    rt::append_time(out, from_);
    out += " to ";
    rt::append_time(out, to_);
  }
  out += "\n\n     steps  interaction\n";
  std::size_t shown = 0;
  for (const Json& row : all["interactions"]) {
    if (++shown > kMostRows) continue;
    out += fmt::format("{:>10}  {}  (#{} to #{})\n", row["steps"].get<std::uint64_t>(), name(row["interaction"]),
                       row["first"].get<std::uint64_t>(), row["last"].get<std::uint64_t>());
  }
  if (shown > kMostRows) out += fmt::format("            and {} more: --json has all\n", shown - kMostRows);
  out += "\n     steps  component\n";
  shown = 0;
  for (const Json& row : all["components"]) {
    if (++shown > kMostRows) continue;
    out += fmt::format("{:>10}  {}:", row["steps"].get<std::uint64_t>(), name(row["component"]));
    for (const Json& place : row["places"]) {
      out +=
          fmt::format(" {} {}×", place["place"].get_ref<const std::string&>(), place["entered"].get<std::uint64_t>());
      if (is_timed_) {
        out += ' ';
        rt::append_time(out, place["ns"].get<rt::i64>());
      }
    }
    out += '\n';
  }
  if (shown > kMostRows) out += fmt::format("            and {} more: --json has all\n", shown - kMostRows);
  return out;
}

}  // namespace bip::traces
