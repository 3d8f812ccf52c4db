"""What the operator may set about recordings."""

from pathlib import Path
from typing import Self

from pydantic import Field, model_validator

from gaitway.params import Params


class RecordingParams(Params):
    """Where recordings go, how they are cut into files, and what is kept.

    The defaults suit a 32 GB SD card that also holds the system. Of the three bounds on what is
    kept the tightest counts; the oldest finished file goes first.
    """

    directory: Path = Path("recordings")
    """Folder of the recordings; made when it is missing."""
    max_file_s: float = Field(default=3600.0, ge=1.0)
    """A new file is begun after this time."""
    max_file_mb: float = Field(default=256.0, ge=0.1)
    """A new file is begun at this size (1 MB is 10^6 bytes)."""
    max_age_days: float = Field(default=30.0, gt=0.0)
    """Older recordings are deleted."""
    max_total_gb: float = Field(default=16.0, gt=0.0)
    """All recordings together stay below this size (1 GB is 10^9 bytes)."""
    min_free_gb: float = Field(default=2.0, ge=0.0)
    """This much of the disk stays free: old recordings are deleted for it, and when none is left
    to delete, recording pauses."""

    @model_validator(mode="after")
    def _holds_two_files(self) -> Self:
        if self.max_total_gb * 1000 < 2 * self.max_file_mb:
            raise ValueError(
                f"max_total_gb = {self.max_total_gb:g} does not hold two files of "
                f"max_file_mb = {self.max_file_mb:g} (raise the first or lower the second)"
            )
        return self
