"""Compares `limpid points` with the Python package velodyne-decoder, point by point.

    pip install velodyne-decoder dpkt mcap mcap-ros2-support numpy
    cargo build --release
    python tests/reference/velodyne.py target/release/limpid "$LIMPID_DATA"
    python tests/reference/velodyne.py figures "$LIMPID_DATA" > testdata/reference/lidar_points.json

The second command stores the peer's figures (sums and checksums) for the tests; those of 3dref.mcap come from the message
itself, by mcap-ros2-support and NumPy.

Every pcap of the data folder, the packets of vlp16-dual.mcap, and made-up packets of the models that no recording is
of. Asked are the same points in the same order: as many, positions within 5 mm, intensity, ring and slot of the
return equal, times within 2 us. Ends with status 1 where any of it fails, or where one of the negative controls (a point
moved by 6 mm, a ring, an intensity or a slot changed, a time shifted, a point left out) goes unnoticed.

Conventions that differ:
- The peer takes the factory byte for granted; the one of vlp-16-test-90deg contradicts its packets' timing, and is
  corrected here before the peer sees it (limpid sees the file as it is).
- The peer cuts scans between packets, limpid between blocks, where the azimuth wraps: the streams of points are compared.
- The peer calls the slot of single returns by the sensor's return mode, limpid "single".
- The beams cross in a point in front of the axis, so that z has an offset by laser (VLP-16 manual, table of vertical
  corrections, up to 11.2 mm; for the others the envelope drawings). Both derive it from the focal distance, the peer has
  rounded tables for the HDL-32E and the Puck Hi-Res. The calibrations that come with the peer as YAML files, like those
  of the ROS driver, leave it out.
- Between the blocks' azimuths both interpolate by the packet's mean rate of rotation, rounded to 0.01 degrees; the manual
  interpolates from each block to the next, which is the same but for the azimuths' own jitter.
"""

import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import dpkt
import numpy as np
import velodyne_decoder as vd
from mcap.reader import make_reader

TOLERANCE_M = 0.005
TOLERANCE_S = 2e-6
PACKET = 1206
SLOTS = {1: 4, 2: 2, 3: 3}  # the peer's strongest, last and both in limpid's numbers
SINGLE = 0
FIELDS = {"float": "<f4", "ushort": "<u2", "uchar": "u1", "uint": "<u4"}


def read_ply(path):
    head, data = path.read_bytes().split(b"end_header\n", 1)
    lines = [line.split() for line in head.decode().splitlines()]
    count = next(int(line[2]) for line in lines if line[0] == "element")
    dtype = [(line[2], FIELDS[line[1]]) for line in lines if line[0] == "property"]
    points = np.frombuffer(data, dtype=dtype)
    assert len(points) == count, path
    return points


def ours(limpid, recording, *options):
    """The points of all scans, and the number of the scan of each."""
    with tempfile.TemporaryDirectory() as folder:
        command = [limpid, "points", str(recording), "-o", folder, *options]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        scans = [read_ply(path) for path in sorted(Path(folder).glob("*.ply"))]
    names = ["x", "y", "z", "intensity", "ring", "return_type", "time_s"]
    points = np.concatenate([scan[names] for scan in scans])
    return points, np.repeat(np.arange(len(scans)), [len(scan) for scan in scans])


def theirs(packets, model):
    """The peer's points of stamped packets, with absolute times."""
    config = vd.Config()
    config.min_range, config.max_range, config.model = 0.0, 1e3, model
    decoder = vd.StreamDecoder(config)
    clouds = [decoder.decode(stamp, packet, True) for stamp, packet in packets]
    clouds.append(decoder.finish(True))
    clouds = [(stamp, points) for stamp, points in filter(None, clouds)]
    points = np.concatenate([points for _, points in clouds])
    times = np.concatenate([stamp.device + points["time"].astype(float) for stamp, points in clouds])
    return points, times


def faults(found, scans, expected, times, single):
    """What is wrong, in words; nothing where all agrees."""
    if len(found) != len(expected) or len(found) == 0:
        return [f"{len(found)} points in place of {len(expected)}"]
    slots = np.array([0, *(SINGLE if single else SLOTS[slot] for slot in (1, 2, 3))])[expected["return_type"]]
    apart = np.max([np.abs(found[axis] - expected[axis]) for axis in "xyz"])
    wrong = [] if apart <= TOLERANCE_M else [f"positions are {apart * 1e3:.1f} mm apart"]
    for name, other in [("intensity", expected["intensity"]), ("ring", expected["ring"]), ("return_type", slots)]:
        if not np.array_equal(found[name], other):
            wrong.append(f"{name} differs at {np.flatnonzero(found[name] != other)[0]}")
    # Scans' stamps are the host's times; within a scan all follows from the sensor's clock.
    starts = np.searchsorted(scans, scans)
    late = np.abs((found["time_s"] - found["time_s"][starts]) - (times - times[starts]))
    if not np.all(late <= TOLERANCE_S):
        wrong.append(f"times differ by {np.max(late) * 1e6:.1f} us")
    return wrong


def unnoticed(found, scans, expected, times, single):
    """The negative controls that pass for right."""
    def changed(name, by):
        other = found.copy()
        other[name][len(found) // 2] += by
        return other
    controls = {name: (changed(name, by), scans) for name, by in
                [("x", 0.006), ("y", -0.006), ("z", 0.006), ("intensity", 1), ("ring", 1), ("return_type", 1), ("time_s", 1e-5)]}
    controls["count"] = (found[:-1], scans[:-1])
    return [name for name, (other, of) in controls.items() if not faults(other, of, expected, times, single)]


def check(name, limpid, recording, packets, model=None):
    found, scans = ours(limpid, recording)
    expected, times = theirs(packets, model)
    single = packets[0][1][PACKET - 2] != 0x39
    wrong = faults(found, scans, expected, times, single)
    missed = [] if wrong else unnoticed(found, scans, expected, times, single)
    wrong += [f"the negative control `{control}` goes unnoticed" for control in missed]
    if not wrong:
        apart = np.max([np.abs(found[axis] - expected[axis]) for axis in "xyz"])
        print(f"ok    {name}: {len(found)} points of {scans[-1] + 1} scans, at most {apart * 1e3:.3f} mm apart")
    for fault in wrong:
        print(f"WRONG {name}: {fault}")
    return not wrong


def pcap_packets(path):
    return [(stamp, bytes(data)) for stamp, data in vd.util.iter_pcap(str(path)) if len(data) == PACKET]


def mcap_packets(path):
    packets = []
    with open(path, "rb") as file:
        for _, _, message in make_reader(file).iter_messages(topics=["/velodyne_packets"]):
            data = message.data
            at = 4 + 12 + struct.unpack_from("<I", data, 12)[0]
            at += -at % 4
            (count,) = struct.unpack_from("<I", data, at)
            at += 4
            for _ in range(count):
                at += -at % 4
                sec, nanosec = struct.unpack_from("<II", data, at)
                packets.append((sec + nanosec * 1e-9, data[at + 8 : at + 8 + PACKET]))
                at += 8 + PACKET
    return packets


def made_up(byte, mode, block_us, turns_per_s=10.0, count=200):
    """Packets of random measurements, on which the peer's factory byte can be relied."""
    random = np.random.default_rng(byte * 256 + mode)
    step = 2 if mode == 0x39 else 1
    packets = []
    for number in range(count):
        start_us = number * 12 // step * block_us
        packet = b""
        for block in range(12):
            azimuth = round((start_us + block // step * block_us) * 1e-6 * turns_per_s * 36000) % 36000
            distances = random.integers(0, 45000, 32) * (random.random(32) > 0.2)
            if step == 2 and block % 2 == 1:
                distances = np.where(random.random(32) > 0.1, before, distances)
            before = distances
            measured = zip(distances.tolist(), random.integers(0, 256, 32).tolist())
            packet += struct.pack("<HH", 0xEEFF, azimuth) + b"".join(struct.pack("<HB", *pair) for pair in measured)
        packets.append((1.7e9 + start_us * 1e-6, packet + struct.pack("<IBB", round(start_us), mode, byte)))
    return packets


def write_pcap(path, packets):
    with open(path, "wb") as file:
        writer = dpkt.pcap.Writer(file)
        for stamp, packet in packets:
            udp = dpkt.udp.UDP(sport=2368, dport=2368, data=packet)
            udp.ulen = len(udp)
            ip = dpkt.ip.IP(src=b"\xc0\xa8\x01\xc9", dst=b"\xff" * 4, p=dpkt.ip.IP_PROTO_UDP, data=udp)
            ip.len = len(ip)
            writer.writepkt(bytes(dpkt.ethernet.Ethernet(data=ip, type=dpkt.ethernet.ETH_TYPE_IP)), stamp)


def recordings(data):
    """All recordings with the packets that the peer is given."""
    lidar = Path(data) / "lidar"
    for path in sorted(lidar.glob("mrpt-*/*.pcap")) + sorted(lidar.glob("veloview-*/*.pcap")):
        packets = pcap_packets(path)
        if "vlp-16" in path.name:
            packets = [(stamp, packet[:-1] + b"\x22") for stamp, packet in packets]
        yield path, packets
    yield lidar / "vlp16-dual.mcap", mcap_packets(lidar / "vlp16-dual.mcap")


def sums(points, slots):
    """Figures that the tests compute too; checksums weigh each point by its number, from 1, modulo 1009."""
    weights = np.arange(1, len(points) + 1) % 1009
    checksum = lambda values: int(np.sum(weights * values.astype(np.int64)))
    axes = [points[axis].astype(float) for axis in "xyz"]
    return {
        "points": len(points),
        "sum_m": [axis.sum() for axis in axes],
        "sum_abs_m": [np.abs(axis).sum() for axis in axes],
        "intensity": checksum(points["intensity"]),
        "ring": checksum(points["ring"]),
        "return_type": checksum(slots),
    }


def cloud_points(path):
    from mcap_ros2.decoder import DecoderFactory

    kinds = {7: "<f4", 4: "<u2", 2: "u1"}
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, _, _, message in reader.iter_decoded_messages(topics=["/hesai/points"]):
            fields = message.fields
            names, offsets = [field.name for field in fields], [field.offset for field in fields]
            formats = [kinds[field.datatype] for field in fields]
            layout = {"names": names, "formats": formats, "offsets": offsets, "itemsize": message.point_step}
            yield np.frombuffer(bytes(message.data), dtype=np.dtype(layout))


def figures(data):
    found = {}
    for path, packets in recordings(data):
        points, _ = theirs(packets, None)
        single = packets[0][1][PACKET - 2] != 0x39
        slots = np.array([0, *(SINGLE if single else SLOTS[slot] for slot in (1, 2, 3))])[points["return_type"]]
        found[path.name] = sums(points, slots)
    clouds = np.concatenate(list(cloud_points(Path(data) / "lidar" / "3dref.mcap")))
    found["3dref.mcap"] = sums(clouds, clouds["return_type"])
    print(json.dumps(found, indent=1))


def main(limpid, data):
    results = [check(path.name, limpid, path, packets) for path, packets in recordings(data)]
    for name, byte, block_us in [("VLP-16", 0x22, 110.592), ("Puck Hi-Res", 0x24, 110.592), ("HDL-32E", 0x21, 46.08), ("VLP-32C", 0x28, 55.296)]:
        for mode in (0x37, 0x38, 0x39):
            with tempfile.TemporaryDirectory() as folder:
                path, packets = Path(folder) / "made-up.pcap", made_up(byte, mode, block_us)
                write_pcap(path, packets)
                results.append(check(f"made-up {name}, mode {mode:#x}", limpid, path, packets))
    if len(results) < 17 or not all(results):
        sys.exit(f"{results.count(False)} of {len(results)} comparisons failed")


if __name__ == "__main__":
    if sys.argv[1] == "figures":
        figures(sys.argv[2])
    else:
        main(*sys.argv[1:3])
