// See fair_units.hpp.
#include "compiler/verify/liveness/fair_units.hpp"

#include <algorithm>

namespace bip::verify {

FairUnits::FairUnits(const rt::StepLabels& labels, const Fairness& fairness) : units_(labels.size()) {
  const auto add = [&](std::uint32_t label, std::uint32_t unit) {
    std::vector<std::uint32_t>& own = units_[label];
    if (own.empty() || own.back() < unit) own.push_back(unit);
    else if (const auto at = std::lower_bound(own.begin(), own.end(), unit); *at != unit) own.insert(at, unit);
  };
  for (const FairnessTerm& term : fairness.terms) {
    const std::uint32_t first = size();
    first_.push_back(first);
    std::uint32_t count = term.has_name() ? 1 : 0;
    for (std::uint32_t label = 0; label < labels.size(); ++label) {
      const auto note = [&](std::uint32_t row) {
        add(label, first + row);
        count = std::max(count, row + 1);
      };
      switch (term.unit) {
        case FairnessUnit::Interactions: note(label); break;
        case FairnessUnit::Atoms:
          for (const rt::PortOfAtom& port : labels.ports(label)) note(port.atom);
          break;
        case FairnessUnit::Connector:
          if (labels[label].connector == term.owner) note(0);
          break;
        case FairnessUnit::Port:
          if (labels.has_port(label, {term.owner, term.port})) note(0);
          break;
        case FairnessUnit::Atom:
          for (const rt::PortOfAtom& port : labels.ports(label)) {
            if (port.atom == term.owner) note(0);
          }
          break;
      }
    }
    is_strong_.insert(is_strong_.end(), count, term.is_strong() ? 1 : 0);
  }
}

}  // namespace bip::verify
