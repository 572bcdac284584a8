"""An interpreter for Fanuc custom macro B on a simple machine with a skip signal."""

from macro_interpreter.controls import CONTROLS, FANUC_0I_F, FanucControl
from macro_interpreter.interpreter import Interpreter, Outcome
from macro_interpreter.machine import Barrier, Machine
from macro_interpreter.programs import Library

__all__ = [
    "CONTROLS",
    "FANUC_0I_F",
    "Barrier",
    "FanucControl",
    "Interpreter",
    "Library",
    "Machine",
    "Outcome",
]
