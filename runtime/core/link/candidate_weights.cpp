// See candidate_weights.hpp.
#include "runtime/core/link/candidate_weights.hpp"

#include "bip/assert.hpp"
#include "runtime/core/core_parts.hpp"

namespace bip::rt {

namespace {

// A product that no compiler contracts with the subtraction after it: the same draw on every machine.
[[gnu::noinline]] double share_of(double share, double total) { return share * total; }

}  // namespace

void CandidateWeights::link() {
  const Image& image = core_.image();
  if (!is_weighted(image)) return;
  of_transition_.assign(core_.tables.transitions.size() + 1, {});
  of_connector_.assign(image.connectors.size, 1);
  for (const TransitionWeight& w : image.transition_weights)
    of_transition_[core_.tables.types[w.type].first_transition + w.transition] = {w.value, w.param};
  for (const ConnectorWeight& w : image.connector_weights) of_connector_[w.connector] = w.value;
}

double CandidateWeights::weight(EnabledSet::Position at) {
  const Candidate candidate = core_.candidate(at);
  core_.firing.participants(candidate, participants_);
  double product = candidate.connector == kNone ? 1 : of_connector_[candidate.connector];
  for (const Participant& p : participants_) {
    const u32 transition = core_.ports.enabled_row(core_.tables.port_base(p.atom) + p.port);
    BIP_ASSERT(transition != kNone, "port {} of atom {} is disabled", p.port, p.atom);
    const Row& row = of_transition_[transition];
    double factor = row.value;
    if (row.param != kNone) {
      const AtomInfo& atom = core_.atoms[p.atom];
      const Cell cell = core_.memory.cells[atom.first_cell + row.param];
      const bool is_float = core_.tables.atom_type(p.atom).variables[row.param].type == CellType::Float;
      factor = is_float ? cell.f : cell.i;
    }
    product *= factor;
  }
  BIP_ASSERT(product > 0, "candidate {} of interaction {} has no weight", at.rank, at.interaction);
  return product;
}

EnabledSet::Position CandidateWeights::drawn(double share) {
  const std::uint64_t count = core_.enabled.total();
  BIP_ASSERT(count != 0 && share >= 0 && share < 1, "share {} of {} candidates", share, count);
  double total = 0;
  weights_.clear();
  for (std::uint64_t k = 0; k < count; ++k) {
    weights_.push_back(weight(core_.enabled.select(k)));
    total += weights_.back();
  }
  double left = share_of(share, total);
  std::uint64_t k = 0;
  while (k + 1 < count && left >= weights_[k]) left -= weights_[k++];
  return core_.enabled.select(k);
}

}  // namespace bip::rt
