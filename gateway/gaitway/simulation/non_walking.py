"""What a device goes through when nobody walks with it, to see that no stride is invented."""

from collections.abc import Callable, Mapping, Sequence
from math import pi, radians
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from gaitway.contracts import SimulatedWalk, WalkPlan
from gaitway.simulation.curves import Constant, Shocks, Stacked, Sum
from gaitway.simulation.imu_model import ImuModel
from gaitway.simulation.motion import RigidMotion
from gaitway.simulation.person import stream
from gaitway.simulation.spline import Knot, Spline, rest, via
from gaitway.simulation.walk import mounted, record

NonWalking = Literal["still", "lying", "leaning", "waving", "turning-on-the-spot", "carried"]
"""``still``: stands upright. ``lying``: on a table that is knocked at. ``leaning``: a person sways
on the planted device. ``waving``: lifted and moved about. ``turning-on-the-spot``: lifted, turned
and put down where it was, again and again. ``carried``: upright in the hand of somebody who walks
without using it, and put down elsewhere."""

UP_RIGHT_FORWARD: Final = {"x": "up", "y": "right", "z": "forward"}


def non_walking(
    plan: WalkPlan,
    kind: NonWalking,
    *,
    duration_s: float = 20.0,
    mounting: Mapping[str, str] = UP_RIGHT_FORWARD,
    device_to_imu_d: Sequence[float] = (0.0, 0.0, 0.5),
    model: ImuModel | None = None,
) -> SimulatedWalk:
    """Return a recording in which nobody walks with the device: no strides, distance 0.

    Args:
        plan: Seed, sample rate, rest before and after, and whether the sensor is ideal; its
            distance, speed and turn are not used.
        kind: What happens between the rests.
        duration_s: How long it happens.
        mounting: Where the IMU axes point on the device.
        device_to_imu_d: From the device's origin to the IMU, metres.
        model: Kind of IMU; an MTi-1 where None.
    """
    rng = stream(plan.seed, kind)
    end_s = plan.rest_s + duration_s
    motion = _MOTIONS[kind](plan.rest_s, end_s, rng)
    place = mounted(mounting, device_to_imu_d)
    return record(plan, motion, place, end_s + plan.rest_s, [], model=model)


def _wander(
    start_s: float,
    end_s: float,
    every_s: tuple[float, float],
    spread: ArrayLike,
    rng: np.random.Generator,
) -> Spline:
    """Return a curve from zero to zero through random points, standard deviation ``spread``."""
    size = np.shape(spread)[0]
    knots: list[Knot] = [rest(start_s, *np.zeros(size))]
    while knots[-1].t_s + 2.0 * every_s[1] < end_s:
        point = np.clip(rng.standard_normal(size), -2.0, 2.0) * np.asarray(spread)
        knots.append(via(knots[-1].t_s + rng.uniform(*every_s), *point))
    return Spline([*knots, rest(end_s, *np.zeros(size))])


def _still(_start_s: float, _end_s: float, rng: np.random.Generator) -> RigidMotion:
    return RigidMotion(Constant(0.0, 0.0, 0.0), _standing(rng))


def _standing(rng: np.random.Generator) -> Constant:
    return Constant(0.0, *(radians(float(lean)) for lean in rng.normal(0.0, 1.0, 2)))


def _lying(start_s: float, end_s: float, rng: np.random.Generator) -> RigidMotion:
    knocks_s = np.sort(rng.uniform(start_s, max(start_s, end_s - 0.5), 8))
    peaks = rng.normal(0.0, 1.0, (8, 3)) * np.array([2e-5, 2e-5, 1e-4])
    table = Constant(0.0, 0.0, 0.75)
    flat = Constant(0.0, 0.5 * pi + float(rng.normal(0.0, 0.02)), float(rng.uniform(-pi, pi)))
    return RigidMotion(Sum(table, Shocks(knocks_s, peaks, 40.0, 0.008)), flat)


def _leaning(start_s: float, end_s: float, rng: np.random.Generator) -> RigidMotion:
    sway = _wander(start_s, end_s, (0.6, 2.0), np.radians([0.3, 1.5, 1.5]), rng)
    return RigidMotion(Constant(0.0, 0.0, 0.0), Sum(_standing(rng), sway))


def _waving(start_s: float, end_s: float, rng: np.random.Generator) -> RigidMotion:
    hand = _wander(start_s, end_s, (0.3, 0.8), (0.15, 0.15, 0.1), rng)
    lifted = _plateau(start_s, end_s, 0.4)
    turns = _wander(start_s, end_s, (0.3, 0.8), (0.4, 0.4, 0.4), rng)
    lift = Stacked(Constant(0.0, 0.0), lifted)
    return RigidMotion(Sum(hand, lift), Sum(_standing(rng), turns))


def _turning(start_s: float, end_s: float, rng: np.random.Generator) -> RigidMotion:
    height, angles = [rest(start_s, 0.0)], [rest(start_s, 0.0, 0.0, 0.0)]
    yaw_rad, down_s = 0.0, start_s
    while down_s + 3.0 < end_s:
        lift_s = down_s + rng.uniform(0.6, 1.2)
        swing_s = rng.uniform(0.5, 0.9)
        down_s = lift_s + swing_s
        height += [rest(lift_s, 0.0), via(lift_s + 0.5 * swing_s, 0.03), rest(down_s, 0.0)]
        angles.append(rest(lift_s, yaw_rad, *angles[-1].values[1:]))
        yaw_rad += radians(rng.uniform(20.0, 60.0))
        angles.append(rest(down_s, yaw_rad, *np.radians(rng.normal(0.0, 1.0, 2))))
    spot = Stacked(Constant(0.0, 0.0), Spline(height))
    return RigidMotion(spot, Spline(angles))


def _carried(start_s: float, end_s: float, rng: np.random.Generator) -> RigidMotion:
    speed_mps, step_s = rng.uniform(0.7, 1.3), rng.uniform(0.45, 0.6)
    way = [rest(start_s, 0.0, 0.0)]
    steps_s = np.arange(start_s + 1.5, end_s - 1.5, step_s)
    for number, t_s in enumerate(steps_s):
        sideways_m = 0.02 * (-1.0) ** number
        way.append(via(float(t_s), speed_mps * float(t_s - steps_s[0]) + 0.5, sideways_m))
    way.append(rest(end_s, way[-1].values[0] + 0.5, 0.0))
    bounce = [rest(start_s, 0.0)]
    for t_s in steps_s:
        bounce += [via(float(t_s), -0.02), via(float(t_s) + 0.5 * step_s, 0.02)]
    bounce.append(rest(end_s, 0.0))
    height = Sum(Spline(bounce), _plateau(start_s, end_s, 0.25))
    sway = _wander(start_s, end_s, (0.4, 0.6), np.radians([4.0, 4.0, 3.0]), rng)
    return RigidMotion(Stacked(Spline(way), height), Sum(_standing(rng), sway))


def _plateau(start_s: float, end_s: float, height_m: float) -> Spline:
    """Return a lift within a second at the start and a lowering within a second at the end."""
    ramp_s = min(1.0, 0.4 * (end_s - start_s))
    high = [rest(start_s + ramp_s, height_m), rest(end_s - ramp_s, height_m)]
    return Spline([rest(start_s, 0.0), *high, rest(end_s, 0.0)])


_MOTIONS: Final[Mapping[str, Callable[[float, float, np.random.Generator], RigidMotion]]] = {
    "still": _still,
    "lying": _lying,
    "leaning": _leaning,
    "waving": _waving,
    "turning-on-the-spot": _turning,
    "carried": _carried,
}
