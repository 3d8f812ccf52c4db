"""What people do with a cane besides walking gives no stride."""

import pytest

from gaitway.api import WalkPlan
from gaitway.simulation import non_walking


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("kind", ["still", "lying", "leaning", "waving", "turning-on-the-spot"])
def test_no_stride_is_invented_and_no_doubt_raised(batch_of, run, kind, seed):
    result = run(batch_of(non_walking(WalkPlan(1.0, seed=seed), kind, duration_s=12.0)))
    assert result.strides == []
    assert result.anomalies == []
    assert result.unmeasured_s == 0.0


@pytest.mark.parametrize("seed", [0, 1])
def test_a_cane_carried_upright_may_be_walking_but_gives_no_stride(batch_of, run, seed):
    result = run(batch_of(non_walking(WalkPlan(1.0, seed=seed), "carried", duration_s=12.0)))
    assert result.strides == []
    assert result.anomalies == ["no-contact"]
    assert result.unmeasured_s > 5.0


@pytest.mark.parametrize("height_m", [0.2, 0.75])
def test_swaying_on_a_cane_whose_imu_sits_elsewhere_is_no_stride(batch_of, run, height_m):
    for seed in (1, 2, 3, 5):
        swaying = non_walking(
            WalkPlan(1.0, seed=seed),
            "leaning",
            duration_s=12.0,
            device_to_imu_d=(0.02, 0.0, height_m),
        )
        assert run(batch_of(swaying)).strides == []


def test_the_published_method_invents_nothing_either(batch_of, run):
    for kind in ("still", "lying", "leaning", "waving"):
        result = run(batch_of(non_walking(WalkPlan(1.0), kind)), method="published")
        assert result.strides == []
