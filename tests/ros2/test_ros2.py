#!/usr/bin/env python3
"""`bipc ros2` between `bipc serve` and a client of ROS 2 actions that is written from the specifications over Fast DDS (client.cpp).

    tests/ros2/test_ros2.py [component|mission]      without a word: both

`component`: a GenoM 3 component with codels in C: members of goals and results, refusals, cancellations, topics, type hashes, and either side that
dies and comes back. `mission`: models/dala through a plan (dala.plan), whose effects are checked in what the simulated rover writes down (world.path).
Nothing but the loopback is used. Times are printed; the median of refusals is checked, too, with a bound that grows with the load of the machine. Python's library only.
"""
import os
import pathlib
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(ROOT / "tests/serve"))
sys.path.insert(0, str(HERE))
from checks import BIPC, LONG, check, finish, until  # noqa: E402
from ros_client import ABORTED, CANCELED, SUCCEEDED, Goal, RosClient  # noqa: E402
from served_level import ServedLevel, translate_track  # noqa: E402

BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or pathlib.Path(BIPC).resolve().parent)
CLIENT = BUILD / "ros2_client"
DOMAIN = 20 + os.getpid() % 200
EMPTY = "B:0"  # a message without members has this one, structure_needs_at_least_one_member
VERBS = ("do", "start", "refused", "repeat", "unknown", "lose", "await", "cancel", "kill", "sleep", "stands", "drives", "say")
PERIOD_MS = 20.0  # of the control task


class Level(ServedLevel):
    """A served level, its bridge, a client."""

    def __init__(self, work, files, serve_options=()):
        super().__init__(work, [BIPC, "ros2", *files, "--domain", str(DOMAIN)], serve_options)
        self.client = RosClient(CLIENT, DOMAIN)

    def close(self):
        self.client.close()
        return super().close()


# ---- a component of GenoM 3

def path_of(*points):
    return [f"i:{len(points)}", *(f"d:{number}" for point in points for number in point)]


def goals(level):
    client = level.client
    for action, type, result in (("track/follow", "TrackFollow", "diss"), ("track/set_gains", "TrackSetGains", "ss"), ("track/set_speed", "TrackSetSpeed", "ss"),
                                 ("track/remember", "TrackRemember", "ss"), ("track/get_note", "TrackGetNote", "sss"), ("track/chase", "TrackChase", "ss"),
                                 ("eye/watch", "EyeWatch", "ss")):
        check(f"there is an action {action}", client.add_action(action, "track_msgs/" + type, result))
    check("what ROS 2 has no type for is left out", "warning[B6130]: service `weigh` is left out: `track_shape` is a union" in level.bridge.text(), level.bridge.text())

    square = path_of((0.02, 0), (0.02, 0.02), (0, 0))
    goal = client.goal("track/follow", *square, "d:0.001", "i:2")
    check("a goal is accepted", client.answer(goal) is True)
    check("and succeeds", client.result(goal)[0] == SUCCEEDED, goal.result)
    check("with its outputs", goal.result and abs(goal.result[0] - 2 * (0.04 + 0.02 * 2 ** 0.5)) < 0.01 and goal.result[1:] == [0, "OK", ""], goal.result)
    check("the status is published", client.until(lambda: client.statuses.get("track/follow", {}).get(goal.id) == SUCCEEDED), client.statuses)
    check("and the intermediate reply", client.until(lambda: ["OK", ""] in goal.feedback), goal.feedback)

    goal = client.goal("track/remember", "s:h\u00e9llo \"x\"", "B:2", "b:false")
    check("what is over at once succeeds", client.answer(goal) is True and client.result(goal) == (SUCCEEDED, "OK"), goal.result)
    goal = client.goal("track/get_note", EMPTY)
    client.answer(goal)
    check("texts come through", client.result(goal)[0] == SUCCEEDED and goal.result[0] == "h\u00e9llo \"x\"" * 2, goal.result)

    goal = client.goal("track/follow", *path_of(), "d:0.1", "i:1")
    check("`validate` refuses", client.answer(goal) is False)
    check("with its exception", goal.report == "e_empty" and "track::e_empty" in goal.feedback[-1][1], goal.feedback)
    check("which is a result, too", client.result(goal) == (ABORTED, "e_empty"), goal.result)
    goal = client.goal("track/set_gains", *(f"d:{k}" for k in range(5)), "d:nan")
    check("what `bipc serve` does not take is refused", client.answer(goal) is False and goal.report == "NOT-TAKEN" and "is a number" in goal.feedback[-1][1], goal.feedback)
    goal = client.goal("track/follow", *path_of(*[(0.5, 0.25)] * 3500), "d:0.1", "i:1")
    check("what is larger than a request is refused, and nothing else", client.answer(goal) is False and "larger" in goal.feedback[-1][1] and "gone" not in level.bridge.text(), goal.feedback)
    twice = client.goal("track/get_note", EMPTY)
    client.answer(twice)
    client.next += 1
    client.numbers["track/get_note", client.next] = ("goal", again := Goal("track/get_note", 0))
    client.tell("goal", "track/get_note", twice.id, EMPTY)
    check("no goal comes twice", client.answer(again) is False)


def cancellations(level):
    client = level.client
    far = path_of((50, 0))
    goal = client.goal("track/follow", *far, "d:0.001", "i:1")
    check("a long goal runs", client.answer(goal) is True)
    check("it is cancelled", client.cancel("track/follow", goal) == (0, [goal.id]))
    check("and says so", client.result(goal) == (CANCELED, "interrupted"), goal.result)
    check("what is over is not cancelled", client.cancel("track/follow", goal) == (3, []))
    check("what is unknown neither", client.cancel("track/follow", Goal("track/follow", 0)) == (2, []))
    older = client.goal("track/follow", *far, "d:0.001", "i:1")
    client.answer(older)
    newer = client.goal("track/follow", *path_of((0, 50)), "d:0.001", "i:1")
    check("the last goal wins", client.answer(newer) is True and client.result(older) == (ABORTED, "interrupted"), older.result)
    check("all are cancelled", client.cancel("track/follow")[0] == 0 and client.result(newer)[0] == CANCELED, newer.result)


def topics(level):
    client = level.client
    check("there is a topic", client.add_topic("track/place", "track_msgs/GeometryPoint", "dd"))
    check("it shows what the port holds", client.until(lambda: client.topics.get("track/place")) and len(client.topics["track/place"][-1]) == 2, client.topics)
    goal = client.goal("track/follow", *path_of((0.02, 0.01)), "d:0.001", "i:1")
    client.result(goal)
    check("and what it holds later", client.until(lambda: [0.02, 0.01] in [[round(v, 3) for v in value] for value in client.topics["track/place"]]), client.topics["track/place"][-1])


# Published with the messages of ROS 2 (Iron and later), in the .json files beside them.
KNOWN = {"action_msgs::msg::dds_::GoalStatusArray_": "RIHS01_6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e"}


def hashes(level):
    """Where ROS 2 looks for them: in the user data of each end, as another DDS sees it."""
    ends = [end for end in level.client.hashes() if end["topic"].startswith(("rt/track/", "rq/track/", "rr/track/"))]
    form = re.compile(r"(serviceid=[0-9a-f]{1,2}(\.[0-9a-f]{1,2}){15};)?typehash=RIHS01_[0-9a-f]{64};$")
    wrong = [end for end in ends if not form.match(end["data"]) or end["data"].startswith("serviceid") == end["topic"].startswith("rt/")]
    check("each end has its hash", len(ends) > 40 and not wrong, wrong or len(ends))
    for type, known in KNOWN.items():
        found = {end["data"] for end in ends if end["type"] == type}
        check(f"the hash of {type}", found == {f"typehash={known};"}, found)
    halves = {end["topic"].split("/")[0]: end["data"].split(";")[0] for end in ends if "track/follow/_action/send_goal" in end["topic"]}
    check("both halves of a service have one id", len(halves) == 2 and len(set(halves.values())) == 1, halves)


def deaths(level):
    client = level.client
    far = path_of((50, 0))
    goal = client.goal("track/follow", *far, "d:0.001", "i:1")
    client.answer(goal)
    level.bridge.end(signal.SIGKILL)
    level.bridge_again()
    check("a killed bridge comes back, and finds what runs", level.bridge.until("adopted track.follow"), level.bridge.text())
    check("its ends are found again", client.wait("track/follow", 2) and client.again("track/follow"))
    running = {}
    client.until(lambda: running.update({i: s for i, s in client.statuses.get("track/follow", {}).items() if s == 2 and i != goal.id}) or running)
    check("what runs is a goal again", len(running) == 1, client.statuses)
    check("that can be cancelled", client.cancel("track/follow") == (0, list(running)))
    check("and ends", client.until(lambda: client.statuses["track/follow"].get(next(iter(running), "")) == CANCELED), client.statuses)

    goal = client.goal_of_new_bridge("track/follow", *far, "d:0.001", "i:1")
    check("the new bridge takes goals", goal.accepted is True, goal.accepted)
    level.server.end(signal.SIGKILL)
    check("a controller that dies aborts its goals", client.result(goal) == (ABORTED, "CONTROLLER-LOST"), goal.result)
    check("the bridge says so", level.bridge.until("warning[R0080]: `bipc serve` at") and "1 goal is aborted" in level.bridge.text(), level.bridge.text())
    refused = client.goal("track/follow", *far, "d:0.001", "i:1")
    check("no goal is accepted meanwhile", client.answer(refused) is False and refused.report == "CONTROLLER-LOST", refused.feedback)
    before = level.bridge.text().count("connected to")
    os.unlink(level.socket)
    level.serve()
    until(lambda: level.bridge.text().count("connected to") > before)
    goal = client.goal("track/follow", *path_of((0.01, 0)), "d:0.001", "i:1")
    check("a new controller is found", client.answer(goal) is True and client.result(goal)[0] == SUCCEEDED, goal.result)
    client.close()
    check("the bridge hears that its clients are gone", level.bridge.until("warning[R0080]: all clients"), level.bridge.text())


def component():
    with tempfile.TemporaryDirectory(prefix="ros2-") as work:
        translate_track(work)
        level = Level(work, ["track.gen", "eye.gen"], ("--asap", "--policy", "fair"))
        try:
            for part in (goals, cancellations, topics, hashes, deaths):
                part(level)
        finally:
            code = level.close()
    check("the bridge ends when it is told to", code == 0, code)


# ---- the mission of models/dala

class Plan:
    """Steps of a file, one after the other: `VERB SERVICE(VALUE) INPUT gets REPORT`. `drives` and `stands`: as the rover writes down."""

    def __init__(self, level, path, record):
        self.level, self.client, self.known, self.goals = level, level.client, set(), {}
        self.unsure = set()   # actions known before the bridge was killed
        self.refusals = []
        self.record = record
        self.steps = [line.partition("#")[0].strip() for line in path.read_text(encoding="utf-8").splitlines()]

    def goal(self, text, seconds=LONG):
        """Sent again if there is no answer: each end finds a new bridge by itself, and what is sent before is lost."""
        bare, _, rest = text.partition(" ")
        service, _, values = bare.rstrip(")").partition("(")
        action = service.replace(".", "/")
        if action not in self.known:
            check(f"there is an action {action}", self.client.add_action(action, "dala_msgs/" + service.replace(".", ""), "ss"))
            self.known.add(action)
        words = [v.strip() for v in values.split(",") if v.strip()]
        members = [*(("d:" if re.match(r"[\d.]+$|nan$", v) else "s:") + v for v in words), "s:" + rest]
        if action in self.unsure:
            self.unsure.remove(action)
            check(f"{action} is there again", self.client.again(action))
            return service, self.client.goal_of_new_bridge(action, *members)
        goal = self.client.goal(action, *members)
        self.client.answer(goal, seconds)
        return service, goal

    def kill(self, which):
        if which == "bridge":
            self.level.bridge.end(signal.SIGKILL)
            self.level.bridge_again()
            self.unsure = set(self.known)
        else:
            self.client.process.kill()
            self.client.process.wait()
            self.client = self.level.client = RosClient(CLIENT, DOMAIN)
            self.known, self.unsure, self.goals = set(), set(), {}

    def rows(self):
        """What the rover has written down, in whole lines: time, x, y, temperature, charge, metres driven, pictures, pictures sent, the nearest obstacle."""
        lines = self.record.read_text(encoding="utf-8").splitlines(keepends=True)
        return [tuple(map(float, line.split())) for line in lines if line.endswith("\n")]

    def drives(self):
        """0.1 m within ten seconds of the rover's time that begin now: it may have to turn first."""
        first = self.rows()[-1]
        self.client.until(lambda: self.rows()[-1][5] > first[5] + 0.1 or self.rows()[-1][0] > first[0] + 10, LONG)
        last = self.rows()[-1]
        check("the rover drives", last[5] > first[5] + 0.1, (first, last))

    def stands(self):
        """For a second of the rover's time that begins with the next row: the last one may be of before it stopped."""
        last = self.rows()[-1]
        self.client.until(lambda: self.rows()[-1][0] > last[0], LONG)
        first = self.rows()[-1]
        self.client.until(lambda: self.rows()[-1][0] >= first[0] + 1, LONG)
        last = self.rows()[-1]
        check("the rover stands", last[0] >= first[0] + 1 and last[5] - first[5] < 0.01, (first, last))

    def lose(self, text):
        """A goal that never arrives: there is no bridge when it is sent, and the next one does not know of it."""
        self.level.bridge.end(signal.SIGKILL)
        action = text.partition(" ")[0].replace(".", "/")
        service, goal = self.goal(text, 2)
        check(f"no answer to a lost {service}", goal.accepted is None, goal.feedback)
        self.level.bridge_again()
        self.unsure = set(self.known)
        check(f"{action} was not asked for", f"accepted {service}" not in self.level.bridge.text(), self.level.bridge.text())

    def run(self):
        for step in filter(None, self.steps):
            verb, _, rest = step.partition(" ")
            rest, _, report = (part.strip() for part in rest.partition(" gets "))
            assert verb in VERBS, step
            if verb == "say":
                print(f"plan: {rest}", flush=True)
            elif verb == "sleep":
                end = time.monotonic() + float(rest)
                self.client.until(lambda: time.monotonic() > end, float(rest) + 1)
            elif verb == "kill":
                self.kill(rest)
            elif verb == "lose":
                self.lose(rest)
            elif verb == "drives":
                self.drives()
            elif verb == "stands":
                self.stands()
            elif verb == "unknown":
                topics = {end["topic"] for end in self.client.hashes()}
                name = rest.replace(".", "/")
                check(step, "rq/NDD/GoTo/_action/send_goalRequest" in topics and not any(name in topic for topic in topics), sorted(topics))
            elif verb in ("await", "cancel"):
                goal = self.goals[rest]
                if verb == "cancel":
                    check(step, self.client.cancel(goal.action, goal) == (0, [goal.id]))
                else:
                    self.judge(step, goal, report)
            else:
                times, rest = (int(rest.split()[0]), rest.split(" ", 2)[2]) if verb == "repeat" else (1, rest)
                for _ in range(times):
                    self.ask(step, "refused" if verb == "repeat" else verb, rest, report)

    def ask(self, step, verb, text, report):
        service, goal = self.goal(text)
        self.goals[service] = goal
        check(f"{step}: answer", goal.accepted is (verb != "refused"), (goal.accepted, goal.feedback))
        if verb == "refused":
            check(step, goal.report == report, goal.feedback)
            if goal.answered_ms is not None:
                self.refusals.append(goal.answered_ms)
        elif verb == "do":
            self.judge(step, goal, report)

    def judge(self, step, goal, report):
        status, got = self.client.result(goal, 5 * LONG)
        wanted = report or "OK"
        expected = SUCCEEDED if wanted == "OK" else CANCELED if wanted == "CANCELED" else ABORTED
        check(step, status == expected and got == ("ACTIVITY_INTERRUPTED" if wanted == "CANCELED" else wanted), (status, goal.result))


def check_record(rows):
    """The effects of the mission, as the rover writes them down."""
    check("no obstacle was touched", min(row[8] for row in rows) > 0.35, min(row[8] for row in rows))
    check("two pictures were taken, and sent", rows[-1][6:8] == (2, 2), rows[-1])
    check("it has come home", abs(rows[-1][1]) < 0.3 and abs(rows[-1][2]) < 0.3, rows[-1])
    for before, row in zip(rows, rows[1:]):
        if row[6] > before[6]:
            begin = next(r for r in rows if r[0] >= row[0] - 3)
            check("a sharp picture was exposed while the rover stood", row[5] - begin[5] < 0.01, (begin, row))
    # The antenna sends from the first picture on that it counts, perhaps just after the wheels have stopped, and a second for each.
    first, second = (next(row for row in rows if row[7] >= count) for count in (1, 2))
    check("pictures were sent while the rover stood", second[0] >= first[0] + 0.5 and second[5] - first[5] < 0.01, (first, second))


def check_refusals(refusals):
    """None waits for the period of the control task: as one follows the other each would take all of it. A busy machine makes most of them slow, not all."""
    quick, median = sorted(refusals)[len(refusals) // 4], statistics.median(refusals)
    print(f"refusals: {len(refusals)}, median {median:.1f} ms, {min(refusals):.1f} to {max(refusals):.1f} ms; load {os.getloadavg()[0]:.1f}")
    check("at least 20 refusals", len(refusals) >= 20, refusals)
    check(f"a quarter of the refusals take less than half a period of {PERIOD_MS:.0f} ms", quick < PERIOD_MS / 2, refusals)


def mission():
    with tempfile.TemporaryDirectory(prefix="ros2-") as work:
        dala = ROOT / "models/dala"
        for name in ("world.hpp", "camera.hpp", "terrain.hpp", "vision.hpp", "bus.hpp", "dala_codels.cpp"):
            shutil.copy(dala / "mission" / name, os.path.join(work, "m_codels.cpp" if name == "dala_codels.cpp" else name))
        source = pathlib.Path(work, "m_codels.cpp")
        source.write_text(source.read_text(encoding="utf-8").replace('"dala_codels.hpp"', '"m_codels.hpp"'), encoding="utf-8")
        # The orbiter is there whenever a plan that waits for new bridges gets so far.
        world = pathlib.Path(work, "world.hpp")
        windows = "windows{{{20, 75}, {79, 400}}}"
        assert windows in world.read_text(encoding="utf-8")
        world.write_text(world.read_text(encoding="utf-8").replace(windows, "windows{{{0, 1e9}, {0, 1e9}}}"), encoding="utf-8")
        pathlib.Path(work, "mission.yields").write_text("".join((dala / name).read_text(encoding="utf-8") for name in ("dala.yields", "mission/async.yields")), encoding="utf-8")
        made = subprocess.run([BIPC, "rules", str(dala / "dala.rules"), "--yields", "mission.yields", "--served", "--skeleton", "--control-period", "2", "-o", "m.bip"], cwd=work, capture_output=True, text=True)
        assert made.returncode == 0, made.stdout + made.stderr
        rules, options = [str(dala / "dala.rules")], ("--asap", "--policy", "fair", "--stall-after", "10s")
        level = Level(work, rules, (*options, "--speed", "10"))
        try:
            check("a poster of GenoM 2 is a topic", level.client.add_topic("POM/Pos", "dala_msgs/POMPos", "ddd"))
            first = level.client
            plan = Plan(level, HERE / "dala.plan", pathlib.Path(work, "world.path"))
            plan.run()
            places = first.topics.get("POM/Pos", [])
            check("the rover is seen driving", len({round(p[0], 1) for p in places}) > 10, len(places))
            check_record(plan.rows())
        finally:
            code = level.close()
        check("the bridge ends when it is told to", code == 0, code)
        level = Level(work, rules, options)
        try:
            plan = Plan(level, HERE / "refusals.plan", None)
            plan.run()
            check_refusals(plan.refusals)
        finally:
            level.close()


def main():
    if not CLIENT.exists() or not (BUILD / "libbipc_dds.so").exists():
        print("skipped: bipc ros2: cyclonedds-dev or libfastrtps-dev is not installed, so there is no DDS or no client of it")
        return finish("ros2")
    for name, part in (("component", component), ("mission", mission)):
        if name in (sys.argv[1:] or ["component", "mission"]):
            part()
    return finish("ros2")


if __name__ == "__main__":
    sys.exit(main())
