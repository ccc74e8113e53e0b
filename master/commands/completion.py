"""`aeroslosh completion`: a script that lets a shell complete commands, options and built-in cases."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from ..base.errors import ExitCode
from ..case import builtin
from . import HELP

SHELLS = ("bash", "zsh", "fish")
CASES = ("point", "boundary", "sweep", "run", "train")  # commands whose first word may be a built-in case
BASH = """# aeroslosh: completion for {shell}; made by `aeroslosh completion {shell}`
{start}_aeroslosh() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}" command="${{COMP_WORDS[1]}}" words=""
    if [ "$COMP_CWORD" -eq 1 ]; then
        words="{commands} --help --version"
    else
        case "$command" in
{branches}
        esac
    fi
    COMPREPLY=( $(compgen -W "$words" -- "$word") )
}}
complete -o default -o bashdefault -F _aeroslosh aeroslosh
"""


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["completion"]
    how = 'bash: eval "$(aeroslosh completion bash)" in ~/.bashrc; fish: … > ~/.config/fish/completions/aeroslosh.fish'
    sub = commands.add_parser("completion", help=text, description=text, epilog=how)
    sub.add_argument("shell", choices=SHELLS, help="whose script to print")
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """The script on standard output."""
    words = {name: _words(name) for name in HELP}
    print(_fish(words) if options.shell == "fish" else _bash(words, options.shell), end="")
    return ExitCode.OK


def _words(command: str) -> list[str]:
    """What may follow a command: its options, formats of its own, built-in cases."""
    import importlib

    top = argparse.ArgumentParser()
    subs = top.add_subparsers()
    importlib.import_module(f".{command}", __package__).register(subs)
    parser = subs.choices[command]
    found: list[str] = []
    for action in parser._actions:
        found += [option for option in action.option_strings if option.startswith("--")]
        if not action.option_strings and action.choices:
            found += [str(choice) for choice in action.choices]
            if isinstance(action.choices, Mapping):  # formats with options of their own
                inner = [o for sub in action.choices.values() for a in sub._actions for o in a.option_strings]
                found += [option for option in dict.fromkeys(inner) if option.startswith("--") and option not in found]
    return [*found, *(builtin.names() if command in CASES else [])]


def _bash(words: dict[str, list[str]], shell: str) -> str:
    branches = "\n".join(f'            {name}) words="{" ".join(found)}" ;;' for name, found in words.items())
    start = "autoload -U +X bashcompinit && bashcompinit\n" if shell == "zsh" else ""
    return BASH.format(shell=shell, start=start, commands=" ".join(words), branches=branches)


def _fish(words: dict[str, list[str]]) -> str:
    lines = ["# aeroslosh: completion for fish; made by `aeroslosh completion fish`"]
    first = "-n __fish_use_subcommand"
    for name, text in HELP.items():
        said = text.replace("'", "\\'")
        lines.append(f"complete -c aeroslosh {first} -a {name} -d '{said}'")
    lines.append(f"complete -c aeroslosh {first} -l version -d 'say the version'")
    for name, found in words.items():
        here = f"-n '__fish_seen_subcommand_from {name}'"
        for word in found:
            lines.append(f"complete -c aeroslosh {here} {f'-l {word[2:]}' if word.startswith('--') else f'-a {word}'}")
    return "\n".join(lines) + "\n"
