// Classifies words whose kind depends on their neighbours: one left-to-right pass with at most three tokens of
// lookahead.
//
// The late words of BIP2 and the words of the paper's notation are names in older models, so they become keywords only
// if the following tokens require it. The pass also marks the words that begin declarations of a package (`port type`,
// `connector type`, a paper `component`), which makes the grammar nearly LL(1) and lets the parser detect a missing
// `end`. The state of the pass is the kind of the current declaration, known from the marked words and `end`.
#include <algorithm>

#include "BipLexer.h"
#include "antlr4-runtime.h"
#include "compiler/parse/token_list.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {
namespace {

using antlr::BipLexer;
constexpr std::size_t kNoToken = 0;

bool is_one_of(std::size_t type, std::initializer_list<std::size_t> types) {
  return std::find(types.begin(), types.end(), type) != types.end();
}
/// A name, or a word that this pass may still turn into one.
bool may_be_name(std::size_t type) {
  return is_name(type) || is_one_of(type, {BipLexer::BEHAVIOR, BipLexer::STATE, BipLexer::CONTAINS, BipLexer::FOR,
                                           BipLexer::IN, BipLexer::NOT_WORD});
}

class Classifier {
 public:
  Classifier(const std::vector<TokenRow>& in, std::string_view text) : in_(in), text_(text) { out_.reserve(in.size()); }

  std::vector<TokenRow> run() { return run(in_.size()); }
  /// Of the first tokens only; the others are looked at.
  std::vector<TokenRow> run(std::size_t count) {
    for (at_ = 0; at_ < count; ++at_) classify(in_[at_]);
    return std::move(out_);
  }
  [[nodiscard]] bool is_between_declarations() const { return region_ == Region::None && open_ == 0 && braces_ == 0; }
  [[nodiscard]] bool looked_behind_the_end() const { return looked_behind_the_end_; }

 private:
  enum class Region { None, Connector, Atom, Compound, Component };

  [[nodiscard]] std::size_t ahead(std::size_t n) const {
    if (at_ + n < in_.size()) return in_[at_ + n].type;
    looked_behind_the_end_ = true;
    return kNoToken;
  }
  [[nodiscard]] std::size_t previous() const { return out_.empty() ? kNoToken : out_.back().type; }
  void push(TokenRow row, std::size_t type) {
    row.type = type;
    out_.push_back(row);
  }
  void enter(Region region, int open) {
    region_ = region;
    open_ = open;
    part_ = Part::Head;
    on_ = end_ = {};
  }

  void classify(const TokenRow& row) {
    switch (row.type) {
      case BipLexer::LBRACK: {
        const bool touches = !out_.empty() && out_.back().end == row.begin && is_name(previous());
        return push(row, touches ? BipLexer::LBRACK : BipLexer::GROUP_OPEN);
      }
      case BipLexer::PORT:
        if (ahead(1) != BipLexer::TYPE) break;
        enter(Region::None, 0);
        return push(row, BipLexer::PORT_DECL);
      case BipLexer::CONNECTOR:
        if (ahead(1) != BipLexer::TYPE) break;
        enter(Region::Connector, 1);
        return push(row, BipLexer::CONNECTOR_DECL);
      case BipLexer::EXTERN:
        if (!is_one_of(ahead(1), {BipLexer::DATA, BipLexer::FUNCTION, BipLexer::OPERATOR})) break;
        enter(Region::None, 0);
        return push(row, BipLexer::EXTERN_DECL);
      case BipLexer::FUNCTION:
        if (previous() != BipLexer::EXTERN_DECL) enter(Region::None, 0);
        break;
      case BipLexer::ATOM: enter(Region::Atom, 1); break;
      case BipLexer::COMPOUND: enter(Region::Compound, 1); break;
      case BipLexer::COMPONENT:
        if (!begins_component()) break;
        enter(Region::Component, 1);
        return push(row, BipLexer::COMPONENT_DECL);
      case BipLexer::ON:
        if (on_is_name()) return push_word_as_name(row, on_);
        begin_part(Part::Clause);
        break;
      case BipLexer::END:
        if (end_is_name()) return push_word_as_name(row, end_);
        if (open_ > 0) --open_;
        if (open_ == 0) region_ = Region::None;
        break;
      case BipLexer::DEFINE: begin_part(Part::Define); break;
      case BipLexer::UP:
      case BipLexer::DOWN:
      case BipLexer::PROVIDED:
      case BipLexer::DATA:
      case BipLexer::EXPORT: begin_part(Part::Other); break;
      case BipLexer::BEHAVIOR:
        if (!begins_behavior()) return push(row, BipLexer::ID);
        ++open_;
        break;
      case BipLexer::STATE: return push(row, begins_state() ? BipLexer::STATE : BipLexer::ID);
      case BipLexer::CONTAINS: return push(row, begins_contains() ? BipLexer::CONTAINS : BipLexer::ID);
      case BipLexer::FOR:
        if (!may_be_name(ahead(1)) || ahead(2) != BipLexer::IN) return push(row, BipLexer::ID);
        in_of_for_ = at_ + 2;
        break;
      case BipLexer::IN: return push(row, in_of_for_ == at_ && at_ > 0 ? BipLexer::IN : BipLexer::ID);
      case BipLexer::NOT_WORD: return push(row, negates() ? BipLexer::NOT_WORD : BipLexer::ID);
      case BipLexer::DASHED: return push_dashed(row);
      case BipLexer::LBRACE:
        if (at_ == property_text_) return push_property_text(row);
        ++braces_;
        break;
      case BipLexer::RBRACE: --braces_; break;
      case BipLexer::ID:
        if (word_of(row) == "when" && ahead(1) == BipLexer::LPAREN && follows_part())
          return push(row, BipLexer::PROVIDED);
        if (begins_property(row)) return push(row, BipLexer::PROPERTY);
        if (word_of(row) == "reset" && may_be_name(ahead(1)) && follows_part()) return push(row, BipLexer::RESET);
        break;
      case BipLexer::INT_RANGE:
        push({0, row.begin, row.end - 2, row.line}, BipLexer::INT);
        return push({0, row.end - 2, row.end, row.line}, BipLexer::DOTDOT);
      default: break;
    }
    out_.push_back(row);
  }

  /// Where in a connector: its parameters, the interaction of `define`, that of a clause, anything else.
  enum class Part { Head, Define, Clause, Other };
  /// `on` or `end` as a name of the declaration at hand.
  struct WordAsName {
    bool is_parameter = false;  // of the connector
    bool is_used = false;       // in this part
    bool is_place = false;      // of the atom
  };

  void begin_part(Part part) {
    part_ = part;
    on_.is_used = end_.is_used = false;
  }
  void push_word_as_name(const TokenRow& row, WordAsName& word) {
    if (region_ == Region::Connector) (part_ == Part::Head ? word.is_parameter : word.is_used) = true;
    if (region_ == Region::Atom && is_one_of(previous(), {BipLexer::PLACE, BipLexer::COMMA})) word.is_place = true;
    push(row, BipLexer::ID);
  }
  /// A sign of an expression, which stands beside names and not beside keywords; `*` ends a side of a priority as well.
  [[nodiscard]] static bool is_operator(std::size_t type) {
    return is_one_of(type, {BipLexer::EQ, BipLexer::NE, BipLexer::LE, BipLexer::GE, BipLexer::GT, BipLexer::PLUS,
                            BipLexer::MINUS, BipLexer::STAR, BipLexer::SLASH, BipLexer::PERCENT, BipLexer::ANDAND,
                            BipLexer::OROR, BipLexer::AMP, BipLexer::PIPE, BipLexer::CARET});
  }
  /// Each parameter of a connector stands once in its interactions: a first `end` there is the parameter.
  [[nodiscard]] bool is_in_interaction(const WordAsName& word) const {
    if (region_ != Region::Connector || !word.is_parameter || word.is_used) return false;
    if (part_ == Part::Define) return true;
    return part_ == Part::Clause && (is_name(previous()) || previous() == BipLexer::COMMA);
  }

  /// What follows `on` and a port.
  [[nodiscard]] static bool continues_clause(std::size_t type) {
    return is_one_of(type, {BipLexer::FROM, BipLexer::TO, BipLexer::PROVIDED, BipLexer::UP, BipLexer::DOWN,
                            BipLexer::DO, BipLexer::COMMA, BipLexer::DOT}) ||
           may_be_name(type);
  }
  /// Older models name ports, their variables and places `on` and `end`: a keyword is followed by no punctuation and
  /// stands behind none that a name must follow.
  [[nodiscard]] bool stands_as_name() const {
    if (is_one_of(ahead(1), {BipLexer::LPAREN, BipLexer::RPAREN, BipLexer::COMMA, BipLexer::DOT, BipLexer::PRIME,
                             BipLexer::LT, BipLexer::ASSIGN}))
      return true;
    if (is_one_of(previous(), {BipLexer::DOT, BipLexer::LT, BipLexer::COLON})) return true;
    if (is_operator(ahead(1)) || (is_operator(previous()) && previous() != BipLexer::STAR) ||
        (braces_ > 0 && ahead(1) == BipLexer::SEMI))
      return true;
    if (previous() == BipLexer::DEFINE) return may_be_name(ahead(1));
    // The interaction of a clause ends with it.
    return region_ == Region::Connector && is_name(previous()) &&
           is_one_of(ahead(1), {BipLexer::UP, BipLexer::DOWN, BipLexer::PROVIDED});
  }
  [[nodiscard]] bool on_is_name() const {
    if (stands_as_name() || previous() == BipLexer::AS) return true;
    if (is_in_interaction(on_))
      return part_ == Part::Define || (ahead(1) == BipLexer::END ? end_.is_used || !end_.is_parameter
                                                                 : !may_be_name(ahead(1)) && ahead(1) != BipLexer::ON);
    if (previous() == BipLexer::ON)
      return continues_clause(ahead(1)) || is_one_of(ahead(1), {BipLexer::ON, BipLexer::END});
    return is_one_of(previous(), {BipLexer::FROM, BipLexer::TO, BipLexer::PLACE, BipLexer::COMMA}) &&
           !may_be_name(ahead(1));
  }
  [[nodiscard]] bool end_is_name() const {
    if (stands_as_name()) return true;
    if (is_in_interaction(end_)) return true;
    if (previous() == BipLexer::ON) return continues_clause(ahead(1)) || (part_ == Part::Clause && end_.is_parameter);
    if (region_ == Region::Atom || region_ == Region::Component) {
      if (is_one_of(previous(), {BipLexer::PLACE, BipLexer::COMMA}) &&
          is_one_of(ahead(1), {BipLexer::INITIAL, BipLexer::PORT, BipLexer::DATA, BipLexer::EXPORT, BipLexer::CLOCK,
                               BipLexer::PLACE}))
        return true;
      if (is_one_of(previous(), {BipLexer::FROM, BipLexer::TO, BipLexer::COMMA})) return end_.is_place;
    }
    return previous() == BipLexer::AS && is_one_of(ahead(1), {BipLexer::END, BipLexer::EXPORT, BipLexer::PRIORITY});
  }
  [[nodiscard]] std::string_view word_of(const TokenRow& row) const {
    return text_.substr(row.begin, row.end - row.begin);
  }
  /// `property name { … }` or `property name[i] { … }`: no name is followed by another one and a brace.
  [[nodiscard]] bool begins_property(const TokenRow& row) {
    if (word_of(row) != "property" || !may_be_name(ahead(1))) return false;
    std::size_t open = 2;
    if (ahead(open) == BipLexer::LBRACK) {
      while (!is_one_of(ahead(open), {BipLexer::RBRACK, BipLexer::LBRACE, BipLexer::END, kNoToken})) ++open;
      ++open;
    }
    if (ahead(open) != BipLexer::LBRACE) return false;
    std::size_t close = open + 1;
    while (!is_one_of(ahead(close), {BipLexer::RBRACE, BipLexer::LBRACE, BipLexer::END, kNoToken})) ++close;
    if (ahead(close) != BipLexer::RBRACE) return false;
    property_text_ = at_ + open;
    property_end_ = at_ + close;
    return true;
  }
  /// One token of all up to the closing brace.
  void push_property_text(TokenRow row) {
    BIP_ASSERT(property_end_ > at_ && property_end_ < in_.size(), "a property from word {} to {}", at_, property_end_);
    at_ = property_end_;
    row.end = in_[at_].end;
    push(row, BipLexer::PROPERTY_TEXT);
  }
  /// Behind the places, a condition, the urgency or the action of a transition or an invariant.
  [[nodiscard]] bool follows_part() const {
    if (braces_ != 0 || (region_ != Region::Atom && region_ != Region::Component) || out_.size() < 2) return false;
    if (is_one_of(previous(),
                  {BipLexer::RPAREN, BipLexer::RBRACE, BipLexer::LAZY, BipLexer::DELAYABLE, BipLexer::EAGER}))
      return true;
    return is_name(previous()) &&
           is_one_of(out_[out_.size() - 2].type, {BipLexer::FROM, BipLexer::TO, BipLexer::COMMA, BipLexer::AT,
                                                  BipLexer::INVARIANT, BipLexer::RESET});
  }
  /// `component Name` of the paper, as opposed to `component Type name(…)` in a compound.
  [[nodiscard]] bool begins_component() const {
    if (open_ == 0) return true;
    if (!may_be_name(ahead(1))) return false;
    const std::size_t second = ahead(2);
    const bool looks_like_instance = is_one_of(ahead(3), {BipLexer::LPAREN, BipLexer::LBRACK, BipLexer::COMMA});
    if (is_one_of(second, {BipLexer::BEHAVIOR, BipLexer::CONTAINS, BipLexer::CLOCK})) return !looks_like_instance;
    return is_one_of(second, {BipLexer::PORT, BipLexer::DATA, BipLexer::CONST, BipLexer::PLACE});
  }
  [[nodiscard]] bool begins_behavior() const {
    if (previous() == BipLexer::DOT || previous() == BipLexer::COMMA) return false;
    if (is_one_of(ahead(1), {BipLexer::INITIAL, BipLexer::STATE, BipLexer::ON, BipLexer::INTERNAL})) {
      return region_ == Region::Component || region_ == Region::Atom;
    }
    return region_ == Region::Component && !is_one_of(ahead(1), {BipLexer::LPAREN, BipLexer::COMMA, BipLexer::DOT});
  }
  [[nodiscard]] bool begins_state() const {
    return open_ >= 2 && may_be_name(ahead(1)) &&
           !is_one_of(previous(), {BipLexer::DOT, BipLexer::COMMA, BipLexer::FROM, BipLexer::TO, BipLexer::ON});
  }
  [[nodiscard]] bool begins_contains() const {
    return (region_ == Region::Component || region_ == Region::Compound) && may_be_name(ahead(1)) &&
           (may_be_name(ahead(2)) || ahead(2) == BipLexer::DOT) &&
           !is_one_of(previous(), {BipLexer::DOT, BipLexer::COMMA});
  }
  [[nodiscard]] bool negates() const {
    const bool operand = may_be_name(ahead(1)) ||
                         is_one_of(ahead(1), {BipLexer::LPAREN, BipLexer::TRUE, BipLexer::FALSE, BipLexer::BANG});
    return operand &&
           is_one_of(previous(), {BipLexer::LPAREN, BipLexer::PROVIDED, BipLexer::AND_WORD, BipLexer::OR_WORD,
                                  BipLexer::ANDAND, BipLexer::OROR, BipLexer::ASSIGN, BipLexer::ARROW, BipLexer::EQ,
                                  BipLexer::NE, BipLexer::BANG, BipLexer::NOT_WORD});
  }
  /// A report in a paper component, else names and minus signs.
  void push_dashed(const TokenRow& row) {
    const std::string_view word = text_.substr(row.begin, row.end - row.begin);
    const bool upper = std::all_of(word.begin(), word.end(),
                                   [](char c) { return c == '-' || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); });
    if (upper && region_ == Region::Component) return push(row, BipLexer::REPORT);
    std::uint32_t begin = row.begin;
    for (std::uint32_t i = row.begin; i < row.end; ++i) {
      if (text_[i] != '-') continue;
      push({0, begin, i, row.line}, BipLexer::ID);
      push({0, i, i + 1, row.line}, BipLexer::MINUS);
      begin = i + 1;
    }
    push({0, begin, row.end, row.line}, BipLexer::ID);
  }

  const std::vector<TokenRow>& in_;
  std::string_view text_;
  std::vector<TokenRow> out_;
  std::size_t at_ = 0;
  std::size_t in_of_for_ = 0;
  std::size_t property_text_ = ~std::size_t{0}, property_end_ = 0;
  Region region_ = Region::None;
  Part part_ = Part::Head;
  WordAsName on_, end_;
  int open_ = 0;
  int braces_ = 0;
  mutable bool looked_behind_the_end_ = false;
};

/// Marks the `else` of each `else if` that has no `fi` of its own. BIP2 closes every `if`; the short spelling closes a
/// whole chain by one `fi`. Counting as if all were chains, an outermost `if` that has `fi`s left over has so many of
/// the long kind. (A parser that looks ahead for this takes cubic time on long chains.)
void mark_else_chains(std::vector<TokenRow>& rows) {
  std::vector<std::size_t> elses;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].type != BipLexer::IF) continue;
    elses.clear();
    int open = 1;
    for (++i; i < rows.size() && open > 0 && rows[i].type != BipLexer::RBRACE; ++i) {
      if (rows[i].type == BipLexer::FI) --open;
      if (rows[i].type != BipLexer::IF) continue;
      if (rows[i - 1].type == BipLexer::ELSE) {
        elses.push_back(i - 1);
      } else {
        ++open;
      }
    }
    std::size_t left_over = 0;
    for (; i < rows.size() && (rows[i].type == BipLexer::FI || rows[i].type == BipLexer::SEMI); ++i) {
      if (rows[i].type == BipLexer::FI) ++left_over;
    }
    --i;
    for (std::size_t k = 0; open == 0 && k + left_over < elses.size(); ++k) rows[elses[k]].type = BipLexer::ELSE_CHAIN;
  }
}

}  // namespace

void classify_tokens(std::vector<TokenRow>& rows, std::string_view text) {
  [[maybe_unused]] const std::uint32_t end = rows.empty() ? 0 : rows.back().end;
  rows = Classifier(rows, text).run();
  BIP_ASSERT((rows.empty() ? 0 : rows.back().end) == end, "{} words end elsewhere than at {}", rows.size(), end);
  mark_else_chains(rows);
}

bool classify_piece(std::vector<TokenRow>& rows, std::span<const std::size_t> ahead, std::string_view text) {
  constexpr std::size_t kMostAhead = 3;
  const std::size_t count = rows.size();
  const bool is_last = ahead.size() < kMostAhead;
  for (const std::size_t type : ahead) rows.push_back({.type = type});
  const std::vector<TokenRow> in = std::move(rows);
  Classifier classifier(in, text);
  rows = classifier.run(count);
  // The rows ahead have no place in the text, so no token may reach into them.
  for (const TokenRow& row : rows) {
    if (row.end <= row.begin) return false;
  }
  mark_else_chains(rows);
  return classifier.is_between_declarations() && (is_last || !classifier.looked_behind_the_end());
}

}  // namespace bip::parse
