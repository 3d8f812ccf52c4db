"""The force calibration: a continuous line of few pieces from volts to newtons."""

from collections.abc import Sequence
from functools import partial
from itertools import combinations
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
from gaitway_plugins.crutch_tip.force import piecewise_line

MIN_LOADS: Final = 6
LOADS_A_PIECE: Final = 3
MIN_SPAN_NEWTON: Final = 100.0
MIN_R2: Final = 0.98
CANDIDATES: Final = 16
PAPER_RMS_NEWTON: Final = 8.78


def channel_mean(part: CalibrationPart, name: str, column: int = 0) -> float:
    """Return the mean of a channel over all samples of a part.

    Raises:
        CalibrationError: The part holds none of it.
    """
    values = [
        item.channels[name][:, column]
        for item in part.items
        if isinstance(item, SampleBatch) and name in item.channels
    ]
    if not values:
        raise CalibrationError(f"nothing of the channel {name} was recorded (check the device)")
    return float(np.mean(np.concatenate(values)))


def fit_force(parts: Sequence[CalibrationPart], pieces: int) -> CalibrationResult:
    """Return the line of at most ``pieces`` pieces through the loads of all parts.

    Raises:
        CalibrationError: Too few loads, too little range, or no line fits them.
    """
    volts = np.array([channel_mean(part, FORCE_VOLT.name) for part in parts])
    newtons = np.array([np.nan if part.answer is None else part.answer for part in parts])
    _check(volts, newtons)
    knots_x, knots_y = continuous_line(volts, newtons, pieces)
    if np.any(np.diff(knots_y) <= 0.0):
        raise CalibrationError("the force does not rise with the voltage (check the wiring)")
    error = piecewise_line(volts, knots_x, knots_y) - newtons
    r2 = 1.0 - float(np.var(error) / np.var(newtons))
    if r2 < MIN_R2:
        raise CalibrationError(
            f"R^2 is {r2:.3f}, {MIN_R2} is asked for: loads and voltages don't belong together "
            "(hold each load still while it is recorded)"
        )
    return _result(volts, newtons, error, knots_x, knots_y, r2)


def continuous_line(x: Floats, y: Floats, pieces: int) -> tuple[Floats, Floats]:
    """Return knots of the continuous piecewise line of least squares, ends included.

    A line with inner knots k is ``a + b x + sum c_i max(0, x - k_i)``: linear but for the knots,
    which are searched on a grid of quantiles. Another piece is taken only where it lessens
    Schwarz's criterion, so that few loads don't make many pieces.
    """
    best: Floats = np.empty(0)
    lowest = np.inf
    grid = np.unique(np.quantile(x, np.linspace(0.1, 0.9, CANDIDATES)))
    for count in range(min(pieces, len(x) // LOADS_A_PIECE)):
        for inner in combinations(grid.tolist(), count):
            edges = np.array([-np.inf, *inner, np.inf])
            if np.histogram(x, edges)[0].min() < 2:
                continue
            knots = np.array(inner)
            residual = y - _basis(x, knots) @ _solved(x, y, knots)
            criterion = len(x) * np.log(max(float(np.mean(residual**2)), 1e-12))
            criterion += (2 + 2 * count) * np.log(len(x))
            if criterion < lowest:
                best, lowest = knots, criterion
    knots_x = np.array([min(0.0, float(x.min())), *best, float(x.max())])
    return knots_x, _basis(knots_x, best) @ _solved(x, y, best)


def _basis(x: Floats, knots: Floats) -> Floats:
    return np.column_stack([np.ones_like(x), x, np.maximum(0.0, x[:, np.newaxis] - knots)])


def _solved(x: Floats, y: Floats, knots: Floats) -> Floats:
    solution = np.linalg.lstsq(_basis(x, knots), y, rcond=None)[0]
    return np.asarray(solution, dtype=np.float64)


def _check(volts: Floats, newtons: Floats) -> None:
    if np.isnan(newtons).any():
        raise CalibrationError("a load without its force: type what the scale shows")
    if len(volts) < MIN_LOADS:
        raise CalibrationError(f"{len(volts)} loads: {MIN_LOADS} or more are needed")
    if np.ptp(newtons) < MIN_SPAN_NEWTON:
        raise CalibrationError(
            f"the loads span {np.ptp(newtons):.0f} N: {MIN_SPAN_NEWTON:.0f} N or more are needed"
        )


def _result(
    volts: Floats, newtons: Floats, error: Floats, knots_x: Floats, knots_y: Floats, r2: float
) -> CalibrationResult:
    freedom = max(1, len(error) - (2 * len(knots_x) - 2))
    rms = float(np.sqrt(np.sum(error**2) / freedom))
    bias, spread = float(np.mean(error)), 1.96 * float(np.std(error, ddof=1))
    warnings = []
    if rms > PAPER_RMS_NEWTON:
        warnings.append(f"RMS {rms:.1f} N; the paper reaches {PAPER_RMS_NEWTON} N")
    return CalibrationResult(
        params={
            "force_knots_volt": [round(value, 5) for value in knots_x.tolist()],
            "force_knots_newton": [round(value, 3) for value in knots_y.tolist()],
            "force_sigma_newton": round(max(rms, 1.0), 2),
        },
        findings=[
            f"{len(knots_x) - 1} straight pieces through {len(volts)} loads, R^2 = {r2:.4f}",
            f"RMS {rms:.2f} N (degrees of freedom taken off)",
            f"Bland-Altman: {bias:+.2f} N, limits {bias - spread:+.1f}, {bias + spread:+.1f} N",
        ],
        warnings=warnings,
        picture=partial(_draw, volts, newtons, error, knots_x, knots_y),
    )


def _draw(
    volts: Floats, newtons: Floats, error: Floats, knots_x: Floats, knots_y: Floats, figure: Any
) -> None:
    line, agreement = figure.subplots(1, 2)
    line.plot(volts, newtons, "o", label="loads")
    line.plot(knots_x, knots_y, "-", label="fit")
    line.set(xlabel="volt", ylabel="newton", title="Calibration")
    line.legend()
    bias, spread = float(np.mean(error)), 1.96 * float(np.std(error, ddof=1))
    agreement.plot(newtons + 0.5 * error, error, "o")
    for level in (bias - spread, bias, bias + spread):
        agreement.axhline(level, linestyle="--", color="gray")
    agreement.set(xlabel="mean of both, newton", ylabel="fit - scale, newton", title="Bland-Altman")
