from typing import get_args

import numpy as np
import pytest

from gaitway.contracts import WalkPlan
from gaitway.simulation import GRAVITY_MPS2, NonWalking, non_walking

KINDS = get_args(NonWalking)
PLAN = WalkPlan(distance_m=0.0, seed=3, rest_s=2.0, ideal_sensor=True)


@pytest.mark.parametrize("kind", KINDS)
def test_no_kind_has_a_stride(kind):
    walk = non_walking(PLAN, kind)
    assert walk.distance_m == 0.0
    assert len(walk.stride_start_s) == len(walk.stride_end_s) == 0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [1, 2])
def test_every_kind_begins_and_ends_at_rest(kind, seed):
    walk = non_walking(WalkPlan(0.0, seed=seed, rest_s=2.0, ideal_sensor=True), kind)
    for ends in (slice(0, 195), slice(-195, None)):
        force = np.linalg.norm(walk.channels["accel"][ends], axis=1)
        np.testing.assert_allclose(force, GRAVITY_MPS2, atol=1e-6)
        np.testing.assert_allclose(walk.channels["gyro"][ends], 0.0, atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_lasts_as_long_as_told(kind):
    walk = non_walking(PLAN, kind, duration_s=11.0)
    assert len(walk.pos_n) == 1501


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("still", "lying")])
def test_something_happens_in_between(kind):
    walk = non_walking(PLAN, kind)
    assert np.abs(walk.channels["gyro"]).max() > 0.05


def test_only_being_carried_leads_away():
    for kind in KINDS:
        way = non_walking(PLAN, kind).pos_n
        distance_m = np.linalg.norm(way[-1] - way[0])
        assert distance_m > 5.0 if kind == "carried" else distance_m < 1e-6


def test_a_device_that_lies_feels_gravity_across_its_length():
    accel = non_walking(PLAN, "lying").channels["accel"][100]
    assert abs(accel[0]) < 0.1 * GRAVITY_MPS2


def test_turning_on_the_spot_turns_a_lot():
    walk = non_walking(PLAN, "turning-on-the-spot")
    turned_rad = abs(walk.channels["gyro"][:, 0].sum()) / walk.rate_hz
    assert turned_rad > np.pi


def test_takes_the_mounting_it_is_given():
    upright = {"x": "forward", "y": "left", "z": "up"}
    walk = non_walking(PLAN, "still", mounting=upright)
    assert walk.channels["accel"][0, 2] > 0.99 * GRAVITY_MPS2
