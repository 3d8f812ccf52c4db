"""What the walker's calibrations find, and what they refuse."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from gaitway.api import CalibrationError, CalibrationPart
from gaitway.estimation.rotation import from_rotation_vector, to_matrix
from gaitway.mounting import mount
from gaitway_plugins.walker.calibration import CALIBRATIONS
from gaitway_plugins.walker.params import WalkerParams

ROLL, WHEELS = CALIBRATIONS


def fitted(calibration, *batches, params=None, **options):
    parts = [CalibrationPart([batch], np.eye(3)) for batch in batches]
    return calibration.fit(params or WalkerParams(), calibration.options(**options), parts)


def angle_deg(C, D):
    return np.degrees(np.arccos(np.clip((np.trace(C @ D.T) - 1.0) / 2.0, -1.0, 1.0)))


@pytest.mark.parametrize("seed", range(4))
def test_a_straight_roll_shows_how_the_sensor_sits_in_any_orientation(tools, seed):
    rng = np.random.default_rng(seed)
    C_db = to_matrix(from_rotation_vector(rng.uniform(-2.0, 2.0, 3).tolist()))
    walk = tools.moved(
        "continuous", steps=8, noise=0.02, seed=seed, modulation=0.1 * (seed % 2),
        gyro_bias=(0.01, -0.01, 0.01),
    )  # fmt: skip
    result = fitted(ROLL, mount(walk.batch(), C_db.T))
    assert angle_deg(result.mounting, C_db) < 1.5
    assert np.linalg.det(result.mounting) == pytest.approx(1.0)


def test_the_wheels_tell_forward_from_backward(tools):
    walk = tools.moved("continuous", steps=8)
    for side in ("left_ticks", "right_ticks"):
        walk.channels[side] = -walk.channels[side]
    assert angle_deg(fitted(ROLL, walk.batch()).mounting, np.diag([-1.0, -1.0, 1.0])) < 1.0


def rolled(tools, rest_s=2.0, length_m=3.0, yaw_rad=0.0, **changes):
    hand = tools.Hand()
    hand.go(rest_s)
    hand.go(5.0, roll=tools.hump(length_m), yaw=tools.hump(yaw_rad))
    hand.go(rest_s)
    return tools.sensed(hand, **changes).batch()


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"length_m": 1.0}, "at least 2 m"),
        ({"yaw_rad": 0.2}, "crooked"),
        ({"rest_s": 0.0}, "standing before and after"),
        ({"length_m": 6.0, "radius_m": 0.1}, "wheel_radius_m"),
    ],
    ids=str,
)
def test_a_roll_that_will_not_do_is_refused_with_its_reason(tools, changes, why):
    with pytest.raises(CalibrationError, match=why):
        fitted(ROLL, rolled(tools, **changes))


def test_a_wheel_that_is_not_counted_is_refused(tools):
    batch = rolled(tools)
    batch.channels["left_ticks"][:] = 0.0
    with pytest.raises(CalibrationError, match="one is stuck"):
        fitted(ROLL, batch)


def spun(tools, turns=2.0, **changes):
    hand = tools.Hand()
    hand.go(2.0)
    hand.go(3.0 * turns, yaw=tools.trapeze(2.0 * np.pi * turns))
    hand.go(2.0)
    return tools.sensed(hand, **changes).batch()


def test_wheels_are_measured_by_a_distance_and_a_turn_on_the_spot(tools):
    true = {"radius_m": 0.0635 * 1.02, "track_m": 0.59}
    result = fitted(WHEELS, rolled(tools, **true), spun(tools, **true), distance_m=3.0)
    assert result.params["wheel_radius_m"] == pytest.approx(true["radius_m"], rel=0.002)
    assert result.params["track_m"] == pytest.approx(true["track_m"], rel=0.005)
    assert result.params["wheel_shared_sigma"] < 0.0045
    WalkerParams(**result.params)


def test_turns_may_be_counted_instead_of_integrated(tools):
    batch = spun(tools, track_m=0.59)
    batch.channels["gyro"][:] *= 1.02
    assert fitted(WHEELS, batch, turns=2.0).params["track_m"] == pytest.approx(0.59, rel=0.005)


@pytest.mark.parametrize(
    ("distance_m", "turns", "why"),
    [(9.0, 2.0, "check wheel_radius_m"), (None, 0.3, "half a turn"), (1.0, 2.0, "at least 2 m")],
)
def test_wheels_that_can_not_be_are_refused(tools, distance_m, turns, why):
    with pytest.raises(CalibrationError, match=why):
        fitted(WHEELS, rolled(tools), spun(tools, turns), distance_m=distance_m)


def test_nothing_to_fit_is_refused(tools):
    with pytest.raises(CalibrationError, match="nothing to fit"):
        fitted(WHEELS, rolled(tools))


def test_fits_are_drawn(tools):
    for result in (fitted(ROLL, rolled(tools)), fitted(WHEELS, spun(tools))):
        figure = Figure()
        result.picture(figure)
        assert figure.axes[0].lines
