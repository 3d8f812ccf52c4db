"""Gaps, spoilt samples, clipping, dragging: what is not measured is said, never made up."""

import numpy as np
import pytest

from gaitway.api import ACCEL, CLIP, GYRO, Anomaly, Gap, SampleBatch, frozen_rows
from gaitway.simulation import rest, via

SEED = 3
STRIDE = 4
"""The one that suffers."""


@pytest.fixture(scope="module")
def truth(walk):
    return walk(5.0, seed=SEED)


@pytest.fixture(scope="module")
def batch(truth, batch_of):
    return batch_of(truth)


@pytest.fixture(scope="module")
def whole(batch, run):
    return run(batch)


@pytest.fixture(scope="module")
def contact_s(truth):
    return truth.stride_end_s[STRIDE]


def changed(batch, **channels):
    merged = {name: frozen_rows(rows, rows.shape[1]) for name, rows in channels.items()}
    return SampleBatch(batch.t_ns, batch.period_s, 0, {**batch.channels, **merged})


@pytest.mark.parametrize("before_contact_s", [0.7, 0.4, 0.05])
@pytest.mark.parametrize("long_s", [0.02, 0.1])
def test_a_short_gap_costs_no_stride(
    batch, whole, contact_s, run, without, before_contact_s, long_s
):
    start_s = contact_s - before_contact_s
    result = run(*without(batch, (start_s, start_s + long_s)))
    assert len(result.strides) == len(whole.strides)
    assert result.distance_m == pytest.approx(whole.distance_m, abs=0.03)
    wider_m = result.strides[STRIDE].stride_length_sigma_m
    assert wider_m > whole.strides[STRIDE].stride_length_sigma_m
    assert result.anomalies == []


@pytest.mark.parametrize("after_lift_s", [0.1, 0.4])
@pytest.mark.parametrize("long_s", [0.15, 0.3])
def test_a_stride_that_a_longer_gap_hides_is_interpolated_and_says_so(
    truth, batch, whole, contact_s, run, without, after_lift_s, long_s
):
    lift_s = contact_s - whole.strides[STRIDE].swing_duration_s
    start_s = lift_s + after_lift_s
    result = run(*without(batch, (start_s, start_s + long_s)))
    assert result.anomalies == ["gap-in-stride"]
    assert [number for number, s in enumerate(result.strides) if s.interpolated] == [STRIDE]
    measured_m = [stride.stride_length_m for stride in result.strides if not stride.interpolated]
    assert measured_m == pytest.approx(np.delete(truth.stride_length_m, STRIDE), abs=0.02)
    assert result.strides[STRIDE].stride_length_sigma_m > 0.05
    assert 0.5 < result.unmeasured_s < 3.0
    assert abs(truth.distance_m - result.distance_m) < 2.0 * result.sigma_m


@pytest.mark.parametrize("long_s", [0.15, 0.4])
def test_a_gap_in_a_stance_costs_nothing(batch, whole, contact_s, run, without, long_s):
    result = run(*without(batch, (contact_s + 0.25, contact_s + 0.25 + long_s)))
    assert len(result.strides) == len(whole.strides)
    assert result.distance_m == pytest.approx(whole.distance_m, abs=0.01)
    assert result.anomalies == []
    assert result.unmeasured_s == 0.0


def test_a_long_gap_while_the_cane_rests_costs_nothing(batch, whole, run, without):
    result = run(*without(batch, (0.8, 2.8)))
    assert result.distance_m == pytest.approx(whole.distance_m, abs=0.01)
    assert result.unmeasured_s == 0.0


def test_steps_behind_a_long_gap_are_not_made_up(truth, batch, run, without):
    """Two whole strides vanish; the cane stands before and after, but leans otherwise."""
    start_s, end_s = truth.stride_end_s[[STRIDE, STRIDE + 2]] + 0.3
    result = run(*without(batch, (start_s, end_s)))
    kept_m = np.delete(truth.stride_length_m, [STRIDE + 1, STRIDE + 2])
    assert len(result.strides) == len(kept_m)
    assert result.distance_m == pytest.approx(kept_m.sum(), abs=0.02)
    assert result.anomalies == ["gap-in-stride", "distance-untrusted"]
    assert result.unmeasured_s == pytest.approx(end_s - start_s, abs=0.7)


def test_a_stride_in_which_the_device_restarts_is_interpolated(batch, whole, contact_s, run):
    cut = round((contact_s - 0.4) / batch.period_s)
    restart = Gap(int(batch.t_ns[cut]), 3, "device-restart")
    result = run(batch[:cut], restart, batch[cut + 3 :])
    assert len(result.strides) == len(whole.strides)
    assert sum(stride.interpolated for stride in result.strides) == 1
    assert result.anomalies == ["gap-in-stride"]


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_a_few_unusable_samples_are_a_short_gap(batch, whole, contact_s, run, value):
    accel = batch.channels[ACCEL.name].copy()
    row = round((contact_s - 0.4) / batch.period_s)
    accel[row : row + 3, 1] = value
    result = run(changed(batch, accel=accel))
    assert len(result.strides) == len(whole.strides)
    assert result.distance_m == pytest.approx(whole.distance_m, abs=0.02)


def test_nothing_but_unusable_samples_gives_nothing(batch, run):
    accel = np.full_like(batch.channels[ACCEL.name], np.nan)
    assert run(changed(batch, accel=accel)).events == []


def test_clipping_is_told_once_a_swing_and_widens_its_stride(batch, whole, contact_s, run):
    clip = np.zeros_like(batch.channels[CLIP.name])
    row = round((contact_s - 0.4) / batch.period_s)
    clip[[row, row + 5, row + 10]] = 1.0
    result = run(changed(batch, clip=clip))
    assert result.anomalies == ["sensor-clipped"]
    assert len(result.strides) == len(whole.strides)
    ratio = [
        new.stride_length_sigma_m / old.stride_length_sigma_m
        for new, old in zip(result.strides, whole.strides, strict=True)
    ]
    assert np.argmax(ratio) == STRIDE
    assert ratio[STRIDE] > 1.3


@pytest.fixture(scope="module")
def dragged(by_hand):
    """A cane pulled along for 20 s at 0.4 m/s with jerks, upright, never still."""
    times_s = np.arange(3.6, 23.0, 0.6)
    way = [via(t, 0.24 * (n + 1), 0.0, 0.0) for n, t in enumerate(times_s)]
    lean = [via(t, 0.0, np.radians(5 + 3 * (-1) ** n), 0.0) for n, t in enumerate(times_s)]
    end = 0.24 * (len(times_s) + 1)
    return by_hand(
        [rest(3.0, 0.0, 0.0, 0.0), *way, rest(24.0, end, 0.0, 0.0)],
        [rest(3.0, 0.0, 0.0, 0.0), *lean, rest(24.0, 0.0, 0.0, 0.0)],
        28.0,
    )


def test_a_dragged_cane_gives_no_distance_but_an_anomaly_and_doubt(dragged, batch_of, run):
    result = run(batch_of(dragged))
    assert result.strides == []
    assert result.distance_m == 0.0
    assert result.anomalies == ["no-contact"]
    assert result.unmeasured_s == pytest.approx(21.0, abs=1.5)
    assert result.sigma_m > 5.0


def test_a_dragged_cane_is_told_while_it_is_dragged(dragged, batch_of, run):
    batch = batch_of(dragged)
    (told,) = [event for event in run(batch).events if isinstance(event, Anomaly)]
    assert (told.t_ns - batch.t_ns[0]) / 1e9 == pytest.approx(3.0 + 3.0, abs=0.5)


def test_an_input_that_ends_while_dragging_counts_what_was_dragged(dragged, batch_of, run):
    result = run(batch_of(dragged)[:1500])
    assert result.distance_m == 0.0
    assert result.unmeasured_s == pytest.approx(12.0, abs=0.5)


def after(first, walk, batch_of, reason="lost"):
    """Return items: a batch, two seconds missing, and a walk."""
    gap = Gap(int(first.t_ns[-1] + first.t_ns[1] - first.t_ns[0]), 200, reason)
    return first, gap, batch_of(walk, gap.t_ns + 2_000_000_000)


def test_walking_is_measured_again_after_dragging(dragged, truth, batch_of, run):
    result = run(*after(batch_of(dragged), truth, batch_of))
    assert result.distance_m == pytest.approx(truth.distance_m, abs=0.03)
    assert len(result.strides) == len(truth.stride_length_m)


@pytest.mark.parametrize("seed", [2, 5])
def test_an_exchanged_sensor_costs_no_stride(walk, batch_of, run, seed):
    """Its biases are others, by several times what they can walk; nobody tells the estimator."""
    old, new = walk(3.0, seed=1), walk(3.0, seed=seed)
    result = run(*after(batch_of(old), new, batch_of, "device-restart"))
    assert len(result.strides) == len(old.stride_length_m) + len(new.stride_length_m)
    assert result.distance_m == pytest.approx(old.distance_m + new.distance_m, abs=0.03)


def test_a_bout_ends_after_the_longest_pause_and_the_next_stride_starts_at_its_lift(
    truth, batch, batch_of, run
):
    result = run(*after(batch, truth, batch_of))
    assert [bout.phase for bout in result.bouts] == ["start", "end", "start", "end"]
    again = result.strides[len(truth.stride_length_m)]
    assert again.stance_duration_s is None
    assert result.bouts[1].distance_m == pytest.approx(truth.distance_m, abs=0.03)


def test_a_gyroscope_channel_alone_turned_upside_down_is_not_walking(batch, run):
    """The cane hangs handle down: its specific force points to its foot."""
    turned = {name: batch.channels[name] * [1.0, -1.0, -1.0] for name in (ACCEL.name, GYRO.name)}
    for method in ("default", "published"):
        assert run(changed(batch, **turned), method=method).strides == []


def test_a_fall_is_told_once(batch, run):
    accel = batch.channels[ACCEL.name].copy()
    accel[100:140] = 0.5
    assert run(changed(batch, accel=accel)).anomalies.count("device-dropped") == 1


def test_a_mounting_that_can_not_be_is_told_and_nothing_counted(batch, run):
    """What the configuration calls up points sideways."""
    turned = {name: batch.channels[name][:, [2, 1, 0]] * (1, -1, 1) for name in ("accel", "gyro")}
    result = run(changed(batch, **turned))
    assert "not-mounted-as-configured" in result.anomalies
    assert result.strides == []
