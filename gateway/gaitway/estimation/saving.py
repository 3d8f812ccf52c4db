"""Saving the state of an estimator, so that a restart of the gateway goes on where it was.

A state is everything an estimator keeps in its attributes. It is written as a pickle, which in
itself could name any code to run; read back, it may name classes that gaitway's mathematics and the
estimator's own package define, and a few containers, and nothing else. Nothing is imported or
called before that is checked.
"""

import io
import pickle
import zlib
from typing import Any, Final

_MAGIC: Final = b"gaitway-state-1 "
_PLAIN: Final = {
    "builtins": {"set", "frozenset", "slice", "complex", "bytearray", "range"},
    "collections": {"deque", "OrderedDict", "defaultdict"},
    "numpy": {"ndarray", "dtype"},
    "numpy._core.multiarray": {"_reconstruct", "scalar"},
    "numpy.core.multiarray": {"_reconstruct", "scalar"},
    "numpy._core.numeric": {"_frombuffer"},
    "numpy.core.numeric": {"_frombuffer"},
}
"""Containers that a state may hold besides classes of gaitway and of the plugin."""
_OF_GAITWAY: Final = (
    "gaitway.estimation",
    "gaitway.samples",
    "gaitway.events",
    "gaitway.contracts",
)
"""Whose classes a state may hold: none of them opens a file or a port when it is made."""


class Saveable:
    """Gives an estimator ``save`` and ``restore``: its state is all it has in its attributes.

    Attributes may hold numbers, texts, containers, arrays, and objects of gaitway's classes and of
    the plugin's own; no functions, locks or files. What ``start_trace`` returned is part of it.
    """

    def save(self) -> bytes:
        """Return everything, checksum included."""
        body = pickle.dumps(self.__dict__, protocol=5)
        name = f"{type(self).__module__}.{type(self).__qualname__}".encode()
        return _MAGIC + b"%s %08x\n" % (name, zlib.crc32(body)) + body

    def restore(self, state: bytes) -> None:
        """Take everything over.

        Raises:
            ValueError: It was saved by another class, or is damaged; nothing has changed.
        """
        head, _, body = state.partition(b"\n")
        name = f"{type(self).__module__}.{type(self).__qualname__}"
        if head != _MAGIC + b"%s %08x" % (name.encode(), zlib.crc32(body)):
            raise ValueError(f"this is no undamaged state of a {name}")
        try:
            attributes = dict(_Reader(body, type(self).__module__.partition(".")[0]).load())
        except Exception as exc:
            # A state of other code may fail in any way; it must not stop the gateway's start.
            raise ValueError(f"this state of a {name} can't be read: {exc}") from exc
        self.__dict__.clear()
        self.__dict__.update(attributes)


class _Reader(pickle.Unpickler):
    def __init__(self, body: bytes, package: str) -> None:
        super().__init__(io.BytesIO(body))
        self._places: Final = (*_OF_GAITWAY, package) if package != "gaitway" else _OF_GAITWAY

    def find_class(self, module: str, name: str) -> Any:
        plain = name in _PLAIN.get(module, ())
        if not plain and not any(f"{module}.".startswith(f"{place}.") for place in self._places):
            raise pickle.UnpicklingError(f"{module}.{name} has no place in a state")
        found = super().find_class(module, name)
        # What a module has only imported (subprocess.Popen, say) is not of its package.
        own = isinstance(found, type) and (found.__module__, found.__qualname__) == (module, name)
        if not plain and not own:
            raise pickle.UnpicklingError(f"{module}.{name} is no class of that package")
        return found
