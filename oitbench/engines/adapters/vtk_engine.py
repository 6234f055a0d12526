"""VTK: unsorted blending, its order-independent pass, and dual depth peeling, all by OpenGL.

Every target that VTK composites in has 8 bits a channel, and so has its picture. Colors are linear
in all of it. Source: the shaders of `vtkOrderIndependentTranslucentPass` and of
`vtkDualDepthPeelingPass`, VTK 9.7.
"""

from __future__ import annotations

import math
import os
import re
from typing import Any, ClassVar

import numpy as np

from oitbench.engines.adapter import Algorithm, Content, Drawing, Engine, Surface
from oitbench.errors import CapabilityError
from oitbench.image.files import Image

_BYTE = 255
_MOST_PEELS = 4096
"""More than any scene has layers: peeling ends by itself when nothing is left."""


class Vtk(Engine):
    """The Visualization Toolkit, in a window off screen."""

    algorithms: ClassVar = {
        "unsorted": Algorithm("alpha_blend", "blends in 8 bits"),
        "order_independent": Algorithm(
            "weighted_average",
            "the same mean color, sums in half floats, result in 8 bits; the background passes by"
            " the product of all layers, where the peer takes a power of their mean",
        ),
        "dual_depth_peeling": Algorithm("dual_depth_peeling", "peels and blends in 8 bits"),
    }

    def __init__(self) -> None:
        # VTK looks for an X server first, and warns if there is none.
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
        try:
            import vtkmodules.vtkRenderingOpenGL2
            from vtkmodules import vtkCommonDataModel, vtkRenderingCore
            from vtkmodules.util import numpy_support
        except ImportError as error:
            raise CapabilityError(
                f"vtk cannot be imported ({error}); pip install 'oitbench[engines]'"
            ) from error
        self._opengl = vtkmodules.vtkRenderingOpenGL2
        self._core, self._data, self._numpy = vtkRenderingCore, vtkCommonDataModel, numpy_support
        self._renderer = ""

    @property
    def version(self) -> str:
        """The version of VTK."""
        from vtkmodules.vtkCommonCore import vtkVersion

        return str(vtkVersion.GetVTKVersion())

    @property
    def renderer(self) -> str:
        """The renderer of OpenGL, known after the first drawing."""
        return self._renderer

    def open(self, content: Content, algorithm: str, size: tuple[int, int]) -> Drawing:
        """Return a window with all surfaces as actors, in order of submission."""
        window = self._core.vtkRenderWindow()
        window.SetOffScreenRendering(True)
        window.SetMultiSamples(0)
        window.SetAlphaBitPlanes(True)
        window.SetSize(*size)
        renderer = self._core.vtkRenderer()
        renderer.SetBackground(*content.background)
        renderer.SetUseOIT(algorithm == "order_independent")
        renderer.SetUseDepthPeeling(algorithm == "dual_depth_peeling")
        renderer.SetMaximumNumberOfPeels(_MOST_PEELS)
        renderer.SetOcclusionRatio(0.0)
        window.AddRenderer(renderer)
        for surface in content.surfaces:
            renderer.AddActor(self._actor(surface))
        self._look(renderer.GetActiveCamera(), content)
        drawing = _Window(window, self._numpy)
        drawing.draw()
        found = re.search(r"renderer string: *(.*)", window.ReportCapabilities())
        self._renderer = found[1].strip() if found else "unknown renderer"
        return drawing

    def _look(self, view: Any, content: Content) -> None:
        camera = content.camera
        view.SetPosition(*camera.position)
        view.SetFocalPoint(*(np.asarray(camera.position) - camera.axes[2]))
        view.SetViewUp(*camera.axes[1])
        view.SetViewAngle(math.degrees(camera.fov_y))
        view.SetClippingRange(camera.near, camera.far)
        if camera.height is not None:
            view.SetParallelProjection(True)
            view.SetParallelScale(camera.height / 2)

    def _actor(self, surface: Surface) -> Any:
        from vtkmodules.vtkCommonCore import vtkPoints

        points = vtkPoints()
        points.SetData(self._numpy.numpy_to_vtk(surface.positions, deep=True))
        cells = self._data.vtkCellArray()
        starts = np.arange(0, 3 * len(surface.triangles) + 1, 3, dtype=np.int64)
        corners = surface.triangles.ravel().astype(np.int64)
        cells.SetData(
            *(self._numpy.numpy_to_vtkIdTypeArray(a, deep=True) for a in (starts, corners))
        )
        data = self._data.vtkPolyData()
        data.SetPoints(points)
        data.SetPolys(cells)
        mapper = self._core.vtkPolyDataMapper()
        mapper.SetInputData(data)
        actor = self._core.vtkActor()
        actor.SetMapper(mapper)
        look = actor.GetProperty()
        look.LightingOff()
        if surface.even:
            mapper.ScalarVisibilityOff()
            look.SetColor(*map(float, surface.color[0]))
            look.SetOpacity(float(surface.opacity[0]))
        else:
            values = np.column_stack([surface.color, surface.opacity])
            colors = np.rint(values * _BYTE).astype(np.uint8)
            data.GetPointData().SetScalars(self._numpy.numpy_to_vtk(colors, deep=True))
        (actor.ForceOpaqueOn if surface.opaque else actor.ForceTranslucentOn)()
        return actor


class _Window(Drawing):
    """A window of VTK."""

    def __init__(self, window: Any, support: Any) -> None:
        self._window, self._numpy = window, support

    def draw(self) -> None:
        """Render, and wait until OpenGL has finished."""
        self._window.Render()
        self._window.WaitForCompletion()

    def image(self) -> Image:
        """Return the picture of 8 bits; its lowest row comes first in VTK."""
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        width, height = self._window.GetSize()
        values = vtkUnsignedCharArray()
        self._window.GetPixelData(0, 0, width - 1, height - 1, 1, values, 0)
        pixels = self._numpy.vtk_to_numpy(values).reshape(height, width, 3)
        return np.asarray(pixels[::-1] / np.float32(_BYTE), dtype=np.float32)

    def release(self) -> None:
        """Free the window's context."""
        self._window.Finalize()
