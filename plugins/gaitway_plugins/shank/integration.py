"""What the published methods integrate, and how: whole walks or stride by stride.

Orlowski & Loose, "Simple Algorithms for the Determination of the Walking Distance based on the
Acceleration Sensor", section 3. Their a_x is the specific force along d's x axis, their w_z the
rate of the shank swinging forward, minus the rate about d's y axis. Gravity's share of the
acceleration stays in, as in the paper.
"""

from typing import Final, Protocol

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import ImuSample
from gaitway.estimation.bandpass import BandPass
from gaitway_plugins.shank.params import ShankParams
from gaitway_plugins.shank.track import samples

_LEAD_S: Final = 0.5
"""Walking begins so long before the first toe-off and ends so long after the last contact."""
BEFORE_PEAK_S: Final = 0.5
"""Toe-off, and the strongest deceleration before it, are at most so long before mid-swing."""

Step = tuple[int, int, float]
"""First sample, last sample and length in metres of a stride."""


class Signals:
    """Filtered signals of the last few seconds, by number of the sample.

    Args:
        params: Of the shank.
        period_s: Of the samples.
    """

    def __init__(self, params: ShankParams, period_s: float) -> None:
        self.period_s: Final = period_s
        self._filters = tuple(
            BandPass(
                1.0 / period_s,
                high_stop_hz=params.high_stop_hz,
                high_pass_hz=params.high_pass_hz,
                low_pass_hz=params.low_pass_hz,
                low_stop_hz=params.low_stop_hz,
            )
            for _ in range(2)
        )
        self._first = 0
        self._t_ns: list[int] = []
        self._rows: list[tuple[float, float]] = []

    @property
    def next(self) -> int:
        """Number of the next sample."""
        return self._first + len(self._rows)

    def push(self, sample: ImuSample) -> tuple[float, float]:
        """Take the next sample; return filtered acceleration and swing rate."""
        accel, rate = self._filters
        row = accel.push(sample.accel_d[0]), rate.push(-sample.gyro_d[1])
        self._t_ns.append(sample.t_ns)
        self._rows.append(row)
        return row

    def t_ns(self, index: int) -> int:
        """Return the host time of a sample."""
        return self._t_ns[index - self._first]

    def accel_mps2(self, begin: int, end: int) -> Floats:
        """Return the acceleration from ``begin`` to ``end``, both included, shape (n,)."""
        return self._part(begin, end)[:, 0]

    def rate_radps(self, begin: int, end: int) -> Floats:
        """Return the swing rate from ``begin`` to ``end``, both included, shape (n,)."""
        return self._part(begin, end)[:, 1]

    def since(self, index: int) -> int:
        """Return the index, or that of the oldest sample known where it is older."""
        return max(index, self._first)

    def drop_before(self, index: int) -> None:
        """Forget samples that nobody will ask for."""
        count = index - self._first
        if count > 0:
            del self._t_ns[:count], self._rows[:count]
            self._first = index

    def _part(self, begin: int, end: int) -> Floats:
        return np.array(self._rows[begin - self._first : end + 1 - self._first])


class Method(Protocol):
    """Swings in, strides out."""

    def swing(self, toe_off: int, contact: int) -> list[Step]:
        """Take a swing that is over."""
        ...

    def stop(self) -> list[Step]:
        """Take that no swing follows: walking is over."""
        ...

    def needs(self) -> int | None:
        """Return the oldest sample still needed, None for none in particular."""
        ...


class WholeSignal:
    """WSI: velocity from the whole walk, raised so that its lowest value is zero.

    The lowest velocity of the walk is known at its end only. Here the lowest so far is taken, and
    when a lower one comes the stride that brought it gets what all before it lack: the sum is the
    paper's at every contact, and so at the end.

    Args:
        signals: Of the shank.
    """

    def __init__(self, signals: Signals) -> None:
        self._signals = signals
        self._lead = samples(_LEAD_S, signals.period_s)
        self._last: int | None = None
        self._clear(0)

    def swing(self, toe_off: int, contact: int) -> list[Step]:
        """Take a swing that is over; the stride before it ended with its own contact."""
        strides = [] if self._last is None else [self._integrate(self._last)]
        if self._last is None:
            self._clear(self._signals.since(toe_off - self._lead))
        self._last = contact
        return strides

    def stop(self) -> list[Step]:
        """Take that walking is over: the last stride comes to rest."""
        last, self._last = self._last, None
        if last is None:
            return []
        return [self._integrate(min(last + self._lead, self._signals.next - 1))]

    def needs(self) -> int | None:
        """Return where the integration has got to."""
        return None if self._last is None else self._at

    def _clear(self, begin: int) -> None:
        self._at = begin
        self._velocity_mps = self._lowest_mps = 0.0
        self._raw_m = self._told_m = self._time_s = 0.0

    def _integrate(self, end: int) -> Step:
        period_s, begin = self._signals.period_s, self._at
        velocity = self._velocity_mps + trapezoid(self._signals.accel_mps2(begin, end), period_s)
        self._raw_m += float(trapezoid(velocity, period_s)[-1])
        self._time_s += (end - begin) * period_s
        self._velocity_mps = float(velocity[-1])
        self._lowest_mps = min(self._lowest_mps, float(velocity.min()))
        before_m, self._told_m = self._told_m, self._raw_m - self._lowest_mps * self._time_s
        self._at = end
        return begin, end, self._told_m - before_m


class Stepwise:
    """SWI: each stride by itself, its lowest velocity a share of its mean.

    Args:
        signals: Of the shank.
        method: Where strides begin. s1: highest swing rate; s2: strongest deceleration before it;
            s3: toe-off, the lowest swing rate before it (Greene et al. 2010).
        v_min_share: Lowest velocity as a share of the mean.
    """

    def __init__(self, signals: Signals, method: str, v_min_share: float) -> None:
        self._signals = signals
        self._method = method
        self._share = v_min_share
        self._before = samples(BEFORE_PEAK_S, signals.period_s)
        self._from: int | None = None

    def swing(self, toe_off: int, contact: int) -> list[Step]:
        """Take a swing that is over."""
        begin, self._from = self._from, self._feature(toe_off, contact)
        if begin is None or begin >= self._from:
            return []
        return [(begin, self._from, self._length_m(begin, self._from))]

    def stop(self) -> list[Step]:
        """Take that walking is over: what follows the last feature is no stride."""
        self._from = None
        return []

    def needs(self) -> int | None:
        """Return where the present stride began."""
        return self._from

    def _feature(self, toe_off: int, contact: int) -> int:
        s = self._signals
        peak = toe_off + int(np.argmax(s.rate_radps(toe_off, contact)))
        if self._method == "s1":
            return peak
        begin = s.since(peak - self._before)
        signal = s.accel_mps2 if self._method == "s2" else s.rate_radps
        return begin + int(np.argmin(signal(begin, peak)))

    def _length_m(self, begin: int, end: int) -> float:
        """Return the length; with ``v_min = k mean(v)`` the mean is that above the lowest/(1-k)."""
        period_s = self._signals.period_s
        velocity = trapezoid(self._signals.accel_mps2(begin, end), period_s)
        raised = velocity - velocity.min()
        return float(trapezoid(raised, period_s)[-1]) / (1.0 - self._share)


def trapezoid(values: Floats, period_s: float) -> Floats:
    """Return the running integral by the trapezoid rule, 0 at the first value, same shape."""
    out = np.zeros(len(values))
    np.cumsum(0.5 * period_s * (values[1:] + values[:-1]), out=out[1:])
    return out
