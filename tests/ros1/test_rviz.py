#!/usr/bin/env python3
"""The rover in rviz: a master, `bipc ros1` over Dala's level, models/dala/mission/show_in_rviz.py, and rviz under Xvfb, whose picture is looked at pixel by pixel.

    tests/ros1/test_rviz.py [--picture FILE.png]

The scan, the path and the pose have colours of their own (dala.rviz). Before the rover has driven there is no path in the picture; after it there is one of the extent that the rover's own record
says, at the scale of the view, the pose at its end, and the scan shows the obstacle where it is. --picture writes the last one. Needs Debian's rviz, xvfb, imagemagick, python3-rospy,
python3-roslaunch, python3-geometry-msgs, python3-nav-msgs, python3-sensor-msgs, python3-tf2-msgs, and runs itself with the Python that has them.
"""
import argparse
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
DALA = ROOT / "models/dala"
sys.path.insert(0, str(ROOT / "tests/serve"))
sys.path.insert(0, str(ROOT / "tests/ros2"))
from checks import BIPC, LONG, check, finish  # noqa: E402
from served_level import Program, ServedLevel  # noqa: E402

BUILD = pathlib.Path(os.environ.get("BIPC_BUILD_DIR") or pathlib.Path(BIPC).resolve().parent)
DEBIAN = "/usr/bin/python3"
WIDTH, HEIGHT = 1000, 700
# Of dala.rviz: pixels a metre, the place in the middle, and colours.
SCALE, MIDDLE = 90, (1.5, 0.5)
SCAN, PATH, POSE, GROUND = (220, 30, 30), (31, 95, 139), (58, 138, 63), (244, 237, 228)
OBSTACLE = (4.4, 1.2, 0.4)  # world.hpp
MISSION = """procedure mission
  do POM.Init
  do RFLEX.Init
  do LaserRF.Init
  start LaserRF.StartAcquisition
  do RFLEX.GotoPosition 1.5 1.2
  do RFLEX.GotoPosition 3 1
"""


class Picture:
    """Of the whole screen."""

    def __init__(self):
        ppm = subprocess.run(["import", "-window", "root", "-depth", "8", "ppm:-"], capture_output=True, check=True).stdout
        head, self.pixels = ppm.split(b"\n255\n", 1)
        self.width, self.height = map(int, head.split()[1:3])
        # The view is what has the colour of the ground, without menus and bars.
        ground = self.places(GROUND, 0)
        columns, rows = [k % self.width for k in ground], [k // self.width for k in ground]
        self.middle = ((min(columns) + max(columns)) / 2, (min(rows) + max(rows)) / 2) if ground else (0, 0)

    def places(self, colour, near):
        return [k // 3 for k in range(0, len(self.pixels), 3) if all(abs(self.pixels[k + c] - colour[c]) <= near for c in range(3))]

    def colours(self):
        return len({self.pixels[k:k + 3] for k in range(0, len(self.pixels), 3)})

    def box(self, colour, near=12):
        """How many pixels have nearly that colour, and in metres least and greatest x and y of theirs; rviz draws x to the right, y upwards."""
        found = self.places(colour, near)
        if not found:
            return 0, None
        xs = [MIDDLE[0] + (k % self.width - self.middle[0]) / SCALE for k in found]
        ys = [MIDDLE[1] - (k // self.width - self.middle[1]) / SCALE for k in found]
        return len(found), (min(xs), max(xs), min(ys), max(ys))


def until(look, holds, seconds=LONG):
    """The first picture of which it holds, else the last one."""
    end = time.monotonic() + seconds
    while True:
        picture = look()
        if holds(picture) or time.monotonic() > end:
            return picture
        time.sleep(0.5)


def translate(work):
    for name in ("world.hpp", "camera.hpp", "terrain.hpp", "vision.hpp", "bus.hpp"):
        shutil.copy(DALA / "mission" / name, work)
    codels = (DALA / "mission/dala_codels.cpp").read_text(encoding="utf-8").replace('"dala_codels.hpp"', '"m_codels.hpp"')
    pathlib.Path(work, "m_codels.cpp").write_text(codels, encoding="utf-8")
    pathlib.Path(work, "m.yields").write_text("".join((DALA / name).read_text(encoding="utf-8") for name in ("dala.yields", "mission/async.yields")), encoding="utf-8")
    made = subprocess.run([BIPC, "rules", str(DALA / "dala.rules"), "--yields", "m.yields", "--served", "--skeleton", "--control-period", "2", "-o", "m.bip"], cwd=work, capture_output=True, text=True)
    assert made.returncode == 0, made.stdout + made.stderr


def rviz_shows(level, work, save):
    show = Program([DEBIAN, str(DALA / "mission/show_in_rviz.py")], work, "show.log")
    check("the node that turns topics begins", show.until("showing"), show.text())
    rviz = Program(["rviz", "-d", str(DALA / "mission/dala.rviz"), "-s", ""], work, "rviz.log")
    empty = until(Picture, lambda p: p.box(POSE)[0] > 100, 5 * LONG)
    check("rviz draws the pose", empty.box(POSE)[0] > 100, rviz.text()[-1500:])
    check("before the laser looks, and before it drives, neither scan nor path", empty.box(SCAN)[0] == 0 and empty.box(PATH)[0] < 60, (empty.box(SCAN), empty.box(PATH)))
    mission = pathlib.Path(work, "mission.txt")
    mission.write_text(MISSION, encoding="utf-8")
    drove = subprocess.run([sys.executable, str(DALA / "mission/executive.py"), level.socket, str(mission)], capture_output=True, text=True, timeout=10 * LONG)
    check("the mission", drove.returncode == 0, drove.stdout[-1500:] + drove.stderr)
    rows = [tuple(map(float, line.split()))[1:3] for line in pathlib.Path(work, "world.path").read_text(encoding="utf-8").splitlines()]
    xs, ys = zip(*rows)
    picture = until(Picture, lambda p: p.box(SCAN)[0] > 100 and p.box(PATH)[0] > 500)
    if save:
        subprocess.run(["import", "-window", "root", save], check=True)
    check("it has many colours", picture.colours() > 20, picture.colours())
    count, path = picture.box(PATH)
    # The arrow of the pose lies over the path's end.
    near = path and abs(path[0] - min(xs)) < 0.1 and abs(path[2] - min(ys)) < 0.1 and abs(path[3] - max(ys)) < 0.1 and max(xs) - 0.5 < path[1] < max(xs) + 0.15
    check("the path is where the rover drove", near, (count, path, (min(xs), max(xs), min(ys), max(ys))))
    count, pose = picture.box(POSE)
    check("the pose is at its end", pose and pose[0] - 0.2 < xs[-1] < pose[1] + 0.2 and pose[2] - 0.2 < ys[-1] < pose[3] + 0.2 and pose[1] - pose[0] < 0.9, (count, pose, rows[-1]))
    count, scan = picture.box(SCAN)
    # The nearest edge of the obstacle in front of it; squares of 0.1 m.
    check("the scan shows the obstacle", scan and abs(scan[1] - OBSTACLE[0]) < OBSTACLE[2] + 0.2 and scan[0] < OBSTACLE[0] - OBSTACLE[2] + 0.15 and count > 100, (count, scan))
    rviz.end()
    show.end(signal.SIGINT)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--picture")
    options = arguments.parse_args()
    missing = [program for program in ("rviz", "Xvfb", "import", "roscore") if shutil.which(program) is None]
    modules = subprocess.run([DEBIAN, "-c", "import rospy, geometry_msgs.msg, nav_msgs.msg, sensor_msgs.msg, tf2_msgs.msg"], capture_output=True, text=True, check=False)
    if missing or modules.returncode or not (BUILD / "libbipc_ros1.so").exists():
        print(f"skipped: rviz: {', '.join(missing) or modules.stderr.strip()[-100:] or 'libroscpp-dev was not installed when bipc was built'}")
        return finish("rviz")
    with tempfile.TemporaryDirectory(prefix="rviz-") as work:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        display = f":{port}"
        os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_HOSTNAME="127.0.0.1", ROS_HOME=work, ROS_LOG_DIR=work, DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1", HOME=work)
        translate(work)
        screen = Program(["Xvfb", display, "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "-nolisten", "tcp"], work, "screen.log")
        core = Program(["roscore", "-p", str(port)], work, "core.log")
        level = None
        try:
            check("there is a master", core.until("started core service"), core.text())
            level = ServedLevel(work, [BIPC, "ros1", str(DALA / "dala.rules")], ("--asap", "--policy", "fair", "--stall-after", "10s"))
            rviz_shows(level, work, options.picture)
        finally:
            if level is not None:
                level.close()
            core.end(signal.SIGINT)
            screen.end()
    return finish("rviz")


if __name__ == "__main__":
    sys.exit(main())
