#!/usr/bin/env python3
"""Every model on every executor: traces must be the same bytes.

    tests/models/test_models.py [--seeds N] [--first N] [--limit N] [--jobs N] [--verdicts|--no-verdicts] [part of a model's name ...]

Each models/**/*.bip runs with the interpreter, the JIT at -O0 and -O2, and as an emitted C++ program, with N seeds.
Compared: the JSON trace, standard output, standard error, exit code. A header line `// run: --root 'Ring(5)' …` gives
arguments; several such lines give several runs. A model without a root of its own needs one, there or in a comment that
says how to run it: (--root 'Ring(1000)'). `// run: none` marks a package that others use.

Verdicts: `// verify: free|deadlock|holds|violated|unknown [options]`, as many as one likes, say how `bipc verify` must answer. Every
system in VERDICTS needs one. Where the answer is `free` or `holds`, certcheck must accept its certificate; proofs that have none that it can check are listed, with the reason. Python's library only.
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests"))
import certificates  # noqa: E402
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
CERTCHECK = BUILD / "certcheck"  # not built without Z3
ROOT_IN_COMMENT = re.compile(r"^//.*--root '([^']+)'", re.M)
CPP_SOURCES = re.compile(r'^@cpp\(.*src="([^"]*)"', re.M)
RUN_LINE = re.compile(r"^// run:(.*)$", re.M)
EMBED_LINE = re.compile(r"^// embed: (\S+)$", re.M)
VERIFY_LINE = re.compile(r"^// verify:\s*(\S+)(.*)$", re.M)
EXIT_OF_VERDICT = {"free": 0, "deadlock": 3, "holds": 0, "violated": 3, "unknown": 4}
VERDICTS = ("models/classic/", "models/dala/", "models/liveness/", "models/protocol/", "models/scaling/", "models/sizes/")
VERIFY_TIMEOUT = 300
TIMEOUT = 120
WITH_VALUE = ("--root", "--policy", "--limit", "--seed", "--trace-format")


def executors():
    yield "interp", ["--backend", "interp"]
    has_jit = "jit" in subprocess.run([BIPC, "version"], capture_output=True, text=True).stdout
    if has_jit:
        yield "jit -O0", ["--backend", "jit", "-O0"]
        yield "jit -O2", ["--backend", "jit", "-O2"]


def compiler():
    wanted = (os.environ.get("BIPC_TEST_CXX") or os.environ.get("CXX", "g++")).split()
    return (["ccache"] if shutil.which("ccache") and "ccache" not in wanted[0] else []) + wanted


def split_arguments(arguments):
    """What belongs to the compilation (--root) and what to the run."""
    root, run = [], []
    it = iter(arguments)
    for a in it:
        target = root if a.startswith("--root") else run
        target.append(a)
        if a in WITH_VALUE:
            target.append(next(it))
    return root, run


def compile_emitted(model, root, work):
    """The program, or what went wrong."""
    source, program = work / "model.cpp", work / "model"
    emitted = subprocess.run([BIPC, "emit", "--emit=cpp", *root, str(model)], capture_output=True, timeout=TIMEOUT)
    if emitted.returncode != 0:
        return None, f"bipc emit ends with {emitted.returncode}\n{emitted.stderr.decode('utf-8', 'replace')}"
    source.write_bytes(emitted.stdout)
    unit = work / "model.o"
    # The C++ side that `@cpp` names, relative to the model's folder.
    cpp = CPP_SOURCES.findall(model.read_text(encoding="utf-8"))
    extra = [str(model.parent / name) for names in cpp for name in names.split(",")]
    flags = ["-std=c++20", "-O1", "-I", str(ROOT / "runtime/include"), "-I", str(ROOT), "-I", str(model.parent)]
    for command in ([*compiler(), *flags, "-c", str(source), "-o", str(unit)],
                    [*compiler(), "-std=c++20", str(unit), *extra, str(BUILD / "libbip_runtime.a"), "-pthread", "-o", str(program)]):
        done = subprocess.run(command, capture_output=True, timeout=10 * TIMEOUT)
        if done.returncode != 0:
            return None, f"{' '.join(command[:2])} fails\n{done.stderr.decode('utf-8', 'replace')[:3000]}"
    return program, None


def check_embedding(model, program, work):
    """A C++ program beside the model that runs it: what went wrong, or nothing."""
    source, built = work / "embedded.cpp", work / "embedded"
    emitted = subprocess.run([BIPC, "emit", "--emit=cpp", str(model)], capture_output=True, timeout=TIMEOUT)
    source.write_bytes(emitted.stdout)
    flags = ["-std=c++20", "-O1", "-Wall", "-Wextra", "-DBIP_NO_MAIN", "-I", str(ROOT / "runtime/include"), "-I", str(ROOT)]
    done = subprocess.run([*compiler(), *flags, str(source), str(model.parent / program), str(BUILD / "libbip_runtime.a"), "-pthread", "-o", str(built)],
                          capture_output=True, timeout=10 * TIMEOUT)
    if emitted.returncode == 0 and done.returncode == 0:
        done = subprocess.run([str(built)], capture_output=True, timeout=TIMEOUT)
    if emitted.returncode or done.returncode:
        return f"{program} ends with {done.returncode}\n{(done.stdout + done.stderr).decode('utf-8', 'replace')[:3000]}"
    return None


def without_source(text):
    """Below a run-time error `bipc run` shows the line of the model, which an emitted program does not have."""
    return re.sub(rb"^ +-->", b"  -->", re.sub(rb"^ *[0-9]* *\|.*\n", b"", text, flags=re.M), flags=re.M)


def outcome(command, work):
    trace = work / "trace"
    trace.unlink(missing_ok=True)
    done = subprocess.run([*command, "--trace", str(trace)], capture_output=True, timeout=TIMEOUT, stdin=subprocess.DEVNULL)
    return {"trace": trace.read_bytes() if trace.exists() else b"", "stdout": done.stdout, "stderr": without_source(done.stderr),
            "exit code": done.returncode}


def difference(a, b):
    for key in a:
        if a[key] != b[key]:
            if isinstance(a[key], int):
                return f"{key} {a[key]} and {b[key]}"
            left, right = a[key].splitlines(), b[key].splitlines()
            for n, (x, y) in enumerate(zip(left, right), 1):
                if x != y:
                    return f"{key} line {n}:\n    {x[:300].decode('utf-8', 'replace')}\n    {y[:300].decode('utf-8', 'replace')}"
            return f"{key}: {len(left)} and {len(right)} lines"
    return None


def check_verdicts(model, text, name):
    """(verdicts as expected, problems)"""
    good, problems = 0, []
    lines = VERIFY_LINE.findall(text)
    if not lines and name.startswith(VERDICTS):
        problems.append(f"{name}: no line `// verify: free|deadlock|holds|violated|unknown`")
    for verdict, arguments in lines:
        if verdict not in EXIT_OF_VERDICT:
            problems.append(f"{name}: `// verify: {verdict}` is no verdict")
            continue
        command = [BIPC, "verify", "--no-reuse", "--timeout", str(VERIFY_TIMEOUT), *shlex.split(arguments), str(model)]
        try:
            done = subprocess.run(command, capture_output=True, timeout=2 * VERIFY_TIMEOUT, stdin=subprocess.DEVNULL)
        except subprocess.TimeoutExpired:
            problems.append(f"{name}: `bipc verify{arguments}` does not end within {2 * VERIFY_TIMEOUT} s")
            continue
        if done.returncode == EXIT_OF_VERDICT[verdict]:
            good += 1
            if verdict in ("free", "holds") and CERTCHECK.exists():
                # Of zones more than this take certcheck minutes; bipc refuses such a certificate by name.
                memory = ["--memory", "64"] if name.startswith("models/timed") else []
                problem = certificates.problem_of_certificate(BIPC, CERTCHECK,
                                                              ["--timeout", str(VERIFY_TIMEOUT), *memory, *shlex.split(arguments), str(model)],
                                                              timeout=10 * VERIFY_TIMEOUT)
                good += 0 if problem else 1
                problems += [f"{name}: `bipc verify{arguments}`: {problem}"] if problem else []
        else:
            problems.append(f"{name}: `bipc verify{arguments}` ends with {done.returncode}, expected {verdict}\n"
                            + (done.stdout + done.stderr).decode("utf-8", "replace")[-1500:])
    return good, problems


def check_model(model, options, execs):
    """(runs that agree, problems)"""
    name = model.relative_to(ROOT).as_posix() if ROOT in model.parents else str(model)
    good, problems = 0, []
    text = model.read_text(encoding="utf-8")
    if [line.strip() for line in RUN_LINE.findall(text)] == ["none"]:
        done = subprocess.run([BIPC, "check", str(model)], capture_output=True, timeout=TIMEOUT)
        if done.returncode == 0 and not done.stderr:
            return 1, []
        return 0, [f"{name}: `bipc check` ends with {done.returncode}\n{done.stderr.decode('utf-8', 'replace')[:2000]}"]
    if options.verdicts:
        good, problems = check_verdicts(model, text, name)
    if options.verdicts == "only" or problems:
        return good, problems
    for program in EMBED_LINE.findall(text):
        with tempfile.TemporaryDirectory(prefix="models-") as folder:
            problem = check_embedding(model, program, pathlib.Path(folder))
        good += 0 if problem else 1
        problems += [f"{name}: {problem}"] if problem else []
    variants = [shlex.split(m) for m in RUN_LINE.findall(text)] or [[]]
    if variants == [[]] and b"B4003" in subprocess.run([BIPC, "run", "--limit", "0", str(model)], capture_output=True).stderr:
        variants = [["--root", root] for root in ROOT_IN_COMMENT.findall(text)] or [[]]
    for arguments in variants:
        root, run = split_arguments(arguments)
        with tempfile.TemporaryDirectory(prefix="models-") as folder:
            work = pathlib.Path(folder)
            program, problem = compile_emitted(model, root, work)
            if problem:
                problems.append(f"{name} {shlex.join(arguments)}: emitted C++: {problem}")
            commands = [(n, [BIPC, "run", str(model), *root, *run, *flags]) for n, flags in execs]
            if program:
                commands.append(("emitted", [str(program), *run]))
            for seed in range(options.first, options.first + options.seeds):
                common = ["--seed", str(seed), *([] if "--limit" in run else ["--limit", str(options.limit)])]
                first_name, first = None, None
                for executor, command in commands:
                    try:
                        found = outcome([*command, *common], work)
                    except subprocess.TimeoutExpired:
                        problems.append(f"{name} {shlex.join(arguments)} seed {seed}: {executor}: no end within {TIMEOUT} s")
                        continue
                    bad = found["exit code"] not in (0, 1) or not found["trace"]
                    if bad:
                        problems.append(f"{name} {shlex.join(arguments)} seed {seed}: {executor} ends with {found['exit code']}\n"
                                        + found["stderr"].decode("utf-8", "replace")[:2000])
                    elif first is None:
                        first_name, first = executor, found
                        good += 1
                    elif difference(first, found):
                        problems.append(f"{name} {shlex.join(arguments)} seed {seed}: {first_name} and {executor} differ in "
                                        + difference(first, found))
                    else:
                        good += 1
                if problems:
                    break
    return good, problems


def main():
    parser = argparse.ArgumentParser(description="Runs every model on every executor.")
    parser.add_argument("--seeds", type=int, default=3, help="of each, runs with the seeds from --first on")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--limit", type=int, default=500)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--no-verdicts", dest="verdicts", action="store_const", const=None, default="too", help="runs only")
    parser.add_argument("--verdicts", dest="verdicts", action="store_const", const="only", help="no runs, only verdicts")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="of N models, in the order of their names, only the first")
    parser.add_argument("what", nargs="*", help="parts of models' names, or files")
    options = parser.parse_args()
    if not os.access(BIPC, os.X_OK):
        sys.exit(f"models: no program at {BIPC}")
    models = sorted((ROOT / "models").rglob("*.bip"))
    if options.what:
        models = [m for m in models if any(w in str(m.relative_to(ROOT)) for w in options.what)] or \
            [pathlib.Path(w).resolve() for w in options.what]
    if options.every < 1:
        parser.error("--every takes a number from 1 on")
    models = models[::options.every]
    execs = list(executors())
    passed = failed = 0
    with concurrent.futures.ThreadPoolExecutor(max_workers=options.jobs) as pool:
        for good, problems in pool.map(lambda m: check_model(m, options, execs), models):
            passed += good
            failed += len(problems)
            for problem in problems:
                print("FAILED " + problem.replace("\n", "\n  "), flush=True)
    certificates.print_passed_over()
    print(f"models: {passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
