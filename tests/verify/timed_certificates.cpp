// bip-timed-certificates: random timed systems of more kinds than test_timed.py has (broadcasts, rules, rendezvous that
// resume together, internal ports, two clocks; those of tools/gen: hierarchies, merged ports, Petri nets). certcheck
// must accept each zone graph for what it shows, and must not accept it for what it refutes. Certificates by pairs of
// like components, of systems that have such: pair_certificates.cpp.
//
//   bip-timed-certificates --from S --count N [--zones N] [--tell 1]
//
// What certcheck cannot follow (a chain of priorities beside urgency, faults in guards of connectors) is refused or not
// checkable, and counted; the same is so for bipc's refusals, which compiler/library makes.
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "compiler/interp/interp.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/evidence/reached_zones.hpp"
#include "runtime/explore/zones.hpp"
#include "tests/verify/pair_certificates.hpp"
#include "tests/verify/timed_systems.hpp"
#include "tools/certcheck/checked_model.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/description.hpp"

namespace {

using namespace bip;

struct Tally {
  unsigned long long systems = 0, left_out = 0, accepted = 0, refused = 0, not_checkable = 0, forged = 0, failed = 0;
};
enum class Answer { Accepted, Rejected, NotCheckable };

Answer ask(const std::string& bsys, const std::string& certificate, std::string& why) {
  try {
    certcheck::Model model;
    z3::context z;
    certcheck::read_model(bsys, model);
    std::istringstream text(certificate);
    why = certcheck::check(model, text, z);
    return Answer::Accepted;
  } catch (const certcheck::NotCheckable& e) {
    why = e.what();
    return Answer::NotCheckable;
  } catch (const std::exception& e) {
    why = e.what();
    return Answer::Rejected;
  }
}

void check(const std::vector<std::string>& texts, std::uint64_t seed, std::uint64_t zones, bool tells, Tally& tally) {
  const gen::Compiled c = gen::compile_texts(texts);
  if (!c.problem.empty() || !system::is_timed(*c.system) || !c.system->code.functions.empty()) return;
  const interp::Interpreter interpreter(*c.lowered);
  const std::string bsys = system::print(*c.system);
  verify::ZoneCollector rows(*c.system, c.lowered->image, {}, 10'000'000);
  rt::ExploreOptions options;
  options.limit = zones;
  const rt::ZoneReport found =
      rt::explore_zones(c.lowered->image, options, [&](const rt::ListedLocation& location) { rows.add(location); });
  const std::string listed = std::move(rows).rows();
  if (found.end != rt::ExploreEnd::Complete || !found.inexact.empty() || !rows.problem().empty() || listed.empty()) {
    ++tally.left_out;
    return;
  }
  ++tally.systems;
  const auto claim = [&](verify::QuestionKind what, bool is_true) {
    verify::Question question;
    question.what = what;
    const std::string text =
        verify::certificate_head(question, *c.system, "Root()") + "method zones\n" + listed + "end\n";
    std::string why;
    const Answer answer = ask(bsys, text, why);
    if (answer == Answer::NotCheckable) ++tally.not_checkable;
    if (!is_true) {
      ++tally.forged;
      tally.failed += answer == Answer::Accepted ? 1 : 0;
      if (answer == Answer::Accepted)
        std::printf("FAILED seed %llu: accepted: %s\n", static_cast<unsigned long long>(seed), why.c_str());
    } else if (answer == Answer::Accepted) {
      ++tally.accepted;
    } else {
      ++tally.refused;
    }
    const bool is_shown = is_true ? tells && answer != Answer::Accepted : answer == Answer::Accepted;
    if (!is_shown) return;
    std::printf("seed %llu: %s\n%s", static_cast<unsigned long long>(seed), why.c_str(), text.c_str());
    for (const std::string& part : texts) std::printf("%s\n", part.c_str());
  };
  claim(verify::QuestionKind::DeadlockFreedom, !found.has_deadlock && !found.has_time_lock);
  claim(verify::QuestionKind::NoErrors, !found.has_error);
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t from = 1, count = 200, zones = 400;
  bool tells = false;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string flag = argv[i];
    const std::uint64_t value = std::strtoull(argv[i + 1], nullptr, 10);
    if (flag == "--from") from = value;
    else if (flag == "--count") count = value;
    else if (flag == "--zones") zones = value;
    else if (flag == "--tell") tells = value != 0;
  }
  Tally written, generated;
  verify::test::PairTally pairs;
  for (std::uint64_t seed = from; seed < from + count; ++seed) {
    check({rt::testing::random_timed_system(seed, seed % 2)}, seed, zones, tells, written);
    check(gen::print_packages(gen::generate(seed, gen::Features::Timed)), seed, zones, tells, generated);
    verify::test::check_pair_certificates(seed, tells, pairs);
  }
  const auto print = [](const char* name, const Tally& t) {
    std::printf(
        "%s: %llu systems (%llu more left out); accepted %llu, refused %llu; forged claims %llu, accepted %llu; "
        "not checkable %llu\n",
        name, t.systems, t.left_out, t.accepted, t.refused, t.forged, t.failed, t.not_checkable);
  };
  print("small systems", written);
  print("of tools/gen", generated);
  std::printf(
      "by pairs: %llu systems; proofs %llu, accepted %llu; forged claims %llu; changed so that a state is missing "
      "%llu, "
      "others %llu; failed %llu\n",
      pairs.systems, pairs.proofs, pairs.accepted, pairs.forged, pairs.changed, pairs.same, pairs.failed);
  const bool is_enough =
      count < 50 || (written.accepted > count / 4 && written.forged > count / 4 && generated.systems > 0 &&
                     pairs.accepted > count / 2 && pairs.forged > count / 4 && pairs.changed > count);
  const unsigned long long failed = written.failed + generated.failed + pairs.failed + (is_enough ? 0 : 1);
  std::printf("timed zones: %llu passed, %llu failed\n", written.accepted + generated.accepted + pairs.accepted,
              failed);
  return failed == 0 ? 0 : 1;
}
