// See step_merge.hpp.
#include "runtime/engine/step_merge.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "runtime/engine/node_process.hpp"
#include "runtime/engine/unwritten_steps.hpp"

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

bool StepMerge::take_begun(u32 node, const Control& control) {
  constexpr std::size_t kHead = 4;
  if (control.numbers.size() < kHead || control.texts.size() != 2) return false;
  const u64 step = control.numbers[0];
  if (node_of_step(step) != node || step <= bounds_[node] || control.numbers[1] >= core_.tables().interactions.size())
    return false;
  // A number stands before a character of its text, or behind the last one.
  if (control.numbers[2] > control.texts[0].size() + 1 || control.numbers[3] > control.texts[1].size() + 1)
    return false;
  if (std::any_of(control.numbers.begin() + kHead, control.numbers.end(),
                  [this](u64 home) { return home >= bounds_.size(); }))
    return false;
  Flight& flight = flights_[step];
  flight.is_told = true;
  flight.interaction = InteractionId(control.numbers[1]);
  flight.out_number = control.numbers[2];
  flight.trace_number = control.numbers[3];
  flight.text = {control.texts[0], control.texts[1]};
  waiting_bytes_ += record_bytes(flight.text);
  most_waiting_bytes_ = std::max(most_waiting_bytes_, waiting_bytes_);
  for (std::size_t i = kHead; i < control.numbers.size(); ++i) add(flight, static_cast<u32>(control.numbers[i]), 1);
  bounds_[node] = step;
  return true;
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
  Flight& flight = first->second;
  const u64 bytes = record_bytes(flight.text);
  BIP_ASSERT(bytes <= waiting_bytes_ && first->first > last_written_, "step {} after {}", first->first, last_written_);
  waiting_bytes_ -= bytes;
  written_bytes_ += bytes;
  last_written_ = first->first;
  const std::string number = std::to_string(written_);
  if (flight.out_number != 0) flight.text.out.insert(flight.out_number - 1, number);
  if (flight.trace_number != 0) flight.text.trace.insert(flight.trace_number - 1, number);
  core_.remember(flight.interaction);
  output_.put_of_node(flight.text, distribution_.placement.nodes[node_of_step(first->first)]);
  flights_.erase(first);
  ++written_;
}

}  // namespace bip::rt
