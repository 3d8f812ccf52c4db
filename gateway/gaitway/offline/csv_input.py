"""Walks from CSV files: read fast, refused with the line and the remedy when anything is wrong."""

import difflib
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from gaitway.errors import InputDataError
from gaitway.offline.plain_csv import read_plain
from gaitway.offline.plausibility import accel_complaint, angle_complaint, gyro_complaint
from gaitway.offline.recording import OfflineRecording
from gaitway.offline.time_grid import Grid, GridError, find_grid
from gaitway.samples import (
    ACCEL,
    CHANNELS,
    GYRO,
    INCLINATION,
    INCLINATION_ROLL,
    Channel,
    EstimatorInput,
    Floats,
    Gap,
    Ints,
    Required,
    SampleBatch,
)
from gaitway.timebase import NS_PER_S

TIME: Final = "t_s"
FIRST_ROW_LINE: Final = 2
MAX_TIME_S: Final = 9e9
"""Nanoseconds beyond this don't fit 64 bits; seconds since 1970 do."""
ALIASES: Final = {
    TIME: r"t|sec|seconds|time.*|timestamp.*|.*_time",
    **{f"accel_{axis}_mps2": rf"(a|acc|accel\w*)[ _.-]?{axis}([^a-z].*)?" for axis in "xyz"},
    **{
        f"gyro_{axis}_radps": rf"(g|gyr|gyro\w*|w|omega|ang\w*)[ _.-]?{axis}([^a-z].*)?"
        for axis in "xyz"
    },
}
"""What others call these columns, as patterns over the lower-case name."""


def read_csv(path: Path, required: Required) -> OfflineRecording:
    """Return the walk of a CSV file whose header names columns as ``samples.CHANNELS`` does.

    Rows that are missing on the sample grid become gaps. ``t_ns`` is ``t_s`` in nanoseconds.

    Args:
        path: The file: UTF-8, commas, decimal points, a header line.
        required: Channels that must be there; of a tuple any one will do.

    Raises:
        InputDataError: The file can't be used; the text names line, column and remedy.
    """
    content = _read_bytes(path)
    plain = read_plain(content)
    first, *lines = [plain[0]] if plain else _lines(path, content)
    header = [cell.strip().strip('"').strip() for cell in first.split(",")]
    channels, notes = _choose(path, header, required)
    names = [TIME, *(column for channel in channels for column in channel.columns)]
    columns = [header.index(name) for name in names]
    table = plain[1][:, columns] if plain else _parse(path, lines, header, columns)
    grid = _grid(path, table[:, 0])
    values = _split(table[:, 1:], channels)
    _check_units(path, values, grid)
    items = _items(table[:, 0], grid, values)
    gaps = [item.n_missing for item in items if isinstance(item, Gap)]
    if gaps:
        notes.append(f"{sum(gaps)} samples are missing, in {len(gaps)} gaps")
    return OfflineRecording(path, grid.period_s, items, frozenset(values), notes)


def _read_bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as exc:
        raise InputDataError(f"{path}: {exc.strerror}") from exc


def _lines(path: Path, content: bytes) -> list[str]:
    if not content.strip():
        raise InputDataError(f"{path}: the file is empty")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as exc:
        line = content[: exc.start].count(b"\n") + 1
        raise InputDataError(
            f"{path}: line {line}: this is no text in UTF-8 (save the table as CSV, UTF-8)"
        ) from exc
    if "\0" in text:
        raise InputDataError(f"{path}: this is a binary file (save the table as CSV, UTF-8)")
    return text.rstrip().splitlines()


def _choose(path: Path, header: list[str], required: Required) -> tuple[list[Channel], list[str]]:
    """Return the channels that are there, and notes on the columns that are passed over."""
    _check_header(path, header)
    single = [entry for entry in required if isinstance(entry, Channel)]
    needed = [TIME, *(column for channel in single for column in channel.columns)]
    missing = [column for column in needed if column not in header]
    if missing:
        raise InputDataError(f"{path}: line 1: {_missing_columns(missing, header)}")
    alternatives = [entry for entry in required if isinstance(entry, tuple)]
    asked = (*single, *(channel for entry in alternatives for channel in entry))
    known = {channel.name: channel for channel in (*CHANNELS, *asked)}.values()
    channels = [channel for channel in known if set(channel.columns) <= set(header)]
    for entry in alternatives:
        if not set(entry) & set(channels):
            either = " or ".join(", ".join(channel.columns) for channel in entry)
            raise InputDataError(
                f"{path}: line 1: columns missing: {either} (the header names {', '.join(header)})"
            )
    used = {TIME, *(column for channel in channels for column in channel.columns)}
    notes = []
    unused = [name for name in header if name not in used]
    if unused:
        notes.append(f"columns passed over: {', '.join(unused)}")
    for channel in known:
        absent = [column for column in channel.columns if column not in header]
        if channel not in channels and len(absent) < len(channel.columns):
            notes.append(f"channel {channel.name} is not used: {', '.join(absent)} is missing")
    return channels, notes


def _check_header(path: Path, header: list[str]) -> None:
    for delimiter, told in ((";", "semicolons"), ("\t", "tabs")):
        if len(header) == 1 and delimiter in header[0]:
            raise InputDataError(
                f"{path}: line 1: columns are separated by {told} (use commas, and decimal points)"
            )
    if all(_is_number(name) for name in header):
        raise InputDataError(
            f"{path}: line 1: numbers where the names of the columns should be (add a header, "
            "for example t_s,accel_x_mps2,...)"
        )
    for name in header:
        if header.count(name) > 1:
            raise InputDataError(f"{path}: line 1: column {name!r} is there twice (remove one)")


def _missing_columns(missing: Sequence[str], header: Sequence[str]) -> str:
    similar = {column: name for column in missing if (name := _similar(column, header))}
    if not similar:
        return f"columns missing: {', '.join(missing)} (the header names {', '.join(header)})"
    renames = ", ".join(f"{name!r} -> {column}" for column, name in similar.items())
    return (
        f"columns missing: {', '.join(missing)}; these look similar: {renames} (rename them, and "
        "convert the values to the unit in the name)"
    )


def _similar(column: str, header: Sequence[str]) -> str | None:
    pattern = ALIASES.get(column)
    for name in header:
        if pattern and re.fullmatch(pattern, name.lower()):
            return name
    others = [name for name in header if name not in ALIASES]
    close = difflib.get_close_matches(column, others, n=1, cutoff=0.8)
    return close[0] if close else None


def _parse(path: Path, lines: list[str], header: list[str], columns: list[int]) -> Floats:
    """Return the wanted columns, shape (rows, columns)."""
    if len(lines) < 2:
        raise InputDataError(f"{path}: {len(lines)} rows of samples: a walk needs at least 2")
    try:
        table = _load(lines, len(header), columns)
    except ValueError as exc:
        _find_bad_cell(path, lines, header, columns)
        raise InputDataError(f"{path}: {exc}") from exc
    if not np.isfinite(table).all():
        _find_bad_cell(path, lines, header, columns)
    return table


def _load(lines: list[str], width: int, columns: list[int]) -> Floats:
    """Return columns of lines that all have the same number of cells; ValueError otherwise."""
    if len(columns) == width:
        # Without usecols numpy itself sees to it that no line has more or fewer cells.
        table = np.loadtxt(lines, delimiter=",", comments=None, ndmin=2)
        if table.shape == (len(lines), width):
            return np.asarray(table[:, columns], dtype=np.float64)
    elif all(line.count(",") == width - 1 for line in lines):
        table = np.loadtxt(lines, delimiter=",", comments=None, ndmin=2, usecols=columns)
        if len(table) == len(lines):
            return np.asarray(table, dtype=np.float64)
    raise ValueError(f"not every line has {width} cells")


def _find_bad_cell(path: Path, lines: list[str], header: list[str], columns: list[int]) -> None:
    """Raise for the first cell that is no finite number, or the first row of another length."""
    for number, line in enumerate(lines, FIRST_ROW_LINE):
        place = f"{path}: line {number}"
        cells = line.split(",")
        if not line.strip():
            raise InputDataError(f"{place}: is empty (remove it; a missing row is a gap)")
        if len(cells) != len(header):
            raise InputDataError(
                f"{place}: {len(cells)} cells where the header names {len(header)} columns "
                "(is the line cut off, are there decimal commas or commas in a text?)"
            )
        for column in columns:
            cell = cells[column].strip()
            place = f"{path}: line {number}, column {header[column]}"
            if not cell:
                raise InputDataError(
                    f"{place}: the cell is empty (remove the row; a missing row is a gap)"
                )
            if not _is_number(cell):
                raise InputDataError(f"{place}: {cell!r} is no number")
            if not np.isfinite(float(cell)):
                raise InputDataError(
                    f"{place}: {cell!r} is not finite (remove the row; a missing row is a gap)"
                )


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell  # float() takes them, no program writes them


def _grid(path: Path, t_s: Floats) -> Grid:
    try:
        grid = find_grid(t_s)
    except GridError as exc:
        line = "" if exc.row is None else f" line {exc.row + FIRST_ROW_LINE},"
        raise InputDataError(f"{path}:{line} column {TIME}: {exc}") from exc
    if max(-t_s[0], t_s[-1]) > MAX_TIME_S:
        raise InputDataError(
            f"{path}: column {TIME}: {t_s[-1]:g} is no time in seconds (count from the start of "
            "the walk, or from 1970)"
        )
    return grid


def _split(table: Floats, channels: Sequence[Channel]) -> dict[str, Floats]:
    values: dict[str, Floats] = {}
    first = 0
    for channel in channels:
        rows = np.ascontiguousarray(table[:, first : first + len(channel.columns)])
        rows.setflags(write=False)
        values[channel.name] = rows
        first += len(channel.columns)
    return values


def _check_units(path: Path, values: Mapping[str, Floats], grid: Grid) -> None:
    accel, gyro = values.get(ACCEL.name), values.get(GYRO.name)
    complaints: list[tuple[Channel, str | None]] = [
        (channel, angle_complaint(values[channel.name]))
        for channel in (INCLINATION, INCLINATION_ROLL)
        if channel.name in values
    ]
    if accel is not None:
        complaints.append((ACCEL, accel_complaint(accel)))
    if gyro is not None:
        complaints.append((GYRO, gyro_complaint(gyro, accel, grid.index, grid.period_s)))
    for channel, complaint in complaints:
        if complaint:
            raise InputDataError(f"{path}: columns {', '.join(channel.columns)}: {complaint}")


def _items(t_s: Floats, grid: Grid, values: Mapping[str, Floats]) -> list[EstimatorInput]:
    t_ns: Ints = np.rint(t_s * NS_PER_S).astype(np.int64)
    t_ns.setflags(write=False)
    holes = (np.flatnonzero(np.diff(grid.index) > 1) + 1).tolist()
    items: list[EstimatorInput] = []
    for start, stop in zip([0, *holes], [*holes, len(t_ns)], strict=True):
        if start:
            n_missing = int(grid.index[start] - grid.index[start - 1]) - 1
            first_ns = int(t_ns[start - 1]) + round(grid.period_s * NS_PER_S)
            items.append(Gap(first_ns, n_missing, "lost"))
        items.append(
            SampleBatch(
                t_ns=t_ns[start:stop],
                period_s=grid.period_s,
                sequence=int(grid.index[start]),
                channels={name: rows[start:stop] for name, rows in values.items()},
            )
        )
    return items
