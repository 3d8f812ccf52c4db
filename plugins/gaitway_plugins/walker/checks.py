"""What makes numbers untrustworthy: wheels that count wrongly, a walker that fell."""

import math
from typing import Final

import numpy as np

from gaitway.api import Anomaly, Event
from gaitway_plugins.walker.blocks import Block
from gaitway_plugins.walker.fix import Fix
from gaitway_plugins.walker.params import WalkerParams

_LOOK_M: Final = 0.6
"""A wheel is judged after each so much of rolling."""
_FALL_MPS2: Final = 3.0
"""A mean force over a block below this is falling."""
_TIPPED: Final = math.cos(math.radians(45.0))
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
        self._pitch_rad = 0.0
        self._both = self._wheels = 0.0

    def push(self, block: Block, fix: Fix, yaw_radps: float, pitch_radps: float) -> list[Event]:
        """Take the next block and its fix; rates without bias. Return what is wrong."""
        found = [*self._posture(block, fix), *self._each_wheel(block, fix, yaw_radps)]
        found += self._both_wheels(block, fix, pitch_radps)
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
        if size < _FALL_MPS2:
            return self._once("fall", "dropped", "it fell freely for a tenth of a second")
        upright = float(force[2]) / size
        self._tilted_s = self._tilted_s + fix.duration_s if upright < _TILTED else 0.0
        if upright >= _TILTED and fix.still:
            self._upright = True
            self._told -= {"tip", "mount", "fall"}
        if self._tilted_s < 1.0:
            return []
        if self._upright and upright < _TIPPED:
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

    def _both_wheels(self, block: Block, fix: Fix, pitch_radps: float) -> list[tuple[str, str]]:
        """Compare the wheels' acceleration with the accelerometer's, pitch removed."""
        ahead = float(block.accel_d[:, 0].mean())
        change = (fix.speed_mps - self._speed_mps) / fix.duration_s
        self._speed_mps = fix.speed_mps
        self._pitch_rad += pitch_radps * fix.duration_s
        if fix.still:
            self._rest_mps2, self._pitch_rad = ahead, 0.0
            return []
        if not fix.rolling or block.bridged:
            return []
        # A block's mean speed lags the force by half a block, which leaves the sign alone.
        felt = ahead - self._rest_mps2 + 9.8 * self._pitch_rad
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
