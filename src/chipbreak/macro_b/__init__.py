"""An interpreter for Fanuc custom macro B on a simple machine with a skip signal."""

from chipbreak.macro_b.interpreter import Interpreter, Outcome
from chipbreak.macro_b.machine import Barrier, Machine
from chipbreak.macro_b.programs import Library

__all__ = ["Barrier", "Interpreter", "Library", "Machine", "Outcome"]
