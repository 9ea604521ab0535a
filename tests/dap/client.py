"""A debug client for the tests: starts `bipc dap`, sends requests, receives responses and events. Python's library only."""
import json
import os
import pathlib
import queue
import subprocess
import threading

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = pathlib.Path(os.environ.get("BIPC") or BUILD / "bipc")
TIMEOUT = 60


class Gone(Exception):
    """The adapter ended, or did not answer in time."""


class Client:
    def __init__(self, folder):
        self.process = subprocess.Popen([str(BIPC), "dap"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=folder)
        self.inbox = queue.Queue()
        self.sequence = 0
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        out = self.process.stdout
        while True:
            length = None
            while True:
                line = out.readline()
                if not line:
                    self.inbox.put(None)
                    return
                if line == b"\r\n":
                    break
                key, _, value = line.decode().partition(":")
                if key.lower() == "content-length":
                    length = int(value)
            self.inbox.put(json.loads(out.read(length)))

    def raw(self, data):
        self.process.stdin.write(data)
        self.process.stdin.flush()

    def send(self, command, arguments=None):
        self.sequence += 1
        message = {"seq": self.sequence, "type": "request", "command": command}
        if arguments is not None:
            message["arguments"] = arguments
        body = json.dumps(message).encode()
        self.raw(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        return self.sequence

    def receive(self):
        try:
            message = self.inbox.get(timeout=TIMEOUT)
        except queue.Empty:
            raise Gone("no answer in time") from None
        if message is None:
            raise Gone(f"the adapter ended with {self.process.wait()}")
        return message

    def end(self):
        self.process.stdin.close()
        return self.process.wait(TIMEOUT)
