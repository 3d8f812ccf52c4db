import numpy as np
import pytest

from gaitway.simulation import Sole

SOLE = Sole(
    ankle_m=0.085,
    heel_m=0.045,
    ball_m=0.15,
    heel_radius_m=0.025,
    ball_radius_m=0.045,
    softness_m=0.002,
)
PITCHES = np.linspace(-0.6, 1.5, 211)


def test_a_flat_foot_has_the_ankle_at_its_height_over_where_it_is():
    flat = np.zeros(1)
    assert SOLE.height(flat)[0] == pytest.approx(SOLE.ankle_m)
    assert SOLE.advance(flat)[0] == pytest.approx(0.0, abs=1e-12)


def test_rolls_without_slipping():
    step_rad = 1e-6
    forward = (SOLE.advance(PITCHES + step_rad) - SOLE.advance(PITCHES - step_rad)) / (2 * step_rad)
    up = (SOLE.height(PITCHES + step_rad) - SOLE.height(PITCHES - step_rad)) / (2 * step_rad)
    # The point of contact stands still: the ankle's velocity is pitch rate x (contact to ankle).
    np.testing.assert_allclose(forward, SOLE.height(PITCHES), atol=1e-8)
    np.testing.assert_allclose(up, SOLE.slope(PITCHES), atol=1e-7)


def lowest_of_arc(pitch, centre_x, radius):
    """Ankle height and contact ahead of the ankle when standing on an arc, by plain geometry."""
    x, z = centre_x, radius - SOLE.ankle_m
    turned_x = x * np.cos(pitch) + z * np.sin(pitch)
    turned_z = -x * np.sin(pitch) + z * np.cos(pitch)
    return radius - turned_z, turned_x


@pytest.mark.parametrize("pitch", [-0.4, -0.2])
def test_stands_on_the_heel_with_the_toes_up(pitch):
    height, ahead = lowest_of_arc(pitch, -SOLE.heel_m, SOLE.heel_radius_m)
    assert SOLE.height(np.array([pitch]))[0] == pytest.approx(height, abs=0.0015)
    assert SOLE.slope(np.array([pitch]))[0] == pytest.approx(ahead, abs=1e-3)


@pytest.mark.parametrize("pitch", [0.2, 0.8, 1.3])
def test_stands_on_the_ball_with_the_heel_up(pitch):
    height, ahead = lowest_of_arc(pitch, SOLE.ball_m, SOLE.ball_radius_m)
    assert SOLE.height(np.array([pitch]))[0] == pytest.approx(height, abs=0.0015)
    assert SOLE.slope(np.array([pitch]))[0] == pytest.approx(ahead, abs=1e-3)


def test_contact_moves_from_heel_to_ball_within_the_flat_range():
    ahead = SOLE.slope(np.array([-3.0, 0.0, 3.0]) * SOLE.flat_rad)
    assert ahead[0] == pytest.approx(-SOLE.heel_m, abs=0.01)
    assert ahead[1] == pytest.approx(0.5 * (SOLE.ball_m - SOLE.heel_m), abs=1e-9)
    assert ahead[2] == pytest.approx(SOLE.ball_m, abs=0.01)
