"""The entry point of `python -m ecume` and of the command `ecume`."""

from ecume.cli import main

if __name__ == "__main__":
    main()
