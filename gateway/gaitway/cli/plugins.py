"""List the devices, codecs and transports that are installed, and every plugin that is broken.

With the name of one, list its parameters with units and defaults.
"""

import argparse
from collections.abc import Mapping  # noqa: TC003  # beside the other imports, as everywhere

from gaitway.cli.notices import print_notices
from gaitway.contracts import CodecType, DeviceType, TransportType
from gaitway.registry import Registry, load_registry


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("name", nargs="?", metavar="NAME", help="a device, codec or transport")


def run(arguments: argparse.Namespace) -> int:
    """List everything, or explain one."""
    registry = load_registry()
    if arguments.name is None:
        _list(registry)
        return 1 if registry.failures else 0
    known: list[DeviceType | CodecType | TransportType] = [
        *registry.devices.values(),
        *registry.codecs.values(),
        *registry.transports.values(),
    ]
    chosen = [offer for offer in known if offer.name == arguments.name]
    for offer in chosen:
        _explain(offer)
    if not chosen:
        print(f"{arguments.name!r} is not installed; gaitway plugins lists what is")
        return 1
    return 0


def _list(registry: Registry) -> None:
    rooms: dict[str, Mapping[str, DeviceType | CodecType | TransportType]] = {
        "devices": registry.devices,
        "codecs": registry.codecs,
        "transports": registry.transports,
    }
    for title, offers in rooms.items():
        print(f"{title}:")
        for name, offer in sorted(offers.items()):
            print(f"  {name:16} {offer.summary}")
    print("plugins:")
    for name, origin in registry.loaded.items():
        print(f"  {name:16} {origin}")
    for error in registry.failures.values():
        print(f"  broken: {error}")
    print_notices()


def _explain(offer: DeviceType | CodecType | TransportType) -> None:
    print(f"{offer.name}: {offer.summary}")
    if isinstance(offer, DeviceType):
        axes = ", ".join(f'{axis} = "{way}"' for axis, way in offer.default_mounting.items())
        print(f"  default mounting: {{ {axes} }}")
    for name, field in offer.params.model_fields.items():
        default = "required" if field.is_required() else repr(field.default)
        print(f"  {name} = {default}")
        for line in (field.description or "").splitlines():
            print(f"      {line}")
