"""Everything gaitway raises on purpose.

::

    GaitwayError
     +-- ConfigError(ValueError)            the operator's file is wrong; exit status 78
     +-- InputDataError(ValueError)         a file given to an offline command is wrong; status 65
     +-- CalibrationError(ValueError)       a calibration is refused; status 65
     +-- PluginError                        one plugin is wrong; it is skipped, the rest runs
     |    +-- PluginLoadError(ImportError)
     |    +-- PluginContractError(TypeError)
     +-- TransportError(OSError)            the link; always retried with backoff
     |    +-- TransportOpenError
     |    +-- TransportLostError(ConnectionError)
     +-- RecordingError(OSError)            the disk; recording pauses, publishing goes on
     +-- PublishError(ConnectionError)      the bus

What a *device* sends never raises: unusable bytes are a ``Fault`` and missing samples a ``Gap``
(``gaitway.samples``). Each message says what, where and what to do about it.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager


class GaitwayError(Exception):
    """Base of everything gaitway raises on purpose."""


class ConfigError(GaitwayError, ValueError):
    """The operator's configuration is wrong. The text names file, key and remedy, a line each."""


class InputDataError(GaitwayError, ValueError):
    """A file given to an offline command can't be used. The text names the line and the remedy."""


class CalibrationError(GaitwayError, ValueError):
    """What was recorded for a calibration does not do. The text says why and what to do better."""


class PluginError(GaitwayError):
    """One plugin can't be used; the others run."""

    def __init__(self, plugin: str, reason: str) -> None:
        super().__init__(f"plugin {plugin!r}: {reason}")
        self.plugin = plugin
        self.reason = reason


class PluginLoadError(PluginError, ImportError):
    """Importing the plugin raised."""


class PluginContractError(PluginError, TypeError):
    """The plugin loaded but what it offers is not what the hooks promise."""


class TransportError(GaitwayError, OSError):
    """The link to a device failed. Retried for ever, with backoff."""


class TransportOpenError(TransportError):
    """The link could not be opened."""


class TransportLostError(TransportError, ConnectionError):
    """The link was open and is gone."""


class RecordingError(GaitwayError, OSError):
    """The recording can't be written."""


class PublishError(GaitwayError, ConnectionError):
    """The bus can't be opened or used."""


@contextmanager
def map_exceptions(mapping: Mapping[type[Exception], type[GaitwayError]]) -> Iterator[None]:
    """Raise a foreign exception as ours, keeping its text and cause.

    Args:
        mapping: Foreign exception type to the type raised in its place; the first match wins.
    """
    try:
        yield
    except Exception as exc:
        for foreign, ours in mapping.items():
            if isinstance(exc, foreign) and not isinstance(exc, GaitwayError):
                raise ours(str(exc) or type(exc).__name__) from exc
        raise
