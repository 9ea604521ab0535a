// Reading the published engine's text: states, choices, cut-off ends, and what counts as the same candidate.
#include <catch2/catch.hpp>

#include "compiler/driver/published_trace.hpp"

using namespace bip::driver;

TEST_CASE("states, candidates and choices are read, other lines passed over") {
  const auto trace = read_published_trace(
      "[BIP ENGINE]: initialize components...\n"
      "something that the model says\n"
      "[BIP ENGINE]: state #0: 1 interaction and 1 internal port:\r\n"
      "[BIP ENGINE]:   [0] ROOT.k: p.put(v=1;) c.get(v=0;)\r\n"
      "[BIP ENGINE]:   [1] ROOT.a.think\n"
      "[BIP ENGINE]: -> choose [1] ROOT.a.think\n"
      "[BIP ENGINE]: state #1: deadlock!\n");
  REQUIRE(trace);
  REQUIRE((*trace).states.size() == 2);
  const TraceState& first = (*trace).states[0];
  CHECK(first.line == 3);
  CHECK(first.candidates == std::vector<std::string>{"ROOT.k: p.put(v=1;) c.get(v=0;)", "ROOT.a.think"});
  CHECK(first.chosen == "ROOT.a.think");
  CHECK(first.is_complete);
  CHECK((*trace).states[1].is_deadlock);
  CHECK((*trace).states[1].candidates.empty());
}

TEST_CASE("a last state that was cut off is not complete") {
  const auto trace = read_published_trace(
      "[BIP ENGINE]: state #7 and global time 6s: 2 interactions:\n"
      "[BIP ENGINE]:   [0] ROOT.k: a.p()\n");
  REQUIRE(trace);
  CHECK((*trace).states[0].number == 7);
  CHECK_FALSE((*trace).states[0].is_complete);
}

TEST_CASE("a limit is no state") {
  const auto trace = read_published_trace(
      "[BIP ENGINE]: state #0: 1 internal port:\n[BIP ENGINE]:   [0] ROOT.a.p\n[BIP ENGINE]: state #1: limit "
      "reached\n");
  REQUIRE(trace);
  CHECK((*trace).states.size() == 1);
}

TEST_CASE("what is no trace fails with a reason") {
  CHECK_FALSE(read_published_trace("hello\n"));
  CHECK_FALSE(read_published_trace("[BIP ENGINE]: state #x: 1 interaction:\n"));
  const auto choice = read_published_trace("[BIP ENGINE]: -> choose [0] ROOT.k\n");
  REQUIRE_FALSE(choice);
  CHECK(choice.error().find("line 1") == 0);
}

TEST_CASE("candidates are compared apart from spaces, truth values, quotes and late digits") {
  CHECK(normal_candidate("R.k:  a.p(b=true;)   c.q()") == normal_candidate("R.k: a.p(b=1;) c.q()"));
  CHECK(normal_candidate("R.k: a.p(x=0.333333;)") == normal_candidate("R.k: a.p(x=0.3333333333333333;)"));
  CHECK(normal_candidate("R.k: a.p(s=\"a; b=2\";y=1;)") == normal_candidate("R.k: a.p(s=\"a; b=2\";y=1;)"));
  CHECK(normal_candidate("R.k: a.p(x=1;)") != normal_candidate("R.k: a.p(x=2;)"));
  CHECK(normal_candidate("R.k: a.p(x=1000001;)") != normal_candidate("R.k: a.p(x=1000002;)"));
}

TEST_CASE("the engine for real time writes instants and intervals of models without time") {
  const auto trace = read_published_trace(
      "[BIP ENGINE]: state #0 and global time 0: 1 interaction and 1 internal port:\n"
      "[BIP ENGINE]:   [0] ROOT.k: a.p(s=\"x) [1\";) [ now, +INFTY ]\n"
      "[BIP ENGINE]:   [1] ROOT.a.think [ now, +INFTY ]\n"
      "[BIP ENGINE]: -> choose [1] ROOT.a.think [ now, +INFTY ] at global time 0\n"
      "[BIP ENGINE]: ERROR: the invariant ROOT.a.i has been violated!\n");
  REQUIRE(trace);
  const TraceState& first = (*trace).states.at(0);
  CHECK(without_intervals(first.candidates.at(0)) == "ROOT.k: a.p(s=\"x) [1\";)");
  CHECK(without_intervals(first.candidates.at(1)) == "ROOT.a.think");
  CHECK(first.candidates.at(1) == "ROOT.a.think [ 0, +INFTY [");
  CHECK(first.chosen == "ROOT.a.think");
  CHECK(first.instant == "0");
  CHECK((*trace).end == TraceEnd::Invariant);
}

TEST_CASE("an end before the first state, and a last line that was cut off") {
  const auto early = read_published_trace("[BIP ENGINE]: state #0 and global time 0: time-lock at 5s!\n");
  REQUIRE(early);
  CHECK((*early).states.empty());
  CHECK((*early).end == TraceEnd::TimeLock);
  const auto cut = read_published_trace(
      "[BIP ENGINE]: state #0: 1 interaction:\n[BIP ENGINE]:   [0] ROOT.k: a.p()\n[BIP ENGINE]: -> choose [0] ROOT.k: "
      "a");
  REQUIRE(cut);
  CHECK((*cut).states.at(0).chosen.empty());
  const auto shorter = read_published_trace("[BIP ENGINE]: state #0: 1 interaction:\n[BIP ENGINE]:   [");
  REQUIRE(shorter);
  CHECK_FALSE((*shorter).states.at(0).is_complete);
}

TEST_CASE("a last line without its end says nothing for certain") {
  const std::string head = "[BIP ENGINE]: state #0 and global time 0ns: 1 interaction:\n";
  const std::string whole = "[BIP ENGINE]:   [0] ROOT.k: a.p(v=10;)\n";
  // A candidate, or a beginning of it.
  for (const std::size_t length : {whole.size() - 1, whole.size() - 4, std::size_t{30}}) {
    const auto trace = read_published_trace(head + whole.substr(0, length));
    REQUIRE(trace);
    CHECK((*trace).states.at(0).candidates.empty());
    CHECK_FALSE((*trace).states.at(0).is_complete);
  }
  const std::string choice = "[BIP ENGINE]: -> choose [0] ROOT.k: a.p(v=10;) at global time 1s400ms";
  for (const std::size_t cut : {0, 4, 5}) {
    const auto trace = read_published_trace(head + whole + choice.substr(0, choice.size() - cut));
    REQUIRE(trace);
    CHECK((*trace).states.at(0).is_complete);
    CHECK((*trace).states.at(0).chosen.empty());
  }
  CHECK((*read_published_trace(head + whole + choice + "\n")).states.at(0).instant == "1s400ms");
}

TEST_CASE("what the end of a trace names is read, and nothing of an end that was cut off") {
  const std::string head = "[BIP ENGINE]: state #0: 1 internal port:\n[BIP ENGINE]:   [0] ROOT.a.p\n";
  const std::string choice = "[BIP ENGINE]: -> choose [0] ROOT.a.p\n";
  const std::string error = "[BIP ENGINE]: ERROR: the invariant i of component ROOT.a has been violated!";
  for (const std::string& line :
       {error, error + "\n", std::string("[BIP ENGINE]: ERROR: invariant ROOT.a.i violated!\n")}) {
    const auto trace = read_published_trace(head + choice + line);
    REQUIRE(trace);
    CHECK((*trace).end == TraceEnd::Invariant);
    CHECK((*trace).end_invariant == "i");
    CHECK((*trace).end_component == "ROOT.a");
  }
  for (std::size_t length = error.find("ERROR") + 5; length < error.size(); ++length) {
    const auto trace = read_published_trace(head + choice + error.substr(0, length));
    REQUIRE(trace);
    CHECK((*trace).end == TraceEnd::CutError);
    CHECK((*trace).end_invariant.empty());
  }
  CHECK((*read_published_trace(head + "[BIP ENGINE]: ERROR: Petri net not 1-safe in ROOT.b.c!\n")).end_component ==
        "ROOT.b.c");
  CHECK((*read_published_trace("[BIP ENGINE]: state #0 and global time 0: time-lock at 5s!\n")).end_lock == "5s");
  CHECK((*read_published_trace("[BIP ENGINE]: state #0 and global time 0: time-lock at 5")).end_lock.empty());
}

TEST_CASE("a trace ends behind a choice if nothing whole follows it") {
  const std::string head = "[BIP ENGINE]: state #0: 1 internal port:\n[BIP ENGINE]:   [0] ROOT.a.p\n";
  const std::string choice = "[BIP ENGINE]: -> choose [0] ROOT.a.p\n";
  const auto ends_so = [](const std::string& text) { return (*read_published_trace(text)).ends_behind_choice; };
  CHECK_FALSE(ends_so(head));
  CHECK(ends_so(head + choice));
  CHECK(ends_so(head + choice + "[BIP ENGINE]: state #1"));
  CHECK_FALSE(ends_so(head + choice + "[BIP ENGINE]: state #1: limit reached\n"));
  CHECK_FALSE(ends_so(head + choice + "[BIP ENGINE]: state #1: 1 interaction:\n"));
}

TEST_CASE("numbers and instants that no engine writes are refused with their line") {
  const std::string state = ": 1 interaction:\n[BIP ENGINE]:   [0] ROOT.k: a.p()\n";
  const std::string choice = "[BIP ENGINE]: -> choose [0] ROOT.k: a.p()\n";
  const auto error_of = [](const std::string& text) {
    const auto trace = read_published_trace(text);
    return trace ? std::string("none") : trace.error();
  };
  const std::string first = "[BIP ENGINE]: state #0" + state + choice;
  CHECK(error_of(first + "[BIP ENGINE]: state #1" + state) == "none");
  CHECK(error_of(first + "[BIP ENGINE]: state #9" + state) ==
        "line 4 has a number that does not follow that of the state before");
  CHECK(error_of("[BIP ENGINE]: state #0: 7 interactions:\n[BIP ENGINE]:   [0] ROOT.k: a.p()\n" + choice) ==
        "line 3 follows a state that lists fewer interactions than it announces");
  CHECK(error_of(first + "[BIP ENGINE]: state #1" + state + "[BIP ENGINE]:   [1] ROOT.k: b.p()\n") ==
        "line 6 is one interaction more than its state announces");
  CHECK(error_of("[BIP ENGINE]: state #0 and global time 1s4m" + state) == "line 1 has no instant");
  CHECK(error_of("[BIP ENGINE]: state #0" + state +
                 "[BIP ENGINE]: -> choose [0] ROOT.k: a.p() at global time 1s4m\n[BIP ENGINE]: more\n") ==
        "line 3 chooses at no instant");
}
