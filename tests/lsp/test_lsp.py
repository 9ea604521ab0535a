#!/usr/bin/env python3
"""Drives bipc-lsp over its standard input: sessions with expected answers, renames of every name, random edits,
broken messages.

    tests/lsp/test_lsp.py [--edits N] [--seed N] [part of a test's name ...]

Needs built bipc and bipc-lsp ($BIPC or build/bipc, the server beside it). Ends with "lsp: N passed, N failed"; each
test_* function, each renamed name, each random edit (twice: beside `bipc check`, and beside a new server) and each hundred broken messages is one. Python's library only.
"""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import client  # noqa: E402
import edits  # noqa: E402
import fresh  # noqa: E402
import malformed  # noqa: E402
import renames  # noqa: E402
import sessions  # noqa: E402

EDITED = ("classic/philosophers", "classic/reactive", "tutorial/auction", "tutorial/crossing", "classic/temperature", "tutorial/relay")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--edits", type=int, default=900)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("only", nargs="*")
    options = parser.parse_args()
    passed = failed = 0
    shown = 0

    def report(text):
        nonlocal shown
        shown += 1
        if shown <= 20:
            print(f"FAILED {text[:1500]}", flush=True)

    def wanted(name):
        return not options.only or any(o in name for o in options.only)

    for name, test in sorted(vars(sessions).items()):
        if not name.startswith("test_") or not wanted(name):
            continue
        try:
            test()
            passed += 1
        except (AssertionError, client.Gone, OSError, KeyError, TypeError, IndexError) as e:
            failed += 1
            report(f"{name}: {type(e).__name__}: {e}")
    models = client.ROOT / "models"
    if wanted("renames"):
        good, bad = renames.run(sorted(models.rglob("*.bip")), report)
        passed, failed = passed + good, failed + bad
    if wanted("edits"):
        chosen = [models / (name + ".bip") for name in EDITED]
        good, bad = edits.run(chosen, -(-options.edits // len(chosen)), options.seed, report)
        passed, failed = passed + good, failed + bad
    if wanted("fresh"):
        good, bad = fresh.run(sorted(models.rglob("*.bip")), max(2, options.edits // 100), options.seed, report)
        passed, failed = passed + good, failed + bad
    if wanted("large"):
        good, bad = fresh.run_large(max(4, options.edits // 30), options.seed, report)
        passed, failed = passed + good, failed + bad
    if wanted("malformed"):
        good, bad = malformed.run(5000, options.seed, report)
        passed, failed = passed + good, failed + bad
    if shown > 20:
        print(f"… and {shown - 20} more")
    print(f"lsp: {passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
