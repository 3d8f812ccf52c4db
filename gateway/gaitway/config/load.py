"""Reading a configuration: every error of every file at once, or everything resolved."""

import glob
import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from gaitway.config.problems import Problem, did_you_mean, validate
from gaitway.config.schema import DeviceConfig, GatewayConfig, RecordingConfig, ResumeConfig
from gaitway.contracts import CodecType, DeviceType, TransportType
from gaitway.errors import ConfigError
from gaitway.mounting import Mounting, rotation_from_mounting
from gaitway.params import Params
from gaitway.registry import Registry, load_registry
from gaitway.samples import Floats

T = TypeVar("T")
P = TypeVar("P", RecordingConfig, ResumeConfig)


@dataclass(frozen=True, slots=True, eq=False)
class ResolvedDevice:
    """One configured device with everything it names looked up and checked.

    Attributes:
        config: Its entry in the file.
        file: The file that holds the entry.
        device_type: What it is.
        params: Parameters of its estimator.
        transport_type: How it is linked.
        transport_params: Parameters of the link.
        codec_type: What it speaks.
        codec_params: Parameters of the codec.
        mounting: Where each IMU axis points, the default filled in.
        C_db: Rotation from IMU to device components, shape (3, 3).
    """

    config: DeviceConfig
    file: Path
    device_type: DeviceType
    params: Params
    transport_type: TransportType
    transport_params: Params
    codec_type: CodecType
    codec_params: Params
    mounting: Mounting
    C_db: Floats


@dataclass(frozen=True, slots=True, eq=False)
class LoadedConfig:
    """A configuration that can be run.

    Attributes:
        file: The main file.
        gateway: Its content, devices of included files added.
        devices: The enabled devices.
        registry: What is installed.
        notes: Things worth knowing that are not errors, a line each.
    """

    file: Path
    gateway: GatewayConfig
    devices: tuple[ResolvedDevice, ...]
    registry: Registry
    notes: tuple[str, ...]

    def effective(self) -> dict[str, Any]:
        """Return the whole configuration, defaults filled in, as JSON-ready data."""
        data = self.gateway.model_dump(mode="json")
        data["devices"] = [
            {
                "id": device.config.id,
                "type": device.device_type.name,
                "driver": {
                    "transport": device.transport_type.name,
                    "codec": device.codec_type.name,
                    **device.transport_params.model_dump(mode="json"),
                    **device.codec_params.model_dump(mode="json"),
                },
                "mounting": dict(device.mounting),
                "params": device.params.model_dump(mode="json"),
            }
            for device in self.devices
        ]
        return data


def resolve_recorded(
    config: Mapping[str, Any], recording: Path, registry: Registry
) -> tuple[ResolvedDevice, ...]:
    """Return the devices of an effective configuration that a recording carries.

    Raises:
        ConfigError: Something in it is not installed here, or no longer valid.
    """
    problems: list[Problem] = []
    left_out: list[Problem] = []
    devices = [
        resolved
        for file, entry in _valid_devices(recording, config, problems)
        if (resolved := _resolve(entry, file, registry, problems, left_out))
    ]
    if problems or left_out:
        raise ConfigError("\n".join(str(problem) for problem in problems + left_out))
    return tuple(devices)


def load_config(file: Path) -> LoadedConfig:
    """Return the configuration of a file and those it includes.

    Raises:
        ConfigError: Something is wrong; the text has a line for every problem found.
        OSError: A file is there and can't be read; trying again may help.
    """
    problems: list[Problem] = []
    left_out: list[Problem] = []
    data = _read_toml(file, problems)
    gateway = validate(GatewayConfig, data, file, "", problems) if data is not None else None
    entries = _device_entries(file, data, problems) if data is not None else []
    disabled = gateway.plugins.disabled if gateway else ()
    registry = load_registry(disabled)
    devices = [
        resolved
        for source, config in entries
        if config.enabled and (resolved := _resolve(config, source, registry, problems, left_out))
    ]
    _check_unique(entries, problems)
    unknown = set(disabled) - set(registry.disabled_found)
    problems += [
        Problem(file, "plugins.disabled", f"no plugin is called {name!r} (see gaitway plugins)")
        for name in sorted(unknown)
    ]
    if problems:
        raise ConfigError("\n".join(str(problem) for problem in problems))
    assert gateway is not None
    gateway = gateway.model_copy(update={"devices": tuple(config for _, config in entries)})
    # systemd names the places a confined service may write to: on disk, and in memory.
    gateway = gateway.model_copy(
        update={
            "recording": _placed(gateway.recording, "STATE_DIRECTORY", file),
            "resume": _placed(gateway.resume, "RUNTIME_DIRECTORY", file),
        }
    )
    notes = [
        f"{error} (only devices of this plugin are affected)"
        for error in registry.failures.values()
    ]
    notes += [f"{problem}; the device is left out" for problem in left_out]
    return LoadedConfig(file, gateway, tuple(devices), registry, tuple(notes))


def _placed(section: P, variable: str, file: Path) -> P:
    """Return a section with its directory absolute: in systemd's, or beside the file."""
    base = Path(os.environ.get(variable) or file.parent)
    return section.model_copy(update={"directory": (base / section.directory).resolve()})


def _read_toml(file: Path, problems: list[Problem]) -> dict[str, Any] | None:
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        problems.append(Problem(file, "", "no such file (configs/ has examples to copy)"))
    except UnicodeDecodeError as exc:
        problems.append(Problem(file, "", f"is not text: {exc}"))
    except (tomllib.TOMLDecodeError, ValueError, RecursionError) as exc:
        problems.append(Problem(file, "", f"is not valid TOML: {exc}"))
    return None


def _device_entries(
    file: Path, data: Mapping[str, Any], problems: list[Problem]
) -> list[tuple[Path, DeviceConfig]]:
    """Return the devices of the main file and of those it includes, each with its file."""
    entries = _valid_devices(file, data, [])  # the main file's problems are known already
    patterns = data.get("include", [])
    for pattern in patterns if isinstance(patterns, list) else []:
        if not isinstance(pattern, str):
            continue
        # Path.glob refuses absolute patterns, which people write.
        names = glob.glob(str(file.parent / pattern)) if pattern else []  # noqa: PTH207
        found = sorted(map(Path, names))
        found = [path for path in found if path.is_file()]
        if not found and "*" not in pattern:
            problems.append(Problem(file, "include", f"no file {pattern!r} beside this one"))
        for included in found:
            inner = _read_toml(included, problems)
            if inner is None:
                continue
            problems += [
                Problem(included, key, "an included file holds [[devices]] only (move it)")
                for key in inner
                if key != "devices"
            ]
            entries += _valid_devices(included, inner, problems)
    return entries


def _valid_devices(
    file: Path, data: Mapping[str, Any], problems: list[Problem]
) -> list[tuple[Path, DeviceConfig]]:
    tables = data.get("devices", [])
    if not isinstance(tables, list):
        problems.append(Problem(file, "devices", "is a list: write [[devices]], double brackets"))
        return []
    entries: list[tuple[Path, DeviceConfig]] = []
    for number, table in enumerate(tables):
        name = table.get("id", number) if isinstance(table, dict) else number
        config = validate(DeviceConfig, table, file, f"devices.{name}", problems)
        if config is not None:
            entries.append((file, config))
    return entries


def _resolve(
    config: DeviceConfig,
    file: Path,
    registry: Registry,
    problems: list[Problem],
    left_out: list[Problem],
) -> ResolvedDevice | None:
    """Return a device with all it names looked up, or None after adding every problem.

    What may be missing because a plugin is broken is no problem of this file: the device is left
    out and the others run.
    """
    before = len(problems) + len(left_out)
    key = f"devices.{config.id}"
    missing = left_out if registry.failures else problems
    device_type = _look_up(config.type, registry.devices, registry, file, f"{key}.type", missing)
    driver = dict(config.driver)
    transport_type = _look_up(
        driver.pop("transport", None),
        registry.transports,
        registry,
        file,
        f"{key}.driver.transport",
        missing,
    )
    codec_type = _look_up(
        driver.pop("codec", None), registry.codecs, registry, file, f"{key}.driver.codec", missing
    )
    transport_params = codec_params = params = None
    if transport_type and codec_type:
        transport_params, codec_params = _split_driver(
            driver, transport_type, codec_type, file, f"{key}.driver", problems
        )
    if device_type:
        params = validate(device_type.params, config.params, file, f"{key}.params", problems)
    default = device_type.default_mounting if device_type else None
    mounting: Mounting | None = config.mounting or default
    C_db = None
    if mounting is not None:
        try:
            C_db = rotation_from_mounting(mounting)
        except ValueError as exc:
            problems.append(Problem(file, f"{key}.mounting", str(exc).removeprefix("mounting: ")))
    if device_type and params and C_db is not None and codec_type and codec_params:
        _check_factories(device_type, params, C_db, codec_type, codec_params, file, key, problems)
    if len(problems) + len(left_out) > before:
        return None
    # No problem was added, so everything was found.
    assert device_type is not None
    assert params is not None
    assert transport_type is not None
    assert transport_params is not None
    assert codec_type is not None
    assert codec_params is not None
    assert mounting is not None
    assert C_db is not None
    return ResolvedDevice(
        config,
        file,
        device_type,
        params,
        transport_type,
        transport_params,
        codec_type,
        codec_params,
        mounting,
        C_db,
    )


def _check_factories(
    device_type: DeviceType,
    params: Params,
    C_db: Floats,
    codec_type: CodecType,
    codec_params: Params,
    file: Path,
    key: str,
    problems: list[Problem],
) -> None:
    """Make estimator and codec once, so that parameters that don't fit together are told now."""
    try:
        _ = device_type.make_estimator(params, C_db).look_ahead_s
        codec_type.make(codec_params)
    except Exception as exc:  # noqa: BLE001
        # A stranger's factory may raise anything; the operator hears it with file and key.
        problems.append(Problem(file, key, f"can't be set up: {type(exc).__name__}: {exc}"))


def _look_up(
    name: Any,
    known: Mapping[str, T],
    registry: Registry,
    file: Path,
    key: str,
    problems: list[Problem],
) -> T | None:
    if isinstance(name, str) and name in known:
        return known[name]
    if name is None:
        problems.append(Problem(file, key, f"is missing (known: {', '.join(sorted(known))})"))
        return None
    text = f"{name!r} is not installed ({did_you_mean(str(name), known)})"
    for failure in registry.failures.values():
        text += f"; {failure}"
    problems.append(Problem(file, key, text))
    return None


def _split_driver(
    driver: Mapping[str, Any],
    transport_type: TransportType,
    codec_type: CodecType,
    file: Path,
    key: str,
    problems: list[Problem],
) -> tuple[Params | None, Params | None]:
    """Give each key of the driver table to the transport or the codec that knows it."""
    of_transport = transport_type.params.model_fields
    of_codec = codec_type.params.model_fields
    for name in driver:
        if name not in of_transport and name not in of_codec:
            remedy = did_you_mean(name, [*of_transport, *of_codec])
            problems.append(Problem(file, f"{key}.{name}", f"unknown key ({remedy})"))
    transport_data = {name: value for name, value in driver.items() if name in of_transport}
    codec_data = {name: value for name, value in driver.items() if name in of_codec}
    return (
        validate(transport_type.params, transport_data, file, key, problems),
        validate(codec_type.params, codec_data, file, key, problems),
    )


def _check_unique(entries: list[tuple[Path, DeviceConfig]], problems: list[Problem]) -> None:
    ids: dict[str, Path] = {}
    ports: dict[str, str] = {}
    for file, config in entries:
        key = f"devices.{config.id}"
        if config.id in ids:
            problems.append(
                Problem(file, f"{key}.id", f"is used twice, also in {ids[config.id]} (rename one)")
            )
        ids.setdefault(config.id, file)
        port = config.driver.get("port")
        if isinstance(port, str) and config.enabled:
            if port in ports:
                problems.append(
                    Problem(file, f"{key}.driver.port", f"{port} also belongs to {ports[port]}")
                )
            ports.setdefault(port, config.id)
