#!/usr/bin/env python3
"""`bipc ros1` between `bipc serve` and ROS 1: a real master, actionlib's and rospy's clients, rosbag.

The component is that of tests/genom/track. Classes of messages are made by genpy from the package that `--interfaces` writes, so ROS 1's
own tools compute the MD5 sums that both ends compare. Needs Debian's python3-rospy, python3-actionlib, python3-roslaunch and
python3-rosbag, and runs itself with the Python that has them.
"""
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(ROOT / "tests/serve"))
sys.path.insert(0, str(ROOT / "tests/ros2"))
from checks import BIPC, LONG, check, finish, until  # noqa: E402

try:
    import actionlib
    import genpy.dynamic
    import rosbag
    import rospy
except ImportError as missing:
    DEBIAN = "/usr/bin/python3"
    if os.environ.get("BIPC_TEST_ROS1") or not os.access(DEBIAN, os.X_OK):
        print(f"skipped: bipc ros1: {missing} (Debian's python3-rospy, python3-actionlib, python3-roslaunch, python3-rosbag)")
        sys.exit(finish("ros1"))
    os.environ["BIPC_TEST_ROS1"] = "again"
    os.execv(DEBIAN, [DEBIAN, *sys.argv])

from actionlib_msgs.msg import GoalID, GoalStatus  # noqa: E402
from std_msgs.msg import Header  # noqa: E402
from served_level import Program, ServedLevel, translate_track  # noqa: E402

BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or pathlib.Path(BIPC).resolve().parent)


# ---- types of ROS 1, from the files of the package

class Package:
    def __init__(self, folder, name):
        self.name, texts = name, {}
        for file in sorted(pathlib.Path(folder, "msg").glob("*.msg")):
            texts[file.stem] = file.read_text(encoding="utf-8")
        for file in sorted(pathlib.Path(folder, "action").glob("*.action")):
            parts = [part.strip("\n") + "\n" for part in file.read_text(encoding="utf-8").split("---\n")]
            status = "Header header\nactionlib_msgs/GoalStatus status\n"
            for part, text, head in zip(("Goal", "Result", "Feedback"), parts, ("Header header\nactionlib_msgs/GoalID goal_id\n", status, status)):
                texts[file.stem + part] = text
                texts[file.stem + "Action" + part] = f"{head}{file.stem}{part} {part.lower()}\n"
        # Of these ROS 1 has the classes, and their texts with all that they are made of.
        known = {"std_msgs/Header": Header._full_text, "actionlib_msgs/GoalID": GoalID._full_text, "actionlib_msgs/GoalStatus": GoalStatus._full_text.split("=" * 80)[0]}
        everything = {**{f"{name}/{key}": text for key, text in texts.items()}, **known}
        # One text, of which genpy makes all classes: the first type, then the others under their names.
        first, *others = everything
        whole = everything[first] + "".join(f"{'=' * 80}\nMSG: {other}\n{everything[other]}" for other in others)
        made = genpy.dynamic.generate_dynamic(first, whole)
        self.classes = {key: made[f"{name}/{key}"] for key in texts}

    def action(self, key):
        made = {f"action_{part.lower()}": self.classes[f"{key}Action{part}"] for part in ("Goal", "Result", "Feedback")}

        class Spec:
            def __init__(self):
                for member, kind in made.items():
                    setattr(self, member, kind())

        return Spec

    def goal(self, key, **members):
        return self.classes[key + "Goal"](**members)

    def point(self, x, y):
        return self.classes["GeometryPoint"](x=x, y=y)


class Client:
    """One of actionlib for each action, with the feedback that came."""

    def __init__(self, package):
        self.package, self.actions, self.feedback = package, {}, []

    def action(self, topic, key):
        self.actions[topic] = actionlib.SimpleActionClient(topic, self.package.action(key))
        return self.actions[topic].wait_for_server(rospy.Duration(LONG))

    def send(self, topic, goal):
        self.feedback.clear()
        self.actions[topic].send_goal(goal, feedback_cb=lambda feedback: self.feedback.append((feedback.report, feedback.detail)))

    def end(self, topic):
        """Status and result."""
        client = self.actions[topic]
        client.wait_for_result(rospy.Duration(LONG))
        return client.get_state(), client.get_result()

    def do(self, topic, goal):
        self.send(topic, goal)
        return self.end(topic)


# ---- what is checked

def goals(level, client, package):
    for topic, key in (("track/follow", "TrackFollow"), ("track/remember", "TrackRemember"), ("track/get_note", "TrackGetNote"), ("track/set_gains", "TrackSetGains")):
        check(f"there is an action {topic}", client.action(topic, key))
    square = [package.point(*place) for place in ((0.02, 0), (0.02, 0.02), (0, 0))]
    state, result = client.do("track/follow", package.goal("TrackFollow", path=square, tolerance=0.001, laps=2))
    check("a goal succeeds", state == GoalStatus.SUCCEEDED, (state, result))
    check("with its outputs", abs(result.length - 2 * (0.04 + 0.02 * 2 ** 0.5)) < 0.01 and (result.laps, result.report, result.detail) == (0, "OK", ""), result)
    check("and the intermediate reply", ("OK", "") in client.feedback, client.feedback)
    members = package.classes["TrackRememberGoal"].__slots__
    values = {name: kind for name, kind in zip(members, package.classes["TrackRememberGoal"]._slot_types)}
    check("members have the types of ROS 1", list(values.values())[0] == "string", values)
    text = {name: "h\u00e9llo" for name, kind in values.items() if kind == "string"}
    numbers = {name: 2 for name, kind in values.items() if kind in ("uint8", "int32")}
    state, result = client.do("track/remember", package.goal("TrackRemember", **text, **numbers))
    check("what is over at once succeeds", state == GoalStatus.SUCCEEDED, (state, result))
    state, result = client.do("track/get_note", package.goal("TrackGetNote"))
    check("texts come through", state == GoalStatus.SUCCEEDED and "h\u00e9llo" in result.note, result)

    state, result = client.do("track/follow", package.goal("TrackFollow", path=[], tolerance=0.1, laps=1))
    check("`validate` refuses", state == GoalStatus.REJECTED and result.report == "e_empty" and "track::e_empty" in result.detail, (state, result))
    check("the status says why", "e_empty" in client.actions["track/follow"].get_goal_status_text(), client.actions["track/follow"].get_goal_status_text())
    nan = {name: float("nan") for name, kind in zip(package.classes["TrackSetGainsGoal"].__slots__, package.classes["TrackSetGainsGoal"]._slot_types) if kind == "float64"}
    if nan:
        state, result = client.do("track/set_gains", package.goal("TrackSetGains", **nan))
        check("what `bipc serve` does not take is refused", state == GoalStatus.REJECTED and result.report == "NOT-TAKEN", (state, result))


def cancellations(level, client, package):
    far = package.goal("TrackFollow", path=[package.point(50, 0)], tolerance=0.001, laps=1)
    follow = client.actions["track/follow"]
    client.send("track/follow", far)
    check("a long goal runs", until(lambda: follow.get_state() == GoalStatus.ACTIVE), follow.get_state())
    follow.cancel_goal()
    state, result = client.end("track/follow")
    check("it is cancelled", state == GoalStatus.PREEMPTED and result.report == "interrupted", (state, result))
    client.send("track/follow", far)
    check("another one runs", until(lambda: follow.get_state() == GoalStatus.ACTIVE), follow.get_state())
    everything = rospy.Publisher("/track/follow/cancel", GoalID, queue_size=1)
    until(lambda: everything.get_num_connections() > 0)
    everything.publish(GoalID())
    state, result = client.end("track/follow")
    check("an empty id cancels all", state == GoalStatus.PREEMPTED, (state, result))
    everything.publish(GoalID(id="nobody's"))
    client.send("track/follow", far)
    check("an unknown id cancels nothing", until(lambda: follow.get_state() == GoalStatus.ACTIVE), follow.get_state())
    client.send("track/follow", package.goal("TrackFollow", path=[package.point(0.01, 0)], tolerance=0.001, laps=1))
    state, result = client.end("track/follow")
    check("the last goal wins", state == GoalStatus.SUCCEEDED, (state, result))


def topics(level, client, package):
    places = []
    bag = os.path.join(level.work, "place.bag")
    record = Program(["rosbag", "record", "-O", bag, "/track/place", "/track/follow/result"], level.work, "record.log")
    reader = rospy.Subscriber("/track/place", package.classes["GeometryPoint"], places.append)
    check("a poster is a topic", until(lambda: places), places)
    # It makes the file when the first message comes; the last place comes at once.
    # A recorder gets what comes after it has connected: nothing tells that here.
    time.sleep(2)
    check("rosbag records", until(lambda: list(pathlib.Path(level.work).glob("place.bag*"))), record.text())
    client.do("track/follow", package.goal("TrackFollow", path=[package.point(0.02, 0.01)], tolerance=0.001, laps=1))
    check("it shows what the port holds later", until(lambda: any((round(p.x, 3), round(p.y, 3)) == (0.02, 0.01) for p in places)), places[-1:])
    for _ in range(3):
        time.sleep(1)
        client.do("track/follow", package.goal("TrackFollow", path=[package.point(0.03, 0.01)], tolerance=0.001, laps=1))
    reader.unregister()
    time.sleep(1)  # what has been sent may not have been recorded
    record.end(signal.SIGINT)
    check("and closes its file", until(lambda: os.path.exists(bag)), record.text())
    with rosbag.Bag(bag) as file:
        rows = {topic: [message for _, message, _ in file.read_messages(topics=[topic])] for topic in ("/track/place", "/track/follow/result")}
        types = {topic: info.msg_type for topic, info in file.get_type_and_topic_info().topics.items()}
    check("rosbag records posters and results", len(rows["/track/place"]) > 0 and len(rows["/track/follow/result"]) > 0, {key: len(row) for key, row in rows.items()})
    check("with their types", types.get("/track/follow/result") == "track_msgs/TrackFollowActionResult", types)
    check("and reads them by the definitions that it got", rows["/track/follow/result"] and rows["/track/follow/result"][0].result.report == "OK", rows["/track/follow/result"])


def deaths(level, client, package):
    far = package.goal("TrackFollow", path=[package.point(50, 0)], tolerance=0.001, laps=1)
    follow = client.actions["track/follow"]
    client.send("track/follow", far)
    until(lambda: follow.get_state() == GoalStatus.ACTIVE)
    level.server.end(signal.SIGKILL)
    state, result = client.end("track/follow")
    check("a controller that dies aborts its goals", state == GoalStatus.ABORTED and result.report == "CONTROLLER-LOST", (state, result))
    state, result = client.do("track/follow", far)
    check("no goal is accepted meanwhile", state == GoalStatus.REJECTED and result.report == "CONTROLLER-LOST", (state, result))
    before = level.bridge.text().count("connected to")
    os.unlink(level.socket)
    level.serve()
    check("a new controller is found", until(lambda: level.bridge.text().count("connected to") > before), level.bridge.text())
    state, result = client.do("track/follow", package.goal("TrackFollow", path=[package.point(0.01, 0)], tolerance=0.001, laps=1))
    check("and takes goals", state == GoalStatus.SUCCEEDED, (state, result))
    client.send("track/follow", far)
    until(lambda: follow.get_state() == GoalStatus.ACTIVE)
    level.bridge.end(signal.SIGKILL)
    level.bridge_again()
    check("a killed bridge comes back, and finds what runs", level.bridge.until("adopted track.follow"), level.bridge.text())
    again = Client(package)
    check("a new client finds the new bridge", again.action("track/follow", "TrackFollow"))
    # What is sent next is none of these, even if it arrives before: the topics of goals and of cancels are two.
    again.actions["track/follow"].cancel_goals_at_and_before_time(rospy.Time.now())
    state, result = again.do("track/follow", package.goal("TrackFollow", path=[package.point(0.02, 0)], tolerance=0.001, laps=1))
    check("and has its goals done", state == GoalStatus.SUCCEEDED, (state, result))


def main():
    if not (BUILD / "libbipc_ros1.so").exists():
        print("skipped: bipc ros1: libroscpp-dev was not installed when bipc was built")
        return finish("ros1")
    with tempfile.TemporaryDirectory(prefix="ros1-") as work:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_HOSTNAME="127.0.0.1", ROS_HOME=work, ROS_LOG_DIR=work)
        translate_track(work)
        command = [BIPC, "ros1", "track.gen", "eye.gen"]
        lost = subprocess.run([*command, "--serve", "nowhere"], cwd=work, capture_output=True, text=True)
        check("without a master it says so", lost.returncode == 2 and f"no master of ROS at http://127.0.0.1:{port}" in lost.stderr, lost)
        written = subprocess.run([*command, "--interfaces", "package"], cwd=work, capture_output=True, text=True)
        check("the package is written", written.returncode == 0, written)
        package = Package(os.path.join(work, "package"), "track_msgs")
        core = Program(["roscore", "-p", str(port)], work, "core.log")
        check("there is a master", core.until("started core service"), core.text())
        level = ServedLevel(work, command, ("--asap", "--policy", "fair"))
        try:
            rospy.init_node("client", anonymous=True, disable_signals=True, disable_rosout=True)
            client = Client(package)
            for part in (goals, cancellations, topics, deaths):
                part(level, client, package)
        finally:
            code = level.close()
            rospy.signal_shutdown("over")
            core.end(signal.SIGINT)
    check("the bridge ends at a signal", code == 0, code)
    return finish("ros1")


if __name__ == "__main__":
    sys.exit(main())
