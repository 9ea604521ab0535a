#!/usr/bin/env python3
"""Runs all tests: every unit_* program, the goldens, the snippets, the meta-tests, the models, random systems.

tools/test calls it after a build. Each group prints one line "group: N passed, N failed"; what failed is shown, the
rest is in build/test-logs/. The last line is "N passed, N failed" over everything. Python's library only.
"""
import os
import pathlib
import re
import subprocess
import sys
import time
import xml.etree.ElementTree as xml

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
LOGS = BUILD / "test-logs"
SYSTEMS = re.compile(r"^differential: (\d+) systems, (\d+) failed$", re.M)
COUNTS = re.compile(r"^(?:\w+: )?(\d+) passed, (\d+) failed$", re.M)


def run_unit(program):
    """Counts of one Catch2 program, by test case; a crash counts as one failure."""
    report = LOGS / f"{program.name}.xml"
    with open(LOGS / f"{program.name}.log", "wb") as log:
        code = subprocess.run([str(program), "-r", "xml", "-o", str(report)], stdout=log, stderr=log).returncode
    try:
        cases = list(xml.parse(report).iter("TestCase"))
        bad = [c for c in cases if c.find("OverallResult") is None or c.find("OverallResult").get("success") != "true"]
    except (xml.ParseError, OSError):
        cases, bad = [], []
    if code != 0:
        # Once more, in words, for the person who reads this.
        text = subprocess.run([str(program)], capture_output=True).stdout.decode("utf-8", "replace")
        print("\n".join(text.splitlines()[-60:]))
    failed = max(len(bad), 1 if code != 0 else 0)
    return max(len(cases) - len(bad), 0), failed


def run_script(name, command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=ROOT)
    text = done.stdout.decode("utf-8", "replace")
    (LOGS / f"{name}.log").write_text(text, encoding="utf-8")
    counts = COUNTS.findall(text) + [(str(int(n) - int(bad)), bad) for n, bad in SYSTEMS.findall(text)]
    passed, failed = (sum(int(c[i]) for c in counts) for i in (0, 1)) if counts else (0, 0)
    if done.returncode != 0 or failed:
        print(text.rstrip())
        failed = max(failed, 1)
    return passed, failed


def groups():
    units = sorted(p for p in BUILD.glob("unit_*") if os.access(p, os.X_OK) and p.is_file())
    yield "unit", [(p.name, lambda p=p: run_unit(p)) for p in units]
    scripts = [("golden", "tests/golden/test_golden.py"), ("snippets", "tests/meta/test_snippets.py"), ("meta", "tests/meta/test_meta.py"), ("odd_inputs", "tests/meta/test_odd_inputs.py"),
               ("slips", "tests/slips/test_slips.py"), ("fmt", "tests/fmt/test_fmt.py"),
               ("models", "tests/models/test_models.py")]
    for name, script in scripts:
        yield name, [(name, lambda n=name, s=script: run_script(n, [sys.executable, str(ROOT / s)]))]
    os.environ["BIPC_BUILD_DIR"] = str(BUILD)
    yield "day", [("day", lambda: run_script("day", [sys.executable, str(ROOT / "tests/models/test_day.py"), "--steps", "6000000"]))]
    yield "genom", [("genom", lambda: run_script("genom", [sys.executable, str(ROOT / "tests/genom/test_genom.py")])),
                    ("dala", lambda: run_script("dala", [sys.executable, str(ROOT / "tests/genom/test_dala.py")])),
                    ("rules", lambda: run_script("rules", [sys.executable, str(ROOT / "tests/rules/test_rules.py")])),
                    ("mission", lambda: run_script("mission", [sys.executable, str(ROOT / "models/dala/run")]))]
    yield "serve", [("serve", lambda: run_script("serve", [sys.executable, str(ROOT / "tests/serve/test_serve.py")]))]
    yield "traces", [("traces", lambda: run_script("traces", [sys.executable, str(ROOT / "tests/traces/test_traces.py")]))]
    yield "debuggers", [("debuggers", lambda: run_script("debuggers", [sys.executable, str(ROOT / "tests/debuggers/test_debuggers.py")]))]
    if (BUILD / "bip-fuzz").exists():
        yield "fuzz", [("fuzz", lambda: run_script("fuzz", [sys.executable, str(ROOT / "tests/fuzz/test_fuzz.py")]))]
    if (BUILD / "bipc-lsp").exists():
        os.environ["BIPC_BUILD_DIR"] = str(BUILD)
        yield "lsp", [("lsp", lambda: run_script("lsp", [sys.executable, str(ROOT / "tests/lsp/test_lsp.py")]))]
    if (BUILD / "bip-gen").exists():
        os.environ["BUILD"] = str(BUILD)
        if (BUILD / "bip-verify-check").exists():
            yield "verify", [("verify", lambda: run_script("verify", [str(ROOT / "tests/verify/test_verify.sh")])),
                             ("terminal", lambda: run_script("terminal", [sys.executable, str(ROOT / "tests/verify/test_terminal.py")])),
                             ("exports", lambda: run_script("exports", [sys.executable, str(ROOT / "tests/verify/test_exports.py")]))]
        yield "differential", [("differential", lambda: run_script("differential", [str(ROOT / "tests/differential/test_differential.sh"), "500"])),
                               ("engines", lambda: run_script("engines", [str(ROOT / "tests/differential/test_engines.sh"), "100"]))]


def main():
    LOGS.mkdir(parents=True, exist_ok=True)
    # The user's own cache is none of ours.
    os.environ["XDG_CACHE_HOME"] = str(BUILD / "tests-cache")
    wanted = sys.argv[1:]
    unknown = set(wanted) - {name for name, _ in groups()}
    if unknown:
        sys.exit(f"test: no group {', '.join(sorted(unknown))}")
    total = [0, 0]
    for name, jobs in groups():
        if wanted and name not in wanted:
            continue
        start = time.monotonic()
        here = [0, 0]
        for _, job in jobs:
            passed, failed = job()
            here[0] += passed
            here[1] += failed
        if not jobs or sum(here) == 0:
            print(f"{name}: nothing ran")
            here[1] += 1
        print(f"{name}: {here[0]} passed, {here[1]} failed ({time.monotonic() - start:.1f} s)", flush=True)
        total = [total[0] + here[0], total[1] + here[1]]
    print(f"{total[0]} passed, {total[1]} failed", flush=True)
    return 1 if total[1] else 0


if __name__ == "__main__":
    sys.exit(main())
