"""Links and wire formats that come with gaitway.

Only records here; what they name is imported when it is used.
"""

from collections.abc import Sequence

from gaitway.api import (
    Clock,
    Codec,
    CodecType,
    Peripheral,
    Transport,
    TransportType,
    hookimpl,
)
from gaitway_drivers.params import SerialParams, XbusParams


@hookimpl
def gaitway_transports() -> Sequence[TransportType]:
    """Return the links of this package."""
    return [
        TransportType(
            name="serial",
            summary="Serial port: UART, USB, RFCOMM, or a pyserial URL such as socket://host:port",
            params=SerialParams,
            make=_make_serial,
        )
    ]


@hookimpl
def gaitway_codecs() -> Sequence[CodecType]:
    """Return the wire formats of this package."""
    return [
        CodecType(
            name="xbus",
            summary="Xsens MTi over Xbus with MTData2 (MTi-1, 10, 100 and 600 series)",
            params=XbusParams,
            make=_make_xbus,
            make_peripheral=_make_xbus_peripheral,
        )
    ]


def _make_serial(params: SerialParams, clock: Clock) -> Transport:
    if "://" in params.port:
        from gaitway_drivers.transports.serial_url import SerialUrl  # noqa: PLC0415 - on use

        return SerialUrl(params, clock)
    from gaitway_drivers.transports.serial_port import SerialPort  # noqa: PLC0415 - on use

    return SerialPort(params, clock)


def _make_xbus(params: XbusParams) -> Codec:
    from gaitway_drivers.codecs.xbus.codec import XbusCodec  # noqa: PLC0415 - on use

    return XbusCodec(params)


def _make_xbus_peripheral(rate_hz: float) -> Peripheral:
    from gaitway_drivers.codecs.xbus.peripheral import XbusPeripheral  # noqa: PLC0415 - on use

    return XbusPeripheral(rate_hz)
