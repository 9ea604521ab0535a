#!/usr/bin/env python3
"""Codels as people write them for genom3 run as they are (compiler/docs/genom.md, `--codels`).

tests/genom/track is a component with sequences, unions, natives, ports and exceptions, its codels in C and C++, and a second one whose port
it reads. They are translated, served, and asked as clients ask; every check looks at what a client is told. Python's library only.
"""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests/serve"))
from checks import BIPC, LONG, Client, check, finish, until  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent / "track"


class Level:
    def __init__(self, work):
        self.path, self.work = os.path.join(work, "s"), work
        self.server = subprocess.Popen([BIPC, "serve", "--asap", "--policy", "fair", "--socket", self.path, "m.bip"], cwd=work, stderr=open(os.path.join(work, "log"), "w", encoding="utf-8"))
        # The socket's file is there a little before the server listens.
        self.client = None
        while self.client is None:
            assert self.server.poll() is None, pathlib.Path(work, "log").read_text(encoding="utf-8")
            try:
                self.client = Client(self.path, LONG)
            except (FileNotFoundError, ConnectionRefusedError):
                time.sleep(0.02)
        self.replies = {}

    def begin(self, service, **input):
        answer = self.client.ask("request", service=service, input=input)
        assert answer["ok"], answer
        return answer["request"]

    def refused(self, service, input):
        answer = self.client.ask("request", service=service, input=input)
        return "" if answer["ok"] else answer["error"]

    def next(self, number, what):
        """The reply of this kind to a request."""
        end = time.monotonic() + LONG
        while (number, what) not in self.replies:
            if time.monotonic() > end:
                return {"report": f"no {what} reply"}
            try:
                note = self.client.note(timeout=1)
            except TimeoutError:
                continue
            if note["note"] == "request":
                self.replies[note["request"], note["reply"]] = note
        return self.replies[number, what]

    def final(self, number):
        reply = self.next(number, "final")
        return reply["report"], reply.get("output", reply.get("exception"))

    def ask(self, service, **input):
        return self.final(self.begin(service, **input))


def refusals(level):
    """An input is judged before anything of it comes to the component."""
    for service, input, part in (
            ("track.follow", {}, "`path` is missing"),
            ("track.follow", {"path": 3}, "`path` is an array"),
            ("track.follow", {"path": [{"x": 1, "y": "far"}]}, "`path[0].y` is a number"),
            ("track.follow", {"path": [{"x": 1, "z": 2}]}, "`path[0]` has no member `z`"),
            ("track.follow", {"path": [], "lap": 2}, "there is no parameter `lap`"),
            ("track.follow", {"path": [], "laps": 1.5}, "`laps` is a whole number from -2147483648"),
            ("track.weigh", {"marks": [1, 2, 3, 4, 5], "scale": None, "outline": {"_d": "CREEP", "width": 1}}, "`marks` has at most 4 elements"),
            ("track.weigh", {"marks": [], "scale": None, "outline": {"_d": "FLY"}}, "`outline._d` is one of CREEP, WALK, RUN"),
            ("track.weigh", {"marks": [], "scale": None, "outline": {"_d": "RUN", "width": 1}}, "`outline` has no member `width`"),
            ("track.set_load", {"carried": {"_d": "WALK", "marks": [1, 2, 3, 4, 5]}}, "`carried.marks` has at most 4 elements"),
            ("track.remember", {"times": 256}, "`times` is a whole number from 0 to 255"),
            ("track.remember", {"loud": 1}, "`loud` is true or false"),
            ("track.gauges", {"name": "much too long", "value": 1}, "`name` is a text of at most 8 bytes"),
            ("track.set_gains", {"gains": [1, 2]}, "`gains` is an array of 6"),
            ("track.follow", "{\"path\": [", "this is no JSON"),
            ("track.follow", [1], "an input is an object")):
        said = level.refused(service, input)
        check(f"{service} {input} is refused", part in said, said)


def values(level):
    """Attributes, initial values, types."""
    until(lambda: level.ask("track.get_drive")[1]["drive"]["limit"]["high"] == 2)  # the task has begun
    check("an attribute has its initial value", (got := level.ask("track.set_speed")) == ("OK", None), got)
    check("one that is judged", level.ask("track.set_speed", speed=99) == ("e_far", {"name": "::track::e_far", "detail": {"distance": 99, "what": "speed"}}))
    check("a struct's initial values", level.ask("track.set_limit", limit={"high": 3}) == ("OK", None))
    check("an array", level.ask("track.set_gains", gains=[1, 2, 3, 4, 5, 0.25])[0] == "OK")
    check("they are in the IDS", (got := level.ask("track.get_drive")) == ("OK", {"drive": {"speed": 0.5, "limit": {"low": 0.1, "high": 3}, "gains": [1, 2, 3, 4, 5, 0.25]}}), got)
    check("union, optional and sequence", level.ask("track.weigh", marks=[1, 2, 0.5], scale=10, outline={"_d": "WALK", "corner": {"x": 3, "y": 4}}) == ("OK", {"sum": 47, "verdict": "slow of 3"}))
    check("a bounded sequence of a union", level.ask("track.set_load", carried={"_d": "WALK", "marks": [1, 2]})[0] == "OK" and (got := level.ask("track.get_load")) == ("OK", {"carried": {"_d": "WALK", "marks": [1, 2]}}), got)
    check("another member of it", level.ask("track.set_load", carried={"_d": "RUN", "way": [{"x": 1, "y": 2}]})[0] == "OK" and (got := level.ask("track.get_load")) == ("OK", {"carried": {"_d": "RUN", "way": [{"x": 1, "y": 2}]}}), got)
    check("room in bounded sequences", (got := level.ask("track.reserve", length=3)) == ("OK", {"marks": [0, 1, 2], "packed": {"_d": "WALK", "marks": [0, 1, 2]}}), got)
    check("not more than the bound", (got := level.ask("track.reserve", length=5)) == ("e_far", {"name": "::track::e_far", "detail": {"distance": 5, "what": "marks"}}), got)
    check("an optional that is absent", level.ask("track.weigh", marks=[1], scale=None, outline={"_d": "::track::CREEP", "width": -1}, pace="RUN") == ("OK", {"sum": 0, "verdict": "fast of 1"}))
    check("codels one after the other", level.ask("track.remember", text="a\u00e9 \"b\"", times=2, loud=True)[0] == "OK" and level.ask("track.get_note") == ("OK", {"note": "A\u00e9 \"B\"A\u00e9 \"B\""}), level.ask("track.get_note"))
    check("a multiple port", level.ask("track.gauges", name="left", value=1.5)[0] == "OK" and level.ask("track.gauges", name="left", value=2)[0] == "OK")
    check("an exception without details", level.ask("track.gauges", name="", value=1) == ("e_empty", {"name": "::track::e_empty"}))
    check("a native is the codels' own", level.ask("track.count")[1]["codels"] > 0)


def activities(level):
    square = [{"x": 0.02, "y": 0}, {"x": 0.02, "y": 0.02}, {"x": 0, "y": 0}]
    report, output = level.ask("track.follow", path=square, laps=2)
    check("an activity with locals, in several cycles", report == "OK" and output["laps"] == 0 and abs(output["length"] - (2 * (0.04 + 0.02 * 2 ** 0.5))) < 0.01, (report, output))
    check("`validate` sees the input", level.ask("track.follow", path=[]) == ("e_empty", {"name": "::track::e_empty"}))
    check("and raises with details", level.ask("track.follow", path=[{"x": 300, "y": 400}]) == ("e_far", {"name": "::track::e_far", "detail": {"distance": 500, "what": "point"}}))
    older = level.begin("track.follow", path=[{"x": 50, "y": 0}])
    level.next(older, "intermediate")
    newer = level.begin("track.follow", path=[{"x": 0, "y": 50}])
    check("a new one interrupts", level.final(older)[0] == "interrupted" and level.next(newer, "intermediate")["report"] == "OK")
    check("`stop` ran", level.ask("track.get_note") == ("OK", {"note": "stopped"}))
    check("and is told to stop", level.ask("track.halt")[0] == "OK" and level.final(newer)[0] == "interrupted")


def ports(level):
    chase = level.begin("track.chase")
    level.next(chase, "intermediate")
    check("what was not written is not there", level.ask("track.count")[0] == "OK" and (chase, "final") not in level.replies)
    check("nor shown", (got := level.client.ask("poster", poster="eye.target")) and got["ok"] and got["value"] is None, got)
    check("another component writes", level.ask("eye.watch", where={"x": 7, "y": 8})[0] == "OK" and level.final(chase) == ("OK", None), level.replies)
    check("it writes again", level.ask("eye.watch", where={"x": -2, "y": 8})[0] == "OK")
    check("what a port holds is shown", (got := level.client.ask("poster", poster="eye.target")).get("value") == {"x": -2, "y": 8}, got)
    for name in ("eye.targets", "track.target", "track.gauge", 3):  # unknown, an in port, a multiple one, no name
        check(f"{name} is not", not (got := level.client.ask("poster", poster=name))["ok"] and "poster" in got["error"], got)
    check("and is read again", level.ask("track.chase") == ("e_far", {"name": "::track::e_far", "detail": {"distance": -2, "what": "behind"}}))


def faults(level):
    check("C++ throws", level.ask("track.odd", how="CREEP") == ("codel_exception", {"codel": "oddStart", "what": "cannot creep"}))
    check("a state that the codel may not yield", level.ask("track.odd", how="WALK")[0] == "bad_transition")
    check("an exception that the service does not throw", level.ask("track.odd", how="RUN") == ("codel_exception", {"name": "::genom::syserr", "detail": {"code": 5, "what": "input/output"}}))


def beside(level):
    """An async codel holds nothing up. This one takes until the test tells it that others were answered, half of LONG at most."""
    enough, impatient = (pathlib.Path(level.work, name) for name in ("enough", "impatient"))
    enough.unlink(missing_ok=True)
    ponder = level.begin("track.ponder", seconds=LONG / 2)
    level.next(ponder, "intermediate")
    check("others are answered meanwhile", level.ask("track.count")[0] == "OK" and not impatient.exists(), level.replies)
    enough.touch()
    check("its output comes when it is back", level.final(ponder) == ("OK", {"answer": "forty-two"}), level.replies)


def restart(level):
    """A process of a component that dies is replaced: its IDS is new, and the codels that start its task have run."""
    check("an attribute is set", level.ask("track.set_limit", limit={"high": 3})[0] == "OK")
    pathlib.Path(level.work, "enough").unlink(missing_ok=True)
    ponder = level.begin("track.ponder", seconds=LONG)
    level.next(ponder, "intermediate")
    nursery = children(level.server.pid)["bip-modules"]
    before = children(nursery)
    os.kill(before["track"], signal.SIGKILL)
    report, told = level.final(ponder)
    # Its codel has begun, or not yet.
    check("what ran there fails, also beside its task", report == "codel_exception" and told["codel"] == "ponderStart" and ("ended by SIGKILL" in told["what"] or "started again" in told["what"]), (report, told))
    check("the IDS is as the start codel left it", (got := level.ask("track.get_drive"))[0] == "OK" and got[1]["drive"]["limit"]["high"] == 2, got)
    check("what others wrote is read again", (got := level.ask("track.chase")) == ("e_far", {"name": "::track::e_far", "detail": {"distance": -2, "what": "behind"}}), got)
    after = children(nursery)
    check("the other component has not noticed", before["eye"] == after["eye"] and before["track"] != after["track"], (before, after))
    # The task's own codel is what is due next: it waits in the stopped process, alone.
    os.kill(after["track"], signal.SIGSTOP)
    time.sleep(0.5)
    os.kill(after["track"], signal.SIGKILL)
    check("a task whose codel was alone in the process goes on", (got := level.ask("track.chase"))[0] == "e_far", got)


def killed(level):
    """genom3's service `kill`: what runs is interrupted, the task stops, nothing is accepted any more."""
    far = level.begin("track.follow", path=[{"x": 50, "y": 0}])
    level.next(far, "intermediate")
    check("a component is killed", level.ask("track.kill") == ("OK", None) and level.final(far)[0] == "interrupted", level.replies)
    for service, input in (("follow", {"path": [{"x": 1, "y": 0}]}), ("ponder", {"seconds": 0}), ("count", {}), ("set_limit", {}), ("connect_port", {"local": "target", "remote": "eye/target"}), ("kill", {})):
        check(f"{service} is refused then", (got := level.ask(f"track.{service}", **input)) == ("disallowed", None), got)
    said = level.refused("track.follow", {})
    check("its input is judged before", "`path` is missing" in said, said)
    check("another component goes on", level.ask("eye.watch", where={"x": 0, "y": 1})[0] == "OK")


def children(parent):
    """{name: pid}"""
    found = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            pid, rest = stat.read_text().split(" (", 1)
        except OSError:
            continue  # gone meanwhile
        name, rest = rest.rsplit(") ", 1)
        if int(rest.split()[1]) == parent:
            found[name] = int(pid)
    return found


def end_process(nursery, module):
    """Kills the process of a module, and waits for the one that takes its place."""
    before = children(nursery)[module]
    os.kill(before, signal.SIGKILL)
    until(lambda: children(nursery).get(module, before) != before)


def serve(work, parts):
    """Serves m.bip to each part in turn; the log."""
    level = Level(work)
    try:
        with level.client:
            for part in parts:
                part(level)
            level.client.ask("shutdown")
        code = level.server.wait(LONG)
        check("it ends with 0", code == 0, (code, pathlib.Path(work, "log").read_text(encoding="utf-8")))
    finally:
        level.server.kill()
    return pathlib.Path(work, "log").read_text(encoding="utf-8")


def run(options, parts):
    with tempfile.TemporaryDirectory(prefix="codels-") as work:
        shutil.copytree(HERE, work, dirs_exist_ok=True)
        made = subprocess.run([BIPC, "genom", "--served", *options, "--codels", "codels/track_codels.c", "--codels", "codels/track_more.cc", "track.gen", "eye.gen", "-o", "m.bip"], cwd=work, capture_output=True, text=True)
        check("they are translated", made.returncode == 0, made.stdout + made.stderr)
        # Nothing of them needs what -w hides.
        warned = subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Wno-array-parameter", "-Werror", "-D_GNU_SOURCE", "-fsyntax-only", "-I.", f"-I{ROOT}/runtime/include", "codels/track_codels.c"], cwd=work, capture_output=True, text=True)
        check("the headers are plain C", warned.returncode == 0, warned.stderr)
        for clang in filter(None, map(shutil.which, ("clang++", "clang++-19"))):
            read = subprocess.run([clang, "-std=c++20", "-w", "-fsyntax-only", "-I.", f"-I{ROOT}/runtime/include", "m_codels.cpp"], cwd=work, capture_output=True, text=True)
            check(f"{clang} compiles what calls them", read.returncode == 0, read.stderr)
        log = serve(work, parts)
        check("the codel that stops the task has run once", log.count("track: stopped") == 1, log)
        check("the log tells of what was thrown", "codel `oddStart` of track.odd threw an exception: cannot creep" in log and "raised ::genom::syserr" in log, log)


def main():
    parts = (refusals, values, activities, ports, faults, beside)
    run([], (*parts, killed))
    # Nothing is different for a client if components are processes of their own.
    run(["--processes"], (*parts, restart, killed))
    return finish("codels")


if __name__ == "__main__":
    sys.exit(main())
