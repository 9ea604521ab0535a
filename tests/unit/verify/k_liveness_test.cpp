// k-liveness on systems with known answers: what holds is proved, on how many atoms; what a run violates is not,
// whether the run repeats, ends, or is unfair.
#include <catch2/catch.hpp>

#include <string>

#include "compiler/verify/liveness/finite_moves.hpp"
#include "tests/unit/verify/hand_made_nets.hpp"

namespace bip::verify {

namespace {

using test::HandMadeNet;

constexpr std::uint32_t kEnough = 16;

RunCircuit circuit_of(const HandMadeNet& made, const KLivenessOptions& options) {
  return make_run_circuit(*made.compiled.system, made.compiled.lowered->image, 2048, options.cancellation);
}
KLivenessProof prove(const HandMadeNet& made, const std::string& property, const std::string& fairness) {
  Result<ParsedProperty> parsed = PropertyReader(*made.compiled.system).read(property);
  REQUIRE(parsed);
  REQUIRE(parsed->form == PropertyForm::Runs);
  KLivenessOptions options;
  Result<Fairness> read = read_fairness(fairness, *made.compiled.system);
  REQUIRE(read);
  options.fairness = std::move(*read);
  options.most_rounds = kEnough;
  const System& system = *made.compiled.system;
  const rt::Image& image = made.compiled.lowered->image;
  return prove_by_k_liveness(parsed->formula, system, image, circuit_of(made, options), options);
}
bool is_proved(const HandMadeNet& made, const std::string& property, const std::string& fairness) {
  return prove(made, property, fairness).outcome == Outcome::Holds;
}

// Two processes and a key; each may be overtaken for ever.
const char* const kKey = R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  connector type Two(Signal a, Signal b)
    define a b
  end
  atom type Process()
    export port Signal ask(), enter(), leave()
    place OUTSIDE, WAITS, INSIDE
    initial to OUTSIDE
    on ask from OUTSIDE to WAITS
    on enter from WAITS to INSIDE
    on leave from INSIDE to OUTSIDE
  end
  atom type Key()
    export port Signal take(), put()
    place FREE, TAKEN
    initial to FREE
    on take from FREE to TAKEN
    on put from TAKEN to FREE
  end
  compound type Root()
    component Process p(), q()
    component Key key()
    connector One p_asks(p.ask), q_asks(q.ask)
    connector Two p_enters(p.enter, key.take), q_enters(q.enter, key.take)
    connector Two p_leaves(p.leave, key.put), q_leaves(q.leave, key.put)
  end
end
)";

// Counts to 3 and ends, or stops before; beside it `ticks` go on if there is one.
std::string counter(const std::string& ticks) {
  return R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Counter()
    data int n = 0
    export port Signal more(), stop()
    place COUNTS, STOPPED
    initial to COUNTS
    on more from COUNTS to COUNTS provided (n < 3) do { n = n + 1; }
    on stop from COUNTS to STOPPED
  end
  atom type Clock()
    export port Signal tick()
    place T
    initial to T
    on tick from T to T
  end
  compound type Root()
    component Counter c()
    connector One more(c.more), stop(c.stop)
)" + ticks +
         R"(
  end
end
)";
}
const char* const kTicks = "    component Clock clock()\n    connector One tick(clock.tick)\n";

// Each asks once.
const char* const kQueue = R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Process()
    export port Signal ask(), enter()
    place OUTSIDE, WAITS, SERVED
    initial to OUTSIDE
    on ask from OUTSIDE to WAITS
    on enter from WAITS to SERVED
  end
  compound type Root()
    component Process p[6]()
    for i in 0..6 connector One ask[i](p[i].ask), enter[i](p[i].enter)
  end
end
)";

// models/scaling/bakery.bip, but who was served does not come again.
const char* const kBakeryOfOneDay = R"(package bakery
  port type Signal()
  port type Ticket(int ticket)
  port type Look(int ticket, int next)
  port type Show(int ticket, int me)
  port type Draw(int ticket, int most)
  connector type Alone(Signal customer)
    define customer
  end
  connector type Higher(Ticket a, Ticket b)
    data int ticket
    export port Ticket highest(ticket)
    define a b
    on a b up { if (a.ticket < b.ticket) then ticket = b.ticket; else ticket = a.ticket; fi }
  end
  connector type Drawn(Draw customer, Ticket others)
    define customer others
    on customer others provided (others.ticket < customer.most) down { customer.ticket = others.ticket + 1; }
  end
  connector type Pass(Look customer, Show other)
    define customer other
    on customer other provided (other.me == customer.next && (other.ticket == 0 || customer.ticket < other.ticket))
  end
  atom type Customer(int me, int n, int highest)
    data int self = me, ticket = 0, next = 0, most = highest
    export port Draw draw(ticket, most)
    export port Look pass(ticket, next)
    export port Ticket value(ticket)
    export port Show show(ticket, self)
    export port Signal leave()
    place AWAY, HOLDS, SERVED, GONE
    initial to AWAY
    on draw from AWAY to HOLDS do { next = (self + 1) % n; }
    on pass from HOLDS to HOLDS do { next = (next + 1) % n; }
    internal from HOLDS to SERVED provided (next == self) do { next = 0; }
    on leave from SERVED to GONE do { ticket = 0; }
    final GONE
    on value from GONE to GONE
    on show from GONE to GONE
    on value from AWAY to AWAY
    on value from HOLDS to HOLDS
    on value from SERVED to SERVED
    on show from AWAY to AWAY
    on show from HOLDS to HOLDS
    on show from SERVED to SERVED
  end
  compound type Shop(int n)
    for i in 0..n component Customer customer[i](i, n, 2 * n)
    for i in 0..n {
      connector Alone leave[i](customer[i].leave)
      connector Higher higher[i * n + 2](customer[(i + 1) % n].value, customer[(i + 2) % n].value)
      for k in 3..n connector Higher higher[i * n + k](higher[i * n + k - 1].highest, customer[(i + k) % n].value)
      connector Drawn draw[i](customer[i].draw, higher[i * n + n - 1].highest)
      for k in 1..n connector Pass pass[i * n + k](customer[i].pass, customer[(i + k) % n].show)
    }
  end
  compound type Root()
    component Shop shop(3)
  end
end
)";

// Many that are independent of each other.
const char* const kMany = R"(package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Process()
    export port Signal begin(), done()
    place IDLE, BUSY
    initial to IDLE
    on begin from IDLE to BUSY
    on done from BUSY to IDLE
  end
  compound type Root()
    component Process p[40]()
    for i in 0..40 connector One begin[i](p[i].begin)
    for i in 0..40 connector One done[i](p[i].done)
  end
end
)";

}  // namespace

TEST_CASE("k-liveness: fairness decides who gets the key") {
  const HandMadeNet key(kKey);
  CHECK(is_proved(key, "p@INSIDE leads to p@OUTSIDE", "weak"));
  CHECK(is_proved(key, "p@WAITS leads to p@INSIDE", "strong"));
  CHECK(is_proved(key, "p@WAITS leads to p@INSIDE", "strong:atoms"));
  CHECK(is_proved(key, "always eventually happens key.take", "weak"));
  CHECK_FALSE(is_proved(key, "p@WAITS leads to p@INSIDE", "none"));
  CHECK_FALSE(is_proved(key, "p@WAITS leads to p@INSIDE", "weak"));
  CHECK_FALSE(is_proved(key, "always eventually p@INSIDE", "none"));
}

TEST_CASE("k-liveness: fairness of things with names") {
  const HandMadeNet key(kKey);
  CHECK(is_proved(key, "p@WAITS leads to p@INSIDE", "strong:p_enters,weak:q_leaves"));
  CHECK(is_proved(key, "p@WAITS leads to p@INSIDE", "strong:p.enter,weak:key.put"));
  CHECK(is_proved(key, "p@WAITS leads to p@INSIDE", "strong:p,weak"));
  CHECK_FALSE(is_proved(key, "p@WAITS leads to p@INSIDE", "weak:p_enters,strong:q_leaves"));
  CHECK_FALSE(is_proved(key, "p@WAITS leads to p@INSIDE", "strong:key"));
}

TEST_CASE("k-liveness: a run that ends repeats its last state") {
  const HandMadeNet ends(counter(""));
  CHECK(is_proved(ends, "eventually always (c@STOPPED || c.n == 3)", "weak"));
  CHECK(is_proved(ends, "eventually always !happens more", "none"));
  CHECK(is_proved(ends, "eventually c@STOPPED", "none"));
  CHECK_FALSE(is_proved(ends, "eventually c.n == 3", "none"));
  CHECK_FALSE(is_proved(ends, "eventually c.n == 3", "strong"));
  CHECK_FALSE(is_proved(ends, "always eventually happens stop", "strong"));
}

TEST_CASE("k-liveness: what others do may go on for ever") {
  const HandMadeNet goes_on(counter(kTicks));
  CHECK_FALSE(is_proved(goes_on, "eventually c@STOPPED", "none"));
  CHECK_FALSE(is_proved(goes_on, "eventually c.n == 3", "weak"));
  CHECK(is_proved(goes_on, "eventually c@STOPPED", "weak"));
  CHECK(is_proved(goes_on, "eventually c@STOPPED", "weak:atoms"));
  CHECK(is_proved(goes_on, "(eventually c@STOPPED) || (always eventually happens tick)", "none"));
}

TEST_CASE("k-liveness: a part of the system suffices, whose states are few") {
  const HandMadeNet many(kMany);
  const KLivenessProof proof = prove(many, "p[7]@BUSY leads to p[7]@IDLE", "weak");
  CHECK(proof.outcome == Outcome::Holds);
  CHECK(proof.atoms == 1);
  CHECK(proof.units == 1);
  CHECK(proof.lemmas > 0);
}

TEST_CASE("k-liveness: an invariant that looks back has no rounds") {
  const HandMadeNet key(kKey);
  const KLivenessProof proof = prove(key, "always (p@INSIDE implies once happens p_asks)", "none");
  CHECK(proof.outcome == Outcome::Holds);
  CHECK(proof.rounds == 0);
  CHECK_FALSE(is_proved(key, "always (p@INSIDE implies once happens q_asks)", "none"));
  CHECK_FALSE(is_proved(key, "always (happens p_enters implies previously happens p_asks)", "none"));
}

TEST_CASE("finite moves: who waits is served, because the others come to rest") {
  const HandMadeNet queue(kQueue);
  Result<ParsedProperty> parsed = PropertyReader(*queue.compiled.system).read("p[0]@WAITS leads to p[0]@SERVED");
  REQUIRE(parsed);
  const System& system = *queue.compiled.system;
  const rt::Image& image = queue.compiled.lowered->image;
  const RunCircuit circuit = circuit_of(queue, {});
  const KLivenessProof proof = prove_by_finite_moves(parsed->formula, system, image, circuit, {});
  CHECK(proof.outcome == Outcome::Holds);
  // Both of each process.
  CHECK(proof.finite_ports == 12);
  // All ports are finite here, and so are the runs: their last states violate these.
  for (const char* const violated : {"p[0]@SERVED leads to p[0]@WAITS", "always eventually p[1]@WAITS"}) {
    Result<ParsedProperty> other = PropertyReader(system).read(violated);
    REQUIRE(other);
    CHECK(prove_by_finite_moves(other->formula, system, image, circuit, {}).outcome == Outcome::Unknown);
  }
}

TEST_CASE("finite moves: a run that ends in final places ends") {
  const HandMadeNet bakery(kBakeryOfOneDay);
  const System& system = *bakery.compiled.system;
  const RunCircuit circuit = circuit_of(bakery, {});
  const auto is_proved_by_finite_moves = [&](const char* property) {
    Result<ParsedProperty> parsed = PropertyReader(system).read(property);
    REQUIRE(parsed);
    return prove_by_finite_moves(parsed->formula, system, bakery.compiled.lowered->image, circuit, {}).outcome ==
           Outcome::Holds;
  };
  CHECK(is_proved_by_finite_moves("shop.customer[0]@HOLDS leads to shop.customer[0]@SERVED"));
  // All steps have a finite port, and the lemmas exclude deadlocks, but not that all are gone.
  CHECK_FALSE(is_proved_by_finite_moves("shop.customer[0]@SERVED leads to shop.customer[0]@AWAY"));
}

TEST_CASE("k-liveness: no time, no answer") {
  const HandMadeNet key(kKey);
  Result<ParsedProperty> parsed = PropertyReader(*key.compiled.system).read("p@INSIDE leads to p@OUTSIDE");
  REQUIRE(parsed);
  KLivenessOptions options;
  options.cancellation = within_seconds(0);
  const KLivenessProof proof = prove_by_k_liveness(parsed->formula, *key.compiled.system, key.compiled.lowered->image,
                                                   circuit_of(key, {}), options);
  CHECK(proof.outcome == Outcome::Unknown);
  CHECK(proof.is_out_of_time);
}

}  // namespace bip::verify
