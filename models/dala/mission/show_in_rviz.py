#!/usr/bin/env python3
"""Shows the rover in rviz: a node of ROS 1 beside `bipc ros1`, which turns its topics into those that rviz draws.

    models/dala/mission/show_in_rviz.py        (and: rviz -d models/dala/mission/dala.rviz)

/POM/Pos becomes /rover/pose (geometry_msgs/PoseStamped), /rover/path (nav_msgs/Path: where it was, each 5 cm) and the transform from `map` to `rover` (/tf), /LaserRF/Scan becomes /rover/scan
(sensor_msgs/LaserScan). Needs Debian's python3-rospy, python3-geometry-msgs, python3-nav-msgs, python3-sensor-msgs, python3-tf2-msgs.
"""
import math
import struct
import threading

import rospy
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import Path
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

STEP = 0.05  # metres between places of the path
FARTHEST = 4.0


class Display:
    def __init__(self):
        self.lock = threading.Lock()  # rospy calls each topic's function in a thread of its own
        self.pose = rospy.Publisher("/rover/pose", PoseStamped, queue_size=1, latch=True)
        self.path = rospy.Publisher("/rover/path", Path, queue_size=1, latch=True)
        self.scan = rospy.Publisher("/rover/scan", LaserScan, queue_size=1, latch=True)
        self.frames = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self.places = []
        # Both posters hold numbers of double precision only, so the classes of their messages are not needed.
        rospy.Subscriber("/POM/Pos", rospy.AnyMsg, lambda message: self.moved(*struct.unpack("<3d", message._buff)))
        rospy.Subscriber("/LaserRF/Scan", rospy.AnyMsg, lambda message: self.scanned(struct.unpack(f"<{len(message._buff) // 8}d", message._buff)))

    def moved(self, x, y, theta):
        now = rospy.Time.now()
        pose = PoseStamped()
        pose.header.frame_id, pose.header.stamp = "map", now
        pose.pose.position.x, pose.pose.position.y = x, y
        pose.pose.orientation.z, pose.pose.orientation.w = math.sin(theta / 2), math.cos(theta / 2)
        frame = TransformStamped(child_frame_id="rover")
        frame.header = pose.header
        frame.transform.translation.x, frame.transform.translation.y = x, y
        frame.transform.rotation = pose.pose.orientation
        with self.lock:
            self.frames.publish(TFMessage([frame]))
            self.pose.publish(pose)
            last = self.places[-1].pose.position if self.places else None
            if last is None or math.hypot(last.x - x, last.y - y) >= STEP:
                self.places.append(pose)
                path = Path(poses=list(self.places))
                path.header = pose.header
                self.path.publish(path)

    def scanned(self, ranges):
        if not any(ranges):
            return  # the laser has not looked yet
        scan = LaserScan(angle_min=0, angle_increment=2 * math.pi / len(ranges), range_min=0.05, range_max=FARTHEST - 0.01, ranges=ranges)
        scan.angle_max = scan.angle_increment * (len(ranges) - 1)
        # The newest transform: a scan is no older than the place where it was taken, to 50 ms.
        scan.header.frame_id, scan.header.stamp = "rover", rospy.Time(0)
        self.scan.publish(scan)


def main():
    rospy.init_node("show_in_rviz")
    Display()
    print("showing", flush=True)
    rospy.spin()


if __name__ == "__main__":
    main()
