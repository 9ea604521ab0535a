// Proofs kept from run to run: what was found of a whole system, and of each compound in it, named by the content of
// its network (net_content.hpp) and by the question. A compound that has not changed finds what is known of it again,
// whatever it stands in.
//
// Recalled is, if the very system is known, all of its proof; else what the last proof of a system with a root of that
// name said of components that are still the same, and what is known of the compounds. All of it is for whoever asks to
// check: a file may be old, of another system, or forged. Cost: hashing the network, and at most kMostParts files.
#pragma once
#include <unordered_map>

#include "compiler/base/content_cache.hpp"
#include "compiler/verify/evidence/cached_proof.hpp"
#include "compiler/verify/net/net_content.hpp"

namespace bip::verify {

struct ReuseCounts {
  bool is_whole = false;     // the very system was known
  std::size_t files = 0;     // that were read and could be used
  std::size_t recalled = 0;  // invariants, lemmas and ways in them
  // Of these what was checked and holds here.
  std::size_t invariants = 0, equations = 0, lemmas = 0;
  bool has_way = false;
  std::size_t stored = 0;  // files
};

/// WhatCosts: not what is found at once.
enum class Keeps : std::uint8_t { WhatCosts, All };

class ProofCache {
 public:
  /// `origin`: whose proofs they are; others' are not looked for.
  ProofCache(ContentCache& cache, std::string origin, Keeps keeps = Keeps::WhatCosts)
      : cache_(cache), origin_(std::move(origin)), keeps_(keeps) {}

  /// `question`: proofs of other questions are others.
  [[nodiscard]] CachedProof recall(const Net& net, const std::string& question);
  /// Of the system last recalled.
  void keep(const Net& net, const std::string& question, const CachedProof& proof);

  [[nodiscard]] Keeps keeps() const { return keeps_; }
  [[nodiscard]] std::size_t broken_files() const { return cache_.broken().size(); }
  ReuseCounts counts;

 private:
  static constexpr std::size_t kMostParts = 256;
  // Of texts that are read for one system: so nobody's file makes us large.
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;

  /// Those whose networks differ, the first of each.
  [[nodiscard]] std::vector<CompoundId> parts(const Net& net) const;
  [[nodiscard]] std::string name_of(const Net& net, CompoundId compound, const std::string& question) const;
  [[nodiscard]] std::string name_of_last(const Net& net, const std::string& question) const;
  void recall_below(const Net& net, CompoundId compound, const std::string& text, CachedProof& into);

  ContentCache& cache_;
  std::string origin_;
  Keeps keeps_;
  NetContent content_;
  std::size_t bytes_ = 0;                         // read
  std::unordered_map<std::string, u32> atom_at_;  // by path
};

}  // namespace bip::verify
