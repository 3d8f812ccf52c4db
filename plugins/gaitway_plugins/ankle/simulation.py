"""A person walking on the level or on stairs with a sensor at the ankle, with exact truth.

The sensor is strapped to the outside of the lower leg just above the malleolus; what is measured is
the path of the ankle joint. Walking begins with half a stride from standing and ends with half a
stride to standing. The foot rolls (``gaitway.simulation.Sole``): heel strike, flat, over the ball;
so nothing of it stands still all through a stance, and the sensor never.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import cos, pi, radians, sin, sqrt
from typing import Final, Self, TypeVar

import numpy as np

from gaitway.api import Floats, SimulatedWalk, WalkPlan
from gaitway.simulation import (
    SENSORS,
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
ANKLE_TO_IMU_D: Final = (0.01, 0.04, 0.07)
"""Seven centimetres above the ankle joint and four to its side."""
STRAP_SIGMA_RAD: Final = (radians(4.0), radians(2.5), radians(2.0))
"""Standard deviations of yaw, pitch and roll with which a sensor is strapped on by eye."""
SPEED_RANGE_MPS: Final = (0.25, 2.2)
MID_STANCE: Final = 0.4
"""Share of the stance in which the foot is flat: strides run from there to there."""
RISE_S: Final = 0.75
"""From standing still to the first toe-off."""
SETTLE_S: Final = 0.5
"""From the last contact to standing still."""
STAIR_RISE_M: Final = 0.17
STAIR_TREAD_M: Final = 0.28
_MORE_THAN_HALF: Final = 0.75
_CLIMBS: Final = {"level": 0.0, "stairs-up": 1.0, "stairs-down": -1.0}
_DEG: Final = pi / 180.0
_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class Pace:
    """How a person walks.

    Attributes:
        length_m: Of a usual stride (two steps).
        cycle_s: From contact to contact of one foot.
        stance_share: Share of the cycle on the floor.
        range_of_usual: The stride relative to the person's stride at 1.25 m/s.
        climb_m: How much a stride rises.
    """

    length_m: float
    cycle_s: float
    stance_share: float
    range_of_usual: float
    climb_m: float

    @classmethod
    def draw(cls, person: Person, plan: WalkPlan, rng: np.random.Generator) -> Self:
        """Return the pace of a person at the plan's speed, or at their own (1.25 m/s times pace).

        On the level step length over cadence is constant, about 0.0064 m/(steps/min) (Sekiya and
        Nagasaki 1998), in proportion to body height. On stairs a stride is two treads, at 0.75
        strides a second times pace.

        Raises:
            ValueError: The plan's speed is out of reach.
        """
        climb = _condition(plan, "terrain", _CLIMBS, "level")
        speed_mps = 1.25 * person.pace if plan.speed_mps is None else plan.speed_mps
        low, high = SPEED_RANGE_MPS
        if not low <= speed_mps <= high:
            raise ValueError(f"speed_mps {speed_mps}: this simulation walks at {low} to {high} m/s")
        walk_ratio = 0.0064 * person.height_m / 1.7 * float(rng.normal(1.0, 0.06))
        share_off = float(rng.normal(0.0, 0.01))
        if climb:
            length_m = 2.0 * STAIR_TREAD_M
            return cls(length_m, 1.0 / (0.75 * person.pace), 0.63 + share_off, 0.5,
                       2.0 * climb * STAIR_RISE_M)  # fmt: skip
        cadence_spm = sqrt(60.0 * speed_mps / walk_ratio)
        return cls(
            length_m=2.0 * walk_ratio * cadence_spm,
            cycle_s=120.0 / cadence_spm,
            stance_share=0.615 - 0.055 * (speed_mps - 1.25) + share_off,
            range_of_usual=sqrt(speed_mps / 1.25),
            climb_m=0.0,
        )


def simulate(plan: WalkPlan) -> SimulatedWalk:
    """Return a walk with a sensor at the ankle.

    A stride runs from one mid-stance to the next, the first from where standing ends, the last to
    where standing begins again; its length is the horizontal displacement of the ankle.

    Args:
        plan: What to walk; ``distance_m`` is kept on a straight level way, and elsewhere reached
            to within half a stride. Conditions:
            ``terrain`` (``level``, ``stairs-up``, ``stairs-down``: steps of 17 on 28 cm) and
            ``sensor`` (``mti``, ``cheap``).

    Raises:
        ValueError: The plan's speed is out of reach, or a condition is not known.
    """
    unknown = set(plan.conditions) - {"terrain", "sensor"}
    if unknown:
        raise ValueError(f"conditions of an ankle are terrain and sensor, not {sorted(unknown)}")
    person = Person.draw(plan.seed)
    rng = stream(plan.seed, "ankle")
    pace = Pace.draw(person, plan, rng)
    leg = Leg.draw(person, rng)
    tilts_rad = [float(rng.normal(0.0, sigma_rad)) for sigma_rad in STRAP_SIGMA_RAD]
    if plan.repetition:
        rng = stream(plan.seed, "ankle", plan.repetition)
    footfalls = _footfalls(plan, person, pace, rng)
    motion = leg_motion(footfalls, leg, rng)
    forward_m, outward_m, up_m = ANKLE_TO_IMU_D
    walk = record(
        plan,
        motion,
        mounted(MOUNTING, (forward_m, leg.side * outward_m, up_m), tilts_rad),
        footfalls[-1].off_s + plan.rest_s,
        list(_strides(footfalls, motion)),
        model=_condition(plan, "sensor", SENSORS, "mti"),
    )
    return _with_heights(walk, footfalls)


def _with_heights(walk: SimulatedWalk, footfalls: Sequence[Footfall]) -> SimulatedWalk:
    heights_m = np.diff([step.z_m for step in footfalls])
    words = {0.0: "level", 1.0: "stairs-up", -1.0: "stairs-down"}
    truth: dict[str, Floats | tuple[str, ...]] = {
        "stride_height_m": heights_m,
        "terrain": tuple(words[float(np.sign(height_m))] for height_m in heights_m),
        "contact_s": np.array([step.contact_s for step in footfalls[1:]]),
        "lift_s": np.array([step.off_s for step in footfalls[:-1]]),
    }
    return SimulatedWalk(
        walk.rate_hz, walk.channels, walk.stride_start_s, walk.stride_end_s, walk.stride_length_m,
        walk.pos_n, walk.q_nb, truth,
    )  # fmt: skip


def _condition(plan: WalkPlan, name: str, values: Mapping[str, _T], usual: str) -> _T:
    """Return what a condition stands for."""
    value = str(plan.conditions.get(name, usual))
    if value not in values:
        raise ValueError(f"{name} {value!r}: one of {', '.join(values)}")
    return values[value]


def _strides(footfalls: Sequence[Footfall], motion: RigidMotion) -> Iterator[TrueStride]:
    first, *middle, last = footfalls
    bounds_s = np.array([first.contact_s, *(step.at(MID_STANCE) for step in middle), last.off_s])
    ankle_n = motion.position(bounds_s)
    lengths_m = np.hypot(*np.diff(ankle_n[:, :2], axis=0).T)
    for start_s, end_s, length_m in zip(bounds_s, bounds_s[1:], lengths_m, strict=False):
        yield TrueStride(float(start_s), float(end_s), float(length_m))


def _footfalls(
    plan: WalkPlan, person: Person, pace: Pace, rng: np.random.Generator
) -> list[Footfall]:
    """Return standing, the steps of one foot, and standing again."""
    footfalls = []
    contact_s, off_s = plan.rest_s, plan.rest_s + RISE_S
    x_m = y_m = z_m = heading_rad = reach = 0.0
    for share, turn_rad in _course(plan, person, pace, rng):
        push = share * pace.range_of_usual
        footfalls.append(Footfall(contact_s, off_s, x_m, y_m, heading_rad, reach, push, z_m))
        cycle_s = pace.cycle_s * float(rng.normal(1.0, person.time_variation))
        contact_s = off_s + cycle_s * (1.0 - pace.stance_share)
        off_s = contact_s + cycle_s * pace.stance_share
        course_rad = heading_rad + 0.5 * turn_rad + float(rng.normal(0.0, 0.01))
        x_m += share * pace.length_m * cos(course_rad)
        y_m += share * pace.length_m * sin(course_rad)
        z_m += (1.0 if share > _MORE_THAN_HALF else 0.5) * pace.climb_m
        heading_rad += turn_rad
        reach = push
    end_s = contact_s + SETTLE_S
    footfalls.append(Footfall(contact_s, end_s, x_m, y_m, heading_rad, reach, 0.0, z_m))
    return footfalls


def _course(
    plan: WalkPlan, person: Person, pace: Pace, rng: np.random.Generator
) -> Iterator[tuple[float, float]]:
    """Yield length, relative to the usual, and turn of each stride, half ones at both ends."""
    if pace.climb_m or plan.turn_back:
        yield from _open_course(plan, person, pace, rng)
        return
    whole = max(1, round(plan.distance_m / pace.length_m - 1.0))
    shares = np.array([0.5, *rng.normal(1.0, person.length_variation, whole), 0.5])
    shares *= plan.distance_m / (pace.length_m * shares.sum())
    yield from ((float(share), 0.0) for share in shares)


def _open_course(
    plan: WalkPlan, person: Person, pace: Pace, rng: np.random.Generator
) -> Iterator[tuple[float, float]]:
    """Yield the same where turns or treads say how long the last stride is."""
    turns = _turn(rng) if plan.turn_back else []
    whole_m, walked_m = pace.length_m, 0.5 * pace.length_m
    # A tread is as long as it is built.
    variation = 0.01 if pace.climb_m else person.length_variation
    yield 0.5, 0.0
    while turns or walked_m < plan.distance_m - whole_m:
        if turns and walked_m >= 0.5 * (plan.distance_m - whole_m):
            share, turn_rad = turns.pop()
        else:
            share, turn_rad = float(rng.normal(1.0, variation)), 0.0
        walked_m += share * whole_m
        yield share, turn_rad
    yield 0.5, 0.0


def _turn(rng: np.random.Generator) -> list[tuple[float, float]]:
    """Return relative length and turn of the short strides that turn a person half round."""
    count = int(rng.integers(3, 6))
    turns_rad = pi * rng.dirichlet(np.full(count, 20.0)) * rng.choice([-1.0, 1.0])
    return [(float(rng.uniform(0.35, 0.6)), float(turn)) for turn in turns_rad]
