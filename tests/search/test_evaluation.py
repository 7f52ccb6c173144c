from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slcs2_jax.config import InputError
from slcs2_jax.search import Trial, counted, deployment_key, fresh_deployment_key, mean_of
from slcs2_jax.search.evaluation import together
from slcs2_jax.search.keys import seed_sequence


@pytest.mark.parametrize(
    ("fitnesses", "least", "redeployments", "expected"),
    [
        ([], 1, 5, None),
        ([-0.1], 1, 5, 1),  # below zero, one deployment decides
        ([0.0], 1, 5, 1),  # the mean must be above zero
        ([0.1], 1, 5, None),
        ([0.1], 1, 0, 1),  # no re-deployment allowed
        ([0.1, -0.3], 1, 5, 2),  # the mean fell below zero
        ([0.3, -0.1], 1, 5, None),  # the mean is still above zero
        ([0.3, -0.1, -0.3], 1, 5, 3),
        ([0.5] * 5, 1, 5, None),
        ([0.5] * 6, 1, 5, 6),  # the first and kappa = 5 re-deployments
        ([0.5] * 9, 1, 5, 6),  # what was computed beyond that does not count
        ([-0.1, 0.9, 0.9], 1, 5, 1),
        ([-0.1], 3, 5, None),
        ([-0.1, 0.0, 0.0], 3, 5, 3),
        ([-0.1, 0.2, 0.2], 3, 5, None),  # after the minimum the rule goes on
        ([0.1] * 8, 8, 5, 8),  # the minimum may exceed kappa
    ],
)
def test_how_many_deployments_count(fitnesses, least, redeployments, expected):
    assert counted(fitnesses, min_deployments=least, max_redeployments=redeployments) == expected


FITNESSES = st.lists(st.floats(-1, 1), min_size=12, max_size=12)


@settings(deadline=None, max_examples=60)
@given(FITNESSES, st.integers(1, 8), st.integers(0, 6), st.integers(0, 4), st.randoms(use_true_random=False))
def test_speculation_and_order_change_nothing(make, fitnesses, least, redeployments, ahead, random):
    deployments = [make.deployment(fitness, (index, 2)) for index, fitness in enumerate(fitnesses)]
    made = 0  # the rule as model 7 words it
    total = 0.0
    while made == 0 or made < least or (total / made > 0 and made - 1 < redeployments):
        total += fitnesses[made]
        made += 1

    trial = Trial(min_deployments=least, max_redeployments=redeployments)
    handed_in = 0
    while not trial.complete:
        wanted = trial.wanted(ahead)
        assert wanted
        assert max(wanted) < trial.limit
        random.shuffle(wanted)
        for index in wanted:
            trial.add(index, deployments[index])
            handed_in += 1
    assert trial.wanted(ahead) == []
    assert handed_in == made if ahead == 0 else handed_in <= made + ahead
    assert trial.result().fitnesses == tuple(fitnesses[:made])
    assert trial.result().contribution_sum[0] == sum(range(made))


def test_wanted_names_the_certain_ones_then_those_ahead(make):
    trial = Trial(min_deployments=2, max_redeployments=3)
    assert trial.wanted() == [0, 1]
    assert trial.wanted(ahead=9) == [0, 1, 2, 3]
    trial.add(1, make.deployment(0.5))
    trial.add(2, make.deployment(0.5))
    assert trial.wanted() == [0]
    assert not trial.complete
    trial.add(0, make.deployment(0.5))
    assert trial.wanted() == [3]
    with pytest.raises(InputError, match=r"deployments \[3\] are still wanted"):
        trial.result()


def test_means_are_over_the_counted_deployments_only(make):
    trial = Trial(max_redeployments=1)
    ramp = np.arange(8.0).reshape(2, 4)
    trial.add(0, make.deployment(0.4, (1, 2), strength=ramp, error=ramp, quality=-ramp, usage=ramp * 0))
    trial.add(1, make.deployment(0.1, (2, 2), strength=3 * ramp, error=ramp + 1, quality=ramp, usage=(ramp == 5)))
    mean = trial.result()
    assert mean.fitness == pytest.approx(0.25)
    assert mean.deployments == 2
    np.testing.assert_array_equal(mean.contribution_sum, [3, 4])
    np.testing.assert_array_equal(mean.contribution, [1.5, 2.0])
    np.testing.assert_array_equal(mean.figures.strength, 2 * ramp)
    np.testing.assert_array_equal(mean.figures.error, ramp + 0.5)
    np.testing.assert_array_equal(mean.figures.quality, 0 * ramp)
    np.testing.assert_array_equal(mean.used, ramp == 5)  # used in one deployment is used
    assert mean.figures.strength.dtype == np.float32
    assert (mean.delivered, mean.steps) == (3.0, 100.0)


@pytest.mark.parametrize("field", ["quality", "strength", "error"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_named_with_its_place(make, field, value):
    array = np.zeros((2, 4))
    array[1, 3] = value
    trial = Trial(name="run with seed 5, generation 12")
    with pytest.raises(InputError) as error:
        trial.add(2, make.deployment(0.1, **{field: array}))
    text = str(error.value)
    assert f"run with seed 5, generation 12, deployment 2: {field} of agent 1, rule 3 is {value}" in text
    assert "\n" not in text


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_fitness_that_is_not_finite_is_named(make, value):
    with pytest.raises(InputError, match=f"deployment 0: fitness is {value}"):
        Trial().add(0, make.deployment(value))


def test_wrong_shapes_signs_and_numbers_are_refused(make):
    with pytest.raises(InputError, match="contribution of agent 1 is -1"):
        Trial().add(0, make.deployment(0.1, (0, -1)))
    with pytest.raises(InputError, match=r"error has shape \(2, 3\)"):
        Trial().add(0, make.deployment(0.1, error=np.zeros((2, 3))))
    trial = Trial(max_redeployments=2)
    trial.add(0, make.deployment(0.1))
    for index in (0, 3, -1):
        with pytest.raises(InputError, match=f"deployment {index} is here already or is not one of 0..2"):
            trial.add(index, make.deployment(0.1))
    with pytest.raises(InputError, match="at least one"):
        mean_of([])


def test_keys_differ_by_seed_generation_deployment_and_purpose():
    keys = [deployment_key(s, g, d) for s in (0, 1, 2**32, 2**64 - 1) for g in range(20) for d in range(6)]
    keys += [fresh_deployment_key(s, d) for s in (0, 1, 2**32, 2**64 - 1) for d in range(30)]
    assert len(set(keys)) == len(keys)
    assert all(word.dtype == np.uint32 for key in keys for word in key)


def test_keys_are_the_same_everywhere():
    """SeedSequence is stable across machines and versions of NumPy: a changed value would break every stored run."""
    expected = np.random.SeedSequence(3, spawn_key=(2, 4, 5)).generate_state(2, np.uint32)
    assert [int(word) for word in deployment_key(3, 4, 5)] == expected.tolist()
    fresh = np.random.SeedSequence(3, spawn_key=(3, 5)).generate_state(2, np.uint32)
    assert [int(word) for word in fresh_deployment_key(3, 5)] == fresh.tolist()


@pytest.mark.parametrize("seed", [-1, 2**64])
def test_a_seed_out_of_range_is_refused(seed):
    with pytest.raises(InputError, match="seed = "):
        seed_sequence(seed, 1)


def test_two_evaluations_together_are_as_one(make):
    rng = np.random.default_rng(0)
    deployed = [make.deployment(rng.random(), (3, 1), rng=rng) for _ in range(7)]
    whole, joined = mean_of(deployed), together(mean_of(deployed[:2]), mean_of(deployed[2:]))
    assert joined.fitnesses == whole.fitnesses
    np.testing.assert_array_equal(joined.contribution_sum, whole.contribution_sum)
    assert (joined.delivered, joined.steps) == (whole.delivered, whole.steps)
    for name, array in whole.figures.arrays().items():
        np.testing.assert_allclose(getattr(joined.figures, name), array, rtol=1e-5, atol=1e-6)
        assert getattr(joined.figures, name).dtype == np.float32
