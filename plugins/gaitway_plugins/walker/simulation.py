"""A person with a front-wheeled walker on level ground, in the paper's four styles."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi, radians
from typing import Final

import numpy as np

from gaitway.api import LEFT_TICKS, RIGHT_TICKS, SimulatedWalk, WalkPlan, frozen_rows
from gaitway.simulation import (
    ImuModel,
    Knot,
    Person,
    RigidMotion,
    Shocks,
    Spline,
    Sum,
    Triad,
    TrueStride,
    mounted,
    record,
    rest,
    stream,
    via,
)
from gaitway_plugins.walker.driving import Driven, Gate, Wheels
from gaitway_plugins.walker.tracing import STYLES

MOUNTING: Final = {"x": "forward", "y": "left", "z": "up"}
IMU_D: Final = (0.0, 0.0, 0.7)
TRACK_M: Final = 0.61
RADIUS_M: Final = 0.0635
PULSES: Final = 1024
SETTLE_S: Final = 0.3
_ON_FLOOR: Final = 0.15
"""Share of a hand's tremor that a walker on four legs takes on."""
_CHEAP: Final = {"noise": 2.5, "gyro_bias": 4.0, "accel_bias": 2.0, "scale": 3.0}
DEFAULTS: Final[Mapping[str, str | float]] = {
    "style": "continuous",
    "turns": 0.0,
    "wheel_slip": 0.02,
    "wheel_radius": 0.0035,
    "modulation": 0.0,
    "step_m": 0.0,
    "shock": 1.0,
    "sensor": "mti",
    "tilt_deg": 0.0,
    "encoders": "good",
    "counter_bits": 0.0,
    "does": "walk",
}
"""Conditions: ``style`` (one of the four, or ``mixed``), ``turns`` (of 90 degrees), ``wheel_slip``
(relative, a tenth of a second), ``wheel_radius`` (relative standard deviation), ``modulation`` (of
speed within a continuous step; drawn where 0), ``step_m`` (drawn where 0), ``shock`` (of setting
down), ``sensor`` (``mti`` or ``cheap``), ``tilt_deg`` (how far the IMU is fixed awry), ``encoders``
(``good``, ``left-stuck``, ``left-reversed``, ``both-reversed``), ``counter_bits`` (where counters
wrap; never where 0), ``does`` (``walk``, or instead: ``stand``, ``lean``, ``turn-on-the-spot``,
``carry``, ``rock``, ``drag``)."""
NOT_WALKING: Final = ("stand", "lean", "turn-on-the-spot", "carry", "rock", "drag")
_SCALES: Final = {
    "good": (1.0, 1.0), "left-stuck": (0.0, 1.0),
    "left-reversed": (-1.0, 1.0), "both-reversed": (-1.0, -1.0),
}  # fmt: skip


@dataclass(slots=True)
class Course:
    """Knots of everything that moves, written step by step.

    Attributes:
        t_s: Where it has got to.
        roll: Way rolled.
        lift: Way lifted.
        height: Above the floor.
        angles: Yaw, pitch and roll.
        strides: True ones.
        styles: Of each.
        closed_s: When the wheels are off the floor.
        downs_s: When it is set down.
    """

    t_s: float
    roll: list[Knot] = field(default_factory=list)
    lift: list[Knot] = field(default_factory=list)
    height: list[Knot] = field(default_factory=list)
    angles: list[Knot] = field(default_factory=list)
    strides: list[TrueStride] = field(default_factory=list)
    styles: list[str] = field(default_factory=list)
    closed_s: list[tuple[float, float]] = field(default_factory=list)
    downs_s: list[float] = field(default_factory=list)

    def stop(self) -> None:
        """Let everything be at rest now."""
        for knots, size in ((self.roll, 1), (self.lift, 1), (self.height, 1), (self.angles, 3)):
            values = knots[-1].values if knots else (0.0,) * size
            if not knots or self.t_s > knots[-1].t_s:
                knots.append(rest(self.t_s, *values))

    def move(self, knots: list[Knot], by: float, duration_s: float, turn_rad: float) -> None:
        """Go on by a length from rest to rest, turning meanwhile."""
        self.stop()
        yaw_rad, *tilt = self.angles[-1].values
        end_s = self.t_s + duration_s
        knots.append(rest(end_s, knots[-1].values[0] + by))
        if self.angles[-1].t_s < end_s:
            self.angles.append(rest(end_s, yaw_rad + turn_rad, *tilt))
        self.t_s = end_s

    def step(self, start_s: float, length_m: float, style: str) -> None:
        """Write down a true step that ends now."""
        since_s = self.strides[-1].end_s if self.strides else start_s
        self.strides.append(TrueStride(since_s, self.t_s, length_m))
        self.styles.append(style)


def simulate(plan: WalkPlan) -> SimulatedWalk:
    """Return a walk with the walker; ``plan.conditions`` are those of ``DEFAULTS``.

    A step runs from the end of the one before, standing included, to its own end; its length is
    the way of the floor point between the wheels.

    Raises:
        ValueError: An unknown condition, or a value it can't have.
    """
    conditions = _conditions(plan)
    person = Person.draw(plan.seed)
    rng = stream(plan.seed, "walker", plan.repetition)
    course = Course(plan.rest_s)
    course.stop()
    if conditions["does"] == "walk":
        _walk(course, plan, person, conditions, rng)
    else:
        _idle(course, str(conditions["does"]), rng)
    course.stop()
    return _recorded(course, plan, person, conditions, rng)


def _conditions(plan: WalkPlan) -> dict[str, str | float]:
    unknown = set(plan.conditions) - set(DEFAULTS)
    if unknown:
        raise ValueError(f"conditions {sorted(unknown)}: known are {', '.join(DEFAULTS)}")
    found = dict(DEFAULTS) | dict(plan.conditions)
    choices = {
        "style": (*STYLES, "mixed"), "sensor": ("mti", "cheap"),
        "encoders": tuple(_SCALES), "does": ("walk", *NOT_WALKING),
    }  # fmt: skip
    for name, allowed in choices.items():
        if found[name] not in allowed:
            raise ValueError(f"{name} {found[name]!r}: one of {', '.join(allowed)}")
    for name in set(DEFAULTS) - set(choices):
        found[name] = float(found[name])
    return found


def _walk(
    course: Course, plan: WalkPlan, person: Person, conditions: dict[str, str | float],
    rng: np.random.Generator,
) -> None:  # fmt: skip
    corners = int(float(conditions["turns"])) + 2 * plan.turn_back
    legs = corners // (2 if plan.turn_back else 1) + 1
    usual_m = float(conditions["step_m"]) or float(rng.uniform(0.35, 0.5))
    for leg in range(legs):
        walked_m = 0.0
        style = str(conditions["style"])
        while walked_m < plan.distance_m / legs - 0.5 * usual_m:
            now = STYLES[int(rng.integers(4))] if style == "mixed" else style
            if now == "continuous":
                left_m = plan.distance_m / legs - walked_m
                most = 8 if style == "mixed" else 10**6
                count = int(np.clip(round(left_m / usual_m), 2, most))
                walked_m += _continuous(course, plan, person, conditions, count, usual_m, rng)
            else:
                length_m = usual_m * float(rng.normal(1.0, person.length_variation))
                speed_mps = plan.speed_mps or 0.45 * person.pace
                _single(course, now, length_m, length_m / speed_mps, rng)
                walked_m += length_m
        if leg + 1 < legs:
            _corner(course, style, pi if plan.turn_back else 0.5 * pi, rng)


def _wander(rng: np.random.Generator) -> float:
    return float(rng.normal(0.0, radians(1.0)))


def _single(
    course: Course, style: str, length_m: float, duration_s: float, rng: np.random.Generator,
    turn_rad: float = 0.0,
) -> None:  # fmt: skip
    start_s = course.t_s
    turn_rad += _wander(rng)
    if style == "full-lift":
        height_m = float(rng.uniform(0.05, 0.10))
        course.stop()
        course.height.append(via(start_s + float(rng.uniform(0.3, 0.5)) * duration_s, height_m))
        course.move(course.lift, length_m, duration_s, turn_rad)
        course.height.append(rest(course.t_s, 0.0))
        course.closed_s.append((start_s, course.t_s))
        course.downs_s.append(course.t_s)
    elif style == "back-tips":
        pitch_rad = radians(float(rng.uniform(2.5, 6.0)))
        _pitch(course, pitch_rad, float(rng.uniform(0.3, 0.5)))
        course.move(course.roll, length_m, duration_s, turn_rad)
        _pitch(course, -pitch_rad, float(rng.uniform(0.25, 0.4)))
        course.downs_s.append(course.t_s)
    else:
        course.move(course.roll, length_m, duration_s, turn_rad)
    course.step(start_s, length_m, style)
    course.t_s += float(rng.uniform(0.6, 1.4))
    course.stop()


def _pitch(course: Course, by_rad: float, duration_s: float) -> None:
    course.stop()
    yaw_rad, pitch_rad, roll_rad = course.angles[-1].values
    course.t_s += duration_s
    course.angles.append(rest(course.t_s, yaw_rad, pitch_rad + by_rad, roll_rad))


def _continuous(
    course: Course, plan: WalkPlan, person: Person, conditions: dict[str, str | float],
    count: int, usual_m: float, rng: np.random.Generator,
) -> float:  # fmt: skip
    """Roll on over several steps, slower between them than within; return how far."""
    speed_mps = plan.speed_mps or 0.6 * person.pace
    depth = float(conditions["modulation"]) or float(rng.uniform(0.15, 0.4))
    course.stop()
    total_m = 0.0
    for number in range(count):
        start_s = course.t_s
        length_m = usual_m * float(rng.normal(1.0, person.length_variation))
        total_m += length_m
        ends = (number == 0) + (number == count - 1)
        course.t_s += length_m / speed_mps * float(rng.normal(1.0, 0.03)) * (1.0 + 0.3 * ends)
        way_m = course.roll[-1].values[0] + length_m
        if number < count - 1:
            course.roll.append(Knot(course.t_s, (way_m,), (speed_mps * (1.0 - depth),), None))
        else:
            course.roll.append(rest(course.t_s, way_m))
        yaw_rad, *tilt = course.angles[-1].values
        course.angles.append(via(course.t_s, yaw_rad + 0.3 * _wander(rng), *tilt))
        course.step(start_s, length_m, "continuous")
    course.angles[-1] = rest(course.t_s, *course.angles[-1].values)
    course.t_s += float(rng.uniform(0.6, 1.4))
    course.stop()
    return total_m


def _corner(course: Course, style: str, turn_rad: float, rng: np.random.Generator) -> None:
    """Turn in three or four short steps with full stops."""
    count = int(rng.integers(3, 5)) * (2 if turn_rad > 2.0 else 1)
    sense = float(rng.choice([-1.0, 1.0]))
    single = "step-by-step" if style in ("continuous", "mixed") else style
    for _ in range(count):
        length_m = float(rng.uniform(0.2, 0.3))
        _single(course, single, length_m, length_m / 0.3, rng, sense * turn_rad / count)


def _idle(course: Course, does: str, rng: np.random.Generator) -> None:
    """Do something else than walking, half a dozen times."""
    for _ in range(6):
        course.t_s += float(rng.uniform(0.5, 2.0))
        course.stop()
        start_s = course.t_s
        if does == "rock":
            by_m, duration_s = float(rng.uniform(0.04, 0.12)), float(rng.uniform(0.4, 0.9))
            course.move(course.roll, by_m, duration_s, 0.0)
            course.t_s += float(rng.choice([0.01, 0.6]))
            course.move(course.roll, -by_m, duration_s, 0.0)
        elif does == "turn-on-the-spot":
            course.move(course.roll, 0.0, 2.0, float(rng.uniform(-1.5, 1.5)))
        elif does == "lean":
            _pitch(course, lean := radians(float(rng.normal(0.0, 0.4))), 0.5)
            _pitch(course, -lean, 0.5)
        elif does == "drag":
            course.move(course.lift, float(rng.uniform(0.2, 0.4)), 1.0, 0.0)
            course.closed_s.append((start_s, course.t_s))
        elif does == "carry":
            course.height.append(via(start_s + 3.0, 0.3))
            course.move(course.lift, float(rng.uniform(2.0, 5.0)), 6.0, _wander(rng))
            course.height.append(rest(course.t_s, 0.0))
            course.closed_s.append((start_s, course.t_s))
            course.t_s += 3.0


def _recorded(
    course: Course, plan: WalkPlan, person: Person, conditions: dict[str, str | float],
    rng: np.random.Generator,
) -> SimulatedWalk:  # fmt: skip
    end_s = course.t_s + SETTLE_S
    roll = Spline(course.roll)
    upright = radians(1.0) * person.posture_pitch_rad / 0.02
    lean = Spline([rest(0.0, 0.0, 0.3 * upright, person.posture_roll_rad)])
    angles = Sum(Spline(course.angles), lean, person.tremor(_grip(course, end_s), rng))
    way, height = Sum(roll, Spline(course.lift)), Spline(course.height)
    position = Driven(way, angles, height, end_s + plan.rest_s)
    motion = RigidMotion(_shaken(course, position, float(conditions["shock"]), rng), angles)
    tilt_rad = np.radians(float(conditions["tilt_deg"])) * rng.standard_normal(3)
    place = mounted(MOUNTING, IMU_D, tilt_rad.tolist())
    walk = record(
        plan, motion, place, end_s + plan.rest_s, course.strides, model=_model(conditions)
    )
    t_s = np.arange(len(walk.pos_n)) / plan.rate_hz
    wheels = _wheels(plan, conditions)
    slip = stream(plan.seed, "slip", plan.repetition)
    left, right = wheels.counts(roll, angles, Gate(course.closed_s), t_s, slip)
    channels = dict(walk.channels)
    channels[LEFT_TICKS.name], channels[RIGHT_TICKS.name] = (
        frozen_rows(left, 1), frozen_rows(right, 1),
    )  # fmt: skip
    return replace(walk, channels=channels, truth={"style": tuple(course.styles)})


def _grip(course: Course, end_s: float) -> Spline:
    """Return how far the hands shake the walker: fully in the air, a little while it stands."""
    knots = [rest(0.2, 0.0), rest(0.7, _ON_FLOOR)]
    for start_s, stop_s in course.closed_s:
        middle_s = 0.5 * (start_s + stop_s)
        ends = (rest(start_s, _ON_FLOOR), rest(middle_s, 1.0), rest(stop_s, _ON_FLOOR))
        knots += [knot for knot in ends if knot.t_s > knots[-1].t_s]
    return Spline([*knots, rest(end_s - 0.1, _ON_FLOOR), rest(end_s, 0.0)])


def _shaken(
    course: Course, position: Driven, shock: float, rng: np.random.Generator
) -> "Driven | Sum":
    if not course.downs_s or not shock:
        return position
    peaks = shock * rng.normal(0.0, 1.0, (len(course.downs_s), 3)) * np.array([2e-4, 1e-4, 5e-4])
    return Sum(position, Shocks(np.array(course.downs_s), peaks, 18.0, 0.015))


def _wheels(plan: WalkPlan, conditions: dict[str, str | float]) -> Wheels:
    rng = stream(plan.seed, "wheels")
    sides = _SCALES[str(conditions["encoders"])]
    both = float(conditions["wheel_radius"]) * rng.standard_normal()
    each = 0.3 * float(conditions["wheel_radius"]) * rng.standard_normal(2)
    ideal = plan.ideal_sensor
    bits = int(float(conditions["counter_bits"]))
    scale = [
        side * (1.0 if ideal else 1.0 + both + one) for side, one in zip(sides, each, strict=True)
    ]
    first = rng.integers(0, 2**bits if bits else 5000, 2)
    return Wheels(
        TRACK_M, RADIUS_M, PULSES, (scale[0], scale[1]),
        0.0 if ideal else float(conditions["wheel_slip"]),
        (float(first[0]), float(first[1])), float(2**bits) if bits else 0.0,
    )  # fmt: skip


def _model(conditions: dict[str, str | float]) -> ImuModel:
    model = ImuModel()
    if conditions["sensor"] == "mti":
        return model

    def worse(kind: Triad, bias: float) -> Triad:
        return replace(
            kind,
            noise_rthz=_CHEAP["noise"] * kind.noise_rthz,
            bias=bias * kind.bias,
            scale=_CHEAP["scale"] * kind.scale,
        )

    return replace(
        model,
        gyro=worse(model.gyro, _CHEAP["gyro_bias"]),
        accel=worse(model.accel, _CHEAP["accel_bias"]),
    )
