"""What a run folder has to show: solutions, of a run under way those of its last checkpoint; and episodes of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from slcs2_jax import runtime
from slcs2_jax.config import InputError, Settings
from slcs2_jax.config.arguments import of_kind, whole
from slcs2_jax.config.field import refuse, show
from slcs2_jax.config.worlds import home_of
from slcs2_jax.looking.recorder import record
from slcs2_jax.looking.recording import Recording
from slcs2_jax.results import FinishedRun, SavedSolution
from slcs2_jax.running.deployable import Deployable, bound
from slcs2_jax.running.evaluator import MOST_DEPLOYMENTS
from slcs2_jax.running.solutions import saved_last
from slcs2_jax.search.keys import fresh_deployment_key
from slcs2_jax.world.scenario import make_scenario


def best_of(run: FinishedRun, instance: int) -> SavedSolution:
    """The best solution of an instance; of a run under way, the best when it was last saved.

    Raises InputError: no such instance, nothing saved yet, or a damaged file.
    """
    if run.summary is not None:
        return run.best(instance)
    best, _ = saved_last(run, instance)
    if best is None:
        raise InputError(f"run={show(str(run.path))}: nothing was saved yet of instance {instance}; look again later")
    return best


def members_of(run: FinishedRun, instance: int) -> list[SavedSolution]:
    """The collection of an instance, the oldest member first; of a run under way, when it was last saved.

    Raises InputError: no such instance, or a damaged file.
    """
    return run.members(instance) if run.summary is not None else saved_last(run, instance)[1]


def member_of(run: FinishedRun, instance: int, member: str) -> SavedSolution:
    """`best`, or a member of the collection by its number. Raises InputError if there is none such."""
    if member == "best":
        return best_of(run, instance)
    found = members_of(run, instance)
    if not (member.isascii() and member.isdecimal() and int(member) < len(found)):
        raise refuse("member", member, f"best, or a number from 0 to {len(found) - 1}" if found else "best")
    return found[int(member)]


def replay(
    policy: Deployable,
    settings: Settings | None = None,
    *,
    seed: int | None = None,
    deployment: int = 0,
    steps: int | None = None,
    after_chunk: Callable[[int], None] = lambda steps: None,
) -> Recording:
    """A fresh deployment of a policy, recorded.

    Args:
        policy: what is deployed: a saved solution, or whatever else `deploy` takes.
        settings: those of the world; by default those that a saved solution evolved with.
        seed: of the scenario; by default that of the instance that a saved solution evolved in, else that of the
            settings. Of settings with many worlds it is that of the search, and the deployment's world is shown.
        deployment: which; the winner's fresh figures are means over the first `search.fresh_deployments` of these.
        steps: how many are needed of the episode; None: all.
        after_chunk: told now and then how many steps were computed.

    Raises:
        InputError: an argument of another kind, or an impossible setting.
    """
    if settings is None:
        settings = of_kind("solution", policy, SavedSolution).settings
    settings = of_kind("settings", settings, Settings)
    ready = bound(policy, settings)
    if seed is None:
        seed = policy.instance_seed if isinstance(policy, SavedSolution) else settings.seed
    deployment = whole("deployment", deployment, 0, MOST_DEPLOYMENTS)
    key = fresh_deployment_key(seed, deployment)
    settings, seed = home_of(settings, seed, deployment)
    scenario = make_scenario(settings, seed)
    runtime.configure(settings.compute)
    return record(settings, scenario, ready, key, steps=steps, after_chunk=after_chunk)


def animate(
    recordings: Recording | Mapping[str, Recording],
    out: str | Path,
    *,
    start: int = 0,
    end: int | None = None,
    every: int | None = None,
    fps: int = 20,
) -> Path:
    """Draw what was recorded as an animation, as `slcs2 replay` does; a file of that name is replaced.

    Args:
        recordings: an episode of `replay`; or several of one world, by title, one above the other by the same clock.
        out: the file, .gif, or .mp4 if there is ffmpeg.
        start, end: first and last moment, time-steps; by default the whole of the longest.
        every: time-steps from frame to frame; by default so that there are about 300 frames.
        fps: frames per second.

    Returns:
        The file.

    Raises:
        InputError: an argument that is not accepted, or matplotlib or Pillow is not installed.
    """
    try:
        from slcs2_jax.looking import animation
    except ImportError as error:
        raise InputError(
            f"animate: {error.name} is not installed; accepted is an installation with slcs2_jax[plot]"
        ) from None
    named = recordings if isinstance(recordings, Mapping) else {"": recordings}
    shown = [of_kind("recordings", one, Recording) for one in named.values()]
    if not shown:
        raise InputError("recordings: none given; at least one is required")
    file, steps = Path(out), max(one.steps for one in shown)
    if file.suffix not in animation.SUFFIXES:
        raise refuse("out", str(file), "a file whose name ends in " + " or ".join(animation.SUFFIXES))
    end = whole("end", steps if end is None else end, 1, steps)
    start = whole("start", start, 0, end - 1)
    every = animation.usual_stride(end - start) if every is None else whole("every", every, 1, end)
    animation.check_frames(end - start, every)
    fps = whole("fps", fps, 1, animation.MOST_FPS)
    animation.animate(shown, list(named), file, start=start, end=end, every=every, fps=fps)
    return file
