"""A language client for the tests: starts bipc-lsp, sends and receives. Python's library only."""
import bisect
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from framed import BIPC, BUILD, ROOT, TIMEOUT, FramedProcess, Gone  # noqa: E402, F401

SERVER = BIPC.parent / "bipc-lsp"


class Client(FramedProcess):
    def __init__(self):
        super().__init__([SERVER, "--stdio"])
        self.pending = []
        self.next_id = 0
        self.checked = 0  # diagnostics that were looked at

    def processor_seconds(self):
        """What the server has used so far, without other processes."""
        return int(pathlib.Path(f"/proc/{self.process.pid}/schedstat").read_text().split()[0]) / 1e9

    def send(self, message):
        self.send_message(message)

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
