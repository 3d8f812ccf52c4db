"""When the walker stands: by its wheels, its rate, and the size and the change of its force.

The paper's Eq. 10 looks at the rate and at differences of the specific force; in the middle of a
smooth lift both are small. Here the wheels must stand as well, the force must be that of gravity,
and it must not have changed from a block before to a block after. Even gliding is still left: the
navigator refuses that.
"""

from typing import Final

import numpy as np

from gaitway.api import Floats
from gaitway.estimation import STANDARD_GRAVITY_MPS2
from gaitway_plugins.walker.blocks import Block
from gaitway_plugins.walker.params import WalkerParams


class Stillness:
    """Judges a block when the next one has come.

    Args:
        params: Of the walker.
    """

    def __init__(self, params: WalkerParams) -> None:
        self._params = params
        self._wheel_max_m: Final = rolling_min_m(params)
        self._calm: list[bool] = []
        self._force: list[Floats] = []

    def push(self, block: Block, gyro_bias_d: Floats) -> bool:
        """Take the next block; return whether the one before was still."""
        self._calm.append(self._is_calm(block, gyro_bias_d))
        self._force.append(block.accel_d.mean(axis=0))
        del self._calm[:-3], self._force[:-3]
        return self._verdict(self._force)

    def last(self) -> bool:
        """Return whether the last block was still, at the end of the stream."""
        return self._verdict(self._force[-2:]) if self._calm else False

    def _verdict(self, forces: list[Floats]) -> bool:
        spread = np.ptp(np.array(forces), axis=0)
        return all(self._calm[-len(forces) :]) and bool(
            spread.dot(spread) <= self._params.still_step_max_mps2**2
        )

    def _is_calm(self, block: Block, gyro_bias_d: Floats) -> bool:
        p = self._params
        force = block.accel_d.mean(axis=0)
        rate = block.gyro_d.mean(axis=0) - gyro_bias_d
        shake = block.accel_d.var(axis=0).sum()
        return bool(
            np.abs(block.wheels_m.sum(axis=0)).max() <= self._wheel_max_m
            and abs(np.sqrt(force.dot(force)) - STANDARD_GRAVITY_MPS2) <= p.still_norm_max_mps2
            and rate.dot(rate) <= p.still_rate_max_radps**2
            and shake <= p.still_shake_max_mps2**2
        )


def rolling_min_m(params: WalkerParams) -> float:
    """Return how far a wheel turns in a block that does not roll: jitter of an edge or two."""
    return max(1.5 * params.tick_m, 0.01 * params.block_s)
