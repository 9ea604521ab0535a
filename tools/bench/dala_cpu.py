"""Table II of the paper, ours: a mission of Dala's fourteen modules under a BIP controller and without BIP, in one run. For tools/bench/dala.

Both programs are C++ with the same flags (those of `bipc build`), with the same codels (models/dala/mission) and the same requests, without
rules, as in the paper. `plain` runs GenoM's own cycles (controller/plain.cpp). CPU seconds of a whole mission, median of --runs, taking turns. What the codels
cost is what `plain` costs; the rest of the controller's time is shared out by the ports that take part in its steps.

A second pair of rows leaves out what the codels of the cameras do (VIAM takes images, Hueblob searches them), which is most of what all codels do; with `real`
both are also run in real time, a tick each 10 ms, where waking up costs both something. `instructions` counts, under valgrind, where those of the second pair go. GenoM's own run time is not here: no public source of GenoM 2 builds on today's systems without changes of
its own, so `plain` is its cycles, not its processes, messages and shared memory, which would make the first column larger.
"""
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
DALA = ROOT / "models/dala"
MISSION = """do POM.Init
do RFLEX.Init
do LaserRF.Init
do Aspect.Init
do NDD.Init
do PTU.Init
do VIAM.Init
do Hueblob.Init
do Heating.Init
do Antenna.Init
do Battery.Init
do Heating.HeatTo 10
do NDD.SetParams
do NDD.SetSpeed 0.5
start LaserRF.StartAcquisition
start Aspect.BuildMap
start VIAM.AcquireContinuous
start Hueblob.Monitor
start RFLEX.TrackSpeedStart
do NDD.GoTo 3.2 0.4
start RFLEX.TrackSpeedStop
await RFLEX.TrackSpeedStart
do PTU.MoveAbsolute -0.8
do VIAM.Acquire
do PTU.MoveAbsolute 0.8
do VIAM.Acquire
start RFLEX.TrackSpeedStart
do NDD.GoTo 0 0
start RFLEX.TrackSpeedStop
await RFLEX.TrackSpeedStart
do Antenna.Communicate
"""
HOOKS = """#include "rover.cpp"
#include "requests.hpp"
void at_end() {}
std::string executive_request() { return bench::requests().next(); }
void executive_answer(const char* module, const char* service, const char* report) { bench::requests().answer(std::string(module) + "." + service, report); }
void executive_reply(const char* module, const char* service, const char* report) { bench::requests().reply(std::string(module) + "." + service, report); }
"""
LIMIT = "60000"  # steps that are looked at: two thirds of a mission, which ends the program
CODELS = ("codel_start", "codel_main", "codel_end", "codel_inter", "codel_fail")


def blocks(text, kind):
    """(name, attributes) of each `kind NAME { ... };`"""
    for name, body in re.findall(kind + r"\s+(\w+)\s*\{(.*?)\n\}", text, re.S):
        yield name, {k: v.strip() for k, v in re.findall(r"(\w+)\s*:\s*([^;]+);", body)}


def table(path):
    """One row of modules.inc."""
    text = re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.S)
    name = next(blocks(text, "module"))[0]
    tasks, requests = list(blocks(text, "exec_task")), list(blocks(text, "request"))
    names, numbers = [r[0] for r in requests], {t[0]: k for k, t in enumerate(tasks)}

    def listed(attributes, key):
        value = attributes.get(key, "none")
        return [] if value == "none" else [v.strip() for v in value.split(",")]

    rows = []
    for request, a in requests:
        incompatible = listed(a, "interrupt_activity")
        stopped = [n for n in names if n != request or request in incompatible] if a["type"] == "init" or incompatible == ["all"] else [n for n in incompatible if n in names]
        codels = ", ".join(a.get(c, "nullptr") for c in CODELS)
        reports = ", ".join(f'"{r}"' for r in listed(a, "fail_reports"))
        rows.append(f'{{"{request}", \'{a["type"][0]}\', {numbers.get(a.get("exec_task"), -1)}, {a.get("codel_control", "nullptr")}, {{{codels}}}, {{{reports}}}, '
                    f'{{{", ".join(str(names.index(n)) for n in stopped)}}}, {2 if request in stopped else 1}}}')
    periods = ", ".join(f'{{"{task}", {a.get("period", "1")}, {a.get("codel_task_main", "nullptr")}}}' for task, a in tasks)
    return f'{{"{name}", {{{periods}}}, {{{", ".join(rows)}}}}},\n'


# What `bipc build` compiles with, without choices of the user.
FLAGS = ("-std=c++20", "-O3", "-pthread", "-fno-pie", "-no-pie")


def make(bipc, work, images):
    work.mkdir(exist_ok=True)
    for source, target in ((DALA / "mission/world.hpp", "world.hpp"), (DALA / "mission/camera.hpp", "camera.hpp"), (DALA / "mission/terrain.hpp", "terrain.hpp"), (DALA / "mission/vision.hpp", "vision.hpp"), (DALA / "mission/bus.hpp", "bus.hpp"), (DALA / "mission/dala_codels.cpp", "rover.cpp"), (HERE / "controller/requests.hpp", "requests.hpp"), (HERE / "controller/plain.cpp", "plain.cpp")):
        shutil.copy(source, work / target)
    # As in the paper no rock is near: Hueblob looks for one all the time.
    world = (work / "world.hpp").read_text(encoding="utf-8")
    (work / "world.hpp").write_text(re.sub(r"rock_x = [\d.]+", "rock_x = 100", world), encoding="utf-8")
    if not images:
        camera, count = re.subn(r"\ninline (void take|bool find_red)\([^{]*\{\n", lambda m: m.group(0) + ("  return;\n" if "void" in m.group(1) else "  return false;\n"), (work / "camera.hpp").read_text(encoding="utf-8"))
        assert count == 2, count
        (work / "camera.hpp").write_text(camera, encoding="utf-8")
    gens = sorted(DALA.glob("*.gen"))
    (work / "requests.txt").write_text(MISSION, encoding="utf-8")
    (work / "dala_codels.cpp").write_text(HOOKS, encoding="utf-8")
    (work / "modules.inc").write_text("".join(map(table, gens)), encoding="utf-8")
    for command in ([bipc, "genom", *gens, "--yields", DALA / "dala.yields", "--executive", "--skeleton", "--control-period", "2", "-o", work / "dala.bip"],
                    [bipc, "build", "dala.bip", "-o", "controller"], [os.environ.get("CXX", "g++"), *FLAGS, "-I", ROOT / "runtime/include", "plain.cpp", "rover.cpp", "-o", "plain"]):
        done = subprocess.run(list(map(str, command)), cwd=work, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{command[:2]}: {done.stdout}{done.stderr[-2000:]}")


def run(work, *command, real=False):
    done = subprocess.run([str(work / command[0]), *command[1:]], cwd=work, capture_output=True, text=True, env={**os.environ, **({"BENCH_REAL_TIME": "1"} if real else {})})
    return done.stdout + done.stderr


def pair(work, runs):
    """{program: (ticks, CPU seconds)}, medians of runs that take turns."""
    results = {"controller": [], "plain": []}
    for seed in range(1, runs + 1):
        results["controller"].append(mission(run(work, "controller", "--seed", str(seed), "--silent")))
        results["plain"].append(mission(run(work, "plain")))
    return {name: (round(statistics.median(t for t, _ in r)), statistics.median(s for _, s in r)) for name, r in results.items()}


def real_pair(work):
    """The same in real time, both at once: neither takes more than a few hundredths of a processor."""
    with concurrent.futures.ThreadPoolExecutor() as pool:
        runs = {"controller": pool.submit(run, work, "controller", "--seed", "1", "--silent", real=True), "plain": pool.submit(run, work, "plain", real=True)}
        return {name: mission(r.result()) for name, r in runs.items()}


# Whose instructions they are, by the names of functions; what remains are codels and libraries that they call.
CAUSES = (("codels are timed", r"Codel[A-Z]|codel_was_late|steady_clock|clock_gettime"),
          ("choice of a step, list of what is enabled", r"RunLoop|Scheduler|EnabledSet|ListChanges|CoreParts::|Prng|collect_strings|wants_collection|__sort|__introsort"),
          ("atoms, and the counters that their ports move", r"AtomSteps|update_places|compared_data|copy_data|has_same_data|^model::"),
          ("counters that cross zero", r"PortStates"),
          ("priorities", r"PriorityState|matches_"),
          ("ports that take part, transfers", r"Firing"),
          ("guards and choices of connectors", r"InteractionSearch|RememberedSearches|evaluate"))


def self_costs(work, *command):
    """{function: its own instructions} of a run under callgrind, and the run's text"""
    out = work / "callgrind.out"
    done = subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", str(work / command[0]), *command[1:]], cwd=work, capture_output=True, text=True)
    costs, names, function, is_call = collections.Counter(), {}, "", False
    for line in out.open(encoding="utf-8", errors="replace"):
        if found := re.match(r"c?fn=\((\d+)\)(?: (.*))?$", line):
            if found.group(2):
                names[found.group(1)] = found.group(2)
            function = names[found.group(1)] if line[0] == "f" else function
        elif line.startswith("calls="):
            is_call = True
        elif found := re.match(r"[+\-*\d]\S* (\d+)$", line):
            # What follows a call are the instructions of the called function, which it has itself.
            costs[function] += 0 if is_call else int(found.group(1))
            is_call = False
    return costs, done.stdout + done.stderr


def print_instructions(bipc, work):
    """Where the instructions of a mission without the codels of images go, by cause. One run of each program: with one seed they are always the same."""
    if shutil.which("valgrind") is None:
        raise SystemExit("instructions are counted by valgrind, which is not installed")
    make(bipc, work, images=False)
    start, _ = self_costs(work, "controller", "--seed", "1", "--silent", "--limit", "1")
    whole, text = self_costs(work, "controller", "--seed", "1", "--silent")
    plain, plain_text = self_costs(work, "plain")
    ticks, plain_ticks = mission(text)[0], mission(plain_text)[0]
    rows = collections.Counter({"start": sum(start.values())})
    for function, cost in whole.items():
        cause = next((name for name, pattern in CAUSES if re.search(pattern, function)), "codels and libraries")
        rows[cause] += cost - start[function]
    print(f"\n{'instructions a tick':<46} {'plain':>9} {'BIP':>9}")
    for name in (*(name for name, _ in CAUSES), "codels and libraries", "start"):
        print(f"{name:<46} {'':>9} {rows[name] / ticks:>9.0f}")
    total, plain_total = sum(whole.values()) / ticks, sum(plain.values()) / plain_ticks
    print(f"{'all':<46} {plain_total:>9.0f} {total:>9.0f}   {total / plain_total:.2f}x")


def mission(text):
    """(ticks, CPU seconds)"""
    found = re.search(r"over: (\d+) ticks, ([\d.]+) s", text)
    if not found:
        raise SystemExit(f"the mission is not over: {text[-500:]}")
    return int(found.group(1)), float(found.group(2))


def shares(trace):
    """{module: its part of the ports of all steps}, steps from a request to its decision."""
    ports, pending, decisions = collections.Counter(), {}, []
    for number, line in enumerate(trace.open(encoding="utf-8", errors="replace")):
        try:
            step = json.loads(line)
        except ValueError:
            break
        for p in step.get("ports", []):
            parts = p["port"].split(".")
            if len(parts) > 3:
                ports[parts[1]] += 1
            if parts[-1].startswith("read_") and "box" in parts:
                pending[parts[1]] = number
            elif parts[-1].startswith(("trig_", "rej_")) and "box" in parts and parts[1] in pending:
                decisions.append(number - pending.pop(parts[1]))
    total = sum(ports.values())
    return {m: n / total for m, n in ports.items()}, decisions


def print_row(name, found):
    (_, plain), (_, controller) = found["plain"], found["controller"]
    print(f"{name:<38} {plain * 1e3:>9.2f} {controller * 1e3:>9.2f}   {controller / plain:.2f}x", flush=True)


def print_table(bipc, work, runs, real):
    bare = work / "bare"
    make(bipc, work, images=True)
    make(bipc, bare, images=False)
    found = pair(work, runs)
    ticks, cpu = {name: t for name, (t, _) in found.items()}, {name: s for name, (_, s) in found.items()}
    split = {m: float(s) for m, s in re.findall(r"^module (\w+) ([\d.]+)$", run(work, "plain", "--split"), re.M)}
    codels = {m: s * cpu["plain"] / sum(split.values()) for m, s in split.items()}
    stats = run(work, "controller", "--seed", "1", "--silent", "--stats", "--limit", LIMIT)
    run(work, "controller", "--seed", "1", "--silent", "--limit", LIMIT, "--trace", "trace.json")
    share, decisions = shares(work / "trace.json")
    own = cpu["controller"] - cpu["plain"]
    print(f"\n{'CPU ms of a mission':<22} {'plain':>9} {'BIP':>9}")
    for m in sorted(codels):
        print(f"{m:<22} {codels[m] * 1e3:>9.2f} {(codels[m] + own * share.get(m, 0)) * 1e3:>9.2f}")
    print(f"\n{'CPU ms of a mission':<38} {'plain':>9} {'BIP':>9}")
    print_row("all codels", found)
    print_row("without those of images", pair(bare, runs))
    if real:
        print_row("in real time", real_pair(work))
        print_row("in real time, without those of images", real_pair(bare))
    print(f"{'ticks of 10 ms':<22} {ticks['plain']:>9} {ticks['controller']:>9}   {100 * (ticks['controller'] / ticks['plain'] - 1):+.2f} %")
    seconds = ticks["controller"] / 100
    print(f"of one processor, in real time: plain {100 * cpu['plain'] / seconds:.2f} %, BIP {100 * cpu['controller'] / seconds:.2f} %")
    ns = re.search(r"CPU ns/step ([\d.]+)", stats)
    if ns and decisions:
        # Without codels: what they take of a step is what they take of all.
        step, steps = float(ns.group(1)) * own / cpu["controller"], statistics.median(decisions)
        print(f"a request's decision: {steps:.0f} steps of {step:.0f} ns, {steps * step / 1e3:.1f} us (median of {len(decisions)}, from the message box's reading to its trigger or rejection)")
