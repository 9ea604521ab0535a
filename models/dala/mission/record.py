#!/usr/bin/env python3
"""Writes what a served Dala does as an MCAP file with Foxglove's schemas: an observer of `bipc serve`, beside the executive.

    models/dala/mission/record.py SOCKET FILE.mcap [--rate HZ] [--compress]

/log (foxglove.Log) has each reply to a request, and what the watchdog says. With --rate also, so often a second: /rover/pose
(foxglove.PoseInFrame), /rover/path (foxglove.PosesInFrame, where it was, once a second), /rover/scan (foxglove.LaserScan, each scan once, from where the
rover is), /diagnostics (diagnostic_msgs/DiagnosticArray: the requests that run)
and /poster/MODULE.POSTER (what it holds). Instants are the model's. Prints a line when it listens: what happens from then on is in the file. Ends
when the server ends; the file is whole then. --compress: chunks in Zstandard's format, by the system's libzstd. Python's library only.
"""
import argparse
import ctypes
import json
import math
import pathlib
import signal
import struct
import sys
import time
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent.parent / "tools"))
from serve_client import Client  # noqa: E402

POSTERS = ("NDD.Speed", "Heating.Temperature", "Battery.State")
INFO, WARNING, ERROR = 2, 3, 4


def struct_of(**properties):
    return {"type": "object", "properties": properties}


NUMBER, TEXT, WHOLE = {"type": "number"}, {"type": "string"}, {"type": "integer"}
TIME = struct_of(sec=WHOLE, nsec=WHOLE)
POSE = struct_of(position=struct_of(x=NUMBER, y=NUMBER, z=NUMBER), orientation=struct_of(x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER))
ROS_TIME = struct_of(sec=WHOLE, nanosec=WHOLE)
STATUS = struct_of(level=WHOLE, name=TEXT, message=TEXT, hardware_id=TEXT, values={"type": "array", "items": struct_of(key=TEXT, value=TEXT)})
SCHEMAS = {
    "foxglove.Log": struct_of(timestamp=TIME, level=WHOLE, message=TEXT, name=TEXT, file=TEXT, line=WHOLE),
    "foxglove.PoseInFrame": struct_of(timestamp=TIME, frame_id=TEXT, pose=POSE),
    "foxglove.PosesInFrame": struct_of(timestamp=TIME, frame_id=TEXT, poses={"type": "array", "items": POSE}),
    "foxglove.LaserScan": struct_of(timestamp=TIME, frame_id=TEXT, pose=POSE, start_angle=NUMBER, end_angle=NUMBER, ranges={"type": "array", "items": NUMBER},
                                    intensities={"type": "array", "items": NUMBER}),
    "diagnostic_msgs/DiagnosticArray": struct_of(header=struct_of(stamp=ROS_TIME, frame_id=TEXT), status={"type": "array", "items": STATUS}),
    "dala.Poster": struct_of(),
}


def text(words):
    data = words.encode()
    return struct.pack("<I", len(data)) + data


def record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


def zstd_compressor():
    """The function that makes a frame (RFC 8878) of bytes."""
    try:
        library = ctypes.CDLL("libzstd.so.1")
    except OSError as problem:
        sys.exit(f"record.py: --compress needs libzstd: {problem}")
    library.ZSTD_compressBound.restype = library.ZSTD_compress.restype = ctypes.c_size_t
    library.ZSTD_compressBound.argtypes = [ctypes.c_size_t]
    library.ZSTD_compress.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int]
    library.ZSTD_isError.argtypes = [ctypes.c_size_t]

    def compress(data):
        bound = library.ZSTD_compressBound(len(data))
        out = ctypes.create_string_buffer(bound)
        size = library.ZSTD_compress(out, bound, data, len(data), 3)
        if library.ZSTD_isError(size):
            sys.exit("record.py: libzstd does not compress a chunk")
        return out.raw[:size]
    return compress


class McapFile:
    """The format's version 0 (mcap.dev): one chunk for each 256 KiB, indexes, a summary. compress: of the chunks, zstd; None: they are not."""

    CHUNK = 1 << 18

    def __init__(self, path, compress=None):
        self.compress = compress
        self.file, self.at, self.crc = open(path, "wb"), 0, 0
        self.schemas, self.channels, self.rows, self.counts = {}, {}, [], {}
        self.chunks, self.open, self.index = [], b"", {}
        self.instants = []
        self.put(b"\x89MCAP0\r\n" + record(1, text("") + text("models/dala")))

    def put(self, data):
        self.file.write(data)
        self.at += len(data)
        self.crc = zlib.crc32(data, self.crc)

    def write(self, topic, schema, instant, value):
        if schema not in self.schemas:
            self.schemas[schema] = len(self.schemas) + 1
            content = json.dumps(SCHEMAS[schema]).encode()
            self.row(3, struct.pack("<H", self.schemas[schema]) + text(schema) + text("jsonschema") + struct.pack("<I", len(content)) + content)
        if topic not in self.channels:
            self.channels[topic] = len(self.channels) + 1
            self.row(4, struct.pack("<HH", self.channels[topic], self.schemas[schema]) + text(topic) + text("json") + struct.pack("<I", 0))
        channel = self.channels[topic]
        self.index.setdefault(channel, []).append((instant, len(self.open)))
        self.open += record(5, struct.pack("<HIQQ", channel, self.counts.get(channel, 0), instant, instant) + json.dumps(value).encode())
        self.counts[channel] = self.counts.get(channel, 0) + 1
        self.instants = [min([instant, *self.instants[:1]]), max([instant, *self.instants[1:]])]
        if len(self.open) > self.CHUNK:
            self.close_chunk()

    def row(self, opcode, content):
        self.rows.append((opcode, record(opcode, content)))
        self.open += self.rows[-1][1]

    def close_chunk(self):
        instants = [instant for rows in self.index.values() for instant, _ in rows]
        if not instants:
            return
        first, last, begin = min(instants), max(instants), self.at
        packed, compression = (self.compress(self.open), text("zstd")) if self.compress else (self.open, text(""))
        self.put(record(6, struct.pack("<QQQI", first, last, len(self.open), zlib.crc32(self.open)) + compression + struct.pack("<Q", len(packed)) + packed))
        size, where = self.at - begin, {}
        for channel, rows in sorted(self.index.items()):
            where[channel] = self.at
            self.put(record(7, struct.pack("<HI", channel, 16 * len(rows)) + b"".join(struct.pack("<QQ", *row) for row in rows)))
        offsets = b"".join(struct.pack("<HQ", *row) for row in where.items())
        self.chunks.append(record(8, struct.pack("<QQQQI", first, last, begin, size, len(offsets)) + offsets + struct.pack("<Q", self.at - begin - size) + compression +
                                  struct.pack("<QQ", len(packed), len(self.open))))
        self.open, self.index = b"", {}

    def close(self):
        self.close_chunk()
        self.put(record(15, struct.pack("<I", self.crc)))
        begin = self.at
        counts = b"".join(struct.pack("<HQ", *row) for row in self.counts.items())
        statistics = struct.pack("<QHIIIIQQI", sum(self.counts.values()), len(self.schemas), len(self.channels), 0, 0, len(self.chunks), *(self.instants or [0, 0]), len(counts)) + counts
        groups = [(opcode, b"".join(data for o, data in self.rows if o == opcode)) for opcode in (3, 4)]
        groups += [(11, record(11, statistics)), (8, b"".join(self.chunks))]
        summary, offsets = b"", b""
        for opcode, data in groups:
            if data:
                offsets += record(14, struct.pack("<BQQ", opcode, begin + len(summary), len(data)))
                summary += data
        footer = struct.pack("<BQQQ", 2, 20, begin, begin + len(summary))
        summary += offsets + footer
        self.put(summary + struct.pack("<I", zlib.crc32(summary)) + b"\x89MCAP0\r\n")
        self.file.close()


class Recorder:
    def __init__(self, level, file, rate):
        self.level, self.file, self.rate = level, file, rate
        self.path, self.next_path, self.scan = [], 0, None

    @staticmethod
    def stamp(ns):
        return {"sec": ns // 10**9, "nsec": ns % 10**9}

    def log(self, ns, level, name, message):
        self.file.write("/log", "foxglove.Log", ns, {"timestamp": self.stamp(ns), "level": level, "message": message, "name": name, "file": "", "line": 0})

    def note(self, note, now):
        if note["note"] == "request":
            is_final, report = note["reply"] == "final", note["report"]
            detail = f" ({note['exception'].get('what', '')})" if "exception" in note else ""
            self.log(note["time"], INFO if report == "OK" else WARNING, note["service"], ("ended: " if is_final else "accepted: ") + report + detail)
        elif note["note"] != "step":
            self.log(now, ERROR, "bipc serve", note.get("text", note["note"]))

    def poster(self, name):
        answer = self.level.ask("poster", poster=name)
        return answer.get("value") if answer["ok"] else None

    def look(self):
        """Poses, posters and what runs, at the model's instant."""
        now = self.level.ask("state", atoms=["ROOT.masterTimer"])["time"]
        place = self.poster("POM.Pos")
        if place:
            p = place["data"]
            pose = {"position": {"x": p["x"], "y": p["y"], "z": 0}, "orientation": {"x": 0, "y": 0, "z": math.sin(p["theta"] / 2), "w": math.cos(p["theta"] / 2)}}
            self.file.write("/rover/pose", "foxglove.PoseInFrame", now, {"timestamp": self.stamp(now), "frame_id": "map", "pose": pose})
            if now >= self.next_path:
                self.path.append(pose)
                self.next_path = now + 10**9
                self.file.write("/rover/path", "foxglove.PosesInFrame", now, {"timestamp": self.stamp(now), "frame_id": "map", "poses": self.path})
            scan = self.poster("LaserRF.Scan")
            if scan and scan != self.scan:
                self.scan, ranges = scan, scan["data"]
                end = 2 * math.pi * (len(ranges) - 1) / len(ranges)
                self.file.write("/rover/scan", "foxglove.LaserScan", now, {"timestamp": self.stamp(now), "frame_id": "map", "pose": pose, "start_angle": 0, "end_angle": end,
                                                                           "ranges": ranges, "intensities": []})
        for name in POSTERS:
            value = self.poster(name)
            if value is not None:
                self.file.write("/poster/" + name, "dala.Poster", now, value)
        rows = [{"level": 0, "name": row["service"], "message": "runs" if row["running"] else "waits", "hardware_id": "rover", "values": [{"key": "request", "value": str(row["request"])}]}
                for row in self.level.ask("requests")["requests"]]
        self.file.write("/diagnostics", "diagnostic_msgs/DiagnosticArray", now, {"header": {"stamp": {"sec": now // 10**9, "nanosec": now % 10**9}, "frame_id": ""}, "status": rows})
        return now

    def run(self):
        self.level.ask("hello", role="observer")
        self.level.ask("subscribe", requests=True)
        print("recording", flush=True)
        now, due = self.level.ask("state", atoms=["ROOT.masterTimer"])["time"], time.monotonic()
        while True:
            if self.rate and time.monotonic() >= due:
                due = max(due + 1 / self.rate, time.monotonic())
                now = self.look()
            try:
                note = self.level.note(timeout=max(0.001, due - time.monotonic()) if self.rate else 1)
            except TimeoutError:
                continue
            now = note.get("time", now)
            self.note(note, now)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("socket")
    arguments.add_argument("file")
    arguments.add_argument("--rate", type=float, default=0)
    arguments.add_argument("--compress", action="store_true", help="chunks in Zstandard's format")
    options = arguments.parse_args()

    def end(*_):
        raise KeyboardInterrupt
    signal.signal(signal.SIGTERM, end)
    file = McapFile(options.file, zstd_compressor() if options.compress else None)
    try:
        with Client(options.socket, 60) as level:
            Recorder(level, file, options.rate).run()
    except (ConnectionError, KeyboardInterrupt):
        pass
    finally:
        file.close()


if __name__ == "__main__":
    main()
