"""Real shanks: 22 nominal 10 m walks of three people, where the recordings are at hand.

Nothing here is tuned by the test; ``roll_share`` was calibrated on these very walks, so the
mean is a check that nothing drifted, and the spread is the measure.
"""

import os
from pathlib import Path

import numpy as np
import pytest

from gaitway.api import Stride
from gaitway_plugins.shank.estimator import ShankEstimator
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.published import PublishedEstimator

SHARED = Path(os.environ.get("GAITWAY_SHARED", Path(__file__).parents[4] / "shared"))
FILES = sorted((SHARED / "data").glob("shank10m_*.csv"))

if len(FILES) < 22:
    pytest.skip(
        "the real shank walks are not here: set GAITWAY_SHARED to see them",
        allow_module_level=True,
    )


@pytest.fixture(scope="module")
def walks(tools):
    found = []
    for path in FILES:
        _, ax, ay, az, gx, gy, gz = np.loadtxt(path, delimiter=",", skiprows=1).T
        # x up, y right, z forward becomes x forward, y left, z up.
        accel, gyro = np.stack([az, -ay, ax], axis=1), np.stack([gz, -gy, gx], axis=1)
        found.append(tools.Walk(accel, gyro, 0.01, 10.0, []))
    return found


def distances_m(tools, walks, make):
    return np.array([sum(tools.lengths_m(tools.said(make(), walk))) for walk in walks])


def test_the_default_measures_ten_metres_within_three_percent(tools, walks):
    found_m = distances_m(tools, walks, lambda: ShankEstimator(ShankParams()))
    assert 9.7 <= found_m.mean() <= 10.3
    assert found_m.std(ddof=1) <= 0.55


def test_nine_in_ten_walks_are_within_two_sigma(tools, walks):
    last = [tools.last_distance(tools.said(ShankEstimator(ShankParams()), w)) for w in walks]
    near = [abs(d.distance_m - 10.0) <= 1.96 * d.distance_sigma_m for d in last]
    assert sum(near) >= 20


def test_every_walk_has_its_strides_and_no_time_unmeasured(tools, walks):
    for walk in walks:
        events = tools.said(ShankEstimator(ShankParams()), walk)
        assert 8 <= sum(isinstance(event, Stride) for event in events) <= 10
        assert tools.last_distance(events).unmeasured_s == 0.0


@pytest.mark.parametrize(
    ("method", "mean_m", "sd_m"), [("wsi", 10.4, 2.3), ("s1", 8.2, 2.4), ("s2", 7.3, 1.6)]
)
def test_the_published_methods_do_as_badly_as_they_are_known_to(tools, walks, method, mean_m, sd_m):
    found_m = distances_m(tools, walks, lambda: PublishedEstimator(ShankParams(method=method)))
    assert found_m.mean() == pytest.approx(mean_m, abs=1.0)
    assert found_m.std(ddof=1) == pytest.approx(sd_m, abs=0.7)
