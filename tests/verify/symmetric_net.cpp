// See symmetric_net.hpp.
#include "tests/verify/symmetric_net.hpp"

#include <algorithm>
#include <iterator>

#include "tests/verify/small_net.hpp"
#include "tools/gen/random.hpp"

namespace bip::verify::test {

namespace {

constexpr const char* kPorts[] = {"p", "q", "r"};

// Places in a circle and some short cuts; a small number that guards read, transfers change, and some steps divide by.
std::string random_type(gen::Prng& random, const std::string& name, bool may_fault) {
  const std::uint64_t places = 2 + random.below(2);
  std::string text = "  atom type " + name + "(int kind)\n    data int n = kind\n" +
                     "    export port Number p(n), q(n), r(n)\n    place P0";
  for (std::uint64_t k = 1; k < places; ++k) text += ", P" + number(k);
  text += "\n    initial to P0\n";
  for (std::uint64_t port = 0; port < 3; ++port) {
    for (std::uint64_t place = 0; place < places; ++place) {
      if (place != port % places && !random.percent(30)) continue;
      text += std::string("    on ") + kPorts[port] + " from P" + number(place) + " to P" +
              number(random.percent(70) ? (place + 1) % places : random.below(places));
      if (random.percent(25)) text += random.percent(50) ? " provided (n > 0)" : " provided (n != 1)";
      if (may_fault && random.percent(10)) text += " do { n = 4 / (2 - n); n = n % 3; }";
      else if (random.percent(30)) text += " do { n = (n + 1) % 3; }";
      text += "\n";
    }
  }
  return text + "  end\n";
}

}  // namespace

SymmetricNet symmetric_net(std::uint64_t seed) {
  gen::Prng random(seed);
  const std::uint64_t size = 3 + random.below(3);
  const bool has_pairs = random.percent(30), may_fault = random.percent(30);
  SymmetricNet net;
  std::string& text = net.text;
  text =
      "package p\n  port type Number(int n)\n"
      "  connector type One(Number a)\n    define a\n  end\n"
      "  connector type Two(Number a, Number b)\n    define a b\n  end\n"
      "  connector type Give(Number a, Number b)\n    define a b\n    on a b provided (a.n != b.n) down { b.n = a.n; "
      "}\n"
      "  end\n"
      "  connector type Swap(Number a, Number b)\n    define a b\n    on a b down { a.n = b.n; }\n  end\n"
      "  connector type Call(Number a, Number b)\n    define a' b\n  end\n"
      "  connector type Three(Number a, Number b, Number c)\n    define a b c\n  end\n";
  text += random_type(random, "Client", may_fault) + random_type(random, "Desk", false);
  text +=
      "  compound type Pair(int kind)\n    component Client a(kind)\n    component Client b(0)\n"
      "    connector Two own(a.p, b.q)\n    export port a.p as p\n    export port a.q as q\n    export port b.r as r\n "
      " end\n";
  // What each client is given: mostly the same.
  const char* const kinds[] = {"0", "0", "0", "i / 2", "i % 2", "i"};
  const std::string range = "    for i in 0.." + number(size) + " ";
  text += "  compound type Root()\n" + range + "component " + (has_pairs ? "Pair" : "Client") + " x[i](" +
          kinds[random.below(std::size(kinds))] + ")\n    component Desk s(1)\n";
  const auto port = [&] { return std::string(".") + kPorts[random.below(3)]; };
  const auto element = [](std::uint64_t i) { return "x[" + number(i) + "]"; };
  const std::string any = "x[i]";
  const std::uint64_t connectors = 3 + random.below(3);
  for (std::uint64_t k = 0; k < connectors; ++k) {
    const std::string name = " c" + number(k);
    switch (random.below(13)) {
      case 0: text += range + "connector One" + name + "[i](" + any + port() + ")\n"; break;
      case 1:
      case 2: text += range + "connector Two" + name + "[i](" + any + port() + ", s" + port() + ")\n"; break;
      case 3:
      case 4: text += range + "connector Give" + name + "[i](" + any + port() + ", s" + port() + ")\n"; break;
      case 5: text += range + "connector Give" + name + "[i](s" + port() + ", " + any + port() + ")\n"; break;
      case 6: text += range + "connector Swap" + name + "[i](" + any + port() + ", s" + port() + ")\n"; break;
      case 7: text += range + "connector Call" + name + "[i](s" + port() + ", " + any + port() + ")\n"; break;
      case 8: {
        // All together.
        const std::string ports = "s" + port() + (random.percent(50) ? "'" : "") + ", x[*]" + port();
        std::string plain = ports;
        std::erase(plain, '\'');
        std::string define = ports;
        std::replace(define.begin(), define.end(), ',', ' ');
        text += "    connector" + name + "(" + plain + ")\n      define [" + define + "]\n";
        break;
      }
      case 9:
        // All pairs of two, in both orders.
        text += range + "{\n      for d in 1.." + number(size) + " connector Give" + name + "[i * " + number(size) +
                " + d](" + any + port() + ", x[(i + d) % " + number(size) + "]" + port() + ")\n    }\n";
        break;
      case 10:
        // A ring.
        text += range + "connector Two" + name + "[i](" + any + port() + ", x[(i + 1) % " + number(size) + "]" +
                port() + ")\n";
        break;
      // Some have more.
      case 11: text += "    connector One" + name + "(" + element(random.below(size)) + port() + ")\n"; break;
      default:
        text += "    connector Three" + name + "(" + element(0) + port() + ", " + element(1) + port() + ", s" + port() +
                ")\n";
    }
  }
  text += "  end\nend\n";
  const auto client = [&](std::uint64_t i) { return element(i) + (has_pairs ? ".a" : ""); };
  const auto condition = [&](const std::string& of) {
    switch (random.below(4)) {
      case 0: return of + ".n == " + number(random.below(3));
      case 1: return "can " + of + port();
      default: return of + "@P" + number(random.below(2));
    }
  };
  // Of all clients, of which some names may take another part.
  const auto over_all = [&](const char* word) {
    const std::string pattern = condition("?");
    std::string all;
    for (std::uint64_t i = 0; i < size; ++i) {
      std::string of_this = random.percent(5) ? condition("?") : pattern;
      of_this.replace(of_this.find('?'), 1, client(i));
      all += (i == 0 ? "" : word) + of_this;
    }
    return all;
  };
  net.properties.push_back("never " + condition(client(0)) + " && " + condition(client(1)));
  net.properties.push_back("never " + condition(client(random.below(size))) + " && (" + over_all(" || ") + ")");
  net.properties.push_back("never " + condition("s") + " && " + over_all(" && "));
  std::string sum;
  for (std::uint64_t i = 0; i < size; ++i) sum += (i == 0 ? "" : " + ") + client(i) + ".n";
  // Quantifiers; `can x[i].a.p` stands for no array.
  const auto any_client = [&] {
    std::string of = condition("?");
    while (of.starts_with("can")) of = condition("?");
    return of.replace(of.find('?'), 1, any + (has_pairs ? ".a" : ""));
  };
  for (int k = 0; k < 3; ++k) {
    const std::string of = any_client() + (random.percent(30) ? " || " + any_client() : "") +
                           (random.percent(15) ? " && i != " + number(random.below(size)) : "");
    const std::string least = number(1 + random.below(size)), over = " i in x: " + of;
    switch (random.below(4)) {
      case 0: net.counted.push_back("never exists" + over); break;
      case 1: net.counted.push_back("never at least " + least + over); break;
      case 2: net.counted.push_back("always at most " + least + over); break;
      default:
        net.counted.push_back("never " + condition(random.percent(80) ? "s" : client(0)) + " && (at least " + least +
                              over + ")");
    }
  }
  net.properties.push_back("always " + sum + " <= " + number(random.below(2 * size)));
  return net;
}

}  // namespace bip::verify::test
