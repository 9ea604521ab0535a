// See contradictions.hpp. A few runs show most services accepted; one question for each of the others. Minimal sets by
// deletion: rules that are not needed for the contradiction are removed one after the other.
#include "compiler/driver/contradictions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "compiler/pipeline/executor.hpp"
#include "compiler/driver/interrupt_cancellation.hpp"
#include "compiler/genom/translate.hpp"
#include "compiler/rules/reduce.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/portfolio/portfolio.hpp"
#include "runtime/engine/simulate.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {
namespace {

class ContradictionChecker {
 public:
  ContradictionChecker(const rules::Reduced& reduced, const rules::Checked& checked, std::size_t rules,
                       const verify::CancellationToken& cancellation)
      : reduced_(reduced), checked_(checked), rules_(rules), cancellation_(cancellation) {}

  /// Which of the properties do random runs under all rules violate?
  [[nodiscard]] std::vector<bool> violated_in_runs(const std::vector<std::string>& properties) const {
    constexpr std::uint64_t kRuns = 4;
    constexpr std::uint64_t kStepsOfRun = 50'000;
    std::vector<bool> violated(properties.size(), false);
    Compilation c{CompileOptions{}};
    Executor executor(MachineCode::Fresh);
    if (!compile_level(c, std::vector<bool>(rules_, true)) || !executor.prepare(c, Backend::Interp, Optimisation::Auto))
      return violated;
    std::vector<verify::Question> questions(properties.size());
    rt::SimulateOptions options;
    options.runs = kRuns;
    options.limit = kStepsOfRun;
    options.is_stopped = [&] { return is_over(); };
    for (std::size_t i = 0; i < properties.size(); ++i) {
      Result<verify::Property> parsed = verify::parse_property(properties[i], *c.system);
      if (!parsed) return violated;
      questions[i].what = verify::QuestionKind::State;
      questions[i].property = std::move(*parsed);
      rt::PathQuery& query = options.queries.emplace_back();
      query.goal = verify::goal_of(questions[i]).state;
    }
    const rt::SimulateReport report = rt::simulate(c.lowered->image, options);
    BIP_ASSERT(report.answers.size() <= properties.size(), "answers to {} of {} questions", report.answers.size(),
               properties.size());
    for (std::size_t i = 0; i < report.answers.size(); ++i) {
      for (const rt::Answer answer : report.answers[i]) violated[i] = violated[i] || answer == rt::Answer::Yes;
    }
    return violated;
  }

  /// Is it proved that the property holds with these rules only?
  [[nodiscard]] bool holds(const std::vector<bool>& kept, const std::string& property) const {
    Compilation c{CompileOptions{}};
    if (!compile_level(c, kept)) return false;
    verify::Question question;
    Result<verify::Property> parsed = verify::parse_property(property, *c.system);
    if (!parsed) return false;
    question.what = verify::QuestionKind::State;
    question.property = std::move(*parsed);
    verify::PortfolioLimits limits;
    limits.cancellation = cancellation_;
    Executor executor(MachineCode::Fresh);
    verify::Portfolio portfolio(
        *c.system, c.lowered->image, verify::StateAccess::Searchable,
        [&] { return executor.prepare(c, Backend::Interp, Optimisation::Auto); },
        [](const char*, std::uint64_t, const char*) {});
    return portfolio.decide(question, limits).outcome == verify::Outcome::Holds;
  }

  /// What becomes of the promises under all rules, in their order; nothing if the level does not compile.
  [[nodiscard]] std::vector<verify::Outcome> promises() const {
    std::vector<verify::Outcome> all;
    Compilation c{CompileOptions{}};
    if (!compile_level(c, std::vector<bool>(rules_, true))) return all;
    Executor executor(MachineCode::Fresh);
    for (const auto& stated : c.system->properties) {
      Result<verify::Property> parsed = verify::parse_property(stated.text, *c.system);
      if (!parsed) return {};
      verify::Question question;
      question.what = verify::QuestionKind::State;
      question.property = std::move(*parsed);
      verify::PortfolioLimits limits;
      limits.cancellation = cancellation_;
      verify::Portfolio portfolio(
          *c.system, c.lowered->image, verify::StateAccess::Searchable,
          [&] { return executor.prepare(c, Backend::Interp, Optimisation::Auto); },
          [](const char*, std::uint64_t, const char*) {});
      all.push_back(portfolio.decide(question, limits).outcome);
    }
    return all;
  }

  /// A subset of all rules that is enough, and of which none can go.
  [[nodiscard]] std::vector<std::size_t> culprits(const std::string& property) const {
    std::vector<bool> kept(rules_, true);
    std::vector<std::size_t> needed;
    for (std::size_t i = 0; i < rules_; ++i) {
      kept[i] = false;
      if (holds(kept, property)) continue;
      BIP_ASSERT(kept.size() == rules_ && needed.size() <= i, "{} of {} rules are needed", needed.size(), i);
      kept[i] = true;
      needed.push_back(i);
    }
    return needed;
  }

  [[nodiscard]] bool is_over() const { return cancellation_.is_over(); }

 private:
  // The reduced level with these rules only.
  [[nodiscard]] bool compile_level(Compilation& c, const std::vector<bool>& kept) const {
    genom::GenerateOptions options = rules::reduced_options(reduced_, "reduced");
    std::vector<genom::Constraint>& rows = options.constraints.rows;
    rows.clear();
    for (std::size_t i = 0; i < reduced_.constraints.rows.size(); ++i) {
      BIP_ASSERT(checked_.rule.size() == reduced_.constraints.rows.size() && checked_.rule[i] < kept.size(),
                 "constraint {} of rule {}", i, checked_.rule[i]);
      if (kept[checked_.rule[i]]) rows.push_back(reduced_.constraints.rows[i]);
    }
    const std::string path = "/reduced/reduced.bip";
    c.open_texts[path] = genom::write_package(reduced_.modules, options).bip;
    return compile(c, path, Stage::Image);
  }

  const rules::Reduced& reduced_;
  const rules::Checked& checked_;
  std::size_t rules_;
  verify::CancellationToken cancellation_;
};

// Rules that are enough to keep some services out.
struct BadStateAbstraction {
  std::vector<std::size_t> culprits;
  std::vector<std::string> services;
};

// One rule is where it is shown, the others are labels.
void counterexample_text(Diagnostics& diags, const rules::RuleFile& file, const BadStateAbstraction& found) {
  BIP_ASSERT(!found.culprits.empty() && !found.services.empty() &&
                 std::is_sorted(found.culprits.begin(), found.culprits.end()),
             "{} rules contradict each other", found.culprits.size());
  auto d = diags.report(Diag::kB6110, file.rules[found.culprits[0]].range, found.services[0]);
  d.label(found.culprits.size() == 1 ? "by this rule alone" : "by this rule");
  for (std::size_t i = 1; i < found.culprits.size(); ++i) d.label(file.rules[found.culprits[i]].range, "and this one");
  if (found.culprits.size() > 1)
    d.note(fmt::format("{} rules together: without any one of them it could be", found.culprits.size()));
  for (std::size_t i = 1; i < found.services.size(); ++i) d.note(fmt::format("nor is `{}`", found.services[i]));
}

}  // namespace

void report_contradictions(Compilation& c, const rules::RuleFile& file, const std::vector<genom::Module>& modules,
                           const rules::Checked& checked, double seconds) {
  const rules::Reduced reduced = rules::reduce(modules, checked.constraints);
  const InterruptCancellation interrupt;
  const ContradictionChecker checker(reduced, checked, file.rules.size(), interrupt.token().within(seconds));
  // Promises first: the user has written them and wants them decided, and the other questions may take all the time.
  const std::vector<verify::Outcome> outcomes =
      file.promises.empty() ? std::vector<verify::Outcome>{} : checker.promises();
  const std::vector<bool> all(file.rules.size(), true);
  std::set<genom::ServiceRef> asked;
  std::vector<std::size_t> rows;
  std::vector<std::string> properties;
  for (std::size_t i = 0; i < reduced.names.size(); ++i) {
    const genom::ServiceRef s = reduced.names[i];
    if (checked.constraints.rows[i].kind != genom::ConstraintKind::Admit || !asked.insert(s).second) continue;
    const bool is_control = reduced.modules[s.module].services[s.service].kind == genom::ServiceKind::Control;
    rows.push_back(i);
    properties.push_back(fmt::format("never m{}.s{}{}.active", s.module, s.service, is_control ? "" : ".controller"));
  }
  const std::vector<bool> is_accepted = checker.violated_in_runs(properties);
  BIP_ASSERT(is_accepted.size() == rows.size() && reduced.names.size() == checked.constraints.rows.size(),
             "{} answers for {} rows", is_accepted.size(), rows.size());
  std::vector<BadStateAbstraction> found;
  for (std::size_t k = 0; k < rows.size() && !checker.is_over(); ++k) {
    const std::size_t i = rows[k];
    const std::string& property = properties[k];
    if (is_accepted[k] || !checker.holds(all, property)) continue;
    const genom::ServiceRef was = checked.constraints.rows[i].subject;
    const std::string name = modules[was.module].name.text + "." + modules[was.module].services[was.service].name.text;
    const auto known = std::find_if(found.begin(), found.end(), [&](const BadStateAbstraction& f) {
      std::vector<bool> kept(file.rules.size(), false);
      for (const std::size_t rule : f.culprits) kept[rule] = true;
      return checker.holds(kept, property);
    });
    if (known != found.end()) {
      known->services.push_back(name);
      continue;
    }
    std::vector<std::size_t> culprits = checker.culprits(property);
    if (!culprits.empty()) found.push_back({std::move(culprits), {name}});
  }
  for (const BadStateAbstraction& f : found) counterexample_text(c.diags, file, f);
  for (std::size_t k = 0; k < file.promises.size(); ++k) {
    const rules::Promise& p = file.promises[k];
    const verify::Outcome outcome = k < outcomes.size() ? outcomes[k] : verify::Outcome::Unknown;
    if (outcome == verify::Outcome::Holds) continue;
    if (outcome == verify::Outcome::Violated) {
      c.diags.report(Diag::kB6160, p.range, p.name.text)
          .note("with modules in which every service runs and ends as it likes")
          .help("`bipc verify` of the level shows a run");
    } else {
      c.diags.report(Diag::kB6161, p.range, p.name.text).help("`bipc verify` of the level, with more time");
    }
  }
}

}  // namespace bip::driver
