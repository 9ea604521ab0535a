#!/usr/bin/env python3
"""Certificates of random timed systems: certcheck accepts what `bipc verify` writes, and nothing else that does not hold.

    tests/verify/test_timed_certificates.py [COUNT] [FROM]     COUNT systems (default 40) from seed FROM (default 1)

The systems and the oracle, which visits every state at every ns, are those of test_timed.py. Three tests of each system:
what bipc proves (no deadlock, no errors, a place that is never reached) is accepted; a certificate that has been changed (a row lost, a
bound, a place, a value, what an action waits for) is not, if a state that the oracle has reached is not in it any more; the certificate of a property that is
always true is not accepted for another claim that the oracle refutes. The same of limits of time, with the least limit that
holds: the oracle's points have the age of the oldest request, too, and a smaller limit or another demand is what it refutes. Of demands
without a limit certificates are also written by this test, from the oracle's points, each a zone of its own: they are accepted if and
only if the response comes in each run. BIPC and CERTCHECK name the programs, JOBS the number of processes. Python's library
only. To see it go red: let `stays` in tools/certcheck/zones.cpp return at once, or leave out its tick, or its ranks.
"""
import collections
import concurrent.futures
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from strong_components import components  # noqa: E402
from test_timed import BIPC, MOST, Fault, Oracle, State, demand_text, make_condition, make_system, sharp, text_of  # noqa: E402

CERTCHECK = os.environ.get("CERTCHECK") or str(pathlib.Path(BIPC).with_name("certcheck"))
MUTATIONS, DEMANDS = 12, 3
MOST_POINTS = 300  # of a certificate that the test writes
ALWAYS = "never a0.v == 77"
# What bipc may say instead of a certificate: only where the oracle has found an error.
REFUSED = "guards of connectors or priorities that end in an error"


def certcheck(folder, certificate):
    path = pathlib.Path(folder) / "asked.cert"
    path.write_text(certificate)
    done = subprocess.run([CERTCHECK, f"{folder}/m.bsys", str(path)], capture_output=True, text=True, timeout=300)
    return done.returncode, (done.stdout + done.stderr).strip()


def prove(folder, question):
    """The certificate, None if there is none, and what bipc said."""
    path = pathlib.Path(folder) / "made.cert"
    path.unlink(missing_ok=True)
    done = subprocess.run([BIPC, "verify", "--backend=interp", "--property", question, "--certificate", str(path), f"{folder}/m.bip"],
                          capture_output=True, text=True, timeout=300)
    return path.read_text() if path.exists() else None, done.returncode, done.stdout + done.stderr


# ---- what a certificate says, read once more
BOUND = re.compile(r"([^-<>=]+)(?:-([^<>=]+))?([<>])=(-?\d+)")


def read_rows(certificate):
    """By state (a tuple of what it says of each atom) its zones; a zone is a list of (clock, clock or None, operator, number)."""
    said, rows, zones = {}, collections.defaultdict(list), None
    for line in certificate.splitlines():
        head, *words = line.split()
        if head == "state":
            for word in words:
                key, _, value = word.partition("@") if "@" in word else word.partition("=")
                said[key] = value
            zones = rows[tuple(sorted(said.items()))]
        elif head == "zone":
            zones.append([BOUND.fullmatch(word).groups() for word in words if not word.startswith("rank=")])
    return rows


ANY = object()  # an age that is not looked at


def is_in(state, atoms, rows, is_told, age=None):
    said = {"observer.waits": str(0 if age is None else 1)}
    for a, s in enumerate(state):
        said[f"ROOT.a{a}"] = f"s{s.place}"
        said[f"ROOT.a{a}.v"] = str(s.value)
        said[f"ROOT.a{a}.resume"] = str(0 if s.waits is None else s.waits + 1)
        said[f"ROOT.a{a}.resume-with"] = str(0 if s.waits is None else a)
    key = tuple(sorted((k, v) for k, v in said.items() if k in is_told))

    def value(clock):
        if clock == "observer.since":
            return age
        return 0 if clock is None else state[int(re.fullmatch(r"ROOT\.a(\d+)\.x", clock)[1])].clock

    def holds(x, y, op, n):
        if (age is None or age is ANY) and "observer.since" in (x, y):
            return True  # nothing waits
        return value(x) - value(y) <= int(n) if op == "<" else value(x) - value(y) >= int(n)
    return any(all(holds(*bound) for bound in zone) for zone in rows.get(key, ()))


def misses_a_state(points, atoms, certificate):
    """Is a state that the oracle has reached, with the age of a request, not in it? Clocks above all constants are not looked at, nor states in which a guard faults."""
    try:
        rows = read_rows(certificate)
    except (AttributeError, TypeError):
        return True
    is_told = {k for key in rows for k, _ in key}
    for state, age in points:
        if any(s.clock > MOST for s in state):
            continue
        if not is_in(state, atoms, rows, is_told, age):
            return True
    return False


def mutate(r, certificate):
    lines = certificate.splitlines()
    rows = [k for k, line in enumerate(lines) if line.startswith(("state", "zone"))]
    k = r.choice(rows)
    words = lines[k].split()
    kind = r.choice(["row", "word", "number", "number", "number"])
    if kind == "row" or len(words) < 2:
        del lines[k]
    else:
        w = r.randrange(1, len(words))
        if kind == "word":
            del words[w]
        else:
            words[w] = re.sub(r"(-?\d+)$", lambda n: str(int(n[1]) + r.choice([-1, 1])), words[w])
        lines[k] = " ".join(words)
    return "\n".join(lines) + "\n"


def claim_text(condition):
    kind, *args = condition
    if kind in ("!", "&&"):
        return f"({'not' if kind == '!' else 'and'} {' '.join(claim_text(part) for part in args)})"
    return {"at": "(at ROOT.a{} s{})", "data": "(eq (data ROOT.a{} v) {})", "happens": "(happens ROOT.c{})",
            "port": "(happens-port ROOT.a{} p{})"}[kind].format(*args)


def is_stable(oracle, state):
    try:
        oracle.candidates(state)
    except Fault:
        return False
    return True


def check_accepted(folder, r, question, certificate, points, oracle, kind, counts, bad):
    """Is it accepted, and has it all points that the oracle reaches? Changed so that one is missing it is not accepted."""
    code, said = certcheck(folder, certificate)
    if code != 0:
        bad.append(f"{question}: not accepted: {said}\n{certificate}")
        return False
    counts[kind + "accepted"] += 1
    if misses_a_state(points, oracle.atoms, certificate):
        bad.append(f"{question}: a point that is reached is not in the certificate\n{certificate}")
    for _ in range(MUTATIONS):
        changed = mutate(r, certificate)
        is_less = misses_a_state(points, oracle.atoms, changed)
        counts[kind + ("changed, not enough" if is_less else "changed, enough")] += 1
        code, said = certcheck(folder, changed) if is_less else (1, "")
        if code not in (1, 4):
            bad.append(f"{question}: accepted without a reached point: {said}\n{changed}")
    return True


def check_demands(folder, seed, oracle, counts, bad):
    """Of limits of time that hold."""
    r = random.Random(f"demands {seed}")

    def random_demand():
        request = None if r.random() < 0.2 else make_condition(r, oracle.atoms, oracle.connectors)
        return sharp(r, oracle, request, make_condition(r, oracle.atoms, oracle.connectors))[0]
    for _ in range(DEMANDS):
        demand, other = random_demand(), random_demand()
        if oracle.misses(demand) is not False:
            continue
        points = [(state, age) for state, age in oracle.points if is_stable(oracle, state)]
        certificate, code, said = prove(folder, demand_text(demand))
        if certificate is None:
            counts["limits refused by bipc"] += 1
            if not oracle.has_no_state and ("error[B1900]" not in said or REFUSED not in said or not oracle.error):
                bad.append(f"{demand_text(demand)}: {code}: {said}")
            continue
        if not check_accepted(folder, r, demand_text(demand), certificate, points, oracle, "limits ", counts, bad):
            continue
        for request, response, within in ((*demand[:2], demand[2] - 1), other):
            if within < 0 or oracle.misses((request, response, within)) is not True:
                continue
            counts["limits forged"] += 1
            claim = f"claim within {within}ns {'first' if request is None else claim_text(request)} {claim_text(response)}"
            code, said = certcheck(folder, re.sub("^claim .*", claim, certificate, flags=re.M))
            if code not in (1, 4):
                bad.append(f"{claim} is accepted: {said}\n{certificate}")


def follow(oracle, request, response, later):
    """The points (state, age of the request that waits, at most `later`) that runs reach, each with what follows while the same request
    waits: (point, is time over, the atom whose action returns or None). None: too many."""
    demand = request, response, None
    first = tuple(State(0, atom.first, 0, None) for atom in oracle.atoms)
    todo, same = [(first, oracle.look(demand, first, None, None, True))], {}
    while todo:
        point = todo.pop()
        if point in same:
            continue
        state, age = point
        found = oracle.expand(state)
        if found is None:
            continue
        if len(same) == MOST_POINTS:
            return None
        edges = [((after, age), False, next(a for a, s in enumerate(state) if after[a] != s)) for after in found.resumed]
        if found.later is not None:
            edges.append(((found.later, None if age is None else min(age + 1, later)), False, None))
        new = []
        for candidate, after in found.steps:
            if after is None:
                continue
            kept = oracle.look(demand, state, candidate, age)
            age_after = oracle.look(demand, after, None, kept)
            if age is None or kept is None or age_after is None:
                new.append((after, age_after))
            else:
                edges.append(((after, 0 if age == later else age), age == later, None))
        todo += [to for to, _, _ in edges] + new
        same[point] = edges if age is not None else []
    return same


def own_certificate(r, oracle, request, response, later):
    """A certificate that `response` comes, of a demand without a limit, as good as there is one. None: too many points."""
    same = follow(oracle, request, response, later)
    if same is None:
        return None
    following = {point: [to for to, _, _ in edges if to in same] for point, edges in same.items()}
    parts = components(list(same), following)
    part_of = {point: k for k, part in enumerate(parts) for point in part}
    returning = {}  # by part: the atom whose action never returns, though it may
    for point, edges in same.items():
        k = part_of[point]
        if any(is_over and part_of.get(to) == k for to, is_over, _ in edges):
            always = set.intersection(*(set(oracle.may_resume(state)) for state, _ in parts[k]))
            # Without one the response never comes, whatever atom the certificate names.
            returning[k] = min(always, default=r.choice([None, *range(len(oracle.atoms))]))
    levels = {}

    def level(k):
        if k not in levels:
            levels[k] = 0  # itself
            ahead = [(part_of[to], is_over) for point in parts[k] for to, is_over, _ in same[point] if to in same and part_of[to] != k]
            levels[k] = max((level(to) + (1 if is_over or k in returning or to in returning else 0) for to, is_over in ahead), default=0)
        return levels[k]
    keys = {k: (level(k), k + 1 if k in returning else 0) for k in range(len(parts))}
    ranks = {key: number for number, key in enumerate(sorted(set(keys.values())))}
    rows = collections.defaultdict(list)
    for (state, age), k in part_of.items():
        zone = f"zone rank={ranks[keys[k]]}" if age is not None else "zone"
        for a, s in enumerate(state):
            zone += f" ROOT.a{a}.x>={s.clock}" + (f" ROOT.a{a}.x<={s.clock}" if s.clock <= MOST else "")
        zone += " observer.since>=0" if age is None else f" observer.since>={age}" + (f" observer.since<={age}" if age < later else "")
        words = [f"ROOT.a{a}@s{s.place} ROOT.a{a}.v={s.value} ROOT.a{a}.resume={0 if s.waits is None else s.waits + 1} "
                 f"ROOT.a{a}.resume-with={0 if s.waits is None else a}" for a, s in enumerate(state)]
        rows[f"state {' '.join(words)} observer.waits={0 if age is None else 1}"].append(zone)
    head = ["bipc-certificate 1", "root Root()", eventually_text(request, response), "method zones", f"later {later}ns"]
    head += [f"returns {ranks[keys[k]]} ROOT.a{a}" for k, a in returning.items() if a is not None]
    return "\n".join([*head, *(line for state, zones in rows.items() for line in (state, *zones)), "end", ""])


def eventually_text(request, response):
    return f"claim eventually {'first' if request is None else claim_text(request)} {claim_text(response)}"


def check_endless_demands(folder, seed, oracle, counts, bad):
    """Of responses without a limit."""
    r = random.Random(f"endless demands {seed}")

    def random_demand():
        request = None if r.random() < 0.2 else make_condition(r, oracle.atoms, oracle.connectors)
        return request, make_condition(r, oracle.atoms, oracle.connectors), None

    def check_own(demand, is_missed, own):
        code, said = certcheck(folder, own)
        kind = "own refused" if is_missed else "own accepted"
        if (code == 0) != (not is_missed) and not (code in (1, 4) and oracle.error):
            bad.append(f"{demand_text(demand)}: own certificate: {said}\n{own}")
        counts[kind] += 1
        counts[kind + " with a return"] += "\nreturns " in own
    # Few demands have to do with actions that return: some of these.
    with_return = 0
    for _ in range(20 if any(t.resume is not None for atom in oracle.atoms for t in atom.transitions) else 0):
        demand = random_demand()
        own = own_certificate(r, oracle, *demand[:2], r.randint(1, 3))
        if own is not None and "\nreturns " in own and with_return < 2:
            with_return += 1
            check_own(demand, oracle.never_comes(*demand[:2]), own)
    for _ in range(DEMANDS):
        demand, other = random_demand(), random_demand()
        is_missed = oracle.never_comes(*demand[:2])
        if is_missed is None or oracle.has_no_state:
            continue
        own = own_certificate(r, oracle, *demand[:2], r.randint(1, 3))
        if own is not None:
            check_own(demand, is_missed, own)
        if is_missed:
            continue
        certificate, code, said = prove(folder, demand_text(demand))
        if certificate is None:
            counts["endless refused by bipc"] += 1
            if "error[B1900]" not in said or REFUSED not in said or not oracle.error:
                bad.append(f"{demand_text(demand)}: {code}: {said}")
            continue
        points = [(state, None if age is None else ANY) for state, age in follow(oracle, *demand[:2], 1) or ()
                  if is_stable(oracle, state)]
        if not check_accepted(folder, r, demand_text(demand), certificate, points, oracle, "endless ", counts, bad):
            continue
        if oracle.never_comes(*other[:2]) is True:
            counts["endless forged"] += 1
            claim = eventually_text(*other[:2])
            code, said = certcheck(folder, re.sub("^claim .*", claim, certificate, flags=re.M))
            if code not in (1, 4):
                bad.append(f"{claim} is accepted: {said}\n{certificate}")


def check(seed):
    """(counts, a difference or "")"""
    atoms, connectors = make_system(random.Random(seed))
    oracle, counts, bad = Oracle(atoms, connectors), collections.Counter(), []
    if not oracle.run():
        return collections.Counter(large=1), ""
    r = random.Random(f"certificates {seed}")
    points = [(state, None) for state in oracle.stable]
    a = r.randrange(len(atoms))
    place = r.randrange(atoms[a].places)
    is_reached = any(state[a].place == place for state in oracle.stable)
    text = text_of(atoms, connectors)
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "m.bip").write_text(text)
        made = subprocess.run([BIPC, "check", "--emit=system", f"{folder}/m.bip"], capture_output=True, text=True, timeout=60)
        (pathlib.Path(folder) / "m.bsys").write_text(made.stdout)
        certificate = None
        for question in ("deadlock", "errors", f"never a{a}@s{place}", ALWAYS):
            certificate, code, said = prove(folder, question)
            if certificate is None:
                is_refused = "error[B1900]" in said
                counts["refused by bipc" if is_refused else "does not hold"] += 1
                if (is_refused and (REFUSED not in said or not oracle.error)) or (not is_refused and code not in (1, 3)):
                    bad.append(f"{question}: {code}: {said}")
                continue
            counts["proofs"] += 1
            check_accepted(folder, r, question, certificate, points, oracle, "", counts, bad)
        check_demands(folder, seed, oracle, counts, bad)
        check_endless_demands(folder, seed, oracle, counts, bad)
        # The last one holds always.
        wrong = ([("deadlock-free")] if oracle.deadlock or oracle.lock else []) + (["error-free"] if oracle.error else [])
        wrong += [f"never (at ROOT.a{a} s{place})"] if is_reached else []
        for claim in wrong if certificate else ():
            counts["forged " + claim.split()[0]] += 1
            code, said = certcheck(folder, re.sub("^claim .*", "claim " + claim, certificate, flags=re.M))
            if code not in (1, 4):
                bad.append(f"{claim} is accepted: {said}\n{certificate}")
    return counts, f"seed {seed}: " + "\n".join(bad) + "\n" + text if bad else ""


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    if not pathlib.Path(CERTCHECK).exists():
        print("timed certificates: left out, certcheck is not built")
        return 0
    counts, bad = collections.Counter(), 0
    with concurrent.futures.ProcessPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        for found, difference in pool.map(check, range(first, first + count), chunksize=4):
            counts.update(found)
            if difference:
                bad += 1
                print(difference)
    print(", ".join(f"{kind}: {n}" for kind, n in sorted(counts.items())))
    # What decides nothing is no test.
    wanted = ("accepted", "changed, not enough", "forged deadlock-free", "forged never", "limits accepted", "limits changed, not enough", "limits forged",
              "endless accepted", "own accepted", "own refused")
    if count >= 40 and any(counts[kind] < count // 8 for kind in wanted):
        bad += 1
        print("too few certificates of some kind")
    print(f"timed certificates: {max(count - bad, 0)} passed, {bad} failed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
