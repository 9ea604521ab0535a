#!/usr/bin/env python3
"""`bipc fmt` over every sound file: twice is once, no word and no comment is lost.

    tests/fmt/test_fmt.py [--every N] [FILE ...]

Without files: models, stdlib and the files of goldens that check. For each: the formatted text is what its own formatting
gives; its tokens are those of the source, but for `;` (a statement has one, whether written or not), parentheses and commas
that house style adds or leaves out, and the order of a transition's parts; its comments are the source's, in their order.
"""
import collections
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests"))
from sample import take_every  # noqa: E402
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
FREE = {";", ",", "(", ")", "[", "]", "{", "}"}
# Spellings that mean the same, by what house style writes.
# `<-` counts as its two signs, for it may be written apart.
SAME = {"∧": "&&", "∨": "||", "¬": "!", "≤": "<=", "≥": ">=", "≠": "!=", "′": "'", "and": "&&", "or": "||", "not": "!"}


def run(*arguments):
    done = subprocess.run([BIPC, *arguments], capture_output=True, timeout=60)
    return done.returncode, done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace")


def words(path):
    """Counts of the tokens that fmt keeps, and the comments in their order."""
    _, text, _ = run("check", "--emit=tokens", path)
    tokens, comments = collections.Counter(), []
    for line in re.split(r"\n(?=\d+:\d+  )", text.rstrip("\n")):
        m = re.match(r"\d+:\d+  (\w+)  (.*)", line, re.S)
        if m is None:
            continue
        if m.group(1) == "COMMENT":
            comments.append(re.sub(r"\s+", " ", m.group(2)).strip())
        elif m.group(1) == "PROPERTY_TEXT":  # one token, whose blanks and line breaks are free
            tokens.update(m.group(2)[1:-1].split())
        elif m.group(2) not in FREE:
            for word in ("<", "-") if m.group(2) in ("<-", "←", ":=") else (SAME.get(m.group(2), m.group(2)),):
                tokens[word] += 1
    return tokens, comments


def problem(name, text):
    with tempfile.TemporaryDirectory() as folder:
        source, once = os.path.join(folder, "source.bip"), os.path.join(folder, "once.bip")
        pathlib.Path(source).write_text(text, encoding="utf-8")
        code, formatted, _ = run("fmt", source)
        if code != 0:
            return None
        pathlib.Path(once).write_text(formatted, encoding="utf-8")
        if run("fmt", once)[1] != formatted:
            return f"{name}: formatted twice it differs"
        if run("fmt", "--check", once)[0] != 0:
            return f"{name}: --check is not content with what fmt wrote"
        before, after = words(source), words(once)
        # Families `t₁, …, tₙ` become `t[*]`, and the older spelling of time today's.
        is_respelled = "₁" in text or re.search(r"\bclock \w+ unit 1 \w+", text) is not None
        if before[0] != after[0] and not is_respelled:
            return f"{name}: words differ: lost {dict(before[0] - after[0])}, new {dict(after[0] - before[0])}"
        if before[1] != after[1]:
            return f"{name}: comments differ: {[c for c in before[1] if c not in after[1]][:3]}"
        return ""


def sources():
    for folder in ("models", "stdlib"):
        for path in sorted((ROOT / folder).rglob("*.bip")):
            yield path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")
    for golden in sorted((ROOT / "tests/golden").rglob("*.golden")):
        parts = re.split(r"^--- (.*)$", golden.read_text(encoding="utf-8", errors="replace"), flags=re.M)
        for head, body in zip(parts[1::2], parts[2::2]):
            if head.startswith("file ") and head.endswith(".bip"):
                yield f"{golden.relative_to(ROOT).as_posix()}: {head.split()[1]}", body[1:]


def main():
    every, paths = take_every(sys.argv[1:])
    given = [(p, pathlib.Path(p).read_text(encoding="utf-8")) for p in paths]
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        answers = list(pool.map(lambda f: problem(*f), given or list(sources())[::every]))
    bad = [a for a in answers if a]
    for line in bad:
        print(line)
    looked_at = sum(a is not None for a in answers)
    print(f"fmt: {looked_at - len(bad)} passed, {len(bad)} failed")
    return 1 if bad or looked_at < (len(given) or 150 // every) else 0


if __name__ == "__main__":
    sys.exit(main())
