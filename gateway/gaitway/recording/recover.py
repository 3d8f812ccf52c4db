"""Making whole files of what a power cut or a failed disk left behind."""

import contextlib
import fcntl
import os
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

from gaitway.recording.items import Unreadable
from gaitway.recording.rebuild import Rebuild
from gaitway.recording.recording_file import ACTIVE_SUFFIX, sync_directory
from gaitway.recording.retention import free_bytes
from gaitway.recording.scan import scan

BROKEN_SUFFIX: Final = ".broken"
TEMPORARY_SUFFIX: Final = ".recovering"
SUMMARY_SHARE: Final = 1.5
"""A rebuilt file is longer than the old one by its indexes; this much at most."""


@dataclass(frozen=True, slots=True)
class Recovered:
    """What became of a leftover file.

    Attributes:
        source: The leftover.
        path: What it is now; the leftover itself where nothing could be done yet.
        messages: How many messages were saved.
        lost_bytes: How much of the leftover gave nothing.
        reason: What was wrong with it; empty for a file that was merely not ended.
    """

    source: Path
    path: Path
    messages: int
    lost_bytes: int
    reason: str

    def __str__(self) -> str:
        """Return a line for the log."""
        told = f": {self.reason}" if self.reason else ""
        if self.path == self.source:
            return f"{self.source} was left behind and is not recovered yet{told}"
        return (
            f"{self.source.name} was left behind: {self.messages} messages saved in "
            f"{self.path.name}, {self.lost_bytes} bytes lost{told}"
        )


def recover(directory: Path, skip: Path | None = None) -> list[Recovered]:
    """Rewrite every leftover ``.mcap.active`` of a directory from its whole chunks.

    A leftover is removed only once its successor is on the disk. One without any message is kept
    under the name ``.broken``. A file that another process is writing is left alone.

    Args:
        directory: Where to look; need not exist.
        skip: The file being written by the caller.

    Raises:
        OSError: The directory can't be read.
    """
    if not directory.is_dir():
        return []
    leftovers = sorted(directory.glob(f"*.mcap{ACTIVE_SUFFIX}"))
    found = [_recover_one(path) for path in leftovers if path != skip]
    return [recovered for recovered in found if recovered is not None]


def _recover_one(path: Path) -> Recovered | None:
    try:
        with path.open("rb") as stream:
            if _is_being_written(stream):
                return None
            return _rewrite(path, stream)
    except OSError as exc:
        return Recovered(path, path, 0, 0, str(exc))


def _is_being_written(stream: BinaryIO) -> bool:
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False  # this file system has no locks
    return False


def _rewrite(path: Path, stream: BinaryIO) -> Recovered:
    size = os.fstat(stream.fileno()).st_size
    if free_bytes(path.parent) < SUMMARY_SHARE * size:
        return Recovered(path, path, 0, 0, "there is no room for its copy")
    final = path.with_name(path.name.removesuffix(ACTIVE_SUFFIX))
    temporary = path.with_name(final.name + TEMPORARY_SUFFIX)
    try:
        with temporary.open("wb") as out:
            messages, damages = _rebuild(stream, out)
            out.flush()
            os.fsync(out.fileno())
        lost_bytes = sum(damage.n_bytes for damage in damages)
        reason = damages[0].reason if damages else ""
        if not messages:
            broken = path.with_name(final.name + BROKEN_SUFFIX)
            path.rename(broken)
            return Recovered(path, broken, 0, lost_bytes, reason or "it holds no message")
        status = os.fstat(stream.fileno())
        os.utime(temporary, ns=(status.st_atime_ns, status.st_mtime_ns))
        temporary.rename(final)
        sync_directory(path.parent)
        path.unlink()
        return Recovered(path, final, messages, lost_bytes, reason)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def _rebuild(stream: BinaryIO, out: BinaryIO) -> tuple[int, list[Unreadable]]:
    rebuild = Rebuild(out)
    damages: list[Unreadable] = []
    for record in scan(stream):
        damage = record if isinstance(record, Unreadable) else rebuild.add(record)
        if damage is not None:
            damages.append(damage)
    rebuild.finish()
    return rebuild.messages, damages
