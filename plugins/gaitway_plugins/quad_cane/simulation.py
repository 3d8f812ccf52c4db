"""A person walking with a quad cane, with exact truth.

The cane stands by itself, is lifted, swung forward, put down and leaned on while the person steps,
over and over: on the ground it is still, in the air it translates and tilts a little (Dang and Suh
2018, Section 3.1.1 and Figures 3-5). The point whose path is measured is the base: the middle of
the four feet on the floor, origin of frame d.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, radians, sin, sqrt
from typing import Final, Self

import numpy as np

from gaitway.api import Floats, SimulatedWalk, WalkPlan
from gaitway.simulation import (
    SENSORS,
    Knot,
    Person,
    RigidMotion,
    Shocks,
    Spline,
    Stacked,
    Sum,
    TrueStride,
    mounted,
    record,
    rest,
    stream,
    via,
)

MOUNTING: Final = {"x": "up", "y": "right", "z": "forward"}
BASE_TO_IMU_D: Final = (0.02, 0.0, 0.5)
"""The IMU sits on the front of the shaft, half a metre above the floor."""
SPEED_RANGE_MPS: Final = (0.05, 1.2)
HOLDING_STILL: Final = 0.04
"""Tremor of the planted cane relative to the one in the air: the floor holds it."""
GRASP_S: Final = 0.3
"""The hand takes the cane this long before it is lifted first, and lets go as long after."""
SLIDE_S: Final = 0.05
SINK_S: Final = 0.03
ROCK_S: Final = 0.09
"""After contact the feet slide, sink in and find the floor one by one for this long."""
AWRY_SIGMA_RAD: Final = radians(1.0)
"""Standard deviation of each angle by which the IMU is fixed awry on the shaft."""


@dataclass(frozen=True, slots=True)
class Stance:
    """How the cane stands on the floor between two swings.

    Attributes:
        contact_s: When the feet touch the floor; 0 for the first stance.
        lift_s: When they leave it; the last stance goes on for ever.
        x_m: Base in n.
        y_m: Base in n.
        angles_rad: Yaw, pitch and roll: the floor is not even and a hand not exact.
    """

    contact_s: float
    lift_s: float
    x_m: float
    y_m: float
    angles_rad: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Habit:
    """A person's way with a quad cane.

    Attributes:
        length_m: Usual placement, 0.3 to 0.6 m where the plan sets no speed.
        cycle_s: From contact to contact, 1.5 to 2.5 s where the plan sets no speed.
        stance_share: Share of the cycle on the floor, 0.45 to 0.6.
        lift_m: How high the base is carried, 0.03 to 0.08 m from placement to placement.
        tilt_rad: How far the shaft is leaned forward after lifting and back before contact.
        touch_mps: Downward speed at which the feet meet the floor.
    """

    length_m: float
    cycle_s: float
    stance_share: float
    lift_m: float
    tilt_rad: float
    touch_mps: float

    @classmethod
    def draw(cls, person: Person, plan: WalkPlan, rng: np.random.Generator) -> Self:
        """Return the habit of a person; a planned speed changes length and cycle by equal shares.

        Raises:
            ValueError: Nobody walks at the plan's speed with a quad cane.
        """
        length_m = float(np.clip(rng.normal(0.45, 0.05) * sqrt(person.pace), 0.3, 0.6))
        cycle_s = float(np.clip(rng.normal(2.0, 0.15) / sqrt(person.pace), 1.5, 2.5))
        if plan.speed_mps is not None:
            low, high = SPEED_RANGE_MPS
            if not low <= plan.speed_mps <= high:
                raise ValueError(
                    f"speed_mps {plan.speed_mps}: a quad cane goes at {low} to {high} m/s"
                )
            ratio = plan.speed_mps * cycle_s / length_m
            length_m = float(np.clip(length_m * sqrt(ratio), 0.15, 0.9))
            cycle_s = length_m / plan.speed_mps
        return cls(
            length_m=length_m,
            cycle_s=cycle_s,
            stance_share=float(rng.uniform(0.45, 0.6)),
            lift_m=float(rng.uniform(0.035, 0.07)),
            tilt_rad=radians(float(rng.uniform(4.0, 9.0))),
            touch_mps=float(rng.uniform(0.08, 0.2)),
        )


def simulate(plan: WalkPlan) -> SimulatedWalk:
    """Return a walk with a quad cane.

    A stride is one placement: from the contact before (for the first: from lifting the cane) to
    its contact, its length the horizontal distance between the two places where the base stood.
    Small placements while turning round count like any other.

    Args:
        plan: What to walk; ``distance_m`` is reached to within half a placement. Condition
            ``sensor`` is a key of ``gaitway.simulation.SENSORS``.

    Raises:
        ValueError: The plan's speed is out of reach, or a condition is unknown.
    """
    sensor = str(plan.conditions.get("sensor", "mti"))
    if set(plan.conditions) - {"sensor"} or sensor not in SENSORS:
        raise ValueError(
            f"conditions {dict(plan.conditions)}: known is sensor, one of {', '.join(SENSORS)}"
        )
    person = Person.draw(plan.seed)
    rng = stream(plan.seed, "quad-cane")
    habit = Habit.draw(person, plan, rng)
    if plan.repetition:
        rng = stream(plan.seed, "quad-cane", plan.repetition)
    stances = _stances(plan, person, habit, rng)
    motion = _motion(stances, person, habit, rng)
    duration_s = stances[-1].contact_s + GRASP_S + plan.rest_s
    tilt_rad = rng.normal(0.0, AWRY_SIGMA_RAD, 3).tolist()
    place = mounted(MOUNTING, BASE_TO_IMU_D, tilt_rad)
    return record(plan, motion, place, duration_s, list(_strides(stances)), model=SENSORS[sensor])


def _strides(stances: Sequence[Stance]) -> Iterator[TrueStride]:
    start_s = stances[0].lift_s
    for before, after in pairwise(stances):
        length_m = float(np.hypot(after.x_m - before.x_m, after.y_m - before.y_m))
        yield TrueStride(start_s, after.contact_s, length_m)
        start_s = after.contact_s


def _stances(
    plan: WalkPlan, person: Person, habit: Habit, rng: np.random.Generator
) -> list[Stance]:
    """Return where and when the cane stands, from the first stance to the last."""
    lift_s = plan.rest_s + GRASP_S
    stances = [Stance(0.0, lift_s, 0.0, 0.0, _lean(person, 0.0, rng))]
    heading_rad = aim_rad = 0.0
    for length_m, turn_rad in _course(plan, person, habit, rng):
        aim_rad += turn_rad
        # Off course by a degree a placement, and steering back.
        veer_rad = turn_rad + 0.2 * (aim_rad - turn_rad - heading_rad) + rng.normal(0.0, 0.017)
        course_rad = heading_rad + 0.5 * veer_rad + rng.normal(0.0, 0.035)
        heading_rad += veer_rad
        cycle_s = habit.cycle_s * max(0.7, rng.normal(1.0, person.time_variation))
        stance_s = cycle_s * (habit.stance_share + rng.normal(0.0, 0.015))
        last = stances[-1]
        contact_s = last.lift_s + cycle_s - stance_s
        x_m, y_m = last.x_m + length_m * cos(course_rad), last.y_m + length_m * sin(course_rad)
        lean_rad = _lean(person, heading_rad, rng)
        stances.append(Stance(contact_s, contact_s + stance_s, x_m, y_m, lean_rad))
    return stances


def _course(
    plan: WalkPlan, person: Person, habit: Habit, rng: np.random.Generator
) -> Iterator[tuple[float, float]]:
    """Yield length and turn of each placement, at least one."""
    turns = _turn(rng) if plan.turn_back else []
    walked_m = 0.0
    while turns or walked_m == 0.0 or walked_m < plan.distance_m - 0.5 * habit.length_m:
        if turns and walked_m >= 0.5 * (plan.distance_m - habit.length_m):
            length_m, turn_rad = turns.pop()
        else:
            turn_rad = 0.0
            length_m = habit.length_m * max(0.4, rng.normal(1.0, 1.5 * person.length_variation))
        walked_m += length_m
        yield length_m, turn_rad


def _turn(rng: np.random.Generator) -> list[tuple[float, float]]:
    """Return length and turn of the short placements that turn a person half round."""
    count = int(rng.integers(5, 9))
    turns_rad = pi * rng.dirichlet(np.full(count, 20.0)) * rng.choice([-1.0, 1.0])
    return [(float(rng.uniform(0.08, 0.22)), float(turn_rad)) for turn_rad in turns_rad]


def _lean(
    person: Person, heading_rad: float, rng: np.random.Generator
) -> tuple[float, float, float]:
    """Return yaw, pitch and roll of a planted cane, different each time it is put down."""
    return (
        heading_rad + radians(rng.normal(0.0, 2.0)),
        0.5 * person.posture_pitch_rad + radians(float(np.clip(rng.normal(0.0, 0.7), -2.0, 2.0))),
        0.5 * person.posture_roll_rad + radians(float(np.clip(rng.normal(0.0, 0.7), -2.0, 2.0))),
    )


def _motion(
    stances: Sequence[Stance], person: Person, habit: Habit, rng: np.random.Generator
) -> RigidMotion:
    ground: list[Knot] = []
    height: list[Knot] = []
    angles: list[Knot] = []
    grip = [rest(stances[0].lift_s - GRASP_S, 0.0)]
    for before, after in pairwise(stances):
        ground += _across_ground(before, after, rng)
        height += _over_ground(before, after, habit, rng)
        angles += _tilting(before, after, habit, rng)
        grip += _holding(before, after)
    grip.append(rest(stances[-1].contact_s + GRASP_S, 0.0))
    contacts_s = np.array([stance.contact_s for stance in stances[1:]])
    base, shaft = _shocks(contacts_s, rng)
    return RigidMotion(
        position=Sum(Stacked(Spline(ground), Spline(height)), base),
        angles=Sum(Spline(angles), shaft, person.tremor(Spline(grip), rng)),
    )


def _across_ground(before: Stance, after: Stance, rng: np.random.Generator) -> Iterator[Knot]:
    """Yield where the base is in the plane; at contact it still slides a millimetre or two."""
    place = np.array([after.x_m, after.y_m])
    way = place - [before.x_m, before.y_m]
    sliding_mps = rng.uniform(0.02, 0.08) * way / np.linalg.norm(way)
    touch = place - 0.4 * SLIDE_S * sliding_mps
    yield rest(before.lift_s, before.x_m, before.y_m)
    yield Knot(after.contact_s, tuple(touch), tuple(sliding_mps), (0.0, 0.0))
    yield rest(after.contact_s + SLIDE_S, *place)


def _over_ground(
    before: Stance, after: Stance, habit: Habit, rng: np.random.Generator
) -> Iterator[Knot]:
    """Yield the height of the base; the rubber feet give by a millimetre when they land."""
    swing_s = after.contact_s - before.lift_s
    touch_mps = habit.touch_mps * rng.uniform(0.7, 1.3)
    yield rest(before.lift_s, 0.0)
    lift_m = habit.lift_m * rng.uniform(0.85, 1.15)
    yield via(before.lift_s + rng.uniform(0.4, 0.55) * swing_s, lift_m)
    yield Knot(after.contact_s, (0.0,), (-touch_mps,), (0.0,))
    yield rest(after.contact_s + SINK_S, 0.0)


def _tilting(
    before: Stance, after: Stance, habit: Habit, rng: np.random.Generator
) -> Iterator[Knot]:
    """Yield yaw, pitch and roll: forward after lifting, back before contact, then foot by foot."""
    swing_s = after.contact_s - before.lift_s
    old, new = np.array(before.angles_rad), np.array(after.angles_rad)
    tilt = np.array([0.0, habit.tilt_rad * rng.uniform(0.8, 1.2), 0.0])
    sway = np.array([0.0, 0.0, radians(rng.normal(0.0, 1.5))])
    uneven = np.radians([0.3, 0.5, 0.5]) * rng.standard_normal(3)
    yield rest(before.lift_s, *old)
    yield via(before.lift_s + 0.30 * swing_s, *(0.70 * old + 0.30 * new + 0.6 * tilt + sway))
    yield via(before.lift_s + 0.75 * swing_s, *(0.25 * old + 0.75 * new - tilt - sway))
    yield Knot(after.contact_s, tuple(new + uneven), accelerations=(0.0, 0.0, 0.0))
    yield rest(after.contact_s + ROCK_S, *new)


def _holding(before: Stance, after: Stance) -> Iterator[Knot]:
    """Yield how freely the hand's tremor moves the cane: 1 in the air, hardly on the floor."""
    yield rest(before.lift_s, HOLDING_STILL)
    yield rest(before.lift_s + 0.25 * (after.contact_s - before.lift_s), 1.0)
    yield rest(after.contact_s, 1.0)
    yield rest(after.contact_s + ROCK_S, HOLDING_STILL)


def _shocks(contacts_s: Floats, rng: np.random.Generator) -> tuple[Shocks, Shocks]:
    """Return how the rubber feet ring, gone within 0.15 s, and the shaft, within 0.3 s.

    The first is a fraction of a millimetre, the second of a tenth of a degree.
    """
    size = (len(contacts_s), 3)
    feet_m = rng.standard_normal(size) * np.array([1.5e-4, 1.5e-4, 2.5e-4])
    shaft_rad = rng.standard_normal(size) * np.array([5e-4, 2e-3, 1e-3])
    return (
        Shocks(contacts_s, feet_m, float(rng.uniform(30.0, 45.0)), 0.004),
        Shocks(contacts_s, shaft_rad, float(rng.uniform(15.0, 25.0)), 0.008),
    )
