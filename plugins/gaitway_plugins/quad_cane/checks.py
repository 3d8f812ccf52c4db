"""What makes a cane's numbers untrustworthy and no single placement shows."""

import math
from typing import Final

import numpy as np

from gaitway.api import Anomaly, Event
from gaitway.estimation import ImuBlock, norms

FALL_MPS2: Final = 2.0
"""A falling body feels less."""
FALL_S: Final = 0.2
"""Free for so long it has fallen 20 cm."""
SIDEWAYS_RAD: Final = math.radians(50.0)
"""No cane that is walked with leans so far."""
SIDEWAYS: Final = 4
"""So many placements in a row at such a tilt are walking with wrong axes."""


class FallCheck:
    """Watches for falls.

    Args:
        period_s: Of the samples.
    """

    def __init__(self, period_s: float) -> None:
        self._fall: Final = max(2, math.ceil(FALL_S / period_s))
        self._falling = 0

    def extend(self, block: ImuBlock) -> list[Event]:
        """Take the next samples; return falls that are certain."""
        free = norms(block.accel_d) < FALL_MPS2
        if not free.any():
            self._falling = 0
            return []
        number = np.arange(1, len(free) + 1)
        runs = number - np.maximum.accumulate(np.where(free, -self._falling, number))
        self._falling = int(runs[-1])
        detail = "free fall for 0.2 s: the cane was dropped"
        return [
            Anomaly(t_ns=t_ns, anomaly="device-dropped", detail=detail)
            for t_ns in block.t_ns[runs == self._fall].tolist()
        ]


class MountingCheck:
    """Watches for placements with an axis up that can't be the shaft's."""

    def __init__(self) -> None:
        self._sideways = 0

    def placement(self, t_ns: int, tilt_rad: float, length_m: float, swing_s: float) -> list[Event]:
        """Take a placement, whether it counts or not; say once when the shaft can't be up.

        Args:
            t_ns: Its contact.
            tilt_rad: Of the configured shaft axis, in the stance.
            length_m: Of the placement.
            swing_s: Its duration.
        """
        if not (0.1 < length_m < 1.5 and 0.3 < swing_s < 3.0):
            return []  # nothing like walking
        self._sideways = self._sideways + 1 if tilt_rad > SIDEWAYS_RAD else 0
        if self._sideways != SIDEWAYS:
            return []
        detail = (
            f"it is placed as in walking with its shaft axis {math.degrees(tilt_rad):.0f} degrees "
            "off the vertical (check mounting); nothing is counted"
        )
        return [Anomaly(t_ns=t_ns, anomaly="not-mounted-as-configured", detail=detail)]
