#!/usr/bin/env python3
"""The start script and the systemd units that `bipc deploy` writes, executed: three nodes at loopback addresses, whose hosts are folders that a small `ssh` in
PATH stands for. It runs the command in a session of its own, which outlives it as on another machine: only the end of what it reads says that it is gone.

    tests/distributed/test_start.py

Units are checked by `systemd-analyze verify` if it is installed. Prints "N passed, N failed" at the end.
"""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

import test_hosts
from test_hosts import BIPC, BUILD, MODEL, check

TABLE = "Table(6)"
NAMES = ["lab", "field", "mast"]

SSH = """#!{python}
# ssh [-T] HOST COMMAND: as on another host, whose home is a folder.
import os, subprocess, sys
words = [word for word in sys.argv[1:] if word != "-T"]
host, command = words
home = os.path.join({homes!r}, host)
if not os.path.isdir(home):
    sys.exit(255)
session = subprocess.Popen(["sh", "-c", command], stdin=subprocess.PIPE, cwd=home, start_new_session=True)
if os.fork() == 0:
    while data := os.read(0, 65536):
        try:
            session.stdin.write(data)
            session.stdin.flush()
        except BrokenPipeError:
            break
    os._exit(0)
session.stdin.close()
sys.exit(session.wait())
"""


def free_port(address):
    with socket.socket(socket.AF_INET6 if ":" in address else socket.AF_INET) as held:
        held.bind((address, 0))
        return held.getsockname()[1]


def has_ipv6():
    try:
        return free_port("::1") > 0
    except OSError:
        return False


def hear_signals():
    """A shell cannot trap what was ignored when it began, as interrupts of background jobs are, or hangups under nohup."""
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)


class Hosts:
    """A deployment for three hosts, and their homes."""

    def __init__(self, folder):
        self.folder, self.homes = folder, folder / "homes"
        addresses = ["127.0.0.1", "::1" if has_ipv6() else "127.0.0.3", "127.0.0.2"]
        self.home = {name: self.homes / address for name, address in zip(NAMES, addresses)}
        for home in self.home.values():
            home.mkdir(parents=True)
        place = ""
        for name, address in zip(NAMES, addresses):
            host = f"[{address}]" if ":" in address else address
            place += f"node {name} host {host}:{free_port(address)}\n"
        for k, name in enumerate(NAMES):
            place += f"phil[{2 * k}..{2 * k + 2}] on {name}\nfork[{2 * k}..{2 * k + 2}] on {name}\n"
        (folder / "x.place").write_text(place)
        self.deploy()
        tools = folder / "tools"
        tools.mkdir()
        (tools / "ssh").write_text(SSH.format(python=sys.executable, homes=str(self.homes)))
        (tools / "ssh").chmod(0o755)
        self.environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "BIPC": BIPC}

    def deploy(self):
        command = [BIPC, "deploy", "--placement", "x.place", "-o", "robot", "--root", TABLE, str(MODEL)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder)
        assert done.returncode == 0, done.stdout + done.stderr

    def processes(self):
        """Those that have to do with the folders of this test, but for the start script and its ssh."""
        found = []
        for entry in pathlib.Path("/proc").iterdir():
            if not entry.name.isdigit():
                continue
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
                if os.readlink(entry / "cwd").startswith(str(self.homes)):
                    found.append(f"{entry.name}: {b' '.join(words).decode(errors='replace')}")
            except OSError:
                continue
        return found

    def run(self, *options, seconds=60, environment=None):
        return subprocess.run([self.folder / "robot/start", *options], capture_output=True, text=True, timeout=seconds, env=environment or self.environment, stdin=subprocess.DEVNULL)

    def start(self, *options):
        return subprocess.Popen([self.folder / "robot/start", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.environment, stdin=subprocess.DEVNULL,
                                preexec_fn=hear_signals)

    def check_ended(self, what):
        end = time.monotonic() + 20
        while self.processes() and time.monotonic() < end:
            time.sleep(0.02)
        check(not self.processes(), f"{what}: a process goes on", "\n".join(self.processes()))


def told(done):
    return f"exit {done.returncode}\n{done.stdout}{done.stderr}"


def test_run(hosts):
    """A run to its limit; words with spaces, quotes and dollars reach the first node as they are."""
    trace = "a run of 'today' at $5.trace"
    done = hosts.run("--silent", "--limit", "300", "--seed", "1", "--trace", trace, "--trace-format=binary")
    check(done.returncode == 0 and "limit: 300 steps" in done.stderr + done.stdout, "a run by the start script", told(done))
    check(done.stderr.count("the run ended at the limit after 300 steps") == 2, "the other nodes end with the run", told(done))
    path = hosts.home["lab"] / trace
    if check(path.exists(), "the trace has its name", told(done) + str(list(hosts.home["lab"].iterdir()))):
        replay = subprocess.run([BIPC, "replay", "--silent", "--recorded", str(path), str(hosts.folder / "robot/lab/model.bsys")], capture_output=True, text=True)
        check(replay.returncode == 0 and "agree" in replay.stdout, "the trace is a run of the model", told(replay))
    hosts.check_ended("a run to its limit")


def test_files(hosts):
    for name, home in hosts.home.items():
        target = home / "bipc-nodes"
        check(target.stat().st_mode & 0o777 == 0o700, f"only the owner enters the folder on the host of {name}")
        check((target / name / "key").stat().st_mode & 0o777 == 0o600, f"only the owner reads the key of {name}")
        check(sorted(path.name for path in target.iterdir()) == [name], f"the host of {name} has one node's folder")


def test_again(hosts):
    """Keys are new and C++ of an earlier deployment is gone after the next one, in another folder."""
    hosts.deploy()
    old = hosts.home["field"] / "my nodes/field/ffi"
    old.mkdir(parents=True)
    (old / "old.hpp").write_text("// of an earlier deployment\n")
    done = hosts.run("--silent", "--limit", "50", "--seed", "2", environment={**hosts.environment, "TARGET": "my nodes"})
    check(done.returncode == 0 and "limit: 50 steps" in done.stderr + done.stdout, "a second deployment", told(done))
    check(not old.exists(), "C++ of an earlier deployment is gone")
    hosts.check_ended("a second deployment")


def test_refused(hosts):
    """The first node refuses its options: the others, which wait for it, end."""
    done = hosts.run("--on-loss", "sometimes", seconds=30)
    check(done.returncode == 2 and "sometimes" in done.stderr, "options that are refused", told(done))
    hosts.check_ended("options that are refused")


def test_interrupt(hosts):
    """SIGINT, SIGTERM or SIGHUP to the script end the run as if it were local: with a complete trace and exit code."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        process = hosts.start("--silent", "--seed", "3", "--trace", "endless.trace", "--trace-format=binary")
        trace = hosts.home["lab"] / "endless.trace"
        end = time.monotonic() + 30
        while not (trace.exists() and trace.stat().st_size > 100000) and time.monotonic() < end and process.poll() is None:
            time.sleep(0.02)
        process.send_signal(number)
        try:
            out, err = process.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            process.kill()
            out, err = process.communicate()
        text = f"exit {process.returncode}\n{out}{err}"
        check(process.returncode == 143 and "interrupted: " in out + err, f"signal {number} ends the run", text)
        replay = subprocess.run([BIPC, "replay", "--silent", "--recorded", str(trace), str(hosts.folder / "robot/lab/model.bsys")], capture_output=True, text=True)
        check(replay.returncode == 0 and "agree" in replay.stdout, f"signal {number}: the trace is complete", text + told(replay))
        trace.unlink(missing_ok=True)
        hosts.check_ended(f"signal {number}")


def test_killed(hosts):
    """The script is killed: no node goes on."""
    process = hosts.start("--silent", "--seed", "4", "--trace", "killed.trace", "--trace-format=binary")
    trace = hosts.home["lab"] / "killed.trace"
    end = time.monotonic() + 30
    while not (trace.exists() and trace.stat().st_size > 100000) and time.monotonic() < end and process.poll() is None:
        time.sleep(0.02)
    check(len(hosts.processes()) >= 3, "three nodes run", "\n".join(hosts.processes()))
    process.kill()
    process.communicate()
    hosts.check_ended("a start script that is killed")


def test_no_host(hosts):
    """A host that cannot be reached: nothing is started."""
    home = hosts.home["mast"]
    away = home.with_name("away")
    home.rename(away)
    done = hosts.run("--silent", "--limit", "10")
    check(done.returncode == 255 and "limit" not in done.stdout + done.stderr, "a host that is away", told(done))
    hosts.check_ended("a host that is away")
    away.rename(home)


def test_units(hosts):
    if shutil.which("systemd-analyze") is None:
        print("systemd-analyze is not installed: units are not checked")
        return
    for name in NAMES:
        unit = hosts.folder / f"robot/{name}/bipc-{name}.service"
        text = unit.read_text()
        check(f"ExecStart=/opt/bipc/{name}/start\n" in text, f"the unit of {name} starts the folder that its README names", text)
        # Where the folder is: systemd-analyze looks for the program.
        there = hosts.folder / unit.name
        there.write_text(text.replace("/opt/bipc/", f"{hosts.folder}/robot/"))
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", str(there)], capture_output=True, text=True)
        check(done.returncode == 0 and unit.name not in done.stderr, f"the unit of {name}", told(done))


def main():
    if not (BUILD / "libbipc_zmq.so").exists():
        print("skipped: start scripts of deployments: libzmq3-dev was not there when bipc was built\n0 passed, 0 failed")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        hosts = Hosts(pathlib.Path(folder).resolve())
        for test in (test_run, test_files, test_again, test_refused, test_interrupt, test_killed, test_no_host, test_units):
            test(hosts)
    print(f"{test_hosts.passed} passed, {test_hosts.failed} failed")
    return 1 if test_hosts.failed else 0


if __name__ == "__main__":
    sys.exit(main())
