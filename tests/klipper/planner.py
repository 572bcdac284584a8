"""Runs moves through Klipper's planner and prints how long each takes; a program of its own, see install.sh.

The first argument is the folder of the unpacked package.  On stdin stands one JSON object a line: limits,
``start`` and ``moves`` (x, y, z, speed [mm/s]); for each one a line of times [s] comes back.
"""

from __future__ import annotations

import importlib
import json
import sys
import types
from pathlib import Path
from typing import Any


def planner_of(folder: str) -> Any:
    """The module, with empty ones in place of those that talk to a machine."""
    package = types.ModuleType("klippy")
    package.__path__ = [str(Path(folder) / "klippy")]
    sys.modules["klippy"] = package
    for name in ("mcu", "chelper", "kinematics", "kinematics.extruder"):
        stub = types.ModuleType(f"klippy.{name}")
        stub.__path__ = []
        sys.modules[f"klippy.{name}"] = stub
    sys.modules["klippy.kinematics"].extruder = sys.modules["klippy.kinematics.extruder"]  # type: ignore[attr-defined]
    return importlib.import_module("klippy.toolhead")


class Head:
    """What the planner asks of a tool head, for a machine with axes at right angles."""

    def __init__(self, limits: dict[str, float]) -> None:
        self.max_velocity = limits["max_velocity"]
        self.max_accel = limits["max_accel"]
        self.junction_deviation = limits["corner_velocity"] ** 2 * (2.0**0.5 - 1.0) / self.max_accel
        self.max_accel_to_decel = self.max_accel * (1.0 - limits["min_cruise_ratio"])
        self.extruder = self
        self.done: list[Any] = []

    def calc_junction(self, before: Any, move: Any) -> float:
        """Nothing is extruded, so nothing limits a corner."""
        return 1e18

    def _process_moves(self, moves: list[Any]) -> None:
        self.done += moves


def times(planner: Any, asked: dict[str, Any]) -> list[float]:
    """How long each move takes."""
    head = Head(asked)
    queue = planner.MoveQueue(head)
    place = [*asked["start"], 0.0]
    for x, y, z, speed in asked["moves"]:
        move = planner.Move(head, place, [x, y, z, 0.0], speed)
        if move.axes_d[2]:
            ratio = move.move_d / abs(move.axes_d[2])
            move.limit_speed(asked["max_z_velocity"] * ratio, asked["max_z_accel"] * ratio)
        place = [x, y, z, 0.0]
        queue.add_move(move)
    queue.flush()
    return [move.accel_t + move.cruise_t + move.decel_t for move in head.done]


if __name__ == "__main__":
    klippy = planner_of(sys.argv[1])
    for line in sys.stdin:
        print(json.dumps(times(klippy, json.loads(line))))
