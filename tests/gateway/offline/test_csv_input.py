import time

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gaitway.errors import InputDataError
from gaitway.offline.csv_input import read_csv
from gaitway.samples import ACCEL, FORCE, GYRO, INCLINATION, Channel, Gap, SampleBatch

IMU = (ACCEL, GYRO)
HEADER = ",".join(["t_s", *ACCEL.columns, *GYRO.columns])


def refusal(path, required=IMU):
    with pytest.raises(InputDataError) as caught:
        read_csv(path, required)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)
    return str(caught.value).removeprefix(f"{path}: ")


def replace_line(path, number, text):
    lines = path.read_text().splitlines()
    lines[number - 1] = text
    path.write_text("\n".join(lines) + "\n")
    return path


def replace_cell(path, number, column, text):
    lines = path.read_text().splitlines()
    cells = lines[number - 1].split(",")
    cells[lines[0].split(",").index(column)] = text
    return replace_line(path, number, ",".join(cells))


def test_a_good_file_is_one_batch_of_exactly_its_numbers(good_csv):
    path = good_csv(n=500)
    recording = read_csv(path, IMU)
    table = [[float(cell) for cell in line.split(",")] for line in path.read_text().split()[1:]]
    (batch,) = recording.items
    assert batch.channels["accel"].tolist() == [row[1:4] for row in table]
    assert batch.channels["gyro"].tolist() == [row[4:] for row in table]
    assert batch.t_ns.tolist() == [round(row[0] * 1e9) for row in table]
    assert (batch.period_s, batch.sequence) == (pytest.approx(0.01), 0)
    assert (recording.samples, recording.samples_lost) == (500, 0)
    assert recording.duration_s == pytest.approx(4.99)
    assert (recording.channels, recording.notes) == (frozenset({"accel", "gyro"}), [])


def test_arrays_are_read_only_and_contiguous(good_csv):
    (batch,) = read_csv(good_csv(), IMU).items
    for values in (batch.t_ns, *batch.channels.values()):
        assert values.flags["C_CONTIGUOUS"]
        assert not values.flags["WRITEABLE"]


def test_columns_may_come_in_any_order_and_others_are_passed_over_with_a_note(write_csv, walk):
    t_s, accel, gyro = walk(n=100)
    header = (
        "gyro_z_radps,accel_x_mps2,label,accel_z_mps2,t_s,force_newton,gyro_x_radps,gyro_y_radps,"
        "accel_y_mps2"
    )
    rows = [
        f"{w[2]!r},{a[0]!r},left foot,{a[2]!r},{t!r},{t * 2!r},{w[0]!r},{w[1]!r},{a[1]!r}"
        for t, a, w in zip(t_s.tolist(), accel.tolist(), gyro.tolist(), strict=True)
    ]
    recording = read_csv(write_csv(*rows, header=header), IMU)
    (batch,) = recording.items
    assert batch.channels["accel"].tolist() == accel.tolist()
    assert batch.channels["gyro"].tolist() == gyro.tolist()
    assert batch.channels["force"].ravel().tolist() == (t_s * 2).tolist()
    assert recording.notes == ["columns passed over: label"]


def test_a_channel_with_a_missing_column_is_not_used_and_told(write_csv, walk):
    table = np.column_stack([*walk(), np.ones((1000, 3))])
    path = write_csv(table=table, header=HEADER + ",q_w,q_x,q_y")
    recording = read_csv(path, IMU)
    assert "q_nb" not in recording.channels
    assert "channel q_nb is not used: q_z is missing" in recording.notes


def test_a_channel_of_a_plugin_is_read_by_its_own_columns(write_csv):
    grip = Channel("acme_grip", ("grip_newton",))
    path = write_csv("0.00,1.5", "0.01,2.5", header="t_s,grip_newton")
    (batch,) = read_csv(path, (grip,)).items
    assert batch.channels["acme_grip"].tolist() == [[1.5], [2.5]]


@pytest.mark.parametrize("end", ["\r\n", "\n", "\r"])
def test_any_end_of_line_a_byte_order_mark_and_quoted_names_are_read(good_csv, end):
    path = good_csv(n=50)
    expected = read_csv(path, IMU).items[0].channels["gyro"].tolist()
    header, *rows = path.read_text().splitlines()
    quoted = ",".join(f'"{name}"' for name in header.split(","))
    path.write_bytes(b"\xef\xbb\xbf" + end.join([quoted, *rows, "", ""]).encode())
    assert read_csv(path, IMU).items[0].channels["gyro"].tolist() == expected


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=30)
@given(st.sets(st.integers(31, 298), max_size=120))
def test_missing_rows_are_gaps_of_exactly_their_number(write_csv, walk, missing):
    kept = [row for row in range(300) if row not in missing]
    path = write_csv(table=np.column_stack(walk(n=300, rate_hz=204.8))[kept])
    recording = read_csv(path, IMU)
    numbers = []
    expected = 0
    for item in recording.items:
        if isinstance(item, Gap):
            assert item.t_ns == pytest.approx(expected / 204.8 * 1e9, abs=0.2e6)
            assert item.reason == "lost"
            expected += item.n_missing
        else:
            assert item.sequence == expected
            numbers += range(expected, expected + len(item))
            expected += len(item)
    assert numbers == kept
    assert isinstance(recording.items[-1], SampleBatch)
    assert recording.samples_lost == len(missing)


def test_gaps_are_told(write_csv, walk):
    table = np.delete(np.column_stack(walk(n=300)), [100, 101, 102, 200], axis=0)
    assert read_csv(write_csv(table=table), IMU).notes == ["4 samples are missing, in 2 gaps"]


def test_an_hour_at_100_hz_is_read_within_seconds_of_processor_time(good_csv):
    """0.5 s on the machine it was written on; the bound leaves room for slower ones."""
    path = good_csv(n=1000)
    header, *rows = path.read_text().split()
    values = [row.split(",", 1)[1] for row in rows]
    hour = [f"{row / 100:.2f},{values[row % 1000]}" for row in range(360_000)]
    path.write_text("\n".join([header, *hour]))
    begun_s = time.process_time()
    assert read_csv(path, IMU).samples == 360_000
    assert time.process_time() - begun_s < 4.0


def test_the_careful_reader_reads_the_same_numbers(good_csv, monkeypatch):
    path = good_csv(n=300)
    fast = read_csv(path, IMU)
    monkeypatch.setattr("gaitway.offline.csv_input.read_plain", lambda _: None)
    careful = read_csv(path, IMU)
    for name in ("accel", "gyro"):
        assert np.array_equal(fast.items[0].channels[name], careful.items[0].channels[name])
    assert fast.items[0].t_ns.tolist() == careful.items[0].t_ns.tolist()


# --- what is refused -------------------------------------------------------------------------


def test_a_file_that_is_not_there_is_named(tmp_path):
    assert refusal(tmp_path / "none.csv") == "No such file or directory"


@pytest.mark.parametrize("content", [b"", b"\n\n  \n"])
def test_an_empty_file_is_refused(tmp_path, content):
    path = tmp_path / "walk.csv"
    path.write_bytes(content)
    assert refusal(path) == "the file is empty"


@pytest.mark.parametrize("rows", [0, 1])
def test_fewer_than_two_rows_are_refused(good_csv, rows):
    path = good_csv()
    path.write_text("\n".join(path.read_text().splitlines()[: rows + 1]))
    assert refusal(path) == f"{rows} rows of samples: a walk needs at least 2"


def test_text_that_is_not_utf8_is_refused_with_its_line(good_csv):
    path = good_csv()
    path.write_bytes(path.read_bytes().replace(b"\n", b"\n\xe4", 3))
    text = refusal(path)
    assert text.startswith("line 2: ")
    assert "save the table as CSV, UTF-8" in text


def test_a_binary_file_is_refused(tmp_path):
    path = tmp_path / "walk.csv"
    path.write_bytes(b"t_s,\0\0\0\1")
    assert "binary file" in refusal(path)


@pytest.mark.parametrize(("delimiter", "told"), [(";", "semicolons"), ("\t", "tabs")])
def test_another_separator_is_named(good_csv, delimiter, told):
    path = good_csv()
    path.write_text(path.read_text().replace(",", delimiter))
    assert refusal(path).startswith(f"line 1: columns are separated by {told} (use commas")


def test_a_missing_header_is_told(good_csv):
    path = good_csv()
    path.write_text(path.read_text().split("\n", 1)[1])
    assert "line 1: numbers where the names" in refusal(path)


def test_a_column_that_is_there_twice_is_refused(good_csv):
    path = good_csv()
    path.write_text(path.read_text().replace("gyro_x_radps", "accel_x_mps2", 1))
    assert "column 'accel_x_mps2' is there twice" in refusal(path)


@pytest.mark.parametrize(
    ("others", "told"),
    [
        ("time,ax,ay,az,gx,gy,gz", "'time' -> t_s, 'ax' -> accel_x_mps2"),
        ("Timestamp,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z", "'Gyr_Z' -> gyro_z_radps"),
        ("t_s,accelX [g],accelY [g],accelZ [g],wx,wy,wz", "'accelZ [g]' -> accel_z_mps2"),
        ("t_s,accel_x,accel_y,accel_z,gyro_x_dps,gyro_y_dps,gyro_z_dps", "'gyro_x_dps' ->"),
        ("t_s,accel_x_ms2,accel_y_ms2,accel_z_ms2,gx,gy,gz", "'accel_x_ms2' -> accel_x_mps2"),
    ],
)
def test_missing_columns_are_named_with_those_that_look_similar(good_csv, others, told):
    path = replace_line(good_csv(), 1, others)
    text = refusal(path)
    assert text.startswith("line 1: columns missing: ")
    assert "accel_x_mps2, accel_y_mps2, accel_z_mps2" in text
    assert told in text
    assert "convert the values" in text


def test_missing_columns_without_similar_ones_are_named_with_what_is_there(good_csv):
    text = refusal(good_csv(), (*IMU, FORCE))
    assert text.startswith("line 1: columns missing: force_newton (the header names t_s, accel_x")


@pytest.mark.parametrize(
    ("cell", "told"),
    [
        ("", "the cell is empty"),
        ("  ", "the cell is empty"),
        ("nan", "'nan' is not finite"),
        ("-inf", "'-inf' is not finite"),
        ("abc", "'abc' is no number"),
        ("1.2.3", "'1.2.3' is no number"),
        ("1_000", "'1_000' is no number"),
        ('"1.0"', "'\"1.0\"' is no number"),
    ],
)
@pytest.mark.parametrize("column", ["t_s", "accel_y_mps2", "gyro_z_radps"])
@pytest.mark.parametrize("line", [2, 57])
def test_a_cell_that_is_no_number_is_told_with_line_and_column(good_csv, line, column, cell, told):
    path = replace_cell(good_csv(n=100), line, column, cell)
    assert refusal(path).startswith(f"line {line}, column {column}: {told}")


def test_the_first_bad_cell_is_told_when_there_are_more(good_csv):
    path = replace_cell(good_csv(n=100), 40, "accel_x_mps2", "nan")
    replace_cell(path, 30, "gyro_x_radps", "oops")
    assert refusal(path).startswith("line 30, column gyro_x_radps")


@pytest.mark.parametrize("extra", [False, True])
@pytest.mark.parametrize(
    ("text", "told"),
    [("0.5,1", "2 cells where"), ("0,5,1,2,3,4,5,6,7,8,9", "11 cells where"), ("", "is empty")],
)
def test_a_line_of_another_length_is_told(good_csv, text, told, extra):
    path = good_csv(n=100)
    if extra:
        lines = path.read_text().split()
        path.write_text("\n".join([lines[0] + ",label", *(f"{line},x" for line in lines[1:])]))
    assert refusal(replace_line(path, 51, text)).startswith(f"line 51: {told}")


def test_the_last_line_cut_off_is_told(good_csv):
    path = good_csv(n=100)
    path.write_text(path.read_text()[:-40])
    assert "line 101: " in refusal(path)
    assert "is the line cut off" in refusal(path)


@pytest.mark.parametrize("t_s", ["0.4700", "0.4800"])
def test_unsorted_or_repeated_time_is_told_with_its_line(good_csv, t_s):
    path = replace_cell(good_csv(n=100), 51, "t_s", t_s)
    assert refusal(path).startswith("line 51, column t_s: time ")


def test_time_off_the_grid_is_told_with_its_line(good_csv):
    path = replace_cell(good_csv(n=100), 51, "t_s", "0.4940")
    text = refusal(path)
    assert text.startswith("line 51, column t_s: time is ")
    assert "off the sample grid" in text


@pytest.mark.parametrize(
    ("factor", "unit"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")]
)
def test_time_in_another_unit_is_refused(write_csv, walk, factor, unit):
    t_s, accel, gyro = walk()
    path = write_csv(table=np.column_stack([t_s * factor, accel, gyro]))
    assert refusal(path).startswith(f"column t_s: t_s looks like {unit}")


def test_time_too_large_for_64_bits_of_nanoseconds_is_refused(write_csv, walk):
    t_s, accel, gyro = walk()
    path = write_csv(table=np.column_stack([t_s + 1e10, accel, gyro]))
    assert refusal(path) == (
        "column t_s: 1e+10 is no time in seconds (count from the start of the walk, or from 1970)"
    )


def test_seconds_since_1970_are_read(write_csv, walk):
    t_s, accel, gyro = walk(n=300)
    table = np.delete(np.column_stack([t_s + 1.7e9, accel, gyro]), slice(100, 150), axis=0)
    recording = read_csv(write_csv(table=table), IMU)
    assert recording.samples_lost == 50


@pytest.mark.parametrize(
    ("factor", "told"),
    [
        (1 / 9.80665, "looks like g: "),
        (1000 / 9.80665, "looks like thousandths of g: "),
        (9.80665, "once too often"),
        (0.3, "is no specific force"),
        (0.0, "is no specific force"),
    ],
)
def test_specific_force_in_another_unit_is_refused(write_csv, walk, factor, told):
    t_s, accel, gyro = walk()
    path = write_csv(table=np.column_stack([t_s, accel * factor, gyro]))
    text = refusal(path)
    assert text.startswith("columns accel_x_mps2, accel_y_mps2, accel_z_mps2: ")
    assert told in text


def test_the_remedy_for_g_is_the_factor(write_csv, walk):
    t_s, accel, gyro = walk()
    path = write_csv(table=np.column_stack([t_s, accel / 9.80665, gyro]))
    assert "(multiply by 9.80665)" in refusal(path)


@pytest.mark.parametrize("amplitude_rad", [0.05, 0.3, 1.0])
def test_angular_rate_in_degrees_is_refused_for_slow_movement_too(write_csv, walk, amplitude_rad):
    t_s, accel, gyro = walk(amplitude_rad=amplitude_rad)
    path = write_csv(table=np.column_stack([t_s, accel, np.degrees(gyro)]))
    text = refusal(path)
    assert text.startswith("columns gyro_x_radps, gyro_y_radps, gyro_z_radps: looks like degrees")
    assert "(multiply by 0.0174533)" in text


def test_angular_rate_in_degrees_is_refused_without_an_accelerometer(write_csv, walk):
    t_s, _, gyro = walk()
    header = ",".join(["t_s", *GYRO.columns])
    path = write_csv(table=np.column_stack([t_s, np.degrees(gyro)]), header=header)
    assert "more than any sensor measures" in refusal(path, (GYRO,))


@pytest.mark.parametrize("amplitude_rad", [0.0, 0.05, 0.3, 1.0])
@pytest.mark.parametrize("mirrored", [1, -1])
def test_angular_rate_in_radians_is_accepted_even_with_a_mirrored_axis(
    write_csv, walk, amplitude_rad, mirrored
):
    t_s, accel, gyro = walk(amplitude_rad=amplitude_rad, frequency_hz=1.0)
    path = write_csv(table=np.column_stack([t_s, accel, mirrored * gyro]))
    assert read_csv(path, IMU).samples == 1000


def test_inclination_in_degrees_is_refused(write_csv):
    t_s = np.arange(100) / 100.0
    table = np.column_stack([t_s, 30 * np.sin(t_s * 6)])
    path = write_csv(table=table, header="t_s,inclination_rad")
    assert refusal(path, (INCLINATION,)).startswith("columns inclination_rad: looks like degrees")
