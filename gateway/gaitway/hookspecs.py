"""The three questions a plugin is asked, once, when the gateway starts.

Each hook returns records and is handed nothing, so a plugin has no way to act at load time.
"""

from collections.abc import Sequence

import pluggy

from gaitway.contracts import CodecType, DeviceType, TransportType

PROJECT = "gaitway"

hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


@hookspec
def gaitway_transports() -> Sequence[TransportType]:  # type: ignore[empty-body]
    """Return the kinds of link this plugin brings."""


@hookspec
def gaitway_codecs() -> Sequence[CodecType]:  # type: ignore[empty-body]
    """Return the wire formats this plugin brings."""


@hookspec
def gaitway_devices() -> Sequence[DeviceType]:  # type: ignore[empty-body]
    """Return the kinds of device this plugin brings."""
