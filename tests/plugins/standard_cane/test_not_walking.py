"""What is no walking gives no strides, and what goes wrong is said."""

import math
from itertools import pairwise

import numpy as np
import pytest

from gaitway.api import WalkPlan
from gaitway.simulation import (
    Constant,
    Knot,
    RigidMotion,
    Spline,
    Stacked,
    mounted,
    non_walking,
    record,
    rest,
    via,
)

MOUNTING = {"x": "up", "y": "right", "z": "forward"}


@pytest.mark.parametrize(
    "kind", ["still", "lying", "leaning", "waving", "turning-on-the-spot", "carried"]
)
@pytest.mark.parametrize("seed", [2000, 2001])
def test_no_stride_is_invented(batch_of, run, kind, seed):
    plan = WalkPlan(1.0, seed=seed)
    recorded = non_walking(plan, kind, duration_s=60.0, device_to_imu_d=(0.0, 0.0, 0.575))
    told = run(batch_of(recorded))
    assert (len(told.strides), told.distance_m) == (0, 0.0)


def test_a_cane_dragged_behind_gives_no_stride(batch_of, run):
    way = [rest(2.0, 0.0, 0.0)]
    way += [via(2.0 + 0.6 * k, 0.3 * k + 0.05 * (k % 2), 0.02 * (k % 3)) for k in range(1, 40)]
    way.append(rest(28.0, 12.5, 0.0))
    lean = [rest(2.0, 0.0, 0.0, 0.0), rest(3.0, 0.0, 0.5, 0.0), rest(28.0, 0.0, 0.5, 0.0)]
    motion = RigidMotion(Stacked(Spline(way), Constant(0.0)), Spline(lean))
    recorded = record(WalkPlan(1.0), motion, mounted(MOUNTING, (0.0, 0.0, 0.575)), 30.0, [])
    assert run(batch_of(recorded)).strides == []


def test_a_cane_dragged_after_some_steps_is_said(batch_of, run):
    """Four placements; then the tip slides on over the floor, faster and slower."""
    ground, height, angles = _steps([0.0] * 5)
    x_m, from_s = ground[-1].values[0], ground[-1].t_s + 0.8
    ground = [*ground, rest(from_s, x_m, 0.0)]
    ground += [via(from_s + 0.7 * k, x_m + 0.4 * k + 0.08 * (k % 2), 0.0) for k in range(1, 15)]
    ground.append(rest(from_s + 11.0, x_m + 6.5, 0.0))
    motion = RigidMotion(Stacked(Spline(ground), Spline(height)), Spline(angles))
    place = mounted(MOUNTING, (0.0, 0.0, 0.575))
    told = run(batch_of(record(WalkPlan(1.0, seed=7), motion, place, from_s + 13.0, [])))
    assert len(told.strides) == 4
    assert "dragging" in told.anomalies
    assert told.distances[-1].unmeasured_s > 0.0
    assert told.sigma_m > 0.5


def test_a_dropped_cane_is_said(batch_of, run):
    fall = [rest(2.0, 0.0, 0.0, 0.0), via(2.5, 0.0, 0.9, 0.0), rest(2.8, 0.0, 1.55, 0.0)]
    shock = [rest(2.75, 0.0), via(2.76, 0.002), rest(2.78, 0.0)]
    motion = RigidMotion(Stacked(Constant(0.0, 0.0), Spline(shock)), Spline(fall))
    recorded = record(WalkPlan(1.0), motion, mounted(MOUNTING, (0.0, 0.0, 0.575)), 8.0, [])
    told = run(batch_of(recorded))
    assert told.anomalies.count("device-dropped") == 1
    assert told.strides == []


def test_a_sensor_mounted_upside_down_is_said(walk, batch_of, run):
    batch = batch_of(walk(8.0, seed=6))
    turned = np.array([1.0, -1.0, -1.0])
    channels = {
        name: values * turned if name in ("accel", "gyro") else values
        for name, values in batch.channels.items()
    }
    told = run(type(batch)(batch.t_ns, batch.period_s, 0, channels))
    assert "not-mounted-as-configured" in told.anomalies
    assert told.strides == []


def test_a_step_up_is_a_change_of_height_and_no_error(batch_of, run):
    ground, height, angles = _steps([0.0, 0.0, 0.15, 0.15, 0.15])
    motion = RigidMotion(Stacked(Spline(ground), Spline(height)), Spline(angles))
    place = mounted(MOUNTING, (0.0, 0.0, 0.575))
    told = run(batch_of(record(WalkPlan(1.0, seed=7), motion, place, 9.0, [])))
    rises_m = [stride.height_change_m for stride in told.strides]
    assert rises_m == pytest.approx([0.0, 0.15, 0.0, 0.0], abs=0.02)
    assert told.distance_m == pytest.approx(3.2, rel=0.01)


def _steps(heights_m: list[float]) -> tuple[list[Knot], list[Knot], list[Knot]]:
    """Return way, height and angles of placements of 0.8 m, an exact inverted pendulum between."""
    lean_rad = math.radians(15.0)
    ground, height = [rest(2.0, 0.0, 0.0)], [rest(2.0, heights_m[0])]
    angles = [rest(1.9, 0.0, 0.05, 0.0)]
    for number, (before_m, after_m) in enumerate(pairwise(heights_m)):
        lift_s, contact_s = 2.0 + 1.2 * number, 2.5 + 1.2 * number
        if number:
            ground.append(rest(lift_s, 0.8 * number, 0.0))
            height.append(rest(lift_s, before_m))
            angles.append(via(lift_s, 0.0, lean_rad, 0.0))
        height.append(via(lift_s + 0.25, max(before_m, after_m) + 0.06))
        ground.append(rest(contact_s, 0.8 * (number + 1), 0.0))
        height.append(rest(contact_s, after_m))
        angles.append(via(contact_s, 0.0, -lean_rad, 0.0))
    angles.append(rest(angles[-1].t_s + 0.6, 0.0, 0.0, 0.0))
    return ground, height, angles
