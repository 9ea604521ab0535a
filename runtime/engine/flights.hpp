// Texts of steps that were begun and are not yet known to be steps of the run: nothing is, before all earlier ones have
// ended well. They are written in the order of the steps.
#pragma once
#include <deque>

#include "bip/assert.hpp"
#include "runtime/engine/output.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

class Flights {
 public:
  explicit Flights(Output& output) : output_(output) {}

  /// Describes the next step, in the state before it.
  void depart(Core& core, EnabledSet::Position at) {
    const std::uint64_t number = departed() - empty_;
    flights_.emplace_back();
    output_.describe(flights_.back().text, core, at, number, kNoChoice);
  }
  /// How often the last one that departed has to land.
  void set_parts(std::uint32_t parts) { flights_.back().open = parts; }
  /// A number among the steps that no step has.
  void skip() {
    flights_.emplace_back();
    ++empty_;
  }
  [[nodiscard]] std::uint64_t departed() const { return written_ + flights_.size(); }
  /// A part of the step has ended.
  void land(std::uint64_t step) {
    BIP_ASSERT(step >= written_ && step - written_ < flights_.size(), "step {}", step);
    BIP_ASSERT(flights_[step - written_].open != 0, "step {} has landed", step);
    --flights_[step - written_].open;
  }
  /// Writes what has landed.
  void write_landed() {
    while (!flights_.empty() && flights_.front().open == 0) write_first();
  }
  /// Writes the steps up to this one, landed or not.
  void write_until(std::uint64_t step) {
    while (!flights_.empty() && written_ <= step) write_first();
  }

 private:
  struct Flight {
    std::uint32_t open = 0;
    StepText text;
  };
  void write_first() {
    output_.put(flights_.front().text);
    flights_.pop_front();
    ++written_;
  }

  Output& output_;
  std::deque<Flight> flights_;  // steps written_ …
  std::uint64_t written_ = 0, empty_ = 0;
};

}  // namespace bip::rt
