#!/usr/bin/env python3
"""Pages of a served model (`bipc view --attach`): what they show of it, what they may do, what is refused.

    tests/view/test_attach.py

The philosophers run into their deadlock under `bipc serve`, a page undoes steps to the first wrong decision, takes another
choice, and the model goes on. Then roles, a model that runs freely, events, breakpoints, another client that moves the
model, a model of another file, no server, no token. The same in a browser is test_page.py.
"""
import json
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time

from web_client import LONG, Model, Page, Run, Served

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tools/python/bipc"))
from serve import Client  # noqa: E402

BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
PHILOSOPHERS = ROOT / "models/classic/philosophers.bip"
SAFE = ROOT / "models/classic/philosophers_safe.bip"
TRAINS = ROOT / "models/timed/train_gate.bip"
COUNTER = ROOT / "tests/serve/counter.bip"
TEXTS = ROOT / "tests/serve/texts.bip"
passed, failed = 0, 0


def check(what, is_so, *shown):
    global passed, failed
    passed, failed = (passed + 1, failed) if is_so else (passed, failed + 1)
    if not is_so:
        print(f"FAILED {what}:", *(str(s)[:600] for s in shown))


class Watched:
    """The run and the model as a page has them."""

    def __init__(self, served):
        self.page, self.run, self.model, self.first, self.said = Page(served), Run(), {}, None, []

    def take(self, note):
        kind = note.get("note")
        if kind == "begin":
            self.first = note
            self.run = Run()
            self.run.candidates = [note["candidates"]]
            self.run.names = note["names"]
        elif kind == "model":
            self.model = note
        elif kind == "said":
            self.said.append(note["text"])
        else:
            self.run.follow([note])

    def until(self, what, holds):
        """Reads notes until it holds."""
        end = time.monotonic() + LONG
        while not holds():
            if time.monotonic() > end:
                check(what, False, self.model, self.run.texts()[-5:], self.run.candidates[-1:])
                return False
            self.take(self.page.message())
        check(what, True)
        return True

    def ask(self, verb, **fields):
        answer = self.page.ask(verb, **fields)
        for note in self.page.notes:
            self.take(note)
        self.page.notes.clear()
        return answer

    def choices(self):
        last = self.run.candidates[-1]
        return None if last is None else [self.run.names[row].replace("ROOT.", "") for row in last["rows"]]

    def places(self):
        """Of the last state, by atom."""
        places = list(self.first["places"])
        for step in self.run.steps:
            for atom, place, _ in step[3]:
                places[atom] = places[atom] if place is None else place
        return places


def fire(w, name):
    before = w.model["steps"]
    choices = w.choices()
    k = next((k for k, text in enumerate(choices or []) if text.split(" ")[0] == name), None)
    if k is None:
        return check(f"{name} is a candidate", False, choices)
    answer = w.ask("fire", candidate=k, steps=before)
    check(f"{name} is taken", answer["ok"], answer)
    w.until(f"the step of {name} is seen", lambda: w.model["steps"] == before + 1 and w.run.steps and w.run.texts()[-1].startswith(name + " ") and (w.choices() is not None))


def deadlock():
    with Model(BIPC, PHILOSOPHERS, "--paused") as model, Served(BIPC, "--attach", model.where, PHILOSOPHERS) as served:
        w = Watched(served)
        w.until("the candidates of the initial state come", lambda: w.model and w.choices())
        check("five candidates, with their ports", w.choices()[0] == "table.left[0]  table.phil[0].take_left table.fork[0].take" and len(w.choices()) == 5, w.choices())
        check("it is paused", w.model["paused"] and not w.model["ended"], w.model)
        first = w.places()
        seen = [first]
        for k in range(5):
            fire(w, f"table.left[{k}]")
            seen.append(w.places())
        check("each philosopher has one fork", sorted(w.places()) == ["HAS_LEFT"] * 5 + ["USED"] * 5, w.places())
        check("a step names who took part", len(w.run.steps[0][2]) == 2 and w.run.steps[0][0] >= 0, w.run.steps[0])
        check("nothing is possible", w.choices() == [], w.choices())
        check("the end is found by a step", w.ask("step", count=1)["ok"])
        w.until("the deadlock is told", lambda: w.model["ended"] and w.run.end and len(w.run.end["cycle"]) > 2)
        check("its story is there", "cycle: " in w.run.end["story"], w.run.end)
        # The first wrong decision is the fourth fork: after it nothing but the deadlock is possible.
        for count in (4, 3):
            check("a step is undone", w.ask("back", count=1)["ok"])
            w.until("and seen", lambda count=count: w.model["steps"] == count and w.run.steps[-1][1] == f"back to the state after {count} steps" and w.choices())
            check("the state is the one before", w.places() == seen[count], w.places(), seen[count])
        check("no end any more", w.run.end is None and not w.model["ended"])
        fire(w, "table.right[2]")
        for _ in range(3):
            before = w.model["steps"]
            check("a step of the policy", w.ask("step", count=1)["ok"])
            w.until("the run goes on", lambda before=before: w.model["steps"] == before + 1 and w.model["paused"])
        why = w.ask("why", path="table.right[0]")
        check("why not", why["ok"] and why["text"].startswith("table.right[0] is ") and "possible" in why["text"], why)
        check("why: an unknown name", not w.ask("why", path="nobody")["ok"])
        check("fire: the model is elsewhere", "has taken" in w.ask("fire", candidate=0, steps=0)["error"])
        check("break: an unknown name", w.ask("break", path="nobody")["error"] == "there is no interaction and no port `nobody`")

        # A second page has the whole run; another client moves the model, and both see it.
        other = Watched(served)
        other.until("a second page has the run", lambda: other.model == w.model and len(other.run.steps) == len(w.run.steps))
        check("and its names", other.run.names == w.run.names and other.run.steps == w.run.steps)
        with Client(model.where, LONG) as client:
            before = w.model["steps"]
            check("another client steps", client.ask("step", count=1)["ok"])
            for page in (w, other):
                page.until("a page sees it", lambda page=page: page.model["steps"] == before + 1)
        for message in (b"x", b"{}", b'{"id":1,"do":"shutdown"}', b'{"id":1,"do":"fire","candidate":0}', b'{"id":1,"do":"step","count":-1}', b'{"id":1,"do":"why","path":' + b"[" * 90):
            bad = Page(served)
            check(f"{message[:40]} ends the connection", bad.is_closed_after(message))
            bad.close()
        w.page.close()
        other.page.close()
    check("the page's server ends well", served.code == 0, served.code)


def roles():
    with Model(BIPC, PHILOSOPHERS, "--paused", port=True) as model:
        for token, role, may_fire in zip(model.tokens, ("operator", "requester", "observer"), (True, False, False)):
            with Served(BIPC, "--attach", f"{model.where}:{token}", PHILOSOPHERS) as served:
                check(f"the page of {role}s says so", f'"attached":"{role}"' in served.get(f"/{served.token}/"))
                check("the token is not in the page", token not in served.get(f"/{served.token}/"))
                w = Watched(served)
                w.until("the candidates come", lambda: w.model and w.choices())
                answer = w.ask("fire", candidate=0, steps=w.model["steps"])
                check(f"fire, of {role}s", answer["ok"] == may_fire and (may_fire or "takes the role of an operator" in answer["error"]), answer)
                w.page.close()
        done = subprocess.run([BIPC, "view", "--attach", model.where, str(PHILOSOPHERS)], capture_output=True, text=True, env={**os.environ, "BIPC_TOKEN": "0" * 32})
        check("a wrong token", done.returncode == 1 and "error[B5090]" in done.stderr and "token" in done.stderr, done)
        done = subprocess.run([BIPC, "view", "--attach", f"{model.where}:{model.tokens[0]}", str(COUNTER)], capture_output=True, text=True)
        check("another model", done.returncode == 1 and "another model runs there" in done.stderr and model.tokens[0] not in done.stderr, done)


def running():
    """A model that runs freely, and that events move."""
    with Model(BIPC, COUNTER) as model, Served(BIPC, "--attach", model.where, COUNTER) as served:
        w = Watched(served)
        w.until("the model is seen", lambda: w.model and w.first)
        check("it is not paused", not w.model["paused"], w.model)
        for n in (7, 8):
            before = w.model["steps"]
            answer = w.ask("post", port="c.add", values="7" if n == 7 else "8 9")
            check("an event is posted", answer["ok"] == (n == 7), answer)
            if n == 7:
                w.until("its step is seen, with its data", lambda: w.model["steps"] > before and w.run.steps and any(value == "7" for step in w.run.steps for _, _, values in step[3] for _, value in values))
        check("no candidates of a model that goes on", w.run.candidates[-1] is None, w.run.candidates[-1])
        check("fire: it is not paused", w.ask("fire", candidate=0, steps=w.model["steps"])["error"] == "the model is not paused")
        check("pause", w.ask("pause")["ok"])
        w.until("it is paused", lambda: w.model["paused"])
        check("resume", w.ask("resume")["ok"])
        w.until("it runs again", lambda: not w.model["paused"])
        w.page.close()
        # The model ends, and with it the page's server.
        with Client(model.where, LONG) as client:
            client.ask("shutdown")
        check("the page's server ends with the model", served.process.wait(LONG) == 0, served.process.returncode)


def texts():
    """A model that gets 20,000 texts: neither it nor the page's server keeps those that no state has any more."""
    def resident(process):
        return int(re.search(r"VmRSS:\s+(\d+)", pathlib.Path(f"/proc/{process.pid}/status").read_text())[1])

    with Model(BIPC, TEXTS) as model, Served(BIPC, "--attach", model.where, TEXTS) as served, Client(model.where, LONG) as client:
        w = Watched(served)
        w.until("the model is seen", lambda: w.model and w.first)
        before = []
        for k in range(20_000):
            if k == 5_000:
                before = [resident(process) for process in (model.process, served.process)]
            if not client.ask("post", port="c.add", values=[str(k) * 100])["ok"]:
                return check("a text is posted", False, k)
        w.until("the last text is seen", lambda: any("19999" in str(step[3]) for step in w.run.steps[-3:]))
        grown = [resident(process) - was for process, was in zip((model.process, served.process), before)]
        # 15,000 texts are 7 MB.
        check("texts are freed", max(grown) < 4096, f"{grown} kB more")
        w.page.close()


def clocks():
    """Clocks of a model with time: what a page computes from its notes is what the model says, after each of its steps."""
    with Model(BIPC, TRAINS, "--paused") as model, Served(BIPC, "--attach", model.where, TRAINS) as served, Client(model.where, LONG) as client:
        w = Watched(served)
        w.until("the candidates of the initial state come", lambda: w.model and w.choices())
        shown = client.ask("state")["atoms"]
        names = list(shown)
        check("each component with clocks has them in the first state", [len(c) for c in w.first["clocks"]] == [len(shown[a].get("clocks", {})) for a in names], w.first["clocks"])
        sets = runs = 0
        for _ in range(12):
            # Time stands still while the model is paused: a step waits until it is due.
            before, rows = w.model["steps"], len(w.run.steps)
            answer = w.ask("step", count=1)
            w.until("a step is seen", lambda: w.model["steps"] > before and w.model["paused"] and len(w.run.steps) > rows and w.choices() is not None)
            state = client.ask("state")
            now = [[list(c) for c in rows] for rows in w.first["clocks"]]
            for step in w.run.steps:
                for atom, clock, *reading in (step[6] if len(step) > 6 else []):
                    now[atom][clock] = reading
                    sets += 1
            for atom, name in enumerate(names):
                for (value, since, speed), wanted in zip(now[atom], state["atoms"][name].get("clocks", {}).values()):
                    got = (value + (state["time"] - since) * speed) / 1e9
                    runs += got > 0
                    if abs(got - wanted["value"]) > 1e-9:
                        return check("a clock is that of the model", False, name, got, wanted, state)
            check("the step is answered", answer["ok"], answer)
        check("clocks are set, and run", sets > 3 and runs > 10, sets, runs)
        w.page.close()


def large():
    """A model of which only the components that moved are asked for: what the page has is the model's state, after steps, undone steps and a burst."""
    with Model(BIPC, SAFE, "--paused", "--root", "Table(60)") as model, Served(BIPC, "--attach", model.where, "--root", "Table(60)", SAFE) as served, Client(model.where, LONG) as client:
        w = Watched(served)
        w.until("the model is seen", lambda: w.model and w.choices())
        paths = [path for path, _ in json.loads(re.search(r'type="application/json">(.*?)</script>', served.get(f"/{served.token}/"))[1])["atoms"]]
        check("it has more than sixty-four components", len(paths) > 64, len(paths))

        def agrees():
            """Waits until the page has the state of a model that stands still."""
            state = client.ask("state")
            wanted = [state["atoms"][path]["place"] for path in paths]
            return w.until("the page has the model's state", lambda: w.model["steps"] == state["steps"] and w.model["paused"] and w.choices() is not None and w.places() == wanted)

        for count in (1, 30, 200):
            before = w.model["steps"]
            check("steps are taken", w.ask("step", count=count)["ok"])
            w.until("and seen", lambda before=before, count=count: w.model["steps"] == before + count and w.model["paused"])
            agrees()
        check("many steps are one row", len(w.run.steps) < 231, len(w.run.steps))
        check("steps are undone", w.ask("back", count=25)["ok"])
        w.until("and seen", lambda: w.model["steps"] == 206)
        agrees()
        check("it runs freely", w.ask("resume")["ok"])
        w.until("and is followed", lambda: w.model["steps"] > 1000 and not w.model["paused"])
        check("pause", w.ask("pause")["ok"])
        w.until("it stands still", lambda: w.model["paused"])
        agrees()
        w.page.close()


class Odd:
    """A server that is none, or a bad one: answers each request by a function, and then sends lines of its own."""

    def __init__(self, answer, then=()):
        self.folder = tempfile.TemporaryDirectory()
        self.where = os.path.join(self.folder.name, "s")
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(self.where)
        self.listener.listen(1)
        self.answer, self.then = answer, then
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        try:
            self.answer_all()
        except OSError:
            pass  # the client has gone

    def answer_all(self):
        connection, _ = self.listener.accept()
        # Two files: one that is read and written forgets lines that it has read ahead.
        with connection, connection.makefile("r", encoding="utf-8") as requests, connection.makefile("w", encoding="utf-8") as lines:
            for line in requests:
                request = json.loads(line)
                answer = self.answer(request)
                if answer is None:
                    return
                answer = answer if isinstance(answer, str) else json.dumps({**({"id": request["id"]} if "id" in request else {}), **answer})
                lines.write(answer + "\n" + "".join(one + "\n" for one in (self.then if request["do"] == "state" else ())))
                lines.flush()


def odd_servers():
    hello = {"ok": True, "format": "bipc-serve", "version": 1, "role": "operator"}
    atoms = {"ROOT.c": {"place": "P", "data": {"n": 0, "count": 0}}, "ROOT.l": {"place": "OFF", "data": {"n": 0}}}
    state = {"ok": True, "time": 0, "steps": 0, "late": 0, "paused": True, "ended": False, "atoms": atoms}

    def answers(**more):
        return lambda request: {"hello": hello, "subscribe": {"ok": True}, "state": state, **more}.get(request["do"], {"ok": True})

    for what, answer, wanted in (("closes", lambda _: None, "no server answers"), ("refuses", lambda _: {"ok": False, "error": "no"}, ": no"), ("another protocol", lambda _: {"ok": True}, "no `bipc serve`"),
                                 ("a later version", answers(hello={**hello, "version": 2}), "version 1"), ("no state", answers(state={"ok": False}), "does not say its state"), ("no atoms", answers(state={"ok": True, "atoms": 7}), "does not say its state"),
                                 ("an atom is missing", answers(state={**state, "atoms": {"ROOT.c": atoms["ROOT.c"]}}), "no component `ROOT.l`"), ("another atom", answers(state={**state, "atoms": {**atoms, "ROOT.x": {}}}), "a component `ROOT.x`"),
                                 ("another place", answers(state={**state, "atoms": {**atoms, "ROOT.l": {"place": "ODD"}}}), "is at `ODD`")):
        server = Odd(answer)
        done = subprocess.run([BIPC, "view", "--attach", server.where, str(COUNTER)], capture_output=True, text=True, timeout=LONG)
        check(what, done.returncode == 1 and "error[B5090]" in done.stderr and wanted in done.stderr, done)
    # What comes later may be anything; the page goes on.
    notes = ["", "x", "[]", "7", "null", '{"note":7}', '{"note":"step"}', '{"note":"step","step":-1,"time":"x","interaction":[],"ports":{}}', '{"note":"step","step":1e300,"ports":[1,null,"","x","ROOT.c.add","ROOT.c.","..",{}],"values":[]}',
             '{"note":"end","text":"cycle: -> ROOT.c -> nobody -> "}', '{"note":"dropped","count":-5}', '{"note":"break"}', '{"id":99,"ok":true}', '{"id":"x"}', '{"id":-1}', '{"note":"late","text":"\\ud800"}', "[" * 5000]
    odd_state = answers(candidates={"ok": True, "steps": 0, "count": -1, "candidates": [7, None, {"interaction": 3, "ports": [1]}, {"interaction": "a", "ports": "b"}]},
                        why={"ok": 3}, fire={"ok": True, "error": 9})
    server = Odd(odd_state, notes)
    with Served(BIPC, "--attach", server.where, COUNTER) as served:
        w = Watched(served)
        w.until("the page of an odd server comes", lambda: w.model and w.first)
        for verb, fields in (("why", {"path": "c.add"}), ("fire", {"candidate": 0, "steps": 0}), ("step", {"count": 1}), ("post", {"port": "c.add", "values": "7"})):
            check(f"{verb} is answered", "ok" in w.ask(verb, **fields))
        w.page.close()
    check("the page's server ends well", served.code == 0, served.code)


deadlock()
roles()
odd_servers()
running()
clocks()
large()
print(f"attach: {passed} passed, {failed} failed")
sys.exit(1 if failed else 0)
