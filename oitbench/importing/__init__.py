"""Scenes from files of users: glTF 2.0 (.glb, .gltf), Wavefront (.obj) and polygons (.ply).

Files are not trusted. Only regular files of their own folder are read, every size is checked before
memory is used for it, and all indices and numbers are checked. CONVENTIONS.md has the tables of
what becomes of materials.

========== ==================================================================
module     holds
========== ==================================================================
scene      `read_scene`, and the parameters of every imported scene
framing    a camera, lights and a ground where a file has none
content    objects, cameras and lights of a file
gltf       reader of glTF: document, accessors, nodes, materials
obj, ply   readers of Wavefront and polygon files
looks      formulas of materials
values     values of surfaces, constant or textured
pictures   decoded PNG, JPEG and WebP
shapes     triangles, normals, closed meshes
polygons   polygons as triangles
files      reading inside a folder
limits     bounds of sizes
notes      what a scene shows differently from its file
========== ==================================================================
"""

from oitbench.importing.scene import PARAMETERS, Imported, read_scene, with_defaults

__all__ = ["PARAMETERS", "Imported", "read_scene", "with_defaults"]
