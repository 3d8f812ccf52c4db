"""What things cost on this machine: ``make bench``.

Whole-process figures come from /proc, of a real daemon with two simulated devices at 100 Hz.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from gaitway.cli.demo import DEVICES, Demo
from gaitway.contracts import WalkPlan
from gaitway.mounting import mount, rotation_from_mounting
from gaitway.registry import load_registry
from gaitway.samples import Chunk, DeviceBatch, SampleBatch
from gaitway_drivers import gaitway_codecs

RATE_HZ = 100.0
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


def codec_table() -> None:
    """Print frames per second of each codec that can be simulated."""
    print("codec                frames per feed   frames/s    us/frame")
    channels = {"accel": np.array([0.1, 0.2, 9.8]), "gyro": np.array([0.01, 0.02, 0.03])}
    for codec_type in gaitway_codecs():
        for together in (1, 10, 100):
            codec = codec_type.make(codec_type.params.model_validate({"listen_only": True}))
            peripheral = codec_type.make_peripheral(RATE_HZ)
            frames = [peripheral.encode(index, channels) for index in range(20_000)]
            if not frames[0]:
                frames = _started(codec_type, channels)
            chunks = [
                Chunk(10_000_000 * start, b"".join(frames[start : start + together]))
                for start in range(0, len(frames), together)
            ]
            codec.start(0)
            began = time.perf_counter()
            decoded = sum(
                len(item) for chunk in chunks for item in codec.feed(chunk)
                if isinstance(item, DeviceBatch)
            )  # fmt: skip
            seconds = time.perf_counter() - began
            assert decoded == len(frames)
            rate = decoded / seconds
            print(f"{codec_type.name:20} {together:15} {rate:10.0f} {1e6 / rate:11.2f}")


def _started(codec_type, channels):
    """Return frames of a peripheral that was started by the codec's own handshake."""
    codec = codec_type.make(codec_type.params.model_validate({}))
    peripheral = codec_type.make_peripheral(RATE_HZ)
    t_ns = 0
    items = codec.start(t_ns)
    while not peripheral.encode(0, channels):
        for item in items:
            reply = peripheral.feed(item.payload) if hasattr(item, "payload") else b""
            items = codec.feed(Chunk(t_ns, reply)) if reply else []
        t_ns += 50_000_000
        items += codec.on_time(t_ns)
    return [peripheral.encode(index, channels) for index in range(20_000)]


def estimator_table() -> None:
    """Print what each estimator costs per sample, by batch size."""
    print("\nestimator            batch   us/sample")
    for device in load_registry().devices.values():
        if device.simulate is None:
            continue
        walk = device.simulate(WalkPlan(distance_m=60.0, seed=1))
        n = len(walk.pos_n)
        C_db = rotation_from_mounting(device.default_mounting)
        t_ns = (np.arange(n) * round(1e9 / RATE_HZ)).astype(np.int64)
        whole = mount(SampleBatch(t_ns, 1 / RATE_HZ, 0, walk.channels), C_db)
        for size in (1, 2, 10, n):
            estimator = device.make_estimator(device.params(), C_db)
            batches = [whole[start : start + size] for start in range(0, n, size)]
            began = time.perf_counter()
            for batch in batches:
                estimator.update(batch)
            seconds = time.perf_counter() - began
            print(f"{device.name:20} {size:5} {1e6 * seconds / n:11.1f}")


def daemon_table(seconds: float) -> None:
    """Print CPU share, memory and recording size of a daemon with two devices at 100 Hz."""
    with tempfile.TemporaryDirectory() as directory:
        demo = Demo(Path(directory) / "bench", 17447)
        demo.write_config()
        with demo.simulator(DEVICES[0], 1), demo.simulator(DEVICES[1], 2):
            began = time.perf_counter()
            with demo.gateway() as process:
                ready_s = time.perf_counter() - began
                time.sleep(10.0)
                before_s, bytes_before = _cpu_s(process.pid), _recorded(demo)
                time.sleep(seconds)
                cpu = (_cpu_s(process.pid) - before_s) / seconds
                grown = (_recorded(demo) - bytes_before) / seconds
                print("\ndaemon with two devices at 100 Hz, recording and publishing")
                print(f"  ready after          {ready_s:8.2f} s")
                print(f"  CPU, of one core     {100 * cpu:8.2f} %")
                print(f"  resident memory      {_rss_mb(process.pid):8.1f} MB")
                print(
                    f"  recording            {grown * 86400 / 2 / 1e9:8.3f} GB per device and day"
                )


def _cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_PER_S


def _rss_mb(pid: int) -> float:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * PAGE_BYTES / 1e6


def _recorded(demo: Demo) -> int:
    return sum(file.stat().st_size for file in demo.directory.glob("recordings/*"))


def start_up_table() -> None:
    """Print what importing and starting costs."""
    print("\ncommand                        seconds")
    for arguments in (["--version"], ["plugins"], ["check", "configs/gateway.toml"]):
        began = time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "gaitway", *arguments], check=True, capture_output=True
        )
        print(f"gaitway {' '.join(arguments):22} {time.perf_counter() - began:7.2f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=30.0, help="how long to watch the daemon")
    arguments = parser.parse_args()
    codec_table()
    estimator_table()
    start_up_table()
    daemon_table(arguments.seconds)
