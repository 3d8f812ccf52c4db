"""When a device stands on the ground, by the norms of specific force and angular rate."""

import math
from collections.abc import Iterable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gaitway.estimation.error_state import STANDARD_GRAVITY_MPS2
from gaitway.estimation.windows import CentredHold, half_window
from gaitway.samples import Floats


class StanceDetector:
    """Zero-velocity intervals after Dang & Suh (2018), Eqs. 16 and 17.

    A sample is in stance when at every sample of the window centred on it the specific force is
    within ``accel_max_mps2`` of gravity and the angular rate below ``gyro_max_radps``, both by
    their norms, so that neither attitude nor mounting matters.

    Args:
        period_s: Of the samples.
        window_s: Length of the window; both of the paper's have the same.
        accel_max_mps2: The paper's B_a.
        gyro_max_radps: The paper's B_g.
        gravity_mps2: Length of the specific force at rest.

    Attributes:
        half: How many samples after its own a verdict is known.
    """

    def __init__(
        self,
        period_s: float,
        *,
        window_s: float,
        accel_max_mps2: float,
        gyro_max_radps: float,
        gravity_mps2: float = STANDARD_GRAVITY_MPS2,
    ) -> None:
        self.half: Final = half_window(window_s, period_s)
        self._hold = CentredHold(self.half)
        self._accel_max = accel_max_mps2
        self._gyro_max = gyro_max_radps
        self._gravity = gravity_mps2

    def push(self, accel: Iterable[float], gyro: Iterable[float]) -> bool:
        """Take the next sample; return whether the one ``half`` samples before was in stance."""
        fx, fy, fz = accel
        wx, wy, wz = gyro
        force = math.sqrt(fx * fx + fy * fy + fz * fz)
        rate = math.sqrt(wx * wx + wy * wy + wz * wz)
        return self._hold.push(
            abs(force - self._gravity) <= self._accel_max and rate <= self._gyro_max
        )

    def extend(self, accel: Floats, gyro: Floats) -> NDArray[np.bool_]:
        """Take many samples at once; return for each what ``push`` would, shape (n,).

        Args:
            accel: Specific force, m/s^2, shape (n, 3).
            gyro: Angular rate, rad/s, shape (n, 3).
        """
        off_mps2 = np.abs(norms(accel) - self._gravity)
        return self._hold.extend((off_mps2 <= self._accel_max) & (norms(gyro) <= self._gyro_max))


def norms(vectors: Floats) -> Floats:
    """Return the length of each of vectors of shape (n, 3)."""
    x, y, z = vectors.T
    lengths: Floats = np.sqrt(x * x + y * y + z * z)
    return lengths
