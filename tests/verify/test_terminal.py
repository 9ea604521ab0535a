#!/usr/bin/env python3
"""`bipc verify` as a person meets it: the progress line on a terminal, Ctrl-C, the limits of time and memory.

    tests/verify/test_terminal.py

The model is a generator of pseudo-random numbers that stops at one of 2^32 values: no invariant, no induction and no search decides
that in a minute. Needs a built bipc ($BIPC, or bipc in $BUILD, or build/bipc). Limits of time are of processor time, so on a loaded machine
a run ends later by the clock.
"""
import os
import pathlib
import pty
import re
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests"))
from patience import LONG  # noqa: E402

BIPC = os.environ.get("BIPC") or str(pathlib.Path(os.environ.get("BUILD") or ROOT / "build") / "bipc")
MODEL = """package dice
  port type Signal()
  connector type One(Signal a) define a end
  atom type Dice()
    data int x = 1
    export port Signal step()
    place ROLLS
    initial to ROLLS
    on step from ROLLS to ROLLS provided (x != 77777) do { x = x * 1103515245 + 12345; }
  end
  compound type Root()
    component Dice dice()
    connector One steps(dice.step)
  end
end
"""
PROGRESS = re.compile(r"\r\x1b\[K(search|induction|invariants): (\d+) (\w+)(, \d+ a second)?   \d+\.\d s \(Ctrl-C ends it\)")


def has_terminals():
    """Some machines (a bare chroot) have no pseudo terminals."""
    try:
        for end in pty.openpty():
            os.close(end)
    except OSError:
        return False
    return True


class Run:
    """bipc verify with its errors on a terminal of our own, or not."""

    def __init__(self, model, options, is_terminal):
        self.is_terminal = is_terminal
        self.seen = ""
        self.start = time.monotonic()
        command = [BIPC, "verify", "--no-reuse", "--backend", "interp", *options, model]
        if not is_terminal:
            self.child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            return
        self.terminal, far = pty.openpty()
        self.child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=far, text=True)
        os.close(far)

    def read_until(self, pattern):
        while not pattern.search(self.seen) and time.monotonic() - self.start < 2 * LONG:
            try:
                text = os.read(self.terminal, 4096)
            except OSError:
                break
            self.seen += text.decode("utf-8", "replace")

    def end(self):
        """Exit code, what was printed, seconds."""
        if self.is_terminal:
            self.read_until(re.compile(r"(?!)"))
        out, err = self.child.communicate(timeout=2 * LONG)
        self.seen += err or ""
        return self.child.returncode, out, time.monotonic() - self.start


def progress(model):
    run = Run(model, ["--timeout", "4"], True)
    code, out, _ = run.end()
    phases = {m.group(1) for m in PROGRESS.finditer(run.seen)}
    assert "search" in phases or "induction" in phases, f"no progress line: {run.seen!r}"
    assert run.seen.endswith("\r\x1b[K"), f"the line is left behind: {run.seen[-60:]!r}"
    assert code == 4 and out.startswith("unknown: ") and "\x1b" not in out, (code, out)


def quiet_elsewhere(model):
    run = Run(model, ["--timeout", "2"], False)
    code, _, _ = run.end()
    assert code == 4 and run.seen == "", (code, run.seen)


def interrupt(model):
    run = Run(model, ["--timeout", "600"], has_terminals())
    if run.is_terminal:
        run.read_until(PROGRESS)
    else:
        time.sleep(2)
    run.child.send_signal(signal.SIGINT)
    code, out, _ = run.end()
    assert code == 4, f"exit code {code}"
    assert out.startswith("unknown: interrupted\n"), out
    assert "  dice@ROLLS" in out, f"what is known is not told: {out}"


def time_limit(model):
    run = Run(model, ["--timeout", "1"], False)
    _, status, usage = os.wait4(run.child.pid, 0)
    out = run.child.stdout.read()
    assert os.waitstatus_to_exitcode(status) == 4 and out.startswith("unknown: "), (status, out)
    used = usage.ru_utime + usage.ru_stime
    assert 0.9 < used < 5, f"{used:.1f} s of the processor instead of 1"


def memory_limit(model):
    run = Run(model, ["--timeout", "20", "--memory", "20"], False)
    _, status, usage = os.wait4(run.child.pid, 0)
    out = run.child.stdout.read()
    assert os.waitstatus_to_exitcode(status) == 4, status
    assert re.match(r"unknown: the search met its limit of memory after \d+ states", out), out
    assert usage.ru_maxrss < 500_000, f"{usage.ru_maxrss} KB"


def main():
    failed = 0
    cases = [progress, quiet_elsewhere, interrupt, time_limit, memory_limit]
    if not has_terminals():
        cases.remove(progress)
        print("left out: progress, this machine has no pseudo terminals")
    with tempfile.TemporaryDirectory() as directory:
        model = os.path.join(directory, "dice.bip")
        pathlib.Path(model).write_text(MODEL, encoding="utf-8")
        for case in cases:
            try:
                case(model)
            except (AssertionError, subprocess.TimeoutExpired) as problem:
                failed += 1
                print(f"FAILED {case.__name__}: {problem}")
    print(f"{len(cases) - failed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
