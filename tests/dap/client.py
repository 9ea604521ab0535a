"""A debug client for the tests: starts `bipc dap`, sends requests, receives responses and events. Python's library only."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from framed import BIPC, BUILD, ROOT, TIMEOUT, FramedProcess, Gone  # noqa: E402, F401


class Client(FramedProcess):
    def __init__(self, folder):
        super().__init__([BIPC, "dap"], folder)
        self.sequence = 0

    def send(self, command, arguments=None):
        self.sequence += 1
        message = {"seq": self.sequence, "type": "request", "command": command}
        if arguments is not None:
            message["arguments"] = arguments
        self.send_message(message)
        return self.sequence

    def end(self):
        self.process.stdin.close()
        return self.process.wait(TIMEOUT)
