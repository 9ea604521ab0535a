#!/usr/bin/env python3
"""What Dala's controller prevents, as a table: facts about a rover, with the rules and the watchdog and without them, fault by fault.

    tests/genom/test_dala_faults.py [--table]

The rover is a process of its own (models/dala/mission/rover.cpp): it moves by the wall clock as it was last told, whatever becomes of the controller, and writes down what
is so. Facts are judged by that record alone (`facts`), with no code of the controller's. Each of two levels, fourteen modules under `bipc serve`, goes through all faults, a
third one, with modules in processes of their own (--processes), through the last but one, and a fourth one, whose codels run in threads as well (--task-threads), through the
last one and a codel that hangs: there the rover drives on. Each fact has to hold with the rules and the watchdog, and to be broken without them, else the test shows nothing. --table prints it only.
Python's library, and g++ for the rover. The last line is "faults: N passed, N failed".
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests"))
sys.path.insert(0, str(ROOT / "tools/python/bipc"))
from patience import LONG  # noqa: E402
from serve import Client  # noqa: E402

DALA = ROOT / "models/dala"
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
# A row of the rover's record.
NOW, X, Y, V, DRIVEN, EXPOSES, SENDS, AGE, TILT, EXPOSES_PAIR, LASER_AGE, VISION_AGE, MAP_AGE = range(13)
MOVES = 0.02  # m/s
# What NDD's period, rules.fresh_speed and the wheels' own task allow a reference to be.
OLD = 0.4
BEGINNINGS = ("POM.Init", "RFLEX.Init", "LaserRF.Init", "Aspect.Init", "NDD.Init", "VIAM.Init", "Hueblob.Init", "Antenna.Init", "NDD.SetParams", "NDD.SetSpeed 0.5",
              "LaserRF.StartAcquisition", "Aspect.BuildMap")
# fact: unit, at most with rules and watchdog, at least without
FACTS = {"a sharp picture is asked for while it drives": ("s blurred", 0.0, 1.0),
         "it is told to drive while a sharp picture is taken": ("s blurred", 0.0, 1.0),
         "it is told to send while it drives": ("s sent in motion", 0.0, 0.5),
         "the decisional level falls silent": ("m after 1.5 s", 0.6, 1.0),
         "a codel hangs for 4 s": ("m after 0.5 s", 0.6, 1.0),
         "NDD fails: its speed gets old": ("m on an old speed", 0.6, 1.0),
         "a codel writes to a bad address": ("m after the crash", 0.6, 1.0),
         "the same, modules in processes of their own": ("m after the crash", 0.6, 1.0),
         "the same, their codels in threads": ("m after the crash", 0.6, 1.0)}
# Of the levels whose modules are processes: all others go through the rest.
CRASH, APART, THREADS = list(FACTS)[-3:]
DRIVES_ON = 1.2  # metres in the four seconds in which a codel in a thread hangs


def facts(rows, begin, end):
    """Of a piece of the record: seconds of blur, seconds of sending in motion, metres, metres on an old speed."""
    blurred = sent = old = 0.0
    part = [r for r in rows if begin <= r[NOW] <= end]
    for before, row in zip(part, part[1:]):
        seconds, moves = row[NOW] - before[NOW], abs(row[V]) > MOVES
        blurred += seconds if moves and row[EXPOSES] else 0
        sent += seconds if moves and row[SENDS] else 0
        old += row[DRIVEN] - before[DRIVEN] if row[AGE] > OLD else 0
    return blurred, sent, part[-1][DRIVEN] - part[0][DRIVEN] if part else 0.0, old


class Level:
    """The fourteen modules, served, and a rover; `is_kept`: under dala.rules and a watchdog, else with neither. `generation`: more options of `bipc rules`."""

    RULES = ("dala.rules",)
    ROVER = ("6", "0")  # where it begins
    KEPT = ("--stall-after", "300ms", "--silent-after", "1s")
    PACE = ()  # of the clock of `bipc serve`

    def __init__(self, work, is_kept, *generation):
        self.work, self.is_kept = work, is_kept
        work.mkdir()
        for name in ("world.hpp", "camera.hpp", "terrain.hpp", "vision.hpp", "bus.hpp", "dala_codels.cpp", "rover.cpp"):
            shutil.copy(DALA / "mission" / name, work / name)
        rules = re.sub(r"//[^\n]*", "", "".join((DALA / name).read_text(encoding="utf-8") for name in self.RULES))
        rules = re.sub(r'rules \w+;\s*extends "[^"]*";', "", rules)
        rules = re.sub(r'"(\w+\.gen)"', lambda m: f'"{DALA / m.group(1)}"', rules).replace(' with "dala.yields"', "")
        if not is_kept:
            rules = ";".join(s for s in rules.split(";") if s.split()[:1] and s.split()[0] in ("rules", "modules", "parameter")) + ";\n"
            # What is called then stops nothing.
            with (work / "dala_codels.cpp").open("a", encoding="utf-8") as codels:
                codels.write('extern "C" void roll_on(const char*) {}\n')
        (work / "dala.rules").write_text(rules, encoding="utf-8")
        (work / "m.yields").write_text("".join((DALA / name).read_text(encoding="utf-8") for name in ("dala.yields", "mission/async.yields")), encoding="utf-8")
        self.run("g++", "-std=c++20", "-O1", "rover.cpp", "-o", "rover")
        self.run(BIPC, "rules", "dala.rules", "--yields", "m.yields", "--served", "--skeleton", "--control-period", "2", *generation, "-o", "dala.bip")
        self.rover = subprocess.Popen(["./rover", "bus", "record", *self.ROVER], cwd=work, stdin=subprocess.PIPE)
        while not (work / "record").exists():
            time.sleep(0.01)
        options = [*(self.KEPT if is_kept else ("--stall-after", "0", "--safe-stop", "roll_on")), *self.PACE]
        with open(work / "log", "w", encoding="utf-8") as log:
            self.level = subprocess.Popen([BIPC, "serve", "dala.bip", "--asap", "--policy", "fair", "--socket", "s", *options], cwd=work, stdout=log, stderr=log,
                                          env={**os.environ, "DALA_ROVER": str(work / "bus")})
        while "listening" not in self.log():
            if self.level.poll() is not None:
                raise AssertionError(self.log())
            time.sleep(0.05)
        self.socket = pathlib.Path(tempfile.mkdtemp(prefix="dala-")) / "s"  # the path of a socket is short
        self.socket.symlink_to(work / "s")
        self.client = Client(str(self.socket), LONG)
        self.client.ask("subscribe", requests=True)
        self.replies = {}

    def run(self, *command):
        done = subprocess.run(command, cwd=self.work, capture_output=True, text=True)
        if done.returncode:
            raise AssertionError(f"{command}: {done.stdout[-500:]}{done.stderr[-1500:]}")

    def log(self):
        return (self.work / "log").read_text(encoding="utf-8")

    def rows(self):
        return [tuple(map(float, line.split())) for line in (self.work / "record").read_text(encoding="utf-8").splitlines() if line.count(" ") == 12]

    def now(self):
        return self.rows()[-1][NOW]

    # ---- the decisional level
    def ask(self, text):
        service, _, given = text.partition(" ")
        answer = self.client.ask("request", service=service, input=given)
        if not answer["ok"]:
            raise AssertionError(f"{text}: {answer}")
        return answer["request"]

    def listen(self, seconds, until=lambda: False):
        """Goes on speaking meanwhile. Returns whether it has happened."""
        end = time.monotonic() + seconds
        while not until():
            if time.monotonic() > end:
                return False
            self.client.ask("requests")
            try:
                note = self.client.note(timeout=0.1)
            except TimeoutError:
                continue
            if note["note"] == "request":
                self.replies.setdefault(note["request"], []).append(note)
        return True

    def do(self, text, seconds=LONG):
        """Until it is accepted, or refused; a control service until its end."""
        number = self.ask(text)
        if not self.listen(seconds, lambda: number in self.replies):
            raise AssertionError(f"no answer to {text}: {self.log()[-500:]}")
        return number

    def ended(self, number, seconds=LONG):
        return self.listen(seconds, lambda: any(r["reply"] == "final" for r in self.replies.get(number, [])))

    def drive(self, text="RFLEX.TrackSpeedStart"):
        for _ in range(5):  # a machine that is busy makes a reference old, and the rule speaks
            self.do(text)
            if self.listen(LONG / 6, lambda: self.rows()[-1][V] > 0.3):
                return
        raise AssertionError(f"it does not drive: {self.log()[-500:]}")

    def stand(self):
        self.do("RFLEX.TrackSpeedStop")
        if not self.listen(LONG, lambda: abs(self.rows()[-1][V]) < MOVES):
            raise AssertionError("it does not stand")

    # ---- the faults, in this order; each a fact and its number
    def begin(self):
        for text in BEGINNINGS:
            number = self.do(text)
            if text[:5] != "Aspec" and "StartAcq" not in text and not self.ended(number):
                raise AssertionError(f"{text} does not end")

    def go(self):
        self.begin()
        for _ in range(4):  # pictures to send later
            self.ended(self.do("VIAM.Acquire(Panoramic)"))
        self.do("NDD.GoTo 500 0")
        names, found = iter(FACTS), {}

        self.drive()
        begin = self.now()
        self.ended(self.do("VIAM.Acquire(Marlin)"))
        found[next(names)] = facts(self.rows(), begin, self.now())[0]
        self.stand()

        begin = self.now()
        self.do("VIAM.Acquire(Marlin)")
        self.ask("RFLEX.TrackSpeedStart")
        self.listen(4)
        found[next(names)] = facts(self.rows(), begin, self.now())[0]
        self.stand()

        self.drive()
        begin = self.now()
        self.ended(self.do("Antenna.Communicate"))
        found[next(names)] = facts(self.rows(), begin, self.now())[1]
        self.stand()

        self.drive()
        begin = self.now()
        time.sleep(5)
        found[next(names)] = facts(self.rows(), begin + 1.5, begin + 5)[2]
        self.stand()

        self.drive()
        self.ask("Hueblob.SetHue hang")
        begin = self.now()
        self.listen(4)
        found[next(names)] = facts(self.rows(), begin + 0.5, begin + 4)[2]
        self.listen(1.5)
        self.stand()

        self.drive()
        self.ask("NDD.SetSpeed fast")
        begin = self.now()
        self.listen(6)
        found[next(names)] = facts(self.rows(), begin, self.now())[3]
        self.stand()

        self.drive(f"RFLEX.GotoPosition {self.rows()[-1][X] + 30} 0")
        self.ask("Hueblob.SetHue crash")
        if self.level.wait(LONG) != -11:
            raise AssertionError(f"it has ended otherwise: {self.log()[-500:]}")
        begin = self.now()
        time.sleep(4)
        found[next(names)] = facts(self.rows(), begin, self.now())[2]
        return found

    def go_in_threads(self):
        """A codel that hangs holds up its own task; the others, and the rover, go on. Then as go_apart."""
        self.begin()
        self.do("NDD.GoTo 500 0")
        self.drive()
        hangs = self.ask("Hueblob.SetHue hang")
        begin = self.now()
        self.listen(4)
        driven = facts(self.rows(), begin, begin + 4)[2]
        if driven < DRIVES_ON or "R0046" in self.log() or not self.ended(hangs):
            raise AssertionError(f"a codel in a thread holds up others: {driven:.2f} m, {self.log()[-1500:]}")
        self.stand()
        return {THREADS: self.crash()}

    def go_apart(self):
        """A crash ends its module, which is started again; the others go on, and so does the controller."""
        self.begin()
        self.do("NDD.GoTo 500 0")
        return {APART: self.crash()}

    def crash(self):
        """Returns what was driven after it."""
        self.drive(f"RFLEX.GotoPosition {self.rows()[-1][X] + 30} 0")
        crash = self.ask("Hueblob.SetHue crash")
        begin = self.now()
        self.listen(4)
        found = facts(self.rows(), begin, self.now())[2]
        self.expect(crash, "SIGSEGV")
        self.do("Hueblob.Abort")  # the zombie
        self.expect(self.ask("Hueblob.SetHue red"), "init")  # what it was told before is gone
        for text in ("Hueblob.Abort", "Hueblob.Init", "Hueblob.SetHue red"):
            last = self.do(text)
            self.ended(last)
        if [r["report"] for r in self.replies[last]] != ["OK", "OK"]:
            raise AssertionError(f"Hueblob does not go on: {self.replies[last]}, {self.log()[-1500:]}")
        self.drive()
        if self.level.poll() is not None or "R0049" not in self.log():
            raise AssertionError(f"the robot was not stopped: {self.log()[-1500:]}")
        return found

    def expect(self, number, word):
        """It has failed, with an exception that says so."""
        if not self.ended(number) or word not in str(self.replies[number][-1].get("exception")):
            raise AssertionError(f"{word}: {self.replies.get(number)}, {self.log()[-1500:]}")

    def end(self):
        if self.level.poll() is None:
            self.level.kill()
            self.level.wait()
        self.rover.stdin.close()
        self.rover.wait(LONG)
        shutil.rmtree(self.socket.parent)


def go_together(names, start, go):
    """{name: what go(name, level) finds} of the levels start(name), at once."""
    found, problems = {}, []

    def one(name):
        level = None
        try:
            level = start(name)
            found[name] = go(name, level)
        except Exception as problem:  # of a thread: told by who waits for it
            problems.append(f"{name}: {problem!r}")
        finally:
            if level is not None:
                level.end()

    threads = [threading.Thread(target=one, args=(name,)) for name in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if problems:
        raise AssertionError("; ".join(problems))
    return found


def measure(work):
    """{fact: (with rules and watchdog, without)}"""
    options = {"apart": ["--processes"], "threads": ["--processes", "--task-threads"]}
    ways = {"apart": Level.go_apart, "threads": Level.go_in_threads}
    work.mkdir(exist_ok=True)
    found = go_together(("kept", "free", "apart", "threads"), lambda name: Level(work / name, name != "free", *options.get(name, [])),
                        lambda name, level: ways.get(name, Level.go)(level))
    # Without rules and processes it is the same fault.
    found["free"] |= dict.fromkeys((APART, THREADS), found["free"][CRASH])
    found["kept"] |= found["apart"] | found["threads"]
    return {fact: (found["kept"][fact], found["free"][fact]) for fact in FACTS}


def print_table(table, facts_of=None, kept_by="rules and watchdog"):
    print(f"{'fault':<58} {'with':>6} {'without':>8}  ({kept_by})")
    for fact, (kept, free) in table.items():
        print(f"{fact:<58} {kept:>6.2f} {free:>8.2f}  {(facts_of or FACTS)[fact][0]}")


def judge(name, what, facts_of, kept_by, measured):
    """Prints the table that `measured` makes in a folder of its own, and whether each fact holds with the rules and is broken without."""
    arguments = argparse.ArgumentParser(description=what)
    arguments.add_argument("--table", action="store_true")
    options = arguments.parse_args()
    with tempfile.TemporaryDirectory(prefix=f"{name}-") as work:
        try:
            table = measured(pathlib.Path(work))
        except AssertionError as problem:
            print(f"{problem}\n{name}: 0 passed, 1 failed")
            return 1
    print_table(table, facts_of, kept_by)
    bad = [f"{fact}: {kept:.2f} with, {free:.2f} without, at most {facts_of[fact][1]} and at least {facts_of[fact][2]}" for fact, (kept, free) in table.items()
           if kept > facts_of[fact][1] or free < facts_of[fact][2]]
    if options.table:
        return 0
    for line in bad:
        print(line)
    print(f"{name}: {len(table) - len(bad)} passed, {len(bad)} failed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(judge("faults", __doc__.splitlines()[0], FACTS, "rules and watchdog", measure))
