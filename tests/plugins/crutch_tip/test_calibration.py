"""What the calibrations find, and what they refuse."""

import json
import subprocess
import sys

import numpy as np
import pytest

from gaitway.api import CalibrationError, CalibrationPart, SampleBatch
from gaitway_plugins.crutch_tip.force import piecewise_line
from gaitway_plugins.crutch_tip.force_fit import fit_force, fit_line
from gaitway_plugins.crutch_tip.gyro_fit import fit_gyro_scale
from gaitway_plugins.crutch_tip.inclinometer_fit import fit_inclinometer

KNOTS_VOLT = np.array([0.04, 0.5, 0.9, 2.0])
KNOTS_NEWTON = np.array([22.0, 90.0, 220.0, 500.0])
RNG = np.random.default_rng(11)


def part(answer=None, rate_hz=100.0, **channels):
    n = len(next(iter(channels.values())))
    t_ns = np.round(np.arange(n) * 1e9 / rate_hz).astype(np.int64)
    return CalibrationPart([SampleBatch(t_ns, 1.0 / rate_hz, 0, channels)], np.eye(3), answer)


def load(newton, sigma=0.0):
    volt = piecewise_line(np.array([newton]), KNOTS_NEWTON, KNOTS_VOLT)
    return part(newton + RNG.normal(0.0, sigma), force_volt=np.tile(volt, (50, 1)))


def loads(newtons, sigma=0.0):
    return [load(newton, sigma) for newton in newtons]


class TestForce:
    def test_finds_the_line_that_was_put_in(self):
        volt = np.linspace(0.04, 2.0, 400)
        newton = piecewise_line(volt, KNOTS_VOLT, KNOTS_NEWTON)
        found = fit_line(volt, newton)
        at = np.linspace(0.04, 2.0, 50)
        np.testing.assert_allclose(
            piecewise_line(at, *found), piecewise_line(at, KNOTS_VOLT, KNOTS_NEWTON), atol=1.0
        )

    def test_a_dozen_steady_loads_will_do(self):
        result = fit_force(loads(np.linspace(25.0, 480.0, 14), sigma=3.0), 0.04, 200.0)
        there = piecewise_line(
            np.array([0.3, 0.7, 1.5]),
            np.array(result.params["force_knots_volt"]),
            np.array(result.params["force_knots_newton"]),
        )
        true = piecewise_line(np.array([0.3, 0.7, 1.5]), KNOTS_VOLT, KNOTS_NEWTON)
        np.testing.assert_allclose(there, true, atol=10.0)
        text = "\n".join(result.findings)
        assert "R^2" in text
        assert "limits of agreement" in text

    def test_the_dead_zone_is_left_out(self):
        dead = [part(10.0, force_volt=np.full((50, 1), 0.01)) for _ in range(30)]
        result = fit_force([*dead, *loads(np.linspace(25.0, 480.0, 20))], 0.04, 200.0)
        assert result.params["force_knots_newton"][0] == pytest.approx(25.0, abs=3.0)

    @pytest.mark.parametrize(
        ("parts", "reason"),
        [
            (loads([50.0, 100.0, 200.0]), "8 or more"),
            (loads(np.linspace(50.0, 90.0, 20)), "span 40 N"),
            ([part(float(n), force_volt=RNG.uniform(0.1, 2.0, (9, 1))) for n in range(50, 500, 9)],
             "volts"),
            ([part(100.0, force=np.ones((9, 1)))], "force_volt is missing"),
        ],
    )  # fmt: skip
    def test_poor_readings_are_refused_with_a_reason(self, parts, reason):
        with pytest.raises(CalibrationError, match=reason):
            fit_force(parts, 0.04, 200.0)


class TestInclinometer:
    def placed(self, degrees, gain=0.97, zero_deg=1.5, sway_deg=0.02):
        return [
            part(
                float(deg),
                inclination=np.radians(RNG.normal((deg - zero_deg) / gain, sway_deg, (200, 1))),
            )
            for deg in degrees
        ]

    def test_finds_gain_and_zero(self):
        result = fit_inclinometer(self.placed([-30, -15, 0, 15, 30]), 30.0)
        assert result.params["inclination_gain"] == pytest.approx(0.97, abs=2e-3)
        assert np.degrees(result.params["inclination_offset_rad"]) == pytest.approx(1.5, abs=0.05)

    @pytest.mark.parametrize(
        ("degrees", "more", "reason"),
        [
            ([0, 10], {}, "4 different"),
            ([0, 1, 2, 3], {}, "span 3"),
            ([-30, -10, 10, 30], {"gain": -1.0}, "mounted"),
            ([-30, -10, 10, 30], {"sway_deg": 3.0}, "moved"),
        ],
    )
    def test_poor_readings_are_refused_with_a_reason(self, degrees, more, reason):
        with pytest.raises(CalibrationError, match=reason):
            fit_inclinometer(self.placed(degrees, **more), 30.0)


def turn(axis=1, degrees=90.0, gain=1.02, still_s=1.0, shake=0.001):
    t_s = np.arange(0.0, 2.0 * still_s + 1.5, 0.01)
    share = np.clip((t_s - still_s) / 1.5, 0.0, 1.0)
    angle = np.radians(degrees) * share**2 * (3.0 - 2.0 * share)
    gyro = np.radians([0.5, -0.7, 0.3]) + RNG.normal(0.0, shake, (len(t_s), 3))
    gyro[:, axis] += np.gradient(angle, 0.01) / gain
    return part(gyro=gyro)


class TestGyroScale:
    def test_finds_the_gain_whichever_way_and_whatever_the_bias(self):
        result = fit_gyro_scale([turn(), turn(degrees=-90.0), turn()], 90.0)
        assert result.params["gyro_gain"] == pytest.approx(1.02, abs=2e-3)
        assert result.warnings == []

    @pytest.mark.parametrize(
        ("parts", "reason"),
        [
            ([turn(axis=0)], "about the axis"),
            ([turn(degrees=45.0)], "45 degrees|44 degrees"),
            ([turn(still_s=0.1)], "still|short"),
            ([turn(), turn(degrees=80.0)], "differ"),
            ([turn(shake=0.1)], "still"),
            ([], "no turn"),
        ],
    )
    def test_poor_turns_are_refused_with_a_reason(self, parts, reason):
        with pytest.raises(CalibrationError, match=reason):
            fit_gyro_scale(parts, 90.0)


def plate_csv(path, seconds=30.0, noise=3.0):
    """Write what a crutch on a force plate gives: the load never stands still."""
    t_s = np.arange(0.0, seconds, 0.01)
    newton = 260.0 - 235.0 * np.cos(2.0 * np.pi * t_s / 6.0)
    volt = piecewise_line(newton, KNOTS_NEWTON, KNOTS_VOLT)
    told = newton + RNG.normal(0.0, noise, len(t_s))
    rows = np.column_stack([t_s, volt, told])
    header = "t_s,force_volt,reference_force_newton"
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.5f")
    return path


def calibrate(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "gaitway", "calibrate", "crutch-tip", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


class TestCommand:
    def test_force_from_a_force_plate_s_file_with_its_picture(self, tmp_path):
        picture = tmp_path / "force.png"
        done = calibrate("force", "--from", plate_csv(tmp_path / "a.csv"), "--picture", picture)
        assert done.returncode == 0, done.stderr
        assert "R^2 0.99" in done.stdout
        line = next(part for part in done.stdout.splitlines() if "force_knots_volt" in part)
        volts = json.loads(line.split("force_knots_volt = ")[1].split("]")[0] + "]")
        newtons = json.loads(line.split("force_knots_newton = ")[1].split("]")[0] + "]")
        at = np.linspace(0.1, 1.9, 20)
        true = piecewise_line(at, KNOTS_VOLT, KNOTS_NEWTON)
        found = piecewise_line(at, np.array(volts), np.array(newtons))
        np.testing.assert_allclose(found, true, atol=4.0)
        assert picture.read_bytes().startswith(b"\x89PNG")

    def test_a_refusal_is_status_65_and_a_reason(self, tmp_path):
        done = calibrate("force", "--from", plate_csv(tmp_path / "a.csv", noise=400.0))
        assert done.returncode == 65
        assert "R^2" in done.stderr or "volts" in done.stderr
