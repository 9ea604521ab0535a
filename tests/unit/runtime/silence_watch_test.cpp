// When the launcher of a distributed run reports that a node gives no sign.
#include <catch2/catch.hpp>

#include "runtime/engine/silence_watch.hpp"

using namespace bip::rt;

namespace {

constexpr i64 kWatchBegan = 100 * kBeat;

Sign watched_sign(SilenceWatch& watch, i64 now, i64 heard, i64 lost_after = kForever) {
  watch.begin_look(now);
  return watch.sign(0, heard, lost_after);
}

}  // namespace

TEST_CASE("silence of three beats is reported once, and so is the next sign") {
  SilenceWatch watch(1, kWatchBegan);
  const i64 heard = kWatchBegan + kBeat / 2;
  for (i64 beat = 1; beat <= 3; ++beat) CHECK(watched_sign(watch, kWatchBegan + beat * kBeat, heard) == Sign::Same);
  CHECK(watched_sign(watch, kWatchBegan + 4 * kBeat, heard) == Sign::Silent);
  CHECK(watch.silence(heard) == 3 * kBeat + kBeat / 2);
  CHECK(watched_sign(watch, kWatchBegan + 5 * kBeat, heard) == Sign::Same);
  CHECK(watched_sign(watch, kWatchBegan + 6 * kBeat, kWatchBegan + 6 * kBeat) == Sign::Heard);
  CHECK(watched_sign(watch, kWatchBegan + 7 * kBeat, kWatchBegan + 6 * kBeat) == Sign::Same);
}

TEST_CASE("a node that was never heard is silent from the start on") {
  SilenceWatch watch(1, kWatchBegan);
  for (i64 beat = 1; beat < 3; ++beat) CHECK(watched_sign(watch, kWatchBegan + beat * kBeat, 0) == Sign::Same);
  CHECK(watched_sign(watch, kWatchBegan + 3 * kBeat, 0) == Sign::Silent);
}

TEST_CASE("silence longer than it may be is a loss, and never so for a process of this machine") {
  SilenceWatch remote(1, kWatchBegan), local(1, kWatchBegan);
  for (i64 beat = 1; beat <= 100; ++beat) {
    const Sign sign = watched_sign(remote, kWatchBegan + beat * kBeat, 0, 10 * kBeat);
    CHECK((sign == Sign::Lost) == (beat >= 10));
    CHECK(watched_sign(local, kWatchBegan + beat * kBeat, 0) == (beat == 3 ? Sign::Silent : Sign::Same));
  }
}

TEST_CASE("a launcher that stood still counts silence from then on") {
  SilenceWatch watch(1, kWatchBegan);
  CHECK(watched_sign(watch, kWatchBegan + kBeat, kWatchBegan + kBeat, 10 * kBeat) == Sign::Same);
  // Stopped for a minute; what came meanwhile is not read yet.
  const i64 woken = kWatchBegan + 60 * kBeat;
  CHECK(watched_sign(watch, woken, kWatchBegan + kBeat, 10 * kBeat) == Sign::Same);
  CHECK(watched_sign(watch, woken + kBeat, kWatchBegan + kBeat, 10 * kBeat) == Sign::Same);
  CHECK(watched_sign(watch, woken + 2 * kBeat, kWatchBegan + kBeat, 10 * kBeat) == Sign::Same);
  CHECK(watched_sign(watch, woken + 3 * kBeat, kWatchBegan + kBeat, 10 * kBeat) == Sign::Silent);
  // That it stood still is no sign of the node.
  CHECK(watched_sign(watch, woken + 60 * kBeat, kWatchBegan + kBeat, 10 * kBeat) == Sign::Same);
  CHECK(watched_sign(watch, woken + 61 * kBeat, woken + 61 * kBeat, 10 * kBeat) == Sign::Heard);
}
