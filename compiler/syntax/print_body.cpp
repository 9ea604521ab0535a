// Prints bodies of atoms and compounds. An atom of the paper's notation is printed as states if each of its transitions
// leaves one place and they are grouped by place, otherwise as places with transitions `from … to …`, as in BIP2.
#include "compiler/base/quote.hpp"
#include "compiler/syntax/printer.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::syntax {

void SyntaxPrinter::ports(const PortDecl& p) {
  annotations(p.annotations, p.range.begin);
  lead_in(p.range.begin, p.range.end);
  begin_line();
  if (p.role == PortRole::External) put("extern ");
  if (p.role == PortRole::Exported && notation_ == Notation::Bip2) put("export ");
  if (p.role == PortRole::Exported && notation_ == Notation::Paper && !p.merged_as.text.empty()) put("export ");
  put("port ");
  if (p.type.is_written()) put(text(p.type) + " ");
  for (std::size_t i = 0; i < p.items.size(); ++i) {
    if (i > 0) put(", ");
    put(p.items[i].name.text);
    if (notation_ == Notation::Bip2 || p.items[i].has_vars) put("(" + text(p.items[i].vars) + ")");
  }
  if (!p.merged_as.text.empty()) put(" as " + std::string(p.merged_as.text));
  if (!p.extern_class.empty()) put(" as " + quoted(p.extern_class));
  if (!p.extern_policy.text.empty()) put(" " + std::string(p.extern_policy.text));
  end_line(p.range.end);
}

void SyntaxPrinter::initial_parts(const Initial& i) {
  put("initial to " + text(i.to));
  block("do", i.action);
  if (i.resumes) put(i.resume == nullptr ? " resume" : " resume (" + text(i.resume, Parentheses::Dropped) + ")");
}

void SyntaxPrinter::transition(const Transition& t, TransitionForm form) {
  const bool in_state = form == TransitionForm::InState;
  BIP_ASSERT(!in_state || t.from.size() == 1, "a transition of a state leaves {} places", t.from.size());
  annotations(t.annotations, t.range.begin);
  lead_in(t.range.begin, t.action.present ? t.action.range.begin : t.range.end);
  begin_line();
  put(t.internal ? "internal" : "on " + std::string(t.port.text));
  if (!in_state) put(" from " + text(t.from) + " to " + text(t.to));
  if (t.guard != nullptr) put(guard(t.guard));
  if (!t.urgency.text.empty()) put(" " + std::string(t.urgency.text));
  const bool bare = in_state && t.action.stmts.size() == 1 && is_simple(*t.action.stmts[0]) &&
                    !has_comment_before(t.action.range.end);
  if (bare) {
    put(" do " + simple(*t.action.stmts[0]));
  } else {
    block("do", t.action);
  }
  if (in_state) put(" to " + text(t.to));
  if (t.resumes) put(t.resume == nullptr ? " resume" : " resume (" + text(t.resume, Parentheses::Dropped) + ")");
  end_line(t.range.end);
}

bool SyntaxPrinter::has_state_form(const Decl& d) {
  if (d.notation != Notation::Paper) return false;
  std::size_t next = 0;
  for (const Name& place : d.places) {
    while (next < d.transitions.size() && d.transitions[next].from.size() == 1 &&
           d.transitions[next].from[0].text == place.text)
      ++next;
  }
  return next == d.transitions.size();
}

/// Where the next `word` outside comments ends. The tree does not record the `end` of a behavior.
std::uint32_t SyntaxPrinter::end_of_word(std::string_view word, std::uint32_t from) const {
  std::size_t comment = next_comment_;
  while (true) {
    const std::size_t at = source_.find(word, from);
    if (at == std::string_view::npos) return from;
    while (comment < syntax_.comments.size() && syntax_.comments[comment].range.end <= at) ++comment;
    if (comment == syntax_.comments.size() || syntax_.comments[comment].range.begin > at)
      return static_cast<std::uint32_t>(at + word.size());
    from = syntax_.comments[comment].range.end;
  }
}

void SyntaxPrinter::behavior(const Decl& d) {
  const std::uint32_t begin = d.initial.present ? d.initial.range.begin : d.places.front().range.begin;
  const std::uint32_t limit = d.initial.present && d.initial.action.present ? d.initial.action.range.begin : begin;
  lead_in(begin, limit);
  begin_line();
  put("behavior");
  if (d.initial.present) {
    put(" ");
    initial_parts(d.initial);
    end_line(d.initial.range.end);
  } else {
    end_line(begin);
  }
  ++indent_;
  first_in_block_ = true;
  std::size_t next = 0;
  std::uint32_t end = last_end_;
  for (const Name& place : d.places) {
    lead_in(place.range.begin, place.range.end);
    begin_line();
    put("state ");
    put(place.text);
    end_line(place.range.end);
    ++indent_;
    while (next < d.transitions.size() && d.transitions[next].from[0].text == place.text) {
      transition(d.transitions[next], TransitionForm::InState);
      end = std::max(end, d.transitions[next++].range.end);
    }
    --indent_;
  }
  BIP_ASSERT(next == d.transitions.size(), "{} of {} transitions are in states", next, d.transitions.size());
  end_block(end_of_word("end", std::max(end, last_end_)));
}

void SyntaxPrinter::atom(const Decl& d) {
  std::vector<Piece> pieces;
  for (const DataDecl& x : d.data) pieces.push_back({x.range.begin, [this, &x] { data(x); }});
  for (const PortDecl& p : d.ports) pieces.push_back({p.range.begin, [this, &p] { ports(p); }});
  for (const ClockDecl& c : d.clocks) {
    pieces.push_back({c.range.begin, [this, &c] {
                        annotations(c.annotations, c.range.begin);
                        lead_in(c.range.begin, c.range.end);
                        begin_line();
                        put("clock " + text(c.names));
                        if (!c.unit.text.empty()) put(" unit " + std::string(c.unit.text));
                        end_line(c.range.end);
                      }});
  }
  if (has_state_form(d) && !d.places.empty()) {
    const std::uint32_t first = d.places.front().range.begin;
    pieces.push_back({d.initial.present ? std::min(first, d.initial.range.begin) : first, [this, &d] { behavior(d); }});
  } else {
    if (!d.places.empty()) {
      pieces.push_back({d.places.front().range.begin, [this, &d] {
                          lead_in(d.places.front().range.begin, d.places.back().range.end);
                          begin_line();
                          put("place " + text(d.places));
                          end_line(d.places.back().range.end);
                        }});
    }
    if (d.initial.present) {
      pieces.push_back({d.initial.range.begin, [this, &d] {
                          const Initial& i = d.initial;
                          lead_in(i.range.begin, i.action.present ? i.action.range.begin : i.range.end);
                          begin_line();
                          initial_parts(i);
                          end_line(i.range.end);
                        }});
    }
    for (const Transition& t : d.transitions)
      pieces.push_back({t.range.begin, [this, &t] { transition(t, TransitionForm::Alone); }});
  }
  for (const FinalPlaces& f : d.finals) {
    pieces.push_back({f.range.begin, [this, &f] {
                        lead_in(f.range.begin, f.range.end);
                        begin_line();
                        put("final " + text(f.places));
                        end_line(f.range.end);
                      }});
  }
  for (const AtomPriority& p : d.atom_priorities) {
    pieces.push_back({p.range.begin, [this, &p] {
                        lead_in(p.range.begin, p.range.end);
                        begin_line();
                        out_.append("priority ")
                            .append(p.name.text)
                            .append(" ")
                            .append(p.low.text)
                            .append(" < ")
                            .append(p.high.text);
                        if (p.guard != nullptr) put(guard(p.guard));
                        end_line(p.range.end);
                      }});
  }
  for (const Invariant& i : d.invariants) {
    pieces.push_back({i.range.begin, [this, &i] {
                        lead_in(i.range.begin, i.range.end);
                        begin_line();
                        out_.append("invariant ").append(i.name.text);
                        if (i.scope != InvariantScope::Always)
                          put((i.scope == InvariantScope::At ? " at " : " from ") + text(i.places));
                        put(guard(i.expr));
                        end_line(i.range.end);
                      }});
  }
  print_in_order(pieces);
}

}  // namespace bip::syntax
