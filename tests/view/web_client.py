"""A client of `bipc view --port`: HTTP and WebSocket by hand, so that unsound requests can be made too."""
import base64
import json
import os
import pathlib
import re
import socket
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from patience import LONG  # noqa: E402


class Served:
    """A live page over a model; `host`, `port`, `token` of its address."""

    def __init__(self, bipc, *arguments, **more):
        self.process = subprocess.Popen([bipc, "view", "--port", "0", *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)
        self.address = self.process.stdout.readline().strip()
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/([0-9a-f]{32})/", self.address)
        assert found, self.address + self.process.stderr.read()
        self.port, self.token = int(found[1]), found[2]
        self.host = f"127.0.0.1:{self.port}"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.code = self.process.wait(LONG)
        self.process.stdout.close()
        self.process.stderr.close()

    def connect(self):
        return socket.create_connection(("127.0.0.1", self.port), timeout=LONG)

    def request(self, text):
        """Sends bytes; returns what comes until the server closes."""
        with self.connect() as s:
            s.sendall(text if isinstance(text, bytes) else text.encode())
            out = b""
            try:
                while part := s.recv(1 << 16):
                    out += part
            except ConnectionError:
                pass
            return out.decode(errors="replace")

    def get(self, path, host=None, more="", method="GET"):
        return self.request(f"{method} {path} HTTP/1.1\r\nHost: {host or self.host}\r\n{more}\r\n")


class Model:
    """`bipc serve` of a model at a socket, or at a port with its three tokens."""

    def __init__(self, bipc, model, *options, port=False):
        self.folder = tempfile.TemporaryDirectory()
        self.where = os.path.join(self.folder.name, "s")
        self.process = subprocess.Popen([bipc, "serve", "--backend", "interp", *(["--port", "0"] if port else ["--socket", self.where]), *options, str(model)],
                                        stderr=subprocess.PIPE, text=True)
        line = self.process.stderr.readline()
        assert "listening" in line, line + self.process.stderr.read()
        self.tokens = []
        if port:
            self.where = re.search(r":(\d+)$", line.strip())[1]
            self.tokens = [self.process.stderr.readline().split()[-1] for _ in range(3)]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(LONG)
        self.process.stderr.close()
        self.folder.cleanup()


class Page:
    """A WebSocket, as a page of this origin opens it; `status`: the answer's first line."""

    def __init__(self, served, origin=None, path=None, host=None):
        self.socket = served.connect()
        self.buffer = b""
        self.next = 0
        self.notes = []
        origin = f"http://{served.host}" if origin is None else origin
        head = (f"GET {path or '/' + served.token + '/live'} HTTP/1.1\r\nHost: {host or served.host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}\r\nSec-WebSocket-Version: 13\r\n" + (f"Origin: {origin}\r\n" if origin else "") + "\r\n")
        self.socket.sendall(head.encode())
        while b"\r\n\r\n" not in self.buffer:
            part = self.socket.recv(4096)
            if not part:
                break
            self.buffer += part
        self.status, _, self.buffer = self.buffer.partition(b"\r\n\r\n")
        self.status = self.status.split(b"\r\n")[0].decode()

    def read(self, count):
        while len(self.buffer) < count:
            part = self.socket.recv(1 << 16)
            if not part:
                raise ConnectionError("closed")
            self.buffer += part
        out, self.buffer = self.buffer[:count], self.buffer[count:]
        return out

    def send_frame(self, payload, opcode=1):
        mask = os.urandom(4)
        length = len(payload)
        head = bytes([0x80 | opcode]) + (bytes([0x80 | length]) if length < 126 else bytes([0xFE]) + struct.pack(">H", length) if length < 65536 else bytes([0xFF]) + struct.pack(">Q", length))
        self.socket.sendall(head + mask + bytes(b ^ mask[k % 4] for k, b in enumerate(payload)))

    def message(self):
        """The next message as JSON; pings are passed over."""
        whole = b""
        while True:
            first, second = self.read(2)
            length = second & 127
            if length == 126:
                length = struct.unpack(">H", self.read(2))[0]
            elif length == 127:
                length = struct.unpack(">Q", self.read(8))[0]
            payload = self.read(length)
            if first & 15 == 8:
                raise ConnectionError("closed")
            if first & 15 == 9:
                continue
            whole += payload
            if first & 0x80:
                return json.loads(whole)

    def ask(self, verb, **fields):
        """The answer; notes that come before it go to `notes`."""
        self.next += 1
        self.send_frame(json.dumps({"id": self.next, "do": verb, **fields}).encode())
        while True:
            message = self.message()
            if message.get("id") == self.next:
                return message
            self.notes.append(message)

    def is_closed_after(self, payload, opcode=1):
        self.send_frame(payload, opcode)
        try:
            while True:
                self.message()
        except (ConnectionError, OSError):
            return True

    def close(self):
        self.socket.close()


class Run:
    """The run as a page has it, from its notes."""

    def __init__(self):
        self.steps, self.candidates, self.names, self.end = [], [None], [], None

    def follow(self, notes):
        for note in notes:
            if note.get("note") != "run":
                continue
            at = note["from"]
            self.steps[at:] = note["steps"]
            self.candidates[at + 1:] = note["candidates"]
            self.names[note["names_from"]:] = note["names"]
            self.end = note["end"]
        notes.clear()

    def texts(self):
        return [step[1].replace("ROOT.", "") for step in self.steps]
