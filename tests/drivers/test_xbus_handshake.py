"""The way into measurement, with devices in every state and mood, on a clock of numbers."""

from collections.abc import Callable

import numpy as np
import pytest

from gaitway.api import (
    ACCEL,
    ATTITUDE,
    GYRO,
    Chunk,
    Command,
    DeviceBatch,
    DeviceStatus,
    Fault,
    HandshakeFailed,
)
from gaitway_drivers.codecs.xbus.codec import XbusCodec
from gaitway_drivers.codecs.xbus.framer import Framer
from gaitway_drivers.codecs.xbus.messages import Mid, encode_message
from gaitway_drivers.codecs.xbus.mtdata2 import encode_item
from gaitway_drivers.codecs.xbus.outputs import (
    Output,
    decode_outputs,
    encode_outputs,
    judge_outputs,
)
from gaitway_drivers.codecs.xbus.peripheral import XbusPeripheral
from gaitway_drivers.params import XbusParams

MS = 1_000_000
CHANNELS = {
    ACCEL.name: np.array([0.0, 0.0, 9.75]),
    GYRO.name: np.array([0.5, 0.0, 0.0]),
    ATTITUDE.name: np.array([1.0, 0.0, 0.0, 0.0]),
}


def mids_in(data: bytes) -> list[int]:
    return [run.mid for run in Framer().feed(0, data) for _ in run.payloads]


class Bench:
    """A codec and a device on one wire; 10 ms a step, a sample a step while it measures.

    ``hears`` decides which messages of the host reach the device.
    """

    def __init__(
        self,
        peripheral: XbusPeripheral,
        params: XbusParams | None = None,
        hears: Callable[[int, int], bool] = lambda mid, t_ns: True,
    ) -> None:
        self.codec = XbusCodec(params or XbusParams())
        self.peripheral = peripheral
        self.hears = hears
        self.t_ns = 5_000 * MS
        self.began_ns = self.t_ns
        self.index = 0
        self.items: list[object] = []
        self.sent: list[tuple[int, int]] = []
        self.chunks: list[Chunk] = []

    def run(self, duration_ms: int, *, power_up: bool = False) -> "Bench":
        waiting = self.peripheral.start() if power_up else b""
        waiting += self._deliver(self.codec.start(self.t_ns))
        for _ in range(duration_ms // 10):
            self.t_ns += 10 * MS
            self.index += 1
            waiting += self.peripheral.encode(self.index, CHANNELS)
            if waiting:
                chunk, waiting = Chunk(self.t_ns, waiting), b""
                self.chunks.append(chunk)
                waiting = self._deliver(self.codec.feed(chunk))
            waiting += self._deliver(self.codec.on_time(self.t_ns))
        return self

    def _deliver(self, items: list[object]) -> bytes:
        answers = b""
        self.items += items
        for item in items:
            if isinstance(item, Command):
                (mid,) = mids_in(item.payload)
                self.sent.append((mid, (self.t_ns - self.began_ns) // MS))
                if self.hears(mid, self.t_ns):
                    answers += self.peripheral.feed(item.payload)
        return answers

    def all(self, kind: type) -> list:
        return [item for item in self.items if isinstance(item, kind)]

    @property
    def samples(self) -> int:
        return sum(len(batch) for batch in self.all(DeviceBatch))

    @property
    def fields(self) -> dict[str, object]:
        return dict(self.all(DeviceStatus)[0].fields)


def awake(peripheral: XbusPeripheral) -> XbusPeripheral:
    """Return a device that was powered up long ago and waits in its config state."""
    peripheral.start()
    peripheral.feed(encode_message(Mid.WAKE_UP_ACK))
    return peripheral


def test_a_device_in_config_streams_after_each_step_was_answered_once():
    bench = Bench(awake(XbusPeripheral(100.0))).run(1000)
    assert [mid for mid, _ in bench.sent] == [
        Mid.GO_TO_CONFIG,
        Mid.REQ_DEVICE_ID,
        Mid.REQ_PRODUCT_CODE,
        Mid.REQ_FIRMWARE,
        Mid.SET_OUTPUT_CONFIGURATION,
        Mid.GO_TO_MEASUREMENT,
    ]
    assert bench.samples > 80
    assert bench.all(Fault) == []
    assert {batch.period_s for batch in bench.all(DeviceBatch)} == {0.01}
    assert ATTITUDE.name in bench.all(DeviceBatch)[-1].channels
    assert bench.fields == {
        "device_id": "03880FA1",
        "product_code": "MTi-3-8A7G6T",
        "firmware": "1.8.2",
        "sample_rate_hz": 100.0,
        "outputs": "1020 1060 4020 8020 E020 2010 0810",
    }


def test_a_device_that_powers_up_is_kept_in_config_and_marked_as_restarted():
    bench = Bench(XbusPeripheral(100.0)).run(1000, power_up=True)
    assert Mid.WAKE_UP_ACK in [mid for mid, _ in bench.sent]
    assert bench.samples > 80
    assert [batch.restarted for batch in bench.all(DeviceBatch)[:3]] == [True, False, False]


def test_a_device_that_measures_already_is_set_up_and_its_old_samples_are_skipped():
    peripheral = XbusPeripheral(
        100.0, outputs=[Output(0x1060, 100), Output(0x4020, 100)], auto_measure=True
    )
    peripheral.start()
    bench = Bench(peripheral).run(1000)
    assert bench.samples > 80
    assert bench.all(Fault) == []
    assert all(GYRO.name in batch.channels for batch in bench.all(DeviceBatch))


def test_measurements_are_not_used_before_the_device_was_set_up():
    peripheral = XbusPeripheral(100.0, auto_measure=True)
    peripheral.start()
    bench = Bench(peripheral, hears=lambda mid, t_ns: False).run(2000)
    assert bench.samples == 0


def test_go_to_config_is_sent_again_after_500_ms_and_then_each_100_ms():
    bench = Bench(awake(XbusPeripheral(100.0)), hears=lambda mid, t_ns: t_ns >= 5_690 * MS)
    bench.run(1500)
    assert [t_ms for mid, t_ms in bench.sent if mid == Mid.GO_TO_CONFIG] == [0, 500, 600, 700]
    assert bench.samples > 60


def test_a_device_that_needs_a_reset_gets_one():
    was_reset = []

    def hears(mid: int, _t_ns: int) -> bool:
        if mid == Mid.RESET:
            was_reset.append(True)
        return bool(was_reset)

    peripheral = XbusPeripheral(100.0, auto_measure=True)
    peripheral.start()
    bench = Bench(peripheral, hears=hears).run(3000)
    sent = [mid for mid, _ in bench.sent]
    assert sent.count(Mid.RESET) == 1
    assert [t_ms for mid, t_ms in bench.sent if mid == Mid.RESET] == [1200]
    assert sent[sent.index(Mid.RESET) + 1 :][:2] == [Mid.WAKE_UP_ACK, Mid.GO_TO_CONFIG]
    assert bench.samples > 100
    assert bench.all(HandshakeFailed) == []


@pytest.mark.parametrize("own_hz", [50.0, 80.0])
def test_a_device_that_sets_another_rate_is_used_at_that_rate_and_both_are_told(own_hz):
    bench = Bench(awake(XbusPeripheral(own_hz)), XbusParams(rate_hz=100.0)).run(1000)
    assert bench.fields["sample_rate_hz"] == own_hz
    assert bench.fields["asked_sample_rate_hz"] == 100
    assert {batch.period_s for batch in bench.all(DeviceBatch)} == {1 / own_hz}
    assert bench.samples > 80


def test_the_rate_asked_for_is_the_one_in_the_parameters():
    bench = Bench(awake(XbusPeripheral(400.0)), XbusParams(rate_hz=400.0)).run(500)
    assert bench.fields["sample_rate_hz"] == 400.0
    assert "asked_sample_rate_hz" not in bench.fields


@pytest.mark.parametrize(
    ("unit_sends", "words"),
    [
        (b"", ["no answer to GoToConfig", "power", "baud"]),
        (b"\x00\x13garbage", ["no Xbus message", "baud"]),
        (encode_message(Mid.MTDATA2, b""), ["although measurements arrive", "listen_only"]),
    ],
    ids=["silent", "garbage", "deaf"],
)
def test_a_device_that_never_answers_fails_once_with_a_reason_that_helps(unit_sends, words):
    codec = XbusCodec(XbusParams())
    codec.start(0)
    items = []
    for t_ms in range(10, 6000, 10):
        if unit_sends:
            items += codec.feed(Chunk(t_ms * MS, unit_sends))
        items += codec.on_time(t_ms * MS)
    (failed,) = [item for item in items if isinstance(item, HandshakeFailed)]
    assert failed.t_ns == 3000 * MS
    assert all(word in failed.reason for word in words)


def test_a_device_that_falls_silent_halfway_fails_and_names_the_step():
    bench = Bench(awake(XbusPeripheral(100.0)), hears=lambda mid, t_ns: mid != Mid.REQ_PRODUCT_CODE)
    (failed,) = bench.run(4000).all(HandshakeFailed)
    assert "ReqProductCode" in failed.reason
    assert [mid for mid, _ in bench.sent].count(Mid.REQ_PRODUCT_CODE) == 6


def test_an_answer_lost_on_the_way_only_costs_time():
    lost = {Mid.SET_OUTPUT_CONFIGURATION, Mid.REQ_FIRMWARE}

    def hears(mid: int, _t_ns: int) -> bool:
        if mid in lost:
            lost.discard(mid)
            return False
        return True

    bench = Bench(awake(XbusPeripheral(100.0)), hears=hears).run(2000)
    assert bench.samples > 80
    assert bench.all(HandshakeFailed) == []


def test_a_measurement_is_as_good_as_the_answer_to_go_to_measurement():
    codec = XbusCodec(XbusParams())
    codec.start(0)
    device = awake(XbusPeripheral(100.0))
    items = codec.start(0)
    while not any(
        Mid.GO_TO_MEASUREMENT in mids_in(i.payload) for i in items if isinstance(i, Command)
    ):
        answer = b"".join(device.feed(i.payload) for i in items if isinstance(i, Command))
        items = codec.feed(Chunk(1, answer))
    device.feed(encode_message(Mid.GO_TO_MEASUREMENT))
    items = [item for i in range(20) for item in codec.feed(Chunk(2, device.encode(i, CHANNELS)))]
    assert sum(len(item) for item in items if isinstance(item, DeviceBatch)) == 20


def test_a_model_without_attitude_is_asked_for_less():
    bench = Bench(awake(XbusPeripheral(100.0, unsupported=frozenset({0x2010})))).run(1000)
    assert bench.fields["outputs"] == "1020 1060 4020 8020 E020"
    assert bench.samples > 80
    assert [fault.kind for fault in bench.all(Fault)] == ["device-error"]


def test_a_model_without_a_gyroscope_fails_with_its_own_words():
    bench = Bench(awake(XbusPeripheral(100.0, unsupported=frozenset({0x8020})))).run(500)
    (failed,) = bench.all(HandshakeFailed)
    assert "not valid for this device" in failed.reason


@pytest.mark.parametrize(
    ("outputs", "word"),
    [
        ([Output(0x1060, 0xFFFF), Output(0x4020, 100)], "rate of turn (8020)"),
        ([Output(0x1060, 0xFFFF), Output(0x8020, 100)], "acceleration (4020)"),
        ([Output(0x4020, 100), Output(0x8020, 100)], "SampleTimeFine (1060)"),
        ([], "nothing"),
    ],
)
def test_a_device_that_set_something_useless_is_refused_by_name(outputs, word):
    codec = XbusCodec(XbusParams())
    codec.start(0)
    answers = [
        encode_message(Mid.GO_TO_CONFIG_ACK),
        encode_message(Mid.DEVICE_ID, bytes(4)),
        encode_message(Mid.PRODUCT_CODE, b"MTi-2"),
        encode_message(Mid.FIRMWARE, bytes(11)),
        encode_message(Mid.OUTPUT_CONFIGURATION, encode_outputs(outputs)),
    ]
    items = [item for answer in answers for item in codec.feed(Chunk(1, answer))]
    assert word in items[-1].reason


def test_samples_come_at_the_lower_rate_of_the_two_they_are_made_of():
    outputs = decode_outputs(
        encode_outputs([Output(0x1060, 0xFFFF), Output(0x4020, 100), Output(0x8020, 50)]) + b"\x80"
    )
    assert len(outputs) == 3
    assert judge_outputs(outputs).rate_hz == 50.0


def test_a_device_that_does_not_tell_its_rate_has_it_measured():
    codec = XbusCodec(XbusParams())
    codec.start(0)
    outputs = [Output(data_id, 0xFFFF) for data_id in (0x1020, 0x1060, 0x4020, 0x8020)]
    for answer in (
        encode_message(Mid.GO_TO_CONFIG_ACK),
        encode_message(Mid.DEVICE_ID, bytes(4)),
        encode_message(Mid.ERROR, b"\x04"),
        encode_message(Mid.ERROR, b"\x04"),
        encode_message(Mid.OUTPUT_CONFIGURATION, encode_outputs(outputs)),
        encode_message(Mid.GO_TO_MEASUREMENT_ACK),
    ):
        codec.feed(Chunk(1, answer))
    device = XbusPeripheral(200.0, outputs=outputs, auto_measure=True)
    device.start()
    items = [item for i in range(20) for item in codec.feed(Chunk(2, device.encode(i, CHANNELS)))]
    assert {item.period_s for item in items if isinstance(item, DeviceBatch)} == {0.005}


def test_a_device_that_restarts_in_the_middle_is_set_up_again():
    bench = Bench(awake(XbusPeripheral(100.0))).run(500)
    waking = bench.peripheral.start()
    bench.items.clear()
    bench.sent.clear()
    answer = bench._deliver(bench.codec.feed(Chunk(bench.t_ns, waking)))
    for index in range(40):
        bench.t_ns += 10 * MS
        chunk = Chunk(bench.t_ns, answer + bench.peripheral.encode(index, CHANNELS))
        answer = bench._deliver(bench.codec.feed(chunk)) if chunk.data else b""
    assert bench.sent[0][0] == Mid.WAKE_UP_ACK
    assert [batch.restarted for batch in bench.all(DeviceBatch)[:2]] == [True, False]
    assert bench.samples > 25


def test_the_recorded_bytes_of_a_slow_handshake_decode_the_same_without_time_passing():
    was_reset = []

    def hears(mid: int, _t_ns: int) -> bool:
        if mid == Mid.RESET:
            was_reset.append(True)
        return bool(was_reset)

    peripheral = XbusPeripheral(100.0, auto_measure=True)
    peripheral.start()
    bench = Bench(peripheral, hears=hears).run(3000)
    codec = XbusCodec(XbusParams())
    codec.start(0)
    again = [
        item
        for chunk in bench.chunks
        for item in codec.feed(chunk)
        if isinstance(item, DeviceBatch | DeviceStatus | Fault)
    ]
    live = [item for item in bench.items if isinstance(item, DeviceBatch | DeviceStatus | Fault)]
    assert [type(item) for item in again] == [type(item) for item in live]
    for one, other in zip(again, live, strict=True):
        if isinstance(one, DeviceBatch):
            assert one.device_ns.tolist() == other.device_ns.tolist()
            assert (one.arrival_ns, one.restarted) == (other.arrival_ns, other.restarted)
        else:
            assert one == other


def test_start_begins_anew_on_the_next_link():
    bench = Bench(awake(XbusPeripheral(100.0))).run(500)
    bench.codec.feed(Chunk(bench.t_ns, b"\xfa\xff\x36\x50half a message"))
    bench.items.clear()
    bench.sent.clear()
    bench.run(500)
    assert bench.sent[0][0] == Mid.GO_TO_CONFIG
    assert bench.all(Fault) == []
    assert bench.samples > 30


def test_listening_sends_nothing_whatever_comes(capture):
    codec = XbusCodec(XbusParams(listen_only=True))
    items = codec.start(0)
    items += codec.feed(Chunk(1, encode_message(Mid.WAKE_UP) + capture))
    for t_ms in range(0, 10_000, 50):
        items += codec.on_time(t_ms * MS)
    assert not [item for item in items if isinstance(item, Command | HandshakeFailed)]
    assert sum(len(item) for item in items if isinstance(item, DeviceBatch)) == 96


# The device's side


def test_the_peripheral_refuses_what_it_can_not_do_in_its_state():
    measuring = XbusPeripheral(100.0, auto_measure=True)
    measuring.start()
    error = encode_message(Mid.ERROR, b"\x04")
    assert measuring.feed(encode_message(Mid.REQ_DEVICE_ID)) == error
    assert awake(XbusPeripheral(100.0)).feed(encode_message(0x64, b"\x00\x02")) == error


def test_the_peripheral_is_silent_until_it_measures():
    device = XbusPeripheral(100.0)
    assert device.encode(0, CHANNELS) == b""
    device.start()
    assert device.encode(0, CHANNELS) == b""


def test_the_peripheral_answers_an_empty_output_configuration_with_its_own():
    outputs = [Output(0x4022, 100), Output(0x8022, 100)]
    device = awake(XbusPeripheral(100.0, outputs=outputs))
    assert device.feed(encode_message(Mid.SET_OUTPUT_CONFIGURATION)) == encode_message(
        Mid.OUTPUT_CONFIGURATION, encode_outputs(outputs)
    )


def test_the_peripheral_sends_temperature_once_a_second():
    device = XbusPeripheral(100.0, auto_measure=True)
    device.start()
    sizes = [len(device.encode(index, CHANNELS)) for index in range(301)]
    assert [index for index, size in enumerate(sizes) if size == max(sizes)] == [0, 100, 200, 300]
    assert (min(sizes), max(sizes)) == (73, 80)


def test_the_peripheral_uses_the_extended_length_when_it_must():
    extra = encode_item(0x7010, bytes(94)) * 3
    device = XbusPeripheral(100.0, auto_measure=True, extra_items=extra)
    device.start()
    frame = device.encode(1, CHANNELS)
    assert frame[3] == 0xFF
    assert frame.endswith(extra, 0, -1)


def test_the_peripheral_can_send_increments(decode):
    outputs = [Output(data_id, 100) for data_id in (0x1060, 0x4013, 0x8033)]
    device = XbusPeripheral(100.0, outputs=outputs, auto_measure=True)
    stream = device.start() + b"".join(device.encode(index, CHANNELS) for index in range(12))
    batches = [item for item in decode([stream]) if isinstance(item, DeviceBatch)]
    for name in (ACCEL.name, GYRO.name):
        np.testing.assert_allclose(batches[-1].channels[name][-1], CHANNELS[name], atol=1e-12)
