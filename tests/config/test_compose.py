"""conf/ through Hydra: what it composes, its sweeps, and its errors in one line."""

import pytest
from omegaconf import OmegaConf

from slcs2_jax.config import InputError, Radio, Settings, World, settings_from
from slcs2_jax.config.command_line import CommandLine
from slcs2_jax.config.compose import run_hydra
from slcs2_jax.config.conf import conf_dir
from slcs2_jax.config.store import Primary


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    yield
    assert list(tmp_path.iterdir()) == [], "Hydra left something behind"


def compose(*arguments):
    calls = []

    def together(jobs):
        calls.append(jobs)
        return [0.0] * len(jobs)

    run_hydra(Primary(name="evolve"), CommandLine.parse(arguments), together)
    return calls


def one(*arguments) -> Settings:
    [[job]] = compose(*arguments)
    return settings_from(job.config)


def test_without_arguments_it_is_the_dataclasses_defaults():
    assert one() == Settings()


@pytest.mark.parametrize("environment", ["open", "jammed", "urban", "urban_jammed"])
@pytest.mark.parametrize("range_", ["short", "long"])
def test_presets_are_the_groups(environment, range_):
    assert one(f"environment={environment}", f"range={range_}").world == World.preset(environment, range_)


def test_every_value_has_a_comment():
    for file in conf_dir().rglob("*.yaml"):
        lines = file.read_text().split("\nhydra:")[0].splitlines()
        for before, line in zip(["", *lines], lines, strict=False):
            if line and line[0] not in "#- " and line != "defaults:":
                assert before.startswith("#"), f"{file.name}: {line}"


def test_overrides():
    settings = one("generations=3", "acceptance=ailta", "exchange=off", "radio.noise_dbm=-90", "grammar=both", "seed=5")
    assert (settings.search.generations, settings.search.acceptance, settings.search.exchange) == (3, "ailta", False)
    assert (settings.radio.noise_dbm, settings.rules.grammar, settings.seed) == (-90.0, "both", 5)


def test_what_is_computed_and_what_is_taken_as_typed():
    """As docs/start.md says."""
    settings = one("swarm.packets=int(12.7)", "exchange=bool(1)", "run_dir={}")
    assert (settings.swarm.packets, settings.search.exchange, settings.run_dir) == (12, True, "{}")
    assert [one(f"run_dir={name}").run_dir for name in ("5", "str(5)", "[a]")] == ["5", "str(5)", "[a]"]


@pytest.mark.parametrize(
    "argument",
    ["swarm.packets={}", "swarm.packets=12.7", "swarm.packets=12.0", "swarm.packets=true", "swarm.packets=float(3)",
     "exchange=1", "world.buildings=0", "instances={}", "worlds={}", "radio.channels={}", "swarm.speed=true"],
)  # fmt: skip
def test_a_setting_takes_its_own_kind_alone(argument):
    name = argument.partition("=")[0]
    with pytest.raises(InputError, match=rf"^{name}=.*: accepted is "):
        one(argument)


def test_a_grammar_by_path():
    assert one("grammar=my/own.bnf").rules.grammar == "my/own.bnf"
    [jobs] = compose("-m", "grammar=main,my/own.bnf")
    assert [settings_from(job.config).rules.grammar for job in jobs] == ["main", "my/own.bnf"]
    assert [job.label for job in jobs] == ["main", "own"]


def test_a_sweep_comes_in_one_call_with_its_labels():
    [jobs] = compose("-m", "environment=open,urban", "range=short,long", "instances=2")
    assert [job.label for job in jobs] == ["open_short", "open_long", "urban_short", "urban_long"]
    worlds = [settings_from(job.config).world for job in jobs]
    assert worlds[3] == World.preset("urban", "long")
    assert {settings_from(job.config).instances for job in jobs} == {2}


def test_labels_of_numbers_and_an_empty_sweep():
    [jobs] = compose("-m", "seed=range(0,2)", "learning.alpha_q=0.1,0.2")
    assert [job.label for job in jobs] == ["s0_alpha_q-0.1", "s0_alpha_q-0.2", "s1_alpha_q-0.1", "s1_alpha_q-0.2"]
    [[job]] = compose("-m", "seed=4")
    assert job.label == "all"


def test_another_launcher_gets_one_job_at_a_time():
    calls = compose("-m", "seed=1,2", "hydra/launcher=basic")
    assert [[job.label for job in jobs] for jobs in calls] == [["s1"], ["s2"]]


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["environment=forest"], "environment=forest: accepted is one of jammed, open, urban, urban_jammed"),
        (["radio=loud"], "radio=loud: accepted is a setting of it, such as those of radio.*"),
        (["radio.nois_dbm=3"], "radio.nois_dbm: no such setting; did you mean radio.noise_dbm"),
        (["frobnicate=3"], "frobnicate: no such setting"),
        (["seed"], "seed: accepted is an override of the form setting=value"),
        (["seed=[1"], "accepted is an override of the form setting=value"),
        (["seed=1,2"], "seed=1,2: accepted is one value; add -m"),
        (["seed=${nowhere}"], "seed: Interpolation key 'nowhere' not found"),
        (["hydra/launcher=rocket"], "hydra/launcher=rocket: accepted is one of basic, batched"),
        (["-m", "environment=open,forest"], "environment=forest: accepted is one of jammed, open, urban, urban_jammed"),
        (["--config-dir", "nowhere"], "option --config-dir=nowhere: accepted is a folder that exists"),
        (["+radio.power_dbm=3"], "+radio.power_dbm=3: accepted is radio.power_dbm=VALUE, without the +"),
        (["+environment=open"], "+environment=open: accepted is environment=OPTION, without the +"),
        (["hydra.sweeper.max_batch_sise=3"], "max_batch_sise"),
        (["search=annealing"], "search.name=annealing: accepted is one of slcs2, random, informed"),
        (["plugins=[nowhere_at_all.x!]"], "accepted is"),
    ],
)
def test_refused_in_one_line(arguments, part, capfd):
    with pytest.raises(InputError) as caught:
        compose(*arguments)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_a_value_that_a_users_group_leaves_open_is_the_default(tmp_path_factory):
    folder = tmp_path_factory.mktemp("groups")
    (folder / "radio").mkdir()
    OmegaConf.save({"noise_dbm": "???", "shadowing_db": 1.0}, folder / "radio" / "mine.yaml")
    assert one("--config-dir", str(folder), "radio=mine").radio == Radio(shadowing_db=1.0)


def test_a_users_own_group(tmp_path_factory):
    folder = tmp_path_factory.mktemp("groups")
    (folder / "radio").mkdir()
    OmegaConf.save({"noise_dbm": -80.0}, folder / "radio" / "mine.yaml")
    assert one("--config-dir", str(folder), "radio=mine").radio.noise_dbm == -80.0
