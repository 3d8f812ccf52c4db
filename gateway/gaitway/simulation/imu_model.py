"""What keeps an IMU from being ideal: noise, bias, scale, alignment, range and resolution."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt
from typing import Final, Self

import numpy as np

from gaitway.samples import Floats
from gaitway.simulation.motion import GRAVITY_MPS2, ImuRun

_DEG: Final = pi / 180.0
_G: Final = GRAVITY_MPS2


@dataclass(frozen=True, slots=True)
class Triad:
    """The kind of a three-axis sensor, in the units of what it measures (SI).

    Attributes:
        noise_rthz: White noise: standard deviation of its integral over one second, so that a mean
            over ``T`` seconds has ``noise_rthz / sqrt(T)``. Data sheets call it noise density.
        bias: Standard deviation of the bias at turn-on.
        bias_walk_rts: Standard deviation of the bias' change over one second.
        scale: Standard deviation of the relative scale error of an axis.
        misalignment_rad: Standard deviation of an axis' tilt towards each of the other two.
        full_scale: Beyond it a reading stays at it and its clip flag is set.
        resolution: One step of the converter.
    """

    noise_rthz: float
    bias: float
    bias_walk_rts: float
    scale: float
    misalignment_rad: float
    full_scale: float
    resolution: float


@dataclass(frozen=True, slots=True)
class ImuModel:
    """The kind of an IMU. The default is the class of an Xsens MTi-1.

    From data sheets: full scale 2000 deg/s and 16 g, noise 0.007 deg/s/rtHz and 120 ug/rtHz (MTi
    1-series), axes orthogonal within 0.05 deg (MTi 10/100-series), gyroscope bias repeatable within
    0.5 deg/s over a year (Xsens support); the resolution is 16 bit of the full scale. Bias walks
    reach the data sheet's in-run stability (10 deg/h, 0.03 mg) in 100 s. Chosen, for want of a
    published number: turn-on bias of the accelerometer 3 mg and scale 0.1 % (a fresh calibration
    is better, a year on a cane is not).

    Attributes:
        gyro: In rad/s.
        accel: In m/s^2.
        converter_hz: Least rate at which the sensor converts before it integrates inside.
    """

    gyro: Triad = Triad(
        noise_rthz=0.007 * _DEG,
        bias=0.25 * _DEG,
        bias_walk_rts=10.0 / 3600.0 * _DEG / sqrt(100.0),
        scale=1e-3,
        misalignment_rad=0.05 * _DEG,
        full_scale=2000.0 * _DEG,
        resolution=2000.0 * _DEG / 2**15,
    )
    accel: Triad = Triad(
        noise_rthz=120e-6 * _G,
        bias=3e-3 * _G,
        bias_walk_rts=0.03e-3 * _G / sqrt(100.0),
        scale=1e-3,
        misalignment_rad=0.05 * _DEG,
        full_scale=16.0 * _G,
        resolution=16.0 * _G / 2**15,
    )
    converter_hz: float = 400.0


SENSORS: Final[Mapping[str, ImuModel]] = {
    "mti": ImuModel(),
    "cheap": ImuModel(
        gyro=Triad(
            noise_rthz=0.03 * _DEG,
            bias=1.0 * _DEG,
            bias_walk_rts=1e-4 * _DEG,
            scale=5e-3,
            misalignment_rad=1.0 * _DEG,
            full_scale=2000.0 * _DEG,
            resolution=2000.0 * _DEG / 2**15,
        ),
        accel=Triad(
            noise_rthz=300e-6 * _G,
            bias=0.08,
            bias_walk_rts=1e-4,
            scale=5e-3,
            misalignment_rad=1.0 * _DEG,
            full_scale=16.0 * _G,
            resolution=16.0 * _G / 2**15,
        ),
    ),
}
"""The class of an Xsens MTi-1, and a cheap one as in a phone, never calibrated."""


@dataclass(frozen=True, slots=True)
class TriadErrors:
    """The errors of one particular three-axis sensor.

    Attributes:
        matrix: Scale and alignment, takes the true vector to what the axes see, shape (3, 3).
        bias: At turn-on, shape (3,).
    """

    matrix: Floats
    bias: Floats

    @classmethod
    def draw(cls, kind: Triad, rng: np.random.Generator) -> Self:
        """Return one sensor of a kind."""
        tilts = kind.misalignment_rad * rng.standard_normal((3, 3))
        np.fill_diagonal(tilts, kind.scale * rng.standard_normal(3))
        return cls(np.eye(3) + tilts, kind.bias * rng.standard_normal(3))


def converted(
    true: Floats,
    kind: Triad,
    period_s: float,
    errors: TriadErrors,
    lead: int,
    rng: np.random.Generator,
) -> tuple[Floats, Floats]:
    """Return what the converter reads and where it was at full scale, both of shape (n, 3).

    Args:
        true: Means over consecutive conversion periods, shape (n, 3).
        kind: Of the sensor.
        period_s: Between conversions.
        errors: Of this sensor.
        lead: Conversions before time 0; from there on the same state of ``rng`` gives the same
            noise whatever the lead and the length.
        rng: Draws noise and bias walk.
    """
    draws = np.roll(rng.standard_normal((len(true), 6)), lead, axis=0)
    noise = kind.noise_rthz / sqrt(period_s) * draws[:, :3]
    walk = np.cumsum(draws[:, 3:], axis=0)
    walk = kind.bias_walk_rts * sqrt(period_s) * (walk - walk[lead - 1])
    raw = true @ errors.matrix.T + errors.bias + walk + noise
    clipped = np.abs(raw) >= kind.full_scale
    steps = np.round(np.clip(raw, -kind.full_scale, kind.full_scale) / kind.resolution)
    return steps * kind.resolution, clipped.astype(np.float64)


def sensed(
    ideal: ImuRun,
    count: int,
    model: ImuModel,
    rng: np.random.Generator,
    noise: np.random.Generator | None = None,
) -> tuple[ImuRun, Floats]:
    """Return what a sensor reports, and its clip flags.

    Each conversion is disturbed, clipped and quantised; then ``count`` of them are integrated
    into one sample as ``ImuRun`` says.

    Args:
        ideal: Without error, one interval per conversion, shape (n * count, 3); the first sample
            is the one that ends at time 0.
        count: Conversions in a sample.
        model: Kind of sensor.
        rng: Draws this sensor, and its noise where ``noise`` is None.
        noise: Draws the noise of another walk with the same sensor.

    Returns:
        The run at the sample rate, and ``CLIP`` flags of shape (n, 1).
    """
    of_gyro, of_accel = rng.spawn(2)
    gyro_errors = TriadErrors.draw(model.gyro, of_gyro)
    accel_errors = TriadErrors.draw(model.accel, of_accel)
    if noise is not None:
        of_gyro, of_accel = noise.spawn(2)
    gyro_b, gyro_clip = converted(
        ideal.gyro_b, model.gyro, ideal.period_s, gyro_errors, count, of_gyro
    )
    accel_b, accel_clip = converted(
        ideal.accel_b, model.accel, ideal.period_s, accel_errors, count, of_accel
    )
    flags = np.hstack([accel_clip, gyro_clip]).reshape(-1, count, 6).max(axis=1)
    clip = flags @ np.array([[1.0], [2.0], [4.0], [8.0], [16.0], [32.0]])
    return ImuRun(ideal.period_s, gyro_b, accel_b).merged(count), clip
