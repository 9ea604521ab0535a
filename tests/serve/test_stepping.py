#!/usr/bin/env python3
"""Stepping through a served model (compiler/docs/serve.md): candidates, fire, why, break, back.

The five philosophers: the way into their deadlock is taken by hand, undone to the first wrong decision, and the run goes on
another way. Also what is refused: atoms, interactions, candidates and steps back that are not there, models that call C++.
"""
import os
import subprocess
import sys
import tempfile

from checks import BIPC, LONG, Client, ROOT, check, finish


class Served:
    def __init__(self, model, *options):
        self.path = os.path.join(tempfile.mkdtemp(), "s")
        self.server = subprocess.Popen([BIPC, "serve", "--backend", "interp", "--socket", self.path, *options, str(model)],
                                       stderr=subprocess.PIPE, text=True)
        assert "listening" in self.server.stderr.readline(), self.server.stderr.read()

    def __enter__(self):
        self.client = Client(self.path, LONG)
        return self.client

    def __exit__(self, *_):
        self.client.ask("shutdown")
        check("the server ends with 0", self.server.wait(LONG) == 0, self.server.returncode)
        self.server.stderr.close()


def fire(client, interaction):
    """Takes the candidate of this name."""
    for candidate in client.ask("candidates")["candidates"]:
        if candidate["interaction"] == interaction:
            return client.ask("fire", candidate=candidate["candidate"])
    return {"ok": False, "error": f"{interaction} is no candidate"}


def state(client):
    answer = client.ask("state")
    return answer["steps"], answer["atoms"]


with Served(ROOT / "models/classic/philosophers.bip", "--paused") as model:
    first = model.ask("candidates")
    check("five candidates in the initial state", first["count"] == 5 and len(first["candidates"]) == 5, first)
    check("a candidate names its ports", first["candidates"][0] == {
        "candidate": 0, "interaction": "ROOT.table.left[0]",
        "ports": ["ROOT.table.phil[0].take_left", "ROOT.table.fork[0].take"]}, first["candidates"][0])
    check("why not: a port is missing", "take_right" in model.ask("why", path="table.right[0]")["why"], model.ask("why", path="table.right[0]"))
    check("why: a candidate is possible", "possible" in model.ask("why", path="ROOT.table.left[0]")["why"].splitlines()[0], model.ask("why", path="ROOT.table.left[0]"))
    check("why not: a port of an atom", model.ask("why", path="table.fork[0].put")["ok"], model.ask("why", path="table.fork[0].put"))
    check("why: an unknown path", model.ask("why", path="table.nobody")["error"] == "there is no interaction or port `table.nobody`", model.ask("why", path="table.nobody"))
    check("why: no path", not model.ask("why")["ok"])

    states = [state(model)]
    for k in range(5):
        check(f"left[{k}] is taken", fire(model, f"ROOT.table.left[{k}]")["ok"])
        states.append(state(model))
    answer = model.ask("state", atoms=["table.phil[0]", "ROOT.table.fork[4]"])
    check("paths with and without ROOT.", {a: v["place"] for a, v in answer["atoms"].items()} == {
        "ROOT.table.phil[0]": "HAS_LEFT", "ROOT.table.fork[4]": "USED"}, answer)
    check("a state without atoms", model.ask("state", atoms=[])["atoms"] == {}, model.ask("state", atoms=[]))
    answer = model.ask("state", atoms=["table.phil[0]", "table.phil[5]"])
    check("an unknown atom", answer.get("error") == "there is no atom `table.phil[5]`", answer)
    check("a deadlock has no candidates", model.ask("candidates")["count"] == 0)
    check("nothing can be taken", model.ask("fire", candidate=0).get("error") == "there is no candidate 0: there are 0")
    check("the end is found by a step", model.ask("step")["ok"])
    while not model.ask("state", atoms=["table.phil[0]"])["ended"]:
        pass
    check("nothing is taken after the end", model.ask("fire", candidate=0).get("error") == "the run has ended")
    check("no step after the end", model.ask("step").get("error") == "the run has ended")

    # Back, state by state, to the first decision after which nothing else was possible: the fifth fork.
    for k in (4, 3):
        check(f"back to {k}", model.ask("back")["ok"])
        check(f"the state {k} is as it was", state(model) == states[k], state(model))
    check("another choice", fire(model, "ROOT.table.right[2]")["ok"], model.ask("candidates"))
    check("more back than there is", model.ask("back", count=99).get("error") == "only 4 steps can be undone", model.ask("back", count=99))
    check("back by no steps", not model.ask("back", count=0)["ok"])
    check("back by four", model.ask("back", count=4)["ok"] and state(model) == states[0], state(model))
    check("candidates of another state", model.ask("fire", candidate=0, steps=1).get("error") == "the model has taken 0 steps, not 1", model.ask("fire", candidate=0, steps=1))
    check("candidates say of which state they are", model.ask("candidates")["steps"] == 0)
    check("steps is a number", not model.ask("fire", candidate=0, steps="0")["ok"])
    check("no such candidate", model.ask("fire", candidate=5).get("error") == "there is no candidate 5: there are 5", model.ask("fire", candidate=5))
    check("a candidate is a number", not model.ask("fire", candidate="left")["ok"])

    # Steps that the policy chooses can be undone, too.
    check("three steps", model.ask("step", count=3)["ok"])
    while not model.ask("state", atoms=["table.phil[0]"])["paused"]:
        pass
    check("three back", model.ask("back", count=3)["ok"] and state(model) == states[0], state(model))

    # A breakpoint: the model runs freely, and pauses after the step in which philosopher 3 takes the left fork.
    saved = model.ask("snapshot")["snapshot"]
    check("a breakpoint", model.ask("break", ports=["phil[3].take_left"])["ok"])
    check("the model runs", model.ask("resume")["ok"])
    note = model.note()
    check("it pauses there", note["note"] == "break" and note["interaction"] == "ROOT.table.left[3]", note)
    answer = model.ask("state", atoms=["table.phil[3]"])
    check("the state after that step", answer["paused"] and answer["atoms"]["ROOT.table.phil[3]"]["place"] == "HAS_LEFT", answer)
    check("the steps of a free run are not undone", model.ask("back").get("error") == "only 0 steps can be undone", model.ask("back"))
    check("the breakpoint is removed", model.ask("break")["ok"])
    check("breakpoints are named", not model.ask("break", interactions=7)["ok"])

    # Another client's breakpoint; then the deadlock ends the run, and who waits at a breakpoint is told.
    check("restored", model.ask("restore", snapshot=saved)["ok"])
    with Client(model.socket.getpeername(), LONG) as other:
        check("a breakpoint of another client", other.ask("break", interactions=["table.left[3]"])["ok"])
        check("a step of this one", fire(model, "ROOT.table.left[3]")["ok"])
        note = other.note()
        check("the other one is told", note["note"] == "break" and note["interaction"] == "ROOT.table.left[3]", note)
        check("a breakpoint that is not reached", other.ask("break", interactions=["table.nobody"])["ok"])
        for k in (0, 1, 2, 4):
            check(f"left[{k}]", fire(model, f"ROOT.table.left[{k}]")["ok"])
        check("on to the end", model.ask("resume")["ok"])
        note = other.note()
        check("the end is told", note["note"] == "end" and note["outcome"] == "deadlock", note)

with Served(ROOT / "models/tutorial/filter.bip", "--paused") as model:
    check("a step of a model with C++", model.ask("fire", candidate=0)["ok"])
    check("C++ is not undone", "calls C++" in model.ask("back").get("error", ""), model.ask("back"))

with Served(ROOT / "tests/serve/counter.bip") as model:
    check("a running model takes no candidate", model.ask("fire", candidate=0).get("error") == "the model is not paused", model.ask("fire", candidate=0))
    check("a running model goes not back", model.ask("back").get("error") == "the model is not paused")

# A model that steps as fast as it can, and a client that hears of each step: its requests are answered between the notes.
with Served(ROOT / "models/classic/philosophers_safe.bip", "--paused", "--root", "Table(60)") as model:
    check("each step is told", model.ask("subscribe")["ok"])
    for k in range(3):
        check("it runs freely", model.ask("resume")["ok"])
        for _ in range(20_000):
            model.note()
        model.notes.clear()
        check("it pauses when it is asked to", model.ask("pause")["ok"])
        check("no more than those that waited are told before the answer", len(model.notes) < 30_000, len(model.notes))
        model.notes.clear()
        before = model.ask("state")["steps"]
        check("and takes no step more", model.ask("state")["steps"] == before)

sys.exit(finish("stepping"))
