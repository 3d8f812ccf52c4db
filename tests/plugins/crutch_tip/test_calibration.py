"""The three calibrations: what is found, and what is refused."""

import numpy as np
import pytest

from gaitway.api import CalibrationError, CalibrationPart, SampleBatch
from gaitway_plugins.crutch_tip.calibration import CALIBRATIONS
from gaitway_plugins.crutch_tip.force import piecewise_line
from gaitway_plugins.crutch_tip.params import (
    PAPER_KNOTS_NEWTON,
    PAPER_KNOTS_VOLT,
    CrutchTipParams,
)


def part(name, values, answer, C_db=None):
    values = np.asarray(values, float).reshape(len(values), -1)
    t_ns = np.arange(len(values), dtype=np.int64) * 10_000_000
    batch = SampleBatch(t_ns, 0.01, 0, {name: values})
    return CalibrationPart([batch], np.eye(3) if C_db is None else C_db, answer)


def fit(name, parts, **options):
    calibration = next(known for known in CALIBRATIONS if known.name == name)
    result = calibration.fit(CrutchTipParams(), calibration.options(**options), parts)
    CrutchTipParams.model_validate(dict(result.params))
    return result


def loads(count, noise_newton, seed=0):
    rng = np.random.default_rng(seed)
    volts = np.linspace(0.06, 1.9, count)
    knots = np.array(PAPER_KNOTS_VOLT), np.array(PAPER_KNOTS_NEWTON)
    newtons = piecewise_line(volts, *knots) + noise_newton * rng.standard_normal(count)
    return [part("force_volt", [v] * 20, n) for v, n in zip(volts, newtons, strict=True)]


def test_force_finds_the_line_of_the_paper():
    params = fit("force", loads(60, 0.5)).params
    volts = np.linspace(0.1, 1.8, 40)
    found = piecewise_line(
        volts, np.array(params["force_knots_volt"]), np.array(params["force_knots_newton"])
    )
    true = piecewise_line(volts, np.array(PAPER_KNOTS_VOLT), np.array(PAPER_KNOTS_NEWTON))
    assert np.sqrt(np.mean((found - true) ** 2)) < 2.0


def test_force_tells_its_error_and_draws_it():
    from matplotlib.figure import Figure

    result = fit("force", loads(40, 6.0))
    assert 3.0 < result.params["force_sigma_newton"] < 9.0
    assert any("Bland-Altman" in line for line in result.findings)
    figure = Figure()
    result.picture(figure)
    assert len(figure.axes) == 2


@pytest.mark.parametrize(
    ("parts", "why"),
    [
        (loads(4, 0.0), "4 loads"),
        ([part("force_volt", [0.1 + 0.01 * k] * 5, 20.0 + k) for k in range(8)], "span"),
        ([part("force_volt", [0.5 - 0.05 * k] * 5, 60.0 * k) for k in range(8)], "rise"),
        ([part("force", [1.0] * 5, 60.0 * k) for k in range(8)], "force_volt"),
    ],
)
def test_force_is_refused(parts, why):
    with pytest.raises(CalibrationError, match=why):
        fit("force", parts)


def test_inclinometer_finds_gain_and_offset():
    parts = [part("inclination", [(a - 0.03) / 1.02] * 9, a) for a in (-0.5, -0.2, 0.1, 0.4)]
    params = fit("inclinometer", parts).params
    assert params["inclination_gain"] == pytest.approx(1.02)
    assert params["inclination_offset_rad"] == pytest.approx(0.03)


def test_inclinometer_the_wrong_way_round_is_refused():
    parts = [part("inclination", [-a] * 9, a) for a in (-0.5, 0.0, 0.5)]
    with pytest.raises(CalibrationError, match="tip is ahead"):
        fit("inclinometer", parts)


def turn(angle_rad, scale=1.0, bias_radps=0.01):
    rate = np.zeros((400, 3))
    rate[100:300, 1] = angle_rad * scale / 2.0 * (1.0 - np.cos(np.linspace(0, 2 * np.pi, 200)))
    return part("gyro", rate + bias_radps, angle_rad)


def test_gyro_scale_is_found_whatever_the_bias():
    params = fit("gyro-scale", [turn(np.pi, 1 / 1.03), turn(-np.pi / 2, 1 / 1.03)]).params
    assert params["gyro_gain"] == pytest.approx(1.03, rel=0.006)


@pytest.mark.parametrize("parts", [[turn(0.3)], [turn(np.pi, -1.0)], []])
def test_gyro_scale_is_refused(parts):
    with pytest.raises(CalibrationError):
        fit("gyro-scale", parts)
