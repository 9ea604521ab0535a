#!/usr/bin/env python3
"""Codels of genom3's C++ mapping run as they are (compiler/docs/genom.md, *Codels in C++*).

tests/genom/survey has a component with codels in C++ and one in C; each reads a port that the other writes. Every check looks at what a
client is told. At the end codels that do not fit: the compiler's message names their line. Python's library only.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from test_c_codels import BIPC, LONG, ROOT, check, children, end_process, finish, serve, until  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent / "survey"
POSE = {"seen_in": "WORLD", "at": {"x": 3, "y": 4}, "heading": 0.5, "spread": [1, 2], "source": "lamp"}


def refusals(level):
    for service, input, part in (
            ("survey.fly_over", {"path": [{"x": 1, "y": "far"}]}, "`path[0].y` is a number"),
            ("survey.fly_over", {"path": [{"x": 1, "z": 2}]}, "`path[0]` has no member `z`"),
            ("survey.measure", {"place": {"_d": "SLOW", "corners": []}, "scale": None, "flags": []}, "`place` has no member `corners`"),
            ("survey.measure", {"place": {"_d": "FLY"}, "scale": None, "flags": []}, "`place._d` is one of SLOW, FAST, NAMED"),
            ("survey.measure", {"place": {"_d": "SLOW", "radius": 1}, "scale": None, "flags": [1]}, "`flags[0]` is true or false"),
            ("survey.tabulate", {"rows": [[1], [2], [3], [4]]}, "`rows` has at most 3 elements"),
            ("survey.tabulate", {"rows": [[1, 2, 3]]}, "`rows[0]` has at most 2 elements"),
            ("survey.mark", {"name": "much too long", "at": {"x": 1, "y": 1}}, "`name` is a text of at most 8 bytes"),
            ("survey.set_gains", {"gains": [1, 2]}, "`gains` is an array of 3")):
        said = level.refused(service, input)
        check(f"{service} {input} is refused", part in said, said)


def values(level):
    until(lambda: level.ask("survey.get_flight")[1]["flight"]["limit"]["high"] == 2)  # the task has begun
    check("a constant and an optional", level.ask("survey.tabulate", rows=[[1], [], [2]]) == ("OK", None) and level.ask("survey.get_note") == ("OK", {"note": "hello nobody"}))
    check("sequences of sequences", (got := level.ask("survey.get_table")) == ("OK", {"table": [[1, -1], [-1], [2, -1]]}), got)
    check("more than a bound", (got := level.ask("survey.tabulate", rows=[[1, 2]])) == ("codel_exception", {"codel": "surveyTabulate", "what": "a sequence of more than 2 elements"}), got)
    check("an initial value is an enumerator", level.ask("survey.set_pace") == ("OK", None))
    check("arrays and structs", level.ask("survey.set_gains", gains=[6, 2, 0.25])[0] == "OK" and level.ask("survey.set_limit", limit={"high": 3})[0] == "OK")
    check("an attribute is judged", level.ask("survey.set_pace", pace="SLOW") == ("e_empty", {"name": "::survey::e_empty"}))
    check("they are in the IDS", (got := level.ask("survey.get_flight")) == ("OK", {"flight": {"pace": "FAST", "limit": {"low": 0.1, "high": 3}, "gains": [6, 2, 0.25], "home": [{"x": 0, "y": 0}, {"x": 0, "y": 0}]}}), got)
    check("union, optional, booleans", (got := level.ask("survey.measure", place={"_d": "SLOW", "radius": 2}, scale=10, flags=[True, False, True])) == ("OK", {"sum": 40, "verdict": "slow of 3"}), got)
    check("another member of the union", (got := level.ask("survey.measure", place={"_d": "FAST", "corners": [{"x": 2, "y": 3}]}, scale=None, flags=[])) == ("OK", {"sum": 6, "verdict": "fast of 0"}), got)
    check("an exception that is returned", (got := level.ask("survey.measure", place={"_d": "FAST", "corners": [{"x": 20, "y": 30}]}, scale=None, flags=[])) == ("e_far", {"name": "::survey::e_far", "detail": {"distance": 600, "what": "corners", "beyond": [{"x": 20, "y": 30}]}}), got)
    check("one without details", level.ask("survey.measure", place={"_d": "FAST", "corners": []}, scale=None, flags=[]) == ("e_empty", {"name": "::survey::e_empty"}))
    check("the default member", level.ask("survey.measure", place={"_d": "NAMED", "name": "roof"}, scale=None, flags=[]) == ("codel_exception", {"codel": "surveyMeasure", "what": "a place called roof"}))
    check("a native is the codels' own", level.ask("survey.frames")[1]["count"] > 0)


def activities(level):
    report, output = level.ask("survey.fly_over", path=[{"x": 0.03, "y": 0}, {"x": 0.03, "y": 0.04}])
    check("an activity with locals, in several cycles", report == "OK" and abs(output["length"] - 0.07) < 1e-6, (report, output))
    check("`validate` throws", level.ask("survey.fly_over", path=[]) == ("e_empty", {"name": "::survey::e_empty"}))
    check("with details", (got := level.ask("survey.fly_over", path=[{"x": 1, "y": 0}, {"x": 300, "y": 400}])) == ("e_far", {"name": "::survey::e_far", "detail": {"distance": 500, "what": "path", "beyond": [{"x": 300, "y": 400}]}}), got)
    older = level.begin("survey.fly_over", path=[{"x": 50, "y": 0}])
    level.next(older, "intermediate")
    newer = level.begin("survey.fly_over", path=[{"x": 0.03, "y": 0.04}])
    check("a new one interrupts", level.final(older)[0] == "interrupted" and level.final(newer)[0] == "OK")
    check("`stop` ran", level.ask("survey.get_note") == ("OK", {"note": "stopped"}))


def faults(level):
    check("an exception of C++", level.ask("survey.fault", how="SLOW", late=False) == ("codel_exception", {"codel": "faultStart", "what": "cannot be so slow"}))
    check("one that the service does not throw", level.ask("survey.fault", how="FAST", late=False) == ("codel_exception", {"name": "::genom::syserr", "detail": {"code": 5, "what": "input/output"}}))
    check("no exception class at all", level.ask("survey.fault", how="SLOW", late=True) == ("codel_exception", {"codel": "faultNext", "what": ""}))
    check("one that is returned", level.ask("survey.fault", how="FAST", late=True) == ("e_far", {"name": "::survey::e_far", "detail": {"distance": 1, "what": "late", "beyond": []}}))


def beside(level):
    enough, impatient = (pathlib.Path(level.work, name) for name in ("enough", "impatient"))
    enough.unlink(missing_ok=True)
    ponder = level.begin("survey.ponder", seconds=LONG / 2)
    level.next(ponder, "intermediate")
    check("others are answered meanwhile", level.ask("survey.frames")[0] == "OK" and not impatient.exists(), level.replies)
    enough.touch()
    check("its output comes when it is back", level.final(ponder) == ("OK", {"answer": "forty-two"}), level.replies)


def ports(level):
    """Between C and C++, both ways."""
    home = level.begin("survey.home")
    level.next(home, "intermediate")
    check("what was not written is not there", level.ask("survey.frames")[0] == "OK" and (home, "final") not in level.replies)
    check("a component in C writes", level.ask("lamp.show", where=POSE)[0] == "OK" and level.final(home) == ("OK", None), level.replies)
    check("one in C++ writes", level.ask("survey.fly_over", path=[{"x": 3, "y": 4}, {"x": 3.01, "y": 4}])[0] == "OK")
    seen = {"seen_in": "BODY", "at": {"x": 3.01, "y": 4}, "spread": [3.01, 4], "source": "survey"}
    report, output = level.ask("lamp.seen")
    last = output["last"] if report == "OK" else {}
    check("and one in C reads", report == "OK" and all(last["where"][name] == value for name, value in seen.items()) and last["outline"] == [{"x": 3, "y": 4}, {"x": 3.01, "y": 4}] and last["hits"][-2:] == [True, False] and last["label"] == "2 places" and last["covariance"] == [[0, 0], [0.5, 0]], (report, output))
    check("the port is shown", (got := level.client.ask("poster", poster="survey.sight"))["ok"] and got["value"] == last, got)


def connections(level):
    """`connect_port`, as genom3 has it."""
    def connect(component, local, remote):
        return level.ask(f"{component}.connect_port", local=local, remote=remote)

    check("no such in port", connect("survey", "sight", "lamp/beacon") == ("no_such_inport", {"name": "::genom::no_such_inport"}))
    check("no such out port", connect("survey", "beacon", "lamp/bacon") == ("no_such_outport", {"name": "::genom::no_such_outport"}))
    check("one of another type", connect("survey", "beacon", "survey/sight")[0] == "no_such_outport")
    check("a multiple port needs a name", connect("survey", "marks_seen", "lamp/beacon")[0] == "no_such_inport" and connect("survey", "beacon", "survey/marks")[0] == "no_such_outport")
    check("a port that nothing is connected to", level.ask("survey.look", name="a") == ("no_such_outport", {"name": "::genom::no_such_outport"}))
    check("a name to a port", connect("survey", "marks_seen/a", "lamp/beacon") == ("OK", None) and (got := level.ask("survey.look", name="a")) == ("OK", {"seen": POSE}), got)
    check("a name to a name, of its own", connect("survey", "marks_seen/b", "survey/marks/left")[0] == "OK" and level.ask("survey.look", name="b") == ("e_empty", {"name": "::survey::e_empty"}))
    check("a multiple port is written", level.ask("survey.mark", name="left", at={"x": 7, "y": 8})[0] == "OK" and level.ask("survey.mark", name="", at={"x": 7, "y": 8})[0] == "e_empty")
    report, output = level.ask("survey.look", name="b")
    check("and read", report == "OK" and output["seen"]["at"] == {"x": 7, "y": 8} and output["seen"]["source"] == "left" and output["seen"]["spread"] == [1, 2] and output["seen"]["heading"] is None, (report, output))
    check("another port instead", connect("survey", "beacon", "lamp/spare")[0] == "OK" and level.ask("lamp.show", where={**POSE, "at": {"x": -1, "y": 0}}, is_spare=True)[0] == "OK" and level.ask("survey.home")[0] == "OK")
    check("the value is that one's", level.ask("lamp.show", where={**POSE, "source": "other", "at": {"x": 9, "y": 0}}, is_spare=True)[0] == "OK" and level.ask("survey.home") == ("e_far", {"name": "::survey::e_far", "detail": {"distance": 9, "what": "an odd beacon", "beyond": [{"x": 9, "y": 0}]}}))
    check("and back", connect("survey", "beacon", "lamp/beacon")[0] == "OK" and level.ask("survey.home")[0] == "OK")
    said = level.refused("survey.connect_port", {"local": "beacon"})
    check("its input is judged", "`remote` is missing" in said, said)


def restart(level, nursery):
    """Ends the process of survey, while a codel is beside its task: where the task's own is alone, it would be what has ended it."""
    log = pathlib.Path(level.path).with_name("log")
    begun = log.read_text(encoding="utf-8").count("survey: ponders")
    pathlib.Path(level.work, "enough").unlink(missing_ok=True)
    ponder = level.begin("survey.ponder", seconds=LONG)
    level.next(ponder, "intermediate")
    # Its codel begins after the reply.
    until(lambda: log.read_text(encoding="utf-8").count("survey: ponders") > begun)
    end_process(nursery, "survey")
    check("what ran there fails", level.final(ponder)[0] == "codel_exception", level.replies)


def reconnected(level):
    """A process that takes the place of another one is connected as that was."""
    odd = ("e_far", {"name": "::survey::e_far", "detail": {"distance": 9, "what": "an odd beacon", "beyond": [{"x": 9, "y": 0}]}})
    check("a port is connected", level.ask("survey.connect_port", local="beacon", remote="lamp/spare") == ("OK", None) and (got := level.ask("survey.home")) == odd, got)
    nursery = children(level.server.pid)["bip-modules"]
    for _ in range(2):
        before = children(nursery)
        restart(level, nursery)
        check("so it is afterwards", (got := level.ask("survey.home")) == odd, got)
        check("a name of a multiple port, too", (got := level.ask("survey.look", name="a"))[0] == "OK" and got[1]["seen"]["source"] == "lamp", got)
        check("in another process", (after := children(nursery))["survey"] != before["survey"] and after["lamp"] == before["lamp"], (before, after))
    check("the last connection counts", level.ask("survey.connect_port", local="beacon", remote="lamp/beacon")[0] == "OK")
    restart(level, nursery)
    check("of several", (got := level.ask("survey.home"))[0] == "OK", got)


def aborts(level):
    def abort(number):
        return level.ask("survey.abort_activity", id=number)

    far = level.begin("survey.fly_over", path=[{"x": 90, "y": 0}])
    level.next(far, "intermediate")
    check("an activity is aborted by the number of its request", abort(far) == ("OK", None) and level.final(far)[0] == "interrupted", level.replies)
    check("and then there is none", abort(far) == ("no_such_activity", None) and abort(10**6) == ("no_such_activity", None))
    check("the reply is of what was asked", level.replies[max(level.replies)]["service"] == "survey.abort_activity", level.replies)
    for input in ({}, {"id": "x"}, {"id": 1, "at": 2}, [1], "1"):
        said = level.refused("survey.abort_activity", input)
        check(f"{input} is no number of a request", "an object with `id`" in said, said)
    check("nor of another component", "there is no service" in (said := level.refused("eye.abort_activity", {"id": 1})), said)


def translate(work, *more, codels=("codels/survey_codels.cc", "codels/lamp_codels.c"), files=("survey.gen", "lamp.gen")):
    shutil.copytree(HERE, work, dirs_exist_ok=True)
    arguments = [BIPC, "genom", "--served", *more, *(a for c in codels for a in ("--codels", c)), *files, "-o", "m.bip"]
    return subprocess.run(arguments, cwd=work, capture_output=True, text=True)


def run(options, parts):
    with tempfile.TemporaryDirectory(prefix="cxx-codels-") as work:
        made = translate(work, *options)
        check("they are translated", made.returncode == 0, made.stdout + made.stderr)
        # Nothing of them needs what -w hides.
        flags = ["-std=c++20", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I.", f"-I{ROOT}/runtime/include"]
        for compiler in filter(None, map(shutil.which, ("g++", "clang++", "clang++-19"))):
            warned = subprocess.run([compiler, *flags, "codels/survey_codels.cc"], cwd=work, capture_output=True, text=True)
            check(f"{compiler} has nothing against the headers", warned.returncode == 0, warned.stderr)
        log = serve(work, parts)
        check("the log tells of what was thrown, and only of what no service throws", "codel `faultStart` of survey.fault threw an exception: cannot be so slow" in log and "raised ::genom::syserr" in log and "e_far" not in log and "e_empty" not in log, log)


def misfits():
    """What does not fit the description is the compiler's to say, with its line. A codel with other parameters is another function for C++: the linker misses the right one, and the line of the other is told."""
    source = (HERE / "codels/survey_codels.cc").read_text(encoding="utf-8")
    for old, new, said in (
            ("flyStop(std::string &note, const genom_context)", "flyStop(std::string note, const genom_context)", "undefined reference to `flyStop'"),
            ("throw survey::e_empty();\n  survey::e_far_detail", "throw survey::e_empti();\n  survey::e_far_detail", "e_empti"),
            ("if (!seen) return survey_pause_start;", "if (!seen) return survey_pause_begin;", "survey_pause_begin")):
        with tempfile.TemporaryDirectory(prefix="cxx-misfit-") as work:
            check(f"there is {old!r}", source.count(old) == 1, source.count(old))
            made = translate(work)
            check("it is translated", made.returncode == 0, made.stderr)
            wrong = source.replace(old, new)
            pathlib.Path(work, "codels/survey_codels.cc").write_text(wrong, encoding="utf-8")
            ran = subprocess.run([BIPC, "run", "m.bip", "--limit", "1"], cwd=work, capture_output=True, text=True)
            line = wrong[:wrong.index(new)].count("\n") + 1
            check(f"{new!r} is refused", ran.returncode != 0 and said in ran.stderr and f"survey_codels.cc:{line}: " in ran.stderr, ran.stderr[-2000:])


def main():
    parts = (refusals, values, activities, faults, beside, ports, connections, aborts)
    run([], parts)
    # Nothing is different for a client if components are processes of their own.
    run(["--processes"], (*parts, reconnected))
    misfits()
    return finish("cxx_codels")


if __name__ == "__main__":
    sys.exit(main())
