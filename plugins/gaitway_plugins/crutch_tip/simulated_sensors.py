"""What a simulated crutch tip measures besides its IMU: force and inclination."""

from collections.abc import Mapping
from math import ceil, pi, radians
from typing import Final

import numpy as np

from gaitway.api import (
    ACCEL,
    FORCE,
    FORCE_VOLT,
    INCLINATION,
    INCLINATION_ROLL,
    Floats,
    WalkPlan,
    frozen_rows,
)
from gaitway.simulation import GRAVITY_MPS2, ImuPlace, RigidMotion, ideal_imu, stream
from gaitway_plugins.crutch_tip.force import piecewise_line
from gaitway_plugins.crutch_tip.params import PAPER_KNOTS_NEWTON, PAPER_KNOTS_VOLT

FRICTION_NEWTON: Final = (8.0, 3.0)
"""Mean and standard deviation of what the sliding part of the tip keeps back of a rising force
and adds to a falling one: with it the force is off by 8.8 N RMS, as the paper's is."""
FULL_FRICTION_NEWTON: Final = 60.0
"""From this force on; below it the sliding part hardly presses on its rails."""
FORCE_SCALE: Final = 0.015
FORCE_NOISE_NEWTON: Final = 2.0
PASSES_HZ: Final = (14.0, 24.0)
"""Low-pass of the inclinometer: SCA100T data sheet, 8 to 28 Hz."""
LEVEL_SIGMA_RAD: Final = radians(0.3)
INCLINATION_SCALE: Final = 0.003
INCLINATION_NOISE_RAD: Final = radians(0.03)
FINE_HZ: Final = 1000.0


class Readings:
    """Force sensor and inclinometer of one crutch.

    Args:
        plan: Sample rate, seed, and whether the sensors are ideal.
        channels: Which there are, a condition of ``simulate``.
        motion: Of the crutch.
        place_d: Of the inclinometer, from the tip, metres.
    """

    def __init__(self, plan: WalkPlan, channels: str, motion: RigidMotion, place_d: Floats) -> None:
        self._plan = plan
        self._which = channels
        self._motion = motion
        self._place = ImuPlace(place_d, np.eye(3))
        self._sensor = stream(plan.seed, "crutch-tip sensors")
        self._noise = stream(plan.seed, "crutch-tip noise", plan.repetition)

    def channels(self, imu: Mapping[str, Floats], t_s: Floats, force: Floats) -> dict[str, Floats]:
        """Return what is measured at some times, of the IMU and besides it.

        Args:
            imu: What the IMU reports.
            t_s: Evenly spaced, shape (n,).
            force: True axial force, newtons, shape (n,).
        """
        newton = self._force(force)
        pitch, roll = self._inclinations(t_s)
        found = dict(imu)
        if self._which == "volt":
            found[FORCE_VOLT.name] = frozen_rows(_volt(newton), 1)
        else:
            found[FORCE.name] = frozen_rows(np.maximum(newton, 0.0), 1)
        if self._which != "accel":
            found[INCLINATION.name] = frozen_rows(pitch, 1)
        if self._which not in ("accel", "no-roll"):
            found[INCLINATION_ROLL.name] = frozen_rows(roll, 1)
        if self._which == "no-accel":
            del found[ACCEL.name]
        return found

    def _force(self, force: Floats) -> Floats:
        if self._plan.ideal_sensor:
            return force
        friction = float(np.clip(self._sensor.normal(*FRICTION_NEWTON), 2.0, 18.0))
        scale = 1.0 + FORCE_SCALE * self._sensor.standard_normal()
        noise = FORCE_NOISE_NEWTON * self._noise.standard_normal(len(force))
        return scale * _with_play(force, friction) + noise

    def _inclinations(self, t_s: Floats) -> tuple[Floats, Floats]:
        """Return pitch and roll as told by the specific force through a low-pass."""
        count = ceil(FINE_HZ / self._plan.rate_hz)
        period_s = 1.0 / (self._plan.rate_hz * count)
        fine_s: Floats = period_s * np.arange(-count, (len(t_s) - 1) * count + 2, dtype=np.float64)
        felt = ideal_imu(self._motion, self._place, fine_s).accel_b
        lean = np.arcsin(np.clip(felt[:, :2] / GRAVITY_MPS2, -1.0, 1.0))
        passes_hz = self._sensor.uniform(*PASSES_HZ)
        late = _low_pass(lean, 2.0 * pi * passes_hz * period_s)[count::count][: len(t_s)]
        if not self._plan.ideal_sensor:
            late = late * (1.0 + INCLINATION_SCALE * self._sensor.standard_normal(2))
            late += LEVEL_SIGMA_RAD * self._sensor.standard_normal(2)
            late += INCLINATION_NOISE_RAD * self._noise.standard_normal(late.shape)
        return -late[:, 0], late[:, 1]


def _with_play(force: Floats, friction: float) -> Floats:
    """Return what is left of a force after friction that has to be overcome either way."""
    out = np.empty_like(force)
    state = 0.0
    for number, value in enumerate(force.tolist()):
        play = friction * min(1.0, value / FULL_FRICTION_NEWTON)
        state = min(max(state, value - play), value + play)
        out[number] = state
    return out


def _low_pass(values: Floats, share: float) -> Floats:
    """Return values after a lag of first order, shape (n, k); ``share`` is period over lag."""
    out = np.empty_like(values)
    weight = 1.0 - np.exp(-share)
    state = values[0]
    for number, value in enumerate(values):
        state = state + weight * (value - state)
        out[number] = state
    return out


def _volt(newton: Floats) -> Floats:
    """Return what the paper's amplifier gives for a force; nothing in its dead zone."""
    return np.maximum(
        0.0, piecewise_line(newton, np.array(PAPER_KNOTS_NEWTON), np.array(PAPER_KNOTS_VOLT))
    )
