"""Entries: what takes part. Each is one readable file in entries/, or a file or plug-in of a user's.

- NAME.txt: a decision list, for every world alike; the first line says its title.
- NAME.yaml: a search by its settings, trained for each world: `title`, `about`, `settings`, and `train_worlds` if it
  evolves in several of them; or the training of a network: `algorithm` too, and `budget`.
- a user's .npz: a saved solution or policy; or the name of a policy that plugins= brings.
"""

from __future__ import annotations

import functools
import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slcs2_jax.config import InputError, plugins
from slcs2_jax.config.arguments import path_of
from slcs2_jax.config.door import check_below, present, read_file
from slcs2_jax.config.errors import refuse, show
from slcs2_jax.config.registry import KINDS
from slcs2_jax.config.schema import accepted_paths, flatten, unknown_setting
from slcs2_jax.config.yaml_text import parse_yaml

if TYPE_CHECKING:
    from slcs2_jax.policy.decision_list import DecisionList

HAND_MADE, EVOLVED, LEARNED, YOURS = "hand-made", "evolved", "learned", "yours"
ALGORITHMS = ("ippo", "strategy")  # of slcs2_jax.learning, which would start JAX
ORDER = (
    *("direct_delivery", "first_contact", "relay_chain", "geographic", "virtual_forces", "designed"),
    *("random", "slcs2", "ailta", "informed", "dominated_novelty", "map_elites"),
    *("ippo", "ippo_recurrent", "strategy"),
)
_SECTIONS = ("search", "knowledge", "learning", "rules", "acceptance", "exchange", "grammar")  # what an entry may set
_OF_THE_SUITE = (
    *("search.episodes", "generations", "search.generations", "search.fresh_deployments"),
    *("ippo.snapshot", "strategy.snapshot"),
)
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}\Z", re.ASCII)
_LARGEST = 2**24  # bytes of a user's file
_LONGEST = 80  # letters of a title
_MOST_WORLDS = 64  # train seeds that each kind of world has


@dataclass(frozen=True)
class Entry:
    """Something that takes part.

    Attributes:
        name, title, about: in commands and files; for people.
        field: hand-made, evolved, learned, or yours.
        content: of a decision list its text, of a training its configuration; "" for a file or a plug-in.
        settings: of a training, by their paths; None of what is not trained.
        train_worlds: that a training of a search evolves in by turns.
        algorithm: that trains a network, by its name; "" of all else. settings are its own then.
        budget: of a network, the share of the suite's env-steps that a training spends.
        path: of a user's .npz file.
        digest: SHA-256, hex, of what it is; of a training, of its configuration.
    """

    name: str
    title: str
    about: str
    field: str
    digest: str
    content: str = ""
    settings: Mapping[str, Any] | None = None
    train_worlds: int = 1
    algorithm: str = ""
    budget: float = 1.0
    path: Path | None = None

    @property
    def trained(self) -> bool:
        """Is it trained for each world?"""
        return self.settings is not None

    def decision_list(self) -> DecisionList:
        """Its rules, if it is a list of them, said in the suite's words or in a plug-in's. Raises InputError."""
        from slcs2_jax.policy.decision_list import parse_decision_list
        from slcs2_jax.suite.words import VOCABULARY

        vocabulary = None if self.field == YOURS else VOCABULARY
        return parse_decision_list(self.content, name=self.name, vocabulary=vocabulary)


@functools.lru_cache(maxsize=1)
def shipped() -> dict[str, Entry]:
    """The suite's own entries by name."""
    folder = resources.files(__package__) / "entries"
    texts = {name: f"{name}.yaml" for name in ORDER if (folder / f"{name}.yaml").is_file()}
    found = {}
    for name in ORDER:
        if name == "designed":
            text = (resources.files("slcs2_jax.policy") / "designed.txt").read_text(encoding="utf-8")
            found[name] = _list(name, text, HAND_MADE)
        elif name in texts:
            found[name] = _training(name, (folder / texts[name]).read_text(encoding="utf-8"))
        else:
            found[name] = _list(name, (folder / f"{name}.txt").read_text(encoding="utf-8"), HAND_MADE)
    return found


def entry_named(name: str) -> Entry:
    """The entry that a command names: the suite's, a file .txt, .yaml or .npz, or a policy that plugins= brings.

    Raises InputError if there is none such, or its name is that of another.
    """
    if name in shipped():
        return shipped()[name]
    if name in KINDS["policy"].own():
        digest = plugins.loaded().get(str(KINDS["policy"].home(name)), "")
        return Entry(_free(name), name, "", YOURS, digest)
    path = path_of("entry", name)
    if path.suffix not in (".txt", ".yaml", ".npz"):
        known = f"one of {', '.join(ORDER)}, a file .txt, .yaml or .npz, or a policy that plugins= brings"
        raise refuse("entry", name, known)
    label = f"entry={path}"
    try:
        data = read_file(path, _LARGEST)
        text = "" if path.suffix == ".npz" else data.decode("utf-8")
    except (InputError, OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{label}: {show(reason)}; accepted is a file .txt, .yaml or .npz") from None
    stem = _free(path.stem)
    if path.suffix == ".npz":
        return Entry(stem, stem, "", YOURS, hashlib.sha256(data).hexdigest(), path=path)
    try:
        if path.suffix == ".yaml":
            return _training(stem, text, YOURS)
        found = _list(stem, text, YOURS)
        found.decision_list()
        return found
    except InputError as error:
        raise InputError(f"{label}: {error}") from None


def chosen(said: str | None) -> list[Entry]:
    """The entries that `entry=a,b` means; the suite's own if nothing is said. Raises InputError."""
    if said is None:
        return list(shipped().values())
    return [entry_named(name) for name in dict.fromkeys(one.strip() for one in said.strip("[]").split(","))]


def _free(name: str) -> str:
    """The name if it can be that of a folder and of an entry of a user's. Raises InputError."""
    if not _NAME.match(name):
        raise refuse("entry", name, "a name of letters, digits, _ and -")
    if name in shipped():
        raise refuse("entry", name, "another name: the suite has an entry of this one")
    return name


def _list(name: str, text: str, of: str) -> Entry:
    """A decision list; a first line `# Title: what it does` says what it is called."""
    first = text.lstrip().splitlines()[0] if text.strip() else ""
    title, colon, about = first.lstrip("# ").partition(":")
    said = first.startswith("#") and bool(colon)
    digest = hashlib.sha256(text.encode()).hexdigest()
    title, about = (title[:_LONGEST], about.strip()) if said else (name, "")
    return Entry(name, title, about, of, digest, content=text)


def _training(name: str, text: str, of: str | None = None) -> Entry:
    """A search or the training of a network, by its settings. Raises InputError for anything else."""
    said = parse_yaml(text)
    network = isinstance(said, dict) and "algorithm" in said
    known = {"title", "about", "settings"} | ({"algorithm", "budget"} if network else {"train_worlds"})
    if not isinstance(said, dict) or set(said) - known or not isinstance(said.get("settings"), dict):
        raise InputError(
            "a training's configuration has title, about, settings and nothing else, settings a mapping; that of a "
            "search may have train_worlds, too, that of a network has algorithm and budget"
        )
    settings = flatten(said["settings"])
    title, about = str(said.get("title", name))[:_LONGEST], " ".join(str(said.get("about", "")).split())
    if network:
        how = _network(said, settings)
        digest = hashlib.sha256(repr((*how, sorted(settings.items()))).encode()).hexdigest()
        algorithm, budget = how
        return Entry(name, title, about, of or LEARNED, digest, text, settings, algorithm=algorithm, budget=budget)
    _check_search(settings)
    worlds = said.get("train_worlds", 1)
    if type(worlds) is not int or not 1 <= worlds <= _MOST_WORLDS:
        raise refuse("train_worlds", worlds, f"a whole number from 1 to {_MOST_WORLDS}")
    what = [*sorted(settings.items()), *([("train_worlds", worlds)] if worlds > 1 else [])]
    digest = hashlib.sha256(repr(what).encode()).hexdigest()
    return Entry(name, title, about, of or EVOLVED, digest, text, settings, worlds)


def _check_search(settings: Mapping[str, Any]) -> None:
    """Raise InputError unless an entry may set these."""
    paths = accepted_paths()
    for path in settings:
        if path not in paths:
            raise unknown_setting(path)
        if path in _OF_THE_SUITE or (paths[path][0] or path) not in _SECTIONS:
            raise refuse("settings", path, f"settings of {', '.join(_SECTIONS)}, but no budget: the suite gives it")


def _network(said: Mapping[str, Any], settings: Mapping[str, Any]) -> tuple[str, float]:
    """Algorithm and budget. Raises InputError; the settings themselves are checked where they are trained with."""
    algorithm, budget = said["algorithm"], said.get("budget", 1.0)
    if algorithm not in ALGORITHMS:
        raise refuse("algorithm", algorithm, f"one of {', '.join(ALGORITHMS)}")
    if type(budget) not in (int, float) or not 0 < budget <= 1:
        raise refuse("budget", budget, "a share of the suite's env-steps, above 0 and at most 1")
    for path in settings:
        if path in _OF_THE_SUITE:
            raise refuse("settings", path, f"settings of {algorithm} and network, but no {path}: the suite gives it")
    return algorithm, float(budget)


def artefact(entry: Entry, world: str, training: int, roots: Sequence[Path]) -> Path | None:
    """The file that a training of an entry left for a world, in the first folder that has it.

    Raises InputError naming a folder on the way that is a link.
    """
    for root in roots:
        path = root / "artefacts" / entry.name / world / f"training_{training}.npz"
        check_below(root, path.parent)
        if present(path):
            return path
    return None
