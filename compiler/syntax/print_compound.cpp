// Prints bodies of compounds: components and connectors in source order; those declared on one line stay on one line.
#include "compiler/syntax/printer.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::syntax {

void SyntaxPrinter::item_group(std::span<const CompoundItem* const> group, Layout layout) {
  BIP_ASSERT(!group.empty(), "a line without items");
  const CompoundItem& first = *group.front();
  BIP_ASSERT(group.size() == 1 || first.type.is_written(), "{} items on a line without their type", group.size());
  const std::uint32_t end = group.back()->range.end;
  if (layout == Layout::OwnLine) {
    annotations(first.annotations, first.range.begin);
    const bool one_line =
        first.inline_body == nullptr && first.kind != ItemKind::For && first.kind != ItemKind::Property;
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
  if (first.kind == ItemKind::Property) return property(first);
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

// The text has a grammar of its own: its lines stay as they are, with the comments in them.
void SyntaxPrinter::property(const CompoundItem& item) {
  put("property ");
  put(item.name.text);
  if (item.index != nullptr) put("[" + text(item.index) + "]");
  std::vector<std::string_view> lines;
  const std::string_view all = item.property.text;
  for (std::size_t at = 0; at <= all.size();) {
    const std::size_t end = std::min(all.find('\n', at), all.size());
    const std::string_view line = all.substr(at, end - at);
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first != std::string_view::npos)
      lines.push_back(line.substr(first, line.find_last_not_of(" \t\r") - first + 1));
    at = end + 1;
  }
  if (lines.size() == 1) {
    put(" { " + std::string(lines.front()) + " }");
  } else {
    put(" {");
    ++indent_;
    for (const std::string_view line : lines) {
      out_ += '\n';
      begin_line();
      put(line);
    }
    --indent_;
    out_ += '\n';
    begin_line();
    put("}");
  }
  while (has_comment_before(item.range.end)) ++next_comment_;
  end_line(item.range.end);
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
