#!/usr/bin/env python3
"""Codels in processes of their own under `bipc serve` (compiler/docs/genom.md): what crashes, exits or hangs ends its module, and nothing else.

The same two modules are served twice: with --processes, where each fault is one activity that fails while the other module drives, answers, and is stopped by
a rule; and without, where the same fault ends the server, so that the test shows what it is for. Python's library only. The last line is "processes: N passed, N failed".
"""
import os
import pathlib
import signal
import subprocess
import tempfile
import time

from checks import BIPC, LONG, Client, check, finish, processes_below, runs, until

EYE = """module eye { number: 1; internal_data: DATA; };
request Init { type: init; exec_task: Look; codel_main: eyeInit; };
request Address { type: exec; exec_task: Look; codel_main: eyeAddress; };
request Die { type: exec; exec_task: Look; codel_main: eyeDie; };
request Exit { type: exec; exec_task: Look; codel_main: eyeExit; };
request Hang { type: exec; exec_task: Look; codel_main: eyeHang; };
request Slow { type: exec; exec_task: Slowly; codel_main: eyeSlow; };
request Watch { type: exec; exec_task: Look; codel_main: eyeWatch; };
request Count { type: exec; exec_task: Look; codel_control: eyeJudge; codel_main: eyeCount; fail_reports: EMPTY; };
request Set { type: control; codel_control: eyeSet; };
exec_task Look { period: 2; };
exec_task Slowly { period: 2; };
poster Seen { update: auto; data: s::seen; exec_task: Look; };
"""
WHEEL = """module wheel { number: 2; internal_data: DATA; };
request Drive { type: exec; exec_task: Motion; codel_main: wheelDrive; codel_inter: wheelBrake; };
request Stop { type: control; interrupt_activity: Drive; };
request Count { type: exec; exec_task: Motion; codel_main: wheelCount; };
request Peek { type: exec; exec_task: Motion; codel_main: wheelPeek; };
exec_task Motion { period: 2; };
"""
RULES = """rules robot;
modules "eye.gen", "wheel.gen" with "robot.yields";
value seen of eye.Seen: 0, 1;
enough: wheel.Peek requires eye.Seen.seen < 2 report "SEEN-ENOUGH";
blind: when eye.Address.failed run wheel.Stop report "BLIND";
"""
CODELS = """#include "robot_codels.hpp"
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>
namespace {
int count = 0, seen = 0;
std::string asked, accepted;
void note(const std::string& what) {
  std::FILE* file = std::fopen("events", "a");
  std::fprintf(file, "%s\\n", what.c_str());
  std::fclose(file);
}
}  // namespace
void request_asked(const char* service, const char* input) { if (!std::strcmp(service, "eye.Count")) asked = input; }
void request_input(const char* service, const char* input) { if (!std::strcmp(service, "eye.Count")) accepted = input; }
extern "C" void safe_stop(const char* why) { note(std::string("stop: ") + why); }
extern "C" const char* bip_poster_value(const char* poster) {
  static std::string json;
  json = "{\\"seen\\":" + std::to_string(seen) + "}";
  return std::strcmp(poster, "eye.Seen") == 0 ? json.c_str() : nullptr;
}
int eye_Seen_seen() { return seen; }
int eyeInit(int&) { return 0; }
int eyeAddress(int&) { static volatile long nowhere = 0; *reinterpret_cast<volatile int*>(nowhere) = 1; return 0; }
int eyeDie(int&) { std::abort(); }
int eyeExit(int&) { std::exit(0); }
int eyeHang(int&) { std::this_thread::sleep_for(std::chrono::seconds(30)); return 0; }
int eyeSlow(int&) { std::this_thread::sleep_for(std::chrono::milliseconds(2500)); return 0; }
int eyeWatch(int&) { return 2; }
int eyeJudge() { return asked == "bad" ? 1 : 0; }
int eyeCount(int&) { ++seen; note("eye counts " + std::to_string(++count) + " " + accepted); return 0; }
int eyeSet() { return 0; }
int wheelDrive(int&) { return 2; }
int wheelBrake(int&) { return 0; }
int wheelPeek(int&) { return 0; }
int wheelCount(int&) { note("wheel counts " + std::to_string(++count)); return 0; }
"""


class Level:
    def __init__(self, work, *options):
        self.work = work
        work.mkdir()
        for name, text in (("eye.gen", EYE), ("wheel.gen", WHEEL), ("robot.rules", RULES), ("robot_codels.cpp", CODELS), ("robot.yields", "codel eyeSlow async 10 s\n")):
            (work / name).write_text(text, encoding="utf-8")
        made = subprocess.run([BIPC, "rules", "robot.rules", "--served", "--skeleton", *options, "-o", "robot.bip"], cwd=work, capture_output=True, text=True)
        assert made.returncode == 0, made.stdout + made.stderr
        with open(work / "log", "w", encoding="utf-8") as log:
            self.server = subprocess.Popen([BIPC, "serve", "--asap", "--policy", "fair", "--socket", "s", "--stall-after", "0", "robot.bip"], cwd=work, stdout=log, stderr=log)
        while "listening" not in self.log():
            assert self.server.poll() is None, self.log()
            time.sleep(0.02)
        here = os.getcwd()
        os.chdir(work)  # the path of a socket is short
        self.client = Client("s", LONG)
        os.chdir(here)
        self.client.ask("subscribe", requests=True)
        self.replies = {}

    def log(self):
        return (self.work / "log").read_text(encoding="utf-8")

    def events(self):
        return (self.work / "events").read_text(encoding="utf-8").splitlines() if (self.work / "events").exists() else []

    def stopped(self, *parts, since=0):
        """Is the safe-stop function called with these words? It runs beside everything else."""
        return bool(until(lambda: [e for e in self.events()[since:] if e.startswith("stop: ") and all(p in e for p in parts)]))

    def begin(self, service, input=""):
        answer = self.client.ask("request", service=service, input=input)
        assert answer["ok"], answer
        return answer["request"]

    def reply(self, number, kind="final", seconds=LONG):
        end = time.monotonic() + seconds
        while (number, kind) not in self.replies and time.monotonic() < end:
            try:
                note = self.client.note(timeout=1)
            except TimeoutError:
                continue
            if note["note"] == "request":
                self.replies[note["request"], note["reply"]] = note
        return self.replies.get((number, kind), {"report": f"no {kind} reply"})

    def ask(self, service, input=""):
        return self.reply(self.begin(service, input))

    def processes(self):
        return processes_below(self.server.pid)


def revive(level):
    """After a crash of GenoM 2's module: zombies go, then it is initialised anew."""
    while level.ask("eye.Abort")["report"] != "UNKNOWN_ACTIVITY":
        pass
    check("its init runs again", (got := level.ask("eye.Init"))["report"] == "OK", got)


def apart(work, *options):
    level = Level(work, "--processes", "--kill-after", "2s", *options)
    level.ask("eye.Init")
    check("each module is a process", {"eye", "wheel", "bip-modules"} <= set(level.processes()), level.processes())
    check("a rule asks its process what its poster holds", (got := level.ask("wheel.Peek"))["report"] == "OK", got)
    check("inputs come to the module", level.ask("eye.Count", "3 1")["report"] == "OK" and "eye counts 1 3 1" in level.events(), level.events())
    check("what is asked is judged there", (got := level.ask("eye.Count", "bad"))["report"] == "CONTROL_CODEL_ERROR" or got["report"] == "EMPTY", got)
    check("and changes nothing", level.ask("eye.Count")["report"] == "OK" and "eye counts 2 " in level.events(), level.events())
    check("and hears of what is new", (got := level.ask("wheel.Peek"))["report"] == "SEEN-ENOUGH", got)
    check("its poster is shown", (got := level.client.ask("poster", poster="eye.Seen"))["value"] == {"seen": 2}, got)
    check("unknown ones are not", not (got := level.client.ask("poster", poster="eye.Sun"))["ok"], got)
    check("what takes its time beside the task is not ended", (got := level.ask("eye.Slow"))["report"] == "OK", got)
    drive = level.begin("wheel.Drive")
    level.reply(drive, "intermediate")
    for fault, what in (("Exit", "ended by exit(0)"), ("Die", "ended by SIGABRT"), ("Hang", "did not answer for 2000 ms and was ended"), ("Address", "ended by SIGSEGV")):
        watch = level.begin("eye.Watch")
        level.reply(watch, "intermediate")
        before = level.processes()
        got = level.ask(f"eye.{fault}")
        codel = "eye" + fault
        check(f"{fault} fails", got["report"] == "ACTIVITY_FAILED" and got.get("exception", {}).get("codel") == codel and what in got["exception"]["what"], got)
        check("the log says which codel of whom, and how", f"warning[R0050]: codel `{codel}` of eye.{fault}: the process of module eye {what}" in level.log(), level.log())
        check("another activity of its module fails as well", (got := level.reply(watch))["report"] == "ACTIVITY_FAILED" and "started again" in got["exception"]["what"], got)
        check("the robot is stopped", level.stopped(codel, what), level.events())
        check("the other module has not noticed it", level.processes().get("wheel") == before["wheel"] and level.ask("wheel.Count")["report"] == "OK", level.processes())
        check("it drives until the rule stops it", fault == "Address" or (drive, "final") not in level.replies, level.replies)
        revive(level)
        check("there is another process with fresh data", level.processes().get("eye") != before["eye"] and level.ask("eye.Count")["report"] == "OK" and level.events()[-1].startswith("eye counts 1 "), level.events())
    check("the rule has seen that it failed", level.reply(drive)["report"] == "ACTIVITY_INTERRUPTED", level.replies)
    before = level.processes()
    stops = len(level.events())
    os.kill(before["wheel"], signal.SIGKILL)
    # Nothing calls it now: no activity runs there.
    until(lambda: "the process of module wheel ended by SIGKILL" in level.log() and level.processes().get("wheel") not in (None, before["wheel"]))
    check("a death is noticed without a call", level.log().count("warning[R0050]: the process of module wheel ended by SIGKILL") == 1 and level.processes().get("wheel") not in (None, before["wheel"]), level.log())
    check("and the robot is stopped", level.stopped("stop: the process of module wheel", since=stops), level.events())
    check("a process that is killed is replaced", level.ask("wheel.Count")["report"] in ("OK", "ACTIVITY_FAILED") and level.ask("wheel.Abort") and level.ask("wheel.Count")["report"] == "OK", level.log())
    before = level.processes()
    os.kill(before["bip-modules"], signal.SIGKILL)
    check("so is the one that starts them, without a call", until(lambda: level.processes().get("bip-modules") not in (None, before["bip-modules"])), level.processes())
    level.ask("wheel.Count"), level.ask("wheel.Abort")
    check("so are all of them", (got := level.ask("wheel.Count"))["report"] == "OK" and {"eye", "wheel", "bip-modules"} <= set(level.processes()), (got, level.log()))
    pids = level.processes()
    level.client.ask("shutdown")
    check("the server ends well", level.server.wait(LONG) == 0, level.log())
    check("and the processes with it", until(lambda: not [name for name, pid in pids.items() if runs(pid)]), pids)


def orphans(work):
    """A controller that is killed leaves nobody behind."""
    level = Level(work, "--processes")
    level.ask("eye.Init")
    pids = level.processes()
    level.server.kill()
    level.server.wait()
    check("a controller that is killed leaves no process", len(pids) == 3 and until(lambda: not [name for name, pid in pids.items() if runs(pid)]), pids)


def together(work):
    """Without processes the same faults end the server; that `exit` was called is said."""
    for fault, code in (("Address", -signal.SIGSEGV), ("Exit", 1)):
        level = Level(work / fault)
        level.ask("eye.Init")
        level.begin(f"eye.{fault}")
        check(f"{fault} ends all", (got := level.server.wait(LONG)) == code, got)


def main():
    with tempfile.TemporaryDirectory(prefix="processes-") as name:
        work = pathlib.Path(name)
        apart(work / "apart")
        apart(work / "threads", "--task-threads")
        orphans(work / "orphans")
        (work / "together").mkdir()
        together(work / "together")
    return finish("processes")


if __name__ == "__main__":
    raise SystemExit(main())
