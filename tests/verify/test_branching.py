#!/usr/bin/env python3
"""Random systems and random properties of branching time: `bipc verify` against an oracle that shares nothing with it.

    tests/verify/test_branching.py [COUNT] [FROM]     COUNT systems (default 150) from seed FROM (default 1)

The systems, their states and their steps are those of test_liveness.py, with deadlocks, priorities and run-time errors. Each is asked three properties with
`possibly`, of depth up to 3. The oracle evaluates them by definition: sets of states, each word as the fixpoint of its equation, computed by going over all states until
nothing changes. A state without steps repeats. A run that bipc reports is followed step by step; what is said of the states on it (that no run from there
reaches E, that a run stays in E for ever) is evaluated by the oracle. Of every fourth system certcheck gets the certificates of what holds, and the negated claim, which it must
refuse, and must refuse a certificate without one of its states. Prints the text of a system with another answer. BIPC names the program, JOBS the number of processes. Python's library only. To see it go red: in
compiler/verify/branching/label_states.cpp let `until` of all runs take a source at its first step inside, let `next` be false of a state without steps, or take the same
quantifier for `dual`; in tools/certcheck/branches.hpp let a state without steps have no successor.
"""
import collections
import concurrent.futures
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from test_liveness import BIPC, CERTCHECK, CERTIFICATES_EVERY, END, MOST_STATES, STEP_LINE, Graph, certcheck, make_system, text_of, write_system  # noqa: E402

PROPERTIES_OF_A_SYSTEM = 3
FEWEST_STATES, TRIES = 5, 20
UNARY = "always", "never", "eventually", "next"
BINARY = "until", "unless"
JOINS = "!", "&&", "||", "implies"


# ---- properties: ("is", condition), (join, parts …), ("all" | "some", word, parts …), ("reach", part): `possibly` of a condition
def random_condition(r, atoms, connectors):
    kind = r.choice(["at", "at", "at", "data", "data", "can"])
    a = r.randrange(len(atoms))
    if kind == "can":
        return kind, r.randrange(len(connectors))
    return kind, a, r.randrange(atoms[a].places) if kind == "at" else r.randint(0, 2)


def random_formula(r, atoms, connectors, depth):
    def part():
        return random_formula(r, atoms, connectors, depth - 1)
    if depth == 0 or r.random() < 0.1:
        return "is", random_condition(r, atoms, connectors)
    kind = r.choice(["join", "all", "some", "some", "reach", "reach"])
    if kind == "join":
        join = r.choice(JOINS)
        return (join, part()) if join == "!" else (join, part(), part())
    if kind == "reach":
        inner = part()
        return ("some", "eventually", inner) if has_bare_word(inner) else ("reach", inner)
    word = r.choice(UNARY + BINARY + (("leads to",) if kind == "all" else ()))
    return (kind, word, part()) if word in UNARY else (kind, word, part(), part())


def parts_of(f):
    return {"is": (), "reach": f[1:], "all": f[2:], "some": f[2:]}.get(f[0], f[1:])


def has_bare_word(f):
    return f[0] == "all" or f[0] in JOINS and any(map(has_bare_word, f[1:]))


def has_possibly(f):
    return f[0] in ("some", "reach") or any(map(has_possibly, parts_of(f)))


def print_formula(f):
    if f[0] == "is":
        kind, *args = f[1]
        return {"at": "a{}@s{}", "data": "a{}.v == {}", "can": "can c{}"}[kind].format(*args)
    parts = [f"({print_formula(part)})" for part in parts_of(f)]
    if f[0] == "reach":
        return f"possibly {parts[0]}"
    word = f[1] if f[0] in ("all", "some") else f[0]
    path = f"{word} {parts[0]}" if len(parts) == 1 else f"{parts[0]} {word} {parts[1]}"
    return path if f[0] != "some" else f"possibly {path}" if len(parts) == 1 else f"possibly ({path})"


def said_of_run(f):
    """How a verdict names what a run has: text of `of_run`."""
    if f[0] == "reach":
        return f"reaches `{print_formula(f[1])}`"
    text = print_formula(f)
    if f[0] == "some":
        text = text[len("possibly "):]
        text = text[1:-1] if f[1] in BINARY else text
    return f"has `{text}`"


# ---- the oracle
class Oracle:
    def __init__(self, graph):
        self.graph, self.all, self.known = graph, frozenset(range(len(graph.states))), {}
        self.after = [sorted({step.target for step in graph.steps[state] if step != END}) or [state] for state in range(len(graph.states))]

    def some(self, inside):
        return frozenset(s for s in self.all if any(to in inside for to in self.after[s]))

    def every(self, inside):
        return frozenset(s for s in self.all if all(to in inside for to in self.after[s]))

    @staticmethod
    def fixpoint(value, equation):
        while True:
            later = equation(value)
            if later == value:
                return value
            value = later

    def path(self, quantifier, word, *parts):
        ahead = self.some if quantifier == "some" else self.every
        a, b = parts[0], parts[-1]
        if word == "next":
            return ahead(a)
        if word == "always":
            return self.fixpoint(self.all, lambda x: a & ahead(x))
        if word == "never":
            return self.fixpoint(self.all, lambda x: (self.all - a) & ahead(x))
        if word == "eventually":
            return self.fixpoint(frozenset(), lambda x: a | ahead(x))
        if word == "until":
            return self.fixpoint(frozenset(), lambda x: b | a & ahead(x))
        if word == "unless":
            return self.fixpoint(self.all, lambda x: b | a & ahead(x))
        answered = self.path("all", "eventually", b)
        return self.path("all", "always", self.all - a | answered)

    def holds(self, f):
        """The states in which it holds."""
        if f not in self.known:
            parts = [self.holds(part) for part in parts_of(f)]
            if f[0] == "is":
                value = frozenset(s for s in self.all if self.graph.atom_holds(f[1], s, END))
            elif f[0] == "!":
                value = self.all - parts[0]
            elif f[0] == "&&":
                value = parts[0] & parts[1]
            elif f[0] == "||":
                value = parts[0] | parts[1]
            elif f[0] == "implies":
                value = self.all - parts[0] | parts[1]
            elif f[0] == "reach":
                value = self.path("some", "eventually", *parts)
            else:
                value = self.path(f[0], f[1], *parts)
            self.known[f] = value
        return self.known[f]

    def reached_from(self, state):
        found, todo = {state}, [state]
        while todo:
            for to in self.after[todo.pop()]:
                if to not in found:
                    found.add(to)
                    todo.append(to)
        return found


def all_parts(f):
    return [f] + [found for part in parts_of(f) for found in all_parts(part)]


def follow(oracle, formula, verdict):
    """What is wrong with the run and with what is said of its states; empty: nothing."""
    graph = oracle.graph
    lines = STEP_LINE.findall(verdict["text"])
    if len(lines) != verdict["steps"]:
        return "its steps are not all printed"
    states = [0]
    for _, connector, ports in lines:
        label = int(connector), tuple(sorted((int(a), int(p)) for a, p in re.findall(r"\ba(\d+)\.p(\d+)", ports)))
        found = [step for step in graph.steps[states[-1]] if step.label == label]
        if not found:
            return f"no step {label} in state {graph.states[states[-1]]}"
        states.append(found[0].target)
    for claim in verdict.get("branches", []):
        state = states[claim["after"]]
        if claim["states"] > len(oracle.reached_from(state)):
            return f"more states than can be reached from {graph.states[state]}"
        named = [part for part in all_parts(formula) if part[0] in ("some", "all", "reach") and said_of_run(part) == claim["of_run"]]
        if not named:
            return f"nothing in the property says `{claim['of_run']}`"
        kind, word, *parts = ("some", "eventually", named[0][1]) if named[0][0] == "reach" else named[0]
        values = [oracle.holds(part) for part in parts]
        # No run has it, or all have it.
        is_true = state not in oracle.path("some", word, *values) if claim["runs"] == "none" else state in oracle.path("all", word, *values)
        if not is_true:
            return f"of {graph.states[state]}: {claim}"
    repeats, has = "cycle" in verdict, None
    if verdict["verdict"] == "violated":
        if formula[:2] == ("all", "always"):
            has = any(s not in oracle.holds(formula[2]) for s in states)
        elif formula[:2] == ("all", "never"):
            has = any(s in oracle.holds(formula[2]) for s in states)
        elif formula[:2] == ("all", "eventually"):
            has = repeats and all(s not in oracle.holds(formula[2]) for s in states)
    elif formula[0] == "reach" or formula[:2] == ("some", "eventually"):
        has = any(s in oracle.holds(formula[-1]) for s in states)
    elif formula[:2] == ("some", "always"):
        has = repeats and all(s in oracle.holds(formula[2]) for s in states)
    elif formula[:2] == ("some", "until"):
        has = any(s in oracle.holds(formula[3]) and all(before in oracle.holds(formula[2]) for before in states[:at]) for at, s in enumerate(states))
    # Data that nothing reads may differ from round to round.
    if repeats and verdict["cycle"] == len(lines) and oracle.after[states[-1]] != [states[-1]] and graph.steps[states[-1]]:
        return "the run goes on"
    return "" if has is not False else "the run does not show it"


def problem_of_certificate(folder, asked, kinds):
    """What is wrong with the certificate of a property that holds; empty: nothing."""
    path, made = os.path.join(folder, "m.bip"), pathlib.Path(folder, "made.cert")
    done = subprocess.run([BIPC, "verify", "--property", asked, "--backend=interp", "--certificate", str(made), path], capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        return f"no certificate: {done.stdout}{done.stderr}"
    write_system(folder)
    text = made.read_text()
    code, said = certcheck(folder, text)
    if code != 0:
        return f"the certificate is not accepted: {said}"
    kinds.append("certificates accepted")
    code, said = certcheck(folder, re.sub("^claim branches (.*)", r"claim branches (not \1)", text, flags=re.M))
    if code != 1:
        return f"the negated claim: {said}"
    rows = text.splitlines()
    states = [k for k, row in enumerate(rows) if row.startswith("state ")]
    if len(states) > 1:
        code, said = certcheck(folder, "\n".join(rows[:states[-1]] + rows[states[-1] + 1:]) + "\n")
        if code != 1:
            return f"a certificate without a state: {said}"
    kinds.append("certificates refused")
    return ""


# ---- the comparison
def check(seed):
    """(what was found, a difference or "")"""
    r = random.Random(seed)
    # Of a state or two all runs are alike.
    for _ in range(TRIES):
        atoms, connectors, rule = make_system(r)
        graph = Graph(atoms, connectors, rule)
        if FEWEST_STATES <= len(graph.states) <= MOST_STATES:
            break
    text = text_of(atoms, connectors, rule)
    if len(graph.states) > MOST_STATES:
        return ["large"], ""
    oracle, kinds, problems = Oracle(graph), [], []
    kinds += ["systems with an end"] if [END] in graph.steps else []
    kinds += ["systems where all steps of a state fail"] if [] in graph.steps else []
    kinds += ["systems with a priority"] if rule else []
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "m.bip")
        pathlib.Path(path).write_text(text)
        for _ in range(PROPERTIES_OF_A_SYSTEM):
            formula = random_formula(r, atoms, connectors, r.choice([1, 2, 3, 3]))
            if not has_possibly(formula):
                formula = ("some", "eventually", formula) if has_bare_word(formula) else ("reach", formula)
                formula = r.choice([formula, ("all", "always", formula)])
            wanted = "holds" if 0 in oracle.holds(formula) else "violated"
            asked = print_formula(formula)
            done = subprocess.run([BIPC, "verify", "--property", asked, "--backend=interp", "--json", path], capture_output=True, text=True, timeout=120)
            try:
                verdict = json.loads(done.stdout)
            except ValueError:
                problems.append(f"`{asked}`: {done.stderr}")
                continue
            kinds.append(verdict["verdict"])
            kinds += [f"`{part[1]}` of {part[0]} runs" for part in all_parts(formula) if part[0] in ("some", "all")]
            difference = "" if verdict["verdict"] == wanted else f"{verdict['verdict']}, the oracle says {wanted}"
            if not difference and "steps" in verdict:
                difference = follow(oracle, formula, verdict)
                kinds += ["runs followed"] if verdict["steps"] else []
                kinds += ["claims of all runs"] if "branches" in verdict else []
                kinds += ["runs that repeat"] if "cycle" in verdict else []
            if not difference and wanted == "holds" and seed % CERTIFICATES_EVERY == 0 and os.path.exists(CERTCHECK):
                difference = problem_of_certificate(folder, asked, kinds)
            if difference:
                problems.append(f"`{asked}`: {difference}\n{verdict['text']}")
    return kinds, f"seed {seed}: " + "\n".join(problems) + f"\n{text}" if problems else ""


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 150
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    kinds, bad = collections.Counter(), 0
    with concurrent.futures.ProcessPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        for found, difference in pool.map(check, range(first, first + count), chunksize=8):
            kinds.update(found)
            if difference:
                bad += 1
                print(difference)
    print(", ".join(f"{kind}: {n}" for kind, n in sorted(kinds.items())))
    # What decides nothing is no test.
    needed = {"holds": 2, "violated": 2, "runs followed": 5, "runs that repeat": 20, "claims of all runs": 5, "systems with an end": 5,
              "systems where all steps of a state fail": 100, "systems with a priority": 8}
    few = [kind for kind, share in needed.items() if kinds[kind] < count // share]
    if count >= 100 and os.path.exists(CERTCHECK) and any(kinds[kind] < count // CERTIFICATES_EVERY for kind in ("certificates accepted", "certificates refused")):
        few.append("certificates")
    if count >= 100 and few:
        bad += 1
        print(f"too few: {', '.join(few)}")
    print(f"branching: {count - bad} passed, {bad} failed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
