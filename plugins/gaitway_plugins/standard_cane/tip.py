"""What a sensor at the tip would feel: the specific force carried down the shaft."""

from typing import Final, NamedTuple

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import ImuSample, half_window


class TipRow(NamedTuple):
    """A sample, and what a sensor at the tip would have read.

    Attributes:
        sample: As measured.
        force_d: Specific force of the tip, m/s^2, shape (3,).
        rate_d: Angular rate at the *end* of the sample, rad/s, shape (3,): measured is the mean
            over it, and the pendulum's velocity is wanted when the sample has been integrated.
        force_mps2: Norm of force_d.
        rate_radps: Norm of rate_d.
    """

    sample: ImuSample
    force_d: Floats
    rate_d: Floats
    force_mps2: float
    rate_radps: float


class TipTransport:
    """Carries specific forces from the sensor to the tip (Dang & Suh 2018, Eq. 27 corrected).

    ``f_tip = y_a + w' x p1 + w x (w x p1)``: the print loses the last term, which at 0.6 rad/s and
    0.78 m is more than its own threshold. With the tip on the floor ``|f_tip|`` is gravity however
    the shaft turns. ``w'`` is the slope of the least-squares line through the rates of a centred
    window; a constant bias of the gyroscope does not show in it.

    Args:
        imu_to_tip_d: The paper's p1, metres, in d.
        window_s: Of the slope.
        period_s: Of the samples.

    Attributes:
        half: How many samples after its own a row is known.
    """

    def __init__(self, imu_to_tip_d: Floats, window_s: float, period_s: float) -> None:
        self.half: Final = max(1, half_window(window_s, period_s))
        self._lever_d: Final = imu_to_tip_d
        reach = np.arange(1, self.half + 1)
        self._weights: Final = reach / (2.0 * period_s * float(reach @ reach))
        self._held: list[ImuSample] = []

    def extend(self, samples: list[ImuSample]) -> list[TipRow]:
        """Take samples; return the rows that are known now, of the samples ``half`` before."""
        held, half = self._held + samples, self.half
        self._held = held[-2 * half :]
        count = len(held) - 2 * half
        if count <= 0:
            return []
        gyro = np.array([sample.gyro_d for sample in held])
        accel = np.array([sample.accel_d for sample in held[half : half + count]])
        slope = np.zeros((count, 3))
        for reach, weight in enumerate(self._weights.tolist(), 1):
            ahead, behind = half + reach, half - reach
            slope += weight * (gyro[ahead : ahead + count] - gyro[behind : behind + count])
        rate = gyro[half : half + count]
        force = accel + np.cross(slope, self._lever_d)
        force += np.cross(rate, np.cross(rate, self._lever_d))
        at_end = 0.5 * (rate + gyro[half + 1 : half + 1 + count])
        norms = np.sqrt(np.sum(force * force, axis=1)), np.sqrt(np.sum(rate * rate, axis=1))
        rows = zip(held[half:], force, at_end, *(norm.tolist() for norm in norms), strict=False)
        return [TipRow(*row) for row in rows]
