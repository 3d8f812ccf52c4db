"""A crutch's samples as rows without holes: short gaps bridged, long ones said."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from gaitway.api import ACCEL, CLIP, GYRO, EstimatorInput, Floats, Gap, Ints, SampleBatch
from gaitway.estimation import Break, norms
from gaitway_plugins.crutch_tip.force import force_newton
from gaitway_plugins.crutch_tip.inclination import lean_components, lean_delays_s
from gaitway_plugins.crutch_tip.params import CrutchTipParams

GYRO_D, FORCE, UP_D, FELT, CLIPPED = slice(0, 3), 3, slice(4, 6), 6, 7
DELAY_S = slice(8, 10)
COLUMNS: Final = 10
_NEEDED: Final = [0, 1, 2, FORCE, UP_D.start]


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Consecutive samples.

    Attributes:
        t_ns: Host time, shape (n,).
        values: A row a sample, shape (n, 10): angular rate in d (rad/s), axial force (newtons), the
            vertical's measured components along d's x and y (NaN where unknown), length of the
            specific force (m/s^2, NaN where unknown), whether an axis clipped, and by how much
            each component of the vertical is late (seconds).
    """

    t_ns: Ints
    values: Floats

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.t_ns)

    def __getitem__(self, part: slice) -> "Rows":
        """Return the samples of a slice."""
        return Rows(self.t_ns[part], self.values[part])

    def joined(self, later: "Rows") -> "Rows":
        """Return these and later ones."""
        return Rows(
            np.concatenate([self.t_ns, later.t_ns]), np.concatenate([self.values, later.values])
        )


class Stream:
    """Turns batches and gaps into rows and breaks; how they are cut changes nothing.

    Args:
        params: Of the crutch.
    """

    def __init__(self, params: CrutchTipParams) -> None:
        self._params = params
        self._last: Rows | None = None
        self._missing = 0
        self._restarted = False

    def feed(self, item: EstimatorInput) -> list[Rows | Break]:
        """Return what the next item makes known, in the order of time."""
        if isinstance(item, Gap):
            self._missing += item.n_missing
            self._restarted |= item.reason == "device-restart"
            return []
        rows = self._rows(item)
        good = np.atleast_1d(np.isfinite(rows.values[:, _NEEDED]).all(axis=1))
        out: list[Rows | Break] = []
        edges = [0, *(np.flatnonzero(np.diff(good)) + 1).tolist(), len(good)]
        for start, stop in pairwise(edges):
            if start < stop and good[start]:
                out += self._take(rows[start:stop], item.period_s)
            else:
                self._missing += stop - start
        return out

    def _rows(self, batch: SampleBatch) -> Rows:
        values = np.full((len(batch), COLUMNS), np.nan)
        values[:, GYRO_D] = batch.channels[GYRO.name] * self._params.gyro_gain
        values[:, FORCE] = force_newton(batch, self._params)
        values[:, UP_D] = lean_components(batch, self._params)
        values[:, DELAY_S] = lean_delays_s(batch, self._params)
        if ACCEL.name in batch.channels:
            values[:, FELT] = norms(batch.channels[ACCEL.name])
        flags = batch.channels.get(CLIP.name)
        values[:, CLIPPED] = 0.0 if flags is None else flags[:, 0] != 0.0
        return Rows(batch.t_ns, values)

    def _take(self, rows: Rows, period_s: float) -> list[Rows | Break]:
        out: list[Rows | Break] = []
        if self._missing and self._last is not None:
            most = math.floor(self._params.max_bridge_s / period_s + 1e-6)
            if self._restarted or self._missing > most:
                out.append(Break(int(self._last.t_ns[0]), (self._missing + 1) * period_s))
            else:
                out.append(_between(self._last, rows[:1], self._missing))
        self._missing, self._restarted = 0, False
        self._last = rows[-1:]
        return [*out, rows]


def _between(before: Rows, after: Rows, missing: int) -> Rows:
    part = np.arange(1, missing + 1)
    share = (part / (missing + 1))[:, np.newaxis]
    t_ns = before.t_ns[0] + (after.t_ns[0] - before.t_ns[0]) * part // (missing + 1)
    return Rows(t_ns, before.values + share * (after.values - before.values))
