"""A language client for the tests: starts bipc-lsp, sends and receives. Python's library only."""
import bisect
import json
import os
import pathlib
import queue
import subprocess
import threading

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build")
BIPC = pathlib.Path(os.environ.get("BIPC") or BUILD / "bipc")
SERVER = BIPC.parent / "bipc-lsp"
TIMEOUT = 60


class Gone(Exception):
    """The server ended, or did not answer in time."""


class Client:
    def __init__(self):
        self.process = subprocess.Popen([str(SERVER), "--stdio"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.inbox = queue.Queue()
        self.pending = []
        self.next_id = 0
        self.checked = 0  # diagnostics that were looked at
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

    def send(self, message):
        body = json.dumps(message).encode()
        self.raw(b"Content-Length: %d\r\n\r\n" % len(body) + body)

    def receive(self):
        try:
            message = self.inbox.get(timeout=TIMEOUT)
        except queue.Empty:
            raise Gone("no answer in time") from None
        if message is None:
            raise Gone(f"the server ended with {self.process.wait()}")
        return message

    def notify(self, method, params):
        self.send({"jsonrpc": "2.0", "method": method, "params": params})

    def call(self, method, params=None):
        """The whole answer: {"result": …} or {"error": …}. Notifications that come before are kept in `pending`."""
        self.next_id += 1
        self.send({"jsonrpc": "2.0", "id": self.next_id, "method": method, "params": params})
        while True:
            message = self.receive()
            if message.get("id") == self.next_id:
                return message
            self.pending.append(message)

    def result(self, method, params=None):
        answer = self.call(method, params)
        if "result" not in answer:
            raise AssertionError(f"{method}: {answer['error']}")
        return answer["result"]

    def error(self, method, params=None):
        answer = self.call(method, params)
        return answer.get("error", {}).get("code")

    def diagnostics(self, uri, version=None):
        """The next diagnostics of the document (of that version)."""
        while True:
            message = self.pending.pop(0) if self.pending else self.receive()
            params = message.get("params", {})
            self.checked += message.get("method") == "textDocument/publishDiagnostics"
            if message.get("method") == "textDocument/publishDiagnostics" and params["uri"] == uri and version in (None, params.get("version")):
                return params["diagnostics"]

    def start(self, encodings=("utf-16",), **more):
        answer = self.result("initialize", {"processId": None, "rootUri": None, "capabilities": {"general": {"positionEncodings": list(encodings)}}, **more})
        self.notify("initialized", {})
        return answer

    def open(self, uri, text, version=1):
        self.notify("textDocument/didOpen", {"textDocument": {"uri": uri, "languageId": "bip", "version": version, "text": text}})

    def change(self, uri, version, changes):
        self.notify("textDocument/didChange", {"textDocument": {"uri": uri, "version": version}, "contentChanges": changes})

    def at(self, method, uri, line, character, **more):
        return self.result("textDocument/" + method, {"textDocument": {"uri": uri}, "position": {"line": line, "character": character}, **more})

    def stop(self):
        """The exit code after an orderly end."""
        self.result("shutdown")
        self.notify("exit", None)
        self.process.stdin.close()
        return self.process.wait(TIMEOUT)


def lines_of(text):
    """Begin of each line, as the protocol cuts them: \\n, \\r\\n, \\r."""
    starts = [0]
    for i, c in enumerate(text):
        if c == "\n" or (c == "\r" and text[i + 1:i + 2] != "\n"):
            starts.append(i + 1)
    return starts


def utf16(text):
    return len(text.encode("utf-16-le", "surrogatepass")) // 2


def position(text, index, encoding="utf-16"):
    """Of a character's index; an index inside a line break is the end of the line."""
    starts = lines_of(text)
    line = bisect.bisect_right(starts, index) - 1
    end = len(text)
    if line + 1 < len(starts):
        end = starts[line + 1] - 1
        if end > starts[line] and text[end - 1:end + 1] == "\r\n":
            end -= 1
    part = text[starts[line]:min(index, end)]
    return {"line": line, "character": utf16(part) if encoding == "utf-16" else len(part.encode())}
