"""The published method: one filter for everything, corrected at every sample.

Doan & Pham (2019), Eqs. 5-38 with the errata of the plugin's README. Zero velocity by Eq. 10 as
printed, which looks at differences of the specific force alone; positions from the filter alone.
"""

import math
from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import (
    ACCEL_BIAS,
    ATT,
    GYRO_BIAS,
    VEL,
    ErrorStateFilter,
    ImuNoise,
    zero_velocity,
)
from gaitway.estimation.rotation import from_gravity, to_matrix
from gaitway_plugins.walker.blocks import Block
from gaitway_plugins.walker.fix import Fix, pitch_of
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.stillness import rolling_min_m
from gaitway_plugins.walker.updates import heading, heading_of, height, position, up_d, vertical

_RATE_MAX_RADPS: Final = 0.1
"""The paper's B_g; it gives no value."""
_STEP_MAX_MPS2: Final = 0.3
"""The paper's B_a; it gives no value."""
_WINDOW_S: Final = 0.2
"""The paper's N_g and N_a; it gives no value."""
_POSITION_SIGMA_M: Final = 0.002
_YAW_SIGMA_RAD: Final = 0.003


class PaperNavigator:
    """The paper's indirect filter with its four updates.

    Args:
        params: Of the walker.
    """

    def __init__(self, params: WalkerParams) -> None:
        self._params = params
        self._arm_d: Final = np.array(params.imu_position_m)
        self._least_m: Final = rolling_min_m(params)
        self._noise: Final = ImuNoise(
            params.accel_noise_mps2_rthz, params.gyro_noise_radps_rthz, 3e-4, 2e-5
        )
        self._kf = ErrorStateFilter()
        self._begun = False
        self._rest_up_d = np.array([0.0, 0.0, 1.0])
        self._quiet = 0
        self._force: Floats | None = None
        self._travel_m = 0.0
        self._heading_rad = 0.0
        self._path_n = np.zeros(3)

    @property
    def gyro_bias_d(self) -> Floats:
        """What is known of the gyroscope's bias."""
        return self._kf.gyro_bias_d

    def lose(self) -> None:
        """Begin anew at the next block."""
        self._begun = False

    def step(self, block: Block, *, calm: bool) -> Fix:
        """Go on by a block, a sample at a time; the plugin's own test of stillness is not used."""
        del calm
        if not self._begun:
            self._begin(block)
        wheels_m = block.wheels_m.sum(axis=0)
        rolling = bool(np.abs(wheels_m).max() > self._least_m)
        still = False
        for row in range(len(block.t_ns)):
            still = self._sample(block, row, rolling=rolling)
        return self._fix(block, still=still and not rolling, rolling=rolling)

    def _begin(self, block: Block) -> None:
        kf, p = self._kf, self._params
        force = block.accel_d.mean(axis=0)
        kf.q_nd = from_gravity(force.tolist())
        self._rest_up_d = up_d(kf)
        kf.gyro_bias_d[:] = block.gyro_d.mean(axis=0)
        kf.vel_n[:] = 0.0
        kf.pos_n[:] = self._path_n + to_matrix(kf.q_nd) @ self._arm_d
        kf.covariance[:] = 0.0
        kf.set_block(VEL, 1e-4)
        kf.set_block(ATT, np.diag([1e-4, 1e-4, 0.0]))
        kf.set_block(GYRO_BIAS, p.gyro_bias_sigma_radps**2)
        kf.set_block(ACCEL_BIAS, p.accel_bias_sigma_mps2**2)
        self._begun = True

    def _sample(self, block: Block, row: int, *, rolling: bool) -> bool:
        kf, p = self._kf, self._params
        before_n, before_q = kf.pos_n.copy(), kf.q_nd
        accel_d, gyro_d = block.accel_d[row], block.gyro_d[row]
        kf.predict(accel_d.tolist(), gyro_d.tolist(), block.period_s, self._noise)
        still = self._zero_velocity(accel_d, gyro_d, block.period_s) and not rolling
        if still:
            # Eq. 11, the floor's height in the place of the IMU's.
            kf.correct(zero_velocity(kf, p.still_speed_sigma_mps))
            kf.correct(height(kf, self._arm_d, 0.0, p.floor_sigma_m))
        elif rolling:
            left_m, right_m = block.wheels_m[row].tolist()
            turn_rad = (right_m - left_m) / p.track_m
            lean = pitch_of(to_matrix(kf.q_nd))
            if abs(lean) < 0.5 * p.back_tips_rad:
                kf.correct(vertical(kf, self._rest_up_d, p.vertical_sigma_rad))
            kf.correct(heading(kf, heading_of(before_q) + turn_rad, _YAW_SIGMA_RAD))
            self._carry(before_n, before_q, 0.5 * (left_m + right_m), turn_rad)
        return still

    def _carry(
        self, before_n: Floats, before_q: tuple[float, ...], length_m: float, turn_rad: float
    ) -> None:
        """Tell the filter where the wheels took the IMU (Eqs. 20-24, 32-38)."""
        C = to_matrix(before_q)
        c, s = math.cos(turn_rad), math.sin(turn_rad)
        turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        way_n = C @ turned @ np.array([length_m, 0.0, 0.0])
        pos_n = before_n + way_n + C @ (turned @ self._arm_d - self._arm_d)
        self._kf.correct(position(self._kf, pos_n, _POSITION_SIGMA_M))

    def _zero_velocity(self, accel_d: Floats, gyro_d: Floats, period_s: float) -> bool:
        """Return whether Eq. 10 holds, looking back over the window."""
        step = np.zeros(3) if self._force is None else accel_d - self._force
        self._force = accel_d
        rate = gyro_d - self._kf.gyro_bias_d
        quiet = rate.dot(rate) <= _RATE_MAX_RADPS**2 and step.dot(step) <= _STEP_MAX_MPS2**2
        self._quiet = self._quiet + 1 if quiet else 0
        return self._quiet * period_s >= _WINDOW_S

    def _fix(self, block: Block, *, still: bool, rolling: bool) -> Fix:
        kf = self._kf
        C = to_matrix(kf.q_nd)
        change = (heading_of(kf.q_nd) - self._heading_rad + math.pi) % (2.0 * math.pi) - math.pi
        self._heading_rad += change
        path_n = kf.pos_n - C @ self._arm_d
        way_n = path_n - self._path_n
        self._path_n = path_n
        speed_mps = 0.5 * float(block.wheels_m.sum()) / block.duration_s
        if rolling:
            self._travel_m += float(
                way_n[:2] @ (math.cos(self._heading_rad), math.sin(self._heading_rad))
            )
        return Fix(
            start_ns=block.start_ns,
            t_ns=block.end_ns,
            duration_s=block.duration_s,
            still=still,
            rolling=rolling,
            speed_mps=speed_mps,
            travel_m=self._travel_m,
            path_n=path_n,
            path_var=np.full(3, 0.02**2),
            heading_rad=self._heading_rad,
            heading_sigma_rad=math.sqrt(kf.covariance[8, 8]),
            pitch_rad=pitch_of(C),
            clipped=block.clipped,
            bridged=block.bridged,
        )
