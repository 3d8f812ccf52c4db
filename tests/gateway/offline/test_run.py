import math
from pathlib import Path

import numpy as np
import pytest

from gaitway.contracts import DeviceType, Trace
from gaitway.events import Anomaly, Distance, Stride
from gaitway.mounting import mount, rotation_from_mounting
from gaitway.offline.recording import OfflineRecording
from gaitway.offline.run import run_estimator, summarise
from gaitway.params import Params
from gaitway.samples import ACCEL, GYRO, Gap, SampleBatch

TURNED = rotation_from_mounting({"x": "up", "y": "right", "z": "forward"})


class Listener:
    """An estimator that notes what it is given and says so at the end."""

    look_ahead_s = 0.0

    def __init__(self):
        self.given = []

    def update(self, item):
        self.given.append(item)
        return [Anomaly(t_ns=len(self.given), anomaly="heard", detail="")]

    def finish(self):
        return [Anomaly(t_ns=0, anomaly="end", detail="")]

    def start_trace(self):
        return Trace()


def batch(n, sequence=0):
    values = np.random.default_rng(sequence).normal(size=(n, 3))
    t_ns = (np.arange(n) + sequence) * 10_000_000
    return SampleBatch(t_ns, 0.01, sequence, {"accel": values, "gyro": -values})


def recording(*items):
    return OfflineRecording(Path("walk.csv"), 0.01, items, frozenset({"accel", "gyro"}))


def device(summary=None):
    return DeviceType(
        "acme-cane", "", (ACCEL, GYRO), Params, lambda _: Listener(), summarise=summary
    )


def stride(length_m=0.7, duration_s=1.1, t_ns=10**9):
    return Stride(
        t_ns=t_ns,
        start_t_ns=0,
        stride_length_m=length_m,
        stride_length_sigma_m=0.02,
        stride_duration_s=duration_s,
        stride_duration_sigma_s=0.01,
        walking_speed_mps=1.0,
        walking_speed_sigma_mps=0.1,
    )


def distance(distance_m, strides):
    return Distance(
        t_ns=1, since_t_ns=0, distance_m=distance_m, distance_sigma_m=0.1, strides=strides,
        walking_s=9.0, unmeasured_s=0.0,
    )  # fmt: skip


def test_samples_come_in_batches_mounted_and_gaps_between_them_in_order():
    estimator, walk, gap = Listener(), batch(250), Gap(2_500_000_000, 3, "lost")
    run_estimator(estimator, recording(walk, gap, batch(5, sequence=253)), TURNED, batch=100)
    assert [len(item) if isinstance(item, SampleBatch) else item for item in estimator.given] == [
        100, 100, 50, gap, 5,
    ]  # fmt: skip
    given = np.concatenate([item.channels["accel"] for item in estimator.given[:3]])
    assert np.array_equal(given, mount(walk, TURNED).channels["accel"])
    assert [item.sequence for item in estimator.given[:3]] == [0, 100, 200]


def test_the_estimator_is_told_the_end_and_all_its_events_are_returned_in_order():
    events = run_estimator(Listener(), recording(batch(30)), TURNED, batch=10)
    assert [event.t_ns for event in events] == [1, 2, 3, 0]


def test_a_summary_takes_the_last_distance():
    events = [distance(0.7, 1), stride(0.7), distance(1.5, 2), stride(0.8)]
    assert summarise(device(), recording(batch(101)), events) == {
        "device": "acme-cane",
        "duration_s": 1.0,
        "walking_s": 9.0,
        "distance_m": 1.5,
        "distance_sigma_m": 0.1,
        "strides": 2,
        "stride_length_m": [0.7, 0.8],
    }


def test_without_a_stride_the_distance_is_zero_and_its_sigma_unknown():
    summary = summarise(device(), recording(batch(101)), [])
    assert (summary["distance_m"], summary["strides"], summary["walking_s"]) == (0.0, 0, 0)
    assert summary["distance_sigma_m"] is None
    assert summary["stride_length_m"] == []


def test_without_a_distance_the_strides_are_summed():
    summary = summarise(device(), recording(batch(101)), [stride(0.7), stride(0.8)])
    assert (summary["distance_m"], summary["strides"]) == (pytest.approx(1.5), 2)
    assert summary["walking_s"] == pytest.approx(2.2)
    assert summary["distance_sigma_m"] is None


def test_duration_counts_the_gaps():
    walk = recording(batch(100), Gap(10**9, 100, "lost"), batch(101, sequence=200))
    assert summarise(device(), walk, [])["duration_s"] == pytest.approx(3.0)
    assert walk.samples_lost == 100


def test_what_the_device_adds_is_in_and_what_is_not_finite_is_none():
    def more(events):
        return {"cadence_spm": math.nan, "phases": {"a": [1.0, math.inf]}, "events": len(events)}

    summary = summarise(device(more), recording(batch(101)), [stride()])
    assert summary["cadence_spm"] is None
    assert summary["phases"] == {"a": [1.0, None]}
    assert summary["events"] == 1
