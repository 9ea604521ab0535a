#!/usr/bin/env python3
"""Faults of the machine around bipc: what cannot be written, read, allocated or started is told, and nothing is lost.

    tests/faults/test_faults.py [--all] [--most N] [--command NAME ...] [--seed N] [GROUP ...]

Without --all a sample of about a minute, drawn by the seed; with it every system call of each command (of slow ones 100), and of
its allocations (about 40,000) 5,000, evenly spread, in less than an hour. How many of how many were taken is printed.

| group | what happens |
|---|---|
| `output` | standard output is full or closed in every command and in an emitted program; traces of all formats on a full disk; diagnostics on a full standard error |
| `input` | events that are a folder, records that are cut off, outputs that are inputs or other outputs, an output that is a pipe |
| `calls` | the k-th system call fails (fail_system_call.c) |
| `memory` | the k-th allocation fails, once or for ever (fail_allocation.c) |
| `files` | no file can be written; a signal comes while one is: the old one stays, nothing is left beside it |
| `limits` | a small stack, few files, small files, no home |
| `threads` | no thread can be had (fail_thread.c) |
| `kill` | SIGKILL, SIGTERM, SIGINT or SIGHUP at a random moment, then the same command with the same cache; the compiler ends as well; a run that waits for events of a pipe ends |

A disturbed command must end by itself and not by a signal of its own, without an internal error. If it says 0, its output and its files are
those of the undisturbed command; otherwise it says why on standard error. Afterwards no temporary file is left, and the same command with
the same cache gives what it gave before. Needs a C compiler; `calls` runs on Linux for x86-64.
"""
import argparse
import concurrent.futures
import os
import pathlib
import platform
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or HERE.parent.parent / "build")
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
CERTCHECK = str(BUILD / "certcheck")
TIMEOUT = 120 if "--all" not in sys.argv else 900  # s; --all may run beside other things
OUTPUT_LOST, NO_RESOURCES, INTERNAL_ERROR = 74, 71, 70
OWN_SIGNALS = {signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGPIPE}

MODEL = """package m
  port type Signal()
  port type Number(int n)
  connector type One(Signal p) define p end
  connector type Two(Signal a, Signal b) define a b end
  atom type Lamp()
    data int n = 0
    export port Signal on_switch(), off_switch()
    place OFF, ON
    initial to OFF
    on on_switch from OFF to ON do { n = (n + 1) % 7; }
    on off_switch from ON to OFF
  end
  atom type Finger()
    export port Signal push()
    place S
    initial to S
    on push from S to S
  end
  compound type Root()
    component Lamp a(), b()
    component Finger finger()
    connector Two turn_on(finger.push, a.on_switch), turn_off(finger.push, a.off_switch)
    connector One on_b(b.on_switch), off_b(b.off_switch)
  end
end
"""
DEAD = MODEL.replace("from ON to OFF\n", "from ON to OFF provided (n < 3)\n").replace(", off_b(b.off_switch)", "")
BATTERY = (HERE.parent.parent / "models/dala/battery.gen").read_text()
LOADED = """@cpp(include="loaded.hpp")
package loaded
  extern function int f(const int)
  port type Signal()
  connector type One(Signal p) define p end
  atom type A()
    data int n = 0
    export port Signal p()
    place S, T
    initial to S
    on p from S to T provided (n < 9) do { n = f(n); }
  end
  compound type Root()
    component A a()
    connector One k(a.p)
  end
end
"""
EVENTS_MODEL = """package e
  port type N(int n)
  atom type Counter()
    data int n = 0, count = 0
    extern port N add(n) remember
    place P
    initial to P
    on add from P to P eager do { count = count + 1; }
  end
  compound type Root()
    component Counter c()
  end
end
"""
EVENTS = "".join('{"time":"%dms","port":"c.add","values":[%d]}\n' % (k, k) for k in range(20))
REQUESTS = "".join('{"id":%d,"do":"%s"}\n' % (k, what) for k, what in enumerate(("hello", "pause", "state", "snapshot", "state")))

FRAMES = "".join("Content-Length: %d\r\n\r\n%s" % (len(text), text) for text in (
    '{"seq":1,"type":"request","command":"initialize"}', '{"seq":2,"type":"request","command":"launch","arguments":{"program":"m.bip","seed":1}}',
    '{"seq":3,"type":"request","command":"threads"}', '{"seq":4,"type":"request","command":"disconnect"}'))

# name: (words, standard input). Files are made anew in the working directory each time.
COMMANDS = {
    "run": ("run --backend interp --seed 1 --limit 300 --trace out.json m.bip", ""),
    "run_record": ("run --backend interp --seed 1 --limit 15 --events events --record out.record e.bip", ""),
    "run_jit": ("run --backend jit -O2 --cache cache --seed 1 --limit 300 --trace-format binary --trace out.bin m.bip", ""),
    "verify": ("verify --cache cache --certificate out.certificate m.bip", ""),
    "explore": ("explore --backend interp --threads 2 --trace out.trace m.bip", ""),
    "emit": ("emit -o out m.bip", ""),
    "fmt": ("fmt -i m.bip", ""),
    "export": ("export --format pnml -o out.pnml m.bip", ""),
    "serve": ("serve --paused --backend interp e.bip", REQUESTS),
    "build": ("build -O0 -o out m.bip", ""),
    "view": ("view --steps 20 -o out.html m.bip", ""),
    "simulate": ("simulate --runs 20 --seed 1 --limit 50 --csv out.csv m.bip", ""),
    "trace": ("trace convert --format csv -o out.csv m.bip run.jsonl", ""),
    "graph": ("graph -o out.svg m.bip", ""),
    "genom": ("genom --skeleton -o out.bip battery.gen", ""),
    "dap": ("dap", FRAMES),
}
# Commands that write files, for the group `files`: each of them is there already.
WRITING = ["export --format pnml -o out m.bip", "graph --format svg -o out m.bip", "view --steps 20 -o out m.bip", "verify --certificate out m.bip", "explore --trace out dead.bip",
           "verify --trace out dead.bip", "simulate --runs 3 --csv out m.bip", "trace convert --format csv -o out m.bip run.jsonl", "migrate -o out m.bip", "fmt -i ugly.bip",
           "run --silent --limit 9 --profile-json out m.bip", "genom -o out battery.gen", "genom --skeleton -o out.bip battery.gen", "emit -o folder m.bip", "build -O0 -o out m.bip"]
HAS_NODES = (BUILD / "libbipc_zmq.so").exists()  # is missing where libzmq3-dev was, as bipc was built
DEPLOYING = "deploy --placement m.place -o nodes m.bip"
PLACEMENT = "node left host 127.0.0.1:7801\nnode right host 127.0.0.1:7802\nb on right\n* on left\n"
SLOW = {"build"}  # in no sample
MANY = {"build", "emit"}
MOST_OF_MANY = 100  # calls that fail in such a command, with --all
# Commands that write to standard output, for the group `output`.
TALKING = [
    "run --seed 1 --limit 9 m.bip", "run --seed 1 --limit 99999 --backend interp m.bip", "run --explore m.bip", "verify m.bip", "verify --json m.bip", "explore m.bip",
    "explore --json m.bip", "explore --trace-format bip2 m.bip", "graph m.bip", "graph --format json m.bip", "emit m.bip", "export m.bip", "export --format pnml m.bip",
    "fmt m.bip", "fmt --check ugly.bip", "migrate m.bip", "explain B0001", "explain", "version", "--version", "--help", "run --help", "check --emit=tokens m.bip", "check --emit=system m.bip",
    "export -o - m.bip", "graph --format json -o - m.bip", "migrate -o - m.bip", "view --steps 9 -o - m.bip", "verify --certificate - m.bip", "verify --trace - dead.bip",
    "explore --trace - dead.bip", "simulate --runs 3 m.bip", "simulate --runs 3 --csv - m.bip", "trace stats m.bip rec.bin", "trace convert --format csv m.bip rec.bin", "trace convert -o - m.bip rec.bin",
    "trace convert --format mcap m.bip rec.bin", "view --port 0 m.bip", "step m.bip", "genom battery.gen", "genom -o - battery.gen", "completion bash", "version --json",
    "run --seed 1 --limit 9 --trace-format bip2 m.bip", "run --seed 1 --limit 9 --trace-format json m.bip", "verify timed.bip", "explore timed.bip", "replay --recorded rec.bin m.bip",
]
TIMED = """package timed
  port type P()
  connector type One(P p) define p end
  atom type T()
    clock x unit nanosecond
    export port P tick()
    place S
    initial to S
    on tick from S to S provided (x == 5) do { x = 0; }
  end
  compound type Root()
    component T t()
    connector One k(t.tick)
  end
end
"""

parser = argparse.ArgumentParser()
parser.add_argument("--all", action="store_true")
parser.add_argument("--most", type=int, default=5000, help="allocations that fail in each command, with --all (default: 5000)")
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--command", action="append", choices=COMMANDS, help="calls, memory and kill: only of this command (may be repeated)")
parser.add_argument("groups", nargs="*")
options = parser.parse_args()
rng = random.Random(options.seed)
work = pathlib.Path(tempfile.mkdtemp(prefix="bipc-faults-"))
failures, passed = [], 0
coverage = [0, 0]  # calls that failed, and those that there are


def fail(what, text):
    failures.append(what)
    print(f"FAILED {what}: {text}", flush=True)


def good(what, is_good, text):
    global passed
    if is_good: passed += 1
    else: fail(what, text)


class Place:
    """A working directory with the models, its own folder for temporary files and its own home."""

    def __init__(self):
        self.path = pathlib.Path(tempfile.mkdtemp(dir=work))
        self.tmp = self.path / "tmp"
        self.files = self.path / "files"
        self.environment = {**os.environ, "TMPDIR": str(self.tmp), "HOME": str(self.path / "home"), "LC_ALL": "C.UTF-8"}
        self.environment.pop("XDG_CACHE_HOME", None)
        for folder in (self.tmp, self.files, self.path / "home"): folder.mkdir()
        self.renew()

    def renew(self):
        """As at first, but for the cache."""
        for path in self.files.iterdir():
            if path.name == "cache": continue
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
        for name, text in (("m.bip", MODEL), ("e.bip", EVENTS_MODEL), ("timed.bip", TIMED), ("ugly.bip", MODEL.replace("  ", "    ")), ("events", EVENTS),
                           ("dead.bip", DEAD), ("m.place", PLACEMENT), ("battery.gen", BATTERY)):
            (self.files / name).write_text(text)
        if (work / "run.jsonl").exists(): shutil.copy(work / "run.jsonl", self.files)

    def run(self, words, stdin="", prefix=(), preexec=None, env=(), **more):
        words = words.split() if isinstance(words, str) else words
        return subprocess.run([*prefix, BIPC, *words], cwd=self.files, input=stdin.encode(), capture_output="stdout" not in more, timeout=TIMEOUT,
                              env={**self.environment, **dict(env)}, preexec_fn=preexec, **more)

    def outputs(self):
        return {str(p.relative_to(self.files)): p.read_bytes() for p in sorted(self.files.rglob("*")) if p.is_file() and "cache" not in p.relative_to(self.files).parts}

    def kept(self):
        """What a later command with the same cache can see of an earlier one, once the files are made anew."""
        roots = (self.files / "cache", self.tmp, self.path / "home")
        return {str(p): p.read_bytes() if p.is_file() else b"" for root in roots for p in sorted(root.rglob("*"))}

    def litter(self):
        return [str(p) for p in list(self.files.rglob("*.new")) + list(self.tmp.iterdir())]


def sorted_answers(name, out):
    return b"\n".join(sorted(out.split(b"\n"))) if name == "serve" else out


class Reference:
    """What a command does undisturbed; its number of system calls or allocations."""

    def __init__(self, name, prefix=(), env=()):
        self.place, self.name = Place(), name
        self.words, self.stdin = COMMANDS[name]
        self.count = 0
        count = self.place.path / "count"
        done = self.place.run(self.words, self.stdin, prefix, env=[*env, ("FAIL_COUNT", str(count))])
        if done.returncode != 0:
            fail(name, f"undisturbed: {done.returncode} {done.stderr.decode()}")
            return
        self.stdout, self.files = sorted_answers(name, done.stdout), self.place.outputs()
        # With what is now in the cache.
        self.place.renew()
        self.place.run(self.words, self.stdin, prefix, env=[*env, ("FAIL_COUNT", str(count))])
        self.count = int(count.read_text()) if count.exists() else 0

    def is_same(self, done, place):
        return done.returncode == 0 and sorted_answers(self.name, done.stdout) == self.stdout and place.outputs() == self.files

    def is_told(self, done):
        """Debuggers hear of a problem by the response to what they asked."""
        return self.name == "dap" and b'"success":false' in done.stdout

    def check(self, what, done, place, before):
        """A disturbed run, whatever it made; `before` is what was kept in its place. Only what it left can disturb the next command."""
        problem = ""
        if done.returncode < 0: problem = f"ended by signal {-done.returncode}"
        elif done.returncode == INTERNAL_ERROR: problem = "internal error"
        elif done.returncode == 0 and not self.is_same(done, place) and not self.is_told(done): problem = "0, and something is lost: " + self.difference(done, place)
        elif done.returncode != 0 and not done.stderr: problem = f"{done.returncode} without a word"
        elif place.litter(): problem = f"left behind: {place.litter()}"
        if not problem and place.kept() != before:
            place.renew()
            again = place.run(self.words, self.stdin)
            if not self.is_same(again, place): problem = f"afterwards: {again.returncode} {again.stderr.decode('utf-8', 'replace')[-300:]} {self.difference(again, place)}"
        good(what, not problem, f"{problem}; {done.stderr.decode('utf-8', 'replace')[-300:]}")

    def difference(self, done, place):
        files = place.outputs()
        changed = [name for name in {*files, *self.files} if files.get(name) != self.files.get(name)]
        return ("standard output " if sorted_answers(self.name, done.stdout) != self.stdout else "") + " ".join(changed[:5])


def side_by_side(jobs):
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for job in [pool.submit(job) for job in jobs]:
            try:
                job.result()
            except subprocess.TimeoutExpired as hung:
                fail("hangs", f"{hung.cmd}: nothing after {hung.timeout} s")


def compile_tool(name, *flags):
    tool = work / name.replace(".c", "")
    subprocess.run(["cc", "-O1", *flags, "-o", str(tool), str(HERE / name)], check=True)
    return tool


def commands():
    """Those whose calls fail and that are killed."""
    return options.command or [name for name in COMMANDS if options.all or name not in SLOW]


def chosen(name, count, sample, most):
    """Which of so many calls fail: a sample drawn by the seed; with --all all of them, or `most`, evenly spread."""
    taken, there = coverage
    wanted = min(count, most if options.all else sample)
    coverage[:] = taken + wanted, there + count
    if not options.all: return sorted(rng.sample(range(1, count + 1), wanted))
    print(f"{name}: {wanted} of {count}", flush=True)
    return [1 + k * count // wanted for k in range(wanted)]


def disturbed(reference, what, prefix=(), env=()):
    place = Place()
    if (reference.place.files / "cache").exists(): shutil.copytree(reference.place.files / "cache", place.files / "cache")
    before = place.kept()
    try:
        done = place.run(reference.words, reference.stdin, prefix, env=env)
    except subprocess.TimeoutExpired:
        return fail(what, f"hangs: nothing after {TIMEOUT} s")
    reference.check(what, done, place, before)
    shutil.rmtree(place.path)


def calls():
    if platform.machine() != "x86_64": return print("skipped: faults of system calls need x86-64")
    tool = compile_tool("fail_system_call.c")
    for name in commands():
        jobs = []
        reference = Reference(name, prefix=(str(tool), "0"))
        for k in chosen(f"calls {name}", reference.count, 12, MOST_OF_MANY if name in MANY else reference.count):
            jobs.append(lambda r=reference, k=k: disturbed(r, f"calls {r.name} {k}", (str(tool), str(k))))
        side_by_side(jobs)


def memory():
    tool = compile_tool("fail_allocation.c", "-shared", "-fPIC")
    load = ("LD_PRELOAD", str(tool))
    for name in commands():
        jobs = []
        reference = Reference(name, env=[load])
        for k in chosen(f"memory {name}", reference.count, 6, min(options.most, MOST_OF_MANY) if name in MANY else options.most):
            for how in ("", "+"):
                jobs.append(lambda r=reference, k=k, how=how: disturbed(r, f"memory {r.name} {k}{how}", env=[load, ("FAIL_ALLOCATION", f"{k}{how}")]))
        side_by_side(jobs)


def threads():
    tool = compile_tool("fail_thread.c", "-shared", "-fPIC")
    load = ("LD_PRELOAD", str(tool))
    for words in ("run --seed 1 --limit 300 m.bip", "run --seed 1 --limit 300 --engine=threads --threads 3 m.bip", "run --seed 1 --limit 9999 --silent --engine=batch --threads 2 m.bip",
                  "verify m.bip", "verify timed.bip", "explore --threads 3 m.bip", "run --seed 1 --limit 15 --events events e.bip"):
        place = Place()
        done = place.run(words, env=[load, ("FAIL_COUNT", str(place.path / "count"))])
        asked = int((place.path / "count").read_text()) if (place.path / "count").exists() else 0
        place.renew()
        same = place.run(words)
        good(f"threads {words}", done.returncode in {same.returncode, NO_RESOURCES} and (done.returncode != NO_RESOURCES or done.stderr) and not place.litter(),
             f"{done.returncode} after {asked} threads: {done.stderr.decode('utf-8', 'replace')[-300:]}")
        if "--threads" in words: good(f"threads {words} are asked for", asked > 0, "no thread was asked for")
        if done.returncode == same.returncode and "--engine" not in words:
            good(f"threads {words} answer", done.stdout == same.stdout, f"{done.stdout[-300:]} is not {same.stdout[-300:]}")


def output():
    place = Place()
    assert place.run("run --seed 1 --limit 9 --trace-format binary --trace rec.bin m.bip").returncode == 0
    programs = [(words, [BIPC, *words.split()]) for words in TALKING + [DEPLOYING] * HAS_NODES]
    built = place.run("build -O0 -o program m.bip")
    good("output build", built.returncode == 0, built.stderr.decode())
    certified = place.run("verify --certificate m.certificate m.bip").returncode == 0 and place.run("check --emit=system m.bip")
    (place.files / "m.bsys").write_bytes(certified.stdout)
    programs += [("program", ["./program", "--seed", "1", "--limit", "9"]), ("program --help", ["./program", "--help"])]
    if os.path.exists(CERTCHECK): programs.append(("certcheck", [CERTCHECK, "m.bsys", "m.certificate"]))
    def one(name, command, how):
        target = open("/dev/full", "wb") if how == "full" else subprocess.PIPE
        shut = (lambda: os.close(1)) if how == "closed" else None
        done = subprocess.run(command, cwd=place.files, stdout=target, stderr=subprocess.PIPE, env=place.environment, timeout=TIMEOUT, preexec_fn=shut)
        good(f"output {how} {name}", done.returncode == OUTPUT_LOST and b"cannot write" in done.stderr, f"{done.returncode} {done.stderr.decode()}")
    side_by_side([lambda n=n, c=c, h=h: one(n, c, h) for n, c in programs for h in ("full", "closed")])
    for form in ("json", "bip2", "binary", "mcap", "perfetto", "steps"):
        for command in ([BIPC, "run", "m.bip"], ["./program"]):
            words = command + ["--seed", "1", "--limit", "5000", "--silent", "--trace", "/dev/full", "--trace-format", form]
            done = subprocess.run(words, cwd=place.files, capture_output=True, env=place.environment, timeout=TIMEOUT)
            if form == "steps" and done.returncode == 2: continue  # no such format of a trace
            good(f"output trace {form} {command[0]}", done.returncode == OUTPUT_LOST and b"cannot write `/dev/full`: No space" in done.stderr, f"{done.returncode} {done.stderr}")
    # Diagnostics are what `check` prints, and what programs read as JSON and SARIF.
    (place.files / "warned.bip").write_text(MODEL.replace("  compound type", "  atom type Unused()\n    export port Signal p()\n    place S\n    initial to S\n  end\n  compound type", 1))
    for words, code in (("check warned.bip", OUTPUT_LOST), ("check --diagnostics=json warned.bip", OUTPUT_LOST), ("check --diagnostics=sarif m.bip", OUTPUT_LOST),
                        ("verify --diagnostics=json warned.bip", OUTPUT_LOST), ("verify warned.bip", 0), ("check m.bip", 0)):
        warned = place.run(words)
        good(f"output told {words}", warned.returncode == 0 and bool(warned.stderr) == (words not in ("check m.bip",)), f"{warned.returncode} {warned.stderr}")
        with open("/dev/full", "wb") as full: done = place.run(words, stdout=subprocess.DEVNULL, stderr=full)
        good(f"output diagnostics {words}", done.returncode == code, f"{done.returncode}")
    # Servers that speak by messages.
    initialize = b"Content-Length: 58\r\n\r\n" + b'{"jsonrpc":"2.0","id":1,"method":"initialize","params":{}}'
    for name, command, asked in (("dap", [BIPC, "dap"], FRAMES.encode()), ("bipc-lsp", [str(BUILD / "bipc-lsp")], initialize)):
        with open("/dev/full", "wb") as full:
            done = subprocess.run(command, cwd=place.files, input=asked, stdout=full, stderr=subprocess.PIPE, env=place.environment, timeout=TIMEOUT)
        good(f"output full {name}", done.returncode == OUTPUT_LOST and b"cannot write `standard output`" in done.stderr, f"{done.returncode} {done.stderr}")
        done = subprocess.run(command, cwd=place.files, input=asked[:20], capture_output=True, env=place.environment, timeout=TIMEOUT)
        good(f"output {name}: the input ends", done.returncode == 1 and b"standard input has ended before" in done.stderr, f"{done.returncode} {done.stderr}")
        folder = os.open(place.files, os.O_RDONLY)
        done = subprocess.run(command, cwd=place.files, stdin=folder, capture_output=True, env=place.environment, timeout=TIMEOUT)
        os.close(folder)
        good(f"output {name}: the input is a folder", done.returncode == OUTPUT_LOST and b"cannot read standard input" in done.stderr, f"{done.returncode} {done.stderr}")
    page = place.run("view --steps 9 -o - m.bip").stdout
    good("output a page alone", page.startswith(b"<!") and page.rstrip().endswith(b"</html>"), page[-200:].decode())
    # The trace does not become descriptor 1, and what is printed does not come into it.
    def close_all():
        for descriptor in (0, 1, 2): os.close(descriptor)
    place.run("run --seed 1 --limit 9 --trace good.json m.bip")
    subprocess.run([BIPC, *"run --seed 1 --limit 9 --trace bad.json m.bip".split()], cwd=place.files, env=place.environment, preexec_fn=close_all)
    good("output closed descriptors", (place.files / "good.json").read_bytes() == (place.files / "bad.json").read_bytes(), (place.files / "bad.json").read_text()[:300])
    for words in ("build -O0 -o", "emit -o", "export -o", "verify --certificate"):
        done = place.run(words.split() + ["/dev/full/x", "m.bip"])
        good(f"output {words}", done.returncode == 1 and b"B5004" in done.stderr, f"{done.returncode} {done.stderr}")


def inputs():
    place = Place()
    def told(what, words, code, text):
        before = place.outputs()
        done = place.run(words)
        good(f"input {what}", done.returncode == code and text.encode() in done.stderr and place.outputs() == before, f"{done.returncode} {done.stderr} {done.stdout[-200:]}")
    (place.files / "folder").mkdir()
    place.run("run --seed 1 --limit 15 --events events --record rec e.bip")
    place.run("run --seed 1 --limit 9 --trace-format binary --trace rec.bin m.bip")
    whole = (place.files / "rec").read_bytes()
    (place.files / "torn").write_bytes(whole[:-30])
    (place.files / "junk.bin").write_bytes((place.files / "rec.bin").read_bytes() + b"more")
    os.link(place.files / "m.bip", place.files / "same.bip")
    told("events are a folder", "run --events folder --seed 1 e.bip", 2, "cannot read `folder`: Is a directory")
    told("events in an I/O error", "run --events /proc/self/mem --seed 1 e.bip", 2, "cannot read `/proc/self/mem`: Input/output error")
    told("a record that is cut off", "run --silent --limit 15 --replay torn e.bip", 0, "the run was cut off there")
    head = whole.splitlines(keepends=True)[0]
    for cut in (60, len(head) - 3):
        (place.files / "torn").write_bytes(whole[:cut])
        told(f"a record of {cut} bytes", "run --silent --limit 15 --replay torn e.bip", 2, "with it the seed")
    for command in ("trace stats m.bip junk.bin", "trace convert --format csv m.bip junk.bin", "step --trace junk.bin m.bip"):
        told(f"junk behind a binary trace: {command}", command, 1, "is followed by 4 bytes")
    told("junk behind a binary trace", "replay --recorded junk.bin m.bip", 1, "is followed by 4 bytes")
    told("the trace is the model", "run --seed 1 --limit 9 --trace m.bip m.bip", 1, "B5013")
    told("the trace is the model by a link", "run --seed 1 --limit 9 --trace same.bip m.bip", 1, "B5013")
    told("the program is the model", "build -o m.bip m.bip", 1, "B5013")
    told("the export is the model", "export -o m.bip m.bip", 1, "B5013")
    told("the certificate is the model", "verify --certificate m.bip m.bip", 1, "B5013")
    told("the counterexample is the model", "explore --trace m.bip m.bip", 1, "B5013")
    told("the record is the events", "run --seed 1 --events events --record events e.bip", 2, "would overwrite the file of --events")
    told("the record is what is replayed", "run --replay rec --record rec e.bip", 2, "would overwrite the file of --replay")
    told("trace and record are one", "run --seed 1 --limit 1 --trace t --record t e.bip", 2, "name the same file")
    place.run("run --seed 1 --limit 9 --trace run.jsonl m.bip")
    place.run("verify --certificate cert m.bip")
    told("the page is the trace", "view --trace run.jsonl -o run.jsonl m.bip", 2, "would overwrite the file of --trace")
    told("the page is the certificate", "view --certificate cert -o cert m.bip", 2, "would overwrite the file of --certificate")
    told("a part of the trace is the trace", "trace filter m.bip run.jsonl --first 2 -o run.jsonl", 2, "would overwrite the file of TRACE")
    told("the converted trace is the trace", "trace convert m.bip rec.bin --format json -o rec.bin", 2, "would overwrite the file of TRACE")
    told("trace and profile are one", "run --seed 1 --limit 1 --trace t --profile-json t m.bip", 2, "name the same file")
    os.link(place.files / "run.jsonl", place.files / "m.html")
    told("the page of the model is the trace", "view --trace run.jsonl m.bip", 1, "B5013")
    (place.files / "loaded.bip").write_text(LOADED)
    (place.files / "loaded.hpp").write_text('#include <fstream>\nstruct Mark { Mark() { std::ofstream("loaded") << 1; } };\ninline Mark mark;\ninline int f(int x) { return x; }\n')
    for words in ("explore --trust-cpp --trace none/x", "verify --trace none/x", "simulate --runs 2 --csv none/x", "view -o none/x"):
        told(f"cannot be written, before C++ is loaded: {words}", words + " loaded.bip", 1, "B5004")
    os.mkfifo(place.files / "pipe")
    with open(place.files / "program", "wb") as copy:
        reader = subprocess.Popen(["cat", str(place.files / "pipe")], stdout=copy)
        done = place.run("build -O0 -o pipe m.bip")
        if done.returncode != 0 or not (place.files / "pipe").is_fifo(): reader.kill()
        reader.wait(timeout=TIMEOUT)
    good("a program is written into a pipe", done.returncode == 0 and (place.files / "program").read_bytes()[:4] == b"\x7fELF" and not place.litter(), f"{done.returncode} {done.stderr}")
    # A folder that is removed before it is written has no input of the command in it, and is one that it has made.
    (place.files / "left/ffi").mkdir(parents=True)
    (place.files / "left/ffi/f.hpp").write_text("inline int f(int x) { return x; }\n")
    (place.files / "loaded.bip").write_text(LOADED.replace("loaded.hpp", "f.hpp"))
    (place.files / "c.place").write_text(PLACEMENT.replace("b on right\n", ""))
    if HAS_NODES: told("the C++ lies where a folder is removed", "deploy --placement c.place -o . -I left/ffi loaded.bip", 1, "B5013")
    if HAS_NODES: told("a folder that others have made", "deploy --placement c.place -o . m.bip", 1, "`bipc deploy` has not made it")
    killed_record(place)
    # A link that somebody laid where the old fixed name was is not followed.
    (place.files / "victim").write_text("mine")
    os.symlink("victim", place.files / "out.pnml.bipc-new")
    place.run("export --format pnml -o out.pnml m.bip")
    good("input fixed name", (place.files / "victim").read_text() == "mine", "somebody else's file was written")
    # What was proved yesterday and is refuted today has no certificate.
    place.run("verify --certificate c m.bip")
    before = (place.files / "c").exists()
    text = MODEL.replace("from ON to OFF", "from OFF to OFF provided (n > 9)")
    (place.files / "m.bip").write_text(text)
    done = place.run("verify --certificate c m.bip")
    good("input refuted certificate", before and done.returncode != 0 and not (place.files / "c").exists(), f"{before} {done.returncode} {done.stderr}")


def limits():
    place = Place()
    deep = MODEL.replace("(n + 1) % 7", "(" * 490 + "n" + ")" * 490)
    (place.files / "deep.bip").write_text(deep)
    def limited(what, words, kind, value, codes):
        done = place.run(words, preexec=lambda: resource.setrlimit(kind, (value, value)))
        good(f"limits {what}", done.returncode in codes and (done.returncode == 0 or done.stderr), f"{done.returncode} {done.stderr.decode('utf-8', 'replace')[-300:]}")
    for words in ("check deep.bip", "fmt deep.bip", "run --seed 1 --limit 9 deep.bip", "run --backend jit -O2 --seed 1 --limit 9 deep.bip", "verify deep.bip", "emit deep.bip"):
        limited(f"small stack {words}", words, resource.RLIMIT_STACK, 256 << 10, {0})
    limited("small file", "run --seed 1 --limit 5000 --silent --trace t m.bip", resource.RLIMIT_FSIZE, 4096, {OUTPUT_LOST})
    limited("small program", "build -O0 -o p m.bip", resource.RLIMIT_FSIZE, 4096, {1})
    limited("few files", "run --seed 1 --limit 5 --trace t m.bip", resource.RLIMIT_NOFILE, 4, {0, 1, 2, 127})
    for megabytes in (30, 60, 120, 250):
        for words in ("run --seed 1 --limit 9 m.bip", "verify m.bip", "explore m.bip"):
            limited(f"{megabytes} MB {words}", words, resource.RLIMIT_AS, megabytes << 20, {0, 1, 2, NO_RESOURCES, 127})
    # Memory runs out while events are read: one line without an end, and more events than there is room for.
    (place.files / "endless").write_text('{"time":"1ms","port":"c.add","values":[' + "1," * (60 << 20) + "1]}\n")
    (place.files / "many").write_text('{"time":"1ms","port":"c.add","values":[1]}\n' * 3_000_000)
    for words in ("run --silent --backend interp --seed 1 --events endless e.bip", "run --silent --backend interp --seed 1 --limit 9 --events many e.bip",
                  "run --silent --backend interp --seed 1 --events endless --record r e.bip"):
        limited(f"events in 100 MB {words}", words, resource.RLIMIT_AS, 100 << 20, {0, 2, NO_RESOURCES} if "many" in words else {2, NO_RESOURCES})
    for name in ("endless", "many"): (place.files / name).unlink()
    # No home, no cache; a relative one is none; one that others can write to is none.
    place.environment.pop("HOME")
    done = place.run("run --backend jit -O2 --seed 1 --limit 9 m.bip")
    good("limits no home", done.returncode == 0 and not list(place.tmp.iterdir()), f"{done.returncode} {done.stderr} {list(place.tmp.iterdir())}")
    place.run("run --backend jit -O2 --seed 1 --limit 9 m.bip", env=[("XDG_CACHE_HOME", "relative")])
    good("limits relative cache", not (place.files / "relative").exists(), "it was made")
    place.run("run --backend jit -O2 --seed 1 --limit 9 m.bip", env=[("XDG_CACHE_HOME", str(place.path / "private"))])
    folders = [place.path / "private", place.path / "private/bipc"]
    good("limits cache mode", [p.stat().st_mode & 0o777 for p in folders] == [0o700] * 2, "not 0700")
    (place.path / "open").mkdir()
    (place.path / "open").chmod(0o777)
    place.run(["run", "--backend", "jit", "-O2", "--cache", str(place.path / "open"), "--seed", "1", "--limit", "9", "m.bip"])
    good("limits open cache", not list((place.path / "open").iterdir()), "a folder that others can write to is used")


def kill():
    jobs = []
    for name in commands() + ["build"] * (not options.all and not options.command):
        reference = Reference(name)
        began = time.monotonic()
        reference.place.run(reference.words, reference.stdin)
        spent = time.monotonic() - began
        for k in range(40 if options.all else 4):
            how = [signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP][k % 4]
            if name == "build" and how == signal.SIGKILL: continue  # see compiler_ends
            jobs.append(lambda r=reference, how=how, after=rng.random() * spent: killed(r, how, after))
    side_by_side(jobs)
    compiler_ends()
    waits_for_events()
    side_by_side([lambda k=k: ends_before_compiler(0.01 + 0.002 * k) for k in range(100 if options.all else 40)])


def waits_for_events():
    """A run that waits for the events of a FIFO or a pipe ends at each signal as other runs do: for a FIFO that nobody writes to, and for the rest of a line."""
    place = Place()
    os.mkfifo(place.files / "fifo")
    built = place.run("build -O0 -o program e.bip")
    good("kill events build", built.returncode == 0, built.stderr.decode())
    def one(command, source, writes, how):
        what = f"kill events {' '.join(command[1:]) or 'program'} {source} {'half a line' if writes else 'nothing'} {how.name}"
        child = subprocess.Popen([*command, "--silent", "--seed", "1", "--events", source], cwd=place.files, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=place.environment)
        until = time.monotonic() + TIMEOUT
        while not catches(child.pid, how) and child.poll() is None and time.monotonic() < until: time.sleep(0.01)
        to = child.stdin
        if source == "fifo" and writes: to = open(place.files / "fifo", "wb")
        if writes:
            to.write(b'{"time":')
            to.flush()
        time.sleep(0.2)
        child.send_signal(how)
        try:
            child.wait(timeout=TIMEOUT)
        except subprocess.TimeoutExpired:
            child.kill()
            return fail(what, f"it has not ended {TIMEOUT} s later")
        finally:
            to.close()
        out = child.stdout.read()
        good(what, child.returncode == 128 + how and out.endswith(b"interrupted: 0 steps\n"), f"{child.returncode} {out} {child.stderr.read()}")
    # One after the other: they share a FIFO.
    for command in ([BIPC, "run", "e.bip"], [BIPC, "run", "--real-time", "e.bip"], ["./program"]):
        for source, writes in (("fifo", False), ("fifo", True), ("/dev/stdin", True)):
            for how in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP): one(command, source, writes, how)


def catches(pid, how):
    """Has the process a handler for the signal?"""
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
    return any(line.startswith("SigCgt:") and int(line.split()[1], 16) >> (how - 1) & 1 for line in status.splitlines())


def ends_before_compiler(after):
    """A signal between the making of the temporary folder and the start of the compiler leaves no folder."""
    place = Place()
    child = subprocess.Popen([BIPC, "build", "-O0", "-o", "out", "m.bip"], cwd=place.files, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                             stderr=subprocess.DEVNULL, env=place.environment)
    time.sleep(after)
    child.send_signal(signal.SIGHUP)
    child.wait(timeout=TIMEOUT)
    good(f"kill before the compiler after {after:.3f}", not list(place.tmp.iterdir()), str(place.litter()))
    shutil.rmtree(place.path)


def compiler_ends():
    """A compiler that would go on for long, and what it has started, end with a bipc that is killed."""
    place = Place()
    compiler = place.path / "slow_compiler"
    compiler.write_text(f"#!/bin/sh\nsleep 600 &\necho $$ $! >{place.path}/running.new\nmv {place.path}/running.new {place.path}/running\nwait\n")
    compiler.chmod(0o700)
    child = subprocess.Popen([BIPC, "build", "-O0", "-o", "out", "m.bip"], cwd=place.files, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                             stderr=subprocess.DEVNULL, env={**place.environment, "CXX": str(compiler)})
    running = place.path / "running"
    until = time.monotonic() + TIMEOUT
    while not running.exists() and child.poll() is None and time.monotonic() < until: time.sleep(0.01)
    child.kill()
    child.wait()
    good("kill compiler begins", running.exists(), "no compiler was started")
    if not running.exists(): return
    pids = [int(pid) for pid in running.read_text().split()]
    while any(map(is_running, pids)) and time.monotonic() < until: time.sleep(0.01)
    good("kill compiler ends", not any(map(is_running, pids)), f"{pids} still run")


def is_running(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


def killed(reference, how, after):
    what = f"kill {reference.name} {how.name} after {after:.3f}"
    place = Place()
    child = subprocess.Popen([BIPC, *reference.words.split()], cwd=place.files, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=place.environment)
    child.stdin.write(reference.stdin.encode())
    child.stdin.flush()
    time.sleep(after)
    child.send_signal(how)
    try:
        child.communicate(timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        child.kill()
        return fail(what, f"it has not ended {TIMEOUT} s later")
    good(what + " code", child.returncode in {0, 4, -how, 128 + how}, str(child.returncode))
    if how != signal.SIGKILL: good(what + " tidy", not place.litter(), str(place.litter()))
    place.renew()
    again = place.run(reference.words, reference.stdin)
    good(what + " again", reference.is_same(again, place), f"{again.returncode} {again.stderr.decode()} {reference.difference(again, place)}")
    shutil.rmtree(place.path)


def killed_record(place):
    """What a run has recorded is in the file at once: a run that is killed loses nothing of it."""
    events = "".join('{"time":"%dms","port":"c.add","values":[%d]}\n' % (100 * k, k) for k in range(600))
    (place.files / "slowly").write_text(events)
    child = subprocess.Popen([BIPC, *"run --backend interp --silent --relaxed --speed 1 --events slowly --record killed e.bip".split()], cwd=place.files, env=place.environment,
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    record, until = place.files / "killed", time.monotonic() + TIMEOUT
    while not (record.exists() and record.read_bytes().count(b"c.add") >= 8) and child.poll() is None and time.monotonic() < until: time.sleep(0.02)
    recorded = record.read_bytes().count(b"c.add")
    child.kill()
    child.wait()
    done = place.run("run --backend interp --limit 600 --replay killed e.bip")
    good("input a record of a run that was killed", 8 <= recorded < 600 and done.returncode == 0 and done.stdout.count(b"c.add") >= recorded, f"{recorded} {done.returncode} {done.stderr} {done.stdout[-300:]}")


def files():
    """Each command whose file is there already, where no file may be longer than some bytes, and with a signal while it writes."""
    tool = compile_tool("signal_at_sync.c", "-shared", "-fPIC")
    def place_with_old_files():
        place = Place()
        for name in ("out", "out.bip"): (place.files / name).write_text("old")
        return place
    def one(words):
        place = place_with_old_files()
        before = place.outputs()
        done = place.run(words, preexec=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8, 8)))
        good(f"files none {words}", done.returncode == 1 and b"B5004" in done.stderr and place.outputs() == before and not place.litter(),
             f"{done.returncode} {done.stderr.decode('utf-8', 'replace')[-300:]} {place.litter()}")
        place = place_with_old_files()
        before = place.outputs()
        done = place.run(words, env=[("LD_PRELOAD", str(tool))])
        after = place.outputs()
        is_whole = all(len(after[name]) > 20 for name in after if after[name] != before.get(name))
        # 0: the command handles signals, and was about to end.
        good(f"files signal {words}", done.returncode in {0, -signal.SIGTERM, 128 + signal.SIGTERM} and not place.litter() and is_whole, f"{done.returncode} {done.stderr[-300:]} {place.litter()}")
    side_by_side([lambda words=words: one(words) for words in WRITING])
    if not HAS_NODES: return
    # Keys are replaced whole, too, and are never for others.
    place = Place()
    place.run(DEPLOYING)
    before = place.outputs()
    done = place.run(DEPLOYING, preexec=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8, 8)))
    good("files none deploy", done.returncode == 1 and b"B5004" in done.stderr and before and place.outputs() == before and not place.litter(), f"{done.returncode} {done.stderr}")
    done = place.run(DEPLOYING, preexec=lambda: os.umask(0))
    keys = list((place.files / "nodes").rglob("*key"))
    good("files keys", done.returncode == 0 and len(keys) == 3 and all(key.stat().st_mode & 0o777 == 0o600 for key in keys) and place.outputs() != before, f"{done.returncode} {done.stderr} {keys}")


GROUPS = {"output": output, "input": inputs, "files": files, "limits": limits, "threads": threads, "kill": kill, "calls": calls, "memory": memory}
# Who starts this may ignore signals (nohup), and children would, too.
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    if signal.getsignal(number) == signal.SIG_IGN: signal.signal(number, signal.SIG_DFL)
started = time.time()
made = Place()
assert made.run("run --silent --seed 1 --limit 9 --trace run.jsonl m.bip").returncode == 0
shutil.copy(made.files / "run.jsonl", work)
for name in options.groups or GROUPS:
    before, coverage[:] = time.time(), (0, 0)
    GROUPS[name]()
    print(f"{name}: {time.time() - before:.1f} s" + (f", {coverage[0]} of {coverage[1]} calls failed in turn" if coverage[1] else ""), flush=True)
shutil.rmtree(work, ignore_errors=True)
print(f"faults: {passed} passed, {len(failures)} failed")
sys.exit(1 if failures else 0)
