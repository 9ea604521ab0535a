// Clocks, bounds, `resume`, `async` and events of .bsys: see parse_bsys_rows.hpp.
#include <charconv>

#include "compiler/system/parse_bsys_rows.hpp"

namespace bip::system::text {

namespace {

// "5000000ns"
std::int64_t ticks(BsysReader& r, const Tree& tree, List& list) {
  std::int64_t value = 0;
  const std::uint32_t node = r.next(list, "a time in ns");
  if (r.failed()) return value;
  const std::string_view word = tree.nodes[node].kind == Node::Kind::Word ? tree.word(node) : std::string_view();
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || word.substr(static_cast<std::size_t>(end - word.data())) != "ns")
    r.fail(node, "expected a time such as 5000000ns");
  return value;
}

}  // namespace

Clock RowParser::clock(List& list, const AtomType& type) {
  Clock row;
  r_.row(list, type.clocks.size());
  row.name = r_.name(list);
  row.unit = ticks(r_, tree_, list);
  row.variable = r_.ref(list, type.variables.size(), "slot",
                        [&](std::uint32_t k) -> const std::string& { return type.variables[k].name; });
  r_.close(list);
  row.loc = list.loc;
  return row;
}

TimeGuard RowParser::when(List& list, const AtomType& type, const CodeScope& scope) {
  TimeGuard row;
  const auto clock_ref = [&](List& from) {
    return r_.ref(from, type.clocks.size(), "clock",
                  [&](std::uint32_t k) -> const std::string& { return type.clocks[k].name; });
  };
  while (std::optional<List> one = r_.sub(list, "bound")) {
    Bound bound;
    const BoundOp ops[] = {BoundOp::Lt, BoundOp::Le, BoundOp::Gt, BoundOp::Ge, BoundOp::Eq};
    bool is_known = false;
    for (const BoundOp op : ops) {
      if (is_known || !r_.flag(*one, name_of(op))) continue;
      bound.op = op;
      is_known = true;
    }
    if (!is_known) r_.fail(one->node, "expected lt, le, gt, ge or eq");
    bound.clock = clock_ref(*one);
    if (std::optional<List> minus = r_.sub(*one, "minus")) {
      bound.minus = clock_ref(*minus);
      r_.close(*minus);
    }
    if (std::optional<List> variable = r_.sub(*one, "slot")) {
      bound.variable = r_.ref(*variable, type.variables.size(), "slot",
                              [&](std::uint32_t k) -> const std::string& { return type.variables[k].name; });
      r_.close(*variable);
    } else {
      bound.ticks = ticks(r_, tree_, *one);
    }
    r_.close(*one);
    bound.loc = one->loc;
    row.bounds.push_back(bound);
  }
  row.measure = body(list, "measure", scope);
  return row;
}

Resume RowParser::resume(List& list, const AtomType& type, const CodeScope& scope) {
  Resume row;
  std::optional<List> one = r_.sub(list, "resume");
  if (!one) return row;
  row.present = true;
  row.guard = guard(*one, scope);
  row.when = when(*one, type, scope);
  r_.close(*one);
  row.loc = one->loc;
  return row;
}

Async RowParser::async(List& list, const AtomType& type) {
  Async row;
  std::optional<List> one = r_.sub(list, "async");
  if (!one) return row;
  row.present = true;
  if (r_.more(*one)) row.budget = ticks(r_, tree_, *one);
  if (std::optional<List> port = r_.sub(*one, "overrun")) {
    row.overrun = r_.ref(*port, type.ports.size(), "port",
                         [&](std::uint32_t k) -> const std::string& { return type.ports[k].name; });
    r_.close(*port);
  }
  r_.close(*one);
  return row;
}

void RowParser::event(List& list, Port& port) {
  port.external = true;
  if (r_.flag(list, "ignore")) port.policy = EventPolicy::Ignore;
  else if (r_.flag(list, "error")) port.policy = EventPolicy::Error;
  else if (!r_.flag(list, "remember")) r_.fail(list.node, "expected remember, ignore or error");
  port.event_class = r_.quoted(list);
  r_.close(list);
}

}  // namespace bip::system::text
