// The launcher's side of what is said around a run of nodes on several hosts (runtime/distributed/greeting.hpp): it
// knocks until all are there, in whatever order they start, and welcomes each until it is in the run. What a person
// must know is printed on standard error, once.
#pragma once
#include <string>
#include <vector>

#include "runtime/core/time/interval.hpp"
#include "runtime/distributed/deployment.hpp"
#include "runtime/distributed/fabric.hpp"
#include "runtime/distributed/greeting.hpp"

namespace bip::rt {

class Gathering {
 public:
  static constexpr i64 kFirstKnock = 5000000;      // ns after the first knock; what connects meanwhile has not heard it
  static constexpr i64 kKnock = 100000000;         // ns between knocks at most
  static constexpr i64 kTellMissing = 3000000000;  // until missing nodes are reported

  /// `welcome` is sent to the nodes when all are present. The others must outlive it.
  Gathering(const Deployment& deployment, Fabric& fabric, Greeting welcome);

  [[nodiscard]] bool is_complete() const;
  /// Knocks, and welcomes again, where that is due.
  void tick(i64 now);
  [[nodiscard]] i64 due() const;
  /// Takes a greeting; other bytes are of a run that is over. Returns how the node is gone; empty: it is not.
  [[nodiscard]] std::string take(const Arrival& arrival, i64 now);
  /// All are there.
  void welcome(i64 now);
  /// The node has begun to take part.
  void note_in_run(u32 node) { guests_[node].is_in_run = true; }
  /// A line for a person.
  void tell(const std::string& text) const;

 private:
  struct Guest {
    bool is_there = false, is_in_run = false;
    bool is_refused = false;  // and that was reported
    u64 number = 0;           // of its answer
  };
  void tell_missing();

  const Deployment& deployment_;
  Fabric& fabric_;
  Greeting welcome_;
  bool is_welcoming_ = false;
  std::vector<Guest> guests_;  // by node; the first one is beside the launcher
  i64 next_ = 0, tell_at_ = 0, pause_ = kFirstKnock;
};

}  // namespace bip::rt
