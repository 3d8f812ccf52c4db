"""Where and when a simulated crutch is planted, and how it moves between."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, radians, sin
from typing import Final

import numpy as np

from gaitway.api import WalkPlan
from gaitway.simulation import Knot, Person, RigidMotion, Shocks, Spline, Sum, rest, stream, via

_SETTLE_S: Final = 0.9
_STANDING_RAD: Final = radians(-6.0)


@dataclass(frozen=True, slots=True)
class Planted:
    """The tip on the floor at one place.

    Attributes:
        contact_s: When it came there.
        lift_s: When it leaves.
        x_m: Where.
        y_m: Where.
        heading_rad: Heading of the crutch at contact.
        twist_rad: How far it turns about the vertical while it stands.
        pitch_rad: At contact and at lift.
        roll_rad: Meanwhile.
        peak_newton: Greatest force.
        turning: A turn is made in the cycle that ends with it.
    """

    contact_s: float
    lift_s: float
    x_m: float
    y_m: float
    heading_rad: float
    twist_rad: float
    pitch_rad: tuple[float, float]
    roll_rad: float
    peak_newton: float
    turning: bool


def plan_stances(plan: WalkPlan, rng: np.random.Generator) -> list[Planted]:
    """Return standing, the stances of a walk, and the last one that ends in standing."""
    person = Person.draw(plan.seed)
    length_m = float(rng.uniform(0.7, 1.3))
    own_s = float(rng.uniform(1.15, 1.8))
    cycle_s = own_s if plan.speed_mps is None else length_m / plan.speed_mps
    share = float(rng.uniform(0.55, 0.68))
    contact, lift = -radians(rng.uniform(14.0, 26.0)), radians(rng.uniform(10.0, 22.0))
    roll, peak = -radians(rng.uniform(5.0, 12.0)), float(rng.uniform(100.0, 400.0))
    if plan.repetition:
        rng = stream(plan.seed, "crutch-tip", plan.repetition)
    x = y = heading = twist = 0.0
    standing = (_STANDING_RAD, _STANDING_RAD)
    found = [Planted(-1.0, plan.rest_s, x, y, heading, 0.0, standing, roll, 0.0, turning=False)]
    course = _course(plan, length_m, person, rng)
    for number, (stride_m, turn_rad) in enumerate(course, 1):
        time_s = cycle_s * float(rng.normal(1.0, person.time_variation))
        in_air = float(rng.uniform(0.4, 1.0)) * turn_rad
        heading += twist + in_air
        twist = turn_rad - in_air
        x += stride_m * cos(heading)
        y += stride_m * sin(heading)
        contact_s = found[-1].lift_s + time_s * (1.0 - share)
        last = number == len(course)
        lift_s = contact_s + (_SETTLE_S if last else time_s * share)
        usual = (contact, _STANDING_RAD if last else lift, roll)
        angles = (np.array(usual) + np.radians(rng.normal(0.0, 1.5, 3))).tolist()
        newton = peak * float(rng.normal(1.0, 0.08))
        pitches = (angles[0], angles[1])
        turning = turn_rad != 0.0
        found.append(
            Planted(contact_s, lift_s, x, y, heading, twist, pitches, angles[2], newton, turning)
        )
    return found


def crutch_motion(planted: Sequence[Planted], rng: np.random.Generator) -> RigidMotion:
    """Return the motion of a crutch whose tip is the origin of d."""
    contacts_s = np.array([stance.contact_s for stance in planted[1:]])
    ringing = rng.standard_normal((len(contacts_s), 3)) * np.array([5e-4, 3e-3, 1e-3])
    shocks = Shocks(contacts_s, ringing, float(rng.uniform(15.0, 25.0)), 0.01)
    angles = Spline(list(_angles(planted, rng)))
    return RigidMotion(Spline(list(_places(planted))), Sum(angles, shocks))


def _course(
    plan: WalkPlan, length_m: float, person: Person, rng: np.random.Generator
) -> list[tuple[float, float]]:
    """Return length and turn of each cycle; half a turn takes one to three of them."""
    count = max(3, round(plan.distance_m / length_m))
    sizes = length_m * rng.normal(1.0, person.length_variation, count)
    turns = np.zeros(count)
    if plan.turn_back:
        of_turn = int(rng.integers(1, 4))
        whole = pi * float(rng.choice([-1.0, 1.0]))
        turns = np.insert(turns, count // 2, whole * rng.dirichlet(np.full(of_turn, 20.0)))
        sizes = np.insert(sizes, count // 2, length_m * rng.uniform(0.2, 0.5, of_turn))
    return list(zip(sizes.tolist(), turns.tolist(), strict=True))


def _places(planted: Sequence[Planted]) -> Iterator[Knot]:
    for before, after in pairwise(planted):
        if before.contact_s >= 0.0:
            yield rest(before.contact_s, before.x_m, before.y_m, 0.0)
        yield rest(before.lift_s, before.x_m, before.y_m, 0.0)
        middle_s = 0.5 * (before.lift_s + after.contact_s)
        yield via(middle_s, 0.5 * (before.x_m + after.x_m), 0.5 * (before.y_m + after.y_m), 0.06)
    yield rest(planted[-1].contact_s, planted[-1].x_m, planted[-1].y_m, 0.0)


def _angles(planted: Sequence[Planted], rng: np.random.Generator) -> Iterator[Knot]:
    """Yield yaw, pitch and roll: at contact, half-way over the tip, and at lift."""
    first, *middle, last = planted
    yield rest(first.lift_s - 0.4, first.heading_rad, first.pitch_rad[1], first.roll_rad)
    yield via(first.lift_s, first.heading_rad, first.pitch_rad[1], first.roll_rad)
    for stance in middle:
        (contact, lift), roll = stance.pitch_rad, stance.roll_rad
        share = float(rng.uniform(0.45, 0.55))
        over_s = stance.contact_s + share * (stance.lift_s - stance.contact_s)
        heading, twist = stance.heading_rad, stance.twist_rad
        yield via(stance.contact_s, heading, contact, roll)
        yield via(over_s, heading + 0.5 * twist, 0.5 * (contact + lift), roll)
        yield via(stance.lift_s, heading + twist, lift, roll)
    yield via(last.contact_s, last.heading_rad, last.pitch_rad[0], last.roll_rad)
    yield rest(last.lift_s, last.heading_rad + last.twist_rad, last.pitch_rad[1], last.roll_rad)
