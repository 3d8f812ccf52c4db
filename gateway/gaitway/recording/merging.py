"""Small batches that follow each other become one message: a tenth of the work and of the size."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from gaitway.recording.lane import LaneItem
from gaitway.samples import SampleBatch

MAX_SAMPLES: Final = 200
"""No message grows longer than this, whatever waited."""


def merge_samples(items: Sequence[LaneItem]) -> list[LaneItem]:
    """Return the items with each unbroken run of batches of a device as one batch.

    It stands where the last of the run stood; everything else keeps its place.
    """
    runs: dict[str, list[int]] = {}
    ended: list[list[int]] = []
    batches = {
        index: item.body for index, item in enumerate(items) if isinstance(item.body, SampleBatch)
    }
    for index, batch in batches.items():
        run = runs.setdefault(items[index].device, [])
        if run and not _continues(batches[run[0]], batches[run[-1]], batch):
            ended.append(run)
            run = runs[items[index].device] = []
        run.append(index)
    merged: list[LaneItem | None] = list(items)
    for run in ended + list(runs.values()):
        for index in run:
            merged[index] = None
        merged[run[-1]] = LaneItem(items[run[0]].device, _joined([batches[i] for i in run]))
    return [item for item in merged if item is not None]


def _continues(first: SampleBatch, last: SampleBatch, batch: SampleBatch) -> bool:
    return (
        batch.sequence == last.sequence + len(last)
        and batch.period_s == last.period_s
        and _widths(batch) == _widths(last)
        and batch.sequence + len(batch) - first.sequence <= MAX_SAMPLES
    )


def _widths(batch: SampleBatch) -> dict[str, int]:
    return {name: values.shape[1] for name, values in batch.channels.items()}


def _joined(run: Sequence[SampleBatch]) -> SampleBatch:
    if len(run) == 1:
        return run[0]
    first = run[0]
    return SampleBatch(
        t_ns=np.concatenate([batch.t_ns for batch in run]),
        period_s=first.period_s,
        sequence=first.sequence,
        channels={
            name: np.concatenate([batch.channels[name] for batch in run]) for name in first.channels
        },
    )
