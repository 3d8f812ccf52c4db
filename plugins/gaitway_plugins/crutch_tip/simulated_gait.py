"""How a crutch is walked with: where and when it stands, and how it moves meanwhile."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import cos, pi, radians, sin, sqrt
from typing import Final, Self

import numpy as np

from gaitway.api import Floats, WalkPlan
from gaitway.simulation import Knot, Person, RigidMotion, Shocks, Spline, Stacked, Sum, rest, via

LENGTH_M: Final = 0.95
"""From the tip to the handle."""
SPEED_RANGE_MPS: Final = (0.1, 1.2)
GRASP_S: Final = 0.6
"""Leaning on the crutch before the first step and after the last."""


@dataclass(frozen=True, slots=True)
class Stance:
    """How the crutch stands on the floor between two swings.

    Attributes:
        contact_s: When the tip touches the floor; 0 for the first stance.
        lift_s: When it leaves it; the last stance goes on for ever.
        x_m: Tip in n.
        y_m: Tip in n.
        yaw_rad: At contact.
        twist_rad: By how much it turns about the vertical until it is lifted.
        contact_rad: Pitch at contact.
        lift_rad: Pitch at lift.
        roll_rad: Lean to the right.
        peak_newton: Greatest axial force.
        turning: Whether the swing before it and the stance belong to a turn.
    """

    contact_s: float
    lift_s: float
    x_m: float
    y_m: float
    yaw_rad: float
    twist_rad: float
    contact_rad: float
    lift_rad: float
    roll_rad: float
    peak_newton: float
    turning: bool


@dataclass(frozen=True, slots=True)
class Habit:
    """A person's way with a crutch.

    Attributes:
        length_m: Usual stride, 0.6 to 1.2 m where the plan sets no speed.
        cycle_s: From contact to contact, 1.3 to 2.4 s where the plan sets no speed.
        stance_share: Share of the cycle on the floor, 0.45 to 0.6.
        early: How far the tip is ahead at contact, as a share of the angle of a stance.
        roll_rad: Usual lean to the right.
        clearance_m: How high the tip is swung.
        peak_newton: Usual greatest force, 100 to 400 N.
    """

    length_m: float
    cycle_s: float
    stance_share: float
    early: float
    roll_rad: float
    clearance_m: float
    peak_newton: float

    @classmethod
    def draw(cls, person: Person, plan: WalkPlan, rng: np.random.Generator) -> Self:
        """Return the habit of a person; a planned speed changes length and cycle by equal shares.

        Raises:
            ValueError: Nobody walks at the plan's speed with a crutch.
        """
        length_m = float(np.clip(rng.normal(0.9, 0.12) * sqrt(person.pace), 0.6, 1.2))
        cycle_s = float(np.clip(rng.normal(1.7, 0.2) / sqrt(person.pace), 1.3, 2.4))
        if plan.speed_mps is not None:
            low, high = SPEED_RANGE_MPS
            if not low <= plan.speed_mps <= high:
                raise ValueError(f"speed_mps {plan.speed_mps}: a crutch goes at {low} to {high}")
            ratio = plan.speed_mps * cycle_s / length_m
            length_m = float(np.clip(length_m * sqrt(ratio), 0.2, 1.4))
            cycle_s = length_m / plan.speed_mps
        return cls(
            length_m=length_m,
            cycle_s=cycle_s,
            stance_share=float(rng.uniform(0.45, 0.6)),
            early=float(rng.uniform(0.35, 0.6)),
            roll_rad=radians(float(rng.uniform(2.0, 6.0))),
            clearance_m=float(rng.uniform(0.03, 0.1)),
            peak_newton=float(rng.uniform(100.0, 400.0)),
        )


def stances_of(
    plan: WalkPlan, habit: Habit, person: Person, turn_cycles: int, rng: np.random.Generator
) -> list[Stance]:
    """Return where and when the crutch stands, from the first stance to the last."""
    upright = radians(float(rng.normal(0.0, 1.5)))
    lift_s = plan.rest_s + GRASP_S
    first_newton = habit.peak_newton * rng.uniform(0.4, 0.8)
    stances = [
        Stance(0.0, lift_s, 0.0, 0.0, 0.0, 0.0, upright, upright, habit.roll_rad, first_newton,
               turning=False)
    ]  # fmt: skip
    for length_m, turn_rad, lean_rad in _course(plan, habit, person, turn_cycles, rng):
        last = stances[-1]
        cycle_s = habit.cycle_s * max(0.7, rng.normal(1.0, person.time_variation))
        stance_s = cycle_s * (habit.stance_share + rng.normal(0.0, 0.015))
        contact_s = last.lift_s + cycle_s - stance_s
        # Two thirds of a turn while the tip is in the air, the rest about the planted tip.
        yaw_rad = last.yaw_rad + last.twist_rad + turn_rad * 2.0 / 3.0
        course_rad = last.yaw_rad + 0.5 * turn_rad
        angle_rad = habit.stance_share * max(length_m, 0.3) / LENGTH_M
        early_rad = -angle_rad * (habit.early + rng.normal(0.0, 0.03))
        stances.append(
            Stance(
                contact_s=contact_s,
                lift_s=contact_s + stance_s,
                x_m=last.x_m + length_m * cos(course_rad),
                y_m=last.y_m + length_m * sin(course_rad),
                yaw_rad=yaw_rad,
                twist_rad=turn_rad / 3.0,
                contact_rad=early_rad,
                lift_rad=early_rad + angle_rad,
                roll_rad=habit.roll_rad + lean_rad + radians(rng.normal(0.0, 0.7)),
                peak_newton=float(habit.peak_newton * max(0.5, rng.normal(1.0, 0.08))),
                turning=bool(turn_rad),
            )
        )
    last = stances[-1]
    stances[-1] = replace(last, lift_rad=0.3 * last.contact_rad, twist_rad=0.0)
    return stances


def _course(
    plan: WalkPlan, habit: Habit, person: Person, turn_cycles: int, rng: np.random.Generator
) -> Iterator[tuple[float, float, float]]:
    """Yield length, turn and sideways lean of each step, at least one."""
    turns = _turn(turn_cycles, rng) if plan.turn_back else []
    walked_m = 0.0
    while turns or walked_m == 0.0 or walked_m < plan.distance_m - 0.5 * habit.length_m:
        if turns and walked_m >= 0.5 * (plan.distance_m - habit.length_m):
            step = turns.pop()
        else:
            length_m = habit.length_m * max(0.5, rng.normal(1.0, person.length_variation))
            step = (length_m, 0.0, 0.0)
        walked_m += step[0]
        yield step


def _turn(cycles: int, rng: np.random.Generator) -> list[tuple[float, float, float]]:
    """Return the steps that turn a person half round: 60 to 180 degrees each."""
    count = cycles or int(rng.integers(1, 4))
    side = rng.choice([-1.0, 1.0])
    return [
        (float(rng.uniform(0.2, 0.5)), float(side * pi / count), radians(rng.uniform(5.0, 12.0)))
        for _ in range(count)
    ]


def motion_of(
    stances: Sequence[Stance], person: Person, habit: Habit, shock: float, rng: np.random.Generator
) -> RigidMotion:
    """Return how the crutch moves through its stances."""
    ground: list[Knot] = []
    height: list[Knot] = []
    angles: list[Knot] = []
    first = stances[0]
    pushed_s = first.lift_s - 0.3 * GRASP_S
    angles.append(rest(pushed_s, first.yaw_rad, first.contact_rad, first.roll_rad))
    for before, after in pairwise(stances):
        ground += [
            rest(before.lift_s, before.x_m, before.y_m), rest(after.contact_s, after.x_m, after.y_m)
        ]  # fmt: skip
        swing_s = after.contact_s - before.lift_s
        top_m = habit.clearance_m * rng.uniform(0.8, 1.2)
        top_s = before.lift_s + rng.uniform(0.4, 0.6) * swing_s
        height += [rest(before.lift_s, 0.0), via(top_s, top_m), rest(after.contact_s, 0.0)]
        angles += _turning(before, after, rng)
    last = stances[-1]
    angles.append(rest(last.contact_s + GRASP_S, last.yaw_rad, last.lift_rad, last.roll_rad))
    contacts_s = np.array([stance.contact_s for stance in stances[1:]])
    tip, shaft = _shocks(contacts_s, shock, rng)
    holding = Spline([rest(0.0, 0.3)])
    return RigidMotion(
        position=Sum(Stacked(Spline(ground), Spline(height)), tip),
        angles=Sum(Spline(angles), shaft, person.tremor(holding, rng)),
    )


def _turning(before: Stance, after: Stance, rng: np.random.Generator) -> Iterator[Knot]:
    """Yield yaw, pitch and roll from lift to contact; the swing overshoots either end a little."""
    swing_s = after.contact_s - before.lift_s
    yaw_rad = before.yaw_rad + before.twist_rad
    over_rad = np.radians(rng.uniform(1.0, 5.0, 2))
    roll_rad = 0.5 * (before.roll_rad + after.roll_rad) + radians(rng.normal(0.0, 2.0))
    yield via(before.lift_s, yaw_rad, before.lift_rad, before.roll_rad)
    yield via(
        before.lift_s + 0.2 * swing_s,
        yaw_rad + 0.15 * (after.yaw_rad - yaw_rad),
        before.lift_rad + over_rad[0],
        0.8 * before.roll_rad + 0.2 * roll_rad,
    )
    yield via(
        before.lift_s + 0.8 * swing_s,
        yaw_rad + 0.85 * (after.yaw_rad - yaw_rad),
        after.contact_rad - over_rad[1],
        0.4 * after.roll_rad + 0.6 * roll_rad,
    )
    yield via(after.contact_s, after.yaw_rad, after.contact_rad, after.roll_rad)


def _shocks(contacts_s: Floats, strength: float, rng: np.random.Generator) -> tuple[Shocks, Shocks]:
    """Return how the rubber rings when it lands, gone within 0.15 s, and the shaft."""
    size = (len(contacts_s), 3)
    tip_m = strength * rng.standard_normal(size) * np.array([2e-4, 2e-4, 3e-4])
    shaft_rad = strength * rng.standard_normal(size) * np.array([3e-4, 1e-3, 1e-3])
    return (
        Shocks(contacts_s, tip_m, float(rng.uniform(30.0, 45.0)), 0.004),
        Shocks(contacts_s, shaft_rad, float(rng.uniform(15.0, 25.0)), 0.008),
    )
