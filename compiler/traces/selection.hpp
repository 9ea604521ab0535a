// Which steps of a recorded run are wanted: by component, interaction, number and instant.
#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "runtime/core/core.hpp"
#include "runtime/debug/session.hpp"

namespace bip::traces {

/// A step of a run, in the state after it.
struct TracedStep {
  std::uint64_t number = 0;  // from 0
  rt::i64 instant = 0;       // ns
  std::string interaction;   // "ROOT.k", of an internal port "ROOT.a.p"
  const std::vector<rt::MovePart>* parts = nullptr;
};

struct Selection {
  // Paths with or without `ROOT.`: of one of them or of what is in it, `left` for all of `left[…]`. Empty: all.
  std::vector<std::string> components, interactions;
  std::uint64_t first = 0, last = std::numeric_limits<std::uint64_t>::max();  // numbers of steps
  rt::i64 begin = 0, end = std::numeric_limits<rt::i64>::max();               // instants

  [[nodiscard]] bool is_all() const;
  /// The first of `components` and `interactions` that the model does not have; empty: none.
  [[nodiscard]] std::string unknown(const rt::Image& image) const;
  [[nodiscard]] bool takes(const rt::Image& image, const TracedStep& step) const;
  [[nodiscard]] bool takes_component(const std::string& path) const;
};

}  // namespace bip::traces
