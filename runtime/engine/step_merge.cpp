// See step_merge.hpp.
#include "runtime/engine/step_merge.hpp"

#include <algorithm>
#include <utility>

#include "bip/assert.hpp"
#include "runtime/distributed/fired_interactions.hpp"
#include "runtime/engine/node_process.hpp"

namespace bip::rt {

void StepMerge::add(Flight& flight, u32 node, int parts) {
  for (auto& [at, open] : flight.open) {
    if (at == node) {
      open += parts;
      return;
    }
  }
  flight.open.emplace_back(node, parts);
}

// A number stands before a character of its text, or behind the last one.
bool StepMerge::is_step(const Step& step) const {
  return step.interaction.value < core_.tables().interactions.size() && step.out_number <= step.out_size + 1 &&
         step.trace_number <= step.trace_size + 1;
}

void StepMerge::add_waiting(const Flight& flight) {
  waiting_bytes_ += flight.bytes();
  most_waiting_bytes_ = std::max(most_waiting_bytes_, waiting_bytes_);
}

// Of several steps that share a number.
bool StepMerge::is_new(u32 node, u64 number) const {
  return node_of_step(number) == node && number > bounds_[node] && !flights_.contains(number);
}

bool StepMerge::take_begun(u32 node, const Control& control) {
  constexpr std::size_t kHead = 4;
  const std::vector<u64>& numbers = control.numbers;
  if (numbers.size() < kHead || control.texts.size() != 2) return false;
  const u64 number = numbers[0];
  if (node_of_step(number) != node || number <= bounds_[node] || numbers[1] >= core_.tables().interactions.size())
    return false;
  Step step{InteractionId(numbers[1]), 0, numbers[2], numbers[3], control.texts[0].size(), control.texts[1].size()};
  if (follower_) {
    if (numbers[2] >= kNone || numbers[3] != 0 || step.out_size + step.trace_size != 0) return false;
    step.rank = static_cast<u32>(std::exchange(step.out_number, 0));
  }
  if (!is_step(step)) return false;
  if (std::any_of(numbers.begin() + kHead, numbers.end(), [this](u64 home) { return home >= bounds_.size(); }))
    return false;
  Flight& flight = flights_[number];
  flight.is_told = true;
  flight.steps.push_back(step);
  flight.text = {control.texts[0], control.texts[1]};
  add_waiting(flight);
  for (std::size_t i = kHead; i < numbers.size(); ++i) add(flight, static_cast<u32>(numbers[i]), 1);
  bounds_[node] = number;
  return true;
}

u64 StepMerge::take_many(u32 node, const Control& control) {
  constexpr std::size_t kEach = 5;
  const std::vector<u64>& numbers = control.numbers;
  if (follower_ || numbers.size() <= kEach || numbers.size() % kEach != 1 || control.texts.size() != 2) return 0;
  const u64 number = numbers[0];
  if (!is_new(node, number)) return 0;
  Flight flight{true, {}, {control.texts[0], control.texts[1]}, {}, {}};
  // Of the texts, what is left for those to come.
  u64 out = flight.text.out.size(), trace = flight.text.trace.size();
  for (std::size_t i = 1; i < numbers.size(); i += kEach) {
    if (numbers[i] >= core_.tables().interactions.size()) return 0;
    const Step step{InteractionId(numbers[i]), 0, numbers[i + 1], numbers[i + 2], numbers[i + 3], numbers[i + 4]};
    if (step.out_size > out || step.trace_size > trace || !is_step(step)) return 0;
    out -= step.out_size;
    trace -= step.trace_size;
    flight.steps.push_back(step);
  }
  if (out != 0 || trace != 0) return 0;
  add_waiting(flight);
  const u64 count = flight.steps.size();
  flights_.emplace(number, std::move(flight));
  bounds_[node] = number;
  return count;
}

u64 StepMerge::take_fired(u32 node, const Control& control) {
  const std::vector<u64>& numbers = control.numbers;
  if (!(output_.records_only() || follower_) || numbers.size() != 2 || control.texts.size() != 1) return 0;
  if (numbers[1] == 0 || !is_new(node, numbers[0])) return 0;
  Flight flight{.is_told = true, .steps = {}, .text = {}, .open = {}, .fired = {}};
  if (!unpack_fired(control.texts[0], numbers[1], core_.tables().interactions.size(), flight.fired)) return 0;
  add_waiting(flight);
  const u64 count = flight.fired.size();
  flights_.emplace(numbers[0], std::move(flight));
  bounds_[node] = numbers[0];
  return count;
}

void StepMerge::take_landed(u32 node, const std::vector<u64>& steps) {
  for (const u64 step : steps) add(flights_[step], node, -1);
}

bool StepMerge::has_ended(const Flight& flight) const {
  return flight.is_told && std::all_of(flight.open.begin(), flight.open.end(),
                                       [this](const auto& part) { return part.second == 0 || is_lost_[part.first]; });
}

void StepMerge::write_ready() {
  while (!flights_.empty()) {
    const auto& [step, flight] = *flights_.begin();
    if (!has_ended(flight)) return;
    for (u32 node = 0; node < bounds_.size(); ++node) {
      if (bounds_[node] < step && !is_lost_[node]) return;
    }
    write_first();
  }
}

void StepMerge::write_until(u64 step) {
  while (!flights_.empty() && flights_.begin()->first <= step) {
    // The node was lost before it reported the step.
    if (flights_.begin()->second.is_told) write_first();
    else flights_.erase(flights_.begin());
  }
}

void StepMerge::write_first() {
  const auto first = flights_.begin();
  const Flight& flight = first->second;
  const u64 bytes = flight.bytes();
  BIP_ASSERT(bytes <= waiting_bytes_ && first->first > last_written_, "step {} after {}", first->first, last_written_);
  waiting_bytes_ -= bytes;
  written_bytes_ += bytes;
  last_written_ = first->first;
  const std::string& node = distribution_.placement.nodes[node_of_step(first->first)];
  if (follower_) {
    for (const Step& step : flight.steps) write_followed({step.interaction, step.rank}, node);
    for (const InteractionId interaction : flight.fired) write_followed({interaction, 0}, node);
  } else if (flight.fired.empty()) {
    write_texts(flight, node);
  } else {
    // The core keeps the last ones only.
    const std::size_t kept = std::min<std::size_t>(flight.fired.size(), Core::kHistory);
    for (auto each = flight.fired.end() - static_cast<std::ptrdiff_t>(kept); each != flight.fired.end(); ++each)
      core_.remember(*each);
    output_.record(flight.fired);
    written_ += flight.fired.size();
  }
  flights_.erase(first);
}

void StepMerge::write_followed(EnabledSet::Position at, const std::string& node) {
  is_sound_ = is_sound_ && follower_->take(at, written_, output_, text_);
  if (!is_sound_) return;
  core_.remember(at.interaction);
  output_.put_of_node(text_, node);
  ++written_;
}

void StepMerge::write_texts(const Flight& flight, const std::string& node) {
  std::size_t out = 0, trace = 0;
  StepText text;
  for (const Step& step : flight.steps) {
    text.out.assign(flight.text.out, out, step.out_size);
    text.trace.assign(flight.text.trace, trace, step.trace_size);
    out += step.out_size;
    trace += step.trace_size;
    const std::string number = std::to_string(written_);
    if (step.out_number != 0) text.out.insert(step.out_number - 1, number);
    if (step.trace_number != 0) text.trace.insert(step.trace_number - 1, number);
    core_.remember(step.interaction);
    output_.put_of_node(text, node);
    ++written_;
  }
}

}  // namespace bip::rt
