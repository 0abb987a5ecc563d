"""`hf fabric-contact`: a sphere pushed into a clamped sheet."""

from hyperfab.chapters.fabric_contact.command import run

__all__ = ["run"]
