// See error_strategy.hpp. Exceptions do not leave compiler/parse: the rule functions of the generated parser catch
// them.
#include "compiler/parse/error_strategy.hpp"

#include <algorithm>

#include "BipParser.h"
#include "compiler/parse/describe_tokens.hpp"
#include "compiler/parse/habits.hpp"
#include "compiler/parse/token_list.hpp"

namespace bip::parse {
namespace {

using antlr::BipParser;
using antlr4::misc::IntervalSet;

bool begins_declaration(std::size_t type) {
  switch (type) {
    case antlr4::Token::EOF:
    case BipParser::ATOM:
    case BipParser::COMPOUND:
    case BipParser::CONNECTOR_DECL:
    case BipParser::PORT_DECL:
    case BipParser::EXTERN_DECL:
    case BipParser::COMPONENT_DECL:
    case BipParser::PACKAGE:
    case BipParser::FUNCTION: return true;
    default: return false;
  }
}

/// Words that no expression, block or list contains, so that an item or its end must be here.
bool begins_item(std::size_t type) {
  switch (type) {
    case BipParser::DATA:
    case BipParser::EXPORT:
    case BipParser::PORT:
    case BipParser::PLACE:
    case BipParser::INITIAL:
    case BipParser::ON:
    case BipParser::INTERNAL:
    case BipParser::PRIORITY:
    case BipParser::COMPONENT:
    case BipParser::CONNECTOR:
    case BipParser::CONTAINS:
    case BipParser::BEHAVIOR:
    case BipParser::STATE:
    case BipParser::FOR:
    case BipParser::PROPERTY:
    case BipParser::DEFINE:
    case BipParser::AT_SIGN:
    case BipParser::END: return true;
    default: return begins_declaration(type);
  }
}

/// `clock`, `invariant` and `final` may be names, but not at the beginning of a line.
bool begins_late_item(antlr4::TokenStream* input) {
  const std::size_t type = input->LA(1);
  if (type != BipParser::CLOCK && type != BipParser::INVARIANT && type != BipParser::FINAL) return false;
  const antlr4::Token* before = input->LT(-1);
  return before == nullptr || before->getLine() != input->LT(1)->getLine();
}

/// `end`, or an item of an atom or a compound.
bool may_begin_item(const IntervalSet& expected) {
  return expected.contains(static_cast<ssize_t>(BipParser::END)) &&
         expected.contains(static_cast<ssize_t>(BipParser::ON)) &&
         expected.contains(static_cast<ssize_t>(BipParser::DATA)) &&
         expected.contains(static_cast<ssize_t>(BipParser::PLACE));
}

bool begins_use_or_declaration(std::size_t type) {
  return begins_declaration(type) || type == BipParser::USE || type == BipParser::CONST;
}

bool is_closer(std::size_t type) {
  return type == BipParser::RPAREN || type == BipParser::RBRACK || type == BipParser::RBRACE;
}

/// What cannot go on inside brackets.
bool cannot_be_inside(std::size_t type) {
  switch (type) {
    case BipParser::SEMI:
    case BipParser::LBRACE:
    case BipParser::DO:
    case BipParser::UP:
    case BipParser::DOWN:
    case BipParser::FROM:
    case BipParser::TO:
    case BipParser::PROVIDED:
    case BipParser::THEN:
    case BipParser::ELSE:
    case BipParser::ELSE_CHAIN:
    case BipParser::FI: return true;
    default: return is_closer(type) || begins_item(type);
  }
}

/// A package and declarations beside it.
bool has_both(const antlr4::RuleContext* file) {
  bool has_package = false, has_decl = false;
  for (const antlr4::tree::ParseTree* child : file->children) {
    has_package |= dynamic_cast<const BipParser::PackageContext*>(child) != nullptr;
    has_decl |= dynamic_cast<const BipParser::DeclContext*>(child) != nullptr;
  }
  return has_package && has_decl;
}

/// Text of several lines as one, shortened.
std::string in_one_line(std::string_view text) {
  constexpr std::size_t kLongest = 72;
  std::string out;
  for (const char c : text) {
    const bool is_blank = c == ' ' || c == '\n' || c == '\t' || c == '\r';
    if (!is_blank || (!out.empty() && out.back() != ' ')) out += is_blank ? ' ' : c;
  }
  if (out.size() <= kLongest) return out;
  std::size_t end = kLongest;
  while ((static_cast<unsigned char>(out[end]) & 0xC0u) == 0x80u) --end;
  return out.substr(0, end) + " …";
}

IntervalSet expected_by(antlr4::Parser* parser, const antlr4::RecognitionException& e) {
  if (const auto* stuck = dynamic_cast<const antlr4::NoViableAltException*>(&e);
      stuck != nullptr && stuck->getDeadEndConfigs() != nullptr) {
    IntervalSet expected;
    for (const auto& config : stuck->getDeadEndConfigs()->configs) {
      IntervalSet next = parser->getATN().nextTokens(config->state);
      next.remove(antlr4::Token::EPSILON);
      expected.addAll(next);
    }
    if (!expected.isEmpty()) return expected;
  }
  return parser->getExpectedTokens();
}

}  // namespace

ReportingStrategy::ReportingStrategy(const SourceMap& sources, FileId file, Diagnostics& diags)
    : text_(sources.text(file)), file_(file), diags_(diags) {
  for (const Diagnostic* d : diags.sorted()) {
    if (d->severity == Severity::Error && d->range.file == file) lexical_lines_.insert(sources.loc(d->range).line);
    is_end_lost_ |= d->kind == Diag::kB0003 && d->range.file == file;
  }
}

SourceRange ReportingStrategy::range(const antlr4::Token* token) const {
  return {file_, static_cast<std::uint32_t>(token->getStartIndex()), static_cast<std::uint32_t>(token->getStopIndex())};
}

std::string ReportingStrategy::found_phrase(const antlr4::Token* token) const {
  if (token->getType() == antlr4::Token::EOF) return "end of file";
  if (token->getType() == BipParser::STRING) return "a string";
  const SourceRange at = range(token);
  return std::string("`").append(text_.substr(at.begin, at.end - at.begin)).append("`");
}

bool ReportingStrategy::is_first_report_at(antlr4::Parser* parser, const antlr4::Token* token) {
  const std::size_t index = token->getTokenIndex();
  if (last_reported_ == index) return false;
  last_reported_ = index;
  // A closer that was assumed a word or two too early comes after all.
  if (token->getType() == conjured_closer_ && index - conjured_at_ <= 2) return false;
  const std::size_t before = index == 0 ? 0 : parser->getTokenStream()->get(index - 1)->getLine();
  if (lexical_lines_.contains(before) || lexical_lines_.contains(token->getLine())) return false;
  // What a line lacks is told at its end.
  if (told_lines_.contains(before) && is_first_of_line(parser, token) && begins_item(token->getType())) return false;
  return told_lines_.insert(token->getLine()).second;
}

bool ReportingStrategy::is_first_of_line(antlr4::Parser* parser, const antlr4::Token* token) const {
  const std::size_t index = token->getTokenIndex();
  return index == 0 || parser->getTokenStream()->get(index - 1)->getLine() != token->getLine();
}

std::size_t ReportingStrategy::column(const antlr4::Token* token) const {
  const std::size_t begin = token->getStartIndex();
  const std::size_t line = begin == 0 ? std::string_view::npos : text_.rfind('\n', begin - 1);
  return line == std::string_view::npos ? begin : begin - line - 1;
}

SourceRange ReportingStrategy::missing_before(antlr4::Parser* parser, const antlr4::Token* found) const {
  if (found->getTokenIndex() == 0 || !is_first_of_line(parser, found)) return range(found);
  const SourceRange before = range(parser->getTokenStream()->get(found->getTokenIndex() - 1));
  return {file_, before.end, before.end};
}

void ReportingStrategy::reportError(antlr4::Parser* parser, const antlr4::RecognitionException& e) {
  const antlr4::Token* found = e.getOffendingToken();
  furthest_error_ = std::max(furthest_error_, found->getTokenIndex());
  in_inline_connector_ = false;
  for (const antlr4::RuleContext* c = parser->getContext(); c != nullptr;
       c = static_cast<const antlr4::RuleContext*>(c->parent)) {
    in_inline_connector_ |= c->getRuleIndex() == BipParser::RuleInlineConnector;
  }
  if (!is_first_report_at(parser, found)) return;
  report_unexpected(parser, found, expected_by(parser, e));
}

// `extern function int Math.max(int, int)`, or `Math::max`.
bool ReportingStrategy::names_class_of_function(antlr4::Parser* parser, const antlr4::Token* found) const {
  const antlr4::RuleContext* context = parser->getContext();
  // Without a result the class is read as one.
  while (context != nullptr &&
         (context->getRuleIndex() == BipParser::RulePath || context->getRuleIndex() == BipParser::RulePathPart ||
          context->getRuleIndex() == BipParser::RuleId || context->getRuleIndex() == BipParser::RuleTypeName))
    context = static_cast<const antlr4::RuleContext*>(context->parent);
  const std::size_t index = found->getTokenIndex();
  antlr4::TokenStream* const input = parser->getTokenStream();
  if (context == nullptr || context->getRuleIndex() != BipParser::RuleExternFunction || index < 2 ||
      input->get(index - 1)->getType() != BipParser::ID)
    return false;
  if (found_phrase(found) == "`.`" || found_phrase(found) == "`:`") return true;
  return found->getType() == BipParser::LPAREN && found_phrase(input->get(index - 2)) == "`.`";
}

// `port Signal up()`: the type alone could be a port's name, so no name is expected where one was meant.
bool ReportingStrategy::is_like_named_port(antlr4::Parser* parser, const antlr4::Token* found) {
  antlr4::TokenStream* const input = parser->getTokenStream();
  const std::size_t index = found->getTokenIndex();
  return index >= 2 && found->getType() != antlr4::Token::EOF && input->get(index - 1)->getType() == BipParser::ID &&
         input->get(index - 2)->getType() == BipParser::PORT && input->get(index + 1)->getType() == BipParser::LPAREN;
}

void ReportingStrategy::report_unexpected(antlr4::Parser* parser, const antlr4::Token* found,
                                          const IntervalSet& expected) {
  const std::size_t index = found->getTokenIndex();
  // A new item while the one before is not complete: its rest is missing where it stops.
  const bool is_complete = expected.contains(static_cast<ssize_t>(BipParser::END)) ||
                           expected.contains(static_cast<ssize_t>(antlr4::Token::EOF));
  const bool is_cut_short = !is_complete && begins_item(found->getType());
  std::string place;
  if (index > 0) place = " after " + found_phrase(parser->getTokenStream()->get(index - 1));
  // A new line where an item may end: what could have continued the line before was hardly meant.
  const bool is_new_item = index > 0 && is_first_of_line(parser, found) && may_begin_item(expected);
  place += is_new_item ? " in " + find_owner(parser->getContext(), text_).phrase
                       : describe_place(parser->getContext(), text_);
  auto diagnostic =
      diags_.report(Diag::kB0001, is_cut_short ? missing_before(parser, found) : range(found),
                    is_new_item ? "`end` or another item" : describe_expected(expected), place, found_phrase(found));
  const SourceRange at = range(found);
  const std::string word(text_.substr(at.begin, at.end - at.begin));
  if (names_class_of_function(parser, found)) {
    diagnostic.note("a class before a function's name is for Java; C++ functions of BIP are in no class")
        .help("declare it under one name, and call the class's function in C++ that `@cpp` names");
  } else if (add_habit(parser, found, diagnostic) || add_missing_fi(parser, found, diagnostic)) {
    return;
  } else if (const std::vector<std::string> similar =
                 is_name(found->getType()) ? similar_names(word, words_of(expected)) : std::vector<std::string>();
             !similar.empty()) {
    diagnostic.help("there is a word `" + similar.front() + "`", at, similar.front());
  } else if (found->getType() != BipParser::ID && !word.empty() && word.front() >= 'a' && word.front() <= 'z' &&
             (expected.contains(static_cast<ssize_t>(BipParser::ID)) || is_like_named_port(parser, found))) {
    diagnostic.note("`" + word + "` is a reserved word");
  }
}

bool ReportingStrategy::add_habit(antlr4::Parser* parser, const antlr4::Token* found, DiagnosticBuilder diagnostic) {
  const std::optional<Habit> habit = find_habit(*parser->getTokenStream(), parser->getContext(), *found, text_);
  if (!habit) return add_line_comment(found, diagnostic);
  if (!habit->note.empty()) diagnostic.note(std::string(habit->note));
  if (!habit->has_edit) return true;
  const SourceRange replaced{file_, static_cast<std::uint32_t>(habit->begin), static_cast<std::uint32_t>(habit->end)};
  const std::string text(text_.substr(replaced.begin, replaced.end - replaced.begin));
  const std::string help =
      habit->with.empty() ? "leave `" + in_one_line(text) + "` out" : "write `" + in_one_line(habit->with) + "`";
  diagnostic.help(help, replaced, habit->with);
  return true;
}

// `-- text`, as in SQL, Ada and Lua.
bool ReportingStrategy::add_line_comment(const antlr4::Token* found, DiagnosticBuilder diagnostic) {
  const std::size_t begin = text_.rfind('\n', found->getStartIndex()) + 1;  // the first line: npos + 1 = 0
  const std::size_t sign = text_.find("--", begin);
  if (sign == std::string_view::npos || sign > found->getStartIndex()) return false;
  if (sign > begin && text_[sign - 1] != ' ') return false;
  const SourceRange at{file_, static_cast<std::uint32_t>(sign), static_cast<std::uint32_t>(sign + 2)};
  diagnostic.help("comments begin with `//`", at, "//");
  return true;
}

// The `if` that is open where a `}` or the end of the atom was found: its `fi` is missing.
bool ReportingStrategy::add_missing_fi(antlr4::Parser* parser, const antlr4::Token* found,
                                       DiagnosticBuilder diagnostic) {
  if (found->getType() != BipParser::RBRACE && found->getType() != BipParser::END) return false;
  const antlr4::RuleContext* context = parser->getContext();
  while (context != nullptr && context->getRuleIndex() != BipParser::RuleIfStmt)
    context = static_cast<const antlr4::RuleContext*>(context->parent);
  if (context == nullptr || found->getTokenIndex() == 0) return false;
  const antlr4::Token* opener = static_cast<const antlr4::ParserRuleContext*>(context)->start;
  diagnostic.label(range(opener), "this `if` has no `fi`");
  if (found->getType() == BipParser::END) {
    diagnostic.help("an `if` ends with `fi`", range(found), "fi");
    return true;
  }
  const SourceRange last = range(parser->getTokenStream()->get(found->getTokenIndex() - 1));
  const bool is_one_line = opener->getLine() == found->getLine();
  const std::string with = is_one_line ? " fi" : "\n" + std::string(column(opener), ' ') + "fi";
  diagnostic.help("write `fi` before `" + std::string(spelling(found->getType())) + "`", {file_, last.end, last.end},
                  with);
  return true;
}

bool ReportingStrategy::report_missing_closer(antlr4::Parser* parser, std::size_t closer) {
  antlr4::TokenStream* input = parser->getTokenStream();
  const antlr4::Token* found = input->LT(1);
  // What is a habit of another language lacks no closer.
  if (find_habit(*input, parser->getContext(), *found, text_)) return false;
  const antlr4::Token* opener = nullptr;
  int closed = 0;
  for (std::size_t i = found->getTokenIndex(); i-- > 0 && opener == nullptr;) {
    const antlr4::Token* token = input->get(i);
    const std::size_t type = token->getType();
    if (is_closer(type)) ++closed;
    const bool opens = type == BipParser::LPAREN || type == BipParser::LBRACK || type == BipParser::GROUP_OPEN ||
                       type == BipParser::LBRACE;
    if (opens && closed-- == 0) opener = token;
  }
  if (opener == nullptr) return false;
  const bool is_first = is_first_report_at(parser, found);
  conjured_closer_ = closer;
  conjured_at_ = found->getTokenIndex();
  if (!is_first) return true;
  diags_
      .report(Diag::kB0007, missing_before(parser, found), spelling(opener->getType()), spelling(closer),
              describe_place(parser->getContext(), text_), found_phrase(found))
      .label(range(opener), "opened here");
  return true;
}

antlr4::Token* ReportingStrategy::conjure(antlr4::Parser* parser, std::size_t type) {
  const antlr4::Token* next = parser->getTokenStream()->LT(1);
  auto token = std::make_unique<antlr4::CommonToken>(type);
  token->setStartIndex(next->getStartIndex());
  token->setStopIndex(next->getStartIndex());
  token->setLine(next->getLine());
  conjured_.push_back(std::move(token));
  return conjured_.back().get();
}

// A misspelled `end`, such as `endatom`, was reported already.
bool ReportingStrategy::is_misspelled_end(antlr4::Parser* parser, const antlr4::Token* found) const {
  if (found->getTokenIndex() == 0) return false;
  const antlr4::Token* last = parser->getTokenStream()->get(found->getTokenIndex() - 1);
  return told_lines_.contains(last->getLine()) && is_first_of_line(parser, last) &&
         text_.substr(last->getStartIndex(), 3) == "end";
}

// An `end` in the column of the outer declaration was the outer one's: then the inner one has none.
void ReportingStrategy::report_missing_end(antlr4::Parser* parser, const antlr4::Token* found) {
  Owner owner = find_owner(parser->getContext(), text_);
  if (owner.opener == nullptr || (is_end_lost_ && found->getType() == antlr4::Token::EOF)) return;
  if (is_misspelled_end(parser, found)) return;
  SourceRange at = missing_before(parser, found);
  const antlr4::Token* last =
      found->getTokenIndex() == 0 ? nullptr : parser->getTokenStream()->get(found->getTokenIndex() - 1);
  if (last != nullptr && last->getType() == BipParser::END && is_first_of_line(parser, last) &&
      column(last) == column(owner.opener)) {
    const Owner inner = find_closed_by(parser->getContext(), last, text_);
    if (inner.opener != nullptr && column(inner.opener) != column(last)) {
      owner = inner;
      at = missing_before(parser, last);
    }
  }
  diags_.report(Diag::kB0006, at, owner.phrase).label("expected `end` here").label(range(owner.opener), "begins here");
}

antlr4::Token* ReportingStrategy::recoverInline(antlr4::Parser* parser) {
  const antlr4::Token* found = parser->getTokenStream()->LT(1);
  const std::size_t type = found->getType();
  const IntervalSet expected = parser->getExpectedTokens();
  if (expected.contains(static_cast<ssize_t>(BipParser::END)) && begins_declaration(type)) {
    if (!(last_reported_ == found->getTokenIndex() && type == antlr4::Token::EOF)) report_missing_end(parser, found);
    last_reported_ = found->getTokenIndex();
    return conjure(parser, BipParser::END);
  }
  for (const std::size_t closer : {BipParser::RPAREN, BipParser::RBRACK, BipParser::RBRACE}) {
    if (expected.contains(static_cast<ssize_t>(closer)) && cannot_be_inside(type) &&
        report_missing_closer(parser, closer)) {
      return conjure(parser, closer);
    }
  }
  throw antlr4::InputMismatchException(parser);
}

void ReportingStrategy::sync(antlr4::Parser* parser) {
  const auto* state = parser->getATN().states[parser->getState()];
  const std::size_t next = parser->getTokenStream()->LA(1);
  const IntervalSet in_rule = parser->getATN().nextTokens(const_cast<antlr4::atn::ATNState*>(state));
  if (in_rule.contains(static_cast<ssize_t>(next))) return;
  const IntervalSet expected = parser->getExpectedTokens();
  if (expected.contains(static_cast<ssize_t>(next))) return;
  if (expected.contains(static_cast<ssize_t>(BipParser::END)) && begins_declaration(next)) return;
  // A missing closer is told by recoverInline, which can also assume it.
  const bool can_leave = in_rule.contains(antlr4::Token::EPSILON) ||
                         is_closer(static_cast<std::size_t>(in_rule.isEmpty() ? 0 : in_rule.getMaxElement()));
  const bool closes = expected.contains(static_cast<ssize_t>(BipParser::RPAREN)) ||
                      expected.contains(static_cast<ssize_t>(BipParser::RBRACK)) ||
                      expected.contains(static_cast<ssize_t>(BipParser::RBRACE));
  if (can_leave && closes && cannot_be_inside(next)) return;
  if (skip_stray_words(parser, expected)) return;
  throw antlr4::InputMismatchException(parser);
}

bool ReportingStrategy::skip_stray_words(antlr4::Parser* parser, const IntervalSet& expected) {
  antlr4::TokenStream* input = parser->getTokenStream();
  const std::size_t rule = parser->getContext()->getRuleIndex();
  bool (*stops)(std::size_t) = nullptr;
  switch (rule) {
    case BipParser::RuleAtomType:
    case BipParser::RuleCompoundType:
    case BipParser::RuleComponent:
    case BipParser::RuleConnectorType:
    case BipParser::RuleBehavior:
      if (!expected.contains(static_cast<ssize_t>(BipParser::END))) return false;
      stops = begins_item;
      break;
    case BipParser::RulePackage:
      if (!expected.contains(static_cast<ssize_t>(BipParser::END))) return false;
      stops = begins_use_or_declaration;
      break;
    case BipParser::RuleFile: stops = begins_use_or_declaration; break;
    default: return false;
  }
  // After an earlier error an `end` too many is its consequence; after declarations behind the package's `end` these
  // are told.
  const bool is_end_of_file = rule == BipParser::RuleFile && input->LA(1) == BipParser::END;
  const bool consequence = is_end_of_file && (diags_.has_errors() || has_both(parser->getContext()));
  const antlr4::Token* stray = input->LT(1);
  if (is_first_report_at(parser, stray) && !consequence) report_unexpected(parser, stray, expected);
  // What stands deeper than a line that cannot be read belongs to it.
  const bool by_columns = stops == begins_use_or_declaration && is_first_of_line(parser, stray);
  const auto is_inside = [&](const antlr4::Token* token) {
    return by_columns && is_first_of_line(parser, token) && column(token) > column(stray);
  };
  do {
    parser->consume();
  } while (input->LA(1) != antlr4::Token::EOF &&
           (!(stops(input->LA(1)) || (stops == begins_item && begins_late_item(input))) || is_inside(input->LT(1))));
  note_skipped_to_end(parser);
  sync(parser);
  return true;
}

void ReportingStrategy::note_skipped_to_end(antlr4::Parser* parser) {
  // What was skipped may have held the `end`: its absence is no second error.
  if (parser->getTokenStream()->LA(1) == antlr4::Token::EOF) last_reported_ = parser->getTokenStream()->index();
}

void ReportingStrategy::recover(antlr4::Parser* parser, std::exception_ptr e) {
  antlr4::TokenStream* input = parser->getTokenStream();
  const auto skip = [&](auto&& stops) {
    while (input->LA(1) != antlr4::Token::EOF && (input->index() < furthest_error_ || !stops(input->LA(1))))
      parser->consume();
    note_skipped_to_end(parser);
  };
  switch (parser->getContext()->getRuleIndex()) {
    case BipParser::RuleBodyItem:
    case BipParser::RuleConnectorPart:
    case BipParser::RuleTransition:
    case BipParser::RuleState:
      skip([&](std::size_t type) {
        if (in_inline_connector_ && parser->getContext()->getRuleIndex() == BipParser::RuleBodyItem &&
            (type == BipParser::DEFINE || type == BipParser::ON))
          return false;
        return begins_item(type) || begins_late_item(input);
      });
      return;
    case BipParser::RuleDecl:
    case BipParser::RuleUse:
    case BipParser::RulePackage: skip(begins_use_or_declaration); return;
    case BipParser::RuleFile:
      // Something between the declarations of the file: skip it and go on with the next one.
      while (input->LA(1) != antlr4::Token::EOF) parser->consume();
      return;
    default: std::rethrow_exception(e);
  }
}

}  // namespace bip::parse
