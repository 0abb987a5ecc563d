"""Sample specimens and molds: the files that `hf sample` writes and the README's main job runs on."""

from __future__ import annotations

from importlib.resources import files

from hyperfab.samples.foam import FOAM_TOML, TEXTILE_TOML, foam_curve
from hyperfab.samples.lycra import lycra
from hyperfab.samples.rubber import treloar

#: Files that are kept as they are, and the folder each belongs to.
_KEPT = {
    "cup-on-plate.toml": "molds",
    "film.csv": "specimens",
    "original.toml": "molds",
    "proposed.toml": "molds",
    "production.toml": "molds",
    "study-heat.toml": "molds",
    "study-press.toml": "molds",
}


def sample_files() -> dict[str, bytes]:
    """Return every sample file: its path below the chosen folder, and its bytes, the same on every machine.

    >>> sorted(path for path in sample_files() if path.startswith("specimens/treloar"))[0]
    'specimens/treloar-1944/biaxial.csv'
    """
    # numpy enters only here: the tables need none of it.
    from hyperfab.io.stl_write import stl_bytes
    from hyperfab.samples.cup import female_cup, male_cup, plate
    from hyperfab.samples.torso import torso

    samples = {f"specimens/treloar-1944/{name}": data for name, data in treloar().items()}
    samples |= {f"specimens/lycra/{name}": data for name, data in lycra().items()}
    samples |= {"specimens/foam.csv": foam_curve(), "specimens/foam.toml": FOAM_TOML}
    samples["specimens/textile.toml"] = TEXTILE_TOML
    here = files(__name__)
    samples |= {
        f"{folder}/{name}": here.joinpath(name).read_bytes()
        for name, folder in _KEPT.items()
        if here.joinpath(name).is_file()
    }
    for name, mold in (
        ("cup-male", male_cup()),
        ("cup-female", female_cup()),
        ("torso", torso()),
        ("plate-male", plate(-20.0, 0.0)),
        ("plate-female", plate(10.0, 30.0)),
    ):
        samples[f"molds/{name}.stl"] = stl_bytes(mold.vertices, mold.faces)
    return samples
