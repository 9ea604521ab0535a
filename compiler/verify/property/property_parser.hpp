// The parser of properties: a class whose members have a file for each topic. Internal to compiler/verify/property.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "compiler/base/result.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/property/binary_operators.hpp"
#include "compiler/verify/property/fairness.hpp"
#include "compiler/verify/property/formula.hpp"
#include "compiler/verify/property/property.hpp"
#include "compiler/verify/property/property_rows.hpp"
#include "compiler/verify/property/rows_of_paths.hpp"

namespace bip::verify {

/// The arguments must outlive the parser, which reads one property.
class PropertyParser : private PropertyRows {
 public:
  PropertyParser(const std::string& text, const System& system, const RowsOfPaths& rows)
      : PropertyRows(text), system_(system), rows_(rows) {
    property_.text = text;
  }

  /// `never E`, `always E`.
  Result<Property> run();
  /// A property of any form.
  Result<ParsedProperty> run_formula();
  /// An expression: of any type; a number or a condition.
  Result<Property> run_expression();
  Result<Property> run_value();

 private:
  static constexpr int kMaxPropertyDepth = 200;

  // ---- the whole (parse_property.cpp)

  // Where no state can be blamed for a fault.
  void refuse_divisions(const std::string& where);
  // A state has many runs before and after it, so a property with `possibly` does not speak of one.
  void refuse_words_of_one_run();
  // `never at least 2 i in a: E`, `always at most 1 i in a: E`, `never F && exists i in a: E`.
  void note_counted();
  void parse_whole(const char* about_the_rest);
  Result<Property> fail(const std::string& why);
  // `under weak:p.enter, strong:leaves` behind a whole property: to the end of the text.
  std::optional<Fairness> take_fairness();
  // What stands behind a whole property.
  std::string about_rest();

  // ---- words of runs and of branching time (parse_formula.cpp)

  std::uint32_t parse_formula(int depth);
  // What words before it and C's operators make; `has_prefix`: it begins with a word.
  std::uint32_t parse_prefixed(int depth, bool& has_prefix);
  // `within 50 ms` behind the operands of `eventually` or `leads to`, whose node is the next one.
  void take_within(std::uint32_t a, std::uint32_t b);
  // `start`: of its text, which ends here; `word`: where its word stands.
  std::uint32_t add_temporal(TemporalOperator op, std::uint32_t a, std::uint32_t b, std::size_t start,
                             std::size_t word);
  // The operand of a word; what looks back is decided by what has been.
  bool check_operand(std::string_view word, TemporalOperator op, std::uint32_t row, std::size_t start);
  bool check_condition(std::uint32_t row, std::size_t start);
  // A sign of another notation or a word of time where a value was expected: said. False: none is here.
  bool is_misplaced();
  // Is the text from `start` to here one pair of parentheses?
  [[nodiscard]] bool closes_at_end(std::size_t start) const;
  // What `always A implies B` can mean, by the place of `always`.
  [[nodiscard]] std::string both_readings(std::size_t prefix, std::string_view connective) const;

  // ---- expressions (parse_expression.cpp)

  std::uint32_t parse_expression(int level, int depth);
  std::uint32_t parse_operand(int depth);
  std::uint32_t make_unary(Op op, std::uint32_t a, std::size_t start);
  // `mark`: the operands are the rows from there on.
  std::uint32_t make_binary(const BinaryOperator& binary, std::uint32_t a, std::uint32_t b, std::size_t start,
                            std::size_t mark);

  // ---- quantifiers (parse_quantified.cpp)

  // `forall` and the others, unless they are names.
  std::optional<IndexQuantifier> take_quantifier();
  // Behind the quantifier's word. At the beginning of a formula it reaches over one, else over an expression.
  std::uint32_t parse_quantified(IndexQuantifier quantifier, int depth, bool is_formula = false);
  struct Positions {
    std::int64_t low = 0, high = 0;  // `high` excluded
  };
  // `0..n`, or an array.
  Positions parse_range();
  std::optional<std::int64_t> parse_index(const char* what);

  // ---- names and constants (parse_reference.cpp)

  std::uint32_t parse_reference(const std::string& name, std::size_t start);
  // Does `== x.text` follow, for a variable that is a string?
  [[nodiscard]] bool is_before_text();
  // `can` or `happens`.
  std::uint32_t parse_offer(std::size_t start, PropertyKind of_connector, PropertyKind of_port);
  std::uint32_t parse_string();
  // As in models: "3", "1.5", ".5", "2.", "1e3".
  std::uint32_t parse_number();
  [[nodiscard]] std::uint32_t find_atom(const std::string& path) const;
  [[nodiscard]] const AtomType& type_of(std::uint32_t atom) const;

  const System& system_;
  const RowsOfPaths& rows_;
  // The first word of its kind.
  std::optional<std::size_t> possibly_at_, past_at_, happens_at_;
  bool accepts_formulas_ = false;
  bool is_beside_text_ = false;  // what is parsed is compared with a string that stands before it
  // Of the last `within`: ns, the row of what it bounds, its place.
  std::optional<std::int64_t> within_;
  std::uint32_t within_row_ = 0;
  std::size_t within_at_ = 0;
  std::size_t rounds_ = 0;                  // values of variables
  std::optional<std::size_t> division_at_;  // the last one that may fault
};

}  // namespace bip::verify
