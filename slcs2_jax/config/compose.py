"""Hydra underneath: compose configurations, one or many, from the settings, conf/ and the command line.

Nothing here knows what a run is: `run_hydra` hands every job's plain mapping to a function of the caller.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slcs2_jax.config import invocation, plugins
from slcs2_jax.config.command_line import CommandLine
from slcs2_jax.config.conf import conf_dir, groups, options
from slcs2_jax.config.errors import InputError, show
from slcs2_jax.config.overrides import Checker
from slcs2_jax.config.store import BY_VALUE, CHOICES, Primary
from slcs2_jax.config.world_text import with_world_text

Together = Callable[[list["Job"]], list[float]]

# In the name of a run of a sweep the value says it all.
_SAY_VALUE_ALONE = frozenset((*CHOICES, *BY_VALUE.values(), "acceptance"))


@dataclass(frozen=True)
class Job:
    """One composed configuration.

    Attributes:
        config: nested mapping of plain values, everything resolved.
        overrides: what the command line set for this job, as Hydra has it.
        label: name of this job among those of a sweep, "" outside of one.
    """

    config: dict[str, Any]
    overrides: tuple[str, ...]
    label: str


def run_hydra(primary: Primary, line: CommandLine, together: Together) -> None:
    """Compose the configuration(s) that the command line asks for and give them to `together`, or print what it asks.

    Args:
        primary: what is composed from.
        line: the command line.
        together: runs jobs and returns a number for each (what an optimising sweeper would minimise). With the launcher
            of this project one call gets all the jobs of a sweep; with any other launcher one call gets one job.

    Raises:
        InputError: for whatever cannot be composed.
    """
    with tempfile.TemporaryDirectory(prefix="slcs2-") as scratch, _hydra(primary, line, scratch):
        overrides, swept = Checker(primary, _groups(primary, line), _hydra_options).check(
            line.overrides, sweep=line.sweep
        )
        if line.hydra_help:
            print(_hydra_help(), end="", flush=True)
        elif line.show:
            print(_shown(primary, overrides, line.show), end="", flush=True)
        elif line.sweep:
            _sweep(primary, line, overrides, swept, together)
        else:
            with _complaints_in_one_line():
                from hydra import compose

                job = make_job(compose(primary.name, overrides), overrides, None)
            together([job])


def _sweep(primary: Primary, line: CommandLine, overrides: list[str], swept: Sequence[str], together: Together) -> None:
    """Let Hydra's sweeper and launcher make the jobs and run them, perhaps in other processes."""
    from hydra.core.global_hydra import GlobalHydra
    from hydra.core.hydra_config import HydraConfig

    own: list[BaseException] = []  # errors of `together`, as opposed to Hydra's
    command, modules = invocation.command(), plugins.named_in(line.overrides)

    def run(jobs: list[Job]) -> list[float]:
        if not jobs:
            raise InputError("option -m: no combination of values; accepted are values that exist")
        try:
            return together(jobs)
        except Exception as error:
            own.append(error)
            raise

    def task(config: Any) -> float:
        invocation.remember(command)
        plugins.load(modules)  # in the process of a launcher they are not there yet
        return run([make_job(config, HydraConfig.get().overrides.task, swept)])[0]

    def sweep(jobs: list[tuple[Any, Sequence[str]]]) -> list[float]:
        return run([make_job(config, overrides, swept) for config, overrides in jobs])

    task.together = sweep  # type: ignore[attr-defined]
    hydra = GlobalHydra.instance().hydra
    assert hydra is not None
    with _complaints_in_one_line(own, elsewhere=line.names_launcher):
        hydra.multirun(primary.name, task, overrides, with_log_configuration=False)


def make_job(config: Any, overrides: Sequence[str], swept: Sequence[str] | None) -> Job:
    """A job from a composed configuration (without its hydra node); `swept` are the keys that differ among the jobs."""
    from omegaconf import OmegaConf

    plain = OmegaConf.to_container(config, resolve=True, throw_on_missing=True)
    assert isinstance(plain, dict)
    config = with_world_text({str(key): value for key, value in plain.items()})
    return Job(config, tuple(overrides), _label(overrides, swept))


def _label(overrides: Sequence[str], swept: Sequence[str] | None) -> str:
    """A folder name from the swept values: open_short, open_s3, ailta. No sweep: ""; a sweep of nothing: all."""
    if swept is None:
        return ""
    values = dict(override.lstrip("+").split("=", 1) for override in overrides if "=" in override)
    parts = []
    for key in swept:
        value = values.get(key, "").strip("'\"")
        if "grammar" in key:
            value = Path(value).stem
        short = "s" if key == "seed" else key.rsplit(".", 1)[-1] + "-"
        text = value if key in _SAY_VALUE_ALONE else short + value
        parts.append("".join(letter if letter.isalnum() or letter in "-._" else "-" for letter in text))
    return "_".join(parts) or "all"


def _groups(primary: Primary, line: CommandLine) -> dict[str, list[str]]:
    """The groups that the command takes, with their options in conf/ and in the user's folder."""
    here, theirs = groups(), line.config_dir
    found = {name: set(here.get(name, ())) for name in primary.groups()}
    for folder in sorted(theirs.iterdir()) if theirs else ():
        if folder.is_dir():
            found[folder.name] = found.get(folder.name, set()) | set(options(folder))
    return {name: sorted(names) for name, names in found.items()}


def _hydra_options(group: str) -> list[str]:
    from hydra.core.global_hydra import GlobalHydra

    return sorted(GlobalHydra.instance().config_loader().get_group_options(group))


@contextmanager
def _hydra(primary: Primary, line: CommandLine, scratch: str) -> Iterator[None]:
    """Hydra with the command's configuration in its store.

    What its sweeper writes (multirun.yaml, empty job folders) goes to a scratch folder unless the user names one.
    """
    from hydra import initialize_config_dir
    from hydra.core.config_store import ConfigStore

    node = primary.node([f"file://{line.config_dir}"] if line.config_dir else ())
    node["hydra"]["sweep"] = {"dir": scratch, "subdir": "."}
    ConfigStore.instance().store(name=primary.name, node=node, provider="slcs2_jax")
    with initialize_config_dir(version_base="1.3", config_dir=str(conf_dir()), job_name="slcs2"):
        yield


def _shown(primary: Primary, overrides: list[str], what: str) -> str:
    """The composed configuration in YAML: of the job, Hydra's own, or both."""
    from hydra import compose
    from omegaconf import OmegaConf

    with _complaints_in_one_line():
        config = compose(primary.name, overrides, return_hydra_config=what != "job")
        return OmegaConf.to_yaml(OmegaConf.create({"hydra": config.hydra}) if what == "hydra" else config)


def _hydra_help() -> str:
    """What of Hydra is accepted here."""
    import hydra

    return (
        f"Hydra {hydra.__version__} composes the settings. Of its options these are accepted:\n"
        "  -m, --multirun          every combination of the values that settings have\n"
        "  --cfg job|hydra|all     print the composed configuration and stop\n"
        "  --config-dir DIR        look for groups there too: DIR/radio/mine.yaml is radio=mine\n"
        f"  hydra/launcher=NAME     of a sweep: {', '.join(_hydra_options('hydra/launcher'))}\n"
        f"  hydra/sweeper=NAME      of a sweep: {', '.join(_hydra_options('hydra/sweeper'))}\n"
        "and settings of Hydra's own, hydra.launcher.n_jobs=4 (--cfg hydra shows them).\n"
        "Values: seed=1; with -m also seed=1,2,3 or seed=range(1,4); name='a text', name=[a,list], name=null.\n"
    )


@contextmanager
def _complaints_in_one_line(own: Sequence[BaseException] = (), *, elsewhere: bool = False) -> Iterator[None]:
    """Whatever goes wrong in Hydra comes from the command line; what the caller's function raised passes as it is."""
    from hydra.errors import HydraException
    from omegaconf.errors import MissingMandatoryValue, OmegaConfBaseException
    from yaml import YAMLError

    try:
        yield
    except InputError:
        raise
    except MissingMandatoryValue as error:
        raise InputError(f"{error.full_key}: has no default; accepted is {error.full_key}=VALUE") from None
    except Exception as error:
        # a job of another launcher may have failed in another process: then the error is none that Hydra would raise
        if error in own or (elsewhere and not isinstance(error, HydraException | OmegaConfBaseException | YAMLError)):
            raise
        key = getattr(error, "full_key", None)
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        text = "; ".join(line for line in lines if not line.startswith(("See http", "full_key:", "object_type=")))[:400]
        raise InputError(f"{show(key)}: {text}" if key else f"configuration: {text}") from None
