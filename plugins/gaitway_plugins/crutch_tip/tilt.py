"""The crutch's tilt: three gyroscope axes integrated, brought back by each stance's inclination.

The paper integrates the gyroscope's y axis alone, so that a crutch that leans sideways takes a turn
of its user for a change of pitch. Here the whole attitude is integrated: an ``ErrorStateFilter`` of
which only attitude and gyroscope bias are used. An inclination is taken in as the mean difference
to what the integrated attitudes let expect, so the crutch may move on while it is measured.
"""

from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import (
    ATT,
    GYRO_BIAS,
    ErrorStateFilter,
    ImuNoise,
    Measurement,
    rotation,
    zero_rate,
)
from gaitway_plugins.crutch_tip.inclination import vertical_d
from gaitway_plugins.crutch_tip.params import CrutchTipParams

_BEGIN_SIGMA_RAD: Final = 0.15
"""Of a first inclination, read at any moment."""
_LOST_RADPS: Final = 1.0
"""How fast a crutch may have turned while no samples came."""
_NIS_MAX: Final = 40.0
"""An inclination that disagrees by more says that the tilt was lost; there it begins anew."""
_REST_RATE_RADPS: Final = 0.004


class Tilt:
    """Attitude and gyroscope bias of a crutch.

    Args:
        params: Of the crutch.
        period_s: Of the samples.
    """

    def __init__(self, params: CrutchTipParams, period_s: float) -> None:
        self._params = params
        self._period_s = period_s
        self._kf = ErrorStateFilter(states=15)
        self._kf.set_block(GYRO_BIAS, params.gyro_bias_sigma_radps**2)
        self._noise = ImuNoise(
            0.0, params.gyro_noise_radps_rthz, 0.0, params.gyro_bias_walk_radps_rts
        )
        self.known = False

    def begin(self, up_d: Floats, sigma_rad: float = _BEGIN_SIGMA_RAD) -> None:
        """Set the tilt from an inclination; what is known of the bias stays.

        Args:
            up_d: The vertical's components along x and y, the second NaN where unknown, shape (2,).
            sigma_rad: Their standard deviation.
        """
        x, y = (0.0 if np.isnan(part) else float(part) for part in up_d)
        z = np.sqrt(max(0.05, 1.0 - x * x - y * y))
        self._kf.q_nd = rotation.from_gravity((x, y, float(z)))
        self._kf.set_block(ATT, np.diag([sigma_rad**2, sigma_rad**2, 0.0]))
        if np.isnan(up_d[1]):
            self._kf.covariance[ATT, ATT] += np.diag([self._params.roll_sigma_rad**2, 0.0, 0.0])
        self.known = True

    def lose(self, duration_s: float) -> None:
        """Take that no samples came for a while."""
        variance = (_LOST_RADPS * duration_s) ** 2
        self._kf.covariance[ATT, ATT] += np.diag([variance, variance, 0.0])

    def move(self, gyro_d: Floats) -> Floats:
        """Go on by samples of the angular rate, shape (n, 3).

        Return the attitude at the time of each, shape (n, 4): half a period before the end of the
        interval that it is integrated over, where a sample is of an instant.
        """
        kf = self._kf
        out = np.empty((len(gyro_d), 10))
        kf.run(np.zeros_like(gyro_d), gyro_d, self._period_s, self._noise, out=out)
        kf.nominal[:6] = 0.0  # position and velocity are not used
        q_nd = out[:, 6:]
        if self._params.imu_sample == "interval":
            return q_nd
        return turned_back(q_nd, 0.5 * self._period_s * gyro_d)

    def rest(self, gyro_d: Floats) -> None:
        """Take in that the crutch rests; what it reads on average is bias, shape (3,)."""
        self._kf.correct(zero_rate(self._kf, gyro_d.tolist(), _REST_RATE_RADPS))

    def correct(self, q_nd: Floats, more_d: Floats, age_s: float, sigma_rad: float) -> Floats:
        """Take in a mean inclination; return the rotation by which attitudes change, shape (4,).

        Args:
            q_nd: Attitude in the middle of its samples, as integrated, shape (4,).
            more_d: Mean of the vertical's components along x and y as measured, less what was
                expected by the integrated attitudes, shape (2,), the second NaN where unknown.
            age_s: How long that middle is past.
            sigma_rad: Standard deviation of the mean.
        """
        before = self._kf.q_nd
        measurement = self.measurement(q_nd, more_d, age_s, sigma_rad)
        if self._kf.innovation(measurement).nis > _NIS_MAX * len(measurement.z):
            self._kf.set_block(ATT, np.diag([_LOST_RADPS**2, _LOST_RADPS**2, 0.0]))
            measurement = self.measurement(q_nd, more_d, age_s, sigma_rad)
        self._kf.correct(measurement)
        return np.array(rotation.multiply(self._kf.q_nd, rotation.conjugate(before)))

    def pitch_sigma_rad(self) -> float:
        """Return the standard deviation of the pitch now."""
        C_nd = rotation.to_matrix(self._kf.q_nd)
        # The pitch turns about the horizontal axis across the shaft's forward lean.
        axis = np.array([-C_nd[1, 0], C_nd[0, 0], 0.0])
        axis /= max(float(np.linalg.norm(axis)), 1e-9)
        return float(np.sqrt(max(0.0, axis @ self._kf.covariance[ATT, ATT] @ axis)))

    def measurement(
        self, q_nd: Floats, more_d: Floats, age_s: float, sigma_rad: float
    ) -> Measurement:
        """Return what ``correct`` takes in, of its arguments."""
        C_dn = rotation.to_matrix(q_nd.tolist()).T
        # up_d = C_dn z; with C_nd = exp([theta x]) C_nd_hat its error is C_dn [z x] theta.
        of_attitude = C_dn @ rotation.skew((0.0, 0.0, 1.0))
        H = np.zeros((3, 15))
        H[:, ATT] = of_attitude
        # theta has since grown by -C_nd d_gyro dt, which the middle did not know of.
        H[:, GYRO_BIAS] = of_attitude @ C_dn.T * age_s
        z, R = more_d.copy(), np.eye(2) * sigma_rad**2
        if np.isnan(z[1]):
            # Nobody told the roll: crutches lean about upright.
            z[1], R[1, 1] = -C_dn[1, 2], self._params.roll_sigma_rad**2
        return Measurement(z, H[:2], R)


def pitch_rad(q_nd: Floats) -> Floats:
    """Return the pitch of attitudes (n, 4), negative where the tip is ahead, shape (n,)."""
    pitch: Floats = -np.arcsin(np.clip(vertical_d(q_nd)[:, 0], -1.0, 1.0))
    return pitch


def turned_back(q_nd: Floats, small_rad: Floats) -> Floats:
    """Return ``q_nd (x) [1, -small_rad / 2]``, for attitudes (n, 4) and small turns in d (n, 3)."""
    w, x, y, z = q_nd.T
    a, b, c = -0.5 * small_rad.T
    back = np.column_stack(
        [
            w - x * a - y * b - z * c,
            x + w * a + y * c - z * b,
            y + w * b - x * c + z * a,
            z + w * c + x * b - y * a,
        ]
    )
    q: Floats = back / np.sqrt((back**2).sum(axis=1, keepdims=True))
    return q


def turned(q: Floats, q_nd: Floats) -> Floats:
    """Return ``q (x) q_nd`` of one rotation and attitudes of shape (n, 4)."""
    w, x, y, z = q
    left = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
    product: Floats = q_nd @ left.T
    return product
