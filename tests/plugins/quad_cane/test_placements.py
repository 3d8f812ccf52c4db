"""Which placements are strides: single ones, put by hand where a test wants them."""

import numpy as np
import pytest

from gaitway.simulation import rest, via


def put(way, start_s, end_s, to_m, *, lean_rad=0.05):
    """Return the knots of one placement that follows a way so far, and of its angles."""
    from_m = way[-1].values[0] if way else 0.0
    middle_s = 0.5 * (start_s + end_s)
    path = [
        rest(start_s, from_m, 0.0, 0.0),
        via(middle_s, 0.5 * (from_m + to_m), 0.0, 0.04),
        rest(end_s, to_m, 0.0, 0.0),
    ]
    upright = (0.0, 0.0, 0.0)
    return path, [rest(start_s, *upright), via(middle_s, 0.0, lean_rad, 0.0), rest(end_s, *upright)]


@pytest.fixture(scope="module")
def placed(by_hand, batch_of):
    """Return the samples of placements given as (start_s, end_s, to_m), and of a rest after."""

    def recording(*placements, rest_s=4.0):
        way, angles = [], []
        for placement in placements:
            path, turns = put(way, *placement)
            way += path
            angles += turns
        return batch_of(by_hand(way, angles, placements[-1][1] + rest_s))

    return recording


def test_a_single_placement_is_a_stride(placed, run):
    (stride,) = run(placed((3.0, 4.0, 0.5))).strides
    assert stride.stride_length_m == pytest.approx(0.5, abs=0.01)
    assert stride.stance_duration_s is None


def test_a_cane_put_right_by_three_centimetres_is_no_stride(placed, run):
    assert run(placed((3.0, 3.8, 0.03))).events == []


def test_a_stride_nobody_can_make_is_not_believed(placed, run):
    result = run(placed((3.0, 5.0, 3.0)))
    assert result.anomalies == ["implausible-stride"]
    assert result.distance_m == 0.0
    assert result.unmeasured_s == pytest.approx(2.0, abs=0.4)


def test_a_swing_that_slows_down_smoothly_does_not_end_before_its_end(placed, run):
    """The last half second of it passes the contact test; its velocity tells otherwise."""
    (stride,) = run(placed((3.0, 5.6, 0.5))).strides
    assert stride.stride_length_m == pytest.approx(0.5, abs=0.015)
    assert (stride.t_ns - stride.start_t_ns) / 1e9 > 2.0


def test_a_swing_that_takes_too_long_is_not_measured_and_said(placed, run):
    result = run(placed((3.0, 8.0, 0.6)))
    assert result.strides == []
    assert result.anomalies == ["no-contact"]
    assert result.unmeasured_s == pytest.approx(5.0, abs=0.8)


def test_a_stride_begins_at_the_contact_before_or_after_a_long_rest_at_its_lift(placed, run):
    result = run(placed((3.0, 4.0, 0.5), (5.0, 6.0, 1.0), (11.0, 12.0, 1.5)))
    first, second, third = result.strides
    assert second.start_t_ns == first.t_ns
    assert second.stance_duration_s == pytest.approx(1.0, abs=0.3)
    assert third.start_t_ns > second.t_ns + 4.5e9
    assert third.stance_duration_s is None
    assert [bout.phase for bout in result.bouts] == ["start", "end", "start", "end"]


def test_putting_the_cane_right_in_between_does_not_begin_a_stride_anew(placed, run):
    first, second = run(placed((3.0, 4.0, 0.5), (4.8, 5.4, 0.53), (6.0, 7.0, 1.03))).strides
    assert second.start_t_ns == first.t_ns
    assert second.stride_length_m == pytest.approx(0.5, abs=0.01)


def test_a_placement_while_not_walking_is_no_stride(by_hand, batch_of, run):
    """A cane that leaned on a table is set upright 20 cm away."""
    leaning = (0.0, np.radians(30.0), 0.0)
    stood_up = by_hand(
        [
            rest(3.0, 0.0, 0.0, 0.0),
            rest(4.5, 0.2, 0.0, 0.0),
            rest(10.0, 0.2, 0.0, 0.0),
            rest(12.4, 0.0, 0.0, 0.0),
        ],
        [
            rest(3.0, 0.0, 0.0, 0.0),
            rest(4.5, *leaning),
            rest(10.0, *leaning),
            rest(12.4, 0.0, 0.0, 0.0),
        ],
        16.0,
        tremble=0.04,
    )
    result = run(batch_of(stood_up))
    assert result.events == []


@pytest.mark.parametrize(
    ("axis", "strides"),
    [pytest.param(2, 0, id="about the forward axis"), pytest.param(0, 1, id="about its shaft")],
)
def test_shaking_on_the_way_is_no_walking_where_walking_does_not_turn(
    by_hand, batch_of, run, axis, strides
):
    """The magnitude subtraction looks at the forward axis alone; the tilt stays small."""
    way, _ = put([], 3.0, 4.0, 0.4)
    shakes = [via(3.0 + 0.12 * n, *(0.25 * (-1) ** n * np.eye(3)[axis])) for n in range(1, 8)]
    upright = (0.0, 0.0, 0.0)
    shaken = by_hand(way, [rest(3.0, *upright), *shakes, rest(4.0, *upright)], 8.0)
    assert len(run(batch_of(shaken)).strides) == strides


def test_walking_has_to_have_lasted_before_a_contact_counts(placed, run):
    batch = placed((3.0, 4.0, 0.5), (5.0, 6.0, 1.0))
    (late,) = run(batch, min_walking_s=5.0).strides
    assert late.t_ns == run(batch).strides[1].t_ns


def test_the_stance_behind_a_stride_makes_it_better_known(placed, run):
    batch = placed((3.0, 4.0, 0.5), (5.0, 6.0, 1.0))
    at_once, settled = run(batch, settle_s=0.0), run(batch)
    for early, late in zip(at_once.strides, settled.strides, strict=True):
        assert late.stride_length_sigma_m < 0.99 * early.stride_length_sigma_m


def test_an_unknown_height_costs_the_strides_but_not_the_distance(walk, batch_of, run):
    """What the lean gives to one stride it takes from the next."""
    batch = batch_of(walk(3.3, seed=1))
    known, unknown = (run(batch, imu_height_sigma_m=sigma_m) for sigma_m in (0.0, 0.2))
    wider = [
        new.stride_length_sigma_m / old.stride_length_sigma_m
        for new, old in zip(unknown.strides, known.strides, strict=True)
    ]
    assert max(wider) > 1.5
    assert unknown.sigma_m == pytest.approx(known.sigma_m, rel=0.2)


@pytest.mark.parametrize("height_m", [0.2, 0.8])
def test_a_height_that_is_wrong_costs_millimetres_a_stride(walk, batch_of, run, height_m):
    truth = walk(3.3, seed=1)
    result = run(batch_of(truth), imu_height_m=height_m)
    assert len(result.strides) == len(truth.stride_length_m)
    assert result.distance_m == pytest.approx(truth.distance_m, abs=0.03)
