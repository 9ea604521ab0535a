#!/usr/bin/env python3
"""Codels in threads, for which their tasks wait (`bipc genom --task-threads`, compiler/docs/genom.md): a slow one holds up its task and who needs its
data, and nothing else: a request that waits for that data holds up no other module, and rules between the two hold. Both generations of GenoM, one lock a
module and one a datum; without the option the same codels hold up everything, so that the test shows what it is for. A slow codel takes until the test lets it go (`Gate`), so no check depends on how fast the machine is. Python's library only. The last line is "task threads: N passed, N failed".
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

from checks import BIPC, LONG, Client, check, finish, until

WCET = 2.0  # s of slowStart: far more than a codel of 100 ms takes on a loaded machine

SLOW = """component slow {
  ids { long count; long other; };
  task heavy { period 500 ms; codel<start> slowTask(ids in other) yield pause::start; };
  activity think(in long ms, out long counted) {
    task heavy;
    codel<start> slowStart(in ms, ids inout count, out counted) yield again, ether wcet 2000 ms;
    codel<again> slowAgain(ids inout count) yield pause::again, ether;
    codel<stop> slowStop(ids out count) yield ether;
    interrupts think;
  };
  activity judged() { task heavy; validate slowJudge(ids in count); codel<start> slowJudged(ids in other) yield ether; };
  function rest() { codel slowRest(ids in other); interrupts think; };
  function tally() { codel slowTally(ids inout count); };
  function drop() { codel slowTally(ids inout count); interrupts think; };
  attribute get_count(out count);
  attribute get_other(out other);
};
"""
QUICK = """component quick {
  ids { long ticks; };
  task fast { period 10 ms; codel<start> quickTask(ids inout ticks) yield pause::start; };
  activity spin() { task fast; codel<start> quickSpin() yield pause::start; codel<stop> quickHalt() yield ether; };
  function halt() { interrupts spin; };
  attribute get_ticks(out ticks);
};
"""
RULES = """rules both;
modules "slow.gen", "quick.gen";
when slow.think.late run slow.rest;
quick.get_ticks before slow.tally;
apart: never slow.tally && quick.spin;
"""
C = """#include "acslow.h"
#include "acquick.h"
#include <stdio.h>
#include <time.h>
#include <unistd.h>

static void nap(long ms)
{
  struct timespec t = { ms / 1000, ms % 1000 * 1000000 };
  nanosleep(&t, NULL);
}
static void touch(const char *name)
{
  FILE *file = fopen(name, "w");
  if (file) fclose(file);
}
/* Until the test opens the gate; not for ever, if the test fails. */
static void pass_gate(void)
{
  touch("inside");
  for (int k = 0; k < 4000 && access("shut", F_OK) == 0; ++k) nap(5);
  touch("left");
}
genom_event slowTask(int32_t other, genom_context self) { (void)other, (void)self; return slow_pause_start; }
genom_event slowStart(int32_t ms, int32_t *count, int32_t *counted, genom_context self)
{
  (void)self;
  if (access("shut", F_OK) == 0) pass_gate();
  else nap(ms);
  *counted = ++*count;
  return ms >= 1000 ? slow_again : slow_ether;
}
genom_event slowAgain(int32_t *count, genom_context self) { (void)self; *count += 10; return slow_pause_again; }
genom_event slowStop(int32_t *count, genom_context self) { (void)self; *count = -1; return slow_ether; }
genom_event slowRest(int32_t other, genom_context self) { (void)other, (void)self; return genom_ok; }
genom_event slowJudge(int32_t count, genom_context self) { (void)count, (void)self; return genom_ok; }
genom_event slowJudged(int32_t other, genom_context self) { (void)other, (void)self; return slow_ether; }
genom_event slowTally(int32_t *count, genom_context self) { (void)self; ++*count; return genom_ok; }
genom_event quickSpin(genom_context self) { (void)self; return quick_pause_start; }
genom_event quickHalt(genom_context self) { (void)self; return quick_ether; }
genom_event quickTask(int32_t *ticks, genom_context self) { (void)self; ++*ticks; return quick_pause_start; }
"""
OLD = """module old { number: 1; internal_data: DATA; };
request Go { type: exec; exec_task: Motion; codel_main: oldGo; codel_inter: oldInter; };
request Stop { type: control; codel_control: oldMayStop; interrupt_activity: Go; };
exec_task Motion { period: 10; codel_task_main: oldMotion; };
"""
LIVELY = """module lively { number: 2; internal_data: DATA; };
request Count { type: exec; exec_task: Fast; codel_main: livelyCount; fail_reports: TICKS; };
exec_task Fast { period: 1; codel_task_main: livelyFast; };
"""
CPP = """#include "old_codels.hpp"
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <thread>
static std::atomic<int> ticks, naps, inside;
static std::atomic<bool> overlaps;
static void nap(int ms) {
  if (++inside > 1) overlaps = true;
  std::this_thread::sleep_for(std::chrono::milliseconds(ms));
  --inside;
}
static bool is_shut() { return std::filesystem::exists("shut"); }
static void touch(const char* name) {
  if (std::FILE* file = std::fopen(name, "w")) std::fclose(file);
}
// Until the test opens the gate; not for ever, if the test fails.
static void pass_gate() {
  touch("inside");
  if (++inside > 1) overlaps = true;
  for (int k = 0; k < 4000 && is_shut(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  --inside;
  touch("left");
}
int oldGo(int&) { nap(300); return 2; }
int oldMayStop() { return 0; }
int oldInter(int&) { return overlaps ? 201 : 0; }
int oldMotion() {
  if (is_shut()) pass_gate();
  nap(++naps % 4 == 0 ? 250 : 1);
  return 0;
}
int livelyCount(int&) { return 0; }
int livelyFast() { ++ticks; return 0; }
void request_asked(const char*, const char*) {}
void request_input(const char*, const char*) {}
extern "C" const char* bip_poster_value(const char* poster) {
  static std::string json;
  if (std::string_view(poster) != "lively.ticks") return nullptr;
  return (json = std::to_string(ticks)).c_str();
}
"""


class Gate:
    """Holds the next slow codel; files in the folder in which the level runs."""

    def __init__(self, work):
        self.shut, self.inside, self.left = (pathlib.Path(work, name) for name in ("shut", "inside", "left"))
        for file in (self.inside, self.left):
            file.unlink(missing_ok=True)
        self.shut.touch()

    def holds(self):
        """Is a codel inside? It would leave after 20 s if nobody opened the gate."""
        return self.inside.exists() and not self.left.exists()

    def open(self):
        self.shut.unlink()


class Level:
    def __init__(self, work, model):
        self.notes, self.work = [], work
        self.socket = os.path.join(work, "s")
        self.process = subprocess.Popen([BIPC, "serve", model, "--asap", "--policy", "fair", "--seed", "1", "--late-after", "0", "--socket", self.socket], cwd=work, stderr=subprocess.DEVNULL)
        while True:
            assert self.process.poll() is None, "bipc serve has ended"
            try:
                self.client = Client(self.socket, LONG)
                return
            except (FileNotFoundError, ConnectionRefusedError):
                time.sleep(0.02)

    def begin(self, service, **given):
        answer = self.client.ask("request", service=service, input=given if given else "")
        assert answer["ok"], answer
        return answer["request"]

    def next(self, number, reply=None):
        """A note, also one that came while another was waited for; the next reply of any kind."""
        def is_it(note):
            return note["note"] == "request" and note["request"] == number and reply in (None, note["reply"])
        while not any(map(is_it, self.notes)):
            self.notes.append(self.client.note(timeout=LONG))
        note = next(filter(is_it, self.notes))
        self.notes.remove(note)
        return note

    def ask(self, service, **given):
        return self.next(self.begin(service, **given), "final")

    def end(self):
        self.client.ask("shutdown")
        return self.process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()


def make(work, *command):
    done = subprocess.run([BIPC, *command], cwd=work, capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)


def ticks_of_genom3(level):
    return level.ask("quick.get_ticks")["output"]["ticks"]


def think(level):
    """A codel that is held at a gate, in a task of 500 ms; the other component counts every 10 ms."""
    ticks_of_genom3(level)
    gate = Gate(level.work)
    thinks = level.begin("slow.think", ms=1200)
    level.next(thinks, "intermediate")
    check("a codel is slow", until(gate.holds))
    return gate, thinks


def model_of_genom3(work, *options):
    (pathlib.Path(work) / "m.c").write_text(C, encoding="utf-8")
    make(work, "rules", "--served", *options, "--codels", "m.c", "both.rules", "-o", "m.bip")
    make(work, "check", "m.bip")
    return Level(work, "m.bip")


def test_genom3(level):
    gate, thinks = think(level)
    begun = time.monotonic()
    before = ticks_of_genom3(level)
    check("another component goes on", until(lambda: ticks_of_genom3(level) >= before + 15) and gate.holds(), before)
    check("its component answers what needs nothing that the codel has", level.ask("slow.get_other")["report"] == "OK" and gate.holds())
    time.sleep(max(0, begun + WCET + 0.1 - time.monotonic()))
    counts = level.begin("slow.get_count")
    time.sleep(0.3)
    check("what needs its data waits for it", any(row["request"] == counts for row in level.client.ask("requests")["requests"]) and gate.holds(), level.client.notes)
    gate.open()
    got = level.next(counts, "final")
    # -1 if its stop codel was there first.
    check("until it has returned", got["output"]["count"] in (1, -1), got)
    # Late: `rest` interrupts it.
    ended = level.next(thinks, "final")
    check("a rule hears that it was late", ended["report"] == "interrupted" and ended["output"]["counted"] == 1, ended)
    check("and its stop codel has run", level.ask("slow.get_count")["output"]["count"] == -1)
    check("one in time is not stopped", level.ask("slow.think", ms=100)["report"] == "OK")
    first = level.begin("slow.think", ms=300)
    level.next(first, "intermediate")
    time.sleep(0.1)
    second = level.ask("slow.think", ms=10)["report"]
    check("a request that interrupts it before or while its codel runs", second == "OK" and level.next(first, "final")["report"] in ("interrupted", "OK"), second)
    check("it ends", level.end() == 0)


def begin_and_wait(level, module, service, gate):
    """Asks for what needs the data of a codel at a gate; returns when its module has taken the request, and so waits."""
    number = level.begin(f"{module}.{service}")
    box = f"ROOT.{module}.control.box"
    # It leaves these places when it has the data.
    check(f"`{service}` is taken", until(lambda: level.client.ask("state", atoms=[box])["atoms"][box]["place"] in ("allowed", "abtI", "turn")))
    check(f"`{service}` waits", any(row["request"] == number for row in level.client.ask("requests")["requests"]) and gate.holds())
    return number


def test_waiting_requests(level):
    """By what a request waits for: its codel, one that rules decide about, the codel that judges its input."""
    for service in ("get_count", "tally", "drop", "judged"):
        gate, thinks = think(level)
        waits = begin_and_wait(level, "slow", service, gate)
        taken_back = level.begin("slow.get_other")
        check("one that waits for that can be taken back", level.client.ask("cancel", request=taken_back)["ok"] and level.next(taken_back, "final")["report"] == "CANCELLED" and gate.holds())
        later, abort = level.begin("slow.get_other"), level.begin("slow.Abort(think)")
        before = ticks_of_genom3(level)
        check("time goes on for longer than a request waits elsewhere", until(lambda: ticks_of_genom3(level) >= before + 300) and gate.holds(), before)
        waiting = {row["request"] for row in level.client.ask("requests")["requests"]}
        check("other requests to that component wait, `Abort` too", {waits, later, abort} <= waiting and gate.holds(), (later, abort, waiting))
        reports = [level.ask(f"quick.{of}")["report"] for of in ("get_ticks", "halt", "get_ticks")]
        check(f"other components answer while `{service}` waits for data", reports == ["OK"] * 3 and gate.holds(), reports)
        if service == "drop":
            controller = "ROOT.slow.think.controller"
            check("what it interrupts is told before", level.client.ask("state", atoms=[controller])["atoms"][controller]["place"] == "abrt" and gate.holds())
        gate.open()
        check(f"`{service}` is answered after that", level.next(waits, "final")["report"] == "OK")
        # What it names may have been told to stop, and have ended, before it is read.
        reports = [level.next(number, "final")["report"] for number in (abort, later)]
        check("the others, too", reports[0] in ("OK", "UNKNOWN_ACTIVITY") and reports[1] == "OK", reports)
        check("what had the data is stopped", level.ask("slow.rest")["report"] == "OK" and level.next(thinks, "final")["report"] == "interrupted")
    gate, thinks = think(level)
    waits = begin_and_wait(level, "slow", "tally", gate)
    refused = level.ask("quick.spin")
    check("what a rule excludes is refused while the other waits", refused["report"] == "APART" and gate.holds(), refused)
    gate.open()
    check("which is answered after that", level.next(waits, "final")["report"] == "OK")
    check("what had the data is stopped at last", level.ask("slow.rest")["report"] == "OK" and level.next(thinks, "final")["report"] == "interrupted")
    spins = level.begin("quick.spin")
    check("what was excluded is accepted then", level.next(spins)["reply"] == "intermediate")
    check("and excludes the other", level.ask("slow.tally")["report"] == "APART")
    check("until it has ended", level.ask("quick.halt")["report"] == "OK" and level.next(spins, "final")["report"] == "interrupted" and level.ask("slow.tally")["report"] == "OK")


def test_without(level):
    gate, thinks = think(level)
    answers = []
    asks = threading.Thread(target=lambda: answers.append(ticks_of_genom3(level)))
    asks.start()
    time.sleep(WCET + 0.1)
    check("without threads all wait for the codel", not answers and gate.holds(), answers)
    gate.open()
    asks.join()
    check("until it has returned", len(answers) == 1, answers)
    level.next(thinks, "final")
    check("it ends, too", level.end() == 0)


def ticks_of_genom2(level):
    return int(level.client.ask("poster", poster="lively.ticks")["value"])


def model_of_genom2(work, lock, *options):
    (pathlib.Path(work) / "old_codels.cpp").write_text(CPP, encoding="utf-8")
    make(work, "genom", "--served", "--task-threads", "--skeleton", "--lock", lock, *options, "old.gen", "lively.gen", "-o", "old.bip")
    make(work, "check", "old.bip")
    return Level(work, "old.bip")


def test_genom2(level, lock):
    goes = level.begin("old.Go")
    level.next(goes, "intermediate")
    gate = Gate(level.work)
    check(f"lock {lock}: a codel of the task sleeps", until(gate.holds))
    before = ticks_of_genom2(level)
    reports = [level.ask("lively.Count")["report"] for _ in range(10)]
    goes_on = until(lambda: ticks_of_genom2(level) >= before + 40)
    # Its control codel waits: with one lock a module before the request is read, with a lock a datum after that.
    begun = level.begin("old.Stop")
    reports += [level.ask("lively.Count")["report"] for _ in range(2)]
    before = ticks_of_genom2(level)
    goes_on = goes_on and until(lambda: ticks_of_genom2(level) >= before + 300)
    check(f"lock {lock}: a request to it waits for longer than elsewhere", any(row["request"] == begun for row in level.client.ask("requests")["requests"]) and gate.holds())
    check(f"lock {lock}: a module goes on while codels of another sleep for longer than their period", reports == ["OK"] * 12 and goes_on and gate.holds(), reports)
    gate.open()
    stopped = level.next(begun, "final")
    ended = level.next(goes, "final")
    check(f"lock {lock}: it can be stopped, and its codels never overlap", stopped["report"] == "OK" and ended["report"] == "ACTIVITY_INTERRUPTED", (stopped, ended))
    check(f"lock {lock}: it ends", level.end() == 0)


def main():
    with tempfile.TemporaryDirectory(prefix="threads-") as work:
        for name, content in (("slow.gen", SLOW), ("quick.gen", QUICK), ("both.rules", RULES), ("old.gen", OLD), ("lively.gen", LIVELY)):
            (pathlib.Path(work) / name).write_text(content, encoding="utf-8")
        for options in ([], ["--processes"]):
            with model_of_genom3(work, "--task-threads", *options) as level:
                test_waiting_requests(level)
                test_genom3(level)
        with model_of_genom3(work) as level:
            test_without(level)
        for lock in ("module", "codel"):
            for options in ([], ["--processes"]):
                with model_of_genom2(work, lock, *options) as level:
                    test_genom2(level, " ".join([lock, *options]))
    return finish("task threads")


if __name__ == "__main__":
    sys.exit(main())
