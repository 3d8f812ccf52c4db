"""Motion through knots with as little jerk as possible.

A hand or a leg that moves at ease keeps jerk low (Flash and Hogan 1985); between two knots that is
a polynomial of fifth degree, whose free rates and accelerations are those of least total jerk.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gaitway.samples import Floats


@dataclass(frozen=True, slots=True)
class Knot:
    """Where a curve is at one time; ``rest`` and ``via`` make the usual ones.

    Attributes:
        t_s: When.
        values: Where, one number a column.
        rates: Derivatives per second; None leaves them to the least jerk.
        accelerations: Second derivatives; None leaves them to the least jerk.
    """

    t_s: float
    values: tuple[float, ...]
    rates: tuple[float, ...] | None = None
    accelerations: tuple[float, ...] | None = None


def rest(t_s: float, *values: float) -> Knot:
    """Return a knot at which the curve stands still."""
    zeros = (0.0,) * len(values)
    return Knot(t_s, values, zeros, zeros)


def via(t_s: float, *values: float) -> Knot:
    """Return a knot the curve passes with whatever rate and acceleration suit it."""
    return Knot(t_s, values)


class Spline:
    """The curve of least jerk through knots: quintic pieces, continuous acceleration.

    Before the first knot it stays at its value, after the last likewise; both must be at rest.
    Rates and accelerations are given for all columns of a knot or for none.

    Args:
        knots: At least one, in rising time.

    Raises:
        ValueError: Times don't rise, or the first or last knot is not at rest.
    """

    def __init__(self, knots: Sequence[Knot]) -> None:
        t_s = np.array([knot.t_s for knot in knots])
        if np.any(np.diff(t_s) <= 0.0):
            raise ValueError("knots must rise in time")
        for end in (knots[0], knots[-1]):
            if end != rest(end.t_s, *end.values):
                raise ValueError(f"a spline begins and ends at rest: see the knot at {end.t_s} s")
        self._t_s = t_s
        self._steps_s = np.diff(t_s)
        states = _least_jerk(*_states(knots), self._steps_s)
        self._ends = states[[0, -1], 0]
        self._coefficients = _coefficients(states, self._steps_s)

    def __call__(self, t_s: Floats, order: int = 0) -> Floats:
        """Return values or the derivative of an order up to 5, shape (n, k)."""
        if len(self._steps_s) == 0:
            return np.tile(self._ends[0] * (order == 0), (len(t_s), 1))
        inside = np.clip(t_s, self._t_s[0], self._t_s[-1])
        piece = np.clip(np.searchsorted(self._t_s, inside, "right") - 1, 0, len(self._steps_s) - 1)
        step_s = self._steps_s[piece, None]
        u = (inside[:, None] - self._t_s[piece, None]) / step_s
        total = np.zeros((len(t_s), self._ends.shape[1]))
        for power in range(5, order - 1, -1):
            falling = float(np.prod(np.arange(power, power - order, -1)))
            total = total * u + falling * self._coefficients[piece, power]
        if order:
            total *= ((t_s >= self._t_s[0]) & (t_s <= self._t_s[-1]))[:, None]
        values: Floats = total / step_s**order
        return values


# Rows: value, rate, acceleration at 0, then at 1; columns: powers of the unit time u.
_END_STATES: Final = np.array(
    [
        [1, 0, 0, 0, 0, 0],
        [0, 1, 0, 0, 0, 0],
        [0, 0, 2, 0, 0, 0],
        [1, 1, 1, 1, 1, 1],
        [0, 1, 2, 3, 4, 5],
        [0, 0, 2, 6, 12, 20],
    ],
    dtype=np.float64,
)
_HERMITE: Final = np.linalg.inv(_END_STATES)


def _unit_jerk_cost() -> Floats:
    """Return the matrix of the integral of squared jerk over unit time, in end states."""
    jerk = np.zeros((6, 6))
    for a in range(3, 6):
        for b in range(3, 6):
            factor = a * (a - 1) * (a - 2) * b * (b - 1) * (b - 2)
            jerk[a, b] = factor / (a + b - 5)
    cost: Floats = _HERMITE.T @ jerk @ _HERMITE
    return cost


_JERK_COST: Final = _unit_jerk_cost()


def _states(knots: Sequence[Knot]) -> tuple[Floats, NDArray[np.bool_]]:
    """Return value, rate and acceleration of each knot (m, 3, k), and which of them are free."""
    states = np.zeros((len(knots), 3, len(knots[0].values)))
    free = np.zeros((len(knots), 3), dtype=np.bool_)
    for row, knot in enumerate(knots):
        for order, given in enumerate((knot.values, knot.rates, knot.accelerations)):
            if given is None:
                free[row, order] = True
            else:
                states[row, order] = given
    return states, free


def _least_jerk(given: Floats, free: NDArray[np.bool_], steps_s: Floats) -> Floats:
    """Return the states with the free entries set: a block tridiagonal system, knot by knot.

    A given entry's equation is that it stays; a free one's that the derivative of the total cost
    vanishes. Forward elimination and back substitution are linear in the number of knots.
    """
    count = len(given)
    diagonal, above = np.zeros((count, 3, 3)), np.zeros((count, 3, 3))
    below = np.zeros((count, 3, 3))
    for piece, step_s in enumerate(steps_s):
        unit = np.tile([1.0, step_s, step_s**2], 2)
        cost = _JERK_COST * np.outer(unit, unit) / step_s**5
        diagonal[piece] += cost[:3, :3]
        diagonal[piece + 1] += cost[3:, 3:]
        above[piece], below[piece + 1] = cost[:3, 3:], cost[3:, :3]
    diagonal = np.where(free[:, :, None], diagonal, np.eye(3))
    above, below = above * free[:, :, None], below * free[:, :, None]
    states = np.where(free[:, :, None], 0.0, given)
    for row in range(1, count):
        factor = np.linalg.solve(diagonal[row - 1].T, below[row].T).T
        diagonal[row] -= factor @ above[row - 1]
        states[row] -= factor @ states[row - 1]
    states[-1] = np.linalg.solve(diagonal[-1], states[-1])
    for row in range(count - 2, -1, -1):
        states[row] = np.linalg.solve(diagonal[row], states[row] - above[row] @ states[row + 1])
    return states


def _coefficients(states: Floats, steps_s: Floats) -> Floats:
    """Return the power coefficients of each piece in unit time, shape (m - 1, 6, k)."""
    unit = np.stack([np.ones_like(steps_s), steps_s, steps_s**2], axis=1)[:, :, None]
    ends = np.concatenate([states[:-1] * unit, states[1:] * unit], axis=1)
    coefficients: Floats = np.einsum("ij,mjk->mik", _HERMITE, ends)
    return coefficients
