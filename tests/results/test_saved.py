"""Saved solutions: the same comes back, and no damaged or foreign file is believed."""

import dataclasses
import json

import numpy as np
import pytest

from slcs2_jax.config import InputError, Rules, Settings, Swarm
from slcs2_jax.grammar import RuleSets, load_grammar, random_rules
from slcs2_jax.results import SavedSolution, load_solution

AGENTS, RULES = 3, 5


@pytest.fixture
def solution() -> SavedSolution:
    rng = np.random.default_rng(0)
    grammar = load_grammar("main")
    mask, action = random_rules(grammar, AGENTS * RULES, rng)
    values = {name: rng.normal(size=(AGENTS, RULES)).astype(np.float32) for name in ("quality", "strength")}
    return SavedSolution(
        rules=RuleSets(mask.reshape(AGENTS, RULES, 4), action.reshape(AGENTS, RULES)),
        error=np.ones((AGENTS, RULES), np.float32),
        usage=np.arange(AGENTS * RULES, dtype=np.int32).reshape(AGENTS, RULES),
        contribution=np.array([1.5, 0, 3], np.float32),
        settings=Settings(swarm=Swarm(agents=AGENTS), rules=Rules(rules=RULES)),
        grammar_text=grammar.text,
        instance_seed=4,
        generation=17,
        fitness=0.25,
        deployments=6,
        **values,
    )


def test_round_trip(solution, tmp_path):
    path = tmp_path / "s.npz"
    solution.save(path)
    again = load_solution(path)
    for name in ("quality", "strength", "error", "usage", "contribution"):
        np.testing.assert_array_equal(getattr(again, name), getattr(solution, name))
        assert getattr(again, name).dtype == getattr(solution, name).dtype
    np.testing.assert_array_equal(again.rules.ids(), solution.rules.ids())
    assert again.settings == solution.settings
    assert (again.fitness, again.generation, again.instance_seed, again.deployments) == (0.25, 17, 4, 6)
    assert again.grammar_text == solution.grammar_text
    assert [p.name for p in tmp_path.iterdir()] == ["s.npz"]


def test_the_same_solution_gives_the_same_bytes(solution, tmp_path):
    solution.save(tmp_path / "a.npz")
    solution.save(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_text_lists_every_rule_the_strongest_first(solution):
    text = solution.text()
    assert text.count("=>") == AGENTS * RULES
    first = text.split("agent 0")[1].splitlines()[2]
    strongest = int(np.argmax(solution.strength[0]))
    assert first.endswith(solution.rules.text(0, strongest))
    assert f"{solution.quality[0, strongest]:.3f}" in first


def test_a_text_file_is_refused(tmp_path):
    (tmp_path / "x.npz").write_text("no solution")
    with pytest.raises(InputError, match=r"x.npz: not a solution saved by slcs2"):
        load_solution(tmp_path / "x.npz")
    with pytest.raises(InputError, match="no such file"):
        load_solution(tmp_path / "absent.npz")


def test_every_truncation_is_refused(solution, tmp_path):
    path = tmp_path / "s.npz"
    solution.save(path)
    data = path.read_bytes()
    for length in range(0, len(data), max(1, len(data) // 40)):
        path.write_bytes(data[:length])
        with pytest.raises(InputError, match=r"s\.npz"):
            load_solution(path)


def test_every_flipped_byte_is_refused_or_harmless(solution, tmp_path):
    path = tmp_path / "s.npz"
    solution.save(path)
    data, refused = path.read_bytes(), 0
    for place in range(0, len(data), 23):
        damaged = bytearray(data)
        damaged[place] ^= 0xFF
        path.write_bytes(bytes(damaged))
        try:
            again = load_solution(path)
        except InputError:
            refused += 1
        else:  # bytes that no reader looks at, such as dates in the archive
            np.testing.assert_array_equal(again.quality, solution.quality)
            assert again.settings == solution.settings
    assert refused


def entries(path) -> dict:
    with np.load(path) as stored:
        return {name: stored[name] for name in stored.files}


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (lambda e: e.pop("usage"), "entries are not those"),
        (lambda e: e.update(extra=np.zeros(1)), "entries are not those"),
        (lambda e: e.update(quality=e["quality"].astype(np.float64)), "quality is float64"),
        (lambda e: e.update(quality=e["quality"][:, :2]), r"quality is float32[3, 2]"),
        (lambda e: e.update(quality=e["quality"] * np.float32(np.nan)), "not finite"),
        (lambda e: e.update(usage=-e["usage"]), "below 0"),
        (lambda e: e.update(rule=e["rule"] + np.int32(100)), "its rules are not those of a solution"),
        (lambda e: e.update(rule=e["rule"] - np.int32(100)), "its rules are not those of a solution"),
        (lambda e: e.update(rule=e["rule"].astype(np.uint8)), "rule is uint8"),
        (lambda e: e.update(rule=e["rule"][:, :2]), "entries"),
        (lambda e: about(e, rules=[5] * 15), "its rules are not those of a solution"),
        (lambda e: about(e, rules=["packet held => fly"] * 15), "action: 'fly' is not known"),
        (lambda e: about(e, rules=["cat near => move toward so"] * 15), "clause: 'cat near' is not known"),
        (lambda e: about(e, rules="packet held => orbit c"), "has the wrong type"),
        (lambda e: e.update(format=np.array("other 3")), "format"),
        (lambda e: e.update(about=np.array("{")), "no JSON, or cut short"),
        (lambda e: e.update(about=np.array("[]")), "JSON object"),
        (lambda e: e.update(about=np.array("{}")), "description"),
        (lambda e: e.update(about=np.array([1, 2])), "its about is missing or no text"),
        (lambda e: about(e, fitness=3.0), "fitness=3.0"),
        (lambda e: about(e, fitness="x"), "fitness='x'"),
        (lambda e: about(e, settings={"swarm": {"agents": 4}}), "settings say otherwise"),
        (lambda e: about(e, settings={"swarm": {"wings": 4}}), "swarm.wings"),
        (lambda e: about(e, settings={"swarm": {"agents": 4.5}}), "swarm.agents=4.5"),
    ],
)
def test_foreign_entries_are_refused(solution, tmp_path, change, part):
    path = tmp_path / "s.npz"
    solution.save(path)
    changed = entries(path)
    change(changed)
    np.savez(path, **changed)
    with pytest.raises(InputError) as caught:
        load_solution(path)
    assert part in str(caught.value)
    assert "s.npz" in str(caught.value)
    assert "\n" not in str(caught.value)


def about(changed: dict, **values) -> None:
    changed["about"] = np.array(json.dumps(json.loads(str(changed["about"])) | values))


def test_pickles_are_never_opened(tmp_path):
    np.savez(tmp_path / "p.npz", mask=np.array([{"a": 1}], dtype=object))
    with pytest.raises(InputError):
        load_solution(tmp_path / "p.npz")


def test_values_that_cannot_be_are_not_saved(solution):
    import dataclasses

    with pytest.raises(InputError, match="quality: a value is not finite"):
        dataclasses.replace(solution, quality=solution.quality * np.nan)
    with pytest.raises(InputError, match="fitness=nan"):
        dataclasses.replace(solution, fitness=float("nan"))


def test_reflexes_and_the_quality_that_rules_begin_with_come_back(solution, tmp_path):
    reflex = np.arange(AGENTS * RULES).reshape(AGENTS, RULES) % 4 == 0
    begun = np.linspace(-1, 3, AGENTS * RULES, dtype=np.float32).reshape(AGENTS, RULES)
    plain = solution.rules
    flagged = dataclasses.replace(solution, rules=RuleSets(plain.mask, plain.action, plain.vocabulary, reflex, begun))
    flagged.save(tmp_path / "flagged.npz")
    again = load_solution(tmp_path / "flagged.npz")
    np.testing.assert_array_equal(again.rules.reflex, reflex)
    np.testing.assert_array_equal(again.rules.quality, begun)
    np.testing.assert_array_equal(again.quality, solution.quality)
    assert again.text().count("reflex: ") == reflex.sum()
    rule = plain.text(0, 4)
    assert f"reflex: {rule}" in again.text()
    solution.save(tmp_path / "plain.npz")
    plain = load_solution(tmp_path / "plain.npz")
    assert plain.rules.reflex is None
    assert plain.rules.quality is None
    assert "reflex" not in plain.text()


@pytest.mark.parametrize("name", ["reflex", "initial_quality"])
def test_flags_and_qualities_of_another_kind_are_refused(solution, tmp_path, name, monkeypatch):
    values = {"reflex": np.zeros((AGENTS, RULES), np.uint8), "initial_quality": np.zeros((AGENTS, 1), np.float32)}
    monkeypatch.setattr("slcs2_jax.results.saved._extras_of", lambda rules: {name: values[name]})
    solution.save(tmp_path / "odd.npz")
    with pytest.raises(InputError, match=f"{name} is .*; accepted is"):
        load_solution(tmp_path / "odd.npz")
