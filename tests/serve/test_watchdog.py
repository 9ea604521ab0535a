#!/usr/bin/env python3
"""A codel that hangs (compiler/docs/serve.md, "When the engine stalls"): the watchdog stops the robot and says why.

A wheel whose world is a thread of its own: it rolls on by the wall clock as it was last told, whatever the controller does, and writes down
where it is. What is judged is that record, by nothing that the controller shares. Once with the watchdog, once without, so that the
test shows what it is for; and codels that take so long that steps begin late. Then what else ends or holds up the engine: signals, errors of the model,
a pause, the end of the process. How long the machine takes to wake a thread is measured beside the watchdog: a thread that sleeps for the watchdog's bound
while the codel hangs writes down when it has woken up.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

from checks import BIPC, LONG, Client, check, finish, until

STALL = 0.2
BOUND = STALL * 9 / 8  # the watchdog looks each eighth of it
AFTER_SLEEPER = 1.0  # s that the watchdog may be later than a thread that sleeps for its bound
HANGS = 4.0
MODULE = """module wheel { number: 1; internal_data: DATA; };
request Drive { type: exec; exec_task: Motion; codel_main: wheelDrive; codel_inter: wheelBrake; };
request Hang { type: exec; exec_task: Motion; codel_main: wheelHang; };
request Dawdle { type: exec; exec_task: Motion; codel_main: wheelDawdle; };
request Address { type: exec; exec_task: Motion; codel_main: wheelAddress; };
request Divide { type: exec; exec_task: Motion; codel_main: wheelDivide; };
request Deep { type: exec; exec_task: Motion; codel_main: wheelDeep; };
request Terminate { type: exec; exec_task: Motion; codel_main: wheelTerminate; };
request Exit { type: exec; exec_task: Motion; codel_main: wheelExit; };
exec_task Motion { period: 2; };
"""
CODELS = """#include "wheel_codels.hpp"
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
namespace {
int zero() { static volatile int none = 0; return none; }
int deep(volatile int* k) { volatile int more[4096]; more[0] = *k + 1; return more[0] < 0 ? 0 : deep(more) + more[0]; }
std::atomic<double> speed{0};
std::atomic<bool> is_stopped{false};
double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }
void note(const char* what) {
  std::FILE* file = std::fopen("events", "a");
  std::fprintf(file, "%.6f %s\\n", now(), what);
  std::fclose(file);
}
// The world.
void roll() {
  std::FILE* file = std::fopen("record", "w");
  double x = 0;
  for (double before = now();; std::this_thread::sleep_for(std::chrono::milliseconds(5))) {
    const double at = now(), v = is_stopped ? 0.0 : speed.load();
    x += v * (at - before);
    before = at;
    std::fprintf(file, "%.6f %.6f %.3f\\n", at, x, v);
    std::fflush(file);
  }
}
const bool rolls = (std::thread(roll).detach(), true);
}  // namespace
void request_asked(const char*, const char*) {}
void request_input(const char*, const char*) {}
extern "C" void safe_stop(const char* why) { is_stopped = true; note(why); }
extern "C" void brake_hard(const char* why) { is_stopped = true; note("brake_hard"); (void)why; }
extern "C" void brake_forever(const char*) { note("brake_forever"); for (;;) std::this_thread::sleep_for(std::chrono::seconds(1)); }
extern "C" void brake_badly(const char*) { note("brake_badly"); *reinterpret_cast<volatile int*>(static_cast<long>(zero())) = 1; }
int wheelAddress(int&) { *reinterpret_cast<volatile int*>(static_cast<long>(zero())) = 1; return 0; }
int wheelDivide(int&) { return 1000 / zero(); }
int wheelDeep(int&) { volatile int k = 0; return deep(&k) & 1; }
int wheelTerminate(int&) { std::thread([] { throw 1; }).join(); return 0; }
int wheelExit(int&) { std::exit(3); }
int wheelDrive(int&) { speed = 1; return 2; }
int wheelBrake(int&) { speed = 0; return 0; }
int wheelHang(int&) {
  note("hangs");
  std::thread([] { std::this_thread::sleep_for(std::chrono::milliseconds(225)); note("sleeper"); }).detach();
  std::this_thread::sleep_for(std::chrono::milliseconds(4000));
  note("returns");
  return 0;
}
int wheelDawdle(int&) { std::this_thread::sleep_for(std::chrono::milliseconds(60)); return 0; }
"""


class Served:
    def __init__(self, folder, *options):
        self.folder = folder
        folder.mkdir()
        self.log = open(folder / "log", "w+", encoding="utf-8")
        self.server = subprocess.Popen([BIPC, "serve", "--asap", "--policy", "fair", "--socket", "s", *options, "../wheel.bip"], cwd=folder, stdout=self.log, stderr=self.log)
        # It says so when it listens; the file is there before.
        until(lambda: "listening" in (folder / "log").read_text(encoding="utf-8") or self.server.poll() is not None)
        here = os.getcwd()
        os.chdir(folder)  # the path of a socket is short
        self.client = Client("s", LONG)
        os.chdir(here)
        self.heard = []  # kinds of notes
        self.client.ask("subscribe", requests=True)

    def ask(self, service):
        answer = self.client.ask("request", service=service)
        assert answer["ok"], answer
        return answer["request"]

    def wait(self, note, seconds=LONG, **values):
        """The next note with these values; None if it does not come."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                told = self.client.note(timeout=max(0.01, end - time.monotonic()))
            except TimeoutError:
                return None
            self.heard.append(told["note"])
            if told["note"] == note and all(told[k] == v for k, v in values.items()):
                return told
        return None

    def end(self):
        self.client.ask("shutdown")
        return self.ended()

    def ended(self):
        code = self.server.wait(LONG)
        self.log.seek(0)
        events = [line.split(" ", 1) for line in (self.folder / "events").read_text(encoding="utf-8").splitlines()] if (self.folder / "events").exists() else []
        record = [tuple(map(float, line.split())) for line in (self.folder / "record").read_text(encoding="utf-8").splitlines() if line.count(" ") == 2]
        return code, self.log.read(), [(float(t), what) for t, what in events], record


def seconds_of(record):
    return record[-1][0] - record[0][0]


def rolled_after(record, at):
    """How long the wheel moved after an instant, and how far it got while the codel hung."""
    moving = [t for t, _, v in record if v > 0 and at < t < at + HANGS]
    places = [x for t, x, _ in record if at < t < at + HANGS]
    return (max(moving) - at if moving else 0.0), (places[-1] - places[0] if places else 0.0)


def main():
    with tempfile.TemporaryDirectory(prefix="watchdog-") as name:
        work = pathlib.Path(name)
        (work / "wheel.gen").write_text(MODULE, encoding="utf-8")
        subprocess.run([BIPC, "genom", "--served", "--skeleton", "wheel.gen", "-o", "wheel.bip"], cwd=work, check=True, capture_output=True)
        check("the header declares it", 'extern "C" void safe_stop(const char* why);' in (work / "wheel_codels.hpp").read_text(encoding="utf-8"))
        (work / "wheel_codels.cpp").write_text(CODELS, encoding="utf-8")
        watched = Served(work / "watched", "--stall-after", f"{int(STALL * 1000)}ms", "--late-after", "20ms")
        free = Served(work / "free", "--stall-after", "0")
        for served in (watched, free):
            served.ask("wheel.Drive")
            check("it drives", served.wait("request", reply="intermediate"))
            served.ask("wheel.Hang")
        told = watched.wait("stalled")
        check("the watchdog tells its clients while the codel hangs", told and "wheelHang" in told["text"] and STALL * 1e9 <= told["ns"] < HANGS * 1e9, told)
        check("and that it is over", watched.wait("runs again"))
        check("and which steps are late", "late" in watched.heard or watched.wait("late"), watched.heard)
        free.wait("request", service="wheel.Hang", reply="final")
        code, log, events, record = watched.end()
        times = dict((what.split()[0], at) for at, what in events)
        hangs, sleeper, returns = (times.get(what, 0) for what in ("hangs", "sleeper", "returns"))
        seconds, metres = rolled_after(record, hangs)
        check(f"the wheel stands {AFTER_SLEEPER} s after a thread that slept for {BOUND:.3f} s", hangs and sleeper and seconds < sleeper - hangs + AFTER_SLEEPER, (seconds, metres, events))
        # Others can be of a machine that let the engine wait.
        whys = [(at, what) for at, what in events if what.startswith("no step") and "wheelHang(int, int" in what]
        check("the safe-stop function hears why", len(whys) == 1 and "has returned" in whys[0][1], events)
        check("while it hangs, not after", hangs and all(hangs < at < returns for at, _ in whys), events)
        check("the log says why", "warning[R0046]: no step has returned for" in log and "wheelHang" in log and "`safe_stop` was called" in log, log)
        check("and when it goes on", "the engine runs again" in log, log)
        late = [line for line in log.splitlines() if "R0047" in line]
        check("late steps are in the log, by what they do", late and all(re.match(r"warning\[R0047\]: step \d+, `.+`, begins \d+ ms too late", line) for line in late), log)
        check("at most one a second", len(late) <= seconds_of(record) + 2, late)
        check("it ends well", code == 0, code)
        code, log, events, record = free.end()
        seconds, metres = rolled_after(record, dict((what.split()[0], at) for at, what in events)["hangs"])
        check("without a watchdog it rolls on for as long as the codel hangs", seconds > 3 and metres > 2.5, (seconds, metres))
        check("and nobody says so while it hangs", "R0046" not in log and "late" not in free.heard, log)
        late = [line for line in log.splitlines() if "R0047" in line]
        check("but the log has it afterwards, though nobody asked for it", 0 < len(late) <= seconds_of(record) + 2 and max(int(re.search(r"begins (\d+) ms", line)[1]) for line in late) > 3000, log)
        others(work)
        signals(work)
        silent(work)
        ends(work)
    return finish("watchdog")


def others(work):
    """A function by another name, a longer bound, one that is not there; what only dawdles is no stall."""
    named = Served(work / "named", "--stall-after", "2s", "--late-after", "0", "--safe-stop", "brake_hard")
    named.ask("wheel.Dawdle")
    check("what dawdles ends", named.wait("request", service="wheel.Dawdle", reply="final"))
    named.ask("wheel.Hang")
    check("the other function", named.wait("stalled"))
    named.wait("runs again")
    _, log, events, _ = named.end()
    check("is called", [what for _, what in events].count("brake_hard") == 2 and log.count("R0049") == 1 and log.count("R0046") == 2, (events, log))
    check("of late steps the log has nothing if that was said", "R0047" not in log, log)
    refused = subprocess.run([BIPC, "serve", "--safe-stop", "fly", "wheel.bip"], cwd=work, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    check("a function that is not there", refused.returncode == 2 and 'has no function `extern "C" void fly(const char* why)`' in refused.stderr, refused)
    refused = subprocess.run([BIPC, "serve", "--stall-after", "soon", "wheel.bip"], cwd=work, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    check("a bound that is none", refused.returncode == 2 and "is no duration" in refused.stderr, refused)


def signals(work):
    """A codel that a signal ends, on a full stack, in a thread of its own: the robot is stopped before the process ends."""
    for service, expected, name, where in (("Address", -11, "signal SIGSEGV", "wheelAddress"), ("Divide", -8, "signal SIGFPE", "wheelDivide"), ("Deep", -11, "signal SIGSEGV", "wheelDeep"),
                                           ("Terminate", 70, "an exception ends the process", ""), ("Exit", 1, "the model's C++ ends the process", "")):
        served = Served(work / service, "--stall-after", "0")
        served.ask("wheel.Drive")
        check("it drives", served.wait("request", reply="intermediate"))
        served.ask("wheel." + service)
        code, log, events, record = served.ended()
        check(f"{service}: the process ends", code == expected, (code, log))
        check(f"{service}: the safe-stop function hears why, once", len(events) == 1 and events[0][1].startswith(name) and where in events[0][1], events)
        check(f"{service}: the wheel stands before that", record and events and not [row for row in record if row[0] > events[0][0] and row[2] != 0], (events, record[-3:]))
        check(f"{service}: the log says so", f"error: {name}" in log or not where, log)
    for function in ("brake_forever", "brake_badly"):
        served = Served(work / function, "--stall-after", "0", "--safe-stop", function)
        served.ask("wheel.Address")
        code, log, events, _ = served.ended()
        check(f"{function} does not keep the process", code == -11 and [what for _, what in events] == [function], (code, events, log))


FAULTY = """@cpp(include="stop.hpp", src="stop.cpp")
package faulty
  extern function int fine(const int)
  port type Signal()
  connector type One(Signal p)
    define p
  end
  atom type A()
    clock c unit millisecond
    data int n = 3
    data int sixth = 0
    export port Signal p()
    place S
    initial to S
    on p from S to S provided c == 20 do { n = n - fine(1); sixth = 6 / n; c = 0; }
  end
  compound type Root()
    component A a()
    connector One p(a.p)
  end
end
"""


SILENT = 3  # s; a loaded machine lets a client that speaks wait, but not for so long


def silent(work):
    """The decisional level falls silent: the robot stops if that was said, and goes on else. Who only looks is not the decisional level."""
    for name, options in (("dead-man", ["--silent-after", f"{SILENT}s"]), ("goes on", [])):
        served = Served(work / name.replace(" ", "_"), *options)
        served.ask("wheel.Drive")
        check("it drives", served.wait("request", reply="intermediate"))
        end = time.monotonic() + 1.5 * SILENT
        while time.monotonic() < end:
            time.sleep(0.25)
            served.client.ask("requests")
        with_events = (served.folder / "events").exists()
        check(f"{name}: who speaks is heard", not with_events)
        here = os.getcwd()
        os.chdir(served.folder)
        observer = Client("s", LONG)
        os.chdir(here)
        role = observer.ask("hello", role="observer")["role"]
        check("a client may take a smaller role", role == "observer", role)
        for request in ({"do": "request", "service": "wheel.Hang"}, {"do": "shutdown"}, {"do": "pause"}, {"do": "hello", "role": "operator"}):
            answer = observer.ask(request.pop("do"), **request)
            check("and has no more rights then", not answer["ok"] and "observer" in answer["error"], answer)
        told, end = None, time.monotonic() + (LONG if options else 1.5 * SILENT)
        while not told and time.monotonic() < end:
            observer.ask("state", atoms=[])
            told = served.wait("stopped", 0.2)
        moves = not [1 for _, what in events_of(served.folder) if f"silent for {SILENT}000 ms" in what]
        check(f"{name}: the robot {'goes on' if not options else 'stops'}", moves == (not options) and (told is not None) == bool(options), told)
        served.ask("wheel.Drive")
        served.end()


def events_of(folder):
    return [line.split(" ", 1) for line in (folder / "events").read_text(encoding="utf-8").splitlines()] if (folder / "events").exists() else []


def ends(work):
    """The engine stands still for another reason: so does the robot."""
    served = Served(work / "paused", "--stall-after", "0")
    served.client.ask("pause")
    check("a pause stops the robot", served.wait("stopped"))
    served.client.ask("pause")
    refused = subprocess.run([BIPC, "serve", "--silent-after", "1s", str(pathlib.Path(__file__).parent / "counter.bip")], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    check("who has nothing to stop needs no dead-man rule", refused.returncode == 2 and "`--silent-after` stops the robot" in refused.stderr, refused)
    code, log, events, _ = served.end()
    check("once, and the end of the process does", [what for _, what in events] == ["the model is paused", "the model is not served any more"], events)
    check("the log says both", log.count("warning[R0049]: ") == 2 and "the model is paused: `safe_stop` was called" in log and code == 0, log)
    folder = work / "faulty"
    folder.mkdir()
    (folder / "faulty.bip").write_text(FAULTY, encoding="utf-8")
    (folder / "stop.hpp").write_text("int fine(int n);\n", encoding="utf-8")
    (folder / "stop.cpp").write_text('#include <cstdio>\nint fine(int n) { return n; }\nextern "C" void safe_stop(const char* why) { std::FILE* f = std::fopen("events", "a"); std::fprintf(f, "%s\\n", why); std::fclose(f); }\n', encoding="utf-8")
    server = subprocess.Popen([BIPC, "serve", "--asap", "--paused", "faulty.bip"], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    server.stdin.write('{"do":"subscribe","interactions":["none"]}\n{"do":"resume"}\n')
    server.stdin.flush()
    told = [server.stdout.readline() for _ in range(4)]
    server.stdin.close()
    log = server.stderr.read()
    code = server.wait(LONG)
    events = (folder / "events").read_text(encoding="utf-8").splitlines() if (folder / "events").exists() else []
    check("an error of the model stops the robot", "the run has ended by an error" in events and any('"note":"stopped"' in line for line in told), (events, told, log, code))


if __name__ == "__main__":
    sys.exit(main())
