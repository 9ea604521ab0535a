#!/usr/bin/env python3
"""The live page of `bipc view --port`: what a page can do, and what nobody else can.

    tests/view/test_live.py

The deadlock of the philosophers is opened, walked back to the first wrong decision, another choice is taken and the run
goes on. Then breakpoints, expressions, time, events, reasons, traces; two pages on one session; and requests that are
not those of the page: other origins, other hosts, no token, unsound ones, too large ones, too many. The same in a browser is test_page.py.
"""
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import time

from web_client import LONG, Page, Run, Served
from patience import PATIENCE, until

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = os.environ.get("BIPC") or str(BUILD / "bipc")
MODELS = ROOT / "models"
PHILOSOPHERS = MODELS / "classic/philosophers.bip"
passed, failed = 0, 0


def check(what, is_so, *shown):
    global passed, failed
    passed, failed = (passed + 1, failed) if is_so else (passed, failed + 1)
    if not is_so:
        print(f"FAILED {what}:", *(str(s)[:600] for s in shown))



def deadlock(folder):
    dead = folder / "dead.json"
    done = subprocess.run([BIPC, "verify", "--trace", str(dead), str(PHILOSOPHERS)], capture_output=True, text=True)
    check("verify finds the deadlock", done.returncode == 3, done.stderr)
    with Served(BIPC, "--trace", dead, PHILOSOPHERS) as served:
        page, run = Page(served), Run()
        check("the page's own socket opens", page.status.startswith("HTTP/1.1 101"), page.status)
        run.follow([page.message()])
        check("the breakpoints are told", page.message() == {"note": "breakpoints", "texts": []})
        length = len(run.steps)
        check("the run is the trace", length == 5 and run.end and len(run.end["cycle"]) > 2, run.steps, run.end)
        why = page.ask("why", at=length, name="")
        check("the deadlock is explained", why["ok"] and "cycle: " in why["text"], why)
        # The last state in which something else than the recorded step is possible.
        at = max(k for k in range(length) if k == 0 or run.candidates[k]["count"] > 1)
        check("there is a decision to take back", 0 < at < length, at)
        here = [run.names[row] for row in run.candidates[at]["rows"]]
        other = next(k for k, name in enumerate(here) if name.replace("ROOT.", "") != run.texts()[at])
        taken = page.ask("take", at=at, candidate=other)
        run.follow(page.notes)
        check("another choice is taken", taken["ok"] and taken["position"] == at + 1 and len(run.steps) == at + 1 and run.steps[at][1] == here[other], taken, run.steps)
        check("it is no deadlock any more", run.end is None and run.candidates[at + 1]["count"] > 0, run.end)
        walk = page.ask("walk", at=at + 1, count=20)
        run.follow(page.notes)
        check("the run goes on", walk["ok"] and len(run.steps) > at + 1, walk, len(run.steps))
        check("its end is where it says", len(run.steps) == at + 21 or run.end is not None, walk)

        # The session's trace is one that others read.
        saved = page.ask("save", at=len(run.steps))
        trace = folder / "saved.jsonl"
        trace.write_text(saved["trace"], encoding="utf-8")
        stepped = subprocess.run([BIPC, "step", "--trace", str(trace), str(PHILOSOPHERS)], input="q\n", capture_output=True, text=True)
        check("the saved trace is that run", stepped.returncode == 0 and f"at {len(run.steps)}" in stepped.stdout, stepped.stdout, stepped.stderr)
        page.close()
    check("the server ends well", served.code == 0, served.code)


def driving():
    with Served(BIPC, "--seed", "7", PHILOSOPHERS) as served:
        page, run = Page(served), Run()
        run.follow([page.message()])
        page.message()
        check("a breakpoint is set", page.ask("breakpoints", texts=["table.phil[0]@EATS", "nobody@EATS"])["problems"][0] == "", page.notes)
        check("all pages hear of it", page.notes[-1] == {"note": "breakpoints", "texts": ["table.phil[0]@EATS"]}, page.notes)
        problems = page.ask("breakpoints", texts=["table.phil[0]@EATS", "nobody@EATS"])["problems"]
        check("a wrong one is refused with the reason", problems[0] == "" and "nobody" in problems[1], problems)
        page.notes.clear()
        ran = page.ask("run", at=0, until="")
        run.follow(page.notes)
        check("the run stops there", "breakpoint table.phil[0]@EATS" in ran["halt"] or run.end is not None, ran)
        at = ran["position"]
        if run.end is None:
            watch = page.ask("watch", at=at, texts=["table.phil[0]@EATS", "table.phil[0]@EATS && false", "nobody"])
            check("expressions are evaluated", watch["values"][0] == ["true", True] and watch["values"][1] == ["false", True] and watch["values"][2][1] is False, watch)
            check("and in other states", page.ask("watch", at=0, texts=["table.phil[0]@EATS"])["values"] == [["false", True]])
        page.ask("breakpoints", texts=[])
        reached = page.ask("run", at=0, until="table.phil[1]@EATS")
        run.follow(page.notes)
        check("a run to a condition", "reached table.phil[1]@EATS" in reached["halt"] or run.end is not None, reached)
        why = page.ask("why", at=0, name="table.right[0]")
        check("why not", why["ok"] and "take_right" in why["text"], why)
        check("why: an unknown name", page.ask("why", at=0, name="nobody") == {"id": page.next, "ok": False, "error": "there is no connector and no port `nobody`"})
        check("why: no deadlock", not page.ask("why", at=0, name="")["ok"])
        check("a candidate that is none", page.ask("take", at=0, candidate=99)["error"] == "there is no candidate 99")
        check("a position that is none", "position" in page.ask("take", at=9999, candidate=0)["error"])
        check("a wrong target", "nobody" in page.ask("run", at=0, until="nobody@X")["error"])
        check("no time in this model", "no time" in page.ask("delay", at=0, time="1s")["error"])
        page.notes.clear()

        # Two pages, one session: both have the same run.
        second, other = Page(served), Run()
        other.follow([second.message()])
        second.message()
        check("the second page gets the run so far", other.steps == run.steps and other.names == run.names)
        again = page.ask("take", at=0, candidate=2)
        run.follow(page.notes)
        other.follow([second.message()])
        check("both see the step that one took", again["ok"] and len(run.steps) == 1 and other.steps == run.steps and other.names == run.names, run.steps, other.steps)

        page.close()
        second.close()
    # A model whose run has no end, so that a walk is still there when it is stopped, and has its limit.
    with Served(BIPC, MODELS / "timed/train_gate.bip") as served:
        page, run = Page(served), Run()
        run.follow([page.message()])
        page.message()
        initial = page.ask("later", at=0)
        check("what comes later is told", initial["ok"] and isinstance(initial["later"], list), initial)
        passed_time = page.ask("delay", at=0, time="+1ns")
        check("time passes, or may not", passed_time["ok"] or "time" in passed_time["error"], passed_time)
        check("a text that is no time", "an instant is" in page.ask("delay", at=0, time="soon")["error"])
        page.notes.clear()
        page.ask("walk", at=0, count=0)
        run.follow(page.notes)
        page.next += 1
        page.send_frame(f'{{"id": {page.next}, "do": "walk", "at": 0, "count": 100000000}}'.encode())
        walk = page.next
        run.follow([page.message()])
        second = Page(served)
        follower = Run()
        check("a page comes while the model runs", second.status.startswith("HTTP/1.1 101"))
        refused = second.ask("take", at=0, candidate=0)
        check("while it runs nothing else moves it", refused.get("error", "").startswith("the model runs"), refused)
        check("it is stopped by another page", second.ask("stop")["ok"])
        while (message := page.message()).get("id") != walk:
            run.follow([message])
        check("the walk's answer says so", message["ok"] and message["halt"] in ("stopped", "a live page holds 100000 steps") and message["position"] == len(run.steps) > 0, message, len(run.steps))
        follower.follow(second.notes)
        check("the late page has the same run", follower.steps == run.steps and follower.names == run.names, len(follower.steps), len(run.steps))
        page.close()
        time.sleep(0.1)
        check("the server goes on without the page", second.ask("watch", at=0, texts=["1 + 1"])["values"] == [["2", True]])
        second.close()


def events():
    """Time and events from outside: the turnstile opens for a coin."""
    with Served(BIPC, MODELS / "timed/turnstile.bip") as served:
        page, run = Page(served), Run()
        run.follow([page.message()])
        page.message()
        delay = page.ask("delay", at=0, time="+5ms")
        run.follow(page.notes)
        check("time passes", delay["ok"] and len(run.steps) == 1 and run.steps[0][4] == 5000000, delay, run.steps)
        check("not back", "not after now" in page.ask("delay", at=1, time="1ms")["error"])
        coin = page.ask("post", at=1, port="arm.coin", values="50")
        run.follow(page.notes)
        check("an event is delivered", coin["ok"] and len(run.steps) == 2 and "arm.coin" in run.steps[1][1], coin, run.steps)
        check("a port that is none", not page.ask("post", at=0, port="nobody", values="")["ok"])
        check("values that do not fit", not page.ask("post", at=0, port="arm.coin", values="true false")["ok"])
        check("values that are no text", not page.ask("post", at=0, port="arm.coin", values=3)["ok"])
        page.ask("walk", at=2, count=1)
        run.follow(page.notes)
        check("the coin is taken", len(run.steps) == 3 and run.steps[2][3], run.steps)
        page.close()
    # Events of a file come before the step that the policy chooses: each is a move, and a state to go to.
    with tempfile.TemporaryDirectory() as made:
        coins = pathlib.Path(made) / "coins.jsonl"
        coins.write_text("".join(f'{{"time": {at}, "port": "arm.coin", "values": [50]}}\n' for at in (1_000_000, 9_000_000)), encoding="utf-8")
        with Served(BIPC, "--events", coins, MODELS / "timed/turnstile.bip") as served:
            page, run = Page(served), Run()
            run.follow([page.message()])
            page.message()
            walk = page.ask("walk", at=0, count=2)
            run.follow(page.notes)
            check("a walk counts its events", walk["ok"] and walk["position"] == 4 == len(run.steps), walk, run.steps)
            check("each event is a row", [run.steps[k][1].endswith("arm.coin") for k in (0, 2)] == [True] * 2 and all(run.steps[k][3] for k in (1, 3)), run.steps)
            check("between them a coin may be taken", run.candidates[1]["count"] > 0, run.candidates)
            again = page.ask("walk", at=walk["position"], count=1)
            run.follow(page.notes)
            check("it goes on from there", again["ok"] and again["position"] == 5 == len(run.steps), again, run.steps)
            check("and from between", page.ask("watch", at=1, texts=["arm.total", "arm.paid"])["values"] == [["0", True]] * 2)
            page.close()


def strangers():
    with Served(BIPC, PHILOSOPHERS) as served:
        page = served.get(f"/{served.token}/")
        check("the page is served", page.startswith("HTTP/1.1 200") and "connect-src ws://127.0.0.1:" in page, page[:300])
        head = page.split("\r\n\r\n")[0].lower()
        check("no other origin may read it", "access-control" not in head and "x-frame-options: deny" in head and "no-referrer" in head and "no-store" in head, head)
        check("one request a connection", "connection: close" in head, head)
        path = f"/{served.token}/"
        wrong = "/" + "0" * 32 + "/"
        refused = {
            "no token": served.get("/"), "a wrong token": served.get(wrong), "half a token": served.get(path[:17] + "/"), "another file": served.get(path + "x"),
            "a token in other words": served.get("/x" + path), "a name for 127.0.0.1": served.get(path, host=f"evil.example:{served.port}"),
            "another port": served.get(path, host="127.0.0.1:1"), "no host": served.request(f"GET {path} HTTP/1.1\r\n\r\n"),
            "two hosts": served.get(path, more=f"Host: {served.host}\r\n"), "POST": served.get(path, method="POST"), "OPTIONS": served.get(path, method="OPTIONS", more="Origin: http://evil.example\r\n"),
            "a body": served.get(path, more="Content-Length: 3\r\n") + "", "an old version": served.request(f"GET {path} HTTP/1.0\r\nHost: {served.host}\r\n\r\n"),
            "two requests at once": served.request(f"GET {path} HTTP/1.1\r\nHost: {served.host}\r\n\r\n" * 2), "chunks": served.get(path, more="Transfer-Encoding: chunked\r\n"),
        }
        for what, answer in refused.items():
            check("refused: " + what, (answer == "" or answer.startswith("HTTP/1.1 4")) and "<svg" not in answer and "Access-Control" not in answer, answer[:200])
        check("no text at all", served.request(b"\x16\x03\x01\x00\xa5hello\r\n\r\n") == "")
        check("a head that is too large", "200" not in served.get(path, more="X: " + "y" * 20000 + "\r\n")[:15])
        for what, options in {"another origin": {"origin": "http://evil.example"}, "no origin": {"origin": ""}, "a file's origin": {"origin": "null"}, "the origin by https": {"origin": f"https://{served.host}"},
                              "another port's origin": {"origin": "http://127.0.0.1:1"}, "a wrong token": {"path": wrong + "live"}, "no token": {"path": "/live"},
                              "a name for 127.0.0.1": {"host": f"evil.example:{served.port}", "origin": f"http://evil.example:{served.port}"}}.items():
            socket = Page(served, **options)
            check("no socket for " + what, socket.status.startswith("HTTP/1.1 4"), socket.status)
            socket.close()
        for what, payload, opcode in [("no JSON", b"hello", 1), ("no object", b"[1]", 1), ("an unknown verb", b'{"id":1,"do":"shutdown"}', 1), ("no number", b'{"do":"stop"}', 1),
                                      ("a negative number", b'{"id":1,"do":"take","at":-1,"candidate":0}', 1), ("a text for a number", b'{"id":1,"do":"take","at":"0","candidate":0}', 1),
                                      ("a number for a text", b'{"id":1,"do":"why","at":0,"name":3}', 1), ("too deep", b'{"id":1,"do":' + b"[" * 60000, 1), ("bytes", b'{"id":1,"do":"stop"}', 2),
                                      ("too long", b'{"id":1,"do":"why","at":0,"name":"' + b"x" * 70000 + b'"}', 1), ("too many texts", b'{"id":1,"do":"watch","at":0,"texts":[' + b'"a",' * 200 + b'"a"]}', 1),
                                      ("no UTF-8", b'\xff\xfe{"id":1}', 1)]:
            socket = Page(served)
            check("a message ends the connection: " + what, socket.is_closed_after(payload, opcode))
            socket.close()
        socket = Page(served)
        check("the session is there after all that", socket.ask("watch", at=0, texts=["1"])["values"] == [["1", True]])
        check("no step was taken", all(note.get("from") == 0 and note.get("steps") == [] for note in socket.notes if note.get("note") == "run"), socket.notes)
        socket.close()

        # Connections that say nothing take no place for ever, and there are only so many.
        silent = [served.connect() for _ in range(40)]
        for s in silent:
            s.setblocking(False)
        check("one connection too many is closed", until(lambda: sum(map(is_closed, silent)) >= 20), sum(map(is_closed, silent)))
        check("those that say nothing keep nobody out", served.get(path).startswith("HTTP/1.1 200"))
        for s in silent:
            s.close()
        check("and there is room again", until(lambda: served.get(path).startswith("HTTP/1.1 200")))
        # A page that goes in the middle of a message.
        socket = Page(served)
        socket.socket.sendall(b"\x81\xfe\x10\x00")
        socket.close()
        check("half a message hurts nobody", served.get(path).startswith("HTTP/1.1 200"))
    check("the server ends well", served.code == 0, served.code)
    with Served(BIPC, PHILOSOPHERS) as first:
        taken = subprocess.run([BIPC, "view", "--port", str(first.port), str(PHILOSOPHERS)], capture_output=True, text=True, timeout=LONG)
        check("a port that is taken", taken.returncode == 2 and "cannot listen" in taken.stderr, taken)
    both = subprocess.run([BIPC, "view", "--port", "0", "-o", "x.html", str(PHILOSOPHERS)], capture_output=True, text=True, timeout=LONG)
    check("a page is written or served", both.returncode == 2 and "--port" in both.stderr, both)
    with Served(BIPC, PHILOSOPHERS) as interrupted:
        interrupted.process.send_signal(signal.SIGINT)
        check("Ctrl-C ends it", interrupted.process.wait(LONG) == 0, interrupted.process.returncode)


def is_closed(s):
    """Has the server closed it? Nothing that it sent is waited for."""
    try:
        return s.recv(1) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True


def ticks(pid):
    return sum(int(x) for x in pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13])


def surroundings():
    # UBSan needs files of its own.
    if PATIENCE == 1:
        with Served(BIPC, PHILOSOPHERS, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (16, 16))) as served:
            crowd = [served.connect() for _ in range(30)]
            time.sleep(0.3)
            before = ticks(served.process.pid)
            time.sleep(1)
            spent = ticks(served.process.pid) - before
            check("more connections than files: nothing spins", spent < 15, f"{spent} ticks of the processor in a second")
            check("and the page is served", served.get(f"/{served.token}/").startswith("HTTP/1.1 200"))
            for s in crowd:
                s.close()
    with Served(BIPC, PHILOSOPHERS, stdin=subprocess.PIPE) as started:
        check("it stays while its parent's pipe is open", started.get(f"/{started.token}/").startswith("HTTP/1.1 200"))
        started.process.stdin.close()
        check("it ends with its parent's pipe", ends(started.process) == 0, started.process.poll())
    with open("/dev/full", "w") as full:
        nobody = subprocess.Popen([BIPC, "view", "--port", "0", str(PHILOSOPHERS)], stdin=subprocess.DEVNULL, stdout=full, stderr=subprocess.PIPE, text=True)
        code, said = ends(nobody), nobody.stderr.read()
        check("an address that nobody hears is not served", code == 74 and "cannot write `standard output`" in said, code, said)


def ends(process):
    """Its exit code; None if it goes on, and is ended then."""
    try:
        return process.wait(LONG)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return None


with tempfile.TemporaryDirectory() as name:
    deadlock(pathlib.Path(name))
    driving()
    events()
    strangers()
    surroundings()
print(f"live: {passed} passed, {failed} failed")
sys.exit(1 if failed else 0)
