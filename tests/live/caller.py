"""Calls services of a node with Cyclone DDS as rmw_cyclonedds does: a header of the client's number and the request's in front.

Usage: caller.py DOMAIN
"""

import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import int64, sequence, uint8, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from listener import LOOPBACK


@dataclass
class Clear(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Request_"):
    client: uint64
    number: int64
    nothing: uint8


@dataclass
class Cleared(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Response_"):
    client: uint64
    number: int64
    success: bool
    message: str


@dataclass
class Names(IdlStruct, typename="rcl_interfaces::srv::dds_::GetParameterTypes_Request_"):
    client: uint64
    number: int64
    names: sequence[str]


@dataclass
class Types(IdlStruct, typename="rcl_interfaces::srv::dds_::GetParameterTypes_Response_"):
    client: uint64
    number: int64
    types: sequence[uint8]


QUALITY = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.Volatile, Policy.History.KeepLast(10)
)


def call(participant, name, request, reply_type):
    """Asks again and again until a reply to one of the requests comes: discovery takes a while."""
    requests = Topic(participant, f"rq/limpid/{name}Request", type(request), qos=QUALITY)
    replies = Topic(participant, f"rr/limpid/{name}Reply", reply_type, qos=QUALITY)
    writer, reader = DataWriter(participant, requests, qos=QUALITY), DataReader(participant, replies, qos=QUALITY)
    for attempt in range(60):
        request.number = attempt + 1
        writer.write(request)
        end = time.monotonic() + 1
        while time.monotonic() < end:
            for reply in reader.take(10):
                if isinstance(reply, reply_type) and reply.client == request.client and reply.number <= request.number:
                    return reply
            time.sleep(0.01)
    raise SystemExit(f"{name}: no reply")


def main(domain: int) -> None:
    # The domain lives as long as it is referred to.
    loopback = Domain(domain, LOOPBACK)
    participant = DomainParticipant(domain)
    print("clear", call(participant, "clear", Clear(0x1122334455667788, 0, 0), Cleared).success)
    names = Names(0x8877665544332211, 0, ["tau", "no_such", "map_frame"])
    print("types", *call(participant, "get_parameter_types", names, Types).types)
    del loopback


if __name__ == "__main__":
    main(int(sys.argv[1]))
