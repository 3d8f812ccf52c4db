"""Where the tip of the cane is between one stance and the next, and how well that is known."""

import math
from collections.abc import Iterable, Sequence
from typing import Final, NamedTuple

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import (
    ACCEL_BIAS,
    ATT,
    GYRO_BIAS,
    POS,
    VEL,
    ErrorStateFilter,
    ImuSample,
    Measurement,
    gravity,
    pivot_velocity,
    rotation,
)
from gaitway_plugins.standard_cane.params import StandardCaneParams
from gaitway_plugins.standard_cane.tip import TipRow
from gaitway_plugins.standard_cane.tuning import Tuning

_UNSURE: Final = 200.0
"""Noise of a clipped or bridged sample, relative to a measured one."""
_LOST: Final = (3e-3, 0.03)
"""How far gyroscope (rad/s) and accelerometer bias (m/s^2) may be off when all was lost."""
_IMPOSSIBLE: Final = 5.0
"""A bias so many standard deviations large is no bias: it is found anew."""
_STILL_RADPS: Final = 0.002
"""How far from the gyroscope's bias the mean rate of a cane in a still hand is, at least."""
_LEVEL_MPS2: Final = 0.03
"""How far the mean specific force of the tip is from gravity although the tip stands."""
_MEMORY: Final = 10.0
"""Contacts over which the variance they show, relative to the filter's own, is averaged."""
_FACTOR_MIN: Final = 0.2
"""However well contacts agree, they don't show all of the error."""


class Way(NamedTuple):
    """How far the tip came from one stance to another.

    Attributes:
        length_m: Horizontally.
        sigma_m: Standard deviation of it.
        rise_m: Upwards.
        rise_sigma_m: Standard deviation of it.
        clearance_m: How high the tip was above the higher of its two ends, at most.
        swung: How far the tip swung ahead of the hand: by so much times the length of a cane.
    """

    length_m: float
    sigma_m: float
    rise_m: float
    rise_sigma_m: float
    clearance_m: float
    swung: float


class Navigator:
    """The error-state filter of a standard cane with the pendulum velocities of its stances.

    Dang & Suh (2018), Eqs. 2-10 and 24, with 15 states where the method says so. Positions are
    those of the tip (Eq. 19), so that leaning over is no way.

    Args:
        params: Of the cane.
        imu_to_tip_d: The paper's p1, metres, in d.
        period_s: Of the samples.

    Attributes:
        aligned: Tilt and velocity are known; when not, only ``start`` makes sense.
    """

    def __init__(self, params: StandardCaneParams, imu_to_tip_d: Floats, period_s: float) -> None:
        self._params = params
        self._lever_d = imu_to_tip_d
        self._lever = tuple(imu_to_tip_d.tolist())
        self._period_s = period_s
        self._tuning = tuning = Tuning.of(params, period_s)
        self._kf = ErrorStateFilter(states=tuning.states)
        self._noise = tuning.noise
        self._noise_unsure = tuning.noise.scaled(_UNSURE)
        self._biases_known = False
        self._origin_n = np.zeros(3)
        self._lever_m = float(np.linalg.norm(imu_to_tip_d))
        self._pointed_n = np.zeros(3)
        self._pointing_n = np.zeros(3)
        self._highest_m = 0.0
        self._fastest_mps = 0.0
        self._factor = 1.0
        self._before_landing = (self._kf.nominal, self._kf.covariance, 0.0, 1.0)
        self.aligned = False

    @property
    def biases_known(self) -> bool:
        """Whether a stance was seen before, so that a shorter one is enough to start from."""
        return self._biases_known

    @property
    def tip_n(self) -> Floats:
        """Position of the tip in n since the first start, metres, shape (3,).

        Where navigation was lost it goes on from the stance before.
        """
        return self._origin_n + self._since_mark_n()

    def tip_velocity_n(self, row: TipRow) -> Floats:
        """Return how fast the tip moves, m/s, shape (3,)."""
        rate_d = row.rate_d - self._kf.gyro_bias_d
        turning_n = rotation.rotate(self._kf.q_nd, rotation.cross(rate_d.tolist(), self._lever))
        velocity_n: Floats = self._kf.vel_n + turning_n
        return velocity_n

    def force_n(self, row: TipRow) -> Floats:
        """Return the specific force of the tip in n, m/s^2, shape (3,)."""
        return np.array(rotation.rotate(self._kf.q_nd, row.force_d.tolist()))

    def tilt_rad(self) -> float:
        """Return the angle between shaft and vertical."""
        return rotation.tilt_rad(self._kf.q_nd)

    def start(self, rows: Sequence[TipRow]) -> bool:
        """Start from a stance, the cane still or swaying about its tip.

        Args:
            rows: Of the stance, in which the tip passed the test of forces.

        Returns:
            Whether it was one: a cane that stands leans little, and its tip feels gravity alone.
        """
        kf, p = self._kf, self._params
        gyro_d = np.array([row.sample.gyro_d for row in rows])
        self._guess_gyro_bias(gyro_d)
        turned = self._turned(gyro_d)
        forces = np.array(
            [rotation.rotate(q, row.force_d.tolist()) for q, row in zip(turned, rows, strict=True)]
        )
        mean = forces.mean(axis=0)
        spread_mps2 = float(np.sqrt(forces.var(axis=0).sum()))
        lean_rad = math.acos(min(1.0, max(-1.0, mean[2] / float(np.linalg.norm(mean)))))
        if spread_mps2 > p.start_spread_max_mps2 or lean_rad > p.start_tilt_max_rad:
            return False
        kf.q_nd = rotation.from_gravity(np.subtract(mean, kf.accel_bias_d).tolist())
        kf.pos_n[:] = -self._lever_n()
        kf.set_block(POS, 0.0)
        kf.set_block(VEL, 1.0)
        kf.set_block(ATT, np.diag([1.0, 1.0, 0.0]))
        sigma_mps2 = math.hypot(_LEVEL_MPS2, spread_mps2 / math.sqrt(len(rows)))
        if self._tuning.states == 9:
            sigma_mps2 = math.hypot(sigma_mps2, p.accel_bias_sigma_mps2)
        kf.correct(gravity(kf, mean.tolist(), sigma_mps2))
        kf.vel_n[:] += -self.tip_velocity_n(rows[-1])
        kf.correct(self._standing(rows[-1], self._tuning.pivot_sigma_mps))
        self._fastest_mps = 0.0
        self.aligned = self._biases_known = True
        self.mark()
        return True

    def lose(self) -> None:
        """Forget tilt, velocity and position; the biases stay known, but less."""
        self.aligned = False
        kf, p = self._kf, self._params
        if self._tuning.states == 9:
            return
        P = kf.covariance
        for block, sigma in ((GYRO_BIAS, _LOST[0]), (ACCEL_BIAS, _LOST[1])):
            missing = np.maximum(0.0, sigma**2 - P[block, block].diagonal())
            P[block, block] += np.diag(missing)
        spoilt = np.abs(kf.accel_bias_d).max() > _IMPOSSIBLE * p.accel_bias_sigma_mps2
        if spoilt or np.abs(kf.gyro_bias_d).max() > _IMPOSSIBLE * p.gyro_bias_sigma_radps:
            self._biases_known = False

    def move(self, row: TipRow) -> None:
        """Go on by a sample."""
        sample: ImuSample = row.sample
        noise = self._noise_unsure if sample.clipped or sample.bridged else self._noise
        self._kf.predict(sample.accel_d, sample.gyro_d, self._period_s, noise)
        _, _, z, vx, vy, vz, qw, qx, qy, qz = self._kf.nominal[:10].tolist()
        self._fastest_mps = max(self._fastest_mps, math.sqrt(vx * vx + vy * vy + vz * vz))
        z += rotation.rotate((qw, qx, qy, qz), self._lever)[2]
        self._highest_m = max(self._highest_m, z)

    def stand(self, row: TipRow, *, landing: bool) -> bool:
        """Take in that the tip stands, unless what was navigated says that it does not (Eq. 24).

        Args:
            row: The last one.
            landing: It is the first of a stance.

        Returns:
            Whether it was taken in.
        """
        kf, sigma_mps = self._kf, self._tuning.pivot_sigma_mps
        share_mps = self._params.contact_share * self._fastest_mps if landing else 0.0
        loose = self._standing(row, math.hypot(2.0 * sigma_mps, share_mps))
        if kf.innovation(loose).nis > self._tuning.contact_nis_max:
            return False
        if landing:
            self._before_landing = (
                kf.nominal.copy(), kf.covariance.copy(), self._fastest_mps, self._factor
            )  # fmt: skip
        nis = kf.correct(self._standing(row, sigma_mps)).nis
        if landing:
            self._factor += (nis / 3.0 - self._factor) / _MEMORY
            self._fastest_mps = 0.0
            self._pointing_n = self._lever_n() / self._lever_m
        return True

    def unland(self, rows: Iterable[TipRow]) -> None:
        """Take back the last landing: the tip was still moving.

        Args:
            rows: Those since, without the landing's.
        """
        nominal, covariance, self._fastest_mps, self._factor = self._before_landing
        self._kf.nominal[:], self._kf.covariance[:] = nominal, covariance
        for row in rows:
            self.move(row)

    def on_floor(self) -> bool:
        """Take in that the tip is as high as where it was lifted (Eqs. 29-30), if it may be.

        Returns:
            Whether it was taken in; if not, there is a step.
        """
        rise_m = float(self._since_mark_n()[2])
        if not self._params.level_floor or abs(rise_m) > self._params.max_unevenness_m:
            return False
        R = np.array([[self._params.floor_sigma_m**2]])
        self._kf.correct(Measurement(np.array([-rise_m]), self._tip_jacobian()[2:], R))
        return True

    def mark(self) -> None:
        """Count the way from here: the position of the tip is zero and known by definition."""
        kf = self._kf
        self._origin_n = self.tip_n
        lever_n = self._lever_n()
        self._pointed_n = lever_n / self._lever_m
        self._highest_m = 0.0
        kf.pos_n[:] = -lever_n
        P = np.triu(kf.covariance) + np.triu(kf.covariance, 1).T
        turned = rotation.skew(lever_n.tolist())
        P[POS, :] = turned @ P[ATT, :]
        P[:, POS] = P[POS, :].T
        P[POS, POS] = turned @ P[ATT, ATT] @ turned.T
        kf.covariance[:] = P

    def way(self) -> Way:
        """Return the way of the tip since the last mark (Eq. 25 at the tip)."""
        moved_n = self._since_mark_n()
        length_m = math.hypot(*moved_n[:2].tolist())
        along = np.array([*(moved_n[:2] / length_m), 0.0]) if length_m else np.array([1.0, 0, 0])
        P = np.triu(self._kf.covariance) + np.triu(self._kf.covariance, 1).T
        H = self._tip_jacobian()
        factor = max(self._factor, _FACTOR_MIN)
        S = factor * (H @ P @ H.T)
        sigma_m = math.sqrt(max(0.0, float(along @ S @ along)))
        rise_sigma_m = math.sqrt(max(0.0, float(S[2, 2])))
        swung = float(along @ (self._pointing_n - self._pointed_n))
        clearance_m = self._highest_m - max(0.0, float(moved_n[2]))
        return Way(length_m, sigma_m, float(moved_n[2]), rise_sigma_m, clearance_m, swung)

    def _standing(self, row: TipRow, sigma_mps: float) -> Measurement:
        return pivot_velocity(self._kf, row.rate_d.tolist(), self._lever, sigma_mps)

    def _guess_gyro_bias(self, gyro_d: Floats) -> None:
        """Take the mean rate for the bias, as far as a hand may not have turned the cane."""
        if self._biases_known:
            return
        kf, p = self._kf, self._params
        kf.accel_bias_d[:] = 0.0
        prior = p.gyro_bias_sigma_radps**2
        swayed = _STILL_RADPS**2 + 4.0 * gyro_d.var(axis=0)
        kf.gyro_bias_d[:] = gyro_d.mean(axis=0) * prior / (prior + swayed)
        if self._tuning.states == 15:
            kf.set_block(GYRO_BIAS, np.diag(prior * swayed / (prior + swayed)))
            kf.set_block(ACCEL_BIAS, p.accel_bias_sigma_mps2**2)

    def _turned(self, gyro_d: Floats) -> list[rotation.Quaternion]:
        """Return for each sample the rotation from d then to d at the last one."""
        q = rotation.IDENTITY
        turned = [q]
        for rate_d in ((gyro_d[:0:-1] - self._kf.gyro_bias_d) * self._period_s).tolist():
            q = rotation.multiply(q, rotation.from_rotation_vector([-w for w in rate_d]))
            turned.append(q)
        return turned[::-1]

    def _lever_n(self) -> Floats:
        """Return from the IMU to the tip in n."""
        return np.array(rotation.rotate(self._kf.q_nd, self._lever))

    def _since_mark_n(self) -> Floats:
        """Return how far the tip has come since the last mark."""
        moved_n: Floats = self._kf.pos_n + self._lever_n()
        return moved_n

    def _tip_jacobian(self) -> Floats:
        """Return how the error state shows in the position of the tip (Eq. 30), shape (3, n)."""
        H = np.zeros((3, self._tuning.states))
        H[:, POS] = np.eye(3)
        H[:, ATT] = -rotation.skew(self._lever_n().tolist())
        return H
