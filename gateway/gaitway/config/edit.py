"""Writing what a calibration found into the configuration, comments and order left as they are."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from gaitway.config.load import ResolvedDevice, load_config
from gaitway.errors import ConfigError


def write_settings(
    main_file: Path,
    device: ResolvedDevice,
    params: Mapping[str, Any],
    mounting: Mapping[str, Any] | None,
) -> None:
    """Set parameters, and the mounting where it is given, of one device in its file.

    The file is replaced as a whole, so that a power cut leaves the old one or the new one, and only
    if the configuration is valid with it.

    Args:
        main_file: The configuration that the device belongs to.
        device: As loaded from it.
        params: Parameter names to values.
        mounting: For each of x, y and z where that IMU axis points.

    Raises:
        ConfigError: The configuration would be wrong; nothing has changed.
        OSError: The file can't be written.
    """
    file = device.file
    before = file.read_text(encoding="utf-8")
    _replace(file, _edited(before, device, params, mounting))
    try:
        load_config(main_file)
    except ConfigError as exc:
        _replace(file, before)
        raise ConfigError(f"{file}: not changed, as it would be wrong then: {exc}") from exc


def _edited(
    text: str,
    device: ResolvedDevice,
    params: Mapping[str, Any],
    mounting: Mapping[str, Any] | None,
) -> str:
    name = device.config.id
    try:
        document = tomlkit.parse(text)
    except TOMLKitError as exc:
        raise ConfigError(f"{device.file}: is not valid TOML: {exc}") from exc
    entries = document.get("devices", [])
    entry = next((entry for entry in entries if entry.get("id") == name), None)
    if entry is None:
        raise ConfigError(f"{device.file}: holds no device {name!r} any more (was it edited?)")
    if params and "params" not in entry:
        entry["params"] = tomlkit.inline_table()
    for key, value in params.items():
        entry["params"][key] = value
    if mounting is not None:
        table = tomlkit.inline_table()
        table.update(mounting)
        entry["mounting"] = table
    return tomlkit.dumps(document)


def _replace(file: Path, text: str) -> None:
    beside = file.with_name(f".{file.name}.new")
    with beside.open("w", encoding="utf-8") as out:
        out.write(text)
        out.flush()
        os.fsync(out.fileno())
    if file.exists():
        beside.chmod(file.stat().st_mode)
    beside.replace(file)
