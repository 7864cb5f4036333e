"""`python -m agentrob` and the command `agentrob`."""

from agentrob.process.startup import importing


def main() -> None:
    """The entry point of the command."""
    with importing():
        from agentrob.cli import main as cli

    cli.main()


if __name__ == "__main__":
    main()
