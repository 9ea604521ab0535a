"""The run-time semantics of a GenoM 2 module as a small program: what a controller made of its description must do.

Written from the description of GenoM's run time alone (control cycle, task cycle, activities, reports), not from the
generator: the differential test runs both side by side. A module is a plain dictionary, as scenarios.py makes them.
Everything that the world decides comes in from outside: which request arrives, what a codel answers, when a task's period
is over. What comes out are lists of events: replies, interruptions, codels in their order.
"""

PERMITTED = {
    "START": {"START", "EXEC", "END", "ETHER", "FAIL", "ZOMBIE", "SLEEP"},
    "EXEC": {"EXEC", "END", "ETHER", "FAIL", "ZOMBIE", "SLEEP"},
    "END": {"END", "ETHER", "FAIL", "ZOMBIE"},
    "INTER": {"INTER", "ETHER", "FAIL", "ZOMBIE"},
    "FAIL": {"ZOMBIE"},
}
DEFAULT = {"START": "EXEC", "EXEC": "END", "END": "ETHER", "INTER": "ETHER", "FAIL": "ZOMBIE"}
CODEL_OF = {"START": "codel_start", "EXEC": "codel_main", "END": "codel_end", "INTER": "codel_inter", "FAIL": "codel_fail"}
RUNNING = ("START", "EXEC", "END", "INTER", "FAIL")


class Activity:
    """One place for an activity of one request."""

    def __init__(self, request, number):
        self.request, self.number = request, number
        self.state = "ETHER"       # ETHER INIT START EXEC END INTER FAIL SLEEP ZOMBIE
        self.report = None         # of an activity that ended and was not told of yet
        self.ran = False           # the last activity got as far as START

    @property
    def name(self):
        return self.request["name"] + (f"_{self.number + 1}" if self.number else "")

    def is_free(self):
        return self.state == "ETHER" and self.report is None

    def is_running(self):
        return self.state in RUNNING or self.state == "SLEEP" or (self.report is not None and self.ran)


class Reference:
    def __init__(self, module, instances):
        self.module = module
        self.requests = {r["name"]: r for r in module["requests"]}
        self.activities = [Activity(r, k) for r in module["requests"] if self.is_execution(r) for k in range(instances(r))]
        self.initialised = not any(r["type"] == "init" for r in module["requests"])
        self.suspended = set()

    @staticmethod
    def is_execution(request):
        codels = any(key in request for key in CODEL_OF.values())
        return request["type"] == "exec" or (request["type"] == "init" and ("exec_task" in request or codels))

    def interrupts(self, request):
        """Activities of requests that this one is incompatible with: `init` with everything else, with itself if it says so."""
        listed = request.get("interrupt_activity", [])
        if request["type"] == "init":
            return [s for s in self.activities if s.request is not request or (listed != "all" and request["name"] in listed)]
        return [s for s in self.activities if listed == "all" or s.request["name"] in listed]

    # ---- the control cycle ----
    def begin_control_cycle(self):
        """Final replies of what ended or failed since the last one."""
        events = []
        for activity in self.activities:
            if activity.report is not None:
                events.append(("final", activity.name, activity.report))
                activity.report = None
        return events

    def request(self, name, answer, activity_of_abort=None):
        """One request; `answer` is what its control codel gives ("OK" or a report), or None if it has none."""
        if name == "Abort":
            return self.abort(activity_of_abort)
        request = self.requests[name]
        if not self.is_execution(request):
            return self.control_request(request, answer)
        events = []
        if request["type"] == "exec":
            refusal = None
            if self.suspended:
                refusal = "SYSTEM_ERROR"
            elif not self.initialised:
                refusal = "WAIT_INIT_RQST"
            elif any(s.state == "ZOMBIE" for s in self.activities):
                refusal = "WAIT_ABORT_ZOMBIE_ACTIVITY"
            if refusal:
                return [("refused", name, refusal)]
        free = [s for s in self.activities if s.request is request and s.is_free()]
        if not free:
            return [("refused", name, "TOO_MANY_ACTIVITIES")]
        activity = free[0]
        if "codel_control" in request:
            events.append(("codel", request["codel_control"]))
            if answer != "OK":
                return events + [("refused", name, answer)]
        events += self.interrupt_all(request)
        activity.state, activity.ran = "INIT", False
        return events

    def control_request(self, request, answer):
        events = self.interrupt_all(request)
        if "codel_control" in request:
            events.append(("codel", request["codel_control"]))
        else:
            answer = "OK"
        if answer == "OK" and request["type"] == "init":
            self.initialised = True
        return events + [("control reply", request["name"], answer)]

    def interrupt_all(self, request):
        return [e for activity in self.interrupts(request) for e in self.interrupt(activity)]

    def interrupt(self, activity):
        if activity.state == "INIT":
            activity.state, activity.report = "ETHER", "ACTIVITY_INTERRUPTED"
        elif activity.state in RUNNING or activity.state == "SLEEP":
            activity.state = "INTER"
        else:
            return []
        return [("interrupted", activity.name)]

    def abort(self, name):
        """The client names an activity; None is one that does not exist."""
        if name is None:
            return [("unknown",)]
        activity = next(s for s in self.activities if s.name == name)
        if activity.state == "ZOMBIE":
            activity.state = "ETHER"
            return [("buried", activity.name)]
        return self.interrupt(activity)

    def end_control_cycle(self):
        """Starts what waits for nobody; returns the intermediate replies."""
        events = []
        for activity in self.activities:
            if activity.state == "INIT" and not any(s.is_running() for s in self.interrupts(activity.request) if s is not activity):
                activity.state, activity.ran = "START", True
                events.append(("started", activity.name))
        return events

    # ---- the task cycle ----
    def has_work(self, task):
        busy = any(s.request["exec_task"] == task["name"] and (s.state in RUNNING or s.state == "SLEEP") for s in self.activities)
        return task["name"] not in self.suspended and ("codel_task_main" in task or busy)

    def task_cycle(self, task, answer):
        """`answer(codel)` gives what a codel answers: OK or ERROR (permanent), (state, report) else."""
        events = []
        if "codel_task_main" in task:
            events.append(("codel", task["codel_task_main"]))
            if answer(task["codel_task_main"]) != "OK":
                self.suspended.add(task["name"])
                return events
        for activity in self.activities:
            if activity.request["exec_task"] != task["name"] or activity.state not in RUNNING:
                continue
            state = activity.state
            codel = activity.request.get(CODEL_OF[state])
            report = "OK"
            if codel is None:
                new = DEFAULT[state]
            else:
                events.append(("codel", codel))
                new, report = answer(codel)
            if new not in PERMITTED[state]:
                self.suspended.add(task["name"])
                return events
            activity.state = new
            if new == "ETHER":
                activity.report = "ACTIVITY_INTERRUPTED" if state == "INTER" else report
                if activity.report == "OK" and activity.request["type"] == "init":
                    self.initialised = True
            elif new == "ZOMBIE":
                activity.report = "ACTIVITY_FAILED"
        return events
