"""Whether a cane is walked with: Dang & Suh (2018), Section 3.3."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from gaitway.api import Floats
from gaitway.estimation import CentredMean, half_window
from gaitway_plugins.quad_cane.params import QuadCaneParams


def tilt_from_gravity_rad(accel_d: Floats) -> Floats:
    """Return the angle between shaft and specific force (Eq. 13), 0 to pi, shape (n,).

    The printed arctangent takes a cane upside down for an upright one; this one does not.

    Args:
        accel_d: Specific force, m/s^2, shape (n, 3).
    """
    fx, fy, fz = accel_d.T
    tilts: Floats = np.arctan2(np.sqrt(fx * fx + fy * fy), fz)
    return tilts


class WalkingTest:
    """Magnitude subtraction and tilt, both as means over a centred window (Eqs. 11-14).

    The paper's axes are x up, y right, z forward; ours in d are x forward, y left, z up. Walking
    turns a cane about its shaft and about the sideways axis, hardly about the forward one.

    Args:
        params: Of the cane.
        period_s: Of the samples.

    Attributes:
        half: How many samples after its own a verdict is known.
    """

    def __init__(self, params: QuadCaneParams, period_s: float) -> None:
        self.half: Final = half_window(params.walking_window_s, period_s)
        self._sms = CentredMean(self.half)
        self._tilt = CentredMean(self.half)
        self._sms_max = params.sms_max_radps
        self._tilt_max = params.tilt_max_rad

    def extend(self, gyro_d: Floats, tilt_rad: Floats) -> NDArray[np.bool_]:
        """Take samples; return the verdicts that are known now, of the samples ``half`` before.

        Args:
            gyro_d: Angular rate, rad/s, shape (n, 3).
            tilt_rad: Of the cane, shape (n,).
        """
        wx, wy, wz = gyro_d.T
        constrained = wy * wy + wz * wz
        sms_radps = np.sqrt(constrained + wx * wx) - np.sqrt(constrained)
        return self._walking(self._sms.extend(sms_radps), self._tilt.extend(tilt_rad))

    def finish(self) -> NDArray[np.bool_]:
        """Return the verdicts on the last samples."""
        return self._walking(np.array(self._sms.finish()), np.array(self._tilt.finish()))

    def _walking(self, sms_radps: Floats, tilt_rad: Floats) -> NDArray[np.bool_]:
        walking: NDArray[np.bool_] = (sms_radps <= self._sms_max) & (tilt_rad <= self._tilt_max)
        return walking
