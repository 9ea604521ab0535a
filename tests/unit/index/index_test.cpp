// The index on small files: `^` marks a name whose declaration and number of uses are expected.
#include <catch2/catch.hpp>
#include <tuple>

#include "compiler/index/index.hpp"
#include "compiler/parse/parse.hpp"

using namespace bip;
using namespace bip::index;

namespace {

struct Indexed {
  SourceMap sources;
  std::vector<syntax::Syntax> trees;
  FileId file;
  Index index;

  explicit Indexed(const std::vector<std::string>& texts) {
    Diagnostics diags;
    for (const std::string& text : texts) {
      file = sources.add("f" + std::to_string(sources.size()), text);
      if (auto tree = parse::parse_file(sources, file, diags)) trees.push_back(std::move(*tree));
    }
    std::vector<const syntax::Syntax*> list;
    for (const syntax::Syntax& tree : trees) list.push_back(&tree);
    index = build_index(list, sources);
  }
  /// The symbol used where `at` begins, `skip` bytes further on.
  const Symbol* symbol(std::string_view at, std::uint32_t skip = 0) const {
    const Use* use = index.use_at(file, static_cast<std::uint32_t>(sources.text(file).find(at)) + skip);
    return use == nullptr ? nullptr : &index.symbols[use->symbol];
  }
  std::size_t uses(std::string_view at, std::uint32_t skip = 0) const {
    const Use* use = index.use_at(file, static_cast<std::uint32_t>(sources.text(file).find(at)) + skip);
    return use == nullptr ? 0 : index.uses_of(use->symbol).size();
  }
};

const std::string kModel = R"(package m
  // A value.
  // Twice.
  port type Value(int v)
  connector type Pass(Value a, Value b)
    define a b
    on a b down { b.v = a.v; }
  end
  atom type Node(int n)
    data int x = n
    export port Value in(x), out(x)
    place S, T
    initial to S
    on in from S to T provided (x < n) do { x = x + 1; }
    on out from T to S
    priority rule in < out
  end
  compound type Pair(int k)
    component Node a(k), b[2](1)
    for i in 0..2 connector Pass c[i](a.out, b[i].in)
    export port a.in as start
  end
  compound type Root()
    component Pair p(3)
    priority none p:* < *:*
  end
end
)";

}  // namespace

TEST_CASE("types, ports, data and places") {
  const Indexed m({kModel});
  REQUIRE(m.symbol("Value(int v)") != nullptr);
  CHECK(m.symbol("Value(int v)")->kind == SymbolKind::PortType);
  CHECK(m.symbol("Value(int v)")->doc == "A value.\nTwice.");
  CHECK(m.uses("Value(int v)") == 4);
  CHECK(m.uses("v)") == 3);
  CHECK(m.symbol("b.v", 2)->kind == SymbolKind::Parameter);
  CHECK(m.uses("x = n") == 6);
  CHECK(m.uses("S, T") == 4);
  CHECK(m.symbol("rule")->kind == SymbolKind::Priority);
  CHECK(m.uses("in(x)") == 5);
}

TEST_CASE("what stands behind a dot") {
  const Indexed m({kModel});
  CHECK(m.symbol("a.out", 2)->name == "out");
  CHECK(m.symbol("b[i].in", 5)->kind == SymbolKind::Port);
  CHECK(m.symbol("b[i].in", 2)->kind == SymbolKind::LoopVariable);
  CHECK(m.symbol("a.in as", 2)->name == "in");
  const Symbol* p = m.symbol("p(3)");
  REQUIRE(p != nullptr);
  const auto behind = m.index.members_behind_dot(
      m.index.use_at(m.file, static_cast<std::uint32_t>(m.sources.text(m.file).find("p(3)")))->symbol);
  REQUIRE(behind.size() == 1);
  CHECK(m.index.symbols[behind[0]].name == "start");
  CHECK(m.index.symbols[m.index.symbols[behind[0]].type].name == "Value");
}

TEST_CASE("the paper's notation") {
  const Indexed m({R"(component R
  port in(x), out(y)
  data int x, y
  behavior initial to empty
    state empty
      on in provided 0 < x do y <- 2 * x to full
    state full
      on out to empty
  end
end
component Root
  contains R r1(x = 1), r2
  connector conn(r1.out, r2.in)
    define [r1.out', r2.in]
    on r1.out, r2.in do { r2.in.x <- r1.out.y; }
end
)"});
  CHECK(m.uses("empty\n    state") == 3);
  CHECK(m.uses("x), out") == 6);
  CHECK(m.symbol("r2.in.x", 6)->kind == SymbolKind::Data);
  CHECK(m.uses("r2\n") == 5);
}

TEST_CASE("packages") {
  const Indexed m({"package std.a\n port type P()\n const data int k = 1\nend\n",
                   "package b\n use std.a\n atom type A()\n data int x = k\n export port std.a.P p()\n place S\n "
                   "initial to S\n on p from S to S provided (x < std.a.k)\n end\nend\n"});
  CHECK(m.symbol("P p()")->kind == SymbolKind::PortType);
  CHECK(m.symbol("P p()")->name_range.file == FileId(0u));
  CHECK(m.symbol("std.a\n")->kind == SymbolKind::Package);
  CHECK(m.symbol("k\n")->kind == SymbolKind::Constant);
  CHECK(m.uses("k\n") == 3);
}

TEST_CASE("a broken declaration leaves the others") {
  const Indexed m(
      {"package m\n port type P()\n atom type A()\n  export port P p()\n  place S T\n  initial to S\n  on p from\n "
       "end\n atom type B()\n  export port P q()\n  place U\n  initial to U\n  on q from U to U\n end\nend\n"});
  REQUIRE(m.symbol("U to") != nullptr);
  CHECK(m.uses("U to") == 4);
  CHECK(m.symbol("P q()") != nullptr);
}

TEST_CASE("a declaration on one line") {
  const Indexed m({kModel});
  const auto line = [&m](std::string_view at, std::uint32_t skip = 0) {
    const Symbol* symbol = m.symbol(at, skip);
    return symbol == nullptr ? "" : detail_of(*symbol, m.sources);
  };
  CHECK(line("Value(int v)") == "port type Value(int v)");
  CHECK(line("Pass(Value a") == "connector type Pass(Value a, Value b)");
  CHECK(line("in(x), out") == "export port Value in(x)");
  CHECK(line("x = n") == "data int x = n");
  CHECK(line("T\n    initial") == "place T");
  // Where nothing else is said it is the text.
  CHECK(line("c[i](a.out") == "connector Pass c[i](a.out, b[i].in)");
  CHECK(line("rule in < out") == "priority rule in < out");
  CHECK(line("start") == "export port a.in as start");
}

TEST_CASE("uses of large files are in the order of the text") {
  std::string text = "package m\n port type P()\n";
  for (int k = 0; k < 3000; ++k)
    text += " atom type A" + std::to_string(k) +
            "()\n  export port P p()\n  place S\n  initial to S\n  on p from S to S\n end\n";
  const Indexed m({text + "end\n", "package other\n port type P()\nend\n", text + "end\n"});
  const auto place = [](const Use& u) { return std::tuple(u.range.file.value, u.range.begin, u.range.end); };
  for (std::size_t k = 1; k < m.index.uses.size(); ++k) REQUIRE(place(m.index.uses[k - 1]) < place(m.index.uses[k]));
  // A type and its port's type, the port twice, the place four times; the package, and the port type.
  CHECK(m.index.uses.size() == 2 * (3000 * 8 + 2) + 2);
}

TEST_CASE("what is around an offset") {
  const Indexed m({kModel});
  const auto at = [&m](std::string_view what) { return static_cast<std::uint32_t>(m.sources.text(m.file).find(what)); };
  for (const std::string_view what : {"a.v", "x < n", "c[i]", "none p", "package"}) {
    const SymbolId inner = m.index.enclosing(m.file, at(what));
    for (std::uint32_t row = 0; row < m.index.symbols.size(); ++row)
      CHECK(m.index.is_around(SymbolId(row), m.file, at(what)) == (SymbolId(row) == inner));
  }
}
