"""What a training walk promises: the lever arm, or a refusal that says what to do better."""

import numpy as np
import pytest

from gaitway.api import CalibrationError, CalibrationPart, Gap, SampleBatch
from gaitway_plugins.ankle.params import AnkleParams, TrainingOptions
from gaitway_plugins.ankle.training import fit_lever


def in_imu_axes(tools, batch):
    turned = {name: batch.channels[name] @ tools.C_db for name in ("accel", "gyro")}
    return SampleBatch(batch.t_ns, batch.period_s, 0, {**batch.channels, **turned})


def fitted(tools, *items, **options):
    part = CalibrationPart(items, tools.C_db)
    return fit_lever(AnkleParams(), TrainingOptions(**options), [part])


def heel_items(tools, **options):
    return in_imu_axes(tools, tools.heel_batch(tools.heel(**{"distance_m": 3.0, **options})))


@pytest.mark.parametrize("lever_d", [(0.03, 0.0, 0.12), (0.0, 0.0, 0.25), (0.08, 0.0, 0.1)])
def test_finds_the_lever_arm_of_a_leg_that_turns_about_its_heel(tools, lever_d):
    found = fitted(tools, heel_items(tools, lever_d=lever_d, vary=0.0, seed=1))
    forward, _, up = lever_d
    assert found.params["lever_arm_m"][0] == pytest.approx(up, abs=0.012)
    assert found.params["lever_arm_m"][2] == pytest.approx(forward, abs=0.012)
    assert found.params["lever_arm_sigma_m"] < 0.03
    assert found.warnings == []


def test_the_axis_the_leg_turns_about_stays_where_a_sensor_can_be(tools):
    found = fitted(tools, heel_items(tools, bias_gyro=0.017, bias_accel=0.1, scale=5e-3, seed=2))
    assert abs(found.params["lever_arm_m"][1]) < 0.1


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_walk_of_a_rolling_foot_makes_the_next_one_accurate_to_two_percent(tools, seed):
    _, short = tools.simulated(distance_m=3.0, seed=seed)
    walk, batch = tools.simulated(distance_m=25.0, seed=seed, repetition=1)
    found = fitted(tools, in_imu_axes(tools, short))
    told = tools.distance(tools.said(tools.estimator(**found.params), batch))
    assert told.distance_m == pytest.approx(walk.distance_m, rel=0.02)
    assert abs(told.distance_m - walk.distance_m) < 1.96 * told.distance_sigma_m


def test_a_distance_told_somewhat_wrong_is_not_used(tools):
    items = heel_items(tools, vary=0.0, seed=1)
    found = fitted(tools, items, distance_m=3.7, distance_sigma_m=0.02)
    assert found.params["lever_arm_m"][0] == pytest.approx(0.12, abs=0.03)
    assert "was not used" in found.warnings[0]


def test_refuses_a_distance_that_can_not_be(tools):
    with pytest.raises(CalibrationError, match="distance_m"):
        fitted(tools, heel_items(tools, distance_m=8.0, seed=1))


def test_refuses_a_file_without_a_walk(tools):
    batch = heel_items(tools, seed=1)
    with pytest.raises(CalibrationError, match="0 strides"):
        fitted(tools, batch[:180])


def test_refuses_no_samples(tools):
    with pytest.raises(CalibrationError, match="no samples"):
        fitted(tools)


@pytest.mark.parametrize("where", ["before", "after"])
def test_refuses_a_walk_without_standing(tools, where):
    batch = heel_items(tools, distance_m=8.0, seed=1)
    part = batch[300:] if where == "before" else batch[: len(batch) - 330]
    with pytest.raises(CalibrationError, match=f"no standing {where}"):
        fitted(tools, part, distance_m=8.0)


def test_refuses_missing_samples(tools):
    batch = heel_items(tools, seed=1)
    gap = Gap(int(batch.t_ns[300]), 30, "lost")
    with pytest.raises(CalibrationError, match="missing"):
        fitted(tools, batch[:300], gap, batch[330:])


def test_refuses_a_clipped_walk(tools):
    batch = heel_items(tools, seed=1)
    accel = np.clip(batch.channels["accel"], -20.0, 20.0)
    clipped = SampleBatch(batch.t_ns, batch.period_s, 0, {**batch.channels, "accel": accel})
    with pytest.raises(CalibrationError, match="range"):
        fitted(tools, clipped)


def test_refuses_a_poor_fit(tools):
    batch = heel_items(tools, seed=1)
    gyro = batch.channels["gyro"].copy()
    gyro[:, 1] *= 1.0 + 0.25 * np.sin(np.arange(len(gyro)) / 30.0)
    wrong = SampleBatch(batch.t_ns, batch.period_s, 0, {**batch.channels, "gyro": gyro})
    with pytest.raises(CalibrationError):
        fitted(tools, wrong)
