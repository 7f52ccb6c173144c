"""Received powers by ns-3's propagation models, in a process of its own: JSON in, JSON out.

In: `places` [[x, y], ...] m, `power_dbm`, `exponent`, `reference_loss_db`, `extra_db` [[...]] of each pair (walls).
Out: `dbm` [sender][receiver], null on the diagonal; `mw` the same in ns-3's own conversion.
"""

from __future__ import annotations

import json
import sys

from ns import ns


def main() -> None:
    said = json.load(sys.stdin)
    nodes = []
    for x, y in said["places"]:
        node = ns.CreateObject[ns.ConstantPositionMobilityModel]()
        node.SetPosition(ns.Vector(x, y, 0.0))
        nodes.append(node)
    distance = ns.CreateObject[ns.LogDistancePropagationLossModel]()
    distance.SetPathLossExponent(said["exponent"])
    distance.SetReference(1.0, said["reference_loss_db"])
    walls = ns.CreateObject[ns.MatrixPropagationLossModel]()
    walls.SetDefaultLoss(0.0)
    for a, row in enumerate(said["extra_db"]):
        for b, loss in enumerate(row):
            if a != b:
                walls.SetLoss(nodes[a], nodes[b], loss, False)
    distance.SetNext(walls)
    dbm = [[None if a is b else distance.CalcRxPower(said["power_dbm"], a, b) for b in nodes] for a in nodes]
    mw = [[None if value is None else 1000 * ns.DbmToW(value) for value in row] for row in dbm]
    json.dump({"dbm": dbm, "mw": mw}, sys.stdout)


if __name__ == "__main__":
    main()
