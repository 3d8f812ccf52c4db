"""The device's side of Xbus: an MTi-3 that answers the host and measures what it is told."""

import math
from collections.abc import Callable, Mapping, Sequence
from enum import Enum, auto, unique
from typing import Final

import numpy as np

from gaitway.api import ACCEL, ATTITUDE, CLIP, GYRO, Floats
from gaitway_drivers.codecs.xbus import mtdata2
from gaitway_drivers.codecs.xbus.framer import Framer
from gaitway_drivers.codecs.xbus.messages import (
    INVALID_MESSAGE,
    INVALID_PARAMETER,
    Mid,
    encode_message,
)
from gaitway_drivers.codecs.xbus.mtdata2 import encode_item, encode_reals, quantity_id
from gaitway_drivers.codecs.xbus.outputs import (
    Output,
    decode_outputs,
    encode_outputs,
    full_outputs,
)
from gaitway_drivers.codecs.xbus.readings import FIRST_CLIP_BIT
from gaitway_drivers.codecs.xbus.ticks import FULL_TICKS, TICK_NS

TICKS_PER_S: Final = 1_000_000_000 // TICK_NS
COUNTS: Final = 2**16
DEVICE_ID: Final = bytes.fromhex("03880FA1")
PRODUCT_CODE: Final = "MTi-3-8A7G6T"
FIRMWARE: Final = bytes((1, 8, 2)) + bytes(8)
TEMPERATURE_CELSIUS: Final = 25.0
FILTER_VALID: Final = 1 << 1
ANY_CLIP: Final = 1 << 19


@unique
class _State(Enum):
    OFF = auto()
    WAKING = auto()
    CONFIG = auto()
    MEASURING = auto()


class XbusPeripheral:
    """A simulated MTi.

    It does the one rate its samples come at: asked for another, it sets its own and says so.

    Args:
        rate_hz: How many samples a second it is given.
        outputs: What it sends until told otherwise; the ids' low bits choose the number format.
        auto_measure: Measure from power-up, as a device does that nobody acknowledges.
        unsupported: Quantities it refuses to send, as data ids without format and frame.
        extra_items: Whole items appended to every measurement.
    """

    def __init__(
        self,
        rate_hz: float,
        *,
        outputs: Sequence[Output] | None = None,
        auto_measure: bool = False,
        unsupported: frozenset[int] = frozenset(),
        extra_items: bytes = b"",
    ) -> None:
        self._rate_hz = rate_hz
        self._outputs = tuple(full_outputs(round(rate_hz)) if outputs is None else outputs)
        self._auto_measure = auto_measure
        self._unsupported = unsupported
        self._extra_items = extra_items
        self._framer = Framer()
        self._state = _State.OFF

    def start(self) -> bytes:
        """Return what the device sends on power-up."""
        self._framer = Framer()
        self._state = _State.MEASURING if self._auto_measure else _State.WAKING
        return encode_message(Mid.WAKE_UP)

    def feed(self, data: bytes) -> bytes:
        """Return the answers to what the host sent."""
        answers = b""
        for run in self._framer.feed(0, data):
            for payload in run.payloads:
                answers += self._answer(run.mid, payload.tobytes())
        return answers

    def encode(self, index: int, channels: Mapping[str, Floats]) -> bytes:
        """Return one measurement, or ``b""`` while not measuring.

        Args:
            index: Number of the sample since power-up.
            channels: Channel name to one row of values, shape (k,); ``accel`` and ``gyro`` at
                least. Attitude and clipping are sent if they are given.
        """
        if self._state is not _State.MEASURING:
            return b""
        items = [
            _ENCODERS[quantity_id(output.data_id)](output, index, self._rate_hz, channels)
            for output in self._outputs
            if quantity_id(output.data_id) in _ENCODERS
        ]
        return encode_message(Mid.MTDATA2, b"".join(items) + self._extra_items)

    def _answer(self, mid: int, data: bytes) -> bytes:
        if mid == Mid.GO_TO_CONFIG:
            self._state = _State.CONFIG
            return encode_message(Mid.GO_TO_CONFIG_ACK)
        if mid == Mid.RESET:
            return encode_message(Mid.RESET_ACK) + self.start()
        if mid == Mid.WAKE_UP_ACK:
            self._state = _State.CONFIG
            return b""
        if mid == Mid.GO_TO_MEASUREMENT:
            self._state = _State.MEASURING
            return encode_message(Mid.GO_TO_MEASUREMENT_ACK)
        if self._state is not _State.CONFIG:
            return encode_message(Mid.ERROR, bytes((INVALID_MESSAGE,)))
        if mid == Mid.SET_OUTPUT_CONFIGURATION:
            return self._set_outputs(decode_outputs(data))
        if mid in _FACTS:
            return encode_message(mid + 1, _FACTS[mid])
        return encode_message(Mid.ERROR, bytes((INVALID_MESSAGE,)))

    def _set_outputs(self, asked: tuple[Output, ...]) -> bytes:
        if any(quantity_id(output.data_id) in self._unsupported for output in asked):
            return encode_message(Mid.ERROR, bytes((INVALID_PARAMETER,)))
        if asked:
            own = round(self._rate_hz)
            self._outputs = tuple(
                output
                if quantity_id(output.data_id) not in _AT_SAMPLE_RATE
                else Output(output.data_id, own)
                for output in asked
            )
        return encode_message(Mid.OUTPUT_CONFIGURATION, encode_outputs(self._outputs))


_FACTS: Final[Mapping[int, bytes]] = {
    Mid.REQ_DEVICE_ID: DEVICE_ID,
    Mid.REQ_PRODUCT_CODE: PRODUCT_CODE.encode("ascii"),
    Mid.REQ_FIRMWARE: FIRMWARE,
}
_AT_SAMPLE_RATE: Final = frozenset(
    {
        mtdata2.ACCELERATION,
        mtdata2.RATE_OF_TURN,
        mtdata2.QUATERNION,
        mtdata2.DELTA_V,
        mtdata2.DELTA_Q,
    }
)

_Encoder = Callable[[Output, int, float, Mapping[str, Floats]], bytes]


def _counter(output: Output, index: int, _rate_hz: float, _channels: Mapping[str, Floats]) -> bytes:
    return encode_item(output.data_id, (index % COUNTS).to_bytes(2, "big"))


def _time(output: Output, index: int, rate_hz: float, _channels: Mapping[str, Floats]) -> bytes:
    ticks = round(index * TICKS_PER_S / rate_hz) % FULL_TICKS
    return encode_item(output.data_id, ticks.to_bytes(4, "big"))


def _status(output: Output, _index: int, _rate: float, channels: Mapping[str, Floats]) -> bytes:
    clip = int(channels[CLIP.name][0]) if CLIP.name in channels else 0
    word = FILTER_VALID | clip << FIRST_CLIP_BIT | (ANY_CLIP if clip else 0)
    return encode_item(output.data_id, word.to_bytes(4, "big"))


def _temperature(output: Output, index: int, rate_hz: float, _: Mapping[str, Floats]) -> bytes:
    if index % max(1, round(rate_hz / max(output.rate, 1))):
        return b""
    return encode_reals(output.data_id, np.array([TEMPERATURE_CELSIUS]))


def _accel(output: Output, _index: int, _rate: float, channels: Mapping[str, Floats]) -> bytes:
    return encode_reals(output.data_id, channels[ACCEL.name])


def _gyro(output: Output, _index: int, _rate: float, channels: Mapping[str, Floats]) -> bytes:
    return encode_reals(output.data_id, channels[GYRO.name])


def _attitude(output: Output, _index: int, _rate: float, channels: Mapping[str, Floats]) -> bytes:
    if ATTITUDE.name not in channels:
        return b""
    return encode_reals(output.data_id, channels[ATTITUDE.name])


def _delta_v(output: Output, _: int, rate_hz: float, channels: Mapping[str, Floats]) -> bytes:
    return encode_reals(output.data_id, channels[ACCEL.name] / rate_hz)


def _delta_q(output: Output, _: int, rate_hz: float, channels: Mapping[str, Floats]) -> bytes:
    half_rad = channels[GYRO.name] / rate_hz / 2.0
    angle_rad = float(np.linalg.norm(half_rad))
    ratio = math.sin(angle_rad) / angle_rad if angle_rad else 1.0
    return encode_reals(output.data_id, np.array([math.cos(angle_rad), *(ratio * half_rad)]))


_ENCODERS: Final[Mapping[int, _Encoder]] = {
    mtdata2.PACKET_COUNTER: _counter,
    mtdata2.SAMPLE_TIME_FINE: _time,
    mtdata2.STATUS_WORD: _status,
    mtdata2.TEMPERATURE: _temperature,
    mtdata2.ACCELERATION: _accel,
    mtdata2.RATE_OF_TURN: _gyro,
    mtdata2.QUATERNION: _attitude,
    mtdata2.DELTA_V: _delta_v,
    mtdata2.DELTA_Q: _delta_q,
}
