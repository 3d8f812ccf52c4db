"""The filter of the ankle: inertial navigation from stance to stance.

In stance the lower leg turns about a point that stands still, so that the velocity of the IMU is
``v = w x r`` (Wu, Wang & Pottie, Eq. 5), ``r`` from that point to the IMU. The paper resets the
velocity to that; here it is a measurement with a standard deviation, which corrects position and
tilt as well, and tells by its innovation whether there was a foot on a floor at all.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import (
    ACCEL_BIAS,
    ATT,
    GYRO_BIAS,
    POS,
    VEL,
    ErrorStateFilter,
    ImuNoise,
    Innovation,
    Measurement,
    gravity,
    pivot_velocity,
    zero_rate,
)
from gaitway.estimation.rotation import Quaternion, from_gravity, rotate, tilt_rad
from gaitway_plugins.ankle.lever import Lever
from gaitway_plugins.ankle.motion import pivot_speed_mps, pivot_velocity_n
from gaitway_plugins.ankle.params import AnkleParams
from gaitway_plugins.ankle.track import Track

_STILL_MPS2: Final = 0.02
"""Of a mean specific force at rest: what a standing leg still does."""
_STILL_RADPS: Final = 1.5e-3
"""Of a mean angular rate at rest."""
_STANCE_MPS2: Final = 1.0
"""Acceleration in the quiet part of a stance."""
_DOUBT: Final = ImuNoise(accel_mps2_rthz=0.2, gyro_radps_rthz=0.1)
"""Noise of a stride that does not close: 0.05 s of samples lost in a swing turn it by 0.2 rad."""
_G: Final = 9.8


@dataclass(frozen=True, slots=True, eq=False)
class Anchor:
    """A moment on the floor.

    Attributes:
        index: Number of its sample.
        t_ns: Its host time.
        pivot_n: Where the pivot is, shape (3,).
        q_nd: Attitude.
        covariance: Of the way since the anchor before, shape (3, 3).
        heading_sigma_rad: How far the heading may have drifted since the filter started.
        doubtful: The way to it did not close and was done again with much more noise.
    """

    index: int
    t_ns: int
    pivot_n: Floats
    q_nd: Quaternion
    covariance: Floats
    heading_sigma_rad: float
    doubtful: bool = False


class Navigator:
    """Goes on from anchor to anchor.

    Args:
        params: Of the ankle.
        period_s: Of the samples.
        lever: From pivot to IMU.

    Attributes:
        kf: The filter.
        path: Position, velocity and ``q_nd`` after each sample since the anchor before, (n, 10).
        innovation: Of the last quiet part.
    """

    def __init__(self, params: AnkleParams, period_s: float, lever: Lever) -> None:
        self.kf: Final = ErrorStateFilter(states=15)
        self.path: Floats = np.zeros((0, 10))
        self.innovation = Innovation(np.zeros(3), 0.0)
        self.started = False
        self._params = params
        self._period_s = period_s
        self._lever = lever
        self._at = -1
        self._last = (-1, self.kf.nominal.copy(), self.kf.covariance.copy())
        self._noise = ImuNoise(
            params.accel_noise_mps2_rthz,
            params.gyro_noise_radps_rthz,
            params.accel_bias_walk_mps2_rts,
            params.gyro_bias_walk_radps_rts,
        )
        self.kf.set_block(GYRO_BIAS, params.gyro_bias_sigma_radps**2)
        self.kf.set_block(ACCEL_BIAS, params.accel_bias_sigma_mps2**2)

    @property
    def at(self) -> int:
        """Return the number of the last sample taken in."""
        return self._at

    def lose(self, index: int = -1) -> None:
        """Forget position, velocity and attitude; what is known of the biases stays."""
        self.started = False
        self._at = index
        self.path = np.zeros((0, 10))

    def start(self, track: Track, begin: int, end: int, *, still: bool) -> Anchor:
        """Start in a quiet part: tilt from gravity, velocity ``w x r``.

        Args:
            track: Where the samples are.
            begin: Its first sample.
            end: Its last.
            still: It is standing, not the middle of a stance.
        """
        kf, accel = self.kf, track.accel_d(begin, end + 1)
        mean = accel.mean(axis=0)
        self._at = (begin + end) // 2
        kf.pos_n[:] = 0.0
        kf.q_nd = from_gravity(np.subtract(mean, kf.accel_bias_d).tolist())
        kf.set_block(POS, 0.0)
        kf.set_block(ATT, np.diag([1.0, 1.0, 0.0]))
        sigma = math.hypot(_STILL_MPS2, float(accel.std(axis=0).max()))
        kf.correct(gravity(kf, mean.tolist(), sigma if still else math.hypot(sigma, _STANCE_MPS2)))
        self._stand_on(track.rate_at(self._at))
        self.started = True
        self.path = np.zeros((0, 10))
        if still:
            self._run(track, end, self._noise)
            self._learn_at_rest(track, begin, end)
        return self._anchor(track)

    def visit(
        self, track: Track, begin: int, end: int, valley: tuple[int, int] | None = None
    ) -> Anchor | None:
        """Take in a quiet part; None when no foot stood on a floor in it.

        Args:
            track: Where the samples are.
            begin: Its first sample.
            end: Its last.
            valley: First and last sample between two swings; None while standing.
        """
        still = valley is None
        moments = [max(begin, self._at + 1), end]
        if valley is not None:
            moments = self._moments(*self._steadiest(track, *valley))
        self._run(track, moments[0], self._noise)
        footing = self._footing(track, 1.0, still=still)
        self.innovation = self.kf.innovation(footing)
        doubtful = self.innovation.nis > self._params.gate_nis
        if doubtful:
            long = (end - begin) * self._period_s >= self._params.sure_quiet_s
            if not long or float(np.linalg.norm(footing.z)) > self._doubt_mps(track):
                return None
            self._run_again(track, begin, end)
        for moment in moments:
            self._run(track, moment, self._noise)
            self.kf.correct(self._footing(track, math.sqrt(len(moments)), still=still))
        if still:
            self._learn_at_rest(track, begin, end)
        return self._anchor(track, doubtful=doubtful)

    def _doubt_mps(self, track: Track) -> float:
        """Return how fast the pivot may seem to be in a stance that did not close.

        At a turning point of a swing it is about as fast as at its fastest.
        """
        gyro = track.gyro_d(self._at + 1 - len(self.path), self._at + 1)
        speed = pivot_speed_mps(self.path, gyro, self._lever)
        return min(self._params.doubt_mps, self._params.doubt_share * float(speed.max(initial=0.0)))

    def _run_again(self, track: Track, begin: int, end: int) -> None:
        """Go again from the anchor before, taking in that something happened on the way.

        Samples were lost unsaid, a range was exceeded, the strap slipped: tilt and velocity are
        less certain than the sensor's noise makes them. Gravity gives the tilt back, roughly.
        """
        index, nominal, covariance = self._last
        until, self._at, self.path = self._at, index, np.zeros((0, 10))
        self.kf.nominal[:] = nominal
        self.kf.covariance[:] = covariance
        self._run(track, until, _DOUBT)
        accel = track.accel_d(begin, end + 1)
        sigma = math.hypot(_STANCE_MPS2, float(accel.std(axis=0).max()))
        self.kf.correct(gravity(self.kf, accel.mean(axis=0).tolist(), sigma))

    def _steadiest(self, track: Track, begin: int, end: int) -> tuple[int, int]:
        """Return where the pivot is least accelerated: the foot is flat before its heel rises.

        The rate of the leg alone doesn't tell: it may well be least while the heel rises.
        """
        begin = max(begin, self._at + 1)
        span = max(2, round(self._params.stance_span_s / self._period_s))
        if end - begin <= span:
            return begin, end
        gained = self._gained_mps(track, begin, end, span)
        best = float(gained.min())
        fit = np.hypot(best, self._params.stance_velocity_sigma_mps) >= gained
        first = last = int(gained.argmin())
        while first > 0 and fit[first - 1]:
            first -= 1
        while last + 1 < len(fit) and fit[last + 1]:
            last += 1
        return begin + first, begin + last + span

    def _gained_mps(self, track: Track, begin: int, end: int, span: int) -> Floats:
        """Return how much velocity the pivot gains in each span; the filter is left as it is."""
        kf = self.kf
        nominal, covariance = kf.nominal.copy(), kf.covariance.copy()
        accel, gyro = track.accel_d(self._at + 1, end + 1), track.gyro_d(self._at + 1, end + 1)
        path = np.zeros((len(accel), 10))
        kf.run(accel, gyro, self._period_s, self._noise, out=path)
        kf.nominal[:], kf.covariance[:] = nominal, covariance
        pivot = pivot_velocity_n(path, gyro - kf.gyro_bias_d, self._lever)[begin - end - 1 :]
        return np.asarray(np.linalg.norm(pivot[span:] - pivot[:-span], axis=1))

    def _moments(self, begin: int, end: int) -> list[int]:
        span = min(end - begin, round(self._params.stance_span_s / self._period_s))
        first = max((begin + end - span) // 2, self._at + 1)
        last = max(first, (begin + end + span) // 2)
        count = min(self._params.stance_samples, last - first + 1)
        return [round(m) for m in np.linspace(first, last, count)]

    def _run(self, track: Track, index: int, noise: ImuNoise) -> None:
        if index <= self._at:
            return
        accel, gyro = track.accel_d(self._at + 1, index + 1), track.gyro_d(self._at + 1, index + 1)
        out = np.zeros((len(accel), 10))
        self.kf.run(accel, gyro, self._period_s, noise, out=out)
        self.path = np.concatenate([self.path, out])
        self._at = index

    def _footing(self, track: Track, scale: float, *, still: bool) -> Measurement:
        """Return that the pivot stands still; less surely across the floor than up and down."""
        p, rate_d = self._params, track.rate_at(self._at)
        lever_mps = self._lever.velocity_sigma_mps(rate_d)
        across_mps = p.standing_velocity_sigma_mps if still else p.stance_velocity_sigma_mps
        up_mps = p.standing_velocity_sigma_mps if still else p.stance_vertical_sigma_mps
        across = (scale * math.hypot(across_mps, lever_mps)) ** 2
        up = (scale * math.hypot(up_mps, 0.5 * lever_mps)) ** 2
        z, H, _ = pivot_velocity(self.kf, rate_d, self._lever.imu_to_pivot_d, 1.0)
        return Measurement(z, H, np.diag([across, across, up]))

    def _stand_on(self, rate_d: tuple[float, float, float]) -> None:
        kf, p = self.kf, self._params
        arm_d = np.cross(np.subtract(rate_d, kf.gyro_bias_d), self._lever.pivot_to_imu_d)
        kf.vel_n[:] = rotate(kf.q_nd, arm_d.tolist())
        sigma = math.hypot(p.stance_velocity_sigma_mps, self._lever.velocity_sigma_mps(rate_d))
        kf.set_block(VEL, sigma**2)

    def _learn_at_rest(self, track: Track, begin: int, end: int) -> None:
        """Take in what standing says of gravity and of the gyroscope's bias.

        A person sways: what the mean is worth goes by how much the readings vary, and how far the
        leg turned meanwhile.
        """
        kf = self.kf
        accel, gyro = track.accel_d(begin, end + 1), track.gyro_d(begin, end + 1)
        mean = gyro.mean(axis=0)
        turning_radps = float(np.linalg.norm(mean - kf.gyro_bias_d))
        sway_radps = 0.5 * float(gyro.std(axis=0).max())
        bias = zero_rate(
            kf, mean.tolist(), math.hypot(_STILL_RADPS, sway_radps, 0.3 * turning_radps)
        )
        if kf.innovation(bias).nis < self._params.gate_nis:
            kf.correct(bias)
        turned_rad = 0.5 * len(gyro) * self._period_s * turning_radps
        spread = 0.3 * float(accel.std(axis=0).max())
        sigma = math.hypot(_STILL_MPS2, spread, _G * turned_rad)
        kf.correct(gravity(kf, accel.mean(axis=0).tolist(), sigma))

    def _anchor(self, track: Track, *, doubtful: bool = False) -> Anchor:
        kf = self.kf
        pivot_n = kf.pos_n + rotate(kf.q_nd, self._lever.imu_to_pivot_d)
        heading = float(kf.covariance[ATT, ATT][2, 2])
        anchor = Anchor(
            self._at,
            track.t_ns(self._at),
            pivot_n,
            kf.q_nd,
            kf.covariance[POS, POS].copy(),
            math.sqrt(heading),
            doubtful,
        )
        kf.set_block(POS, 0.0)
        self._last = (self._at, kf.nominal.copy(), kf.covariance.copy())
        return anchor

    def leaning_rad(self) -> float:
        """Return how far the leg is from upright."""
        return tilt_rad(self.kf.q_nd)

    def take_path(self) -> Floats:
        """Return the path since the anchor before, and begin the next one."""
        path, self.path = self.path, np.zeros((0, 10))
        return path

    def know_biases_of(self, other: "Navigator", gap_s: float) -> None:
        """Take over what another one knows of the sensor, a while ago."""
        self.kf.gyro_bias_d[:] = other.kf.gyro_bias_d
        self.kf.accel_bias_d[:] = other.kf.accel_bias_d
        walks = (self._params.gyro_bias_walk_radps_rts, self._params.accel_bias_walk_mps2_rts)
        for block, walk in zip((GYRO_BIAS, ACCEL_BIAS), walks, strict=True):
            known = other.kf.covariance[block, block]
            self.kf.set_block(block, known + np.eye(3) * walk**2 * gap_s)
