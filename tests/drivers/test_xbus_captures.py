"""Whole recordings of a real MTi-G-710 against the text its authors' decoder wrote."""

from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from gaitway.api import ACCEL, CLIP, GYRO, DeviceBatch, Fault
from gaitway_drivers.codecs.xbus.framer import Framer
from gaitway_drivers.codecs.xbus.mtdata2 import parse_layout, quantity_id
from gaitway_drivers.codecs.xbus.outputs import decode_outputs, judge_outputs

RECORDINGS = ["1", "2"]

GOLDEN_IDS = {
    "PacketCounter": 0x1020,
    "SampleTimeFine": 0x1060,
    "UTCTime": 0x1010,
    "StatusWord": 0xE020,
    "StatusByte": 0xE010,
    "EulerAngles": 0x2030,
    "Acceleration": 0x4020,
    "DeltaV": 0x4010,
    "RateOfTurn": 0x8020,
    "DeltaQ": 0x8030,
    "LatLon": 0x5040,
    "AltitudeEllipsoid": 0x5020,
    "VelocityXYZ": 0xD010,
    "GNSSPVTData": 0x7010,
}
NUMBER_FORMATS = {"1": "Float32", "2": "FP1220"}


def golden_messages(path: Path) -> Iterator[dict[int, list[str]]]:
    """Yield each message of a golden text: data id without format bits to the lines below it."""
    for block in path.read_text().split("\n\n"):
        message: dict[int, list[str]] = {}
        lines: list[str] = []
        for line in block.splitlines():
            if line.startswith("  "):
                lines.append(line.strip())
            else:
                name = line.rstrip(":").split("(")[0]
                lines = message[GOLDEN_IDS[name]] = []
        if message:
            yield message


def values_of(lines: list[str]) -> list[float]:
    return [float(line.split(":")[-1]) for line in lines]


def utc_of(value: np.void) -> str:
    moment = datetime(
        *(int(value[name]) for name in ("year", "month", "day", "hour", "minute", "second")),
        tzinfo=UTC,
    )
    fraction = f"{int(value['ns']):09d}".rstrip("0")
    return f"{moment:%Y-%m-%dT%H:%M:%S}{'.' + fraction if fraction else ''}Z"


@pytest.mark.parametrize("recording", RECORDINGS)
def test_every_item_of_a_recording_equals_its_golden_text(
    golden: Path, recording: str, item_value: Callable
) -> None:
    folder = golden / "xsens_einride" / recording
    framer = Framer()
    runs = framer.feed(0, (folder / "output.bin").read_bytes()) + framer.finish()
    payloads = [row for run in runs for row in run.payloads]
    messages = list(golden_messages(folder / "output.golden"))
    assert (framer.junk_bytes, framer.bad_checksums) == (0, 0)
    assert len(payloads) == len(messages) == 100
    for payload, message in zip(payloads, messages, strict=True):
        layout = parse_layout(payload.tobytes())
        assert layout.fault == ""
        assert {quantity_id(item.data_id) for item in layout.items} == message.keys()
        for item in layout.items:
            lines = message[quantity_id(item.data_id)]
            value = item_value(layout, item, payload.tobytes())
            if item.data_id == 0x1010:
                assert utc_of(value) == lines[0]
            elif item.data_id in (0xE010, 0xE020):
                assert int(value) == int(lines[0], 2)
            elif item.data_id == 0x7010:
                assert int.from_bytes(value.tobytes()[:4], "big") == values_of(lines)[0]
            else:
                assert np.ravel(value).tolist() == values_of(lines)


@pytest.mark.parametrize("recording", RECORDINGS)
def test_every_message_with_rate_and_acceleration_is_a_sample(
    golden: Path, recording: str, decode: Callable
) -> None:
    folder = golden / "xsens_einride" / recording
    expected = [m for m in golden_messages(folder / "output.golden") if 0x4020 in m and 0x8020 in m]
    items = decode([(folder / "output.bin").read_bytes()])
    batches = [item for item in items if isinstance(item, DeviceBatch)]
    assert not [item for item in items if isinstance(item, Fault)]
    assert {batch.period_s for batch in batches} == {0.01}
    device_ns = np.concatenate([batch.device_ns for batch in batches])
    accel = np.concatenate([batch.channels[ACCEL.name] for batch in batches])
    gyro = np.concatenate([batch.channels[GYRO.name] for batch in batches])
    assert device_ns.tolist() == [int(message[0x1060][0]) * 100_000 for message in expected]
    assert accel.tolist() == [values_of(message[0x4020]) for message in expected]
    assert gyro.tolist() == [values_of(message[0x8020]) for message in expected]


def test_status_word_of_a_recording_becomes_clip_flags(capture: bytes, decode: Callable) -> None:
    batches = [item for item in decode([capture]) if isinstance(item, DeviceBatch)]
    assert all((batch.channels[CLIP.name] == 0.0).all() for batch in batches)


@pytest.mark.parametrize("recording", RECORDINGS)
def test_output_configuration_of_a_recording_is_read_as_its_golden_text(
    golden: Path, recording: str
) -> None:
    folder = golden / "xsens_einride" / recording
    lines = (folder / "outputconfig.golden").read_text().splitlines()
    expected = []
    for name, rate in zip(lines[::2], lines[1::2], strict=True):
        number_format = 1 if "FP1220" in name else 0
        hertz = 0xFFFF if rate.strip() == "Max" else int(rate.split()[0])
        expected.append((GOLDEN_IDS[name.rstrip(":").split("(")[0]] | number_format, hertz))
    outputs = decode_outputs((folder / "outputconfig.bin").read_bytes())
    assert [(output.data_id, output.rate) for output in outputs] == expected
    report = judge_outputs(outputs)
    assert (report.missing, report.rate_hz) == ("", 100.0)
