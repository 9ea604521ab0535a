#!/usr/bin/env python3
"""Runs on several processes: `bipc run --engine=distributed`, on one machine.

    tests/distributed/test_processes.py [--runs N]

Every run is written as a binary trace, which `bipc replay --recorded` must accept: its steps are a run of the sequential semantics and its end is the
state that the nodes ended in. Then a node is killed at random moments, with both kinds of --on-loss, the launcher is interrupted, and killed; idle nodes are
watched. After each run no process and no socket is left. Prints "N passed, N failed" at the end.
"""
import argparse
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

import test_hosts
from test_hosts import BIPC, BUILD, LONG, PATIENCE, ROOT, check, until

MODELS = ROOT / "models"
# model, root, steps at most
CASES = [
    ("classic/philosophers", None, 3000), ("classic/gas_station", None, 300), ("classic/smokers", None, 200), ("classic/atm", None, 300),
    ("classic/bus_priority", None, 200), ("classic/sensor_broadcast", None, 200), ("classic/two_phase_commit", None, 200),
    ("classic/token_ring", None, 200), ("classic/readers_writers", None, 200), ("liveness/peterson", None, 200), ("bench/philosophers", "Table(12)", 500),
    ("bench/priority_desks", None, 300), ("bench/pingpong", "Pairs(8)", 2000), ("bench/ring", "Ring(9)", 300),
    # In logical time.
    ("timed/train_gate", None, 300), ("timed/watchdog", None, 200), ("timed/heart_pacer", None, 200), ("timed/rods", "Park(3, 8, 108)", 200),
]
FAULTY = """package m
  port type P()
  connector type Two(P p, P q)
    define p q
  end
  atom type Counter(int most)
    data int n
    data int left
    export port P go()
    place S
    initial to S do { n = 0; }
    on go from S to S do { n = n + 1; left = 100 / (most - n); }
  end
  compound type Root()
    component Counter a(3)
    component Counter b(50)
    component Counter c(70)
    connector Two x(a.go, b.go)
    connector Two y(b.go, c.go)
  end
end
"""

def sockets():
    return set(pathlib.Path(os.environ.get("TMPDIR", "/tmp")).glob("bipc-nodes-*"))


def children(pid):
    try:
        return [int(word) for word in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def catches(pid, number):
    """Has the process a handler for the signal?"""
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
    return int(re.search(r"^SigCgt:\s+(\w+)", status, re.M)[1], 16) >> (number - 1) & 1


def is_alive(pid):
    try:
        return "\nState:\tZ" not in pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


class Run:
    """A run with a trace, beside us. `model` is a path."""

    def __init__(self, folder, model, root, *options):
        self.trace, self.model, self.root = folder / "run.trace", model, ["--root", root] if root else []
        self.command = [BIPC, "run", "--engine=distributed", "--silent", "--stats", "--trace", str(self.trace), "--trace-format=binary", *options, *self.root, str(model)]
        self.resumed = None
        self.said = folder / "run.err"
        with open(self.said, "w", encoding="utf-8") as said:
            self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, stderr=said, text=True, cwd=folder)

    def is_over(self):
        return self.process.poll() is not None

    def nodes(self, count):
        """Processes of the nodes, when all are there and the launcher handles signals."""
        until(lambda: self.is_over() or len(children(self.process.pid)) >= count and catches(self.process.pid, signal.SIGINT))
        return children(self.process.pid)

    def wait_for(self, words):
        """Until it has said so."""
        return until(lambda: words in self.said.read_text(encoding="utf-8") or self.is_over()) and words in self.said.read_text(encoding="utf-8")

    def end(self):
        hangs = ""
        try:
            self.out, _ = self.process.communicate(timeout=5 * LONG)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.out, _ = self.process.communicate()
            hangs = "\n(it did not end)"
        self.err = self.said.read_text(encoding="utf-8") + hangs
        return self.process.returncode

    def replay(self):
        resume = ["--resume", str(self.resumed)] if self.resumed else []
        done = subprocess.run([BIPC, "replay", "--silent", "--recorded", str(self.trace), *resume, *self.root, str(self.model)], capture_output=True, text=True)
        return done.returncode == 0 and "the end agree" in done.stdout, done.stdout + done.stderr

    def check(self, codes, what):
        code = self.end()
        text = f"{' '.join(self.command)}\nexit {code}\n{self.out}{self.err}"
        check(code in codes, f"{what}: exit {code}", text)
        is_legal, said = self.replay()
        check(is_legal, f"{what}: the trace is no run of the model", text + said)
        steps = re.search(r"(\d+) steps?\b", self.out)
        return int(steps[1]) if steps else None


def test_models(folder, runs):
    for model, root, steps in CASES:
        for k in range(runs):
            nodes = 1 + (k + len(model)) % 5
            # Every other run takes what it can of conflict sets apart, and locks what is shared.
            split = ["--split-above", "1"] if k % 2 == 1 else []
            run = Run(folder, MODELS / f"{model}.bip", root, "--nodes", str(nodes), "--limit", str(steps), "--seed", str(k), *split)
            run.check({0}, f"{model} on {nodes} nodes {' '.join(split)}")
            if "limit:" in run.out:
                check(f"limit: {steps} steps" in run.out, f"{model}: the limit is exact", run.out)


def test_fault(folder):
    """The run ends at the error, with the steps before it."""
    model = folder / "faulty.bip"
    model.write_text(FAULTY)
    for k in range(4):
        run = Run(folder, model, None, "--nodes", "3", "--seed", str(k))
        run.check({1}, "a run-time error")
        check("R0005" in run.err, "the error is told", run.err)


def test_kill(folder, draws, runs):
    for k in range(runs):
        for how in ("stop", "go-on"):
            nodes = 4
            run = Run(folder, MODELS / "bench/philosophers.bip", "Table(8)", "--nodes", str(nodes), "--seed", str(k), "--on-loss", how, "--limit", "100000000")
            processes = run.nodes(nodes)
            time.sleep(draws.random() * 0.6)
            victim = draws.choice(processes)
            os.kill(victim, signal.SIGKILL)
            if how == "go-on":
                # It may go on for ever with what does not need the node; then Ctrl-C ends it.
                time.sleep(0.4)
                if run.process.poll() is None:
                    run.process.send_signal(signal.SIGINT)
            run.check({1} if how == "stop" else {1, 130}, f"a node is killed, --on-loss={how}")
            check("error[R0030]: lost `" in run.err and "killed by signal 9" in run.err, "who is lost is told", run.err)


def test_interrupt(folder, draws):
    for signal_number in (signal.SIGINT, signal.SIGTERM):
        run = Run(folder, MODELS / "bench/ring.bip", "Ring(9)", "--nodes", "3")
        run.nodes(3)
        time.sleep(0.1 + draws.random() * 0.3)
        run.process.send_signal(signal_number)
        run.check({128 + signal_number}, f"signal {signal_number}")


def wake_ups(pid):
    """How often the threads of a process have gone to sleep of their own will."""
    return sum(int(re.search(r"^voluntary_ctxt_switches:\s+(\d+)", (task / "status").read_text(), re.M)[1]) for task in pathlib.Path(f"/proc/{pid}/task").iterdir())


def test_idle(folder):
    """Nodes that wait for one that stands still sleep: the launcher asks each once a second, and a node that looked on a clock of its own would wake far more often."""
    run = Run(folder, MODELS / "bench/ring.bip", "Ring(9)", "--nodes", "3")
    processes = run.nodes(3)
    time.sleep(0.3)
    os.kill(processes[0], signal.SIGSTOP)
    check(come_to_rest(processes[1:]), "nodes that wait for one that stands still come to rest")
    before, begun = [wake_ups(pid) for pid in processes[1:]], time.monotonic()
    time.sleep(2)
    woken, seconds = [now - then for now, then in zip((wake_ups(pid) for pid in processes[1:]), before)], time.monotonic() - begun
    os.kill(processes[0], signal.SIGCONT)
    check(max(woken) <= 100 * seconds, "idle nodes sleep", f"wake-ups in {seconds:.1f} s: {woken}")
    run.process.send_signal(signal.SIGINT)
    run.check({130}, "a run that was idle")


def test_silence(folder):
    """A node that is stopped is named after three seconds, with what may wait for it; the run goes on with it."""
    run = Run(folder, MODELS / "bench/philosophers.bip", "Table(8)", "--nodes", "4", "--seed", "5", "--limit", "100000000")
    processes = run.nodes(4)
    time.sleep(0.3)
    os.kill(processes[1], signal.SIGSTOP)
    run.wait_for("may wait for it")
    time.sleep(0.5)
    check(not run.is_over(), "silence ends no run")
    os.kill(processes[1], signal.SIGCONT)
    run.wait_for("is heard again")
    size = run.trace.stat().st_size
    # It is written by 64 KiB.
    check(until(lambda: run.trace.stat().st_size > size), "the run goes on", f"{size} bytes of the trace before, and after")
    run.process.send_signal(signal.SIGINT)
    run.check({130}, "a node that is stopped for a while")
    told = re.findall(r"bipc: node `(\d)` (gives no sign|is heard again)", run.err)
    check(told == [("2", "gives no sign"), ("2", "is heard again")], "silence is told once, and its end", run.err)
    check(f"gives no sign for 3 s: its process {processes[1]} is stopped\n  at home there: ROOT." in run.err, "why it is silent is told", run.err)
    waiting = re.search(r"  may wait for it: (.*)", run.err)
    check(waiting is not None and "ROOT." in waiting[1], "what may wait is told", run.err)


LONG_ACTIONS = """@cpp(include="long.hpp")
package long_actions
  extern function int work_for(const int milliseconds)
  port type P()
  connector type Two(P p, P q)
    define p q
  end
  atom type A(int milliseconds)
    data int n = 0
    export port P go()
    place S
    initial to S
    on go from S to S do { n = n + work_for(milliseconds); }
  end
  compound type Root(int milliseconds)
    component A a(milliseconds), b(0)
    connector Two k(a.go, b.go)
  end
end
"""


def test_long_actions(folder):
    """An action that ends before the limit is no silence; a longer one is named, ends, and the run goes on to its limit."""
    (folder / "long_actions.bip").write_text(LONG_ACTIONS)
    (folder / "long.hpp").write_text("#pragma once\n#include <chrono>\ninline int work_for(int milliseconds) {\n  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(milliseconds);\n"
                                     "  while (std::chrono::steady_clock::now() < until) {\n  }\n  return 1;\n}\n")
    # The limit is 3 s of silence: seconds are left for what a loaded machine adds on both sides.
    for milliseconds, steps in ((1000, 4), (6000, 1)):
        run = Run(folder, folder / "long_actions.bip", f"Root({milliseconds})", "--nodes", "2", "--seed", "1", "--limit", str(steps))
        run.check({0}, f"an action of {milliseconds} ms")
        check(("gives no sign" in run.err) == (milliseconds > 3000), f"an action of {milliseconds} ms", run.err)
        if milliseconds > 3000:
            check("is running: an action" in run.err and "ROOT.b" in run.err, "a long action is told", run.err)


def test_orphans(folder):
    run = Run(folder, MODELS / "bench/ring.bip", "Ring(9)", "--nodes", "3")
    processes = run.nodes(3)
    time.sleep(0.2)
    run.process.kill()
    run.end()
    check(until(lambda: not any(is_alive(pid) for pid in processes)), "nodes end with their launcher")
    for left in sockets():
        for file in left.iterdir():
            file.unlink()
        left.rmdir()


def test_checkpoints(folder, draws, runs):
    """A node is killed between checkpoints; the run goes on from the last one, on more nodes, and again from one that a signal asked for."""
    for k, (name, root) in enumerate(runs * [("bench/philosophers", "Table(8)"), ("timed/train_gate", None)]):
        model = MODELS / f"{name}.bip"
        first, second = folder / "first.checkpoint", folder / "second.checkpoint"
        run = Run(folder, model, root, "--nodes", "3", "--seed", str(k), "--checkpoint", "150ms", "--checkpoint-file", str(first))
        processes = run.nodes(3)
        until(first.exists)
        time.sleep(draws.random() * 0.4)
        os.kill(draws.choice(processes), signal.SIGKILL)
        run.check({1}, "a node is killed after a checkpoint")
        check(first.exists() and f"--resume {first}" in run.err, "how to go on is told", run.err)
        run = Run(folder, model, root, "--nodes", str(2 + 3 * (k // 2)), "--seed", str(k), "--resume", str(first), "--checkpoint-file", str(second))
        run.resumed = first
        run.nodes(2 + 3 * (k // 2))
        until(lambda: catches(run.process.pid, signal.SIGUSR1))
        time.sleep(0.3)
        run.process.send_signal(signal.SIGUSR1)
        until(lambda: second.exists() or run.is_over())
        run.process.send_signal(signal.SIGINT)
        run.check({130}, "a resumed run")
        check(second.exists(), "a signal asks for a checkpoint", run.err)
        run = Run(folder, model, root, "--nodes", "4", "--seed", str(k), "--limit", "500", "--resume", str(second))
        run.resumed = second
        run.check({0}, "a run that was resumed twice")
        first.unlink()
        second.unlink()


def cpu(pid):
    """Nanoseconds of all threads of a process."""
    return sum(int((task / "schedstat").read_text().split()[0]) for task in pathlib.Path(f"/proc/{pid}/task").iterdir())


def come_to_rest(processes):
    """Waits until the processes take less than a hundredth of a processor."""
    def rest():
        before = [cpu(pid) for pid in processes]
        time.sleep(0.5)
        return all(cpu(pid) - then < 5_000_000 for pid, then in zip(processes, before))
    return until(rest, 5 * LONG)


def test_unwritten(folder):
    """While a node or the launcher stands still, the others go on until what they say of their steps fills its room, and no further; then all go on to the exact limit."""
    # Programs with sanitizers are too slow for as many steps as fill it, if only their interactions are told.
    most, limit = 64 << 20, 20_000_000 if PATIENCE == 1 else 1_000_000
    for who, how, codes in (("node", signal.SIGCONT, {0}), ("node", signal.SIGKILL, {1}), ("node, go-on", signal.SIGKILL, {0, 1}), ("launcher", signal.SIGCONT, {0})):
        options = ["--on-loss=go-on"] if who.endswith("go-on") else []
        run = Run(folder, MODELS / "bench/pingpong.bip", "Pairs(64)", "--nodes", "4", "--seed", "3", "--limit", str(limit), *options)
        processes = run.nodes(4)
        silent = run.process.pid if who == "launcher" else processes[1]
        os.kill(silent, signal.SIGSTOP)
        what = f"the {who} stands still, then signal {int(how)}"
        check(come_to_rest([pid for pid in processes if pid != silent]), f"{what}: the others wait")
        check(run.process.poll() is None, f"{what}: the run has not ended")
        os.kill(silent, how)
        steps = run.check(codes, what)
        check(steps == limit or (how == signal.SIGKILL and not options), f"{what}: the limit is reached", run.out + run.err)
        held = re.search(r"^bytes of steps before they were written: (\d+) at most$", run.err, re.M)
        # Three of four nodes fill theirs; each may be above it by what it says at once.
        check(held is not None and int(held[1]) <= most + (1 << 20) and (who == "launcher" or PATIENCE != 1 or int(held[1]) > most // 2), f"{what}: what waits is bounded", run.err)


def test_credit(folder):
    """A node that takes all steps alone is given what the other one does not need, while the launcher is far behind."""
    place = folder / "alone.place"
    place.write_text("node 1\nnode 2\n* on 1\n")
    for seed in range(4):
        run = Run(folder, MODELS / "bench/pingpong.bip", "Pairs(256)", "--placement", str(place), "--seed", str(seed), "--limit", "250000")
        check(run.check({0}, "one node takes all steps") == 250000, "one node takes all steps: the limit is exact", run.out + run.err)


def test_many_steps(folder):
    """Local steps of a run that writes none are taken many at once: the limit is exact, and a checkpoint is a state from which other nodes go on."""
    place = folder / "alone.place"
    place.write_text("node 1\nnode 2\n* on 1\n")
    for model, root, policy in (("philosophers", "Table(12)", "uniform"), ("philosophers", "Table(12)", "fair"), ("ring", "Ring(9)", "uniform"), ("pingpong", "Pairs(8)", "first")):
        path = MODELS / "bench" / f"{model}.bip"
        command = [BIPC, "run", "--engine=distributed", "--silent", "--placement", str(place), "--seed", "3", "--policy", policy, "--root", root]
        done = subprocess.run([*command, "--limit", "1234567", str(path)], capture_output=True, text=True)
        check(done.returncode == 0 and "limit: 1234567 steps" in done.stdout, f"{model}, {policy}: the limit is exact", done.stdout + done.stderr)
        saved = folder / "many.checkpoint"
        process = subprocess.Popen([*command, "--checkpoint", "100ms", "--checkpoint-file", str(saved), str(path)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        until(saved.exists)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=LONG)
        check(process.returncode == 130 and saved.exists(), f"{model}, {policy}: it is interrupted after a checkpoint", out + err)
        run = Run(folder, path, root, "--nodes", "4", "--seed", "3", "--limit", "2000", "--resume", str(saved))
        run.resumed = saved
        run.check({0}, f"{model}, {policy}: four nodes go on")
        check(re.search(r"^frames .* refused 0;", run.err, re.M) is not None, f"{model}, {policy}: no message is refused", run.err)
        saved.unlink()


def test_lines(folder):
    """Step lines, which the launcher makes of the interactions that nodes send, are those of the recorded run; so are JSON lines. With time and with C++ nodes make them."""
    (folder / "long_actions.bip").write_text(LONG_ACTIONS)
    (folder / "long.hpp").write_text("#pragma once\ninline int work_for(int milliseconds) { return milliseconds + 1; }\n")
    cases = [(MODELS / f"{name}.bip", root) for name, root in (
        ("classic/gas_station", None), ("classic/sensor_broadcast", None), ("classic/bus_priority", None), ("classic/atm", None), ("classic/two_phase_commit", None),
        ("bench/pingpong", "Pairs(8)"), ("bench/philosophers", "Table(12)"), ("chance/craps", None), ("timed/train_gate", None))]
    for k, (model, root) in enumerate([*cases, (folder / "long_actions.bip", "Root(3)")]):
        names = ["--root", root] if root else []
        # Steps in parts and steps as a whole, as places or by compiled code.
        for nodes, options in ((3, []), (1, ["-O", "2"]), (4, ["--split-above", "1", "--on-loss=go-on"])):
            trace = folder / "lines.trace"
            for lines, traced in (("steps", "binary"), ("json", "json")):
                command = [BIPC, "run", "--engine=distributed", "--nodes", str(nodes), "--seed", str(k), "--limit", "400", *options, "--trace", trace, "--trace-format", traced, *names, model]
                done = subprocess.run(command, capture_output=True, text=True)
                what = f"{model.stem} on {nodes} nodes, {lines}"
                written = [line for line in done.stdout.splitlines() if line.startswith(("#", '{"step"'))]
                if not check(done.returncode in (0, 3) and len(written) > 0, f"{what}: it runs", f"exit {done.returncode}\n{done.stdout}{done.stderr}"):
                    continue
                if lines == "json":
                    check(written == [line for line in trace.read_text().splitlines() if line.startswith('{"step"')], f"{what}: the trace has the lines of standard output")
                    check(all(re.search(r',"node":"\d"}$', line) for line in written), f"{what}: each line names its node", done.stdout)
                    continue
                check(all(re.search(r"  @\d$", line) for line in written), f"{what}: each line names its node", done.stdout)
                replay = subprocess.run([BIPC, "replay", "--recorded", trace, *names, model], capture_output=True, text=True)
                again = [line for line in replay.stdout.splitlines() if line.startswith("#")]
                check(replay.returncode == 0 and [re.sub(r"  @\d$", "", line) for line in written] == again, f"{what}: the lines are those of the recorded run", done.stdout + replay.stdout + replay.stderr)


def test_frames(folder):
    """A frame takes all messages that are ready together: with 100 interactions in flight between two nodes there are some 60 messages to a frame."""
    place = folder / "two.place"
    place.write_text("node 1\nnode 2\nping[*] on 1\n* on 2\n")
    command = [BIPC, "run", "--silent", "--stats", "--engine=distributed", "--placement", str(place), "--seed", "1", "--limit", "20000", "--root", "Pairs(100)", str(MODELS / "bench/pingpong.bip")]
    done = subprocess.run(command, capture_output=True, text=True)
    said = re.search(r"messages (\d+)[^\n]*\nframes (\d+)", done.stderr)
    check(done.returncode == 0 and said is not None, "100 in flight run to their limit", done.stdout + done.stderr)
    messages, frames = (int(word) for word in said.groups())
    check(messages == 40000 and frames * 5 < messages, f"frames take what is ready together: {frames} frames for {messages} messages", done.stderr)
    check_processor_use(done.stderr, 20000)


def check_processor_use(said, steps):
    """CPU ns/step is that of all processes; nodes take most of it, and one that begins no step has none."""
    a_step = re.search(r"CPU ns/step ([\d.]+)\n", said)
    used = re.search(r"CPU seconds of the nodes: ([\d.]+) ([\d.]+); of the launcher: ([\d.]+)\nCPU ns/step of the nodes: ([\d.-]+) ([\d.-]+)\n", said)
    if not check(a_step is not None and used is not None, "--stats tells the CPU of each node", said):
        return
    nodes, launcher = [float(used[1]), float(used[2])], float(used[3])
    check(min(nodes) > 0, "each node takes CPU", said)
    # Three rounded terms.
    check(abs(float(a_step[1]) * steps / 1e9 - sum(nodes) - launcher) < 0.002, "CPU ns/step is that of the nodes and the launcher", said)
    check(used[5] == "-" and abs(float(used[4]) * steps / 1e9 - nodes[0]) < 0.001, "CPU ns/step of a node is of the steps that it began", said)


def test_bench(folder):
    """The benchmark comes to its end: a message and its answer for each step between two nodes, and a figure in each row."""
    written = folder / "bench.json"
    done = subprocess.run([ROOT / "tools/bench/distributed", "--quick", "--steps", "100", "--json", written], capture_output=True, text=True, env={**os.environ, "BUILD": str(BUILD)})
    if not check(done.returncode == 0, "tools/bench/distributed --quick", done.stdout + done.stderr):
        return
    rows = json.loads(written.read_text())
    pairs, market = rows["messages"][0], rows["messages"][1]
    check(pairs["ours"] == pairs["split"] == pairs["three_layers"] == 2 and pairs["as_processes"] == 4, "messages of pairs", done.stdout)
    check(2 <= market["split"] <= market["ours"] < market["three_layers"], "messages of clients that meet any server", done.stdout)
    on_processes = rows["processes"]
    check(on_processes["in_flight"][0]["messages"] == 2, "messages on processes", done.stdout)
    check({row["format"] for row in on_processes["traced"]} == {"binary", "json"} and len(on_processes["local"]) == 1, "local steps", done.stdout)
    # With no delay, 36 interactions take less than two starts differ by: what they took may come out below 0.
    check(on_processes["far"][0]["interactions"] == 40, "steps through a relay", done.stdout)


def test_errors(folder):
    """A network that is not there is named, with the package; other commands do not miss it."""
    moved = folder / "alone"
    moved.mkdir()
    (moved / "bipc").symlink_to(BIPC)
    copy = moved / "copy"
    copy.write_bytes(pathlib.Path(BIPC).resolve().read_bytes())
    copy.chmod(0o755)
    done = subprocess.run([copy, "run", "--engine=distributed", "--backend=interp", str(MODELS / "classic/smokers.bip")], capture_output=True, text=True)
    check(done.returncode == 2 and "libzmq3-dev" in done.stderr, "no network: what is missing is named", done.stdout + done.stderr)
    maps = subprocess.run(["ldd", BIPC], capture_output=True, text=True).stdout
    check("libzmq" not in maps, "only runs on several processes load libzmq", maps)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--runs", type=int, default=2)
    options = parser.parse_args()
    if not (BUILD / "libbipc_zmq.so").exists():
        print("skipped: runs on several processes: libzmq3-dev was not there when bipc was built\n0 passed, 0 failed")
        return 0
    draws = random.Random(7)
    before = sockets()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        test_models(folder, options.runs)
        test_fault(folder)
        test_kill(folder, draws, options.runs)
        test_interrupt(folder, draws)
        test_idle(folder)
        test_silence(folder)
        test_long_actions(folder)
        test_orphans(folder)
        test_checkpoints(folder, draws, options.runs)
        test_unwritten(folder)
        test_credit(folder)
        test_many_steps(folder)
        test_lines(folder)
        test_frames(folder)
        test_errors(folder)
        # It compares with programs that a sanitized build has no libraries for.
        if PATIENCE == 1:
            test_bench(folder)
    check(sockets() <= before, "no socket is left")
    print(f"{test_hosts.passed} passed, {test_hosts.failed} failed")
    return 1 if test_hosts.failed else 0


if __name__ == "__main__":
    sys.exit(main())
