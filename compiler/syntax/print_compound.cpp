// Prints bodies of compounds: components and connectors in source order; those declared on one line stay on one line.
#include "compiler/syntax/printer.hpp"

namespace bip::syntax {

void SyntaxPrinter::item_group(std::span<const CompoundItem* const> group, Layout layout) {
  const CompoundItem& first = *group.front();
  const std::uint32_t end = group.back()->range.end;
  if (layout == Layout::OwnLine) {
    annotations(first.annotations, first.range.begin);
    const bool one_line = first.inline_body == nullptr && first.kind != ItemKind::For;
    lead_in(first.range.begin, one_line ? end : first.range.begin);
    begin_line();
  }
  if (first.kind == ItemKind::For) {
    out_.append("for ")
        .append(first.name.text)
        .append(" in ")
        .append(text(first.low))
        .append("..")
        .append(text(first.high));
    std::vector<Piece> pieces;
    items(first.items, pieces);
    const bool alone = pieces.size() == 1 && first.items.front()->annotations.empty();
    if (alone) {
      put(" ");
      return item_group(first.items, Layout::SameLine);
    }
    put(" {");
    header_line(first.high->range.end);
    print_in_order(pieces);
    while (has_comment_before(end)) comment_line(syntax_.comments[next_comment_++]);
    --indent_;
    begin_line();
    put("}");
    return end_line(end);
  }
  if (first.kind == ItemKind::Priority) return priority(*first.priority);
  const bool component = first.kind == ItemKind::Component;
  put(component ? (notation_ == Notation::Paper ? "contains " : "component ") : "connector ");
  if (first.type.is_written()) put(text(first.type) + " ");
  for (std::size_t i = 0; i < group.size(); ++i) {
    const CompoundItem& item = *group[i];
    if (i > 0) put(", ");
    put(item.name.text);
    if (item.index != nullptr) put("[" + text(item.index) + "]");
    if (!component) put("(" + text(item.ports) + ")");
    if (component && (notation_ == Notation::Bip2 || !item.args.empty())) put("(" + text(item.args) + ")");
  }
  if (first.inline_body == nullptr) return end_line(end);
  header_line(first.ports.empty() ? first.name.range.end : first.ports.back().range.end);
  // An inline connector is of the paper's notation, whatever it stands in.
  const Notation outer = notation_;
  notation_ = Notation::Paper;
  connector_parts(*first.inline_body);
  notation_ = outer;
  --indent_;
}

void SyntaxPrinter::priority(const CompoundPriority& p) {
  out_.append("priority ").append(p.name.text);
  if (p.index != nullptr) put("[" + text(p.index) + "]");
  out_.append(" ").append(text(p.low)).append(" < ").append(text(p.high));
  if (p.guard != nullptr) put(guard(p.guard));
  end_line(p.range.end);
}

void SyntaxPrinter::items(std::span<const CompoundItem* const> list, std::vector<Piece>& pieces) {
  for (std::size_t i = 0; i < list.size();) {
    std::size_t n = 1;
    const CompoundItem& first = *list[i];
    // Items of one line share the place where their type was written.
    while (first.type.is_written() && i + n < list.size() && list[i + n]->type.is_written() &&
           list[i + n]->type.name.range.begin == first.type.name.range.begin) {
      ++n;
    }
    const auto group = list.subspan(i, n);
    pieces.push_back({first.type.is_written() ? first.type.name.range.begin : first.range.begin,
                      [this, group] { item_group(group, Layout::OwnLine); }});
    i += n;
  }
}

void SyntaxPrinter::compound(const Decl& d) {
  std::vector<Piece> pieces;
  for (const DataDecl& x : d.data) pieces.push_back({x.range.begin, [this, &x] { data(x); }});
  items(d.items, pieces);
  for (const CompoundPriority& p : d.priorities) {
    pieces.push_back({p.range.begin, [this, &p] {
                        annotations(p.annotations, p.range.begin);
                        lead_in(p.range.begin, p.range.end);
                        begin_line();
                        priority(p);
                      }});
  }
  for (const CompoundExport& e : d.exports) {
    pieces.push_back({e.range.begin, [this, &e] {
                        annotations(e.annotations, e.range.begin);
                        lead_in(e.range.begin, e.range.end);
                        begin_line();
                        put((e.is_data ? "export data " : "export port ") + text(e.targets) + " as ");
                        put(e.name.text);
                        end_line(e.range.end);
                      }});
  }
  print_in_order(pieces);
}

}  // namespace bip::syntax
