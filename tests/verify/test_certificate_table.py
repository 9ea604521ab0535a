#!/usr/bin/env python3
"""No verdict that holds without a certificate, unless the table in compiler/docs/verification.md names it.

    tests/verify/test_certificate_table.py [part of a row ...]

The table "verdict that holds | --certificate" must have exactly the rows of ROWS. Each has questions that hold, and what becomes of them with --certificate:
`accepted` by certcheck (of the method that the row names), `counted` (the number of states, which certcheck calls not checkable), `refused` (B1900), or
`unknown`. Python's library only. To see it go red: delete a row of the table, or let `certificate` in compiler/verify/evidence/certificate.cpp return an empty text.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
CERTCHECK = pathlib.Path(BIPC).with_name("certcheck")  # not built without Z3
PAGE = ROOT / "compiler/docs/verification.md"
MODELS, GOLDENS = ROOT / "models", ROOT / "tests/golden/verify"
TIMEOUT = 300 * float(os.environ.get("BIPC_TEST_PATIENCE") or 1)

LANE = "never (into[0]@FULL || into[0]@FULL_NEXT) && into[0].round != out[0].round && into[0].bit != out[0].bit"
AGREEMENT = "never proposer[0]@CHOSEN && proposer[1]@CHOSEN && proposer[0].value != proposer[1].value"
# By row of the table: model, arguments, what becomes of it, how a line of the certificate begins.
ROWS = {
    "deadlock-free, error-free, `never` and `always` of a state: by invariants or induction": [
        ("classic/philosophers_safe.bip", ["--root", "Table(5)"], "accepted", "method invariants"),
        ("scaling/sliding_window.bip", ["--root", "Window(12)", "--property", LANE], "accepted", "method induction"),
        ("scaling/sliding_window.bip", ["--root", "Window(20)", "--property", "never sink.is_wrong"], "accepted", "method induction")],
    "the same, by a visit of all states": [
        ("sizes/semaphore.bip", ["--root", "Shared(3)", "--property", "errors"], "accepted", None),
        ("free_by_exhaustion.golden", [], "counted", "method exhaustive")],
    "the same, by a visit up to [symmetry](#symmetry)": [
        ("scaling/paxos.bip", ["--root", "Synod(4, 3)", "--property", AGREEMENT.replace("proposer[1]", "proposer[2]") + " || can prepare[0] && proposer[0]@CHOSEN"], "accepted", "state ")],
    "`never` and `always` of a state, by [counting](#counting)": [
        ("scaling/paxos.bip", ["--root", "Synod(40, 2)", "--property", AGREEMENT], "accepted", "bound 40 ")],
    "`never` and `always` of a state, deadlock-free, by [regions of values](#regions-of-values)": [
        ("scaling/filter_lock.bip", ["--root", "Lock(24)"], "accepted", "unless "),
        ("scaling/filter_lock.bip", ["--root", "Lock(8)", "--timeout", "12", "--property", "never process[0]@CRITICAL && process[1]@CRITICAL"], "unknown", None)],
    "the same, of a model whose C++ was left out": [
        ("unread_cpp.golden", ["--property", "never a.n > 5"], "accepted", "method induction")],
    "properties of runs, invariants that look back": [
        ("liveness/philosophers_queue.bip", ["--root", "Table(3)", "--property", "phil[0]@HUNGRY leads to phil[0]@EATS", "--fair", "weak"], "accepted", "state "),
        ("runs_k_liveness.golden", ["--property", "p[3]@WAITS leads to p[3]@BUSY", "--fair", "strong", "--memory", "20"], "accepted", "rounds "),
        ("liveness/train_gate.bip", ["--root", "Crossing(3)", "--property", "always eventually train[0]@CROSSES", "--fair", "strong:approaches[0]"], "accepted", "fairness strong:connector:"),
        ("runs_k_liveness.golden", ["--property", "p[3]@WAITS leads to p[3]@BUSY under strong:begin[3],weak:key[1]", "--memory", "20"], "accepted", "turn strong:connector:"),
        ("scaling/filter_lock.bip", ["--root", "Lock(6)", "--timeout", "4", "--memory", "50", "--fair", "weak", "--property", "process[0]@ENTERS leads to process[0]@CRITICAL"], "unknown", None)],
    "the same, of a model with time": [
        ("timed/train_gate.bip", ["--root", "Crossing(2)"], "accepted", "method zones"),
        ("fail_certificate_of_time.golden", ["--root", "Weighs()"], "refused", None),
        ("fail_certificate_of_time.golden", ["--root", "Counts()", "--memory", "2"], "refused", None)],
    "a property of two of many like components with time, by pairs": [
        ("scaling/fischer.bip", ["--root", "Group(40)", "--property", "never process[7]@CRITICAL && process[22]@CRITICAL"], "accepted", "method pairs")],
    "branching time (`possibly`)": [
        ("classic/philosophers_safe.bip", ["--root", "Table(3)", "--property", "always possibly phil[0]@EATS"], "accepted", "claim branches "),
        ("fail_branching_not_supported.golden", ["--root", "Warm()", "--property", "possibly l@LIT"], "refused", None)],
    "the same, of one word with time or fairness": [
        ("fail_branching_not_supported.golden", ["--root", "Timed()", "--property", "possibly l@LIT"], "refused", None),
        ("fail_branching_not_supported.golden", ["--root", "Lazy()", "--fair=weak", "--property", "possibly always l@DARK || l@LIT"], "refused", None)],
    "limits of time (`within`)": [
        ("certificate_of_response.golden", ["--property", "p@CALLED leads to p@RUNS within 20 ms"], "accepted", "method zones")],
    "properties of runs without a limit, of a model with time": [
        ("runs_with_time.golden", ["--property", "always eventually a@LIT"], "accepted", "zone rank="),
        ("runs_with_time_resume.golden", ["--property", "happens bake leads to happens open"], "accepted", "returns ")],
    "invariants that look back, of a model with time": [
        ("fail_runs_with_time_past_certificate.golden", ["--property", "always (happens hold implies once happens press)"], "refused", None)],
    "`--for-all n`": [
        ("sizes/token_ring.bip", ["--for-all", "n"], "accepted", None)],
    "`--partial`": [
        ("classic/philosophers_safe.bip", ["--root", "Table(3)", "--partial"], "accepted", "state ")],
    "`--partial` of a model with time": [
        ("timed/two_rods.bip", ["--partial"], "refused", None)],
}


def table_rows():
    """The first cells of the table's rows."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    start = lines.index("| verdict that holds | `--certificate` |") + 2
    rows = []
    for line in lines[start:]:
        if not line.startswith("| "):
            break
        rows.append(line.split(" | ")[0][2:])
    return rows


def model_file(name, work):
    if not name.endswith(".golden"):
        return MODELS / name
    text = (GOLDENS / name).read_text(encoding="utf-8")
    found = re.search(r"^--- file (\S+\.bip)\n(.*?)(?=^--- )", text, re.M | re.S)
    path = pathlib.Path(work) / found[1]
    path.write_text(found[2], encoding="utf-8")
    return path


def run(command):
    return subprocess.run(command, capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL, timeout=TIMEOUT)


def problem_of(name, arguments, expected, line):
    with tempfile.TemporaryDirectory(prefix="certificate-table-") as work:
        model, certificate, system = str(model_file(name, work)), pathlib.Path(work) / "c.cert", pathlib.Path(work) / "c.bsys"
        if expected != "refused" and run([BIPC, "verify", "--no-reuse", *arguments, model]).returncode != 0:
            return "does not hold"
        asked = run([BIPC, "verify", "--no-reuse", "--certificate", str(certificate), *arguments, model])
        told = (asked.stdout + asked.stderr).strip()[-400:]
        if expected == "refused":
            return None if asked.returncode == 1 and "error[B1900]: a certificate for" in asked.stderr and not certificate.exists() else f"is not refused: {told}"
        if expected == "unknown":
            return None if asked.returncode == 4 and not certificate.exists() else f"is not unknown: {told}"
        if asked.returncode != 0 or not certificate.exists():
            return f"no certificate, exit code {asked.returncode}: {told}"
        if line and not any(told.startswith(line) for told in certificate.read_text(encoding="utf-8").splitlines()):
            return f"the certificate has no line `{line}…`"
        if not CERTCHECK.exists():
            return None
        sized = arguments[:2] if "--for-all" in arguments else []
        roots = arguments[arguments.index("--root"):][:2] if "--root" in arguments else []
        made = run([BIPC, *(["verify", *sized] if sized else ["check"]), "--emit=system", *roots, model])
        system.write_text(made.stdout, encoding="utf-8")
        checked = run([str(CERTCHECK), str(system), str(certificate)])
        code = {"accepted": 0, "counted": 4}[expected]
        return None if checked.returncode == code else f"certcheck ends with {checked.returncode}: {(checked.stdout + checked.stderr).strip()[-400:]}"


def main():
    problems = []
    rows = table_rows()
    problems += [f"{PAGE.name}: row `{row}` has no question here" for row in rows if row not in ROWS]
    problems += [f"{PAGE.name}: no row `{row}`" for row in ROWS if row not in rows]
    asked = 0
    for row, questions in ROWS.items():
        if sys.argv[1:] and not any(part in row for part in sys.argv[1:]):
            continue
        for name, arguments, expected, line in questions:
            asked += 1
            try:
                problem = problem_of(name, arguments, expected, line)
            except subprocess.TimeoutExpired as over:
                problem = f"no end within {TIMEOUT} s: {over.cmd[:2]}"
            if problem:
                problems.append(f"{row}: {name} {' '.join(arguments)}: {problem}")
    for problem in problems:
        print(problem)
    print(f"{asked} questions of {len(rows)} rows")
    print(f"certificates: {max(asked - len(problems), 0)} passed, {len(problems)} failed")
    return 1 if problems or asked == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
