#!/usr/bin/env python3
"""The Python package bipc of the build tree: compile, diagnostics, run, batches, explore, verify, pictures, threads, Ctrl-C, bipc.serve.

Run by the Python that the module was built for (Debian's); says so if the build has no module.
"""
import json
import math
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests"))
from patience import LONG, until  # noqa: E402

BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = os.environ.get("BIPC") or BUILD / "bipc"
PYTHON = "/usr/bin/python3"
PHILOSOPHERS = ROOT / "models/classic/philosophers.bip"
SAFE = ROOT / "models/classic/philosophers_safe.bip"


def test_errors_are_objects():
    try:
        bipc.load("package p\ncompound type Root()\n  component Missing m()\nend\nend\n")
    except bipc.CompileError as error:
        first = error.diagnostics[0]
        assert (first.severity, first.file, first.line, first.column) == ("error", "model.bip", 3, 13), first
        assert first.code.startswith("B") and first.code in error.text and first.code in str(error), error.text
    else:
        raise AssertionError("no error")
    assert bipc.check(PHILOSOPHERS) == []
    try:
        bipc.load("/nowhere/m.bip")
    except bipc.CompileError as error:
        assert error.diagnostics[0].line == 0
    for wrong in (lambda: bipc.load(PHILOSOPHERS, backend="gpu"), lambda: bipc.load(PHILOSOPHERS, "Table(3)").start(policy="best"),
                  lambda: bipc.load(PHILOSOPHERS, "Table(3)").verify("never nobody@EATS")):
        try:
            wrong()
        except ValueError:
            continue
        raise AssertionError("a wrong word was taken")


def test_policies_are_those_of_the_command():
    """Each name of `bipc run --policy` gives the run of the command; an unknown one lists them all."""
    shown = subprocess.run([BUILD / "bipc", "run", "--help"], capture_output=True, text=True).stdout
    names = re.search(r"--policy (\S+)", shown)[1].split("|")
    assert "fair" in names, names
    for name in names:
        done = subprocess.run([BUILD / "bipc", "run", "--root", "Table(5)", "--seed", "7", "--limit", "100", "--no-cache", "--policy", name, PHILOSOPHERS],
                              capture_output=True, text=True)
        wanted = re.findall(r"^#\d+ +(\S+)", done.stdout, re.M)
        trace = [step.interaction for step in bipc.load(PHILOSOPHERS, "Table(5)").start(seed=7, policy=name).trace(100)]
        assert trace == wanted and len(wanted) > 1, (name, trace, done.stdout[:500])
    try:
        bipc.load(PHILOSOPHERS, "Table(3)").start(policy="best")
    except ValueError as error:
        assert all(name in str(error) for name in names) and "`best`" in str(error), error
    else:
        raise AssertionError("a wrong policy was taken")


def test_runs_are_those_of_the_command():
    """Same seed, same interactions as `bipc run`, by JIT and interpreter."""
    done = subprocess.run([BUILD / "bipc", "run", "--root", "Table(5)", "--seed", "7", "--limit", "200", "--no-cache", PHILOSOPHERS], capture_output=True, text=True)
    wanted = re.findall(r"^#\d+ +(\S+)", done.stdout, re.M)
    traces = []
    for backend in ("auto", "interp"):
        system = bipc.load(PHILOSOPHERS, "Table(5)", backend=backend).start(seed=7)
        trace = system.trace(200)
        traces.append([step.interaction for step in trace])
    assert traces == [wanted, wanted] and len(wanted) > 1, (traces, done.stdout[:500])


def test_step_candidates_fire_snapshot():
    system = bipc.load(PHILOSOPHERS, "Table(3)").start(seed=1)
    names = system.candidates()
    assert len(names) == 3 and all(name.startswith("ROOT.") for name in names), names
    saved = system.snapshot()
    assert system.fire(names[1]) == "stepped" and system.steps == 1
    places = [system.place(path) for path in system.model.components]
    assert "HAS_LEFT" in places, places
    system.restore(saved)
    assert system.steps == 0 and system.candidates() == names
    first = [step.interaction for step in system.trace(30)]
    system.restore(saved)
    assert [step.interaction for step in system.trace(30)] == first
    for wrong, kind in ((lambda: system.fire("ROOT.nothing"), ValueError), (lambda: system.read("ROOT.x.y"), KeyError), (lambda: system.place("ROOT.q"), KeyError)):
        try:
            wrong()
        except kind:
            continue
        raise AssertionError("a wrong name was taken")
    while system.outcome == "stepped" and system.step() == "stepped":
        pass
    assert system.outcome == "deadlock" and "deadlock" in system.story and system.candidates() == []


def test_many_seeds():
    model = bipc.load(SAFE, "Table(5)")
    runs = model.simulate(20, 500, seed=3)
    assert len(runs) == 20 and runs.steps == [500] * 20 and set(runs.ends) == {"limit"} and list(runs.seeds) == list(range(3, 23)), runs
    deadlocks = bipc.load(PHILOSOPHERS).simulate(20, 500)
    single = [bipc.load(PHILOSOPHERS).start(seed=seed) for seed in range(20)]
    assert [s.run(500) for s in single] == deadlocks.steps and set(deadlocks.ends) == {"deadlock"}, deadlocks.ends


def test_simulate_as_the_command():
    observers = ["count put[0]", "time until phil[0]@EATS", "reaches phil[0]@EATS && phil[2]@EATS", "mean fork[0]@FREE", "last fork[1]@FREE"]
    runs = bipc.load(SAFE, "Table(5)").simulate(300, 10, seed=7, observe=observers, stop="phil[3]@EATS", threads=2)
    with tempfile.TemporaryDirectory() as folder:
        csv = pathlib.Path(folder) / "runs.csv"
        words = [word for o in observers for word in ("--observe", o)]
        said = json.loads(subprocess.run([BIPC, "simulate", SAFE, "--root", "Table(5)", "--runs", "300", "--limit", "10", "--seed", "7", "--stop", "phil[3]@EATS",
                                          "--json", "--csv", csv, *words], capture_output=True, text=True, check=True).stdout)
        rows = [line.split(",") for line in csv.read_text().splitlines()[1:]]
    assert [int(row[0]) for row in rows] == list(runs.seeds) and [row[1] for row in rows] == runs.ends and [int(row[2]) for row in rows] == runs.steps
    assert {"limit", "stop"} == set(runs.ends), set(runs.ends)
    for k, (observer, row) in enumerate(zip(observers, said["observers"])):
        assert [float(r[3 + k]) for r in rows if r[3 + k]] == [v for v in runs.values[observer] if not math.isnan(v)], observer
        assert ["" == r[3 + k] for r in rows] == [math.isnan(v) for v in runs.values[observer]], observer
        e = runs.estimates[observer]
        assert (e.count, e.mean, e.median, [e.low, e.high]) == (row["runs"], row["mean"], row["median"], row["interval"]), (e, row)
    assert "95% interval" in runs._repr_html_() and observers[0] in runs._repr_html_()
    for wrong in ({"observe": ["time until nobody@EATS"]}, {"observe": ["sometimes phil[0]@EATS"]}, {"stop": "phil[0].x"}, {"until": 5}):
        try:
            bipc.load(SAFE, "Table(5)").simulate(1, 1, **wrong)
        except ValueError as error:
            assert str(error), wrong
        else:
            raise AssertionError(wrong)


def test_traces_as_tables():
    trace = bipc.load(SAFE, "Table(3)").start(seed=2).trace(50)
    assert len(trace) == 50 and trace[-1].number == 49 and trace[3:5][0].number == 3
    assert "<table>" in trace._repr_html_() and trace[0].interaction in trace._repr_html_()
    assert trace.timeline()._repr_svg_().count("<rect") == 50
    try:
        import numpy
    except ImportError:
        print("skipped: traces as arrays: numpy is missing (Debian's package python3-numpy)")
    else:
        rows = trace.to_numpy()
        assert rows["number"].tolist() == list(range(50)) and rows["interaction"].dtype == numpy.uint32
    try:
        import pandas  # noqa: F401
    except ImportError:
        print("skipped: traces as frames: pandas is missing (Debian's package python3-pandas)")
    else:
        assert trace.to_pandas()["interaction"].iloc[0] == trace[0].interaction


def test_explore_and_verify():
    model = bipc.load(PHILOSOPHERS, "Table(4)")
    found = model.explore()
    assert found.end == "complete" and found.deadlocks == 1 and len(found.deadlock) == 4, found
    ends = bipc.explore(ROOT / "models/liveness/leader_election.bip")
    assert ends.finals > 0 and ends.deadlocks == 0, ends.text
    verdict = model.verify()
    assert verdict.violated and verdict.name == "deadlock" and verdict.counterexample.end == "deadlock"
    system = model.start()
    for step in verdict.counterexample.steps:
        assert system.fire(step.interaction) == "stepped"
    assert system.candidates() == []
    safe = bipc.verify(SAFE, root="Table(20)", certificate=True, timeout=20)
    assert safe.holds and safe.certificate, safe.text
    with tempfile.TemporaryDirectory() as folder:
        system, proof = pathlib.Path(folder, "t.bsys"), pathlib.Path(folder, "t.cert")
        system.write_text(bipc.load(SAFE, "Table(20)").system_text)
        proof.write_text(safe.certificate)
        if (BUILD / "certcheck").exists():
            done = subprocess.run([BUILD / "certcheck", system, proof], capture_output=True, text=True)
            assert done.stdout.startswith("accepted"), done
        else:
            print("skipped: the certificate is not checked: certcheck was not built")


def test_pictures():
    model = bipc.load(PHILOSOPHERS, "Table(3)")
    assert "digraph bip" in model.graph() and model.graph("json").startswith("{")
    assert model._repr_svg_().startswith("<svg ") and "phil" in model.svg("structure")
    assert "Table(3)" in repr(model)


def test_python_goes_on_while_it_works():
    """The GIL is free: another thread counts during a long exploration."""
    model = bipc.load(SAFE, "Table(24)")
    counted, end = [0], threading.Event()

    def count():
        while not end.is_set():
            counted[0] += 1
            time.sleep(0.001)
    other = threading.Thread(target=count)
    other.start()
    model.explore(seconds=0.5, threads=1)
    end.set()
    other.join()
    assert counted[0] > 20, counted


def test_interrupt_ends_work():
    """Ctrl-C: KeyboardInterrupt long before the end, in an exploration, a proof and a run; the objects can be used afterwards."""
    model = bipc.load(SAFE, "Table(24)")
    system = model.start()
    # Who starts this in the background of a shell without job control has it ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for work in (lambda: model.explore(threads=1, seconds=60), lambda: system.run(2**40)):
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        try:
            work()
        except KeyboardInterrupt:
            pass
        else:
            raise AssertionError("it was not interrupted")
        finally:
            timer.cancel()
    assert system.step() == "stepped"


def test_serve_client_after_a_time_out():
    from bipc.serve import Client
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/model.sock"
        server = subprocess.Popen([BUILD / "bipc", "serve", "--root", "Table(5)", "--paused", "--socket", path, SAFE], stdin=subprocess.DEVNULL,
                                  stdout=subprocess.DEVNULL)
        try:
            def connected():
                assert server.poll() is None, "serve has ended"
                try:
                    return Client(path, LONG)
                except (FileNotFoundError, ConnectionRefusedError):
                    return None
            with until(connected) as client:
                assert client.ask("hello")["ok"]
                begin = time.monotonic()
                try:
                    client.note(timeout=0.2)
                except TimeoutError:
                    assert 0.15 < time.monotonic() - begin < LONG
                else:
                    raise AssertionError("there was a note")
                assert client.ask("hello")["ok"]
        finally:
            server.terminate()
            server.wait()


def test_stubs_name_what_is_there():
    """Every public name of the package is in the stubs, and the other way round."""
    text = (ROOT / "tools/python/bipc/__init__.pyi").read_text()
    for name in bipc.__all__:
        assert re.search(rf"^(class|def) {name}\b|^{name}\b|\b{name} as {name}\b", text, re.M), f"__init__.pyi lacks {name}"
    for kind in ("Model", "System", "Trace", "Runs"):
        body = re.search(rf"^class {kind}\b.*?(?=^class |^def |\Z)", text, re.M | re.S).group(0)
        stubs = {n for n in re.findall(r"    def (\w+)\(|^    (\w+):", body, re.M) for n in n if n and not n.startswith("_")}
        there = {n for n in dir(getattr(bipc, kind)) if not n.startswith("_")}
        assert there <= stubs, f"{kind}: the stubs lack {there - stubs}"
        if kind == "System":
            made = bipc.load(SAFE, "Table(2)").start()
            assert all(hasattr(made, n) for n in stubs), stubs
        assert getattr(bipc, kind).__doc__


def test_documents():
    """The examples of python.md are one session; embedding.md shows the program that is built."""
    session = "".join(re.findall(r"^```python\n(.*?)^```", (ROOT / "compiler/docs/python.md").read_text(), re.M | re.S))
    done = subprocess.run([PYTHON, "-c", session], cwd=ROOT, env={**os.environ, "PYTHONPATH": str(BUILD / "python")}, capture_output=True, text=True)
    assert done.returncode == 0 and "deadlock" in done.stdout, done.stderr
    shown = re.search(r"^```cpp\n(.*?)^```", (ROOT / "compiler/docs/embedding.md").read_text(), re.M | re.S).group(1)
    assert shown == (ROOT / "models/embedding/compile_here.cpp").read_text()


def main():
    passed = failed = 0
    for name, test in sorted((n, f) for n, f in globals().items() if n.startswith("test_")):
        try:
            test()
            passed += 1
        except Exception as problem:
            failed += 1
            print(f"FAILED {name[5:]}: {type(problem).__name__}: {problem}")
    print(f"python: {passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    if not list((BUILD / "python/bipc").glob("_bipc*.so")):
        print("skipped: the Python module was not built: pybind11-dev or python3-dev is missing (tools/setup --test)\npython: 0 passed, 0 failed")
        sys.exit(0)
    if os.path.realpath(sys.executable) != os.path.realpath(PYTHON):
        sys.exit(subprocess.run([PYTHON, __file__]).returncode)
    sys.path.insert(0, str(BUILD / "python"))
    import bipc
    sys.exit(main())
