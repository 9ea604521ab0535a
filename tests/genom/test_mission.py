#!/usr/bin/env python3
"""A mission of models/dala at a pace that the machine keeps: ten times the clock on an idle one, and so many times less as programs wait for a processor.

    tests/genom/test_mission.py [OPTION of models/dala/run …]

The modules run by the clock: their rules judge how old a reference is, and on a machine that lets them wait all of them are old. At a slower clock the same mission has
the same rules. An attempt that fails is followed by a slower one while programs wait; on an idle machine there is none. Python's library only.
"""
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SPEED, SLOWEST = 10.0, 0.5


def waiting():
    """Programs that run or wait, for each processor: at least 1."""
    minute, _, _, now, _ = pathlib.Path("/proc/loadavg").read_text().split()
    return max(1.0, max(float(minute), int(now.split("/")[0])) / (os.cpu_count() or 1))


def pace():
    """How many times the clock a mission is to be."""
    return max(SLOWEST, SPEED / waiting())


def main():
    speed = pace()
    while True:
        ran = subprocess.run([sys.executable, str(ROOT / "models/dala/run"), "--speed", f"{speed:.2f}", *sys.argv[1:]], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        slower = max(SLOWEST, speed / 3)
        if ran.returncode == 0 or slower == speed or waiting() < 1.5:
            print(ran.stdout + f"at {speed:.1f} times the clock, with {waiting():.1f} programs for each processor")
            return ran.returncode
        surprises = [line for line in ran.stdout.splitlines() if "surprise in" in line]
        print(f"not at {speed:.1f} times the clock, with {waiting():.1f} programs for each processor:", *surprises, sep="\n", flush=True)
        speed = slower


if __name__ == "__main__":
    sys.exit(main())
