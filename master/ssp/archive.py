"""A coupled system as an archive of System Structure and Parameterization 1.0, which other co-simulation tools load.

Source: SSP 1.0 (Modelica Association Project SSP, 2019, https://ssp-standard.org), and what its tools were seen to do with it
(docs/ssp.md):
- parameter sets are bound to the components, their names without prefix, and have one name: libcosim and ecos read no others;
- an enumeration's value is written as the Integer which FMI 2.0 sets it by: ssv:Enumeration ends libcosim and ecos;
- a text equal to the FMU's own start value is left out: FMPy's simulator sets no texts;
- connectors are the Real outputs and the wired inputs: FMPy takes an input connector without connection for another one's;
- SSP 1.0 has no place for a step: it stands in the annotations of libcosim and of OMSimulator, in ours, and in the description;
- OMSimulator looks at the system's first annotation alone, and takes no archive with annotations at the top: ours is the second.

The same system gives the same bytes.
"""

from __future__ import annotations

import io
import math
import zipfile
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from xml.etree import ElementTree as ET

from ..base import files as base_files
from ..base.errors import AeroSloshError
from ..results.provenance import source_hash
from . import units as ssp_units
from .system import Coupled, Part

SPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
    "aeroslosh": "urn:aeroslosh:ssp",
}
SET = "initialValues"  # name of every parameter set
KINDS = {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean", "String": "String"}
DATE = (1980, 1, 1, 0, 0, 0)
for _prefix, _uri in SPACES.items():  # libcosim, ecos and OMSimulator look for the prefixes, not for the namespaces
    ET.register_namespace(_prefix, _uri)


def write(coupled: Coupled, target: Path) -> None:
    """Write the archive, whole or not at all. Raises AeroSloshError where it cannot be written."""
    data = archive(coupled)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        base_files.write(target, data)
    except OSError as error:
        raise AeroSloshError(
            f"The archive cannot be written: {error.strerror or error}", str(target), "give another with --out"
        ) from None


def archive(coupled: Coupled) -> bytes:
    """The archive: the description, parameter sets, FMUs byte for byte, and the resolved settings. Raises AeroSloshError."""
    units = ssp_units.of_parts(coupled.parts)
    files = {
        "SystemStructure.ssd": _text(_description(coupled, units)),
        "extra/aeroslosh/settings.toml": coupled.settings.encode(),
    }
    for part in coupled.parts:
        files[f"resources/{part.name}.ssv"] = _text(_parameters(part, units))
        files[_source(part, coupled)] = part.path.read_bytes()
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as packed:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, DATE)
            entry.compress_type = zipfile.ZIP_STORED if name.endswith(".fmu") else zipfile.ZIP_DEFLATED
            entry.create_system, entry.external_attr = 3, 0o644 << 16
            packed.writestr(entry, files[name])
    return stream.getvalue()


def _description(coupled: Coupled, units: Mapping[str, ssp_units.Base]) -> ET.Element:
    """SystemStructure.ssd."""
    text = f"{coupled.description} Communication step {coupled.dt!r} s, {coupled.steps} steps. " + " ".join(coupled.notes)
    about = {"version": "1.0", "name": coupled.name, "description": text, "generationTool": _tool()}
    root = ET.Element(_tag("ssd", "SystemStructureDescription"), about)
    system = _add(root, "ssd", "System", name=coupled.name)
    elements = _add(system, "ssd", "Elements")
    for part in coupled.parts:
        _component(elements, part, coupled, units)
    if coupled.wires:
        connections = _add(system, "ssd", "Connections")
        for wire in coupled.wires:
            (a, _, x), (b, _, y) = wire.source.partition("."), wire.target.partition(".")
            _add(connections, "ssd", "Connection", startElement=a, startConnector=x, endElement=b, endConnector=y)
    _annotations(_add(system, "ssd", "Annotations"), coupled)
    _units(root, "ssd", units)
    experiment = _add(root, "ssd", "DefaultExperiment", startTime=repr(coupled.start), stopTime=repr(coupled.stop))
    place = _annotation(_add(experiment, "ssd", "Annotations"), "com.opensimulationplatform")
    _add(_add(place, "osp", "Algorithm"), "osp", "FixedStepAlgorithm", baseStepSize=repr(_not_cut_short(coupled.dt)))
    return root


def _annotations(annotations: ET.Element, coupled: Coupled) -> None:
    """What OMSimulator asks for, and where the archive comes from."""
    steps = _add(_annotation(annotations, "org.openmodelica"), "oms", "SimulationInformation")
    _add(steps, "oms", "FixedStepMaster", description="oms-ma", stepSize=repr(coupled.dt), relativeTolerance="0.0001")
    export = _add(
        _annotation(annotations, "aeroslosh"),
        "aeroslosh",
        "Export",
        step=repr(coupled.dt),
        steps=str(coupled.steps),
        settings="extra/aeroslosh/settings.toml",
        settings_sha256=coupled.settings_sha256,
        master_sha256=source_hash(),
    )
    for part in coupled.parts:
        _add(export, "aeroslosh", "Fmu", component=part.name, sha256=part.sha256)


def _component(elements: ET.Element, part: Part, coupled: Coupled, units: Mapping[str, ssp_units.Base]) -> None:
    """One ssd:Component."""
    text = part.description.description
    about = {"description": text} if text else {}
    element = _add(
        elements,
        "ssd",
        "Component",
        name=part.name,
        type="application/x-fmu-sharedlibrary",
        source=_source(part, coupled),
        implementation="CoSimulation",
        **about,
    )
    wired = {end for wire in coupled.wires for end in (wire.source, wire.target)}
    chosen = [
        v for v in part.variables.values() if v.type == "Real" and (v.causality == "output" or f"{part.name}.{v.name}" in wired)
    ]
    if chosen:
        connectors = _add(element, "ssd", "Connectors")
        for variable in chosen:
            about = {"description": variable.description} if variable.description else {}
            connector = _add(connectors, "ssd", "Connector", name=variable.name, kind=variable.causality, **about)
            _add(connector, "ssc", "Real", **({"unit": variable.unit} if variable.unit in units else {}))
    bindings = _add(element, "ssd", "ParameterBindings")
    _add(bindings, "ssd", "ParameterBinding", type="application/x-ssp-parameter-set", source=f"resources/{part.name}.ssv")


def _parameters(part: Part, units: Mapping[str, ssp_units.Base]) -> ET.Element:
    """The .ssv of one component."""
    root = ET.Element(_tag("ssv", "ParameterSet"), {"version": "1.0", "name": SET, "generationTool": _tool()})
    parameters, used = _add(root, "ssv", "Parameters"), {}
    for name, value in sorted(part.values.items()):
        variable = part.variables[name]
        kind = KINDS[variable.type]
        if kind == "String" and value == (variable.start or ""):
            continue
        about = {"description": variable.description} if variable.description else {}
        content = {"value": _literal(kind, value)}
        if kind == "Real" and variable.unit in units:
            content["unit"] = variable.unit
            used[variable.unit] = units[variable.unit]
        _add(_add(parameters, "ssv", "Parameter", name=name, **about), "ssv", kind, **content)
    _units(root, "ssv", used)
    return root


def _units(parent: ET.Element, space: str, units: Mapping[str, ssp_units.Base]) -> None:
    if units:
        place = _add(parent, space, "Units")
        for name in sorted(units):
            _add(_add(place, "ssc", "Unit", name=name), "ssc", "BaseUnit", **units[name])


def _annotation(annotations: ET.Element, kind: str) -> ET.Element:
    return _add(annotations, "ssc", "Annotation", type=kind)


def _source(part: Part, coupled: Coupled) -> str:
    """Where the FMU lies in the archive: under its own name, or under the component's where another FMU has that."""
    others = {p.sha256 for p in coupled.parts if p.path.name == part.path.name}
    return f"resources/{part.path.name if len(others) == 1 else part.name + '.fmu'}"


def _not_cut_short(dt: float) -> float:
    """`dt` [s], or the next number above it that libcosim, which cuts off parts of a nanosecond, takes for the same count."""
    count = round(dt * 1e9)
    while int(dt * 1e9) < count:
        dt = math.nextafter(dt, math.inf)
    return dt


def _literal(kind: str, value: float | int | bool | str) -> str:
    if kind == "Real":
        return repr(float(value))
    if kind == "Boolean":
        return "true" if value else "false"
    return str(int(value)) if kind == "Integer" else str(value)


def _tool() -> str:
    return f"aeroslosh {metadata.version('aeroslosh')}"


def _tag(space: str, name: str) -> str:
    return f"{{{SPACES[space]}}}{name}"


def _add(parent: ET.Element, space: str, tag: str, **attributes: str) -> ET.Element:
    return ET.SubElement(parent, _tag(space, tag), attributes)


def _text(root: ET.Element) -> bytes:
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"
