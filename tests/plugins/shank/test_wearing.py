"""A sensor that was strapped on otherwise than configured."""

import numpy as np
import pytest

from gaitway.api import Anomaly
from gaitway_plugins.shank.estimator import ShankEstimator
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.wearing import swing_axis

WALK = {"strides": 24}
TURNS = {
    "twisted by 60 degrees": [[0.5, 0.866, 0.0], [-0.866, 0.5, 0.0], [0.0, 0.0, 1.0]],
    "backward": [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
    "upside down": [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
    "on its side": [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
}


def mounted_awry(tools, turn):
    walk = tools.walk(**WALK)
    turn = np.array(turn)
    return tools.Walk(walk.accel @ turn.T, walk.gyro @ turn.T, 0.01, walk.distance_m, [])


def anomalies(events):
    return [event.anomaly for event in events if isinstance(event, Anomaly)]


@pytest.mark.parametrize("turn", TURNS.values(), ids=TURNS)
def test_another_mounting_is_said_once_and_measured_all_the_same(tools, turn):
    walk = mounted_awry(tools, turn)
    events = tools.said(ShankEstimator(ShankParams()), walk)
    assert anomalies(events).count("not-mounted-as-configured") == 1
    lengths_m = tools.lengths_m(events)
    # Until the axis is known, eight seconds, strides may go unseen.
    assert len(lengths_m) >= 14
    assert np.median(lengths_m) == pytest.approx(walk.distance_m / 24, rel=0.05)


def test_of_the_configured_mounting_nothing_is_said(tools):
    events = tools.said(ShankEstimator(ShankParams()), tools.walk(yaw_rad=0.4, **WALK))
    assert anomalies(events) == []


def test_a_leg_that_swings_to_and_fro_alike_has_no_direction():
    rate = 3.0 * np.sin(np.arange(400) * 0.05)
    gyro = np.stack([0.0 * rate, rate, 0.0 * rate], axis=1)
    assert swing_axis(gyro, np.array([0.0, 0.0, 9.8])) is None
