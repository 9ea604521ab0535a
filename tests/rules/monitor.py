"""Watches a trace of a functional level for states that rules forbid. Written from what rules mean, not from how they are translated.

A rule is a tuple: ("before", A, B), ("apart", A, B), ("during", A, B), ("fresh", A, POSTER, ticks, kept), ("at most", A, ticks),
("at least", A, ticks, B), ("sum", parameter, most), ("recent", A, B, C or None, ticks or None): A has succeeded since C was accepted and no
longer ago, ("held", A, POSTER, values, most, kept): what POSTER holds, the k-th value by its k-th way to be written, ("at most of", n, services),
("not while", A, B), ("unless", A, CONDITION, kept): A requires or maintains that it is false, ("when", CONDITION, S, NAME). A CONDITION is
("silent", MODULE or None, ticks), ("missed", TASK, period in ticks), ("failed", S), ("lost", S), ("active", S), ("both", CONDITION, CONDITION). A service is "MODULE.NAME"; with several instances it runs while one does.
"""
import json
import re

INSTANCE = re.compile(r"_\d+$")  # of a service, from the second on


class Forbidden(Exception):
    pass


class Activity:
    """One instance of a service, as the ports of its controller tell it."""

    def __init__(self):
        self.accepted = self.runs = self.told = self.in_codel = False


class Edge:
    """What a `when` rule has to do: `due` if its recovery has to come before any other request to that module, `may` how often it may come.

    Each time the condition becomes true asks for one recovery. Those of several times are one if none came between. Within an instant the recovery that an
    earlier time asked for may come before the level has looked at the condition, and then another one for this time; when time goes on it has looked."""

    def __init__(self, rule):
        self.rule = rule
        self.holds = self.held_at_tick = False   # the condition, now and at the end of the last instant
        self.may, self.due, self.recovered = 0, False, False   # the last: in this instant


class Task:
    """A periodic task: ticks since a cycle of it was due, and whether one is under way."""

    def __init__(self):
        self.t, self.works, self.missed = 0, False, False


class Monitor:
    def __init__(self, rules):
        self.rules = rules
        self.activities = {}   # service -> {component -> Activity}
        self.succeeded = set()
        self.age = {}          # poster -> steps since it was written
        self.asked = {}        # service -> parameter -> value of the request that is looked at
        self.value = {}        # ... of the last one accepted
        self.held = {}         # poster -> which way it was written last
        self.won = {}          # (A, C) of a rule -> when A succeeded, since C was accepted
        self.accepted_at, self.ended_at = {}, {}
        self.now = 0
        self.heard = {}        # module -> when something was last requested of it
        self.failed, self.lost = set(), set()
        conditions = [c for rule in rules if rule[0] in ("when", "unless") for c in self.parts(rule[1] if rule[0] == "when" else rule[2])]
        self.tasks = {c[1]: Task() for c in conditions if c[0] == "missed"}
        self.periods = {c[1]: c[2] for c in conditions if c[0] == "missed"}
        self.edges = [Edge(rule) for rule in rules if rule[0] == "when"]
        self.called = {}       # kind of condition -> how often a `when` rule had its recovery
        self.counts = {"ticks": 0, "requests": 0, "accepted": 0, "rejected": 0, "stopped": 0}
        self.reports = set()

    # ---- what the rules speak of ----
    def instances(self, service):
        return self.activities.get(service, {}).values()

    def active(self, service):
        return any(a.accepted for a in self.instances(service))

    def running(self, service):
        return any(a.runs for a in self.instances(service))

    def untold(self, service):
        """Something of it runs, or may begin to, and nobody told it to stop; while a codel runs nobody can."""
        return any(a.accepted and not a.told and not a.in_codel for a in self.instances(service))

    # ---- the trace ----
    def follow(self, lines):
        for line in lines:
            step = json.loads(line)
            if step.get("end") in ("error", "deadlock"):
                raise Forbidden(f"the run ends with {step}")
            if "interaction" in step or "port" in step:
                try:
                    self.step(step)
                except Forbidden as e:
                    raise Forbidden(f"step {step.get('step')}, {step.get('interaction')}: {e}") from None

    def step(self, step):
        name = step.get("interaction", "")[len("ROOT."):]
        ports = [p["port"].removeprefix("ROOT.") for p in step.get("ports", [])]
        if any(p == "masterTimer.tick" for p in ports):
            self.tick()
        for port in ports:
            module, *path, event = port.split(".")
            if module in ("semaphore", "masterTimer") or not path:
                continue
            self.event(module, path, event, name)
        if "_reject_" in name:
            self.counts["rejected"] += 1
            self.reports.update(p["values"]["rep"] for p in step["ports"] if "rep" in p.get("values", {}))
        for edge in self.edges:
            holds = self.true(edge.rule[1])
            if holds and not edge.holds:
                edge.may += 1
            edge.holds = holds
        if "_stop_" in name and any(p.endswith((".halt", ".cancel")) for p in ports):
            self.counts["stopped"] += 1

    def event(self, module, path, event, name):
        if path[-1] == "box" and event.startswith("read_"):
            service = f"{module}.{event[len('read_'):]}"
            self.asked_for(module, name)
            self.counts["requests"] += 1
            self.asked[service] = dict(self.parameters(name, f"{module}_read_{event[len('read_'):]}"))
        elif path[-1] == "box" and event.startswith("allow_"):
            self.decided(f"{module}.{event[len('allow_'):]}")
        elif path[-1] in ("timer", "scheduler"):
            self.task(f"{module}.{path[0]}", event)
        elif event.split("_")[0] == "write" and len(path) == 1:
            self.age[f"{module}.{path[0]}"] = 0
            self.held[f"{module}.{path[0]}"] = int(event.removeprefix("write").lstrip("_") or 1) - 1
        elif event == "grow" and len(path) == 1:
            self.age[f"{module}.{path[0]}"] = self.age.get(f"{module}.{path[0]}", 0) + 1
        elif path[-1] in ("controller", "activity") or len(path) == 1:
            component = path[0]
            if path[-1] == "activity" and event in ("abt", "rest", "resume"):
                return
            service = f"{module}.{INSTANCE.sub('', component)}"
            if path[-1] == "activity":
                if event == "lost":
                    self.lost.add(service)
                self.activities.setdefault(service, {}).setdefault(component, Activity()).in_codel = event.startswith("run_")
                return
            self.controller(service, component, event, is_control=len(path) == 1)

    @staticmethod
    def parameters(name, prefix):
        words = name[len(prefix) + 1:].split("_")
        return [(words[i], words[i + 1]) for i in range(0, len(words) - 1, 2)]

    def controller(self, service, component, event, is_control):
        a = self.activities.setdefault(service, {}).setdefault(component, Activity())
        if event == "trig":
            a.accepted, a.told, a.runs = True, False, is_control
            self.counts["accepted"] += 1
            self.value[service] = self.asked.get(service, {})
            self.accepted_at[service] = self.now
            self.failed.discard(service)
            self.lost.discard(service)
            self.accepted(service)
            for key in [k for k in self.won if k[1] == service]:
                del self.won[key]
            if is_control:
                self.together()
        elif event == "start":
            a.runs = True
            self.together()
        elif event in ("halt", "abt"):
            a.told = True
        elif event in ("fin", "nofin", "intr", "fail", "cancel"):
            if event == "fin" or (event == "intr" and not a.told):
                self.succeeded.add(service)
            if event == "fin":
                self.won.update({(rule[1], rule[3]): self.now for rule in self.rules if rule[0] == "recent" and rule[1] == service})
            if event in ("nofin", "fail"):
                self.failed.add(service)
            a.accepted = a.runs = False
            self.ended_at[service] = self.now

    def task(self, name, event):
        if name not in self.tasks:
            return
        t = self.tasks[name]
        if event == "tick":
            t.t += 1
            if t.t == self.periods[name]:
                t.missed = t.works
        elif event == "trigger":
            t.t, t.works = 0, True
        elif event in ("give", "stop"):
            t.works = False

    # ---- time and liveness ----
    @classmethod
    def parts(cls, c):
        return [p for of in c[1:] for p in cls.parts(of)] if c[0] == "both" else [c]

    def true(self, c):
        if c[0] == "both":
            return self.true(c[1]) and self.true(c[2])
        if c[0] == "silent":
            last = max((at for m, at in self.heard.items() if c[1] in (None, m)), default=0)
            return self.now - last >= c[2]
        if c[0] == "missed":
            return self.tasks[c[1]].missed
        return self.active(c[1]) if c[0] == "active" else c[1] in (self.failed if c[0] == "failed" else self.lost)

    def asked_for(self, module, name):
        """A request to a module: of the decisional level, or a recovery."""
        _, is_recovery, rule = name.partition("_recover_")
        if not is_recovery:
            self.heard[module] = self.now
        for edge in self.edges:
            _, condition, service, of = edge.rule
            if is_recovery and rule == of:
                if not edge.may:
                    raise Forbidden(f"{service} is asked for by {of}, {condition} has not become true")
                edge.may, edge.due, edge.recovered = edge.may - 1, False, True
                self.called[condition[0]] = self.called.get(condition[0], 0) + 1
            elif not is_recovery and edge.due and service.split(".")[0] == module:
                raise Forbidden(f"something is requested of {module} before {service}, which {of} asks for")

    # ---- the rules ----
    def decided(self, service):
        for rule in self.rules:
            if rule[0] == "fresh" and rule[1] == service and self.age.get(rule[2], 0) > rule[3]:
                raise Forbidden(f"{service} is allowed, {rule[2]} is {self.age[rule[2]]} old")
            if rule[0] == "unless" and rule[1] == service and self.true(rule[2]):
                raise Forbidden(f"{service} is allowed, {rule[2]}")
            if rule[0] == "not while" and rule[1] == service and self.active(rule[2]):
                raise Forbidden(f"{service} is allowed, {rule[2]} is active")
            if rule[0] == "during" and rule[1] == service and not self.active(rule[2]):
                raise Forbidden(f"{service} is allowed, {rule[2]} is not active")
            if rule[0] == "held" and rule[1] == service and self.holds(rule) > rule[4]:
                raise Forbidden(f"{service} is allowed, {rule[2]} holds {self.holds(rule)}")
            if rule[0] == "recent" and rule[2] == service:
                at = self.won.get((rule[1], rule[3]))
                if at is None or (rule[4] is not None and self.now - at > rule[4]):
                    raise Forbidden(f"{service} is allowed, {rule[1]} has last succeeded {at} (since {rule[3]})")
            if rule[0] == "at least" and rule[1] == service and rule[3] in self.accepted_at:
                ended = self.now - self.ended_at.get(rule[3], self.now)
                if self.active(rule[3]) or ended < rule[2]:
                    raise Forbidden(f"{service} is allowed {ended} ticks after {rule[3]}")

    def accepted(self, service):
        for rule in self.rules:
            if rule[0] == "before" and rule[2] == service and rule[1] not in self.succeeded:
                raise Forbidden(f"{service} is accepted, {rule[1]} has never succeeded")
            if rule[0] == "at most of" and sum(self.active(s) for s in rule[2]) > rule[1]:
                raise Forbidden(f"{service} is accepted: of {', '.join(rule[2])} more than {rule[1]} are active")
            if rule[0] == "sum":
                total = sum(int(v.get(rule[1], 0)) for s, v in self.value.items() if self.active(s))
                if total > rule[2]:
                    raise Forbidden(f"the sum of {rule[1]} is {total}")

    def holds(self, rule):
        return rule[3][self.held.get(rule[2], 0)]

    def together(self):
        for rule in self.rules:
            if rule[0] == "apart" and self.running(rule[1]) and self.running(rule[2]):
                raise Forbidden(f"{rule[1]} and {rule[2]} overlap")

    def tick(self):
        for edge in self.edges:
            edge.due = edge.due or (edge.holds and not edge.held_at_tick and not edge.recovered)
            edge.may = min(edge.may, 1)
            edge.held_at_tick, edge.recovered = edge.holds, False
        for rule in self.rules:
            if rule[0] == "unless" and rule[3] and self.untold(rule[1]) and self.true(rule[2]):
                raise Forbidden(f"{rule[1]} runs on, {rule[2]}")
        self.now += 1
        self.counts["ticks"] += 1
        for rule in self.rules:
            if rule[0] == "during" and self.untold(rule[1]) and not self.active(rule[2]):
                raise Forbidden(f"{rule[1]} runs on without {rule[2]}")
            if rule[0] == "fresh" and rule[4] and self.untold(rule[1]) and self.age.get(rule[2], 0) > rule[3]:
                raise Forbidden(f"{rule[1]} runs on, {rule[2]} is {self.age[rule[2]]} old")
            if rule[0] == "held" and rule[5] and self.untold(rule[1]) and self.holds(rule) > rule[4]:
                raise Forbidden(f"{rule[1]} runs on, {rule[2]} holds {self.holds(rule)}")
            if rule[0] == "at most" and self.untold(rule[1]) and self.now - self.accepted_at[rule[1]] > rule[2]:
                raise Forbidden(f"{rule[1]} has run for {self.now - self.accepted_at[rule[1]]} ticks")
