"""Calibrate a device: be told what to do, do it, see the fit, have the result in the configuration.

    gaitway calibrate                                 what can be calibrated
    gaitway calibrate gateway.toml left-cane tip      guided, live; stop the gateway first
    gaitway calibrate gateway.toml left-cane tip --from turns.csv
    gaitway calibrate standard-cane tip --from turns.csv      only print what was found

With --from a file takes the place of the guided recording: columns as for gaitway estimate, and
reference_<what a step asks for> where one does (reference_force_newton for a crutch's force).
Exit status 65: refused, and the message says why and what to do better; nothing was written.
"""

import argparse
import asyncio
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from gaitway.cli.settings import calibration_options
from gaitway.config.edit import write_settings
from gaitway.config.load import ResolvedDevice, load_config
from gaitway.config.problems import did_you_mean
from gaitway.contracts import (
    Calibration,
    CalibrationPart,
    CalibrationResult,
    CalibrationStep,
    DeviceType,
)
from gaitway.errors import ConfigError, InputDataError
from gaitway.mounting import mounting_table, rotation_from_mounting
from gaitway.offline.calibration_input import parts_of_files
from gaitway.params import Params
from gaitway.registry import load_registry
from gaitway.runtime.capture import Capture
from gaitway.samples import Floats
from gaitway.timebase import HostClock

PICTURE_INCHES: Final = (8.0, 6.0)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "what", nargs="*", metavar="WHAT", help="CONFIG DEVICE CALIBRATION, or TYPE CALIBRATION"
    )
    parser.add_argument(
        "--from", dest="files", action="append", type=Path, default=[], metavar="FILE",
        help="a recording in the place of the guide (.csv, .mcap); may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE",
        help="an option of the calibration, as in TOML",
    )  # fmt: skip
    parser.add_argument("--picture", type=Path, metavar="FILE.png", help="where the fit is drawn")
    parser.add_argument("--yes", action="store_true", help="write the result without asking")


def run(arguments: argparse.Namespace) -> int:
    """List, or calibrate."""
    if len(arguments.what) < 2:
        return _list(arguments.what)
    if len(arguments.what) > 3:
        raise InputDataError("too many words (CONFIG DEVICE CALIBRATION, or TYPE CALIBRATION)")
    job = _job(arguments.what)
    options = calibration_options(job.calibration, "--set", arguments.set)
    if arguments.files:
        parts = parts_of_files(arguments.files, job.calibration, job.C_db, job.device_id)
    elif job.device is None:
        raise InputDataError("nothing to fit (add --from FILE, or name a configuration to record)")
    else:
        parts = asyncio.run(_guided(job.calibration, job.device))
    result = job.calibration.fit(job.params, options, parts)
    _tell(job, result, arguments.picture)
    if job.device is None or job.config is None:
        return 0
    if not arguments.yes and not _agreed(f"write this into {job.device.file}? [y/N] "):
        print("nothing was written")
        return 0
    table = mounting_table(result.mounting) if result.mounting is not None else None
    write_settings(job.config, job.device, result.params, table)
    print(f"written to {job.device.file}; the gateway takes it at its next start")
    return 0


@dataclass(frozen=True, slots=True, eq=False)
class _Job:
    """What is to be calibrated.

    Attributes:
        device_type: The kind of device.
        calibration: Which of its calibrations.
        params: Of its estimator, as configured or by default.
        C_db: The mounting, as configured or by default, shape (3, 3).
        config: The configuration, where one was named.
        device: The configured device, where one was named.
    """

    device_type: DeviceType
    calibration: Calibration
    params: Params
    C_db: Floats
    config: Path | None = None
    device: ResolvedDevice | None = None

    @property
    def device_id(self) -> str | None:
        """Return the id of the configured device."""
        return self.device.config.id if self.device else None


def _job(what: Sequence[str]) -> _Job:
    if len(what) == 2:
        devices = load_registry().devices
        if what[0] not in devices:
            raise ConfigError(f"{what[0]!r} is not installed ({did_you_mean(what[0], devices)})")
        device_type = devices[what[0]]
        C_db = rotation_from_mounting(device_type.default_mounting)
        chosen = _calibration(device_type, what[1])
        return _Job(device_type, chosen, device_type.params.model_validate({}), C_db)
    config = Path(what[0])
    configured = {device.config.id: device for device in load_config(config).devices}
    if what[1] not in configured:
        remedy = did_you_mean(what[1], configured)
        raise ConfigError(f"{config}: no enabled device is called {what[1]!r} ({remedy})")
    device = configured[what[1]]
    chosen = _calibration(device.device_type, what[2])
    return _Job(device.device_type, chosen, device.params, device.C_db, config, device)


def _calibration(device_type: DeviceType, name: str) -> Calibration:
    offered = {calibration.name: calibration for calibration in device_type.calibrations}
    if name not in offered:
        remedy = did_you_mean(name, offered) if offered else "it offers none"
        raise ConfigError(f"{device_type.name} has no calibration {name!r} ({remedy})")
    return offered[name]


def _list(what: Sequence[str]) -> int:
    """Print what can be calibrated, of one type or of all."""
    devices = load_registry().devices
    if what and what[0] not in devices:
        raise ConfigError(f"{what[0]!r} is no device type ({did_you_mean(what[0], devices)})")
    for name, device_type in sorted(devices.items()):
        if what and name != what[0]:
            continue
        print(f"{name}:" if device_type.calibrations else f"{name}: nothing to calibrate")
        for calibration in device_type.calibrations:
            print(f"  {calibration.name:16} {calibration.summary}")
            for key, field in calibration.options.model_fields.items() if what else ():
                default = "required" if field.is_required() else repr(field.default)
                print(f"      --set {key}=... ({default}) {field.description or ''}")
    return 0


async def _guided(calibration: Calibration, device: ResolvedDevice) -> list[CalibrationPart]:
    """Lead a person through the steps; return what was recorded meanwhile."""
    print(f"{calibration.name}: {calibration.summary}")
    print(f"opening {device.config.id} ...", flush=True)
    parts: list[CalibrationPart] = []
    async with Capture(device, HostClock()) as capture:
        for number, step in enumerate(calibration.steps, 1):
            again = True
            while again:
                print(f"\nstep {number} of {len(calibration.steps)}: {step.prompt}")
                parts.append(await _record(capture, step, device))
                again = step.repeat and await _answer("once more? [Y/n] ") not in ("n", "no")
    return parts


async def _record(
    capture: Capture, step: CalibrationStep, device: ResolvedDevice
) -> CalibrationPart:
    await _answer("press Enter when ready ")
    entered = None
    if step.duration_s is None:
        entered = asyncio.create_task(_answer("recording; press Enter when done "))
    recorded_s = 0.0

    def progress(seconds: float) -> None:
        nonlocal recorded_s
        recorded_s = seconds
        if step.duration_s is not None and sys.stdout.isatty():
            left_s = max(0.0, step.duration_s - seconds)
            print(f"\rrecording, {left_s:4.1f} s left ", end="", flush=True)

    def done() -> bool:
        if entered is not None:
            return entered.done()
        assert step.duration_s is not None
        return recorded_s >= step.duration_s

    items = await capture.record(done, progress)
    print(f"recorded {recorded_s:.1f} s", flush=True)
    return CalibrationPart(items, device.C_db, await _number(step.asks) if step.asks else None)


async def _number(name: str) -> float:
    """Ask for a number until one is typed."""
    while True:
        text = await _answer(f"{name} = ")
        try:
            return float(text.replace(",", "."))
        except ValueError:
            print(f"{text!r} is no number")


async def _answer(prompt: str) -> str:
    """Ask; the loop goes on meanwhile."""
    return await asyncio.to_thread(_input, prompt)


def _input(prompt: str) -> str:
    try:
        return input(prompt).strip().lower()
    except EOFError as exc:
        raise InputDataError("nobody answers (standard input has ended); use --from FILE") from exc


def _agreed(question: str) -> bool:
    return _input(question) in ("y", "yes")


def _tell(job: _Job, result: CalibrationResult, picture: Path | None) -> None:
    print("\nfound:")
    for finding in result.findings:
        print(f"  {finding}")
    for warning in result.warnings:
        print(f"  doubtful: {warning}")
    print("\nfor the configuration:")
    for line in _toml(result):
        print(f"  {line}")
    if result.picture is not None:
        print(f"\npicture of the fit: {_draw(job, result, picture)}")


def _toml(result: CalibrationResult) -> Iterator[str]:
    if result.params:
        inner = ", ".join(f"{key} = {_value(value)}" for key, value in result.params.items())
        yield f"params = {{ {inner} }}"
    if result.mounting is not None:
        table: Mapping[str, Any] = mounting_table(result.mounting)
        yield f"mounting = {{ {', '.join(f'{k} = {_value(v)}' for k, v in table.items())} }}"


def _value(value: Any) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list | tuple):
        return f"[{', '.join(_value(item) for item in value)}]"
    return str(value)


def _draw(job: _Job, result: CalibrationResult, path: Path | None) -> str:
    assert result.picture is not None
    try:
        from matplotlib.figure import Figure  # noqa: PLC0415  heavy, and an extra
    except ImportError:
        return "none, as matplotlib is missing (pip install 'gaitway[plots]')"
    name = job.device_id or job.device_type.name
    path = path or Path(f"{name}-{job.calibration.name}.png")
    figure = Figure(figsize=PICTURE_INCHES, layout="constrained")
    result.picture(figure)
    figure.savefig(path, dpi=110)
    return os.fspath(path)
