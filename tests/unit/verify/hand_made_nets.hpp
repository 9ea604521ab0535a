// Nets that are small enough to know every answer by hand, for the unit tests of the prover's parts.
#pragma once
#include <catch2/catch.hpp>

#include <string>
#include <vector>

#include "compiler/verify/net/mode_reachability.hpp"
#include "compiler/verify/net/net.hpp"
#include "tools/gen/compiled.hpp"

namespace bip::verify::test {

/// A model, its net and what is reachable in that by structure. Neither moves nor copies: the parts refer to each
/// other.
struct HandMadeNet {
  explicit HandMadeNet(const std::string& text)
      : compiled(compile(text)), net(build_net(*compiled.system)), reachable(net, Direction::Forward, nullptr) {
    for (u32 atom = 0; atom + 1 < net.mode_base.size(); ++atom) {
      for (u32 mode : net.class_at(atom).initial) reachable.turn_on(net.mode_base[atom] + mode);
    }
    reachable.run();
  }
  HandMadeNet(const HandMadeNet&) = delete;
  HandMadeNet& operator=(const HandMadeNet&) = delete;

  /// The mode with a name as "lock@FREE".
  [[nodiscard]] u32 mode(const std::string& name) const {
    for (u32 mode = 0; mode < net.mode_count(); ++mode) {
      if (net.mode_name(mode) == name) return mode;
    }
    FAIL("no mode " << name);
    return kNoRow;
  }
  [[nodiscard]] std::vector<u32> modes(const std::vector<std::string>& names) const {
    std::vector<u32> result;
    for (const std::string& name : names) result.push_back(mode(name));
    std::sort(result.begin(), result.end());
    return result;
  }
  /// By mode: 1 if named.
  [[nodiscard]] std::vector<std::uint8_t> marking(const std::vector<std::string>& names) const {
    std::vector<std::uint8_t> result(net.mode_count(), 0);
    for (u32 mode : modes(names)) result[mode] = 1;
    return result;
  }

  gen::Compiled compiled;
  Net net;
  ModeReachability reachable;

 private:
  static gen::Compiled compile(const std::string& text) {
    gen::Compiled result = gen::compile_texts({text});
    INFO(result.problem);
    REQUIRE(result.problem.empty());
    return result;
  }
};

/// A lock and two users; `extra` are further transitions of the lock, `connectors` further connectors. In every
/// reachable state exactly one of lock@FREE, u@IN and v@IN is marked.
[[nodiscard]] inline std::string lock_and_users(const std::string& extra = "", const std::string& connectors = "") {
  return R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  connector type Two(Signal a, Signal b)
    define a b
  end
  atom type Lock()
    export port Signal take(), give(), other()
    place FREE, TAKEN
    initial to FREE
    on take from FREE to TAKEN
    on give from TAKEN to FREE
    )" + extra +
         R"(
  end
  atom type User()
    export port Signal enter(), leave()
    place OUT, IN
    initial to OUT
    on enter from OUT to IN
    on leave from IN to OUT
  end
  compound type Root()
    component Lock lock()
    component User u(), v()
    connector Two eu(u.enter, lock.take), ev(v.enter, lock.take), lu(u.leave, lock.give), lv(v.leave, lock.give)
    )" + connectors +
         R"(
  end
end
)";
}

/// A store of two units; a user takes one, a machine takes two at once. Always: store + users + 2 * machine = 2.
[[nodiscard]] inline std::string store_of_two() {
  return R"(package p
  port type Signal()
  connector type Two(Signal a, Signal b)
    define a b
  end
  atom type Store()
    export port Signal get(), put(), get_two(), put_two()
    place N0, N1, N2
    initial to N2
    on get from N2 to N1
    on get from N1 to N0
    on put from N0 to N1
    on put from N1 to N2
    on get_two from N2 to N0
    on put_two from N0 to N2
  end
  atom type User()
    export port Signal get(), put()
    place IDLE, HAS
    initial to IDLE
    on get from IDLE to HAS
    on put from HAS to IDLE
  end
  compound type Root()
    component Store store()
    component User u(), v(), machine()
    connector Two gu(u.get, store.get), pu(u.put, store.put), gv(v.get, store.get), pv(v.put, store.put)
    connector Two gm(machine.get, store.get_two), pm(machine.put, store.put_two)
  end
end
)";
}

}  // namespace bip::verify::test
