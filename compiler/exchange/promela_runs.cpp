// See promela_runs.hpp. SPIN's formulas have no `next` operator, its weak fairness is one of processes, and a model is
// one process here. So:
//
// Points. `at` says that the process is at a point of the run: a state and the step that leaves it. Without `happens`
// and `next` each state is one as soon as the model is `ready`. With them a step is first `chosen`, which is the point,
// and then taken, which leads to a state that is none. Formulas speak of points only, so they do not see how often a
// state repeats: "E at all points" is `[] (at -> E)`.
//
// Weak fairness: `turn` goes round the units (interactions or components). It passes a unit that has just taken part in
// a step or cannot now, as many as it can at once; `round` says that it has come round, or that the run has ended. A
// run is fair if this is so again and again. Strong fairness: at some point (`began`) the units that are impossible
// from then on are guessed (`gone`), and a run in which one of them is possible later is dropped (`broken`); the turn
// passes those units and those that have just taken part.
//
// Cost: weak fairness multiplies the states by the number of units at most, strong fairness also by 2 for each unit.
#include "compiler/exchange/promela_runs.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "runtime/include/bip/assert.hpp"

namespace bip::exchange {

namespace {

// "(a) || (b)"; "false" of none.
template <typename Rows, typename Text>
std::string any_of(const Rows& rows, const Text& text) {
  std::string all;
  for (const auto& row : rows) all += fmt::format("{}{}", all.empty() ? "" : " || ", text(row));
  return all.empty() ? "false" : all;
}

std::string unit_words(const verify::Fairness& fairness) {
  if (fairness.terms.size() != 1 || fairness.terms[0].has_name()) return verify::name_of(fairness);
  return fairness.terms[0].unit == verify::FairnessUnit::Atoms ? "components" : "interactions";
}

const char* smallest_type(std::size_t greatest) { return greatest < 256 ? "byte" : "int"; }

}  // namespace

PromelaRuns::PromelaRuns(std::vector<StepText> steps, const verify::Formula& formula, const verify::Fairness& fairness)
    : steps_(std::move(steps)), fairness_(fairness) {
  has_chosen_ = std::any_of(formula.nodes.begin(), formula.nodes.end(), [](const verify::FormulaNode& node) {
    return node.kind == verify::FormulaKind::Next || node.kind == verify::FormulaKind::Step;
  });
  for (const verify::FairnessTerm& term : fairness_.terms) add_units(term);
}

void PromelaRuns::add_units(const verify::FairnessTerm& term) {
  // By atom; of other terms one, or one for each step.
  std::map<std::size_t, std::vector<std::size_t>> units;
  if (term.has_name()) units[0] = {};
  for (std::size_t step = 0; step < steps_.size(); ++step) {
    const auto add = [&](std::size_t row) {
      std::vector<std::size_t>& unit = units[row];
      if (unit.empty() || unit.back() != step) unit.push_back(step);
    };
    switch (term.unit) {
      case verify::FairnessUnit::Interactions: add(step); break;
      case verify::FairnessUnit::Connector:
        if (steps_[step].connector == ConnectorId(term.owner)) add(0);
        break;
      case verify::FairnessUnit::Atoms:
      case verify::FairnessUnit::Port:
      case verify::FairnessUnit::Atom:
        for (const auto& [atom, port] : steps_[step].ports) {
          if (term.unit == verify::FairnessUnit::Atoms) add(atom.value);
          else if (atom == AtomId(term.owner) && (term.unit == verify::FairnessUnit::Atom || port == term.port)) add(0);
        }
        break;
    }
  }
  for (auto& [row, unit] : units) units_.push_back({std::move(unit), term.is_strong()});
}

std::string PromelaRuns::rounds() const {
  std::string passes;
  for (std::size_t unit = 0; unit < units_.size(); ++unit) {
    passes += fmt::format("{}(turn == {} && (happened{} || {}{}))", passes.empty() ? "" : "\n     || ", unit, unit,
                          units_[unit].is_strong ? "gone" : "!possible", unit);
  }
  return fmt::format(
      "  do\n  :: ({}) -> turn = turn + 1;\n  :: else -> break;\n  od;\n"
      "  if\n  :: turn == {} -> turn = 0; round = true;\n  :: else -> skip;\n  fi;\n",
      passes.empty() ? "false" : passes, units_.size());
}

std::string PromelaRuns::declarations() const {
  std::string out;
  if (has_chosen_) {
    out += fmt::format(
        "{} chosen = {}; /* the step to take; {}: none yet; {}: the run has ended */\n#define at (chosen != {})\n",
        smallest_type(none() + 1), none(), none(), none() + 1, none());
  } else {
    out += "bool ready = false; /* is the initial state reached? */\n#define at ready\n";
  }
  if (is_fair()) {
    out += fmt::format("hidden {} last = {}; /* the step that led here; at first none */\n", smallest_type(none()),
                       none());
  }
  if (is_fair() || has_chosen_) {
    std::vector<std::size_t> all(steps_.size());
    for (std::size_t step = 0; step < all.size(); ++step) {
      all[step] = step;
      out += fmt::format("#define step{} ({})\n", step, steps_[step].possible);
    }
    out += fmt::format("#define goes_on (!fault{} && ({}))\n", condition(),
                       any_of(all, [](std::size_t step) { return fmt::format("step{}", step); }));
  }
  if (!is_fair()) return out;
  for (std::size_t unit = 0; unit < units_.size(); ++unit) {
    out += fmt::format("#define possible{} ({})\n#define happened{} ({})\n", unit,
                       any_of(units_[unit].steps, [](std::size_t step) { return fmt::format("step{}", step); }), unit,
                       any_of(units_[unit].steps, [](std::size_t step) { return fmt::format("last == {}", step); }));
    if (units_[unit].is_strong) out += fmt::format("bool gone{} = false;\n", unit);
  }
  out += fmt::format("{} turn = 0; /* of {} */\nbool round = false;\n", smallest_type(units_.size()),
                     unit_words(fairness_));
  // The condition of a step may be long, and formulas are not: what `fair` reads is noted after each step.
  out += "inline note_end() {\n  if\n  :: goes_on -> skip;\n  :: else -> round = true;\n  fi;\n}\n";
  if (!is_strong()) {
    return out + fmt::format(
                     "#define fair (!fault && round)\ninline count_round() {{\n  round = false;\n{}  note_end();\n}}\n",
                     rounds());
  }
  std::string wrong;
  for (std::size_t unit = 0; unit < units_.size(); ++unit) {
    if (!units_[unit].is_strong) continue;
    wrong += fmt::format("{}(gone{} && possible{})", wrong.empty() ? "" : " || ", unit, unit);
  }
  return out +
         fmt::format(
             "bool began = false; /* is it guessed which are gone? */\nbool broken = false; /* a wrong guess */\n"
             "#define fair (!fault && !broken && round)\n"
             "inline count_round() {{\n  round = false;\n  if\n  :: began ->\n  broken = {};\n{}  :: else -> skip;\n  "
             "fi;\n  note_end();\n}}\n",
             wrong.empty() ? "false" : wrong, rounds());
}

std::string PromelaRuns::before_step(std::size_t step) const {
  BIP_ASSERT(step < steps_.size(), "step {} of {}", step, steps_.size());
  return has_chosen_ ? fmt::format("chosen == {}", step)
                     : fmt::format("!fault{} && {}", condition(), steps_[step].possible);
}

std::string PromelaRuns::after_step(std::size_t step) const {
  BIP_ASSERT(step < steps_.size(), "step {} of {}", step, steps_.size());
  std::string out;
  if (has_chosen_) out += fmt::format("     chosen = {};\n", none());
  if (is_fair()) out += fmt::format("     last = {};\n     count_round();\n", step);
  return out;
}

std::string PromelaRuns::alternatives() const {
  std::string out;
  for (std::size_t step = 0; has_chosen_ && step < steps_.size(); ++step)
    out += fmt::format("  :: chosen == {} && goes_on && step{} -> chosen = {}\n", none(), step, step);
  if (has_chosen_) {
    out += fmt::format("  :: chosen == {} && !fault{} && !goes_on -> chosen = {}\n", none(), condition(), none() + 1);
  }
  if (!is_strong()) return out;
  out += "  :: broken -> break\n  :: atomic { goes_on && !began ->\n     began = true;\n";
  for (std::size_t unit = 0; unit < units_.size(); ++unit) {
    if (!units_[unit].is_strong) continue;
    out += fmt::format("     if\n     :: !possible{} -> gone{} = true;\n     :: true -> skip;\n     fi;\n", unit, unit);
  }
  return out + "     }\n";
}

std::string PromelaRuns::condition() const { return is_strong() ? " && !broken" : ""; }

std::string PromelaRuns::premise(MayFault may_fault) const {
  if (is_fair()) return "(! ([] (<> fair))) || ";
  return may_fault == MayFault::Yes ? "(<> fault) || " : "";
}

std::string PromelaRuns::happens(const verify::StepCondition& condition) const {
  BIP_ASSERT(has_chosen_, "a formula without steps");
  std::vector<std::size_t> rows;
  for (std::size_t step = 0; step < steps_.size(); ++step) {
    const std::vector<std::pair<AtomId, u32>>& ports = steps_[step].ports;
    const std::pair<AtomId, u32> port{AtomId(condition.owner), condition.port};
    const bool is_one = condition.is_port ? std::find(ports.begin(), ports.end(), port) != ports.end()
                                          : steps_[step].connector == ConnectorId(condition.owner);
    if (is_one) rows.push_back(step);
  }
  return '(' + any_of(rows, [](std::size_t step) { return fmt::format("(chosen == {})", step); }) + ')';
}

// Between two points there is a state that is none. After the last step the state repeats.
std::string PromelaRuns::next(const std::string& operand) const {
  BIP_ASSERT(has_chosen_, "a formula without `next`");
  return fmt::format("(((chosen == {}) && {}) || (at U ((! at) && ((! at) U (at && {})))))", none() + 1, operand,
                     operand);
}

}  // namespace bip::exchange
