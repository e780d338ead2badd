"""`python -m ecume`, and the `ecume` command."""

from ecume.cli import main

if __name__ == "__main__":
    main()
