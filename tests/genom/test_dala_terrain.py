#!/usr/bin/env python3
"""Dala's two ways of navigation, and a field of stones between it and its goal: with terrain.rules it gets there, without them it would topple.

    tests/genom/test_dala_terrain.py [--table]

As in test_dala_faults.py the rover is a process of its own (models/dala/mission/rover.cpp), and facts are judged by what it writes down, with no code of the controller's.
Two levels, fourteen modules under `bipc serve`, one of them without rules, go through three faults and then through models/dala/mission/terrain.txt. The mission has to be over, by laser and by
vision, with the rules; each fact has to hold with them and to be broken without them, else the test shows nothing. --table prints it only.
Python's library, and g++ for the rover. The last line is "terrain: N passed, N failed".
"""
import math
import subprocess
import sys

from test_dala_faults import DALA, DRIVEN, EXPOSES_PAIR, LASER_AGE, LONG, MAP_AGE, MOVES, NOW, TILT, V, VISION_AGE, X, Y, Level, go_together, judge

SHARP = 0.25    # m/s: above it pairs of images are blurred (mission/vision.hpp)
FOUND = 0.35    # s: so old is a reference that its module still writes
OLD = 2.0       # s: terrain.rules stop it after one
GOAL = (1, -8)  # of terrain.txt
SPEED = 2       # of the clock
PATIENCE = 10 * LONG  # for a mission of 65 s at that speed
# fact: unit, at most with rules, at least without
FACTS = {"pairs of images are asked for while it drives by laser": ("s blurred", 0.0, 1.0),
         "by laser as well, while it drives by vision": ("s with two references", 0.5, 2.0),
         "the cameras stop while it drives by vision": ("m on an old map", 0.0, 0.3),
         "the mission: a field of stones": ("degrees of tilt", 16.0, 20.0)}


def facts(rows, begin, end=1e9):
    """Of a piece of the record: seconds of blur, seconds with two references, metres on an old map, the largest tilt; metres by laser, by vision."""
    blurred = two = old = by_laser = by_vision = 0.0
    part = [r for r in rows if begin <= r[NOW] <= end]
    for before, row in zip(part, part[1:]):
        seconds, metres = row[NOW] - before[NOW], row[DRIVEN] - before[DRIVEN]
        laser, vision = row[LASER_AGE] < FOUND, row[VISION_AGE] < FOUND
        blurred += seconds if row[EXPOSES_PAIR] and row[V] > SHARP else 0
        two += seconds if laser and vision and abs(row[V]) > MOVES else 0
        old += metres if vision and row[MAP_AGE] > OLD else 0
        by_laser += metres if laser and not vision else 0
        by_vision += metres if vision and not laser else 0
    return blurred, two, old, math.degrees(max((r[TILT] for r in part), default=0)), by_laser, by_vision


class Rover(Level):
    RULES = ("dala.rules", "terrain.rules")
    ROVER = ("-5", "1", str(SPEED))
    KEPT = ("--stall-after", "2s")
    PACE = ("--speed", str(SPEED))

    pairs = None  # the request for them that runs

    def shut(self):
        self.do("VIAM.StopAcquire")
        if self.pairs is not None and not self.ended(self.pairs):
            raise AssertionError("the cameras do not stop")

    def look(self):
        self.shut()
        self.pairs = self.must("VIAM.AcquireContinuous(Pairs)")
        self.listen(1)

    def must(self, text):
        """It is accepted."""
        number = self.do(text)
        if self.replies[number][0]["report"] != "OK":
            raise AssertionError(f"{text}: {self.replies[number]}")
        return number

    def moves(self, speed):
        if not self.listen(LONG, lambda: self.rows()[-1][V] > speed):
            raise AssertionError(f"it does not drive: {self.log()[-500:]}")

    def go(self):
        names, found = iter(FACTS), {}
        self.begin()
        for text in ("Stereo.Init", "DTM.Init", "P3D.Init"):
            self.ended(self.do(text))
        self.must("P3D.SetSpeed(0.15)")
        self.must("Stereo.CorrelateContinuous")
        self.must("DTM.FuseContinuous")

        self.look()
        self.shut()
        self.must("RFLEX.TrackSpeedStart")
        self.must("NDD.GoTo 20 1")
        self.moves(0.3)
        begin = self.now()
        asked = self.do("VIAM.AcquireContinuous(Pairs)")
        self.pairs = None if self.is_kept else asked
        self.listen(1.5)
        found[next(names)] = facts(self.rows(), begin)[0]
        self.do("NDD.Stop")
        self.stand()

        self.look()
        self.must("P3D.GoTo 6 1")
        self.must("RFLEX.TrackSpeedStart")
        self.moves(0.1)
        begin = self.now()
        self.ask("NDD.GoTo 20 1")
        self.listen(2)
        found[next(names)] = facts(self.rows(), begin)[1]
        self.do("NDD.Stop")
        self.do("P3D.Stop")
        self.stand()

        self.look()
        self.must("P3D.GoTo 6 1")
        self.must("RFLEX.TrackSpeedStart")
        self.moves(0.1)
        begin = self.now()
        self.shut()
        self.listen(4)
        found[next(names)] = facts(self.rows(), begin)[2]
        self.do("P3D.Stop")
        self.stand()

        begin = self.now()
        problem = self.mission()
        rows = self.rows()
        *_, tilt, by_laser, by_vision = facts(rows, begin)
        found[next(names)] = tilt
        far = math.hypot(rows[-1][X] - GOAL[0], rows[-1][Y] - GOAL[1])
        if self.is_kept and (problem or far > 0.6 or by_laser < 1.5 or by_vision < 3):
            raise AssertionError(f"the mission: {far:.2f} m from its goal, {by_laser:.1f} m by laser, {by_vision:.1f} m by vision {problem}")
        return found

    def mission(self):
        """Why it was not a success; empty if it was. Without rules nothing is asked that they refuse, so that it gets as far."""
        lines = (DALA / "mission/terrain.txt").read_text(encoding="utf-8").splitlines()
        mission = self.work / "mission.txt"
        mission.write_text("\n".join(line for line in lines if self.is_kept or not line.startswith("  refused ")), encoding="utf-8")
        try:
            done = subprocess.run([sys.executable, str(DALA / "mission/executive.py"), str(self.socket), str(mission)], capture_output=True, text=True, timeout=PATIENCE)
        except subprocess.TimeoutExpired as late:
            return f"is not over: {(late.stdout or b'').decode()[-1500:]}"
        return done.stdout[-1500:] + done.stderr if done.returncode else ""


def measure(work):
    """{fact: (with rules, without)}"""
    found = go_together(("kept", "free"), lambda name: Rover(work / name, name == "kept"), lambda _, rover: rover.go())
    return {fact: (found["kept"][fact], found["free"][fact]) for fact in FACTS}


if __name__ == "__main__":
    sys.exit(judge("terrain", __doc__.splitlines()[0], FACTS, "rules", measure))
