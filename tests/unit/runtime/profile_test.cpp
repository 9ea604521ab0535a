// Profiles: counts are exact, times fit into the run's, and a profiled run is the same run.
#include <catch2/catch.hpp>

#include <chrono>
#include <string>

#include "bip/run.hpp"
#include "runtime/core/profile.hpp"
#include "tests/unit/runtime/models.hpp"

using namespace bip::rt;
using namespace bip::rt::testing;

namespace {

struct Profiled {
  std::vector<Code> codes;
  Image image;
  explicit Profiled(const Image& original) : codes(original.codes.begin(), original.codes.end()), image(original) {
    image.codes = {codes.data(), static_cast<u32>(codes.size())};
  }
};

std::string steps_of(const Image& image, Profile* profile, std::uint64_t limit) {
  RunOptions options;
  options.has_seed = true;
  options.limit = limit;
  options.profile = profile;
  std::FILE* out = std::tmpfile();
  (void)run(image, options, out, stderr);
  std::string text;
  std::rewind(out);
  for (int c = std::fgetc(out); c != EOF; c = std::fgetc(out)) text += static_cast<char>(c);
  std::fclose(out);
  return text;
}

// Works for about as long as it is told, by the clock.
std::int32_t spin(const void* context, Cell*, Cell*, const u32*) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::microseconds(*static_cast<const int*>(context));
  while (std::chrono::steady_clock::now() < until) {
  }
  return 1;
}

}  // namespace

TEST_CASE("a profile counts steps and calls, and the run stays the same") {
  ImageBuilder b;
  build_pairs(b, 2);
  Profiled model(b.image());
  const std::string plain = steps_of(model.image, nullptr, 100);
  Profile profile(model.codes);
  CHECK(steps_of(model.image, &profile, 100) == plain);
  // One pair hands over to and fro.
  REQUIRE(profile.interactions().size() == 2);
  CHECK(profile.interactions()[0].name == "ROOT.there0");
  CHECK(profile.interactions()[0].steps == 50);
  CHECK(profile.interactions()[1].steps == 50);
  std::uint64_t calls = 0;
  for (std::size_t row = 0; row < model.codes.size(); ++row) calls += profile.code(row).calls;
  CHECK(calls == 150);
  double seconds = 0;
  for (const InteractionProfile& row : profile.interactions()) seconds += profile.seconds_of(row);
  CHECK(seconds <= profile.seconds());
}

TEST_CASE("a profile says who is slow") {
  ImageBuilder b;
  build_pairs(b, 2);
  Profiled model(b.image());
  // The action of Ping's `get` takes 20 ms, the transfer 20 us a time, the rest next to nothing: 400 ms in all are not
  // lost in the time slices that a loaded machine gives to others.
  int slow = 20000, brief = 20;
  u32 action = kNone, down = model.image.connector_types[0].clauses[0].down;
  for (const Transition& t : model.image.atom_types[0].transitions) action = t.action == kNone ? action : t.action;
  REQUIRE(action != kNone);
  model.codes[action] = {&spin, &slow};
  model.codes[down] = {&spin, &brief};
  Profile profile(model.codes);
  (void)steps_of(model.image, &profile, 40);
  CHECK(profile.code(action).calls == 20);
  CHECK(profile.code(down).calls == 40);
  CHECK(profile.seconds_of(profile.code(action)) >= 20 * 20000e-6 * 0.99);
  CHECK(profile.seconds_of(profile.code(down)) >= 40 * 20e-6 * 0.99);
  const InteractionProfile& there = profile.interactions()[0];
  const InteractionProfile& back = profile.interactions()[1];
  CHECK(profile.seconds_of(back) > profile.seconds_of(there));
  CHECK(profile.code_seconds_of(back) <= profile.seconds_of(back) * 1.01);
}

TEST_CASE("without its profile the code is as before") {
  ImageBuilder b;
  build_pairs(b, 2);
  Profiled model(b.image());
  const std::vector<Code> before = model.codes;
  {
    const Profile profile(model.codes);
    CHECK(model.codes[0].fn != before[0].fn);
  }
  for (std::size_t row = 0; row < before.size(); ++row) {
    CHECK(model.codes[row].fn == before[row].fn);
    CHECK(model.codes[row].context == before[row].context);
  }
}
