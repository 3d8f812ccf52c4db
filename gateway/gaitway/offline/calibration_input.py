"""Files in the place of a guided recording: what a calibration fits, from CSV or MCAP."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from gaitway.contracts import Calibration, CalibrationPart
from gaitway.errors import InputDataError
from gaitway.offline.csv_input import read_csv
from gaitway.offline.mcap_input import read_mcap
from gaitway.samples import Channel, EstimatorInput, Floats, Gap, Required, SampleBatch

REFERENCE_PREFIX = "reference_"


def reference_channel(calibration: Calibration) -> Channel | None:
    """Return the column that holds what a person would have typed, where a step asks for it.

    A calibration whose step asks for ``force_newton`` wants a column ``reference_force_newton``.
    """
    asks = next((step.asks for step in calibration.steps if step.asks), None)
    return Channel(REFERENCE_PREFIX + asks, (REFERENCE_PREFIX + asks,)) if asks else None


def parts_of_files(
    files: Sequence[Path],
    calibration: Calibration,
    C_db: Floats,
    device_id: str | None = None,
    required: Required = (),
) -> list[CalibrationPart]:
    """Return what the files hold for a calibration: one part a file, or one a reference value.

    Args:
        files: CSV files, or MCAP recordings where no reference is needed.
        calibration: What is to be fitted.
        C_db: The mounting, from IMU to device components, shape (3, 3).
        device_id: Which device of an MCAP file.
        required: Channels that must be there.

    Raises:
        InputDataError: A file can't be used.
    """
    reference = reference_channel(calibration)
    parts: list[CalibrationPart] = []
    for file in files:
        if not file.is_file():
            raise InputDataError(f"{file}: no such file")
        if file.suffix != ".mcap":
            recording = read_csv(file, [*required, *([reference] if reference else [])])
        elif reference:
            raise InputDataError(
                f"{file}: a recording does not hold {reference.name}; export a CSV file with that "
                "column beside the samples"
            )
        else:
            recording = read_mcap(file, device_id)
            recording.require(required)
        if reference is None:
            parts.append(CalibrationPart(recording.items, C_db))
        else:
            parts += _by_reference(recording.items, reference, C_db)
    return parts


def _by_reference(
    items: Sequence[EstimatorInput], reference: Channel, C_db: Floats
) -> Iterator[CalibrationPart]:
    """Yield each run of samples over which the reference does not change."""
    for item in items:
        if isinstance(item, Gap):
            continue
        values = item.channels[reference.name][:, 0]
        edges = [0, *(np.flatnonzero(np.diff(values)) + 1).tolist(), len(item)]
        for start, stop in pairwise(edges):
            part: SampleBatch = item[start:stop]
            yield CalibrationPart([part], C_db, float(values[start]))
