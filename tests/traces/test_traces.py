#!/usr/bin/env python3
"""Traces for other tools, read back: MCAP by a reader of its own (mcap.py), Perfetto's as JSON, both against the JSON lines.

    tests/traces/test_traces.py [--limit N]

Of each run the same steps stand in all three: instants, interactions, ports, values. MCAP: every CRC, count and index. Perfetto: a
track a component, whose slices follow each other without gap from 0 to the end. The same of served models, which a client takes back to
a snapshot meanwhile. Python's library only.
"""
import argparse
import csv
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time
from decimal import Decimal

from mcap import Mcap

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(ROOT / "tools"))
sys.path.insert(0, str(ROOT / "tests"))
from patience import LONG, until  # noqa: E402
from serve_client import Client  # noqa: E402

BIPC = os.environ.get("BIPC") or str(pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or ROOT / "build") / "bipc")
RUNS = [["models/timed/heart_pacer.bip"], ["models/timed/two_rods.bip"], ["models/timed/producer_resume.bip"],
        ["models/classic/philosophers.bip"], ["models/classic/sensor_broadcast.bip"], ["models/classic/pipeline_std.bip"],
        ["models/bench/ring.bip", "--root", "Ring(300)"]]
SERVED = ["models/timed/heart_pacer.bip", "models/classic/sensor_broadcast.bip"]


def trace(arguments, limit, form, folder):
    path = folder / form
    done = subprocess.run([BIPC, "run", "--backend", "interp", "--seed", "5", "--limit", str(limit), "--silent", "--trace", str(path), "--trace-format", form,
                           str(ROOT / arguments[0]), *arguments[1:]], capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return path.read_bytes()


def served(model, limit, form, folder):
    """What `bipc serve` writes: half the steps, back to the first snapshot, all of them."""
    path, socket = folder / form, str(folder / "socket")
    server = subprocess.Popen([BIPC, "serve", "--backend", "interp", "--seed", "5", "--asap", "--speed", "1000", "--paused", "--socket", socket,
                               "--trace", str(path), "--trace-format", form, str(ROOT / model)])
    def connected():
        assert server.poll() is None, "serve has ended"
        try:
            return Client(socket, LONG)
        except (FileNotFoundError, ConnectionRefusedError):
            return None
    client = until(connected)
    assert client, "nobody listens"
    with client:
        def walk(count):
            before = client.ask("state", atoms=[])["steps"]
            assert client.ask("step", count=count)["ok"]
            while client.ask("state", atoms=[])["steps"] < before + count:
                time.sleep(0.01)
        first = client.ask("snapshot")["snapshot"]
        walk(limit // 2)
        assert client.ask("restore", snapshot=first)["ok"]
        walk(limit)
        assert client.ask("shutdown")["ok"]
    assert server.wait(LONG) == 0
    os.unlink(socket) if os.path.exists(socket) else None
    return path.read_bytes()


def instant(step):
    return step.get("time", step.get("step", step.get("steps")) * 1_000_000)


def check_mcap(data, steps, end):
    file = Mcap(data)
    wanted, parts = [], {}
    for step in steps:
        ports = [{"port": p["port"], "values": p.get("values", {})} for p in step["ports"]]
        wanted.append((instant(step), {"step": step["step"], "interaction": step["interaction"], "ports": ports}))
        for p in ports:
            component, port = p["port"].rsplit(".", 1)
            topic = "/" + component.removeprefix("ROOT.").replace(".", "/")
            parts.setdefault(topic, []).append((instant(step), step["step"], step["interaction"], port, p["values"]))
    by_topic = {}
    for topic, when, value in file.messages:
        by_topic.setdefault(topic, []).append((when, value))
    assert file.by_index() == by_topic, "the indexes find something else"
    assert by_topic.pop("/steps", []) == wanted, "/steps"
    ((when, value),) = by_topic.pop("/end")
    assert when == instant(end) and value["end"] == end["end"] and value["steps"] == end["steps"], "/end"
    found = {t: [(w, v["step"], v["interaction"], v["port"], v["values"]) for w, v in rows] for t, rows in by_topic.items()}
    assert found == parts, "components"
    assert all(isinstance(v["place"], str) and v["place"] for rows in by_topic.values() for _, v in rows)
    return len(file.chunks), len(file.channels)


def check_perfetto(data, steps, end):
    file = json.loads(data, parse_float=Decimal)
    names, slices, ports, interactions = {}, {}, [], []
    for e in file["traceEvents"]:
        if e["ph"] == "M":
            if e["name"] == "thread_name":
                names[e["tid"]] = e["args"]["name"]
            continue
        when = Decimal(e["ts"]) * 1000
        assert when == int(when)
        if e["ph"] == "X":
            slices.setdefault(e["tid"], []).append((int(when), int(Decimal(e["dur"]) * 1000), e["name"]))
        elif e["cat"] == "port":
            ports.append((int(when), e["args"]["step"], names[e["tid"]] + "." + e["name"], e["args"]["values"]))
        elif e["cat"] == "interaction":
            interactions.append((int(when), e["args"]["step"], e["name"]))
        else:
            assert e["cat"] == "end" and e["name"] == end["end"] and int(when) == instant(end)
    as_text = lambda v: json.dumps(v, sort_keys=True, default=str)
    wanted = [(instant(s), s["step"], p["port"], p.get("values", {})) for s in steps for p in s["ports"]]
    assert [(*p[:3], as_text(p[3])) for p in ports] == [(*p[:3], as_text(p[3])) for p in wanted], "ports"
    assert interactions == [(instant(s), s["step"], s["interaction"]) for s in steps], "interactions"
    assert names[0] == "interactions" and set(slices) == set(names) - {0}, "tracks"
    for rows in slices.values():
        at = 0
        for begin, length, place in rows:
            assert begin == at and length >= 0 and place
            at += length
        assert at == instant(end), "slices do not reach the end"
    return len(slices)


def check_converted(run, folder, steps, end):
    """`bipc trace`: the same bytes as the run's own trace; compressed the same messages; waves and tables with the same steps."""
    model, options = str(ROOT / run[0]), run[1:]

    def convert(name, *more, action="convert"):
        out = folder / name
        done = subprocess.run([BIPC, "trace", action, model, str(folder / "json"), "-o", str(out), *options, *more], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return out.read_bytes()
    assert convert("c.jsonl").splitlines()[1:-1] == (folder / "json").read_bytes().splitlines()[1:-1], "JSON lines"
    whole = convert("c.mcap")
    check_mcap(whole, steps, {**end, "end": json.loads(convert("c.jsonl").splitlines()[-1])["end"]})
    packed = convert("z.mcap", "--compress")
    check_mcap(packed, steps, {**end, "end": json.loads(convert("c.jsonl").splitlines()[-1])["end"]})
    assert len(packed) * 3 < len(whole) or len(steps) < 100, (len(packed), len(whole))
    rows = list(csv.DictReader(convert("c.csv").decode().splitlines()))
    assert [(int(r["step"]), "ROOT." + r["component"] + "." + r["port"]) for r in rows] == [(s["step"], p["port"]) for s in steps for p in s["ports"]], "CSV"
    assert [(int(r["step"]), int(r["instant_ns"])) for r in rows] == [(s["step"], s.get("time", 0)) for s in steps for _ in s["ports"]], "instants of the CSV"
    places, events = waves(convert("c.vcd").decode())
    known = {s["interaction"] for s in steps}
    assert [e for e in events] == [(s.get("time", s["step"] + 1), s["interaction"].removeprefix("ROOT.")) for s in steps if "." + s["interaction"] not in (".",) and s["interaction"].removeprefix("ROOT.") in {n for _, n in events}], "VCD"
    # Each component is last where the table says.
    last = {r["component"]: r["place"] for r in rows}
    assert all(places["ROOT." + c] == p.replace(" ", "_") for c, p in last.items()), "places of the VCD"
    return len(known)


def check_read_back(run, folder):
    """MCAP, plain and compressed, and Perfetto of the run become its JSON lines again; what is mutilated is refused or passed over, never more."""
    model, options = str(ROOT / run[0]), run[1:]
    lines, rng = (folder / "json").read_bytes(), random.Random(7)

    def bipc(*arguments):
        return subprocess.run([BIPC, "trace", *arguments[:1], model, *arguments[1:], *options], capture_output=True, timeout=LONG)

    for form, more in (("mcap", []), ("mcap", ["--compress"]), ("perfetto", [])):
        out, back = folder / "exported", folder / "back"
        done = bipc("convert", str(folder / "json"), "-o", str(out), "--format", form, *more)
        if more and b"libzstd" in done.stderr:
            continue
        assert done.returncode == 0, done.stderr
        done = bipc("convert", str(out), "-o", str(back), "--format", "json")
        assert done.returncode == 0, done.stderr
        assert back.read_bytes() == lines, form + ": another run comes back"
        whole = bytearray(out.read_bytes())
        for _ in range(6):
            bad = bytearray(whole)
            for _ in range(rng.randrange(1, 4)):
                at = rng.randrange(len(bad))
                if rng.random() < 0.3:
                    del bad[at:at + rng.randrange(1, 200)]
                else:
                    bad[at] = rng.randrange(256)
            (folder / "bad").write_bytes(bad)
            done = bipc("stats", str(folder / "bad"))
            assert done.returncode in (0, 1), (form, done.returncode, done.stderr[-500:])


def waves(text):
    """What a VCD says: the last place of each component, and (instant, interaction) of each event."""
    names, scopes, now, places, events = {}, [], 0, {}, []
    head, body = text.split("$enddefinitions $end\n")
    for line in head.splitlines():
        words = line.split()
        if words[0] == "$scope":
            scopes.append(words[2])
        elif words[0] == "$upscope":
            scopes.pop()
        elif words[0] == "$var":
            assert words[3] not in names, "an identifier twice"
            names[words[3]] = (words[1], ".".join(scopes), words[4])
    assert not scopes
    before = -1
    for line in body.splitlines():
        if line.startswith("#"):
            now = int(line[1:])
            assert now > before, "instants go back"
            before = now
        elif line[0] == "s":
            value, name = line[1:].split(" ")
            if names[name][2] == "place":
                places[names[name][1]] = value
        elif line[0] in "01" and names[line[1:]][0] == "event":
            events.append((now, names[line[1:]][2]))
        else:
            assert line[0] in "$br01", line
    return places, events


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--limit", type=int, default=400)
    limit = parser.parse_args().limit
    most_chunks = 0
    for k, run in enumerate(RUNS):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            # One of them long enough for several chunks.
            steps = 16 * limit if k == 0 else limit
            lines = [json.loads(line) for line in trace(run, steps, "json", folder).decode().splitlines()]
            exact = [json.loads(line, parse_float=Decimal) for line in (folder / "json").read_text().splitlines()]
            chunks, channels = check_mcap(trace(run, steps, "mcap", folder), lines[1:-1], lines[-1])
            tracks = check_perfetto(trace(run, steps, "perfetto", folder), exact[1:-1], exact[-1])
            check_converted(run, folder, lines[1:-1], lines[-1])
            check_read_back(run, folder)
            most_chunks = max(most_chunks, chunks)
            print(f"traces: {run[0]}: {len(lines) - 2} steps, {chunks} chunks, {channels} channels, {tracks} tracks")
            refused = subprocess.run([BIPC, "run", "--trace-format", "mcap", str(ROOT / run[0]), *run[1:]], capture_output=True, text=True)
            assert refused.returncode == 2 and "--trace-format=mcap needs --trace" in refused.stderr
    assert most_chunks > 1, "no file had two chunks"
    for model in SERVED:
        with tempfile.TemporaryDirectory() as folder:
            lines = [json.loads(line) for line in served(model, limit, "json", pathlib.Path(folder)).decode().splitlines()]
            assert len(lines) == limit // 2 + limit + 2 and lines[-1]["end"] == "interrupted", (len(lines), lines[-1])
            check_mcap(served(model, limit, "mcap", pathlib.Path(folder)), lines[1:-1], lines[-1])
            print(f"traces: {model}, served: {len(lines) - 2} steps")
    refused = subprocess.run([BIPC, "serve", "--trace", "/nowhere/at/all", str(ROOT / SERVED[0])], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    assert refused.returncode == 2 and "cannot write" in refused.stderr, refused.stderr
    print(f"traces: {2 * len(RUNS) + len(SERVED)} passed, 0 failed")


if __name__ == "__main__":
    try:
        main()
    except AssertionError as error:
        import traceback
        traceback.print_exc()
        sys.exit(f"traces: {error}")
