"""policy= of the command line: the designed behaviour, a user's decision list, a saved policy, or a plug-in's."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from slcs2_jax.running.deployable import Deployable


_LARGEST = 2**30  # bytes of a policy file, which was read before


class NamedPolicy(NamedTuple):
    """A policy that the command line names.

    title: as a person reads it. content: what it is now, to be held to later: a list's text, or a file's SHA-256; ""
    for a plug-in's, whose source a run records anyway.
    """

    title: str
    policy: Deployable
    content: str


def policy_named(name: str) -> NamedPolicy:
    """What policy=NAME stands for. Raises InputError if there is none such, or naming a damaged file."""
    from slcs2_jax.config.door import read_file
    from slcs2_jax.config.registry import KINDS
    from slcs2_jax.policy.bound import bind, load_bound
    from slcs2_jax.policy.decision_list import load_decision_list

    if name in KINDS["policy"].own():
        return NamedPolicy(name, bind(name, ()), "")
    if Path(name).suffix == ".npz":
        policy, _ = load_bound(name)
        digest = hashlib.sha256(read_file(Path(name), _LARGEST)).hexdigest()
        return NamedPolicy(Path(name).stem, policy, digest)
    decisions = load_decision_list(name)
    return NamedPolicy(Path(name).stem, decisions, decisions.text)
