#!/usr/bin/env python3
"""Who gets a place at a served model (compiler/docs/serve.md): 64 clients of lower roles, idle ones or silent ones do not keep its owner
out, and what is idle or silent too long goes. As root also: another user is not let in although the socket's mode would.
"""
import atexit
import json
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time

from checks import BIPC, LONG, check, finish, until

MODEL = pathlib.Path(__file__).resolve().parent / "counter.bip"
NOBODY = 65534
PLACES, FOR_LOWER_ROLES = 64, 60


class Served:
    """A server at a Unix socket or at TCP, with options for its time limits."""

    def __init__(self, *options, tcp=False):
        self.folder = tempfile.mkdtemp()
        self.path = os.path.join(self.folder, "s")
        where = ["--port", "0"] if tcp else ["--socket", self.path]
        self.server = subprocess.Popen([BIPC, "serve", "--backend", "interp", *where, *options, str(MODEL)], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        atexit.register(self.server.kill)
        told = self.server.stderr.readline()
        assert "listening" in told, told
        self.tokens = {}
        if not tcp: return
        self.port = int(told.rsplit(":", 1)[1])
        for role in ("operator", "requester", "observer"):
            self.tokens[role] = re.search("([0-9a-f]{32})$", self.server.stderr.readline().strip()).group(1)

    def connect(self):
        if self.tokens: return socket.create_connection(("127.0.0.1", self.port), LONG)
        s = socket.socket(socket.AF_UNIX)
        s.settimeout(LONG)
        s.connect(self.path)
        return s

    def hello(self, role=None):
        """A connection that has said hello, and the answer; an empty one if there is none."""
        s = self.connect()
        return s, said(s, {"do": "hello", **({"token": self.tokens[role]} if role else {})})

    def end(self):
        self.server.terminate()
        self.server.wait(LONG)
        self.server.stderr.close()


def said(s, request):
    """What comes back; {} if the connection is closed."""
    try:
        s.sendall(json.dumps(request).encode() + b"\n")
        text = b""
        while not text.endswith(b"\n"):
            piece = s.recv(1 << 16)
            if not piece: return {}
            text += piece
        return json.loads(text.splitlines()[0])
    except OSError:
        return {}


def is_open(s):
    """Has the server not closed it?"""
    s.setblocking(False)
    try:
        return s.recv(1) != b""
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        s.settimeout(LONG)


# Observers at TCP, all of them at work: the operator comes in, and no more observers than there are places for them.
served = Served(tcp=True)
observers = [served.hello("observer") for _ in range(PLACES)]
for s, _ in observers[:FOR_LOWER_ROLES]: said(s, {"do": "subscribe"})
check("as many observers as have places are in", all(answer.get("ok") for _, answer in observers[:FOR_LOWER_ROLES]), [a.get("ok") for _, a in observers])
check("the others are told why not", all("all places for observers" in answer.get("error", "") for _, answer in observers[FOR_LOWER_ROLES:]), observers[-1][1])
operators = [served.hello("operator") for _ in range(PLACES - FOR_LOWER_ROLES)]
check("operators come in", all(answer.get("role") == "operator" for _, answer in operators), operators)
check("nobody at work has lost a place", all(is_open(s) for s, _ in observers[:FOR_LOWER_ROLES]))
observers[0][0].close()
check("a place that is given up is an observer's again", until(lambda: served.hello("observer")[1].get("ok")))
served.end()

# At a Unix socket all are the user's own: the idlest goes, not one that is at work.
served = Served()
first, answer = served.hello()
check("the first at the socket", answer.get("ok") and said(first, {"do": "subscribe"}).get("ok"), answer)
crowd = [served.hello() for _ in range(PLACES - 1)]
check("all places are taken", all(answer.get("ok") for _, answer in crowd))
late, answer = served.hello()
check("a new one at the socket need not wait", answer.get("ok"), answer)
check("the idlest has gone", not is_open(crowd[0][0]))
check("the others stay", is_open(first) and all(is_open(s) for s, _ in crowd[1:]))
served.end()

# At TCP a stranger takes no place of a client that was heard a moment ago, and takes one that is idle. A machine that needs longer than the limit to connect all gets a longer limit.
for idle_after in (1.5, 6, 24, 96):
    served = Served("--idle-after", f"{idle_after * 1000:.0f}ms", tcp=True)
    began = time.monotonic()
    operators = [served.hello("operator") for _ in range(PLACES)]
    stranger, answer = served.hello("operator")
    if time.monotonic() - began < idle_after: break
    served.end()
check("a stranger comes while nobody is idle yet", time.monotonic() - began < idle_after, idle_after)
check("and is not let in", answer == {}, answer)
time.sleep(idle_after + 0.5)
check("busy ones stay", said(operators[0][0], {"do": "state"}).get("ok"))
check("an idle one makes room", served.hello("operator")[1].get("ok"))
check("the idlest one", is_open(operators[0][0]) and sum(not is_open(s) for s, _ in operators) == 1)
served.end()

# Who says nothing is closed, who has said something is not.
served, patient = Served("--close-after", "500ms"), Served("--close-after", "3600s")
talker, answer = served.hello()
waits = patient.connect()
began = time.monotonic()
silent = served.connect()
check("a silent one is closed", silent.recv(1) == b"")
waited = time.monotonic() - began
check("not before its time", waited >= 0.5, waited)
time.sleep(2)  # longer than the server takes to look for silent ones again
check("nor where silence may last longer", is_open(waits))
check("a talker is not", answer.get("ok") and is_open(talker) and said(talker, {"do": "state"}).get("ok"))
served.end()
patient.end()
refused = subprocess.run([BIPC, "serve", "--close-after", "0", str(MODEL)], stdin=subprocess.DEVNULL, capture_output=True, text=True)
check("no limit of nothing", refused.returncode == 2 and "less than 1ms" in refused.stderr, refused)

# The peer's user counts, not the socket's mode.
def answer_to(user, path):
    """How many bytes another process, of this user, is told at the socket; -1: it could not connect."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        told = b"-1"
        try:
            os.setgroups([])
            os.setgid(user)
            os.setuid(user)
            s = socket.socket(socket.AF_UNIX)
            s.settimeout(LONG)
            s.connect(path)
            told = b"0"
            s.sendall(b'{"do":"hello"}\n')
            told = str(len(s.recv(4096))).encode()
        except OSError:
            pass
        os.write(writing, told)
        os._exit(0)
    os.close(writing)
    os.waitpid(child, 0)
    with open(reading) as pipe: return int(pipe.read())


if os.geteuid() == 0:
    served = Served()
    for path, mode in ((served.folder, 0o711), (served.path, 0o666)): os.chmod(path, mode)
    check("the user is answered", answer_to(0, served.path) > 0)
    told = answer_to(NOBODY, served.path)
    check("another user connects and is told nothing", told == 0, told)
    check("the server goes on", served.hello()[1].get("ok"))
    served.end()
else:
    print("skipped: only root can connect as another user")
sys.exit(finish("places"))
