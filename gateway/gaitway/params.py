"""The base of every parameter model: of devices, codecs, transports and the gateway itself."""

from pydantic import BaseModel, ConfigDict


class Params(BaseModel):
    """Parameters a person may set: frozen, in SI units, an unknown key is an error.

    Document each field with the docstring under it; the text goes into ``gaitway plugins`` and the
    JSON Schema that editors complete from.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", use_attribute_docstrings=True, allow_inf_nan=False
    )
