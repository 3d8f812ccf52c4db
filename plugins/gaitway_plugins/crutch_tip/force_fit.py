"""From volts and newtons to the continuous piecewise line of the force sensor.

Sesar et al. (2019), Eqs. 1 to 3, fit three lines by themselves, with limits set by hand; theirs
jump by 5 to 6 N. Here the pieces meet, and where they meet is fitted too.
"""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from gaitway.api import (
    FORCE_VOLT,
    CalibrationError,
    CalibrationPart,
    CalibrationResult,
    Floats,
    SampleBatch,
)
from gaitway_plugins.crutch_tip.agreement import Agreement
from gaitway_plugins.crutch_tip.force import piecewise_line

LEAST_READINGS: Final = 8
LEAST_R_SQUARED: Final = 0.95
DOUBTFUL_NEWTON: Final = 20.0
LEAST_SIGMA_NEWTON: Final = 2.0
PLACES: Final = 20
"""Places tried for each knot at a time, of equally many readings each."""
LEAST_SHARE: Final = 0.08
"""Of the readings have to lie on each piece."""


def fit_force(
    parts: Sequence[CalibrationPart], dead_volt: float, least_newton: float
) -> CalibrationResult:
    """Return the knots of the line from volts to newtons.

    Args:
        parts: One a steady load, or one a sample where the load never stood still.
        dead_volt: Readings below tell nothing.
        least_newton: Span of forces that has to be covered.

    Raises:
        CalibrationError: The readings don't make a line.
    """
    volt, newton = _readings(parts)
    alive = volt >= dead_volt
    volt, newton = volt[alive], newton[alive]
    if len(volt) < LEAST_READINGS:
        raise CalibrationError(
            f"{len(volt)} readings above {dead_volt} V: take {LEAST_READINGS} or more"
        )
    span = float(np.ptp(newton))
    if span < least_newton:
        raise CalibrationError(
            f"the forces span {span:.0f} N: load the crutch from little to {least_newton:.0f} N "
            "and more"
        )
    knots_volt, knots_newton = fit_line(volt, newton)
    agreement = Agreement(piecewise_line(volt, knots_volt, knots_newton), newton, "N")
    _judge(agreement, knots_newton)
    doubts = [] if agreement.rms <= DOUBTFUL_NEWTON else ["load slowly: friction or delay shows"]

    def picture(figure: Any) -> None:
        line, difference = figure.subplots(2, 1)
        line.plot(volt, newton, ".", markersize=4, label="reference")
        line.plot(knots_volt, knots_newton, "o-", label="fit")
        line.set(xlabel="V", ylabel="N", title="Force")
        line.legend()
        agreement.draw(difference)

    return CalibrationResult(
        params={
            "force_knots_volt": np.round(knots_volt, 4).tolist(),
            "force_knots_newton": np.round(knots_newton, 2).tolist(),
            "force_sigma_newton": round(max(LEAST_SIGMA_NEWTON, agreement.rms), 2),
        },
        findings=[
            "knots "
            + ", ".join(
                f"{v:.3f} V = {n:.1f} +- {agreement.rms:.1f} N"
                for v, n in zip(knots_volt, knots_newton, strict=True)
            ),
            *agreement.findings(),
        ],
        warnings=doubts,
        picture=picture,
    )


def fit_line(volt: Floats, newton: Floats) -> tuple[Floats, Floats]:
    """Return the four knots of the continuous line of least squares with two free inner ones.

    The inner knots are moved in turn between places with equally many readings, ever closer.

    Args:
        volt: Shape (n,).
        newton: Shape (n,).
    """
    order = np.sort(volt)
    shares = np.array([0.33, 0.67])
    reach = 0.33
    while reach > 0.5 / len(volt) and reach > 1e-3:
        for inner in (0, 1, 0, 1):
            tried = shares[inner] + reach * np.linspace(-1.0, 1.0, PLACES)
            shares[inner] = min(
                tried.tolist(),
                key=lambda at: _misfit(_with(shares, inner, at), order, volt, newton),
            )
        reach *= 0.4
    knots = _knots(shares, order)
    return knots, _heights(knots, volt, newton)


def _with(shares: Floats, inner: int, at: float) -> Floats:
    moved = shares.copy()
    moved[inner] = at
    return moved


def _misfit(shares: Floats, order: Floats, volt: Floats, newton: Floats) -> float:
    edges = np.array([0.0, *shares, 1.0])
    knots = _knots(np.clip(shares, 0.0, 1.0), order)
    if (np.diff(edges) < LEAST_SHARE).any() or (np.diff(knots) <= 0.0).any():
        return float("inf")
    missing = piecewise_line(volt, knots, _heights(knots, volt, newton)) - newton
    return float(missing @ missing)


def _knots(shares: Floats, order: Floats) -> Floats:
    return np.array([order[0], *np.quantile(order, shares).tolist(), order[-1]])


def _heights(knots: Floats, volt: Floats, newton: Floats) -> Floats:
    """Return the newtons at knots that fit best: hat functions, least squares."""
    hats = [np.interp(volt, knots, row) for row in np.eye(len(knots))]
    return np.array(np.linalg.lstsq(np.array(hats).T, newton, rcond=None)[0].tolist())


def _readings(parts: Sequence[CalibrationPart]) -> tuple[Floats, Floats]:
    """Return mean volts and the newtons that were told, of each part."""
    volt, newton = [], []
    for part in parts:
        batches = [item for item in part.items if isinstance(item, SampleBatch)]
        if any(FORCE_VOLT.name not in batch.channels for batch in batches):
            raise CalibrationError("force_volt is missing: the device tells newtons already")
        if batches and part.answer is not None:
            values = np.concatenate([batch.channels[FORCE_VOLT.name][:, 0] for batch in batches])
            volt.append(float(np.nanmean(values)))
            newton.append(part.answer)
    known = np.isfinite(volt) & np.isfinite(newton)
    return np.array(volt)[known], np.array(newton)[known]


def _judge(agreement: Agreement, knots_newton: Floats) -> None:
    if (np.diff(knots_newton) <= 0.0).any():
        raise CalibrationError(
            "more volts do not mean more newtons everywhere: cover the range evenly, load and "
            "relieve slowly"
        )
    if agreement.r_squared < LEAST_R_SQUARED:
        raise CalibrationError(
            f"R^2 {agreement.r_squared:.3f}: volts and newtons do not belong together (are plate "
            "and crutch recorded at the same time?)"
        )
