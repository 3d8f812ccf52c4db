"""The pitch of a crutch as it goes: integrated, set right in every stance, also backward."""

from typing import Final, NamedTuple, Protocol

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import half_window, rotation
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.stream import GYRO_D, UP_D, Rows
from gaitway_plugins.crutch_tip.tilt import Tilt, pitch_rad, turned

MIN_WINDOW_S: Final = 0.05
"""A stance whose middle is shorter tells no inclination."""


class Settled(NamedTuple):
    """Pitches that won't change any more.

    Attributes:
        pitch_rad: Shape (n,).
        sigma_rad: Shape (n,).
    """

    pitch_rad: Floats
    sigma_rad: Floats


class Tracker(Protocol):
    """Follows the pitch of one unbroken stretch of samples; indexes count from its beginning."""

    def extend(self, rows: Rows) -> None:
        """Go on by samples."""
        ...

    def loaded(self, index: int) -> None:
        """Take that the crutch is loaded since a sample."""
        ...

    def relieved(self, index: int) -> None:
        """Take that it is not any more since a sample."""
        ...

    def pitch(self, index: int) -> tuple[float, float]:
        """Return pitch and its standard deviation at a sample of the last seconds."""
        ...

    def settle(self, *, all_of_them: bool = False) -> Settled:
        """Return the pitches that won't change any more, each once, in order."""
        ...

    def broken(self, duration_s: float) -> None:
        """Take that samples are missing; indexes begin at 0 again."""
        ...


class TiltTracker:
    """The default: ``Tilt``, and what an inclination says of the samples before it.

    The correction that an inclination brings has grown since the last one, so the samples between
    get their share of it. The samples of the last ``window_s`` are kept.

    Args:
        params: Of the crutch.
        period_s: Of the samples.
    """

    _first: int
    _told: int
    _corrected: int
    _used: int
    _stance_from: int | None
    _q_nd: Floats
    _sigma_rad: Floats
    _values: Floats

    def __init__(self, params: CrutchTipParams, period_s: float) -> None:
        self._params = params
        self._period_s = period_s
        self._tilt = Tilt(params, period_s)
        self._keep = round(params.window_s / period_s)
        self._edge = round(params.stance_edge_s / period_s)
        self._window = max(2, round(params.inclination_window_s / period_s))
        self._least = max(1, round(MIN_WINDOW_S / period_s))
        self._rest = max(2, round(params.rest_window_s / period_s))
        self._clear()

    def extend(self, rows: Rows) -> None:
        """Go on by samples."""
        if not self._tilt.known:
            first = rows.values[: self._window, UP_D]
            self._tilt.begin(np.array([np.mean(first[:, 0]), np.mean(first[:, 1])]))
        before_rad = self._tilt.pitch_sigma_rad()
        q_nd = self._tilt.move(rows.values[:, GYRO_D])
        after_rad = self._tilt.pitch_sigma_rad()
        share = np.arange(1, len(rows) + 1) / len(rows)
        sigma = np.sqrt(before_rad**2 + share * (after_rad**2 - before_rad**2))
        self._q_nd = np.concatenate([self._q_nd, q_nd])
        self._sigma_rad = np.concatenate([self._sigma_rad, sigma])
        self._values = np.concatenate([self._values, rows.values])
        self._learn_at_rest()
        if self._stance_from is not None:
            end = self._first + len(self._q_nd) - self._edge
            if end - self._used >= self._window:
                self._learn(self._used, end)

    def loaded(self, index: int) -> None:
        """Take that the crutch is loaded since a sample."""
        self._stance_from = index
        self._used = index + self._edge

    def relieved(self, index: int) -> None:
        """Take that it is not any more since a sample."""
        self._stance_from = None
        if index - self._edge - self._used >= self._least:
            self._learn(self._used, index - self._edge)

    def pitch(self, index: int) -> tuple[float, float]:
        """Return pitch and its standard deviation at a contact or lift, whose time is uncertain."""
        row = min(max(0, index - self._first), len(self._q_nd) - 1)
        sigma_rad = max(float(self._sigma_rad[row]), self._tilt.pitch_sigma_rad())
        moment = slice(max(0, row - 1), row + 2)
        rate_radps = float(np.abs(self._values[moment, GYRO_D][:, 1]).max())
        timing_rad = rate_radps * self._params.stride_time_sigma_s
        shared_rad = self._params.inclination_shared_sigma_rad
        told_rad = float(np.hypot(np.hypot(sigma_rad, shared_rad), timing_rad))
        return float(pitch_rad(self._q_nd[row : row + 1])[0]), told_rad

    def settle(self, *, all_of_them: bool = False) -> Settled:
        """Return the pitches that won't change any more, each once, in order."""
        end = self._first + len(self._q_nd)
        until = end if all_of_them else max(self._corrected, end - self._keep)
        rows = slice(self._told - self._first, max(self._told, until) - self._first)
        settled = Settled(pitch_rad(self._q_nd[rows]), self._told_sigma(self._sigma_rad[rows]))
        self._told = max(self._told, until)
        self._forget(max(0, min(self._told, end - self._keep) - self._first))
        return settled

    def broken(self, duration_s: float) -> None:
        """Take that samples are missing; indexes begin at 0 again."""
        self._tilt.lose(duration_s)
        self._clear()

    def _clear(self) -> None:
        self._first = self._told = self._corrected = self._used = 0
        self._rested = 0
        self._stance_from = None
        self._q_nd = np.empty((0, 4))
        self._sigma_rad = np.empty(0)
        self._values = np.empty((0, 8))

    def _forget(self, rows: int) -> None:
        self._first += rows
        self._q_nd = self._q_nd[rows:]
        self._sigma_rad = self._sigma_rad[rows:]
        self._values = self._values[rows:]

    def _learn_at_rest(self) -> None:
        end = self._first + len(self._q_nd)
        if end - self._rested < self._rest:
            return
        gyro = self._values[-self._rest :, GYRO_D]
        p = self._params
        if np.abs(gyro.mean(axis=0)).max() > p.rest_gyro_max_radps:
            return
        if gyro.std(axis=0).max() > p.rest_gyro_std_max_radps:
            return
        self._rested = end
        self._tilt.rest(gyro.mean(axis=0))
        self._learn(end - self._rest, end)

    def _learn(self, start: int, stop: int) -> None:
        """Take in the inclination between two samples."""
        end = self._first + len(self._q_nd)
        self._used = max(self._used, stop)
        window = slice(max(0, start - self._first), max(0, stop - self._first))
        count = window.stop - window.start
        if count < self._least:
            return
        few = max(1.0, self._window / count)
        own_rad = self._params.inclination_sigma_rad * float(np.sqrt(few))
        correction = self._tilt.correct(
            self._q_nd[window],
            self._values[window, UP_D],
            (end - 0.5 * (start + stop)) * self._period_s,
            float(np.hypot(own_rad, self._moving_rad(self._values[window, GYRO_D]))),
        )
        self._spread(correction, min(end, 0.5 * (start + stop)), end)

    def _moving_rad(self, gyro_d: Floats) -> float:
        """Return by how much motion disturbs a mean inclination: it is late, and feels its lever.

        In a stance this is little; in a swing that is taken for one, because the tip is dragged, it
        says that hardly anything was seen.
        """
        p, rate = self._params, gyro_d[:, :2]
        spin = np.diff(rate, axis=0) / self._period_s
        pushed = (
            p.inclination_lever_s2 * float(np.abs(spin.mean(axis=0)).max()) if len(spin) else 0.0
        )
        return float(np.hypot(p.inclination_lag_s * np.abs(rate.mean(axis=0)).max(), pushed))

    def _told_sigma(self, sigma_rad: Floats) -> Floats:
        """Return standard deviations with what all inclinations share."""
        told: Floats = np.hypot(sigma_rad, self._params.inclination_shared_sigma_rad)
        return told

    def _spread(self, correction: Floats, middle: float, end: int) -> None:
        """Turn what was integrated since the last correction by its share of this one."""
        number = np.arange(self._first, end)
        since = max(1.0, middle - self._corrected)
        share = np.clip((number - self._corrected) / since, 0.0, 1.0)
        angle = np.array(rotation.to_rotation_vector(correction.tolist()))
        whole = share >= 1.0
        self._q_nd[whole] = turned(correction, self._q_nd[whole])
        for row in np.flatnonzero((share > 0.0) & ~whole).tolist():
            part = rotation.from_rotation_vector((share[row] * angle).tolist())
            self._q_nd[row] = rotation.multiply(part, self._q_nd[row].tolist())
        self._sigma_rad[share > 0.0] = np.minimum(
            self._sigma_rad[share > 0.0], self._tilt.pitch_sigma_rad() * 1.5
        )
        self._corrected = max(self._corrected, int(middle))


class PublishedTracker:
    """The paper's: Heun's integral of one axis, set to the inclinometer at the end of each stance.

    Sesar et al. (2019), Eqs. 4 and 5. Nothing tells how far it may be off; its sigma is the paper's
    own RMS error.

    Args:
        params: Of the crutch.
        period_s: Of the samples.
    """

    SIGMA_RAD: Final = float(np.radians(1.40))
    """The paper's Table 2, cycles without turning."""

    _first: int
    _told: int
    _contact: int
    _pitch: Floats
    _rate: Floats
    _inclination: Floats

    def __init__(self, params: CrutchTipParams, period_s: float) -> None:
        self._period_s = period_s
        self._keep = round(params.window_s / period_s)
        self._edge = round(params.stance_edge_s / period_s)
        self.broken(0.0)

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
        self._first = self._told = self._contact = 0
        self._pitch = np.empty(0)
        self._rate = np.empty(0)
        self._inclination = np.empty(0)


def make_tracker(params: CrutchTipParams, period_s: float) -> Tracker:
    """Return the tracker of the method that the parameters name."""
    if params.method == "published":
        return PublishedTracker(params, period_s)
    return TiltTracker(params, period_s)


def smoothing_samples(params: CrutchTipParams, period_s: float) -> int:
    """Return over how many samples a force is averaged."""
    return 2 * half_window(params.force_smoothing_s, period_s) + 1
