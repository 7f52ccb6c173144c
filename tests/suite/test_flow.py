"""Train, choose, evaluate, tabulate: the whole way in small worlds, interrupted and repeated."""

from __future__ import annotations

import dataclasses
import json
import shutil

import numpy as np
import pytest

from slcs2_jax import cli
from slcs2_jax.config import Compute, InputError
from slcs2_jax.config.worlds import home_of
from slcs2_jax.results import Quiet, load_solution
from slcs2_jax.suite import shown, training
from slcs2_jax.suite.entries import EVOLVED, entry_named, shipped
from slcs2_jax.suite.frozen import digest
from slcs2_jax.suite.measured import load
from slcs2_jax.suite.table import collect
from slcs2_jax.suite.training import plan, read_record, train
from slcs2_jax.suite.worlds import load_suite
from slcs2_jax.world.scenario import make_scenario


@pytest.fixture(scope="module")
def trained(tiny, tmp_path_factory):
    """Two trainings of SLCS2 in four-agent worlds."""
    root = tmp_path_factory.mktemp("suite")
    trainings = plan(shipped()["slcs2"], [tiny.worlds["few"]], root, compute=Compute())
    train(trainings, Quiet())
    return root, trainings


def test_a_training_keeps_to_its_budget_and_its_seeds(trained, tiny):
    _, trainings = trained
    world = tiny.worlds["few"]
    assert [one.settings.seed for one in trainings] == list(world.seeds_of("train"))
    for one in trainings:
        said = read_record(one.record)
        assert said["budget"] == world.episodes == 6
        assert 6 <= said["episodes"] <= 6 + 5  # the last solution may be deployed again
        assert said["env_steps"] <= said["episodes"] * world.time_limit
        assert said["validation_episodes"] == len(said["validation"]) * 2


def test_the_fittest_in_the_validation_worlds_is_kept(trained):
    _, trainings = trained
    for one in trainings:
        said = read_record(one.record)
        means = np.mean(said["validation"], axis=1)
        assert said["chosen"] == int(np.argmax(means))
        kept, held = load_solution(one.artefact), training.candidates(one.settings)[said["chosen"]]
        np.testing.assert_array_equal(kept.rules.mask, held.rules.mask)
        np.testing.assert_array_equal(kept.rules.action, held.rules.action)


def test_what_is_there_is_not_made_again(trained):
    _, trainings = trained
    assert train(trainings, Quiet()) == []


def test_again_from_scratch_it_is_the_same_bytes(trained, tiny, tmp_path):
    _, trainings = trained
    again = plan(shipped()["slcs2"], [tiny.worlds["few"]], tmp_path, compute=Compute())
    train(again, Quiet())
    for one, other in zip(trainings, again, strict=True):
        assert one.artefact.read_bytes() == other.artefact.read_bytes()
        assert one.record.read_bytes() == other.record.read_bytes()


def test_every_search_is_trained_within_the_budget(tiny, tmp_path):
    """All in one call, where those that can share a batch do."""
    entries = [entry for entry in shipped().values() if entry.field == EVOLVED]
    trainings = [
        one
        for entry in entries
        for one in plan(entry, [tiny.worlds["few"]], tmp_path, compute=Compute(), trainings=1, episodes=23)
    ]
    assert len(train(trainings, Quiet())) == len(entries) == 6
    for one in trainings:
        said = read_record(one.record)
        assert 23 <= said["episodes"] <= 23 + 5, one.entry.name
        assert load_solution(one.artefact).rules.action.shape == (4, 100)


def test_a_training_in_many_worlds_takes_others_than_the_one_before(tmp_path):
    file = tmp_path / "many.yaml"
    file.write_text("train_worlds: 5\nsettings: {search: {name: informed}}\n")
    world = load_suite().worlds["two_patrols"]
    trainings = plan(entry_named(str(file)), [world], tmp_path, compute=Compute(), trainings=13)
    taken = [[home_of(one.settings, one.settings.seed, place) for place in range(5)] for one in trainings]
    seeds = [seed for one in taken for _, seed in one]
    assert seeds == [*world.seeds_of("train")[:60], *world.seeds_of("train")[:5]]
    assert {len(one.settings.worlds) for one in trainings} == {1}  # a race may end after the first of a kind
    made = [make_scenario(its, seed) for its, seed in taken[0]]
    assert digest(world.stated, made) == digest(world.stated, map(world.scenario, world.seeds_of("train")[:5]))


def test_many_worlds_of_a_town_from_files_are_refused(tmp_path):
    file = tmp_path / "many.yaml"
    file.write_text("train_worlds: 5\nsettings: {}\n")
    with pytest.raises(InputError, match="train_worlds=5: accepted is 1 in world houses, whose towns come from files"):
        plan(entry_named(str(file)), [load_suite().worlds["houses"]], tmp_path, compute=Compute())


def test_interrupted_before_the_choice_it_goes_on_to_the_same_bytes(trained, tiny, tmp_path):
    root, trainings = trained
    shutil.copytree(root / "runs", tmp_path / "runs")
    again = plan(shipped()["slcs2"], [tiny.worlds["few"]], tmp_path, compute=Compute())
    assert train(again, Quiet()) == [one.artefact for one in again]
    for one, other in zip(trainings, again, strict=True):
        assert one.artefact.read_bytes() == other.artefact.read_bytes()


def test_an_artefact_of_another_budget_is_refused(trained, tiny):
    root, _ = trained
    other = plan(shipped()["slcs2"], [tiny.worlds["few"]], root, compute=Compute(), episodes=7)
    with pytest.raises(InputError, match=r"training_0\.npz: was trained by another configuration"):
        train(other, Quiet())


def test_what_is_not_trained_is_refused(tiny, tmp_path):
    with pytest.raises(InputError, match="entry=designed: is not trained"):
        plan(shipped()["designed"], [tiny.worlds["few"]], tmp_path, compute=Compute())


def test_evaluate_prints_rows_side_by_side_and_resumes(trained, in_use, capsys):
    root, _ = trained
    call = ["suite", "evaluate", "slcs2,designed", "world=few", f"run_dir={root}"]
    assert cli.main(call) == 0
    printed = capsys.readouterr().out
    assert "> SLCS2" in printed
    assert "> The designed behaviour" in printed
    world = in_use.worlds["few"]
    found = load(root, "slcs2", world)
    assert found.steps.shape == (2, 3, 2)
    assert found.episodes == sum(
        read_record(root / f"artefacts/slcs2/few/training_{r}.json")[name]
        for r in range(2)
        for name in ("episodes", "validation_episodes")
    )
    file = root / "results/slcs2/few.npz"
    before, written = file.read_bytes(), file.stat().st_mtime_ns
    assert cli.main(call) == 0
    assert file.stat().st_mtime_ns == written  # known, and not computed again
    file.unlink()
    assert cli.main(call) == 0
    assert file.read_bytes() == before
    table = collect(in_use, [root], [world])
    assert shown.best_of_fields(table) == [("few", "designed"), ("few", "slcs2")]
    facts = [one for one, _ in shown.shown(table, [root], Compute())]
    assert [one["entry"] for one in facts] == ["The designed behaviour", "SLCS2"]
    for one in facts:
        shares = [share for _, share in one["says"]]
        assert shares == sorted(shares, reverse=True)
        assert 0 < sum(shares) <= 1 + 1e-9
        assert all("=>" in text for text, _ in one["says"])
        assert len(one["rules"]["text"]) == 4 * one["rules"]["rules"]
    assert cli.main(["suite", "table", f"run_dir={root}", "world=few", f"out={root}", "replays=on"]) == 0
    assert "Four agents only" in capsys.readouterr().out
    page = (root / "index.html").read_text()
    assert "Benchmark suite-v1" in page
    assert page.count('<script type="application/octet-stream;base64"') == 3  # the tables, and two replays
    assert "| SLCS2 | evolved |" in (root / "table.md").read_text()
    assert (root / "overall.csv").read_text().startswith("entry,field,fitness,IQM")


def test_tuning_looks_at_the_validation_worlds_alone(in_use, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    call = ["suite", "evaluate", "designed", "world=few", "split=validation", "deployments=1", "run_dir=r"]
    assert cli.main(call) == 0
    world = in_use.worlds["few"]
    found = load(tmp_path / "r", "designed", world, "validation")
    assert found.seeds.tolist() == list(world.seeds_of("validation"))
    assert load(tmp_path / "r", "designed", world) is None
    assert cli.main(["suite", "table", "world=few", "split=validation", "run_dir=r"]) == 0
    assert "The designed behaviour" in capsys.readouterr().out
    assert cli.main(["suite", "table", "world=few", "run_dir=r"]) == 2


def test_more_deployments_or_another_policy_are_computed_anew(in_use, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.txt").write_text("packet held => move toward sink\n")
    call = ["suite", "evaluate", "mine.txt", "world=few", "seeds=2", "run_dir=r"]
    assert cli.main([*call, "deployments=1"]) == 0
    world = in_use.worlds["few"]
    assert load(tmp_path / "r", "mine", world).steps.shape == (1, 2, 1)
    assert cli.main([*call, "deployments=2"]) == 0
    first = load(tmp_path / "r", "mine", world)
    assert first.steps.shape == (1, 2, 2)
    (tmp_path / "mine.txt").write_text("packet held => move toward source\n")
    assert cli.main([*call, "deployments=2"]) == 0
    assert load(tmp_path / "r", "mine", world).digest != first.digest
    assert entry_named("mine.txt").digest == load(tmp_path / "r", "mine", world).digest


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "suite=: accepted is one of list, train, evaluate, table"),
        (["train"], "accepted is slcs2 suite train ENTRY"),
        (["train", "nobody"], "entry=nobody: accepted is one of"),
        (["train", "designed"], "entry=designed: is not trained"),
        (["evaluate", "designed", "world=moon"], "world=moon: accepted is one of open_short, few"),
        (["evaluate", "designed", "seeds=0"], "seeds=0: accepted is a whole number from 1"),
        (["evaluate", "designed", "world=few", "seeds=9"], "seeds=9: accepted is a whole number from 1 to 3"),
        (["evaluate", "designed", "swarm.agents=3"], "the worlds are frozen"),
        (["evaluate", "slcs2", "world=few"], "has no artefact of training 0 in world few"),
        (["evaluate", "designed", "out=x"], "option=out: accepted is one of"),
        (["table"], "holds no results"),
        (["table", "out=nowhere"], "out=nowhere: accepted is a folder that exists"),
    ],
)
def test_bad_input_is_one_line(in_use, tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["suite", *arguments]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1


def test_a_changed_world_is_not_trained_in(tiny, tmp_path):
    world = dataclasses.replace(tiny.worlds["few"], sha256="0" * 64)
    with pytest.raises(InputError, match="world few of suite-v1: its checksum"):
        train(plan(shipped()["slcs2"], [world], tmp_path, compute=Compute()), Quiet())


def test_a_damaged_artefact_or_record_is_named(trained, in_use, tmp_path, capsys):
    root, _ = trained
    shutil.copytree(root / "artefacts", tmp_path / "artefacts")
    path = tmp_path / "artefacts/slcs2/few/training_1.npz"
    path.write_bytes(path.read_bytes()[:-40])
    assert cli.main(["suite", "evaluate", "slcs2", "world=few", f"run_dir={tmp_path}"]) == 2
    assert "training_1.npz: not a solution saved by slcs2" in capsys.readouterr().err
    record = tmp_path / "artefacts/slcs2/few/training_0.json"
    said = json.loads(record.read_text())
    record.write_text(json.dumps(said | {"episodes": 1}))
    with pytest.raises(InputError, match=r"training_0\.json: its checksum does not fit"):
        read_record(record)


@pytest.mark.parametrize("link", ["artefacts", "artefacts/slcs2", "artefacts/slcs2/few"])
def test_an_artefact_behind_a_link_is_not_read(trained, in_use, tmp_path, capsys, link):
    root, trainings = trained
    shutil.copytree(root / "artefacts", tmp_path / "artefacts")
    shutil.rmtree(tmp_path / link)
    (tmp_path / link).symlink_to(root / link)
    assert cli.main(["suite", "evaluate", "slcs2", "world=few", f"run_dir={tmp_path}"]) == 2
    assert f"{tmp_path / link}: is a link; accepted is a folder" in capsys.readouterr().err
    with pytest.raises(InputError, match="is a link"):
        training.made(dataclasses.replace(trainings[0], root=tmp_path))


def test_no_training_goes_on_behind_a_link(trained, tiny, tmp_path):
    root, _ = trained
    (tmp_path / "runs/slcs2/few").mkdir(parents=True)
    (tmp_path / "runs/slcs2/few/training_0").symlink_to(root / "runs/slcs2/few/training_0")
    again = plan(shipped()["slcs2"], [tiny.worlds["few"]], tmp_path, compute=Compute())
    with pytest.raises(InputError, match="training_0: is a link; accepted is a folder"):
        train(again, Quiet())
