// See prove_pairs.hpp.
#include "compiler/verify/timed/prove_pairs.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "compiler/model/code_uses.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/evidence/reached_zones.hpp"
#include "compiler/verify/net/unread_data.hpp"
#include "compiler/verify/timed/like_components.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Zones of one round's graph, at most.
constexpr std::uint64_t kZonesOfPairs = 200000;

class PairProver {
 public:
  PairProver(const System& system, const Property& property, const ExplorePart& explore,
             const CancellationToken& cancellation, const PartLimits& limits, std::size_t certificate_bytes)
      : property_(property),
        is_read_(find_read_data(system, data_of(property))),
        simple_(without_unread_data(system, is_read_)),
        neighbours_(simple_),
        explore_(explore),
        cancellation_(cancellation),
        limits_(limits),
        certificate_bytes_(certificate_bytes) {}

  TimeProof prove() {
    proof_.is_proved = choose_members() && prepare_steps() && reach_fixpoint();
    return std::move(proof_);
  }

 private:
  using Places = std::pair<u32, u32>;

  bool fail(const std::string& reason) {
    proof_.reason = reason;
    return false;
  }
  [[nodiscard]] const AtomType& type_of(u32 atom) const {
    return simple_.atom_types[simple_.atoms[AtomId(std::size_t{atom})].type];
  }

  // The pair: like components that the property names, and others of them if it names fewer.
  bool choose_members() {
    const std::vector<u32> about = atoms_of(property_);
    std::string reason = "the property speaks of no component that has its like";
    for (u32 atom : about) {
      like_ = find_like_components(simple_, neighbours_, atom, reason);
      if (like_) break;
    }
    if (!like_) return fail(reason);
    if (like_->outside.size() + 2 > limits_.members) return fail("too many components are beside the array");
    for (u32 atom : like_->atoms) {
      if (std::binary_search(about.begin(), about.end(), atom)) pair_.push_back(atom);
    }
    if (pair_.size() > 2) return fail("the property speaks of more than two components of an array");
    for (std::size_t k = 0; pair_.size() < 2; ++k) {
      if (std::find(pair_.begin(), pair_.end(), like_->atoms[k]) == pair_.end()) pair_.push_back(like_->atoms[k]);
    }
    std::sort(pair_.begin(), pair_.end());
    const auto third = std::find_if(like_->atoms.begin(), like_->atoms.end(), [&](u32 atom) {
      return std::find(pair_.begin(), pair_.end(), atom) == pair_.end();
    });
    BIP_ASSERT(pair_.size() == 2 && third != like_->atoms.end(), "{} of {} components are the pair", pair_.size(),
               like_->atoms.size());
    third_ = *third;
    for (const DataRef& data : data_of(property_)) {
      const bool is_of_pair = std::find(pair_.begin(), pair_.end(), data.atom.value) != pair_.end();
      if (is_of_pair ? like_->is_number[data.variable] != 0
                     : like_->number_outside.contains({data.atom.value, data.variable}))
        return fail("the property reads numbers");
    }
    members_ = like_->outside;
    members_.insert(members_.end(), pair_.begin(), pair_.end());
    std::sort(members_.begin(), members_.end());
    proof_.neighbourhoods = 1;
    proof_.largest = members_.size();
    proof_.alike = like_->atoms.size();
    return true;
  }
  [[nodiscard]] u32 local(u32 atom) const {
    BIP_ASSERT(std::binary_search(members_.begin(), members_.end(), atom), "atom {} is none of {} members", atom,
               members_.size());
    return static_cast<u32>(std::lower_bound(members_.begin(), members_.end(), atom) - members_.begin());
  }

  // The local system without steps of third components, and what these are.
  bool prepare_steps() {
    // Numbers that a third component writes are known: this is said with its steps.
    std::vector<std::vector<std::uint8_t>> is_read = is_read_;
    for (const auto& [atom, variable] : like_->number_outside)
      is_read[simple_.atoms[AtomId(std::size_t{atom})].type.value][variable] = 0;
    const VariableFacts nothing = [](u32, u32) { return AbstractValue{}; };
    LocalizedSystem part = localize(simple_, neighbours_, is_read, nothing, members_);
    if (!part.obstacle.empty()) return fail(part.obstacle);
    if (!part.required.empty()) return fail("others write data beside the array");
    base_ = std::move(part.system);
    for (u32 row = 0; row < members_.size(); ++row) {
      const std::string& path = simple_.atoms[AtomId(std::size_t{members_[row]})].path;
      base_.atoms[AtomId(std::size_t{row})].path = path;
    }
    BIP_ASSERT(part.is_whole.size() == base_.connectors.size(), "{} marks of {} connectors", part.is_whole.size(),
               base_.connectors.size());
    IndexVector<ConnectorId, Connector> kept;
    for (std::size_t k = 0; k < base_.connectors.size(); ++k) {
      Connector& connector = base_.connectors[ConnectorId(k)];
      const bool has_pair = std::any_of(connector.ports.begin(), connector.ports.end(), [&](const PortRef& ref) {
        return ref.kind == PortRef::Kind::Atom &&
               (ref.atom.value == local(pair_[0]) || ref.atom.value == local(pair_[1]));
      });
      // A step of a third one and of atoms outside is said below, with where the third one is.
      if (part.is_whole[k] == 0 && !has_pair) continue;
      is_whole_.push_back(part.is_whole[k]);
      kept.push(std::move(connector));
    }
    base_.connectors = std::move(kept);
    steps_ = outside_steps(*like_, neighbours_, third_);
    add_places_as_ports();
    return true;
  }

  // What `*` says of the ports that there are, it does not say of those that come.
  static std::vector<AtomPriority> without_wildcards(const AtomType& type) {
    std::vector<AtomPriority> rules;
    for (const AtomPriority& rule : type.priorities) {
      for (u32 low = 0; low < type.ports.size(); ++low) {
        for (u32 high = 0; high < type.ports.size(); ++high) {
          const bool fits = (rule.low == AtomPriority::kAnyPort || rule.low == low) &&
                            (rule.high == AtomPriority::kAnyPort || rule.high == high);
          if (!fits || low == high) continue;
          rules.push_back(rule);
          rules.back().low = low;
          rules.back().high = high;
        }
      }
    }
    return rules;
  }
  // A port of each of the two for each of its places, which shows that it is there.
  void add_places_as_ports() {
    const PortTypeId signal = base_.port_types.push({.name = "Place", .variables = {}});
    for (std::size_t k = 0; k < 2; ++k) {
      AtomType& type = base_.atom_types[base_.atoms[AtomId(std::size_t{local(pair_[k])})].type];
      first_place_port_ = static_cast<u32>(type.ports.size());
      type.priorities = without_wildcards(type);
      for (u32 place = 0; place < type.places.size(); ++place) {
        type.ports.push_back({.name = "at" + std::to_string(place), .type = signal, .variables = {}, .exported = true});
        Transition stays;
        stays.port = first_place_port_ + place;
        stays.from = stays.to = {place};
        type.transitions.push_back(std::move(stays));
      }
    }
  }

  // Places from which a component may take a port.
  [[nodiscard]] std::set<u32> sources(u32 port) const {
    std::set<u32> places;
    for (const Transition& t : type_of(third_).transitions) {
      BIP_ASSERT(t.from.size() == 1, "a transition of an automaton from {} places", t.from.size());
      if (t.port == port) places.insert(t.from.front());
    }
    return places;
  }
  [[nodiscard]] bool may_be_together(u32 a, u32 b) const { return together_.contains({a, b}); }

  // The steps of third components that the pairs so far allow. False: one of them cannot be said.
  bool add_steps(System& to, std::vector<std::uint8_t>& is_whole) {
    const u32 places = static_cast<u32>(type_of(third_).places.size());
    for (const OutsideStep& step : steps_) {
      const std::set<u32> from = sources(step.port);
      for (u32 a = 0; a < places; ++a) {
        for (u32 b = 0; b < places; ++b) {
          const bool is_possible = may_be_together(a, b) && std::any_of(from.begin(), from.end(), [&](u32 c) {
                                     return may_be_together(a, c) && may_be_together(b, c);
                                   });
          if (is_possible && !add_step(to, step, a, b)) return false;
          if (is_possible) is_whole.push_back(0);
        }
      }
    }
    return true;
  }
  bool add_step(System& to, const OutsideStep& step, u32 a, u32 b) {
    std::vector<Neighbours::Leaf> leaves;
    std::map<std::pair<u32, u32>, u32> bind_of;  // atom, variable
    u32 binds = 0;
    for (const Neighbours::Leaf& leaf : step.leaves) {
      leaves.push_back({local(leaf.atom), leaf.port});
      for (u32 variable : type_of(leaf.atom).ports[leaf.port].variables) bind_of[{leaf.atom, variable}] = binds++;
    }
    leaves.push_back({local(pair_[0]), first_place_port_ + a});
    leaves.push_back({local(pair_[1]), first_place_port_ + b});
    Clause clause;
    if (!add_numbers(to, step, bind_of, clause)) return false;
    add_rendezvous(to, "third", leaves, std::move(clause));
    return true;
  }
  // The numbers that the step writes: that of the third component stands for all numbers but those of the two.
  bool add_numbers(System& to, const OutsideStep& step, const std::map<std::pair<u32, u32>, u32>& bind_of,
                   Clause& clause) {
    const Connector& connector = simple_.connectors[neighbours_.tops()[step.top].connector];
    const ConnectorType& type = simple_.connector_types[connector.type];
    bool is_said = true;
    for (const Clause& original : type.clauses) {
      model::for_each_stmt(simple_.code, original.down, [&](const Stmt& s) {
        if (model::assigned_variable(s, Op::LoadSelf)) return;
        const std::optional<u32> bind = model::assigned_variable(s, Op::LoadBind);
        if (!bind) {
          is_said = false;
          return;
        }
        std::size_t param = type.params.size() - 1;
        while (type.params[param].first_bind > *bind) --param;
        const PortRef& ref = connector.ports[param];
        if (ref.atom.value == third_) return;
        const u32 variable = type_of(ref.atom.value).ports[ref.port].variables[s.index - type.params[param].first_bind];
        if (!like_->number_outside.contains({ref.atom.value, variable})) return;
        Expr value = simple_.code.exprs[s.value];
        if (value.op == Op::LoadBind) {
          const auto row = std::lower_bound(like_->atoms.begin(), like_->atoms.end(), third_) - like_->atoms.begin();
          value = {.op = Op::ConstInt, .type = Type::Int, .int_value = like_->numbers[static_cast<std::size_t>(row)]};
        }
        if (value.op != Op::ConstInt) is_said = false;
        Stmt store = s;
        store.index = bind_of.at({ref.atom.value, variable});
        store.value = to.code.exprs.push(value);
        store.next = clause.down;
        clause.down = to.code.stmts.push(store);
      });
    }
    return is_said || fail("a transfer of `" + connector.path + "` has branches or calls");
  }

  // Explores with the steps that the pairs so far allow, until there are no new pairs.
  bool reach_fixpoint() {
    const Property mine = localize(property_, members_);
    while (true) {
      System system = base_;
      std::vector<std::uint8_t> is_whole = is_whole_;
      if (!add_steps(system, is_whole)) return false;
      BIP_ASSERT(is_whole.size() == system.connectors.size(), "{} marks of {} connectors", is_whole.size(),
                 system.connectors.size());
      const std::size_t before = together_.size();
      rt::PartQuestion question{.atom = local(pair_[0]), .is_whole = is_whole, .is_impossible = {}, .is_asked = {}};
      question.asks_places = true;
      question.is_asked = [&](const rt::Core& core) { return is_broken(mine, core); };
      // Sees each location once.
      question.is_impossible = [&](const rt::Core& core) {
        const u32 a = place_of(core, pair_[0]), b = place_of(core, pair_[1]);
        together_.insert({a, b});
        together_.insert({b, a});
        return false;
      };
      std::optional<ZoneCollector> listed;
      if (certificate_bytes_ != 0) {
        question.visit = [&](const rt::Image& image, const rt::ListedLocation& location) {
          if (!listed) listed.emplace(system, image, unread_cells(image), certificate_bytes_);
          listed->add(location);
        };
      }
      const rt::PartReport found = explore_(system, local_options(kZonesOfPairs, cancellation_), question);
      ++proof_.explored;
      proof_.zones += found.zones;
      if (found.is_open) return fail("two components that are alike, and what is beside them, do not show it");
      if (!found.is_complete)
        return fail(!found.inexact.empty()    ? found.inexact
                    : cancellation_.is_over() ? "the time is over"
                                              : "two components that are alike have too many zones");
      if (together_.size() != before) continue;
      if (listed) add_certificate(std::move(*listed));
      return true;
    }
  }
  [[nodiscard]] bool is_read(u32 atom, u32 variable) const {
    return is_read_[simple_.atoms[AtomId(std::size_t{atom})].type.value][variable] != 0;
  }
  // Of the local system, ascending.
  [[nodiscard]] std::vector<rt::VariableId> unread_cells(const rt::Image& image) const {
    std::vector<rt::VariableId> cells;
    for (u32 row = 0; row < members_.size(); ++row) {
      for (u32 variable = 0; variable < type_of(members_[row]).variables.size(); ++variable) {
        if (!is_read(members_[row], variable)) cells.push_back(image.atoms[row].variable(variable));
      }
    }
    return cells;
  }
  // The pair, the data in which numbers are, and the zone graph.
  void add_certificate(ZoneCollector listed) {
    const std::string rows = std::move(listed).rows();
    if (rows.empty()) return;
    const auto path_of = [&](u32 atom) { return ' ' + simple_.atoms[AtomId(std::size_t{atom})].path; };
    proof_.rows = "pair" + path_of(pair_[0]) + path_of(pair_[1]);
    for (u32 atom : members_) {
      const bool is_of_pair = std::find(pair_.begin(), pair_.end(), atom) != pair_.end();
      for (u32 variable = 0; variable < type_of(atom).variables.size(); ++variable) {
        const DataVariable& row = type_of(atom).variables[variable];
        const bool holds_number =
            is_of_pair ? like_->is_number[variable] != 0 : like_->number_outside.contains({atom, variable});
        if (holds_number && !row.is_param && is_read(atom, variable)) proof_.rows += path_of(atom) + '.' + row.name;
      }
    }
    proof_.rows += '\n' + rows;
  }
  [[nodiscard]] u32 place_of(const rt::Core& core, u32 atom) const {
    const AtomType& type = type_of(atom);
    for (u32 place = 0; place < type.places.size(); ++place) {
      if (core.is_marked(local(atom), place)) return place;
    }
    BIP_UNREACHABLE("an automaton is at a place");
  }

  const Property& property_;
  std::vector<std::vector<std::uint8_t>> is_read_;
  System simple_;
  Neighbours neighbours_;
  const ExplorePart& explore_;
  CancellationToken cancellation_;
  PartLimits limits_;
  std::size_t certificate_bytes_;
  std::optional<LikeComponents> like_;
  std::vector<u32> pair_, members_;
  u32 third_ = 0;
  System base_;
  std::vector<std::uint8_t> is_whole_;  // by connector of base_
  std::vector<OutsideStep> steps_;      // of the third
  u32 first_place_port_ = 0;
  std::set<Places> together_;  // places that two components may be at together, in both orders
  TimeProof proof_;
};

}  // namespace

TimeProof prove_state_by_pairs(const System& system, const Property& property, const ExplorePart& explore,
                               const CancellationToken& cancellation, const PartLimits& limits,
                               std::size_t certificate_bytes) {
  TimeProof proof;
  proof.reason = obstacle_to_local_proof(system, property);
  if (!proof.reason.empty()) return proof;
  return PairProver(system, property, explore, cancellation, limits, certificate_bytes).prove();
}

}  // namespace bip::verify
