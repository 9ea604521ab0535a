// bip-verify-check: random systems, each asked three questions (deadlock, run-time errors, a random property), the
// prover's verdicts against a visit of all states.
//
//   bip-verify-check --from S --count N [--states N] [--seconds S] [--out DIR] [--sort nets|models|sizes|equal|levels]
//
// Of every fourth seed (--sort sizes: of all) a system with an array is asked, too, and answered by what small
// instances of it teach; a proof must agree with the visit.
//
// Of every fourth seed (--sort equal: of all) a system with equal components is asked, and answered by searches up to
// symmetry: their verdicts must be those of the visit of all states. So must proofs by counting, of these systems and
// of voters and candidates who count votes (tests/verify/quorum_net.hpp).
//
// Of every fourth seed (--sort levels: of all) processes that wait for each other level by level are asked, and
// answered by regions of values alone, as all other systems are, too: what these prove must hold in all states.
//
// Of every fifth seed the questions are asked again with kept proofs: as they were left, damaged, and forged under a
// right hash. Answers must be the same; what forged proofs led to is given to certcheck, too.
//
// Two provers a question: one without search, whose proofs and replayed ways must agree with the visit; and the whole
// one, which should have an answer. With --out each proof of a system leaves N.bsys, N.cert for certcheck. --print DIR
// writes all systems there, as .bsys, and asks nothing.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <vector>

#include "compiler/interp/interp.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/verify/portfolio/counted_property.hpp"
#include "compiler/verify/portfolio/counting_engine.hpp"
#include "compiler/verify/property/formula.hpp"
#include "compiler/verify/evidence/certificate.hpp"
#include "compiler/verify/evidence/counterexample_text.hpp"
#include "compiler/verify/portfolio/local_deadlock_search.hpp"
#include "compiler/verify/portfolio/induction_engines.hpp"
#include "compiler/verify/portfolio/local_lemma_engine.hpp"
#include "compiler/verify/portfolio/region_engine.hpp"
#include "compiler/verify/portfolio/search_engines.hpp"
#include "compiler/verify/portfolio/search_symmetry.hpp"
#include "compiler/verify/portfolio/small_instance_engine.hpp"
#include "tests/verify/level_net.hpp"
#include "tests/verify/quorum_net.hpp"
#include "tests/verify/random_property.hpp"
#include "tests/verify/relevance_oracle.hpp"
#include "tests/verify/sized_net.hpp"
#include "tests/verify/small_net.hpp"
#include "tests/verify/symmetric_net.hpp"
#include "tests/verify/tampering.hpp"
#include "tests/verify/waiting_oracle.hpp"
#include "tools/gen/compiled.hpp"
#include "tools/gen/description.hpp"

namespace {

using namespace bip;

struct Options {
  std::uint64_t from = 1, count = 100, states = 5000;
  double seconds = 1;
  std::string out, print;
  bool nets = true, models = true, sizes = true, equal = true, levels = true;
};
struct Totals {
  std::uint64_t systems = 0, questions = 0, too_large = 0, holds = 0, violated = 0, open_proofs = 0, unknown = 0,
                failed = 0, certificates = 0;
  std::uint64_t decided = 0;                  // answers of the prover
  std::uint64_t learnt = 0, learnt_from = 0;  // proofs by small instances; questions
  std::uint64_t local = 0;                    // proofs by local lemmas
  std::uint64_t of_pairs = 0;                 // and by lemmas about pairs
  // Searches up to symmetry; those that permuted components, and how many of these found a bad state; states, and those
  // that were saved.
  std::uint64_t symmetric = 0, permuted = 0, permuted_violated = 0, orbits = 0, orbits_saved = 0;
  std::uint64_t permuted_stuck = 0;
  // Properties with quantifiers; those whose first conditions were asked; the violated ones of these.
  std::uint64_t counted = 0, counted_few = 0, counted_violated = 0;
  // Questions about voters; those that hold; proofs of these by counting, and of other systems with equal components.
  std::uint64_t votes = 0, votes_hold = 0, by_counting = 0, equal_by_counting = 0;
  // Questions about levels; those that hold; proofs of these by regions of values, and of other systems.
  std::uint64_t levels = 0, levels_hold = 0, by_regions = 0, certified_by_regions = 0, others_by_regions = 0;
  std::uint64_t reused = 0, whole = 0, rows = 0, forged_rows = 0;
  verify::test::RelevanceCounts relevance;
};

class Check {
 public:
  Check(const Options& options, Totals& totals) : o_(options), t_(totals) {
    std::string name = (std::filesystem::temp_directory_path() / "bip-verify-check-XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) kept_ = name;
  }
  ~Check() {
    std::error_code ignored;
    if (!kept_.empty()) std::filesystem::remove_all(kept_, ignored);
  }
  Check(const Check&) = delete;
  Check& operator=(const Check&) = delete;

  void system(const std::string& name, const std::vector<std::string>& texts, std::uint64_t seed) {
    name_ = name;
    wants_certificate_ = seed % 2 == 0;
    seed_ = seed;
    const gen::Compiled c = gen::compile_texts(texts);
    if (!is_compiled(c)) return;
    // What C++ remembers is outside of a state: there is no visit to compare with.
    if (!c.system->code.functions.empty() || !c.system->code.ffi_types.empty()) return;
    ++t_.systems;
    if (!o_.print.empty()) {
      std::ofstream(o_.print + '/' + name + ".bsys") << system::print(*c.system);
      return;
    }
    const interp::Interpreter interpreter(*c.lowered);
    verify::Question deadlock, errors, state;
    errors.what = verify::QuestionKind::NoErrors;
    state.what = verify::QuestionKind::State;
    const std::string property = verify::test::random_property(*c.system, seed);
    std::optional<verify::Property> parsed = read_property(property, *c.system);
    if (!parsed) return;
    state.property = std::move(*parsed);
    int number = 0;
    for (const verify::Question* question : {&deadlock, &errors, &state})
      one(c, *question, name + '-' + std::to_string(number++));
  }

  // A system with equal components: searches up to symmetry against a visit of all states.
  void equal(const std::string& name, std::uint64_t seed) {
    name_ = name;
    const verify::test::SymmetricNet net = verify::test::symmetric_net(seed);
    const gen::Compiled c = gen::compile_texts({net.text});
    if (!is_compiled(c)) return;
    ++t_.systems;
    const interp::Interpreter interpreter(*c.lowered);
    std::vector<std::string> asked{"deadlock", "errors"};
    asked.insert(asked.end(), net.properties.begin(), net.properties.end());
    for (std::size_t number = 0; number < asked.size(); ++number) {
      verify::Question question;
      question.what = number == 0   ? verify::QuestionKind::DeadlockFreedom
                      : number == 1 ? verify::QuestionKind::NoErrors
                                    : verify::QuestionKind::State;
      if (question.what == verify::QuestionKind::State) {
        std::optional<verify::Property> parsed = read_property(asked[number], *c.system);
        if (!parsed) return;
        question.property = std::move(*parsed);
      }
      search_up_to_symmetry(c, question, asked[number]);
    }
    for (const std::string& counted : net.counted) ask_first_conditions(c, counted);
    wait_up_to_symmetry(c);
  }

  // Voters and candidates: proofs by counting against a visit of all states.
  void quorum(const std::string& name, std::uint64_t seed) {
    name_ = name;
    const verify::test::QuorumNet net = verify::test::quorum_net(seed);
    const gen::Compiled c = gen::compile_texts({net.text});
    if (!is_compiled(c)) return;
    ++t_.systems;
    const interp::Interpreter interpreter(*c.lowered);
    // Of some systems only a few proofs are written; the name ends as test_verify.sh wants it.
    const std::string file = name + "-";
    int number = 0;
    for (const std::string& asked : net.properties) {
      std::optional<verify::Property> parsed = read_property(asked, *c.system);
      if (!parsed) return;
      verify::Question question;
      question.what = verify::QuestionKind::State;
      question.property = std::move(*parsed);
      const std::optional<bool> holds = holds_in_all_states(c, question);
      if (!holds) continue;
      ++t_.votes;
      t_.votes_hold += *holds ? 1 : 0;
      t_.by_counting += is_proved_by_counting(c, question, asked, *holds, file + std::to_string(number++)) ? 1 : 0;
      t_.others_by_regions += is_proved_by_regions(c, question, asked, *holds) ? 1 : 0;
    }
  }

  // Processes and levels: proofs by regions of values against a visit of all states.
  void levels(const std::string& name, std::uint64_t seed) {
    name_ = name;
    const verify::test::LevelNet net = verify::test::level_net(seed);
    const gen::Compiled c = gen::compile_texts({net.text});
    if (!is_compiled(c)) return;
    ++t_.systems;
    const interp::Interpreter interpreter(*c.lowered);
    std::vector<std::string> asked{""};
    asked.insert(asked.end(), net.properties.begin(), net.properties.end());
    for (const std::string& property : asked) {
      verify::Question question;
      if (!property.empty()) {
        std::optional<verify::Property> parsed = read_property(property, *c.system);
        if (!parsed) return;
        question.what = verify::QuestionKind::State;
        question.property = std::move(*parsed);
      }
      const std::optional<bool> holds = holds_in_all_states(c, question);
      if (!holds) continue;
      ++t_.levels;
      t_.levels_hold += *holds ? 1 : 0;
      const std::string named = property.empty() ? "deadlock" : property;
      t_.by_regions += is_proved_by_regions(c, question, named, *holds) ? 1 : 0;
      const std::string file = name + '-' + static_cast<char>('0' + (&property - asked.data()));
      t_.certified_by_regions += is_proved_by_regions(c, question, named, *holds, file) ? 1 : 0;
    }
  }

  // A system whose array is longer than those that it is learnt from.
  void sized(const std::string& name, std::uint64_t seed) {
    constexpr std::uint32_t kSize = 6;
    name_ = name;
    const gen::Compiled c = gen::compile_texts({verify::test::sized_net(seed, kSize)});
    if (!is_compiled(c)) return;
    ++t_.systems;
    const interp::Interpreter interpreter(*c.lowered);
    std::vector<std::unique_ptr<gen::Compiled>> made;
    const verify::SmallInstances instances = [&](std::uint32_t size) -> std::optional<verify::SmallInstance> {
      if (size >= kSize) return std::nullopt;
      made.push_back(std::make_unique<gen::Compiled>(gen::compile_texts({verify::test::sized_net(seed, size)})));
      if (!made.back()->problem.empty()) return std::nullopt;
      return verify::SmallInstance{made.back()->system.get(), &made.back()->lowered->image};
    };
    // Deadlock, and properties of which some should hold.
    constexpr std::uint64_t kProperties = 6;
    for (std::uint64_t number = 0; number <= kProperties; ++number) {
      verify::Question question;
      std::string asked = "deadlock";
      if (number != 0) {
        question.what = verify::QuestionKind::State;
        asked = verify::test::random_property(*c.system, seed * kProperties + number);
        std::optional<verify::Property> parsed = read_property(asked, *c.system);
        if (!parsed) return;
        question.property = std::move(*parsed);
      }
      const verify::Net net = verify::build_net(*c.system);
      const verify::SearchLimits limits{
          .cancellation = verify::within_seconds(20), .megabytes = 1000, .states = o_.states, .report = {}};
      const verify::SearchResult all = verify::search(net, c.lowered->image, verify::goal_of(question), {}, limits);
      // Most are broken, which small instances show as well: a few of these suffice.
      if (all.end == verify::SearchEnd::Found && number % 3 != 0) continue;
      verify::SystemParts parts(*c.system, c.lowered->image, verify::StateAccess::Searchable, [] { return true; });
      verify::PortfolioLimits few;
      few.cancellation = verify::within_seconds(o_.seconds);
      few.megabytes = 1000;
      const verify::Report report = [](const char*, std::uint64_t, const char*) {};
      verify::ProofContext context{parts, question, few, report, nullptr, {}, {}};
      context.small_instances = &instances;
      if (parts.has_usable_net()) context.facts.proof = verify::find_reachable_modes(parts.net());
      const bool is_local =
          verify::kLocalLemmaEngine.attempt(context, {}, few.cancellation).outcome == verify::Outcome::Holds;
      t_.local += is_local ? 1 : 0;
      if (is_local && all.end == verify::SearchEnd::Found)
        fail(asked + ": proved by local lemmas, but a bad state is reachable");
      const bool is_of_pairs =
          verify::kPairLemmaEngine.attempt(context, {}, few.cancellation).outcome == verify::Outcome::Holds;
      t_.of_pairs += is_of_pairs ? 1 : 0;
      if (is_of_pairs && all.end == verify::SearchEnd::Found)
        fail(asked + ": proved by lemmas about pairs, but a bad state is reachable");
      const verify::EngineResult found = verify::kSmallInstanceEngine.attempt(context, {}, few.cancellation);
      ++t_.learnt_from;
      if (found.outcome != verify::Outcome::Holds) continue;
      const auto* const proof = std::get_if<verify::InductiveProof>(&found.evidence);
      t_.learnt += proof != nullptr && !proof->lemmas.empty() ? 1 : 0;
      if (all.end == verify::SearchEnd::Found)
        fail(asked + ": proved by small instances, but a bad state is reachable");
    }
  }

 private:
  void fail(const std::string& what) {
    ++t_.failed;
    std::printf("FAILED %s: %s\n", name_.c_str(), what.c_str());
    std::fflush(stdout);
  }

  // Each of the two says what failed.
  bool is_compiled(const gen::Compiled& c) {
    if (!c.problem.empty()) fail("does not compile: " + c.problem);
    return c.problem.empty();
  }
  std::optional<verify::Property> read_property(const std::string& text, const System& system) {
    Result<verify::Property> parsed = verify::parse_property(text, system);
    if (parsed) return std::move(*parsed);
    fail("property `" + text + "`: " + parsed.error());
    return std::nullopt;
  }

  // Nothing: the states are too many, which is counted.
  std::optional<bool> holds_in_all_states(const gen::Compiled& c, const verify::Question& question) {
    const verify::SearchResult all = verify::search(verify::build_net(*c.system), c.lowered->image,
                                                    verify::goal_of(question), {}, limits_of_visit());
    if (all.end != verify::SearchEnd::Limit) return all.end == verify::SearchEnd::Exhausted;
    ++t_.too_large;
    return std::nullopt;
  }
  verify::SearchLimits limits_of_visit() const {
    return {.cancellation = verify::within_seconds(20), .megabytes = 1000, .states = o_.states, .report = {}};
  }

  void search_up_to_symmetry(const gen::Compiled& c, const verify::Question& question, const std::string& asked) {
    const verify::Net net = verify::build_net(*c.system);
    const rt::Image& image = c.lowered->image;
    const verify::SearchResult all = verify::search(net, image, verify::goal_of(question), {}, limits_of_visit());
    if (all.end == verify::SearchEnd::Limit) {
      ++t_.too_large;
      return;
    }
    verify::SystemParts parts(*c.system, image, verify::StateAccess::Searchable, [] { return true; });
    verify::PortfolioLimits few;
    few.cancellation = verify::within_seconds(20);
    few.megabytes = 1000;
    const verify::Report report = [](const char*, std::uint64_t, const char*) {};
    verify::ProofContext context{parts, question, few, report, nullptr, {}, {}};
    const verify::EngineResult found = verify::kExhaustiveEngine.attempt(context, {}, few.cancellation);
    const bool is_violated = all.end == verify::SearchEnd::Found;
    ++t_.symmetric;
    if (!found.permuted.empty()) {
      ++t_.permuted;
      t_.permuted_violated += is_violated ? 1 : 0;
      if (!is_violated && found.states) {
        t_.orbits += *found.states;
        t_.orbits_saved += all.states - std::min(all.states, *found.states);
      }
    }
    if (found.outcome == verify::Outcome::Unknown) fail(asked + ": no answer up to symmetry: " + found.reason);
    else if ((found.outcome == verify::Outcome::Violated) != is_violated)
      fail(asked + (is_violated ? ": holds up to symmetry, but a bad state is reachable"
                                : ": violated up to symmetry, but all states are fine"));
    if (question.what == verify::QuestionKind::State)
      t_.equal_by_counting += is_proved_by_counting(c, question, asked, !is_violated, "") ? 1 : 0;
    const auto* const run = std::get_if<verify::Counterexample>(&found.evidence);
    if (run != nullptr && !verify::reaches(image, verify::goal_of(question), run->choices))
      fail(asked + ": the way cannot be taken");
  }

  // By one engine alone. `holds`: in all states. `file`: of the certificate; empty: none is asked for.
  bool is_proved_by(const verify::Engine& engine, double seconds, const gen::Compiled& c,
                    const verify::Question& question, const std::string& asked, bool holds,
                    const std::string& file = {}) {
    verify::SystemParts parts(*c.system, c.lowered->image, verify::StateAccess::Searchable, [] { return true; });
    verify::PortfolioLimits limits;
    limits.cancellation = verify::within_seconds(seconds);
    limits.wants_certificate = !file.empty();
    const verify::Report report = [](const char*, std::uint64_t, const char*) {};
    verify::ProofContext context{parts, question, limits, report, nullptr, {}, {}};
    if (!engine.applies_to(context)) return false;
    verify::EngineResult found = engine.attempt(context, {}, limits.cancellation);
    if (found.outcome != verify::Outcome::Holds) return false;
    if (!holds) fail(asked + ": proved by " + engine.name + ", but a bad state is reachable");
    if (!file.empty() && !o_.out.empty()) {
      const verify::Portfolio portfolio(
          *c.system, c.lowered->image, verify::StateAccess::Searchable, [] { return true; }, report);
      verify::Decision decision;
      decision.outcome = found.outcome;
      decision.evidence = std::move(found.evidence);
      write(c, question, portfolio, decision, file);
    }
    return true;
  }
  bool is_proved_by_counting(const gen::Compiled& c, const verify::Question& question, const std::string& asked,
                             bool holds, const std::string& file) {
    return is_proved_by(verify::kCountingEngine, 20, c, question, asked, holds, o_.out.empty() ? "" : file);
  }
  bool is_proved_by_regions(const gen::Compiled& c, const verify::Question& question, const std::string& asked,
                            bool holds, const std::string& file = {}) {
    return is_proved_by(verify::kRegionEngine, 5, c, question, asked, holds, file);
  }

  // A property with a quantifier: if the first conditions stand for all, they have the answer of all.
  void ask_first_conditions(const gen::Compiled& c, const std::string& asked) {
    Result<verify::ParsedProperty> parsed = verify::PropertyReader(*c.system).read(asked);
    if (!parsed) return fail(asked + ": " + parsed.error());
    ++t_.counted;
    const rt::Image& image = c.lowered->image;
    const std::optional<verify::Property> first = verify::with_first_conditions(parsed->state, image);
    if (!first) return;
    verify::Question whole, few;
    whole.what = few.what = verify::QuestionKind::State;
    whole.property = std::move(parsed->state);
    few.property = *first;
    const verify::Net net = verify::build_net(*c.system);
    const verify::SearchResult of_all = verify::search(net, image, verify::goal_of(whole), {}, limits_of_visit());
    const verify::SearchResult of_few = verify::search(net, image, verify::goal_of(few), {}, limits_of_visit());
    if (of_all.end == verify::SearchEnd::Limit || of_few.end == verify::SearchEnd::Limit) return;
    ++t_.counted_few;
    t_.counted_violated += of_all.end == verify::SearchEnd::Found ? 1 : 0;
    if (of_all.end != of_few.end) fail(asked + ": the first conditions have another answer");
    // It breaks the property as a whole, too.
    if (of_few.end == verify::SearchEnd::Found && !verify::reaches(image, verify::goal_of(whole), of_few.choices))
      fail(asked + ": the way to the first conditions does not violate it");
  }

  void wait_up_to_symmetry(const gen::Compiled& c) {
    const rt::Image& image = c.lowered->image;
    if (!verify::has_symmetry(image)) return;
    const verify::Net net = verify::build_net(*c.system);
    if (net.too_large_atom != verify::kNoRow) return;
    const verify::LocalDeadlockResult all = verify::find_local_deadlock(net, image, limits_of_visit());
    if (all.search.end == verify::SearchEnd::Limit) return;
    const verify::LocalDeadlockResult few =
        verify::find_local_deadlock(net, image, limits_of_visit(), verify::SymmetryUse::Permute);
    ++t_.symmetric;
    if (few.search.end != all.search.end) {
      fail(few.search.end == verify::SearchEnd::Limit ? "local deadlock: no answer up to symmetry: " + few.search.limit
                                                      : "local deadlock: another answer up to symmetry");
      return;
    }
    if (few.search.end != verify::SearchEnd::Found) return;
    ++t_.permuted_stuck;
    if (few.search.choices.size() != all.search.choices.size()) fail("local deadlock: another length up to symmetry");
    if (const std::string problem = verify::test::check_waiting(image, few.search.choices, few.stuck, o_.states);
        !problem.empty())
      fail("local deadlock up to symmetry: " + problem);
  }

  void one(const gen::Compiled& c, const verify::Question& question, const std::string& file) {
    ++t_.questions;
    const verify::Net net = verify::build_net(*c.system);
    const verify::SearchLimits limits{
        .cancellation = verify::within_seconds(20), .megabytes = 1000, .states = o_.states, .report = {}};
    const verify::SearchResult all = verify::search(net, c.lowered->image, verify::goal_of(question), {}, limits);
    const bool is_known = all.end != verify::SearchEnd::Limit;
    t_.too_large += is_known ? 0 : 1;
    const bool is_violated = all.end == verify::SearchEnd::Found;
    (is_violated ? t_.violated : t_.holds) += is_known ? 1 : 0;
    const std::string told = question.what == verify::QuestionKind::State ? question.property.text : "deadlock";
    if (is_known) {
      t_.others_by_regions += is_proved_by_regions(c, question, told, !is_violated) ? 1 : 0;
      const std::string other = file.substr(0, file.size() - 1) + static_cast<char>(file.back() + ('r' - '0'));
      t_.certified_by_regions += is_proved_by_regions(c, question, told, !is_violated, other) ? 1 : 0;
    }

    for (const bool with_search : {false, true}) {
      verify::PortfolioLimits decide;
      decide.cancellation = verify::within_seconds(with_search ? 10 * o_.seconds : o_.seconds);
      decide.megabytes = 1000;
      decide.may_search = with_search;
      decide.wants_certificate = wants_certificate_;
      verify::Portfolio portfolio(
          *c.system, c.lowered->image, verify::StateAccess::Searchable, [] { return true; },
          [](const char*, std::uint64_t, const char*) {});
      // The whole prover would visit all states of those that are known, as the test did.
      if (with_search && is_known && open_ == 0) continue;
      const verify::Decision d = portfolio.decide(question, decide);
      open_ = d.outcome == verify::Outcome::Unknown ? 1 : 0;
      (with_search ? t_.unknown : t_.open_proofs) += static_cast<std::uint64_t>(open_);
      if (d.outcome == verify::Outcome::Unknown) continue;
      ++t_.decided;
      const bool says_violated = d.outcome == verify::Outcome::Violated;
      const std::string asked = question.what == verify::QuestionKind::State      ? question.property.text
                                : question.what == verify::QuestionKind::NoErrors ? "errors"
                                                                                  : "deadlock";
      if (is_known && says_violated != is_violated)
        fail(asked +
             (says_violated ? ": violated, but all states are fine" : ": proved, but a bad state is reachable"));
      if (says_violated && !verify::reaches(c.lowered->image, verify::goal_of(question), d.counterexample()->choices))
        fail(asked + ": the way cannot be taken");
      if (!says_violated && wants_certificate_ && !o_.out.empty()) write(c, question, portfolio, d, file);
    }
    open_ = 0;
    if (is_violated) {
      constexpr std::size_t kStates = 300;
      const std::string problem =
          verify::test::check_relevance(c.lowered->image, verify::goal_of(question), seed_, kStates, t_.relevance);
      if (!problem.empty()) fail(file + ": " + problem);
    }
    if (seed_ % 5 == 0 && !kept_.empty())
      reuse(c, question, is_known ? std::optional(is_violated) : std::nullopt, file);
  }

  // The same question with what was kept of it. `is_violated`: as the visit of all states has it.
  void reuse(const gen::Compiled& c, const verify::Question& question, std::optional<bool> is_violated,
             const std::string& file) {
    std::error_code ignored;
    std::filesystem::remove_all(kept_, ignored);
    std::optional<verify::Outcome> first;
    for (const char* state : {"first", "kept", "damaged", "forged", "forged again"}) {
      if (state[0] == 'd') verify::test::damage(kept_, seed_);
      const bool is_forged = state[0] == 'f' && state != std::string("first");
      if (is_forged) {
        // Of a damaged folder the last run has made a good one again.
        std::string last = verify::test::forge(kept_, foreign_, seed_ + (state[6] == 0 ? 0 : 1));
        if (!last.empty()) foreign_ = std::move(last);
      }
      ContentCache cache(ContentKind::Proof, kept_.string(), std::uint64_t{1} << 30);
      verify::ProofCache memory(cache, "test", verify::StorePolicy::All);
      verify::Portfolio portfolio(
          *c.system, c.lowered->image, verify::StateAccess::Searchable, [] { return true; },
          [](const char*, std::uint64_t, const char*) {});
      portfolio.use_cache(&memory);
      verify::PortfolioLimits limits;
      // What is wrong in a file may cost time, though no verdict.
      limits.cancellation = verify::within_seconds(first ? 10 * o_.seconds : o_.seconds);
      limits.megabytes = 1000;
      limits.may_search = false;
      limits.wants_certificate = wants_certificate_;
      const verify::Decision d = portfolio.decide(question, limits);
      ++t_.reused;
      t_.whole += memory.counts.is_whole ? 1 : 0;
      (is_forged ? t_.forged_rows : t_.rows) +=
          memory.counts.invariants + memory.counts.lemmas + (memory.counts.has_counterexample ? 1 : 0);
      const bool says_violated = d.outcome == verify::Outcome::Violated;
      if (!first) first = d.outcome;
      else if (d.outcome != *first && *first != verify::Outcome::Unknown)
        fail(std::string("with proofs ") + state +
             (d.outcome == verify::Outcome::Unknown ? ": no answer, but one without: " + d.reason
                                                    : ": another verdict than without"));
      // Nothing was kept, or the time was over: there is nothing to compare.
      if (first == verify::Outcome::Unknown) return;
      if (d.outcome == verify::Outcome::Unknown) continue;
      if (is_violated && says_violated != *is_violated)
        fail(std::string("with proofs ") + state +
             (says_violated ? ": violated, but all states are fine" : ": proved, but a bad state is reachable"));
      if (says_violated && !verify::reaches(c.lowered->image, verify::goal_of(question), d.counterexample()->choices))
        fail(std::string("with proofs ") + state + ": the way cannot be taken");
      // By its number certcheck knows it as another question.
      if (is_forged && !says_violated && wants_certificate_ && !o_.out.empty() && !verify::is_exhaustive(d.evidence)) {
        write(c, question, portfolio, d,
              file.substr(0, file.size() - 1) + static_cast<char>(file.back() + 3 + (state[6] == 0 ? 0 : 3)));
      }
    }
  }

  void write(const gen::Compiled& c, const verify::Question& question, const verify::Portfolio& portfolio,
             const verify::Decision& d, const std::string& file) {
    // A run that ends before its first state has none that could be bad: there every certificate is a proof, a broken
    // one, too.
    rt::Core core(c.lowered->image);
    if (!core.initialize()) return;
    std::ofstream(o_.out + '/' + file + ".bsys") << system::print(*c.system);
    std::ofstream(o_.out + '/' + file + ".cert") << verify::certificate(portfolio, question, d, *c.system, "Root()");
    ++t_.certificates;
  }

  const Options& o_;
  Totals& t_;
  std::string name_;
  int open_ = 0;
  std::uint64_t seed_ = 0;
  std::filesystem::path kept_;  // proofs
  std::string foreign_;         // a proof of another system
  // Of every second seed: some proofs have no certificate, and then another one is looked for.
  bool wants_certificate_ = true;
};

}  // namespace

int main(int argc, char** argv) {
  Options o;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string flag = argv[i];
    const char* value = argv[i + 1];
    if (flag == "--from") o.from = std::strtoull(value, nullptr, 10);
    else if (flag == "--count") o.count = std::strtoull(value, nullptr, 10);
    else if (flag == "--states") o.states = std::strtoull(value, nullptr, 10);
    else if (flag == "--seconds") o.seconds = std::strtod(value, nullptr);
    else if (flag == "--out") o.out = value;
    else if (flag == "--print") o.print = value;
    else if (flag == "--sort") {
      o.nets = std::strcmp(value, "nets") == 0;
      o.models = std::strcmp(value, "models") == 0;
      o.sizes = std::strcmp(value, "sizes") == 0;
      o.equal = std::strcmp(value, "equal") == 0;
      o.levels = std::strcmp(value, "levels") == 0;
    }
  }
  Totals t;
  Check check(o, t);
  for (std::uint64_t seed = o.from; seed < o.from + o.count; ++seed) {
    if (o.nets) check.system("net" + std::to_string(seed), {verify::test::small_net(seed)}, seed);
    if (o.nets && (seed % 3 == 0 || !o.print.empty()))
      check.system("locks" + std::to_string(seed), {verify::test::lock_net(seed)}, seed);
    if (o.nets) check.system("values" + std::to_string(seed), {verify::test::value_net(seed)}, seed);
    if (o.nets && (seed % 2 == 0 || !o.print.empty()))
      check.system("counters" + std::to_string(seed), {verify::test::counter_net(seed)}, seed);
    if (o.equal && o.print.empty() && (seed % 4 == 0 || !o.nets)) {
      check.equal("equal" + std::to_string(seed), seed);
      check.quorum("quorum" + std::to_string(seed), seed);
    }
    if (o.levels && o.print.empty() && (seed % 4 == 0 || !o.nets)) check.levels("levels" + std::to_string(seed), seed);
    if (o.sizes && o.print.empty() && (seed % 4 == 0 || !o.nets)) check.sized("sizes" + std::to_string(seed), seed);
    if (o.models) check.system("model" + std::to_string(seed), gen::print_packages(gen::generate(seed)), seed);
  }
  const auto n = [](std::uint64_t v) { return static_cast<unsigned long long>(v); };
  std::printf(
      "questions %llu: hold %llu, violated %llu, more states than %llu: %llu; without search open %llu; unknown %llu; "
      "certificates %llu\n",
      n(t.questions), n(t.holds), n(t.violated), n(o.states), n(t.too_large), n(t.open_proofs), n(t.unknown),
      n(t.certificates));
  std::printf("with kept proofs %llu: the system known %llu, rows used %llu, forged ones %llu\n", n(t.reused),
              n(t.whole), n(t.rows), n(t.forged_rows));
  std::printf("runs %llu: steps left out %llu, a step decided %llu, none %llu\n", n(t.relevance.runs),
              n(t.relevance.left_out), n(t.relevance.decided), n(t.relevance.inevitable));
  std::printf(
      "small instances: %llu questions, %llu proofs with lemmas learnt from them, %llu by local lemmas, "
      "%llu by lemmas about pairs\n",
      n(t.learnt_from), n(t.learnt), n(t.local), n(t.of_pairs));
  std::printf(
      "symmetry: %llu searches, %llu permuted components (%llu violated, %llu waited), %llu states instead of %llu\n",
      n(t.symmetric), n(t.permuted), n(t.permuted_violated), n(t.permuted_stuck), n(t.orbits),
      n(t.orbits + t.orbits_saved));
  constexpr std::uint64_t kManySymmetric = 200;
  if (t.symmetric >= kManySymmetric && (t.permuted == 0 || t.permuted == t.symmetric || t.permuted_violated == 0 ||
                                        t.permuted_stuck == 0 || t.orbits_saved == 0)) {
    ++t.failed;
    std::printf("FAILED: of %llu searches none permuted components with each answer\n", n(t.symmetric));
  }
  std::printf("quantifiers: %llu properties, %llu by their first conditions (%llu violated)\n", n(t.counted),
              n(t.counted_few), n(t.counted_violated));
  if (t.counted >= kManySymmetric && (t.counted_few == 0 || t.counted_few == t.counted || t.counted_violated == 0 ||
                                      t.counted_violated == t.counted_few)) {
    ++t.failed;
    std::printf("FAILED: of %llu properties with quantifiers none of each kind\n", n(t.counted));
  }
  std::printf("counting: %llu properties of voters, %llu hold, %llu proved; %llu of other systems proved\n", n(t.votes),
              n(t.votes_hold), n(t.by_counting), n(t.equal_by_counting));
  if (t.votes >= kManySymmetric && (t.by_counting == 0 || t.by_counting > t.votes_hold || t.votes_hold == t.votes)) {
    ++t.failed;
    std::printf("FAILED: of %llu properties of voters none of each kind\n", n(t.votes));
  }
  std::printf(
      "regions: %llu questions about levels, %llu hold, %llu proved; %llu of other systems proved; %llu certificates\n",
      n(t.levels), n(t.levels_hold), n(t.by_regions), n(t.others_by_regions), n(t.certified_by_regions));
  if (t.levels >= kManySymmetric &&
      (t.by_regions == 0 || t.certified_by_regions == 0 || t.by_regions > t.levels_hold || t.levels_hold == t.levels)) {
    ++t.failed;
    std::printf("FAILED: of %llu questions about levels none of each kind\n", n(t.levels));
  }
  // Of so many systems some have answers; a run without is no test.
  constexpr std::uint64_t kMany = 20;
  if (o.print.empty() && (o.nets || o.models) && t.systems >= kMany &&
      (t.decided == 0 || t.holds == 0 || t.violated == 0 || t.rows == 0 || t.relevance.left_out == 0 ||
       t.relevance.decided == 0)) {
    ++t.failed;
    std::printf("FAILED: %llu answers, %llu rows of kept proofs: nothing was compared\n", n(t.decided), n(t.rows));
  }
  constexpr std::uint64_t kManyLearnt = 100;
  if (t.learnt_from >= kManyLearnt && (t.learnt == 0 || t.local == 0)) {
    ++t.failed;
    std::printf("FAILED: of %llu questions none was proved by small instances, or none by local lemmas\n",
                n(t.learnt_from));
  }
  if (t.relevance.runs >= kMany && (t.relevance.left_out == 0 || t.relevance.decided == 0)) {
    ++t.failed;
    std::printf("FAILED: of %llu runs no step was left out, or none decided\n", n(t.relevance.runs));
  }
  std::printf("systems %llu, failed %llu\n", n(t.systems), n(t.failed));
  return t.failed == 0 ? 0 : 1;
}
