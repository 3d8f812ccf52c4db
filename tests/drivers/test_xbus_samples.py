"""From measurements to samples: which channels, which time, what is said to be missing."""

import math

import numpy as np
import pytest

from gaitway.api import (
    ACCEL,
    ATTITUDE,
    CLIP,
    GYRO,
    Chunk,
    DeviceBatch,
    DeviceStatus,
    Fault,
    HandshakeFailed,
)
from gaitway_drivers.codecs.xbus.codec import XbusCodec
from gaitway_drivers.codecs.xbus.messages import Mid, encode_message
from gaitway_drivers.codecs.xbus.mtdata2 import encode_item, encode_reals
from gaitway_drivers.params import XbusParams

IMU = {0x4020: (0.0, 0.0, 9.75), 0x8020: (0.5, 0.25, -0.5)}
TICK_NS = 100_000
S_TICKS = 10_000


def batches_of(items):
    return [item for item in items if isinstance(item, DeviceBatch)]


def device_ns_of(items):
    return [at_ns for batch in batches_of(items) for at_ns in batch.device_ns.tolist()]


def faults_of(items):
    return [(item.kind, item.count) for item in items if isinstance(item, Fault)]


def status_of(items, field):
    return [
        item.fields[field]
        for item in items
        if isinstance(item, DeviceStatus) and field in item.fields
    ]


def channel_of(items, name):
    return np.concatenate([batch.channels[name] for batch in batches_of(items)])


def steady(measurement, count, first=0, **extra):
    return [measurement(i, 100 * i, IMU, **extra) for i in range(first, first + count)]


# Channels


def test_channels_are_read_only_c_ordered_float64(measurement, decode):
    reals = IMU | {0x2014: (0.5, 0.5, 0.5, 0.5)}
    rest = encode_item(0xE020, bytes(4))
    stream = b"".join(measurement(i, 100 * i, reals, rest) for i in range(40))
    (batch,) = batches_of(decode([stream], rate_hz=100.0))
    assert len(batch) == 40
    assert batch.channels.keys() == {ACCEL.name, GYRO.name, ATTITUDE.name, CLIP.name}
    for rows in [batch.device_ns, *batch.channels.values()]:
        assert not rows.flags.writeable
        assert rows.flags.c_contiguous
        assert len(rows) == 40
    assert {rows.dtype for rows in batch.channels.values()} == {np.dtype(np.float64)}


@pytest.mark.parametrize(
    ("data_id", "sent", "expected"),
    [
        (0x2010, (0.5, 0.5, 0.5, 0.5), (0.5, 0.5, 0.5, 0.5)),
        (0x2018, (0.0, 1.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)),
        (0x2010, (-0.5, 0.5, -0.5, 0.5), (0.5, -0.5, 0.5, -0.5)),
        # A sensor that lies level, z up, is upside down in north-east-down.
        (0x2014, (0.0, 1.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
        (0x2014, (0.0, -1.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
        # Heading east by the right-hand rule about down is -90 degrees about up.
        (0x2014, (0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0), (0.7071068, 0, 0, -0.7071068)),
    ],
)
def test_attitude_is_given_for_a_z_up_frame(measurement, decode, data_id, sent, expected):
    stream = [measurement(i, 100 * i, IMU | {data_id: sent}) for i in range(3)]
    attitude = channel_of(decode(stream, rate_hz=100.0), ATTITUDE.name)
    np.testing.assert_allclose(attitude, [expected] * 3, atol=1e-7)


@pytest.mark.parametrize("axis", range(6))
def test_clip_bits_of_the_status_word_are_ours_in_order(measurement, decode, axis):
    status = (1 << (8 + axis)) | 1 << 14 | 1 << 19 | 0b11
    stream = [measurement(1, 100, IMU, encode_item(0xE020, status.to_bytes(4, "big")))]
    assert channel_of(decode(stream, rate_hz=100.0), CLIP.name).tolist() == [[float(1 << axis)]]


def test_increments_become_their_mean_over_the_period(measurement, decode):
    rate_rad = np.array((0.3, -0.2, 0.1)) / 50.0
    angle = float(np.linalg.norm(rate_rad))
    dq = (math.cos(angle / 2), *(math.sin(angle / 2) / angle * rate_rad))
    stream = [measurement(i, 200 * i, {0x4013: (0.02, 0.04, 0.196), 0x8033: dq}) for i in range(12)]
    items = decode(stream)
    np.testing.assert_allclose(channel_of(items, ACCEL.name)[5], (1.0, 2.0, 9.8), rtol=1e-12)
    np.testing.assert_allclose(channel_of(items, GYRO.name)[5], (0.3, -0.2, 0.1), rtol=1e-9)


def test_a_rotation_increment_of_nothing_is_no_rate(measurement, decode):
    stream = [measurement(1, 100, {0x4020: (0, 0, 1), 0x8030: (1, 0, 0, 0)})]
    assert channel_of(decode(stream, rate_hz=100.0), GYRO.name).tolist() == [[0.0, 0.0, 0.0]]


def test_a_rotation_increment_and_its_negative_are_the_same_rate(measurement, decode):
    dq = np.array((math.cos(0.05), math.sin(0.05), 0.0, 0.0))
    stream = [
        measurement(i, 100 * i, {0x4020: (0, 0, 1), 0x8033: s * dq}) for i, s in ((1, 1), (2, -1))
    ]
    gyro = channel_of(decode(stream, rate_hz=100.0), GYRO.name)
    np.testing.assert_allclose(gyro, [(10.0, 0.0, 0.0)] * 2, rtol=1e-12)


def test_measured_values_win_over_increments(measurement, decode):
    reals = IMU | {0x4010: (1.0, 1.0, 1.0), 0x8030: (0.0, 1.0, 0.0, 0.0)}
    items = decode([measurement(1, 100, reals)], rate_hz=100.0)
    assert channel_of(items, ACCEL.name).tolist() == [list(IMU[0x4020])]
    assert channel_of(items, GYRO.name).tolist() == [list(IMU[0x8020])]


def test_signalling_nan_is_passed_on_without_a_warning(measurement, decode):
    rest = encode_item(0x4020, bytes.fromhex("7f800001") * 3) + encode_reals(0x8020, np.ones(3))
    items = decode([measurement(1, 100, {}, rest)], rate_hz=100.0)
    assert np.isnan(channel_of(items, ACCEL.name)).all()


@pytest.mark.parametrize("only", [0x4020, 0x8020])
def test_one_of_rate_and_acceleration_alone_is_no_sample(measurement, decode, only):
    stream = [measurement(i, 100 * i, {only: IMU[only]}) for i in range(30)]
    assert decode(stream, rate_hz=100.0) == []


# One instant in two messages


@pytest.mark.parametrize("count", [1, 5, 40])
def test_two_messages_of_one_instant_make_one_sample(measurement, decode, count):
    stream = []
    for i in range(count):
        stream.append(measurement(2 * i, 100 * i, IMU))
        stream.append(measurement(2 * i + 1, 100 * i, {0x2010: (1.0, 0.0, 0.0, 0.0)}))
    items = decode(stream, rate_hz=100.0)
    assert device_ns_of(items) == [100 * i * TICK_NS for i in range(count)]
    assert len(channel_of(items, ATTITUDE.name)) == count
    assert faults_of(items) == []


@pytest.mark.parametrize("strays", [0, 1])
def test_halves_of_an_instant_find_each_other_past_older_messages(measurement, decode, strays):
    stream = []
    for i in range(20):
        stream.append(measurement(None, 30_000 + 100 * i, IMU))
        stream += [measurement(None, 500 + i, {}, encode_item(0xE020, bytes(4)))] * strays
        stream.append(measurement(None, 30_000 + 100 * i, {0x2010: (1.0, 0.0, 0.0, 0.0)}))
    items = decode(stream, rate_hz=100.0)
    assert len(channel_of(items, ATTITUDE.name)) == 20


def test_a_merged_sample_arrived_with_its_second_message(measurement):
    codec = XbusCodec(XbusParams(listen_only=True, rate_hz=100.0))
    codec.start(0)
    codec.feed(Chunk(1000, measurement(0, 0, {0x4020: IMU[0x4020]})))
    codec.feed(Chunk(2000, measurement(1, 0, {0x8020: IMU[0x8020]})))
    (batch,) = batches_of(codec.feed(Chunk(3000, measurement(2, 100, IMU))))
    assert batch.arrival_ns == 2000


def test_rate_and_acceleration_in_two_messages_make_one_sample(measurement, decode):
    stream = []
    for i in range(30):
        stream.append(measurement(2 * i, 100 * i, {0x8020: IMU[0x8020]}))
        stream.append(measurement(2 * i + 1, 100 * i, {0x4020: IMU[0x4020]}))
    items = decode(stream, rate_hz=100.0)
    assert device_ns_of(items) == [100 * i * TICK_NS for i in range(30)]


def test_a_stream_of_whole_instants_does_not_wait_for_the_next_message(measurement):
    codec = XbusCodec(XbusParams(listen_only=True, rate_hz=100.0))
    codec.start(0)
    stream = steady(measurement, 30)
    counts = [len(device_ns_of(codec.feed(Chunk(t, data)))) for t, data in enumerate(stream)]
    assert sum(counts) == 30
    assert counts[-15:] == [1] * 15


def test_a_stream_that_begins_to_split_is_merged_after_the_first_instant(measurement, decode):
    stream = steady(measurement, 20)
    for i in range(20, 60):
        stream.append(measurement(2 * i - 20, 100 * i, IMU))
        stream.append(measurement(2 * i - 19, 100 * i, {0x2010: (1.0, 0.0, 0.0, 0.0)}))
    items = decode(stream, rate_hz=100.0)
    assert device_ns_of(items) == [100 * i * TICK_NS for i in range(60)]
    merged = [b for b in batches_of(items) if ATTITUDE.name in b.channels]
    assert sum(len(batch) for batch in merged) == 39


def test_older_messages_about_satellites_change_nothing(measurement, decode):
    gnss = encode_item(0x7010, bytes(94))
    stream = []
    for i in range(40):
        stream.append(measurement(2 * i, 30_000 + 100 * i, IMU))
        status = encode_item(0xE020, (0x3F00).to_bytes(4, "big"))
        stream.append(measurement(2 * i + 1, 5_000 + 100 * i, {}, gnss + status))
    items = decode(stream, rate_hz=100.0)
    assert device_ns_of(items) == [(30_000 + 100 * i) * TICK_NS for i in range(40)]
    assert all(CLIP.name not in batch.channels for batch in batches_of(items))
    assert not any(batch.restarted for batch in batches_of(items))
    assert faults_of(items) == []


def test_samples_of_one_chunk_are_one_batch_even_across_lost_ones(measurement):
    codec = XbusCodec(XbusParams(listen_only=True, rate_hz=100.0))
    codec.start(0)
    codec.feed(Chunk(0, b"".join(steady(measurement, 20))))
    items = codec.feed(Chunk(7, b"".join(steady(measurement, 5, 20) + steady(measurement, 5, 30))))
    (batch,) = batches_of(items)
    assert (len(batch), batch.arrival_ns) == (10, 7)
    assert faults_of(items) == [("lost-messages", 5)]


def test_a_change_of_channels_begins_a_new_batch(measurement, decode):
    with_attitude = IMU | {0x2010: (1.0, 0.0, 0.0, 0.0)}
    stream = steady(measurement, 12)
    stream += [measurement(i, 100 * i, with_attitude) for i in range(12, 17)]
    items = decode([b"".join(stream)], rate_hz=100.0)
    assert [len(batch) for batch in batches_of(items)] == [12, 5]


def test_a_sample_held_back_keeps_the_time_its_bytes_arrived(measurement):
    codec = XbusCodec(XbusParams(listen_only=True, rate_hz=100.0))
    codec.start(0)
    first, second = steady(measurement, 2)
    assert codec.feed(Chunk(1000, first)) == []
    (batch,) = batches_of(codec.feed(Chunk(2000, second)))
    assert batch.arrival_ns == 1000


# Device time


@pytest.mark.parametrize("end", [2**32, 864_000_000])
@pytest.mark.parametrize("missing", [0, 3000])
def test_device_time_goes_on_across_both_wraps(measurement, decode, end, missing):
    ticks = [end - 1500 + 100 * i for i in range(15)]
    ticks += [100 * missing + 100 * i for i in range(15)]
    stream = [measurement(i, tick, IMU) for i, tick in enumerate(ticks)]
    items = decode(stream, rate_hz=100.0)
    steps = np.diff(device_ns_of(items)) // TICK_NS
    assert steps.tolist() == [100] * 14 + [100 * missing + 100] + [100] * 14
    assert not any(batch.restarted for batch in batches_of(items))


def test_the_wrap_of_the_golden_vector_is_one_sample_each(measurement, decode):
    stream = [
        measurement(counter, tick, IMU)
        for counter, tick in ((65534, 4294967196), (65535, 4294967295), (0, 99))
    ]
    items = decode(stream, rate_hz=100.0)
    assert np.diff(device_ns_of(items)).tolist() == [99 * TICK_NS, 100 * TICK_NS]
    assert faults_of(items) == []


@pytest.mark.parametrize("whole", [True, False])
def test_a_clock_that_goes_back_elsewhere_began_anew(measurement, decode, whole):
    stream = [measurement(50_000 + i, 500_000 + 100 * i, IMU) for i in range(25)]
    stream += [measurement(i, 100 * i, IMU) for i in range(1, 16)]
    items = decode([b"".join(stream)] if whole else stream, rate_hz=100.0)
    batches = batches_of(items)
    assert [int(b.device_ns[0]) for b in batches if b.restarted] == [100 * TICK_NS]
    assert device_ns_of(items)[25:] == [100 * i * TICK_NS for i in range(1, 16)]
    assert faults_of(items) == []


def test_after_a_wake_up_the_clock_began_anew_even_if_it_reads_later(measurement, decode):
    stream = steady(measurement, 15)
    stream += [encode_message(Mid.WAKE_UP)] + [
        measurement(20_000 + i, 9000 + 100 * i, IMU) for i in range(15)
    ]
    items = decode(stream, rate_hz=100.0)
    assert [int(b.device_ns[0]) for b in batches_of(items) if b.restarted] == [9000 * TICK_NS]
    assert faults_of(items) == []


def test_after_a_wake_up_no_earlier_wrap_counts(measurement, decode):
    ticks = [2**32 - 1500 + 100 * i for i in range(15)] + [100 * i for i in range(5)]
    stream = [measurement(i, tick, IMU) for i, tick in enumerate(ticks)]
    stream += [encode_message(Mid.WAKE_UP), measurement(1, 9000, IMU)]
    assert device_ns_of(decode(stream, rate_hz=100.0))[-1] == 9000 * TICK_NS


def test_without_sample_time_the_packet_counter_makes_the_time(measurement, decode):
    counters = [65530, 65531, 65535, 0, 1, 2, 7]
    stream = [measurement(counter, None, IMU) for counter in counters]
    items = decode(stream, rate_hz=50.0)
    assert (np.diff(device_ns_of(items)) // 20_000_000).tolist() == [1, 4, 1, 1, 1, 5]
    assert sum(count for kind, count in faults_of(items) if kind == "lost-messages") == 7


def test_messages_about_satellites_take_no_time_where_the_counter_makes_it(measurement, decode):
    stream = []
    for i in range(0, 20, 2):
        stream.append(measurement(i, None, IMU))
        stream.append(measurement(i + 1, None, {}, encode_item(0x7010, bytes(94))))
    items = decode(stream, rate_hz=50.0)
    assert (np.diff(device_ns_of(items)) // 20_000_000).tolist() == [1] * 9


def test_without_sample_time_a_wake_up_is_a_restart(measurement, decode):
    stream = [measurement(i, None, IMU) for i in range(5)]
    stream += [encode_message(Mid.WAKE_UP)]
    stream += [measurement(9000 + i, None, IMU) for i in range(5)]
    items = decode(stream, rate_hz=50.0)
    assert [len(b) for b in batches_of(items) if b.restarted] == [1]
    assert faults_of(items) == []


def test_sample_time_that_comes_late_in_a_stream_is_a_restart(measurement, decode):
    stream = [measurement(i, None, IMU) for i in range(10)]
    stream += [measurement(i, 100 * i - 900, IMU) for i in range(10, 20)]
    items = decode(stream, rate_hz=50.0)
    assert [int(b.device_ns[0]) for b in batches_of(items) if b.restarted] == [100 * TICK_NS]
    assert len(device_ns_of(items)) == 20


def test_without_sample_time_and_rate_the_remedy_is_said_once(measurement, decode):
    items = decode([measurement(i, None, IMU) for i in range(20)])
    (failed,) = items
    assert isinstance(failed, HandshakeFailed)
    assert "rate_hz" in failed.reason


# Sample period


def test_the_period_is_the_most_common_step_of_the_first_ten(measurement):
    codec = XbusCodec(XbusParams(listen_only=True))
    codec.start(0)
    ticks = [0, 100, 350, 400, 500, 600, 900, 1000, 1100, 1200, 1225, 1250, 1275]
    stream = [measurement(i, tick, IMU) for i, tick in enumerate(ticks)]
    items = [codec.feed(Chunk(t, data)) for t, data in enumerate(stream)]
    assert all(not found for found in items[:9])
    (batch,) = batches_of(items[9])
    assert (len(batch), batch.period_s) == (10, 0.01)
    assert status_of(items[9], "sample_rate_hz") == [100.0]


def test_finish_releases_what_was_held_for_the_period(measurement, decode):
    items = decode(steady(measurement, 4))
    assert device_ns_of(items) == [100 * i * TICK_NS for i in range(4)]
    assert {batch.period_s for batch in batches_of(items)} == {0.01}


def test_one_sample_alone_is_a_fault_as_it_has_no_period(measurement, decode):
    assert faults_of(decode(steady(measurement, 1))) == [("no-period", 1)]


def test_samples_that_never_go_forward_are_not_held_for_ever(measurement, decode):
    stream = [measurement(i, 10_000_000 - 100 * i, IMU) for i in range(95)]
    items = decode(stream)
    assert sum(count for kind, count in faults_of(items) if kind == "no-period") == 95
    assert batches_of(items) == []


# Faults


def test_a_hole_in_the_packet_counter_is_counted(measurement, decode):
    stream = steady(measurement, 15) + steady(measurement, 15, 18) + steady(measurement, 9, 34)
    items = decode(stream, rate_hz=100.0)
    assert sum(count for kind, count in faults_of(items) if kind == "lost-messages") == 4
    assert len(device_ns_of(items)) == 39


def test_losses_before_the_first_sample_are_no_restart(measurement, decode):
    gnss = encode_item(0x7010, bytes(94))
    stream = [measurement(0, None, {}, gnss), measurement(7, None, {}, gnss)]
    items = decode([*stream, measurement(8, 100, IMU)], rate_hz=100.0)
    assert [batch.restarted for batch in batches_of(items)] == [False]
    assert faults_of(items) == [("lost-messages", 6)]


def test_a_counter_that_jumps_back_is_no_loss(measurement, decode):
    stream = steady(measurement, 15) + [
        measurement(40_000 + i, 100 * i, IMU) for i in range(15, 20)
    ]
    assert faults_of(decode(stream, rate_hz=100.0)) == []


def test_messages_of_all_kinds_share_the_packet_counter(measurement, decode):
    stream = []
    for i in range(20):
        stream.append(measurement(3 * i, 100 * i, IMU))
        stream.append(measurement(3 * i + 1, None, {}, encode_item(0x7010, bytes(94))))
        stream.append(measurement(3 * i + 2, 17, {0x0810: (20.0,)}))
    assert faults_of(decode(stream, rate_hz=100.0)) == []


def test_an_item_that_reaches_beyond_its_payload_costs_only_its_message(measurement, decode):
    bad = measurement(15, 1500, IMU, bytes.fromhex("e02050") + bytes(4))
    items = decode([*steady(measurement, 15), bad, *steady(measurement, 15, 16)], rate_hz=100.0)
    assert faults_of(items) == [("bad-payload", 1)]
    assert device_ns_of(items) == [100 * i * TICK_NS for i in range(31) if i != 15]


def test_an_item_of_the_wrong_size_is_a_bad_payload(measurement, decode):
    bad = measurement(15, 1500, {0x8020: (0.0, 0.0, 0.0)}, encode_item(0x4020, bytes(6)))
    items = decode([*steady(measurement, 15), bad], rate_hz=100.0)
    assert faults_of(items) == [("bad-payload", 1)]
    assert "item 4020 has 6 bytes, not 12" in next(i for i in items if isinstance(i, Fault)).detail


def test_unknown_items_are_skipped_by_their_size(measurement, decode):
    stream = [
        measurement(i, 100 * i, IMU, encode_item(0x9990, bytes(i)) + encode_item(0x0040, b""))
        for i in range(20)
    ]
    items = decode(stream, rate_hz=100.0)
    assert len(device_ns_of(items)) == 20
    assert faults_of(items) == []


def test_garbage_is_told_in_bytes_and_broken_messages_in_number(measurement, decode):
    broken = bytearray(measurement(15, 1500, IMU))
    broken[20] ^= 1
    stream = [*steady(measurement, 15), b"garbage", bytes(broken), *steady(measurement, 15, 16)]
    items = decode([b"".join(stream)], rate_hz=100.0)
    told = dict(faults_of(items))
    assert told == {"resync": 7 + len(broken), "bad-checksum": 1, "lost-messages": 1}


def test_each_fault_is_told_once(measurement, decode):
    stream = [*steady(measurement, 15), b"garbage", *steady(measurement, 5, 15), b"more"]
    items = decode([*stream, *steady(measurement, 5, 20)], rate_hz=100.0)
    assert faults_of(items) == [("resync", 7), ("resync", 4)]


@pytest.mark.parametrize(
    ("mid", "data", "words"),
    [
        (Mid.ERROR, "1e", ["error", "0x1E", "timer overflow"]),
        (Mid.ERROR, "2800000007", ["error", "0x28", "00000007"]),
        (Mid.WARNING, "29", ["warning", "0x29", "unknown meaning"]),
        (Mid.ERROR, "", ["no code"]),
    ],
)
def test_errors_of_the_device_are_told_in_words(measurement, decode, mid, data, words):
    items = decode([encode_message(mid, bytes.fromhex(data))])
    assert faults_of(items) == [("device-error", 1)]
    assert all(word in items[0].detail for word in words)


def test_a_stream_that_ends_within_a_message_is_a_fault(measurement, decode):
    items = decode([*steady(measurement, 15), measurement(15, 1500, IMU)[:30]], rate_hz=100.0)
    assert dict(faults_of(items)) == {"stall": 1, "resync": 30}


@pytest.mark.parametrize(("rate_hz", "stalls"), [(100.0, 1), (10.0, 0)])
def test_a_message_may_take_three_periods(measurement, rate_hz, stalls):
    codec = XbusCodec(XbusParams(listen_only=True, rate_hz=rate_hz))
    codec.start(0)
    codec.feed(Chunk(1, measurement(0, 0, IMU) + bytes.fromhex("faff36ff0800")))
    items = codec.feed(Chunk(200_000_000, measurement(1, 100, IMU)))
    assert dict(faults_of(items)).get("stall", 0) == stalls


# Temperature


def test_temperature_is_told_at_first_and_when_it_changed_but_once_a_minute(measurement, decode):
    told_c = {0: 20.0, 10: 20.4, 30: 22.0, 61: 22.25, 62: 23.5, 100: 30.0, 130: 30.0, 300: 30.4}
    stream = [
        measurement(i, second * S_TICKS, IMU | {0x0810: (celsius,)})
        for i, (second, celsius) in enumerate(told_c.items())
    ]
    items = decode(stream, rate_hz=100.0)
    assert status_of(items, "temperature_celsius") == [20.0, 22.25, 30.0]


def test_a_temperature_that_is_no_number_is_not_told(measurement, decode):
    items = decode([measurement(0, 0, IMU | {0x0810: (math.nan,)})], rate_hz=100.0)
    assert status_of(items, "temperature_celsius") == []
