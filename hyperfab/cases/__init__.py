"""What is asked of each command: one frozen case a command, from which options, checks, ``setup`` and schema derive."""
