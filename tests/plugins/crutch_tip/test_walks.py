"""What is promised of a crutch walk: pitch, loads, bouts; and what is no walk."""

import numpy as np
import pytest

from gaitway.api import Gap
from gaitway_plugins.crutch_tip.estimator import CrutchTipEstimator
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.summary import summarise


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def cycles(tools, seeds, method="default", **conditions):
    straight, turning = [], []
    for seed in seeds:
        walk, batch = tools.walk(10.0, seed=seed, turn_back=True, conditions=conditions)
        _, rows = tools.said(batch, trace=True, method=method)
        of_cycle = tools.cycle_rms_deg(walk, rows[:, 0])
        turns = walk.truth["turning"] > 0.0
        straight += of_cycle[~turns].tolist()
        turning += of_cycle[turns].tolist()
    return rms(straight), rms(turning)


def test_pitch_is_better_than_published_straight_and_in_turns(tools):
    straight, turning = cycles(tools, range(6))
    of_paper, turning_of_paper = cycles(tools, range(6), method="published")
    assert straight <= 1.0 < of_paper
    assert turning <= 3.0 < turning_of_paper


@pytest.mark.parametrize("seen", ["no-roll", "no-accel", "neither", "accel-only"])
def test_does_with_what_is_measured(tools, seen):
    straight, turning = cycles(tools, range(3), seen=seen)
    assert straight <= 1.2
    assert turning <= 4.5


def test_every_stance_is_a_load_with_its_force_in_newtons_and_body_weight(tools):
    walk, batch = tools.walk(seed=4, conditions={"force": "volt"})
    events = tools.said(batch, body_mass_kg=70.0)
    loads = tools.of(events, "load")
    assert len(loads) == len(walk.truth["peak_newton"])
    for load, peak in zip(loads, walk.truth["peak_newton"], strict=True):
        assert abs(load.peak_force_newton - peak) < 3.0 * load.peak_force_sigma_newton
        assert load.peak_load_percent == pytest.approx(load.peak_force_newton / 70 / 0.0980665)
        assert load.mean_force_newton < load.peak_force_newton
        assert load.loading_rate_newtonps > 0.0
        assert load.contact_pitch_rad < load.lift_pitch_rad
    told = summarise(events)
    assert told["distance_m"] is None
    assert told["stances"] == len(loads)
    assert len(tools.of(events, "bout")) == 2


def test_most_pitches_are_inside_the_stated_interval(tools):
    inside = []
    for seed in range(10):
        walk, batch = tools.walk(5.0, seed=seed)
        _, rows = tools.said(batch, trace=True)
        assert len(rows) == len(batch)
        inside.append(np.abs(rows[:, 0] - walk.truth["pitch_rad"]) <= 1.96 * rows[:, 1])
    assert 0.9 <= np.concatenate(inside).mean() <= 0.995


@pytest.mark.parametrize("size", [1, 7])
@pytest.mark.parametrize("method", ["default", "published"])
def test_batches_change_nothing(tools, size, method):
    _, batch = tools.walk(3.0, seed=1)
    assert tools.said(batch, size=size, method=method) == tools.said(batch, method=method)


def test_a_restart_in_mid_walk_changes_nothing(tools):
    _, batch = tools.walk(4.0, seed=2)
    first = CrutchTipEstimator(CrutchTipParams())
    events = list(first.update(batch[:700]))
    again = CrutchTipEstimator(CrutchTipParams())
    again.restore(first.save())
    events += [*again.update(batch[700:]), *again.finish()]
    assert events == tools.said(batch, size=700)


def test_rates_agree(tools):
    peaks = []
    for rate_hz in (50.0, 100.0, 200.0):
        walk, batch = tools.walk(seed=3, rate_hz=rate_hz, ideal_sensor=True)
        events, rows = tools.said(batch, trace=True)
        assert rms(tools.cycle_rms_deg(walk, rows[:, 0])) < 1.0
        peaks.append([load.peak_force_newton for load in tools.of(events, "load")])
    np.testing.assert_allclose(peaks[0], peaks[1], rtol=0.02)
    np.testing.assert_allclose(peaks[2], peaks[1], rtol=0.02)


def test_a_gap_costs_its_stance_and_no_other(tools):
    walk, batch = tools.walk(seed=5)
    at = int(100 * (walk.truth["contact_s"][3] + 0.2))
    estimator = CrutchTipEstimator(CrutchTipParams())
    events = [
        *estimator.update(batch[:at]),
        *estimator.update(Gap(int(batch.t_ns[at]), 50, "lost")),
        *estimator.update(batch[at + 50 :]),
        *estimator.finish(),
    ]
    whole = tools.of(tools.said(batch), "load")
    assert len(whole) - 1 <= len(tools.of(events, "load")) <= len(whole)


def test_dragging_is_said_and_not_of_a_usual_walk(tools):
    for seed in range(3):
        _, dragged = tools.walk(10.0, seed=seed, conditions={"load": "dragged"})
        told = {event.anomaly for event in tools.of(tools.said(dragged), "anomaly")}
        assert "dragging" in told
        _, usual = tools.walk(10.0, seed=seed, turn_back=True)
        assert tools.of(tools.said(usual), "anomaly") == []


def test_an_inclinometer_the_wrong_way_round_is_said_and_no_pitch_told(tools):
    walk, _ = tools.walk(12.0, seed=6)
    channels = dict(walk.channels)
    channels["inclination"] = -channels["inclination"]
    events = tools.said(tools.batch(channels, walk.rate_hz))
    assert "not-mounted-as-configured" in {e.anomaly for e in tools.of(events, "anomaly")}
    assert tools.of(events, "load")[-1].contact_pitch_rad is None


def test_a_stuck_force_is_said(tools):
    walk, _ = tools.walk(8.0, seed=7)
    channels = dict(walk.channels)
    channels["force"] = np.full_like(channels["force"], 120.0)
    events = tools.said(tools.batch(channels, walk.rate_hz))
    assert "force-implausible" in {e.anomaly for e in tools.of(events, "anomaly")}


def still(tools, minutes, force, tilt_rad=0.0, seed=0):
    n = int(minutes * 6000)
    rng = np.random.default_rng(seed)
    channels = {
        "gyro": 0.002 * rng.standard_normal((n, 3)) + 0.01,
        "accel": np.tile([9.8 * np.cos(tilt_rad), 0.0, -9.8 * np.sin(tilt_rad)], (n, 1)),
        "inclination": np.full((n, 1), tilt_rad) + 0.005 * rng.standard_normal((n, 1)),
        "force": (force(np.arange(n) / 100) + 2.0 * rng.standard_normal(n))[:, np.newaxis],
    }
    return tools.batch(channels, 100.0)


def test_lying_on_a_table_and_being_bumped_is_nothing(tools):
    lying = still(tools, 10, lambda t: 150.0 * (t % 7.0 < 0.05), tilt_rad=1.4)
    assert tools.said(lying) == []


def test_leaning_on_the_crutch_is_a_load_and_no_walk(tools):
    events = tools.said(still(tools, 2, lambda t: 100.0 * (t % 20.0 > 8.0)))
    assert len(tools.of(events, "load")) >= 5
    assert tools.of(events, "bout") == []


def pendulum(rate_hz=100.0, count=8, noise=0.0, bias_radps=0.0, rest_s=2.0):
    """Return a planar walk of another make: cosines, an inclinometer that is true but noisy."""
    t = np.arange(0.0, 2 * rest_s + 1.5 * count, 1.0 / rate_hz)
    phase, cycle = np.modf((t - rest_s) / 1.5)
    walking = (t >= rest_s) & (cycle < count)
    swing = np.clip(phase / 0.4, 0.0, 1.0)
    stance = np.clip((phase - 0.4) / 0.6, 0.0, 1.0)
    pitch = np.where(phase < 0.4, 0.3 * np.cos(np.pi * swing), -0.3 * np.cos(np.pi * stance))
    pitch = np.where(walking, pitch, 0.3)
    force = np.where(walking & (phase > 0.4), 250.0 * np.sin(np.pi * stance), 0.0)
    rng = np.random.default_rng(1)
    gyro = np.zeros((len(t), 3))
    gyro[:, 1] = -np.gradient(pitch, 1.0 / rate_hz)
    gyro += bias_radps + 0.1 * noise * rng.standard_normal(gyro.shape)
    seen = pitch + noise * rng.standard_normal(len(t))
    channels = {"gyro": gyro, "inclination": seen[:, np.newaxis], "force": force[:, np.newaxis]}
    return channels, pitch, count


@pytest.mark.parametrize("rate_hz", [50.0, 200.0])
@pytest.mark.parametrize(("noise", "bias_radps"), [(0.0, 0.0), (0.02, 0.0175)])
def test_a_walk_of_another_make(tools, rate_hz, noise, bias_radps):
    channels, pitch, count = pendulum(rate_hz, noise=noise, bias_radps=bias_radps)
    events, rows = tools.said(tools.batch(channels, rate_hz), trace=True)
    assert len(tools.of(events, "load")) == count
    assert np.degrees(rms(rows[:, 0] - pitch)) < 1.0
