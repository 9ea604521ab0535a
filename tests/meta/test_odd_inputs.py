#!/usr/bin/env python3
"""Odd inputs: whatever a file holds, bipc answers with a diagnostic and the documented exit code, within twenty seconds of the
processor's time (a busy machine is no finding, and takes twice as long by that, too; the clock may show four minutes).

    tests/meta/test_odd_inputs.py [--every N] [part of a case's name ...]

Each case is made here, at run time, because most are large: nesting, long names, long chains, loops without end, files
that are no text. Expected is an exit code and, for errors, the code of the first diagnostic. Needs python3 and a built
bipc ($BIPC, or bipc in $BIPC_BUILD_DIR, or build/bipc). BIPC_TEST_PATIENCE=20 is for sanitized builds: twenty times as
long, and no limit of the address space, which their shadow memory needs.
"""
import itertools
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests"))
from sample import take_every  # noqa: E402
PATIENCE = float(os.environ.get("BIPC_TEST_PATIENCE", "1"))
SECONDS = int(20 * PATIENCE)
ADDRESS_SPACE_KB = 6_000_000 if PATIENCE == 1 else "unlimited"
N = 100_000

TYPES = """  port type Signal()
  connector type One(Signal p) define p end
  connector type Up(Signal p) export port Signal e() define p end
  atom type A()
    export port Signal p()
    place S
    initial to S
    on p from S to S
  end
"""


def package(body):
    return f"package odd\n{body}end\n"


def action(text, before=""):
    """A package with an atom type whose `initial` runs `text`."""
    return package(f"{before}  atom type A()\n    data int x = 0\n    data bool b = false\n    place S\n"
                   f"    initial to S do {{ {text} }}\n  end\n")


def root(lines):
    return package(f"{TYPES}  compound type Root()\n    component A a()\n{lines}  end\n")


def functions(n, body):
    """`f0` … `fn`, each by `body` from the one before."""
    return "  function int f0(int n) = n + n\n" + "".join(f"  function int f{i}(int n) = {body.format(i - 1)}\n" for i in range(1, n + 1))


def chain(n, line):
    return "".join(line.format(i, i + 1) for i in range(n))


def cases():
    """(name, file's content as text or bytes or None for no file, arguments, exit code, first code or None)"""
    def check(name, text, code, exit_code=1):
        # The default limit of instances is what the machine's memory holds.
        return (name, text, ["check"] + (["--max-instances", "2000000"] if code == "B4006" else []), exit_code, code)

    sound = package(TYPES)
    # ---- files
    yield check("missing file", None, "B0090")
    yield check("empty file", "", "B0009")
    yield check("only blanks", " \n\t\n", "B0009")
    yield check("only a comment", "// nothing", "B0009")
    yield check("binary noise", bytes((i * 2654435761 >> 11) & 0xFF for i in range(100_000)), "B0090")
    yield check("a NUL byte", "package a\0\nend\n", "B0090")
    yield check("latin-1", "// caf\xe9\n".encode("latin-1") + sound.encode(), "B0090")
    yield check("utf-16", sound.encode("utf-16"), "B0090")
    yield check("byte order mark", "\ufeff" + sound, None, 0)
    yield check("\\r\\n", sound.replace("\n", "\r\n"), None, 0)
    yield check("no newline at the end", sound.rstrip("\n"), None, 0)
    yield check("100 MB of zeros", 100_000_000, "B0090")
    yield check("60 MB of blanks", " " * 60_000_000, "B0009")
    # ---- nesting
    yield check("parentheses", action("x = " + "(" * N + "1" + ")" * N + ";"), "B0008")
    yield check("parentheses without end", action("x = " + "(" * N + ";"), "B0008")
    yield check("a long sum", action("x = " + "+".join(["1"] * N) + ";"), "B0008")
    yield check("many signs", action("x = " + "-" * N + "1;"), "B0008")
    yield check("if in if", action("if (b) then " * N + "x = 1;" + " fi" * N), "B0008")
    yield check("else if", action("if (b) then x = 1; " + "else if (b) then x = 2; " * N + "fi"), "B0008")
    yield check("groups", package("  port type T()\n  connector type C(T p) define " + "(" * N + "p" + ")" * N + " end\n"), "B0008")
    yield check("braces", action("{" * N + "}" * N), "B0008")
    yield check("indices", action("x = " + "a[" * N + "0" + "]" * N + ";"), "B0008")
    yield check("loops in loops", root("    " + "for i in 0..1 " * N + "connector One c(a.p)\n"), "B0008")
    yield check("comments", "/*" * N, "B0003")
    yield check("dots", action("x = " + ".".join(["a"] * N) + ";"), "B1001")
    # ---- size
    yield check("a long name", package("  port type " + "a" * 5_000_000 + "()\n"), None, 0)
    yield check("a long unknown name", action("x = " + "a" * 1_000_000 + ";"), "B1001")
    yield check("a long string", package('  const data string s = "' + "a" * 5_000_000 + '"\n'), None, 0)
    yield check("a long int", package("  const data int s = " + "1" * 1_000_000 + "\n"), "B1011")
    yield check("a long exponent", package("  const data float s = 1e" + "9" * 1_000_000 + "\n"), "B1012")
    yield check("annotations", "@a(b)\n" * N + sound, None, 0)
    yield check("10,000 errors", action("\n".join(f"y{i} = 1;" for i in range(10_000))), "B1001")
    yield check("10,000 errors in a line", action(" ".join(f"y{i} = 1;" for i in range(10_000))), "B1001")
    yield check("10,000 errors of syntax", package("  port type ;\n" * 10_000), "B0001")
    yield check("names that are nearly known", action("\n".join(f"v{i}x = 1;" for i in range(3000))).replace(
        "    place", "".join(f"    data int v{i} = 0\n" for i in range(3000)) + "    place"), "B1001")
    yield check("places", package("  atom type A()\n    place " + ", ".join(f"s{i}" for i in range(20_000)) + "\n    initial to s0\n" + "".join(
        f"    internal from s{i} to s{i + 1}\n" for i in range(19_998, -1, -1)) + "  end\n"), None, 0)
    yield check("transitions of one port", package("  port type T()\n  atom type A()\n    export port T p()\n    place S\n    initial to S\n" +
                                                   "    on p from S to S provided (1 < 2)\n" * 10_000 + "  end\n"), "B1026", 0)
    yield check("a wide define", package("  port type T()\n  connector type C(" + ", ".join(f"T p{i}" for i in range(10_000)) + ") define " + " ".join(
        f"p{i}'" for i in range(10_000)) + " end\n"), None, 0)
    # ---- functions
    yield check("recursion", action("x = f(1);", "  function int f(int n) = f(n - 1) + f(n - 2)\n"), "B1016")
    yield check("calls that double", action("x = f13(1);", functions(13, "f{0}(n) + f{0}(n)")), None, 0)
    yield check("calls that double for long", action("x = f40(1);", functions(40, "f{0}(n) + f{0}(n)")), "B0008")
    yield check("calls that double too often", action("x = f16(1);", functions(16, "f{0}(n) + f{0}(n)")), "B4006")
    yield check("arguments that double", action("x = f40(1);", functions(40, "f{0}(n + n)")), "B4006")
    yield check("calls in arguments", action("x = " + "f(" * 400 + "0" + ")" * 400 + ";", "  function int f(int n) = n + 1\n"), None, 0)
    yield check("deep calls in arguments", action("x = " + "f(" * 400 + "0" + ")" * 400 + ";",
                                                  "  function int f(int n) = " + "(" * 300 + "n" + " + 1)" * 300 + "\n"), "B0008")
    yield check("deep bodies", action("x = f15(1);", functions(15, "-(" * 230 + "f{0}(n)" + ")" * 230)), "B0008")
    # ---- instances
    yield check("compounds in compounds, outermost first", package(TYPES + chain(20_000, "  compound type C{0}()\n    component C{1} c()\n  end\n") +
                                                                   "  compound type C20000()\n    component A a()\n    connector One o(a.p)\n  end\n"), "B0008")
    yield check("compounds in compounds, innermost first", package(
        TYPES + "  compound type C0()\n    component A a()\n    connector One o(a.p)\n  end\n" +
        "".join(f"  compound type C{i}()\n    component C{i - 1} c()\n  end\n" for i in range(1, 20_000))), "B0008")
    yield check("compounds that double", package(TYPES + chain(40, "  compound type C{0}()\n    component C{1} c(), d()\n  end\n") +
                                                 "  compound type C40()\n    component A a()\n    connector One o(a.p)\n  end\n"), "B4006")
    yield check("connectors of connectors", root(chain(20_000, "    connector Up c{0}(c{1}.e)\n") + "    connector Up c20000(a.p)\n    connector One o(c0.e)\n"), "B0008")
    yield check("inline connectors of connectors", "component A\n  port p\n  behavior initial to s\n    state s\n      on p to s\n  end\nend\ncomponent Root\n"
                "  contains A a\n" + chain(20_000, "  connector c{0}(c{1}.e) export port Port e define [c{1}.e]\n") +
                "  connector c20000(a.p) export port Port e define [a.p]\nend\n", "B0008")
    yield check("a loop without end", root("    for i in 0..2000000000 for j in 0..0 connector One c[j](a.p)\n"), "B4006")
    yield check("a loop of one element", root("    for i in 0..2000000000 connector One c[0](a.p)\n"), "B4015")
    yield check("a loop of faults", root("    for i in 0..1000000 connector One c[i / 0](a.p)\n"), "B4008")
    yield check("a far index", root("    for i in 2000000000..2000000001 connector One c[i](a.p)\n"), "B4006")
    yield check("a large array", root("    @SuppressWarning(unboundcomponentport) component A b[2000000000]\n").replace("component A a()", "@SuppressWarning(unboundcomponentport) component A a()"), "B4006")
    yield check("priorities", root("    component A b[3001]\n    for i in 0..3001 connector One c[i](b[i].p)\n" +
                                   chain(3000, "    priority p{0} c[{0}]:* < c[{1}]:*\n")).replace("component A a()", "@SuppressWarning(unboundcomponentport) component A a()"), None, 0)
    # ---- roots and other commands
    for name, text, code in (("parentheses", "(" * N, "B0008"), ("long", "Root(" + "1" * N + ")", "B1015"), ("a NUL", "Root(\x01)", "B0002")):
        yield (f"--root: {name}", root("    connector One o(a.p)\n"), ["check", "--root", text], 1, code)
    yield ("fmt of a long sum", action("x = " + "+".join(["1"] * 400) + ";"), ["fmt"], 0, None)
    yield ("fmt of nesting", action("x = " + "(" * N + ";"), ["fmt"], 1, "B0008")
    yield ("run of a deep expression", package(TYPES.replace("on p from S to S", "on p from S to S provided (" + "!(" * 240 + "true" + ")" * 240 + ")") +
           "  compound type Root()\n    component A a()\n    connector One o(a.p)\n  end\n"), ["run", "--backend=interp", "--limit", "3", "--silent"], 0, None)


def first_code(text):
    found = re.search(r"^(?:error|warning)\[(\w+)\]", text, re.M)
    return found.group(1) if found else None


def run(bipc, folder, content, arguments):
    """Exit code (None: no end in time), standard error."""
    path = pathlib.Path(folder, "odd.bip")
    if isinstance(content, int):
        with open(path, "wb") as file:
            file.truncate(content)
    elif content is not None:
        path.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
    command = ["bash", "-c", f'ulimit -v {ADDRESS_SPACE_KB}; ulimit -t {SECONDS}; exec "$@"', "bash", bipc, arguments[0], str(path), *arguments[1:]]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=12 * SECONDS, env={**os.environ, "NO_COLOR": "1"})
    except subprocess.TimeoutExpired:
        return None, ""
    finally:
        path.unlink(missing_ok=True)
    if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        return None, ""
    return done.returncode, done.stderr.decode("utf-8", "replace")


def main():
    every, words = take_every(sys.argv[1:])
    bipc = os.environ.get("BIPC") or str(pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build") / "bipc")
    if not os.access(bipc, os.X_OK):
        sys.exit(f"odd_inputs: no program at {bipc} (build it with tools/build, or set BIPC)")
    bipc = os.path.abspath(bipc)
    passed = failed = 0
    with tempfile.TemporaryDirectory(prefix="odd-") as folder:
        for name, content, arguments, exit_code, code in itertools.islice(cases(), 0, None, every):
            if words and not any(w in name for w in words):
                continue
            start = time.monotonic()
            got, text = run(bipc, folder, content, arguments)
            seconds = time.monotonic() - start
            problem = None
            if got is None:
                problem = f"no end within {SECONDS} s of the processor"
            elif got != exit_code:
                problem = f"exit code {got}, expected {exit_code}"
            elif first_code(text) != code:
                problem = f"first diagnostic {first_code(text)}, expected {code}"
            elif len(text) > 100_000:
                problem = f"{len(text)} characters of diagnostics"
            if problem:
                failed += 1
                print(f"FAILED {name}: {problem}   ({seconds:.1f} s)\n  {text[:300]}", flush=True)
            else:
                passed += 1
                if words:
                    print(f"ok {name}   ({seconds:.1f} s)")
    print(f"odd_inputs: {passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
