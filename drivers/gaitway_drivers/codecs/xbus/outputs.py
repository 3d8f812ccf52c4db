"""What a device is asked to send, and what it says it will."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from gaitway_drivers.codecs.xbus import mtdata2
from gaitway_drivers.codecs.xbus.mtdata2 import quantity_id

ENTRY_BYTES: Final = 4
EVERY_MESSAGE: Final = 0xFFFF
"""Rate that means "with every message"; devices may answer 0 for it."""
DEFAULT_RATE_HZ: Final = 100
TEMPERATURE_RATE_HZ: Final = 1


@dataclass(frozen=True, slots=True)
class Output:
    """One entry of an output configuration.

    Attributes:
        data_id: What is sent, format and frame included.
        rate: Whole hertz; 0 or ``EVERY_MESSAGE`` with every message.
    """

    data_id: int
    rate: int


def core_outputs(rate_hz: int) -> tuple[Output, ...]:
    """Return what every model can send and no estimator can do without."""
    return (
        Output(mtdata2.PACKET_COUNTER, EVERY_MESSAGE),
        Output(mtdata2.SAMPLE_TIME_FINE, EVERY_MESSAGE),
        Output(mtdata2.ACCELERATION, rate_hz),
        Output(mtdata2.RATE_OF_TURN, rate_hz),
        Output(mtdata2.STATUS_WORD, EVERY_MESSAGE),
    )


def full_outputs(rate_hz: int) -> tuple[Output, ...]:
    """Return the core with the sensor's attitude and temperature.

    73 bytes a message, and 7 more once a second: 7.3 kB/s at 100 Hz, where 115200 baud carries
    11.5 kB/s.
    """
    return (
        *core_outputs(rate_hz),
        Output(mtdata2.QUATERNION, rate_hz),
        Output(mtdata2.TEMPERATURE, TEMPERATURE_RATE_HZ),
    )


def encode_outputs(outputs: Iterable[Output]) -> bytes:
    """Return the data of SetOutputConfiguration, or of its answer."""
    return b"".join(
        output.data_id.to_bytes(2, "big") + output.rate.to_bytes(2, "big") for output in outputs
    )


def decode_outputs(data: bytes) -> tuple[Output, ...]:
    """Return the entries of an output configuration; an unfinished last one is left out."""
    return tuple(
        Output(
            int.from_bytes(data[at : at + 2], "big"), int.from_bytes(data[at + 2 : at + 4], "big")
        )
        for at in range(0, len(data) - ENTRY_BYTES + 1, ENTRY_BYTES)
    )


@dataclass(frozen=True, slots=True)
class OutputReport:
    """What can be expected of a device that set these outputs.

    Attributes:
        missing: What is not there though no sample can be made without it; empty if usable.
        rate_hz: How often it will make a sample; None if it doesn't say.
    """

    missing: str
    rate_hz: float | None


def judge_outputs(outputs: Iterable[Output]) -> OutputReport:
    """Tell whether outputs make samples, and at what rate."""
    rates = {quantity_id(output.data_id): output.rate for output in outputs}
    accel = rates.get(mtdata2.ACCELERATION, rates.get(mtdata2.DELTA_V))
    gyro = rates.get(mtdata2.RATE_OF_TURN, rates.get(mtdata2.DELTA_Q))
    timed = mtdata2.SAMPLE_TIME_FINE in rates or mtdata2.PACKET_COUNTER in rates
    missing = [
        name
        for name, there in (
            ("acceleration (4020)", accel is not None),
            ("rate of turn (8020)", gyro is not None),
            ("SampleTimeFine (1060)", timed),
        )
        if not there
    ]
    told = [rate for rate in (accel, gyro) if rate not in (None, 0, EVERY_MESSAGE)]
    return OutputReport(", ".join(missing), float(min(told)) if told else None)
