"""What the tests of `bipc serve` share: where things are, the client, waiting, checks that are counted."""
import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tools/python/bipc"))
sys.path.insert(0, str(ROOT / "tests"))
from patience import LONG, PATIENCE, until  # noqa: E402, F401
from serve import Client  # noqa: E402, F401

BIPC = os.environ.get("BIPC") or str(pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build") / "bipc")
_counts = {True: 0, False: 0}


def processes_below(parent):
    """{name: pid} of the children of a process, and of theirs."""
    found, parents = {}, {parent}
    for _ in range(2):
        for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
            try:
                pid, rest = stat.read_text().split(" (", 1)
            except OSError:
                continue  # gone meanwhile
            name, rest = rest.rsplit(") ", 1)
            if int(rest.split()[1]) in parents:
                found[name] = int(pid)
        parents |= set(found.values())
    return found


def runs(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(") ", 1)[1][0] != "Z"
    except OSError:
        return False


def check(what, holds, got=None):
    _counts[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}: {got}", flush=True)


def finish(name):
    """Prints the counts; the script's exit code."""
    print(f"{name}: {_counts[True]} passed, {_counts[False]} failed")
    return 1 if _counts[False] else 0
