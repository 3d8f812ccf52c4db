"""Whether a cane is walked with: Dang & Suh (2018), Section 3.3."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gaitway.estimation.rotation import Vector
from gaitway.estimation.windows import CentredMean, half_window
from gaitway.samples import Floats


def tilt_from_gravity_rad(accel_d: Vector) -> float:
    """Return the angle between shaft and specific force (Eq. 13), 0 to pi.

    The printed arctangent takes a cane upside down for an upright one; this one does not.

    Args:
        accel_d: Specific force, z along the shaft.
    """
    fx, fy, fz = accel_d
    return math.atan2(math.sqrt(fx * fx + fy * fy), fz)


def tilts_from_gravity_rad(accel_d: Floats) -> Floats:
    """Return the same for many samples, shape (n,), of specific forces of shape (n, 3)."""
    fx, fy, fz = accel_d.T
    tilts: Floats = np.arctan2(np.sqrt(fx * fx + fy * fy), fz)
    return tilts


class WalkingTest:
    """Magnitude subtraction and tilt, both as means over a centred window (Eqs. 11-14).

    The paper's axes are x up, y right, z forward; ours in d are x forward, y left, z up. Walking
    turns a cane about its shaft and about the sideways axis, hardly about the forward one.

    Args:
        window_s: Of the means; the paper's N_sms and N_theta.
        period_s: Of the samples.
        sms_max_radps: The paper's B_sms.
        tilt_max_rad: The paper's B_theta.

    Attributes:
        half: How many samples after its own a verdict is known.
    """

    def __init__(
        self, *, window_s: float, period_s: float, sms_max_radps: float, tilt_max_rad: float
    ) -> None:
        self.half: Final = half_window(window_s, period_s)
        self._sms = CentredMean(self.half)
        self._tilt = CentredMean(self.half)
        self._sms_max = sms_max_radps
        self._tilt_max = tilt_max_rad

    def push(self, gyro_d: Vector, tilt_rad: float) -> bool | None:
        """Take the next angular rate, and the tilt of the cane with it.

        Returns:
            The verdict on the sample ``half`` before, once there is one.
        """
        wx, wy, wz = gyro_d
        constrained = wy * wy + wz * wz
        sms = self._sms.push(math.sqrt(constrained + wx * wx) - math.sqrt(constrained))
        tilt = self._tilt.push(tilt_rad)
        return None if sms is None or tilt is None else self._walking(sms, tilt)

    def extend(self, gyro_d: Floats, tilt_rad: Floats) -> NDArray[np.bool_]:
        """Take samples; return the verdicts that are known now, as ``push`` would give them.

        Args:
            gyro_d: Angular rate, rad/s, shape (n, 3).
            tilt_rad: Of the cane, shape (n,).
        """
        wx, wy, wz = gyro_d.T
        constrained = wy * wy + wz * wz
        sms = self._sms.extend(np.sqrt(constrained + wx * wx) - np.sqrt(constrained))
        verdicts: NDArray[np.bool_] = (sms <= self._sms_max) & (
            self._tilt.extend(tilt_rad) <= self._tilt_max
        )
        return verdicts

    def finish(self) -> list[bool]:
        """Return the verdicts on the last samples."""
        means = zip(self._sms.finish(), self._tilt.finish(), strict=True)
        return [self._walking(sms, tilt) for sms, tilt in means]

    def _walking(self, sms_radps: float, tilt_rad: float) -> bool:
        return sms_radps <= self._sms_max and tilt_rad <= self._tilt_max
