#!/usr/bin/env python3
"""Requests to a served functional level (compiler/docs/genom.md): refused when they are unknown or lack a value, a queue a module,
stops first, numbers in replies, taken back by number.

Two modules with C++ codels, `north` and `south`. Every sentence of the test is a promise to who drives a robot: his stop does not wait
for what others mistyped or asked for, and nothing older begins after it.
"""
import contextlib
import os
import pathlib
import subprocess
import sys
import tempfile
import time

from checks import BIPC, LONG, Client, check, finish, until

MODULE = """module {0} {{ number: {1}; internal_data: DATA; }};
request Go {{ type: exec; exec_task: Motion; codel_main: {0}Go; codel_inter: {0}Brake; }};
request Turn {{ type: exec; exec_task: Motion; codel_main: {0}Turn; codel_inter: {0}Brake; }};
request Burst {{ type: exec; exec_task: Motion; codel_control: {0}Check; codel_main: {0}Burst; }};
request Slow {{ type: exec; exec_task: Motion; codel_main: {0}Slow; }};
request Mark {{ type: control; codel_control: {0}Mark; }};
request Stop {{ type: control; interrupt_activity: Go; }};
exec_task Motion {{ period: 2; }};
"""
RULES = """rules level;
modules "north.gen", "south.gen" with "side.yields";
parameter speed of north.Go: 10, 20;
north.Go requires request.speed in [-50, 100] report "TOO-FAST";
parameter gear of south.Slow: first, "far reverse";
late: when north.Slow.late run north.Stop;
"""
# An activity goes on until it is told to stop. Times are counted in ticks of 10 ms.
CODELS = """#include "level_codels.hpp"
#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <thread>
static std::string asked;
void request_asked(const char*, const char* input) { asked = input; }
void request_input(const char* service, const char* input) { std::printf("%s gets %s\\n", service, input); std::fflush(stdout); }
int northGo(int&) { return 2; }
int northTurn(int&) { return 2; }
int northBrake(int&) { return 0; }
int northMark() { return 0; }
int northCheck() { return asked == "refuse" ? throw std::runtime_error("a \\"map\\"\\nis missing") : 0; }
int northBurst(int&) { throw std::runtime_error("no map"); }
int northSlow(int&) { std::this_thread::sleep_for(std::chrono::milliseconds(500)); return 0; }
int southSlow(int&) { return 0; }
int southCheck() { return 0; }
int southBurst(int&) { throw 3; }
int southGo(int&) { return 2; }
int southTurn(int&) { return 2; }
int southBrake(int&) { return 0; }
int southMark() { return 0; }
"""


class Level:
    """A served level and what it told one client."""

    def __init__(self, work):
        self.path = os.path.join(work, "s")
        self.output = open(os.path.join(work, "out"), "w+", encoding="utf-8")
        self.server = subprocess.Popen([BIPC, "serve", "--asap", "--policy", "fair", "--socket", self.path, "level.bip"], cwd=work,
                                       stdout=self.output, stderr=subprocess.PIPE, text=True)
        line = self.server.stderr.readline()
        assert "listening" in line, line + self.server.stderr.read()
        self.client = Client(self.path, LONG)
        self.replies = {}  # number: [(what, report), ...]
        self.thrown = {}   # number: what its final reply tells of an exception
        self.order = []    # numbers by their final replies

    def ask(self, service, input=""):
        answer = self.client.ask("request", service=service, input=input)
        assert answer["ok"], answer
        return answer["request"]

    def refusal(self, do="request", **more):
        answer = self.client.ask(do, **more)
        return None if answer["ok"] else answer["error"]

    def listen(self, holds, seconds=LONG):
        """Until `holds()`; False after so many seconds."""
        end = time.monotonic() + seconds
        while not holds():
            try:
                note = self.client.note(timeout=max(0.01, end - time.monotonic()))
            except TimeoutError:
                return holds()
            if note["note"] == "request":
                self.replies.setdefault(note["request"], []).append((note["reply"], note["report"]))
                if note["reply"] == "final":
                    self.thrown[note["request"]] = note.get("exception")
                    self.order.append(note["request"])
        return True

    def final(self, number):
        self.listen(lambda: any(what == "final" for what, _ in self.replies.get(number, [])))
        return (self.replies.get(number) or [(None, None)])[-1][1]

    def stands_still(self):
        """Requests wait meanwhile: else each is read as soon as it comes."""
        return StandStill(self.client)

    def accepted(self, number):
        self.listen(lambda: number in self.replies)
        return (self.replies.get(number) or [(None, None)])[0]


class StandStill:
    def __init__(self, client):
        self.client = client

    def __enter__(self):
        assert self.client.ask("pause")["ok"]

    def __exit__(self, *_):
        assert self.client.ask("resume")["ok"]


def main():
    with tempfile.TemporaryDirectory(prefix="requests-") as work:
        for number, name in enumerate(("north", "south"), 1):
            pathlib.Path(work, f"{name}.gen").write_text(MODULE.format(name, number), encoding="utf-8")
        pathlib.Path(work, "side.yields").write_text("request south.Turn overtakes\ncodel northSlow takes 100 ms\n", encoding="utf-8")
        pathlib.Path(work, "level.rules").write_text(RULES, encoding="utf-8")
        pathlib.Path(work, "level_codels.cpp").write_text(CODELS, encoding="utf-8")
        subprocess.run([BIPC, "rules", "--served", "--skeleton", "level.rules", "-o", "level.bip"], cwd=work, check=True, capture_output=True)
        level = Level(work)
        with level.client:
            refusals(level)
            values(level)
            words(level)
            one_value(level)
            stops_first(level)
            taken_back(level)
            floods(level)
            set_back(level)
            exceptions(level)
            over_budget(level)
            level.client.ask("shutdown")
        check("it ends with 0", level.server.wait(LONG) == 0)
        codels_of_genom3(work)
        level.output.seek(0)
        told = level.output.read()
        check("codels get inputs of what is accepted", "north.Go(99.5) gets {\"id\":3}\n" in told, told)
        check("and the request as the rule judged it", "north.Go(98.5) gets {\"speed\":98.5}\n" in told and "north.Go(97) gets {\"speed\":97}\n" in told and "( 98.5" not in told and "south.Mark gets bare" in told, told)
        check("and of nothing else", "too fast" not in told and "never" not in told, told)
    return finish("requests")


def refusals(level):
    """Before anything of it comes to the model."""
    for service, part in (("north.Stpo", "did you mean `north.Stop`?"), ("Mark", "did you mean `north.Mark` or `south.Mark`?"), ("north.Fly", "`north` has Go, Turn, Burst, Slow, Mark, Stop, Abort"),
                          ("battery.Use", "there are the modules north, south"), ("north.Go", "`north.Go(speed)`"), ("north.Go(1, 2)", "`north.Go(speed)`"),
                          ("north.Go(fast)", "`speed` is a number, not `fast`"), ("north.Go(nan)", "a number"), ("north.Go(3", "`north.Go(speed)`"), ("north.Stop(3)", "`north.Stop`"), ("", "there is no service")):
        said = level.refusal(service=service)
        check(f"`{service}` is refused", said and part in said, said)
    check("a mailbox takes no events", "`north_mail.request` takes no events" in (said := level.refusal("post", port="north_mail.request", values=["north.Stop", "", 1]) or ""), said)
    check("`service` is asked for", "`service` is missing" in level.refusal())
    check("an input is a text", "`input` is a text" in level.refusal(service="north.Stop", input=3))
    hello = level.client.ask("hello")
    told = {row["service"]: row for row in hello["services"]}
    check("hello tells of services", told["north.Go"] == {"service": "north.Go", "kind": "activity", "overtakes": False, "values": {"speed": "number"}}, told)
    check("who overtakes", [name for name, row in told.items() if row["overtakes"]] == ["north.Stop", "north.Abort", "south.Turn", "south.Stop", "south.Abort"], told)


def over_budget(level):
    """A codel that its task waits for takes longer than the side file says: the rule stops what runs, as soon as it has answered."""
    go = level.ask("north.Go(10)")
    check("it runs", level.accepted(go) == ("intermediate", "OK"), level.replies.get(go))
    check("what takes too long ends well itself", level.final(level.ask("north.Slow")) == "OK")
    check("and the rule has stopped the other", level.final(go) == "ACTIVITY_INTERRUPTED", level.replies.get(go))


def values(level):
    """Parameters are data: the rule's condition judges any value."""
    for value in ("300", "100.5", "1e3", "-51", "-50.5"):
        check(f"TOO-FAST speaks for {value}", level.final(level.ask(f"north.Go({value})", {"id": "too fast"})) == "TOO-FAST")
    go = level.ask("north.Go(99.5)", {"id": 3})
    check("99.5 is accepted", level.accepted(go) == ("intermediate", "OK"), level.replies)
    check("and runs", {"request": go, "service": "north.Go", "running": True} in level.client.ask("requests")["requests"])
    check("a stop ends", level.final(level.ask("north.Stop")) == "OK")
    check("and the activity", level.final(go) == "ACTIVITY_INTERRUPTED", level.replies)
    go = level.ask(" north.Go\t( 98.5 )", {"speed": 98.5})
    check("blanks do not matter", level.accepted(go) == ("intermediate", "OK") and level.final(level.ask("south.Mark( )", "bare")) == "OK", level.replies)
    check("also of a stop", level.final(level.ask(" north.Stop ()")) == "OK" and level.final(go) == "ACTIVITY_INTERRUPTED", level.replies)


def words(level):
    """Rules are about the words that they declare: another one would pass each of them."""
    for service, input in (("south.Slow(First)", ""), ("south.Slow(second)", ""), ("south.Slow(far~reverse)", ""), ("south.Slow(first|far reverse)", ""), ('south.Slow("first")', ""), ("south.Slow", {"gear": "second"})):
        said = level.refusal(service=service, input=input)
        check(f"`{service}` with {input} is refused", said and said.startswith("`gear` is one of first, far reverse, not `"), said)
    for service, input in (("south.Slow(first)", ""), ("south.Slow( far reverse )", ""), ("south.Slow", {"gear": "far reverse"})):
        check(f"`{service}` with {input} is accepted", level.final(level.ask(service, input)) == "OK", level.replies)


def one_value(level):
    """What the rule judges is what the codel gets: a second value for a parameter is refused, both are named."""
    for service, input, part in (("north.Go(20)", {"speed": 4000}, "`speed` is `20` in parentheses and `4000` in the input"), ("north.Go(4000)", '{"speed": 20}', "`4000` in parentheses and `20`"),
                                 ("north.Go(20)", '{"speed": 20, "speed": 4000}', "`4000` in the input"), ("north.Go(20)", "4000", "beside values in parentheses"), ("north.Go(20)", "[4000]", "beside values"),
                                 ("north.Go(20)", {"speed": "4000"}, '`speed` is a number, not `"4000"`'), ("north.Go", {"pace": 20}, "`north.Go(speed)`"), ("north.Go", "20", "`north.Go(speed)`"),
                                 ("north.Go(20)", '{"a":' + "[" * 20000 + "]" * 20000 + "}", "beside values")):
        said = level.refusal(service=service, input=input)
        check(f"`{service}` with {str(input)[:30]} is refused", said and part in said, said)
    check("the value of the input alone is judged", level.final(level.ask("north.Go", {"speed": 300})) == "TOO-FAST")
    go = level.ask("north.Go", {"speed": 97})
    check("and accepted", level.accepted(go) == ("intermediate", "OK"), level.replies.get(go))
    check("a stop ends it", level.final(level.ask("north.Stop")) == "OK" and level.final(go) == "ACTIVITY_INTERRUPTED", level.replies)


def codels_of_genom3(folder):
    """The same for codels that have their parameters by name."""
    work = pathlib.Path(folder, "arm")
    work.mkdir()
    (work / "arm.gen").write_text("""component arm {
  task main { period 10 ms; };
  activity go(in double speed, in long count = 3) { task main; codel<start> goStart(in speed, in count) yield ether; };
  activity turn(in double speed = 7., in long count = 0) { task main; codel<start> turnStart(in speed) yield ether; };
};
""", encoding="utf-8")
    (work / "arm.rules").write_text("""rules arm;
modules "arm.gen";
parameter speed of arm.go: 10, 20;
parameter count of arm.turn: 1, 2;
slow: arm.go requires request.speed <= 100 report "TOO-FAST";
few: arm.turn requires request.count <= 5 report "TOO-MANY";
""", encoding="utf-8")
    (work / "codels.c").write_text("""#include "acarm.h"
#include <stdio.h>
genom_event goStart(double speed, int32_t count, genom_context self) { (void)self; printf("go gets %g and %d\\n", speed, (int)count); fflush(stdout); return arm_ether; }
genom_event turnStart(double speed, genom_context self) { (void)self; printf("turn gets %g\\n", speed); fflush(stdout); return arm_ether; }
""", encoding="utf-8")
    made = subprocess.run([BIPC, "rules", "--served", "--codels", "codels.c", "arm.rules", "-o", "level.bip"], cwd=work, capture_output=True, text=True)
    check("they are translated", made.returncode == 0, made.stderr)
    level = Level(work)
    with level.client:
        for service, input, part in (("arm.go(20)", {"speed": 4000}, "`speed` is `20` in parentheses and `4000` in the input"), ("arm.go(4000)", {"speed": 20}, "`4000` in parentheses and `20`"),
                                     ("arm.go", {}, "`arm.go(speed)`"), ("arm.go", {"speed": "fast"}, "`speed` is a number"), ("arm.go(20)", "4000", "an input is an object"), ("arm.go(20)", {"pace": 1}, "there is no parameter `pace`")):
            said = level.refusal(service=service, input=input)
            check(f"`{service}` with {input} is refused", said and part in said, said)
        for service, input, report in (("arm.go(20)", {}, "OK"), ("arm.go(21)", "", "OK"), ("arm.go", {"speed": 22, "count": 4}, "OK"), ("arm.go(2.35e1)", {"speed": 23.5}, "OK"), ("arm.go", {"speed": 400}, "TOO-FAST"),
                                       ("arm.go(401)", {"count": 5}, "TOO-FAST"), ("arm.turn(2)", {"speed": 8}, "OK"), ("arm.turn(9)", "", "TOO-MANY")):
            check(f"`{service}` with {input}: {report}", (got := level.final(level.ask(service, input))) == report, got)
        level.client.ask("shutdown")
    check("it ends with 0", level.server.wait(LONG) == 0)
    level.output.seek(0)
    told = [line for line in level.output.read().splitlines() if " gets " in line]
    check("codels get what rules have judged", told == ["go gets 20 and 3", "go gets 21 and 3", "go gets 22 and 4", "go gets 23.5 and 3", "turn gets 8"], told)


def stops_first(level):
    """Of many requests a stop is answered first, and no older one begins what it told to stop."""
    busy = level.ask("north.Go(1)")
    level.accepted(busy)
    with level.stands_still():
        older = [level.ask(*request) for request in [("north.Go(1)", {"id": "never"}), ("north.Mark", "")] * 20]
        stop, other = level.ask("north.Stop"), level.ask("south.Mark")
        newer = level.ask("north.Go(2)")
    check("the stop comes through", level.final(stop) == "OK" and level.final(busy) == "ACTIVITY_INTERRUPTED", level.replies)
    check("another module does not wait", level.final(other) == "OK")
    # One or two were on their way into the module when the stop came.
    early = [n for n in older if n in level.order and level.order.index(n) < level.order.index(stop)]
    refused = {level.final(n) for n in older[0::2]}
    check("before the older ones", len([n for n in early if n in older[1::2]]) <= 2, early)
    check("which are not begun", refused <= {"ACTIVITY_INTERRUPTED", "TOO_MANY_ACTIVITIES"}, refused)
    check("what it does not stop goes on in order", [n for n in level.order if n in older[1::2]] == older[1::2] or not level.listen(lambda: set(older[1::2]) <= set(level.order)) or
          [n for n in level.order if n in older[1::2]] == older[1::2], level.order)
    # The activity that was told to stop may not have ended yet.
    check("a newer one is not stopped", level.accepted(newer) in (("intermediate", "OK"), ("final", "TOO_MANY_ACTIVITIES")), level.replies.get(newer))
    if level.accepted(newer)[0] == "final":
        check("and begins", level.accepted(level.ask("north.Go(2)")) == ("intermediate", "OK"), level.replies)
    level.final(level.ask("north.Stop"))
    with level.stands_still():
        waiting = [level.ask("south.Mark") for _ in range(20)]
        turn = level.ask("south.Turn")
    level.accepted(turn)
    check("the side file lets others overtake", len([n for n in level.order if n in waiting]) <= 2, level.order)
    level.final(waiting[-1])
    check("cancel ends an activity", level.refusal("cancel", request=turn) is None and level.final(turn) == "ACTIVITY_INTERRUPTED", level.replies.get(turn))


def taken_back(level):
    with level.stands_still():
        first = [level.ask("north.Mark") for _ in range(10)]
        late = level.ask("north.Turn", "never")
        taken = level.refusal("cancel", request=late)
    check("a request is taken back", taken is None and level.final(late) == "CANCELLED", level.replies.get(late))
    with level.stands_still():
        held = level.ask("south.Mark")
        said = level.refusal("cancel", request=held)
    check("also in the mailbox, if it is not decided", said is None and level.final(held) in ("CANCELLED", "OK") or "ask again" in (said or "") or "final reply" in (said or ""), said)
    check("others go on", [level.final(n) for n in first] == ["OK"] * 10)
    check("what is over is not", "has had its final reply" in level.refusal("cancel", request=first[0]))
    check("what never was is not", "there was no request 100000" in level.refusal("cancel", request=100000))
    check("a number is asked for", "`request` is a number" in level.refusal("cancel", request="x"))
    turn = level.ask("south.Turn")
    level.accepted(turn)
    with Client(level.path, LONG) as other:
        check("another client hears of all, if it wants", other.ask("subscribe", requests=True)["ok"])
        check("and sees what runs", [row["request"] for row in other.ask("requests")["requests"]] == [turn])
        check("and may end it", other.ask("cancel", request=turn)["ok"])
        told = [other.note() for _ in range(2)]
        check("it is told", [(n["note"], n["service"], n["report"]) for n in told if n["request"] == turn] == [("request", "south.Turn", "ACTIVITY_INTERRUPTED")], told)
    check("an activity that is not there", level.final(level.ask("south.Abort(Fly)")) == "UNKNOWN_ACTIVITY", level.replies)


def floods(level):
    """One client asks for more than its share: it is refused, others are not, and no stop is."""
    turn = level.ask("north.Turn")
    go = level.ask("north.Go(1)")
    check("two run", level.accepted(turn) == level.accepted(go) == ("intermediate", "OK"), level.replies)
    with contextlib.ExitStack() as several, Client(level.path, LONG) as crowd:
        with level.stands_still():
            taken, said = flood(crowd, "north.Mark")
            check("a flood is refused to who floods", 500 <= taken <= 502 and said == "full: 500 requests of this client wait for `north`, 500 in all", (taken, said))
            check("another client has its room", level.refusal(service="north.Mark") is None)
            many = [several.enter_context(Client(level.path, LONG)) for _ in range(12)]
            shares = [flood(client, "north.Mark")[0] for client in many]
            check("nor are others while many flood", min(shares) == 10 and sum(shares) < 1000 - taken + 10 * len(shares), shares)
            twenty, said = flood(crowd, "north.Stop")
            check("the same stop twenty times is enough", 20 <= twenty <= 22 and "full: 20 requests `north.Stop` of this client wait" in (said or ""), (twenty, said))
            check("another stop of this client is accepted", crowd.ask("request", service="north.Abort(Turn)")["ok"])
            stop = level.ask("north.Stop")
            abort = level.refusal(service="north.Abort(Nothing)")
            taken_back = level.refusal("cancel", request=turn)
            check("so is each of others: stop, Abort, cancel", stop and abort is None and taken_back is None, (abort, taken_back))
        check("the stop comes through", level.final(stop) == "OK" and level.final(go) == "ACTIVITY_INTERRUPTED", level.replies.get(go))
        # A reply to the first client tells of its own requests: how many of the flood came before is seen in what is open.
        check("before the flood", (rest := len(level.client.ask("requests")["requests"])) > 100, rest)
        check("the other activity ends", level.final(turn) in ("ACTIVITY_INTERRUPTED", "ZOMBIE_REMOVED", "ABORTED"), level.replies.get(turn))
    empties(level)
    with level.stands_still():
        # Each time as a new client: who has left keeps little.
        for _ in range(12):
            with Client(level.path, LONG) as crowd:
                flood(crowd, "north.Mark")
                flood(crowd, "north.Stop")
            check("most of what has left is gone", until(lambda: len(level.client.ask("requests")["requests"]) <= 104), len(level.client.ask("requests")["requests"]))
        check("and there is room", level.refusal(service="north.Mark") is None and level.refusal(service="north.Stop") is None)
    empties(level)


def flood(client, service):
    """How many are taken, and why no more."""
    for taken in range(3000):
        answer = client.ask("request", service=service)
        if not answer["ok"]:
            return taken, answer["error"]
    return 3000, None


def empties(level):
    check("then nothing waits", until(lambda: not level.client.ask("requests")["requests"]), level.client.ask("requests")["requests"][:3])


def set_back(level):
    saved = level.client.ask("snapshot")["snapshot"]
    level.final(level.ask("north.Mark"))
    check("it is set back", level.client.ask("restore", snapshot=saved)["ok"])
    check("and takes requests", level.final(level.ask("north.Mark")) == "OK")


def exceptions(level):
    """Of one codel: its activity fails, and whoever asked hears why; all others go on."""
    turn = level.ask("south.Turn")
    level.accepted(turn)
    burst = level.ask("north.Burst")
    check("an activity whose codel throws fails", level.final(burst) == "ACTIVITY_FAILED", level.replies.get(burst))
    check("its reply tells what was thrown", level.thrown.get(burst) == {"codel": "northBurst", "what": "no map"}, level.thrown)
    check("the other module's activity runs on", {"request": turn, "service": "south.Turn", "running": True} in level.client.ask("requests")["requests"])
    check("and takes requests", level.final(level.ask("south.Mark")) == "OK")
    check("its own module waits for the zombie to go", level.final(level.ask("north.Turn")) == "WAIT_ABORT_ZOMBIE_ACTIVITY")
    check("Abort removes it", level.final(level.ask("north.Abort(Burst)")) == "OK")
    again = level.ask("north.Turn")
    check("then it goes on as before", level.accepted(again) == ("intermediate", "OK"), level.replies.get(again))
    refused = level.ask("north.Burst", "refuse")
    check("a control codel that throws refuses", level.final(refused) == "CONTROL_CODEL_ERROR", level.replies.get(refused))
    check("and says why", level.thrown.get(refused) == {"codel": "northCheck", "what": 'a "map"\nis missing'}, level.thrown)
    other = level.ask("south.Burst")
    check("what is thrown need not be std::exception", level.final(other) == "ACTIVITY_FAILED" and level.thrown[other] == {"codel": "southBurst", "what": ""}, level.thrown)
    check("replies without one do not mention it", level.final(level.ask("north.Mark")) == "OK" and level.thrown[max(level.thrown)] is None)


if __name__ == "__main__":
    sys.exit(main())
