// bip-mutate-certificates: proofs of small random systems are changed at random, and certcheck must not accept those
// whose clauses no longer suffice. Whether they do is found without it: all states that satisfy them are tried on the
// engine's core.
//
//   bip-mutate-certificates --from S --count N [--each N] [--states N] [--tell 1]
//
// N seeds, five systems each (a small net, locks, values passed on, counters, a model of tools/gen), up to three claims
// each, --each changes of every proof. Accepting too little is no fault, but is counted: what certcheck demands row by
// row may hold of all rows together only.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <sstream>

#include "compiler/interp/interp.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/evidence/counterexample_text.hpp"
#include "compiler/verify/evidence/reached_states.hpp"
#include "tests/verify/clauses.hpp"
#include "tests/verify/listed_states.hpp"
#include "tests/verify/mutation.hpp"
#include "tests/verify/random_property.hpp"
#include "tests/verify/small_net.hpp"
#include "tools/certcheck/checked_model.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/description.hpp"

namespace {

using namespace bip;
using verify::test::Worth;

struct Options {
  std::uint64_t from = 1, count = 20, each = 20;
  std::size_t states = 4000;
  bool tells = false;  // what certcheck refuses though it suffices
};
constexpr std::uint64_t kFewStates = 300;
enum class Told { Accepted, Rejected, NotCheckable };
struct Totals {
  unsigned long long lists = 0, proofs = 0, refused_proofs = 0, skipped = 0, same = 0;
  unsigned long long waits = 0, forged = 0;
  unsigned long long insufficient = 0, rejected = 0, not_checkable = 0, malformed = 0, sufficient = 0, accepted = 0,
                     failed = 0;
};

Told ask(const certcheck::Model& model, const std::string& text, std::string& why) {
  try {
    z3::context z;
    std::istringstream certificate(text);
    why = certcheck::check(model, certificate, z);
    return Told::Accepted;
  } catch (const certcheck::NotCheckable& e) {
    why = e.what();
    return Told::NotCheckable;
  } catch (const std::exception& e) {
    why = e.what();
    return Told::Rejected;
  }
}

class Run {
 public:
  Run(const Options& options, Totals& totals) : o_(options), t_(totals) {}

  void system(const std::string& name, const std::vector<std::string>& texts, std::uint64_t seed) {
    const gen::Compiled c = gen::compile_texts(texts);
    if (!c.problem.empty() || !c.system->code.functions.empty() || !c.system->code.ffi_types.empty()) return;
    const interp::Interpreter interpreter(*c.lowered);
    certcheck::Model model;
    try {
      certcheck::read_model(system::print(*c.system), model);
    } catch (const certcheck::NotCheckable&) {
      return;
    }
    verify::Question deadlock, errors, state;
    errors.what = verify::QuestionKind::NoErrors;
    state.what = verify::QuestionKind::State;
    Result<verify::Property> parsed = verify::parse_property(verify::test::random_property(*c.system, seed), *c.system);
    if (!parsed) return;
    state.property = std::move(*parsed);
    int number = 0;
    for (const verify::Question* question : {&deadlock, &errors, &state})
      one(c, model, *question, name + '-' + std::to_string(number++), seed);
    local_deadlock(c, model, name + "-local", seed);
  }

 private:
  void one(const gen::Compiled& c, const certcheck::Model& model, const verify::Question& question,
           const std::string& name, std::uint64_t seed) {
    verify::PortfolioLimits limits;
    limits.cancellation = verify::within_seconds(2);
    limits.may_search = false;
    limits.wants_certificate = true;
    verify::Portfolio portfolio(
        *c.system, c.lowered->image, verify::StateAccess::Searchable, [] { return true; },
        [](const char*, std::uint64_t, const char*) {});
    verify::Decision d = portfolio.decide(question, limits);
    if (d.outcome != verify::Outcome::Holds) return;
    const verify::SearchGoal goal = verify::goal_of(question);
    verify::test::Clauses clauses(*c.system, c.lowered->image);
    judge(
        model, name, verify::certificate(portfolio, question, d, *c.system, "Root()"),
        [&](const std::string& text) { return clauses.worth(text, goal, o_.states); },
        seed * 3 + static_cast<std::uint64_t>(question.what));

    // The same claim once more, by the states that a search reaches.
    const std::string rows = reached(c, portfolio, goal);
    if (rows.empty()) return;
    d.evidence = verify::ReachedStates{rows};
    ++t_.lists;
    judge(
        model, name + "-states", verify::certificate(portfolio, question, d, *c.system, "Root()"),
        [&](const std::string& text) {
          return verify::test::listed_worth(text, *c.system, c.lowered->image, goal, o_.states);
        },
        seed * 3 + static_cast<std::uint64_t>(question.what) + 1000003);
  }

  // The rows of all states that a search without such a goal reaches; empty: it does not end.
  static std::string reached(const gen::Compiled& c, verify::Portfolio& portfolio, const verify::SearchGoal& goal) {
    verify::StateCollector states(*c.system, c.lowered->image, 10'000'000);
    const verify::SearchLimits few{.cancellation = verify::within_seconds(2),
                                   .states = kFewStates,
                                   .report = {},
                                   .visit = [&](const rt::State& state) { states.add(state); }};
    const bool is_all = states.is_listable() && verify::search(portfolio.net(), c.lowered->image, goal, {}, few).end ==
                                                    verify::SearchEnd::Exhausted;
    return is_all ? states.rows() : std::string();
  }
  // Only the states are changed: a changed list must be refused if it is not closed under steps. If a component waits
  // for ever in a reachable state, every list must be refused.
  void local_deadlock(const gen::Compiled& c, const certcheck::Model& model, const std::string& name,
                      std::uint64_t seed) {
    verify::Question question;
    question.what = verify::QuestionKind::NoLocalDeadlock;
    verify::PortfolioLimits limits;
    limits.cancellation = verify::within_seconds(2);
    verify::Portfolio portfolio(
        *c.system, c.lowered->image, verify::StateAccess::Searchable, [] { return true; },
        [](const char*, std::uint64_t, const char*) {});
    const verify::Outcome outcome = portfolio.decide(question, limits).outcome;
    if (outcome == verify::Outcome::Unknown) return;
    const std::string rows = reached(c, portfolio, {});
    if (rows.empty()) return;
    const std::string text =
        verify::certificate_head(question, *c.system, "Root()") + "method induction\n" + rows + "end\n";
    if (outcome == verify::Outcome::Holds) {
      ++t_.waits;
      judge(
          model, name, text,
          [&](const std::string& changed) {
            return verify::test::listed_worth(changed, *c.system, c.lowered->image, {}, o_.states);
          },
          seed * 3 + 2000003);
      return;
    }
    ++t_.forged;
    std::string why;
    if (ask(model, text, why) == Told::Accepted) fail(name, "a component waits for ever, and yet: " + why, text);
  }

  void judge(const certcheck::Model& model, const std::string& name, const std::string& proof,
             const std::function<Worth(const std::string&)>& worth_of, std::uint64_t seed) {
    const Worth whole = worth_of(proof);
    if (whole == Worth::TooLarge) {
      ++t_.skipped;
      return;
    }
    ++t_.proofs;
    std::string why;
    if (whole != Worth::Suffices) fail(name, "the prover's own rows do not suffice", proof);
    if (ask(model, proof, why) != Told::Accepted) {
      ++t_.refused_proofs;
      if (o_.tells) std::printf("REFUSED %s: %s\n%s", name.c_str(), why.c_str(), proof.c_str());
      return;
    }
    gen::Prng random(seed);
    for (std::uint64_t k = 0; k < o_.each; ++k) {
      const std::string changed = verify::test::mutate(proof, random);
      if (changed == proof) {
        ++t_.same;
        continue;
      }
      const Worth worth = worth_of(changed);
      if (worth == Worth::TooLarge) continue;
      const Told told = ask(model, changed, why);
      if (worth == Worth::Suffices) {
        ++t_.sufficient;
        t_.accepted += told == Told::Accepted ? 1 : 0;
        if (o_.tells && told != Told::Accepted)
          std::printf("REFUSED %s, changed: %s\n%s", name.c_str(), why.c_str(), changed.c_str());
        continue;
      }
      ++(worth == Worth::Malformed ? t_.malformed : t_.insufficient);
      if (told == Told::Accepted) fail(name, "clauses that do not suffice are accepted: " + why, changed);
      if (worth == Worth::Insufficient) ++(told == Told::Rejected ? t_.rejected : t_.not_checkable);
    }
  }
  void fail(const std::string& name, const std::string& what, const std::string& proof) {
    ++t_.failed;
    std::printf("FAILED %s: %s\n%s", name.c_str(), what.c_str(), proof.c_str());
    std::fflush(stdout);
  }

  const Options& o_;
  Totals& t_;
};

}  // namespace

int main(int argc, char** argv) {
  Options o;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string flag = argv[i];
    const std::uint64_t value = std::strtoull(argv[i + 1], nullptr, 10);
    if (flag == "--from") o.from = value;
    else if (flag == "--count") o.count = value;
    else if (flag == "--each") o.each = value;
    else if (flag == "--states") o.states = value;
    else if (flag == "--tell") o.tells = value != 0;
  }
  Totals t;
  Run run(o, t);
  for (std::uint64_t seed = o.from; seed < o.from + o.count; ++seed) {
    run.system("net" + std::to_string(seed), {verify::test::small_net(seed)}, seed);
    run.system("locks" + std::to_string(seed), {verify::test::lock_net(seed)}, seed);
    run.system("values" + std::to_string(seed), {verify::test::value_net(seed)}, seed);
    run.system("counters" + std::to_string(seed), {verify::test::counter_net(seed)}, seed);
    run.system("model" + std::to_string(seed), gen::print_packages(gen::generate(seed)), seed);
  }
  std::printf(
      "proofs %llu (%llu of states, %llu more of states for local deadlocks, where %llu more do not hold; %llu "
      "refused, "
      "%llu more have too many states); changed so that they do not "
      "suffice: %llu (rejected %llu, not checkable %llu), no certificate any more: %llu; "
      "they still do: %llu (accepted %llu); nothing changed: %llu\n",
      t.proofs, t.lists, t.waits, t.forged, t.refused_proofs, t.skipped, t.insufficient, t.rejected, t.not_checkable,
      t.malformed, t.sufficient, t.accepted, t.same);
  std::printf("mutations: %llu passed, %llu failed\n", t.insufficient + t.malformed - t.failed, t.failed);
  return t.failed == 0 && t.insufficient > 0 && t.lists > 0 && t.waits > 0 && t.forged > 0 ? 0 : 1;
}
