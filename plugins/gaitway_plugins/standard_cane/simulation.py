"""A person walking with a standard cane, with exact truth.

The tip stands while the person leans the shaft over it, an inverted pendulum; then the tip is
lifted, swung ahead of the hand and put down again (Dang & Suh 2018, Section 3.1.2 and Figures 7 to
10). The point whose path is measured is the tip, origin of frame d. The shaft never stands still:
it turns on at contact and at lift, the hand trembles, the rubber rolls, rings and slides.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import asin, cos, pi, radians, sin, sqrt
from typing import Final, Self

import numpy as np

from gaitway.api import Floats, SimulatedWalk, WalkPlan
from gaitway.simulation import (
    ImuModel,
    Knot,
    Person,
    RigidMotion,
    Shocks,
    Spline,
    Stacked,
    Sum,
    Tremor,
    TrueStride,
    mounted,
    record,
    rest,
    stream,
    via,
)

MOUNTING: Final = {"x": "up", "y": "right", "z": "forward"}
SPEED_RANGE_MPS: Final = (0.1, 1.6)
HAND_M: Final = 0.85
"""Height of the hand above the tip."""
MEMS: Final = ImuModel(
    gyro=replace(ImuModel().gyro, noise_rthz=radians(0.02), bias=radians(0.5), scale=3e-3),
    accel=replace(ImuModel().accel, noise_rthz=3e-3, bias=0.05, scale=3e-3),
)
"""A cheap sensor, not calibrated."""
SETTLE_S: Final = 0.05
"""After contact the rubber slides and gives for so long."""
LIMITS: Final = {
    "imu_to_tip_m": (0.1, 0.9), "sway_rad": (0.0, 0.2), "creep_m": (0.0, 0.02),
    "shock": (0.0, 5.0), "lift_m": (0.02, 0.2),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Conditions:
    """What can be varied by name.

    Attributes:
        imu_to_tip_m: Height of the IMU above the tip, along the shaft.
        sway_rad: Amplitude of the hand's swaying before and after the walk.
        creep_m: How far the rubber rolls in a stance, at most.
        shock: Of contacts, relative to the usual.
        lift_m: How high the tip is swung; the person's own where 0.
        sensor: ``mti`` or ``mems``.
    """

    imu_to_tip_m: float = 0.575
    sway_rad: float = 0.01
    creep_m: float = 0.002
    shock: float = 1.0
    lift_m: float = 0.0
    sensor: str = "mti"

    @classmethod
    def of(cls, plan: WalkPlan) -> Self:
        """Return what a plan asks for.

        Raises:
            ValueError: It asks for something unknown or out of range.
        """
        values: dict[str, str | float] = {}
        for name, value in plan.conditions.items():
            if name == "sensor" and value in ("mti", "mems"):
                values[name] = value
                continue
            if name not in LIMITS or isinstance(value, str):
                known = ", ".join((*LIMITS, "sensor (mti or mems)"))
                raise ValueError(f"condition {name} = {value}: a standard cane has {known}")
            low, high = LIMITS[name]
            if not low <= value <= high:
                raise ValueError(f"condition {name} = {value}: is from {low} to {high}")
            values[name] = value
        return cls(**values)  # type: ignore[arg-type]  # checked by name above


@dataclass(frozen=True, slots=True)
class Stance:
    """How the tip stands between two swings.

    Attributes:
        contact_s: When the tip touches the floor; 0 for the first stance.
        lift_s: When it leaves it; the last stance goes on for ever.
        place_m: Of the tip in the plane, shape (2,).
        creep_m: How far it rolls until it is lifted, shape (2,).
        contact_rad: Yaw, pitch and roll of the shaft at contact, shape (3,).
        lift_rad: The same at lift.
    """

    contact_s: float
    lift_s: float
    place_m: Floats
    creep_m: Floats
    contact_rad: Floats
    lift_rad: Floats


@dataclass(frozen=True, slots=True)
class Habit:
    """A person's way with a standard cane.

    Attributes:
        length_m: Usual placement.
        cycle_s: From contact to contact.
        stance_share: Share of the cycle on the floor.
        lift_m: How high the tip is swung.
        touch_mps: Downward speed at which it meets the floor.
    """

    length_m: float
    cycle_s: float
    stance_share: float
    lift_m: float
    touch_mps: float

    @classmethod
    def draw(cls, person: Person, plan: WalkPlan, rng: np.random.Generator) -> Self:
        """Return the habit of a person; a planned speed changes length and cycle by equal shares.

        Raises:
            ValueError: Nobody walks at the plan's speed with a cane.
        """
        length_m = float(np.clip(rng.normal(0.85, 0.1) * sqrt(person.pace), 0.5, 1.2))
        cycle_s = float(np.clip(rng.normal(1.3, 0.1) / sqrt(person.pace), 0.95, 2.0))
        if plan.speed_mps is not None:
            low, high = SPEED_RANGE_MPS
            if not low <= plan.speed_mps <= high:
                raise ValueError(f"speed_mps {plan.speed_mps}: a cane goes at {low} to {high} m/s")
            ratio = plan.speed_mps * cycle_s / length_m
            length_m = float(np.clip(length_m * sqrt(ratio), 0.25, 1.5))
            cycle_s = length_m / plan.speed_mps
        return cls(
            length_m=length_m,
            cycle_s=cycle_s,
            stance_share=float(rng.uniform(0.5, 0.62)),
            lift_m=float(rng.uniform(0.03, 0.1)),
            touch_mps=float(rng.uniform(0.1, 0.4)),
        )


def simulate(plan: WalkPlan) -> SimulatedWalk:
    """Return a walk with a standard cane.

    A stride is one placement: from the contact before (for the first: from lifting the cane) to
    its contact, its length the horizontal distance between the two places of the tip.

    Args:
        plan: What to walk; ``distance_m`` is reached to within half a placement. Conditions:
            ``imu_to_tip_m`` (height of the IMU above the tip), ``sway_rad``, ``creep_m``,
            ``shock``, ``lift_m``, ``sensor`` (``mti`` or ``mems``).

    Raises:
        ValueError: The plan's speed or a condition is out of reach.
    """
    conditions = Conditions.of(plan)
    person = Person.draw(plan.seed)
    rng = stream(plan.seed, "standard-cane")
    habit = Habit.draw(person, plan, rng)
    if conditions.lift_m:
        habit = replace(habit, lift_m=conditions.lift_m)
    awry_rad = rng.normal(0.0, radians(1.0))
    if plan.repetition:
        rng = stream(plan.seed, "standard-cane", plan.repetition)
    stances = _stances(plan, habit, conditions, rng)
    end_s = stances[-1].contact_s + 0.3 + plan.rest_s
    motion = _motion(stances, end_s, person, habit, conditions, rng)
    # Awry about the shaft only: the way to the tip stays as it was told.
    place = mounted(MOUNTING, (0.0, 0.0, conditions.imu_to_tip_m), (awry_rad, 0.0, 0.0))
    model = MEMS if conditions.sensor == "mems" else ImuModel()
    return record(plan, motion, place, end_s, list(_strides(stances)), model=model)


def _strides(stances: Sequence[Stance]) -> Iterator[TrueStride]:
    start_s = stances[0].lift_s
    for before, after in pairwise(stances):
        length_m = float(np.linalg.norm(after.place_m - before.place_m))
        yield TrueStride(start_s, after.contact_s, length_m)
        start_s = after.contact_s


def _stances(
    plan: WalkPlan, habit: Habit, conditions: Conditions, rng: np.random.Generator
) -> list[Stance]:
    """Return where and when the tip stands, from the first stance to the last."""
    lift_s = plan.rest_s
    upright = np.radians(rng.normal(0.0, 2.0, 3))
    nowhere = np.zeros(2)
    stances = [Stance(0.0, lift_s, nowhere, nowhere, upright, upright)]
    heading_rad = 0.0
    for length_m, turn_rad in _course(plan, habit, rng):
        # Off course by a degree a placement, and steering back.
        heading_rad += turn_rad + rng.normal(0.0, 0.02)
        cycle_s = habit.cycle_s * max(0.7, rng.normal(1.0, 0.04))
        stance_s = cycle_s * (habit.stance_share + rng.normal(0.0, 0.015))
        last = stances[-1]
        contact_s = last.lift_s + cycle_s - stance_s
        way = np.array([cos(heading_rad), sin(heading_rad)])
        half_rad = asin(min(0.6, 0.5 * habit.stance_share * length_m / HAND_M))
        lean_rad = np.radians(rng.normal(0.0, 2.0, (2, 3)))
        lean_rad += [[heading_rad, -half_rad, 0.0], [heading_rad, half_rad, 0.0]]
        creep_m = conditions.creep_m * rng.uniform(0.0, 1.0) * way
        place_m = last.place_m + length_m * way
        stances.append(Stance(contact_s, contact_s + stance_s, place_m, creep_m, *lean_rad))
    return stances


def _course(
    plan: WalkPlan, habit: Habit, rng: np.random.Generator
) -> Iterator[tuple[float, float]]:
    """Yield length and turn of each placement, at least one."""
    turns = int(rng.integers(4, 7)) if plan.turn_back else 0
    turn_rad = pi / turns * float(rng.choice([-1.0, 1.0])) if turns else 0.0
    walked_m = 0.0
    while turns or walked_m == 0.0 or walked_m < plan.distance_m - 0.5 * habit.length_m:
        length_m = habit.length_m * max(0.4, rng.normal(1.0, 0.05))
        if turns and walked_m >= 0.5 * (plan.distance_m - habit.length_m):
            turns -= 1
            length_m *= 0.5
            yield length_m, turn_rad
        else:
            yield length_m, 0.0
        walked_m += length_m


def _motion(
    stances: Sequence[Stance],
    end_s: float,
    person: Person,
    habit: Habit,
    conditions: Conditions,
    rng: np.random.Generator,
) -> RigidMotion:
    ground: list[Knot] = []
    height: list[Knot] = []
    for before, after in pairwise(stances):
        ground += _across_ground(before, after, rng)
        height += _over_ground(before, after, habit, rng)
    contacts_s = np.array([stance.contact_s for stance in stances[1:]])
    tip, shaft = _shocks(contacts_s, conditions.shock, rng)
    lift_s, down_s = stances[0].lift_s, stances[-1].contact_s + 0.3
    grip = Spline([rest(0.0, 0.0), rest(lift_s, 1.0), rest(down_s, 1.0), rest(end_s, 0.0)])
    return RigidMotion(
        position=Sum(Stacked(Spline(ground), Spline(height)), tip),
        angles=Sum(
            Spline(list(_leaning(stances))),
            shaft,
            person.tremor(grip, rng),
            _sway(lift_s, down_s, end_s, conditions.sway_rad, rng),
        ),
    )


def _leaning(stances: Sequence[Stance]) -> Iterator[Knot]:
    """Yield yaw, pitch and roll: over the tip in stance, back in swing, never at rest between."""
    yield rest(stances[0].lift_s - 0.1, *stances[0].lift_rad)
    for stance in stances[1:-1]:
        yield via(stance.contact_s, *stance.contact_rad)
        yield via(stance.lift_s, *stance.lift_rad)
    last = stances[-1]
    yield via(last.contact_s, *last.contact_rad)
    yield rest(last.contact_s + 0.3, *(0.5 * (last.contact_rad + last.lift_rad)))


def _across_ground(before: Stance, after: Stance, rng: np.random.Generator) -> Iterator[Knot]:
    """Yield where the tip is in the plane; at contact it still slides a millimetre or two."""
    way = after.place_m - before.place_m
    sliding_mps = rng.uniform(0.0, 0.1) * way / np.linalg.norm(way)
    touch = after.place_m - 0.4 * SETTLE_S * sliding_mps
    yield rest(before.lift_s, *(before.place_m + before.creep_m))
    yield Knot(after.contact_s, tuple(touch), tuple(sliding_mps), (0.0, 0.0))
    yield rest(after.contact_s + SETTLE_S, *after.place_m)


def _over_ground(
    before: Stance, after: Stance, habit: Habit, rng: np.random.Generator
) -> Iterator[Knot]:
    """Yield the height of the tip; the rubber gives by a millimetre when it lands."""
    swing_s = after.contact_s - before.lift_s
    touch_mps = habit.touch_mps * rng.uniform(0.7, 1.3)
    yield rest(before.lift_s, 0.0)
    lift_m = habit.lift_m * rng.uniform(0.85, 1.15)
    yield via(before.lift_s + rng.uniform(0.4, 0.6) * swing_s, lift_m)
    yield Knot(after.contact_s, (0.0,), (-touch_mps,), (0.0,))
    yield rest(after.contact_s + 0.6 * SETTLE_S, 0.0)


def _sway(
    lift_s: float, down_s: float, end_s: float, sway_rad: float, rng: np.random.Generator
) -> Tremor:
    """Return how the hand moves the planted cane before and after the walk."""
    quiet = [rest(lift_s, 0.0), rest(down_s, 0.0)]
    envelope = [
        rest(0.0, 0.0), rest(0.2 * lift_s, 1.0), rest(0.8 * lift_s, 1.0), *quiet,
        rest(down_s + 0.3 * (end_s - down_s), 1.0), rest(end_s, 0.0),
    ]  # fmt: skip
    peaks = sway_rad * rng.uniform(0.3, 0.6, (2, 3))
    return Tremor(Spline(envelope), peaks, [0.35, 0.8], rng.uniform(0.0, 2.0 * pi, (2, 3)))


def _shocks(contacts_s: Floats, shock: float, rng: np.random.Generator) -> tuple[Shocks, Shocks]:
    """Return how the rubber tip rings, gone within 0.15 s, and the shaft, within 0.3 s."""
    size = (len(contacts_s), 3)
    tip_m = shock * rng.standard_normal(size) * np.array([1e-4, 1e-4, 2e-4])
    shaft_rad = shock * rng.standard_normal(size) * np.array([5e-4, 1e-3, 1e-3])
    return (
        Shocks(contacts_s, tip_m, float(rng.uniform(30.0, 45.0)), 0.004),
        Shocks(contacts_s, shaft_rad, float(rng.uniform(15.0, 25.0)), 0.008),
    )
