#!/usr/bin/env python3
"""What `models/dala/run --record` writes (models/dala/mission/record.py), read by the strict reader of MCAP (mcap.py): a short mission with a
refusal and an exception, and a drive. Python's library only."""
import math
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests/traces"))
sys.path.insert(0, str(ROOT / "tests/serve"))
sys.path.insert(0, str(ROOT / "tests/genom"))
from checks import check, finish  # noqa: E402
from mcap import Mcap  # noqa: E402
from test_mission import pace  # noqa: E402

MISSION = """procedure mission
  do POM.Init
  do RFLEX.Init
  do NDD.Init
  do Hueblob.Init
  refused NDD.GoTo 3 1 gets PARAMS-OR-SPEED-NOT-SET
  do Hueblob.SetHue throw gets ACTIVITY_FAILED
  do LaserRF.Init
  start LaserRF.StartAcquisition
  sleep 1
  do RFLEX.GotoPosition 1 0
"""


def main():
    with tempfile.TemporaryDirectory(prefix="record-") as work:
        mission, file = os.path.join(work, "mission.txt"), os.path.join(work, "m.mcap")
        pathlib.Path(mission).write_text(MISSION, encoding="utf-8")
        ran = subprocess.run([sys.executable, str(ROOT / "models/dala/run"), "--mission", mission, "--record", file, "--compress", "--speed", f"{pace():.2f}"], capture_output=True, text=True)
        check("the mission", ran.returncode == 0, ran.stdout + ran.stderr)
        data = pathlib.Path(file).read_bytes()
    read = Mcap(data)
    check("chunks are compressed", all(c["compression"] == "zstd" and c["packed"] < len(c["inner"]) / 2 for c in read.chunks))
    topics = {}
    for topic, instant, value in read.messages:
        topics.setdefault(topic, []).append((instant, value))
    schemas = {topic: read.schemas[schema][0] for topic, schema, _ in read.channels.values()}
    check("topics and their schemas", schemas == {"/log": "foxglove.Log", "/rover/pose": "foxglove.PoseInFrame", "/rover/path": "foxglove.PosesInFrame", "/rover/scan": "foxglove.LaserScan",
                                                  "/diagnostics": "diagnostic_msgs/DiagnosticArray", "/poster/NDD.Speed": "dala.Poster",
                                                  "/poster/Heating.Temperature": "dala.Poster", "/poster/Battery.State": "dala.Poster"}, schemas)
    log = [(value["name"], value["message"], value["level"]) for _, value in topics["/log"]]
    check("what is accepted is in the log", ("POM.Init", "accepted: OK", 2) in log and ("POM.Init", "ended: OK", 2) in log, log)
    check("what is refused", ("NDD.GoTo", "ended: PARAMS-OR-SPEED-NOT-SET", 3) in log, log)
    check("what throws", ("Hueblob.SetHue", "ended: ACTIVITY_FAILED (no such hue)", 3) in log, log)
    places = [value["pose"]["position"]["x"] for _, value in topics["/rover/pose"]]
    check("the rover drives", places[0] == 0 and 0.8 < places[-1] < 1.1 and len(set(places)) > 5, places)
    check("its path is where it was", len(topics["/rover/path"][-1][1]["poses"]) == len(topics["/rover/path"]) > 1)
    scans = [value for _, value in topics["/rover/scan"]]
    first = scans[0]["ranges"]
    # A disc of radius 0.35 at (2, 0.1), seen from the origin; nothing is behind the rover.
    check("a scan is what the laser sees", len(first) == 72 and abs(first[0] - (2 - math.sqrt(0.35**2 - 0.1**2))) < 0.001 and first[36] == 4, first)
    check("its rays go round", scans[0]["start_angle"] == 0 and abs(scans[0]["end_angle"] - 2 * math.pi * 71 / 72) < 1e-9)
    check("scans come from where the rover is, each once", 5 < len(scans) and scans[-1]["pose"]["position"]["x"] > 0.5 and scans[-1]["ranges"][0] < 1.2, scans[-1])
    check("what runs is in the diagnostics", any(row["name"] == "RFLEX.GotoPosition" for _, value in topics["/diagnostics"] for row in value["status"]))
    check("stamps are instants", all(value["timestamp"]["sec"] * 10**9 + value["timestamp"]["nsec"] == instant for instant, value in topics["/rover/pose"]))
    check("the indexes lead to all", sum(len(rows) for rows in read.by_index().values()) == len(read.messages))
    print(f"{len(data)} bytes, {len(read.messages)} messages")
    return finish("record")


if __name__ == "__main__":
    sys.exit(main())
