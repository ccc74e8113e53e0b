"""Base of the test doubles: plain pythonfmu slaves, guarded by hand, with units and full state."""

import copy
import pickle
import sys
import traceback
from xml.etree.ElementTree import Element, SubElement

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String
from pythonfmu.enums import Fmi2Status

TYPES = {"Real": Real, "Integer": Integer, "Boolean": Boolean, "String": String}


def pin(script_globals):
    """Keep the script's module alive: pythonfmu drops one reference of it at each instantiation."""
    sys.__dict__.setdefault("_fmu_pins", []).append(script_globals)


class Double(Fmi2Slave):
    """VARIABLES: (name, causality, start, unit); STATE: attributes beyond the variables."""

    VARIABLES = ()
    STATE = ()
    initializing = False

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.units = {}
        extra = (("failed", "output", False, ""), ("error", "output", "", ""))
        for name, causality, start, unit in (*self.VARIABLES, *extra):
            setattr(self, name, start)
            kind = {bool: "Boolean", int: "Integer", str: "String"}.get(type(start), "Real")
            more = {"variability": Fmi2Variability.fixed} if causality == "parameter" else {}
            self.register_variable(TYPES[kind](name, causality=Fmi2Causality[causality], **more))
            self.units[name] = unit

    def to_xml(self, model_options=None):
        root = super().to_xml(model_options or {})
        for variable in root.find("ModelVariables"):
            if self.units.get(variable.get("name")):
                variable.find("Real").set("unit", self.units[variable.get("name")])
        definitions = Element("UnitDefinitions")
        for unit in sorted({u for u in self.units.values() if u}):
            SubElement(definitions, "Unit", name=unit)
        root.insert(1, definitions)
        return root

    def guarded(self, action, *arguments):
        """Run; on an exception note it as the product's FMUs do: `failed`, `error`, traceback to the log."""
        try:
            action(*arguments)
            return True
        except Exception as error:
            self.failed, self.error = True, f"{type(error).__name__}: {error}"
            self.log(traceback.format_exc().replace("%", "%%"), Fmi2Status.error)
            return False

    def enter_initialization_mode(self):
        self.initializing = True

    def exit_initialization_mode(self):
        self.initializing = False
        self.guarded(self.begin)

    def get_real(self, vrs):
        if self.initializing:  # FMI 2.0: outputs asked for in initialisation mode follow from the inputs set so far
            self.guarded(self.begin)
        return super().get_real(vrs)

    def do_step(self, current_time, step_size):
        return self.guarded(self.advance, current_time, step_size)

    def _get_fmu_state(self):
        names = [v.name for v in self.vars.values()] + list(self.STATE)
        return {name: copy.copy(getattr(self, name)) for name in names}

    def _set_fmu_state(self, state):
        for name, value in state.items():
            setattr(self, name, copy.copy(value))

    @staticmethod
    def _fmu_state_to_bytes(state):
        return pickle.dumps(state)

    @staticmethod
    def _fmu_state_from_bytes(data):
        return pickle.loads(bytes(data))
