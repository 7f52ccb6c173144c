from slcs2_jax.running.usage import Usage


def test_shares_and_sums():
    one = Usage(compile_seconds=5, device_seconds=3, host_seconds=1, slot_steps=100, useful_steps=80)
    both = one + Usage(compile_seconds=1, device_seconds=6, host_seconds=0, slot_steps=100, useful_steps=100)
    assert (one.seconds, one.host_share, one.useful_share) == (9, 0.25, 0.8)
    assert (both.seconds, both.host_share, both.useful_share) == (16, 0.1, 0.9)


def test_nothing_done_has_no_shares():
    assert (Usage().seconds, Usage().host_share, Usage().useful_share) == (0, 0, 0)
