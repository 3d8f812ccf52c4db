"""Streaming band-pass filters: Butterworth, causal, designed in closed form.

A filter is a cascade of biquads (second-order sections). Each section of an analogue Butterworth
filter has the same corner and its own quality ``Q_k``; the bilinear transform with a prewarped
corner makes it digital (Oppenheim & Schafer, Discrete-Time Signal Processing, 7.1). Nothing is
known of the future, so a component is delayed by the group delay of the filter at its frequency.
"""

import cmath
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

Kind = Literal["low", "high"]


@dataclass(frozen=True, slots=True)
class Biquad:
    """One second-order section, ``(b0 + b1/z + b2/z^2) / (1 + a1/z + a2/z^2)``.

    Attributes:
        b0: Of the input.
        b1: Of the input one sample ago.
        b2: Of the input two samples ago.
        a1: Of the output one sample ago.
        a2: Of the output two samples ago.
    """

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float

    def response(self, omega: float) -> complex:
        """Return the frequency response at ``omega`` radians per sample."""
        z1 = cmath.exp(-1j * omega)
        z2 = z1 * z1
        return (self.b0 + self.b1 * z1 + self.b2 * z2) / (1.0 + self.a1 * z1 + self.a2 * z2)


def butterworth(kind: Kind, order: int, corner_hz: float, rate_hz: float) -> tuple[Biquad, ...]:
    """Return the sections of a Butterworth filter.

    Args:
        kind: Which side passes.
        order: Even, at least 2.
        corner_hz: Where 3 dB are lost, below half the rate.
        rate_hz: Sample rate.

    Raises:
        ValueError: The order is odd or the corner is not below half the rate.
    """
    if order < 2 or order % 2:
        raise ValueError(f"order {order}: an even one, so that it is made of biquads")
    if not 0.0 < corner_hz < 0.5 * rate_hz:
        raise ValueError(f"corner {corner_hz} Hz: must be between 0 and half of {rate_hz} Hz")
    warped = math.tan(math.pi * corner_hz / rate_hz)
    qualities = (0.5 / math.cos(math.pi * (2 * k + 1) / (2 * order)) for k in range(order // 2))
    return tuple(_section(kind, warped, quality) for quality in qualities)


def _section(kind: Kind, warped: float, quality: float) -> Biquad:
    scale = 1.0 / (1.0 + warped / quality + warped * warped)
    gain = warped * warped * scale if kind == "low" else scale
    return Biquad(
        b0=gain,
        b1=2.0 * gain if kind == "low" else -2.0 * gain,
        b2=gain,
        a1=2.0 * (warped * warped - 1.0) * scale,
        a2=(1.0 - warped / quality + warped * warped) * scale,
    )


class Cascade:
    """Filters a stream of scalars through sections, a sample at a time.

    It starts as if the first value had been there for ever, so that gravity's share of the first
    sample does not ring.

    Args:
        sections: In any order; their product is the filter.
    """

    def __init__(self, sections: Sequence[Biquad]) -> None:
        self._sections = tuple(sections)
        self._states: list[list[float]] = []

    def push(self, value: float) -> float:
        """Take the next value; return the filtered one."""
        if not self._states:
            self._settle(value)
        for section, state in zip(self._sections, self._states, strict=True):
            out = section.b0 * value + state[0]
            state[0] = section.b1 * value - section.a1 * out + state[1]
            state[1] = section.b2 * value - section.a2 * out
            value = out
        return value

    def filter(self, values: Iterable[float]) -> list[float]:
        """Take several values; return the filtered ones."""
        return [self.push(value) for value in values]

    def _settle(self, value: float) -> None:
        for section in self._sections:
            out = section.response(0.0).real * value
            second = section.b2 * value - section.a2 * out
            self._states.append([section.b1 * value - section.a1 * out + second, second])
            value = out


class BandPass(Cascade):
    """High-pass and low-pass in a row, from the edges of their transitions.

    Each corner is half-way, geometrically, between the edge of the stop band and that of the pass
    band, so that with transitions of a factor 2 to 2.5 and order 4 a pass edge loses 0.1 to 0.3 dB
    and a stop edge at least 12 dB.

    Args:
        rate_hz: Sample rate.
        high_stop_hz: Below, nothing passes.
        high_pass_hz: Above, everything passes.
        low_pass_hz: Below, everything passes.
        low_stop_hz: Above, nothing passes; where the rate is too low for it, nothing is there.
        order: Of both filters.
    """

    def __init__(
        self,
        rate_hz: float,
        *,
        high_stop_hz: float,
        high_pass_hz: float,
        low_pass_hz: float,
        low_stop_hz: float,
        order: int = 4,
    ) -> None:
        high_hz = math.sqrt(high_stop_hz * high_pass_hz)
        low_hz = min(math.sqrt(low_pass_hz * low_stop_hz), 0.45 * rate_hz)
        sections = (
            *butterworth("high", order, high_hz, rate_hz),
            *butterworth("low", order, low_hz, rate_hz),
        )
        super().__init__(sections)
        self._rate_hz = rate_hz

    def delay_s(self, frequency_hz: float) -> float:
        """Return the group delay at a frequency; the high-pass makes it long near its corner."""
        step = 1e-4
        omega = 2.0 * math.pi * frequency_hz / self._rate_hz
        turned = 0.0
        for section in self._sections:
            ahead, behind = section.response(omega + step), section.response(omega - step)
            turned += cmath.phase(ahead / behind)
        return -turned / (2.0 * step * self._rate_hz)
