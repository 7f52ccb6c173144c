"""Configuration: typed, validated, documented settings. Importing this does not start JAX."""

from slcs2_jax.config.errors import InputError, StorageError
from slcs2_jax.config.jammers import Jammers
from slcs2_jax.config.knowledge import Knowledge
from slcs2_jax.config.model import Learning, Rules, Swarm, Task, World
from slcs2_jax.config.radio import Radio
from slcs2_jax.config.schema import settings_from, settings_to_dict
from slcs2_jax.config.settings import Checkpoint, Compute, Search, Settings
from slcs2_jax.config.table import Row, settings_table

__all__ = [
    "Checkpoint",
    "Compute",
    "InputError",
    "Jammers",
    "Knowledge",
    "Learning",
    "Radio",
    "Row",
    "Rules",
    "Search",
    "Settings",
    "StorageError",
    "Swarm",
    "Task",
    "World",
    "settings_from",
    "settings_table",
    "settings_to_dict",
]
