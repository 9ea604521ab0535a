#!/usr/bin/env python3
"""A client of `bipc serve` (compiler/docs/serve.md), as a library and on the command line. Python's library only.

    tools/serve_client.py SOCKET|PORT:TOKEN '{"do":"hello"}' ...    sends the requests, prints the answers
    tools/serve_client.py SOCKET|PORT:TOKEN --watch                 subscribes and prints notes until the server ends

The server of a port prints its token when it begins.

    with Client("/tmp/model.sock") as model:
        model.ask("post", port="panel.turn", values={"level": 3})
"""
import json
import socket
import sys


class Client:
    def __init__(self, where, timeout=10):
        port, _, token = str(where).partition(":")
        is_port = port.isdigit()
        self.socket = socket.socket(socket.AF_INET if is_port else socket.AF_UNIX)
        self.socket.settimeout(timeout)
        self.socket.connect(("127.0.0.1", int(port)) if is_port else where)
        self.lines = self.socket.makefile("rb")
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

    def read(self):
        line = self.lines.readline()
        if not line:
            raise ConnectionError("the server has gone")
        return json.loads(line)

    def ask(self, do, **more):
        """The answer as a dictionary; notes that come before it are kept."""
        self.next_id += 1
        self.socket.sendall(json.dumps({"id": self.next_id, "do": do, **more}).encode() + b"\n")
        while True:
            answer = self.read()
            # A connection that is refused is answered without a number.
            if answer.get("id") == self.next_id or answer.get("ok") is False and "id" not in answer:
                return answer
            self.notes.append(answer)

    def note(self):
        return self.notes.pop(0) if self.notes else self.read()


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
