"""modelDescription.xml of FMI 2.0: units, types, ranges, dependencies, reproducible content.

pythonfmu's own description lacks all of these (`fmpy validate` refuses it), writes starts that are not bit
exact and a random guid. Here a float is `repr(float)`, the guid is a UUID5 of the content and the date is
fixed. Layout and order of the elements: FMI 2.0.4 specification, section 2.2.
"""

from __future__ import annotations

import datetime
import os
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from . import units
from .variables import Value, Variable

# What the library and the slave base class really do; nothing else is claimed.
CAPABILITIES = {
    "needsExecutionTool": "false",  # no tool is called: the library takes the machine's Python into the process
    "canHandleVariableCommunicationStepSize": "true",
    "canInterpolateInputs": "false",
    "maxOutputDerivativeOrder": "0",
    "canRunAsynchronuously": "false",
    "canBeInstantiatedOnlyOncePerProcess": "false",
    "canNotUseMemoryManagementFunctions": "true",
    "canGetAndSetFMUstate": "true",
    "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "false",
}


@dataclass(frozen=True)
class Model:
    """What the description says beside the variables. Times in seconds."""

    name: str
    description: str
    version: str
    content_hash: str
    stop_time: float
    step_size: float
    tolerance: float


def describe(model: Model, variables: Sequence[Variable], categories: Mapping[str, str]) -> Element:
    """Return the `fmiModelDescription` element; the value reference of a variable is its place in
    `variables`.
    """
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=model.name,
        description=model.description,
        version=model.version,
        license="MIT",
        generationTool="aeroslosh fmus.kit",
        generationDateAndTime=_date(),
        variableNamingConvention="structured",
    )
    SubElement(root, "CoSimulation", {"modelIdentifier": model.name, **CAPABILITIES})
    _units(root, variables)
    _types(root, variables)
    logs = SubElement(root, "LogCategories")
    for name, text in categories.items():
        SubElement(logs, "Category", name=name, description=text)
    SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(model.stop_time),
        stepSize=repr(model.step_size),
        tolerance=repr(model.tolerance),
    )
    listed = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(variables):
        _scalar(listed, reference, variable)
    _structure(root, variables)
    # the guid names this content: interface and sources
    identity = f"aeroslosh:{model.content_hash}:".encode() + tostring(root)
    root.set("guid", f"{{{uuid.uuid5(uuid.NAMESPACE_URL, identity.hex())}}}")
    indent(root)
    return root


def _date() -> str:
    """Return a fixed date, that of SOURCE_DATE_EPOCH where it is set: the same source builds the same
    bytes.
    """
    seconds = int(os.environ.get("SOURCE_DATE_EPOCH", "315532800"))  # 1980-01-01, the zero of zip files
    return datetime.datetime.fromtimestamp(seconds, datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def _units(root: Element, variables: Sequence[Variable]) -> None:
    names = sorted({v.unit for v in variables if v.unit})
    if not names:
        return
    definitions = SubElement(root, "UnitDefinitions")
    for name in names:
        unit = SubElement(definitions, "Unit", name=name)
        SubElement(unit, "BaseUnit", {key: repr(value) for key, value in units.base(name).items()})
        if name == "rad":
            SubElement(unit, "DisplayUnit", name="deg", factor="57.29577951308232")


def _types(root: Element, variables: Sequence[Variable]) -> None:
    definitions = Element("TypeDefinitions")
    quantities = sorted({(_quantity(v), v.unit) for v in variables if _quantity(v) and v.type == "Real"})
    for quantity, unit in quantities:
        SubElement(
            SubElement(definitions, "SimpleType", name=_type_name(quantity, unit)),
            "Real",
            quantity=quantity,
            unit=unit,
        )
    for variable in variables:
        if variable.items:
            simple = SubElement(definitions, "SimpleType", name=f"{variable.name}_type")
            enumeration = SubElement(simple, "Enumeration")
            for number, (name, text) in enumerate(variable.items):
                SubElement(enumeration, "Item", name=name, value=str(number), description=text)
    if len(definitions):
        root.append(definitions)


def _quantity(variable: Variable) -> str:
    """What the variable is an amount of, by its unit unless it says so itself."""
    return variable.quantity or units.QUANTITY.get(variable.unit, "")


def _type_name(quantity: str, unit: str) -> str:
    return f"{quantity} [{unit}]"


def _scalar(parent: Element, reference: int, variable: Variable) -> None:
    variability = {"parameter": "tunable" if variable.tunable else "fixed"}.get(
        variable.causality, "continuous" if variable.type == "Real" else "discrete"
    )
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": variability,
    }
    if variable.causality != "input":  # FMI forbids to write it for inputs; it is exact
        attributes["initial"] = "exact" if variable.causality == "parameter" else "calculated"
    scalar = SubElement(parent, "ScalarVariable", attributes)
    details: dict[str, str] = {}
    if variable.items:
        details["declaredType"] = f"{variable.name}_type"
    elif variable.type == "Real" and (quantity := _quantity(variable)):
        details["declaredType"] = _type_name(quantity, variable.unit)
        details["quantity"] = quantity
    if variable.unit:
        details["unit"] = variable.unit
    real = variable.type == "Real"
    for key in ("min", "max", "nominal"):
        bound = getattr(variable, key)
        if bound is not None:
            details[key] = repr(float(bound)) if real else str(int(bound))
    if variable.start is not None:
        details["start"] = _text(variable.start, real)
    SubElement(scalar, "Enumeration" if variable.items else variable.type, details)


def _text(value: Value, real: bool) -> str:
    if real:
        return repr(float(value))
    return str(value).lower() if isinstance(value, bool) else str(value)


def _structure(root: Element, variables: Sequence[Variable]) -> None:
    index = {variable.name: place for place, variable in enumerate(variables, start=1)}
    outputs = [variable for variable in variables if variable.causality == "output"]
    structure = SubElement(root, "ModelStructure")
    for tag, initially in (("Outputs", False), ("InitialUnknowns", True)):
        listed = SubElement(structure, tag)
        for variable in outputs:
            # between steps nothing that is set moves an output: it is what the last step, or the start, assigned
            names = variable.depends if initially else ()
            places = " ".join(str(place) for place in sorted(index[name] for name in names))
            SubElement(listed, "Unknown", index=str(index[variable.name]), dependencies=places)
