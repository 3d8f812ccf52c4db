from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from gaitway.samples import Floats

def predict(
    nominal: Floats,
    covariance: Floats,
    accel_d: Iterable[float],
    gyro_d: Iterable[float],
    dt_s: float,
    gravity_mps2: float,
    accel_mps2_rthz: float,
    gyro_radps_rthz: float,
    accel_bias_walk_mps2_rts: float,
    gyro_bias_walk_radps_rts: float,
    /,
) -> None: ...
def run(
    nominal: Floats,
    covariance: Floats,
    accel_d: Floats,
    gyro_d: Floats,
    dt_s: float,
    gravity_mps2: float,
    accel_mps2_rthz: float,
    gyro_radps_rthz: float,
    accel_bias_walk_mps2_rts: float,
    gyro_bias_walk_radps_rts: float,
    still: NDArray[np.bool_] | None,
    imu_to_pivot_d: Iterable[float],
    sigma_mps: float,
    out: Floats | None,
    /,
) -> None: ...
def innovation(
    nominal: Floats,
    covariance: Floats,
    z: Floats,
    H: Floats,
    R: Floats,
    standardised: Floats,
    /,
) -> float: ...
def correct(
    nominal: Floats,
    covariance: Floats,
    z: Floats,
    H: Floats,
    R: Floats,
    standardised: Floats,
    /,
) -> float: ...
