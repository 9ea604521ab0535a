// See neighbourhood.hpp.
#include "compiler/verify/liveness/neighbourhood.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr u32 kMostCombinations = 1'000'000;
constexpr std::size_t kMostMoves = 16'000'000;
constexpr u32 kCombinationsBetweenLooks = 1024;

// The row of a component, or the number of rows if it is not there.
u32 find_row(const std::vector<u32>& sorted, u32 atom) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), atom);
  return static_cast<u32>(at != sorted.end() && *at == atom ? at - sorted.begin() : sorted.end() - sorted.begin());
}

}  // namespace

Neighbourhood::Neighbourhood(NeighbourhoodSteps& steps, const std::vector<u32>& named, const std::vector<u32>& beside,
                             const CancellationToken& cancellation)
    : atoms_(named) {
  BIP_ASSERT(std::is_sorted(named.begin(), named.end()) && std::is_sorted(beside.begin(), beside.end()),
             "{} and {} components in no order", named.size(), beside.size());
  atoms_.insert(atoms_.end(), beside.begin(), beside.end());
  std::sort(atoms_.begin(), atoms_.end());
  find_steps(steps, named, beside);
  for (const u32 atom : beside) {
    const LocalSpace* space = steps.space(atom, cancellation);
    BIP_ASSERT(space != nullptr, "component {} has no space", atom);
    if (space->size() > kMostCombinations / width_) return;
    sizes_.push_back(space->size());
    strides_.push_back(width_);
    width_ *= space->size();
  }
  is_complete_ = find_moves(steps, cancellation);
}

void Neighbourhood::find_steps(NeighbourhoodSteps& steps, const std::vector<u32>& named,
                               const std::vector<u32>& beside) {
  std::vector<u32> all;
  for (const u32 atom : atoms_) all.insert(all.end(), steps.steps_of(atom).begin(), steps.steps_of(atom).end());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  for (const u32 step : all) {
    FollowedStep& followed = steps_.emplace_back();
    followed.step = step;
    for (const u32 atom : steps.atoms_of(step)) {
      const u32 row = find_row(named, atom), row_beside = find_row(beside, atom);
      if (row < named.size()) followed.seats.push_back({atom, true, row});
      else if (row_beside < beside.size()) followed.seats.push_back({atom, false, row_beside});
      followed.has_named = followed.has_named || row < named.size();
      followed.has_beside = followed.has_beside || row_beside < beside.size();
    }
    followed.is_whole = followed.seats.size() == steps.atoms_of(step).size();
  }
}

bool Neighbourhood::find_moves(NeighbourhoodSteps& steps, const CancellationToken& cancellation) {
  const std::vector<u32> nobody;
  for (u32 from = 0; from < width_; ++from) {
    if (from % kCombinationsBetweenLooks == 0 && cancellation.is_over()) return false;
    first_.push_back(static_cast<u32>(moves_.size()));
    for (const FollowedStep& step : steps_) {
      if (step.has_named) continue;
      for (const NeighbourhoodSteps::Move& move : steps.moves(step.step, members_of(step, nobody, from))) {
        // Spaces have all states from the start; one that has not is of no use.
        for (std::size_t k = 0; k < step.seats.size(); ++k) {
          if (move[k] >= sizes_[step.seats[k].row]) return false;
        }
        u32 to = from;
        std::vector<u32> none;
        apply(step, move, none, to);
        moves_.push_back({step.step, to});
      }
    }
    if (moves_.size() > kMostMoves) return false;
  }
  first_.push_back(static_cast<u32>(moves_.size()));
  return true;
}

const FollowedStep* Neighbourhood::find_whole(u32 step) const {
  const auto at = std::lower_bound(steps_.begin(), steps_.end(), step,
                                   [](const FollowedStep& followed, u32 number) { return followed.step < number; });
  return at != steps_.end() && at->step == step && at->is_whole ? &*at : nullptr;
}

NeighbourhoodSteps::Members Neighbourhood::members_of(const FollowedStep& step, const std::vector<u32>& named,
                                                      u32 combination) const {
  NeighbourhoodSteps::Members members;
  for (const FollowedStep::Seat& seat : step.seats)
    members.add({seat.atom, seat.is_named ? named[seat.row] : state_of(seat.row, combination)});
  return members;
}

void Neighbourhood::apply(const FollowedStep& step, const NeighbourhoodSteps::Move& move, std::vector<u32>& named,
                          u32& combination) const {
  for (std::size_t k = 0; k < step.seats.size(); ++k) {
    const FollowedStep::Seat& seat = step.seats[k];
    if (seat.is_named) named[seat.row] = move[k];
    else combination = with(seat.row, move[k], combination);
  }
}

}  // namespace bip::verify
