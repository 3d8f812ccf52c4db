"""What the two methods of the quad cane differ in, as numbers."""

import math
from dataclasses import dataclass
from typing import Final, Self

from gaitway.estimation import ImuNoise
from gaitway_plugins.quad_cane.params import QuadCaneParams

PUBLISHED_NOISE: Final = ImuNoise(
    accel_mps2_rthz=math.sqrt(0.0005), gyro_radps_rthz=math.sqrt(0.0001)
)
"""r_a and r_g of Dang & Suh (2018), Eq. 31, which their Section 3.2 uses as densities."""
PUBLISHED_ZERO_VELOCITY_MPS_RTHZ: Final = math.sqrt(0.001 * 0.01)
"""r_u of Eq. 31, a variance per sample at 100 Hz."""


@dataclass(frozen=True, slots=True)
class Tuning:
    """Settings of the filter.

    Attributes:
        states: Of the error-state filter.
        noise: Of the sensor.
        zero_velocity_every: Samples from one zero velocity to the next within a stance.
        zero_velocity_sigma_mps: Of one of them.
        zero_velocity_nis_max: Beyond it the cane is not taken for standing.
        imu_height_m: The IMU above the base, along the shaft.
        imu_height_sigma_m: Its standard deviation.
        tilt_from_gravity: The walking test takes the tilt from each specific force (Eq. 13) and not
            from the navigated attitude.
    """

    states: int
    noise: ImuNoise
    zero_velocity_every: int
    zero_velocity_sigma_mps: float
    zero_velocity_nis_max: float
    imu_height_m: float
    imu_height_sigma_m: float
    tilt_from_gravity: bool

    @classmethod
    def of(cls, params: QuadCaneParams, period_s: float) -> Self:
        """Return the settings of the method that the parameters name."""
        if params.method == "published":
            return cls(
                states=9,
                noise=PUBLISHED_NOISE,
                zero_velocity_every=1,
                zero_velocity_sigma_mps=PUBLISHED_ZERO_VELOCITY_MPS_RTHZ / math.sqrt(period_s),
                zero_velocity_nis_max=math.inf,
                imu_height_m=0.0,
                imu_height_sigma_m=0.0,
                tilt_from_gravity=True,
            )
        noise = ImuNoise(
            accel_mps2_rthz=params.accel_noise_mps2_rthz,
            gyro_radps_rthz=params.gyro_noise_radps_rthz,
            accel_bias_walk_mps2_rts=params.accel_bias_walk_mps2_rts,
            gyro_bias_walk_radps_rts=params.gyro_bias_walk_radps_rts,
        )
        return cls(
            states=15,
            noise=noise,
            zero_velocity_every=max(1, round(params.zero_velocity_every_s / period_s)),
            zero_velocity_sigma_mps=params.zero_velocity_sigma_mps,
            zero_velocity_nis_max=params.zero_velocity_nis_max,
            imu_height_m=params.imu_height_m,
            imu_height_sigma_m=params.imu_height_sigma_m,
            tilt_from_gravity=False,
        )
