#!/usr/bin/env python3
"""`bipc verify` and `bipc explore` answer alike on every model.

    tests/models/test_agreement.py [--timeout SECONDS] [--jobs N] [part of a model's name ...]

For each models/**/*.bip with each of its roots (as test_models.py finds them) both are asked for deadlocks and for
errors. Compared are answers: what the explorer has visited as a whole, or has found before a limit, against the prover's
verdict. A question that the explorer has answered and the prover has not is a failure, too, unless the line
`// agreement: unknown REASON` of the model says why. Python's library only.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from test_models import BIPC, ROOT, ROOT_IN_COMMENT, RUN_LINE, split_arguments  # noqa: E402

UNKNOWN_LINE = re.compile(r"^// agreement: unknown (\S.*)$", re.M)
STATES = 300000


def roots_of(model, text):
    lines = [line.strip() for line in RUN_LINE.findall(text)]
    if lines == ["none"]:
        return []
    roots = [split_arguments(shlex.split(line))[0] for line in lines] or [[]]
    if roots == [[]] and b"B4003" in subprocess.run([BIPC, "check", str(model), "--emit=system"], capture_output=True).stderr:
        roots = [["--root", root] for root in ROOT_IN_COMMENT.findall(text)] or [[]]
    return [list(root) for root in dict.fromkeys(map(tuple, roots))]


def answer_of(command, timeout):
    """The JSON object that the command prints last, and its exit code."""
    done = subprocess.run(command, capture_output=True, timeout=20 * timeout + 100, stdin=subprocess.DEVNULL)
    for line in reversed(done.stdout.decode("utf-8", "replace").splitlines()):
        if line.startswith("{"):
            return json.loads(line), done.returncode
    return {"stderr": done.stderr.decode("utf-8", "replace")[-800:]}, done.returncode


def explored(answer):
    """Deadlocks and errors as the explorer knows them: True, False, or None."""
    if "end" not in answer:
        return None, None
    complete = answer["end"] == "complete"
    stuck = answer.get("deadlocks", 0) + answer.get("time_locks", 0) > 0
    failed = answer.get("errors", 0) > 0
    return (True if stuck else False if complete else None), (True if failed else False if complete else None)


def proved(answer):
    verdict = answer.get("verdict")
    return {"deadlock": True, "time lock": True, "error": True, "violated": True, "deadlock-free": False, "no-error": False,
            "error-free": False, "holds": False}.get(verdict)


def check_model(model, options):
    name = model.relative_to(ROOT).as_posix()
    text = model.read_text(encoding="utf-8")
    may_be_unknown = UNKNOWN_LINE.search(text) is not None
    compared, problems = 0, []
    for root in roots_of(model, text):
        common = [*root, "--timeout", str(options.timeout), "--json", str(model)]
        seen, code = answer_of([BIPC, "explore", "--limit", str(STATES), *common], options.timeout)
        for question, known in zip(("deadlock", "errors"), explored(seen)):
            said, verify_code = answer_of([BIPC, "verify", "--no-reuse", "--property", question, *common], options.timeout)
            told = proved(said)
            if options.show:
                print(f"{name} {shlex.join(root)} {question}: explore {known} ({seen.get('end')}, {code}), "
                      f"verify {told} ({said.get('verdict')}, {verify_code}) {said.get('stderr', '')}", flush=True)
            if known is not None and told is not None:
                compared += 1
            if known is not None and told != known and not (told is None and may_be_unknown):
                problems.append(f"{name} {shlex.join(root)}: {question}: explore says {known}, verify {told}\n"
                                f"{json.dumps(seen)[:600]}\n{json.dumps(said)[:600]}")
            elif known is None and told is None and code not in (0, 1, 3, 4):
                problems.append(f"{name} {shlex.join(root)}: bipc explore ends with {code}\n{seen.get('stderr', '')}")
    return compared, problems


def main():
    parser = argparse.ArgumentParser(description="Compares the prover's answers with the explorer's on every model.")
    parser.add_argument("--timeout", type=int, default=10, help="seconds of each question")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--show", action="store_true", help="print every answer")
    parser.add_argument("what", nargs="*", help="parts of models' names")
    options = parser.parse_args()
    if not os.access(BIPC, os.X_OK):
        sys.exit(f"agreement: no program at {BIPC}")
    models = [m for m in sorted((ROOT / "models").rglob("*.bip"))
              if not options.what or any(w in str(m.relative_to(ROOT)) for w in options.what)]
    passed = failed = 0
    with concurrent.futures.ThreadPoolExecutor(max_workers=options.jobs) as pool:
        for compared, problems in pool.map(lambda m: check_model(m, options), models):
            passed += compared
            failed += len(problems)
            for problem in problems:
                print("FAILED " + problem.replace("\n", "\n  "), flush=True)
    print(f"agreement: {passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
