#!/usr/bin/env python3
"""One slip of the pen in a good file: does the first error stand where the slip is, and is it alone?

    tests/slips/test_slips.py [--count N] [--seed S] [--list] [--only KIND] [part of a file's name ...]

Takes sound files (models, stdlib, the files of goldens that check), and in each trial deletes, doubles or swaps one token
(with the next one), or leaves the closing quote of a string away. `bipc check` must answer with errors of the syntax or of
names, or accept (some slips give another sound file). Counted are the trials that give a syntax error (B0...):

- `on the line`: the first error stands on a line between the tokens around the slip,
- `within one line` of these, and the number of errors.

The thresholds at the end are well below what is reached; --list shows the trials that miss, to be read. Needs python3 only.
"""
import argparse
import collections
import concurrent.futures
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
TOKEN = re.compile(r'"(?:[^"\\\n]|\\.)*"|//[^\n]*|/\*.*?\*/|[A-Za-z_][A-Za-z0-9_]*|\d+\.\d*(?:e-?\d+)?|\d+|'
                   r"<-|<=|>=|==|!=|&&|\|\||\.\.|\S", re.S)
KINDS = ("delete", "double", "swap", "unquote")
# Shares in percent of the trials with a syntax error, and the mean number of errors.
ON_THE_LINE, WITHIN_ONE, ALONE, MEAN_ERRORS = 97.0, 98.0, 90.0, 1.2


def sources():
    """(name, text) of sound files, in a fixed order."""
    for folder in ("models", "stdlib"):
        for path in sorted((ROOT / folder).rglob("*.bip")):
            yield path.name, path.read_text(encoding="utf-8")
    for golden in sorted((ROOT / "tests/golden").rglob("*.golden")):
        if golden.name.startswith("fail_"):
            continue
        parts = re.split(r"^--- (.*)$", golden.read_text(encoding="utf-8", errors="replace"), flags=re.M)
        for head, body in zip(parts[1::2], parts[2::2]):
            if head.startswith("file ") and head.endswith(".bip"):
                yield pathlib.Path(head.split()[1]).name, body[1:]


def tokens(text):
    """(begin, end) of tokens, comments left out."""
    return [m.span() for m in TOKEN.finditer(text) if not m.group().startswith(("//", "/*"))]


def slip(text, spans, kind, at):
    """The text with the slip, and the lines between which it is; None if the kind does not apply there."""
    begin, end = spans[at]
    before = spans[at - 1][1] if at > 0 else 0
    after = spans[at + 1][0] if at + 1 < len(spans) else len(text)
    line = lambda offset: text.count("\n", 0, offset) + 1
    if kind == "delete":
        return text[:begin] + text[end:], line(before), line(after)
    if kind == "double":
        return text[:end] + " " + text[begin:end] + text[end:], line(begin), line(after)
    if kind == "unquote":
        return (text[:end - 1] + text[end:], line(begin), line(begin)) if text[begin] == '"' else None
    if at + 1 >= len(spans) or text[begin:end] == text[slice(*spans[at + 1])]:
        return None
    b, e = spans[at + 1]
    last = spans[at + 2][0] if at + 2 < len(spans) else len(text)
    return text[:begin] + text[b:e] + text[end:b] + text[begin:end] + text[e:], line(before), line(last)


def check(work, name, text):
    with tempfile.TemporaryDirectory(dir=work) as folder:
        path = pathlib.Path(folder) / name
        path.write_text(text, encoding="utf-8")
        done = subprocess.run([BIPC, "check", "--diagnostics=json", str(path)], capture_output=True, text=True, timeout=60)
    if done.returncode not in (0, 1, 2, 3, 4):
        return None
    found = [json.loads(l) for l in done.stderr.splitlines() if l.startswith("{")]
    return [d for d in found if d.get("severity") == "error"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=KINDS)
    parser.add_argument("--list", action="store_true")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    random_ = random.Random(options.seed)
    files = [(n, t) for n, t in sources() if not options.names or any(w in n for w in options.names)]
    files = [(n, t, spans) for n, t in files if len(t) < 20_000 and (spans := tokens(t))]
    work = tempfile.mkdtemp(prefix="slips")
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        sound = [f for f, errors in zip(files, pool.map(lambda f: check(work, f[0], f[1]), files)) if errors == []]
        trials = []
        while len(trials) < options.count:
            name, text, spans = random_.choice(sound)
            kind = options.only or random_.choice(("delete", "delete", "double", "swap", "unquote"))
            at = random_.randrange(len(spans))
            if kind == "unquote":
                quoted = [i for i, (b, _) in enumerate(spans) if text[b] == '"']
                at = random_.choice(quoted) if quoted else at
                kind = kind if quoted else "delete"
            made = slip(text, spans, kind, at)
            if made is not None:
                trials.append((name, kind, text[slice(*spans[at])], *made))
        answers = list(pool.map(lambda t: check(work, t[0], t[3]), trials))
    os.rmdir(work)
    return report(options, trials, answers)


def report(options, trials, answers):
    outcomes = collections.Counter()
    per_kind = collections.defaultdict(collections.Counter)
    numbers = collections.Counter()
    crashed = 0
    for (name, kind, token, text, low, high), errors in zip(trials, answers):
        if errors is None:
            crashed += 1
            print(f"{name}: {kind} {token!r} at line {low}: bipc did not answer")
            continue
        if not errors or not errors[0]["code"].startswith("B0"):
            outcomes["sound" if not errors else "names and types"] += 1
            continue
        outcomes["syntax"] += 1
        numbers[min(len(errors), 6)] += 1
        line = errors[0]["range"]["line"]
        off = max(low - line, line - high, 0)
        where = "on the line" if off == 0 else "within one line" if off == 1 else "elsewhere"
        per_kind[kind][where] += 1
        per_kind[kind]["errors"] += len(errors)
        per_kind[kind]["alone"] += len(errors) == 1
        if options.list and (off > 0 or len(errors) > 1):
            print(f"== {name} {low}-{high}: {kind} `{token}`: {where}, {len(errors)} errors")
            for number, shown in enumerate(text.splitlines(), 1):
                if low - 1 <= number <= high + 1:
                    print(f"    {number:4} {shown}")
            for e in errors[:4]:
                print(f"   {e['range']['line']}:{e['range']['column']} {e['code']} {e['message']}")
    total = collections.Counter()
    for kind in KINDS:
        total.update(per_kind[kind])
        print_row(kind, per_kind[kind])
    on_line, within, alone, mean = print_row("all", total)
    print(f"syntax {outcomes['syntax']}, names and types {outcomes['names and types']}, sound {outcomes['sound']}; errors a file: "
          + ", ".join(f"{n}{'+' if n == 6 else ''}: {numbers[n]}" for n in sorted(numbers)))
    bad = crashed > 0 or (not options.only and not options.names and
                          (on_line < ON_THE_LINE or within < WITHIN_ONE or alone < ALONE or mean > MEAN_ERRORS))
    print(f"slips: {len(trials) - bad} passed, {int(bad)} failed")
    return 1 if bad else 0


def print_row(title, counts):
    n = sum(counts[w] for w in ("on the line", "within one line", "elsewhere")) or 1
    row = (100 * counts["on the line"] / n, 100 * (n - counts["elsewhere"]) / n, 100 * counts["alone"] / n, counts["errors"] / n)
    print(f"{title:8} {n:5} syntax errors: on the line {row[0]:5.1f} %, within one {row[1]:5.1f} %, alone {row[2]:5.1f} %, mean {row[3]:.2f}")
    return row


if __name__ == "__main__":
    sys.exit(main())
