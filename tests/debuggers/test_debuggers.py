#!/usr/bin/env python3
"""What gdb and perf see of machine code that `bipc run -g` makes: breakpoints by a model's line, stacks with its lines, a map.

    tests/debuggers/test_debuggers.py

gdb is one of the packages that tools/setup --test installs: without it the test fails. Needs python3; `bipc` is that of $BIPC or build/bipc.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BIPC = os.environ.get("BIPC") or str(pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build") / "bipc")
MODEL = """package shop
  port type Value(int v)

  connector type Sell(Value give, Value take)
    define give take

    on give take provided (give.v > 0) down {
      take.v = take.v + 1;
      give.v = give.v - 1;
    }
  end

  atom type Store()
    data int v = 50
    export port Value give(v)

    place OPEN

    initial to OPEN

    on give from OPEN to OPEN
  end

  atom type Buyer()
    data int v = 0, seen = 0
    export port Value take(v)

    place BUYS

    initial to BUYS

    on take from BUYS to BUYS do {
      seen = seen + 1;
      seen = seen + v;
    }
  end

  compound type Shop()
    component Store store()
    component Buyer buyer()
    connector Sell sell(store.give, buyer.take)
  end
end
"""
failures = []
passed = 0


def check(what, holds, shown=""):
    global passed
    if holds:
        passed += 1
    else:
        failures.append(f"{what}\n{shown[-3000:]}")


def run_of(*options):
    return [BIPC, "run", "-g", "--seed", "1", "--limit", "20", *options, "shop.bip"]


def stops_at(work, line, *options):
    """What gdb says at a breakpoint in the model."""
    gdb = ["gdb", "-nx", "-batch", "-ex", "set debuginfod enabled off", "-ex", "set breakpoint pending on", "-ex", f"break shop.bip:{line}", "-ex", "run",
           "-ex", "bt 3", "-ex", "kill", "--args", *run_of(*options)]
    done = subprocess.run(gdb, cwd=work, capture_output=True, text=True, timeout=300, stdin=subprocess.DEVNULL)
    return done.stdout + done.stderr


def main():
    with tempfile.TemporaryDirectory(prefix="debuggers-") as work:
        pathlib.Path(work, "shop.bip").write_text(MODEL)
        os.environ["XDG_CACHE_HOME"] = str(pathlib.Path(work, "cache"))
        for level in ("-O0", "-O2"):
            # A second run takes the code from the cache, with its lines.
            for _ in range(2):
                bipc = subprocess.Popen(run_of("--backend=jit", level), cwd=work, stdout=subprocess.PIPE)
                text = bipc.communicate(timeout=120)[0].decode()
                path = pathlib.Path(f"/tmp/perf-{bipc.pid}.map")
                check(f"{level}: the map is there", path.exists())
                lines = path.read_text() if path.exists() else ""
                path.unlink(missing_ok=True)
                check(f"{level}: a run ends as without", bipc.returncode == 0 and text.endswith("limit: 20 steps\n"), text)
                for name in (r"Sell_on_give_take_guard \[shop\.bip:7\]", r"Buyer_on_take_from_BUYS_action \[shop\.bip:\d+\]"):
                    check(f"{level}: perf knows {name}", re.search(rf"^[0-9a-f]+ [0-9a-f]+ {name}$", lines, re.M), lines)
        if shutil.which("gdb"):
            for level in ("-O0", "-O2"):
                for line, function in ((8, "Sell_on_give_take_down"), (33, "Buyer_on_take_from_BUYS_action")):
                    said = stops_at(work, line, "--backend=jit", level)
                    check(f"{level}: gdb stops at line {line}", re.search(rf"#0 .*{function}.* at .*shop\.bip:{line}$", said, re.M), said)
            # Compiled steps carry the connector's line, and what is inlined its own.
            said = stops_at(work, 41, "--backend=jit", "-O2", "--silent")
            check("a compiled step: gdb stops at the connector's line", re.search(r"#0 .*step_Sell.* at .*shop\.bip:41$", said, re.M), said)
        else:
            check("gdb is installed (tools/setup --test)", False)
    for failure in failures:
        print(f"FAILED {failure}")
    print(f"debuggers: {passed} passed, {len(failures)} failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
