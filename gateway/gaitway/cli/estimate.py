"""Estimate a walk offline, with the live estimator itself, fed in batches.

INPUT is a recording of ours (--id picks the device) or a CSV file whose header names what it holds:
t_s, accel_x_mps2, accel_y_mps2, accel_z_mps2, gyro_x_radps, gyro_y_radps, gyro_z_radps, and where
the device needs them q_w..q_z, force_newton, force_volt, inclination_rad, inclination_roll_rad,
left_ticks, right_ticks. Axes are the IMU's; mounting says how it sits:

    gaitway estimate walk.csv --device quad-cane --json
    gaitway estimate walk.csv --device shank --set method=wsi --set mounting.x=up ...

A device that learns takes a training walk (gaitway calibrate lists what each can learn):

    gaitway estimate walk.csv --device shank --train known.csv --train-set distance_m=20

Missing rows of the sample grid are gaps and are worked with. Exit status 65: the file can't be
used, and the message says which line and why, or the training walk is refused; 78: a parameter is
wrong.
"""

import argparse
import csv
import json
import math
import sys
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gaitway.cli.settings import assignments, calibration_options
from gaitway.config.problems import Problem, did_you_mean, validate
from gaitway.contracts import CalibrationResult, DeviceType, Estimator, Trace
from gaitway.errors import ConfigError, InputDataError
from gaitway.mounting import mounting_table, rotation_from_mounting
from gaitway.offline.csv_input import read_csv
from gaitway.offline.recording import OfflineRecording
from gaitway.offline.run import run_estimator, summarise
from gaitway.params import Params
from gaitway.registry import load_registry
from gaitway.samples import Floats
from gaitway.timebase import NS_PER_S


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "input", type=Path, metavar="INPUT", help="a .csv file or a .mcap recording"
    )
    parser.add_argument("--device", metavar="TYPE", help="device type; an MCAP file knows its own")
    parser.add_argument("--id", metavar="ID", help="which device of an MCAP file")
    parser.add_argument("--params", type=Path, metavar="FILE.toml", help="parameters and mounting")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="one parameter, as in TOML; mounting.x=up or mounting.x=[1,0,0] sets one axis",
    )
    parser.add_argument(
        "--train", type=Path, metavar="FILE", help="training walk (.csv, .mcap), for what learns"
    )
    parser.add_argument(
        "--train-set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="an option of the training, as in TOML",
    )
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object and nothing else"
    )
    parser.add_argument(
        "--events",
        action="store_true",
        help="print every event as JSON, a line each; with --json inside its object",
    )
    parser.add_argument("--out", type=Path, metavar="FILE.csv", help="write per-sample estimates")


def run(arguments: argparse.Namespace) -> int:
    """Read, estimate, print."""
    recording, device = _read(arguments)
    settings = _Settings(recording, device, arguments.params, arguments.set)
    params, C_db = settings.checked()
    if arguments.train is not None:
        _train(settings, arguments, params, C_db)
        params, C_db = settings.checked()
    estimator: Estimator = device.make_estimator(params, C_db)
    trace = estimator.start_trace() if arguments.out else None
    events = run_estimator(estimator, recording, C_db)
    if trace is not None:
        write_trace(trace, arguments.out)
    for note in recording.notes:
        print(f"gaitway estimate: {note}", file=sys.stderr)
    summary = summarise(device, recording, events)
    told = [{"kind": event.kind, **event.model_dump()} for event in events]
    if arguments.json:
        print(json.dumps(summary | {"events": told} if arguments.events else summary))
    elif arguments.events:
        for event in told:
            print(json.dumps(event))
    else:
        _print_summary(summary)
    return 0


class _Settings:
    """Parameters and mounting, each from the last that names it.

    In this order: the device type's defaults, the recording, ``--params``, what was learned from a
    training walk, ``--set``.

    Args:
        recording: May bring its own.
        device: The device type.
        file: Of ``--params``.
        assigned: Of ``--set``.
    """

    def __init__(
        self,
        recording: OfflineRecording,
        device: DeviceType,
        file: Path | None,
        assigned: Sequence[str],
    ) -> None:
        self.device, self._source = device, file or Path("--set")
        mounting = recording.mounting or device.default_mounting
        self._layers: list[Mapping[str, Any]] = [{**recording.params, "mounting": dict(mounting)}]
        if file:
            self._layers.append(_toml(file))
        self._assigned = assignments(assigned)

    def learn(self, result: CalibrationResult) -> None:
        """Take what was found in a training walk."""
        mounting = {} if result.mounting is None else mounting_table(result.mounting)
        self._layers.append({**result.params, "mounting": mounting})

    def checked(self) -> tuple[Params, Floats]:
        """Return the parameters, and the mounting as ``C_db``.

        Raises:
            ConfigError: Something is wrong with them.
        """
        values, mounting = self._merged()
        problems: list[Problem] = []
        params = validate(self.device.params, values, self._source, "", problems)
        try:
            C_db = rotation_from_mounting(mounting)
        except ValueError as exc:
            text = str(exc).removeprefix("mounting: ")
            problems.append(Problem(self._source, "mounting", text))
        if problems:
            raise ConfigError("\n".join(str(problem) for problem in problems))
        assert params is not None
        return params, C_db

    def _merged(self) -> tuple[dict[str, Any], dict[str, Any]]:
        values: dict[str, Any] = {}
        mounting: dict[str, Any] = {}
        for layer in (*self._layers, self._assigned):
            own = dict(layer)
            table = own.pop("mounting", {})
            if not isinstance(table, dict):
                raise ConfigError(
                    'mounting: is a table as { x = "up", y = "right", z = "forward" }'
                )
            mounting |= table
            values |= own
        return values, mounting


def _train(
    settings: _Settings, arguments: argparse.Namespace, params: Params, C_db: Floats
) -> None:
    """Let the device learn from a walk; tell what it found."""
    device = settings.device
    calibration = next((known for known in device.calibrations if known.trains), None)
    if calibration is None:
        raise InputDataError(f"--train: {device.name} learns nothing from a training walk")
    from gaitway.offline.calibration_input import parts_of_files  # noqa: PLC0415  heavy

    options = calibration_options(calibration, "--train-set", arguments.train_set)
    parts = parts_of_files([arguments.train], calibration, C_db, arguments.id, device.requires)
    result = calibration.fit(params, options, parts)
    for finding in result.findings:
        print(f"gaitway estimate: learned: {finding}", file=sys.stderr)
    for warning in result.warnings:
        print(f"gaitway estimate: doubtful: {warning}", file=sys.stderr)
    settings.learn(result)


def write_trace(trace: Trace, path: Path) -> None:
    """Write per-sample estimates as CSV: time in seconds, then the trace's columns.

    What is not known yet is an empty cell.
    """
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["t_s", *trace.columns])
        for t_ns, row in zip(trace.t_ns, trace.rows, strict=True):
            cells = ("" if math.isnan(value) else f"{value:.9g}" for value in row)
            writer.writerow([f"{t_ns / NS_PER_S:.6f}", *cells])


def _read(arguments: argparse.Namespace) -> tuple[OfflineRecording, DeviceType]:
    registry = load_registry()
    path: Path = arguments.input
    if not path.is_file():
        raise InputDataError(f"{path}: no such file")
    if path.suffix in (".mcap", ".active"):
        from gaitway.offline.mcap_input import read_mcap  # noqa: PLC0415  heavy

        recording = read_mcap(path, arguments.id)
        name = arguments.device or recording.device_type
        if name is None:
            raise InputDataError(f"{path}: does not say what the device is (add --device TYPE)")
        device = _device(name, registry.devices)
        recording.require(device.requires)
        return recording, device
    if arguments.device is None:
        raise InputDataError(f"{path}: a CSV file does not say what the device is (add --device)")
    device = _device(arguments.device, registry.devices)
    return read_csv(path, device.requires), device


def _device(name: str, devices: Mapping[str, DeviceType]) -> DeviceType:
    if name not in devices:
        raise ConfigError(f"--device: {name!r} is not installed ({did_you_mean(name, devices)})")
    return devices[name]


def _toml(file: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as exc:
        raise ConfigError(f"{file}: {exc}") from exc


def _print_summary(summary: Mapping[str, Any]) -> None:
    for name, value in summary.items():
        print(f"{name:20} {_shown(value)}")


def _shown(value: Any) -> str:
    if value is None:
        return "unknown"
    if isinstance(value, float):
        return f"{value:.3f}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return " ".join(_shown(item) for item in value)
    return str(value)
