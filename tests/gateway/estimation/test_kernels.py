"""The compiled kernels against their readable twin, and against anything that may be passed."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitway.estimation import (
    ATT,
    POS,
    VEL,
    ErrorStateFilter,
    ImuNoise,
    kernels,
    pivot_velocity,
)
from gaitway.estimation import _kernels_twin as twin
from gaitway.estimation.rotation import from_rotation_vector

compiled = pytest.importorskip("gaitway.estimation._kernels", reason="there is no C compiler")

DT_S, GRAVITY = 0.01, 9.81
DENSITIES = (5e-3, 5e-4, 1e-3, 1e-4)
STEP = (DT_S, GRAVITY, *DENSITIES)
LEVER_D = (0.1, -0.05, -0.6)


def some_filter(states, seed=1):
    """Return nominal state and covariance of a filter in the middle of some movement."""
    rng = np.random.default_rng(seed)
    nominal = rng.normal(0.0, 0.3, 16)
    nominal[6:10] = from_rotation_vector(rng.normal(0.0, 0.5, 3))
    nominal[10:] *= 0.1
    root = rng.normal(0.0, 0.05, (states, states))
    P = root @ root.T
    return nominal, np.triu(P) + np.triu(P, 1).T


def some_walk(n, seed=2, rate_radps=1.0):
    rng = np.random.default_rng(seed)
    accel_d = rng.normal((0.0, 0.0, GRAVITY), 2.0, (n, 3))
    gyro_d = rng.normal(0.0, rate_radps, (n, 3))
    return accel_d, gyro_d, np.arange(n) % 10 > 5


def copies(buffers):
    return [buffer.copy() for buffer in buffers]


def agree(one, other, tolerance=1e-10):
    for a, b in zip(one, other, strict=True):
        assert a == pytest.approx(b, rel=tolerance, abs=tolerance * (1e-6 + np.abs(b).max()))
    assert np.array_equal(one[1], one[1].T)


@pytest.mark.parametrize("states", [9, 15])
@pytest.mark.parametrize("lever_d", [(0.0, 0.0, 0.0), LEVER_D])
def test_a_walk_is_the_same_as_the_twins(states, lever_d):
    accel_d, gyro_d, still = some_walk(500)
    start = some_filter(states)
    results = []
    for module in (compiled, twin):
        buffers, out = copies(start), np.empty((500, 10))
        module.run(*buffers, accel_d, gyro_d, *STEP, still, lever_d, 0.02, out)
        assert np.array_equal(out[-1], buffers[0][:10])
        results.append([*buffers, out])
    agree(*(buffers[:2] for buffers in results))
    assert results[0][2] == pytest.approx(results[1][2], rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("states", [9, 15])
@pytest.mark.parametrize("rate_radps", [0.0, 1e-9, 1e-3, 0.9, 49.9, 50.1, 300.0])
def test_a_sample_is_the_twins_on_both_sides_of_each_branch_of_the_angle(states, rate_radps):
    """The kernel leaves its series at 0.25 rad of half the half turn: 100 rad/s over 0.01 s."""
    results = []
    for module in (compiled, twin):
        for axis in np.eye(3):
            buffers = copies(some_filter(states))
            gyro_d = buffers[0][10:13] + 2.0 * rate_radps * axis
            module.predict(*buffers, (1.0, 2.0, 8.0), gyro_d, *STEP)
            results.append(buffers)
    for one, other in zip(results[:3], results[3:], strict=True):
        agree(one, other, 1e-13)


@given(
    seed=st.integers(0, 2**32 - 1),
    states=st.sampled_from([9, 15]),
    rows=st.integers(1, 7),
    scale=st.floats(1e-3, 1e3),
)
def test_any_measurement_does_what_it_does_in_the_twin(seed, states, rows, scale):
    rng = np.random.default_rng(seed)
    z, H = scale * rng.standard_normal(rows), rng.standard_normal((rows, states))
    root = scale * rng.standard_normal((rows, rows))
    R = root @ root.T + scale**2 * np.eye(rows)
    start, results = some_filter(states, seed), []
    for module in (compiled, twin):
        buffers, standardised = copies(start), np.empty(rows)
        looked = module.innovation(*buffers, z, H, R, standardised)
        assert all(map(np.array_equal, buffers, start))
        assert module.correct(*buffers, z, H, R, standardised) == looked
        results.append([*buffers, standardised, np.array(looked)])
    for a, b in zip(*results, strict=True):
        assert a == pytest.approx(b, rel=1e-7, abs=1e-9 * max(1.0, scale))


@given(
    accel_d=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    gyro_d=st.tuples(*[st.floats(-1e2, 1e2)] * 3),
    seed=st.integers(0, 2**32 - 1),
    states=st.sampled_from([9, 15]),
)
def test_any_sample_does_what_it_does_in_the_twin(accel_d, gyro_d, seed, states):
    results = []
    for module in (compiled, twin):
        buffers = copies(some_filter(states, seed))
        module.predict(*buffers, accel_d, gyro_d, *STEP)
        results.append(buffers)
    agree(*results, 1e-11)


@pytest.mark.parametrize("states", [9, 15])
def test_how_a_walk_is_cut_changes_no_bit(states):
    accel_d, gyro_d, still = some_walk(300)
    results = []
    for size in (1, 7, 100, 300):
        buffers = some_filter(states)
        for start in range(0, 300, size):
            rows = slice(start, start + size)
            compiled.run(
                *buffers, accel_d[rows], gyro_d[rows], *STEP, still[rows], LEVER_D, 0.02, None
            )
        results.append(buffers)
    for buffers in results[1:]:
        assert all(map(np.array_equal, buffers, results[0]))


@pytest.mark.parametrize("states", [9, 15])
def test_a_run_is_its_samples_one_by_one_to_the_bit(states):
    accel_d, gyro_d, _ = some_walk(300)
    together, one_by_one = ErrorStateFilter(states=states), ErrorStateFilter(states=states)
    for kf in (together, one_by_one):
        kf.nominal[:], kf.covariance[:] = some_filter(states)
    together.run(accel_d, gyro_d, DT_S, ImuNoise(*DENSITIES))
    for force_d, rate_d in zip(accel_d.tolist(), gyro_d.tolist(), strict=True):
        one_by_one.predict(force_d, rate_d, DT_S, ImuNoise(*DENSITIES))
    assert np.array_equal(together.nominal, one_by_one.nominal)
    assert np.array_equal(together.covariance, one_by_one.covariance)


@pytest.mark.parametrize("states", [9, 15])
@pytest.mark.parametrize("module", [compiled, twin])
@pytest.mark.parametrize("lever_d", [(0.0, 0.0, 0.0), LEVER_D])
def test_standing_still_in_a_run_is_the_measurement_of_that_name(
    states, module, lever_d, monkeypatch
):
    for name in ("predict", "run", "correct"):
        monkeypatch.setattr(kernels, name, getattr(module, name))
    accel_d, gyro_d, still = some_walk(50)
    together, one_by_one = ErrorStateFilter(states=states), ErrorStateFilter(states=states)
    for kf in (together, one_by_one):
        kf.nominal[:], kf.covariance[:] = some_filter(states)
    together.run(
        accel_d,
        gyro_d,
        DT_S,
        ImuNoise(*DENSITIES),
        still=still,
        imu_to_pivot_d=lever_d,
        sigma_mps=0.03,
    )
    for row in range(50):
        one_by_one.predict(accel_d[row], gyro_d[row], DT_S, ImuNoise(*DENSITIES))
        if still[row]:
            one_by_one.correct(pivot_velocity(one_by_one, gyro_d[row], lever_d, 0.03))
    assert together.nominal == pytest.approx(one_by_one.nominal, rel=1e-11, abs=1e-12)
    assert together.covariance == pytest.approx(one_by_one.covariance, rel=1e-9, abs=1e-13)


@pytest.mark.parametrize("states", [9, 15])
def test_covariance_stays_symmetric_and_positive_over_a_hundred_thousand_samples(states):
    accel_d, gyro_d, still = some_walk(1000, rate_radps=0.5)
    kf = ErrorStateFilter(states=states)
    for block, variance in ((VEL, 1e-4), (ATT, 0.01)):
        kf.set_block(block, variance)
    for _ in range(100):
        kf.run(accel_d, gyro_d, DT_S, ImuNoise(*DENSITIES), still=still, sigma_mps=1e-3)
        kf.pos_n[:] = 0.0
        kf.set_block(POS, 0.0)
    P = kf.covariance
    assert np.array_equal(P, P.T)
    scale = np.sqrt(P.diagonal() + 1e-30)
    assert np.linalg.eigvalsh(P / np.outer(scale, scale)).min() > -1e-9
    assert np.hypot.reduce(kf.q_nd) == pytest.approx(1.0, abs=1e-15)


def test_arrays_may_be_strided_reversed_or_read_only():
    accel_d, gyro_d, still = some_walk(40)
    one, other = some_filter(15), some_filter(15)
    compiled.run(*one, accel_d[::2], gyro_d[::-2], *STEP, still[::2], LEVER_D, 0.02, None)
    for array in (accel_d, gyro_d, still):
        array.setflags(write=False)
    rows = [np.ascontiguousarray(a) for a in (accel_d[::2], gyro_d[::-2], still[::2])]
    wide = np.zeros((15, 30))[:, ::2]
    wide[:] = other[1]
    out = np.zeros((10, 20)).T
    compiled.run(other[0], wide, *rows[:2], *STEP, rows[2], LEVER_D, 0.02, out)
    assert np.array_equal(one[0], other[0])
    assert np.array_equal(one[1], wide)
    assert np.array_equal(out[-1], one[0][:10])


def test_no_samples_are_no_change():
    before, buffers = some_filter(15), some_filter(15)
    none = np.empty((0, 3))
    compiled.run(*buffers, none, none, *STEP, np.empty(0, bool), LEVER_D, 0.02, np.empty((0, 10)))
    assert all(map(np.array_equal, buffers, before))


NOMINAL, P = some_filter(15)
F3, STILL = np.zeros((4, 3)), np.zeros(4, bool)
FROZEN = np.zeros(16)
FROZEN.setflags(write=False)


def run(nominal=NOMINAL, P=P, accel=F3, gyro=F3, dt=DT_S, still=STILL, lever=LEVER_D, out=None):
    compiled.run(nominal, P, accel, gyro, dt, GRAVITY, *DENSITIES, still, lever, 0.02, out)


def correct(z=(0.0,) * 3, H=np.zeros((3, 15)), R=np.eye(3), standardised=None):  # noqa: B008
    z = np.array(z) if isinstance(z, tuple) else z
    whitened = np.empty(3) if standardised is None else standardised
    return compiled.correct(NOMINAL, P, z, H, R, whitened)


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (partial(run, nominal=np.zeros(15)), ValueError, "nominal.*15 by 1"),
        (partial(run, nominal=[0.0] * 16), TypeError, "nominal.*writable.*list"),
        (partial(run, nominal=FROZEN), TypeError, "nominal.*writable"),
        (partial(run, nominal=np.zeros(16, np.float32)), TypeError, "nominal.*float64.*'f'"),
        (partial(run, P=np.zeros((12, 12))), ValueError, "9 by 9 or 15 by 15, not 12 by 12"),
        (partial(run, P=np.zeros((15, 9))), ValueError, "15 by 9"),
        (partial(run, P=np.zeros(225)), ValueError, "covariance.*2 dimensions"),
        (partial(run, accel=np.zeros((4, 4))), ValueError, "accel_d.*4 by 4"),
        (partial(run, accel=np.zeros(3)), ValueError, "accel_d.*2 dimensions"),
        (partial(run, accel=np.zeros((4, 3), ">f8")), TypeError, "accel_d.*float64"),
        (partial(run, gyro=np.zeros((3, 3))), ValueError, "gyro_d.*3 by 3"),
        (partial(run, gyro=np.zeros((4, 3), int)), TypeError, "gyro_d.*float64.*'l'"),
        (partial(run, still=np.zeros(4)), TypeError, "still.*bool"),
        (partial(run, still=np.zeros(3, bool)), ValueError, "still"),
        (partial(run, out=np.zeros((4, 9))), ValueError, "out.*4 by 9"),
        (partial(run, out=np.broadcast_to(0.0, (4, 10))), TypeError, "out.*writable"),
        (partial(run, lever=(1.0, 2.0)), ValueError, "imu_to_pivot_d.*3 numbers, got 2"),
        (partial(run, lever=("a", "b", "c")), TypeError, "real number"),
        (partial(run, lever=3.0), TypeError, "iterable of three"),
        (partial(run, dt="1"), TypeError, "real number"),
        (partial(correct, z=np.zeros(0)), ValueError, "1 to 15 numbers, not 0"),
        (partial(correct, z=np.zeros(16)), ValueError, "1 to 15 numbers, not 16"),
        (partial(correct, z=np.zeros((3, 1))), ValueError, "z: needs 1 dimension"),
        (partial(correct, H=np.zeros((3, 9))), ValueError, "H.*3 by 9"),
        (partial(correct, R=np.eye(2)), ValueError, "R.*2 by 2"),
        (partial(correct, standardised=np.zeros(2)), ValueError, "standardised.*2 by 1"),
        (partial(correct, R=-np.eye(3)), ValueError, "not positive definite"),
        (partial(compiled.run, NOMINAL), TypeError, "run: takes 14 arguments, got 1"),
        (partial(compiled.predict), TypeError, "predict: takes 10 arguments, got 0"),
        (partial(compiled.correct, NOMINAL, P), TypeError, "correct: takes 6 arguments, got 2"),
    ],
)
def test_what_does_not_fit_is_refused_in_clear_words_and_changes_nothing(call, error, text):
    nominal, covariance = NOMINAL.copy(), P.copy()
    with pytest.raises(error, match=text):
        call()
    assert np.array_equal(NOMINAL, nominal)
    assert np.array_equal(P, covariance)


def test_a_list_that_shortens_itself_while_it_is_read_harms_nobody():
    class Number:
        def __float__(self):
            del vector[1:]
            return 0.0

    vector = [Number(), 1.0, 2.0]
    with pytest.raises(IndexError):
        compiled.predict(*some_filter(9), vector, (0.0, 0.0, 0.0), *STEP)


@pytest.mark.parametrize("module", [compiled, twin])
def test_what_is_not_a_number_goes_on_as_such(module):
    nominal, P = some_filter(15)
    nans, zeros = np.full((5, 3), np.nan), np.zeros((5, 3))
    module.run(nominal, P, nans, zeros, *STEP, np.ones(5, bool), LEVER_D, 0.02, None)
    assert np.isnan(nominal[3:6]).all()
    nis = module.correct(nominal, P, np.zeros(3), np.eye(3, 15), np.eye(3), np.empty(3))
    assert np.isnan(nis)
