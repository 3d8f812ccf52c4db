import numpy as np
import pytest

from gaitway.simulation import Footfall, Leg, Person, RigidMotion, leg_motion
from gaitway.simulation.leg_motion import LANDING_S


def footfalls() -> list[Footfall]:
    steps = [Footfall(2.0, 2.75, 0.0, 0.0, 0.0, 0.0, 0.5)]
    for number, x_m in enumerate([0.65, 1.95, 3.25, 4.55]):
        contact_s = 3.2 + 1.15 * number
        push = 0.5 if number == 3 else 1.0
        reach = 0.5 if number == 0 else 1.0
        steps.append(Footfall(contact_s, contact_s + 0.7, x_m, 0.0, 0.0, reach, push))
    end_s = steps[-1].off_s + 0.45
    return [*steps, Footfall(end_s, end_s + 0.5, 5.2, 0.0, 0.0, 0.5, 0.0)]


LEG = Leg.draw(Person.draw(4), np.random.default_rng(4))


def motion(seed: int = 0) -> RigidMotion:
    return leg_motion(footfalls(), LEG, np.random.default_rng(seed))


def test_stands_before_and_after_where_it_is_told():
    ends_s = np.array([0.0, 2.0, 20.0])
    ankle_n = motion().position(ends_s)
    np.testing.assert_allclose(ankle_n[:, 0], [0.0, 0.0, 5.2], atol=1e-6)
    np.testing.assert_allclose(ankle_n[:, 2], LEG.sole.ankle_m, atol=1e-6)
    np.testing.assert_allclose(motion().position(ends_s, 1), np.zeros((3, 3)), atol=1e-9)
    np.testing.assert_allclose(motion().angles(ends_s, 1), np.zeros((3, 3)), atol=1e-9)


def test_velocity_is_the_derivative_of_position_through_stance_and_swing():
    t_s, step_s = np.arange(0.0, 10.0, 0.0007), 1e-6
    walking = motion()
    difference = (walking.position(t_s + step_s) - walking.position(t_s - step_s)) / (2 * step_s)
    np.testing.assert_allclose(walking.position(t_s, 1), difference, atol=1e-4)


def test_acceleration_does_not_jump_at_contact_landing_or_toe_off():
    walking = motion()
    for step in footfalls()[1:-1]:
        for moment_s in (step.contact_s, step.contact_s + LANDING_S, step.off_s):
            around_s = moment_s + np.array([-2e-5, -1e-5, -1e-6, 1e-6, 1e-5, 2e-5])
            velocity = walking.position(around_s, 1)
            before = (velocity[1] - velocity[0]) / 1e-5
            after = (velocity[5] - velocity[4]) / 1e-5
            assert np.abs(after - before).max() < 0.5


def test_a_planted_foot_keeps_the_ankle_in_its_place():
    walking = motion()
    for step in footfalls()[1:-1]:
        flat_s = step.at(0.0) + np.linspace(0.3, 0.55, 30) * (step.off_s - step.contact_s)
        ankle_n = walking.position(flat_s)
        assert np.abs(ankle_n[:, 0] - step.x_m).max() < 0.01
        assert np.abs(ankle_n[:, 2] - LEG.sole.ankle_m).max() < 0.005


def test_the_shank_rolls_over_the_planted_foot_without_stopping():
    walking = motion()
    for step in footfalls()[1:-1]:
        flat_s = step.contact_s + np.linspace(0.3, 0.9, 50) * (step.off_s - step.contact_s)
        pitch_rate = walking.angles(flat_s, 1)[:, 1]
        assert 0.3 < pitch_rate.min() < 1.6


def test_the_ankle_stays_above_the_floor_in_swing():
    walking = motion()
    for before, after in zip(footfalls()[:-1], footfalls()[1:], strict=True):
        swing_s = np.linspace(before.off_s, after.contact_s, 100)
        assert walking.position(swing_s)[:, 2].min() > 0.6 * LEG.sole.ankle_m


def test_steps_differ_from_draw_to_draw_but_feet_fall_where_told():
    mid_stance_s = np.array([step.at(0.4) for step in footfalls()[1:-1]])
    one, other = motion(0), motion(1)
    np.testing.assert_allclose(one.position(mid_stance_s), other.position(mid_stance_s), atol=0.003)
    swing_s = np.array([4.1])
    assert np.abs(one.angles(swing_s) - other.angles(swing_s)).max() > 1e-4


@pytest.mark.parametrize("height_m", [1.5, 1.9])
def test_a_tall_person_has_a_big_foot(height_m):
    person = Person(height_m, 1.0, 0.03, 0.03, 0.0, 0.0, 8.0, 1e-3)
    sole = Leg.draw(person, np.random.default_rng(0)).sole
    assert sole.heel_m + sole.ball_m == pytest.approx(0.77 * 0.152 * height_m)
    assert 0.039 * height_m < sole.ankle_m < 0.039 * height_m + 0.03
