"""What `aeroslosh doctor` found: one line each, good or bad, with a remedy where something is to be done."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

LEVELS = ("ok", "warning", "problem")  # from good to bad
LOG = 6  # lines of what a component said that people are shown


class Finding(NamedTuple):
    """One thing looked at. `level` is one of LEVELS; `remedy` a sentence where it is not "ok"; `values` the same for programs."""

    topic: str
    level: str
    text: str
    remedy: str = ""
    values: Mapping[str, Any] = MappingProxyType({})

    def data(self) -> dict[str, Any]:
        """For JSON."""
        return {"topic": self.topic, "level": self.level, "text": self.text, "remedy": self.remedy, **self.values}


def ok(topic: str, text: str, **values: Any) -> Finding:
    """Nothing to do."""
    return Finding(topic, "ok", text, "", values)


def warning(topic: str, text: str, remedy: str, **values: Any) -> Finding:
    """Something works less well, or not with every host."""
    return Finding(topic, "warning", text, remedy, values)


def problem(topic: str, text: str, remedy: str, **values: Any) -> Finding:
    """Something does not work."""
    return Finding(topic, "problem", text, remedy, values)


def worst(findings: Iterable[Finding]) -> str:
    """The worst level among them; "ok" of none."""
    return max((finding.level for finding in findings), key=LEVELS.index, default="ok")


def table(findings: Iterable[Finding]) -> str:
    """For people: level, topic, text, and the remedy below."""
    lines = []
    for finding in findings:
        lines.append(f"{finding.level:8} {finding.topic:12} {finding.text}")
        if finding.remedy:
            lines.append(f"{'':8} {'':12} remedy: {finding.remedy}")
        lines += [f"{'':8} {'':12}   | {text}" for text in str(finding.values.get("log", "")).splitlines()[-LOG:]]
    return "\n".join(lines)
