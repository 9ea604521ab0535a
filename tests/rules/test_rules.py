#!/usr/bin/env python3
"""Rules hold: random rules over two small modules, and models/dala/dala.rules over all, run with random requests and codels.

    tests/rules/test_rules.py [--sets N] [--from SEED] [--steps N] [--runs N] [--dala N]

A set is some rules, translated by `bipc rules`, checked without a warning, and run with a few seeds; monitor.py looks for a state
that a rule forbids, and time has to go on. Over all, every kind of rule has to have let in, rejected and stopped somebody.
Python's library only. The last line is "rules: N passed, N failed".
"""
import argparse
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
DALA = ROOT / "models/dala"
sys.path.insert(0, str(HERE))
import monitor  # noqa: E402

BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
# Two small modules, so that each service is asked for often.
MODULES = {
    "wheel": """module wheel { number: 7; internal_data: DATA; };
request SetSpeed { type: exec; exec_task: Motion; codel_main: setSpeed; };
request Turn { type: exec; exec_task: Motion; codel_main: turn; codel_inter: brake; interrupt_activity: Turn; };
request Park { type: exec; exec_task: Motion; codel_main: park; interrupt_activity: Turn; };
request Stop { type: control; interrupt_activity: Turn; };
poster Speed { update: user; data: s::speed; exec_task: Motion; };
exec_task Motion { period: 2; codel_task_main: cycle; };
""",
    "arm": """module arm { number: 8; internal_data: DATA; };
request Aim { type: exec; exec_task: Joint; codel_main: aim; };
request Lift { type: exec; exec_task: Joint; codel_main: lift; codel_inter: rest; fail_reports: HEAVY; };
request Home { type: control; interrupt_activity: Lift; };
poster Pose { update: user; data: p::pose; exec_task: Joint; };
exec_task Joint { period: 3; codel_task_main: sense; };
"""}
SIDE = """codel cycle yields OK
codel sense yields OK
codel setSpeed yields EXEC ETHER
codel turn yields EXEC ETHER
codel brake yields INTER ETHER
codel park yields EXEC ETHER
codel aim yields EXEC ETHER
codel lift yields EXEC ETHER
codel rest yields ETHER
"""
EXECUTION = ("wheel.SetSpeed", "arm.Aim", "wheel.Turn", "arm.Lift", "wheel.Park")
CONTROL = ("wheel.Stop", "arm.Home")
POSTERS = ("wheel.Speed", "arm.Pose")
LOADS = (0, 3, 7, 9)
WRITTEN_EVERY = {"wheel.Speed": 2, "arm.Pose": 3}
PERIODS = {"wheel.Motion": 2, "arm.Joint": 3}
# dala.rules, as the monitor has it.
BATTERY = tuple(f"Battery.{who}StartUsingBattery" for who in ("Camera", "PTU", "Laser", "Wheels", "Antenna"))
DALA_RULES = [("before", "NDD.SetParams", "NDD.GoTo"), ("before", "NDD.SetSpeed", "NDD.GoTo"), *(("apart", "Antenna.Communicate", f"RFLEX.{s}") for s in ("TrackSpeedStart", "GotoPosition", "GotoSpeed")),
              ("fresh", "RFLEX.TrackSpeedStart", "NDD.Speed", 10, True), ("sum", "power", 100)]


def bipc(*arguments, codes=(0,)):
    done = subprocess.run([BIPC, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode not in codes or "warning[" in done.stderr:
        raise monitor.Forbidden(f"bipc {' '.join(map(str, arguments))} ends with {done.returncode}\n{done.stdout[-500:]}{done.stderr[-2000:]}")
    return done


def random_condition(r):
    """(text, tuple) of a condition on time and liveness."""
    kind = r.choice(("silent", "silent", "missed", "failed", "failed", "lost"))
    if kind == "silent":
        module, ticks = r.choice((None, *MODULES)), r.randint(2, 15)
        text, condition = f"{f'{module} is ' if module else ''}silent for {ticks} ticks", (kind, module, ticks)
    elif kind == "missed":
        task = r.choice(tuple(PERIODS))
        text, condition = f"{task}.missed", (kind, task, PERIODS[task])
    else:
        service = "arm.Aim" if kind == "lost" else r.choice(("arm.Lift", "arm.Lift", "arm.Aim"))
        text, condition = f"{service}.{kind}", (kind, service)
    if r.random() < 0.3:
        service = r.choice(EXECUTION)
        return f"{text} && {service}.active", ("both", condition, ("active", service))
    return text, condition


def random_rules(r):
    """(text, tuples) of a few rules that do not contradict each other by their shape: `before` follows the order of EXECUTION."""
    text, rules = [], []
    for _ in range(r.randint(1, 5)):
        a, b = r.sample(EXECUTION, 2)
        kind = r.choice(("before", "apart", "apart", "during", "fresh", "fresh", "at most", "at least", "recent", "recent", "held", "held", "at most of", "group", "when", "when", "unless"))
        if kind == "when":
            condition, service = random_condition(r), r.choice(CONTROL)
            text.append(f"rule{len(text)}: when {condition[0]} run {service};")
            rules.append(("when", condition[1], service, f"rule{len(text) - 1}"))
        elif kind == "unless":
            condition, kept = random_condition(r), r.random() < 0.6
            while a in str(condition[1]) and "active" in condition[0]:
                condition = random_condition(r)
            text.append(f"{a} {'maintains' if kept else 'requires'} !({condition[0]});")
            rules.append(("unless", a, condition[1], kept))
        elif kind == "before":
            a, b = sorted((a, b), key=EXECUTION.index)
            if r.random() < 0.3:
                a = r.choice(CONTROL)
            text.append(f"{a} before {b};")
            rules.append(("before", a, b))
        elif kind in ("at most of", "group"):
            among = r.sample(EXECUTION, r.randint(2, len(EXECUTION)))
            n = r.randint(1, len(among) - 1)
            if kind == "group":
                # Its name stands for all of them; a condition on it is one on any of them.
                group, others = f"group{len(text)}", [s for s in EXECUTION if s not in among]
                text.append(f"services {group}: {', '.join(among)};")
                if others and r.random() < 0.5:
                    text.append(f"{others[0]} requires !{group}.active;")
                    rules += [("not while", others[0], s) for s in among]
                    continue
                text.append(f"at most {n} of {group};")
            else:
                text.append(f"at most {n} of {', '.join(among)};")
            rules.append(("at most of", n, among))
        elif kind == "recent":
            a, b = sorted((a, b), key=EXECUTION.index)
            a = r.choice((a, r.choice(CONTROL)))
            since, ticks = r.choice((None, b, a, r.choice(CONTROL))), r.choice((None, r.randint(5, 60)))
            text.append(f"{a} before {b}{f' since {since}' if since else ''}{f' within {ticks} ticks' if ticks else ''};")
            rules.append(("recent", a, b, since, ticks) if since or ticks else ("before", a, b))
        elif kind == "held":
            p, most, kept = r.choice(POSTERS), r.choice((0, 3, 7)), r.random() < 0.6
            text.append(f"{a} {'maintains' if kept else 'requires'} {p}.load <= {most};")
            rules.append(("held", a, p, LOADS, most, kept))
        elif kind == "apart":
            policies = [r.choice(("reject", "wait", "interrupt")) for _ in range(r.randint(0, 2))]
            text.append(f"{a} does not overlap {b}{': ' if policies else ''}{', '.join(policies)};")
            rules.append(("apart", a, b))
        elif kind == "during":
            a, b = sorted((a, b), key=EXECUTION.index)
            text.append(f"{b} only during {a};")
            rules.append(("during", b, a))
        elif kind == "fresh":
            p = r.choice(POSTERS)
            ticks, kept = r.randint(WRITTEN_EVERY[p], 12), r.random() < 0.6
            text.append(f"{a} {'maintains' if kept else 'requires'} {p} is fresh within {ticks} ticks{' on violation run wheel.Stop' if r.random() < 0.3 else ''};")
            rules.append(("fresh", a, p, ticks, kept))
        elif kind == "at most":
            ticks = r.randint(1, 20)
            text.append(f"{a} takes at most {ticks} ticks;")
            rules.append(("at most", a, ticks))
        else:
            ticks = r.randint(1, 20)
            text.append(f"{a} at least {ticks} ticks after {b};")
            rules.append(("at least", a, ticks, b))
    return text, rules


def watch(bip, rules, seed, steps, work):
    trace = work / "trace.json"
    bipc("run", bip, "--backend", "interp", "--silent", "--seed", seed, "--limit", steps, "--trace", trace)
    m = monitor.Monitor(rules)
    with open(trace, encoding="utf-8") as lines:
        m.follow(lines)
    if m.counts["ticks"] < steps // 200:
        raise monitor.Forbidden(f"time stands still: {m.counts['ticks']} ticks in {steps} steps")
    return {**m.counts, **{f"called by {kind}": n for kind, n in m.called.items()}}


def rises(steps):
    """Does the monitor permit these steps of a level with one rule, `when wheel is silent for 2 ticks run arm.Home`? T: a tick, W: a request to wheel, A: one to arm, R: the recovery."""
    of = {"T": ("InterModuleSync", "masterTimer.tick"), "W": ("wheel_read_Turn", "wheel.control.box.read_Turn"), "A": ("arm_read_Aim", "arm.control.box.read_Aim"), "R": ("arm_recover_when", "arm.control.box.read_Home")}
    m = monitor.Monitor([("when", ("silent", "wheel", 2), "arm.Home", "when")])
    try:
        m.follow(json.dumps({"step": k, "interaction": f"ROOT.{of[s][0]}", "ports": [{"port": f"ROOT.{of[s][1]}"}]}) for k, s in enumerate(steps))
    except monitor.Forbidden:
        return False
    return True


# How often a recovery is asked for, by what compiler/docs/rules.md says: once each time the condition becomes true.
RISES = (("TTR", True), ("TR", False), ("TTRR", False), ("TTTTRTR", False), ("TTAR", True), ("TTTAR", False),
         # It becomes true twice: the first recovery comes before the second time, in the instant of the second, or after it.
         ("TTRWTTR", True), ("TTWTTRR", True), ("TTWTTRTR", True), ("TTWTTRTRTR", False), ("TTTWTTRTR", True), ("TTWTTTR", True), ("TTWTTTRR", False), ("TTWTTTRTR", False),
         ("TTWTTTAR", False))


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--sets", type=int, default=60)
    arguments.add_argument("--from", type=int, default=1, dest="first")
    arguments.add_argument("--steps", type=int, default=4000)
    arguments.add_argument("--runs", type=int, default=1)
    arguments.add_argument("--dala", type=int, default=1, help="runs of all fourteen modules with dala.rules")
    options = arguments.parse_args()
    passed, problems, counts = 0, [], {}
    problems += [f"the monitor {'forbids' if permitted else 'permits'} {steps}" for steps, permitted in RISES if rises(steps) != permitted]
    with tempfile.TemporaryDirectory(prefix="rules-") as folder:
        work = pathlib.Path(folder)
        for name, text in MODULES.items():
            (work / f"{name}.gen").write_text(text, encoding="utf-8")

        def one(bip, rules, seed, what):
            nonlocal passed
            try:
                for key, n in watch(bip, rules, seed, options.steps, work).items():
                    counts[key] = counts.get(key, 0) + n
                passed += 1
            except monitor.Forbidden as e:
                problems.append(f"{what}, run {seed}: {e}")

        for number in range(options.first, options.first + options.sets):
            text, rules = random_rules(random.Random(number))
            # Only some have a codel that is given up.
            (work / "some.yields").write_text(SIDE + ("codel aim async 30 ms\n" if ".lost" in "".join(text) else ""), encoding="utf-8")
            source = work / "some.rules"
            source.write_text("rules some;\nmodules " + ", ".join(f'"{m}.gen"' for m in MODULES) + ' with "some.yields";\n' + "".join(f"value load of {p}: {', '.join(map(str, LOADS))};\n" for p in POSTERS) + "\n".join(text) + "\n", encoding="utf-8")
            what = f"set {number} ({' '.join(text)})"
            try:
                bipc("rules", source, "-o", work / "some.bip")
                bipc("check", work / "some.bip")
            except monitor.Forbidden as e:
                problems.append(f"{what}: {e}")
                continue
            for run in range(options.runs):
                one(work / "some.bip", rules, number * options.runs + run, what)
        if options.dala:
            bipc("rules", DALA / "dala.rules", "-o", work / "dala.bip")
            for run in range(options.dala):
                one(work / "dala.bip", DALA_RULES, run + 1, "dala.rules")
    if options.sets >= 60:
        problems += [f"nobody was ever {what}" for what in ("accepted", "rejected", "stopped", "called by silent", "called by missed", "called by failed") if not counts.get(what)]
    for problem in problems[:20]:
        print(problem)
    print(", ".join(f"{n} {what}" for what, n in counts.items()))
    print(f"rules: {passed} passed, {len(problems)} failed")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
