"""What happens to a cane besides walking: it falls, or its sensor sits otherwise than told."""

import math
from typing import Final

from gaitway.api import Anomaly
from gaitway.estimation import ImuSample

_SMOOTH_S: Final = 0.3
"""Time constant of the direction of gravity; a swing is over in that time."""
_LYING_RAD: Final = math.radians(65.0)
_UPRIGHT_RAD: Final = math.radians(45.0)
_UPSIDE_DOWN_RAD: Final = math.radians(120.0)
_KNOCK_MPS2: Final = 30.0
_FALL_S: Final = 2.0
"""From upright to lying on the floor, with a knock."""
_PERSISTENT_S: Final = 5.0
"""Nobody holds a cane upside down for so long."""


class Mishaps:
    """Watches the direction of gravity and knocks.

    Args:
        period_s: Of the samples.
    """

    def __init__(self, period_s: float) -> None:
        self._period_s = period_s
        self._gain = period_s / (_SMOOTH_S + period_s)
        self._force = (0.0, 0.0, 0.0)
        self._upright_s = self._knocked_s = math.inf
        self._upside_down_s = 0.0
        self._told = False

    def push(self, sample: ImuSample) -> Anomaly | None:
        """Take the next sample; return what it completes."""
        x, y, z = (
            old + self._gain * (new - old)
            for old, new in zip(self._force, sample.accel_d, strict=True)
        )
        self._force = (x, y, z)
        tilt_rad = math.atan2(math.sqrt(x * x + y * y), z)
        self._upright_s += self._period_s
        self._knocked_s += self._period_s
        fx, fy, fz = sample.accel_d
        if fx * fx + fy * fy + fz * fz > _KNOCK_MPS2**2:
            self._knocked_s = 0.0
        if tilt_rad < _UPRIGHT_RAD:
            self._upright_s = self._upside_down_s = 0.0
            self._told = False
        if self._told or tilt_rad < _LYING_RAD:
            return None
        return self._fallen(sample.t_ns) or self._upside_down(sample.t_ns, tilt_rad)

    def _fallen(self, t_ns: int) -> Anomaly | None:
        if max(self._upright_s, self._knocked_s) > _FALL_S:
            return None
        self._told = True
        detail = "the cane lies, a moment after it was upright, and something knocked at it"
        return Anomaly(t_ns=t_ns, anomaly="device-dropped", detail=detail)

    def _upside_down(self, t_ns: int, tilt_rad: float) -> Anomaly | None:
        self._upside_down_s += self._period_s if tilt_rad > _UPSIDE_DOWN_RAD else 0.0
        if self._upside_down_s < _PERSISTENT_S:
            return None
        self._told = True
        detail = "the cane seems to be upside down: does the sensor sit as the mounting says?"
        return Anomaly(t_ns=t_ns, anomaly="not-mounted-as-configured", detail=detail)
