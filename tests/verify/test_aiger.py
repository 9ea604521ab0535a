#!/usr/bin/env python3
"""What `bipc export --format=aiger` writes, given to ABC: a bad state is reachable exactly where `bipc explore` finds one.

    tests/verify/test_aiger.py [COUNT] [FROM]     the models of models/classic, a counter with known answers, and COUNT random
                                                  systems (default 20) from seed FROM

Each file is also run through a small simulator of AIGER files that follows random inputs: where no bad state is reachable the
output stays 0. That needs no ABC; where ABC (Debian: berkeley-abc) is not installed, its answers count as skipped. BUILD names
the build directory, JOBS the number of processes. Python's library only. To see it go red: write `bad` negated, or the latches
without their initial values, in compiler/verify/symbolic/aiger.cpp.
"""
import concurrent.futures
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BUILD") or os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
ABC = shutil.which("berkeley-abc")
LIMIT = 20000
COUNTER = """package p
  port type Signal()
  connector type One(Signal a)
    define a
  end
  atom type Counter()
    data int n = 3
    export port Signal more()
    place S
    initial to S
    on more from S to S do { n = n + 2; if (n > 12) then n = n - 11; fi }
  end
  compound type Root()
    component Counter c()
    connector One more(c.more)
  end
end
"""


def run(command, timeout=300):
    return subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=timeout)


def parse(text):
    """(inputs, latches [literal, next, reset], output, gates [literal, left, right])."""
    lines = text.split("\n")
    head = [int(word) for word in lines[0].split()[1:]]
    _, inputs, latches, outputs, gates = head
    rows = [[int(word) for word in line.split()] for line in lines[1 : 1 + inputs + latches + outputs + gates]]
    latch_rows = [row if len(row) == 3 else row + [0] for row in rows[inputs : inputs + latches]]
    return inputs, latch_rows, rows[inputs + latches][0], rows[inputs + latches + outputs :]


def to_binary(text):
    """The binary form, which is all that ABC reads."""
    inputs, latches, output, gates = parse(text)
    out = bytearray(f"aig {inputs + len(latches) + len(gates)} {inputs} {len(latches)} 1 {len(gates)}\n".encode())
    for _, following, reset in latches:
        out += f"{following}{'' if reset == 0 else f' {reset}'}\n".encode()
    out += f"{output}\n".encode()

    def number(value):
        while value >= 128:
            out.append(value & 127 | 128)
            value >>= 7
        out.append(value)

    for literal, left, right in gates:
        assert literal > left >= right, (literal, left, right)
        number(literal - left)
        number(left - right)
    return bytes(out)


def simulate(text, steps, seed):
    """Is the output ever 1 on a random path?"""
    rng = random.Random(seed)
    inputs, latches, output, gates = parse(text)
    state = {literal // 2: False if reset == 0 else rng.random() < 0.5 for literal, _, reset in latches}
    for _ in range(steps):
        values = {0: False, **state}
        # Mostly one step at a time: others change nothing.
        chosen = rng.randrange(inputs) + 1 if inputs else 0
        for k in range(1, inputs + 1):
            values[k] = k == chosen or rng.random() < 0.02

        def value(literal):
            return values[literal // 2] != bool(literal & 1)

        for literal, left, right in gates:
            values[literal // 2] = value(left) and value(right)
        if value(output):
            return True
        state = {literal // 2: value(following) for literal, following, _ in latches}
    return False


def abc(text):
    """Does ABC reach the output? None: it gave up."""
    with tempfile.NamedTemporaryFile(suffix=".aig") as file:
        file.write(to_binary(text))
        file.flush()
        try:
            done = run([ABC, "-q", f"read_aiger {file.name}; print_stats; pdr -T 20"], 40)
        except subprocess.TimeoutExpired:
            return None
    answer = done.stdout + done.stderr
    if "Property proved" in answer:
        return False
    if "was asserted in frame" in answer:
        return True
    if "i/o" not in answer:
        raise RuntimeError(f"ABC refuses the file: {answer[:500]}")
    return None


def explore(path):
    """Is there a deadlock? None: too many states, or run-time errors end the search."""
    done = run([BIPC, "explore", "--json", "--backend", "interp", "--threads", "1", "--limit", str(LIMIT), str(path)])
    if done.returncode not in (0, 3):
        return None
    result = json.loads(done.stdout)
    return None if result["errors"] else result["deadlocks"] != 0


def check(path, expected=None, property_text=None):
    """Exports and compares. Returns (what was compared: "simulated", "reachable", "unreachable"; what is wrong, or "")."""
    name = f"{path.stem} {property_text or ''}".strip()
    compared = []
    try:
        expected = explore(path) if expected is None else expected
        if expected is None:
            return compared, ""
        made = run([BIPC, "export", "--format", "aiger", *(["--property", property_text] if property_text else []), str(path)])
        if made.returncode != 0:
            return compared, "" if "B5060" in made.stderr else f"{name}: export ends with {made.returncode}: {made.stderr[:500]}"
        if not expected:
            if simulate(made.stdout, 200, 1):
                return compared, f"{name}: the simulated output is 1, and no bad state is reachable"
            compared.append("simulated")
        answer = abc(made.stdout) if ABC else None
        if answer is not None:
            compared.append("reachable" if expected else "unreachable")
            if answer != expected:
                return compared, f"{name}: ABC says {'reachable' if answer else 'unreachable'}, explore says the opposite"
        return compared, ""
    except (RuntimeError, AssertionError, ValueError, IndexError, KeyError, subprocess.TimeoutExpired) as problem:
        return compared, f"{name}: {type(problem).__name__}: {problem}"


def main():
    count, start = (sys.argv[1:] + ["20", "1"])[0], (sys.argv[2:] + ["1"])[0]
    totals, failed = {"simulated": 0, "reachable": 0, "unreachable": 0}, 0
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        run([str(BUILD / "bip-verify-check"), "--from", start, "--count", count, "--print", folder]).check_returncode()
        questions = [(path,) for path in sorted((ROOT / "models" / "classic").glob("*.bip")) + sorted(work.glob("*.bsys"))]
        # Bits with the initial value 1, and a property: n is 3, 5, 7, 9, 11, 2, 4, 6, 8, 10, 12, 3: 13 never comes.
        counter = work / "counter.bip"
        counter.write_text(COUNTER)
        questions += [(counter, n != 13, f"never c.n == {n}") for n in (3, 11, 12, 13)]
        with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS") or os.cpu_count() or 1)) as pool:
            for compared, wrong in pool.map(lambda question: check(*question), questions):
                for what in compared:
                    totals[what] += 1
                if wrong:
                    failed += 1
                    print(f"FAILED {wrong}", flush=True)
    answers = totals["reachable"] + totals["unreachable"]
    print(f"aiger: {len(questions)} questions; ABC agrees that a bad state is reachable in {totals['reachable']} and not in "
          f"{totals['unreachable']}; simulated {totals['simulated']}")
    if not ABC:
        print("skipped: ABC is not installed (Debian's package berkeley-abc): exported circuits were only simulated")
    elif min(totals["reachable"], totals["unreachable"]) < 5:
        print("FAILED too few answers of each kind: this decides nothing")
        failed += 1
    if totals["simulated"] < 5:
        print("FAILED too few circuits were simulated")
        failed += 1
    print(f"{max(totals['simulated'] + answers - failed, 0)} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
