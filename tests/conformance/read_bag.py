#!/usr/bin/env python3
"""read_bag.py FILE.bag TOPIC...: reads a ROS 1 bag with Debian's python3-rosbag.

Messages of types that Debian has (sensor_msgs) are decoded by those packages; of others, rosbag makes
the type from the definition in the file. Each TOPIC must be there. Exit 77: rosbag is not there.
"""

import collections
import sys

try:
    import rosbag
    import sensor_msgs.point_cloud2
except ImportError as error:
    print(f"SKIPPED: {error}; install python3-rosbag and python3-sensor-msgs (tools/conformance.sh)")
    sys.exit(77)


def check_cloud(message):
    """Every point, with its finite coordinates, as a ROS node would read it."""
    points = list(sensor_msgs.point_cloud2.read_points(message, ("x", "y", "z"), skip_nans=True))
    assert points, "a cloud without a finite point"
    assert len(message.data) == message.row_step * message.height, "row_step does not fit the data"
    return len(points)


def main(path, *wanted):
    count, points = collections.Counter(), 0
    with rosbag.Bag(path) as bag:
        types = {topic: info.msg_type for topic, info in bag.get_type_and_topic_info().topics.items()}
        for topic, message, stamp in bag.read_messages():
            count[topic] += 1
            assert stamp.to_nsec() > 0, f"{topic}: a message without a time"
            if message._type == "sensor_msgs/PointCloud2" and count[topic] <= 3:
                points += check_cloud(message)
        assert sum(count.values()) == bag.get_message_count(), "the index misses messages"
    for topic, number in sorted(count.items()):
        print(f"{topic} {types[topic]}: {number} messages")
    print(f"{points} points of the first clouds read")
    missing = set(wanted) - set(count)
    assert not missing, f"no message on {missing}"
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
