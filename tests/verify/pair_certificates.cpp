// Certificates by pairs of like components, of random systems. certcheck must accept what the prover writes; must not
// accept the states of two components for a claim that the zone graph of the whole refutes, nor for a system that does
// not treat all alike; and must not accept a changed certificate that misses a state which a run of the engine's core
// has met. For that the rows are read once more here, and each two processes of each such state are looked up in them.
#include "tests/verify/pair_certificates.hpp"

#include <charconv>
#include <cstdio>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "compiler/interp/interp.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/timed/prove_pairs.hpp"
#include "runtime/explore/follow_path.hpp"
#include "tests/verify/pair_systems.hpp"
#include "tools/certcheck/checked_model.hpp"
#include "tools/gen/compiled.hpp"

namespace bip::verify::test {

namespace {

constexpr int kMutations = 12, kRuns = 40, kEvents = 60;
// True of all states, so that the certificate has all states of a pair.
constexpr const char* kAlways = "never row.a[0]@S0 && row.a[0]@S1";

rt::PartReport explore_local(const System& part, const rt::ExploreOptions& options, const rt::PartQuestion& question) {
  const std::unique_ptr<lower::LoweredSystem> lowered = lower::lower(part, "part");
  const interp::Interpreter interpreter(*lowered);
  return rt::explore_part(lowered->image, options, question);
}

bool is_accepted(const std::string& bsys, const std::string& certificate, std::string& why) {
  try {
    certcheck::Model model;
    z3::context z;
    certcheck::read_model(bsys, model);
    std::istringstream text(certificate);
    why = certcheck::check(model, text, z);
    return true;
  } catch (const std::exception& e) {
    why = e.what();
    return false;
  }
}

// A state of the whole, by atom: the processes, then the component in the middle.
struct Point {
  std::vector<std::string> places;
  std::vector<std::int64_t> numbers, clocks;
  friend auto operator<=>(const Point&, const Point&) = default;
};

Point point_of(const System& system, const rt::Core& core) {
  Point point;
  for (std::uint32_t a = 0; a < system.atoms.size(); ++a) {
    const AtomType& type = system.atom_types[system.atoms[AtomId(std::size_t{a})].type];
    for (std::uint32_t place = 0; place < type.places.size(); ++place) {
      if (core.is_marked(a, place)) point.places.push_back(type.places[place]);
    }
    std::uint32_t n = 0;
    while (type.variables[n].name != "n") ++n;
    point.numbers.push_back(core.cell(core.image().atoms[a].variable(static_cast<rt::u32>(n))).i);
    point.clocks.push_back(static_cast<std::int64_t>(core.time().clock_value(a, 0)));
  }
  return point;
}

// Of random runs, tick by tick.
std::set<Point> points_of_runs(const gen::Compiled& c, std::uint64_t seed) {
  std::set<Point> points;
  rt::Prng random(seed);
  for (int run = 0; run < kRuns; ++run) {
    rt::Core core(c.lowered->image);
    bool goes_on = rt::begins(core);
    for (int event = 0; event < kEvents && goes_on; ++event) {
      points.insert(point_of(*c.system, core));
      const std::uint64_t count = core.candidate_count();
      const bool takes = count != 0 && random.below(3) != 0;
      goes_on = takes ? core.time().take(core.position(random.below(count))) : rt::let_time_pass(core, core.now() + 1);
    }
  }
  return points;
}

// What a certificate says, read once more.
class Reading {
 public:
  explicit Reading(const std::string& certificate) {
    std::map<std::string, std::string> said;
    std::vector<Zone>* zones = nullptr;
    std::istringstream lines(certificate);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string head, word;
      words >> head;
      if (head == "pair") {
        while (words >> word) holders_.insert(word);
      } else if (head == "state") {
        while (words >> word) {
          const std::size_t mark = word.find_first_of("@=");
          said[word.substr(0, mark)] = mark == std::string::npos ? "" : word.substr(mark + 1);
        }
        zones = &rows_[said];
      } else if (head == "zone" && zones != nullptr) {
        Zone& zone = zones->emplace_back();
        while (words >> word) zone.push_back(word);
      }
    }
  }

  // Are processes i and j of the point, with the component in the middle, in it?
  [[nodiscard]] bool has(const Point& point, std::size_t i, std::size_t j) const {
    const std::size_t middle = point.places.size() - 1;
    std::map<std::string, std::string> said;
    std::map<std::string, std::int64_t> clocks;
    const auto tell = [&](const std::string& path, std::size_t atom, const std::string& clock) {
      said[path] = point.places[atom];
      const std::int64_t number = point.numbers[atom];
      const bool is_number =
          holders_.contains(path + ".n") && number >= 1 && number <= static_cast<std::int64_t>(middle);
      const std::int64_t told = !is_number                                   ? number
                                : number == static_cast<std::int64_t>(i) + 1 ? 1
                                : number == static_cast<std::int64_t>(j) + 1 ? 2
                                                                             : 3;
      said[path + ".n"] = std::to_string(told);
      said[path + ".resume"] = said[path + ".resume-with"] = "0";
      clocks[path + "." + clock] = point.clocks[atom];
    };
    tell("ROOT.row.a[0]", i, "x");
    tell("ROOT.row.a[1]", j, "x");
    tell("ROOT.row.m", middle, "y");
    for (const auto& [state, zones] : rows_) {
      const bool is_it = std::all_of(state.begin(), state.end(), [&](const auto& word) {
        const auto found = said.find(word.first);
        return found != said.end() && found->second == word.second;
      });
      if (is_it && std::any_of(zones.begin(), zones.end(), [&](const Zone& zone) { return is_in(zone, clocks); }))
        return true;
    }
    return false;
  }
  [[nodiscard]] bool misses(const std::set<Point>& points) const {
    return std::any_of(points.begin(), points.end(), [&](const Point& point) {
      const std::size_t processes = point.places.size() - 1;
      for (std::size_t i = 0; i < processes; ++i) {
        for (std::size_t j = 0; j < processes; ++j) {
          if (i != j && !has(point, i, j)) return true;
        }
      }
      return false;
    });
  }

 private:
  using Zone = std::vector<std::string>;  // "ROOT.row.a[0].x<=3", "ROOT.row.a[0].x-ROOT.row.m.y<=3"

  static bool is_in(const Zone& zone, const std::map<std::string, std::int64_t>& clocks) {
    return std::all_of(zone.begin(), zone.end(), [&](const std::string& bound) {
      const std::size_t equal = bound.find('=');
      if (equal == std::string::npos || equal == 0) return false;
      const std::string names = bound.substr(0, equal - 1);
      const std::size_t minus = names.find('-');
      std::int64_t limit = 0;
      (void)std::from_chars(bound.data() + equal + 1, bound.data() + bound.size(), limit);
      const auto clock = clocks.find(names.substr(0, minus));
      const auto other = minus == std::string::npos ? clocks.end() : clocks.find(names.substr(minus + 1));
      if (clock == clocks.end() || (minus != std::string::npos && other == clocks.end())) return false;
      const std::int64_t value = clock->second - (other == clocks.end() ? 0 : other->second);
      return bound[equal - 1] == '<' ? value <= limit : value >= limit;
    });
  }

  std::set<std::string> holders_;
  std::map<std::map<std::string, std::string>, std::vector<Zone>> rows_;
};

// A row lost, a word lost, a number off by one.
std::string changed(const std::string& certificate, rt::Prng& random) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> open;
  std::istringstream lines(certificate);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    rows.emplace_back();
    for (std::string word; words >> word;) rows.back().push_back(word);
    const std::string& head = rows.back()[0];
    if (head == "state" || head == "zone" || (head == "pair" && rows.back().size() > 3))
      open.push_back(rows.size() - 1);
  }
  std::vector<std::string>& row = rows[open[random.below(open.size())]];
  const std::size_t first = row[0] == "pair" ? 3 : 1;
  const std::uint64_t kind = random.below(5);
  if (row.size() <= first || (kind == 0 && first == 1)) {
    row.clear();
  } else {
    const std::size_t at = first + random.below(row.size() - first);
    const std::size_t digits = row[at].find_last_not_of("0123456789") + 1;
    if (kind == 1 || digits == row[at].size()) {
      row.erase(row.begin() + static_cast<long>(at));
    } else {
      const int number = std::stoi(row[at].substr(digits)) + (random.below(2) == 0 ? 1 : -1);
      row[at] = row[at].substr(0, digits) + std::to_string(std::max(number, 0));
    }
  }
  std::string out;
  for (const std::vector<std::string>& words : rows) {
    for (std::size_t k = 0; k < words.size(); ++k) out += (k == 0 ? "" : " ") + words[k];
    if (!words.empty()) out += '\n';
  }
  return out;
}

// The text with the last process in one connector more.
std::string with_another_connector(std::string text, std::uint64_t processes) {
  const std::size_t end = text.find("  end\n  compound type Root()");
  return text.insert(end, "    connector Two more(a[" + std::to_string(processes - 1) + "].p, m.q)\n");
}

}  // namespace

void check_pair_certificates(std::uint64_t seed, bool tells, PairTally& tally) {
  PairSystemWriter writer(seed);
  const std::uint64_t processes = 3 + seed % 2;
  const std::string text = writer.model(processes), wanted = writer.property();
  const gen::Compiled c = gen::compile_texts({text});
  if (!c.problem.empty()) return;
  const interp::Interpreter interpreter(*c.lowered);
  const std::string bsys = system::print(*c.system);
  ++tally.systems;
  const auto fail = [&](const std::string& what, const std::string& certificate) {
    ++tally.failed;
    std::printf("FAILED seed %llu: %s\n%s%s", static_cast<unsigned long long>(seed), what.c_str(), certificate.c_str(),
                text.c_str());
  };
  std::string why;
  const auto certificate_of = [&](const std::string& asked, const std::string& claim) {
    Question question, claimed;
    question.what = claimed.what = QuestionKind::State;
    Result<Property> property = parse_property(asked, *c.system), other = parse_property(claim, *c.system);
    if (!property || !other) return std::string();
    question.property = std::move(*property);
    claimed.property = std::move(*other);
    const TimeProof proof =
        prove_state_by_pairs(*c.system, question.property, explore_local, within_seconds(20), {}, 10'000'000);
    if (!proof.is_proved || proof.rows.empty()) return std::string();
    return certificate_head(claimed, *c.system, "Root()") + "method pairs\n" + proof.rows + "end\n";
  };
  rt::ExploreOptions options;
  options.limit = 20000;
  Result<Property> property = parse_property(wanted, *c.system);
  if (!property) return;
  options.predicate = [&](const rt::Core& core) { return is_broken(*property, core); };
  const rt::ZoneReport whole = rt::explore_zones(c.lowered->image, options);

  for (const std::string& asked : {wanted, std::string(kAlways)}) {
    const std::string proof = certificate_of(asked, asked);
    if (proof.empty()) continue;
    ++tally.proofs;
    if (is_accepted(bsys, proof, why)) ++tally.accepted;
    else fail("not accepted: " + why, proof);
    const gen::Compiled other = gen::compile_texts({with_another_connector(text, processes)});
    if (other.problem.empty() && is_accepted(system::print(*other.system), proof, why))
      fail("accepted of a system that does not treat all alike: " + why, proof);
  }
  const std::string states = certificate_of(kAlways, kAlways);
  if (states.empty()) return;
  if (whole.has_match) {
    ++tally.forged;
    const std::string forged = certificate_of(kAlways, wanted);
    if (is_accepted(bsys, forged, why)) fail("a claim that is false is accepted: " + why, forged);
  }
  const std::set<Point> points = points_of_runs(c, seed);
  if (Reading(states).misses(points)) fail("a state of a run is not in the certificate", states);
  rt::Prng random(seed);
  for (int k = 0; k < kMutations; ++k) {
    const std::string other = changed(states, random);
    if (!Reading(other).misses(points)) {
      ++tally.same;
      continue;
    }
    ++tally.changed;
    if (is_accepted(bsys, other, why)) fail("accepted without a state of a run: " + why, other);
    else if (tells) std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), why.c_str());
  }
}

}  // namespace bip::verify::test
