"""Options of the commands that compose their settings with Hydra."""

from __future__ import annotations

from collections.abc import Sequence

from slcs2_jax.config.errors import InputError
from slcs2_jax.config.field import refuse


def check_options(arguments: Sequence[str]) -> None:
    """Refuse in one line what Hydra's parser would refuse in many. Raises InputError."""
    from slcs2_jax.config.compose import CFG_VALUES, FLAGS, FLAGS_WITH_VALUE, is_sweep

    rest = list(arguments)
    while rest:
        argument = rest.pop(0)
        if argument in FLAGS_WITH_VALUE:
            if not rest or rest[0].startswith("-"):
                raise InputError(f"option {argument}: accepted is {argument} VALUE")
            value = rest.pop(0)
            if argument in ("-c", "--cfg"):
                if value not in CFG_VALUES:
                    raise refuse(f"option {argument}", value, "one of " + ", ".join(CFG_VALUES))
                if is_sweep(arguments):
                    raise InputError(f"option {argument}: not together with -m; accepted is one of the two")
        elif argument.startswith("-") and argument not in FLAGS:
            raise refuse("option", argument, "one of -m, --cfg job, --config-dir DIR, --help")
