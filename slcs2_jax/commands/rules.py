"""slcs2 rules: what each agent's behaviour says, how it acted, and where its rules came from."""

from __future__ import annotations

from typing import Any

from slcs2_jax.commands.looked_at import look_at, new_file, one_of, subject_and_options
from slcs2_jax.config.escape import terminal
from slcs2_jax.config.field import refuse

TAKES_SETTINGS = False
HELP = """\
slcs2 rules RUN [option=value ...]: the rules of a solution in words; RUN is a run folder or a saved solution (.npz)
slcs2 rules swarm=NAME [...]: of an evolved swarm that comes with slcs2, such as long_urban

For each rule q, zeta, eps and tau; in how many steps of a replay it matched and was chosen; and where it came from.
Then what each agent did most, and which rules exchange spread through the swarm.

  instance=0          of the run
  member=best         best, or the number of a member of the collection
  agent=all           all, or one agent
  top=10              rules of each agent that the text shows; 0: all
  sort=strength       strength, use or quality: the greatest first
  replay=on           off computes no episode; matched and chosen are then unknown
  deployment=0        which of the fresh deployments in the solution's own world is replayed
  format=text         text, csv (a row for each rule) or json (everything)
  out=FILE            a new file; without it, the terminal
"""
_DEFAULTS: dict[str, Any] = {
    "instance": 0,
    "member": "best",
    "agent": "all",
    "top": 10,
    "sort": "strength",
    "replay": True,
    "deployment": 0,
    "format": "text",
    "out": None,
}
OPTIONS = tuple(_DEFAULTS)


def run(arguments: list[str]) -> int:
    """Show the rules that the arguments ask for."""
    path, options = subject_and_options("rules", arguments, _DEFAULTS)
    from slcs2_jax.looking.rulebook import SORTS, rule_lines, spread_rules
    from slcs2_jax.looking.rules_text import Rulebook

    one_of("sort", options["sort"], tuple(SORTS))
    form = one_of("format", options["format"], ("text", "csv", "json"))
    out = new_file(options["out"])
    solution = look_at(path, options["instance"], options["member"])
    agent = _agent(options["agent"], solution.agents)
    recording = None
    if options["replay"]:
        from slcs2_jax.looking.solutions import replay

        recording = replay(solution, deployment=options["deployment"])
    lines = rule_lines(solution, recording, options["sort"])
    book = Rulebook(
        solution=solution,
        lines=[line for line in lines if agent is None or line.agent == agent],
        spread=spread_rules(solution),
        replay_fitness=None if recording is None else recording.fitness,
        steps=None if recording is None else recording.steps,
    )
    text = book.text(options["top"]) if form == "text" else book.csv() if form == "csv" else book.json()
    if out is None:
        print(text, end="", flush=True)
    else:
        from slcs2_jax.results.files import write_text

        write_text(out, text)
        print(f"rules {terminal(str(out))}", flush=True)
    return 0


def _agent(said: str, agents: int) -> int | None:
    if said == "all":
        return None
    if not (said.isascii() and said.isdecimal() and int(said) < agents):
        raise refuse("agent", said, f"all, or a number from 0 to {agents - 1}")
    return int(said)
