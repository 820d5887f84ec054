"""Reads an MCAP with the reference Python readers and prints what is in it as JSON.

Needs the packages mcap, mcap-ros2-support and numpy.
    python read_output.py out.mcap            topics, types, counts and decoded values of the first message
    python read_output.py out.mcap --check    also checks the rules between limpid's topics; exits 1 at the first broken one
"""

import argparse
import collections
import json
import sys

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

ENCODINGS = {"mono8": np.uint8, "16UC1": np.uint16, "32FC1": np.float32}


def nanoseconds(stamp):
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def pixels(image):
    """The image as an array; its size, step and payload must agree."""
    kind = np.dtype(ENCODINGS[image.encoding])
    assert image.step == image.width * kind.itemsize, (image.step, image.width)
    return np.frombuffer(bytes(image.data), kind).reshape(image.height, image.width)


def pose(p, q):
    return {"translation_m": [p.x, p.y, p.z], "rotation_xyzw": [q.x, q.y, q.z, q.w]}


def describe_grid(grid):
    info = getattr(grid, "info", None) or grid.metadata
    size = [getattr(info, "width", None) or info.size_x, getattr(info, "height", None) or info.size_y]
    values = np.array(list(grid.data), np.int16)
    assert len(values) == size[0] * size[1]
    found, counts = np.unique(values, return_counts=True)
    return {
        "size": size,
        "resolution_m": info.resolution,
        "origin": pose(info.origin.position, info.origin.orientation),
        "cells_by_value": {int(v): int(n) for v, n in zip(found, counts)} if len(found) < 12 else f"{len(found)} values",
        "range": [int(values.min()), int(values.max())],
    }


def describe_image(image):
    values = pixels(image)
    return {
        "size": [image.width, image.height],
        "encoding": image.encoding,
        "range": [float(np.nanmin(values)), float(np.nanmax(values))],
        "zero_share": float((values == 0).mean()),
    }


def describe_camera(info):
    return {"size": [info.width, info.height], "model": info.distortion_model,
            "d": list(info.d), "k": list(info.k), "r": list(info.r), "p": list(info.p)}


def describe_transforms(message):
    return [{"parent": t.header.frame_id, "child": t.child_frame_id,
             **pose(t.transform.translation, t.transform.rotation)} for t in message.transforms]


def points(cloud):
    """The cloud as an array of its fields, all float32 and packed."""
    names = [field.name for field in cloud.fields]
    assert [field.offset for field in cloud.fields] == [4 * i for i in range(len(names))]
    assert cloud.point_step == 4 * len(names) and cloud.row_step == cloud.point_step * cloud.width
    return np.frombuffer(bytes(cloud.data), np.float32).reshape(cloud.width * cloud.height, len(names))


def describe_cloud(cloud):
    values = points(cloud)
    return {"points": len(values), "fields": [field.name for field in cloud.fields],
            "range": [values.min(0).tolist(), values.max(0).tolist()] if len(values) else None}


def describe_diagnostics(message):
    return [{"level": s.level if isinstance(s.level, int) else s.level[0], "name": s.name, "message": s.message,
             "values": {v.key: v.value for v in s.values}} for s in message.status]


def verdicts(grid):
    """The cells of the map's verdicts by field."""
    assert [(f.name, f.offset, f.type) for f in grid.fields] == [("cost", 0, 1), ("reason", 1, 1), ("sensor", 2, 1), ("age_s", 4, 7)]
    kind = np.dtype({"names": ["cost", "reason", "sensor", "age_s"], "formats": ["u1", "u1", "u1", "<f4"],
                     "offsets": [0, 1, 2, 4], "itemsize": grid.cell_stride})
    assert grid.row_stride == grid.cell_stride * grid.column_count
    return np.frombuffer(bytes(grid.data), kind).reshape(-1, grid.column_count)


def describe_verdicts(grid):
    cells = verdicts(grid)
    reasons, counts = np.unique(cells["reason"], return_counts=True)
    return {"size": list(cells.shape[::-1]), "cell_size_m": grid.cell_size.x, "origin": pose(grid.pose.position, grid.pose.orientation),
            "cells_by_reason": {int(r): int(n) for r, n in zip(reasons, counts)}, "oldest_s": float(cells["age_s"].max())}


DESCRIBE = {
    "foxglove_msgs/msg/Grid": describe_verdicts,
    "nav_msgs/msg/OccupancyGrid": describe_grid,
    "nav2_msgs/msg/Costmap": describe_grid,
    "sensor_msgs/msg/Image": describe_image,
    "sensor_msgs/msg/PointCloud2": describe_cloud,
    "sensor_msgs/msg/CameraInfo": describe_camera,
    "sensor_msgs/msg/CompressedImage": lambda m: {"format": m.format, "bytes": len(m.data)},
    "tf2_msgs/msg/TFMessage": describe_transforms,
    "diagnostic_msgs/msg/DiagnosticArray": describe_diagnostics,
}


def occupancy_of_cost(cost):
    """nav2's costmap publisher: 0, 253, 254 and 255 have their own values, the rest is scaled to 1..98."""
    return {0: 0, 253: 99, 254: 100, 255: -1}.get(cost, 1 + (97 * (cost - 1)) // 251)


def check(frames, tau):
    """Rules between the topics of limpid's output, for every frame."""
    occupancy, costs = frames["/limpid/costmap"], frames["/limpid/costmap_raw"]
    assert len(occupancy) == len(costs)
    for grid, raw in zip(occupancy, costs):
        assert list(grid.data) == [occupancy_of_cost(c) for c in raw.data], "costmap is not nav2's translation"
        assert nanoseconds(grid.header.stamp) == nanoseconds(raw.header.stamp)
    names = ["/limpid/reliability", "/limpid/reliability_float", "/limpid/depth_filtered/image", "/limpid/depth_filtered/camera_info"]
    for mono, real, depth, info in zip(*(frames.get(name, []) for name in names), strict=True):
        assert len({(nanoseconds(m.header.stamp), m.header.frame_id) for m in (mono, real, depth, info)}) == 1
        reliability = pixels(real)
        assert np.isfinite(reliability).all() and reliability.min() >= 0 and reliability.max() <= 1
        # Halves round away from zero, as the float has them.
        assert (pixels(mono) == np.floor(reliability.astype(np.float32) * np.float32(255) + np.float32(0.5))).all()
        assert (pixels(depth)[reliability <= np.float32(tau)] == 0).all(), "an unreliable pixel kept its depth"
        assert [info.width, info.height] == [depth.width, depth.height]
    for cloud in frames.get("/limpid/points_trusted", []):
        values = points(cloud)
        assert np.isfinite(values).all() and (values[:, 2] > 0).all() and (values[:, 3] > np.float32(tau)).all()


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("file")
    arguments.add_argument("--check", action="store_true")
    arguments.add_argument("--tau", type=float, default=0.3)
    arguments = arguments.parse_args()

    frames, topics = collections.defaultdict(list), {}
    with open(arguments.file, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        profile = reader.get_header().profile
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            frames[channel.topic].append(decoded)
            topic = topics.setdefault(channel.topic, {"type": schema.name, "count": 0})
            topic["count"] += 1
            if topic["count"] == 1:
                if hasattr(decoded, "timestamp"):
                    stamp, frame_id = decoded.timestamp, decoded.frame_id
                else:
                    header = getattr(decoded, "header", None) or decoded.transforms[0].header
                    stamp, frame_id = header.stamp, header.frame_id
                topic |= {"log_time": message.log_time, "stamp_ns": nanoseconds(stamp), "frame_id": frame_id}
                topic["first"] = DESCRIBE[schema.name](decoded)
    json.dump({"profile": profile, "topics": dict(sorted(topics.items()))}, sys.stdout, indent=1)
    print()
    if arguments.check:
        check(frames, arguments.tau)
        print("all rules hold", file=sys.stderr)


if __name__ == "__main__":
    main()
