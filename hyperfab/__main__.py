"""``python -m hyperfab`` is ``hf``."""

from hyperfab.cli import main

if __name__ == "__main__":
    main()
