#!/usr/bin/env python3
"""Runs on several hosts: `bipc deploy` and `bipc node`, four nodes in four network namespaces (over loopback where those are not permitted) that reach each
other through a relay only (relay.cpp), which delays, cuts and resets their connections.

    tests/distributed/test_hosts.py [--faults N] [--runs N] [--loopback] [--seed N]

Every run writes a binary trace, which `bipc replay --recorded` must accept. A sample of faults is the default; `--faults 1000` is the long test: so many while all steps
are of several nodes, and the sample while most are of one. Prints "N passed, N failed" at the end.
"""
import argparse
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests"))
from patience import LONG, PATIENCE, until  # noqa: E402

BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
MODEL, TABLE = ROOT / "models/bench/philosophers.bip", "Table(16)"
NODES = 4
MOST_LOCAL = 40  # faults of the run whose steps are mostly of one node: its trace grows by a million steps in a tenth of a second
NAMES = ["lab", "field", "mast", "rover"]
OTHER_MODEL = """package m
  port type P()
  connector type One(P p)
    define p
  end
  atom type A()
    export port P go()
    place S
    initial to S
    on go from S to S
  end
  compound type Root()
    component A a()
    component A b()
    connector One k(a.go)
    connector One l(b.go)
  end
end
"""

# A rover in logical time: its camera's pictures take 25 ms, on a node of their own, and the wheels go on meanwhile.
ROVER = """package rover
  port type P()
  port type Picture(int number)
  connector type Two(P p, P q)
    define p q
  end
  connector type Send(Picture from_, Picture to_)
    define from_ to_
    on from_ to_ down { to_.number = from_.number; }
  end
  atom type Camera()
    clock x unit millisecond
    data int number = 0
    export port P look()
    export port Picture send(number)
    place IDLE, SEES
    initial to IDLE
    @async(budget="25ms")
    on look from IDLE to SEES do { number = number + 1; }
    on send from SEES to IDLE eager
  end
  atom type Brain()
    data int number = 0
    export port P look()
    export port Picture get(number)
    place THINKS, WAITS
    initial to THINKS
    on look from THINKS to WAITS
    on get from WAITS to THINKS
  end
  atom type Wheels()
    clock t unit millisecond
    port P turn()
    place DRIVE
    initial to DRIVE do { t = 0; }
    on turn from DRIVE to DRIVE provided (t >= 10) eager do { t = 0; }
  end
  compound type Root()
    component Brain brain()
    component Camera camera()
    component Wheels wheels(), spare()
    connector Two look(brain.look, camera.look)
    connector Send send(camera.send, brain.get)
  end
end
"""

passed = failed = 0


def check(is_right, what, details=""):
    global passed, failed
    passed += bool(is_right)
    if not is_right:
        failed += 1
        print(f"FAILED: {what}\n{details}", flush=True)
    return is_right


def has_namespaces():
    done = subprocess.run(["unshare", "-n", "ip", "link", "add", "bipcprobe", "type", "veth"], capture_output=True)
    return done.returncode == 0


def run_ip(*words):
    subprocess.run(["ip", *words], check=True, capture_output=True)


def free_ports(address, count):
    held = [socket.socket() for _ in range(count)]
    for one in held:
        one.bind((address, 0))
    ports = [one.getsockname()[1] for one in held]
    for one in held:
        one.close()
    return ports


def free_network():
    """The first byte pairs of addresses that no other test on this machine has."""
    taken = subprocess.run(["ip", "-o", "address"], check=True, capture_output=True, text=True).stdout
    first = os.getpid() % 100
    return next(two for two in (f"10.{77 + (first + k) % 100}" for k in range(100)) if f" {two}." not in taken)


class Hosts:
    """Four places for nodes, and the relay between them. A node with a larger number connects to those with smaller ones, the launcher beside the first to all."""

    def __init__(self, folder, seed, in_namespaces):
        self.in_namespaces = in_namespaces
        self.keepers, self.devices = [], []
        tag = f"{os.getpid() % 100000:05}"
        if in_namespaces:
            two = free_network()
            for k in range(NODES):
                keeper = subprocess.Popen(["unshare", "-n", "sleep", "infinity"])
                self.keepers.append(keeper)
                while os.readlink(f"/proc/{keeper.pid}/ns/net") == os.readlink("/proc/self/ns/net"):
                    time.sleep(0.005)
                outer, inner = f"bh{tag}{k}", f"bi{tag}{k}"
                run_ip("link", "add", outer, "type", "veth", "peer", "name", inner)
                self.devices.append(outer)
                run_ip("link", "set", inner, "netns", str(keeper.pid))
                run_ip("address", "add", f"{two}.{k}.1/24", "dev", outer)
                run_ip("link", "set", outer, "up")
                for words in (["address", "add", f"{two}.{k}.2/24", "dev", inner], ["link", "set", inner, "up"], ["link", "set", "lo", "up"]):
                    subprocess.run(["nsenter", "-n", "-t", str(keeper.pid), "ip", *words], check=True)
            self.real = [f"{two}.{k}.2:7701" for k in range(NODES)]
            self.seen = {(a, b): f"{two}.{a}.1:{7800 + b}" for a in range(NODES) for b in range(NODES) if a != b}
        else:
            # An address of this process: nobody else takes a port there while it is free.
            own = f"127.{os.getpid() >> 16 & 127 | 128}.{os.getpid() >> 8 & 255}.{os.getpid() & 255}"
            ports = free_ports(own, NODES + NODES * NODES)
            self.real = [f"{own}:{port}" for port in ports[:NODES]]
            self.seen = {(a, b): f"{own}:{ports[NODES + NODES * a + b]}" for a in range(NODES) for b in range(NODES) if a != b}
        program = folder / "relay"
        if not program.exists():
            subprocess.run(["c++", "-std=c++20", "-O1", str(ROOT / "tests/distributed/relay.cpp"), "-o", str(program)], check=True)
        self.links = list(self.seen)
        self.relay = subprocess.Popen([program, str(seed), *(f"{self.seen[link]}={self.real[link[1]]}" for link in self.links)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self.relay.stdout.readline() == "ready\n", "the relay does not start"

    def tell(self, line):
        self.relay.stdin.write(line + "\n")
        self.relay.stdin.flush()

    def numbers_of(self, node):
        return [k for k, link in enumerate(self.links) if node in link]

    def command(self, node, words):
        return (["nsenter", "-n", "-t", str(self.keepers[node].pid)] if self.in_namespaces else []) + words

    def end(self):
        self.relay.stdin.close()
        self.relay.wait(LONG)
        for keeper in self.keepers:
            keeper.kill()
            keeper.wait()
        for device in self.devices:
            subprocess.run(["ip", "link", "delete", device], capture_output=True)


def placement(addresses, shift=0):
    """Philosophers in order, and their forks so many nodes further: with 0 most steps are of one node."""
    text = "".join(f"node {name} host {address}\n" for name, address in zip(NAMES, addresses))
    for k, name in enumerate(NAMES):
        text += f"phil[{4 * k}..{4 * k + 4}] on {name}\nfork[{4 * k}..{4 * k + 4}] on {NAMES[(k + shift) % NODES]}\n"
    return text


def deploy(folder, hosts, name="robot", model=MODEL, root=TABLE, place=None):
    """Folders whose nodes see each other through the relay."""
    path = folder / f"{name}.place"
    path.write_text(place or placement(hosts.real))
    command = [BIPC, "deploy", "--placement", str(path), "-o", str(folder / name), *(["--root", root] if root else []), str(model)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    for a in range(NODES):
        seen = [hosts.real[b] if a == b else hosts.seen[a, b] for b in range(NODES)]
        text = path.read_text()
        for b in range(NODES):
            text = text.replace(f"node {NAMES[b]} host {hosts.real[b]}", f"node {NAMES[b]} host {seen[b]}")
        (folder / name / NAMES[a] / "model.place").write_text(text)
    return folder / name


class Process:
    def __init__(self, command, folder):
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder)
        self.pid, self.text = self.process.pid, ""
        self.readers = [threading.Thread(target=self.read, args=[file]) for file in (self.process.stdout, self.process.stderr)]
        for reader in self.readers:
            reader.start()

    def read(self, file):
        for line in file:
            self.text += line

    def wait_for(self, words, seconds=LONG):
        until(lambda: words in self.text or self.process.poll() is not None, seconds)
        return words in self.text

    def end(self, seconds):
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            self.text += "\n(it did not end)"
        for reader in self.readers:
            reader.join()
        return self.process.returncode


class Run:
    """Nodes of a deployment, started in the order given."""

    def __init__(self, folder, hosts, deployed, order, *options, others=()):
        self.folder, self.deployed, self.options = folder, deployed, options
        self.trace = folder / "run.trace"
        self.trace.unlink(missing_ok=True)
        self.nodes = {}
        for node in order:
            words = [BIPC, "node", str(deployed / NAMES[node])]
            words += ["--trace", str(self.trace), "--trace-format=binary", "--silent", "--stats", *options] if node == 0 else list(others)
            self.nodes[node] = Process(hosts.command(node, words), folder)
            time.sleep(0.05)

    def text(self):
        return f"{' '.join(self.options)}\n" + "".join(f"---- {NAMES[node]}: exit {one.process.returncode}\n{one.text}" for node, one in sorted(self.nodes.items()))

    def end(self):
        code = self.nodes[0].end(2 * LONG)
        for one in self.nodes.values():
            one.end(LONG)
        return code

    def check_trace(self, what):
        done = subprocess.run([BIPC, "replay", "--silent", "--recorded", str(self.trace), str(self.deployed / "lab/model.bsys")], capture_output=True, text=True)
        return check(done.returncode == 0 and "agree" in done.stdout, f"{what}: the trace is no run of the model", self.text() + done.stdout + done.stderr)

    def check(self, codes, what):
        code = self.end()
        check(code in codes, f"{what}: exit {code}", self.text())
        self.check_trace(what)


def test_order(folder, hosts, deployed, draws):
    """In any order, with a late one; all tell the same end."""
    for order in ([0, 1, 2, 3], [3, 1, 0, 2]):
        run = Run(folder, hosts, deployed, order, "--limit", "2000", "--seed", str(draws.randrange(1000)))
        run.check({0}, f"order {order}")
        check("limit: 2000 steps" in run.nodes[0].text, "the limit is exact", run.text())
        for node in (1, 2, 3):
            check("the run ended at the limit after 2000 steps" in run.nodes[node].text and run.nodes[node].process.returncode == 0, "the ends agree", run.text())


def test_end(folder, hosts, deployed):
    """A short run ends when it is over: every node confirms the last message, for which the launcher would wait a second in each run. A busy machine makes some runs as slow."""
    taken = []
    while len(taken) < 20 and not (taken and min(taken) < 0.9):
        run = Run(folder, hosts, deployed, [0, 1, 2, 3], "--limit", "10")
        run.check({0}, "a short run")
        seconds, there = (re.search(text, run.nodes[0].text) for text in (r"seconds ([\d.]+)", r"there after ([\d.]+)"))
        if not check(seconds and there, "a short run is measured", run.text()):
            return
        taken.append(float(seconds[1]) - float(there[1]))
    check(min(taken) < 0.9 * PATIENCE, "a short run ends at once", str(taken))


def test_late(folder, hosts, deployed):
    run = Run(folder, hosts, deployed, [0, 1, 2], "--limit", "100")
    check(run.nodes[0].wait_for("waiting for `rover`"), "who is missing is told", run.text())
    run.nodes[3] = Process(hosts.command(3, [BIPC, "node", str(deployed / NAMES[3])]), folder)
    run.check({0}, "a late node")


def test_faults(folder, hosts, deployed, faults, seed):
    """Random cuts, stalls, resets: nobody is lost, nothing is doubled, the run goes on until it is interrupted."""
    run = Run(folder, hosts, deployed, [0, 1, 2, 3], "--seed", str(seed), "--lost-after", "30s")
    run.nodes[1].wait_for("the run begins")
    hosts.tell(f"faults {faults} 60")
    line = hosts.relay.stdout.readline()
    check(line == f"done {faults}\n", "all faults were made", line)
    time.sleep(1)
    run.nodes[0].process.send_signal(signal.SIGINT)
    run.check({130}, f"{faults} faults")
    steps = re.search(r"interrupted: (\d+) steps", run.nodes[0].text)
    again = re.search(r"sent again (\d+)", run.nodes[0].text)
    check(steps and int(steps[1]) > 20 * faults, f"{faults} faults: the run goes on", run.text())
    check("lost" not in run.nodes[0].text.replace("--lost-after", ""), f"{faults} faults: nobody is lost", run.text())
    border = re.search(r"steps of several nodes (\d+)", run.nodes[0].text)
    print(f"{faults} faults: {steps and steps[1]} steps, {border and border[1]} of several nodes, {again and again[1]} frames sent again", flush=True)


def test_cut(folder, hosts, deployed):
    """All cables are out for three seconds: it is told at most, and goes on."""
    run = Run(folder, hosts, deployed, [0, 1, 2, 3], "--seed", "3")
    run.nodes[1].wait_for("the run begins")
    time.sleep(0.5)
    hosts.tell("cut all 3000")
    time.sleep(3)
    size = run.trace.stat().st_size
    check(run.nodes[0].process.poll() is None, "a cut of 3 s ends nothing", run.text())
    check(until(lambda: run.trace.stat().st_size > size + 65536), "the run goes on after a cut of 3 s", run.text())
    run.nodes[0].process.send_signal(signal.SIGINT)
    run.check({130}, "a cut of 3 s")
    check("R0030" not in run.nodes[0].text, "a cut of 3 s: nobody is lost", run.text())


def test_loss(folder, hosts, deployed, draws):
    for how in ("stop", "go-on"):
        victim = draws.randrange(1, NODES)
        run = Run(folder, hosts, deployed, [0, 1, 2, 3], "--seed", "4", "--lost-after", "3s", "--on-loss", how)
        run.nodes[1].wait_for("the run begins")
        time.sleep(0.3 + draws.random() * 0.5)
        os.kill(run.nodes[victim].pid, signal.SIGKILL)
        check(run.nodes[0].wait_for("gave no sign for ") or run.nodes[0].process.poll() is not None, "silence is told", run.text())
        if how == "go-on":
            time.sleep(0.5)
            if run.nodes[0].process.poll() is None:
                run.nodes[0].process.send_signal(signal.SIGINT)
        run.check({1} if how == "stop" else {1, 130}, f"a killed node, --on-loss={how}")
        check(f"R0030]: lost `{NAMES[victim]}`" in run.nodes[0].text, "who is lost is told", run.text())
        # In the launcher's time, by default it would be 10 s.
        silence = re.search(r"gave no sign for (\d+) s", run.nodes[0].text)
        check(silence and 3 <= int(silence[1]) < 10, "a loss is noticed after three beats", run.text())


def test_time(folder, hosts):
    """Logical time over hosts: the cable of the camera's node is out until it has been missed; the rover stops, says why, and goes on."""
    model = folder / "rover.bip"
    model.write_text(ROVER)
    place = "".join(f"node {name} host {address}\n" for name, address in zip(NAMES, hosts.real))
    place += "brain on lab\nspare on field\ncamera on mast\nwheels on rover\n"
    deployed = deploy(folder, hosts, "timed", model, None, place)
    run = Run(folder, hosts, deployed, [0, 1, 2, 3], "--seed", "7", "--lost-after", "60s", others=("--lost-after", "60s"))
    run.nodes[1].wait_for("the run begins")
    time.sleep(0.5)
    for link in hosts.numbers_of(2):
        hosts.tell(f"cut {link} 600000")
    check(run.nodes[0].wait_for("`mast` gives no sign for 3 s"), "why the rover stops is told", run.text())
    size = run.trace.stat().st_size
    time.sleep(0.5)
    check(run.trace.stat().st_size == size, "time stops", f"{size} {run.trace.stat().st_size}")
    for link in hosts.numbers_of(2):
        hosts.tell(f"cut {link} 0")
    check(run.nodes[0].wait_for("`mast` is heard again"), "that it goes on is told", run.text())
    until(lambda: run.trace.stat().st_size > size)
    time.sleep(0.5)
    run.nodes[0].process.send_signal(signal.SIGINT)
    run.check({130}, "a cut in logical time")
    steps = re.search(r"interrupted: (\d+) steps", run.nodes[0].text)
    check(run.trace.stat().st_size > size and "R0030" not in run.nodes[0].text, "it goes on", run.text())
    return int(steps[1]) if steps else 0


def test_cable(folder, hosts, deployed):
    """A node whose cable stays out is lost for the others, and ends by itself."""
    run = Run(folder, hosts, deployed, [0, 1, 2, 3], "--lost-after", "3s", others=("--lost-after", "3s"))
    run.nodes[1].wait_for("the run begins")
    time.sleep(0.3)
    for link in hosts.numbers_of(2):
        hosts.tell(f"cut {link} 600000")
    run.check({1}, "a cable that stays out")
    check("R0030]: lost `mast`" in run.nodes[0].text, "who is lost is told", run.text())
    check("no word of the launcher" in run.nodes[2].text and run.nodes[2].process.returncode == 1, "who is alone ends", run.text())
    hosts.tell("cut all 0")
    hosts.tell("break all 0")


def test_leave(folder, hosts, deployed):
    """A node that is ended says so; one that is started anew is not taken for the one before."""
    run = Run(folder, hosts, deployed, [0, 1, 2, 3])
    run.nodes[1].wait_for("the run begins")
    time.sleep(0.3)
    run.nodes[3].process.send_signal(signal.SIGTERM)
    run.check({1}, "a node that is ended")
    check("`rover` ended by signal 15" in run.nodes[0].text, "why a node left is told", run.text())
    run = Run(folder, hosts, deployed, [0, 1, 2, 3])
    run.nodes[1].wait_for("the run begins")
    time.sleep(0.3)
    os.kill(run.nodes[2].pid, signal.SIGKILL)
    run.nodes[2].end(LONG)
    anew = Process(hosts.command(2, [BIPC, "node", str(deployed / NAMES[2])]), folder)
    run.check({1}, "a node that is started anew")
    check("`mast` was started anew" in run.nodes[0].text, "that a node was started anew is told", run.text())
    anew.process.send_signal(signal.SIGTERM)
    check(anew.end(LONG) == 143, "a waiting node ends by a signal", anew.text)


def test_launcher(folder, hosts, deployed):
    """Nodes end when the launcher is gone, at once if another one knocks."""
    run = Run(folder, hosts, deployed, [0, 1, 2, 3], others=("--lost-after", "2s"))
    run.nodes[1].wait_for("the run begins")
    time.sleep(0.3)
    run.nodes[0].process.kill()
    run.end()
    for node in (1, 2, 3):
        check("no word of the launcher" in run.nodes[node].text and run.nodes[node].process.returncode == 1, "nodes end without their launcher", run.text())


def test_refused(folder, hosts, deployed):
    """Another model, other keys, a key that others can read."""
    other = deploy(folder, hosts, "other", root="Table(16)", place=placement(hosts.real).replace("phil[0..4] on lab", "phil[0..3] on lab\nphil[3] on field"))
    mixed = folder / "mixed"
    shutil.copytree(deployed, mixed)
    shutil.copy(other / "rover/model.place", mixed / "rover/model.place")
    run = Run(folder, hosts, mixed, [0, 1, 2, 3], "--limit", "100")
    check(run.nodes[0].wait_for("node `rover` has another model, placement or bipc, and is refused"), "another placement is refused", run.text())
    check(run.nodes[3].wait_for("`lab` has another model"), "who is refused knows", run.text())
    for one in run.nodes.values():
        one.process.send_signal(signal.SIGTERM)
    run.end()
    # Keys of another deployment: nobody hears it.
    shutil.rmtree(mixed / "rover")
    shutil.copytree(other / "rover", mixed / "rover")
    shutil.copy(deployed / "rover/model.place", mixed / "rover/model.place")
    run = Run(folder, hosts, mixed, [0, 1, 2, 3], "--limit", "100")
    check(run.nodes[0].wait_for("waiting for `rover`"), "another key is not heard", run.text())
    time.sleep(0.5)
    check("the run begins" not in run.text(), "another key takes no part", run.text())
    run.nodes[3].process.send_signal(signal.SIGTERM)
    run.nodes[3].end(LONG)
    run.nodes[3] = Process(hosts.command(3, [BIPC, "node", str(deployed / NAMES[3])]), folder)
    run.deployed = deployed
    run.check({0}, "the right key after a wrong one")
    refused = re.search(r"refused (\d+)", run.nodes[0].text)
    check(refused and int(refused[1]) > 0, "who is refused is counted", run.text())
    (mixed / "lab/key").chmod(0o644)
    done = subprocess.run([BIPC, "node", str(mixed / "lab")], capture_output=True, text=True)
    check(done.returncode == 2 and "others can read this key" in done.stderr, "a key that others can read is refused", done.stderr)
    for name in NAMES:
        check((deployed / name / "key").stat().st_mode & 0o777 == 0o600, "only its owner reads a key")
    done = subprocess.run([BIPC, "node", str(deployed / "field"), "--limit", "3"], capture_output=True, text=True)
    check(done.returncode == 2 and "`lab`" in done.stderr, "options of the run are the first node's", done.stderr)


def test_odd_bytes(folder, hosts, deployed, draws):
    """Whoever connects without a key and says anything is not heard, and nothing ends."""
    run = Run(folder, hosts, deployed, [0, 1, 2, 3], "--seed", "9")
    run.nodes[1].wait_for("the run begins")
    sent = 0
    host, port = hosts.seen[1, 0].split(":") if hosts.in_namespaces else hosts.real[0].split(":")
    for _ in range(40):
        try:
            with socket.create_connection((host, int(port)), timeout=2) as odd:
                odd.sendall(draws.choice([b"", b"\xff\0\0\0\0\0\0\0\1\x7f\3\1CURVE" + bytes(40)]) + draws.randbytes(draws.randrange(1, 3000)))
                sent += 1
        except OSError:
            pass
    time.sleep(0.3)
    run.nodes[0].process.send_signal(signal.SIGINT)
    run.check({130}, "odd bytes")
    refused = re.search(r"refused (\d+)", run.nodes[0].text)
    check(refused and int(refused[1]) > 0, f"odd bytes of {sent} connections are counted", run.text())
    print(f"odd bytes: {refused and refused[1]} refused of {sent} connections")


def test_cpp(folder, hosts):
    """The C++ of a model comes with it."""
    side = folder / "side"
    side.mkdir()
    (side / "twice.hpp").write_text("#pragma once\ninline int twice(int x) { return 2 * x; }\n")
    (side / "m.bip").write_text("""@cpp(include="twice.hpp")
package m
  extern function int twice(int)
  port type P(int v)
  connector type Two(P p, P q)
    define p q
    on p q down { q.v = p.v; }
  end
  atom type A()
    data int n
    export port P go(n)
    place S
    initial to S do { n = 1; }
    on go from S to S do { n = twice(n) % 1000; }
  end
  compound type Root()
    component A a()
    component A b()
    connector Two k(a.go, b.go)
  end
end
""")
    text = "".join(f"node {name} host {address}\n" for name, address in zip(NAMES, hosts.real))
    deployed = deploy(folder, hosts, "cpp", side / "m.bip", None, text + "a on field\n* on rover\n")
    shutil.rmtree(side)
    run = Run(folder, hosts, deployed, [2, 3, 0, 1], "--limit", "50", "--show-state")
    run.check({0}, "a model with C++")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--faults", type=int, default=40)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--loopback", action="store_true")
    parser.add_argument("--only", help="one test, by its name without `test_`")
    options = parser.parse_args()
    if not (BUILD / "libbipc_zmq.so").exists():
        print("skipped: runs on several hosts: libzmq3-dev was not there when bipc was built\n0 passed, 0 failed")
        return 0
    draws = random.Random(options.seed)
    in_namespaces = not options.loopback and has_namespaces()
    if not in_namespaces:
        # One line for whoever reads the sum: the tests below run, but on no network of their own.
        print("skipped: runs on several hosts: in network namespaces" + (" (--loopback)" if options.loopback else ", which are not permitted here") + "; over loopback in their place")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        hosts = Hosts(folder, options.seed, in_namespaces)
        try:
            deployed = deploy(folder, hosts)
            tests = {
                "order": lambda: test_order(folder, hosts, deployed, draws), "late": lambda: test_late(folder, hosts, deployed), "end": lambda: test_end(folder, hosts, deployed),
                "faults": lambda: test_faults(folder, hosts, deployed, min(options.faults, MOST_LOCAL), options.seed),
                "border_faults": lambda: test_faults(folder, hosts, deploy(folder, hosts, "crossed", place=placement(hosts.real, 1)), options.faults, options.seed),
                "cut": lambda: test_cut(folder, hosts, deployed),
                "loss": lambda: test_loss(folder, hosts, deployed, draws), "cable": lambda: test_cable(folder, hosts, deployed),
                "leave": lambda: test_leave(folder, hosts, deployed), "launcher": lambda: test_launcher(folder, hosts, deployed),
                "refused": lambda: test_refused(folder, hosts, deployed), "odd_bytes": lambda: test_odd_bytes(folder, hosts, deployed, draws),
                "cpp": lambda: test_cpp(folder, hosts), "time": lambda: test_time(folder, hosts),
            }
            for which, test in tests.items():
                if options.only in (None, which):
                    test()
        finally:
            hosts.end()
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
