"""A real daemon with two simulated devices at 100 Hz: figures of the whole process from /proc."""

import os
import tempfile
import time
from pathlib import Path

from gaitway.cli.demo import DEVICES, Demo

TICKS_PER_S = os.sysconf("SC_CLK_TCK")
PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


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
