"""A world of your own from a file: a street with a courtyard, a jammer on patrol, and where the agents start.

python examples/own_world.py                                    # from Python
slcs2 evaluate policy=designed world=street.yaml instances=4    # from the command line, with the file beside it
"""

import slcs2_jax as slcs2

STREET = """\
sink: [400, 0]              # m; the source is the origin
time_limit: 8000
walls:
  - {from: [100, -60], to: [100, -15]}        # a segment along an axis
  - {from: [100, 15], to: [100, 60]}
  - {corner: [220, -40], opposite: [260, 25]}  # a rectangle: its four sides
jammers:
  - {place: [330, 40], motion: patrol, route: [[330, -40]], speed: 1.0, power_db: -10}
starts: [[10, 0], [0, 10], [-10, 0], [0, -10], [10, 10], [-10, -10], [20, 0], [0, 20]]
"""


def main():
    """Deploy the designed behaviour in the street, and see who hears whom at the end of an episode."""
    with open("street.yaml", "w", encoding="utf-8") as file:
        file.write(STREET)
    world, swarm = slcs2.World.from_file("street.yaml"), slcs2.Swarm(agents=8, packets=40)
    settings = slcs2.Settings(world=world, swarm=swarm, instances=4)
    designed = slcs2.load_decision_list("designed")
    summary = slcs2.evaluate(settings, designed, deployments=2)
    for scenario in summary.scenarios:
        print(f"seed {scenario.seed}: fitness {scenario.fitness:.3f}, {scenario.delivered:.1f} of 40 packets")
    episode = slcs2.replay(designed, settings)
    heard = episode.neighbours(episode.steps - 1)
    print(f"{episode.steps} steps; at the end {int(heard[episode.sink].sum())} of 8 agents hear the sink")


if __name__ == "__main__":
    main()
