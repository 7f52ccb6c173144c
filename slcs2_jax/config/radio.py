"""The radio's settings: propagation, fading, reception and noise (docs/model.md), with reasons and limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from slcs2_jax.config.errors import refuse
from slcs2_jax.config.field import LEAST, Section, setting
from slcs2_jax.config.registry import KINDS

CALIBRATED = "first values that bring results to the paper's magnitude"


@dataclass(frozen=True)
class Radio(Section):
    """Propagation, reception and noise (docs/model.md)."""

    SECTION: ClassVar[str] = "radio"

    channels: tuple[int, ...] = setting(
        (1, 6, 11),
        "numbers of the channels, none of which disturbs another, in the order in which a jammer scans them",
        status="paper",
        fewest=1,
        most=14,
        distinct=True,
        low=1,
        high=14,
    )
    power_dbm: float = setting(
        20.0,
        "P_t, full transmission power, the jammer's too",
        unit="dBm",
        reason="100 mW, the 2.4 GHz EIRP limit",
        low=-200,
        high=200,
    )
    half_power_db: float = setting(
        -3.01, "half power relative to full power", unit="dB", reason="half in linear units", low=-100, high=0
    )
    reference_distance: float = setting(
        1.0, "d0, reference distance of the path loss", unit="m", reason="usual choice", low=LEAST, high=1e4
    )
    reference_loss_db: float = setting(
        40.05,
        "PL0, path loss at the reference distance",
        unit="dB",
        reason="Friis at 2.4 GHz and 1 m",
        low=-200,
        high=200,
    )
    propagation: str = setting(
        "log_distance", "mean received power over distance and walls", status="paper", part="propagation"
    )
    path_loss_exponent: float = setting(
        2.8,
        "gamma, path-loss exponent",
        status="calibrated",
        reason="ns-3's default is 3.0, UAV measurements give 2.0-3.0; " + CALIBRATED,
        low=LEAST,
        high=10,
    )
    fading: str = setting(
        "lognormal", "how received power varies, drawn per link and step", status="paper", part="fading"
    )
    shadowing_db: float = setting(
        4.0,
        "lognormal: sigma of the shadowing, drawn per link and step",
        unit="dB",
        reason="UAV measurements give 2.8-5.3 dB",
        low=0,
        high=20,
    )
    rician_k: float = setting(
        10.0,
        "rician: K, power of the direct path over that of the scattered ones; a ratio, 0 is Rayleigh fading",
        reason="10 dB, a usual value between vehicles in the air and the ground",
        low=0,
        high=1e6,
    )
    nakagami_m: float = setting(
        3.0,
        "nakagami: m, shape; 1 is Rayleigh fading, more is steadier",
        reason="ns-3's default below 80 m is 1.5; more direct paths in the air",
        low=0.5,
        high=1e4,
    )
    wall_loss_db: float = setting(
        2.0,
        "L_w, loss per crossed wall",
        unit="dB",
        status="calibrated",
        reason="ns-3: internal wall 5, wood 4; " + CALIBRATED,
        low=0,
        high=200,
    )
    noise_dbm: float = setting(
        -94.0, "thermal noise", unit="dBm", reason="-174 + 10 log10(20 MHz) + 7 dB noise figure", low=-200, high=200
    )
    receive_threshold_dbm: float = setting(
        -82.0,
        "P_rs, weakest signal that is received",
        unit="dBm",
        reason="802.11 clear channel assessment at 20 MHz",
        low=-200,
        high=200,
    )
    sinr_threshold_db: float = setting(
        10.0, "least signal to interference and noise", unit="dB", reason="ns-2's capture threshold", low=-100, high=100
    )

    @property
    def network_range(self) -> float:
        """net (m): the distance at which the mean received power equals P_rs (docs/model.md)."""
        if self.propagation == "log_distance":
            return log_distance_reach(self)
        return float(KINDS["propagation"].get(self.propagation).reach(self))

    def cross_check(self) -> None:
        try:
            usable = 0 < self.network_range < 1e7
        except OverflowError:
            usable = False
        if not usable:
            raise refuse(
                "radio.path_loss_exponent",
                self.path_loss_exponent,
                "a value that gives a network range below 10000 km with the radio's powers",
            )


def log_distance_reach(radio: Any, power_dbm: Any = None, level_dbm: Any = None) -> Any:
    """Distance, m, at which the mean power received by log-distance path loss without walls is at a level.

    Args:
        radio: a `Radio`, or anything with its attributes, be they numbers or traced arrays.
        power_dbm: of the sender, dBm; default the radio's full power.
        level_dbm: dBm; default P_rs.
    """
    power = radio.power_dbm if power_dbm is None else power_dbm
    level = radio.receive_threshold_dbm if level_dbm is None else level_dbm
    exponent = (power - radio.reference_loss_db - level) / (10 * radio.path_loss_exponent)
    return radio.reference_distance * 10.0**exponent
