// Counts of a recorded run: steps by interaction and by component, and how long components were where.
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "compiler/traces/selection.hpp"

namespace bip::traces {

class RunStatistics {
 public:
  explicit RunStatistics(const Selection& selection) : selection_(selection) {}
  void begin(const rt::Core& core);
  /// After each step; counts those that are wanted.
  void step(const rt::Core& core, const TracedStep& step);
  /// {"steps": n, "wanted": n, "from": ns, "to": ns, "interactions": [{"interaction": path, "steps": n, "first": step,
  ///  "last": step}], "components": [{"component": path, "steps": n, "places": [{"place": name, "entered": n,
  ///  "steps": n, "ns": n}]}]}: the most frequent first. Places: of the whole run; ns only with time.
  [[nodiscard]] nlohmann::ordered_json json() const;
  /// The same as a table for people.
  [[nodiscard]] std::string text() const;

 private:
  struct Count {
    std::uint64_t steps = 0, first = 0, last = 0;
  };
  struct Place {
    std::uint64_t entered = 0, steps = 0;
    rt::i64 ns = 0;
  };
  struct Component {
    std::string path, place;
    std::uint64_t steps = 0, since_step = 0;
    rt::i64 since = 0;
    std::map<std::string, Place> places;
  };

  const Selection& selection_;
  bool is_timed_ = false;
  std::uint64_t steps_ = 0, wanted_ = 0;
  rt::i64 from_ = 0, to_ = 0, now_ = 0;
  std::map<std::string, Count> interactions_;
  std::map<rt::u32, Component> components_;
};

}  // namespace bip::traces
