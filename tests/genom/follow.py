"""Follows a trace of generated BIP, hands the world's choices in it to the reference, and compares what each cycle did."""
import json


class Difference(Exception):
    pass


class Follower:
    def __init__(self, module, reference):
        self.module, self.reference = module, reference
        self.component = module["name"]
        self.tasks = {t["name"]: t for t in module["tasks"]}
        self.activities = {s.name: s for s in reference.activities}
        self.control = None   # events of the control cycle that is open
        self.cycles = {}      # task -> (events, answers) of its cycle
        self.running = {}     # task -> (state, codel) whose codel is running
        self.request = self.answer = self.aborted = None
        self.counts = {"control": 0, "task": 0, "replies": 0}
        self.seen = set()     # (state, answer) of codels, reports

    def follow(self, lines):
        for line in lines:
            step = json.loads(line)
            if "interaction" in step or "port" in step:
                self.step(step)
            elif step.get("end") in ("error", "deadlock"):
                raise Difference(f"the run ends with {step}")

    def step(self, step):
        name = step.get("interaction", "")
        ports = [(p["port"], p.get("values", {})) for p in step.get("ports", [])]
        prefix = f"ROOT.{self.component}."
        inner = name[len(prefix):] if name.startswith(prefix) else ""
        root = name[len(f"ROOT.{self.component}_"):] if name.startswith(f"ROOT.{self.component}_") else ""
        try:
            self.one(inner, root, ports)
        except Difference as e:
            raise Difference(f"step {step.get('step')}: {e}") from None

    def one(self, inner, root, ports):
        if inner == "collect":
            actual = [("final", self.activity_of(p), v["rep"]) for p, v in ports if p.endswith(".controller.reply")]
            self.compare("final replies", self.reference.begin_control_cycle(), actual)
            self.counts["replies"] += len(actual)
            self.control, self.request, self.answer, self.aborted = [], None, "OK", None
        elif root.startswith("read_"):
            self.request = root[len("read_"):]
        elif inner == "done":
            self.end_control()
        elif root.startswith("begin_") or inner.startswith("begin_"):
            self.begin_task((root or inner)[len("begin_"):])
        elif inner.endswith(".stop") or inner.endswith(".permanent_done"):
            task, event = inner.split(".")
            if event == "stop" and self.reference.has_work(self.tasks[task]):
                raise Difference(f"{task} stops, but has work")
            if event == "permanent_done":
                self.cycles[task][1].append("OK")
        elif inner.startswith("permanent_fails_"):
            task = inner[len("permanent_fails_"):]
            self.cycles[task][1].append("ERROR")
            self.end_task(task)
        elif inner.startswith("give_"):
            self.end_task(inner[len("give_"):])
        elif self.control is not None and self.control_event(inner, root, ports):
            pass
        else:
            self.turn(ports)

    @staticmethod
    def activity_of(port):
        return port.split(".")[2]

    @staticmethod
    def compare(what, expected, actual):
        if expected != actual:
            raise Difference(f"{what}: expected {expected}, got {actual}")

    # ---- control ----
    def control_event(self, inner, root, ports):
        request = self.reference.requests.get(self.request)
        if inner.startswith("refuse_"):
            self.control.append(("refused", self.request, inner[len("refuse_"):]))
        elif inner.startswith("full_"):
            self.control.append(("refused", self.request, "TOO_MANY_ACTIVITIES"))
        elif inner.startswith("admit_"):
            if any(p.endswith(".controller.ctrl") for p, _ in ports):
                self.control.append(("codel", request["codel_control"]))
        elif inner.startswith("invalid_"):
            activity = next(self.activity_of(p) for p, _ in ports if p.endswith(".controller.invalid"))
            self.answer = inner[len(f"invalid_{activity}_"):]
            self.control.append(("refused", self.request, self.answer))
        elif root.startswith("abtInc_") or inner.startswith(("abort_", "bury_")) or inner == "unknown_activity":
            for port, _ in ports:
                if port.endswith((".controller.abt", ".controller.cancel")):
                    self.aborted = self.activity_of(port)
                    self.control.append(("interrupted", self.aborted))
                if port.endswith(".controller.bury"):
                    self.aborted = self.activity_of(port)
                    self.control.append(("buried", self.aborted))
            if inner == "unknown_activity":
                self.control.append(("unknown",))
        elif inner.startswith("final_"):
            if any(p.endswith(".nofin") for p, _ in ports):
                self.answer = inner[len(f"final_{self.request}_"):]
            if "codel_control" in request:
                self.control.append(("codel", request["codel_control"]))
            self.control.append(("control reply", self.request, self.answer))
        elif inner.startswith("launch_"):
            self.control.append(("started", inner[len("launch_"):]))
        else:
            return False
        return True

    def end_control(self):
        expected = [] if self.request is None else self.reference.request(self.request, self.answer, self.aborted)
        expected = expected + self.reference.end_control_cycle()
        self.compare(f"control cycle with request {self.request}", expected, self.control)
        self.seen.update(("report", e[-1]) for e in expected if e[0] == "refused")
        self.control = None
        self.counts["control"] += 1

    # ---- tasks ----
    def begin_task(self, name):
        task = self.tasks[name]
        if not self.reference.has_work(task):
            raise Difference(f"a cycle of {name}, which has nothing to do")
        self.cycles[name] = ([], [])
        if "codel_task_main" in task:
            self.cycles[name][0].append(("codel", task["codel_task_main"]))

    def turn(self, ports):
        for port, _ in ports:
            parts = port.split(".")  # ROOT.module.activity.activity.event
            if len(parts) == 5 and parts[3] == "activity" and parts[2] in self.activities:
                self.activity(self.activities[parts[2]], parts[4])

    def activity(self, activity, event):
        task = activity.request["exec_task"]
        if event.startswith("run_"):
            state = event[len("run_"):]
            codel = activity.request.get({"START": "codel_start", "EXEC": "codel_main", "END": "codel_end", "INTER": "codel_inter", "FAIL": "codel_fail"}[state])
            self.running[task] = (state, codel)
            if codel:
                self.cycles[task][0].append(("codel", codel))
            return
        if event in ("rest", "abt", "start", "bury"):
            return
        state, codel = self.running[task]
        answer = {"ok": ("ETHER", "OK"), "intr": ("ETHER", "OK"), "zombie": ("ZOMBIE", "OK"), "bad": ("NONSENSE", "OK")}.get(event)
        if event.startswith("to_"):
            answer = (event[len("to_"):], "OK")
        if event.startswith("report_"):
            answer = ("ETHER", event[len("report_"):])
        if answer is None:
            raise Difference(f"event {event} of {activity.name}")
        if codel:
            self.cycles[task][1].append(answer)
            self.seen.add((state, answer[0]))
        if event == "bad":
            self.end_task(task)

    def end_task(self, name):
        events, answers = self.cycles.pop(name)
        queue = list(answers)

        def answer(codel):
            if not queue:
                raise Difference(f"cycle of {name}: the reference runs {codel}, the model did {events}")
            return queue.pop(0)

        expected = self.reference.task_cycle(self.tasks[name], answer)
        self.compare(f"cycle of {name} with answers {answers}", expected, events)
        if queue:
            raise Difference(f"cycle of {name}: answers left {queue}")
        self.counts["task"] += 1
