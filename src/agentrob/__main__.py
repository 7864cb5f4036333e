"""`python -m agentrob`: the same as the command `agentrob`."""

from agentrob.cli import main

if __name__ == "__main__":
    main()
