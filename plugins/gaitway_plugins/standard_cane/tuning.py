"""What the two methods of the standard cane differ in, as numbers."""

import math
from dataclasses import dataclass
from typing import Final, Self

from gaitway.estimation import ImuNoise
from gaitway_plugins.standard_cane.params import StandardCaneParams

PUBLISHED_NOISE: Final = ImuNoise(
    accel_mps2_rthz=math.sqrt(0.0005), gyro_radps_rthz=math.sqrt(0.0001)
)
"""r_a and r_g of Dang & Suh (2018), Eq. 33, which their Section 3.2 uses as densities."""
PUBLISHED_PIVOT_MPS_RTHZ: Final = math.sqrt(0.001 * 0.01)
"""r_u2 of Eq. 33, a variance per sample at 100 Hz."""
PUBLISHED_WINDOW_S: Final = 0.25
"""N_a of Eq. 33."""
PUBLISHED_FORCE_MAX_MPS2: Final = 0.2
"""B_a of Eq. 33."""


@dataclass(frozen=True, slots=True)
class Tuning:
    """Settings of the filter and of the contact test.

    Attributes:
        states: Of the error-state filter.
        noise: Of the sensor.
        contact_window_s: All of it has to pass.
        contact_force_max_mps2: Deviation of the tip's specific force from gravity.
        contact_nis_max: Beyond it the tip is not taken for standing.
        pivot_every: Samples from one velocity of the pendulum to the next within a stance.
        pivot_sigma_mps: Of one of them.
    """

    states: int
    noise: ImuNoise
    contact_window_s: float
    contact_force_max_mps2: float
    contact_nis_max: float
    pivot_every: int
    pivot_sigma_mps: float

    @classmethod
    def of(cls, params: StandardCaneParams, period_s: float) -> Self:
        """Return the settings of the method that the parameters name."""
        if params.method == "published":
            return cls(
                states=9,
                noise=PUBLISHED_NOISE,
                contact_window_s=PUBLISHED_WINDOW_S,
                contact_force_max_mps2=PUBLISHED_FORCE_MAX_MPS2,
                contact_nis_max=math.inf,
                pivot_every=1,
                pivot_sigma_mps=PUBLISHED_PIVOT_MPS_RTHZ / math.sqrt(period_s),
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
            contact_window_s=params.contact_window_s,
            contact_force_max_mps2=params.contact_force_max_mps2,
            contact_nis_max=params.contact_nis_max,
            pivot_every=max(1, round(params.pivot_every_s / period_s)),
            pivot_sigma_mps=params.pivot_sigma_mps,
        )
