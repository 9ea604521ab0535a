#!/usr/bin/env python3
"""Dala's decisional level: reads a file of procedures, asks a served functional level for services, hears of reports.

    models/dala/mission/executive.py SOCKET MISSION [--journal FILE]

A line a step; `#` begins a comment:
    procedure NAME                      the steps up to the next one; it begins with `mission`
    do SERVICE [INPUT …] [gets REPORT]    asks, and waits for the final reply: OK, or what is said
    start SERVICE [INPUT …]               asks, and waits until it is accepted
    refused SERVICE [INPUT …] gets REPORT asks, and is refused so
    await SERVICE [gets REPORT]           waits for the final reply of one that was started
    call NAME [VALUE …]                   its steps, with the values in the place of $1, $2, …
    if SERVICE ended NAME                 calls NAME if it has ended with OK
    if POSTER.MEMBER is VALUE NAME [VALUE …] else NAME [VALUE …]    calls the first one if the poster holds that
    while SERVICE until POSTER.MEMBER is VALUE for SECONDS    waits until the poster has held that for so long, or the service does not run
    until at X Y NAME [VALUE …]           calls NAME until the rover (POM.Pos) is less than 0.4 m from there, at most 20 times
    sleep SECONDS | say TEXT
    window FROM TO [FROM TO …]          waits until it is in one of them, of those that are not over
    lose | die                          faults: the next request never arrives; this process is killed, half a request is sent
A REPORT may be several, `OK|BLOCKED`. A service is MODULE.NAME, with the values of its parameters in parentheses if rules speak of them. What is not answered within two
seconds is asked again. The journal has what a next process needs to go on. Ends with 0 if nothing came otherwise than said.
Python's library only.
"""
import argparse
import json
import math
import os
import re
import pathlib
import signal
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent.parent / "tools"))
from serve_client import Client  # noqa: E402

PATIENCE = 2.0
ASKS = ("do", "start", "refused")
NEAR, ROUNDS = 0.4, 20


class Step:
    def __init__(self, line, number):
        line, _, report = line.partition(" gets ")
        self.number, self.report, self.line = number, report.strip() or "OK", line
        self.verb, _, rest = line.strip().partition(" ")
        self.text = rest.strip()
        self.service, _, self.input = self.text.partition(" ")

    def with_values(self, values):
        """This step of a procedure that is called with them."""
        if "$" not in self.text:
            return self
        filled = Step(re.sub(r"\$(\d)", lambda m: values[int(m[1]) - 1], self.line), self.number)
        filled.report = self.report
        return filled


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
        self.stack = [["mission", 0, []]]  # procedure, next step, its values
        self.finished = {}             # service -> its last final report
        self.open = []                 # started and not ended
        self.now, self.surprises, self.loses = 0.0, 0, False
        self.rounds = {}               # of each `until`
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
        if report not in step.report.split("|"):
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
            name, at, values = self.stack[-1]
            steps = self.procedures[name]
            if at == len(steps):
                self.stack.pop()
                continue
            self.stack[-1][1] += 1
            self.step(steps[at].with_values(values))
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
            self.call(step.text.split())
        elif step.verb == "if":
            watched, verb, *rest = step.text.split()
            if verb == "is":
                split = rest.index("else")
                self.call(rest[1:split] if self.held(watched) == rest[0] else rest[split + 1:])
            elif self.finished.pop(watched, None) == "OK":
                self.call(rest)
        elif step.verb == "while":
            self.hold(step.text)
        elif step.verb == "until":
            _, x, y, *rest = step.text.split()
            self.approach(step, float(x), float(y), rest)
        elif step.verb in ("sleep", "window"):
            numbers = [float(n) for n in step.text.split()]
            # A slow machine gets there later: in the next window, if there is one.
            begins = [begin for begin, end in zip(numbers[::2], numbers[1::2]) if self.now < end]
            until = self.now + numbers[0] if step.verb == "sleep" else (begins or [0])[0]
            while self.now < until:
                self.listen()
            if step.verb == "window":
                self.expect(step, "OK" if begins else "TOO-LATE")
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

    def call(self, words):
        self.stack.append([words[0], 0, words[1:]])

    def approach(self, step, x, y, words):
        """Calls, with this step to be looked at again, until the rover is there."""
        place = self.poster("POM.Pos")["data"]
        rounds = self.rounds.pop(step.number, 0) + 1
        if math.hypot(place["x"] - x, place["y"] - y) < NEAR:
            return
        if rounds > ROUNDS:
            self.expect(step, "NEVER-THERE")
            return
        self.rounds[step.number] = rounds
        self.stack[-1][1] -= 1
        self.call(words)

    def poster(self, name):
        answer = self.level.ask("poster", poster=name)
        if not answer["ok"]:
            sys.exit(f"poster {name}: {answer['error']}")
        return answer["value"]

    def held(self, name):
        """What a member of a poster holds, as text."""
        module, poster, member = name.split(".")
        return str(self.poster(f"{module}.{poster}")["data"][member])

    def hold(self, text):
        service, _, name, _, value, _, seconds = text.split()
        since = None
        while service in self.open and (since is None or self.now < since + float(seconds)):
            if self.held(name) != value:
                since = None
            elif since is None:
                since = self.now
            begin = self.now
            while self.now < begin + 0.2:
                self.listen()

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
