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

from collections.abc import Callable, Iterable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gaitway.estimation import kernels
from gaitway.estimation.noise import ImuNoise
from gaitway.estimation.rotation import Quaternion, normalized
from gaitway.estimation.states import ACCEL_BIAS_NOMINAL, GYRO_BIAS_NOMINAL, POS, Q_ND, VEL
from gaitway.samples import Floats

STANDARD_GRAVITY_MPS2: Final = 9.80665


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
        covariance: Of the error state, shape (states, states), in the order of
            ``gaitway.estimation.states``. Only its upper triangle is read.
    """

    def __init__(self, *, states: int = 15, gravity_mps2: float = STANDARD_GRAVITY_MPS2) -> None:
        if states not in (9, 15):
            raise ValueError(f"an error-state filter has 9 or 15 states, not {states}")
        self.states: Final = states
        self.gravity_mps2: Final = gravity_mps2
        self.nominal: Final[Floats] = np.zeros(16)
        self.nominal[Q_ND] = (1.0, 0.0, 0.0, 0.0)
        self.covariance: Final[Floats] = np.zeros((states, states))

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
        w, x, y, z = self.nominal[Q_ND].tolist()
        return (w, x, y, z)

    @q_nd.setter
    def q_nd(self, value: Iterable[float]) -> None:
        self.nominal[Q_ND] = normalized(value)

    @property
    def gyro_bias_d(self) -> Floats:
        """Gyroscope bias, rad/s, shape (3,): a view."""
        return self.nominal[GYRO_BIAS_NOMINAL]

    @property
    def accel_bias_d(self) -> Floats:
        """Accelerometer bias, m/s^2, shape (3,): a view."""
        return self.nominal[ACCEL_BIAS_NOMINAL]

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
        kernels.predict(
            self.nominal,
            self.covariance,
            accel_d,
            gyro_d,
            dt_s,
            self.gravity_mps2,
            noise.accel_mps2_rthz,
            noise.gyro_radps_rthz,
            noise.accel_bias_walk_mps2_rts,
            noise.gyro_bias_walk_radps_rts,
        )

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
        kernels.run(
            self.nominal,
            self.covariance,
            np.asarray(accel_d, np.float64),
            np.asarray(gyro_d, np.float64),
            dt_s,
            self.gravity_mps2,
            noise.accel_mps2_rthz,
            noise.gyro_radps_rthz,
            noise.accel_bias_walk_mps2_rts,
            noise.gyro_bias_walk_radps_rts,
            still if still is None else np.asarray(still, np.bool_),
            imu_to_pivot_d,
            sigma_mps,
            out,
        )

    def innovation(self, measurement: Measurement) -> Innovation:
        """Return how well a measurement agrees with the filter, and change nothing: for gates."""
        return self._weigh(kernels.innovation, measurement)

    def correct(self, measurement: Measurement) -> Innovation:
        """Take in a measurement; return how well it agreed with the filter before.

        The gain is the optimal one and the covariance falls by ``W D^-1 W^T``, symmetric as it
        stands, where ``H P H^T + R = L D L^T`` and ``W = P H^T L^-T``.

        Raises:
            ValueError: ``H P H^T + R`` is not positive definite; nothing has changed.
        """
        return self._weigh(kernels.correct, measurement)

    def _weigh(
        self,
        kernel: Callable[[Floats, Floats, Floats, Floats, Floats, Floats], float],
        measurement: Measurement,
    ) -> Innovation:
        z, H, R = measurement
        z, H, R = np.asarray(z, float), np.asarray(H, float), np.asarray(R, float)
        standardised = np.empty(len(z))
        nis = kernel(self.nominal, self.covariance, z, H, R, standardised)
        return Innovation(standardised, nis)
