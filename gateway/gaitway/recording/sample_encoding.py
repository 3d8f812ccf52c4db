"""Samples as JSON and back, bit for bit.

JSON has no NaN and no infinity, and a float32 written as a double is twice as long as it need be.
So a channel whose values all are float32 is written with as many digits as a float32 needs and
named under ``float32``; a reader rounds it to float32 after parsing. What is not finite stands as
0 in its column and is listed under ``not_finite``.
"""

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any, Final

import numpy as np
import orjson

from gaitway.samples import CHANNELS, Floats, SampleBatch

COLUMNS: Final[Mapping[str, tuple[str, ...]]] = {
    channel.name: channel.columns for channel in CHANNELS
}
CHANNEL_OF_COLUMN: Final[Mapping[str, tuple[str, int]]] = {
    column: (channel.name, index)
    for channel in CHANNELS
    for index, column in enumerate(channel.columns)
}
NOT_COLUMNS: Final = frozenset({"t_ns", "period_s", "sequence", "float32", "not_finite"})


def encode_samples(batch: SampleBatch) -> bytes:
    """Return a batch as JSON: a list for each column, named with its unit.

    The columns of a channel that the core has no name for are called ``{channel}.{index}``.
    """
    fields: dict[str, Any] = {
        "t_ns": batch.t_ns.tolist(),
        "period_s": float(batch.period_s),
        "sequence": int(batch.sequence),
        "float32": [],
    }
    not_finite: list[dict[str, Any]] = []
    for name, values in batch.channels.items():
        names = COLUMNS.get(name) or [f"{name}.{index}" for index in range(values.shape[1])]
        finite = values
        if not np.isfinite(values).all():
            not_finite += _not_finite(names, values)
            finite = np.where(np.isfinite(values), values, 0.0)
        fields.update(zip(names, _columns(name, finite, fields["float32"]), strict=True))
    if not_finite:
        fields["not_finite"] = not_finite
    return orjson.dumps(fields, option=orjson.OPT_SERIALIZE_NUMPY)


def decode_samples(data: bytes) -> SampleBatch:
    """Return the batch that ``encode_samples`` was given.

    Raises:
        ValueError: The JSON is none, or columns of one channel differ in length.
        LookupError: A field or column is missing.
        TypeError: A field is of another type.
    """
    return _batch(orjson.loads(data))


def decode_joined(payloads: Sequence[bytes]) -> list[SampleBatch]:
    """Return what ``decode_samples`` gives for each, those in a row without a hole as one batch.

    Raises:
        ValueError, LookupError, TypeError: As ``decode_samples``, for any of them.
    """
    batches: list[SampleBatch] = []
    run: list[dict[str, Any]] = []
    for fields in map(orjson.loads, payloads):
        if run and not _continues(run[-1], fields):
            batches.append(_batch(_joined(run)))
            run = []
        run.append(fields)
    return [*batches, _batch(_joined(run))] if run else batches


def _continues(before: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
    """Tell whether two messages can be one: the same columns, the next sample, nothing odd."""
    return (
        before.keys() == after.keys()
        and "not_finite" not in after
        and after["sequence"] == before["sequence"] + len(before["t_ns"])
        and after["period_s"] == before["period_s"]
        and after["float32"] == before["float32"]
    )


def _joined(run: Sequence[dict[str, Any]]) -> dict[str, Any]:
    first = run[0]
    if len(run) == 1:
        return first
    lengths = [len(part["t_ns"]) for part in run]
    whole: dict[str, Any] = {}
    for name in first:
        if name == "t_ns" or name not in NOT_COLUMNS:
            parts = [part[name] for part in run]
            if list(map(len, parts)) != lengths:
                raise ValueError(f"column {name} and t_ns differ in length")
            whole[name] = list(chain.from_iterable(parts))
    return first | whole


def _batch(fields: Mapping[str, Any]) -> SampleBatch:
    columns: dict[str, dict[int, list[float]]] = {}
    for column, values in fields.items():
        if column not in NOT_COLUMNS:
            name, index = _channel_of(column)
            columns.setdefault(name, {})[index] = values
    for spot in fields.get("not_finite", ()):
        name, index = _channel_of(spot["column"])
        columns[name][index][spot["row"]] = float(spot["value"])
    t_ns = np.array(fields["t_ns"], dtype=np.int64)
    t_ns.setflags(write=False)
    channels = {
        name: _rows(by_index, len(t_ns), np.float32 if name in fields["float32"] else np.float64)
        for name, by_index in columns.items()
    }
    return SampleBatch(t_ns, fields["period_s"], fields["sequence"], channels)


def _columns(name: str, values: Floats, short: list[str]) -> list[Any]:
    """Return the columns ready for JSON; add the name to ``short`` when float32 holds them all."""
    with np.errstate(over="ignore"):
        rounded = values.astype(np.float32)
    if not (rounded == values).all():
        return list(values.T.tolist())
    short.append(name)
    return list(np.ascontiguousarray(rounded.T))


def _not_finite(names: list[str] | tuple[str, ...], values: Floats) -> list[dict[str, Any]]:
    return [
        {"column": names[index], "row": row, "value": str(values[row, index])}
        for row, index in np.argwhere(~np.isfinite(values)).tolist()
    ]


def _channel_of(column: str) -> tuple[str, int]:
    known = CHANNEL_OF_COLUMN.get(column)
    if known is not None:
        return known
    name, _, index = column.rpartition(".")
    return name, int(index)


def _rows(
    by_index: Mapping[int, list[float]], n: int, dtype: type[np.float32 | np.float64]
) -> Floats:
    columns = np.array([by_index[index] for index in range(len(by_index))], dtype=dtype)
    if columns.shape != (len(by_index), n):
        raise ValueError(f"columns of shape {columns.shape} where t_ns has {n}")
    rows = columns.T.astype(np.float64, order="C")
    rows.setflags(write=False)
    return rows
