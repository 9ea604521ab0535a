// The registry as a table, and the store of diagnostics with its order.
//
// `sorted` orders by file, offset and then order of report, so the output does not depend on the order in which a stage
// walks its tables. Cost: n log n when diagnostics are rendered, none when they are reported.
#include "compiler/diag/diagnostics.hpp"

#include <algorithm>
#include <tuple>

namespace bip {
namespace {

constexpr DiagInfo kInfos[] = {
#define BIP_DIAG(code, severity, slug, message) {#code, Severity::severity, slug, message},
#include "compiler/diag/kinds.def"
#include "runtime/include/bip/assert.hpp"
#undef BIP_DIAG
};

// What has no place comes first: a file that is not there explains all that follows.
auto place(const Diagnostic& d) {
  const bool placed = d.range.is_valid();
  return std::tuple(placed, placed ? d.range.file.value : 0u, placed ? d.range.begin : 0u);
}

bool is_duplicate(const Diagnostic& a, const Diagnostic& b) {
  return a.kind == b.kind && place(a) == place(b) && a.range.end == b.range.end && a.message == b.message;
}

std::string shortened(std::string message) {
  constexpr std::size_t kLongest = 600;
  if (message.size() <= kLongest) return message;
  // A name of a megabyte is no help: its ends are. Cuts keep whole characters.
  const auto is_inside = [&](std::size_t at) { return (static_cast<unsigned char>(message[at]) & 0xC0u) == 0x80u; };
  std::size_t head = kLongest / 2;
  std::size_t tail = message.size() - kLongest / 2;
  while (is_inside(head)) --head;
  while (is_inside(tail)) ++tail;
  BIP_ASSERT(head < tail, "the cut of a message keeps its bytes {} to {} twice", tail, head);
  return message.substr(0, head) + "…" + message.substr(tail);
}

}  // namespace

const DiagInfo& info(Diag kind) {
  const auto row = static_cast<std::size_t>(kind);
  BIP_ASSERT(row < std::size(kInfos), "there is no kind {} of diagnostics", row);
  return kInfos[row];
}

const std::vector<Diag>& all_diags() {
  static const std::vector<Diag> all = [] {
    std::vector<Diag> kinds;
    for (std::size_t i = 0; i < std::size(kInfos); ++i) kinds.push_back(static_cast<Diag>(i));
    return kinds;
  }();
  return all;
}

std::optional<Diag> find_diag(std::string_view code) {
  for (const Diag kind : all_diags()) {
    if (code == info(kind).code) return kind;
  }
  return std::nullopt;
}

DiagnosticBuilder Diagnostics::add(Diag kind, SourceRange range, std::string message) {
  BIP_ASSERT(!range.is_valid() || range.begin <= range.end, "{} has a range from {} to {}", info(kind).code,
             range.begin, range.end);
  BIP_ASSERT(!message.empty(), "{} says nothing", info(kind).code);
  Diagnostic d{};
  d.kind = kind;
  d.severity = info(kind).severity;
  d.range = range;
  d.message = shortened(std::move(message));
  ++(d.severity == Severity::Error ? error_count_ : warning_count_);
  all_.push_back(std::make_unique<Diagnostic>(std::move(d)));
  BIP_ASSERT(error_count_ + warning_count_ == all_.size(), "{} errors and {} warnings of {} diagnostics", error_count_,
             warning_count_, all_.size());
  return DiagnosticBuilder(*all_.back());
}

std::vector<const Diagnostic*> Diagnostics::sorted() const {
  std::vector<const Diagnostic*> order;
  order.reserve(all_.size());
  for (const auto& d : all_) order.push_back(d.get());
  std::stable_sort(order.begin(), order.end(),
                   [](const Diagnostic* a, const Diagnostic* b) { return place(*a) < place(*b); });
  // Equal places are neighbours now, but two equal messages may have a third between them.
  std::vector<const Diagnostic*> kept;
  kept.reserve(order.size());
  for (const Diagnostic* d : order) {
    bool seen = false;
    for (auto it = kept.rbegin(); it != kept.rend() && place(**it) == place(*d) && !seen; ++it) {
      seen = is_duplicate(**it, *d);
    }
    if (!seen) kept.push_back(d);
  }
  return kept;
}

}  // namespace bip
