"""`python -m agentrob` and the command `agentrob`: the same words, started quickly."""

from agentrob.process.quick import quick_imports


def main() -> None:
    """The entry point of the command."""
    with quick_imports():
        from agentrob.cli import main as cli

    cli.main()


if __name__ == "__main__":
    main()
