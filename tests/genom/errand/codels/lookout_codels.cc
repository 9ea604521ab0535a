// Codels of lookout.
#include "aclookout.hpp"

#include <cmath>

extern "C" {

genom_event lookoutStart(uint32_t &looks, const genom_context) {
  looks = 0;
  return lookout_ether;
}

genom_event watchStart(const errands::spot &where, errands::weather weather, const errands::grid &size, const genom::bounded_string<8> &label,
                       const std::string &note, const std::optional<double> &limit, errands::spots &seen, std::string &summary,
                       std::array<double, 2> &area, uint32_t &looks, uint32_t &count, const genom_context self) {
  if (weather == errands::FOG) {
    watching::e_dark_detail d;
    d.weather = weather;
    d.since = "dawn";
    throw watching::e_dark(d);
  }
  if (where.name.empty()) return genom::raise(watching::e_nothing(), self);
  if (where.name == "elsewhere") throw std::runtime_error("lost on the way");
  if (where.x == 1000) return lookout_pause_start;  // until it is told to stop
  if (limit && std::hypot(where.x, where.y) > *limit) return genom::raise(genom::no_such_data(), self);
  seen.push_back(where);
  summary = label.str() + ": " + note + ", " + std::to_string(seen.size()) + " at " + where.name;
  area = {size[0] * size[1], size[0] + size[1]};
  count = ++looks;
  return lookout_ether;
}

genom_event stareStart(const genom_context) { return lookout_pause_start; }

genom_event reportStart(const genom::bounded_string<8> &name, std::vector<double> &times, std::string &told, const lookout_tally &tally,
                        const genom_context self) {
  errands::spot last;
  genom::bounded_string<16> verdict;
  if (const genom_event how = tally.call(name, times, last, verdict, self); how != genom_ok) return how;
  told = verdict.str() + " " + last.name + " " + std::to_string(last.x + last.y);
  return lookout_ether;
}
}
