"""The paper's pitch: one gyroscope axis, set to the inclinometer at the end of each stance."""

from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.stances import kept_samples
from gaitway_plugins.crutch_tip.stream import GYRO_D, UP_D, Rows
from gaitway_plugins.crutch_tip.tracker import Settled


class PublishedTracker:
    """The paper's: Heun's integral of one axis, set to the inclinometer at the end of each stance.

    Sesar et al. (2019), Eqs. 4 and 5. Nothing tells how far it may be off; its sigma is the paper's
    own RMS error.

    Args:
        params: Of the crutch.
        period_s: Of the samples.
    """

    _first: int
    _told: int
    _contact: int
    _pitch: Floats
    _rate: Floats
    _inclination: Floats

    SIGMA_RAD: Final = float(np.radians(1.40))
    """The paper's Table 2, cycles without turning."""

    def __init__(self, params: CrutchTipParams, period_s: float) -> None:
        self._period_s = period_s
        self._keep = kept_samples(params, period_s)
        self._edge = round(params.stance_edge_s / period_s)
        self._begin()

    def extend(self, rows: Rows) -> None:
        """Go on by samples (Eq. 4)."""
        rate = rows.values[:, GYRO_D][:, 1]
        inclination = -np.arcsin(np.clip(rows.values[:, UP_D][:, 0], -1.0, 1.0))
        if not len(self._pitch):
            start, before = float(inclination[0]), float(rate[0])
        else:
            start, before = float(self._pitch[-1]), float(self._rate[-1])
        rates = np.concatenate([[before], rate])
        steps = 0.5 * self._period_s * (rates[1:] + rates[:-1])
        pitch = np.cumsum(np.concatenate([[start], steps]))[1:]
        self._pitch = np.concatenate([self._pitch, pitch])
        self._rate = np.concatenate([self._rate, rate])
        self._inclination = np.concatenate([self._inclination, inclination])

    def loaded(self, index: int) -> None:
        """Take that the crutch is loaded since a sample."""
        self._contact = index

    def relieved(self, index: int) -> None:
        """Set the pitch by the inclinometer's mean (Eq. 5)."""
        start = max(self._contact + self._edge - self._first, 0)
        stop = index - self._edge - self._first
        if stop - start < 1:
            return
        middle = (start + stop) // 2
        rate = self._rate[middle:]
        ahead = np.append(rate[1:], rate[-1])
        steps = self._period_s / 3.0 * (rate[:-1] + rate[1:] + ahead[1:])
        level = float(np.mean(self._inclination[start:stop]))
        # What was told before stays told; from the end of the stance on it is the corrected one.
        self._pitch[index - self._first :] = (level + np.concatenate([[0.0], np.cumsum(steps)]))[
            index - self._first - middle :
        ]

    def pitch(self, index: int) -> tuple[float, float]:
        """Return pitch and its standard deviation at a sample of the last seconds."""
        row = min(max(0, index - self._first), len(self._pitch) - 1)
        return float(self._pitch[row]), self.SIGMA_RAD

    def settle(self, *, all_of_them: bool = False) -> Settled:
        """Return the pitches that won't change any more, each once, in order."""
        end = self._first + len(self._pitch)
        until = end if all_of_them else max(self._told, end - self._keep)
        pitch = self._pitch[self._told - self._first : until - self._first]
        self._told = until
        forget = max(0, min(self._told, end - self._keep) - self._first)
        self._first += forget
        self._pitch, self._rate = self._pitch[forget:], self._rate[forget:]
        self._inclination = self._inclination[forget:]
        return Settled(pitch, np.full(len(pitch), self.SIGMA_RAD))

    def broken(self, duration_s: float) -> None:
        """Take that samples are missing; indexes begin at 0 again."""
        del duration_s
        self._begin()

    def _begin(self) -> None:
        self._first = self._told = self._contact = 0
        self._pitch = np.empty(0)
        self._rate = np.empty(0)
        self._inclination = np.empty(0)
