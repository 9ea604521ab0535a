#!/usr/bin/env python3
"""Programs of `bipc build --serve`: there at once, and the same as `bipc serve`.

A robot module with codels in C++, served by `bipc serve` and by a built program: the same answers to the same requests, the same trace of
the same steps, the functions of its C++ found by their names (safe_stop, inputs, posters), the first answer after less than a second of a
processor; a socket that another program listens at is refused; and a program of a module in a process of its own outlives a codel that crashes.
"""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from checks import BIPC, LONG, Client, check, finish, processes_below, runs, until

MODULE = """module arm { number: 7; internal_data: DATA; };
request Lift { type: exec; exec_task: Motion; codel_main: armLift; codel_inter: armBrake; };
request Weigh { type: exec; exec_task: Motion; codel_main: armWeigh; };
request Fall { type: exec; exec_task: Motion; codel_main: armFall; };
request Stop { type: control; interrupt_activity: Lift; };
poster State { update: auto; data: s::state; exec_task: Motion; };
exec_task Motion { period: 2; codel_task_main: armPermanent; };
"""
CODELS = """#include "level_codels.hpp"
#include <cstdio>
#include <cstdlib>
#include <string>
static std::string input;
void request_asked(const char*, const char*) {}
void request_input(const char*, const char* text) { input = text; }
int armPermanent() { return 0; }
int armLift(int&) { return 2; }
int armWeigh(int& report) { report = 0; return input == "heavy" ? throw 3 : 0; }
int armFall(int&) { std::abort(); }
int armBrake(int&) { return 0; }
extern "C" const char* bip_poster_value(const char* poster) {
  return std::string(poster) == "arm.State" ? "{\\"weight\\":3}" : nullptr;
}
extern "C" void safe_stop(const char* why) { std::printf("STOP %s\\n", why); std::fflush(stdout); }
extern "C" void brake(const char* why) { std::printf("BRAKE %s\\n", why); std::fflush(stdout); }
"""
STEPS = 400


def cpu_seconds(pid):
    """Of the process and its children that have ended."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


class Served:
    def __init__(self, command, work, name, *options):
        self.work, self.path = work, str(work / name)
        self.log = open(work / (name + ".log"), "w+", encoding="utf-8")
        self.process = subprocess.Popen([*command, "--socket", self.path, "--asap", "--policy", "fair", "--seed", "3", *options], cwd=work, stdout=self.log, stderr=self.log)
        # `bipc serve` compiles the codels first.
        while "listening" not in (told := (work / (name + ".log")).read_text(encoding="utf-8")):
            assert self.process.poll() is None, told
            time.sleep(0.02)
        self.client = Client(self.path, timeout=LONG)

    def end(self):
        self.client.ask("shutdown")
        code = self.process.wait(timeout=LONG)
        self.log.seek(0)
        return code, self.log.read()


def final(client, service, text=""):
    """The report of the final reply."""
    number = client.ask("request", service=service, input=text).get("request")
    while True:
        note = client.note(timeout=LONG)
        if note.get("note") == "request" and note.get("request") == number and note["reply"] == "final":
            return note["report"]


def same_steps(commands, work):
    traces = []
    for k, command in enumerate(commands):
        trace = work / f"steps{k}.json"
        served = Served(command, work, f"t{k}", "--paused", "--trace", str(trace))
        served.client.ask("step", count=STEPS)
        check("all steps are taken", until(lambda: served.client.ask("state", atoms=[])["steps"] == STEPS))
        code, _ = served.end()
        check("a served model ends with 0", code == 0, code)
        traces.append(trace.read_text(encoding="utf-8"))
    check("steps are written", traces[0].count('"step"') >= STEPS or traces[0].count("\n") > STEPS, len(traces[0]))
    check("built and served models take the same steps", traces[0] == traces[1])
    # Of an idle level: time, and every other tick the cycle of the permanent codel, which is two.
    ticks = traces[0].count("ROOT.InterModuleSync")
    check("a tick of an idle level is two steps", 1.8 < STEPS / ticks < 2.2, (STEPS, ticks))


def same_answers(commands, work):
    answers = []
    for k, command in enumerate(commands):
        served = Served(command, work, f"a{k}")
        c = served.client
        heard = [c.ask("hello"), final(c, "arm.Weigh"), c.ask("request", service="arm.Fly")["error"]]
        number = c.ask("request", service="arm.Lift")["request"]
        while c.note(timeout=LONG).get("reply") != "intermediate":
            pass
        heard += [final(c, "arm.Stop"), c.note(timeout=LONG).get("report"), number]
        heard += [c.ask("poster", poster="arm.State").get("value"), c.ask("poster", poster="arm.Wings").get("ok")]
        heard += [row["calls"] > 0 for row in c.ask("codels").get("codels", [])[:1]]
        # The exception of a codel leaves a zombie, so it comes last.
        heard.append(final(c, "arm.Weigh", "heavy"))
        heard[0].pop("id", None)
        code, log = served.end()
        answers.append((heard, code, "STOP the model is not served any more" in log))
    check("built and served models answer alike", answers[0] == answers[1], answers)
    check("both call safe_stop at their end", answers[1][1:] == (0, True), answers[1])
    check("a codel's exception ends its activity", answers[1][0][-1] == "ACTIVITY_FAILED", answers[1][0])


def starts_at_once(program, work):
    served = Served([program], work, "q")
    served.client.ask("hello")
    used = cpu_seconds(served.process.pid)
    check("the first answer after less than a second of a processor", used < 1, used)
    other = subprocess.run([program, "--socket", served.path], capture_output=True, text=True)
    check("a socket at which a program listens is refused", other.returncode == 2 and served.path in other.stderr, other.stderr)
    served.process.send_signal(signal.SIGTERM)
    check("SIGTERM ends it with 0", served.process.wait(timeout=LONG) == 0, served.process.returncode)


def other_safe_stop(program, work):
    served = Served([program], work, "b", "--safe-stop", "brake")
    code, log = served.end()
    check("--safe-stop finds a function of the program", code == 0 and "BRAKE" in log and "STOP" not in log, log)
    missing = subprocess.run([program, "--safe-stop", "wings"], input="", capture_output=True, text=True)
    check("a safe-stop function that there is not is refused", missing.returncode == 2 and "wings" in missing.stderr, missing.stderr)


def apart(work):
    """`genom --processes`: the program starts the module's process itself."""
    folder = work / "apart"
    folder.mkdir()
    served = Served([build(folder, "--processes")], folder, "p")
    check("the codels of a built program answer", (got := final(served.client, "arm.Weigh")) == "OK", got)
    begun = processes_below(served.process.pid)
    check("its module is a process", {"arm", "bip-modules"} <= set(begun), begun)
    check("its poster is shown", (got := served.client.ask("poster", poster="arm.State").get("value")) == {"weight": 3}, got)
    check("a codel that crashes ends its activity", (got := final(served.client, "arm.Fall")) == "ACTIVITY_FAILED", got)
    while final(served.client, "arm.Abort") != "UNKNOWN_ACTIVITY":
        pass
    check("another process goes on", (got := final(served.client, "arm.Weigh")) == "OK", got)
    now = processes_below(served.process.pid)
    check("of the same program", now.get("arm") not in (None, begun.get("arm")) and now.get("bip-modules") == begun.get("bip-modules"), (begun, now))
    code, log = served.end()
    check("the program ends with 0", code == 0, code)
    check("safe_stop is called when the process has died", "STOP `armFall` of arm.Fall: the process of module arm ended by SIGABRT" in log, log)
    check("the processes end with the program", until(lambda: not [name for name, pid in now.items() if runs(pid)]), now)


def build(folder, *options):
    """The program of the module."""
    (folder / "arm.gen").write_text(MODULE, encoding="utf-8")
    (folder / "level_codels.cpp").write_text(CODELS, encoding="utf-8")
    for command in (["genom", "--served", "--skeleton", *options, "arm.gen", "-o", "level.bip"], ["build", "--serve", "-O0", "level.bip", "-o", "level"]):
        done = subprocess.run([BIPC, *command], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    return str(folder / "level")


def main():
    with tempfile.TemporaryDirectory(prefix="built-") as folder:
        work = pathlib.Path(folder)
        program = build(work)
        commands = ([BIPC, "serve", "level.bip"], [program])
        same_steps(commands, work)
        same_answers(commands, work)
        starts_at_once(program, work)
        other_safe_stop(program, work)
        apart(work)
    return finish("built")


if __name__ == "__main__":
    sys.exit(main())
