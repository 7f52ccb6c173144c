"""What a choice of conf/ sets, for settings made in Python: the same as on the command line."""

from __future__ import annotations

from dataclasses import replace

from slcs2_jax.config.conf import choices, groups
from slcs2_jax.config.schema import accepted_paths, flatten
from slcs2_jax.config.settings import Settings


def with_search(settings: Settings, name: str) -> Settings:
    """The settings with the search of this name and the parts that go with it, as `search=NAME` chooses them.

    What conf/search/NAME.yaml says takes the place of what the settings have (`informed` brings knowledge, racing, a
    population, ...); everything else stays. To leave a part out, replace it afterwards. A name without such a file is
    that of a search alone, for instance one that a plug-in registered.

    Raises InputError: what the settings have does not go with that search, or there is none of this name.
    """
    if name not in groups()["search"]:
        return replace(settings, search=replace(settings.search, name=name))
    paths, values = accepted_paths(), flatten(choices("search", (name,))[name])
    by_section: dict[str, dict[str, object]] = {}
    for path, value in values.items():
        section, attribute = paths[path]
        by_section.setdefault(section, {})[attribute] = value
    changed = {section: replace(getattr(settings, section), **own) for section, own in by_section.items()}
    return replace(settings, **changed)
