#!/usr/bin/env python3
"""Certificates of deadlock-freedom by regions of values (rows `unless`): what is damaged, or of a system with a deadlock, certcheck refuses.

    tests/verify/test_region_certificates.py [COUNT] [SEED]

A lock by levels (models/scaling/filter_lock.bip, in which nobody looks at the others, so that a level more lets all wait) has such a certificate. COUNT times
(default 120) it is damaged at random and given to certcheck with a lock that has a deadlock, one of those of BROKEN: not one of these may be accepted, nor the
certificate as it is. With the sound lock, rows that the proof cannot do without are left out or changed, one by one: refused, too. Python's library only. To see it go
red: let `check_weights` in tools/certcheck/states.cpp return before the last line, or `keeps` always return true.
"""
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
TIMEOUT = 300 * float(os.environ.get("BIPC_TEST_PATIENCE") or 1)
SIZE = 16  # of less other engines have proofs, too
NOBODY_LOOKS = [("other.level < process.level)", "other.level < process.level && other.level < 0 - 1)"),
                ("        connector Look look[", "      }\n      for k in 1..n {\n        connector Look look[")]
# Locks with the same names of components and connectors, all of which can have a deadlock: who enters last is not overtaken by all others.
BROKEN = {
    "a level for each": [("for k in 1..n component", "for k in 1..n + 1 component"), ("for k in 1..n {\n        connector Enter", "for k in 1..n + 1 {\n        connector Enter"),
                         ("level < n - 1", "level < n"), ("level == n - 1", "level == n")],
    "the last one of all": [("level.last != process.me", "level.last < process.me")],
    "one is critical for ever": [("on leave from CRITICAL to OUTSIDE do", "on leave from CRITICAL to OUTSIDE provided (level < 0) do")],
    "nobody enters": [("(process.level == level.level) down", "(process.level == level.level && process.level > 1) down")],
    "only by the next one": [("level.last != process.me", "level.last == process.next")],
}


def run(command):
    return subprocess.run(command, capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL, timeout=TIMEOUT)


class Locks:
    def __init__(self, work):
        self.work = pathlib.Path(work)
        self.text = self.changed((ROOT / "models/scaling/filter_lock.bip").read_text(encoding="utf-8"), NOBODY_LOOKS)

    @staticmethod
    def changed(text, changes):
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        return text

    def model(self, name, changes):
        """The path of the model and of its system."""
        model, system = self.work / f"{name}.bip", self.work / f"{name}.bsys"
        model.write_text(self.changed(self.text, changes), encoding="utf-8")
        made = run([BIPC, "check", "--emit=system", "--root", f"Lock({SIZE})", str(model)])
        assert made.returncode == 0, made.stderr
        system.write_text(made.stdout, encoding="utf-8")
        return model, system

    def check(self, system, rows):
        """What certcheck says: accepted, refused, or something else."""
        certificate = self.work / "c.cert"
        certificate.write_text("".join(" ".join(row) + "\n" for row in rows), encoding="utf-8")
        done = run([str(CERTCHECK), str(system), str(certificate)])
        return {0: "accepted", 1: "refused"}.get(done.returncode, f"exit code {done.returncode}"), done.stdout.strip()


def change_number(word, numbers):
    """Some number in the word, one more or less, or any."""
    found = list(re.finditer(r"-?\d+", word))
    if not found:
        return word
    at = numbers.choice(found)
    value = int(at[0])
    return word[:at.start()] + str(numbers.choice([value + 1, value - 1, numbers.randrange(-2, SIZE + 2)])) + word[at.end():]


def damage(rows, numbers):
    """One change, as a wrong prover could make it; the head stays."""
    rows = [list(row) for row in rows]
    at = numbers.choice([k for k, row in enumerate(rows) if row[0] in ("lemma", "unless")])
    row = rows[at]
    other = numbers.choice([each for each in rows if each[0] == row[0]])
    kind = numbers.randrange(7)
    word = numbers.randrange(1, len(row))
    if kind == 0:
        del rows[at]
    elif kind == 1 and len(row) > 2:
        del row[word]
    elif kind == 2:
        row[word] = change_number(row[word], numbers)
    elif kind == 3:
        row.append(other[-1])
    elif kind == 4:
        row[1], other[1] = other[1], row[1]
    elif kind == 5:
        rows.insert(at, list(row))
    else:
        row[-1] = other[-1]
    return rows


def needed_changes(rows):
    """(what, rows) without which there is no proof: each level holds back as many as it can, and one process is left."""
    unless = [k for k, row in enumerate(rows) if row[0] == "unless"]
    for k in unless[::7]:
        yield f"without {rows[k][1]}", rows[:k] + rows[k + 1:]
        first = rows[k][2]
        yield f"{rows[k][1]}: a weight of 0", rows[:k] + [[*rows[k][:2], re.sub(r"\*\d+$", "*0", first), *rows[k][3:]]] + rows[k + 1:]
        if len(rows[k]) > 3:
            yield f"{rows[k][1]}: a weight of 2", rows[:k] + [[*rows[k][:2], re.sub(r"\*\d+$", "*2", first), *rows[k][3:]]] + rows[k + 1:]
            yield f"{rows[k][1]}: one side", rows[:k] + [rows[k][:3]] + rows[k + 1:]
        other = rows[unless[(unless.index(k) + 1) % len(unless)]]
        yield f"{rows[k][1]}: another connector", rows[:k] + [["unless", other[1], *rows[k][2:]]] + rows[k + 1:]
    for what in ("@LOOKS", "self="):
        at = next(k for k, row in enumerate(rows) if row[0] == "lemma" and any(what in word for word in row))
        yield f"without the lemma of {what}", rows[:at] + rows[at + 1:]


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 120
    numbers = random.Random(int(sys.argv[2]) if len(sys.argv) > 2 else 1)
    if not CERTCHECK.exists():
        print("certificates by regions are left out: certcheck is not built")
        return 0
    problems, asked, refused_whole = [], 0, 0
    with tempfile.TemporaryDirectory(prefix="region-certificates-") as work:
        locks = Locks(work)
        model, system = locks.model("sound", [])
        certificate = pathlib.Path(work) / "sound.cert"
        proved = run([BIPC, "verify", "--no-cache", "--certificate", str(certificate), "--root", f"Lock({SIZE})", str(model)])
        if proved.returncode != 0 or "unless " not in certificate.read_text(encoding="utf-8"):
            print(f"FAILED: no certificate by regions: {proved.stdout}{proved.stderr}")
            return 1
        rows = [line.split() for line in certificate.read_text(encoding="utf-8").splitlines()]
        asked += 1
        told, why = locks.check(system, rows)
        if told != "accepted":
            problems.append(f"the whole certificate is {told}: {why}")
        for what, changed in needed_changes(rows):
            asked += 1
            told, why = locks.check(system, changed)
            if told != "refused":
                problems.append(f"{what}: {told}: {why}")
        broken = []
        for name, changes in BROKEN.items():
            model, system = locks.model(name.replace(" ", "-"), changes)
            broken.append(system)
            asked += 2
            found = run([BIPC, "verify", "--no-cache", "--root", f"Lock({SIZE})", str(model)])
            if found.returncode != 3:
                problems.append(f"{name}: has no deadlock: {found.stdout}")
            told, why = locks.check(system, rows)
            if told != "refused":
                problems.append(f"{name}: the whole certificate is {told}: {why}")
        for number in range(count):
            changed = rows
            for _ in range(numbers.randrange(1, 4)):
                changed = damage(changed, numbers)
            asked += 1
            told, why = locks.check(broken[number % len(broken)], changed)
            refused_whole += "weights" in why
            if told != "refused":
                problems.append(f"damage {number} of {list(BROKEN)[number % len(broken)]}: {told}: {why}")
    for problem in problems:
        print(f"FAILED {problem}")
    print(f"{count} damaged certificates of locks with a deadlock, {refused_whole} refused for their weights")
    print(f"certificates by regions: {asked - len(problems)} passed, {len(problems)} failed")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
