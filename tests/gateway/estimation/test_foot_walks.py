"""The toolkit on real people's feet: the same mathematics as a cane, with other thresholds.

The thresholds are those of Jimenez et al. (2010), 9 < |f| < 11 m/s^2 and |w| < 50 deg/s; nothing
here was chosen on these walks.
"""

from math import hypot, radians
from pathlib import Path

import numpy as np
import pytest

from gaitway.estimation import (
    POS,
    ErrorStateFilter,
    ImuNoise,
    RestDetector,
    StanceDetector,
    align_at_rest,
    zero_velocity,
)

FOLDER = Path(__file__).parent / "foot_walks"
PERIOD_S = 0.005


def stride_lengths(accel, gyro, states):
    """Return the horizontal way from each stance to the next."""
    kf = ErrorStateFilter(states=states)
    noise = ImuNoise(0.01, 1e-3, 1e-4, 1e-5)
    rests = RestDetector(
        PERIOD_S,
        window_s=0.4,
        accel_std_max_mps2=0.15,
        gyro_std_max_radps=0.08,
        gyro_max_radps=0.1,
    )
    stance = StanceDetector(
        PERIOD_S, window_s=0.1, accel_max_mps2=1.0, gyro_max_radps=radians(50.0)
    )
    aligned = stood = False
    lengths = []
    samples = list(zip(map(tuple, accel.tolist()), map(tuple, gyro.tolist()), strict=True))
    for newest, sample in enumerate(samples):
        standing = stance.push(*sample)
        if newest < stance.half:
            continue
        force_d, rate_d = samples[newest - stance.half]
        if not aligned:
            if rest := rests.push(force_d, rate_d):
                align_at_rest(
                    kf,
                    rest,
                    accel_bias_sigma_mps2=0.05,
                    gyro_bias_sigma_radps=3e-3,
                    velocity_sigma_mps=0.01,
                )
                aligned = True
            continue
        kf.predict(force_d, rate_d, PERIOD_S, noise)
        if standing:
            kf.correct(zero_velocity(kf, 0.02))
        elif stood:
            lengths.append(hypot(*kf.pos_n[:2].tolist()))
            kf.pos_n[:] = 0.0
            kf.set_block(POS, 0.0)
        stood = standing
    lengths.append(hypot(*kf.pos_n[:2].tolist()))
    return np.array([length for length in lengths if length > 0.3])


@pytest.mark.parametrize("states", [9, 15])
@pytest.mark.parametrize(("walk", "within"), [("hallway_31", 0.03), ("hallway_33", 0.015)])
def test_a_real_walk_has_its_strides_and_its_distance(walk, within, states):
    data = np.load(FOLDER / f"{walk}.npz")
    found = stride_lengths(data["accel"] * 1e-3, data["gyro"] * 1e-4, states)
    true = data["stride_length_m"]
    assert len(found) == len(true)
    assert found.sum() == pytest.approx(true.sum(), rel=within)
    assert np.median(np.abs(found - true)) < 0.04
