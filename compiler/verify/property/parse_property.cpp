// Parses whole properties and decides of which form they are; the names of a system are resolved on the way. Nesting
// and the number of nodes are limited: what follows the tree of nodes recurs. The first problem ends the parse. Cost:
// linear in the text and in the number of atoms and connectors.
#include <fmt/format.h>

#include "compiler/verify/property/expression.hpp"
#include "compiler/verify/property/property_parser.hpp"
#include "compiler/verify/property/property_words.hpp"

namespace bip::verify {

Result<Property> PropertyParser::run_expression() {
  property_.root = parse_expression(1, 0);
  skip_blanks();
  if (problem_.empty() && at_ != text_.size()) set_problem("this does not belong to the expression");
  property_.fault = fault_of(property_.root);
  if (!problem_.empty()) return Failure{problem_};
  return std::move(property_);
}

Result<ParsedProperty> PropertyParser::run_formula() {
  accepts_formulas_ = true;
  property_.root = parse_formula(0);
  skip_blanks();
  const std::size_t end = at_;
  std::optional<Fairness> fairness = take_fairness();
  if (fairness) property_.text = text_.substr(0, text_.find_last_not_of(" \t\n", end - 1) + 1);
  if (problem_.empty() && at_ != text_.size()) set_problem(about_rest());
  if (problem_.empty() && within_ && property_.root != within_row_) {
    at_ = within_at_;
    set_problem(kWithinAlone);
  }
  if (problem_.empty() && type(property_.root) != Type::Bool) {
    at_ = 0;
    set_problem("a property is true or false, this is " + std::string(name_of(type(property_.root))));
  }
  if (problem_.empty() && !is_temporal(property_.root)) {
    at_ = 0;
    set_problem(
        "a property says `never`, `always`, `eventually`, `leads to`, `until`, `unless` or `possibly`; this is a "
        "condition on one state");
  }
  if (problem_.empty() && is_of_past_[property_.root] != 0 && looks_ahead_[property_.root] == 0) {
    at_ = 0;
    set_problem("at the beginning of a run nothing is past: `always (…)` and `never (…)` ask at every point of it");
  }
  if (!problem_.empty()) return Failure{problem_};
  const PropertyNode& root = property_.nodes[property_.root];
  const bool is_invariant = root.kind == PropertyKind::Temporal && !is_temporal(root.a) &&
                            (root.temporal == TemporalOperator::Always || root.temporal == TemporalOperator::Never);
  ParsedProperty parsed;
  parsed.fairness = std::move(fairness);
  const Failure for_finite{
      fmt::format("column {}: fairness is of infinite runs, and finite ones decide this property", end + 1)};
  if (is_invariant && fairness) return for_finite;
  if (is_invariant) {
    property_.is_never = root.temporal == TemporalOperator::Never;
    property_.root = root.a;
    // Its operator is the last row.
    property_.nodes.pop_back();
    guard_divisions();
    if (!problem_.empty()) return Failure{problem_};
    note_counted();
    parsed.state = std::move(property_);
    return parsed;
  }
  refuse_divisions("in a property of runs");
  if (possibly_at_) refuse_words_of_one_run();
  if (!problem_.empty()) return Failure{problem_};
  if (possibly_at_) {
    Result<BranchingFormula> branching = make_branching(property_, is_temporal_, extents_);
    if (!branching) return Failure{branching.error()};
    parsed.form = PropertyForm::Branching;
    parsed.branching = std::move(*branching);
    return parsed;
  }
  Result<Formula> formula = make_formula(property_, is_temporal_, within_);
  if (!formula) return Failure{formula.error()};
  if (fairness && is_invariant_of_past(*formula)) return for_finite;
  parsed.form = PropertyForm::Runs;
  parsed.formula = std::move(*formula);
  return parsed;
}

Result<Property> PropertyParser::run() {
  const std::string word = parse_path();
  if (word == "possibly") {
    at_ = 0;
    return fail("`possibly` asks what may follow a state, which `bipc verify --property` answers");
  }
  if (word != "never" && word != "always") {
    at_ = 0;
    return fail("a property starts with `never` or `always`");
  }
  property_.is_never = word == "never";
  parse_whole("this does not belong to the property");
  if (problem_.empty() && type(property_.root) != Type::Bool)
    set_problem("a property is true or false, this is " + std::string(name_of(type(property_.root))));
  guard_divisions();
  if (!problem_.empty()) return Failure{problem_};
  return std::move(property_);
}

Result<Property> PropertyParser::run_value() {
  parse_whole("this does not belong to the expression");
  if (problem_.empty() && !is_numeric(type(property_.root)) && type(property_.root) != Type::Bool)
    set_problem("a number or a condition was expected, this is " + std::string(name_of(type(property_.root))));
  refuse_divisions("here");
  if (!problem_.empty()) return Failure{problem_};
  return std::move(property_);
}

void PropertyParser::refuse_divisions(const std::string& where) {
  if (!problem_.empty() || !division_at_) return;
  at_ = *division_at_;
  problem_.clear();
  set_problem("this division may fail: " + where + " the divisor is a number other than 0 and -1");
}

void PropertyParser::refuse_words_of_one_run() {
  const auto refuse = [&](const std::optional<std::size_t>& at, const std::string& why) {
    if (!at || !problem_.empty()) return;
    at_ = *at;
    set_problem(why);
  };
  refuse(past_at_, "a word that looks back speaks of one run, `possibly` of all that may follow a state");
  refuse(happens_at_,
         "`happens` speaks of a step of one run, `possibly` of states: `can …` asks whether it is possible");
  if (within_) refuse(within_at_, "`within` bounds the time of each run, and `possibly` has no such limit");
}

void PropertyParser::note_counted() {
  const std::uint32_t made = last_counted_.made;
  if (made == Property::kNoRow || last_counted_.is_negated == property_.is_never) return;
  const PropertyNode& root = property_.nodes[property_.root];
  const bool joins = property_.is_never && root.kind == PropertyKind::Operator && root.op == Op::And;
  if (joins && (root.a == made || root.b == made)) last_counted_.counted.beside = root.a == made ? root.b : root.a;
  else if (property_.root != made) return;
  property_.counted = std::move(last_counted_.counted);
}

void PropertyParser::parse_whole(const char* about_the_rest) {
  property_.root = parse_expression(1, 0);
  skip_blanks();
  if (problem_.empty() && at_ != text_.size()) set_problem(about_the_rest);
}

Result<Property> PropertyParser::fail(const std::string& why) {
  set_problem(why);
  return Failure{problem_};
}

std::optional<Fairness> PropertyParser::take_fairness() {
  if (!problem_.empty() || !take_words("under")) return std::nullopt;
  Result<Fairness> read = read_fairness(text_, at_, system_, rows_);
  at_ = text_.size();
  if (!read) problem_ = read.error();
  return read ? std::optional(std::move(*read)) : std::nullopt;
}

std::string PropertyParser::about_rest() {
  const std::size_t start = at_;
  const bool is_within = take_words("within");
  at_ = start;
  return is_within ? "`within` bounds `eventually` and `leads to`" : "this does not belong to the property";
}

Result<Property> parse_property(const std::string& text, const System& system) {
  return PropertyParser(text, system, RowsOfPaths(system)).run();
}

PropertyReader::PropertyReader(const System& system) : system_(system), rows_(std::make_unique<RowsOfPaths>(system)) {}
PropertyReader::~PropertyReader() = default;

Result<ParsedProperty> PropertyReader::read(const std::string& text) const {
  return PropertyParser(text, system_, *rows_).run_formula();
}

Result<Property> parse_value(const std::string& text, const System& system) {
  return PropertyParser(text, system, RowsOfPaths(system)).run_value();
}

Result<Property> parse_expression(const std::string& text, const System& system) {
  return PropertyParser(text, system, RowsOfPaths(system)).run_expression();
}

}  // namespace bip::verify
