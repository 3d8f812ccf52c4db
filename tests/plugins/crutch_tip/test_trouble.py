"""What makes numbers untrustworthy is said."""

import numpy as np
import pytest

from gaitway.api import SampleBatch


def wobble(n, rate=0.5):
    gyro = np.zeros((n, 3))
    gyro[:, 1] = rate * np.sin(np.arange(n) / 15.0)
    return gyro


def test_dragging_is_said(made, run):
    force = np.full((1000, 1), 12.0)
    told = run(made(10.0, gyro=wobble(1000), force=force))
    assert set(told.anomalies) == {"dragging"}
    assert told.loads == []


def test_swinging_in_the_air_is_no_dragging(made, run):
    assert run(made(10.0, gyro=wobble(1000))).anomalies == []


def test_a_free_fall_is_said(made, run):
    accel = np.tile([0.0, 0.0, 9.80665], (600, 1))
    accel[300:340] = [0.0, 0.2, 0.3]
    assert run(made(6.0, accel=accel)).anomalies == ["device-dropped"]


def test_toppling_over_is_said(made, run):
    angle = np.interp(np.arange(600), [300, 350], [0.0, np.pi / 2.0])
    gyro = np.zeros((600, 3))
    gyro[:, 1] = np.gradient(angle) * 100.0
    told = run(made(6.0, gyro=gyro, inclination=angle[:, None]))
    assert told.anomalies == ["device-dropped"]


def test_laying_it_down_is_no_drop(made, run):
    angle = np.interp(np.arange(600), [200, 400], [0.0, np.pi / 2.0])
    gyro = np.zeros((600, 3))
    gyro[:, 1] = np.gradient(angle) * 100.0
    assert run(made(6.0, gyro=gyro, inclination=angle[:, None])).anomalies == []


def test_a_force_beyond_the_range_is_said(made, run):
    force = np.zeros((600, 1))
    force[200:300] = 1200.0
    assert "sensor-saturated" in run(made(6.0, force=force)).anomalies


def test_clipping_is_said(made, run):
    clip = np.zeros((600, 1))
    clip[300] = 16.0
    assert run(made(6.0, clip=clip)).anomalies == ["sensor-clipped"]


@pytest.mark.parametrize("seed", [3, 4])
def test_an_inclinometer_the_wrong_way_round_is_said_and_no_pitch_told(walk, batch_of, run, seed):
    batch = batch_of(walk(seed=seed, turn_back=False))
    channels = {**batch.channels, "inclination": -batch.channels["inclination"]}
    told = run(SampleBatch(batch.t_ns, batch.period_s, 0, channels))
    assert "not-mounted-as-configured" in told.anomalies
    assert told.loads[-1].contact_pitch_rad is None
    assert told.loads[-1].peak_force_newton > 0.0


def test_a_sound_walk_has_no_anomaly(walk, batch_of, run):
    assert run(batch_of(walk())).anomalies == []


def test_lying_about_in_a_wrong_attitude_it_comes_right_when_walked_with(
    walk, batch_of, run, rms_deg
):
    """The first inclination is wrong by far; the first stance corrects it."""
    simulated = walk(turn_back=False)
    batch = batch_of(simulated)
    inclination = batch.channels["inclination"].copy()
    inclination[:10] = 1.0
    bad = SampleBatch(batch.t_ns, batch.period_s, 0, {**batch.channels, "inclination": inclination})
    assert rms_deg(simulated, run(bad))[0] < 1.0
