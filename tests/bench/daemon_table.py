"""A real daemon with six simulated devices at 100 Hz: figures of the whole process from /proc."""

import contextlib
import os
import tempfile
import time
from pathlib import Path

from gaitway.cli.demo import Demo

DEVICES = {
    "quad-cane-left": "quad-cane",
    "quad-cane-right": "quad-cane",
    "standard-cane": "standard-cane",
    "ankle": "ankle",
    "shank-left": "shank",
    "shank-right": "shank",
}
"""Those whose channels an MTi carries: crutch tip and walker have no wire format yet."""

TICKS_PER_S = os.sysconf("SC_CLK_TCK")
PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


def daemon_table(seconds: float) -> None:
    """Print CPU share, memory and recording size of a daemon with six devices at 100 Hz."""
    with tempfile.TemporaryDirectory() as directory, contextlib.ExitStack() as stack:
        demo = Demo(Path(directory) / "bench", 17447, DEVICES)
        demo.write_config()
        for seed, device in enumerate(DEVICES, 1):
            stack.enter_context(demo.simulator(device, seed))
        began = time.perf_counter()
        process = stack.enter_context(demo.gateway())
        ready_s = time.perf_counter() - began
        time.sleep(10.0)
        before_s, bytes_before = _cpu_s(process.pid), _recorded(demo)
        time.sleep(seconds)
        cpu = (_cpu_s(process.pid) - before_s) / seconds
        grown = (_recorded(demo) - bytes_before) / seconds / len(DEVICES)
        print(f"\ndaemon with {len(DEVICES)} devices at 100 Hz, recording and publishing")
        print(f"  ready after          {ready_s:8.2f} s")
        print(f"  CPU, of one core     {100 * cpu:8.2f} %   (aim: below 10)")
        print(f"  resident memory      {_rss_mb(process.pid):8.1f} MB  (aim: below 100)")
        print(f"  recording            {grown * 86400 / 1e9:8.3f} GB per device and day")


def _cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_PER_S


def _rss_mb(pid: int) -> float:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * PAGE_BYTES / 1e6


def _recorded(demo: Demo) -> int:
    return sum(file.stat().st_size for file in demo.directory.glob("recordings/*"))
