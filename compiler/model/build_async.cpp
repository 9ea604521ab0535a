// `@async(budget="10ms", overrun=late)` before a transition: its action runs beside the others (semantics.md, Codels).
// Linear in its arguments.
#include <array>

#include "compiler/model/build_time.hpp"

namespace bip::model {

namespace {

// `10ms`, `1s500us`; -1: it is none, or nothing passes.
std::int64_t ticks_of(std::string_view text) {
  struct Unit {
    std::string_view name;
    std::int64_t ticks;
  };
  constexpr std::array<Unit, 4> kUnits{{{"s", 1'000'000'000}, {"ms", 1'000'000}, {"us", 1'000}, {"ns", 1}}};
  constexpr std::int64_t kMost = kMaxTicks / 1'000'000'000;
  std::int64_t total = 0;
  // The largest unit comes first, each once.
  for (const Unit* unit = kUnits.data(); !text.empty(); ++unit) {
    std::size_t digits = 0;
    std::int64_t count = 0;
    for (; digits < text.size() && text[digits] >= '0' && text[digits] <= '9' && count < kMost; ++digits)
      count = count * 10 + (text[digits] - '0');
    const std::size_t end = std::min(text.find_first_of("0123456789", digits), text.size());
    while (unit != kUnits.data() + kUnits.size() && unit->name != text.substr(digits, end - digits)) ++unit;
    if (digits == 0 || count >= kMost || unit == kUnits.data() + kUnits.size()) return -1;
    total += count * unit->ticks;
    text.remove_prefix(end);
  }
  return total > 0 && total <= kMaxTicks ? total : -1;
}

std::uint32_t overrun_port(ModelBuilder& b, const syntax::AnnotationArg& arg, const AtomType& atom) {
  std::vector<std::string> known;
  for (std::uint32_t port = 0; port < atom.ports.size(); ++port) {
    const Port& p = atom.ports[port];
    if (!p.external || !p.variables.empty()) continue;
    if (p.name == arg.value) return port;
    known.push_back(p.name);
  }
  help_similar(b.diags.report(Diag::kB4022, arg.key.range, arg.value, atom.name), arg.value, arg.key.range, known);
  return Async::kNone;
}

}  // namespace

Async build_async(ModelBuilder& b, const syntax::Transition& t, const AtomType& atom) {
  Async out;
  for (const syntax::Annotation& a : t.annotations) {
    if (a.name.text != "async") continue;
    out.present = true;
    if (t.internal) b.diags.report(Diag::kB1612, a.range, "an", "@async");
    const syntax::AnnotationArg* overrun = nullptr;
    for (const syntax::AnnotationArg& arg : a.args) {
      if (arg.key.text == "budget") {
        out.budget = ticks_of(arg.value);
        if (out.budget < 0) b.diags.report(Diag::kB4021, arg.key.range, arg.value);
      } else if (arg.key.text == "overrun") {
        overrun = &arg;
        out.overrun = overrun_port(b, arg, atom);
      } else {
        help_similar(b.diags.report(Diag::kB4020, arg.key.range, arg.key.text), arg.key.text, arg.key.range,
                     {"budget", "overrun"});
      }
    }
    if (overrun != nullptr && out.budget < 0) b.diags.report(Diag::kB4023, overrun->key.range, overrun->value);
  }
  return out;
}

}  // namespace bip::model
