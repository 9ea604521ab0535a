// See explore_alone.hpp.
#include "compiler/verify/regions/explore_alone.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "compiler/model/code_uses.hpp"
#include "compiler/verify/regions/region_step.hpp"

namespace bip::verify {

namespace {

constexpr u32 kStatesBetweenLooks = 64;

// Range has no order of its own.
struct WriteOrder {
  bool operator()(const LocalSpace::Writes& a, const LocalSpace::Writes& b) const {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
      return std::tie(x.first, x.second.low, x.second.high) < std::tie(y.first, y.second.low, y.second.high);
    });
  }
};

class AloneExplorer {
 public:
  AloneExplorer(const RegionNet& net, u32 atom, LocalSpace& space) : net_(net), atom_(atom), space_(space) {
    const AtomType& type = net.type_of(atom);
    is_plain_.resize(type.ports.size(), 0);
    writes_.resize(type.ports.size());
    steps_.resize(type.ports.size());
    if (net.writing == Writing::Anything) {
      for (u32 port = 0; port < type.ports.size(); ++port) write_anything(port);
    } else {
      for (u32 port = 0; port < type.ports.size(); ++port) is_plain_[port] = type.ports[port].exported ? 0 : 1;
      for (const u32 connector : net.connectors[atom]) add(connector);
    }
    for (u32 port = 0; port < type.ports.size(); ++port) forget_overwritten(port);
  }

  bool run(u32 most, const CancellationToken& cancellation) {
    (void)space_.initial();
    for (u32 state = 0; state < space_.size() && !space_.is_too_large(); ++state) {
      if (space_.size() > most || (state % kStatesBetweenLooks == 0 && cancellation.is_over())) return false;
      for (u32 port = 0; port < is_plain_.size(); ++port) leave(state, port);
    }
    return !space_.is_too_large();
  }

 private:
  // Whether or not a connector is there: what is reached is closed under all that the component may do.
  void write_anything(u32 port) {
    LocalSpace::Writes writes;
    for (const u32 variable : net_.written[net_.system->atoms[AtomId(std::size_t{atom_})].type.value][port])
      writes.emplace_back(variable, net_.range(atom_, variable));
    if (writes.empty()) is_plain_[port] = 1;
    else writes_[port].insert(std::move(writes));
  }
  void add(u32 connector) {
    RegionStep step = step_of(net_, connector, {atom_});
    const RegionStep::Member member = step.members.front();
    const ConnectorTypeId type = net_.connector(connector).type;
    const std::vector<u32>& variables = net_.type_of(atom_).ports[member.port].variables;
    bool writes = false, reads = false;
    for (u32 k = 0; k < variables.size(); ++k) {
      writes |= net_.assigned[type.value][member.first_bind + k] != 0;
      reads |= net_.reads[type.value][member.first_bind + k] && !net_.is_fixed(atom_, variables[k]);
    }
    if (!writes) {
      is_plain_[member.port] = 1;
    } else if (reads) {
      steps_[member.port].push_back(std::move(step));
    } else {
      std::vector<Range> binds = step.binds;
      if (transfer(net_, connector, binds)) writes_[member.port].insert(writes_to(net_, step, member, atom_, binds));
    }
  }
  // A variable that is written has no say in what follows, unless a guard of the port's transitions reads it. So states
  // that differ in it alone have the same successors.
  void forget_overwritten(u32 port) {
    const AtomType& type = net_.type_of(atom_);
    std::vector<bool>& ignored = ignored_.emplace_back(type.variables.size(), false);
    if (writes_[port].empty()) return;
    for (const auto& [variable, range] : *writes_[port].begin()) ignored[variable] = true;
    for (const LocalSpace::Writes& writes : writes_[port]) {
      std::vector<bool> written(type.variables.size(), false);
      for (const auto& [variable, range] : writes) written[variable] = true;
      for (u32 k = 0; k < written.size(); ++k) ignored[k] = ignored[k] && written[k];
    }
    std::vector<bool> read(type.variables.size(), false);
    for (const Transition& t : type.transitions) {
      if (t.port == port) model::mark_reads(net_.system->code, t.guard, Op::LoadSelf, read);
    }
    for (u32 k = 0; k < read.size(); ++k) ignored[k] = ignored[k] && !read[k];
  }
  void leave(u32 state, u32 port) {
    if (is_plain_[port] != 0) (void)space_.after(state, port, {});
    if (!writes_[port].empty() && is_new(state, port)) {
      for (const LocalSpace::Writes& writes : writes_[port]) (void)space_.after(state, port, writes);
    }
    for (const RegionStep& step : steps_[port]) {
      const RegionStep::Member& member = step.members.front();
      std::vector<Range> binds = step.binds;
      const std::vector<u32>& variables = net_.type_of(atom_).ports[port].variables;
      for (u32 k = 0; k < variables.size(); ++k) binds[member.first_bind + k] = space_.range(state, variables[k]);
      if (transfer(net_, step.connector, binds))
        (void)space_.after(state, port, writes_to(net_, step, member, atom_, binds));
    }
  }
  bool is_new(u32 state, u32 port) {
    std::vector<std::int64_t> view(space_.marking(state).begin(), space_.marking(state).end());
    view.push_back(-1);
    for (u32 k = 0; k < ignored_[port].size(); ++k) {
      if (!ignored_[port][k]) view.push_back(space_.range(state, k).low);
    }
    return seen_[port].insert(std::move(view)).second;
  }

  const RegionNet& net_;
  u32 atom_;
  LocalSpace& space_;
  std::vector<std::uint8_t> is_plain_;                            // by port: some step writes nothing
  std::vector<std::set<LocalSpace::Writes, WriteOrder>> writes_;  // by port, of steps that read nothing of the atom
  std::vector<std::vector<RegionStep>> steps_;                    // by port, others
  std::vector<std::vector<bool>> ignored_;                        // by port and variable
  std::map<u32, std::set<std::vector<std::int64_t>>> seen_;       // by port
};

}  // namespace

std::optional<LocalSpace> explore_alone(const RegionNet& net, u32 atom, const RegionConstants& constants,
                                        const std::vector<std::uint8_t>& follows, u32 most,
                                        const CancellationToken& cancellation) {
  LocalSpace space(net, atom, constants, follows);
  if (space.is_too_large() || !AloneExplorer(net, atom, space).run(most, cancellation)) return std::nullopt;
  return space;
}

}  // namespace bip::verify
