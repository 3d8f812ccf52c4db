"""The paper's methods: the arithmetic on signals that can be integrated by hand."""

import numpy as np
import pytest

from gaitway.api import Anomaly, Stride
from gaitway_plugins.shank.integration import Signals, Stepwise, WholeSignal, trapezoid
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.published import PublishedEstimator

METHODS = ("wsi", "s1", "s2", "s3")


class Raw(Signals):
    """Signals that come as they are, not filtered."""

    def __init__(self, accel_mps2, rate_radps, period_s=0.01):
        super().__init__(ShankParams(), period_s)
        self._rows = list(zip(accel_mps2.tolist(), rate_radps.tolist(), strict=True))
        self._t_ns = [round(i * period_s * 1e9) for i in range(len(self._rows))]


def test_the_trapezoid_rule_integrates_a_straight_line_exactly():
    t = np.arange(0.0, 1.0, 0.01)
    assert trapezoid(3.0 * t, 0.01) == pytest.approx(1.5 * t**2)


def test_stepwise_raises_velocity_to_a_share_of_its_mean():
    t = np.arange(0.0, 1.005, 0.01)
    velocity = 1.0 - np.cos(2 * np.pi * t)
    signals = Raw(np.gradient(velocity, 0.01), np.zeros_like(t))
    length_m = Stepwise(signals, "s1", 0.15)._length_m(0, 100)
    # mean of 1 - cos is 1 m/s; with v_min = 0.15 mean the mean is 1 / 0.85
    assert length_m == pytest.approx(1.0 / 0.85, rel=2e-3)


@pytest.mark.parametrize(("method", "expected"), [("s1", 150), ("s2", 130), ("s3", 120)])
def test_a_stride_begins_at_the_feature_of_its_method(method, expected):
    at = np.arange(300.0)
    rate = 5.0 * np.exp(-(((at - 150) / 8) ** 2)) - 3.0 * np.exp(-(((at - 120) / 5) ** 2))
    accel = -9.0 * np.exp(-(((at - 130) / 3) ** 2))
    method = Stepwise(Raw(accel, rate), method, 0.15)
    assert method._feature(140, 170) == expected


@pytest.mark.parametrize("drift_mps2", [-0.3, 0.3], ids=["minimum last", "minimum first"])
def test_whole_signal_adds_up_to_the_whole_wherever_the_minimum_comes(drift_mps2):
    t = np.arange(0.0, 4.0, 0.01)
    accel = drift_mps2 - 2.0 * np.cos(2 * np.pi * t)
    method = WholeSignal(Raw(accel, np.zeros_like(t)))
    steps = []
    for toe_off, contact in ((60, 100), (160, 200), (260, 300)):
        steps += method.swing(toe_off, contact)
    steps += method.stop()
    begin, end = steps[0][0], steps[-1][1]
    velocity = trapezoid(accel[begin : end + 1], 0.01)
    whole_m = trapezoid(velocity - velocity.min(), 0.01)[-1]
    assert sum(length_m for _, _, length_m in steps) == pytest.approx(whole_m)
    assert [step[1] for step in steps[:-1]] == [100, 200]


@pytest.mark.parametrize("method", METHODS)
def test_the_size_of_batches_changes_nothing(tools, method):
    walk = tools.walk(noise=0.05)

    def events(*cuts):
        return tools.said(PublishedEstimator(ShankParams(method=method)), walk, cuts)

    whole = events()
    assert sum(isinstance(event, Stride) for event in whole) >= 5
    assert events(*range(1, len(walk))) == whole
    assert events(*range(37, len(walk), 37)) == whole


@pytest.mark.parametrize("method", METHODS)
def test_standing_gives_nothing(tools, method):
    accel = np.random.default_rng(4).normal(0.0, 0.1, (2000, 3)) + np.array([0.3, 0.0, 9.8])
    walk = tools.Walk(accel, np.zeros((2000, 3)), 0.01, 0.0, [])
    assert tools.said(PublishedEstimator(ShankParams(method=method)), walk) == []


@pytest.mark.parametrize("method", METHODS)
def test_a_gap_while_walking_is_said_and_counted_as_unmeasured(tools, method):
    walk = tools.walk(strides=8)
    est = PublishedEstimator(ShankParams(method=method))
    events = tools.said_with_gap(est, walk, walk.toe_offs[3] + 15, 20)
    assert [e.anomaly for e in events if isinstance(e, Anomaly)] == ["gap-in-stride"]
    assert tools.last_distance(events).unmeasured_s > 0.2


@pytest.mark.parametrize("method", METHODS)
def test_every_stride_is_told_within_the_look_ahead(tools, method):
    walk, est = tools.walk(), PublishedEstimator(ShankParams(method=method))
    waits_s = [
        (at * 1e7 - event.t_ns) / 1e9
        for at in range(len(walk))
        for event in est.update(walk.batch(at, at + 1))
        if isinstance(event, Stride)
    ]
    assert waits_s
    assert max(waits_s) <= est.look_ahead_s


def test_the_trace_holds_the_filtered_signals_of_every_sample(tools):
    walk, est = tools.walk(), PublishedEstimator(ShankParams(method="s1"))
    trace = est.start_trace()
    tools.said(est, walk)
    rows = np.array(trace.rows)
    assert len(rows) == len(walk)
    # The filter takes the mean off and leaves a swing's height nearly as it is.
    swing = -walk.gyro[walk.toe_offs[1] : walk.toe_offs[4], 1]
    assert rows[walk.toe_offs[1] : walk.toe_offs[4], 1].max() == pytest.approx(
        swing.max(), rel=0.15
    )
