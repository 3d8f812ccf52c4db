"""A person walking with a crutch, with exact truth.

The planted crutch turns about its rubber tip while the person walks past; relieved, the tip is
swung forward over the floor (Sesar et al. 2019, Figures 7 and 10). The point whose path is measured
is the tip, origin of frame d. Where the person turns round, the crutch leans sideways meanwhile,
so that the turn shows on its y axis: what the paper's turning cycles suffer from.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import radians
from typing import Final

import numpy as np

from gaitway.api import GYRO, Floats, SimulatedWalk, WalkPlan, frozen_rows
from gaitway.simulation import (
    Curve,
    ImuModel,
    Person,
    RigidMotion,
    TrueStride,
    imu_attitude,
    mounted,
    record,
    stream,
)
from gaitway_plugins.crutch_tip.simulated_force import Loading, force_at, loads_of, passing_times_s
from gaitway_plugins.crutch_tip.simulated_gait import (
    GRASP_S,
    Habit,
    Stance,
    motion_of,
    stances_of,
)
from gaitway_plugins.crutch_tip.simulated_sensors import Readings

MOUNTING: Final = {"x": "up", "y": "right", "z": "forward"}
AWRY_SIGMA_RAD: Final = radians(0.3)
"""Standard deviation of each angle by which the IMU is fixed awry in the tip."""
DEFAULTS: Final[dict[str, str | float]] = {
    "channels": "all",
    "samples": "instant",
    "sensor": "mti",
    "peak_force_newton": 0.0,
    "turn_cycles": 0.0,
    "imu_height_m": 0.1,
    "gyro_bias_dps": 0.0,
    "shock": 1.0,
}
WORDS: Final = {
    "channels": ("all", "no-roll", "no-accel", "accel", "volt"),
    "samples": ("instant", "interval"),
    "sensor": ("mti", "mems"),
}
MEMS: Final = ImuModel(
    gyro=replace(
        ImuModel().gyro, noise_rthz=radians(0.02), bias=radians(0.7), scale=3e-3,
        misalignment_rad=radians(0.3),
    ),
    accel=replace(ImuModel().accel, noise_rthz=300e-6 * 9.80665, bias=0.05, scale=3e-3),
)  # fmt: skip
"""A cheap chip."""


def simulate(plan: WalkPlan) -> SimulatedWalk:
    """Return a walk with a crutch.

    A stride is one step of the crutch: from the contact before (for the first: from lifting it) to
    its contact, its length the horizontal distance between the two places of the tip.

    Conditions:
        channels: ``all``: force in newtons, accelerometer, inclinometer of two axes; ``no-roll``:
            one axis; ``no-accel``; ``accel``: no inclinometer; ``volt``: all, force in volts.
        samples: ``instant`` or ``interval``, as the parameter ``imu_sample``.
        sensor: ``mti``, or ``mems``: a cheap chip.
        peak_force_newton: Usual greatest force; drawn where 0.
        turn_cycles: In how many cycles (1 to 3) a person who walks back turns; drawn where 0.
        imu_height_m: Of the sensors above the sole.
        gyro_bias_dps: Added to the gyroscope's three axes.
        shock: How hard the tip is put down, 0 not at all.

    Truth, one value a sample: ``pitch_rad``, ``roll_rad``, ``force_newton``, ``stance`` and
    ``turning`` (0 or 1). Of the stance that ends each stride: ``contact_s`` and ``lift_s``, where
    the force passes 25.2 N (the paper's F_min), ``contact_pitch_rad`` and ``lift_pitch_rad`` there,
    and ``peak_force_newton``.

    Args:
        plan: What to walk; ``distance_m`` is reached to within half a stride.

    Raises:
        ValueError: The plan's speed is out of reach, or a condition unknown.
    """
    conditions = _conditions(plan)
    person = Person.draw(plan.seed)
    rng = stream(plan.seed, "crutch-tip")
    habit = Habit.draw(person, plan, rng)
    if conditions["peak_force_newton"]:
        habit = replace(habit, peak_newton=float(conditions["peak_force_newton"]))
    if plan.repetition:
        rng = stream(plan.seed, "crutch-tip", plan.repetition)
    stances = stances_of(plan, habit, person, int(float(conditions["turn_cycles"])), rng)
    motion = motion_of(stances, person, habit, float(conditions["shock"]), rng)
    duration_s = stances[-1].contact_s + GRASP_S + plan.rest_s
    return _recorded(plan, conditions, stances, motion, duration_s)


def _conditions(plan: WalkPlan) -> dict[str, str | float]:
    unknown = set(plan.conditions) - set(DEFAULTS)
    if unknown:
        raise ValueError(f"conditions {sorted(unknown)}: known are {', '.join(DEFAULTS)}")
    found = DEFAULTS | dict(plan.conditions)
    for name, words in WORDS.items():
        if found[name] not in words:
            raise ValueError(f"condition {name} {found[name]!r}: one of {', '.join(words)}")
    return found


@dataclass(frozen=True, slots=True)
class _Later:
    """A curve that is ahead by some time."""

    curve: Curve
    ahead_s: float

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        return self.curve(t_s + self.ahead_s, order)


def _recorded(
    plan: WalkPlan,
    conditions: dict[str, str | float],
    stances: Sequence[Stance],
    motion: RigidMotion,
    duration_s: float,
) -> SimulatedWalk:
    tilt_rad = stream(plan.seed, "crutch-tip awry").normal(0.0, AWRY_SIGMA_RAD, 3).tolist()
    place = mounted(MOUNTING, (0.0, 0.0, float(conditions["imu_height_m"])), tilt_rad)
    # ``record`` gives means over the interval before; of the moment means over half of it after.
    ahead_s = 0.5 / plan.rate_hz if conditions["samples"] == "instant" else 0.0
    sensed = RigidMotion(_Later(motion.position, ahead_s), _Later(motion.angles, ahead_s))
    model = MEMS if conditions["sensor"] == "mems" else ImuModel()
    strides = [
        TrueStride(
            before.contact_s if number else before.lift_s,
            after.contact_s,
            float(np.hypot(after.x_m - before.x_m, after.y_m - before.y_m)),
        )
        for number, (before, after) in enumerate(pairwise(stances))
    ]
    walk = record(plan, sensed, place, duration_s, strides, model=model)
    t_s = np.arange(len(walk.pos_n)) / plan.rate_hz
    readings = Readings(plan, str(conditions["channels"]), motion, place.device_to_imu_d)
    bias_radps = radians(float(conditions["gyro_bias_dps"]))
    gyro = frozen_rows(walk.channels[GYRO.name] + bias_radps, 3)
    imu = {**walk.channels, GYRO.name: gyro}
    loads = loads_of(stances, duration_s)
    force = force_at(loads, t_s)
    return replace(
        walk,
        channels=readings.channels(imu, t_s, force),
        pos_n=motion.position(t_s),
        q_nb=imu_attitude(motion, place, t_s),
        truth=_truth(stances, loads, motion, t_s),
    )


def _truth(
    stances: Sequence[Stance], loads: Sequence[Loading], motion: RigidMotion, t_s: Floats
) -> dict[str, Floats]:
    passing_s = np.array([passing_times_s(load) for load in loads[1:]]).reshape(-1, 2)
    contact_s, lift_s = passing_s.T
    _, pitch, roll = motion.angles(t_s).T
    on_floor = [(stance.contact_s <= t_s) & (t_s < stance.lift_s) for stance in stances]
    turned = [
        (before.lift_s <= t_s) & (t_s < after.lift_s)
        for before, after in pairwise(stances)
        if after.turning
    ]
    return {
        "pitch_rad": pitch,
        "roll_rad": roll,
        "force_newton": force_at(loads, t_s),
        "stance": np.any(on_floor, axis=0).astype(np.float64),
        "turning": np.any([*turned, np.zeros(len(t_s), bool)], axis=0).astype(np.float64),
        "contact_s": contact_s,
        "lift_s": lift_s,
        "contact_pitch_rad": motion.angles(contact_s)[:, 1],
        "lift_pitch_rad": motion.angles(lift_s)[:, 1],
        "peak_force_newton": np.array([load.peak_newton for load in loads[1:]]),
    }
