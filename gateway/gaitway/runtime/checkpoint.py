"""Where a device's estimator stands, on file, so that the gateway goes on there after a restart.

The file is replaced by a rename, *before* the events that it knows of are published. So a kill at
any moment can cost the news of an event, never repeat one, and the distance told next is never less
than the one told last. It is not synced: a state names the boot of the host whose monotonic clock
its times are of, and is worth nothing after the next one.
"""

import json
import logging
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from gaitway import __version__
from gaitway.config.load import LoadedConfig, ResolvedDevice
from gaitway.recording.items import Resumed
from gaitway.timebase import NS_PER_S

logger = logging.getLogger(__name__)

EVERY_S: Final = 1.0
"""How often a state is written while samples flow and nothing happens."""
CHANGEABLE: Final = frozenset({"params", "mounting"})
"""What an operator changes: the state can't go on then, but it can be ended."""
BOOT_ID: Final = Path("/proc/sys/kernel/random/boot_id")
BOOT_ID_VARIABLE: Final = "GAITWAY_BOOT_ID"
"""Set by the systemd unit, which hides that file."""


class Checkpoint:
    """The state file of one device.

    Args:
        device: Its id.
        file: Where.
        identity: What must be the same for a state to be taken: names to JSON values.
        within_s: How old a state may be.
    """

    def __init__(
        self, device: str, file: Path, identity: Mapping[str, Any], within_s: float
    ) -> None:
        self._device, self._file, self._within_s = device, file, within_s
        self._identity: Mapping[str, Any] = json.loads(json.dumps(identity))

    def load(self, now_ns: int) -> Resumed | None:
        """Return the state to go on from, or to end where it can't; None where there is none."""
        try:
            state = self._read(self._file.read_bytes(), now_ns)
        except FileNotFoundError:
            return None
        except (OSError, ValueError, LookupError, TypeError, AttributeError) as exc:
            why = str(exc) if isinstance(exc, OSError | _ForeignError) else f"damaged: {exc!r}"
            logger.info("%s: begins anew, its last state is not taken: %s", self._device, why)
            return None
        if state.ended:
            logger.info("%s: begins anew, its last state is ended: %s", self._device, state.ended)
        else:
            age_s = (now_ns - state.saved_t_ns) / NS_PER_S
            logger.info("%s: goes on from %.1f s ago", self._device, age_s)
        return state

    def _read(self, content: bytes, now_ns: int) -> Resumed:
        head, _, estimator = content.partition(b"\n")
        fields = json.loads(head)
        if fields["estimator_bytes"] != len(estimator):
            raise ValueError("cut off")
        given, saved_t_ns = fields["identity"], int(fields["saved_t_ns"])
        different = [key for key, value in self._identity.items() if given.get(key) != value]
        age_s = (now_ns - saved_t_ns) / NS_PER_S
        if foreign := [key for key in different if key not in CHANGEABLE]:
            raise _ForeignError(f"saved with another {', '.join(foreign)}")
        if age_s < 0:
            raise ValueError("saved in the future")
        ended = ""
        if different:
            ended = f"saved with another {', '.join(different)}"
        elif age_s > self._within_s:
            ended = f"it is {age_s:.0f} s old (resume.within_s = {self._within_s:g})"
        return Resumed(now_ns, saved_t_ns, dict(fields["aligner"]), estimator, ended)

    def write(self, t_ns: int, aligner: Mapping[str, Any], estimator: bytes) -> None:
        """Replace the file.

        Args:
            t_ns: Now, host monotonic.
            aligner: State of the aligner.
            estimator: State of the estimator, as of the same sample.

        Raises:
            OSError: It can't be written.
        """
        head = {
            "identity": self._identity,
            "saved_t_ns": t_ns,
            "aligner": aligner,
            "estimator_bytes": len(estimator),
        }
        beside = self._file.with_suffix(".new")
        try:
            beside.write_bytes(json.dumps(head).encode() + b"\n" + estimator)
        except FileNotFoundError:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            beside.write_bytes(json.dumps(head).encode() + b"\n" + estimator)
        beside.replace(self._file)

    def clear(self) -> None:
        """Forget the state: what was published since would be told again."""
        try:
            self._file.unlink(missing_ok=True)
        except OSError as exc:
            logger.warning("%s: a state that no longer holds stays: %s", self._device, exc)


class _ForeignError(ValueError):
    """The state is sound and of another device type, version or boot."""


def checkpoint_for(device: ResolvedDevice, loaded: LoadedConfig) -> Checkpoint | None:
    """Return the state file of a device; None where it always begins anew."""
    resume = loaded.gateway.resume
    boot = _boot_id()
    if resume.within_s <= 0 or boot is None:
        return None
    identity = {
        "gaitway": __version__,
        "plugin": loaded.registry.device_origins.get(device.device_type.name),
        "type": device.device_type.name,
        "params": device.params.model_dump(mode="json"),
        "mounting": dict(device.mounting),
        "boot": boot,
    }
    name = device.config.id
    return Checkpoint(name, resume.directory / f"{name}.state", identity, resume.within_s)


def _boot_id() -> str | None:
    """Return what tells this boot of the host from every other, None where nothing does."""
    given = os.environ.get(BOOT_ID_VARIABLE)
    if given:
        return given
    try:
        return BOOT_ID.read_text(encoding="ascii").strip().replace("-", "")
    except OSError as exc:
        logger.warning("every device begins anew after a restart: %s", exc)
        return None
