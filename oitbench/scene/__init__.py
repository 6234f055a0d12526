"""What a scene is: frozen descriptions that name no renderer."""

from oitbench.scene.lights import (
    PENUMBRA,
    DirectionalLight,
    EnvironmentLight,
    Light,
    Medium,
    SpotLight,
    sample_density,
)
from oitbench.scene.material import BLACK, RGB, WHITE, Array, Material, Texture, is_grey
from oitbench.scene.model import Camera, FragmentLists, Mesh, Object, Scene

__all__ = [
    "BLACK",
    "PENUMBRA",
    "RGB",
    "WHITE",
    "Array",
    "Camera",
    "DirectionalLight",
    "EnvironmentLight",
    "FragmentLists",
    "Light",
    "Material",
    "Medium",
    "Mesh",
    "Object",
    "Scene",
    "SpotLight",
    "Texture",
    "is_grey",
    "sample_density",
]
