"""A face that fails on demand, to see what a host sees."""

from __future__ import annotations

import math
import sys

import numpy as np

from ..kit.slave import Slave
from ..kit.variables import choice, input_, output, parameter

MODES = ("none", "raise", "exit", "nan", "initialize", "save", "restore", "unsavable", "long", "half a character")


class Faulty(Slave):
    """Adds up its input, or fails in the way that `fault` asks for."""

    variables = (
        choice("fault", "none", {mode: mode for mode in MODES}, "How to fail"),
        parameter("gain", 2.0, "1", "Factor of the input", min=0.5, max=4.0),
        parameter("count", 3, "", "An integer with a range", min=1, max=5),
        parameter("label", "text", "", "A string"),
        input_("u", 0.0, "m", "What is added up"),
        output("y", "m", "Sum", depends=("gain",)),
    )

    @property
    def mode(self) -> str:
        """Name of the fault."""
        return MODES[self.fault]

    def initialize(self) -> None:
        """Start, or fail."""
        self.history = np.zeros(1)
        self.y = 0.0
        if self.mode == "initialize":
            raise ValueError("no start is possible. Remedy: another fault")

    def step(self, time: float, step_size: float) -> None:
        """Add, or fail."""
        if self.mode == "raise":
            raise ZeroDivisionError("100 % forced: %s %n")
        if self.mode == "exit":
            sys.exit(3)
        if self.mode == "long":
            raise RuntimeError("long " * 4000)
        if self.mode == "half a character":  # as in the name of a file that is not UTF-8
            raise RuntimeError("no such file: caf\udce9.dat")
        self.history = np.append(self.history, self.gain * self.u)
        self.y = math.nan if self.mode == "nan" else float(self.history.sum())

    def save(self) -> dict[str, object]:
        """Return the history."""
        if self.mode == "save":
            raise RuntimeError("cannot save")
        return {"history": {1, 2} if self.mode == "unsavable" else self.history}

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        """Take back the history."""
        if self.mode == "restore":
            raise RuntimeError("cannot restore")
        self.history = snapshot["history"]
