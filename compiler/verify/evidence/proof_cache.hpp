// The proof cache: stores proofs from run to run, of a whole system and of each compound in it, named by the content of
// the network (net_content.hpp) and by the question. So the proof of a compound that has not changed is found again in
// any system.
//
// If the very system is cached, all of its proof is recalled; else the rows about unchanged components in the last
// proof of a system with a root of that name, and those of equal compounds. The caller checks all of it: a file may be
// old, of another system, or forged. Cost: hashing the network, and at most kMaxParts files.
#pragma once
#include <unordered_map>

#include "compiler/base/content_cache.hpp"
#include "compiler/verify/evidence/cached_proof.hpp"
#include "compiler/verify/net/net_content.hpp"

namespace bip::verify {

struct ReuseCounts {
  bool is_whole = false;     // the very system is in the cache
  std::size_t files = 0;     // that were read and could be used
  std::size_t recalled = 0;  // rows in them: invariants, equations, lemmas, counterexamples
  // Those rows that were checked and hold.
  std::size_t invariants = 0, equations = 0, lemmas = 0;
  bool has_counterexample = false;
  std::size_t stored = 0;  // files
};

/// Which proofs are stored. Expensive: only those that take longer to find than to read.
enum class StorePolicy : std::uint8_t { Expensive, All };

class ProofCache {
 public:
  /// Refers to `cache`, which must outlive it. `origin` names whose proofs they are: others are not read.
  ProofCache(ContentCache& cache, std::string origin, StorePolicy policy = StorePolicy::Expensive)
      : cache_(cache), origin_(std::move(origin)), policy_(policy) {}

  /// Returns what is cached about the question, unchecked, and resets `counts`. Unreadable files count as absent.
  [[nodiscard]] CachedProof recall(const Net& net, const std::string& question);
  /// Stores a proof about the system last recalled, and its rows by compound. A file that cannot be written is no
  /// error; `counts.stored` says how many were.
  void store(const Net& net, const std::string& question, const CachedProof& proof);

  [[nodiscard]] StorePolicy policy() const { return policy_; }
  [[nodiscard]] std::size_t broken_files() const { return cache_.broken().size(); }
  ReuseCounts counts;

 private:
  static constexpr std::size_t kMaxParts = 256;
  // Of texts that are read for one system: bounds the memory that an untrusted cache file can claim.
  static constexpr std::size_t kMaxBytes = std::size_t{64} << 20;

  /// Returns the compounds below the root whose networks differ, the first of each kind.
  [[nodiscard]] std::vector<CompoundId> parts(const Net& net) const;
  [[nodiscard]] std::string name_of(const Net& net, CompoundId compound, const std::string& question) const;
  [[nodiscard]] std::string name_of_last(const Net& net, const std::string& question) const;
  void recall_below(const Net& net, CompoundId compound, const std::string& text, CachedProof& into);

  ContentCache& cache_;
  std::string origin_;
  StorePolicy policy_;
  NetContent content_;
  std::size_t bytes_ = 0;                         // read
  std::unordered_map<std::string, u32> atom_at_;  // by path
};

}  // namespace bip::verify
