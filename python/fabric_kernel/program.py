"""The program `fabric`: one command for each question."""

import argparse
import contextlib
import importlib
import io
import re
import sys
from collections.abc import Sequence

from ._kernel import PRESETS, VERSION
from .about import Parser, ending

COMMANDS = {
    "run": ("run", "one impact: a table, pictures and a report"),
    "v50": ("v50", "the ballistic limit with its interval"),
    "accuracy": ("accuracy", "error against run time, and the cheapest settings that keep an error"),
    "compare": ("compare", "shields side by side: their limits, ranked, and which differ"),
    "tests": ("own_tests", "your own firing tests against the model, and the factor that they give"),
    "residual": ("residual", "the residual velocity over the impact velocity"),
    "fragments": ("fragments", "the share that goes through, by velocity, attitude and impact point"),
    "report": ("catalogue", "pictures and report again, of what these have written"),
    "scene": ("catalogue", "a scene file with every parameter, its unit and its meaning"),
    "fabrics": ("catalogue", "the named fabrics with their sources"),
    "fmu": ("fmu", "an FMU that starts with a scene, from that of a release"),
    "replay": ("catalogue", "do a capsule again and compare bit by bit"),
}


def completion() -> str:
    """Completion of commands, options, presets and files, for bash and zsh."""
    cases = []
    for command in COMMANDS:
        said = io.StringIO()
        with contextlib.suppress(SystemExit), contextlib.redirect_stdout(said):
            main([command, "--help"])
        options = sorted(set(re.findall(r"(?<![\w-])--[a-z][\w-]*", said.getvalue())))
        cases.append(f"    {command}) words='{' '.join([*options, *PRESETS])}' ;;")
    return "\n".join(
        [
            '[ -z "$ZSH_VERSION" ] || { autoload -U +X compinit bashcompinit; compinit; bashcompinit; }',
            "_fabric() {",
            "  local words",
            '  case "$COMP_CWORD:${COMP_WORDS[1]}" in',
            f"    1:*) words='{' '.join(COMMANDS)}' ;;",
            *(case.replace("    ", "    *:", 1) for case in cases),
            "  esac",
            '  COMPREPLY=($(compgen -W "$words" -- "${COMP_WORDS[COMP_CWORD]}"))',
            "}",
            "complete -o default -F _fabric fabric",
        ]
    )


def main(arguments: Sequence[str] | None = None) -> None:
    words = list(sys.argv[1:] if arguments is None else arguments)
    names = "\n".join(f"  {name:10} {about}" for name, (_, about) in COMMANDS.items())
    parser = Parser(
        prog="fabric",
        usage="fabric COMMAND ...",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description=f"Impact of rigid fragments on ballistic fabric.\n\ncommands:\n{names}",
        epilog="fabric help COMMAND says what a command takes.\nPages that messages name, as docs/v50.md, are in the release's "
        "fabric-documentation.zip.",
    )
    parser.add_argument("--completion", action="store_true", help="completion for bash and zsh: source <(fabric --completion)")
    parser.add_argument("--version", action="version", version=f"fabric {VERSION}")
    parser.add_argument("command", nargs="?", choices=COMMANDS, metavar="COMMAND", help=argparse.SUPPRESS)
    if words[:1] == ["help"]:
        words = [*words[1:2], "--help"]
    given = parser.parse_args(words[:1])
    command = given.command
    if given.completion or command is None:
        given.json = False
        with ending(parser, given):
            print(completion() if given.completion else parser.format_help().rstrip())
        return
    options = [word.partition("=")[0] for word in words if word.startswith("--")]
    if len(set(options)) < len(options):
        parser.exit(2, f"error: {max(options, key=options.count)}: is there twice\n")
    module = importlib.import_module(f".{COMMANDS[command][0]}", __package__)
    if COMMANDS[command][0] == "catalogue":
        getattr(module, command)(words[1:])
    else:
        module.main(words[1:])


if __name__ == "__main__":
    main()
