"""The parts by themselves: piecewise line, contact detector, what a leaning sensor reads."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from gaitway.api import Bout
from gaitway.estimation import ATT, GYRO_BIAS, rotation
from gaitway_plugins.crutch_tip.books import Books, Pitches
from gaitway_plugins.crutch_tip.force import ContactDetector, piecewise_line
from gaitway_plugins.crutch_tip.inclination import expected_lean, vertical_d
from gaitway_plugins.crutch_tip.params import (
    PAPER_KNOTS_NEWTON,
    PAPER_KNOTS_VOLT,
    CrutchTipParams,
)
from gaitway_plugins.crutch_tip.stances import ForceMeter, Stance
from gaitway_plugins.crutch_tip.tilt import Tilt, turned_back


@given(steps=st.lists(st.tuples(st.floats(0.01, 5.0), st.floats(0.01, 500.0)), min_size=2))
def test_a_piecewise_line_goes_through_its_knots_and_back(steps):
    x, y = np.cumsum(steps, axis=0).T
    np.testing.assert_allclose(piecewise_line(x, x, y), y, rtol=1e-9)
    at = np.linspace(x[0] - 1.0, x[-1] + 1.0, 40)
    there = piecewise_line(at, x, y)
    assert (np.diff(there) > 0.0).all()
    np.testing.assert_allclose(piecewise_line(there, y, x), at, atol=1e-6)


@pytest.mark.parametrize(
    ("volt", "slope", "offset"),
    [(0.3, 149.102, 17.7974), (0.7, 325.658, -69.3642), (1.5, 257.714, -10.2081)],
)
def test_the_paper_s_three_lines_are_the_default(volt, slope, offset):
    newton = piecewise_line(
        np.array([volt]), np.array(PAPER_KNOTS_VOLT), np.array(PAPER_KNOTS_NEWTON)
    )
    assert newton[0] == pytest.approx(slope * volt + offset, abs=0.1)


@pytest.mark.parametrize(
    "knots", [{"force_knots_volt": (0.0, 1.0)}, {"force_knots_newton": (0.0, 1.0, 1.0, 2.0)}]
)
def test_knots_that_make_no_line_are_refused(knots):
    with pytest.raises(ValidationError, match="knots"):
        CrutchTipParams(**knots)


forces = st.lists(st.sampled_from([0.0, 21.0, 24.0, 26.0, 100.0]), min_size=1, max_size=120)


@given(forces=forces, hold=st.integers(1, 6), cuts=st.lists(st.integers(0, 120), max_size=4))
@settings(max_examples=200)
def test_edges_alternate_last_and_do_not_depend_on_how_forces_come(forces, hold, cuts):
    whole = ContactDetector(25.2, hold)
    edges = whole.extend(np.array(forces))
    assert [edge.loaded for edge in edges] == [number % 2 == 0 for number in range(len(edges))]
    samples = [edge.sample for edge in edges]
    assert samples == sorted(samples)
    for edge in edges:
        assert (forces[edge.sample] >= 25.2) == edge.loaded
    parted = ContactDetector(25.2, hold)
    bounds = [0, *sorted(cut for cut in cuts if cut < len(forces)), len(forces)]
    told = [
        edge
        for start, stop in pairwise(bounds)
        for edge in parted.extend(np.array(forces[start:stop]))
    ]
    assert told == edges


def test_a_bounce_is_no_contact():
    detector = ContactDetector(25.2, 6)
    assert detector.extend(np.array([0.0] * 10 + [80.0] * 5 + [0.0] * 10)) == []


def test_contact_and_lift_are_where_the_force_passes_the_same_threshold():
    force = np.concatenate([np.arange(0.0, 100.0), np.arange(100.0, 0.0, -1.0)])
    contact, lift = ContactDetector(25.2, 3).extend(force)
    assert force[contact.sample - 1] < 25.2 <= force[contact.sample]
    assert force[lift.sample] < 25.2 <= force[lift.sample - 1]


def test_a_force_about_the_threshold_does_not_flicker():
    force = np.array([0.0] * 5 + ([26.0] * 9 + [23.0] * 9) * 5)
    assert len(ContactDetector(25.2, 3).extend(force)) == 1


@given(cuts=st.lists(st.integers(1, 99), max_size=5))
def test_a_stance_s_force_is_the_same_however_it_comes(cuts):
    force = np.random.default_rng(2).uniform(30.0, 300.0, 100)
    told = []
    for edges in ([0, 100], [0, *sorted(set(cuts)), 100]):
        stance, meter = Stance(0, 0), ForceMeter(0.01, 5)
        meter.begin()
        for start, stop in pairwise(edges):
            meter.measure(stance, force[start:stop])
        told.append((stance.peak_newton, stance.rate_newtonps, stance.count))
        assert stance.mean_newton == pytest.approx(force.mean())
    assert told[0] == pytest.approx(told[1])


def test_a_step_that_is_stood_on_for_long_counts_once_and_in_the_bout_it_ends():
    books, events = Books(CrutchTipParams()), []
    pitches = Pitches(-0.3, 0.01, 0.3, 0.01)
    for number in range(6):
        stance = Stance(0, number * 2_000_000_000, lift_ns=number * 2_000_000_000 + 1_000_000_000)
        if number == 2:
            events += books.standing(stance, pitches)
        events += books.stance(stance, pitches)
    events += books.close()
    bouts = [event for event in events if isinstance(event, Bout) and event.phase == "end"]
    assert [bout.strides for bout in bouts] == [2, 3]


def test_a_planted_sensor_feels_its_own_turning():
    """Against the second derivative of the way of a point on a pendulum."""
    dt, height_m = 1e-3, 0.2
    t_s = np.arange(0.0, 1.0, dt)
    theta = 0.4 * np.sin(3.0 * t_s)
    x, z = height_m * np.sin(theta), height_m * np.cos(theta)
    ax, az = (np.gradient(np.gradient(way, dt), dt) for way in (x, z))
    felt = ax * np.cos(theta) - (az + 9.80665) * np.sin(theta)
    q = np.column_stack([np.cos(theta / 2), 0 * theta, np.sin(theta / 2), 0 * theta])
    gyro = np.column_stack([0 * theta, np.gradient(theta, dt), 0 * theta])
    lean = expected_lean(q, gyro, dt, np.zeros((len(t_s), 2)), height_m)
    np.testing.assert_allclose(lean[5:-5, 0], felt[5:-5] / 9.80665, atol=1e-4)


def test_a_late_sensor_tells_of_before():
    dt, late_s = 1e-3, 0.01
    theta = 0.5 * np.arange(0.0, 1.0, dt)
    q = np.column_stack([np.cos(theta / 2), 0 * theta, np.sin(theta / 2), 0 * theta])
    gyro = np.tile([0.0, 0.5, 0.0], (len(theta), 1))
    lean = expected_lean(q, gyro, dt, np.full((len(theta), 2), late_s), 0.0)
    np.testing.assert_allclose(lean[:, 0], -np.sin(theta - 0.5 * late_s), atol=1e-4)


def test_turning_back_undoes_half_a_sample():
    q = np.array([[1.0, 0.0, 0.0, 0.0]])
    back = turned_back(q, np.array([[0.0, 0.02, 0.0]]))
    np.testing.assert_allclose(back, [[np.cos(0.01), 0.0, -np.sin(0.01), 0.0]], atol=1e-6)


def test_the_inclination_s_jacobian_is_that_of_differences():
    """Errors of attitude and gyroscope bias now, against the vertical some time ago.

    The bias' column takes the attitude as it was then, hence its tolerance.
    """
    period_s, rate, age = 0.01, np.array([0.3, -0.8, 0.5]), 25
    tilt = Tilt(CrutchTipParams(imu_sample="interval"), period_s)
    tilt.begin(np.array([0.2, -0.1]))
    path = tilt.move(np.tile(rate, (50, 1)))
    middle, now = path[-1 - age], path[-1].tolist()
    H = tilt.measurement(middle, np.zeros(2), age * period_s, 1.0).H

    def before(turn_n, bias_d):
        """Return the vertical's lean then, if attitude now and bias are wrong by so much."""
        true = rotation.multiply(rotation.from_rotation_vector(turn_n), now)
        back = rotation.from_rotation_vector((-(rate - bias_d) * age * period_s).tolist())
        return vertical_d(np.array([rotation.multiply(true, back)]))[0, :2]

    step = 1e-5
    for column in range(3):
        error = step * np.eye(3)[column]
        by_turn = (before(error.tolist(), 0.0) - before((-error).tolist(), 0.0)) / (2.0 * step)
        by_bias = (before([0.0] * 3, error) - before([0.0] * 3, -error)) / (2.0 * step)
        np.testing.assert_allclose(H[:, ATT][:, column], by_turn, atol=1e-4)
        np.testing.assert_allclose(H[:, GYRO_BIAS][:, column], by_bias, atol=0.1 * age * period_s)
