"""Check a configuration: everything short of opening a port.

Prints every error at once, each with file, key and remedy, and exits with status 78; or what the
gateway would do, and exits with 0.
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

from gaitway.cli.notices import print_notices
from gaitway.config.load import ResolvedDevice, load_config
from gaitway.config.schema import ResumeConfig
from gaitway.mounting import describe_axis


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("config", type=Path, metavar="CONFIG", help="gateway.toml")
    parser.add_argument(
        "--json", action="store_true", help="print the effective configuration, defaults filled in"
    )


def run(arguments: argparse.Namespace) -> int:
    """Check and describe."""
    loaded = load_config(arguments.config)
    if arguments.json:
        print(json.dumps(loaded.effective(), indent=2))
        return 0
    gateway = loaded.gateway
    for device in loaded.devices:
        axes = ", ".join(f"{axis} {describe_axis(way)}" for axis, way in device.mounting.items())
        port = getattr(device.transport_params, "port", "")
        print(
            f"{device.config.id}: {device.device_type.name} over {device.transport_type.name}"
            f" {port} ({device.codec_type.name}), mounted {axes}"
        )
    for config in gateway.devices:
        if not config.enabled:
            print(f"{config.id}: switched off")
    if not loaded.devices:
        print("no devices: the gateway would run and do nothing (add [[devices]])")
    print(f"keys: gaitway/v1/{gateway.site}/{{device}}/{{kind}}")
    print(f"bus: {', '.join(gateway.bus.listen) or 'listens nowhere'}")
    recording = gateway.recording
    print(f"recording: {recording.directory if recording.enabled else 'off'}")
    print(f"restart: {_restart(gateway.resume)}")
    for note in loaded.notes:
        print(f"note: {note}")
    for device in loaded.devices:
        for note in _notes(device, arguments.config):
            print(f"note: {device.config.id}: {note}")
    print_notices()
    print("ok")
    return 0


def _restart(resume: ResumeConfig) -> str:
    if resume.within_s <= 0:
        return "every device begins anew"
    return f"goes on within {resume.within_s:g} s from {resume.directory}"


def _notes(device: ResolvedDevice, config: Path) -> Iterator[str]:
    """Yield what is allowed and probably not meant."""
    port = getattr(device.transport_params, "port", None)
    if isinstance(port, str) and port.startswith("/") and not Path(port).exists():
        yield f"port {port} is not there now (plug it in; systemd/99-gaitway.rules names it)"
    name = device.config.id
    commands = [
        f"gaitway calibrate {config} {name} {calibration.name}"
        for calibration in device.device_type.calibrations
    ]
    remedy = f" ({' or '.join(commands)})" if commands else ""
    for key in device.device_type.measured:
        if key not in device.config.params:
            value = getattr(device.params, key)
            told = "is not known" if value is None else f"= {value} is a typical one"
            yield f"{key} {told}: measure yours and set it in params{remedy}"
