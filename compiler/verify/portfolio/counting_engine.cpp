// See counting_engine.hpp.
#include "compiler/verify/portfolio/counting_engine.hpp"

#include <algorithm>

#include "compiler/base/log.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/counting/counting_rows.hpp"
#include "compiler/verify/counting/exclude_all.hpp"
#include "compiler/verify/net/unread_data.hpp"
#include "compiler/verify/portfolio/search_symmetry.hpp"
#include "runtime/core/text.hpp"
#include "runtime/explore/explore.hpp"

namespace bip::verify {

namespace {

bool may_count(const ProofContext& context) {
  const rt::Image& image = context.parts.image();
  // What hides an interaction, and time, are not what its own atoms decide.
  return context.question.what == QuestionKind::State && context.limits.may_search && context.parts.is_searchable() &&
         image.priorities.size == 0 && image.ffi == nullptr && !rt::has_time(image);
}

// The members that may change places; without those that the property names, which stay where they are.
InterchangeableGroups groups_beside(const std::vector<u32>& named, const rt::Image& image) {
  InterchangeableGroups groups = rt::interchangeable_members(image, symmetry_limits());
  const auto has_named = [&](const std::vector<u32>& member) {
    return std::any_of(member.begin(), member.end(),
                       [&](u32 atom) { return std::binary_search(named.begin(), named.end(), atom); });
  };
  for (auto& group : groups) std::erase_if(group, has_named);
  std::erase_if(groups, [](const auto& group) { return group.size() < 2; });
  return groups;
}

CountingProof::Sum sum_of(CountedNetBuilder& builder, const BadPlaces& bad, const SubInvariant& proof) {
  const CountedNet& net = builder.net();
  CountingProof::Sum sum;
  sum.in_bad_states = proof.scale * static_cast<std::int64_t>(bad.sets.size());
  for (const SubInvariant::WeightedTrap& trap : proof.traps) sum.in_bad_states += trap.factor;
  for (u32 place = 0; place < net.places.size(); ++place) {
    sum.initially += proof.weights[place] * net.tokens[place];
    if (proof.weights[place] == 0) continue;
    const u32 kind = net.places[place].kind, atom = net.atom_of_kind[kind];
    if (!builder.enter_atoms({atom}, {place})) continue;
    std::string line = std::to_string(proof.weights[place]) + " for ";
    const auto count = std::count(net.kind_of_atom.begin(), net.kind_of_atom.end(), kind);
    if (count > 1) line += "each of " + std::to_string(count) + " like ";
    rt::append_relative(line, builder.core().image().atoms[atom]);
    line += " at `" + rt::places_of(builder.core(), atom) + '`';
    const std::string data = rt::data_of(builder.core(), atom);
    if (!data.empty()) line += "  " + data;
    sum.weights.push_back(std::move(line));
  }
  return sum;
}

EngineResult prove_by_counting(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  EngineResult result;
  result.retry = Retry::Pointless;
  if (!context.parts.has_code()) return result;
  const rt::Image& image = context.parts.image();
  const Property& property = context.question.property;
  const CancellationToken share = cancellation.within(budget.seconds);
  const InterchangeableGroups groups = groups_beside(atoms_of(property), image);
  if (groups.empty()) return result;
  const System& system = context.parts.system();
  const std::vector<rt::VariableId> unread_cells = find_unread_cells(system, image, data_of(property));
  CountedNetBuilder builder(image, groups, unread_cells);
  builder.build({.cancellation = share});
  if (!builder.net().problem.empty()) {
    BIP_LOG(Portfolio, 1, "counting: {}", builder.net().problem);
    return result;
  }
  const auto bad = find_bad_places(builder, property, goal_of(context.question).state);
  if (!bad) return result;
  const std::optional<std::vector<ExcludedPlaces>> excluded = exclude_all(builder, *bad, share);
  if (!excluded) return result;
  CountingProof evidence;
  std::vector<SubInvariant> proofs;
  evidence.local_states = builder.net().places.size();
  for (const ExcludedPlaces& each : *excluded) {
    evidence.sums.push_back(sum_of(builder, each.places, each.proof));
    proofs.push_back(each.proof);
  }
  if (context.limits.wants_certificate) {
    std::optional<std::string> rows = counting_rows(builder, proofs, system, unread_cells);
    if (!rows) return result;
    evidence.rows = std::move(*rows);
  }
  result.outcome = Outcome::Holds;
  result.evidence = std::move(evidence);
  return result;
}

}  // namespace

const Engine kCountingEngine{"counting", may_count, prove_by_counting};

}  // namespace bip::verify
