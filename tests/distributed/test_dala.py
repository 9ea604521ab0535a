#!/usr/bin/env python3
"""Dala on three hosts: six of its modules with their codels, the rover a process of its own, and cables that are pulled in the middle of the mission.

    tests/distributed/test_dala.py [--loopback] [--keep DIR]

`drive` has the wheels, the laser and the navigation, `eyes` the camera, whose codel runs beside the other steps (`async`), and `base` the executive and the clock. Each
host is a network namespace behind the relay of test_hosts.py (loopback where namespaces are not permitted). The rover (models/dala/mission/rover.cpp) moves by the wall clock as it was
last told, whatever becomes of its hosts, and writes down what is so: it is judged by that record. A cable is out until the launcher has reported the silent host: the rover has to stand by then, for
`drive` stops it, has to go on when the cable is in again, and to reach its goal. Prints "N passed, N failed" at the end.
"""
import argparse
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import test_hosts
from test_hosts import BIPC, BUILD, LONG, ROOT, Process, check, until

DALA = ROOT / "models/dala"
MODULES = ("laserrf", "aspect", "ndd", "rflex", "pom", "viam")
test_hosts.NODES, test_hosts.NAMES = 3, ["base", "eyes", "drive"]
BASE, EYES, DRIVE = range(3)
GOAL = (3.2, 0.4)
NOW, X, Y, V, DRIVEN = range(5)
MOVES = 0.02  # m/s
# The goal is known on each host: requests of an executive without rules carry no values.
CODELS = """#include "mission_codels.cpp"

#include <cstdio>

namespace {
const bool has_goal = (request_input("NDD.GoTo", "%g %g"), request_input("NDD.SetSpeed", "0.5"), true);
}

std::string executive_request() {
  static const char* const kRequests[] = {"POM.Init", "RFLEX.Init", "LaserRF.Init", "Aspect.Init", "NDD.Init", "VIAM.Init", "NDD.SetParams", "NDD.SetSpeed",
                                          "LaserRF.StartAcquisition", "Aspect.BuildMap", "VIAM.AcquireContinuous", "RFLEX.TrackSpeedStart", "NDD.GoTo"};
  static unsigned asked = 0, ticks = 0;
  return ++ticks %% 8 == 0 && asked < std::size(kRequests) ? kRequests[asked++] : "";
}
void executive_answer(const char* module, const char* service, const char* report) {
  std::printf("%%s.%%s: %%s\\n", module, service, report);
  std::fflush(stdout);
}
void executive_reply(const char* module, const char* service, const char* report) {
  std::printf("%%s.%%s ends: %%s\\n", module, service, report);
  std::fflush(stdout);
}
""" % GOAL


def run(folder, *command):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{command}: {done.stdout[-2000:]}{done.stderr[-3000:]}")


def facts_of(modules):
    """What dala.yields says of these modules."""
    lines = []
    for line in (DALA / "dala.yields").read_text(encoding="utf-8").splitlines():
        words = line.split()
        if words[:1] == ["codel"] and not words[1].lower().startswith(modules):
            continue
        if words[:1] == ["task"]:
            posters = [poster for poster in words[3:] if poster.split(".")[0].lower() in modules]
            if words[1].split(".")[0].lower() not in modules or not posters:
                continue
            line = " ".join([*words[:3], *posters])
        lines.append(line)
    # A picture takes its time, beside all else.
    return "\n".join([*lines, "codel viamAcquireContinuousMain async 100 ms", ""])


def generate(folder):
    for name in ("world.hpp", "camera.hpp", "terrain.hpp", "vision.hpp", "bus.hpp", "rover.cpp"):
        shutil.copy(DALA / "mission" / name, folder / name)
    shutil.copy(DALA / "mission/dala_codels.cpp", folder / "mission_codels.cpp")
    (folder / "dala_codels.cpp").write_text(CODELS, encoding="utf-8")
    (folder / "dala.yields").write_text(facts_of(MODULES), encoding="utf-8")
    run(folder, "g++", "-std=c++20", "-O1", "rover.cpp", "-o", "rover")
    run(folder, BIPC, "genom", "--executive", "--skeleton", "--yields", "dala.yields", *(str(DALA / f"{name}.gen") for name in MODULES), "-o", "dala.bip")


class RoverLost(Exception):
    """The rover has ended, or writes nothing: there is nothing to judge."""


class Rover:
    def __init__(self, folder, seconds=30):
        self.record, self.seconds = folder / "record", seconds
        self.process = subprocess.Popen(["./rover", "bus", "record", "0", "0"], cwd=folder, stdin=subprocess.PIPE)
        self.wait_for(self.record.exists, "a record")

    def wait_for(self, condition, what):
        """Returns what the condition gives, when it gives something; raises RoverLost when it cannot come any more."""
        end = time.monotonic() + self.seconds
        while not (found := condition()):
            if self.process.poll() is not None:
                raise RoverLost(f"the rover ended with exit code {self.process.returncode} before it wrote {what}")
            if time.monotonic() > end:
                raise RoverLost(f"the rover has not written {what} within {self.seconds} s")
            time.sleep(0.01)
        return found

    def rows(self):
        return [tuple(map(float, line.split())) for line in self.record.read_text(encoding="utf-8").splitlines() if line.count(" ") == 12]

    def row(self):
        return self.wait_for(self.rows, "a row of its record")[-1]

    def wait_until(self, holds, seconds):
        end = time.monotonic() + seconds
        while not holds(self.row()) and time.monotonic() < end:
            if self.process.poll() is not None:
                raise RoverLost(f"the rover ended with exit code {self.process.returncode} in the middle of the mission")
            time.sleep(0.02)
        return holds(self.row())

    def end(self):
        self.process.stdin.close()
        try:
            self.process.wait(LONG)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise RoverLost(f"the rover did not end within {LONG:.0f} s") from None


def check_waits():
    """A rover that ends at once, writes nothing, or ends on its way is reported; nothing waits for it without limit."""
    for script, words in (("exit 3", "ended with exit code 3 before it wrote a record"), ("exec cat", "has not written a record within"),
                          ("> record; exec cat", "has not written a row"), ("echo 0 0 0 0 0 0 0 0 0 0 0 0 0 > record; exit 4", "exit code 4 in the middle")):
        with tempfile.TemporaryDirectory() as name:
            folder, said, rover = pathlib.Path(name), "", None
            (folder / "rover").write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
            (folder / "rover").chmod(0o755)
            try:
                rover = Rover(folder, 1 if script == "exec cat" else LONG)
                rover.seconds = 1 if "cat" in script else LONG
                rover.wait_until(lambda row: False, LONG)
            except RoverLost as lost:
                said = str(lost)
            check(words in said, f"a rover that does `{script}` is reported", said)
            if rover is not None:
                rover.end()


def pull(hosts, rover, nodes, node, text):
    """The cable of the node is out until the launcher and the rover's node have said so."""
    name, driver = test_hosts.NAMES[node], nodes[DRIVE]
    if not check(rover.wait_until(lambda row: row[V] > 0.1, 5 * LONG), f"the rover drives before the cable of `{name}` is pulled", text()):
        return
    stops, starts = driver.text.count("`safe_stop` was called"), driver.text.count("steps end again after")
    for link in hosts.numbers_of(node):
        hosts.tell(f"cut {link} 600000")
    check(nodes[BASE].wait_for(f"`{name}` gives no sign for 3 s"), f"{name}: who is silent is reported", text())
    check(until(lambda: driver.text.count("`safe_stop` was called") > stops) and "no step has ended for" in driver.text, f"{name}: `drive` says that it stops the rover", text())
    rover.wait_until(lambda row: row[V] < MOVES, LONG)
    time.sleep(0.5)
    stood = rover.row()
    check(stood[V] < MOVES, f"{name}: the rover stands, and moves with {stood[V]} m/s", text())
    for link in hosts.numbers_of(node):
        hosts.tell(f"cut {link} 0")
    check(nodes[BASE].wait_for(f"`{name}` is heard again"), f"{name}: that it is back is reported", text())
    check(rover.wait_until(lambda row: row[DRIVEN] > stood[DRIVEN] + 0.05, 5 * LONG), f"{name}: the rover goes on", text())
    check(driver.text.count("steps end again after") > starts, f"{name}: `drive` says that it goes on", text())


def mission(folder, hosts):
    generate(folder)
    rover = Rover(folder)
    place = "".join(f"node {name} host {address}\n" for name, address in zip(test_hosts.NAMES, hosts.real))
    place += "".join(f"{module} on drive\n" for module in ("LaserRF", "Aspect", "NDD", "RFLEX", "POM")) + "VIAM on eyes\n* on base\n"
    deployed = test_hosts.deploy(folder, hosts, "robot", folder / "dala.bip", None, place)
    nodes = {}
    for node in (DRIVE, EYES, BASE):
        words = ["env", f"DALA_ROVER={folder / 'bus'}", BIPC, "node", str(deployed / test_hosts.NAMES[node]), "--stall-after", "500ms" if node == DRIVE else "0", "--lost-after", "120s"]
        nodes[node] = Process(hosts.command(node, words + (["--silent", "--stats", "--seed", "1", "--policy", "fair"] if node == BASE else [])), folder)

    def text():
        return "".join(f"---- {test_hosts.NAMES[node]}: exit {one.process.returncode}\n{one.text[-3000:]}" for node, one in sorted(nodes.items()))

    try:
        drive(hosts, rover, nodes, text)
    except RoverLost as lost:
        check(False, str(lost), text())
    finally:
        for one in nodes.values():
            if one.process.poll() is None:
                one.process.kill()
            one.end(LONG)
        if rover.process.poll() is None:
            rover.process.kill()
            rover.process.wait()


def drive(hosts, rover, nodes, text):
    for node in (EYES, DRIVE):
        pull(hosts, rover, nodes, node, text)
    check(nodes[DRIVE].wait_for("NDD.GoTo ends: OK", 10 * LONG), "the mission is over", text())
    last = rover.row()
    check(((last[X] - GOAL[0]) ** 2 + (last[Y] - GOAL[1]) ** 2) ** 0.5 < 0.4, f"the rover is at its goal, not at {last[X]}, {last[Y]}", text())
    nodes[BASE].process.send_signal(signal.SIGINT)
    check(nodes[BASE].end(LONG) == 130, "the run is interrupted", text())
    for node in (EYES, DRIVE):
        nodes[node].end(LONG)
    steps = re.search(r"interrupted: (\d+) steps", nodes[BASE].text)
    print(f"{steps[1] if steps else 0} steps, {last[NOW]:.1f} s, {last[DRIVEN]:.2f} m")
    rover.end()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--loopback", action="store_true")
    parser.add_argument("--keep", help="a folder to work in")
    parser.add_argument("--waits", action="store_true", help="only that the test ends when the rover does not move or write")
    options = parser.parse_args()
    check_waits()
    if options.waits:
        print(f"{test_hosts.passed} passed, {test_hosts.failed} failed")
        return 1 if test_hosts.failed else 0
    if not (BUILD / "libbipc_zmq.so").exists():
        print("skipped: runs on several hosts: libzmq3-dev was not there when bipc was built\n0 passed, 0 failed")
        return 0
    in_namespaces = not options.loopback and test_hosts.has_namespaces()
    if not in_namespaces:
        print("over loopback: no network namespaces here")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(options.keep or name).resolve()
        folder.mkdir(exist_ok=True)
        hosts = test_hosts.Hosts(folder, 1, in_namespaces)
        try:
            mission(folder, hosts)
        except RoverLost as lost:
            check(False, str(lost))
        finally:
            hosts.end()
    print(f"{test_hosts.passed} passed, {test_hosts.failed} failed")
    return 1 if test_hosts.failed else 0


if __name__ == "__main__":
    sys.exit(main())
