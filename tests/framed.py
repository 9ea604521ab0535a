"""A program that speaks in frames with a Content-Length, as language servers and debug adapters do. Python's library only."""
import json
import os
import pathlib
import queue
import subprocess
import threading

from patience import LONG as TIMEOUT

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = pathlib.Path(os.environ.get("BIPC") or BUILD / "bipc")


class Gone(Exception):
    """The program ended, or did not answer in time."""


class FramedProcess:
    def __init__(self, command, folder=None):
        self.process = subprocess.Popen([str(word) for word in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=folder)
        self.inbox = queue.Queue()
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

    def send_message(self, message):
        body = json.dumps(message).encode()
        self.raw(b"Content-Length: %d\r\n\r\n" % len(body) + body)

    def receive(self):
        try:
            message = self.inbox.get(timeout=TIMEOUT)
        except queue.Empty:
            raise Gone("no answer in time") from None
        if message is None:
            raise Gone(f"the program ended with {self.process.wait()}")
        return message
