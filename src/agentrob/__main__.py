"""Entry point of `python -m agentrob` and of the command `agentrob`."""

from agentrob.process.memory import importing


def main() -> None:
    """Import and run the command line."""
    with importing():
        from agentrob.cli import main as cli

    cli.main()


if __name__ == "__main__":
    main()
