"""A person walking on level ground with a sensor on the shank, with exact truth.

The sensor is strapped to the front of the lower shank just above the ankle; its path is what is
measured. Walking begins with half a stride from standing and ends with half a stride to standing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import cos, pi, radians, sin, sqrt
from typing import Final, Self

import numpy as np

from gaitway.api import SimulatedWalk, WalkPlan
from gaitway.simulation import (
    Footfall,
    Leg,
    Person,
    RigidMotion,
    TrueStride,
    leg_motion,
    mounted,
    record,
    stream,
)

MOUNTING: Final = {"x": "up", "y": "right", "z": "forward"}
IMU_AHEAD_M: Final = 0.04
"""The IMU sits four centimetres before the shank's axis."""
IMU_ABOVE_M: Final = (0.13, 0.22)
"""And so high above the ankle joint: a bulky sensor above the malleoli. On people the estimator
learned 0.18 to 0.20 m."""
SOFTNESS_M: Final = (0.010, 0.018)
"""Of a shod foot that rolls: the sole rocks by some 0.1 rad to either side of flat while the centre
of pressure runs from heel to ball, a rocker in the manner of Hansen, Childress and Knox (2004).
The ankle moves on in mid-stance at some 0.05 m/s; on people's walks the estimator needs as much."""
FEET: Final = ("rolling", "flat")
STRAP_SIGMA_RAD: Final = (radians(4.0), radians(2.5), radians(2.0))
"""Standard deviations of yaw, pitch and roll with which a sensor is strapped on by eye."""
SPEED_RANGE_MPS: Final = (0.25, 2.2)
MID_STANCE: Final = 0.4
"""Share of the stance at which the shank turns most slowly: strides run from there to there."""
RISE_S: Final = 0.75
"""From standing still to the first toe-off."""
SETTLE_S: Final = 0.5
"""From the last contact to standing still."""


@dataclass(frozen=True, slots=True)
class Pace:
    """How fast a person walks.

    Attributes:
        length_m: Of a usual stride (two steps).
        cycle_s: From contact to contact of one foot.
        stance_share: Share of the cycle on the floor.
        range_of_usual: The stride relative to the person's stride at 1.25 m/s.
    """

    length_m: float
    cycle_s: float
    stance_share: float
    range_of_usual: float

    @classmethod
    def draw(cls, person: Person, plan: WalkPlan, rng: np.random.Generator) -> Self:
        """Return the pace of a person at the plan's speed, or at their own (1.25 m/s times pace).

        Step length over cadence is constant at all speeds, about 0.0064 m/(steps/min) (Sekiya and
        Nagasaki 1998), here in proportion to body height. Stance shortens as speed grows, from
        64 % of the cycle at 0.8 m/s to 59 % at 1.7 m/s.

        Raises:
            ValueError: The plan's speed is out of reach.
        """
        speed_mps = 1.25 * person.pace if plan.speed_mps is None else plan.speed_mps
        low, high = SPEED_RANGE_MPS
        if not low <= speed_mps <= high:
            raise ValueError(f"speed_mps {speed_mps}: this simulation walks at {low} to {high} m/s")
        walk_ratio = 0.0064 * person.height_m / 1.7 * float(rng.normal(1.0, 0.06))
        cadence_spm = sqrt(60.0 * speed_mps / walk_ratio)
        return cls(
            length_m=2.0 * walk_ratio * cadence_spm,
            cycle_s=120.0 / cadence_spm,
            stance_share=0.615 - 0.055 * (speed_mps - 1.25) + float(rng.normal(0.0, 0.01)),
            range_of_usual=sqrt(speed_mps / 1.25),
        )


def simulate(plan: WalkPlan) -> SimulatedWalk:
    """Return a walk with a sensor on the shank.

    A stride runs from one mid-stance to the next, the first from where standing ends, the last to
    where standing begins again; its length is the horizontal displacement of the sensor, so that
    without turning the lengths add up to the distance from standing to standing.

    Args:
        plan: What to walk; ``distance_m`` is reached to within half a stride. Its condition
            ``foot`` is ``rolling``, as feet do, or ``flat``: an ankle that stands still in
            mid-stance.

    Raises:
        ValueError: The plan's speed is out of reach, or a condition is not known.
    """
    foot = _foot(plan)
    person = Person.draw(plan.seed)
    rng = stream(plan.seed, "shank")
    pace = Pace.draw(person, plan, rng)
    leg = Leg.draw(person, rng)
    place = stream(plan.seed, "shank-place")
    ankle_to_imu_d = (IMU_AHEAD_M, 0.0, float(place.uniform(*IMU_ABOVE_M)))
    if foot == "rolling":
        softness_m = float(place.uniform(*SOFTNESS_M))
        leg = replace(leg, sole=replace(leg.sole, softness_m=softness_m))
    tilts_rad = [float(rng.normal(0.0, sigma_rad)) for sigma_rad in STRAP_SIGMA_RAD]
    if plan.repetition:
        rng = stream(plan.seed, "shank", plan.repetition)
    footfalls = _footfalls(plan, person, pace, rng)
    motion = leg_motion(footfalls, leg, rng)
    return record(
        plan,
        motion,
        mounted(MOUNTING, ankle_to_imu_d, tilts_rad),
        footfalls[-1].off_s + plan.rest_s,
        list(_strides(footfalls, motion, ankle_to_imu_d)),
        measured_d=ankle_to_imu_d,
    )


def _foot(plan: WalkPlan) -> str:
    """Return how the plan's foot stands, after looking at all conditions."""
    unknown = set(plan.conditions) - {"foot"}
    if unknown:
        raise ValueError(f"condition {min(unknown)!r}: the shank knows foot alone")
    foot = plan.conditions.get("foot", "rolling")
    if foot not in FEET:
        raise ValueError(f"foot {foot!r}: this simulation knows {' and '.join(FEET)}")
    return str(foot)


def _strides(
    footfalls: Sequence[Footfall], motion: RigidMotion, imu_d: Sequence[float]
) -> Iterator[TrueStride]:
    first, *middle, last = footfalls
    bounds_s = np.array([first.contact_s, *(step.at(MID_STANCE) for step in middle), last.off_s])
    sensor_n = motion.point_n(bounds_s, np.array(imu_d))
    lengths_m = np.hypot(*np.diff(sensor_n[:, :2], axis=0).T)
    for start_s, end_s, length_m in zip(bounds_s, bounds_s[1:], lengths_m, strict=False):
        yield TrueStride(float(start_s), float(end_s), float(length_m))


def _footfalls(
    plan: WalkPlan, person: Person, pace: Pace, rng: np.random.Generator
) -> list[Footfall]:
    """Return standing, the steps of one foot, and standing again."""
    footfalls = []
    contact_s, off_s = plan.rest_s, plan.rest_s + RISE_S
    x_m = y_m = heading_rad = reach = 0.0
    for length_m, turn_rad in _course(plan, person, pace, rng):
        push = length_m / pace.length_m * pace.range_of_usual
        footfalls.append(Footfall(contact_s, off_s, x_m, y_m, heading_rad, reach, push))
        cycle_s = pace.cycle_s * float(rng.normal(1.0, person.time_variation))
        contact_s = off_s + cycle_s * (1.0 - pace.stance_share)
        off_s = contact_s + cycle_s * pace.stance_share
        course_rad = heading_rad + 0.5 * turn_rad + float(rng.normal(0.0, 0.01))
        x_m += length_m * cos(course_rad)
        y_m += length_m * sin(course_rad)
        heading_rad += turn_rad
        reach = push
    end_s = contact_s + SETTLE_S
    footfalls.append(Footfall(contact_s, end_s, x_m, y_m, heading_rad, reach, 0.0))
    return footfalls


def _course(
    plan: WalkPlan, person: Person, pace: Pace, rng: np.random.Generator
) -> Iterator[tuple[float, float]]:
    """Yield length and turn of each stride, half ones at both ends."""
    turns = _turn(pace, rng) if plan.turn_back else []
    walked_m = length_m = 0.5 * pace.length_m
    yield length_m, 0.0
    while turns or walked_m < plan.distance_m - pace.length_m:
        if turns and walked_m >= 0.5 * (plan.distance_m - pace.length_m):
            length_m, turn_rad = turns.pop()
        else:
            length_m = pace.length_m * float(rng.normal(1.0, person.length_variation))
            turn_rad = 0.0
        walked_m += length_m
        yield length_m, turn_rad
    yield 0.5 * pace.length_m, 0.0


def _turn(pace: Pace, rng: np.random.Generator) -> list[tuple[float, float]]:
    """Return length and turn of the short strides that turn a person half round."""
    count = int(rng.integers(3, 6))
    turns_rad = pi * rng.dirichlet(np.full(count, 20.0)) * rng.choice([-1.0, 1.0])
    return [(pace.length_m * float(rng.uniform(0.35, 0.6)), float(turn)) for turn in turns_rad]
