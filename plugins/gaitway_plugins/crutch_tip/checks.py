"""What makes a crutch's numbers untrustworthy, said while it happens."""

from typing import Final

import numpy as np

from gaitway.api import Anomaly, Event, Floats
from gaitway.estimation import norms
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.stream import CLIPPED, FELT, FORCE, GYRO_D, UP_D, Rows

DRAG_S: Final = 2.0
DRAG_RATE_RADPS: Final = 0.15
DRAG_FORCE_SHARE: Final = 0.1
DRAG_SHARE: Final = 0.8
"""Dragged: turned about for so long at such a rate with a little force for such a share of it."""
FALL_MPS2: Final = 3.0
FALL_S: Final = 0.2
"""Free fall, 20 cm deep."""
TOPPLE_RADPS: Final = 2.5
TOPPLE_S: Final = 1.5
LYING: Final = 0.85
LYING_S: Final = 0.5
"""Toppled over: so soon after turning so fast it lies, the vertical so much across the shaft, for
so long: in a swing the acceleration looks like lying for a moment."""
AGAIN_S: Final = 10.0
"""An anomaly that goes on is told again after this."""
DISAGREEING: Final = 4
TURNED_RAD: Final = 0.08
"""In so many stances in a row that turn by more, inclinometer and gyroscope go opposite ways."""


class Checks:
    """Watches samples and stances.

    Args:
        params: Of the crutch.
        period_s: Of the samples.
    """

    def __init__(self, params: CrutchTipParams, period_s: float) -> None:
        self._params = params
        self._period_s = period_s
        self._dragged_s = self._fell_s = 0.0
        self._since_fast_s = TOPPLE_S
        self._lying_s = 0.0
        self._disagreeing = 0
        self._quiet_until_ns: dict[str, int] = {}

    def samples(self, rows: Rows) -> list[Event]:
        """Take the next samples, a tenth of a second or so."""
        values, t_ns = rows.values, int(rows.t_ns[-1])
        duration_s = len(rows) * self._period_s
        force = values[:, FORCE]
        p = self._params
        touching = (force > DRAG_FORCE_SHARE * p.force_min_newton) & (force < p.force_min_newton)
        moving = float(norms(values[:, GYRO_D]).mean()) > DRAG_RATE_RADPS
        dragged = moving and bool(touching.mean() >= DRAG_SHARE)
        self._dragged_s = max(0.0, self._dragged_s + (duration_s if dragged else -duration_s))
        falling = bool((values[:, FELT] < FALL_MPS2).all())
        self._fell_s = self._fell_s + duration_s if falling else 0.0
        beyond = bool((np.abs(force) > p.force_full_scale_newton).any())
        found: list[Event] = []
        if self._dragged_s >= DRAG_S:
            found += self._tell(t_ns, "dragging", "the tip touches the floor but is never loaded")
        if self._fell_s >= FALL_S:
            found += self._tell(t_ns, "device-dropped", "free fall: the crutch was dropped")
        if self._toppled(values, duration_s):
            found += self._tell(t_ns, "device-dropped", "the crutch has toppled over and lies")
        if beyond:
            found += self._tell(
                t_ns, "sensor-saturated", "a force beyond the load cell's range is not believed"
            )
        if values[:, CLIPPED].any():
            found += self._tell(t_ns, "sensor-clipped", "an axis was at the end of its range")
        return found

    def _toppled(self, values: Floats, duration_s: float) -> bool:
        fast = bool((norms(values[:, GYRO_D]) > TOPPLE_RADPS).any())
        self._since_fast_s = 0.0 if fast else self._since_fast_s + duration_s
        across = float(np.mean(np.sqrt(np.nansum(values[:, UP_D] ** 2, axis=1))))
        self._lying_s = self._lying_s + duration_s if across > LYING and not fast else 0.0
        return self._since_fast_s < TOPPLE_S and self._lying_s >= LYING_S

    def stance(self, t_ns: int, by_gyro_rad: float, by_inclinometer_rad: float) -> list[Event]:
        """Take by how much a stance turned the crutch, as each sensor says."""
        if min(abs(by_gyro_rad), abs(by_inclinometer_rad)) > TURNED_RAD:
            opposite = by_gyro_rad * by_inclinometer_rad < 0.0
            self._disagreeing = self._disagreeing + 1 if opposite else 0
        if self._disagreeing < DISAGREEING:
            return []
        return self._tell(
            t_ns,
            "not-mounted-as-configured",
            "inclinometer and gyroscope turn opposite ways (check mounting): pitch is not told",
        )

    @property
    def misplaced(self) -> bool:
        """Whether the axes can't be as configured."""
        return self._disagreeing >= DISAGREEING

    def _tell(self, t_ns: int, name: str, detail: str) -> list[Event]:
        if t_ns < self._quiet_until_ns.get(name, t_ns):
            return []
        self._quiet_until_ns[name] = t_ns + round(AGAIN_S * 1e9)
        return [Anomaly(t_ns=t_ns, anomaly=name, detail=detail)]


def change(values: Floats) -> float:
    """Return by how much a quantity changed from its first to its last third."""
    third = max(1, len(values) // 3)
    return float(np.mean(values[-third:]) - np.mean(values[:third]))
