#!/usr/bin/env python3
"""The modules of models/dala: translated, checked without a warning, run, verified, and counted beside the paper's Table I.

    tests/genom/test_dala.py [--table] [--steps N] [--timeout SECONDS] [part of a module's name ...]

Components have to be those of Table I, locations and interactions in its order (rank correlation at least 0.85). The paper's five are verified
together, and so are all modules, which are also checked and run as one functional level, and all under dala.rules, whose promises are proved, as are those of terrain.rules. --table prints the table. Python's library only.
The last line is "genom: N passed, N failed".
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DALA = ROOT / "models/dala"
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
FIVE = ("laserrf", "aspect", "ndd", "rflex", "antenna")
BIPC = os.path.abspath(os.environ.get("BIPC") or BUILD / "bipc")
CERTCHECK = BUILD / "certcheck"
# Table I: components, locations, interactions. POM is not in it.
TABLE = {"laserrf": (43, 213, 202), "aspect": (29, 160, 117), "ndd": (27, 152, 117), "rflex": (56, 308, 227), "antenna": (20, 97, 73),
         "battery": (30, 176, 138), "heating": (26, 149, 116), "ptu": (37, 174, 151), "hueblob": (28, 187, 156), "viam": (41, 227, 231),
         "dtm": (34, 198, 201), "stereo": (33, 196, 199), "p3d": (50, 254, 219)}


def bipc(*arguments, codes=(0,)):
    done = subprocess.run([BIPC, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode not in codes or "warning[" in done.stderr:
        raise AssertionError(f"bipc {' '.join(map(str, arguments))} ends with {done.returncode}: {done.stdout[-300:]}{done.stderr[-1500:]}")
    return done


def side_of(name, work):
    """The lines of dala.yields that are about one module, without what it reads of others."""
    lines, here = [], False
    for line in (DALA / "dala.yields").read_text(encoding="utf-8").splitlines():
        if line.startswith("# "):
            here = line[2:].strip().lower() == name
        elif here and not line.startswith("task "):
            lines.append(line)
    path = pathlib.Path(work) / f"{name}.yields"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def sizes(bip):
    """Components, locations, interactions of the module itself, from the flat system: the semaphore and the clock are not its own."""
    system = bipc("emit", "--emit=system", bip).stdout
    places, kind, atoms, locations = {}, None, 0, 0
    for line in system.splitlines():
        if m := re.match(r"\(atom-type (\d+) ", line):
            kind = m.group(1)
            places[kind] = 0
        elif line.startswith("  (place "):
            places[kind] += 1
        elif m := re.match(r"\(atom \d+ \S+ (\d+):(\S+)", line):
            if m.group(2).split(".")[-1] not in ("Semaphore", "MasterTimer"):
                atoms += 1
                locations += places[m.group(1)]
    interactions = sum(1 for line in system.splitlines() if line.startswith("(connector ") and " bound " not in line.split("(in ")[0])
    return atoms, locations, interactions


def ranks(values):
    order = sorted(values)
    return [sum(i for i, o in enumerate(order) if o == v) / order.count(v) for v in values]


def correlation(a, b):
    """Spearman's: of the ranks."""
    x, y = ranks(a), ranks(b)
    mx, my = sum(x) / len(x), sum(y) / len(y)
    top = sum((p - mx) * (q - my) for p, q in zip(x, y))
    return top / (sum((p - mx) ** 2 for p in x) * sum((q - my) ** 2 for q in y)) ** 0.5


def prove_with_rules(work, timeout):
    """The level under dala.rules: what rules remember is data, which the prover bounds by induction."""
    bip = pathlib.Path(work) / "ruled.bip"
    bipc("rules", DALA / "dala.rules", "-o", bip)
    verdict = bipc("verify", "--no-reuse", "--property", "deadlock", "--timeout", timeout, bip, codes=(0, 3, 4)).stdout.splitlines()[0]
    if not verdict.startswith("deadlock-free: proved"):
        raise AssertionError(f"with rules: {verdict}")
    return verdict


def keep_promises(work, timeout):
    """The promises of dala.rules: of the reduced modules, and of the whole level with a certificate that certcheck accepts. Without one of its rules a promise is not kept."""
    work = pathlib.Path(work)
    bip, bsys, certificate = work / "ruled.bip", work / "ruled.bsys", work / "promise.cert"
    shown = bipc("rules", "--prove", "--timeout", timeout, DALA / "dala.rules", "-o", bip).stderr
    if "B616" in shown:
        raise AssertionError(f"promises of the reduced modules: {shown}")
    bsys.write_text(bipc("check", "--emit=system", bip).stdout, encoding="utf-8")
    for promise in ("sharp", "prepared"):
        verdict = bipc("verify", "--no-reuse", "--property", promise, "--timeout", timeout, "--certificate", certificate, bip, codes=(0, 3, 4)).stdout
        if not verdict.startswith("holds"):
            raise AssertionError(f"promise {promise}: {verdict}")
        accepted = subprocess.run([CERTCHECK, bsys, certificate], capture_output=True, text=True, check=False)
        if not accepted.stdout.startswith("accepted"):
            raise AssertionError(f"certificate of promise {promise}: {accepted.stdout}{accepted.stderr}")
    for description in (*DALA.glob("*.gen"), DALA / "dala.yields"):
        shutil.copy(description, work)
    rules = (DALA / "dala.rules").read_text(encoding="utf-8").splitlines()
    (work / "less.rules").write_text("\n".join(line for line in rules if not line.startswith("sharp_while_moving")), encoding="utf-8")
    broken = bipc("rules", "--prove", "--timeout", timeout, work / "less.rules", "-o", bip, codes=(0, 1)).stderr
    if "the rules do not keep promise `sharp`" not in broken or "promise `steady`" in broken:
        raise AssertionError(f"without a rule: {broken}")


def keep_terrain_promises(work, timeout):
    """Those of terrain.rules and of dala.rules, which it extends; of the whole level one with a certificate. Without one of its rules pairs of images are taken while it drives fast."""
    work = pathlib.Path(work)
    bip, bsys, certificate = work / "terrain.bip", work / "terrain.bsys", work / "terrain.cert"
    shown = bipc("rules", "--prove", "--timeout", timeout, DALA / "terrain.rules", "-o", bip).stderr
    promises = re.findall(r"^    property (\w+)", bip.read_text(encoding="utf-8"), re.M)
    if "B616" in shown or promises != ["sharp", "steady", "prepared", "still", "one_navigation", "sharp_pairs", "bounded"]:
        raise AssertionError(f"promises of terrain.rules: {promises} {shown}")
    bsys.write_text(bipc("check", "--emit=system", bip).stdout, encoding="utf-8")
    verdict = bipc("verify", "--no-reuse", "--property", "one_navigation", "--timeout", timeout, "--certificate", certificate, bip, codes=(0, 3, 4)).stdout
    accepted = subprocess.run([CERTCHECK, bsys, certificate], capture_output=True, text=True, check=False)
    if not verdict.startswith("holds") or not accepted.stdout.startswith("accepted"):
        raise AssertionError(f"promise one_navigation: {verdict} {accepted.stdout}{accepted.stderr}")
    # Those modules that its own rules are about: what is not kept is found sooner.
    modules = ", ".join(f'"{DALA / name}.gen"' for name in ("ndd", "rflex", "viam", "dtm", "p3d"))
    rules = (DALA / "terrain.rules").read_text(encoding="utf-8").replace('extends "dala.rules"', f"modules {modules}").splitlines()
    (work / "less.rules").write_text("\n".join(line for line in rules if not line.startswith("pairs_at_rest")), encoding="utf-8")
    broken = bipc("rules", "--prove", "--timeout", timeout, work / "less.rules", "-o", bip, codes=(0, 1)).stderr
    if re.findall("keep promise `(.*?)`", broken) != ["sharp_pairs"]:
        raise AssertionError(f"without a rule: {broken}")


def figures(work, timeout):
    """The deadlocks of the paper's Figures 11 and 12 and of its footnote 19, in generated modules."""
    work = pathlib.Path(work)
    side, fresh, bip = side_of("ndd", work), work / "fresh.yields", work / "figure.bip"

    def verify(*arguments):
        bipc("genom", *arguments, "-o", bip)
        found = json.loads(bipc("verify", "--no-reuse", "--json", "--timeout", timeout, bip, codes=(0, 3, 4)).stdout)
        return found["verdict"], {component: state["places"][0] for component, state in found.get("state", {}).items()}

    verdict, places = verify("--as-in-the-paper", "first", DALA / "ndd.gen", "--yields", side)
    if verdict != "deadlock" or places["NDD.control.box"] != "abtI" or places["NDD.NddTask.scheduler"] != "idle":
        raise AssertionError(f"Figure 11: {verdict} {places}")
    verdict, _ = verify("--as-in-the-paper", "repaired", DALA / "ndd.gen", "--yields", side)
    if verdict != "deadlock-free":
        raise AssertionError(f"Figure 11, repaired: {verdict}")
    # Aspect stops for good where its permanent codel fails.
    aspect = side_of("aspect", work).read_text(encoding="utf-8").replace("codel aspectPermanent yields OK", "codel aspectPermanent yields OK ERROR")
    fresh.write_text(side.read_text(encoding="utf-8") + aspect + "task NDD.NddTask reads Aspect.PolarPoster within 5\n", encoding="utf-8")
    verdict, _ = verify("--as-in-the-paper", "repaired", DALA / "ndd.gen", DALA / "aspect.gen", "--yields", fresh)
    if verdict != "deadlock":
        raise AssertionError(f"Figure 12: {verdict}")
    # Footnote 19: Antenna takes its lock and never gives it back, so neither its task nor its control task begins again.
    verdict, _ = verify(DALA / "antenna.gen", "--yields", side_of("antenna", work))
    if verdict != "deadlock-free":
        raise AssertionError(f"Antenna: {verdict}")
    text, count = re.subn(r"(connector give_AntennaTask\(AntennaTask.give), lock.give(.*?\n\s*define \[AntennaTask.give), lock.give", r"\1\2", bip.read_text(encoding="utf-8"))
    bip.write_text(text, encoding="utf-8")
    found = json.loads(bipc("verify", "--no-reuse", "--json", "--timeout", timeout, bip, codes=(0, 3, 4)).stdout)
    if count != 1 or found["verdict"] != "deadlock" or found["state"]["Antenna.lock"]["places"] != ["HELD"]:
        raise AssertionError(f"footnote 19: {count} {found['verdict']} {found.get('state', {}).get('Antenna.lock')}")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("names", nargs="*")
    arguments.add_argument("--table", action="store_true")
    arguments.add_argument("--steps", type=int, default=1000)
    arguments.add_argument("--timeout", type=int, default=240)
    options = arguments.parse_args()
    names = [n for n in [*TABLE, "pom"] if not options.names or any(part in n for part in options.names)]
    passed, problems, counted, rows = 0, [], {}, []
    with tempfile.TemporaryDirectory(prefix="dala-") as work:
        for name in names:
            try:
                bip = pathlib.Path(work) / f"{name}.bip"
                bipc("genom", DALA / f"{name}.gen", "--yields", side_of(name, work), "-o", bip)
                bipc("check", bip)
                ran = bipc("run", bip, "--seed", 1, "--limit", options.steps, "--silent").stdout
                if f"limit: {options.steps} steps" not in ran:
                    raise AssertionError(f"the run of {name} ends early: {ran}")
                begin = time.monotonic()
                verdict = bipc("verify", "--no-reuse", "--timeout", options.timeout, bip).stdout.splitlines()[0]
                seconds = time.monotonic() - begin
                if not verdict.startswith("deadlock-free: proved"):
                    raise AssertionError(f"{name}: {verdict}")
                counted[name] = sizes(bip)
                if name in TABLE and counted[name][0] != TABLE[name][0]:
                    raise AssertionError(f"{name} has {counted[name][0]} components, Table I has {TABLE[name][0]}")
                rows.append((name, *counted[name], bip.read_text(encoding="utf-8").count("\n"), seconds, verdict))
                passed += 1
            except AssertionError as e:
                problems.append(f"{name}: {e}")
        try:
            if not options.names:
                bip, side = pathlib.Path(work) / "five.bip", pathlib.Path(work) / "five.yields"
                side.write_text("".join(side_of(n, work).read_text(encoding="utf-8") for n in FIVE), encoding="utf-8")
                bipc("genom", *(DALA / f"{n}.gen" for n in FIVE), "--yields", side, "-o", bip)
                verdict = bipc("verify", "--no-reuse", "--timeout", options.timeout, bip, codes=(0, 3, 4)).stdout.splitlines()[0]
                if not verdict.startswith("deadlock-free: proved"):
                    raise AssertionError(f"the five: {verdict}")
                passed += 1
                bip = pathlib.Path(work) / "dala.bip"
                bipc("genom", *(DALA / f"{n}.gen" for n in names), "--yields", DALA / "dala.yields", "-o", bip)
                bipc("check", bip)
                if f"limit: {options.steps} steps" not in bipc("run", bip, "--seed", 1, "--limit", options.steps, "--silent").stdout:
                    raise AssertionError("the run of all modules ends early")
                verdict = bipc("verify", "--no-reuse", "--timeout", options.timeout, bip, codes=(0, 3, 4)).stdout.splitlines()[0]
                if not verdict.startswith("deadlock-free: proved"):
                    raise AssertionError(verdict)
                rows.append(("all", *sizes(bip), bip.read_text(encoding="utf-8").count("\n"), 0.0, ""))
                passed += 1
                prove_with_rules(work, options.timeout)
                passed += 1
                keep_promises(work, options.timeout)
                passed += 1
                keep_terrain_promises(work, options.timeout)
                passed += 1
                figures(work, options.timeout)
                passed += 1
        except AssertionError as e:
            problems.append(f"all modules: {e}")
    known = [n for n in counted if n in TABLE]
    if len(known) == len(TABLE):
        for column, what in ((1, "locations"), (2, "interactions")):
            r = correlation([counted[n][column] for n in known], [TABLE[n][column] for n in known])
            print(f"{what}: rank correlation with Table I {r:.2f}")
            if r < 0.85:
                problems.append(f"{what} are not in the order of Table I: {r:.2f}")
    if options.table:
        print("| module | components | locations | interactions | lines | verify s | paper: components locations interactions |")
        for name, atoms, locations, interactions, lines, seconds, _ in rows:
            print(f"| {name} | {atoms} | {locations} | {interactions} | {lines} | {seconds:.2f} | {' '.join(map(str, TABLE.get(name, ())))} |")
    for problem in problems:
        print(problem)
    print(f"genom: {passed} passed, {len(problems)} failed")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
