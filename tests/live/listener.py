"""Listens with Cyclone DDS: prints the headers of a node's costmap and of its updates, one a line, until so many came.

Usage: listener.py DOMAIN COUNT
"""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float32, float64, int8, int32, sequence, uint32
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

LOOPBACK = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    x: float64
    y: float64
    z: float64
    qx: float64
    qy: float64
    qz: float64
    qw: float64


@dataclass
class MetaData(IdlStruct, typename="nav_msgs::msg::dds_::MapMetaData_"):
    map_load_time: Time
    resolution: float32
    width: uint32
    height: uint32
    origin: Pose


@dataclass
class Grid(IdlStruct, typename="nav_msgs::msg::dds_::OccupancyGrid_"):
    header: Header
    info: MetaData
    data: sequence[int8]


@dataclass
class Update(IdlStruct, typename="map_msgs::msg::dds_::OccupancyGridUpdate_"):
    header: Header
    x: int32
    y: int32
    width: uint32
    height: uint32
    data: sequence[int8]


def main(domain: int, count: int) -> None:
    # The domain lives as long as it is referred to.
    loopback = Domain(domain, LOOPBACK)
    participant = DomainParticipant(domain)
    reliable = Policy.Reliability.Reliable(duration(seconds=1))
    kept = Policy.History.KeepLast(100)
    maps = Qos(reliable, Policy.Durability.TransientLocal, kept)
    updates = Qos(reliable, Policy.Durability.Volatile, kept)
    readers = [
        DataReader(participant, Topic(participant, "rt/limpid/costmap", Grid, qos=maps), qos=maps),
        DataReader(participant, Topic(participant, "rt/limpid/costmap_updates", Update, qos=updates), qos=updates),
    ]
    print("listening", flush=True)
    end = time.monotonic() + 60
    while count > 0 and time.monotonic() < end:
        for reader in readers:
            for message in reader.take(100):
                if not isinstance(message, (Grid, Update)):
                    continue
                where = message.info if isinstance(message, Grid) else message
                assert len(message.data) == where.width * where.height
                stamp = message.header.stamp
                kind = type(message).__name__
                print(kind, stamp.sec * 10**9 + stamp.nanosec, message.header.frame_id, where.width, where.height, flush=True)
                count -= 1
        time.sleep(0.002)
    del loopback


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
