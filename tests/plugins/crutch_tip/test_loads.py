"""What is told of loads and of walking."""

import numpy as np
import pytest

from gaitway.api import Bout
from gaitway_plugins.crutch_tip.summary import summarise

START_NS = 5_000_000_000_000


def test_every_load_is_told_with_its_force(walk, batch_of, run):
    simulated = walk(peak_force_newton=250.0)
    told = run(batch_of(simulated), body_mass_kg=70.0)
    assert len(told.loads) == len(simulated.stride_length_m) + 1
    error = [
        load.peak_force_newton - true
        for load, true in zip(told.loads[1:], simulated.truth["peak_force_newton"], strict=True)
    ]
    assert np.abs(error).max() < 25.0
    for load in told.loads:
        assert load.peak_load_percent == pytest.approx(
            100.0 * load.peak_force_newton / (70.0 * 9.80665)
        )
        assert load.mean_force_newton < load.peak_force_newton
        assert 0.3 < load.stance_duration_s < 5.0


def test_without_a_body_mass_no_percentage_is_told(walk, batch_of, run):
    assert {load.peak_load_percent for load in run(batch_of(walk())).loads} == {None}


def test_the_loading_rate_is_that_of_the_force(made, run):
    t_s = np.arange(0.0, 6.0, 0.01)
    force = np.interp(t_s, [2.0, 2.4, 3.0, 3.4], [0.0, 200.0, 200.0, 0.0])[:, None]
    (load,) = run(made(6.0, force=force)).loads
    assert load.loading_rate_newtonps == pytest.approx(500.0, rel=0.01)
    assert load.peak_force_newton == pytest.approx(200.0)
    assert load.stance_duration_s == pytest.approx(1.4 - 2 * 0.0504, abs=0.02)


def test_the_pitch_goes_from_negative_to_positive_in_a_stance(walk, batch_of, run):
    for load in run(batch_of(walk(turn_back=False))).loads[1:-1]:
        assert load.contact_pitch_rad < -0.05
        assert load.lift_pitch_rad > 0.05


def test_a_bout_is_as_long_as_the_walk(walk, batch_of, run):
    simulated = walk()
    start, end = [e for e in run(batch_of(simulated)).events if isinstance(e, Bout)]
    assert (start.phase, end.phase) == ("start", "end")
    assert end.strides == len(simulated.stride_length_m)
    walked_s = simulated.truth["lift_s"][-1] - simulated.stride_start_s[0]
    assert end.duration_s == pytest.approx(walked_s, abs=0.1)


def test_the_last_step_counts_though_it_is_stood_on_for_long_and_the_bout_ends_meanwhile(
    walk, batch_of, run
):
    simulated = walk(turn_back=False, rest_s=8.0)
    told = run(batch_of(simulated))
    assert told.steps == len(simulated.stride_length_m)
    end = next(e for e in told.events if isinstance(e, Bout) and e.phase == "end")
    assert (end.t_ns - START_NS) / 1e9 == pytest.approx(simulated.truth["contact_s"][-1], abs=0.05)
    last = told.loads[-1]
    true_deg = np.degrees(simulated.truth["contact_pitch_rad"][-1])
    assert np.degrees(last.contact_pitch_rad) == pytest.approx(true_deg, abs=1.5)


def test_leaning_on_a_standing_crutch_is_a_load_but_no_step(made, run):
    t_s = np.arange(0.0, 40.0, 0.01)
    force = (150.0 * (np.sin(2.0 * np.pi * t_s / 2.0) > 0.0))[:, None]
    sway = 0.02 * np.sin(2.0 * np.pi * t_s / 3.0)
    gyro = np.zeros((len(t_s), 3))
    gyro[:, 1] = np.gradient(sway, t_s)
    told = run(made(40.0, force=force, gyro=gyro, inclination=sway[:, None]))
    assert len(told.loads) >= 18
    assert told.steps == 0


def test_stillness_gives_nothing(made, run):
    noise = np.random.default_rng(1)
    gyro = noise.normal(0.01, 0.002, (6000, 3))
    told = run(made(60.0, gyro=gyro, force=noise.normal(1.0, 1.5, (6000, 1))))
    assert told.events == []
    assert len(told.rows) == 6000


def test_a_load_that_went_on_before_the_first_sample_is_not_measured(made, run):
    t_s = np.arange(0.0, 6.0, 0.01)
    force = np.where((t_s < 1.0) | ((t_s > 2.0) & (t_s < 3.0)), 100.0, 0.0)[:, None]
    (load,) = run(made(6.0, force=force)).loads
    assert load.stance_duration_s == pytest.approx(1.0, abs=0.03)


def test_a_gap_costs_the_stance_it_is_in_and_no_other(walk, batch_of, run, without):
    simulated = walk(turn_back=False)
    batch = batch_of(simulated)
    middle_s = 0.5 * (simulated.truth["contact_s"][3] + simulated.truth["lift_s"][3])
    holed = run(*without(batch, (middle_s - 0.1, middle_s + 0.1)))
    whole = run(batch)
    assert len(holed.loads) == len(whole.loads) - 1
    assert holed.steps == whole.steps - 1


def test_the_summary_counts_loads_and_knows_no_distance(walk, batch_of, run):
    told = run(batch_of(walk()))
    summary = summarise(told.events)
    assert summary["stances"] == len(told.loads)
    assert summary["strides"] == told.steps
    assert summary["distance_m"] is None
    assert len(summary["peak_force_newton"]) == len(told.loads)
