"""The pitch of a crutch as it goes: integrated, set right in every stance, also backward."""

import math
from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import rotation
from gaitway_plugins.crutch_tip.inclination import expected_lean
from gaitway_plugins.crutch_tip.params import CrutchTipParams
from gaitway_plugins.crutch_tip.stances import kept_samples
from gaitway_plugins.crutch_tip.stream import COLUMNS, DELAY_S, GYRO_D, UP_D, Rows
from gaitway_plugins.crutch_tip.tilt import Tilt, pitch_rad, turned
from gaitway_plugins.crutch_tip.tracker import Settled

MIN_WINDOW_S: Final = 0.05
"""A stance whose middle is shorter tells no inclination."""


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
    _rested: int
    _begin_rad: float | None
    _stance_from: int | None
    _q_nd: Floats
    _sigma_rad: Floats
    _values: Floats

    def __init__(self, params: CrutchTipParams, period_s: float) -> None:
        self._params = params
        self._period_s = period_s
        self._tilt = Tilt(params, period_s)
        self._keep = kept_samples(params, period_s)
        self._edge = round(params.settle_s / period_s)
        self._window = max(2, round(params.inclination_window_s / period_s))
        self._least = max(1, round(MIN_WINDOW_S / period_s))
        self._rest = max(2, round(params.rest_window_s / period_s))
        self._begin()

    def extend(self, rows: Rows) -> None:
        """Go on by samples."""
        if not self._tilt.known:
            first = rows.values[: self._window, UP_D]
            self._tilt.begin(np.array([np.mean(first[:, 0]), np.mean(first[:, 1])]))
        before_rad = self._tilt.pitch_sigma_rad()
        if not len(self._q_nd):
            self._begin_rad = before_rad
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
        """Return the pitch where the load changed before a sample, and its standard deviation."""
        row = min(max(1, index - self._first), len(self._q_nd) - 1)
        before_rad, after_rad = pitch_rad(self._q_nd[row - 1 : row + 1]).tolist()
        rate_radps = (after_rad - before_rad) / self._period_s
        p = self._params
        sigma_rad = math.hypot(
            max(float(self._sigma_rad[row]), self._tilt.pitch_sigma_rad()),
            p.inclination_offset_sigma_rad,
            rate_radps * p.stride_time_sigma_s,
        )
        return 0.5 * (before_rad + after_rad), sigma_rad

    def settle(self, *, all_of_them: bool = False) -> Settled:
        """Return the pitches that won't change any more, each once, in order."""
        end = self._first + len(self._q_nd)
        until = end if all_of_them else max(self._corrected, end - self._keep)
        rows = slice(self._told - self._first, max(self._told, until) - self._first)
        level_rad = self._params.inclination_offset_sigma_rad
        settled = Settled(pitch_rad(self._q_nd[rows]), np.hypot(self._sigma_rad[rows], level_rad))
        self._told = max(self._told, until)
        self._forget(max(0, min(self._told, end - self._keep) - self._first))
        return settled

    def broken(self, duration_s: float) -> None:
        """Take that samples are missing; indexes begin at 0 again."""
        self._tilt.lose(duration_s)
        self._begin()

    def _begin(self) -> None:
        self._first = self._told = self._corrected = self._used = self._rested = 0
        self._begin_rad = None
        self._stance_from = None
        self._q_nd = np.empty((0, 4))
        self._sigma_rad = np.empty(0)
        self._values = np.empty((0, COLUMNS))

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
        q_nd, values = self._q_nd[window], self._values[window]
        expected = expected_lean(
            q_nd, values[:, GYRO_D], self._period_s, values[:, DELAY_S], self._params.imu_height_m
        )
        before_rad = self._tilt.pitch_sigma_rad()
        correction = self._tilt.correct(
            q_nd[count // 2],
            np.mean(values[:, UP_D] - expected, axis=0),
            (end - 0.5 * (start + stop)) * self._period_s,
            self._params.inclination_sigma_rad * float(np.sqrt(few)),
        )
        # What was off from the beginning was so all the time since.
        off = 0.0 if self._begin_rad is None else min(1.0, self._begin_rad / before_rad)
        self._begin_rad = None
        self._spread(correction, min(end, 0.5 * (start + stop)), end, off)

    def _spread(self, correction: Floats, middle: float, end: int, off: float) -> None:
        """Turn what was integrated since the last correction by its share of this one.

        Args:
            correction: The rotation.
            middle: Number of the sample it is of.
            end: Number of samples so far.
            off: Share of it that was due already at the last correction.
        """
        number = np.arange(self._first, end)
        since = max(1.0, middle - self._corrected)
        share = np.clip(off + (1.0 - off) * (number - self._corrected) / since, 0.0, 1.0)
        share[number < self._corrected] = 0.0
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
