"""A person walking with a crutch that has sensors in its tip, with exact truth.

The tip stands still while it is loaded and the crutch turns forward over it; in the air it is
swung back. The path that is told is that of the tip.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import pi, radians
from typing import Final

import numpy as np

from gaitway.api import (
    ACCEL,
    FORCE,
    FORCE_VOLT,
    INCLINATION,
    INCLINATION_ROLL,
    Floats,
    SimulatedWalk,
    WalkPlan,
    frozen_rows,
)
from gaitway.simulation import (
    GRAVITY_MPS2,
    ImuModel,
    RigidMotion,
    Triad,
    TrueStride,
    ideal_imu,
    mounted,
    record,
    stream,
)
from gaitway_plugins.crutch_tip.course import Planted, crutch_motion, plan_stances
from gaitway_plugins.crutch_tip.params import PAPER_KNOTS_NEWTON, PAPER_KNOTS_VOLT

MOUNTING: Final = {"x": "up", "y": "right", "z": "forward"}
TIP_TO_IMU_D: Final = (0.02, 0.0, 0.12)
CONDITIONS: Final = {
    "sensor": ("mti", "cheap"),
    "force": ("newton", "volt"),
    "seen": ("all", "no-roll", "no-accel", "neither", "accel-only"),
    "load": ("usual", "dragged"),
}
"""Names and values of ``WalkPlan.conditions``; the first value is the default."""
_HIDDEN: Final = {
    "all": set[str](),
    "no-roll": {INCLINATION_ROLL.name},
    "no-accel": {ACCEL.name},
    "neither": {INCLINATION_ROLL.name, ACCEL.name},
    "accel-only": {INCLINATION.name, INCLINATION_ROLL.name},
}
_LAG_S: Final = 1.0 / (2.0 * pi * 18.0)
"""Of the inclinometer: 18 Hz of bandwidth (SCA100T data sheet)."""
_DEAD_VOLT: Final = 0.04
_CHEAP: Final = ImuModel(
    gyro=replace(ImuModel().gyro, noise_rthz=radians(0.03), bias=radians(0.6), scale=4e-3),
    accel=Triad(300e-6 * GRAVITY_MPS2, 0.06, 1e-4, 5e-3, 2e-3, 16.0 * GRAVITY_MPS2, 0.005),
)


def simulate(plan: WalkPlan) -> SimulatedWalk:
    """Return a walk with a crutch.

    A stride is a cycle of the paper, from one lift to the next. Truth: ``pitch_rad``, ``roll_rad``
    and ``force_newton``, one value a sample; ``contact_s``, ``lift_s`` and ``peak_newton`` of the
    stance that ends a stride, and ``turning``, 1 where its cycle turns the person, else 0.

    Args:
        plan: What to walk. Conditions: ``sensor`` ``mti`` or ``cheap``; ``force`` ``newton`` or
            ``volt``; ``seen`` ``all``, ``no-roll``, ``no-accel``, ``neither`` or ``accel-only``;
            ``load`` ``usual`` or ``dragged`` (10 to 24 N stay on the tip in the swing).

    Raises:
        ValueError: A condition is unknown.
    """
    conditions = _checked(plan.conditions)
    rng = stream(plan.seed, "crutch-tip")
    planted = plan_stances(plan, rng)
    motion = crutch_motion(planted, stream(plan.seed, "crutch-tip-swings", plan.repetition))
    strides = [
        TrueStride(a.lift_s, b.lift_s, float(np.hypot(b.x_m - a.x_m, b.y_m - a.y_m)))
        for a, b in pairwise(planted)
    ]
    place = mounted(MOUNTING, TIP_TO_IMU_D, rng.normal(0.0, radians(0.3), 3).tolist())
    model = _CHEAP if conditions["sensor"] == "cheap" else None
    end_s = planted[-1].lift_s + max(plan.rest_s, 0.5)
    walk = record(plan, motion, place, end_s, strides, model=model)
    return _with_tip(walk, plan, motion, planted, conditions)


def true_force(planted: Sequence[Planted], t_s: Floats, rng: np.random.Generator) -> Floats:
    """Return the axial force, newtons, shape (n,): one or two humps a stance."""
    force = np.zeros(len(t_s))
    for stance in planted[1:]:
        share = (t_s - stance.contact_s) / (stance.lift_s - stance.contact_s)
        inside = (share > 0.0) & (share < 1.0)
        hump = np.sin(pi * share[inside]) ** 0.7
        hump *= 1.0 + rng.uniform(-0.25, 0.25) * np.cos(2.0 * pi * share[inside])
        force[inside] = stance.peak_newton * hump / hump.max()
    return force


def _checked(given: Mapping[str, str | float]) -> dict[str, str]:
    for name, value in given.items():
        if value not in CONDITIONS.get(name, ()):
            raise ValueError(f"conditions: {name} = {value!r}: known are {CONDITIONS}")
    known = {name: values[0] for name, values in CONDITIONS.items()}
    return known | {name: str(value) for name, value in given.items()}


def _with_tip(
    walk: SimulatedWalk,
    plan: WalkPlan,
    motion: RigidMotion,
    planted: Sequence[Planted],
    conditions: Mapping[str, str],
) -> SimulatedWalk:
    rng = stream(plan.seed, "crutch-tip-sensors", plan.repetition)
    t_s = np.arange(len(walk.pos_n)) / plan.rate_hz
    force = true_force(planted, t_s, rng)
    if conditions["load"] == "dragged":
        rubbing = np.convolve(rng.standard_normal(len(t_s)), np.ones(20) / 20**0.5, mode="same")
        force = np.maximum(force, np.clip(17.0 + 3.0 * rubbing, 10.0, 24.0))
    channels = dict(walk.channels)
    channels |= _inclinations(plan, motion, len(t_s), rng)
    channels |= _force_channel(plan, force, conditions["force"], rng)
    hidden = _HIDDEN[conditions["seen"]]
    angles = motion.angles(t_s)
    return replace(
        walk,
        channels={name: values for name, values in channels.items() if name not in hidden},
        truth={
            "pitch_rad": angles[:, 1],
            "roll_rad": angles[:, 2],
            "force_newton": force,
            "contact_s": np.array([stance.contact_s for stance in planted[1:]]),
            "lift_s": np.array([stance.lift_s for stance in planted[1:]]),
            "peak_newton": np.array([stance.peak_newton for stance in planted[1:]]),
            "turning": np.array([float(stance.turning) for stance in planted[1:]]),
        },
    )


def _inclinations(
    plan: WalkPlan, motion: RigidMotion, n: int, rng: np.random.Generator
) -> dict[str, Floats]:
    """Return what an inclinometer of two axes reads: gravity and acceleration, 9 ms late."""
    place = mounted({"x": "forward", "y": "left", "z": "up"}, TIP_TO_IMU_D)
    felt = ideal_imu(motion, place, np.arange(-1, n) / plan.rate_hz).accel_b / GRAVITY_MPS2
    share = 1.0 - np.exp(-1.0 / (plan.rate_hz * _LAG_S))
    late = felt[:, :2].copy()
    for row in range(1, n):
        late[row] = late[row - 1] + share * (felt[row, :2] - late[row - 1])
    reading = np.arcsin(np.clip(late * [-1.0, 1.0], -1.0, 1.0))
    if not plan.ideal_sensor:
        reading += np.radians(rng.normal(0.0, 0.4, 2))
        reading += np.radians(0.3) * rng.standard_normal((n, 2))
    return {
        INCLINATION.name: frozen_rows(reading[:, 0], 1),
        INCLINATION_ROLL.name: frozen_rows(reading[:, 1], 1),
    }


def _force_channel(
    plan: WalkPlan, force: Floats, unit: str, rng: np.random.Generator
) -> dict[str, Floats]:
    """Return the force as read: gain, offset, friction of the sliding part, noise."""
    read = force
    if not plan.ideal_sensor:
        gain, offset = float(rng.normal(1.0, 0.025)), float(rng.normal(0.0, 4.0))
        friction = float(rng.normal(0.0, 3.0)) * np.sign(np.gradient(force))
        read = np.where(force > 0.0, gain * force + friction, 0.0) + offset
        read = read + 2.0 * rng.standard_normal(len(force))
    if unit == "newton":
        return {FORCE.name: frozen_rows(read, 1)}
    volts = np.interp(read, PAPER_KNOTS_NEWTON, PAPER_KNOTS_VOLT)
    return {FORCE_VOLT.name: frozen_rows(np.where(volts < _DEAD_VOLT, 0.0, volts), 1)}
