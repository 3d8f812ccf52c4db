"""Finding what is installed: each plugin is loaded and vetted alone, so one costs only itself."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Final, TypeVar

import pluggy

from gaitway import hookspecs
from gaitway.contracts import CodecType, DeviceType, TransportType
from gaitway.errors import PluginContractError, PluginError, PluginLoadError

GROUP: Final = "gaitway.plugins"

T = TypeVar("T", TransportType, CodecType, DeviceType)


@dataclass(slots=True)
class Registry:
    """All transports, codecs and devices that are installed and sound.

    Attributes:
        transports: By name.
        codecs: By name.
        devices: By name.
        loaded: Names of the plugins in use, with the distribution and version each came from.
        device_origins: Device types to the plugin that offers each, with distribution and version.
        failures: One error per plugin that can't be used, by entry-point name.
        disabled_found: Names of the installed plugins that the configuration switched off.
    """

    transports: dict[str, TransportType] = field(default_factory=dict)
    codecs: dict[str, CodecType] = field(default_factory=dict)
    devices: dict[str, DeviceType] = field(default_factory=dict)
    loaded: dict[str, str] = field(default_factory=dict)
    device_origins: dict[str, str] = field(default_factory=dict)
    failures: dict[str, PluginError] = field(default_factory=dict)
    disabled_found: tuple[str, ...] = ()

    def add(self, ep: EntryPoint) -> None:
        """Load one plugin and take what it offers.

        Raises:
            PluginError: It can't be loaded or breaks the contract; nothing of it was taken.
        """
        try:
            plugin = ep.load()
        except (Exception, SystemExit) as exc:
            # A stranger's import may raise anything, even SystemExit; it must cost only itself.
            raise PluginLoadError(ep.name, f"{type(exc).__name__}: {exc}") from exc
        manager = pluggy.PluginManager(hookspecs.PROJECT)  # its own: no plugin can silence another
        manager.add_hookspecs(hookspecs)
        try:
            manager.register(plugin, name=ep.name)
            manager.check_pending()  # a misspelt hook is an error, not silence
            transports = _offers(ep.name, TransportType, manager.hook.gaitway_transports)
            codecs = _offers(ep.name, CodecType, manager.hook.gaitway_codecs)
            devices = _offers(ep.name, DeviceType, manager.hook.gaitway_devices)
        except PluginError:
            raise
        except Exception as exc:
            raise PluginContractError(ep.name, f"{type(exc).__name__}: {exc}") from exc
        _check_measured(ep.name, devices)
        if not (transports or codecs or devices):
            raise PluginContractError(
                ep.name, "offers nothing (decorate gaitway_devices with gaitway.api.hookimpl)"
            )
        _check_duplicates(ep.name, self.transports, transports)
        _check_duplicates(ep.name, self.codecs, codecs)
        _check_duplicates(ep.name, self.devices, devices)
        self.transports.update({offer.name: offer for offer in transports})
        self.codecs.update({offer.name: offer for offer in codecs})
        self.devices.update({offer.name: offer for offer in devices})
        origin = f"{ep.dist.name} {ep.dist.version}" if ep.dist else "unknown"
        self.loaded[ep.name] = origin
        self.device_origins.update({offer.name: f"{ep.name} of {origin}" for offer in devices})


def load_registry(
    disabled: Iterable[str] = (), found: Iterable[EntryPoint] | None = None
) -> Registry:
    """Return everything installed under the entry-point group, failures included.

    Args:
        disabled: Entry-point names to skip.
        found: Entry points to load instead of the installed ones.
    """
    off = tuple(disabled)
    candidates = sorted(
        entry_points(group=GROUP) if found is None else found, key=lambda candidate: candidate.name
    )
    registry = Registry(disabled_found=tuple(ep.name for ep in candidates if ep.name in off))
    for ep in candidates:
        if ep.name in off:
            continue
        try:
            registry.add(ep)
        except PluginError as exc:
            registry.failures[ep.name] = exc
    return registry


def _offers(plugin: str, kind: type[T], hook: Callable[[], Any]) -> Sequence[T]:
    offers: list[T] = []
    for returned in hook():
        if not isinstance(returned, list | tuple):
            raise PluginContractError(
                plugin, f"a hook returned {type(returned).__name__}, not a list of {kind.__name__}"
            )
        for offer in returned:
            if not isinstance(offer, kind):
                raise PluginContractError(
                    plugin, f"offered {type(offer).__name__} where {kind.__name__} was asked for"
                )
            offers.append(offer)
    return offers


def _check_measured(plugin: str, devices: Sequence[DeviceType]) -> None:
    for device in devices:
        unknown = sorted(set(device.measured) - set(device.params.model_fields))
        if unknown:
            raise PluginContractError(
                plugin, f"{device.name}: measured names {unknown}, which are no parameters"
            )


def _check_duplicates(plugin: str, taken: Mapping[str, T], offers: Sequence[T]) -> None:
    names = [offer.name for offer in offers]
    for name in names:
        if name in taken or names.count(name) > 1:
            raise PluginContractError(
                plugin, f"offers {name!r}, which is taken (disable one of the two plugins)"
            )
