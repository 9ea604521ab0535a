#!/usr/bin/env python3
"""Random systems and random properties of runs: `bipc verify` against an oracle that shares nothing with it.

    tests/verify/test_liveness.py [COUNT] [FROM]     COUNT systems (default 150) from seed FROM (default 1)

Each system is asked three properties, each with one kind of fairness, and whether some fair run has a word (`possibly (a until b)`). The oracle enumerates states by semantics of its own and
decides by another method: positions of a run are (state, what was true at the position before, step, promises for the next
position), truth comes from the memory and the promises (Lichtenstein, Pnueli 1985), and strong fairness by trying every set of interactions that are impossible from some point on. A
violation that bipc reports is followed step by step: the cycle must close, be fair, and violate the property. The circuit is asked
alone, too (bip-prove-runs): it must not prove what is violated, and prove some of what holds. Of every fourth system certcheck gets the
certificates: it must accept them for exactly those kinds of fairness, and the negation of the property exactly where, the oracle says so; and no certificate
without one of its states. Prints the text of
a system with another answer. BIPC names the program, JOBS the number of processes. Python's library only. To see it go red: let
`covers` in compiler/verify/liveness/automaton.cpp ignore `postponed`, or count no unit in `is_accepting` of components.cpp, or
let `is_each_step_finite` of finite_moves.cpp and `has_no_end` return true, or let `is_sure` of neighbourhood_steps.cpp return true for a guard, or
let `add_end` of round_monitor.cpp add no step, or `fair_part` in tools/certcheck/runs.cpp return nothing.
"""
import collections
import concurrent.futures
import itertools
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from strong_components import components  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BUILD") or os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
PROVER = str(BUILD / "bip-prove-runs")
CERTCHECK = os.environ.get("CERTCHECK") or str(pathlib.Path(BIPC).with_name("certcheck"))
CERTIFICATES_EVERY = int(os.environ.get("CERTIFICATES_EVERY", "4"))
FAIRNESS = "none", "weak", "strong", "weak:atoms", "strong:atoms"
MOST_STATES, MOST_NODES, MOST_STRONG = 60, 6000, 10
PROPERTIES_OF_A_SYSTEM = 3

Transition = collections.namedtuple("Transition", "port source target guard change")
Atom = collections.namedtuple("Atom", "places transitions first")
Connector = collections.namedtuple("Connector", "leaves trigger guard moves")
# `label`: connector and ports that take part; None after the end of a run.
Step = collections.namedtuple("Step", "label target")
END = Step(None, None)


class Fault(Exception):
    """A step ends in an error."""


# ---- the systems
CHANGES = {"more": "v = (v + 1) % 3;", "zero": "v = 0;", "divide": "v = 2 / v;"}


def changed(change, value):
    if change == "divide":
        if value == 0:
            raise Fault
        return 2 // value
    return {"more": (value + 1) % 3, "zero": 0, None: value}[change]


def make_system(r):
    atoms = []
    for _ in range(r.choice([1, 2, 2, 3])):
        places = r.randint(1, 3)
        transitions = [Transition(port, source, r.randrange(places), r.choice([None, None, None, 0, 1, 2]),
                                  r.choice([None, None, "more", "more", "zero", "divide"]))
                       for port in range(r.randint(1, 2)) for source in range(places) if r.random() < 0.75]
        atoms.append(Atom(places, transitions, r.randint(0, 2)))
    ports = [(a, p) for a in range(len(atoms)) for p in range(2)]
    connectors = []
    for _ in range(r.randint(1, 4)):
        first = r.choice(ports)
        others = [p for p in ports if p[0] != first[0]]
        leaves = (first,) + ((r.choice(others),) if others and r.random() < 0.6 else ())
        trigger = len(leaves) == 2 and r.random() < 0.35
        connectors.append(Connector(leaves, trigger, r.randint(0, 2) if r.random() < 0.2 and not trigger else None,
                                    len(leaves) == 2 and not trigger and r.random() < 0.3))
    rule = (0, 1) if len(connectors) > 1 and r.random() < 0.3 else None  # the first waits for the second
    return atoms, connectors, rule


def text_of(atoms, connectors, rule):
    out = ["package m", "  port type P(int v)"]
    for row, c in enumerate(connectors):
        names = "p q" if len(c.leaves) == 2 else "p"
        out.append(f"  connector type C{row}(P {', P '.join(names.split())})\n    define {names.replace('p', 'p' + chr(39)) if c.trigger else names}")
        if c.guard is not None or c.moves:
            out.append(f"    on {names}" + (f" provided (p.v != {c.guard})" if c.guard is not None else "") + (" down { q.v = p.v; }" if c.moves else ""))
        out.append("  end")
    for row, atom in enumerate(atoms):
        out.append(f"  atom type A{row}()\n    data int v = {atom.first}\n    export port P p0(v)\n    export port P p1(v)")
        out.append("    place " + ", ".join(f"s{k}" for k in range(atom.places)) + "\n    initial to s0")
        for t in atom.transitions:
            out.append(f"    on p{t.port} from s{t.source} to s{t.target}" + (f" provided (v != {t.guard})" if t.guard is not None else "")
                       + (f" do {{ {CHANGES[t.change]} }}" if t.change else ""))
        # A run that ends where each atom is final repeats its last state, as all do.
        if atoms[0].first != 1:
            out.append("    final " + ", ".join(f"s{k}" for k in range(atom.places)))
        out.append("  end")
    out.append("  compound type Root()")
    out += [f"    component A{row} a{row}()" for row in range(len(atoms))]
    out += [f"    connector C{row} c{row}(" + ", ".join(f"a{a}.p{p}" for a, p in c.leaves) + ")" for row, c in enumerate(connectors)]
    if rule:
        out.append(f"    priority r c{rule[0]}:* < c{rule[1]}:*")
    return "\n".join(out + ["  end", "end", ""])


class Graph:
    """All states; by state its candidates' labels and its steps, without those that end in an error."""

    def __init__(self, atoms, connectors, rule):
        self.atoms, self.connectors, self.rule = atoms, connectors, rule
        self.states, self.steps, self.offers = [tuple((0, atom.first) for atom in atoms)], [], []
        rows = {self.states[0]: 0}
        for state in self.states:
            found, offered = [], []
            for row, taken in self.candidates(state):
                label = (row, tuple(sorted((a, t.port) for a, t in taken)))
                offered.append(label)
                try:
                    after = self.fire(state, self.connectors[row], taken)
                except Fault:
                    continue
                if after not in rows:
                    rows[after] = len(self.states)
                    self.states.append(after)
                found.append(Step(label, rows[after]))
            self.steps.append(found if offered else [END])
            self.offers.append(offered)
            if len(self.states) > MOST_STATES:
                return

    def enabled(self, state, a, port):
        place, value = state[a]
        for t in self.atoms[a].transitions:
            if t.port == port and t.source == place and (t.guard is None or value != t.guard):
                return t
        return None

    def candidates(self, state):
        found = []
        for row, c in enumerate(self.connectors):
            taken = [(a, self.enabled(state, a, p)) for a, p in c.leaves]
            if taken[0][1] is None or (not c.trigger and any(t is None for _, t in taken)):
                continue
            if c.guard is not None and state[c.leaves[0][0]][1] == c.guard:
                continue
            found.append((row, [(a, t) for a, t in taken if t]))
        if self.rule and any(row == self.rule[1] for row, _ in found):
            found = [one for one in found if one[0] != self.rule[0]]
        return found

    @staticmethod
    def fire(state, connector, taken):
        after = list(state)
        if connector.moves:
            (p, _), (q, _) = connector.leaves
            after[q] = (after[q][0], after[p][1])
        for a, t in taken:
            after[a] = (t.target, changed(t.change, after[a][1]))
        return tuple(after)

    def atom_holds(self, what, state, step):
        kind, *args = what
        if kind == "at":
            return self.states[state][args[0]][0] == args[1]
        if kind == "data":
            return self.states[state][args[0]][1] == args[1]
        if kind == "can":
            return any(label[0] == args[0] for label in self.offers[state])
        if kind == "happens":
            return step.label is not None and step.label[0] == args[0]
        return step.label is not None and tuple(args) in step.label[1]


# ---- properties: nested tuples; a leaf is ("is", condition)
def random_condition(r, atoms, connectors):
    kind = r.choice(["at", "at", "at", "data", "can", "happens", "happens", "port"])
    a = r.randrange(len(atoms))
    if kind == "at":
        return "at", a, r.randrange(atoms[a].places)
    if kind == "data":
        return "data", a, r.randint(0, 2)
    if kind == "port":
        return "port", a, r.randint(0, 1)
    return kind, r.randrange(len(connectors))


AHEAD = ["next", "always", "eventually", "eventually", "always", "never", "until", "until", "unless", "leads to"]
BACK = ["previously", "once", "historically", "since"]
UNARY = {"!", "next", "always", "eventually", "never", "previously", "once", "historically"}


def random_formula(r, atoms, connectors, depth, kinds=AHEAD + BACK):
    if depth == 0 or r.random() < 0.15:
        return "is", random_condition(r, atoms, connectors)
    kind = r.choice(["!", "&&", "||", "implies"] + kinds)
    def part():
        return random_formula(r, atoms, connectors, depth - 1, BACK if kind in BACK else kinds)
    return (kind, part()) if kind in UNARY else (kind, part(), part())


def looks(f, words):
    return f[0] in words or f[0] not in ("is", "true") and any(looks(part, words) for part in f[1:])


def is_invariant_of_past(f):
    return f[0] in ("always", "never") and looks(f[1], BACK) and not looks(f[1], AHEAD)


def is_temporal(f):
    return f[1][0] in ("happens", "port") if f[0] == "is" else f[0] not in ("!", "&&", "||", "implies") or any(map(is_temporal, f[1:]))


def print_formula(f):
    if f[0] == "is":
        kind, *args = f[1]
        return {"at": "a{}@s{}", "data": "a{}.v == {}", "can": "can c{}", "happens": "happens c{}", "port": "happens a{}.p{}"}[kind].format(*args)
    parts = [f"({print_formula(part)})" for part in f[1:]]
    return f"{f[0]} {parts[0]}" if len(parts) == 1 else f"{parts[0]} {f[0]} {parts[1]}"


TRUE = ("true",)


def core_of(f):
    """The same by `!`, `&&`, `next`, `until`, `previously` and `since` alone."""
    if f[0] == "is":
        return f
    parts = [core_of(part) for part in f[1:]]
    a, b = parts[0], parts[-1]
    def no(x):
        return "!", x
    def either(x, y):
        return no(("&&", no(x), no(y)))
    def eventually(x):
        return "until", TRUE, x
    def always(x):
        return no(eventually(no(x)))
    return {"!": lambda: no(a), "&&": lambda: ("&&", a, b), "||": lambda: either(a, b), "implies": lambda: either(no(a), b), "next": lambda: ("next", a),
            "always": lambda: always(a), "never": lambda: always(no(a)), "eventually": lambda: eventually(a), "until": lambda: ("until", a, b),
            "previously": lambda: ("previously", a), "since": lambda: ("since", a, b), "once": lambda: ("since", TRUE, a),
            "historically": lambda: no(("since", TRUE, no(a))),
            "unless": lambda: either(("until", a, b), always(a)), "leads to": lambda: always(either(no(a), eventually(b)))}[f[0]]()


# ---- the oracle
def parts_of(f, found):
    for part in f[1:] if f[0] not in ("is", "true") else ():
        parts_of(part, found)
    if f not in found:
        found.append(f)
    return found


def terms_of(fairness):
    """(is it strong?, what it is about) of each term: interactions are about "", components about "atoms"."""
    return [] if fairness == "none" else [(term.startswith("strong"), term.partition(":")[2]) for term in fairness.split(",")]


def kind_of(fairness):
    """Of what the counts at the end are."""
    return "named" if any(what not in ("", "atoms") for _, what in terms_of(fairness)) else fairness.split(":")[0]


def units_of(label, fairness):
    """What takes its turn with a step: (is it strong?, what the term is about, which of these)."""
    units = set()
    for is_strong, what in terms_of(fairness) if label else ():
        if what == "":
            units.add((is_strong, what, label))
        elif what == "atoms":
            units |= {(is_strong, what, a) for a, _ in label[1]}
        elif what == f"c{label[0]}" or any(what in (f"a{a}", f"a{a}.p{p}") for a, p in label[1]):
            units.add((is_strong, what, None))
    return units


def possible_units(graph, state, fairness):
    return {unit for step in graph.steps[state] for unit in units_of(step.label, fairness)}


def random_fairness(r, atoms, connectors):
    """Of some things with names, beside which there may be a term about each interaction or component."""
    names = [f"c{k}" for k in range(len(connectors))] + [f"a{a}" for a in range(len(atoms))] + [f"a{a}.p{p}" for a in range(len(atoms)) for p in range(2)]
    terms = [f"{r.choice(['weak', 'strong'])}:{name}" for name in r.sample(names, min(len(names), r.choice([1, 1, 2, 2, 3])))]
    if r.random() < 0.3:
        terms.insert(r.randrange(len(terms) + 1), r.choice(["weak", "weak", "strong", "weak:atoms", "strong:atoms"]))
    return ",".join(terms)


def certificate_words(fairness):
    """The same as certificates have it."""
    def word(is_strong, what):
        kind = "" if what in ("", "atoms") else "connector:ROOT." if what.startswith("c") else "port:ROOT." if "." in what else "atom:ROOT."
        return ("strong" if is_strong else "weak") + (":" if what else "") + kind + what
    return " ".join(word(*term) for term in terms_of(fairness)) or "none"


def is_violated(graph, formula, fairness):
    """Is there a fair run on which the formula is false? None: too large."""
    parts = parts_of(core_of(formula), [])
    promised = [f for f in parts if f[0] in ("next", "until")]
    backward = [f for f in parts if f[0] in ("previously", "since")]
    remembered = [f[1] if f[0] == "previously" else f for f in backward]

    def values(state, memory, step, later):
        value = {}
        for f in parts:
            if f[0] == "true":
                value[f] = True
            elif f[0] == "is":
                value[f] = graph.atom_holds(f[1], state, step)
            elif f[0] == "!":
                value[f] = not value[f[1]]
            elif f[0] == "&&":
                value[f] = value[f[1]] and value[f[2]]
            elif f[0] == "next":
                value[f] = later.get(f, False)
            elif f[0] == "until":
                value[f] = value[f[2]] or (value[f[1]] and later.get(f, False))
            else:
                before = memory[backward.index(f)]
                value[f] = before if f[0] == "previously" else value[f[2]] or (value[f[1]] and before)
        return value

    # What looks back does not read promises: the memories that runs bring along first.
    def goes_to(state, memory, step):
        value = values(state, memory, step, {})
        return state if step.label is None else step.target, tuple(value[f] for f in remembered)
    first = 0, (False,) * len(backward)
    places, rows = [first], {first}
    for state, memory in places:
        for step in graph.steps[state]:
            to = goes_to(state, memory, step)
            if to not in rows:
                rows.add(to)
                places.append(to)
    if is_invariant_of_past(formula):
        # A point shows it: a state with the step that follows. Where all steps end in errors nothing happens.
        inner = core_of(formula[1])
        return any(values(state, memory, step, {})[inner] == (formula[0] == "never")
                   for state, memory in places for step in graph.steps[state] or [END])
    if sum(len(graph.steps[state]) for state, _ in places) << len(promised) > MOST_NODES:
        return None
    truth = {}
    for place in places:
        for number, step in enumerate(graph.steps[place[0]]):
            for bits in itertools.product((False, True), repeat=len(promised)):
                truth[place[0], number, bits, place[1]] = values(*place, step, dict(zip(promised, bits)))
    at_place = collections.defaultdict(list)
    for node in truth:
        at_place[node[0], node[3]].append(node)
    following = {}
    for node, value in truth.items():
        state, number, bits, memory = node
        step = graph.steps[state][number]
        following[node] = [other for other in at_place[goes_to(state, memory, step)]
                           if all(bits[k] == truth[other][f[1] if f[0] == "next" else f] for k, f in enumerate(promised))]
    root = parts[-1]
    reached = {node for node in at_place[first] if not truth[node][root]}
    todo = list(reached)
    while todo:
        for to in following[todo.pop()]:
            if to not in reached:
                reached.add(to)
                todo.append(to)
    possible = [possible_units(graph, state, fairness) for state in range(len(graph.steps))]
    taken = {node: units_of(graph.steps[node[0]][node[1]].label, fairness) for node in reached}
    everything = sorted({unit for units in possible for unit in units}, key=str)
    weak, strong = ([unit for unit in everything if unit[0] == is_strong] for is_strong in (False, True))
    if len(strong) > MOST_STRONG:
        return None
    # Strong: which units are impossible from some point on? The others happen again and again.
    choices = itertools.chain.from_iterable(itertools.combinations(strong, n) for n in range(len(strong) + 1))
    for impossible in map(set, choices):
        nodes = [node for node in reached if not impossible & set(possible[node[0]])]
        inside = set(nodes)
        arrows = {node: [to for to in following[node] if to in inside] for node in nodes}
        for own in components(nodes, arrows):
            if len(own) == 1 and own[0] not in arrows[own[0]]:
                continue
            if not all(any(truth[node][f[2]] or not truth[node][f] for node in own) for f in promised if f[0] == "until"):
                continue
            done = {unit for node in own for unit in taken[node]}
            if not all(unit in done or any(unit not in possible[node[0]] for node in own) for unit in weak):
                continue
            # A step of a component's node may leave it; each node has one step, and some successor of it is inside.
            if not all(unit in done for unit in strong if unit not in impossible):
                continue
            return True
    return False


def value_on_lasso(graph, formula, states, steps, cycle):
    """Truth at position 0, by positions that are followed for as long as anything can change."""
    size = len(states)
    # The memory of what looks back settles within a round for each operator.
    extra = sum(f[0] in ("previously", "since") for f in parts_of(core_of(formula), [])) * (size - cycle)
    states, steps = ([row[at] if at < size else row[cycle + (at - cycle) % (size - cycle)] for at in range(size + extra)] for row in (states, steps))
    cycle, size = cycle + extra, size + extra
    def after(at):
        return at + 1 if at + 1 < size else cycle
    known = {}
    def holds(f):
        if f not in known:
            if f[0] == "true":
                known[f] = [True] * size
            elif f[0] == "is":
                known[f] = [graph.atom_holds(f[1], states[at], steps[at]) for at in range(size)]
            elif f[0] == "!":
                known[f] = [not v for v in holds(f[1])]
            elif f[0] == "&&":
                known[f] = [v and w for v, w in zip(holds(f[1]), holds(f[2]))]
            elif f[0] == "next":
                known[f] = [holds(f[1])[after(at)] for at in range(size)]
            elif f[0] == "previously":
                known[f] = [at > 0 and holds(f[1])[at - 1] for at in range(size)]
            elif f[0] == "since":
                left, right = holds(f[1]), holds(f[2])
                known[f] = [any(right[start] and all(left[start + 1:at + 1]) for start in range(at + 1)) for at in range(size)]
            else:
                left, right, row = holds(f[1]), holds(f[2]), []
                for start in range(size):
                    at, result = start, False
                    for _ in range(2 * size):
                        if right[at]:
                            result = True
                            break
                        if not left[at]:
                            break
                        at = after(at)
                    row.append(result)
                known[f] = row
        return known[f]
    return holds(core_of(formula))[0]


STEP_LINE = re.compile(r"^#(\d+)  ROOT\.c(\d+)  (.*)$", re.M)


def follow(graph, formula, fairness, verdict):
    """What is wrong with the run that a verdict reports; empty: nothing."""
    lines = STEP_LINE.findall(verdict["text"])
    if len(lines) != verdict["steps"] or [int(n) for n, _, _ in lines] != list(range(len(lines))):
        return "its steps are not all printed"
    is_prefix = "cycle" not in verdict
    labels = [(int(connector), tuple(sorted((int(a), int(p)) for a, p in re.findall(r"\ba(\d+)\.p(\d+)", ports)))) for _, connector, ports in lines]
    whole = len(labels) if is_prefix else verdict["cycle"]
    stem, repeated = labels[:whole], labels[whole:]
    state, states, steps, rounds = 0, [], [], {}
    # Data that nothing reads may differ from round to round: round by round until a state comes again.
    for part in itertools.chain([stem], itertools.repeat(repeated)):
        for label in part:
            found = [step for step in graph.steps[state] if step.label == label]
            if not found:
                return f"no step {label} in state {graph.states[state]}"
            states.append(state)
            steps.append(found[0])
            state = found[0].target
        if state in rounds or not repeated:
            break
        rounds[state] = len(states)
    cycle = rounds.get(state, len(states))
    if is_prefix:
        # The last step violates it, or the state after it, whatever the step that follows.
        def is_violated_at_end(states, steps):
            wrong = formula[1] if formula[0] == "never" else ("!", formula[1])
            for _ in states[1:]:
                wrong = "next", wrong
            return bool(states) and value_on_lasso(graph, wrong, states, steps, len(states) - 1)
        by_state = all(is_violated_at_end(states + [state], steps + [step]) for step in graph.steps[state] or [END])
        # After the end its last state repeats.
        repeats = range(2, 2 + len(parts_of(core_of(formula), []))) if graph.steps[state] == [END] else []
        by_repeats = any(is_violated_at_end(states + [state] * n, steps + [END] * n) for n in repeats)
        return "" if by_state or by_repeats or is_violated_at_end(states, steps) else "the run does not violate the property"
    if not repeated:
        if graph.steps[state] != [END]:
            return "the run goes on"
        states.append(state)
        steps.append(END)
    if value_on_lasso(graph, formula, states, steps, cycle):
        return "the run satisfies the property"
    done = {unit for step in steps[cycle:] for unit in units_of(step.label, fairness)}
    possible = [possible_units(graph, at, fairness) for at in states[cycle:]]
    due = {unit for unit in set.union(*possible) if unit[0]} | set.intersection(*possible)
    return "the run is not fair" if due - done else difference_of_turns(graph, states, steps, cycle, fairness, verdict)


def difference_of_turns(graph, states, steps, cycle, fairness, verdict):
    """What is wrong with the reasons why the run is fair to things with names; empty: nothing."""
    named = [(is_strong, what) for is_strong, what in terms_of(fairness) if what not in ("", "atoms")]
    said = verdict.get("fair_to", [])
    if steps[cycle:] == [END]:
        return "an end is fair by nothing else" if said else ""
    if [(row["fairness"] == "strong", row["of"]) for row in said] != named:
        return f"it is not said why the run is fair to {named}"
    for row, (is_strong, what) in zip(said, named):
        unit, at = (is_strong, what, None), row.get("step")
        # Of the round that is printed, which may not be the first one in which all data repeat.
        is_printed = at is not None and verdict["cycle"] <= at < verdict["steps"]
        happens = is_printed and unit in units_of(steps[at].label, fairness)
        possible = [unit in possible_units(graph, state, fairness) for state in states[cycle:]]
        if not {"happens": happens, "impossible": is_printed and not is_strong and unit not in possible_units(graph, states[at], fairness),
                "never possible": not any(possible)}[row["why"]]:
            return f"the run is not fair to {what} because of {row}"
    return ""


# ---- certificates
def write_system(folder):
    system = pathlib.Path(folder, "m.bsys")
    if not system.exists():
        system.write_text(subprocess.run([BIPC, "check", "--emit=system", os.path.join(folder, "m.bip")], capture_output=True, text=True, timeout=120, check=True).stdout)


def certcheck(folder, text):
    path = pathlib.Path(folder, "m.cert")
    path.write_text(text)
    done = subprocess.run([CERTCHECK, os.path.join(folder, "m.bsys"), str(path)], capture_output=True, text=True, timeout=120)
    return done.returncode, done.stdout.strip()


def problem_of_certificate(folder, graph, formula, asked, fairness, r, kinds):
    """What is wrong with the certificate of a property that holds; empty: nothing."""
    path, made = os.path.join(folder, "m.bip"), pathlib.Path(folder, "made.cert")
    done = subprocess.run([BIPC, "verify", "--property", asked, "--fair", fairness, "--backend=interp", "--certificate", str(made), path],
                          capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        return f"no certificate: {done.stdout}{done.stderr}"
    write_system(folder)
    text = made.read_text()
    code, said = certcheck(folder, text)
    if code == 4 and "too many operators" in said:
        kinds.append("certificates not checkable")
        return ""
    if code != 0:
        return f"the certificate is not accepted: {said}"
    kinds.append("certificates accepted")
    rows = text.splitlines()
    states = [k for k, row in enumerate(rows) if row.startswith("state ")]
    if len(states) > 1:
        # The last one, whose row no other one builds on.
        code, said = certcheck(folder, "\n".join(rows[:states[-1]] + rows[states[-1] + 1:]) + "\n")
        if code != 1:
            return f"a certificate without a state: {said}"
    if is_invariant_of_past(formula):
        return ""
    negated = re.sub("^claim runs (.*)", r"claim runs (not \1)", text, flags=re.M)
    for claimed, claim in ((formula, text), (("!", formula), negated)):
        for other in r.sample(FAIRNESS, 3) + [random_fairness(r, graph.atoms, graph.connectors)]:
            expected = is_violated(graph, claimed, other)
            if expected is None:
                continue
            code, said = certcheck(folder, re.sub("^fairness .*", f"fairness {certificate_words(other)}", claim, flags=re.M))
            kinds.append(f"changed claims {'refused' if expected else 'accepted'}")
            if code not in (0, 1) or (code == 0) == expected:
                return f"{print_formula(claimed)} under {other}: certcheck says `{said}`, the oracle {'violated' if expected else 'holds'}"
    return ""


def problems_of_engine(option, name, path, asked_of_circuit, kinds):
    """What is proved by ports that move finitely often, or by neighbourhoods, must be what the oracle says."""
    done = subprocess.run([PROVER, option, path], input="".join(f"{fairness} {asked}\n" for fairness, asked, *_ in asked_of_circuit),
                          capture_output=True, text=True, timeout=240)
    answers = done.stdout.splitlines()
    if len(answers) != len(asked_of_circuit):
        return [f"bip-prove-runs {option}: {len(answers)} answers\n{done.stderr}"]
    problems = []
    for (fairness, asked, expected, is_invariant, _), answer in zip(asked_of_circuit, answers):
        is_proved = answer.startswith("holds")
        if is_proved and expected:
            problems.append(f"`{asked}` --fair={fairness}: by {name} `{answer}`, the oracle says violated")
        if not expected and not is_invariant:
            kinds.append(f"{name}, {kind_of(fairness)}: {'proved' if is_proved else 'open'}")
    return problems


def problems_of_proofs(folder, graph, asked_of_circuit, kinds):
    """Certificates of proofs on the circuit are accepted, and changed ones only where the oracle agrees."""
    path, proofs, problems = os.path.join(folder, "m.bip"), os.path.join(folder, "proof"), []
    write_system(folder)
    done = subprocess.run([PROVER, path, "5", "16", proofs], input="".join(f"{fairness} {asked}\n" for fairness, asked, *_ in asked_of_circuit),
                          capture_output=True, text=True, timeout=120)
    answers = done.stdout.splitlines()
    if len(answers) != len(asked_of_circuit):
        return [f"bip-prove-runs for certificates: {len(answers)} answers\n{done.stderr}"]
    for row, ((fairness, asked, expected, is_invariant, formula), answer) in enumerate(zip(asked_of_circuit, answers)):
        if not answer.startswith("holds"):
            kinds += [] if expected or is_invariant else ["circuit, certificate: open"]
            continue
        if expected:
            problems.append(f"`{asked}` --fair={fairness}: the circuit says `{answer}` with a certificate, the oracle says violated")
            continue
        text = pathlib.Path(f"{proofs}.{row}").read_text()
        code, said = certcheck(folder, text)
        kinds.append("circuit, certificate: accepted")
        if code != 0:
            problems.append(f"`{asked}` --fair={fairness}: certcheck says `{said}` of\n{text}")
        # Whatever else it claims then must be true.
        negated = re.sub("^claim runs (.*)", r"claim runs (not \\1)", text, flags=re.M)
        fewer = re.sub("^rounds .*", "rounds 0", text, flags=re.M)
        for claimed, other, changed in ((("!", formula), fairness, negated), *((formula, f, re.sub("^fairness .*", f"fairness {certificate_words(f)}", fewer, flags=re.M))
                                                                               for f in (*FAIRNESS, random_fairness(random.Random(text), graph.atoms, graph.connectors)))):
            code, said = certcheck(folder, changed)
            kinds.append(f"circuit, changed certificate: {'refused' if code else 'accepted'}")
            if code == 0 and is_violated(graph, claimed, other):
                problems.append(f"certcheck accepts what the oracle finds violated:\n{changed}")
    return problems


# ---- one fair run: `possibly` before one word
def problem_of_possible(path, atoms, connectors, graph, fairness, r, kinds):
    """What is wrong with the answer about a fair run that has one word of conditions; empty: nothing."""
    def condition():
        kind, *args = random_condition(r, atoms, connectors)
        while kind in ("happens", "port"):
            kind, *args = random_condition(r, atoms, connectors)
        return "is", (kind, *args)
    word = r.choice(["always", "never", "next", "until", "unless"])
    formula = (word, condition()) if word in UNARY else (word, condition(), condition())
    expected = is_violated(graph, ("!", formula), fairness)
    if expected is None:
        return ""
    asked = f"possibly ({print_formula(formula)})"
    done = subprocess.run([BIPC, "verify", "--property", asked, "--fair", fairness, "--backend=interp", "--json", path], capture_output=True, text=True, timeout=120)
    try:
        verdict = json.loads(done.stdout)
    except ValueError:
        return f"`{asked}` --fair={fairness}: {done.stderr}"
    kinds.append(f"one run {verdict['verdict']}")
    difference = "" if verdict["verdict"] == ("holds" if expected else "violated") else f"{verdict['verdict']}, the oracle says {'holds' if expected else 'violated'}"
    if not difference and expected:
        difference = follow(graph, ("!", formula), fairness, verdict)
    return f"`{asked}` --fair={fairness}: {difference}\n{verdict['text']}" if difference else ""


# ---- the comparison
def check(seed):
    """(what was found, a difference or "")"""
    r = random.Random(seed)
    atoms, connectors, rule = make_system(r)
    text = text_of(atoms, connectors, rule)
    graph = Graph(atoms, connectors, rule)
    kinds, problems, asked_of_circuit = [], [], []
    if len(graph.states) > MOST_STATES:
        return ["large"], ""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "m.bip")
        pathlib.Path(path).write_text(text)
        for number in range(PROPERTIES_OF_A_SYSTEM):
            formula = random_formula(r, atoms, connectors, r.choice([1, 2, 2, 3]))
            if looks(formula, BACK) and not looks(formula, AHEAD):
                formula = r.choice(["always", "never"]), formula  # else it asks for the past of the beginning
            if not is_temporal(formula):
                formula = (r.choice(["eventually", "always"]), ("next", formula))
            if formula[0] in ("always", "never") and not is_temporal(formula[1]):
                formula = ("next", formula)  # else it is a property of states
            fairness = r.choice(["none", "none", "weak", "strong", "weak:atoms", "strong:atoms"])
            other = random.Random(f"fairness {seed} {number}")
            is_said_inside = other.random() < 0.3
            if other.random() < 0.4:
                fairness = random_fairness(other, atoms, connectors)
            expected = is_violated(graph, formula, fairness)
            if expected is None:
                kinds.append("large")
                continue
            asked = print_formula(formula)
            # What the property says itself takes the place of the option.
            inside = ["--property", f"{asked} under {fairness}", "--fair", other.choice(FAIRNESS)]
            said = inside if is_said_inside and not is_invariant_of_past(formula) else ["--property", asked, "--fair", fairness]
            done = subprocess.run([BIPC, "verify", *said, "--backend=interp", "--json", path],
                                  capture_output=True, text=True, timeout=120)
            try:
                verdict = json.loads(done.stdout)
            except ValueError:
                kinds.append("refused")
                problems.append(f"`{asked}` --fair={fairness}: {done.stderr}")
                continue
            kinds.append(f"{'invariant of past' if is_invariant_of_past(formula) else kind_of(fairness)} {verdict['verdict']}")
            kinds += ["looks back"] if looks(formula, BACK) else []
            wanted = "violated" if expected else "holds"
            difference = ""
            if not expected and verdict["verdict"] == wanted and seed % CERTIFICATES_EVERY == 0 and os.path.exists(CERTCHECK):
                difference = problem_of_certificate(folder, graph, formula, asked, fairness, random.Random(seed), kinds)
            if verdict["verdict"] != wanted:
                difference = f"{verdict['verdict']}, the oracle says {wanted}"
            elif expected:
                difference = follow(graph, formula, fairness, verdict)
                helpful = verdict.get("holds_under")
                if not difference and helpful and is_violated(graph, formula, helpful):
                    difference = f"it does not hold under {helpful}"
            if difference:
                problems.append(f"`{asked}` --fair={fairness}: {difference}\n{verdict['text']}")
            asked_of_circuit.append((fairness, asked, expected, is_invariant_of_past(formula), formula))
        rest = random.Random(f"one run {seed}")
        if problem := problem_of_possible(path, atoms, connectors, graph, rest.choice([*FAIRNESS[1:], *[random_fairness(rest, atoms, connectors)] * 2]), rest, kinds):
            problems.append(problem)
        problems += problems_of_engine("--finite", "finite moves", path, asked_of_circuit, kinds)
        problems += problems_of_engine("--neighbourhoods", "neighbourhoods", path, asked_of_circuit, kinds)
        done = subprocess.run([PROVER, path], input="".join(f"{fairness} {asked}\n" for fairness, asked, *_ in asked_of_circuit),
                              capture_output=True, text=True, timeout=120)
        if seed % CERTIFICATES_EVERY == 0 and os.path.exists(CERTCHECK):
            problems += problems_of_proofs(folder, graph, asked_of_circuit, kinds)
        answers = done.stdout.splitlines()
        if len(answers) != len(asked_of_circuit):
            problems.append(f"bip-prove-runs: {len(answers)} answers\n{done.stderr}")
        for (fairness, asked, expected, is_invariant, _), answer in zip(asked_of_circuit, answers):
            is_proved = answer.startswith("holds")
            if is_proved and expected:
                problems.append(f"`{asked}` --fair={fairness}: the circuit says `{answer}`, the oracle says violated")
            if not expected:
                kinds.append(f"circuit, {'invariant of past' if is_invariant else kind_of(fairness)}: {'proved' if is_proved else 'open'}")
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
    needed = [f"{kind} {verdict}" for kind in ("none", "weak", "strong", "named", "invariant of past") for verdict in ("holds", "violated")]
    proved = [f"circuit, {kind}: proved" for kind in ("none", "weak", "strong", "named", "invariant of past")]
    changed_claims = [f"changed claims {what}" for what in ("accepted", "refused")]
    if count >= 100 and os.path.exists(CERTCHECK) and any(kinds[kind] < count // CERTIFICATES_EVERY // 3 for kind in ["certificates accepted", "circuit, certificate: accepted", *changed_claims]):
        bad += 1
        print("too few certificates")
    if count >= 100 and any(kinds[f"one run {verdict}"] < count // 10 for verdict in ("holds", "violated")):
        bad += 1
        print("too few questions about one run")
    if count >= 100 and any(kinds[kind] < count // 30 for kind in proved):
        bad += 1
        print("the circuit proved too few")
    if count >= 100 and kinds["finite moves, none: proved"] == 0:
        bad += 1
        print("nothing was proved by finite moves")
    if count >= 100 and any(kinds[f"neighbourhoods, {kind}: proved"] < count // 30 for kind in ("none", "weak", "strong")):
        bad += 1
        print("neighbourhoods proved too few")
    if count >= 100 and (kinds["large"] > count or any(kinds[kind] < count // 20 for kind in needed)):
        bad += 1
        print("too few questions of some kind")
    print(f"liveness: {count - bad} passed, {bad} failed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
