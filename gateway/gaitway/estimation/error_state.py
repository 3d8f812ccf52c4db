"""An inertial navigator with an error-state Kalman filter around it.

The *nominal state* integrates the sensor. The *error state* is what it lacks to the truth, small
enough to be linear; a measurement estimates it, ``correct`` moves it into the nominal state, and
it is zero again. This is the indirect filter of Dang & Suh (2018), Eqs. 2-10 with the sign of
Eq. 10 corrected, in a form whose transition is the identity plus a few blocks:

- the attitude error is a rotation vector *in frame n*: ``C_nd = exp([theta x]) C_nd_hat``. The
  paper's half-angle error in the body, ``q = q_hat (x) [1, q_e]``, is ``theta = 2 C_nd q_e``.
  In frame n the attitude error does not turn with the device, and the one direction that gravity
  can't show, heading, is the same axis for ever, so no measurement can pretend to see it;
- with 15 states the biases are estimated, with 9 they are what they were set to.

Error dynamics, with ``f_n`` the specific force in n, ``u`` white noise and ``d`` the bias errors::

    theta' = -C_nd (d_gyro + u_gyro)
    vel'   = -[f_n x] theta - C_nd (d_accel + u_accel)
    pos'   = vel
"""

import math
from collections.abc import Iterable
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitway.estimation.noise import ImuNoise
from gaitway.estimation.rotation import (
    Quaternion,
    from_rotation_vector,
    multiply,
    normalized,
    to_matrix,
)
from gaitway.samples import Floats

POS: Final = slice(0, 3)
"""Position error, frame n, metres."""
VEL: Final = slice(3, 6)
"""Velocity error, frame n, m/s."""
ATT: Final = slice(6, 9)
"""Attitude error, a rotation vector in frame n, radians."""
GYRO_BIAS: Final = slice(9, 12)
"""Error of the gyroscope bias, frame d, rad/s; only with 15 states."""
ACCEL_BIAS: Final = slice(12, 15)
"""Error of the accelerometer bias, frame d, m/s^2; only with 15 states."""

STANDARD_GRAVITY_MPS2: Final = 9.80665

_Q: Final = slice(6, 10)
_GYRO_BIAS_NOMINAL: Final = slice(10, 13)
_ACCEL_BIAS_NOMINAL: Final = slice(13, 16)


class Measurement(NamedTuple):
    """What was seen of the error state: ``z = H x + noise``, noise of covariance R.

    Attributes:
        z: Measured minus predicted, shape (m,).
        H: How the error state shows in it, shape (m, states).
        R: Covariance of its noise, shape (m, m).
    """

    z: Floats
    H: Floats
    R: Floats


class Innovation(NamedTuple):
    """How well a measurement agreed with what the filter expected.

    Attributes:
        standardised: The residual in units of its standard deviation, decorrelated, shape (m,):
            independent and of unit variance when the filter is consistent.
        nis: Normalised innovation squared, their sum of squares: chi-square with m degrees of
            freedom when the filter is consistent.
    """

    standardised: Floats
    nis: float


class ErrorStateFilter:
    """Position, velocity and attitude by inertial navigation, kept in bounds by measurements.

    State and covariance live in two flat buffers that are written in place and never replaced.

    Args:
        states: 15 to estimate the sensor's biases, 9 to take them as known.
        gravity_mps2: Local gravity.

    Attributes:
        nominal: Position, velocity (frame n), ``q_nd``, gyroscope and accelerometer bias (frame d),
            shape (16,).
        covariance: Of the error state, shape (states, states), in the order of the module's slices.
    """

    def __init__(self, *, states: int = 15, gravity_mps2: float = STANDARD_GRAVITY_MPS2) -> None:
        if states not in (9, 15):
            raise ValueError(f"an error-state filter has 9 or 15 states, not {states}")
        self.states: Final = states
        self.gravity_mps2: Final = gravity_mps2
        self.nominal: Final[Floats] = np.zeros(16)
        self.nominal[_Q] = (1.0, 0.0, 0.0, 0.0)
        self.covariance: Final[Floats] = np.zeros((states, states))
        self._transition: Final[Floats] = np.eye(states)
        self._product: Final[Floats] = np.empty((states, states))

    @property
    def pos_n(self) -> Floats:
        """Position in n, metres, shape (3,): a view, assign with ``pos_n[:] = ...``."""
        return self.nominal[POS]

    @property
    def vel_n(self) -> Floats:
        """Velocity in n, m/s, shape (3,): a view."""
        return self.nominal[VEL]

    @property
    def q_nd(self) -> Quaternion:
        """Attitude of the device; assign any quaternion, it is normalised."""
        w, x, y, z = self.nominal[_Q].tolist()
        return (w, x, y, z)

    @q_nd.setter
    def q_nd(self, value: Iterable[float]) -> None:
        self.nominal[_Q] = normalized(value)

    @property
    def gyro_bias_d(self) -> Floats:
        """Gyroscope bias, rad/s, shape (3,): a view."""
        return self.nominal[_GYRO_BIAS_NOMINAL]

    @property
    def accel_bias_d(self) -> Floats:
        """Accelerometer bias, m/s^2, shape (3,): a view."""
        return self.nominal[_ACCEL_BIAS_NOMINAL]

    def set_block(self, block: slice, covariance: Floats | float) -> None:
        """Forget what is known of one block of the error: new variance, no correlation.

        Args:
            block: ``POS``, ``VEL``, ``ATT``, ``GYRO_BIAS`` or ``ACCEL_BIAS``.
            covariance: Of shape (3, 3), or one variance for three independent axes. Zero says that
                the block is known by definition, as a position is where it is counted from.
        """
        self.covariance[block, :] = 0.0
        self.covariance[:, block] = 0.0
        self.covariance[block, block] = np.eye(3) * covariance

    def predict(
        self, accel_d: Iterable[float], gyro_d: Iterable[float], dt_s: float, noise: ImuNoise
    ) -> None:
        """Go on by one sample.

        Args:
            accel_d: Mean specific force over the sample, as measured, m/s^2.
            gyro_d: Mean angular rate over the sample, as measured, rad/s.
            dt_s: Its length.
            noise: Of the sensor.
        """
        px, py, pz, vx, vy, vz, qw, qx, qy, qz, *bias = self.nominal.tolist()
        gx, gy, gz = gyro_d
        fx, fy, fz = accel_d
        half_s = 0.5 * dt_s
        half_turn = from_rotation_vector(
            ((gx - bias[0]) * half_s, (gy - bias[1]) * half_s, (gz - bias[2]) * half_s)
        )
        q_middle = multiply((qw, qx, qy, qz), half_turn)
        C = to_matrix(q_middle)
        ax, ay, az = C.dot((fx - bias[3], fy - bias[4], fz - bias[5])).tolist()
        up = az - self.gravity_mps2
        halved = half_s * dt_s
        self.nominal[:10] = (
            px + vx * dt_s + ax * halved,
            py + vy * dt_s + ay * halved,
            pz + vz * dt_s + up * halved,
            vx + ax * dt_s,
            vy + ay * dt_s,
            vz + up * dt_s,
            *normalized(multiply(q_middle, half_turn)),
        )
        Q = _process_covariance(noise, dt_s, self.states)
        self._predict_covariance(C, (ax * dt_s, ay * dt_s, az * dt_s), dt_s, Q)

    def run(
        self,
        accel_d: Floats,
        gyro_d: Floats,
        dt_s: float,
        noise: ImuNoise,
        *,
        still: NDArray[np.bool_] | None = None,
        imu_to_pivot_d: Iterable[float] = (0.0, 0.0, 0.0),
        sigma_mps: float = 0.01,
        out: Floats | None = None,
    ) -> None:
        """Go on by many samples at once: the same as ``predict`` for each, and a great deal faster.

        Args:
            accel_d: Specific force of each sample, m/s^2, shape (n, 3).
            gyro_d: Angular rate of each sample, rad/s, shape (n, 3).
            dt_s: Length of a sample.
            noise: Of the sensor.
            still: After which samples a point of the device stands still (``pivot_velocity``),
                shape (n,); after none where None.
            imu_to_pivot_d: From the sensor to that point, metres; zero is ``zero_velocity``.
            sigma_mps: How fast it may be moving nevertheless, per axis.
            out: Where to write position, velocity and ``q_nd`` after each sample, shape (n, 10).
        """
        from gaitway.estimation.measurements import pivot_velocity  # noqa: PLC0415

        lever_d = tuple(imu_to_pivot_d)
        for row in range(len(accel_d)):
            self.predict(accel_d[row].tolist(), gyro_d[row].tolist(), dt_s, noise)
            if still is not None and still[row]:
                self.correct(pivot_velocity(self, gyro_d[row].tolist(), lever_d, sigma_mps))
            if out is not None:
                out[row] = self.nominal[:10]

    def innovation(self, measurement: Measurement) -> Innovation:
        """Return how well a measurement agrees with the filter, and change nothing: for gates."""
        return self._weigh(measurement)[0]

    def correct(self, measurement: Measurement) -> Innovation:
        """Take in a measurement; return how well it agreed with the filter before.

        With ``S = H P H^T + R = L L^T`` and ``G = P H^T L^-T`` the gain is ``G L^-1`` and the
        covariance falls by ``G G^T``: Joseph's form with the optimal gain, symmetric as it stands.
        """
        innovation, G = self._weigh(measurement)
        P = self.covariance
        np.subtract(P, G.dot(G.T), out=P)
        np.add(P, P.T, out=self._product)
        np.multiply(self._product, 0.5, out=P)
        self._inject(G.dot(innovation.standardised))
        return innovation

    def _weigh(self, measurement: Measurement) -> tuple[Innovation, Floats]:
        z, H, R = measurement
        PHt = self.covariance.dot(H.T)
        whiten = _whitener(H.dot(PHt) + R)
        standardised = whiten.dot(z)
        return Innovation(standardised, float(standardised.dot(standardised))), PHt.dot(whiten.T)

    def _predict_covariance(
        self, C: Floats, delta_v: tuple[float, float, float], dt_s: float, Q: Floats
    ) -> None:
        # P <- F P F^T + Q with F = I + dt A, the error dynamics of the module's docstring.
        F = self._transition
        dx, dy, dz = delta_v
        F[0, 3] = F[1, 4] = F[2, 5] = dt_s
        F[3, 7], F[3, 8], F[4, 8] = dz, -dy, dx
        F[4, 6], F[5, 6], F[5, 7] = -dz, dy, -dx
        if self.states == 15:
            np.multiply(C, -dt_s, out=F[ATT, GYRO_BIAS])
            F[VEL, ACCEL_BIAS] = F[ATT, GYRO_BIAS]
        np.dot(F, self.covariance, out=self._product)
        np.dot(self._product, F.T, out=self.covariance)
        np.add(self.covariance, Q, out=self.covariance)

    def _inject(self, error: Floats) -> None:
        # The error is in the nominal state now and zero again; its covariance turns with the
        # attitude only in second order.
        nominal = self.nominal
        nominal[:6] += error[:6]
        self.q_nd = multiply(from_rotation_vector(error[ATT].tolist()), self.q_nd)
        if self.states == 15:
            nominal[10:] += error[9:]


@lru_cache(maxsize=32)
def _process_covariance(noise: ImuNoise, dt_s: float, states: int) -> Floats:
    Q = noise.process_covariance(dt_s, states)
    Q.setflags(write=False)
    return Q


def _whitener(S: Floats) -> Floats:
    """Return ``L^-1`` of ``S = L L^T``, shape (m, m), lower triangular."""
    if len(S) != 3:
        return np.linalg.inv(np.linalg.cholesky(S))
    # Nearly every measurement is a vector; three floats beat the overhead of LAPACK five times.
    (a, _, _), (b, c, _), (d, e, f) = S.tolist()
    u = 1.0 / math.sqrt(a)
    b *= u
    d *= u
    v = 1.0 / math.sqrt(c - b * b)
    e = (e - b * d) * v
    w = 1.0 / math.sqrt(f - d * d - e * e)
    lower = b * u * v
    return np.array(((u, 0.0, 0.0), (-lower, v, 0.0), ((e * lower - d * u) * w, -e * v * w, w)))
