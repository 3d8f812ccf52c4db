"""The default: wheels carry the path while they roll, the filter while the walker is lifted."""

import math
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
    zero_rate,
    zero_velocity,
)
from gaitway.estimation.rotation import from_gravity, to_matrix
from gaitway_plugins.walker.blocks import Block
from gaitway_plugins.walker.fix import Fix, Rolled, pitch_of, rolled
from gaitway_plugins.walker.params import WalkerParams
from gaitway_plugins.walker.stillness import rolling_min_m
from gaitway_plugins.walker.updates import (
    heading_of,
    height,
    rolling_velocity,
    up_d,
    vertical,
    yaw_rate,
)

_GATE: Final = 30.0
"""A measurement with a larger normalised innovation squared is not believed."""
_GLIDE_MPS: Final = 0.08
"""Slower than this is no gliding, however sure the filter is."""
_SETTLED: Final = 3
"""After so many still blocks nothing more is learned of the way before."""
_GUESSED: Final = ImuNoise(0.5, 0.1, 3e-4, 2e-5)
"""Of samples that were drawn in a straight line across a gap, or cut off at a range's end."""
_ADRIFT_MPS: Final = 0.7
"""Of a velocity that nothing held for longer than a lift."""


class WheelNavigator:
    """Fifteen states around an inertial navigator, one measurement of each kind a block.

    While the wheels turn, the path is their way along the filter's heading: nothing is gained by
    passing it through the filter. In the air it is the filter's displacement since it stood, to
    which the velocity that standing showed afterwards has been applied.

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
        self._base_n = np.zeros(3)
        self._path_n = np.zeros(3)
        self._travel_m = 0.0
        self._heading_rad = 0.0
        self._rest_up_d: Floats | None = None
        self._rest_pitch_rad = 0.0
        self._free_s = 0.0
        self._calm_s = 0.0
        self._still = 0

    @property
    def gyro_bias_d(self) -> Floats:
        """What is known of the gyroscope's bias."""
        return self._kf.gyro_bias_d

    def lose(self) -> None:
        """Take velocity and tilt for unknown; the biases stay."""
        self._begun = False

    def step(self, block: Block, *, calm: bool) -> Fix:
        """Go on by a block."""
        if not self._begun:
            self._level(block)
        wheels = self._rolled(block)
        mean_vel_n = self._predict(block)
        still = calm and self._stands()
        self._calm_s = self._calm_s + block.duration_s if calm and not still else 0.0
        if still:
            still = self._stand(block)
        elif wheels.rolling:
            self._roll(block, wheels, mean_vel_n)
        else:
            self._float(block)
        return self._fix(block, wheels, still=still)

    def _rolled(self, block: Block) -> Rolled:
        yaw = up_d(self._kf).dot(block.gyro_d.mean(axis=0) - self._kf.gyro_bias_d)
        return rolled(block, float(yaw), self._params, self._least_m)

    def _level(self, block: Block) -> None:
        kf, p = self._kf, self._params
        first = not kf.covariance.any()
        if first:
            kf.set_block(GYRO_BIAS, p.gyro_bias_sigma_radps**2)
            kf.set_block(ACCEL_BIAS, p.accel_bias_sigma_mps2**2)
        self._base_n = self._path_n
        # The walker is upright unless told otherwise; a swaying start is cured by what follows.
        turn = self._heading_rad
        force = block.accel_d.mean(axis=0) - kf.accel_bias_d
        kf.q_nd = from_gravity(force.tolist()) if force.any() else kf.q_nd
        self._turn_to(turn)
        kf.vel_n[:] = 0.0
        kf.set_block(VEL, _ADRIFT_MPS**2)
        kf.set_block(ATT, np.diag([0.05**2, 0.05**2, 0.0 if first else 0.1**2]))
        kf.pos_n[:] = to_matrix(kf.q_nd) @ self._arm_d
        self._free_s = p.max_lift_s
        self._begun = True

    def _turn_to(self, heading_rad: float) -> None:
        half = 0.5 * (heading_rad - heading_of(self._kf.q_nd))
        c, s = math.cos(half), math.sin(half)
        w, x, y, z = self._kf.q_nd
        self._kf.q_nd = (c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w)

    def _predict(self, block: Block) -> Floats:
        out = np.empty((len(block.t_ns), 10))
        before = self._kf.vel_n.copy()
        noise = _GUESSED if block.bridged or block.clipped else self._noise
        self._kf.run(block.accel_d, block.gyro_d, block.period_s, noise, out=out)
        return np.asarray(out[:, 3:6].mean(axis=0) - (out[-1, 3:6] - before) / (2 * len(out)))

    def _stands(self) -> bool:
        """Return whether calm is standing and not even gliding: the filter would know.

        It is believed for the length of a lift while it sees the walker above the floor, and else
        for ``glide_s``: a hard setting down may have cost it its velocity.
        """
        kf, p = self._kf, self._params
        fast = float(np.sqrt(kf.vel_n.dot(kf.vel_n))) > _GLIDE_MPS
        if not fast or kf.innovation(zero_velocity(kf, 0.03)).nis < _GATE:
            return True
        above = float(self._path_n[2] - self._base_n[2]) > p.min_rise_m
        believed_s = p.max_lift_s if above else p.glide_s
        if (self._free_s if above else self._calm_s) < believed_s:
            return False
        # Wrong by more than it can be: what made it so must not be taken for a bias.
        kf.set_block(VEL, _ADRIFT_MPS**2)
        return True

    def _stand(self, block: Block) -> bool:
        """Tell the filter that it does not move; return whether it stands on the floor."""
        kf, p = self._kf, self._params
        kf.correct(zero_velocity(kf, p.still_speed_sigma_mps))
        kf.correct(zero_rate(kf, block.gyro_d.mean(axis=0).tolist(), p.still_rate_sigma_radps))
        if self._held():
            self._free_s += block.duration_s
            self._still = 0
            return False
        floor = height(kf, self._arm_d, 0.0, p.floor_sigma_m)
        if 0.0 < self._free_s <= p.max_lift_s and kf.innovation(floor).nis < _GATE:
            kf.correct(floor)
        self._free_s = 0.0
        self._still += 1
        self._rest_up_d = up_d(kf)
        self._rest_pitch_rad = pitch_of(to_matrix(kf.q_nd))
        return True

    def _held(self) -> bool:
        kf, p = self._kf, self._params
        up_m = float(kf.pos_n[2] - (to_matrix(kf.q_nd) @ self._arm_d)[2])
        sure_m = max(p.held_m, 4.0 * math.sqrt(kf.covariance[2, 2]))
        return 0.0 < self._free_s <= p.max_lift_s and up_m > sure_m

    def _roll(self, block: Block, wheels: Rolled, mean_vel_n: Floats) -> None:
        kf, p = self._kf, self._params
        self._free_s, self._still = 0.0, 0
        rate_d = block.gyro_d.mean(axis=0)
        speed_mps = wheels.length_m / block.duration_s
        seen = rolling_velocity(
            kf, mean_vel_n, rate_d, -self._arm_d, speed_mps, p.wheel_speed_sigma_mps
        )
        if kf.innovation(seen).nis < _GATE:
            kf.correct(seen)
        if wheels.yaw_radps is not None:
            turned = yaw_rate(kf, rate_d, wheels.yaw_radps, p.wheel_yaw_sigma_radps)
            if kf.innovation(turned).nis < _GATE / 3.0:
                kf.correct(turned)
        lean = abs(pitch_of(to_matrix(kf.q_nd)) - self._rest_pitch_rad)
        if self._rest_up_d is not None and lean < 0.5 * p.back_tips_rad:
            kf.correct(vertical(kf, self._rest_up_d, p.vertical_sigma_rad))

    def _float(self, block: Block) -> None:
        kf, p = self._kf, self._params
        self._free_s += block.duration_s
        self._still = 0
        if self._free_s > p.max_lift_s:
            # Nothing is known any more but that it does not fly away.
            kf.correct(zero_velocity(kf, _ADRIFT_MPS))

    def _anchor(self, path_n: Floats) -> None:
        """Count the filter's displacement from here, where the body's origin is."""
        self._base_n = path_n
        self._kf.pos_n[:] = to_matrix(self._kf.q_nd) @ self._arm_d
        self._kf.set_block(POS, 0.0)

    def _carry(self, wheels: Rolled, *, rolling: bool) -> None:
        """Take heading and path to the end of the block."""
        kf = self._kf
        change = (heading_of(kf.q_nd) - self._heading_rad + math.pi) % (2.0 * math.pi) - math.pi
        middle_rad = self._heading_rad + 0.5 * change
        self._heading_rad += change
        if rolling:
            self._travel_m += wheels.length_m
            way_n = np.array([math.cos(middle_rad), math.sin(middle_rad), 0.0])
            self._path_n = self._path_n + wheels.length_m * way_n
            self._anchor(self._path_n)
        else:
            self._path_n = self._base_n + kf.pos_n - to_matrix(kf.q_nd) @ self._arm_d
            if self._still >= _SETTLED:
                self._anchor(self._path_n)

    def _fix(self, block: Block, wheels: Rolled, *, still: bool) -> Fix:
        rolling = wheels.rolling and not still
        self._carry(wheels, rolling=rolling)
        kf = self._kf
        C = to_matrix(kf.q_nd)
        return Fix(
            start_ns=block.start_ns,
            t_ns=block.end_ns,
            duration_s=block.duration_s,
            still=still,
            rolling=rolling,
            speed_mps=wheels.length_m / block.duration_s,
            travel_m=self._travel_m,
            path_n=self._path_n,
            # A tilt that stays wrong moves the IMU's lever arm at both ends alike.
            path_var=np.diag(kf.covariance)[POS].copy(),
            heading_rad=self._heading_rad,
            heading_sigma_rad=math.sqrt(kf.covariance[8, 8]),
            pitch_rad=pitch_of(C),
            clipped=block.clipped,
            bridged=block.bridged,
        )
