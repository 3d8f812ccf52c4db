"""What else there is to say of a sensor at an ankle: dropped, or not mounted as configured."""

import math
from typing import Final

from gaitway.api import Anomaly, Event
from gaitway.estimation import ImuSample
from gaitway.estimation.rotation import rotate
from gaitway_plugins.ankle.params import AnkleParams
from gaitway_plugins.ankle.way import Way

_FALL_MPS2: Final = 2.0
"""A falling body feels less."""
_FALL_S: Final = 0.2
"""20 cm deep."""
_ASKEW_RAD: Final = math.radians(60.0)
"""Walking in a direction so far from the device's x axis is no walking forward."""
_AGREEING: Final = 4
"""So many strides in a row."""


class Watch:
    """Says anomalies that concern the sensor rather than a stride.

    Args:
        params: Of the ankle.
        period_s: Of the samples.
    """

    def __init__(self, params: AnkleParams, period_s: float) -> None:
        self._fall: Final = max(2, math.ceil(_FALL_S / period_s))
        self._lean: Final = params.max_lean_rad
        self._falling = 0
        self._askew = 0

    def push(self, sample: ImuSample) -> list[Event]:
        """Take the next sample."""
        fx, fy, fz = sample.accel_d
        free = fx * fx + fy * fy + fz * fz < _FALL_MPS2**2
        self._falling = self._falling + 1 if free else 0
        if self._falling != self._fall:
            return []
        detail = "free fall for 0.2 s: what follows may not be on the leg"
        return [Anomaly(t_ns=sample.t_ns, anomaly="device-dropped", detail=detail)]

    def stride(self, way: Way) -> list[Event]:
        """Take a stride's direction; say once when several agree that x is not forward."""
        ahead_x, ahead_y, _ = rotate(way.before.q_nd, (1.0, 0.0, 0.0))
        course = math.atan2(way.step_n[1], way.step_n[0]) - math.atan2(ahead_y, ahead_x)
        off = abs(math.remainder(course, 2.0 * math.pi))
        self._askew = self._askew + 1 if off > _ASKEW_RAD else 0
        if self._askew != _AGREEING:
            return []
        detail = f"strides lead {math.degrees(off):.0f} degrees off the configured forward axis"
        return [Anomaly(t_ns=way.after.t_ns, anomaly="not-mounted-as-configured", detail=detail)]
