"""Triangle surfaces: nearest point, ray, cone of normals, curvature, soundness."""

from .mesh import Nearest, Surface
from .soundness import Soundness, consistently_wound, inside_out, soundness

__all__ = ["Nearest", "Soundness", "Surface", "consistently_wound", "inside_out", "soundness"]
