"""The whole path of a sample, from the bytes of a read to the filter's state, stage by stage."""

import statistics
import time

from codec_table import frames_of

from gaitway.alignment import Aligner
from gaitway.estimation import ErrorStateFilter, ImuNoise
from gaitway.mounting import mount, rotation_from_mounting
from gaitway.samples import ACCEL, GYRO, Chunk, DeviceBatch
from gaitway_drivers import gaitway_codecs

NOISE = ImuNoise(5e-3, 5e-4, 1e-4, 1e-5)
C_DB = rotation_from_mounting({"x": "up", "y": "right", "z": "forward"})
STAGES = ("decoded", "aligned", "mounted", "9 states", "15 states")


def path_table() -> None:
    """Print what each stage costs a frame: the median read, so that other work is left out."""
    print(
        "\nbytes to decoded to estimated (xbus, aligner, mounting, ErrorStateFilter.run), us/frame"
    )
    print("frames per read  " + "".join(f"{stage:>11}" for stage in STAGES) + "    whole path, 9")
    (codec_type,) = (each for each in gaitway_codecs() if each.name == "xbus")
    frames = frames_of(codec_type)
    for together in (1, 10, 100):
        chunks = [
            Chunk(10_000_000 * start, b"".join(frames[start : start + together]))
            for start in range(0, len(frames), together)
        ]
        took_us = [took / together for took in _stages_us(codec_type, chunks)]
        whole_us = sum(took_us[:-1])
        print(f"{together:15}  " + "".join(f"{us:11.2f}" for us in took_us) + f"{whole_us:17.2f}")


def _stages_us(codec_type, chunks):
    """Return the median cost of a read in each stage, each fed with what the one before made."""
    codec = codec_type.make(codec_type.params.model_validate({"listen_only": True}))
    codec.start(0)
    decoded_us, items = _timed(codec.feed, chunks)
    batches = [item for read in items for item in read if isinstance(item, DeviceBatch)]
    aligned_us, items = _timed(Aligner().align, batches)
    batches = [item for read in items for item in read]
    mounted_us, batches = _timed(lambda batch: mount(batch, C_DB), batches)
    filters_us = [_timed(_runner(states), batches)[0] for states in (9, 15)]
    return decoded_us, aligned_us, mounted_us, *filters_us


def _runner(states):
    kf = ErrorStateFilter(states=states)
    return lambda batch: kf.run(
        batch.channels[ACCEL.name], batch.channels[GYRO.name], batch.period_s, NOISE
    )


def _timed(stage, inputs):
    results, took_ns = [], []
    for each in inputs:
        began_ns = time.perf_counter_ns()
        results.append(stage(each))
        took_ns.append(time.perf_counter_ns() - began_ns)
    return statistics.median(took_ns) / 1e3, results
