"""Table II of the paper, ours: a mission of Dala's fourteen modules under a BIP controller and without BIP, in one run. For tools/bench/dala.

Both programs are C++ at -O2/-O3 in one process and logical time, with the same codels (models/dala/mission) and the same requests, without
rules, as in the paper. `plain` runs GenoM's own cycles (controller/plain.cpp). CPU seconds of a whole mission, median of --runs, taking turns. What the codels
cost is what `plain` costs; the rest of the controller's time is shared out by the ports that take part in its steps.
"""
import collections
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


def make(bipc, work):
    for source, target in ((DALA / "mission/world.hpp", "world.hpp"), (DALA / "mission/camera.hpp", "camera.hpp"), (DALA / "mission/bus.hpp", "bus.hpp"), (DALA / "mission/dala_codels.cpp", "rover.cpp"), (HERE / "controller/requests.hpp", "requests.hpp"), (HERE / "controller/plain.cpp", "plain.cpp")):
        shutil.copy(source, work / target)
    # As in the paper no rock is near: Hueblob looks for one all the time.
    world = (work / "world.hpp").read_text(encoding="utf-8")
    (work / "world.hpp").write_text(re.sub(r"rock_x = [\d.]+", "rock_x = 100", world), encoding="utf-8")
    gens = sorted(DALA.glob("*.gen"))
    (work / "requests.txt").write_text(MISSION, encoding="utf-8")
    (work / "dala_codels.cpp").write_text(HOOKS, encoding="utf-8")
    (work / "modules.inc").write_text("".join(map(table, gens)), encoding="utf-8")
    for command in ([bipc, "genom", *gens, "--yields", DALA / "dala.yields", "--executive", "--skeleton", "--control-period", "2", "-o", work / "dala.bip"],
                    [bipc, "build", "dala.bip", "-o", "controller"], [os.environ.get("CXX", "g++"), "-std=c++20", "-O2", "-I", ROOT / "runtime/include", "plain.cpp", "rover.cpp", "-o", "plain"]):
        done = subprocess.run(list(map(str, command)), cwd=work, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{command[:2]}: {done.stdout}{done.stderr[-2000:]}")


def run(work, *command):
    done = subprocess.run([str(work / command[0]), *command[1:]], cwd=work, capture_output=True, text=True)
    return done.stdout + done.stderr


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


def print_table(bipc, work, runs):
    make(bipc, work)
    results = {"controller": [], "plain": []}
    for seed in range(1, runs + 1):
        results["controller"].append(mission(run(work, "controller", "--seed", str(seed), "--silent")))
        results["plain"].append(mission(run(work, "plain")))
    ticks = {name: round(statistics.median(t for t, _ in r)) for name, r in results.items()}
    cpu = {name: statistics.median(s for _, s in r) for name, r in results.items()}
    split = {m: float(s) for m, s in re.findall(r"^module (\w+) ([\d.]+)$", run(work, "plain", "--split"), re.M)}
    codels = {m: s * cpu["plain"] / sum(split.values()) for m, s in split.items()}
    stats = run(work, "controller", "--seed", "1", "--silent", "--stats", "--limit", "200000")
    run(work, "controller", "--seed", "1", "--silent", "--limit", "200000", "--trace", "trace.json")
    share, decisions = shares(work / "trace.json")
    own = cpu["controller"] - cpu["plain"]
    print(f"\n{'CPU ms of a mission':<22} {'plain':>9} {'BIP':>9}")
    for m in sorted(codels):
        print(f"{m:<22} {codels[m] * 1e3:>9.2f} {(codels[m] + own * share.get(m, 0)) * 1e3:>9.2f}")
    print(f"{'all':<22} {cpu['plain'] * 1e3:>9.2f} {cpu['controller'] * 1e3:>9.2f}   {cpu['controller'] / cpu['plain']:.2f}x")
    print(f"{'ticks of 10 ms':<22} {ticks['plain']:>9} {ticks['controller']:>9}   {100 * (ticks['controller'] / ticks['plain'] - 1):+.2f} %")
    seconds = ticks["controller"] / 100
    print(f"of one processor, in real time: plain {100 * cpu['plain'] / seconds:.2f} %, BIP {100 * cpu['controller'] / seconds:.2f} %")
    ns = re.search(r"CPU ns/step ([\d.]+)", stats)
    if ns and decisions:
        # Without codels: what they take of a step is what they take of all.
        step, steps = float(ns.group(1)) * own / cpu["controller"], statistics.median(decisions)
        print(f"a request's decision: {steps:.0f} steps of {step:.0f} ns, {steps * step / 1e3:.1f} us (median of {len(decisions)}, from the message box's reading to its trigger or rejection)")
