#!/usr/bin/env python3
"""Random compounds with a size: what `bipc verify --for-all n` says of all sizes, against all states of small ones.

    tests/verify/test_sizes.py [--count N] [--seed N] [--largest N]

Each model has one or two arrays of n components and up to two components outside of them, joined by loops over
neighbours (in a circle or in a line), by single elements at either end, and by all elements of an array. `bipc explore`
counts the deadlocks of every size up to --largest. A proof for all sizes must not meet one, the size of a deadlock
must be the first that has one, and enough of the models must be proved. Where certcheck is built, it must accept the
certificates of proofs. For a changed model (a connector less, another initial place, another transition) that has a
deadlock at a size that the certificate's part for all sizes is about, it must accept neither that part nor changed ones.
Python's library only. To see it go red: let `check_promises` or `check_words` in tools/certcheck/words.cpp return at once.
"""
import argparse
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
CERTCHECK = pathlib.Path(BIPC).with_name("certcheck")  # not built without Z3
CHANGES = 6
LEAST = 3  # neighbours on both sides are different elements
TIMEOUT = 120


def atom(rng, name, has_choice):
    """An atom type of a few places; every port has a transition. With has_choice a parameter decides about one of them."""
    places = [f"P{k}" for k in range(rng.randint(2, 3))]
    ports = [f"p{k}" for k in range(rng.randint(2, 3))]
    own = rng.random() < 0.3
    rows, used = [], set()

    def transition(port, source, target):
        if (port, source) in used:
            return
        used.add((port, source))
        guard = " provided (c)" if has_choice and rng.random() < 0.4 else ""
        rows.append(f"    on {port} from {source} to {target}{guard}")

    for k, place in enumerate(places):  # a circle of all places
        transition(rng.choice(ports), place, places[(k + 1) % len(places)])
    for port in ports:
        if not any(p == port for p, _ in used):
            transition(port, rng.choice(places), rng.choice(places))
    if rng.random() < 0.4:
        transition(rng.choice(ports), rng.choice(places), rng.choice(places))
    if own:
        transition("own", rng.choice(places), rng.choice(places))
    text = [f"  @SuppressWarning(unboundcomponentport)\n  atom type {name}({'bool c' if has_choice else ''})", f"    export port Signal {', '.join(p + '()' for p in ports)}"]
    if own:
        text.append("    port Signal own()")
    text += [f"    place {', '.join(places)}", "    initial to P0", *rows]
    if rng.random() < 0.1:
        text.insert(-len(rows), "")
    return "\n".join([*text, "  end"]), ports


def model(seed):
    rng = random.Random(seed)
    arrays, singles = ["x", "y"][:rng.randint(1, 2)], ["s", "t"][:rng.randint(0, 2)]
    ports, types, items = {}, [], []
    for name in [*arrays, *singles]:
        is_array = name in arrays
        has_choice = is_array and rng.random() < 0.5
        text, ports[name] = atom(rng, "T" + name, has_choice)
        types.append(text)
        if has_choice:
            condition = rng.choice(["i == 0", "i == n - 1", "i < 1", "i != n - 2", "i > 0 && i < n - 1"])
            items.append(f"    for i in 0..n component T{name} {name}[i]({condition})")
        else:
            items.append(f"    component T{name} {name}{'[n]' if is_array else ''}()")

    def bound(name, index):
        return f"{name}{'[' + index + ']' if name in arrays else ''}.{rng.choice(ports[name])}"

    def connector(k):
        kind = rng.choice(["loop", "loop", "loop", "loop", "line", "end", "all"])
        trigger = rng.choice(["", "", "'"])
        if kind in ("loop", "line"):
            index = ["i", "(i + 1) % n", "(i + n - 1) % n"] if kind == "loop" else ["i", "i + 1"]
            range_ = "0..n" if kind == "loop" else rng.choice(["0..n - 1", "1..n - 1"])
            parts = [(rng.choice(arrays), position) for position in index]
            parts += [(name, "") for name in singles]
            chosen = rng.sample(parts, min(len(parts), rng.choice([1, 2, 2, 2, 3])))
            if all(name in singles for name, _ in chosen):
                chosen = [(arrays[0], "i")]
        elif kind == "end":
            range_ = ""
            parts = [(rng.choice(arrays), position) for position in ("0", "n - 1")] + [(name, "") for name in singles]
            chosen = rng.sample(parts, rng.randint(1, min(2, len(parts))))
        else:
            range_ = ""
            chosen = [(rng.choice(arrays), "*")] + [(name, "") for name in singles[:1]]
            if singles and trigger:
                chosen.reverse()
        paths = [bound(name, index) for name, index in chosen]
        define = " ".join(path + (trigger if position == 0 else "") for position, path in enumerate(paths))
        loop, element = (f"for i in {range_} ", "[i]") if range_ else ("", "")
        return f"    {loop}connector c{k}{element}({', '.join(paths)})\n      define [{define}]"

    items += [connector(k) for k in range(rng.randint(2, 5))]
    types.append("  compound type M(int n)\n" + "\n".join(items) + "\n  end")
    return "package m\n  port type Signal()\n\n" + "\n\n".join(types) + "\nend\n"


def run(arguments, path):
    return subprocess.run([BIPC, *arguments, str(path)], capture_output=True, text=True, timeout=TIMEOUT)


def has_deadlock(path, size):
    """None: more states than the limit, or the size does not compile."""
    # A few thousand states: machine code would take longer to make than to save.
    done = run(["explore", "--json", "--backend", "interp", "--reduce", "none", "--root", f"M({size})", "--limit", "200000"], path)
    if done.returncode not in (0, 3):
        return None
    found = json.loads(done.stdout)
    return None if found["end"] != "complete" and not found["deadlocks"] else found["deadlocks"] > 0


# ---- certificates
def certcheck(folder, systems, certificate):
    for name, text in (("asked.bsys", systems), ("asked.cert", certificate)):
        (pathlib.Path(folder) / name).write_text(text, encoding="utf-8")
    done = subprocess.run([CERTCHECK, f"{folder}/asked.bsys", f"{folder}/asked.cert"], capture_output=True, text=True, timeout=TIMEOUT)
    return done.returncode, (done.stdout + done.stderr).strip()


def changed_model(rng, text):
    """A connector less, another initial place, or a transition that leads elsewhere."""
    lines = text.splitlines()
    connectors = [k for k, line in enumerate(lines) if " connector " in f" {line} "]
    starts = [k for k, line in enumerate(lines) if "initial to" in line]
    moves = [k for k, line in enumerate(lines) if line.strip().startswith("on ")]
    kind = rng.choice(["connector", "initial", "move"])
    if kind == "connector":
        k = rng.choice(connectors)
        del lines[k:k + 2]
    elif kind == "initial":
        k = rng.choice(starts)
        lines[k] = "    initial to P1"
    else:
        k = rng.choice(moves)
        lines[k] = re.sub(r" to P\d", f" to P{rng.randint(0, 1)}", lines[k])
    return "\n".join(lines) + "\n"


def changed_certificate(rng, text):
    """A row lost, a mode more or less, another state."""
    lines = text.splitlines()
    rows = [k for k, line in enumerate(lines) if line.startswith(("begin", "next"))]
    if not rows:
        return text
    k = rng.choice(rows)
    words = lines[k].split(" ")
    first = 3 if words[0] == "begin" else 4
    kind = rng.choice(["lost", "less", "mode", "state"])
    if kind == "lost":
        del lines[k]
    elif kind == "less" and len(words) > first:
        del words[rng.randrange(first, len(words))]
        lines[k] = " ".join(words)
    elif kind == "mode" and len(words) > first:
        at = rng.randrange(first, len(words))
        words[at] = re.sub(r":(\d+)$", f":{rng.randint(0, 2)}", words[at])
        lines[k] = " ".join(words)
    else:
        other = lines[rng.choice(rows)].split(" ")
        words[first - 1] = other[2 if other[0] == "begin" else 3]
        lines[k] = " ".join(words)
    return "\n".join(lines) + "\n"


def part_for_all(systems, certificates):
    """From the least size that it is about on: that size, its systems, its certificate."""
    parts = [f"(bsys 1)\n{part}" for part in systems.split("(bsys 1)\n")[1:]]
    at = next(k for k, part in enumerate(parts) if "\n(for-all n " in part)
    least = int(re.search(r"\n\(for-all n (\d+)", parts[at]).group(1))
    return least, "".join(parts[at:]), "bipc-certificate 1\n" + certificates.split("bipc-certificate 1\n")[-1]


def check_certificate(seed, folder, path, largest, counts):
    systems = run(["verify", "--for-all", f"n >= {LEAST}", "--emit=system"], path).stdout
    certificates = (pathlib.Path(folder) / "made.cert").read_text(encoding="utf-8")
    code, said = certcheck(folder, systems, certificates)
    counts[f"certificates {'accepted' if code == 0 else 'not accepted'}"] = counts.get(f"certificates {'accepted' if code == 0 else 'not accepted'}", 0) + 1
    if code != 0:
        return f"the certificate is not accepted: {said}"
    _, _, certificate = part_for_all(systems, certificates)
    rng = random.Random(seed * 7 + 1)
    other = pathlib.Path(folder) / "other.bip"
    for _ in range(CHANGES):
        other.write_text(changed_model(rng, path.read_text(encoding="utf-8")), encoding="utf-8")
        made = run(["verify", "--for-all", f"n >= {LEAST}", "--emit=system"], other)
        if made.returncode != 0:
            continue
        least, its_systems, _ = part_for_all(made.stdout, certificates)
        stuck = [size for size in range(least, largest + 1) if has_deadlock(other, size)]
        if not stuck:
            continue
        counts["changed models with a deadlock"] = counts.get("changed models with a deadlock", 0) + 1
        for asked in [certificate, *(changed_certificate(rng, certificate) for _ in range(3))]:
            code, said = certcheck(folder, its_systems, asked)
            if code == 0:
                return f"accepted, but n = {stuck[0]} has a deadlock: {said}\n{other.read_text(encoding='utf-8')}\n{asked}"
    return None


def check(seed, folder, largest, counts):
    """The verdict, and what contradicts it."""
    path = pathlib.Path(folder) / "m.bip"
    path.write_text(model(seed), encoding="utf-8")
    certificate = ["--certificate", f"{folder}/made.cert"] if CERTCHECK.exists() else []
    done = run(["verify", "--for-all", f"n >= {LEAST}", "--json", "--timeout", "20", *certificate], path)
    if done.returncode == 1:
        return "refused", None  # a model that does not compile
    if done.returncode not in (0, 3, 4):
        return "failed", f"exit code {done.returncode}: {done.stderr}"
    verdict = json.loads(done.stdout)
    deadlocks = {size: has_deadlock(path, size) for size in range(LEAST, largest + 1)}
    name = verdict["verdict"]
    if name == "deadlock-free":
        wrong = [size for size, found in deadlocks.items() if found]
        if wrong or not certificate:
            return name, f"deadlock-free for all sizes, but not for {wrong}" if wrong else None
        return name, check_certificate(seed, folder, path, largest, counts)
    if name == "deadlock":
        size = verdict["size"]
        earlier = [s for s, found in deadlocks.items() if found and s < size]
        if earlier or deadlocks.get(size) is False:
            return name, f"deadlock at {size}, but explore says {deadlocks}"
    return name, None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--largest", type=int, default=7)
    arguments = parser.parse_args()
    counts, problems = {}, []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(arguments.seed, arguments.seed + arguments.count):
            name, problem = check(seed, folder, arguments.largest, counts)
            counts[name] = counts.get(name, 0) + 1
            if problem:
                problems.append(f"seed {seed}: {problem}\n{model(seed)}")
    print(f"{arguments.count} models: {', '.join(f'{counts[k]} {k}' for k in sorted(counts))}")
    if counts.get("deadlock-free", 0) * 20 < arguments.count:
        problems.append("fewer than one in twenty is proved: the test says too little")
    if CERTCHECK.exists() and counts.get("changed models with a deadlock", 0) * 20 < arguments.count:
        problems.append("too few changed models have a deadlock: the test says too little")
    print("\n".join(problems), end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
