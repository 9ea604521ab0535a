#!/usr/bin/env python3
"""Strings that a run makes are freed: a run of many steps needs about as much memory as one of few, however it is run.

    tests/models/test_strings.py

The models (made here) call C++ that returns another text in each step; between nodes the texts travel, and the one that gets them
compares them with what they must be. Peak memory of 600,000 steps less that of 20,000 may be 30 MB; if nothing was freed it would be
100 MB. Prints a line a failure and "N passed, M failed".
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

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
# Two pairs: who sends a text, and who throws it away after a look at it. In `drawn` the numbers of the texts are drawn.
SENT = """@cpp(src="ext-cpp/texts.cpp", include="texts.hpp")
package sent
  extern function string text_of(int)
  extern function check_text(const string, const int)
  port type Text(int n, string text)
  connector type Pass(Text p, Text q)
    define p q
    on p q down { q.n = p.n; q.text = p.text; }
  end
  atom type Source()
    data int n = 0
    data string text
    export port Text put(n, text)
    place ready
    initial to ready do { text = text_of(n); }
    on put from ready to ready do { n = n + 1; text = text_of(n); }
  end
  atom type Sink()
    data int n = 0
    data string text = ""
    export port Text get(n, text)
    place ready
    initial to ready
    on get from ready to ready do { check_text(text, n); }
  end
  compound type Root()
    component Source a(), b()
    component Sink c(), d()
    connector Pass ac(a.put, c.get), ad(a.put, d.get), bc(b.put, c.get), bd(b.put, d.get)
  end
end
"""
DRAWN = MODEL.replace("package texts\n", "package drawn\n  use std.chance\n").replace("n = n + 1;", "n = uniform(0, 2000000000);")
HEADER = "#pragma once\n#include <string>\nstd::string text_of(int n);\nvoid check_text(const std::string& text, int n);\n"
SOURCE = """#include "texts.hpp"
#include <stdexcept>
std::string text_of(int n) { return std::string(60, 'a') + std::to_string(n); }
void check_text(const std::string& text, int n) {
  if (text != text_of(n)) throw std::runtime_error("`" + text + "` is not the text of " + std::to_string(n));
}
"""


def peak(command, stdin=os.devnull):
    """Peak memory of a program alone, in KB: not that of the compiler that it may start."""
    child = os.fork()
    if child == 0:
        null = os.open(os.devnull, os.O_RDWR)
        for number in (1, 2):
            os.dup2(null, number)
        os.dup2(os.open(stdin, os.O_RDONLY), 0)
        os.execv(command[0], command)
    _, status, usage = os.wait4(child, 0)
    return os.waitstatus_to_exitcode(status), usage.ru_maxrss


def peak_of_server(model, steps):
    """Of `bipc serve` that takes the steps because a client asks for them. Such steps can be undone in models without C++."""
    server = subprocess.Popen([BIPC, "serve", "--paused", "--backend", "interp", "--root", "Root()", str(model)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)

    def ask(**request):
        server.stdin.write(json.dumps(request).encode() + b"\n")
        server.stdin.flush()
        answer = {}
        while "ok" not in answer:
            answer = json.loads(server.stdout.readline())
        return answer

    is_good = ask(do="step", count=steps)["ok"]
    while is_good and ask(do="state", atoms=["ROOT.a"])["steps"] < steps:
        time.sleep(0.1)
    kb = int(re.search(r"VmHWM:\s+(\d+)", pathlib.Path(f"/proc/{server.pid}/status").read_text())[1])
    server.stdin.close()
    server.stdout.read()
    return server.wait() if is_good else 1, kb


def main():
    passed = failed = 0
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        (work / "ext-cpp").mkdir()
        model, sent, drawn = (work / f"{name}.bip" for name in ("texts", "sent", "drawn"))
        for path, text in ((model, MODEL), (sent, SENT), (drawn, DRAWN)):
            path.write_text(text)
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
            "simulate, drawn values": [BIPC, "simulate", str(drawn), "--root", "Root()", "--seed", "1", "--runs", "20"],
            "run --engine=simulated": [BIPC, "run", str(sent), "--root", "Root()", "--seed", "1", "--silent", "--engine=simulated", "--nodes", "3"],
            "run --engine=simulated, losses": [BIPC, "run", str(sent), "--root", "Root()", "--seed", "1", "--silent", "--engine=simulated", "--nodes", "2", "--faults", "lose 20%, double 20%"],
            "run --engine=simulated, locks": [BIPC, "run", str(sent), "--root", "Root()", "--seed", "1", "--silent", "--engine=simulated", "--nodes", "4", "--split-above", "1"],
            "run --engine=distributed": [BIPC, "run", str(sent), "--root", "Root()", "--seed", "1", "--silent", "--engine=distributed", "--nodes", "2"],
            "a program of bipc build": [str(program), "--silent", "--seed", "1"],
        }
        for name in ("run", "simulate, drawn values", "run --engine=simulated"):  # the C++ is compiled and kept
            subprocess.run([*ways[name], "--limit", "1"], check=True, capture_output=True)
        peaks = {}
        for name, command in ways.items():
            runs = int(command[command.index("--runs") + 1]) if "--runs" in command else 1
            peaks[name] = [peak([*command, "--limit", str(n // runs)]) for n in (FEW, MANY)]
        for n in (FEW, MANY):
            (work / f"{n}.commands").write_text(f"s {n}\nq\n")
        peaks["step --trust-cpp"] = [peak([BIPC, "step", "--trust-cpp", *root], work / f"{n}.commands") for n in (FEW, MANY)]
        peaks["serve, steps of a client"] = [peak_of_server(model, n) for n in (FEW, MANY)]
        for name, ((few_code, few), (many_code, many)) in peaks.items():
            if few_code == 0 and many_code == 0 and many - few < MOST_KB:
                passed += 1
            else:
                failed += 1
                print(f"{name}: {FEW} steps: exit code {few_code}, {few} KB; {MANY} steps: exit code {many_code}, {many} KB")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
