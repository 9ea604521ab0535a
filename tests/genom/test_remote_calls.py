#!/usr/bin/env python3
"""Codels call services of other components (compiler/docs/genom.md, *Calls of other components*).

tests/genom/errand has a component in C and one in C++ that use each other's interfaces. Every check looks at what a client is told of the
activity whose codel makes the call. Python's library only.
"""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from test_c_codels import BIPC, ROOT, check, children, end_process, finish, serve, until  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent / "errand"
ROOF = {"x": 3, "y": 4, "name": "roof"}


def visit(level, where=ROOF, seen=(), limit=None, **more):
    return level.ask("guide.visit", where=where, seen=list(seen), limit=limit, **more)


def calls(level):
    before = {"x": 1, "y": 2, "name": "\u00e4 \"q\""}
    check("inputs and outputs, from C to C++", (got := visit(level, seen=[before])) == ("OK", {"seen": [before, ROOF], "summary": "guide: as far as \"you\" can, 2 at roof", "area": [1.25, 3], "count": 1}), got)
    check("the other's data are its own", (got := visit(level, limit=5))[0] == "OK" and got[1]["count"] == 2 and got[1]["seen"] == [ROOF], got)
    check("an exception with details", (got := visit(level, weather="FOG")) == ("e_dark", {"name": "::watching::e_dark", "detail": {"weather": "FOG", "since": "dawn"}}), got)
    check("one without", (got := visit(level, where={**ROOF, "name": ""})) == ("e_nothing", {"name": "::watching::e_nothing"}), got)
    check("one that the caller does not throw", (got := visit(level, limit=4.9)) == ("codel_exception", {"name": "::genom::no_such_data"}), got)
    check("what is no exception of the description", (got := visit(level, where={**ROOF, "name": "elsewhere"})) == ("unkown_error", {"name": "::genom::unkown_error", "detail": {"what": "lookout.watch: codel_exception"}}), got)
    check("from C++ to C", (got := level.ask("lookout.report", name="me", times=[1, 2.5])) == ("OK", {"times": [2, 5, 1], "told": "asked by me me 3.500000"}), got)
    for number in (2, 3):
        check("again", (got := level.ask("lookout.report", name="you", times=[]))[1]["times"] == [number], got)
    check("an exception in C++", (got := level.ask("lookout.report", name="me", times=[])) == ("e_tired", {"name": "::guiding::e_tired", "detail": {"asked": 4}}), got)
    took = []
    for _ in range(20):
        number = level.begin("guide.visit", where=ROOF, seen=[], limit=None)
        check("calls one after the other", (got := level.final(number))[0] == "OK", got)
        took.append((level.replies[number, "final"]["time"] - level.replies[number, "intermediate"]["time"]) / 1e9)
    # In the level's time, in which a period of its task is 10 ms: the quickest, since a busy machine makes some of them slow.
    check("a call takes some periods", min(took) < 0.5, took)


def stares(level):
    """A visit that lasts until the lookout rests."""
    number = level.begin("guide.visit", where=ROOF, seen=[], limit=None)
    level.next(number, "intermediate")
    check("the caller waits", (number, "final") not in level.replies)
    return number


def rests(level):
    def is_over():
        assert level.ask("lookout.rest", seconds=0)[0] == "OK"
        return not level.client.ask("requests")["requests"]

    until(is_over)


def connects(level):
    def connect(local, remote):
        return level.ask("guide.connect_service", local=local, remote=remote)

    none = ("no_such_service", {"name": "::genom::no_such_service"})
    check("no such remote", connect("look", "lookout/watch") == none)
    check("no such service", connect("watch", "lookout/look") == none)
    check("one with other parameters", connect("watch", "lookout/rest") == none and connect("watch", "guide/tally") == none)
    check("another service", connect("watch", "lookout/stare") == ("OK", None))
    number = stares(level)
    rests(level)
    check("is the one that is called", level.final(number)[0] == "interrupted", level.replies)
    check("and back", connect("watch", "lookout/watch") == ("OK", None) and (got := visit(level))[0] == "OK", got)


def restarted(level):
    nursery = children(level.server.pid)["bip-modules"]
    check("it is connected", level.ask("guide.connect_service", local="watch", remote="lookout/stare")[0] == "OK")
    end_process(nursery, "guide")
    number = stares(level)
    rests(level)
    check("a process that takes the place of another one is connected as that was", level.final(number)[0] == "interrupted", level.replies)
    number = stares(level)
    # Until its codel has made the call.
    until(lambda: len(level.client.ask("requests")["requests"]) >= 2)
    os.kill(children(nursery)["lookout"], signal.SIGKILL)
    report, told = level.final(number)
    check("the other component may die", report == "unkown_error" and told["detail"]["what"] == "lookout.stare: codel_exception", (report, told))
    check("and comes back", level.ask("guide.connect_service", local="watch", remote="lookout/watch")[0] == "OK" and (got := visit(level))[0] == "OK" and got[1]["count"] == 1, got)


def killed(level):
    number = level.begin("guide.visit", where={**ROOF, "x": 1000}, seen=[], limit=None)
    level.next(number, "intermediate")
    until(lambda: len(level.client.ask("requests")["requests"]) >= 2)
    check("the other component is killed", level.ask("lookout.kill") == ("OK", None) and (got := level.final(number))[0] == "interrupted", level.replies)
    check("it refuses then", (got := visit(level))[0] == "disallowed", got)


def waits(level):
    """The end of the level is the end of a call."""
    check("a call is begun", level.ask("guide.connect_service", local="watch", remote="lookout/stare")[0] == "OK")
    stares(level)


def translate(work, *more):
    shutil.copytree(HERE, work, dirs_exist_ok=True)
    return subprocess.run([BIPC, "genom", "--served", *more, "--codels", "codels/guide_codels.c", "--codels", "codels/lookout_codels.cc", "guide.gen", "lookout.gen", "-o", "m.bip"], cwd=work, capture_output=True, text=True)


def run(options, parts):
    with tempfile.TemporaryDirectory(prefix="remote-") as work:
        made = translate(work, *options)
        check("they are translated", made.returncode == 0, made.stdout + made.stderr)
        warned = subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Wno-array-parameter", "-Werror", "-D_GNU_SOURCE", "-fsyntax-only", "-I.", f"-I{ROOT}/runtime/include", "codels/guide_codels.c"], cwd=work, capture_output=True, text=True)
        check("the headers are plain C", warned.returncode == 0, warned.stderr)
        for compiler in filter(None, map(shutil.which, ("g++", "clang++", "clang++-19"))):
            warned = subprocess.run([compiler, "-std=c++20", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I.", f"-I{ROOT}/runtime/include", "codels/lookout_codels.cc"], cwd=work, capture_output=True, text=True)
            check(f"{compiler} has nothing against the headers", warned.returncode == 0, warned.stderr)
        serve(work, parts)


def main():
    run([], (calls, connects, killed))
    run([], (waits,))
    run(["--processes"], (calls, connects, restarted, killed))
    run(["--processes"], (waits,))
    return finish("remote_calls")


if __name__ == "__main__":
    sys.exit(main())
