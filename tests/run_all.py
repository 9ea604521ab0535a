#!/usr/bin/env python3
"""Runs all tests: every unit_* program, the goldens, the snippets, the meta-tests, the models, random systems.

tools/test calls it after a build. As many programs run at a time as there are processors (BIPC_TEST_JOBS: another
number); those that measure time run by themselves, at the end. Each group prints one line "group: N passed, N failed";
what failed is shown, the rest is in build/test-logs/ (`seconds`: how long each program took). A program that was not built is a failure. The last line is
"N passed, N failed" over everything. Arguments choose groups (`verify`) or programs of one (`verify:exports`).
With --sample most programs get a part of their cases, and some do not run; a line before the last says which.
Python's library only.
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys
import threading
import time
import xml.etree.ElementTree as xml

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
LOGS = BUILD / "test-logs"
SYSTEMS = re.compile(r"^differential: (\d+) systems, (\d+) failed$", re.M)
SKIPPED = re.compile(r"^skipped: (.*)$", re.M)
COUNTS = re.compile(r"^(?:[\w ]+: )?(\d+) passed, (\d+) failed$", re.M)

RACES = LOGS / "races"  # reports of the thread sanitizer, one file for each process
TIME_LIMIT = 1800  # s of a program; the longest takes a third
LEFT_OUT = ["left out"]  # of a sample: the program takes long, and has no small part that says much
UNIT_SAMPLE = 4  # of so many test cases of a long program of unit tests a sample has one

skipped = []  # what scripts said that they left out, because a program of somebody else is not installed


def every_nth_case(program, n):
    """A file with the names of every n-th test case, for Catch2's option -f."""
    # Catch2 2, whose exit code is the number of cases; then Catch2 3.
    for listing in (["--list-test-names-only"], ["--list-tests", "--verbosity", "quiet"]):
        names = subprocess.run([str(program), *listing], capture_output=True, text=True).stdout.splitlines()
        names = [name.strip() for name in names if name.strip()]
        if len(names) >= n:
            break
    chosen = LOGS / f"{program.name}.cases"
    # A comma would end a name, and [ begin a tag.
    chosen.write_text("".join(re.sub(r"([][,])", r"\\\1", name) + "\n" for name in names[::n]), encoding="utf-8")
    return chosen


def run_unit(program, every=1):
    """Counts of one Catch2 program, by test case (of `every` only the first); a crash counts as one failure."""
    report = LOGS / f"{program.name}.xml"
    names = ["-f", str(every_nth_case(program, every))] if every > 1 else []
    with open(LOGS / f"{program.name}.log", "wb") as log:
        code = subprocess.run([str(program), *names, "-r", "xml", "-o", str(report)], stdout=log, stderr=log).returncode
    try:
        cases = list(xml.parse(report).iter("TestCase"))
        bad = [c for c in cases if c.find("OverallResult") is None or c.find("OverallResult").get("success") != "true"]
    except (xml.ParseError, OSError):
        cases, bad = [], []
    if code != 0:
        # Once more, in words, for the person who reads this.
        text = subprocess.run([str(program), *names], capture_output=True).stdout.decode("utf-8", "replace")
        print("\n".join(text.splitlines()[-60:]))
    failed = max(len(bad), 1 if code != 0 else 0)
    return max(len(cases) - len(bad), 0), failed


def wait_for(name, process):
    """Exit code of a program; one that does not end in time is interrupted, so that it ends what it has started, then killed."""
    try:
        return process.wait(TIME_LIMIT * float(os.environ.get("BIPC_TEST_PATIENCE") or 1))
    except subprocess.TimeoutExpired:
        print(f"{name}: it did not end in time", flush=True)
        process.send_signal(signal.SIGINT)
    try:
        process.wait(20)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    return 1


def run_script(name, command):
    path = LOGS / f"{name}.log"
    # Not through a pipe, which stays open for as long as anything runs that the program has left behind.
    with open(path, "wb") as log, subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, cwd=ROOT) as process:
        code = wait_for(name, process)
    text = path.read_text(encoding="utf-8", errors="replace")
    counts = COUNTS.findall(text) + [(str(int(n) - int(bad)), bad) for n, bad in SYSTEMS.findall(text)]
    passed, failed = (sum(int(c[i]) for c in counts) for i in (0, 1)) if counts else (0, 0)
    for reason in SKIPPED.findall(text):
        skipped.append(reason)
        print(f"{name}: skipped: {reason}", flush=True)
    if code != 0 or failed:
        print(text.rstrip())
        failed = max(failed, 1)
    return passed, failed


class Job:
    """One program of a group. `alone`: it measures the processor or the clock, so nothing runs beside it. `run_sample`: what
    a sample runs in its place, `run` itself unless it is given; None: a sample leaves it out."""

    def __init__(self, name, run, weight=1, alone=False, **sample):
        self.name, self.run, self.weight, self.alone = name, run, weight, alone
        self.run_sample = sample.get("run_sample", run)


def script(name, path, *arguments, weight=1, alone=False, sample=None):
    """`sample`: the arguments of a sampled run, or LEFT_OUT; without it a sample runs the same."""
    command = ["bash" if path.endswith(".sh") else sys.executable, str(ROOT / path)]

    def run():
        return run_script(name, [*command, *arguments])
    if sample is None:
        return Job(name, run, weight, alone)
    return Job(name, run, weight, alone, run_sample=None if sample is LEFT_OUT else lambda: run_script(name, [*command, *sample]))


def sampled(groups):
    """The groups with what a sample runs; the programs that it leaves out; those that have fewer cases in it."""
    kept, left_out, fewer = [], [], []
    for name, jobs in groups:
        left_out += [f"{name}:{job.name}" for job in jobs if job.run_sample is None]
        fewer += [f"{name}:{job.name}" for job in jobs if job.run_sample not in (None, job.run)]
        rest = [Job(job.name, job.run_sample, job.weight, job.alone) for job in jobs if job.run_sample is not None]
        if rest:
            kept.append((name, rest))
    return kept, left_out, fewer


def needs(binary, *jobs):
    """The jobs; if the program was not built, failures that say so."""
    if (BUILD / binary).exists():
        return list(jobs)

    def missing(job):
        print(f"{job.name}: no {BUILD / binary}: it was not built")
        return 0, 1
    return [Job(job.name, lambda job=job: missing(job)) for job in jobs]


def unit_jobs():
    """Each folder of tests/unit is a program; jit only where the build has LLVM. One that is missing is a failure."""
    if not (BUILD / "CMakeCache.txt").exists():
        sys.exit(f"test: {BUILD} is no build directory (tools/build makes one)")
    folders = sorted(p.name for p in (ROOT / "tests/unit").iterdir() if any(p.glob("*.cpp")))
    if build_option("BIPC_JIT") in ("OFF", "0", "FALSE", "NO"):
        print("unit_jit and all runs by machine code are left out: the build has no LLVM (BIPC_JIT=OFF)", flush=True)
        folders.remove("jit")
    if not (BUILD / "libbipc_zmq.so").exists():
        print("unit_zmq is left out: libzmq3-dev was not there when bipc was built", flush=True)
        folders.remove("zmq")
    weights = {"runtime": 40, "verify": 60, "explore": 50, "pipeline": 30, "jit": 30}
    for folder in folders:
        program = BUILD / f"unit_{folder}"
        sample = {"run_sample": lambda p=program: run_unit(p, UNIT_SAMPLE)} if folder in ("emit_cpp", "explore", "pipeline", "verify") else {}
        yield from needs(program.name, Job(folder, lambda p=program: run_unit(p), weights.get(folder, 2), alone=folder == "pipeline", **sample))


def timed_zone_jobs():
    """certcheck against zone graphs: a program of every build that has Z3, so that one that is missing is a failure."""
    if not (has_library("Z3_INC") and has_library("Z3_LIB")):
        print("timed zones are left out: libz3-dev was not there when bipc was built", flush=True)
        return []
    command = [str(BUILD / "bip-timed-certificates"), "--count"]
    return needs("bip-timed-certificates", Job("timed zones", lambda: run_script("timed zones", [*command, "150"]), 60,
                                               run_sample=lambda: run_script("timed zones", [*command, "25"])))


def has_library(name):
    """Did CMake find what the entry of its cache asks for?"""
    value = build_option(name)
    return value != "" and not value.endswith("-NOTFOUND")


def build_option(name):
    """A value of the build's CMake cache; empty if it is not there."""
    found = re.search(rf"^{name}:\w+=(.*)$", (BUILD / "CMakeCache.txt").read_text(), re.M)
    return found.group(1) if found else ""


def is_sanitized():
    return build_option("BIPC_SANITIZE") != ""


def groups(options):
    """(name, jobs) in the order in which they are reported."""
    os.environ["BIPC_BUILD_DIR"] = str(BUILD)
    os.environ["BUILD"] = str(BUILD)
    return [
        ("unit", list(unit_jobs())),
        ("golden", [script("golden", "tests/golden/test_golden.py", "--every", str(options.goldens_every), "--containing", options.goldens_containing, weight=45, sample=["--every", "10"])]),
        ("snippets", [script("snippets", "tests/meta/test_snippets.py", weight=10, sample=["--every", "8"])]),
        ("book", [script("book", "tests/book/test_book.py", weight=8)]),
        ("meta", [script("meta", "tests/meta/test_meta.py", weight=5), script("help_examples", "tests/meta/test_help_examples.py", weight=10, sample=["check", "run", "verify"])]),
        ("odd_inputs", [script("odd_inputs", "tests/meta/test_odd_inputs.py", weight=20, sample=["--every", "5"])]),
        ("mistakes", [script("mistakes", "tests/mistakes/test_mistakes.py", weight=8, sample=["connectors"])]),
        ("slips", [script("slips", "tests/slips/test_slips.py", weight=5, sample=["--count", "100"])]),
        ("fmt", [script("fmt", "tests/fmt/test_fmt.py", weight=10, sample=["--every", "10"])]),
        ("models", [script("models", "tests/models/test_models.py", weight=57, sample=["--every", "12"]),
                    script("agreement", "tests/models/test_agreement.py", "--timeout", "5", weight=25, sample=LEFT_OUT),
                    script("strings", "tests/models/test_strings.py", weight=8, sample=LEFT_OUT)]),
        ("day", [script("day", "tests/models/test_day.py", "--steps", "6000000", weight=14, sample=["--steps", "600000"])]),
        ("genom", [script("genom", "tests/genom/test_genom.py", weight=30, sample=["--scenarios", "50"]), script("dala", "tests/genom/test_dala.py", weight=30, sample=LEFT_OUT),
                   script("rules", "tests/rules/test_rules.py", weight=10, sample=["--sets", "12"]), script("constructs", "tests/genom/test_constructs.py", weight=3), script("codels", "tests/genom/test_c_codels.py", weight=10), script("cxx_codels", "tests/genom/test_cxx_codels.py", weight=10, sample=LEFT_OUT), script("remote_calls", "tests/genom/test_remote_calls.py", weight=10, sample=LEFT_OUT), script("mission", "tests/genom/test_mission.py", alone=True, sample=LEFT_OUT), script("crash", "tests/genom/test_mission.py", "--processes", "--mission", "models/dala/mission/crash.txt", alone=True, sample=LEFT_OUT), script("threads", "tests/genom/test_mission.py", "--processes", "--task-threads", alone=True, sample=LEFT_OUT), script("stones", "tests/genom/test_mission.py", "--rules", "models/dala/terrain.rules", "--mission", "models/dala/mission/terrain.txt", alone=True, sample=LEFT_OUT), script("faults", "tests/genom/test_dala_faults.py", alone=True, sample=LEFT_OUT), script("terrain", "tests/genom/test_dala_terrain.py", alone=True, sample=LEFT_OUT)]),
        ("serve", [script("serve", "tests/serve/test_serve.py", alone=True), script("stepping", "tests/serve/test_stepping.py"), script("places", "tests/serve/test_places.py"), script("requests", "tests/serve/test_requests.py"), script("watchdog", "tests/serve/test_watchdog.py", alone=True, sample=LEFT_OUT), script("built", "tests/serve/test_built.py", weight=10, sample=LEFT_OUT), script("processes", "tests/serve/test_processes.py", weight=10, sample=LEFT_OUT), script("task threads", "tests/serve/test_task_threads.py", alone=True, sample=LEFT_OUT)]),
        ("ros1", [script("component", "tests/ros1/test_ros1.py", alone=True, sample=LEFT_OUT), script("rviz", "tests/ros1/test_rviz.py", alone=True, sample=LEFT_OUT)]),
        ("ros2", [script("component", "tests/ros2/test_ros2.py", "component", alone=True), script("mission", "tests/ros2/test_ros2.py", "mission", alone=True, sample=LEFT_OUT)]),
        ("distributed", [script("distributed", "tests/distributed/test_processes.py", alone=True), script("start", "tests/distributed/test_start.py", alone=True), script("hosts", "tests/distributed/test_hosts.py", alone=True, sample=LEFT_OUT), script("dala_hosts", "tests/distributed/test_dala.py", alone=True, sample=LEFT_OUT)]),
        # Sanitizers make system calls and allocate by themselves, need much address space, and trace the process to find leaks.
        ("faults", [script("faults", "tests/faults/test_faults.py", *(["output", "input", "threads", "kill"] if is_sanitized() else []), alone=True, sample=["output", "input"])]),
        ("traces", [script("traces", "tests/traces/test_traces.py", weight=3), script("record", "tests/traces/test_record.py", alone=True)]),
        ("debuggers", [script("debuggers", "tests/debuggers/test_debuggers.py", alone=True, sample=LEFT_OUT)]),
        # A sanitized build cannot be installed.
        *([("package", [script("package", "tests/package/test_package.py", weight=25, sample=LEFT_OUT), *needs("bipc-runner", script("runner", "tests/package/test_runner.py", weight=5))])] if not is_sanitized() else []),
        # Nor is its Python module built.
        *([("python", [script("python", "tests/python/test_python.py", alone=True), script("notebooks", "tests/python/test_notebooks.py", alone=True, sample=LEFT_OUT)])] if not is_sanitized() else []),
        ("fuzz", needs("bip-fuzz", script("fuzz", "tests/fuzz/test_fuzz.py", weight=140, sample=["--edits", "5000"]))),
        ("graph", [script("graph", "tests/graph/test_pictures.py", weight=5)]),
        ("view", [script("view", "tests/view/test_page.py", alone=True, sample=LEFT_OUT), script("live", "tests/view/test_live.py"), script("attach", "tests/view/test_attach.py")]),
        ("dap", [script("dap", "tests/dap/test_dap.py", weight=20)]),
        ("lsp", needs("bipc-lsp", script("lsp", "tests/lsp/test_lsp.py", weight=145, sample=["--edits", "150"]))),
        ("verify", needs("bip-verify-check", script("verify", "tests/verify/test_verify.sh", str(options.nets), str(options.first), weight=180, sample=["30", "2001"]),
                         script("terminal", "tests/verify/test_terminal.py", alone=True), script("exports", "tests/verify/test_exports.py", weight=20, sample=["2"]),
                         script("aiger", "tests/verify/test_aiger.py", weight=10, sample=LEFT_OUT), script("timed", "tests/verify/test_timed.py", weight=10, sample=["20"]),
                         *needs("bip-prove-runs", script("liveness", "tests/verify/test_liveness.py", weight=10, sample=["20"])),
                         script("branching", "tests/verify/test_branching.py", weight=5, sample=["20"]),
                         script("timed certificates", "tests/verify/test_timed_certificates.py", weight=15, sample=["5"]),
                         *timed_zone_jobs(),
                         script("certificate table", "tests/verify/test_certificate_table.py", weight=5),
                         script("region certificates", "tests/verify/test_region_certificates.py", weight=5, sample=["20"]),
                         script("sizes", "tests/verify/test_sizes.py", weight=10, sample=["--count", "12"]))),
        ("differential", needs("bip-gen", script("differential", "tests/differential/test_differential.sh", str(options.systems), str(options.first), *(["--without-emitted"] if options.without_emitted else []), weight=150, sample=["40", "2001"]),
                               script("engines", "tests/differential/test_engines.sh", "100", weight=40, sample=["20"]))),
    ]


def main():
    LOGS.mkdir(parents=True, exist_ok=True)
    # A shell without job control starts programs in the background with interrupts ignored, which all that they start inherit.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # The user's own cache is none of ours.
    os.environ["XDG_CACHE_HOME"] = str(BUILD / "tests-cache")
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--systems", type=int, default=200, help="random systems of the group differential")
    arguments.add_argument("--nets", type=int, default=300, help="random systems of the prover's test; 2000 is what test_verify.sh itself takes")
    arguments.add_argument("--goldens-every", type=int, default=1, metavar="N", help="of N golden files only one")
    arguments.add_argument("--goldens-containing", default="", metavar="REGEX", help="only golden files with a text that the regular expression matches")
    arguments.add_argument("--first", type=int, default=2001, help="seed of the first random system")
    arguments.add_argument("--without-emitted", action="store_true", help="random systems are not also run as emitted C++")
    arguments.add_argument("--sample", action="store_true", help="some cases of each group; says what it leaves out")
    arguments.add_argument("groups", nargs="*")
    options = arguments.parse_args()
    wanted = set(options.groups)
    everything = groups(options)
    if is_sanitized():
        os.environ.setdefault("BIPC_TEST_PATIENCE", "20")
        # Frames of sanitized functions are several times larger.
        hard = resource.getrlimit(resource.RLIMIT_STACK)[1]
        resource.setrlimit(resource.RLIMIT_STACK, (64 << 20 if hard == resource.RLIM_INFINITY else min(64 << 20, hard), hard))
        # Freed memory is kept for a while: not so much that tests of memory see nothing else. Signals of a crash are handled by bipc.
        own_signals = [f"handle_{name}=0" for name in ("segv", "sigbus", "sigfpe", "sigill", "abort")]
        os.environ["ASAN_OPTIONS"] = ":".join(filter(None, [os.environ.get("ASAN_OPTIONS"), "quarantine_size_mb=8", *own_signals]))
        for old in LOGS.glob(RACES.name + ".*"):
            old.unlink()
        # Processes of codels are forked while threads run, and start threads of their own. No second is waited at each exit.
        os.environ["TSAN_OPTIONS"] = ":".join(filter(None, [f"suppressions={ROOT / 'tests/tsan.supp'}", "die_after_fork=0", "atexit_sleep_ms=0", f"log_path={RACES}", *own_signals, os.environ.get("TSAN_OPTIONS")]))
        # Programs that link the runtime of the build need its compiler and sanitizers; what bipc loads must not have them.
        os.environ.setdefault("BIPC_TEST_CXX", f"{build_option('CMAKE_CXX_COMPILER')} -fsanitize={build_option('BIPC_SANITIZE')}")
    unknown = wanted - {name for name, _ in everything} - {f"{name}:{job.name}" for name, jobs in everything for job in jobs}
    if unknown:
        sys.exit(f"test: no group {', '.join(sorted(unknown))}")
    chosen = [(name, [job for job in jobs if not wanted or name in wanted or f"{name}:{job.name}" in wanted]) for name, jobs in everything]
    chosen = [(name, jobs) for name, jobs in chosen if jobs]
    left_out, fewer = [], []
    if options.sample:
        chosen, left_out, fewer = sampled(chosen)
    results, seconds = {}, {}

    def execute(job):
        start = time.monotonic()
        results[job] = job.run()
        seconds[job] = time.monotonic() - start
        report()

    reported, lock, total = set(), threading.Lock(), [0, 0]

    def report():
        """Prints each group once all of it has run."""
        with lock:
            for name, jobs in chosen:
                if name in reported or not all(job in seconds for job in jobs):
                    continue
                reported.add(name)
                passed, failed = (sum(results[job][k] for job in jobs) for k in (0, 1))
                if passed + failed == 0:
                    print(f"{name}: nothing ran")
                    failed = 1
                print(f"{name}: {passed} passed, {failed} failed ({sum(seconds[job] for job in jobs):.1f} s)", flush=True)
                total[0] += passed
                total[1] += failed

    jobs = [job for _, group in chosen for job in group]
    workers = int(os.environ.get("BIPC_TEST_JOBS") or os.cpu_count() or 1)
    with concurrent.futures.ThreadPoolExecutor(max_workers=workers) as pool:
        # The longest first, so that none is left alone at the end.
        list(pool.map(execute, sorted((job for job in jobs if not job.alone), key=lambda job: -job.weight)))
    for job in jobs:
        if job.alone:
            execute(job)
    # Also of processes whose exit codes and output nobody sees.
    for report_file in sorted(LOGS.glob(RACES.name + ".*")):
        print(report_file.read_text(encoding="utf-8", errors="replace")[:4000])
        total[1] += 1
    (LOGS / "seconds").write_text("".join(f"{seconds[job]:8.1f}  {name}:{job.name}\n" for name, group in chosen for job in group))
    if options.sample:
        print(f"a sample: {len(fewer)} programs had fewer cases; left out: {', '.join(left_out) or 'nothing'} "
              "(tools/test --all runs everything, tools/test GROUP… these groups whole)", flush=True)
    print(f"{total[0]} passed, {total[1]} failed" + (f", {len(skipped)} skipped" if skipped else ""), flush=True)
    return 1 if total[1] else 0


if __name__ == "__main__":
    sys.exit(main())
