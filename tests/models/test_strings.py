#!/usr/bin/env python3
"""Strings that a run makes are freed: a run of many steps needs about as much memory as one of few, however it is run.

    tests/models/test_strings.py

The model (made here) calls C++ that returns another text in each step. Peak memory of 600,000 steps less that of 20,000
may be 30 MB; if nothing was freed it would be 100 MB. Prints a line a failure and "N passed, M failed".
"""
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
FEW, MANY, MOST_KB = 20_000, 600_000, 30_000
MODEL = """@cpp(src="ext-cpp/texts.cpp", include="texts.hpp")
package texts
  extern function string text_of(int)
  port type Signal()
  connector type One(Signal p)
    define p
  end
  atom type Counter()
    data int n = 0
    data string text
    export port Signal p()
    place counting
    initial to counting
    on p from counting to counting do { n = n + 1; text = text_of(n); }
  end
  compound type Root()
    component Counter a()
    connector One c(a.p)
  end
end
"""
HEADER = "#pragma once\n#include <string>\nstd::string text_of(int n);\n"
SOURCE = '#include "texts.hpp"\nstd::string text_of(int n) { return std::string(60, \'a\') + std::to_string(n); }\n'


def peak(command):
    """Peak memory of a program alone, in KB: not that of the compiler that it may start."""
    child = os.fork()
    if child == 0:
        null = os.open(os.devnull, os.O_RDWR)
        for number in (0, 1, 2):
            os.dup2(null, number)
        os.execv(command[0], command)
    _, status, usage = os.wait4(child, 0)
    return os.waitstatus_to_exitcode(status), usage.ru_maxrss


def main():
    passed = failed = 0
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        (work / "ext-cpp").mkdir()
        model = work / "texts.bip"
        model.write_text(MODEL)
        (work / "ext-cpp" / "texts.hpp").write_text(HEADER)
        (work / "ext-cpp" / "texts.cpp").write_text(SOURCE)
        program = work / "texts"
        subprocess.run([BIPC, "build", str(model), "--root", "Root()", "-o", str(program)], check=True)
        root = [str(model), "--root", "Root()", "--seed", "1"]
        ways = {
            "run": [BIPC, "run", *root, "--silent"],
            "run, with a trace": [BIPC, "run", *root],
            "run --backend=interp": [BIPC, "run", *root, "--silent", "--backend", "interp"],
            "run --stats": [BIPC, "run", *root, "--silent", "--stats", "--backend", "interp"],
            "run --policy=fair": [BIPC, "run", *root, "--silent", "--policy", "fair"],
            "run --engine=threads": [BIPC, "run", *root, "--silent", "--engine", "threads"],
            "run --engine=batch": [BIPC, "run", *root, "--silent", "--engine", "batch"],
            "simulate": [BIPC, "simulate", *root, "--runs", "1"],
            "simulate, many runs": [BIPC, "simulate", *root, "--runs", "200"],
            "a program of bipc build": [str(program), "--silent", "--seed", "1"],
        }
        subprocess.run([*ways["run"], "--limit", "1"], check=True, capture_output=True)  # the C++ is compiled and kept
        for name, command in ways.items():
            runs = 200 if "many" in name else 1
            (few_code, few), (many_code, many) = (peak([*command, "--limit", str(n // runs)]) for n in (FEW, MANY))
            if few_code == 0 and many_code == 0 and many - few < MOST_KB:
                passed += 1
            else:
                failed += 1
                print(f"{name}: {FEW} steps: exit code {few_code}, {few} KB; {MANY} steps: exit code {many_code}, {many} KB")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
