// Parses a property by precedence climbing (Richards, Whitby-Strevens 1979), with the names of a system
// resolved on the way. Nesting and the number of nodes are limited: what follows the tree of nodes recurs. The first
// problem ends the parse. Cost: linear in the text and in the number of atoms and connectors.
#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>

#include "compiler/base/ascii.hpp"
#include "compiler/model/fold.hpp"
#include "compiler/model/operators.hpp"
#include "compiler/system/index_expression.hpp"
#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "compiler/verify/property/binary_operators.hpp"
#include "compiler/verify/property/expression.hpp"
#include "compiler/verify/property/make_formula.hpp"
#include "compiler/verify/property/property_rows.hpp"
#include "compiler/verify/property/property_words.hpp"
#include "compiler/verify/property/rows_of_paths.hpp"
#include "runtime/core/text.hpp"
#include "runtime/engine/event_file.hpp"

namespace bip::verify {

namespace {

constexpr int kMaxPropertyDepth = 200;
// Of variables of quantifiers.
constexpr std::size_t kMaxRounds = 4'000'000;

bool begins_name(char c) { return is_letter(c) || c == '_'; }

class PropertyParser : private PropertyRows {
 public:
  PropertyParser(const std::string& text, const System& system, const RowsOfPaths& rows)
      : text_(text), system_(system), rows_(rows) {
    property_.text = text;
  }

  Result<Property> run_expression() {
    property_.root = parse_expression(1, 0);
    skip_blanks();
    if (problem_.empty() && at_ != text_.size()) set_problem("this does not belong to the expression");
    property_.fault = fault_of(property_.root);
    if (!problem_.empty()) return Failure{problem_};
    return std::move(property_);
  }

  Result<ParsedProperty> run_formula() {
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

  Result<Property> run() {
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
  Result<Property> run_value() {
    parse_whole("this does not belong to the expression");
    if (problem_.empty() && !is_numeric(type(property_.root)) && type(property_.root) != Type::Bool)
      set_problem("a number or a condition was expected, this is " + std::string(name_of(type(property_.root))));
    refuse_divisions("here");
    if (!problem_.empty()) return Failure{problem_};
    return std::move(property_);
  }

 private:
  // Where no state can be blamed for a fault.
  void refuse_divisions(const std::string& where) {
    if (!problem_.empty() || !division_at_) return;
    at_ = *division_at_;
    problem_.clear();
    set_problem("this division may fail: " + where + " the divisor is a number other than 0 and -1");
  }

  // A state has many runs before and after it, so a property with `possibly` does not speak of one.
  void refuse_words_of_one_run() {
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

  // `never at least 2 i in a: E`, `always at most 1 i in a: E`, `never F && exists i in a: E`.
  void note_counted() {
    const std::uint32_t made = last_counted_.made;
    if (made == Property::kNoRow || last_counted_.is_negated == property_.is_never) return;
    const PropertyNode& root = property_.nodes[property_.root];
    const bool joins = property_.is_never && root.kind == PropertyKind::Operator && root.op == Op::And;
    if (joins && (root.a == made || root.b == made)) last_counted_.counted.beside = root.a == made ? root.b : root.a;
    else if (property_.root != made) return;
    property_.counted = std::move(last_counted_.counted);
  }

  void parse_whole(const char* about_the_rest) {
    property_.root = parse_expression(1, 0);
    skip_blanks();
    if (problem_.empty() && at_ != text_.size()) set_problem(about_the_rest);
  }
  Result<Property> fail(const std::string& why) {
    set_problem(why);
    return Failure{problem_};
  }
  void skip_blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n')) ++at_;
  }
  bool take_sign(std::string_view sign) {
    skip_blanks();
    if (text_.compare(at_, sign.size(), sign) != 0) return false;
    at_ += sign.size();
    return true;
  }
  // "a", "a[3].b"; empty: no name here. Of an index that names bound variables, its value.
  std::string parse_path() {
    skip_blanks();
    std::string path;
    while (at_ < text_.size() && begins_name(text_[at_])) {
      while (at_ < text_.size() && (begins_name(text_[at_]) || is_digit(text_[at_]))) path += text_[at_++];
      while (at_ < text_.size() && text_[at_] == '[') {
        std::size_t end = at_ + 1;
        while (end < text_.size() && is_digit(text_[end])) ++end;
        if (end > at_ + 1 && end < text_.size() && text_[end] == ']') {
          path.append(text_, at_, end + 1 - at_);
          at_ = end + 1;
        } else if (bound_.is_empty() || !take_index(path)) {
          return path;
        }
      }
      if (at_ + 1 >= text_.size() || text_[at_] != '.' || !begins_name(text_[at_ + 1])) break;
      path += text_[at_++];
    }
    return path;
  }
  [[nodiscard]] std::optional<std::int64_t> evaluate(std::size_t& at) const {
    return system::evaluate_index(text_, at, [this](std::string_view name) { return bound_.value_of(name); });
  }
  // `[(i + 1) % 3]` behind the path. False: it has no value.
  bool take_index(std::string& path) {
    std::size_t at = at_ + 1;
    const std::optional<std::int64_t> index = evaluate(at);
    at = std::min(text_.find_first_not_of(" \t\n", at), text_.size());
    if (!index || at == text_.size() || text_[at] != ']') {
      set_problem("this index is no number: it may name variables that are bound around it");
      return false;
    }
    if (*index < 0) {
      set_problem("an index is at least 0, this is " + std::to_string(*index));
      return false;
    }
    path += '[' + std::to_string(*index) + ']';
    at_ = at + 1;
    return true;
  }
  static std::uint32_t find_path(const RowsByPath& rows, const std::string& path) {
    const auto found = rows.find(rt::whole_path(path));
    return found == rows.end() ? kNotFound : found->second;
  }
  [[nodiscard]] std::uint32_t find_atom(const std::string& path) const { return find_path(rows_.atoms, path); }
  template <class Rows>
  static std::uint32_t find_row(const Rows& rows, const std::string& name) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (rows[k].name == name) return static_cast<std::uint32_t>(k);
    }
    return kNotFound;
  }
  const AtomType& type_of(std::uint32_t atom) const {
    return system_.atom_types[system_.atoms[AtomId(std::size_t{atom})].type];
  }

  std::uint32_t parse_reference(const std::string& name, std::size_t start) {
    const auto wrong = [&](const std::string& why) {
      at_ = start;
      set_problem(why);
      return 0u;
    };
    if (take_sign("@")) {
      const std::uint32_t atom = find_atom(name);
      if (atom == kNotFound) return wrong("there is no component `" + name + "`");
      const std::string place = parse_path();
      if (place.empty()) return wrong("a place of `" + name + "` is missing behind `@`");
      const std::vector<std::string>& places = type_of(atom).places;
      for (std::size_t k = 0; k < places.size(); ++k) {
        if (places[k] == place)
          return add({.kind = PropertyKind::At, .owner = atom, .row = static_cast<std::uint32_t>(k)});
      }
      return wrong("there is no place `" + place + "` in `" + name + "`");
    }
    const std::size_t dot = name.rfind('.');
    const std::uint32_t atom = dot == std::string::npos ? kNotFound : find_atom(name.substr(0, dot));
    for (const OtherSign& other : kOtherFunctions) {
      if (name == other.sign) return wrong(std::string(other.word));
    }
    if (!accepts_formulas_ && name == "possibly")
      return wrong("`possibly` asks what may follow a state, which `bipc verify --property` answers");
    // The first word of all.
    if (accepts_formulas_ && start == 0 && dot == std::string::npos)
      return wrong("a property starts with `never`, `always`, `eventually` or a condition, not with `" + name + "`");
    if (atom == kNotFound) return wrong("`" + name + "` is no data: COMPONENT.DATA, or COMPONENT@PLACE");
    const std::uint32_t variable = find_row(type_of(atom).variables, name.substr(dot + 1));
    if (variable == kNotFound)
      return wrong("there is no data `" + name.substr(dot + 1) + "` in `" + name.substr(0, dot) + "`");
    const Type cell_type = type_of(atom).variables[variable].type;
    if (is_ffi(cell_type)) return wrong("`" + name + "` is a C++ object");
    return add({.kind = PropertyKind::Data, .type = cell_type, .owner = atom, .row = variable});
  }
  // `can` or `happens`.
  std::uint32_t parse_offer(std::size_t start, PropertyKind of_connector, PropertyKind of_port) {
    if (of_connector == PropertyKind::HappensConnector && !happens_at_) happens_at_ = start;
    const std::string name = parse_path();
    const std::uint32_t connector = find_path(rows_.connectors, name);
    if (connector != kNotFound) {
      if (system_.is_top(ConnectorId(std::size_t{connector}))) return add({.kind = of_connector, .owner = connector});
      at_ = start;
      set_problem("connector `" + name + "` exports a port: it is a part of others");
      return 0;
    }
    const std::size_t dot = name.rfind('.');
    const std::uint32_t atom = dot == std::string::npos ? kNotFound : find_atom(name.substr(0, dot));
    const std::uint32_t port = atom == kNotFound ? kNotFound : find_row(type_of(atom).ports, name.substr(dot + 1));
    if (port != kNotFound) return add({.kind = of_port, .owner = atom, .row = port});
    at_ = start;
    set_problem("there is no connector and no port `" + name + "`");
    return 0;
  }

  std::uint32_t parse_string() {
    std::string value;
    while (at_ < text_.size() && text_[at_] != '"') value += text_[at_++];
    if (!take_sign("\"")) set_problem("this string has no end");
    PropertyNode node{.type = Type::String, .int_value = -1};
    for (std::size_t k = 0; k < system_.code.strings.size(); ++k) {
      if (system_.code.strings[k] == value) node.int_value = static_cast<std::int32_t>(k);
    }
    if (value.empty()) node.int_value = 0;
    return add(node);
  }
  // As in models: "3", "1.5", ".5", "2.", "1e3".
  std::uint32_t parse_number() {
    const std::size_t first = at_;
    const auto skip_digits = [&] {
      while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
    };
    skip_digits();
    bool is_float = at_ < text_.size() && text_[at_] == '.';
    if (is_float) ++at_;
    skip_digits();
    if (at_ < text_.size() && (text_[at_] == 'e' || text_[at_] == 'E')) {
      std::size_t digits = at_ + 1;
      if (digits < text_.size() && (text_[digits] == '+' || text_[digits] == '-')) ++digits;
      if (digits < text_.size() && is_digit(text_[digits])) {
        is_float = true;
        at_ = digits;
        skip_digits();
      }
    }
    PropertyNode node{.type = is_float ? Type::Float : Type::Int};
    const char* begin = text_.data() + first;
    const char* end = text_.data() + at_;
    const bool fits = is_float ? std::from_chars(begin, end, node.float_value).ec == std::errc()
                               : std::from_chars(begin, end, node.int_value).ec == std::errc();
    if (!fits) {
      at_ = first;
      set_problem(is_float ? "this number does not fit a `float`" : "this number does not fit an `int`");
    }
    return add(node);
  }
  [[nodiscard]] bool is_at_number() const {
    const std::size_t digit = at_ < text_.size() && text_[at_] == '.' ? at_ + 1 : at_;
    return digit < text_.size() && is_digit(text_[digit]);
  }

  std::uint32_t parse_operand(int depth) {
    if (depth > kMaxPropertyDepth) {
      set_problem("nested too deeply");
      return 0;
    }
    skip_blanks();
    const std::size_t start = at_;
    if (take_sign("(")) {
      const std::uint32_t inside = accepts_formulas_ ? parse_formula(depth + 1) : parse_expression(1, depth + 1);
      if (!take_sign(")")) {
        set_problem(word_at(at_) == "under" ? "`under` stands behind a whole property" : "a `)` is missing");
      }
      return inside;
    }
    if (take_sign("!")) return make_unary(Op::Not, parse_operand(depth + 1), start);
    if (take_sign("~")) return make_unary(Op::BitNot, parse_operand(depth + 1), start);
    if (take_sign("-")) return make_unary(Op::Neg, parse_operand(depth + 1), start);
    if (take_sign("\"")) return parse_string();
    if (is_at_number()) return parse_number();
    if (accepts_formulas_ && is_misplaced()) return 0;
    if (const std::optional<IndexQuantifier> quantifier = take_quantifier())
      return parse_quantified(*quantifier, depth);
    if (!problem_.empty()) return 0;
    const std::string name = parse_path();
    if (!problem_.empty()) return 0;
    if (const std::optional<std::int64_t> value = bound_.value_of(name); value && !is_next('@'))
      return constant(Type::Int, static_cast<std::int32_t>(*value));
    if (name == "true" || name == "false") return add({.int_value = name == "true" ? 1 : 0});
    if (name == "can") return parse_offer(start, PropertyKind::CanConnector, PropertyKind::CanPort);
    if (accepts_formulas_ && name == "happens" && !is_next('@'))
      return parse_offer(start, PropertyKind::HappensConnector, PropertyKind::HappensPort);
    if (name.empty()) {
      set_problem(at_ == text_.size() ? "the property ends too early" : "a value was expected here");
      return 0;
    }
    return parse_reference(name, start);
  }
  std::uint32_t make_unary(Op op, std::uint32_t a, std::size_t start) {
    const bool fits = takes(info_of(op).operands, type(a));
    if (!fits && problem_.empty()) {
      at_ = start;
      set_problem(op == Op::Not      ? "`!` needs a truth value"
                  : op == Op::BitNot ? "`~` needs an int"
                                     : "`-` needs a number");
    }
    if (fits && is_folded(a)) return constant(type(a), fold_int(op, property_.nodes[a].int_value));
    return add({.kind = PropertyKind::Operator, .type = type(a), .op = op, .a = a, .b = a});
  }
  std::uint32_t parse_expression(int level, int depth) {
    const std::size_t mark = property_.nodes.size();
    std::uint32_t left = parse_operand(depth);
    while (problem_.empty()) {
      skip_blanks();
      const std::size_t start = at_;
      // No subtraction of what is greater.
      if (accepts_formulas_ && (text_.compare(at_, 2, "->") == 0 || text_.compare(at_, 3, "-->") == 0)) return left;
      const BinaryOperator* found = nullptr;
      for (const BinaryOperator& binary : binary_operators()) {
        if (found == nullptr && text_.compare(at_, binary.sign.size(), binary.sign) == 0) found = &binary;
      }
      if (found == nullptr || found->level < level) return left;
      at_ += found->sign.size();
      const std::uint32_t right = parse_expression(found->level + 1, depth + 1);
      if (!problem_.empty()) return left;
      left = make_binary(*found, left, right, start, mark);
    }
    return left;
  }
  // `mark`: the operands are the rows from there on.
  std::uint32_t make_binary(const BinaryOperator& binary, std::uint32_t a, std::uint32_t b, std::size_t start,
                            std::size_t mark) {
    const bool numbers = is_numeric(type(a)) && is_numeric(type(b));
    const OperandTypes operands = info_of(binary.op).operands;
    if (problem_.empty() && binary.op != Op::And && binary.op != Op::Or && (is_temporal(a) || is_temporal(b))) {
      at_ = start;
      set_problem("`" + std::string(binary.sign) + "` compares values of one state, not what happens in a run");
    }
    const bool fits = operands == OperandTypes::Native ? numbers || type(a) == type(b)
                                                       : takes(operands, type(a)) && takes(operands, type(b));
    const bool is_float = type(a) == Type::Float || type(b) == Type::Float;
    const Type result = result_of(binary.op, is_float ? Type::Float : Type::Int);
    if (!fits && problem_.empty()) {
      at_ = start;
      set_problem("`" + std::string(binary.sign) + "` does not take " + name_of(type(a)) + " and " + name_of(type(b)) +
                  hint_of(binary.op, property_.nodes[a]));
    }
    if (is_division(binary.op) && result == Type::Int && problem_.empty()) {
      const std::optional<std::int32_t> divisor = constant_of(b);
      if (!divisor || *divisor == 0 || *divisor == -1) division_at_ = start;
    }
    if (binary.op == Op::And || binary.op == Op::Or) return join(binary.op, a, b, mark);
    if (problem_.empty() && is_folded(a) && is_folded(b) && type(a) == Type::Int) {
      const std::int32_t left = property_.nodes[a].int_value, right = property_.nodes[b].int_value;
      if (!is_division(binary.op) || !division_faults(left, right)) {
        forget_from(mark);
        return constant(result, fold_int(binary.op, left, right));
      }
    }
    return add({.kind = PropertyKind::Operator, .type = result, .op = binary.op, .a = a, .b = b});
  }

  // ---- quantifiers
  // `forall` and the others, unless they are names.
  std::optional<IndexQuantifier> take_quantifier() {
    const std::size_t start = at_;
    for (const QuantifierWord& quantifier : kQuantifiers) {
      if (!take_words(quantifier.word)) continue;
      const char next = is_next('(') ? '(' : at_ < text_.size() ? text_[at_] : '\0';
      if (begins_name(next) || is_digit(next) || next == '(') return quantifier.meaning;
      at_ = start;
    }
    return std::nullopt;
  }
  std::optional<std::int64_t> parse_index(const char* what) {
    skip_blanks();
    const std::size_t start = at_;
    const std::optional<std::int64_t> value = evaluate(at_);
    if (value) return value;
    at_ = start;
    set_problem(what);
    return std::nullopt;
  }
  struct Positions {
    std::int64_t low = 0, high = 0;  // `high` excluded
  };
  // `0..n`, or an array.
  Positions parse_range() {
    skip_blanks();
    const std::size_t start = at_;
    if (begins_name(at_ < text_.size() ? text_[at_] : '\0')) {
      const std::string path = parse_path();
      if (!bound_.value_of(path)) {
        if (const std::uint32_t size = rows_.size_of_array(rt::whole_path(path)); size != 0) return {0, size};
        at_ = start;
        set_problem("there is no array of components `" + path + "`");
        return {};
      }
      at_ = start;
    }
    const std::optional<std::int64_t> low = parse_index("a range was expected: `0..3`, or an array of components");
    if (low && !take_sign("..")) set_problem("a range has two bounds: `0..3`");
    const std::optional<std::int64_t> high = low ? parse_index("the upper bound of a range was expected") : low;
    return low && high ? Positions{*low, *high} : Positions{};
  }
  // Behind the quantifier's word. At the beginning of a formula it reaches over one, else over an expression.
  std::uint32_t parse_quantified(IndexQuantifier quantifier, int depth, bool is_formula = false) {
    const std::size_t start = at_;
    const auto wrong = [&](std::size_t at, const std::string& why) {
      at_ = at;
      set_problem(why);
      return 0u;
    };
    const std::string forms = "quantifiers are written " + std::string(kQuantifierForms);
    const std::optional<std::int64_t> limit = counts(quantifier) ? parse_index("a number was expected") : std::nullopt;
    if (!problem_.empty()) return 0;
    skip_blanks();
    const std::size_t name_at = at_;
    const std::string name = parse_path();
    if (name.empty() || name.find_first_of(".[") != std::string::npos || !take_words("in")) return wrong(start, forms);
    const Positions range = parse_range();
    if (!problem_.empty()) return 0;
    if (!take_sign(":")) return wrong(at_, "a `:` was expected; " + forms);
    const std::size_t body = at_, mark = property_.nodes.size();
    std::vector<std::uint32_t> rows;
    std::size_t known = 0;  // of counted ones: true whatever the state
    ++quantifiers_;
    bool is_decided = false;
    for (std::int64_t value = range.low; value < range.high && !is_decided && problem_.empty(); ++value) {
      at_ = body;
      if (++rounds_ > kMaxRounds) return wrong(name_at, "there are too many values of variables");
      bound_.bind(name, value);
      const std::size_t before = property_.nodes.size();
      const std::uint32_t row = is_formula ? parse_formula(depth + 1) : parse_expression(1, depth + 1);
      const bool is_constant = is_folded(row) && type(row) == Type::Bool;
      bound_.release();
      if (problem_.empty() && (type(row) != Type::Bool || (counts(quantifier) && is_temporal(row))))
        return wrong(body, counts(quantifier) ? "conditions on one state are counted"
                                              : "a condition was expected, this is " + std::string(name_of(type(row))));
      if (!is_constant || !problem_.empty()) {
        rows.push_back(row);
        continue;
      }
      const bool is_true = property_.nodes[row].int_value != 0;
      forget_from(before);
      if (counts(quantifier)) known += is_true ? 1 : 0;
      else is_decided = is_true == (quantifier == IndexQuantifier::Exists);
    }
    if (range.low >= range.high) at_ = end_of_body(text_, body, is_formula ? Reach::Formula : Reach::Expression);
    const std::uint32_t made = problem_.empty() ? join_all(quantifier, rows, limit, known, is_decided, mark) : 0;
    --quantifiers_;
    return made;
  }
  [[nodiscard]] bool is_next(char c) {
    skip_blanks();
    return at_ < text_.size() && text_[at_] == c;
  }
  // Takes the words if they stand here: `leads to`, and no `leads.to`, `leads@to`, `leadsto`.
  bool take_words(std::string_view words) {
    const std::size_t start = at_;
    for (std::size_t from = 0; from <= words.size();) {
      const std::size_t end = std::min(words.find(' ', from), words.size());
      if (parse_path() != words.substr(from, end - from) || is_next('@')) {
        at_ = start;
        return false;
      }
      from = end + 1;
    }
    return true;
  }
  // A sign of another notation or a word of time where a value was expected: said. False: none is here.
  bool is_misplaced() {
    const std::size_t start = at_;
    for (const OtherSign& other : kOtherPrefixes) {
      if (begins_name(other.sign.back()) ? !take_words(other.sign) : !take_sign(other.sign)) continue;
      at_ = start;
      set_problem("`" + std::string(other.sign) + "` is written `" + std::string(other.word) + "`");
      return true;
    }
    at_ = start;
    for (const TemporalWord& prefix : kPrefixes) {
      if (!take_words(prefix.word)) continue;
      at_ = start;
      set_problem("`" + std::string(prefix.word) + "` inside of an expression needs parentheses: `(" +
                  std::string(prefix.word) + " …)`");
      return true;
    }
    return false;
  }

  // `start`: of its text, which ends here; `word`: where its word stands.
  std::uint32_t add_temporal(TemporalOperator op, std::uint32_t a, std::uint32_t b, std::size_t start,
                             std::size_t word) {
    if (op == TemporalOperator::Possibly && !possibly_at_) possibly_at_ = word;
    if (is_of_past(op) && !past_at_) past_at_ = word;
    const std::uint32_t row = add({.kind = PropertyKind::Temporal, .temporal = op, .a = a, .b = b});
    extents_[row] = {start, text_.find_last_not_of(" \t\n", at_ - 1) + 1};
    return row;
  }
  // `under weak:p.enter, strong:leaves` behind a whole property: to the end of the text.
  std::optional<Fairness> take_fairness() {
    if (!problem_.empty() || !take_words("under")) return std::nullopt;
    Result<Fairness> read = read_fairness(text_, at_, system_, rows_);
    at_ = text_.size();
    if (!read) problem_ = read.error();
    return read ? std::optional(std::move(*read)) : std::nullopt;
  }
  // What stands behind a whole property.
  std::string about_rest() {
    const std::size_t start = at_;
    const bool is_within = take_words("within");
    at_ = start;
    return is_within ? "`within` bounds `eventually` and `leads to`" : "this does not belong to the property";
  }
  // `within 50 ms` behind the operands of `eventually` or `leads to`, whose node is the next one.
  void take_within(std::uint32_t a, std::uint32_t b) {
    skip_blanks();
    const std::size_t start = at_;
    if (!problem_.empty() || !take_words("within")) return;
    skip_blanks();
    const std::size_t number = at_;
    std::string time;
    while (at_ < text_.size() && is_digit(text_[at_])) {
      while (at_ < text_.size() && is_digit(text_[at_])) time += text_[at_++];
      skip_blanks();
      while (at_ < text_.size() && is_letter(text_[at_])) time += text_[at_++];
      // `1 s 500 ms`
      const std::size_t behind = at_;
      skip_blanks();
      if (at_ >= text_.size() || !is_digit(text_[at_])) at_ = behind;
    }
    const std::int64_t ticks = rt::parse_time(time);
    const bool is_second = within_.has_value();
    if (ticks < 0) {
      at_ = number;
      set_problem("a time was expected, such as `50 ms`; its units are s, ms, us and ns");
    } else if (is_second || !system::is_timed(system_) || looks_ahead_[a] != 0 || looks_ahead_[b] != 0 ||
               is_of_past_[a] != 0 || is_of_past_[b] != 0) {
      at_ = start;
      set_problem(is_second                    ? kWithinAlone
                  : !system::is_timed(system_) ? "`within` bounds a time, and the model has no clocks"
                                               : "`within` is about conditions and `happens`, not about what else "
                                                 "comes or has been");
    }
    within_ = ticks;
    within_at_ = start;
    within_row_ = static_cast<std::uint32_t>(property_.nodes.size());
  }
  // The operand of a word; what looks back is decided by what has been.
  bool check_operand(std::string_view word, TemporalOperator op, std::uint32_t row, std::size_t start) {
    if (!check_condition(row, start)) return false;
    if (!is_of_past(op) || looks_ahead_[row] == 0) return true;
    at_ = start;
    set_problem("`" + std::string(word) + "` looks back, and this looks ahead");
    return false;
  }
  bool check_condition(std::uint32_t row, std::size_t start) {
    if (problem_.empty() && type(row) != Type::Bool) {
      skip_blanks();
      const bool goes_on = at_ < text_.size() && !begins_name(text_[at_]) && text_[at_] != ')';
      if (goes_on) {
        set_problem("this does not belong to the property");
        return false;
      }
      at_ = start;
      set_problem("a condition was expected, this is " + std::string(name_of(type(row))));
    }
    return problem_.empty();
  }

  // What words before it and C's operators make; `has_prefix`: it begins with a word.
  std::uint32_t parse_prefixed(int depth, bool& has_prefix) {
    if (depth > kMaxPropertyDepth) {
      set_problem("nested too deeply");
      return 0;
    }
    skip_blanks();
    const std::size_t start = at_;
    for (const TemporalWord& prefix : kPrefixes) {
      if (!take_words(prefix.word)) continue;
      has_prefix = true;
      skip_blanks();
      const std::size_t operand = at_;
      const bool has_parentheses = is_next('(');
      bool is_prefixed = false;
      const std::uint32_t a = parse_prefixed(depth + 1, is_prefixed);
      if (!check_operand(prefix.word, prefix.meaning, a, operand)) return 0;
      // `eventually (always a) && b`: of the whole, or of the first part? A pair of parentheses around the whole leaves
      // an operator whose row is older than the closing sign.
      const PropertyNode& node = property_.nodes[a];
      if (has_parentheses && !is_prefixed && node.kind == PropertyKind::Operator && node.op != Op::Not &&
          is_temporal(a) && !closes_at_end(operand)) {
        at_ = start;
        set_problem("does `" + std::string(prefix.word) + "` reach to the end? Write `" + std::string(prefix.word) +
                    " (… " + std::string(symbol_of(node.op)) + " …)` or `(" + std::string(prefix.word) + " …) " +
                    std::string(symbol_of(node.op)) + " …`");
        return 0;
      }
      if (prefix.meaning == TemporalOperator::Eventually) take_within(a, a);
      return add_temporal(prefix.meaning, a, a, start, start);
    }
    return parse_expression(1, depth);
  }
  // Is the text from `start` to here one pair of parentheses?
  [[nodiscard]] bool closes_at_end(std::size_t start) const {
    int open = 0;
    for (std::size_t at = start; at < at_; ++at) {
      if (text_[at] == '(') ++open;
      if (text_[at] == ')' && --open == 0) return text_.find_first_not_of(" \t\n", at + 1) >= at_;
    }
    return false;
  }
  std::string word_at(std::size_t start) const {
    return text_.substr(start, text_.find_first_of(" \t\n", start) - start);
  }
  // What `always A implies B` can mean, by the place of `always`.
  std::string both_readings(std::size_t prefix, std::string_view connective) const {
    const std::string first = word_at(prefix), then(connective);
    return "`" + first + " (… " + then + " …)` or `(" + first + " …) " + then + " …`";
  }
  std::uint32_t parse_formula(int depth) {
    skip_blanks();
    const std::size_t start = at_, mark = property_.nodes.size();
    if (const std::optional<IndexQuantifier> quantifier = take_quantifier())
      return parse_quantified(*quantifier, depth + 1, !counts(*quantifier));
    bool has_prefix = false;
    const std::uint32_t left = parse_prefixed(depth, has_prefix);
    if (!problem_.empty()) return 0;
    skip_blanks();
    const std::size_t middle = at_;
    for (const OtherSign& other : kOtherConnectives) {
      if (begins_name(other.sign.front()) ? !take_words(other.sign) : !take_sign(other.sign)) continue;
      at_ = middle;
      set_problem("`" + std::string(other.sign) + "` is written `" + std::string(other.word) + "`" +
                  (has_prefix ? ": " + both_readings(start, other.word) : std::string()));
      return 0;
    }
    const TemporalWord* found = nullptr;
    for (const TemporalWord& word : kConnectives) {
      if (found == nullptr && take_words(word.word)) found = &word;
    }
    const bool is_implication = found == nullptr && take_words("implies");
    if (found == nullptr && !is_implication) return left;
    const std::string word(is_implication ? "implies" : found->word);
    if (has_prefix) {
      at_ = middle;
      set_problem("does `" + word_at(start) + "` reach over `" + word + "`? Write " + both_readings(start, word));
      return 0;
    }
    skip_blanks();
    const std::size_t behind = at_;
    bool is_prefixed = false;
    const std::uint32_t right = parse_prefixed(depth + 1, is_prefixed);
    const TemporalOperator meaning = found == nullptr ? TemporalOperator::Always : found->meaning;
    if (!check_operand(word, meaning, left, start) || !check_operand(word, meaning, right, behind)) return 0;
    if (meaning == TemporalOperator::LeadsTo) take_within(left, right);
    skip_blanks();
    const std::size_t end = at_;
    for (const std::string_view next : {"leads to", "until", "unless", "since", "implies"}) {
      if (!take_words(next)) continue;
      at_ = end;
      set_problem("`" + word + "` and `" + std::string(next) + "` need parentheses: which comes first?");
      return 0;
    }
    if (!is_implication) return add_temporal(found->meaning, left, right, start, middle);
    if (is_folded(left)) {
      if (property_.nodes[left].int_value != 0) return right;
      forget_from(mark);
      return constant(Type::Bool, 1);
    }
    const std::uint32_t negated = make_not(left);
    return add({.kind = PropertyKind::Operator, .op = Op::Or, .a = negated, .b = right});
  }

  static constexpr std::uint32_t kNotFound = 0xffffffffu;
  const std::string& text_;
  const System& system_;
  const RowsOfPaths& rows_;
  // The first word of its kind.
  std::optional<std::size_t> possibly_at_, past_at_, happens_at_;
  bool accepts_formulas_ = false;
  // Of the last `within`: ns, the row of what it bounds, its place.
  std::optional<std::int64_t> within_;
  std::uint32_t within_row_ = 0;
  std::size_t within_at_ = 0;
  std::size_t rounds_ = 0;                  // values of variables
  std::optional<std::size_t> division_at_;  // the last one that may fault
};

}  // namespace

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
