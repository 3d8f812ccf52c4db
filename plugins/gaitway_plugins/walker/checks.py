"""What makes numbers untrustworthy: wheels that count wrongly, a walker that fell."""

import math
from typing import Final

import numpy as np

from gaitway.api import Anomaly, Event, Floats
from gaitway.estimation import STANDARD_GRAVITY_MPS2
from gaitway_plugins.walker.blocks import Block
from gaitway_plugins.walker.fix import Fix
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.upset import FALL_MPS2, TIPPED

_LOOK_M: Final = 0.6
"""A wheel is judged after each so much of rolling."""
_TILTED: Final = math.cos(math.radians(20.0))
_EVIDENCE: Final = 6.0
"""Sum of squared wheel accelerations, (m/s^2)^2, after which their sense is judged."""


class Checks:
    """Says each trouble once, when it begins.

    Args:
        params: Of the walker.
    """

    def __init__(self, params: WalkerParams) -> None:
        self._params = params
        self._left = self._right = self._left_signed = self._right_signed = self._turned = 0.0
        self._told: set[str] = set()
        self._upright = False
        self._tilted_s = 0.0
        self._speed_mps = 0.0
        self._rest_mps2 = 0.0
        self._rising_mps2 = 0.0
        self._rate_d = np.zeros(3)
        self._pitch_rad = 0.0
        self._both = self._wheels = 0.0

    def push(self, block: Block, fix: Fix, rate_d: Floats) -> list[Event]:
        """Take the next block, its fix and its mean rate without bias. Return what is wrong."""
        found = [*self._posture(block, fix), *self._each_wheel(block, fix, float(rate_d[2]))]
        found += self._both_wheels(block, fix, rate_d)
        return [Anomaly(t_ns=fix.t_ns, anomaly=name, detail=detail) for name, detail in found]

    @property
    def untrusted(self) -> bool:
        """Whether the sense of a wheel is wrong, so that no way comes of its counts."""
        return not self._told.isdisjoint({"one", "both"})

    def _once(self, key: str, anomaly: str, detail: str) -> list[tuple[str, str]]:
        if key in self._told:
            return []
        self._told.add(key)
        return [(anomaly, detail)]

    def _posture(self, block: Block, fix: Fix) -> list[tuple[str, str]]:
        force = block.accel_d.mean(axis=0)
        size = float(np.sqrt(force.dot(force)))
        if size < FALL_MPS2:
            return self._once("fall", "dropped", "it fell freely for a tenth of a second")
        upright = float(force[2]) / size
        self._tilted_s = self._tilted_s + fix.duration_s if upright < _TILTED else 0.0
        if upright >= _TILTED and fix.still:
            self._upright = True
            self._told -= {"tip", "mount", "fall"}
        if self._tilted_s < 1.0:
            return []
        if self._upright and upright < TIPPED:
            return self._once("tip", "tipped-over", "it lies on its side")
        if not self._upright and fix.still:
            detail = "at rest the vertical is not up in the walker's axes: see mounting"
            return self._once("mount", "not-mounted-as-configured", detail)
        return []

    def _each_wheel(self, block: Block, fix: Fix, yaw_radps: float) -> list[tuple[str, str]]:
        if not fix.rolling:
            return []
        left_m, right_m = block.wheels_m.sum(axis=0).tolist()
        self._left += abs(left_m)
        self._right += abs(right_m)
        self._left_signed += left_m
        self._right_signed += right_m
        self._turned += yaw_radps * fix.duration_s
        if max(self._left, self._right) < _LOOK_M:
            return []
        told_rad = (self._right_signed - self._left_signed) / self._params.track_m
        odd = abs(told_rad - self._turned) > max(0.4, 0.5 * abs(told_rad))
        left, right = self._left, self._right
        opposed = self._left_signed * self._right_signed < 0.0
        self._left = self._right = self._left_signed = self._right_signed = self._turned = 0.0
        if not odd:
            self._told -= {"stuck", "one"}
            return []
        if min(left, right) < 0.02 * _LOOK_M:
            side = "left" if left < right else "right"
            detail = f"the {side} wheel is not counted, although the walker goes straight on"
            return self._once("stuck", "encoder-stuck", detail)
        if opposed:
            detail = "the wheels turn against each other, the gyroscope says straight on: one sign"
            return self._once("one", "not-mounted-as-configured", detail)
        return []

    def _both_wheels(self, block: Block, fix: Fix, rate_d: Floats) -> list[tuple[str, str]]:
        """Compare the wheels' acceleration with what the accelerometer felt of it."""
        change = (fix.speed_mps - self._speed_mps) / fix.duration_s
        felt = self._felt(block, rate_d)
        self._speed_mps = fix.speed_mps
        if fix.still:
            self._rest_mps2, self._pitch_rad = float(block.accel_d[:, 0].mean()), 0.0
            return []
        self._pitch_rad += float(rate_d[1]) * fix.duration_s
        if not fix.rolling or block.bridged:
            return []
        self._both += felt * change
        self._wheels += change * change
        if self._wheels < _EVIDENCE:
            return []
        backward = self._both < -0.4 * self._wheels
        self._both = self._wheels = 0.0
        if not backward:
            self._told -= {"both"}
            return []
        detail = (
            "the wheels count backward when the accelerometer feels forward: signs, or mounting"
        )
        return self._once("both", "not-mounted-as-configured", detail)

    def _felt(self, block: Block, rate_d: Floats) -> float:
        """Return the forward acceleration of the body's origin, about the start of the block.

        A difference of mean speeds is the acceleration weighted by a triangle over both blocks,
        and so is the force here: the mean over the last block is half a block late, which in a
        quick push with a pitch can turn the sign. Of the force, gravity goes with the pitch, and
        so does what the pitch's own acceleration gives the IMU high above the floor.
        """
        share = (np.arange(len(block.accel_d)) + 0.5) / len(block.accel_d)
        ahead = block.accel_d[:, 0]
        mean_mps2 = self._rising_mps2 + float(np.mean((1.0 - share) * ahead))
        self._rising_mps2 = float(np.mean(share * ahead))
        turning = (rate_d - self._rate_d) / block.duration_s
        self._rate_d = rate_d
        lever_mps2 = float(np.cross(turning, self._params.imu_position_m)[0])
        gravity = STANDARD_GRAVITY_MPS2 * self._pitch_rad
        return mean_mps2 - lever_mps2 - self._rest_mps2 + gravity
