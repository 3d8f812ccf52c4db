"""How the sensor is worn, told from the turning of the leg itself.

A leg that walks turns about one axis, level and across the way, backward much faster than forward.
So the principal axis of the angular rate, pointed by the skewness of the rate about it, is the axis
to the left of the body, whatever way the sensor was strapped on.
"""

from typing import Final

import numpy as np

from gaitway.api import Anomaly, Event, Floats
from gaitway.estimation import ImuSample
from gaitway.estimation.rotation import Vector
from gaitway_plugins.shank.track import samples

_BLOCK_S: Final = 4.0
"""Looked at so long: two to four strides."""
_AGREE: Final = 2
"""So many blocks in a row have to say the same."""
_RATE_MIN_RADPS: Final = 1.0
"""Less than this, root mean square, is no walk; people's is 2 to 3, a shuffle's 1.1."""
_SHARE_MIN: Final = 0.7
"""Of the turning about the principal axis."""
_SKEW_MIN: Final = 0.5
"""Of the rate about it; walking has 1 and more, swinging to and fro 0."""
_LEVEL_MAX: Final = 0.4
"""Sine of the principal axis' steepness."""
_SAME_MIN: Final = 0.87
"""Cosine of 30 degrees: two blocks agree whose axes differ by less."""
_ACROSS_MIN: Final = 0.7
"""Cosine of 45 degrees: so far from where it should be the axis does no harm and stays."""
_UPRIGHT_MIN: Final = 0.64
"""Cosine of 50 degrees: mean of gravity along the shank while walking."""
_AS_CONFIGURED: Final[Vector] = (0.0, 1.0, 0.0)


class Wearing:
    """Finds the axis about which the leg swings, and whether it is the configured one.

    Attributes:
        axis_d: About which the shank's sagittal rate is taken.
    """

    def __init__(self) -> None:
        self.axis_d: Vector = _AS_CONFIGURED
        self._gyro_d: list[Vector] = []
        self._accel_d: list[Vector] = []
        self._count = 0
        self._candidate = np.array(_AS_CONFIGURED)
        self._seen = 0
        self._said = False

    def begin(self, period_s: float) -> None:
        """Take that samples of this period follow, after a break."""
        self._count = samples(_BLOCK_S, period_s)
        self._gyro_d.clear()
        self._accel_d.clear()

    def push(self, sample: ImuSample) -> list[Event]:
        """Take the next sample; return what has to be said of the mounting."""
        self._gyro_d.append(sample.gyro_d)
        self._accel_d.append(sample.accel_d)
        if len(self._gyro_d) < self._count:
            return []
        up = np.mean(self._accel_d, axis=0)
        axis = swing_axis(np.array(self._gyro_d), up)
        self._gyro_d.clear()
        self._accel_d.clear()
        return [] if axis is None else self._take(axis, up, sample.t_ns)

    def _take(self, axis: Floats, up: Floats, t_ns: int) -> list[Event]:
        self._seen = self._seen + 1 if float(axis @ self._candidate) >= _SAME_MIN else 1
        self._candidate = axis
        if self._seen < _AGREE:
            return []
        across = float(axis[1]) >= _ACROSS_MIN
        x, y, z = axis.tolist()
        self.axis_d = _AS_CONFIGURED if across else (x, y, z)
        upright = float(up[2]) >= _UPRIGHT_MIN * float(np.linalg.norm(up))
        said, self._said = self._said, not (across and upright)
        if said or not self._said:
            return []
        return [Anomaly(t_ns=t_ns, anomaly="not-mounted-as-configured", detail=_detail(axis, up))]


def swing_axis(gyro_d: Floats, up: Floats) -> Floats | None:
    """Return the axis to the left of a walking leg, a unit vector; None where nobody walks.

    Args:
        gyro_d: Angular rates, shape (n, 3).
        up: Mean specific force, shape (3,).
    """
    powers, axes = np.linalg.eigh(gyro_d.T @ gyro_d / len(gyro_d))
    total = float(powers.sum())
    if total < _RATE_MIN_RADPS**2 or powers[2] < _SHARE_MIN * total:
        return None
    axis = axes[:, 2]
    skew = float(np.mean((gyro_d @ axis) ** 3)) / float(powers[2]) ** 1.5
    level = abs(float(axis @ up)) <= _LEVEL_MAX * float(np.linalg.norm(up))
    if abs(skew) < _SKEW_MIN or not level:
        return None
    return np.asarray(-axis if skew > 0.0 else axis)


def _detail(axis: Floats, up: Floats) -> str:
    off_deg = float(np.degrees(np.arccos(np.clip(axis[1], -1.0, 1.0))))
    lean_deg = float(np.degrees(np.arccos(np.clip(up[2] / np.linalg.norm(up), -1.0, 1.0))))
    return (
        f"the leg swings about an axis {off_deg:.0f} deg off the configured left, and up is "
        f"{lean_deg:.0f} deg off; measured all the same, check mounting"
    )
