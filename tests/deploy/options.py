"""Command lines in manifests, held to the options that the built programs have."""

import re
import subprocess

from programs import program

_OPTION = re.compile(r"^ +(?:-\w,)?(--[a-z-]+)", re.MULTILINE)


def known_options(*command):
    """From the help of `shutterline render` or `shutterline-worker`: {option: whether it takes a value}."""
    help_text = subprocess.run([program(command[0]), *command[1:], "--help"], capture_output=True, text=True,
                               check=True).stdout
    options = {}
    for line in help_text.splitlines():
        match = _OPTION.match(line)
        if match:
            rest = line[match.end():]
            # A value's name follows after one blank, a description after several.
            options[match[1]] = re.match(r" [^ ]", rest) is not None and not rest.startswith(" Excludes")
    assert "--help" in options, help_text
    return options


def problems_of(command):
    """What is wrong with a command line of ours, word by word; nothing for programs of others."""
    name = command[0].rsplit("/", 1)[-1]
    if name not in ("shutterline", "shutterline-server", "shutterline-worker", "shutterline-scenes"):
        return [f"{name} is none of our programs"]
    words = command[1:]
    known = known_options(name, words[0]) if name == "shutterline" and words else known_options(name)
    return [f"{name} has no option {option}" for option in (word.partition("=")[0] for word in words)
            if option.startswith("--") and option not in known]
