// Folded variables of connectors: code gets the same rows as from a table that is not folded, whoever runs it first, a
// step, a guard, or somebody who looks at a hierarchy's values.
#include <catch2/catch.hpp>

#include <memory>
#include <string>
#include <vector>

#include "compiler/pipeline/pipeline.hpp"
#include "compiler/interp/interp.hpp"
#include "runtime/core/core.hpp"

using namespace bip;
using namespace bip::pipeline;

namespace {

// Two hundred pairs that hand a number to and fro, with the guard on the way back, or through a connector with a value
// of its own.
std::string pairs(const std::string& guard, bool is_nested) {
  return "package m\n"
         "  port type L(int v)\n"
         "  connector type Hand(L give, L take)\n    define give take\n"
         "    on give take " +
         guard +
         " down { take.v = give.v + 1; }\n  end\n"
         "  connector type Up(L give, L take)\n    data int m\n    export port L top(m)\n    define give take\n"
         "    on give take up { m = give.v + take.v; } down { take.v = m; }\n  end\n"
         "  connector type Top(L p)\n    define p\n    on p down { p.v = p.v % 1000 + 1; }\n  end\n"
         "  atom type A()\n    data int v = 0\n    export port L give(v), take(v)\n    place P, Q\n    initial to P\n"
         "    on give from P to Q\n    on take from Q to P\n  end\n"
         "  atom type B(int k)\n    data int v = k\n    export port L give(v), take(v)\n    place P, Q\n    initial to "
         "P\n"
         "    on take from P to Q\n    on give from Q to P\n  end\n"
         "  compound type Root()\n    component A a[200]()\n    for i in 0..200 component B b[i](i * i)\n    for i in "
         "0..200 {\n"
         "      connector Hand back[i](b[i].give, a[i].take)\n" +
         (is_nested ? "      connector Up low[i](a[i].give, b[i].take)\n      connector Top top[i](low[i].top)\n"
                    : "      connector Hand there[i](a[i].give, b[i].take)\n") +
         "    }\n  end\nend\n";
}

// The data after some steps.
std::vector<rt::u64> run(const rt::Image& image, bool looks_first) {
  rt::Core core(image);
  REQUIRE(core.initialize());
  std::vector<rt::Participant> who;
  rt::u64 step = 0;
  for (; step < 3000 && core.candidate_count() != 0; ++step) {
    const rt::u64 k = step * 7919 % core.candidate_count();
    if (looks_first) core.direct_participants(core.candidate(k), who);
    REQUIRE(core.fire(k));
  }
  CHECK(step > 300);
  std::vector<rt::u64> data;
  for (const rt::VariableId variable : bip::IdRange<rt::VariableId>(image.cell_count))
    data.push_back(core.cell(variable).bits);
  return data;
}

}  // namespace

TEST_CASE("folded variables of connectors are what they were") {
  for (const bool is_nested : {false, true}) {
    for (const std::string guard : {"", "provided (give.v < 500)"}) {
      Compilation c{CompileOptions{.root = "Root()"}};
      c.open_texts["m.bip"] = pairs(guard, is_nested);
      REQUIRE(compile(c, "m.bip", Stage::Image));
      const interp::Interpreter interpreter(*c.lowered);
      const rt::Image& image = c.lowered->image;
      REQUIRE(image.binds.repeats.size != 0);
      CHECK(image.binds.rows.size <= 16);
      std::vector<rt::Bind> all;
      for (const rt::Bind& bind : image.binds) all.push_back(bind);
      rt::Image plain = image;
      plain.binds = {all.data(), static_cast<rt::u32>(all.size())};
      for (const bool looks_first : {false, true}) CHECK(run(image, looks_first) == run(plain, looks_first));
    }
  }
}
