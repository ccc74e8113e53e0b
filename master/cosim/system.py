"""Components and the wires between their Real outputs and inputs; everything is checked before anything runs."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..base.errors import AeroSloshError
from ..fmi.component import Component
from .acceleration import Aitken
from .substeps import Pace, Stride

INITIAL_PASSES = 30
RENAMED = {"": "1", None: "1", "-": "1"}  # ways of writing "no unit"


@dataclass(frozen=True)
class Wire:
    """`source` and `target` are "component.variable"."""

    source: str
    target: str

    def __str__(self) -> str:
        return f"{self.source} -> {self.target}"


def wires(text: str | Iterable[str]) -> list[Wire]:
    """Wires from lines like "structure.alpha -> aero.alpha"."""
    found = []
    for line in text.strip().splitlines() if isinstance(text, str) else text:
        source, arrow, target = (part.strip() for part in line.partition("->"))
        if not arrow or source.count(".") < 1 or target.count(".") < 1:
            raise AeroSloshError(f"'{line.strip()}' is no wire", "wiring", "write: structure.alpha -> aero.alpha")
        found.append(Wire(source, target))
    return found


class System:
    """Components stepped in the order given, and their wires.

    paces       component → how it goes through a step (module `cosim/substeps`); others step once
    surrogates  component → a cheaper model with the same inputs and outputs that predicts its answer (`model_predictor`)
    values   all Real outputs of all components, one after the other. Shape: (n_outputs,)
    lagged   positions in `wires` whose source is stepped after (or is) the target: the schemes must predict these
    loops    each algebraic loop found, as the names along it (direct feed-through by the model descriptions)
    Raises AeroSloshError when a wire's ends do not exist, do not fit, or an input is wired twice."""

    def __init__(
        self,
        components: Sequence[Component],
        connections: Sequence[Wire],
        paces: Mapping[str, Pace] | None = None,
        surrogates: Mapping[str, Component] | None = None,
    ) -> None:
        self.components = list(components)
        self.surrogates = dict(surrogates or {})
        names = [c.name for c in self.everyone]
        if len(set(names)) != len(names):
            raise AeroSloshError(f"Two components have the same name: {names}", "system", "name each component once")
        self._by_name = {c.name: c for c in components}
        self.wires = list(connections)
        self._check()
        self.place = {c.name: i for i, c in enumerate(components)}
        offsets = np.cumsum([0] + [len(c.outputs.names) for c in components])
        self._slices = [slice(offsets[i], offsets[i + 1]) for i in range(len(components))]
        self.values = np.zeros(int(offsets[-1]))
        sources = [self._ends(wire)[0] for wire in self.wires]
        targets = [self._ends(wire)[1] for wire in self.wires]
        at = [offsets[self.place[a]] + self._by_name[a].output_index[x] for a, x in sources]
        self.source = np.array(at, dtype=np.intp)  # position in `values`
        lagged = [self.place[a] >= self.place[b] for (a, _), (b, _) in zip(sources, targets, strict=True)]
        self.lagged = [k for k, late in enumerate(lagged) if late]
        self.lagged_array = np.array(self.lagged, dtype=np.intp)
        self._incoming = []  # per component: wires, input positions
        self._fresh = []  # per component: wires it feeds whose targets are stepped later in the pass
        for component in components:
            mine = [k for k, (b, _) in enumerate(targets) if b == component.name]
            inputs = [component.input_index[targets[k][1]] for k in mine]
            self._incoming.append((np.array(mine, dtype=np.intp), np.array(inputs, dtype=np.intp)))
            mine = [k for k, (a, _) in enumerate(sources) if a == component.name and not lagged[k]]
            self._fresh.append(np.array(mine, dtype=np.intp))
        self.strides = [Stride(c, (paces or {}).get(c.name, Pace())) for c in components]
        self._waves = any(stride.pace.waveform != "hold" for stride in self.strides)
        self.loops = self._find_loops()
        self.initial_change = 0.0

    def __getitem__(self, name: str) -> Component:
        return self._by_name[name]

    @property
    def everyone(self) -> list[Component]:
        """Components and surrogates."""
        return [*self.components, *self.surrogates.values()]

    def initialize(self, start_time: float = 0.0) -> None:
        """Initialise every component not yet initialised, with consistent initial inputs along the wires.

        Components already initialised keep their state. The exchange is repeated until it settles, which also
        solves algebraic loops at the start (Aitken's relaxation); `initial_change` tells how well."""
        fresh = [c for c in self.components if c.state == "instantiated"]
        for component in fresh:
            component.enter_initialization(start_time)
        lagged, relaxation = self.lagged_array, Aitken()
        self.collect()
        for component in fresh:  # a parameter refused: say so before its outputs, not numbers, make another one fail
            component.check("fmi2EnterInitializationMode")
        carried = self.wire_values()
        for _ in range(INITIAL_PASSES if fresh else 0):
            for i, component in enumerate(self.components):
                self.collect()
                now = self.wire_values()
                now[lagged] = carried[lagged]
                self.feed(i, now)
                if component in fresh:
                    component.inputs.set()
            self.collect()
            change = self.wire_values()[lagged] - carried[lagged]
            size = np.maximum(np.abs(carried[lagged]), np.abs(change))
            size = np.where(size > 0.0, size, 1.0)
            self.initial_change = float(np.max(np.abs(change) / size, initial=0.0))
            if self.initial_change <= 1e-12:
                break
            carried[lagged] = relaxation.next(carried[lagged], change, np.ones(lagged.size))
        for component in fresh:
            component.exit_initialization()
        self.collect()
        for i in range(len(self.components)):
            self.feed(i, self.wire_values())
        for name, surrogate in self.surrogates.items():
            if surrogate.state == "instantiated":
                surrogate.enter_initialization(start_time)
                self.feed_surrogate(name, self.wire_values())
                surrogate.inputs.set()
                surrogate.exit_initialization()
        for stride in self.strides:
            stride.reset()

    def output_names(self) -> list[str]:
        """ "component.output" in the order of `values`."""
        return [f"{c.name}.{name}" for c in self.components for name in c.outputs.names]

    def collect(self) -> None:
        """Read the outputs of all components into `values`."""
        for component, part in zip(self.components, self._slices, strict=True):
            component.outputs.get()
            self.values[part] = component.outputs.values

    def wire_values(self) -> np.ndarray:
        """What each wire carries now. Shape: (n_wires,)."""
        return self.values[self.source]

    def feed(self, i: int, carried: np.ndarray) -> None:
        """Put `carried` (one value a wire) into the input buffer of component `i`."""
        mine, inputs = self._incoming[i]
        self.components[i].inputs.values[inputs] = carried[mine]

    def feed_surrogate(self, name: str, carried: np.ndarray) -> None:
        """Put `carried` into the inputs of the surrogate of component `name`: those by the same names."""
        surrogate, main = self.surrogates[name], self._by_name[name]
        mine, inputs = self._incoming[self.place[name]]
        for k, position in zip(mine, inputs, strict=True):
            surrogate.inputs.values[surrogate.input_index[main.inputs.names[position]]] = carried[k]

    def begin_step(self, dt: float) -> None:
        """A communication step of `dt` [s] begins: the components' inputs start from what the wires carry now."""
        if not self._waves:
            return
        carried = self.wire_values()
        for i, stride in enumerate(self.strides):
            self.feed(i, carried)
            stride.begin(self.components[i].inputs.values, dt)

    def one_pass(self, carried: np.ndarray, dt: float) -> None:
        """Step every component in order; `carried` holds the assumed values of the lagged wires. Others are fresh."""
        now = carried.copy()
        for i in range(len(self.components)):
            self.feed(i, now)
            self.step_component(i, dt)
            fresh = self._fresh[i]
            if fresh.size:
                now[fresh] = self.values[self.source[fresh]]

    def step_component(self, i: int, dt: float) -> None:
        """Step component `i` with the inputs fed, and take its outputs into `values`."""
        self.strides[i].step(dt)
        self.take(i)

    def take(self, i: int) -> None:
        """The outputs of component `i`, as read last, into `values`."""
        self.values[self._slices[i]] = self.components[i].outputs.values

    def close(self) -> None:
        """Free all instances."""
        for component in self.everyone:
            component.close()

    # checks

    def _ends(self, wire: Wire) -> tuple[tuple[str, str], tuple[str, str]]:
        a, _, x = wire.source.partition(".")
        b, _, y = wire.target.partition(".")
        return (a, x), (b, y)

    def _check(self) -> None:
        wired: dict[str, Wire] = {}
        for wire in self.wires:
            for end, causality in zip(self._ends(wire), ("output", "input"), strict=True):
                self._check_end(wire, end, causality)
            (a, x), (b, y) = self._ends(wire)
            here, there = self._by_name[a].variables[x], self._by_name[b].variables[y]
            units = [RENAMED.get(v.unit, v.unit) for v in (here, there)]
            if units[0] != units[1]:
                raise AeroSloshError(
                    f"Units differ: {wire.source} is in {units[0]}, {wire.target} in {units[1]}",
                    f"wire {wire}",
                    "wire variables of the same unit; the master converts nothing silently",
                )
            if wire.target in wired:
                raise AeroSloshError(
                    f"Input {wire.target} is wired twice",
                    f"wires {wired[wire.target]} and {wire}",
                    "keep one of them",
                )
            wired[wire.target] = wire
        self._check_surrogates()

    def _check_surrogates(self) -> None:
        for name, surrogate in self.surrogates.items():
            if name not in self._by_name:
                raise AeroSloshError(
                    f"'{surrogate.name}' predicts '{name}', which is no component",
                    "system",
                    f"components are: {', '.join(self._by_name)}",
                )
            ends = [self._ends(wire) for wire in self.wires]
            lacks = [y for _, (b, y) in ends if b == name and y not in surrogate.input_index]
            lacks += [x for (a, x), _ in ends if a == name and x not in surrogate.output_index]
            if lacks:
                raise AeroSloshError(
                    f"'{surrogate.name}' cannot predict '{name}': it has no Real {', '.join(dict.fromkeys(lacks))}",
                    surrogate.path.name,
                    "a predicting model has the wired inputs and outputs of the model it stands for",
                )

    def _check_end(self, wire: Wire, end: tuple[str, str], causality: str) -> None:
        component, variable = end
        if component not in self._by_name:
            raise AeroSloshError(
                f"There is no component '{component}'",
                f"wire {wire}",
                f"components are: {', '.join(self._by_name)}",
            )
        known = self._by_name[component].variables
        if variable not in known:
            close = difflib.get_close_matches(variable, list(known), n=1)
            hint = f"did you mean '{close[0]}'? " if close else ""
            names = ", ".join(n for n, v in known.items() if v.causality == causality)
            raise AeroSloshError(
                f"{component} has no variable '{variable}'",
                f"wire {wire}",
                f"{hint}({causality}s are: {names})",
            )
        actual = known[variable].causality
        if actual != causality:
            article = "an" if actual in ("input", "output") else "a"
            raise AeroSloshError(
                f"{component}.{variable} is {article} {actual}, not an {causality}",
                f"wire {wire}",
                "a wire goes from an output to an input",
            )
        if known[variable].type != "Real":
            raise AeroSloshError(
                f"{component}.{variable} is of type {known[variable].type}",
                f"wire {wire}",
                "wires carry Real variables",
            )

    def _find_loops(self) -> list[list[str]]:
        """Loops of direct feed-through: wires, and input → output where the model structure does not rule it out."""
        edges: dict[str, list[str]] = {}
        for wire in self.wires:
            edges.setdefault(wire.source, []).append(wire.target)
        for component in self.components:
            for unknown in component.description.outputs:
                # without a list an output depends on everything (FMI 2.0, section 2.2.8)
                known = component.variables.values() if unknown.dependencies is None else unknown.dependencies
                for dependency in known:
                    if dependency.causality == "input":
                        start = f"{component.name}.{dependency.name}"
                        edges.setdefault(start, []).append(f"{component.name}.{unknown.variable.name}")
        return [members for members in _strongly_connected(edges) if len(members) > 1]


def _strongly_connected(edges: dict[str, list[str]]) -> list[list[str]]:
    """Tarjan's algorithm (SIAM J. Comput. 1(2), 1972, doi 10.1137/0201010), recursive: systems are small."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in edges.get(node, []):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            members = []
            while True:
                members.append(stack.pop())
                if members[-1] == node:
                    break
            found.append(members[::-1])

    for node in list(edges):
        if node not in index:
            visit(node)
    return found
