"""Entry point of `python -m agentrob` and of the command `agentrob`."""

import sys

from agentrob.process.interpreter import importing

#: The exit code of a program that Ctrl-C ended.
INTERRUPTED = 130


def main() -> None:
    """Import and run the command line."""
    try:
        with importing():
            from agentrob.cli import main as cli
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    cli.main()


if __name__ == "__main__":
    main()
