// See proof_cache.hpp.
#include "compiler/verify/evidence/proof_cache.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "compiler/base/content_hash.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// As much of a hash as tells components of a file apart.
constexpr std::size_t kShort = 16;

CompoundId parent_of(const System& system, CompoundId compound) { return system.compounds[compound].parent; }

std::size_t depth_of(const System& system, CompoundId compound) {
  std::size_t depth = 0;
  for (; parent_of(system, compound).is_valid(); compound = parent_of(system, compound)) ++depth;
  return depth;
}

// The smallest compound that holds both.
CompoundId common(const System& system, CompoundId a, CompoundId b) {
  std::size_t depth_a = depth_of(system, a), depth_b = depth_of(system, b);
  for (; depth_a > depth_b; --depth_a) a = parent_of(system, a);
  for (; depth_b > depth_a; --depth_b) b = parent_of(system, b);
  while (a != b) {
    a = parent_of(system, a);
    b = parent_of(system, b);
  }
  return a;
}

template <class Rows>
CompoundId owner_of(const System& system, const Rows& rows) {
  CompoundId owner;
  u32 last = kNoRow;
  for (const auto& row : rows) {
    if (row.atom == last) continue;
    last = row.atom;
    const CompoundId parent = system.atoms[AtomId(std::size_t{row.atom})].parent;
    owner = owner.is_valid() ? common(system, owner, parent) : parent;
  }
  return owner;
}

}  // namespace

std::vector<CompoundId> ProofCache::parts(const Net& net) const {
  std::vector<CompoundId> result;
  std::set<std::string_view> seen;
  // The root is no part.
  for (std::size_t row = 1; row < net.system->compounds.size() && result.size() < kMaxParts; ++row) {
    if (seen.insert(content_.of_compound[row]).second) result.emplace_back(row);
  }
  return result;
}

std::string ProofCache::name_of(const Net& net, CompoundId compound, const std::string& question) const {
  const bool is_root = !parent_of(*net.system, compound).is_valid();
  return content_hash({origin_, question, is_root ? "system" : "part", content_.of_compound[compound.value]});
}

std::string ProofCache::name_of_last(const Net& net, const std::string& question) const {
  return content_hash({origin_, question, "last", net.system->compounds[CompoundId(std::size_t{0})].type});
}

void ProofCache::recall_below(const Net& net, CompoundId compound, const std::string& text, CachedProof& into) {
  bytes_ += text.size();
  if (bytes_ > kMaxBytes) return;
  const System& system = *net.system;
  if (atom_at_.empty()) {
    for (std::size_t row = 0; row < system.atoms.size(); ++row)
      atom_at_[system.atoms[AtomId(row)].path] = static_cast<u32>(row);
  }
  const std::string& above = system.compounds[compound].path;
  const auto atom_of = [&](const AtomName& name) -> std::optional<u32> {
    const auto found = atom_at_.find(above + '.' + name.path);
    if (found == atom_at_.end() || name.content != content_.of_class[net.class_of[found->second]].substr(0, kShort))
      return std::nullopt;
    return found->second;
  };
  std::optional<CachedProof> proof = parse_cached_proof(text, atom_of);
  if (!proof) return;
  ++counts.files;
  if (into.method == ProofMethod::None) into.method = proof->method;
  into.invariants.insert(into.invariants.end(), proof->invariants.begin(), proof->invariants.end());
  into.lemmas.insert(into.lemmas.end(), proof->lemmas.begin(), proof->lemmas.end());
  into.equations.insert(into.equations.end(), proof->equations.begin(), proof->equations.end());
  into.uses_bounds = proof->uses_bounds;
  into.choices = std::move(proof->choices);
}

CachedProof ProofCache::recall(const Net& net, const std::string& question) {
  counts = {};
  content_ = content_of(net);
  atom_at_.clear();
  bytes_ = 0;
  const CompoundId root(std::size_t{0});
  CachedProof result;
  if (const auto text = cache_.load(name_of(net, root, question))) {
    recall_below(net, root, *text, result);
    counts.is_whole = counts.files != 0;
  }
  if (!counts.is_whole) {
    // Where the last proof of such a root is.
    if (const auto last = cache_.load(name_of_last(net, question)); last && last->size() == 64) {
      if (const auto text = cache_.load(*last)) recall_below(net, root, *text, result);
    }
    result.choices.clear();
    // Those of another system are found anew: they are solved for all of it at once.
    result.equations.clear();
    result.uses_bounds = false;
    std::map<std::string_view, std::vector<CompoundId>> equal;
    for (std::size_t row = 1; row < net.system->compounds.size(); ++row)
      equal[content_.of_compound[row]].emplace_back(row);
    for (CompoundId part : parts(net)) {
      const auto text = cache_.load(name_of(net, part, question));
      if (!text) continue;
      CachedProof part_proof;
      for (CompoundId same : equal[content_.of_compound[part.value]]) recall_below(net, same, *text, part_proof);
      result.invariants.insert(result.invariants.end(), part_proof.invariants.begin(), part_proof.invariants.end());
      result.lemmas.insert(result.lemmas.end(), part_proof.lemmas.begin(), part_proof.lemmas.end());
    }
    // The same may come from several files: the first one stays where it is.
    const auto keep_first = [](auto& rows) {
      std::set<typename std::remove_reference_t<decltype(rows)>::value_type> seen;
      std::erase_if(rows, [&](const auto& row) { return !seen.insert(row).second; });
    };
    keep_first(result.invariants);
    keep_first(result.lemmas);
  }
  counts.recalled =
      result.invariants.size() + result.equations.size() + result.lemmas.size() + (result.choices.empty() ? 0 : 1);
  return result;
}

void ProofCache::store(const Net& net, const std::string& question, const CachedProof& proof) {
  const System& system = *net.system;
  BIP_ASSERT(content_.of_compound.size() == system.compounds.size(), "the system was not recalled before");
  BIP_ASSERT(proof.method != ProofMethod::None, "a proof without method is not stored");
  const auto name_below = [&](CompoundId compound) {
    return [&, compound](u32 atom) {
      return AtomName{path_below(system.compounds[compound].path, system.atoms[AtomId(std::size_t{atom})].path),
                      content_.of_class[net.class_of[atom]].substr(0, kShort)};
    };
  };
  const CompoundId root(std::size_t{0});
  const std::string name = name_of(net, root, question), text = print_cached_proof(proof, name_below(root));
  if (text.size() > kMaxBytes || !cache_.store(name, text)) return;
  counts.stored = 1;
  if (proof.method == ProofMethod::Steps) return;
  counts.stored += cache_.store(name_of_last(net, question), name) ? 1 : 0;

  std::map<CompoundId, CachedProof> below;
  for (const CachedInvariant& invariant : proof.invariants)
    below[owner_of(system, invariant.terms)].invariants.push_back(invariant);
  for (const CachedLemma& lemma : proof.lemmas) below[owner_of(system, lemma)].lemmas.push_back(lemma);
  for (CompoundId part : parts(net)) {
    const auto found = below.find(part);
    if (found == below.end()) continue;
    counts.stored +=
        cache_.store(name_of(net, part, question), print_cached_proof(found->second, name_below(part))) ? 1 : 0;
  }
}

}  // namespace bip::verify
