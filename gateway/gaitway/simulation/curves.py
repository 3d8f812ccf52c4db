"""Smooth curves of time, from which positions and attitudes are built.

A curve gives its values and its exact first derivative, so that what an IMU measures along it is
derived and never modelled. Curves are added (``Sum``) and set side by side (``Stacked``).
"""

from collections.abc import Sequence
from typing import Final, Protocol

import numpy as np

from gaitway.samples import Floats


class Curve(Protocol):
    """A continuously differentiable function of time with one or more columns."""

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        """Return values (order 0) or rates per second (order 1) at rising times, shape (n, k)."""
        ...


class Constant:
    """A curve that stays where it is.

    Args:
        values: One number a column.
    """

    def __init__(self, *values: float) -> None:
        self._values = np.array(values)

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        """Return the values, or zeros for order 1, shape (n, k)."""
        row = self._values if order == 0 else np.zeros_like(self._values)
        return np.tile(row, (len(t_s), 1))


class Sum:
    """The sum of curves with equal columns.

    Args:
        terms: At least one curve.
    """

    def __init__(self, *terms: Curve) -> None:
        self._terms = terms

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        """Return the sum of the terms' values or rates, shape (n, k)."""
        total = self._terms[0](t_s, order)
        for term in self._terms[1:]:
            total = total + term(t_s, order)
        return total


class Stacked:
    """Curves side by side: the columns of the first, then those of the second, and so on.

    Args:
        parts: At least one curve.
    """

    def __init__(self, *parts: Curve) -> None:
        self._parts = parts

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        """Return the columns of all parts, shape (n, k)."""
        return np.hstack([part(t_s, order) for part in self._parts])


SHOCK_END: Final = 40.0
"""A shock is over after this many decay times: what is left is below 1e-12 of its peak."""
_ENVELOPE_PEAK: Final = 27.0 * np.exp(-3.0)


class Shocks:
    """Short damped oscillations, one at each contact, as a part of the motion itself.

    Each is ``peak (s^3 e^-s / 1.34) sin(2 pi f t)`` with ``s = t / decay_s`` from the contact on:
    three times continuously differentiable, at rest before, and back at zero afterwards, so that
    it adds nothing to where the device ends up.

    Args:
        t_s: Rising times of contact, shape (m,).
        peaks: Bound of each oscillation in each column, shape (m, k), metres or radians.
        frequency_hz: Of the oscillation.
        decay_s: Its time constant; the envelope is highest after three of them.
    """

    def __init__(self, t_s: Floats, peaks: Floats, frequency_hz: float, decay_s: float) -> None:
        self._t_s = t_s
        self._peaks = peaks / (_ENVELOPE_PEAK * decay_s**3)
        self._exponent = complex(-1.0 / decay_s, 2.0 * np.pi * frequency_hz)
        self._length_s = SHOCK_END * decay_s

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        """Return displacements or their rates, shape (n, k)."""
        total = np.zeros((len(t_s), self._peaks.shape[1]))
        first = np.searchsorted(t_s, self._t_s)
        last = np.searchsorted(t_s, self._t_s + self._length_s)
        for start, stop, contact_s, peak in zip(first, last, self._t_s, self._peaks, strict=True):
            total[start:stop] += np.outer(self._wave(t_s[start:stop] - contact_s, order), peak)
        return total

    def _wave(self, t_s: Floats, order: int) -> Floats:
        powers = t_s**3 if order == 0 else (3.0 + self._exponent * t_s) * t_s**2
        wave: Floats = np.imag(powers * np.exp(self._exponent * t_s))
        return wave


class Tremor:
    """Sines of several frequencies under an envelope, as of a hand that is not quite still.

    Args:
        envelope: One column, usually between 0 and 1.
        peaks: Amplitude of each sine in each column, shape (m, k).
        frequencies_hz: Of each sine, shape (m,).
        phases_rad: Of each sine in each column, shape (m, k).
    """

    def __init__(
        self, envelope: Curve, peaks: Floats, frequencies_hz: Sequence[float], phases_rad: Floats
    ) -> None:
        self._envelope = envelope
        self._peaks = peaks
        self._omegas = 2.0 * np.pi * np.asarray(frequencies_hz)
        self._phases = phases_rad

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        """Return displacements or their rates, shape (n, k)."""
        if order == 0:
            return self._envelope(t_s) * self._sines(t_s, 0)
        return self._envelope(t_s, 1) * self._sines(t_s, 0) + self._envelope(t_s) * self._sines(
            t_s, 1
        )

    def _sines(self, t_s: Floats, order: int) -> Floats:
        total = np.zeros((len(t_s), self._peaks.shape[1]))
        for omega, peak, phase in zip(self._omegas, self._peaks, self._phases, strict=True):
            angle = omega * t_s[:, None] + phase
            total += peak * np.sin(angle) if order == 0 else peak * omega * np.cos(angle)
        return total
