"""Which recordings are kept: never more, and never older, than the operator allows."""

import logging
import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from gaitway.recording.params import RecordingParams
from gaitway.timebase import NS_PER_S

logger = logging.getLogger(__name__)

FINISHED: Final = re.compile(r"(\d{8}T\d{6}Z)-[0-9a-z]{1,32}-(\d{1,9})\.mcap")
"""Names of our own finished recordings; whatever is called otherwise is not ours to delete."""
BYTES_PER_GB: Final = 1_000_000_000
BYTES_PER_MB: Final = 1_000_000
SECONDS_PER_DAY: Final = 86_400
CLOCK_SET_NS: Final = 1_577_836_800 * NS_PER_S
"""1 January 2020: a file stamped earlier was written while the clock was not set."""


@dataclass(frozen=True, slots=True)
class Recording:
    """A finished recording on the disk.

    Attributes:
        path: Where it is.
        order: Sorts recordings from old to new.
        modified_ns: When it was finished, nanoseconds since 1970.
        size_bytes: How long it is.
    """

    path: Path
    order: tuple[int, str, int]
    modified_ns: int
    size_bytes: int


def free_bytes(directory: Path) -> int:
    """Return how much of the disk an unprivileged process may still fill."""
    return shutil.disk_usage(directory).free


def recordings(directory: Path) -> list[Recording]:
    """Return our finished recordings in a directory, oldest first."""
    found = []
    for path in directory.iterdir():
        name = FINISHED.fullmatch(path.name)
        if name is None or path.is_symlink() or not path.is_file():
            continue
        status = path.stat()
        order = (status.st_mtime_ns, name[1], int(name[2]))
        found.append(Recording(path, order, status.st_mtime_ns, status.st_size))
    return sorted(found, key=lambda recording: recording.order)


def make_room(params: RecordingParams, wall_ns: int, *, margin_bytes: int = 0) -> list[Path]:
    """Delete what must go, oldest first; return what was deleted.

    Age is that of the file's end, and of no account while a clock was not set. The size of all
    recordings is held one file below its bound: the one about to be written.

    Args:
        params: What to keep.
        wall_ns: The present, nanoseconds since 1970.
        margin_bytes: How much more than the reserve should be free.

    Raises:
        OSError: The directory can't be read.
    """
    kept = recordings(params.directory)
    total_bytes = sum(recording.size_bytes for recording in kept)
    max_total_bytes = params.max_total_gb * BYTES_PER_GB - params.max_file_mb * BYTES_PER_MB
    oldest_ns = wall_ns - params.max_age_days * SECONDS_PER_DAY * NS_PER_S
    deleted = []
    for recording in kept:
        too_old = CLOCK_SET_NS < recording.modified_ns < oldest_ns
        too_much = total_bytes > max_total_bytes or lacks_reserve(params, margin_bytes=margin_bytes)
        if not (too_old or too_much):
            # A file of unset clock may stand before one that is too old.
            if recording.modified_ns > CLOCK_SET_NS:
                break
            continue
        if _delete(recording.path):
            deleted.append(recording.path)
            total_bytes -= recording.size_bytes
    return deleted


def lacks_reserve(params: RecordingParams, *, margin_bytes: int = 0) -> bool:
    """Return whether less of the disk is free than the reserve and a margin."""
    return free_bytes(params.directory) < params.min_free_gb * BYTES_PER_GB + margin_bytes


def _delete(path: Path) -> bool:
    try:
        path.unlink()
    except OSError as exc:
        logger.warning("%s should go to make room and can't be deleted: %s", path, exc)
        return False
    logger.info("deleted %s to make room", path)
    return True
