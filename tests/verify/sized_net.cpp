// Arrays of equal components: what an instance of one size shows of another.
#include "tests/verify/sized_net.hpp"

#include "tests/verify/small_net.hpp"
#include "tools/gen/random.hpp"

namespace bip::verify::test {

namespace {

// One transition per port and place at most; a circle through all places. Every other type carries a bit, which it gets
// through `p` and changes by `q`.
std::string random_type(gen::Prng& random, const std::string& name) {
  const std::uint64_t places = 2 + random.below(2);
  std::string text = "  atom type " + name + "(bool is_first)\n    data bool bit = is_first\n" +
                     "    export port Bit p(bit), q(bit), r(bit)\n    place P0";
  for (std::uint64_t k = 1; k < places; ++k) text += ", P" + number(k);
  const bool starts_elsewhere = random.percent(30);
  text += "\n    initial to P0\n";
  if (starts_elsewhere) text += "    internal from P0 to P1 provided (is_first && bit) do { bit = false; }\n";
  const char* ports[] = {"p", "q", "r"};
  for (std::uint64_t port = 0; port < 3; ++port) {
    for (std::uint64_t place = 0; place < places; ++place) {
      if (place != port % places && !random.percent(40)) continue;
      text += std::string("    on ") + ports[port] + " from P" + number(place) + " to P" +
              number(random.percent(70) ? (place + 1) % places : random.below(places));
      if (random.percent(20)) text += random.percent(50) ? " provided (bit)" : " provided (!bit)";
      if (port == 1 && random.percent(40)) text += " do { bit = !bit; }";
      text += "\n";
    }
  }
  return text + "  end\n";
}

}  // namespace

std::string sized_net(std::uint64_t seed, std::uint32_t size) {
  gen::Prng random(seed);
  std::string text =
      "package p\n  port type Bit(bool bit)\n"
      "  connector type One(Bit a)\n    define a\n  end\n"
      "  connector type Two(Bit a, Bit b)\n    define a b\n  end\n"
      "  connector type Tell(Bit a, Bit b)\n    define a b\n    on a b down { b.bit = a.bit; }\n  end\n"
      "  connector type Hint(Bit a, Bit b)\n    define a' b\n  end\n"
      "  connector type Three(Bit a, Bit b, Bit c)\n    define a b c\n  end\n";
  text += random_type(random, "Station") + random_type(random, "Lock");
  text += "  compound type Row(int n)\n    for i in 0..n component Station x[i](i == 0)\n    component Lock s(true)\n";
  const char* ports[] = {"p", "q", "r"};
  const auto port = [&] { return std::string(".") + ports[random.below(3)]; };
  const std::uint64_t connectors = 2 + random.below(4);
  for (std::uint64_t k = 0; k < connectors; ++k) {
    const std::string name = " c" + number(k);
    switch (random.below(8)) {
      case 0: text += "    for i in 0..n connector One" + name + "[i](x[i]" + port() + ")\n"; break;
      case 1:
      case 2: text += "    for i in 0..n connector Two" + name + "[i](x[i]" + port() + ", s" + port() + ")\n"; break;
      case 3:
        text += "    for i in 0..n connector Tell" + name + "[i](x[i]" + port() + ", x[(i + 1) % n]" + port() + ")\n";
        break;
      case 4:
        text += "    for i in 1..n connector Tell" + name + "[i](x[i - 1]" + port() + ", x[i]" + port() + ")\n";
        break;
      case 5: text += "    for i in 0..n connector Hint" + name + "[i](s" + port() + ", x[i]" + port() + ")\n"; break;
      case 6:
        text += "    for i in 0..n connector Three" + name + "[i](x[i]" + port() + ", x[(i + 1) % n]" + port() + ", s" +
                port() + ")\n";
        break;
      default: text += "    connector Two" + name + "(x[0]" + port() + ", x[n - 1]" + port() + ")\n";
    }
  }
  return text + "  end\n  compound type Root()\n    component Row row(" + number(size) + ")\n  end\nend\n";
}

}  // namespace bip::verify::test
