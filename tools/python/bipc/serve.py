#!/usr/bin/env python3
"""A client of `bipc serve` (compiler/docs/serve.md), as a library and on the command line. Python's library only.

    python3 -m bipc.serve SOCKET|PORT:TOKEN '{"do":"hello"}' ...    sends the requests, prints the answers
    python3 -m bipc.serve SOCKET|PORT:TOKEN --watch                 subscribes and prints notes until the server ends

The server of a port prints its token when it begins.

    from bipc.serve import Client
    with Client("/tmp/model.sock") as model:
        model.ask("post", port="panel.turn", values={"level": 3})
"""
import json
import socket
import sys
import time


class Client:
    """A connection to a running model. After a time-out it can be used as before: what came in part is kept."""

    def __init__(self, where, timeout=10):
        port, _, token = str(where).partition(":")
        is_port = port.isdigit()
        self.timeout = timeout
        self.socket = socket.socket(socket.AF_INET if is_port else socket.AF_UNIX)
        self.socket.settimeout(timeout)
        self.socket.connect(("127.0.0.1", int(port)) if is_port else where)
        self.received = b""  # that is not a whole line yet
        self.next_id = 0
        self.notes = []  # that came while an answer was waited for
        if is_port:
            answer = self.ask("hello", token=token)
            if not answer["ok"]:
                raise ConnectionError(answer["error"])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def read(self, timeout=None):
        """The next line. Raises TimeoutError after `timeout` seconds (None: those of the constructor), ConnectionError at the server's end."""
        seconds = self.timeout if timeout is None else timeout
        end = None if seconds is None else time.monotonic() + seconds
        while b"\n" not in self.received:
            left = None if end is None else end - time.monotonic()
            if left is not None and left <= 0:
                raise TimeoutError(f"no line within {seconds} s")
            self.socket.settimeout(left)
            piece = self.socket.recv(65536)
            if not piece:
                raise ConnectionError("the server has gone")
            self.received += piece
        line, _, self.received = self.received.partition(b"\n")
        return json.loads(line)

    def ask(self, do, **more):
        """The answer as a dictionary; notes that come before it are kept. An answer that comes after its time-out is dropped."""
        self.next_id += 1
        self.socket.settimeout(self.timeout)
        self.socket.sendall(json.dumps({"id": self.next_id, "do": do, **more}).encode() + b"\n")
        while True:
            answer = self.read()
            # A connection that is refused is answered without a number.
            if answer.get("id") == self.next_id or answer.get("ok") is False and "id" not in answer:
                return answer
            if "id" not in answer:
                self.notes.append(answer)

    def note(self, timeout=None):
        """The next note. Raises TimeoutError after `timeout` seconds (None: those of the constructor)."""
        while not self.notes:
            line = self.read(timeout)
            if "id" not in line:
                return line
        return self.notes.pop(0)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    with Client(sys.argv[1], None if sys.argv[2] == "--watch" else 10) as model:
        if sys.argv[2] == "--watch":
            print(json.dumps(model.ask("subscribe")))
            while True:
                print(json.dumps(model.note()), flush=True)
        for text in sys.argv[2:]:
            print(json.dumps(model.ask(**json.loads(text))))


if __name__ == "__main__":
    main()
