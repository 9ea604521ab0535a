#!/usr/bin/env python3
"""The start script and the systemd units that `bipc deploy` writes, executed: three nodes at loopback addresses, whose hosts are folders that a small `ssh` in
PATH stands for. It runs the command in a session of its own, which outlives it as on another machine: only the end of what it reads says that it is gone.
Then the same over OpenSSH, if its `sshd` is installed (Debian's openssh-server): one of this test, with keys of its own, listens at a free port of these addresses and knows nobody but
this user. It neither reads nor changes what the user or the machine has of ssh.

    tests/distributed/test_start.py [--openssh]

--openssh: fails if `sshd` is missing. Units are checked by `systemd-analyze verify` if it is installed. Prints "N passed, N failed" at the end.
"""
import argparse
import os
import pathlib
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile

import test_hosts
from test_hosts import BIPC, BUILD, LONG, MODEL, check, until

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
        self.addresses = addresses = ["127.0.0.1", "::1" if has_ipv6() else "127.0.0.3", "127.0.0.2"]
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
        self.tools = folder / "tools"
        self.tools.mkdir()
        self.open()
        self.environment = {**os.environ, "PATH": f"{self.tools}:{os.environ['PATH']}", "BIPC": BIPC}

    def open(self):
        self.write_ssh(SSH.format(python=sys.executable, homes=str(self.homes)))

    def close(self):
        """The last host, or all of them, cannot be reached from now on."""
        self.home["mast"].rename(self.homes.with_name("away"))

    def write_ssh(self, text):
        (self.tools / "ssh").write_text(text)
        (self.tools / "ssh").chmod(0o755)

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

    def run(self, *options, environment=None):
        return subprocess.run([self.folder / "robot/start", *options], capture_output=True, text=True, timeout=2 * LONG, env=environment or self.environment, stdin=subprocess.DEVNULL)

    def start(self, *options):
        return subprocess.Popen([self.folder / "robot/start", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.environment, stdin=subprocess.DEVNULL,
                                preexec_fn=hear_signals)

    def check_ended(self, what):
        until(lambda: not self.processes())
        check(not self.processes(), f"{what}: a process goes on", "\n".join(self.processes()))


class OpenSsh(Hosts):
    """The same with OpenSSH: one sshd at all addresses, which begins each session in the home of the address."""

    def open(self):
        for name in ("host", "user"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-C", "", "-f", self.folder / name], check=True)
        shutil.copy(self.folder / "user.pub", self.folder / "authorized")
        port = free_port("127.0.0.1")
        host_key = " ".join((self.folder / "host.pub").read_text().split()[:2])
        (self.folder / "known").write_text("".join(f"[{address}]:{port} {host_key}\n" for address in self.addresses))
        lines = [f"Port {port}", *(f"ListenAddress {address}" for address in self.addresses), f"HostKey {self.folder}/host", f"AuthorizedKeysFile {self.folder}/authorized",
                 "PidFile none", "StrictModes no", "UsePAM no", "PasswordAuthentication no", "KbdInteractiveAuthentication no", "PermitRootLogin prohibit-password",
                 f"AllowUsers {pwd.getpwuid(os.getuid()).pw_name}", f"SetEnv BIPC={BIPC}"]
        for address in self.addresses:
            lines += [f"Match LocalAddress {address}", f"ForceCommand cd '{self.homes}/{address}' && eval \"$SSH_ORIGINAL_COMMAND\""]
        (self.folder / "sshd_config").write_text("\n".join(lines) + "\n")
        (self.folder / "ssh_config").write_text(f"Port {port}\nIdentityFile {self.folder}/user\nIdentitiesOnly yes\nIdentityAgent none\nUserKnownHostsFile {self.folder}/known\n"
                                                "GlobalKnownHostsFile none\nBatchMode yes\nLogLevel ERROR\nControlMaster no\n")
        self.write_ssh(f"#!/bin/sh\nexec {shutil.which('ssh')} -F '{self.folder}/ssh_config' \"$@\"\n")
        # Where sshd leaves its rights to those who are not logged in yet; its package makes it when the machine starts.
        self.made = pathlib.Path("/run/sshd") if os.getuid() == 0 and not pathlib.Path("/run/sshd").exists() else None
        if self.made:
            self.made.mkdir(mode=0o755)
        with open(self.folder / "sshd.log", "w") as log:
            self.sshd = subprocess.Popen([find_sshd(), "-D", "-e", "-f", self.folder / "sshd_config"], stderr=log, stdin=subprocess.DEVNULL)
        until(lambda: self.log().count("Server listening") >= len(self.addresses) or self.sshd.poll() is not None)

    def log(self):
        return (self.folder / "sshd.log").read_text()

    def close(self):
        self.sshd.terminate()
        self.sshd.wait()
        if self.made:
            self.made.rmdir()
            self.made = None


def find_sshd():
    """It must be started by its whole path, and is in no PATH of a user."""
    return shutil.which("sshd", path=f"{os.environ['PATH']}:/usr/sbin:/usr/local/sbin")


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
    done = hosts.run("--on-loss", "sometimes")
    check(done.returncode == 2 and "sometimes" in done.stderr, "options that are refused", told(done))
    hosts.check_ended("options that are refused")


def test_interrupt(hosts):
    """SIGINT, SIGTERM or SIGHUP to the script end the run as if it were local: with a complete trace and exit code."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        process = hosts.start("--silent", "--seed", "3", "--trace", "endless.trace", "--trace-format=binary")
        trace = hosts.home["lab"] / "endless.trace"
        until(lambda: trace.exists() and trace.stat().st_size > 100000 or process.poll() is not None)
        process.send_signal(number)
        try:
            out, err = process.communicate(timeout=2 * LONG)
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
    until(lambda: trace.exists() and trace.stat().st_size > 100000 or process.poll() is not None)
    check(len(hosts.processes()) >= 3, "three nodes run", "\n".join(hosts.processes()))
    process.kill()
    process.communicate()
    hosts.check_ended("a start script that is killed")


def test_no_host(hosts):
    """The last host, or all, cannot be reached: nothing is started."""
    hosts.close()
    done = hosts.run("--silent", "--limit", "10")
    check(done.returncode == 255 and "limit" not in done.stdout + done.stderr, "hosts that are away", told(done))
    hosts.check_ended("hosts that are away")


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
    parser = argparse.ArgumentParser()
    parser.add_argument("--openssh", action="store_true")
    options = parser.parse_args()
    kinds = [Hosts]
    if find_sshd() and shutil.which("ssh-keygen"):
        kinds.append(OpenSsh)
    elif not check(not options.openssh, "sshd is installed (openssh-server)"):
        return 1
    else:
        print("sshd is not installed (openssh-server): ssh is a small program of this test only")
    for kind in kinds:
        with tempfile.TemporaryDirectory() as folder:
            hosts = kind(pathlib.Path(folder).resolve())
            try:
                for test in (test_run, test_files, test_again, test_refused, test_interrupt, test_killed, test_units):
                    test(hosts)
            finally:
                test_no_host(hosts)
            if kind is OpenSsh:
                check(hosts.log().count("Accepted publickey") > 30, "sessions are those of sshd", hosts.log())
    print(f"{test_hosts.passed} passed, {test_hosts.failed} failed")
    return 1 if test_hosts.failed else 0


if __name__ == "__main__":
    sys.exit(main())
