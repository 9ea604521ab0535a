#!/usr/bin/env python3
"""A day of model time of each timed model, without drift: its steps repeat to the nanosecond (day.cpp says how that is told).

    tests/models/test_day.py [--hours N] [--steps N] [MODEL ...]        (default: 24 hours however many steps, models/timed/*.bip)

Each model becomes a program; about a minute of the processor for a day of a model with a period of some ms. With --steps a model is left
after so many: the suite's way, in which those with few steps a day have their day all the same.
"""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")


def compiler():
    wanted = (os.environ.get("BIPC_TEST_CXX") or os.environ.get("CXX", "c++")).split()
    return (["ccache"] if shutil.which("ccache") and "ccache" not in wanted[0] else []) + wanted


def day_of(model, hours, steps, work):
    """(is it sound, what is said)"""
    emitted = subprocess.run([BIPC, "emit", "--emit=cpp", str(model)], capture_output=True)
    (work / "model.cpp").write_bytes(emitted.stdout)
    here = pathlib.Path(__file__).resolve().parent
    flags = ["-std=c++20", "-O1", "-DBIP_NO_MAIN", "-I", str(ROOT / "runtime/include"), "-I", str(ROOT)]
    built = emitted
    for command in ([*compiler(), *flags, "-c", str(work / "model.cpp"), "-o", str(work / "model.o")],
                    [*compiler(), *flags, "-c", str(here / "day.cpp"), "-o", str(work / "day.o")],
                    [*compiler(), str(work / "model.o"), str(work / "day.o"), str(BUILD / "libbip_runtime.a"), "-pthread", "-o", str(work / "day")]):
        built = subprocess.run(command, capture_output=True) if built.returncode == 0 else built
    if emitted.returncode or built.returncode:
        return False, built.stderr.decode("utf-8", "replace")
    done = subprocess.run([str(work / "day"), str(hours), str(steps)], capture_output=True, text=True)
    return done.returncode == 0, done.stdout.strip() + done.stderr


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--hours", type=float, default=24)
    parser.add_argument("--steps", type=int, default=0)
    parser.add_argument("models", nargs="*", type=pathlib.Path)
    options = parser.parse_args()
    failed = 0
    models = options.models or sorted((ROOT / "models/timed").glob("*.bip"))
    for model in models:
        with tempfile.TemporaryDirectory(prefix="day-") as folder:
            sound, text = day_of(model, options.hours, options.steps, pathlib.Path(folder))
        failed += 0 if sound else 1
        print(f"{model.stem}: {text}", flush=True)
    print(f"day: {len(models) - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
