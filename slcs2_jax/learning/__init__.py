"""Networks that learn: IPPO in the environment, and an evolution strategy through the evaluator.

    from slcs2_jax.learning import ippo

    worlds = [(settings, range(32))]
    policy = ippo.train(ippo.Ippo(), worlds, seed=0, budget_env_steps=1_000_000, folder="runs/ippo")

Both return a policy to deploy like any other, and go on exactly where they were stopped.
"""
