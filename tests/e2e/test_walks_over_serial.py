"""Walks through the serial line and the daemon give the strides that ``estimate`` gives."""

import json
import os
import threading
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from gaitway.cli import main
from gaitway.contracts import SimulatedWalk
from gaitway.events import Stride
from gaitway.recording.reader import read
from gaitway.samples import ACCEL, GYRO, frozen_rows
from gaitway.testing.simulated_device import SimulatedDevice
from gaitway.timebase import HostClock
from gaitway_drivers import gaitway_codecs

ROOT = Path(__file__).parents[2]
SHARED = Path(os.environ.get("GAITWAY_SHARED", ROOT.parent / "shared"))
WALKS = sorted((SHARED / "data").glob("shank10m_*.csv"))
FLOAT32_M = 0.001
"""Xbus carries float32, a CSV decimals: a stride may differ by rounding, not by a millimetre."""


def recorded_walk(file):
    """Return a CSV file as something to play; its truth is not used."""
    rows = np.loadtxt(file, delimiter=",", skiprows=1)
    n = len(rows)
    none = np.zeros(0)
    return SimulatedWalk(
        rate_hz=round(1 / float(np.median(np.diff(rows[:, 0])))),
        channels={
            ACCEL.name: frozen_rows(rows[:, 1:4], 3),
            GYRO.name: frozen_rows(rows[:, 4:7], 3),
        },
        stride_start_s=none,
        stride_end_s=none,
        stride_length_m=none,
        pos_n=np.zeros((n, 3)),
        q_nb=np.zeros((n, 4)),
    )


def play_all(gateway, files, device_type):
    """Play every file to the daemon at the same time, each on a port of its own."""
    (xbus,) = gaitway_codecs()
    names = {f"w{number}": file for number, file in enumerate(files)}
    gateway.set("resume = { within_s = 0 }")  # the stop ends the walk, as a file's end does
    with ExitStack() as stack:
        threads = []
        for name, file in names.items():
            link = gateway.directory / "ports" / name
            walk = recorded_walk(file)
            device = stack.enter_context(
                SimulatedDevice(link, xbus.make_peripheral(walk.rate_hz), HostClock())
            )
            gateway.add_device(name, device_type, link)
            threads.append(threading.Thread(target=device.play, args=(walk,)))
        gateway.start()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        gateway.stop()
    return names


def live_strides(gateway, name):
    return [
        item.body.stride_length_m
        for file in gateway.recordings
        for item in read(file)
        if item.device == name and isinstance(item.body, Stride)
    ]


def assert_live_equals_estimate(gateway, names, device_type, capsys):
    different = []
    total = 0
    for name, file in names.items():
        assert main(["estimate", str(file), "--device", device_type, "--json"]) == 0
        expected = json.loads(capsys.readouterr().out)["stride_length_m"]
        actual = live_strides(gateway, name)
        total += len(expected)
        if len(actual) != len(expected) or not np.allclose(actual, expected, atol=FLOAT32_M):
            different.append((file.name, expected, actual))
    assert different == []
    assert total > 0


@pytest.mark.slow
@pytest.mark.parametrize("device_type", ["quad-cane", "shank"])
def test_simulated_walks_are_the_same_live_and_offline(gateway, capsys, tmp_path, device_type):
    files = []
    for seed in range(3):
        files.append(tmp_path / f"walk{seed}.csv")
        options = ["--distance", "4", "--rest", "2", "--seed", str(seed)]
        assert main(["simulate", device_type, "--csv", str(files[-1]), *options]) == 0
    capsys.readouterr()
    names = play_all(gateway, files, device_type)
    assert_live_equals_estimate(gateway, names, device_type, capsys)


@pytest.mark.slow
@pytest.mark.skipif(not WALKS, reason="the real shank walks are not here (GAITWAY_SHARED)")
def test_real_shank_walks_are_the_same_live_and_offline(gateway, capsys):
    names = play_all(gateway, WALKS, "shank")
    assert_live_equals_estimate(gateway, names, "shank", capsys)
