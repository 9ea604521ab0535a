#!/usr/bin/env python3
"""Random timed systems: `bipc explore` and `bipc verify` against an oracle that lets time pass tick by tick.

    tests/verify/test_timed.py [COUNT] [FROM]     COUNT systems (default 60) from seed FROM (default 1)

The systems have clocks in ns with small constants, bounds that are open or closed, limits from data, invariants, all urgencies,
`resume`, triggers, guards, transfers, and divisions by zero in guards, limits and actions. The oracle is written from
compiler/docs/semantics.md and shares nothing with bipc: it visits every state at every ns, clocks cut off above all constants, and
says whether a deadlock, a time lock and an error are reachable, and whether a random `never E`, `E leads to F within T`,
`eventually F within T`, or one of these without T, or `always E` where E looks back, is violated, and `possibly E` and `possibly always E` hold. Prints the text of a system with another answer. BIPC names the
program, JOBS the number of processes. Each tenth system is asked by the program, the others by the Python package of the build folder
if there is one. To see it go red: let `may_pass` ignore one of its rules.
"""
import collections
import concurrent.futures
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from strong_components import components  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BUILD") or os.environ.get("BIPC_BUILD_DIR") or ROOT / "build").resolve()
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
try:
    sys.path.insert(0, str(BUILD / "python"))
    import bipc
except ImportError:
    bipc = None  # every system is asked by the program, and not only each tenth
MOST_STATES = 6000
MOST = 6  # no constant is larger

# A bound is (operator, limit), the limit a number or "v"; a guard over data is (kind, number).
Transition = collections.namedtuple("Transition", "port source target guard bounds urgency resets change resume")
Atom = collections.namedtuple("Atom", "places transitions invariant first")  # invariant: (place, operator, limit)
Connector = collections.namedtuple("Connector", "leaves trigger guard moves")  # leaves: rows of atoms and ports
# Of one atom; `waits`: row of the transition whose `resume` it waits for, or None. `fresh`: it went on at this instant.
State = collections.namedtuple("State", "place value clock waits")

# What follows a state: steps with the states after them (None: a fault), those in which an atom goes on, the next ns (or None).
# `is_last`: an atom that waits cannot go on later.
Expanded = collections.namedtuple("Expanded", "steps resumed later is_last")
NEVER = 1 << 62  # ns
WORDS_OF_STATES = "never", "possibly", "possibly always"


class Fault(Exception):
    """A run ends in an error."""


def divide(a, b):
    if b == 0:
        raise Fault
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


# ---- the systems
def guard_text(guard, name):
    kind, k = guard
    return {"<": f"{name} < {k}", "!=": f"{name} != {k}", "/": f"6 / ({name} - {k}) > 0"}[kind]


def guard_holds(guard, value):
    kind, k = guard
    if kind == "/":
        return divide(6, value - k) > 0
    return value < k if kind == "<" else value != k


CHANGES = {"more": "v = (v + 1) % 3;", "zero": "v = 0;", "divide": "v = (4 / (v - 1)) % 4;"}


def changed(change, value):
    if change == "more":
        return (value + 1) % 3
    if change == "zero":
        return 0
    quotient = divide(4, value - 1)
    return quotient - divide(quotient, 4) * 4


def make_bounds(r, most):
    return tuple((r.choice(["<", "<=", ">", ">", ">=", ">=", "=="]), "v" if r.random() < 0.08 else r.randint(0, MOST))
                 for _ in range(r.randint(0, most)))


def make_atom(r):
    places = r.randint(1, 3)
    transitions = []
    for port in range(r.randint(1, 2)):
        for source in r.sample(range(places), r.randint(1, places)):
            guard = (r.choice(["<", "!=", "!=", "/"]), r.randint(0, 2)) if r.random() < 0.3 else None
            resume = None
            if r.random() < 0.15:
                resume = tuple((r.choice([">", ">=", "<", "<="]), r.randint(0, MOST)) for _ in range(r.randint(1, 2)))
            transitions.append(Transition(port, source, r.randrange(places), guard, make_bounds(r, 2),
                                          r.choice(["lazy", "lazy", "delayable", "eager", "eager"]), r.random() < 0.6,
                                          r.choice([None, None, "more", "zero", "divide"]), resume))
    invariant = None
    if r.random() < 0.4:
        invariant = (r.randrange(places), r.choice(["<", "<=", "<="]), r.randint(1, MOST))
    return Atom(places, transitions, invariant, r.randint(0, 2))


def make_system(r):
    atoms = [make_atom(r) for _ in range(r.choice([1, 2, 2, 2, 3]))]
    ports = [(a, p) for a, atom in enumerate(atoms) for p in sorted({t.port for t in atom.transitions})]
    connectors = []
    for _ in range(r.randint(1, 3)):
        first = r.choice(ports)
        others = [p for p in ports if p[0] != first[0]]
        leaves = [first] + ([r.choice(others)] if others and r.random() < 0.6 else [])
        trigger = len(leaves) == 2 and r.random() < 0.3
        guard = (r.choice(["!=", "/"]), r.randint(0, 2)) if r.random() < 0.25 and not trigger else None
        moves = len(leaves) == 2 and not trigger and r.random() < 0.3
        connectors.append(Connector(tuple(leaves), trigger, guard, moves))
    return atoms, connectors


def bounds_text(bounds):
    return " && ".join(f"x {op} {limit}" for op, limit in bounds)


def text_of(atoms, connectors):
    out = ["package m", "  port type P(int v)"]
    for row, c in enumerate(connectors):
        both = len(c.leaves) == 2
        out.append(f"  connector type C{row}(P p{', P q' if both else ''})\n    define p{chr(39) if c.trigger else ''}{' q' if both else ''}")
        if c.guard or c.moves:
            provided = f" provided ({guard_text(c.guard, 'p.v')})" if c.guard else ""
            out.append(f"    on p{' q' if both else ''}{provided}{' down { q.v = p.v; }' if c.moves else ''}")
        out.append("  end")
    for row, atom in enumerate(atoms):
        ports = sorted({t.port for t in atom.transitions})
        out.append(f"  atom type A{row}()\n    clock x unit nanosecond\n    data int v = {atom.first}")
        out += [f"    export port P p{port}(v)" for port in ports]
        out.append("    place " + ", ".join(f"s{k}" for k in range(atom.places)) + "\n    initial to s0 do { x = 0; }")
        for t in atom.transitions:
            condition = " && ".join(([f"({guard_text(t.guard, 'v')})"] if t.guard else []) + ([bounds_text(t.bounds)] if t.bounds else []))
            action = (CHANGES[t.change] if t.change else "") + (" x = 0;" if t.resets else "")
            out.append(f"    on p{t.port} from s{t.source} to s{t.target}{f' provided ({condition})' if condition else ''} {t.urgency}"
                       f"{f' do {{ {action} }}' if action else ''}{f' resume ({bounds_text(t.resume)})' if t.resume else ''}")
        if atom.invariant:
            place, op, limit = atom.invariant
            out.append(f"    invariant i at s{place} provided (x {op} {limit})")
        out.append("  end")
    out.append("  compound type Root()")
    out += [f"    component A{row} a{row}()" for row in range(len(atoms))]
    out += [f"    connector C{row} c{row}(" + ", ".join(f"a{a}.p{p}" for a, p in c.leaves) + ")" for row, c in enumerate(connectors)]
    return "\n".join(out + ["  end", "end", ""])


# ---- the oracle
def compare(clock, op, limit):
    return {"<": clock < limit, "<=": clock <= limit, ">": clock > limit, ">=": clock >= limit, "==": clock == limit}[op]


def holds(bounds, clock, value=0):
    return all(compare(clock, op, value if limit == "v" else limit) for op, limit in bounds)


class Oracle:
    def __init__(self, atoms, connectors):
        self.atoms, self.connectors = atoms, connectors
        self.deadlock = self.lock = self.error = self.has_no_state = False
        self.stable = []  # states whose candidates are known
        self.expanded = {}

    def may_resume(self, state):
        """The atoms that may go on now. An action returns at any instant at which its `resume` holds."""
        return [a for a, s in enumerate(state)
                if s.waits is not None and holds(self.atoms[a].transitions[s.waits].resume, s.clock)]

    def is_last(self, state, a):
        """No later instant lets the atom go on."""
        return not holds(self.atoms[a].transitions[state[a].waits].resume, min(state[a].clock + 1, MOST + 1))

    def enabled(self, state):
        """By atom and port the transition that is possible now. The guard of a marked transition is evaluated at any instant."""
        found = {}
        for a, s in enumerate(state):
            for t in self.atoms[a].transitions if s.waits is None else ():
                if t.source != s.place or (t.guard and not guard_holds(t.guard, s.value)):
                    continue
                if holds(t.bounds, s.clock, s.value):
                    found[a, t.port] = t
        return found

    def candidates(self, state):
        """Each is a list of (atom, transition), and its connector."""
        enabled = self.enabled(state)
        found = []
        for c in self.connectors:
            possible = [leaf for leaf in c.leaves if leaf in enabled]
            if c.leaves[0] not in possible or (not c.trigger and len(possible) < len(c.leaves)):
                continue
            if c.guard and not guard_holds(c.guard, state[c.leaves[0][0]].value):
                continue
            found.append(([(a, enabled[a, p]) for a, p in possible], c))
        return found

    def fire(self, state, candidate):
        taken, c = candidate
        after = list(state)
        if c.moves:
            after[taken[1][0]] = after[taken[1][0]]._replace(value=after[taken[0][0]].value)
        for a, t in taken:
            s = after[a]
            value = changed(t.change, s.value) if t.change else s.value
            after[a] = State(t.target, value, 0 if t.resets else s.clock,
                             self.atoms[a].transitions.index(t) if t.resume is not None else None)
        return tuple(after)

    def invariants_hold(self, state):
        return all(atom.invariant is None or atom.invariant[0] != s.place or compare(s.clock, *atom.invariant[1:])
                   for atom, s in zip(self.atoms, state))

    def may_pass(self, state, candidates):
        """To the next ns, from a state with these candidates."""
        later = tuple(s._replace(clock=min(s.clock + 1, MOST + 1)) for s in state)
        if not self.invariants_hold(state) or not self.invariants_hold(later):
            return None
        if any(self.is_last(state, a) for a in self.may_resume(state)):
            return None
        for taken, _ in candidates:
            urgencies = {t.urgency for _, t in taken}
            if "eager" in urgencies:
                return None
            if "delayable" in urgencies and not all(holds(t.bounds, later[a].clock, state[a].value) for a, t in taken):
                return None
        try:
            opened = self.candidates(later)
        except Fault:
            return later
        for taken, _ in opened:
            if any(t.urgency == "eager" for _, t in taken) and any(
                    op in "<>" and not holds([(op, limit)], state[a].clock, state[a].value) for a, t in taken for op, limit in t.bounds):
                return None
        return later

    def is_true(self, condition, state, step):
        """At a point of a run: a state while time passes (no step), or a step that leaves it."""
        kind, *args = condition
        if kind == "!":
            return not self.is_true(args[0], state, step)
        if kind == "&&":
            return all(self.is_true(part, state, step) for part in args)
        if kind == "at":
            return state[args[0]].place == args[1]
        if kind == "data":
            return state[args[0]].value == args[1]
        if step is None:
            return False
        taken, connector = step
        return connector is self.connectors[args[0]] if kind == "happens" else any((a, t.port) == tuple(args) for a, t in taken)

    def look(self, demand, state, step, age, is_first=False):
        """The age of the oldest request without a response; None: no request waits."""
        request, response, _ = demand
        if self.is_true(response, state, step):
            return None
        if age is None and (is_first if request is None else self.is_true(request, state, step)):
            return 0
        return age

    def expand(self, state):
        """What follows a state, computed once; None: a run ends there in an error."""
        if state not in self.expanded:
            try:
                candidates = self.candidates(state)
            except Fault:
                self.expanded[state] = None
                return None
            resuming = self.may_resume(state)
            steps = []  # candidate, and the state after it; None: its action faults
            for candidate in candidates:
                try:
                    steps.append((candidate, self.fire(state, candidate)))
                except Fault:
                    steps.append((candidate, None))
            self.expanded[state] = Expanded(steps, [state[:a] + (state[a]._replace(waits=None),) + state[a + 1:] for a in resuming],
                                            self.may_pass(state, candidates), any(self.is_last(state, a) for a in resuming))
        return self.expanded[state]

    def worst_age(self, request, response, most=MOST):
        """The largest age that a request (None: the beginning) reaches without a response; NEVER if it may have none at all, or one
        older than `most`. None: too many states."""
        demand = request, response, most
        first = tuple(State(0, atom.first, 0, None) for atom in self.atoms)
        start = first, self.look(demand, first, None, None, True)
        known, todo, worst = {start}, [start], 0
        while todo:
            state, age = todo.pop()
            found = self.expand(state)
            if found is None:
                continue
            if age is not None:
                worst = max(worst, age)
                # Nothing follows, or too late.
                if age > most or (found.later is None and not found.steps and not found.is_last):
                    return NEVER
            following = [(after, age) for after in found.resumed]
            if found.later is not None:
                following.append((found.later, None if age is None else age + 1))
            for candidate, after in found.steps:
                if after is not None:
                    following.append((after, self.look(demand, after, None, self.look(demand, state, candidate, age))))
            for new in following:
                if new not in known:
                    known.add(new)
                    todo.append(new)
            if len(known) > 3 * MOST_STATES:
                return None
        self.points = known
        return worst

    def misses(self, demand):
        """Does a run miss the demand (request or None for the beginning, response, ns)? None: too many states."""
        worst = self.worst_age(*demand)
        return None if worst is None else worst > demand[2]

    def never_comes(self, request, response):
        """Is there a run with a request (None: the beginning) whose response never comes? It ends at a time lock, or time passes in it for
        ever: a strong component of points at which the request waits, with a ns in it. An action that may return does so some time.
        None: too many states."""
        demand = request, response, None
        first = tuple(State(0, atom.first, 0, None) for atom in self.atoms)
        start = first, self.look(demand, first, None, None, True)
        known, todo, waits, ticks = {start}, [start], {}, set()
        while todo:
            point = todo.pop()
            state, age = point
            found = self.expand(state)
            if found is None:
                continue
            if age is not None and found.later is None and not found.steps and not found.is_last:
                return True
            following, same = [], []  # same: the request that waits still does
            if found.later is not None:
                following.append((found.later, age))
                same.append(age is not None)
                if age is not None:
                    ticks.add((point, following[0]))
            for after in found.resumed:
                following.append((after, age))
                same.append(age is not None)
            for candidate, after in found.steps:
                if after is not None:
                    kept = self.look(demand, state, candidate, age)
                    following.append((after, self.look(demand, after, None, kept)))
                    same.append(age is not None and kept is not None and following[-1][1] is not None)
            waits[point] = [new for new, is_same in zip(following, same) if is_same]
            for new in following:
                if new not in known:
                    known.add(new)
                    todo.append(new)
            if len(known) > 3 * MOST_STATES:
                return None
        parts = components(list(waits), waits)
        component = {node: k for k, own in enumerate(parts) for node in own}
        lasting = {component[a] for a, b in ticks if component[a] == component.get(b)}
        return any(not set.intersection(*(set(self.may_resume(state)) for state, _ in parts[k])) for k in lasting)

    def at_point(self, past, state, candidate, before):
        """(value of a formula that looks back, what its words leave behind: a tuple as long as it has words). `before`: the same of the point before."""
        kind, *parts = past
        if kind not in ("once", "historically", "since", "!", "&&") or not has_past(past):
            return self.is_true(past, state, candidate), ()
        values, left = [], ()
        for part in parts:
            own = words_of_past(part)
            value, after = self.at_point(part, state, candidate, before[:own])
            values.append(value)
            left, before = left + after, before[own:]
        if kind in ("!", "&&"):
            return (not values[0] if kind == "!" else all(values)), left
        value = {"once": lambda: values[0] or before[0], "historically": lambda: values[0] and before[0],
                 "since": lambda: values[-1] or (values[0] and before[0])}[kind]()
        return value, (*left, value)

    def breaks(self, past):
        """Is there a point of a run at which the formula is false? None: too many states."""
        first = tuple(State(0, atom.first, 0, None) for atom in self.atoms)
        value, left = self.at_point(past, first, None, nothing_before(past))
        known = {(first, left, not value)}
        todo = list(known)
        while todo:
            state, left, is_broken = todo.pop()
            found = self.expand(state)
            if found is None:
                continue
            if is_broken:
                return True
            following = [(after, None) for after in found.resumed]
            if found.later is not None:
                following.append((found.later, None))
            following += [(after, candidate) for candidate, after in found.steps if after is not None]
            for after, candidate in following:
                values, memory = [], left
                if candidate is not None:
                    value, memory = self.at_point(past, state, candidate, memory)
                    values.append(value)
                value, memory = self.at_point(past, after, None, memory)
                new = after, memory, not all([*values, value])
                if new not in known:
                    known.add(new)
                    todo.append(new)
            if len(known) > 3 * MOST_STATES:
                return None
        return False

    def run(self):
        """False: too many states."""
        first = tuple(State(0, atom.first, 0, None) for atom in self.atoms)
        known, todo = {first}, [first]
        while todo:
            state = todo.pop()
            found = self.expand(state)
            if found is None:
                self.error = True
                self.has_no_state |= state == first
                continue
            self.stable.append(state)
            following = list(found.resumed)
            if found.later is not None:
                following.append(found.later)
            if not found.steps:
                # Nobody makes an action return before the last instant.
                self.lock |= found.later is None and not found.is_last
                self.deadlock |= found.later == state and not found.resumed
            for _, after in found.steps:
                if after is None:
                    self.error = True
                else:
                    following.append(after)
            for new in following:
                if new not in known:
                    known.add(new)
                    todo.append(new)
            if len(known) > MOST_STATES:
                return False
        return True


def make_state_condition(r, atoms, depth=1):
    a = r.randrange(len(atoms))
    kind = r.choice(["at", "at", "data", "&&", "!"] if depth else ["at", "data"])
    if kind in ("at", "data"):
        return kind, a, r.randrange(atoms[a].places) if kind == "at" else r.randint(0, 2)
    return (kind, *(make_state_condition(r, atoms, 0) for _ in range(1 if kind == "!" else 2)))


def make_condition(r, atoms, connectors, depth=1):
    kind = r.choice(["at", "at", "data", "happens", "happens", "port", "!", "&&"] if depth else ["at", "at", "data", "happens", "port"])
    a = r.randrange(len(atoms))
    if kind == "at":
        return "at", a, r.randrange(atoms[a].places)
    if kind == "data":
        return "data", a, r.randint(0, 2)
    if kind == "happens":
        return "happens", r.randrange(len(connectors))
    if kind == "port":
        return "port", a, r.choice(sorted({t.port for t in atoms[a].transitions}))
    parts = [make_condition(r, atoms, connectors, 0) for _ in range(1 if kind == "!" else 2)]
    return (kind, *parts)


def has_past(formula):
    return formula[0] in ("once", "historically", "since") or (formula[0] in ("!", "&&") and any(has_past(part) for part in formula[1:]))


def words_of_past(formula):
    if formula[0] in ("!", "&&") or has_past(formula):
        return (formula[0] not in ("!", "&&")) + sum(words_of_past(part) for part in formula[1:])
    return 0


def nothing_before(formula):
    """What the words that look back leave behind before the first point, in the order of at_point: of `historically` it is true."""
    if formula[0] not in ("!", "&&") and not has_past(formula):
        return ()
    left = tuple(value for part in formula[1:] for value in nothing_before(part))
    return left if formula[0] in ("!", "&&") else (*left, formula[0] == "historically")


def make_past(r, atoms, connectors, depth=2):
    """Mostly of the form \"not this, unless that has been\"."""
    kind = r.choice(["once", "historically", "since", "since", "!", "&&", "unless before"])
    inner = lambda: make_past(r, atoms, connectors, depth - 1) if depth and r.random() < 0.4 else make_condition(r, atoms, connectors)  # noqa: E731
    if kind == "unless before":
        return "!", ("&&", inner(), ("!", ("once", inner())))
    if kind in ("!", "&&") and depth == 2:
        return kind, *(make_past(r, atoms, connectors, depth - 1) for _ in range(1 if kind == "!" else 2))
    return (kind, *(inner() for _ in range(2 if kind in ("since", "&&") else 1)))


def past_text(formula):
    if not has_past(formula):
        return condition_text(formula)
    parts = [f"({past_text(part)})" for part in formula[1:]]
    return f" {formula[0]} ".join(parts) if len(parts) == 2 else f"{formula[0]} {parts[0]}"


def condition_text(condition):
    kind, *args = condition
    if kind == "!":
        return f"!({condition_text(args[0])})"
    if kind == "&&":
        return f"({condition_text(args[0])}) && ({condition_text(args[1])})"
    return {"at": "a{}@s{}", "data": "a{}.v == {}", "happens": "happens c{}", "port": "happens a{}.p{}"}[kind].format(*args)


def sharp(r, oracle, request, response):
    """The demand with the least limit that holds, or the next smaller one; any limit if all hold or none. With the oracle's answer:
    is it missed? None: too many states."""
    worst = oracle.worst_age(request, response)
    within = r.randint(0, MOST) if worst in (None, 0, NEVER) else worst - r.randint(0, 1)
    demand = request, response, within
    return demand, oracle.misses(demand) if worst is None else worst > within


def demand_text(demand):
    request, response, within = demand
    text = f"({condition_text(response)})" + ("" if within is None else f" within {within} ns")
    return f"eventually {text}" if request is None else f"({condition_text(request)}) leads to {text}"


# ---- the comparison
def ask(path, *words):
    done = subprocess.run([BIPC, *words, "--backend=interp", "--json", path], capture_output=True, text=True, timeout=600)
    try:
        return json.loads(done.stdout), done.stderr
    except ValueError:
        return None, done.stderr


def ask_program(text, properties):
    """What `bipc explore` says, then verdicts about deadlocks, errors and each property, asked as those that a model states; or (None, why)."""
    with tempfile.TemporaryDirectory() as folder:
        path, stated = os.path.join(folder, "m.bip"), os.path.join(folder, "m.prop")
        pathlib.Path(path).write_text(text)
        explored, problem = ask(path, "explore")
        if explored is None:
            return None, problem
        errors, _ = ask(path, "verify", "--property", "errors")
        pathlib.Path(stated).write_text("".join(f"property p{k} {{ {asked} }}\n" for k, asked in enumerate(properties)))
        found, problem = ask(path, "verify", "--properties", stated)
    rows = {row["name"]: row for row in found["verdicts"]} if found else {}
    return explored, [rows.get("deadlock"), errors, *(rows.get(f"p{k}") for k in range(len(properties)))]


def ask_package(text, properties):
    """The same by the Python package, in this process: a sixth of the time."""
    try:
        model = bipc.load(text, backend="interp", cache=False)
    except bipc.CompileError as error:
        return None, error.text
    found = model.explore()
    explored = {name: getattr(found, name) for name in ("end", "deadlocks", "time_locks", "errors")}
    return explored, [json.loads(model.verify(asked).json) for asked in ("", "errors", *properties)]


def check(seed):
    """(kinds of what was found, a difference or "")"""
    atoms, connectors = make_system(random.Random(seed))
    oracle = Oracle(atoms, connectors)
    if not oracle.run():
        return ["large"], ""
    text = text_of(atoms, connectors)
    r = random.Random(f"demands {seed}")
    demands = [sharp(r, oracle, None if r.random() < 0.2 else make_condition(r, atoms, connectors), make_condition(r, atoms, connectors))
               for _ in range(3)]
    nevers = [make_state_condition(r, atoms) for _ in range(3)]
    # Without a limit, of the same conditions.
    demands += [((request, response, None), oracle.never_comes(request, response)) for (request, response, _), _ in demands]
    properties = [demand_text(demand) for demand, _ in demands]
    properties += [f"{words} ({condition_text(never)})" for words in WORDS_OF_STATES for never in nevers]
    pasts = [past for past in (make_past(r, atoms, connectors) for _ in range(4)) if has_past(past)]
    properties += [f"always ({past_text(past)})" for past in pasts]
    explored, given = (ask_program if bipc is None or seed % 10 == 0 else ask_package)(text, properties)
    if explored is None:
        return ["refused"], f"seed {seed}: explore: {given}\n{text}"
    verdict, errors, *answers = given
    answers, about_states, about_past = answers[:len(demands)], answers[len(demands):len(answers) - len(pasts)], answers[len(answers) - len(pasts):]
    expected = (oracle.deadlock, oracle.lock, oracle.error)
    found = (explored["deadlocks"] > 0, explored["time_locks"] > 0, explored["errors"] > 0)
    words = "deadlock %s, time lock %s, error %s"
    difference = ""
    if explored["end"] != "complete" or found != expected:
        difference = f"explore: {words % found} ({explored['end']})"
    if oracle.has_no_state:
        allowed = {"no-state"}
    else:
        allowed = {kind for kind, is_reached in (("deadlock", oracle.deadlock), ("time lock", oracle.lock)) if is_reached} or {"deadlock-free"}
    if verdict is None or verdict["verdict"] not in allowed:
        difference += f"\nverify: {verdict and verdict['verdict']}"
    if errors is None or errors["verdict"] != ("error" if oracle.error else "error-free"):
        difference += f"\nverify --property errors: {errors and errors['verdict']}"
    kinds = []
    for k, answer in enumerate(about_states):
        words, never = WORDS_OF_STATES[k // len(nevers)], nevers[k % len(nevers)]
        if words == "possibly always":
            is_true = oracle.never_comes(None, ("!", never))
        else:
            is_true = any(oracle.is_true(never, state, None) for state in oracle.stable) == (words == "possibly")
        wanted = "no-state" if oracle.has_no_state else {None: "large", True: "holds", False: "violated"}[is_true]
        kinds.append(f"{words}: {wanted}")
        if wanted != "large" and (answer is None or answer["verdict"] != wanted):
            difference += f"\n`{words} {condition_text(never)}`: {answer and answer['text']}, the oracle says {wanted}"
    for past, answer in zip(pasts, about_past):
        wanted = "no-state" if oracle.has_no_state else {None: "large", True: "violated", False: "holds"}[oracle.breaks(past)]
        kinds.append(f"looks back: {wanted}")
        if wanted != "large" and (answer is None or answer["verdict"] != wanted):
            difference += f"\n`always ({past_text(past)})`: {answer and answer['text']}, the oracle says {wanted}"
    for (demand, is_missed), answer in zip(demands, answers):
        wanted = "no-state" if oracle.has_no_state else {None: "large", True: "violated", False: "holds"}[is_missed]
        kinds.append(f"{'without a limit' if demand[2] is None else 'within'}: {wanted}")
        if wanted == "large":
            continue
        if answer is None or answer["verdict"] != wanted:
            difference += f"\n`{demand_text(demand)}`: {answer and answer['text']}, the oracle says {wanted}"
        elif wanted == "violated" and demand[2] is not None and not answer["ends"] and answer["time"] - answer["requested"] <= demand[2]:
            difference += f"\n`{demand_text(demand)}`: not missed yet: {answer['text']}"
        elif answer.get("cycle") is not None:
            kinds.append("a cycle of steps")
    kind = "+".join(k for k, v in zip(("deadlock", "time lock", "error"), expected) if v) or "free"
    kinds.append(kind)
    return kinds, f"seed {seed}: oracle: {words % expected}; {difference}\n{text}" if difference else ""


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    kinds, bad = collections.Counter(), 0
    with concurrent.futures.ProcessPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        for kind, difference in pool.map(check, range(first, first + count), chunksize=8):
            kinds.update(kind)
            if difference:
                bad += 1
                print(difference)
    print(", ".join(f"{kind}: {n}" for kind, n in sorted(kinds.items())))
    compared = count - kinds["large"] - kinds["refused"]
    # What decides nothing is no test.
    if count >= 60 and (compared < count // 2 or any(kinds[k] == 0 for k in ("free", "deadlock", "time lock", "a cycle of steps"))
                        or any(kinds[f"{limit}: {k}"] < count // 10 for limit in ("within", "without a limit", "looks back", *WORDS_OF_STATES) for k in ("holds", "violated"))):
        bad += 1
        print("too few systems of some kind")
    print(f"timed: {compared - bad if compared > bad else 0} passed, {bad} failed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
