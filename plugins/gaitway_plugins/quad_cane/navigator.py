"""Where the cane is between one stance and the next, and how well that is known."""

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import (
    ACCEL_BIAS,
    GYRO_BIAS,
    POS,
    VEL,
    ErrorStateFilter,
    ImuBlock,
    ImuSample,
    Measurement,
    RestDetector,
    align_at_rest,
    isotropic,
    level_at_rest,
    pivot_velocity,
    rotation,
    zero_rate,
    zero_velocity,
)
from gaitway_plugins.quad_cane.params import QuadCaneParams
from gaitway_plugins.quad_cane.tuning import Tuning

_SHAFT_D: Final = (0.0, 0.0, 1.0)
_VERTICAL_N: Final = (0.0, 0.0, 1.0)
_UNSURE: Final = 200.0
"""Noise of a clipped or bridged sample, relative to a measured one: a tenth of a second bridged
across the contact hides a change of velocity of about 0.1 m/s."""
_LOST: Final = (5e-3, 0.05)
"""How far gyroscope (rad/s) and accelerometer bias (m/s^2) may be gone where navigation was lost:
as far as at a new turn-on, which it may have been; and what went wrong may have spoilt them."""
_RESUMED: Final = (1e-3, 5e-3)
"""The same where the cane still stood as before when the samples came back."""
_IMPOSSIBLE: Final = 5.0
"""An accelerometer bias so many standard deviations large is no bias: it is found anew."""
_SAME_TILT_RAD: Final = 0.005
"""A cane that was put down again leans differently, by half a degree or so, on any floor."""
_VARIANCE_FACTOR_MEMORY: Final = 10.0
"""Contacts over which the variance they show, relative to the filter's own, is averaged."""
_VARIANCE_FACTOR_MIN: Final = 0.2
"""However well contacts agree, they don't show all of the error."""


class Displacement(NamedTuple):
    """A horizontal way.

    Attributes:
        length_m: From the last mark to here.
        sigma_m: Standard deviation of the navigation.
        lean_sigma_m: Standard deviation because the IMU's height is not exactly known and the cane
            leans differently; the next placement takes it back, so it does not add up.
    """

    length_m: float
    sigma_m: float
    lean_sigma_m: float


class _State(NamedTuple):
    """What a landing changes."""

    nominal: Floats
    covariance: Floats
    fastest_mps: float
    variance_factor: float


class Navigator:
    """The error-state filter of a quad cane with the zero velocities and rates of its stances.

    Dang & Suh (2018), Eqs. 2-10 and 18, with 15 states where the method says so. Positions are
    those of the base, ``imu_height_m`` below the IMU along the shaft, so that a cane that leans
    differently has not moved; ``published`` takes the IMU for the base as the paper does.

    Args:
        params: Of the cane.
        period_s: Of the samples.

    Attributes:
        aligned: Tilt and velocity are known; when not, only ``seek`` makes sense.
    """

    def __init__(self, params: QuadCaneParams, period_s: float) -> None:
        self._params = params
        self._period_s = period_s
        self._tuning = tuning = Tuning.of(params, period_s)
        self._kf = ErrorStateFilter(states=tuning.states)
        self._noise = tuning.noise
        self._noise_unsure = tuning.noise.scaled(_UNSURE)
        self._rest = self._new_rest(params.rest_window_s)
        self._ever_aligned = False
        self._up_n_marked = np.array([0.0, 0.0, 1.0])
        self._origin_n = np.zeros(3)
        self._fastest_mps = 0.0
        self._variance_factor = 1.0
        self._before_landing = _State(self._kf.nominal, self._kf.covariance, 0.0, 1.0)
        self.aligned = False

    @property
    def pos_n(self) -> Floats:
        """Position of the base in n since the first alignment, metres, shape (3,)."""
        return self._origin_n + self._moved_n()

    @property
    def vel_n(self) -> Floats:
        """Velocity of the IMU in n, m/s, shape (3,)."""
        return self._kf.vel_n

    def seek(self, sample: ImuSample) -> bool:
        """Look for a rest to start from; return whether this sample completed one."""
        rest = self._rest.push(sample.accel_d, sample.gyro_d)
        if rest is None:
            return False
        self._origin_n = self.pos_n
        p, kf, sigma_mps = self._params, self._kf, self._tuning.zero_velocity_sigma_mps
        if self._ever_aligned and self._tuning.states == 15:
            level_at_rest(kf, rest, velocity_sigma_mps=sigma_mps)
            kf.correct(zero_rate(kf, rest.gyro_d, p.zero_rate_sigma_radps))
        else:
            align_at_rest(
                kf,
                rest,
                accel_bias_sigma_mps2=p.accel_bias_sigma_mps2,
                gyro_bias_sigma_radps=p.gyro_bias_sigma_radps,
                velocity_sigma_mps=sigma_mps,
            )
        self.aligned = self._ever_aligned = True
        self._up_n_marked = self._up_n()
        return True

    def lose(self) -> None:
        """Forget tilt, velocity and position; the biases stay known, but less."""
        self.aligned = False
        self._rest = self._new_rest(self._params.resume_window_s)
        self._doubt_biases(*_LOST)
        p, kf = self._params, self._kf
        spoilt = np.abs(kf.accel_bias_d).max() > _IMPOSSIBLE * p.accel_bias_sigma_mps2
        if spoilt or np.abs(kf.gyro_bias_d).max() > p.rest_gyro_max_radps:
            self._ever_aligned = False

    def resume(self, accel_d: Floats) -> bool:
        """Go on after samples were missing, if the cane stands as it stood before.

        Args:
            accel_d: Mean specific force since, m/s^2, shape (3,).

        Returns:
            Whether it does; if not, all but the biases is lost.
        """
        kf = self._kf
        up_d = np.subtract(accel_d, kf.accel_bias_d) / kf.gravity_mps2
        leaned = np.subtract(rotation.rotate(kf.q_nd, up_d.tolist()), _VERTICAL_N)
        if float(np.linalg.norm(leaned)) > _SAME_TILT_RAD:
            self.lose()
            return False
        self._doubt_biases(*_RESUMED)
        kf.vel_n[:] = 0.0
        kf.set_block(VEL, self._tuning.zero_velocity_sigma_mps**2)
        self.mark()
        return True

    def move(self, block: ImuBlock, out: Floats) -> None:
        """Go on by samples.

        Args:
            block: The samples.
            out: Where position, velocity and attitude after each go, shape (n, 10).
        """
        unsure = block.clipped | block.bridged
        edges = [0, len(block)]
        if unsure.any():
            edges[1:1] = (np.flatnonzero(unsure[1:] != unsure[:-1]) + 1).tolist()
        for start, stop in pairwise(edges):
            noise = self._noise_unsure if unsure[start] else self._noise
            accel_d, gyro_d = block.accel_d[start:stop], block.gyro_d[start:stop]
            self._kf.run(accel_d, gyro_d, self._period_s, noise, out=out[start:stop])
        fastest_mps = math.sqrt((out[:, VEL] ** 2).sum(axis=1).max())
        self._fastest_mps = max(self._fastest_mps, fastest_mps)

    def stand(self, sample: ImuSample, *, landing: bool) -> bool:
        """Take in that the cane stands, unless what was navigated says that it does not.

        Zero velocity (Eq. 18), of the base where the IMU's height is given, and, with 15 states,
        zero rate.

        Args:
            sample: The last one.
            landing: It is the first of a stance.

        Returns:
            Whether it was taken in.
        """
        kf, p, sigma_mps = self._kf, self._params, self._tuning.zero_velocity_sigma_mps
        share_mps = p.zero_velocity_share * self._fastest_mps if landing else 0.0
        loose = self._at_rest(sample, math.hypot(sigma_mps, share_mps))
        if kf.innovation(loose).nis > self._tuning.zero_velocity_nis_max:
            return False
        turning_radps = math.dist(sample.gyro_d, kf.gyro_bias_d.tolist())
        of_height_mps = self._tuning.imu_height_sigma_m * turning_radps
        zero = loose._replace(R=isotropic(math.hypot(sigma_mps, of_height_mps)))
        if landing:
            self._land(zero)
        else:
            kf.correct(zero)
        if self._tuning.states == 15:
            # The faster it turns, the less of it is bias.
            sigma_radps = math.hypot(p.zero_rate_sigma_radps, turning_radps)
            kf.correct(zero_rate(kf, sample.gyro_d, sigma_radps))
        return True

    def unland(self, blocks: Iterable[ImuBlock]) -> None:
        """Take back the last landing: the cane was still moving.

        Args:
            blocks: The samples since, without the landing's.
        """
        before = self._before_landing
        self._kf.nominal[:], self._kf.covariance[:] = before.nominal, before.covariance
        self._fastest_mps, self._variance_factor = before.fastest_mps, before.variance_factor
        for block in blocks:
            self.move(block, np.empty((len(block), 10)))

    def mark(self) -> None:
        """Count the way from here: position is zero and known by definition."""
        self._origin_n = self.pos_n
        self._kf.pos_n[:] = 0.0
        self._kf.set_block(POS, 0.0)
        self._up_n_marked = self._up_n()

    def displacement(self) -> Displacement:
        """Return the horizontal way since the last mark (Eq. 25, without its vertical part).

        The filter's own variance counts as many times as the contacts of late have shown.
        """
        moved_n = self._moved_n()[:2]
        length_m = math.hypot(*moved_n.tolist())
        along = moved_n / length_m if length_m > 0.0 else np.array([1.0, 0.0])
        factor = max(self._variance_factor, _VARIANCE_FACTOR_MIN)
        variance = factor * float(along @ self._kf.covariance[:2, :2] @ along)
        # How much of the way rests on the IMU's height: the change of the shaft's lean.
        per_height = along @ (self._up_n() - self._up_n_marked)[:2]
        lean_sigma_m = abs(float(per_height)) * self._tuning.imu_height_sigma_m
        return Displacement(length_m, math.sqrt(max(0.0, variance)), lean_sigma_m)

    def tilt_rad(self) -> float:
        """Return the angle between shaft and vertical."""
        return rotation.tilt_rad(self._kf.q_nd)

    def _land(self, zero: Measurement) -> None:
        """Take in the first zero velocity of a stance, so that it can be taken back."""
        kf = self._kf
        self._before_landing = _State(
            kf.nominal.copy(), kf.covariance.copy(), self._fastest_mps, self._variance_factor
        )
        excess = kf.correct(zero).nis / 3.0 - self._variance_factor
        self._variance_factor += excess / _VARIANCE_FACTOR_MEMORY
        self._fastest_mps = 0.0

    def _doubt_biases(self, gyro_radps: float, accel_mps2: float) -> None:
        """Let the biases be known no better than this."""
        if self._tuning.states == 9:
            return
        P = self._kf.covariance
        for block, sigma in ((GYRO_BIAS, gyro_radps), (ACCEL_BIAS, accel_mps2)):
            missing = np.maximum(0.0, sigma**2 - P[block, block].diagonal())
            P[block, block] += np.diag(missing)

    def _at_rest(self, sample: ImuSample, sigma_mps: float) -> Measurement:
        """Return that the base stands still, however the shaft above it sways."""
        tuning = self._tuning
        if not tuning.imu_height_m:
            return zero_velocity(self._kf, sigma_mps)
        base_d = (0.0, 0.0, -tuning.imu_height_m)
        return pivot_velocity(self._kf, sample.gyro_d, base_d, sigma_mps)

    def _moved_n(self) -> Floats:
        """Return how far the base has come since the last mark."""
        leaned = self._up_n() - self._up_n_marked
        moved_n: Floats = self._kf.pos_n - self._tuning.imu_height_m * leaned
        return moved_n

    def _up_n(self) -> Floats:
        """Return the direction of the shaft in n."""
        return np.array(rotation.rotate(self._kf.q_nd, _SHAFT_D))

    def _new_rest(self, window_s: float) -> RestDetector:
        p = self._params
        return RestDetector(
            self._period_s,
            window_s=window_s,
            accel_std_max_mps2=p.rest_accel_std_max_mps2,
            gyro_std_max_radps=p.rest_gyro_std_max_radps,
            gyro_max_radps=p.rest_gyro_max_radps,
        )
