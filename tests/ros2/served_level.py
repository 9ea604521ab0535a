"""What the tests of both bridges share: programs whose output is read, a served level with its bridge, the component that they serve."""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests/serve"))
from checks import BIPC, LONG  # noqa: E402


class Program:
    """A process whose output is read until a line comes."""

    def __init__(self, command, work, log):
        self.log = pathlib.Path(work, log)
        self.file = open(self.log, "a", encoding="utf-8")
        self.begin = self.log.stat().st_size
        self.process = subprocess.Popen(command, cwd=work, stdout=self.file, stderr=self.file)

    def text(self):
        return self.log.read_text(encoding="utf-8")[self.begin:]

    def until(self, words, seconds=LONG):
        end = time.monotonic() + seconds
        while words not in self.text():
            if self.process.poll() is not None or time.monotonic() > end:
                return False
            time.sleep(0.01)
        return True

    def end(self, how=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(how)
        code = self.process.wait(LONG)
        self.file.close()
        return code


class ServedLevel:
    """A served level and its bridge. `command`: the bridge's, with its descriptions."""

    def __init__(self, work, command, serve_options=()):
        self.work, self.command, self.options = work, command, serve_options
        self.socket = os.path.join(tempfile.mkdtemp(prefix="ros-"), "s")
        self.serve()
        self.bridge_again()

    def serve(self):
        self.server = Program([BIPC, "serve", *self.options, "--socket", self.socket, "m.bip"], self.work, "serve.log")
        assert self.server.until("listening", 5 * LONG), self.server.text()

    def bridge_again(self):
        self.bridge = Program([*self.command, "--serve", self.socket, "--rate", "50"], self.work, "bridge.log")
        assert self.bridge.until("connected to"), self.bridge.text()

    def close(self):
        code = self.bridge.end()
        self.server.end()
        shutil.rmtree(os.path.dirname(self.socket), ignore_errors=True)
        return code


def translate_track(work):
    for source in sorted((ROOT / "tests/genom/track").iterdir()):
        (shutil.copytree if source.is_dir() else shutil.copy)(source, os.path.join(work, source.name))
    codels = [word for name in ("track_codels.c", "track_more.cc") for word in ("--codels", "codels/" + name)]
    made = subprocess.run([BIPC, "genom", "--served", *codels, "track.gen", "eye.gen", "-o", "m.bip"], cwd=work, capture_output=True, text=True)
    assert made.returncode == 0, made.stdout + made.stderr
