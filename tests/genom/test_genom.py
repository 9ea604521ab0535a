#!/usr/bin/env python3
"""Generated BIP against the reference: random modules, random requests, random answers of codels.

    tests/genom/test_genom.py [--scenarios N] [--from SEED] [--steps N] [--keep]

Each scenario is a module (reference.py, scenarios.py), translated by `bipc genom`, checked without a warning, and run with
a seed; follow.py hands the choices in the trace to the reference and compares replies, reports, interruptions and the order
of codels, cycle by cycle. Every answer that a codel may give has to occur somewhere. Python's library only.
The last line is "genom: N passed, N failed".
"""
import argparse
import concurrent.futures
import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE))
import follow  # noqa: E402
import reference  # noqa: E402
import scenarios  # noqa: E402

BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
RUNS = 4  # seeds of one translated module


def bipc(*arguments):
    done = subprocess.run([BIPC, *arguments], capture_output=True, text=True)
    if done.returncode != 0 or "warning[" in done.stderr:
        raise follow.Difference(f"bipc {' '.join(arguments)} ends with {done.returncode}\n{done.stdout[-500:]}{done.stderr[-2000:]}")


def one_module(seed, steps, first_run, runs):
    """(scenarios that passed, problems, counts, what was seen)"""
    module = scenarios.make_module(seed)
    least = 1 + seed % 2
    passed, problems, counts, seen = 0, [], {}, set()
    with tempfile.TemporaryDirectory(prefix="genom-") as work:
        gen, side, bip, trace = (os.path.join(work, n) for n in ("m.gen", "m.yields", "m.bip", "m.json"))
        pathlib.Path(gen).write_text(scenarios.as_gen(module), encoding="utf-8")
        pathlib.Path(side).write_text(scenarios.as_side_file(module), encoding="utf-8")
        try:
            bipc("genom", gen, "--yields", side, "-o", bip, "--instances", str(least))
        except follow.Difference as e:
            return 0, [f"module {seed}: {e}"] * runs, counts, seen
        for run in range(first_run, first_run + runs):
            try:
                bipc("run", bip, "--backend", "interp", "--silent", "--seed", str(seed * RUNS + run), "--limit", str(steps), "--trace", trace)
                f = follow.Follower(module, reference.Reference(module, scenarios.instances(module, least)))
                with open(trace, encoding="utf-8") as lines:
                    f.follow(lines)
                passed += 1
                seen |= f.seen
                for key, n in f.counts.items():
                    counts[key] = counts.get(key, 0) + n
            except follow.Difference as e:
                problems.append(f"module {seed}, run {run}: {e}")
    return passed, problems, counts, seen


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--scenarios", type=int, default=400)
    arguments.add_argument("--from", type=int, default=1, dest="first")
    arguments.add_argument("--steps", type=int, default=3000)
    arguments.add_argument("--jobs", type=int, default=2)
    options = arguments.parse_args()
    modules = range(options.first, options.first + max(1, options.scenarios // RUNS))
    passed, problems, counts, seen = 0, [], {}, set()
    with concurrent.futures.ThreadPoolExecutor(max_workers=options.jobs) as pool:
        for ok, bad, some, found in pool.map(lambda seed: one_module(seed, options.steps, 0, RUNS), modules):
            passed += ok
            problems += bad
            seen |= found
            for key, n in some.items():
                counts[key] = counts.get(key, 0) + n
    if options.scenarios >= 200:
        wanted = {(state, answer) for state, answers in reference.PERMITTED.items() for answer in answers}
        wanted |= {("report", r) for r in ("SYSTEM_ERROR", "WAIT_INIT_RQST", "WAIT_ABORT_ZOMBIE_ACTIVITY", "TOO_MANY_ACTIVITIES")}
        problems += [f"never seen: {what}" for what in sorted(wanted - seen)]
    for problem in problems[:20]:
        print(problem)
    print(f"{counts.get('control', 0)} control cycles, {counts.get('task', 0)} task cycles, {counts.get('replies', 0)} final replies compared")
    print(f"genom: {passed} passed, {len(problems)} failed")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
