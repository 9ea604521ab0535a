"""What the tests of `bipc serve` share: where things are, the client, checks that are counted."""
import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tools/python/bipc"))
from serve import Client  # noqa: E402, F401

BIPC = os.environ.get("BIPC") or str(pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build") / "bipc")
_counts = {True: 0, False: 0}


def check(what, holds, got=None):
    _counts[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}: {got}", flush=True)


def finish(name):
    """Prints the counts; the script's exit code."""
    print(f"{name}: {_counts[True]} passed, {_counts[False]} failed")
    return 1 if _counts[False] else 0
