"""Descriptions of scenes: frozen dataclasses that do not depend on a renderer.

Space is right-handed with y up, in the scene's unit of length (default: meters) and radians; the
camera looks down its −z axis. Radiance, transmission and albedo are linear Rec.709 and not
premultiplied.

========== =================================================================
module     holds
========== =================================================================
model      `Scene`, and the effects that a scene requests
objects    `Mesh`, `Object`, `FragmentLists`
view_meshes `Sprites` and `Strands`: meshes that face the camera
camera     `Camera`
paths      stereo pairs and moving cameras: `stereo`, `orbit`, `between`
coincidence surfaces that lie in one plane
material   `Material` and `Texture`: how surfaces cover, transmit and reflect
lights     directional, spot and environment lights
environment means of an environment light's radiance, by direction
medium     `Medium`: fog
vectors    types of vectors, colors and arrays, and vector algebra
checks     validation of values
texturing  the texture filter that both renderers share
solids     lengths inside of closed meshes
========== =================================================================
"""

from oitbench.scene.camera import Camera
from oitbench.scene.lights import (
    PENUMBRA,
    DirectionalLight,
    EnvironmentLight,
    Light,
    SpotLight,
)
from oitbench.scene.material import LEAST_LOBE, WRAPS, Material, Texture, Wrap
from oitbench.scene.medium import Medium, sample_density
from oitbench.scene.model import Scene
from oitbench.scene.objects import FragmentLists, Mesh, Object
from oitbench.scene.vectors import (
    BLACK,
    RGB,
    WHITE,
    Array,
    Floats,
    Vector,
    as_vector,
    axes_along,
    opposite,
    unit,
)
from oitbench.scene.view_meshes import Sprites, Strands, ViewMesh

__all__ = [
    "BLACK",
    "LEAST_LOBE",
    "PENUMBRA",
    "RGB",
    "WHITE",
    "WRAPS",
    "Array",
    "Camera",
    "DirectionalLight",
    "EnvironmentLight",
    "Floats",
    "FragmentLists",
    "Light",
    "Material",
    "Medium",
    "Mesh",
    "Object",
    "Scene",
    "SpotLight",
    "Sprites",
    "Strands",
    "Texture",
    "Vector",
    "ViewMesh",
    "Wrap",
    "as_vector",
    "axes_along",
    "opposite",
    "sample_density",
    "unit",
]
