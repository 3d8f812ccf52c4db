"""The command line: help that teaches, statuses of sysexits.h, one JSON object."""

import csv
import json
import math
from dataclasses import replace

import pytest

from gaitway.cli import COMMANDS, main, notices
from gaitway.contracts import Calibration
from gaitway.params import Params
from gaitway.registry import Registry, load_registry


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """A short simulated walk as CSV."""
    file = tmp_path_factory.mktemp("walk") / "cane.csv"
    options = ["--distance", "1.5", "--rest", "3", "--seed", "4"]
    assert main(["simulate", "quad-cane", "--csv", str(file), *options]) == 0
    return file


def edited(walk, tmp_path, change):
    """Return a copy of a walk with its rows (header first) changed."""
    rows = list(csv.reader(walk.read_text().splitlines()))
    change(rows)
    file = tmp_path / "edited.csv"
    with file.open("w", newline="") as out:
        csv.writer(out).writerows(rows)
    return file


def estimate(file, *options):
    return main(["estimate", str(file), "--device", "quad-cane", *options])


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command, capsys):
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0
    assert len(capsys.readouterr().out.splitlines()) > 6


def test_without_a_command_all_are_listed(capsys):
    assert main([]) == 64
    listed = capsys.readouterr().out
    assert [name for name in COMMANDS if name not in listed] == []


def test_a_misspelt_command_is_refused(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["estmate"])
    assert ended.value.code == 2
    assert "estimate" in capsys.readouterr().err


def test_estimate_prints_exactly_one_json_object_with_the_promised_keys(walk, capsys):
    assert estimate(walk, "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    assert list(summary)[:7] == [
        "device", "duration_s", "walking_s", "distance_m", "distance_sigma_m", "strides",
        "stride_length_m",
    ]  # fmt: skip
    assert summary["strides"] == len(summary["stride_length_m"]) > 0
    assert summary["distance_m"] == pytest.approx(sum(summary["stride_length_m"]))


def test_events_go_into_the_one_object_when_both_are_asked_for(walk, capsys):
    assert estimate(walk, "--json", "--events") == 0
    kinds = {event["kind"] for event in json.loads(capsys.readouterr().out)["events"]}
    assert kinds == {"bout", "stride", "distance"}


def test_per_sample_estimates_have_a_row_a_sample(walk, tmp_path):
    out = tmp_path / "out.csv"
    assert estimate(walk, "--out", str(out)) == 0
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert len(rows) == len(walk.read_text().splitlines()) - 1
    assert "pos_x_m" in rows[0]


def test_a_mounting_given_by_set_turns_the_axes(walk, tmp_path, capsys):
    """The same walk with the IMU upside down, told so, gives the same distance."""

    def turn(rows):
        for row in rows[1:]:
            for column in (1, 2, 4, 5):  # x and y turn about z
                row[column] = str(-float(row[column]))

    assert estimate(walk, "--json") == 0
    upright = json.loads(capsys.readouterr().out)
    flipped = edited(walk, tmp_path, turn)
    assert estimate(flipped, "--json", "--set", "mounting.x=down", "--set", "mounting.y=left") == 0
    assert json.loads(capsys.readouterr().out)["distance_m"] == pytest.approx(
        upright["distance_m"], abs=1e-6
    )


def test_an_imu_that_sits_askew_told_so_by_components_gives_the_same_distance(
    walk, tmp_path, capsys
):
    """The IMU turned by 17 degrees about its z axis, which points forward."""
    cosine, sine = math.cos(0.3), math.sin(0.3)

    def turn(rows):
        for row in rows[1:]:
            for column in (1, 4):
                x, y = float(row[column]), float(row[column + 1])
                row[column : column + 2] = [
                    repr(cosine * x + sine * y), repr(cosine * y - sine * x)
                ]  # fmt: skip

    assert estimate(walk, "--json") == 0
    straight = json.loads(capsys.readouterr().out)
    # x is up, y is right: the turned x points up and a little to the right.
    mounting = [
        f"mounting.x=[0.0, {-sine}, {cosine}]",
        f"mounting.y=[0.0, {-cosine}, {-sine}]",
        "mounting.z=[1, 0, 0]",
    ]
    options = [word for text in mounting for word in ("--set", text)]
    assert estimate(edited(walk, tmp_path, turn), "--json", *options) == 0
    assert json.loads(capsys.readouterr().out)["distance_m"] == pytest.approx(
        straight["distance_m"], abs=1e-6
    )


def test_a_parameter_file_is_taken_and_set_goes_over_it(walk, tmp_path, capsys):
    params = tmp_path / "params.toml"
    params.write_text('method = "published"\n')
    distances = []
    for options in (
        [],
        ["--params", str(params)],
        ["--params", str(params), "--set", "method=default"],
    ):
        assert estimate(walk, "--json", *options) == 0
        distances.append(json.loads(capsys.readouterr().out)["distance_m"])
    assert distances[0] == distances[2] != distances[1]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--set", "metod=published"], "metod: unknown key (did you mean 'method'?)"),
        (["--set", "mounting.x=left"], "mounting"),
        (["--set", "mounting.x=[1.0, 0.0]"], "mounting.x: [1.0, 0.0] is neither a direction"),
        (["--set", "mounting.x=[0.5,0,0.87]"], "degrees apart, not 90"),
        (["--set", "mounting=up"], "mounting: is a table"),
        (["--set", "nonsense"], "is not KEY=VALUE"),
    ],
)
def test_a_wrong_parameter_ends_with_status_78(walk, capsys, options, message):
    assert estimate(walk, *options) == 78
    assert message in capsys.readouterr().err


def blank(rows):
    rows[40][2] = ""


def nan(rows):
    rows[40][5] = "nan"


def swap(rows):
    rows[50], rows[51] = rows[51], rows[50]


def rename(rows):
    rows[0][1] = "ax"


def off_grid(rows):
    rows[60][0] = str(float(rows[60][0]) + 0.004)


def in_g(rows):
    for row in rows[1:]:
        row[1:4] = [str(float(value) / 9.80665) for value in row[1:4]]


def in_degrees(rows):
    for row in rows[1:]:
        row[4:7] = [str(float(value) * 57.29578) for value in row[4:7]]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (blank, "41"),
        (nan, "41"),
        (swap, "sort"),
        (rename, "accel_x_mps2"),
        (off_grid, "grid"),
        (in_g, "9.80665"),
        (in_degrees, "rad"),
    ],
)
def test_a_file_that_cannot_be_used_ends_with_status_65_and_says_why(
    walk, tmp_path, capsys, change, message
):
    assert estimate(edited(walk, tmp_path, change), "--json") == 65
    told = capsys.readouterr()
    assert told.out == ""
    assert message in told.err
    assert "edited.csv" in told.err


def test_missing_rows_are_worked_with(walk, tmp_path, capsys):
    def drop(rows):
        del rows[30:40]  # while standing

    assert estimate(walk, "--json") == 0
    whole = json.loads(capsys.readouterr().out)
    assert estimate(edited(walk, tmp_path, drop), "--json") == 0
    dropped = json.loads(capsys.readouterr().out)
    assert dropped["strides"] == whole["strides"]
    assert dropped["distance_m"] == pytest.approx(whole["distance_m"], rel=0.01)


def test_a_device_that_is_not_installed_is_told_with_what_is(walk, capsys):
    assert main(["estimate", str(walk), "--device", "quadcane"]) == 78
    assert "did you mean 'quad-cane'" in capsys.readouterr().err


def test_conditions_reach_the_simulation_as_words_and_numbers(tmp_path, monkeypatch):
    asked = []
    device = load_registry().devices["quad-cane"]

    def simulate(plan):
        asked.append(dict(plan.conditions))
        return device.simulate(replace(plan, conditions={}))

    registry = Registry(devices={"quad-cane": replace(device, simulate=simulate)})
    monkeypatch.setattr("gaitway.cli.simulate.load_registry", lambda: registry)
    words = ["simulate", "quad-cane", "--csv", str(tmp_path / "x.csv"), "--distance", "1"]
    options = ["--condition", "shocks=hard", "--condition", "grade=0.5"]
    assert main([*words, *options]) == 0
    assert asked == [{"shocks": "hard", "grade": 0.5}]


@pytest.mark.parametrize(
    ("condition", "message"),
    [("hard", "--condition hard: is not KEY=VALUE"), ("a=[1]", "neither a number nor a word")],
)
def test_a_wrong_condition_is_told(tmp_path, capsys, condition, message):
    words = ["simulate", "quad-cane", "--csv", str(tmp_path / "x.csv"), "--condition", condition]
    assert main(words) == 78
    assert message in capsys.readouterr().err


def test_check_tells_what_the_gateway_would_do(capsys):
    assert main(["check", "configs/devices/quad-cane.toml"]) == 0
    told = capsys.readouterr().out
    assert "quad-cane over serial /dev/gaitway/quad-cane (xbus)" in told
    assert told.endswith("ok\n")


def test_check_tells_what_was_never_measured_and_how_to_measure_it(tmp_path, monkeypatch, capsys):
    class WalkerParams(Params):
        wheel_radius_m: float = 0.0635
        track_m: float = 0.61
        block_s: float = 0.1

    fit = Calibration("wheels", "", (), Params, lambda *_: None)
    walker = replace(
        load_registry().devices["quad-cane"],
        name="walker",
        params=WalkerParams,
        make_estimator=lambda *_: Idle(),
        measured=("wheel_radius_m", "track_m"),
        calibrations=(fit,),
    )
    registry = load_registry()
    registry.devices["walker"] = walker
    monkeypatch.setattr("gaitway.config.load.load_registry", lambda _: registry)
    driver = 'driver = { transport = "serial", port = "/dev/nowhere", codec = "xbus" }'
    config = tmp_path / "gateway.toml"
    config.write_text(
        f'[[devices]]\nid = "w"\ntype = "walker"\n{driver}\nparams = {{ track_m = 0.61 }}\n'
    )
    assert main(["check", str(config)]) == 0
    notes = [line for line in capsys.readouterr().out.splitlines() if line.startswith("note: w:")]
    port, radius = notes
    assert "port /dev/nowhere is not there now" in port
    assert "wheel_radius_m = 0.0635 is a typical one: measure yours" in radius
    assert radius.endswith(f"(gaitway calibrate {config} w wheels)")


class Idle:
    look_ahead_s = 0.0


def test_check_tells_what_a_restart_does(tmp_path, capsys):
    config = tmp_path / "gateway.toml"
    for within_s, text in ((60, "goes on within 60 s"), (0, "every device begins anew")):
        config.write_text(f"resume = {{ within_s = {within_s} }}\n")
        assert main(["check", str(config)]) == 0
        assert f"restart: {text}" in capsys.readouterr().out


def test_plugins_explains_the_parameters_of_one(capsys):
    assert main(["plugins", "xbus"]) == 0
    assert "listen_only = False" in capsys.readouterr().out


@pytest.mark.parametrize("command", [["plugins"], ["check", "configs/gateway.toml"]])
@pytest.mark.parametrize("compiled", [True, False])
def test_missing_kernels_are_noticed_in_one_line(command, compiled, capsys, monkeypatch):
    monkeypatch.setattr(notices, "COMPILED", compiled)
    assert main(command) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if "kernels" in line]
    assert lines == ([] if compiled else [notices.MISSING_KERNELS])
