"""``gaitway estimate --train``: what a device learns from a walk is used for the next one."""

import json

import numpy as np
import pytest

from gaitway.cli import main
from gaitway.contracts import Calibration, CalibrationResult, DeviceType
from gaitway.errors import CalibrationError
from gaitway.events import Anomaly
from gaitway.mounting import rotation_from_mounting
from gaitway.params import Params
from gaitway.registry import Registry
from gaitway.samples import ACCEL, FORCE, FORCE_VOLT, Gap


class PoleParams(Params):
    gain: float = 1.0
    offset: float = 0.0


class WalkOptions(Params):
    distance_m: float
    hurry: bool = False


class Teller:
    """An estimator that says with what it was made and what it is given."""

    look_ahead_s = 0.0

    def __init__(self, params, C_db):
        self.made = {**params.model_dump(), "C_db": C_db.tolist()}
        self.channels = []

    def update(self, item):
        if not isinstance(item, Gap):
            self.channels = sorted(item.channels)
        return []

    def finish(self):
        detail = json.dumps(self.made | {"channels": self.channels})
        return [Anomaly(t_ns=0, anomaly="made", detail=detail)]


def fit(params, options, parts):
    if options.hurry:
        raise CalibrationError("too short (walk 20 m)")
    n = sum(len(part.items[0]) for part in parts)
    return CalibrationResult(
        params={"gain": options.distance_m / n, "offset": params.offset + 1.0},
        findings=[f"gain {options.distance_m / n} +- 0.1"],
        mounting=parts[0].C_db @ rotation_from_mounting({"x": "left", "y": "backward", "z": "up"}),
        warnings=["the walk was short"],
    )


LEARNS = Calibration("walk", "", (), WalkOptions, fit, trains=True)
OTHER = Calibration("other", "", (), Params, fit)


def pole(*calibrations):
    return DeviceType(
        "pole",
        "",
        (ACCEL, (FORCE, FORCE_VOLT)),
        PoleParams,
        Teller,
        summarise=lambda events: {"distance_m": None} | json.loads(events[0].detail),
        calibrations=calibrations,
    )


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Return a function that estimates a walk with a pole; it gives status, JSON and stderr."""
    for name, rows in (("walk", 50), ("known", 100)):
        table = np.column_stack([np.arange(rows) * 0.01, np.tile([0.0, 0.0, 9.8, 50.0], (rows, 1))])
        header = "t_s,accel_x_mps2,accel_y_mps2,accel_z_mps2,force_newton"
        np.savetxt(
            tmp_path / f"{name}.csv", table, delimiter=",", header=header, comments="", fmt="%.6g"
        )

    def estimate(*options, calibrations=(OTHER, LEARNS), train="known.csv"):
        registry = Registry(devices={"pole": pole(*calibrations)})
        monkeypatch.setattr("gaitway.cli.estimate.load_registry", lambda: registry)
        taught = ["--train", str(tmp_path / train)] if train else []
        words = ["estimate", str(tmp_path / "walk.csv"), "--device", "pole", "--json"]
        status = main([*words, *taught, *options])
        out, err = capsys.readouterr()
        return status, json.loads(out) if out else None, err

    return estimate


def test_parameters_and_mounting_are_learned_and_told(run):
    status, summary, err = run("--train-set", "distance_m=20")
    assert status == 0
    assert (summary["gain"], summary["offset"]) == (0.2, 1.0)
    assert summary["C_db"] == [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    assert "learned: gain 0.2 +- 0.1" in err
    assert "doubtful: the walk was short" in err


def test_set_goes_over_what_was_learned_and_is_known_to_the_training(run, tmp_path):
    (tmp_path / "pole.toml").write_text("gain = 7.0\noffset = 5.0\n")
    options = ("--params", str(tmp_path / "pole.toml"), "--train-set", "distance_m=20")
    _, summary, _ = run(*options)
    assert (summary["gain"], summary["offset"]) == (0.2, 6.0)
    _, summary, _ = run(*options, "--set", "gain=3", "--set", "mounting.z=[0,0,1]")
    assert (summary["gain"], summary["offset"]) == (3.0, 6.0)


def test_without_training_nothing_is_learned(run):
    status, summary, err = run(train=None)
    assert (status, summary["gain"], err) == (0, 1.0, "")


def test_a_refused_training_walk_ends_with_status_65_and_the_reason(run):
    status, summary, err = run("--train-set", "distance_m=20", "--train-set", "hurry=true")
    assert (status, summary) == (65, None)
    assert "too short (walk 20 m)" in err


@pytest.mark.parametrize(
    ("options", "changes", "status", "message"),
    [
        ([], {}, 78, "--train-set: distance_m: is missing"),
        (["--train-set", "distance_m=1", "--train-set", "distanc_m=1"], {}, 78, "did you mean"),
        ([], {"calibrations": (OTHER,)}, 65, "pole learns nothing from a training walk"),
        (["--train-set", "distance_m=1"], {"train": "none.csv"}, 65, "none.csv: no such file"),
    ],
)
def test_what_can_t_be_learned_from_is_told(run, options, changes, status, message):
    found, _, err = run(*options, **changes)
    assert found == status
    assert message in err


def test_a_training_walk_needs_the_channels_of_the_device(run, tmp_path):
    file = tmp_path / "known.csv"
    file.write_text(file.read_text().replace("force_newton", "pressure_pa"))
    status, _, err = run("--train-set", "distance_m=1")
    assert status == 65
    assert "known.csv: line 1: columns missing: force_newton or force_volt" in err


@pytest.mark.parametrize("column", ["force_newton", "force_volt"])
def test_of_alternative_channels_any_one_will_do(run, tmp_path, column):
    file = tmp_path / "walk.csv"
    file.write_text(file.read_text().replace("force_newton", column))
    status, summary, _ = run(train=None)
    assert status == 0
    assert summary["channels"] == ["accel", "force" if "newton" in column else "force_volt"]


def test_a_device_may_say_that_distance_is_not_known(run):
    _, summary, _ = run(train=None)
    assert summary["distance_m"] is None
    assert list(summary).index("distance_m") == 3  # in its usual place
