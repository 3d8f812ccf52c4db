"""Estimate a walk offline, with the live estimator itself, fed in batches.

INPUT is a recording of ours (--id picks the device) or a CSV file whose header names what it holds:
t_s, accel_x_mps2, accel_y_mps2, accel_z_mps2, gyro_x_radps, gyro_y_radps, gyro_z_radps, and where
the device needs them q_w..q_z, force_newton, force_volt, inclination_rad, inclination_roll_rad,
left_ticks, right_ticks. Axes are the IMU's; mounting says how it sits:

    gaitway estimate walk.csv --device quad-cane --json
    gaitway estimate walk.csv --device shank --set method=wsi --set mounting.x=up ...

Missing rows of the sample grid are gaps and are worked with. Exit status 65: the file can't be
used, and the message says which line and why; 78: a parameter is wrong.
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

from gaitway.cli.settings import assignments
from gaitway.config.problems import Problem, did_you_mean, validate
from gaitway.contracts import DeviceType, Estimator, Trace
from gaitway.errors import ConfigError, InputDataError
from gaitway.mounting import rotation_from_mounting
from gaitway.offline.csv_input import read_csv
from gaitway.offline.mcap_input import read_mcap
from gaitway.offline.recording import OfflineRecording
from gaitway.offline.run import run_estimator, summarise
from gaitway.registry import load_registry
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
        help="one parameter, as in TOML; mounting.x=up sets one axis",
    )
    parser.add_argument(
        "--train", type=Path, metavar="FILE", help="training walk, for devices that learn"
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
    settings = _settings(arguments)
    mounting, values = _split_mounting(settings, recording, device)
    problems: list[Problem] = []
    source = arguments.params or Path("--set")
    params = validate(device.params, values, source, "", problems)
    try:
        C_db = rotation_from_mounting(mounting)
    except ValueError as exc:
        problems.append(Problem(source, "mounting", str(exc).removeprefix("mounting: ")))
    if problems:
        raise ConfigError("\n".join(str(problem) for problem in problems))
    if arguments.train is not None:
        raise InputDataError(f"--train: {device.name} learns nothing from a training walk")
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


def _settings(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the parameters of the file, then those of --set over them."""
    settings: dict[str, Any] = {}
    if arguments.params:
        try:
            settings = tomllib.loads(arguments.params.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as exc:
            raise ConfigError(f"{arguments.params}: {exc}") from exc
    return assignments(arguments.set, settings)


def _split_mounting(
    settings: Mapping[str, Any], recording: OfflineRecording, device: DeviceType
) -> tuple[Mapping[str, str], dict[str, Any]]:
    """Return the mounting and the estimator's parameters; a recording brings its own."""
    values = dict(recording.params or {})
    mounting = dict(recording.mounting or device.default_mounting)
    for key, value in settings.items():
        if key == "mounting":
            if not isinstance(value, dict) or not all(isinstance(v, str) for v in value.values()):
                raise ConfigError(
                    'mounting: is a table as { x = "up", y = "right", z = "forward" }'
                )
            mounting |= value
        else:
            values[key] = value
    return mounting, values


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
