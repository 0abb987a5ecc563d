"""`hf press-contact`: where two hot molds touch through the fabric-foam-fabric sandwich, and how hard."""

from hyperfab.chapters.press_contact.command import run

__all__ = ["run"]
