#!/usr/bin/env python3
"""What `bipc export` writes, asked by others: deadlocks and states must be those that `bipc explore` finds.

    tests/verify/test_exports.py [COUNT] [FROM]        systems of COUNT seeds (default 30), small nets, locks and models of tools/gen

Promela: SPIN (if installed) finds an invalid end state exactly where there is a deadlock, and answers the properties of runs in
spin_questions.py, with their fairness, as `bipc verify` does. PNML: the net is well-formed by
the rules of the PT net schema, and has as many reachable markings, and dead ones, as the system has states and deadlocks.
BUILD names the build directory, JOBS the number of systems at a time. Python's library only. To see it go red: leave out
the `fault` guard, or `record`, in compiler/exchange, or let `premise` of promela_runs.cpp return nothing.
"""
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from spin_questions import QUESTIONS  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BUILD") or os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
LIMIT = 20000
PAN_TABLE = "-w17"  # 2^17 rows for LIMIT states; the default of 128 MB is cleared at each start, which takes longer than the search
NS = "{http://www.pnml.org/version-2009/grammar/pnml}"
PTNET = "http://www.pnml.org/version-2009/grammar/ptnet"


def run(command, cwd=None, timeout=600):
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, errors="replace", timeout=timeout)


def explore(path, *options):
    """(states, deadlocks, errors, final states), or None: too many."""
    done = run([BIPC, "explore", "--json", "--backend", "interp", "--threads", "1", "--limit", str(LIMIT), "--timeout", "300", *options, str(path)])
    if done.returncode not in (0, 1, 3):
        return None
    told = json.loads(done.stdout)
    return told["states"], told["deadlocks"], told["errors"], told.get("final_states", 0)


def spin(text, work):
    """Does SPIN find an invalid end state? None: it gave up."""
    (work / "m.pml").write_text(text)
    made = run(["spin", "-a", "m.pml"], work)
    if made.returncode != 0 or "error" in made.stdout.lower():
        raise RuntimeError(f"spin refuses it: {made.stdout[:500]}{made.stderr[:500]}")
    built = run(["cc", "-O0", "-w", "-fwrapv", "-DSAFETY", "-DMEMLIM=1000", "-o", "pan", "pan.c"], work)
    if built.returncode != 0:
        raise RuntimeError(f"pan.c does not compile: {built.stderr[:500]}")
    told = run(["./pan", PAN_TABLE, "-m200000"], work).stdout
    errors = re.search(r"errors: (\d+)", told)
    if not errors or "max search depth too small" in told or "Search not completed" in told and errors.group(1) == "0":
        return None
    if errors.group(1) != "0" and "invalid end state" not in told:
        raise RuntimeError(f"an error of another kind: {told[:500]}")
    return errors.group(1) != "0"


def ask_bipc(question):
    """Does the property hold, as `bipc verify` says?"""
    done = run([BIPC, "verify", "--no-reuse", *question])
    if done.returncode not in (0, 3):
        raise RuntimeError(f"verify ends with {done.returncode}: {done.stdout[:300]}{done.stderr[:300]}")
    return done.returncode == 0


def ask_spin(question, work):
    """Does the property hold, as SPIN says? None: SPIN gave up."""
    promela = run([BIPC, "export", "--format=promela", *question])
    if promela.returncode != 0:
        raise RuntimeError(f"export ends with {promela.returncode}: {promela.stderr[:300]}")
    (work / "m.pml").write_text(promela.stdout)
    made = run(["spin", "-a", "m.pml"], work)
    if made.returncode != 0:
        raise RuntimeError(f"spin refuses it: {made.stdout[:500]}{made.stderr[:500]}")
    built = run(["cc", "-O0", "-w", "-fwrapv", "-DMEMLIM=1000", "-o", "pan", "pan.c"], work)
    if built.returncode != 0:
        raise RuntimeError(f"pan.c does not compile: {built.stderr[:500]}")
    told = run(["./pan", PAN_TABLE, "-a", "-m200000"], work).stdout
    errors = re.search(r"errors: (\d+)", told)
    if not errors or "max search depth too small" in told or "Search not completed" in told and errors.group(1) == "0":
        return None
    return errors.group(1) == "0"


def check_property(row):
    """What is wrong with the two answers to a row of spin_questions.py; empty: they agree."""
    model, root, fair, asked = row
    question = ["--property", asked, "--fair", fair, *(["--root", root] if root else []), str(ROOT / f"models/{model}.bip")]
    with tempfile.TemporaryDirectory() as work:
        try:
            ours, theirs = ask_bipc(question), ask_spin(question, pathlib.Path(work))
        except (RuntimeError, subprocess.TimeoutExpired) as problem:
            return str(problem)
    return "" if ours == theirs else f"bipc says {ours}, SPIN {theirs}"


def check_properties(pool):
    """How many properties of runs SPIN answers as bipc does, and how many not."""
    agreed = failed = 0
    for row, wrong in zip(QUESTIONS, pool.map(check_property, QUESTIONS)):
        if wrong:
            print(f"FAILED {' '.join(str(word) for word in row)}: {wrong}", flush=True)
        agreed, failed = agreed + (not wrong), failed + bool(wrong)
    return agreed, failed


def read_net(text):
    """Places with their tokens, transitions as (taken, put). Complains of what the schema does not allow."""
    root = xml.fromstring(text)
    assert root.tag == NS + "pnml", "the root is no pnml"
    nets = list(root)
    assert len(nets) == 1 and nets[0].tag == NS + "net" and nets[0].get("type") == PTNET and nets[0].get("id"), "not one PT net"
    pages = nets[0].findall(NS + "page")
    assert len(pages) == 1 and {child.tag for child in nets[0]} <= {NS + "page", NS + "name"}, "not one page"
    places, takes, puts, ids = {}, {}, {}, {nets[0].get("id"), pages[0].get("id")}
    for node in pages[0]:
        assert node.get("id") and node.get("id") not in ids, f"id {node.get('id')} is not there once"
        ids.add(node.get("id"))
        allowed = {"place": {"name", "initialMarking"}, "transition": {"name"}, "arc": {"name", "inscription"}}[node.tag[len(NS):]]
        for part in node:
            assert part.tag[len(NS):] in allowed and part.find(NS + "text") is not None, f"{part.tag} in {node.tag}"
        if node.tag == NS + "place":
            places[node.get("id")] = int(node.findtext(f"{NS}initialMarking/{NS}text") or 0)
        elif node.tag == NS + "transition":
            takes[node.get("id")], puts[node.get("id")] = [], []
    for arc in pages[0].findall(NS + "arc"):
        source, target = arc.get("source"), arc.get("target")
        if source in places:
            assert target in takes, "an arc from a place leads to no transition"
            takes[target].append(source)
        else:
            assert source in takes and target in places, "an arc with an end that is none"
            puts[source].append(target)
    return places, [(takes[t], puts[t]) for t in takes]


def markings(places, transitions):
    """Reachable markings and dead ones; None: too many, or a place with two tokens."""
    start = frozenset(p for p, tokens in places.items() if tokens)
    seen, todo, dead = {start}, collections.deque([start]), 0
    while todo:
        now, is_dead = todo.popleft(), True
        for taken, put in transitions:
            if not all(p in now for p in taken):
                continue
            is_dead = False
            left = now - set(taken)
            if len(set(put)) != len(put) or any(p in left for p in put):
                return None
            after = left | set(put)
            if after not in seen:
                seen.add(after)
                todo.append(after)
        dead += is_dead
        if len(seen) > LIMIT:
            return None
    return len(seen), dead


def check(path, has_spin):
    """What was compared, and what is wrong."""
    compared, wrong = [], []
    try:
        ours = explore(path)
        promela = run([BIPC, "export", "--format=promela", str(path)])
        if promela.returncode == 0 and ours and has_spin:
            with tempfile.TemporaryDirectory() as work:
                theirs = spin(promela.stdout, pathlib.Path(work))
            if theirs is not None:
                compared.append("deadlock" if ours[1] else "free")
                if theirs != (ours[1] > 0):
                    wrong.append(f"{ours[1]} deadlocks, SPIN: {theirs}")
        elif promela.returncode != 0:
            compared.append("no promela")
            if "error[B5060]" not in promela.stderr:
                wrong.append(f"export to promela ends with {promela.returncode}: {promela.stderr[:300]}")
        pnml = run([BIPC, "export", "--format=pnml", "--disable-maximal-progress", str(path)])
        if pnml.returncode == 0:
            ours, theirs = explore(path, "--disable-maximal-progress"), markings(*read_net(pnml.stdout))
            if ours and theirs and ours[2] == 0:
                compared.append("net")
                # Data that decides nothing is part of states, and of no marking.
                has_data = re.search(r"^  \(slot (?!.* param)", path.read_text(), re.M)
                # A net has no final states: they are dead markings like others.
                dead = ours[1] + ours[3]
                if (ours[0], dead) != theirs and not (has_data and (dead > 0) == (theirs[1] > 0)):
                    wrong.append(f"states and those without a step {(ours[0], dead)}, the net's {theirs}")
        elif "error[B5060]" not in pnml.stderr:
            wrong.append(f"export to pnml ends with {pnml.returncode}: {pnml.stderr[:300]}")
    except (RuntimeError, AssertionError, xml.ParseError, KeyError, ValueError, subprocess.TimeoutExpired) as problem:
        wrong.append(f"{type(problem).__name__}: {problem}")
    return compared, wrong


def main():
    count, start = (sys.argv[1:] + ["30", "1"])[0], (sys.argv[2:] + ["1"])[0]
    has_spin = bool(shutil.which("spin") and shutil.which("cc"))
    with tempfile.TemporaryDirectory() as systems:
        subprocess.run([str(BUILD / "bip-verify-check"), "--from", start, "--count", count, "--print", systems], check=True, stdout=subprocess.DEVNULL)
        paths = sorted(pathlib.Path(systems).glob("*.bsys"))
        totals, failed = collections.Counter(), 0
        with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS") or os.cpu_count() or 1)) as pool:
            for path, (compared, wrong) in zip(paths, pool.map(lambda p: check(p, has_spin), paths)):
                totals.update(compared)
                for what in wrong:
                    failed += 1
                    print(f"FAILED {path.stem}: {what}", flush=True)
            agreed, disagreed = check_properties(pool) if has_spin else (0, 0)
            failed += disagreed
    if not has_spin:
        failed += 1
        print("FAILED SPIN or cc is not installed (tools/setup --test)")
    print(f"exports: {len(paths)} systems; SPIN agrees on {totals['free']} without and {totals['deadlock']} with deadlock; "
          f"{totals['net']} nets have the same states and deadlocks; no Promela for {totals['no promela']}; "
          f"SPIN agrees on {agreed} properties")
    compared = agreed + totals["net"] + (totals["free"] + totals["deadlock"] if has_spin else 0)
    failed += 0 if totals["net"] and (not has_spin or (totals["free"] and totals["deadlock"])) else 1
    print(f"{max(compared - failed, 0)} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
