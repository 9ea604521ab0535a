#!/usr/bin/env python3
"""Dala's decisional level: reads a file of procedures, asks a served functional level for services, hears of reports.

    models/dala/mission/executive.py SOCKET MISSION [--journal FILE]

A line a step; `#` begins a comment:
    procedure NAME                      the steps up to the next one; it begins with `mission`
    do SERVICE [INPUT …] [gets REPORT]    asks, and waits for the final reply: OK, or what is said
    start SERVICE [INPUT …]               asks, and waits until it is accepted
    refused SERVICE [INPUT …] gets REPORT asks, and is refused so
    await SERVICE [gets REPORT]           waits for the final reply of one that was started
    call NAME | if SERVICE ended NAME | sleep SECONDS | window FROM TO | say TEXT
    lose | die                          faults: the next request never arrives; this process is killed, half a request is sent
A service is MODULE.NAME, with the values of its parameters in parentheses if rules speak of them. What is not answered within two
seconds is asked again. The journal has what a next process needs to go on. Ends with 0 if nothing came otherwise than said.
Python's library only.
"""
import argparse
import json
import os
import pathlib
import signal
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent.parent / "tools"))
from serve_client import Client  # noqa: E402

PATIENCE = 2.0
ASKS = ("do", "start", "refused")


class Step:
    def __init__(self, line, number):
        line, _, report = line.partition(" gets ")
        self.number, self.report = number, report.strip() or "OK"
        self.verb, _, rest = line.strip().partition(" ")
        self.text = rest.strip()
        self.service, _, self.input = self.text.partition(" ")


def read(path):
    procedures, steps = {}, None
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        line = line.partition("#")[0].strip()
        if line.startswith("procedure "):
            steps = procedures.setdefault(line.split()[1], [])
        elif line:
            steps.append(Step(line, number))
    return procedures


class Executive:
    def __init__(self, level, procedures, journal):
        self.level, self.procedures, self.journal = level, procedures, journal
        self.stack = [["mission", 0]]  # procedure, next step
        self.finished = {}             # service -> its last final report
        self.open = []                 # started and not ended
        self.now, self.surprises, self.loses = 0.0, 0, False
        self.told = None               # (service, report) that came last
        level.ask("subscribe", ports=["masterTimer.tick"], requests=True)
        self.accepted = set()          # numbers of requests that are activities now
        # What is over at once has no activity.
        self.controls = {row["service"] for row in level.ask("hello")["services"] if row["kind"] == "control"}
        self.now = level.ask("state", atoms=["ROOT.masterTimer"])["time"] / 1e9

    @staticmethod
    def bare(service):
        return service.partition("(")[0]

    def log(self, text):
        print(f"{self.now:8.2f}  {text}", flush=True)

    def expect(self, step, report):
        if report != step.report:
            self.surprises += 1
            self.log(f"surprise in line {step.number}: {report}, not {step.report}")

    # ---- what the level says
    def listen(self):
        """One note."""
        note = self.level.note()
        if note["note"] == "end":
            sys.exit(f"the functional level has ended: {note['text']}")
        if note["note"] not in ("step", "request"):
            return
        self.now = note["time"] / 1e9
        if note["note"] == "step":
            return
        if note["reply"] == "intermediate":
            self.accepted.add(note["request"])
            self.answer(note["service"], note["report"])
        elif note["request"] in self.accepted:
            self.reply(note["service"], note["report"])
        else:
            self.answer(note["service"], note["report"])

    def answer(self, service, report):
        self.told = (service, report)
        self.log(f"accepted {service}" if report == "OK" else f"refused  {service}: {report}")

    def reply(self, service, report):
        self.finished[service] = report
        if service in self.open:
            self.open.remove(service)
        self.log(f"ended    {service}: {report}")

    # ---- what it is asked for
    def request(self, step):
        """The answer to a request; who never hears of it asks again."""
        service = self.bare(step.service)
        self.finished.pop(service, None)
        while True:
            self.told = None
            if self.loses:
                self.loses = False
            else:
                answer = self.level.ask("request", service=step.service, input=step.input)
                if not answer["ok"]:
                    self.log(f"refused  {service}: {answer['error']}")
                    return "NOT-TAKEN"
            until = self.now + PATIENCE
            while self.now < until:
                self.listen()
                if self.told and self.told[0] == service:
                    return self.told[1]
            self.log(f"no answer to {step.service}: asked again")

    def wait(self, service):
        while service not in self.finished:
            self.listen()
        return self.finished[service]

    def run(self):
        while self.stack:
            name, at = self.stack[-1]
            steps = self.procedures[name]
            if at == len(steps):
                self.stack.pop()
                continue
            self.stack[-1][1] += 1
            self.step(steps[at])
            self.write_journal()
        self.log(f"procedures over, {self.surprises} surprises")

    def step(self, step):
        service = self.bare(step.service)
        if step.verb in ASKS:
            report = self.request(step)
            if report == "OK" and step.verb != "refused" and service not in self.controls:
                self.open.append(service)
                if step.verb == "do":
                    report = self.wait(service)
            self.expect(step, report)
        elif step.verb == "await":
            self.expect(step, self.wait(service))
        elif step.verb == "call":
            self.stack.append([step.text, 0])
        elif step.verb == "if":
            watched, _, procedure = step.text.split()
            if self.finished.pop(watched, None) == "OK":
                self.stack.append([procedure, 0])
        elif step.verb in ("sleep", "window"):
            numbers = [float(n) for n in step.text.split()]
            until = self.now + numbers[0] if step.verb == "sleep" else numbers[0]
            while self.now < until:
                self.listen()
            if step.verb == "window":
                self.expect(step, "OK" if self.now < numbers[1] else "TOO-LATE")
        elif step.verb == "say":
            self.log(step.text)
        elif step.verb == "lose":
            self.loses = True
        elif step.verb == "die":
            self.write_journal()
            self.level.socket.sendall(b'{"do":"request","service":"NDD.')
            os.kill(os.getpid(), signal.SIGKILL)
        else:
            sys.exit(f"line {step.number}: `{step.verb}` is no step")

    # ---- for whoever comes after
    def write_journal(self):
        if self.journal:
            kept = {"stack": self.stack, "finished": self.finished, "open": self.open, "surprises": self.surprises}
            self.journal.with_suffix(".new").write_text(json.dumps(kept), encoding="utf-8")
            self.journal.with_suffix(".new").rename(self.journal)

    def go_on(self):
        """From the journal; what ended since then has left its report in its controller."""
        kept = json.loads(self.journal.read_text(encoding="utf-8"))
        self.stack, self.finished, self.surprises = kept["stack"], kept["finished"], kept["surprises"]
        paths = {f"ROOT.{service}.controller": service for service in kept["open"]}
        state = self.level.ask("state", atoms=sorted(paths)) if paths else {"atoms": {}, "time": 0}
        self.now = state["time"] / 1e9
        self.accepted = {row["request"] for row in self.level.ask("requests")["requests"] if row["running"]}
        for path, atom in state["atoms"].items():
            if atom["data"]["active"]:
                self.open.append(paths[path])
            else:
                self.finished[paths[path]] = atom["data"]["rep"]
        self.log(f"a new executive: {', '.join(self.open) or 'nothing'} runs")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("socket")
    arguments.add_argument("mission", type=pathlib.Path)
    arguments.add_argument("--journal", type=pathlib.Path)
    options = arguments.parse_args()
    with Client(options.socket, 60) as level:
        executive = Executive(level, read(options.mission), options.journal)
        if options.journal and options.journal.exists():
            executive.go_on()
        executive.run()
        return 1 if executive.surprises else 0


if __name__ == "__main__":
    sys.exit(main())
